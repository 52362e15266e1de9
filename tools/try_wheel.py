"""Install a wheel of rmfs in a new environment, and try it there, away from the checkout.

Usage: python tools/try_wheel.py WHEEL

pip gets what the wheel needs from the package index. Then come the README's tour, each command in one folder, and
the kernel's tests, which are copied. It ends with code 1 as soon as something fails. It takes some minutes.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import venv
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
COPIED = ("tests", "tools", "scenarios", "docs", "pyproject.toml")
"""Files that the tests read besides the installed packages."""


def blocks(language: str) -> list[str]:
    """Return the README's code blocks of a language."""
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


def commands() -> list[list[str]]:
    """Return the words of each call of ``rmfs`` in the README, in its order."""
    lines = (line for block in blocks("sh") for line in block.splitlines())
    return [shlex.split(line, comments=True) for line in lines if line.startswith("rmfs ")]


def save_files(folder: Path) -> None:
    """Save the README's rule and scenario as it says."""
    (folder / "my_rule.py").write_text(blocks("python")[0], encoding="utf-8")
    (folder / "my-scenario.toml").write_text(blocks("toml")[0], encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> int:
    """Try a wheel; return the exit code."""
    (wheel,) = sys.argv[1:] if arguments is None else arguments
    with tempfile.TemporaryDirectory(dir=ROOT.parent) as name:  # it is large
        return _tried(Path(wheel).resolve(), Path(name))


def _tried(wheel: Path, folder: Path) -> int:
    venv.create(folder / "venv", with_pip=True)
    programs = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
    tour, copy = folder / "tour", folder / "copy"
    tour.mkdir()
    save_files(tour)
    copy.mkdir()
    for name in COPIED:
        (shutil.copytree if (ROOT / name).is_dir() else shutil.copy)(ROOT / name, copy / name)
    calls = [(folder, ["pip", "install", "--quiet", f"{wheel}[test]"])]
    calls += [(tour, words) for words in commands()]
    calls += [(copy, ["pytest", "-q", "-m", "not slow", "-n", "2", "tests/rmfs_core"])]
    variables = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    variables["PATH"] = os.pathsep.join([str(programs), variables["PATH"]])
    for within, words in calls:
        print(f"$ {shlex.join(words)}", flush=True)
        call = [str(programs / words[0]), *words[1:]]
        done = subprocess.run(call, cwd=within, env=variables, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(done.stdout[-5000:], done.stderr[-5000:], sep="\n")
            return 1
    print("The wheel does what the README shows.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
