"""Run the code blocks of documentation pages, and compare their output with what they show.

Usage: python tools/pages.py [--update] [--long] PAGE.md ...

A page is done from top to bottom in an empty folder:

- A block with a caption is a file of that name, which is written.
- A ``console`` block has commands after ``$ ``, each with the output that it shows (standard error included). A command
  has to end with code 0, or with N where the block is marked ``% exit N``. Its output is compared where some is shown;
  ``...`` stands for any text within a line, and alone in a line for any lines.
- A ``text`` block is only shown.
- What a command leaves running in the background is ended with the page.
- Every other block has to be marked ``% not run: REASON`` in the line before it.
- A block marked ``% long: REASON`` takes minutes: it is done with ``--long`` alone.

A page that is marked ``% slow: REASON`` is left to the slow tests. With ``--update`` the shown output of commands that
no longer print what the page shows is replaced by what they print.
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import subprocess
import sys
import sysconfig
import tempfile
import textwrap
import venv
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from attrs import define, field

WIDTH = 80
SETTINGS = ("PYTHON", "PYTEST", "PIP_", "CI", "BUILD_NUMBER")
"""How variables begin that commands do not see; pytest prints other lines where the last two are set."""
_FENCE = re.compile(r"^(?P<indent> *)(?P<ticks>`{3,})(?:\{code-block\} *)?(?P<language>[\w-]+)\s*$")
_MARK = re.compile(r"^ *% (?P<mark>not run|slow|long|exit):? (?P<text>.+)$")


class PageError(Exception):
    """A page does not do what it says; the text says where and how."""


@define
class Command:
    """A command of a console block.

    Parameters
    ----------
    line, end
        Where its output begins and ends, as positions in the lines of the page.
    text
        The command as typed.
    shown
        The output that the page shows; empty where it shows none.
    exit_code
        How it has to end.
    """

    line: int
    end: int
    text: str
    shown: str
    exit_code: int = 0


@define
class Block:
    """A fenced block of a page, by the line it starts in (from 1)."""

    line: int
    language: str
    caption: str
    text: str
    marks: dict[str, str] = field(factory=dict)
    indent: str = ""

    def commands(self) -> list[Command]:
        """Return the commands of a console block."""
        found: list[Command] = []
        lines = self.text.split("\n")[:-1]
        typing = False
        for number, line in enumerate(lines, start=self.line):
            if typing:
                found[-1].text += "\n" + line
            elif line.startswith("$ "):
                found.append(Command(number, number, line[2:], ""))
            elif not found:
                raise PageError(f"line {number + 1}: a console block begins with `$ ` and a command")
            else:
                found[-1].shown += line + "\n"
            if typing or line.startswith("$ "):
                found[-1].line = number + 1
                typing = line.endswith("\\")
            found[-1].end = number + 1
        if found:
            found[-1].exit_code = int(self.marks.get("exit", 0))
        return found


def blocks(page: str) -> Iterator[Block]:
    """Return the fenced blocks of a page, with their marks."""
    lines = page.split("\n")
    number = 0
    while number < len(lines):
        opened = _FENCE.match(lines[number])
        number += 1
        if opened is None:
            continue
        marks = {}
        above = number - 2
        while above >= 0 and (mark := _MARK.match(lines[above])):
            marks[mark["mark"]] = mark["text"]
            above -= 1
        close = next(i for i in range(number, len(lines)) if lines[i].strip() == opened["ticks"])
        body = lines[number:close]
        caption = ""
        while body and (option := re.match(r"^ *:(\w+): *(.*)$", body[0])):
            caption = option[2] if option[1] == "caption" else caption
            body = body[2:] if body[1:] and not body[1].strip() else body[1:]
        indent = opened["indent"]
        text = "".join(line.removeprefix(indent) + "\n" for line in body)
        yield Block(close - len(body), opened["language"], caption, text, marks, indent)
        number = close + 1


def slow(page: str) -> str:
    """Return why a page takes long; empty where it does not."""
    found = re.search(r"^% slow: (.+)$", page, re.MULTILINE)
    return found[1] if found else ""


def matches(shown: str, printed: str) -> bool:
    """Return whether output is what a page shows of it, blanks at the ends of lines and of the whole left out."""
    want, got = ([line.rstrip() for line in text.strip().split("\n")] for text in (shown, printed))
    anything = r"(?:.*\n)*"
    parts = [anything if line.strip() == "..." else _pattern(line) + r"\n" for line in want]
    return re.fullmatch("".join(parts), "\n".join(got) + "\n") is not None


def _pattern(line: str) -> str:
    """Return the regular expression of a shown line; ``...`` in it is any text."""
    return ".*".join(re.escape(part) for part in line.split("..."))


def elided(shown: str, printed: str) -> list[str]:
    """Return the lines of new output, with what the page leaves out of the old one left out again."""
    old = [line.rstrip() for line in shown.strip("\n").split("\n")]
    new = [line.rstrip() for line in printed.strip("\n").split("\n")]
    inline = [line for line in old if "..." in line and line.strip() != "..."]
    new = [next((line for line in inline if re.fullmatch(_pattern(line), fresh)), fresh) for fresh in new]
    for position, line in enumerate(old):
        if line.strip() == "...":
            before = new.index(old[position - 1]) + 1 if position and old[position - 1] in new else 0
            after = old[position + 1] if position + 1 < len(old) else None
            until = len(new) if after is None else next((i for i in range(before, len(new)) if new[i] == after), None)
            if until is not None and (before or position == 0):
                new[before:until] = ["..."]
    return new


def _environment(folder: Path) -> dict[str, str]:
    """Return the variables that commands see. A page may install something: it has an environment of its own."""
    scripts = _own_environment(folder)
    return {
        **{name: value for name, value in os.environ.items() if not name.startswith(SETTINGS)},
        "PATH": f"{scripts}{os.pathsep}{os.environ.get('PATH', '')}",
        "COLUMNS": str(WIDTH),
        "NO_COLOR": "1",
        "TERM": "dumb",
        "PYTEST_ADDOPTS": "-p no:cacheprovider",
        # What a page installs it has made itself; all it depends on is there.
        "PIP_NO_INDEX": "1",
        "PIP_NO_DEPS": "1",
        "PIP_NO_BUILD_ISOLATION": "0",
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
    }


def _own_environment(folder: Path) -> Path:
    """Make an environment that sees what this one has, and return the folder of its commands."""
    venv.create(folder, symlinks=True, with_pip=False)
    scripts = folder / "bin"
    packages = Path(sysconfig.get_path("purelib", vars={"base": str(folder), "platbase": str(folder)}))
    standard = {sysconfig.get_path("stdlib"), sysconfig.get_path("platstdlib")}
    here = str(Path(__file__).resolve().parent)
    seen = [entry for entry in sys.path if Path(entry).is_dir() and entry != here]
    seen = [entry for entry in seen if entry not in standard and not entry.endswith("lib-dynload")]
    (packages / "seen.pth").write_text("\n".join(seen) + "\n", encoding="utf-8")
    starts = {
        "rmfs": "from rmfs_commands.cli.main import main; main()",
        "pip": "import runpy; runpy.run_module('pip', run_name='__main__')",
        "pytest": "import pytest, sys; sys.exit(pytest.main())",
    }
    for name, code in starts.items():
        script = scripts / name
        script.write_text(f"#!{scripts / 'python'}\n{code}\n", encoding="utf-8")
        script.chmod(0o755)
    return scripts


def done(page: str, folder: Path, update: bool = False, long: bool = False) -> str:
    """Do what a page says in an empty folder, and return the page, with new output where it is to be updated.

    Parameters
    ----------
    page
        Its text.
    folder
        Where its files are written and its commands run.
    update
        Whether output that is no longer printed is replaced; else it is an error.
    long
        Whether blocks that take minutes are done, too.

    Raises
    ------
    PageError
        When something else happens than the page says.
    """
    lines = page.split("\n")
    shift = 0
    groups: list[int] = []
    with tempfile.TemporaryDirectory() as own, _ended(groups):
        environment = _environment(Path(own) / "env")
        for block in blocks(page):
            place = f"line {block.line}"
            if "not run" in block.marks or (block.language == "text" and not block.caption):
                continue
            if "long" in block.marks and not long:
                continue
            if block.language == "console":
                for command in block.commands():
                    printed = _printed(command, folder, environment, groups)
                    if not command.shown or matches(command.shown, printed):
                        continue
                    if not update:
                        raise PageError(
                            f"line {command.line}: `{command.text}` prints\n{textwrap.indent(printed, '  ')}\n"
                            f"where the page shows\n{textwrap.indent(command.shown, '  ')}"
                        )
                    fresh = [(block.indent + line).rstrip() for line in elided(command.shown, printed)]
                    lines[command.line + shift : command.end + shift] = fresh
                    shift += len(fresh) - (command.end - command.line)
            elif block.caption:
                file = folder / block.caption
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(block.text, encoding="utf-8")
            else:
                raise PageError(
                    f"{place}: a block of {block.language} needs a caption, the file's name, or `% not run: REASON`"
                )
    return "\n".join(lines)


@contextmanager
def _ended(groups: list[int]) -> Iterator[None]:
    """End what commands have left running in the background, however the page ends."""
    try:
        yield
    finally:
        for group in groups:
            with suppress(ProcessLookupError):
                os.killpg(group, signal.SIGKILL)


def _printed(command: Command, folder: Path, environment: dict[str, str], groups: list[int]) -> str:
    """Run a command, take down its group of processes, and return what it prints."""
    ended = subprocess.Popen(
        ["bash", "-c", command.text],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    groups.append(ended.pid)
    printed, _ = ended.communicate()
    if ended.returncode != command.exit_code:
        raise PageError(
            f"line {command.line}: `{command.text}` ended with {ended.returncode}, not {command.exit_code}:\n{printed}"
        )
    return printed


def main(arguments: Sequence[str] | None = None) -> int:
    """Do the pages of the command line; return the exit code."""
    description = (__doc__ or "").partition("\n\n")[0]
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("pages", nargs="+", type=Path, metavar="PAGE.md")
    parser.add_argument("--update", action="store_true", help="replace output that is no longer what is printed")
    parser.add_argument("--long", action="store_true", help="do what takes minutes, too")
    given = parser.parse_args(arguments)
    failed = False
    for path in given.pages:
        page = path.read_text(encoding="utf-8")
        try:
            with tempfile.TemporaryDirectory() as folder:
                new = done(page, Path(folder), update=given.update, long=given.long)
        except PageError as error:
            print(f"{path}: {error}", file=sys.stderr)
            failed = True
            continue
        if new != page:
            path.write_text(new, encoding="utf-8")
            print(f"{path}: updated")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
