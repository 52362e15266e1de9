"""The distribution: what it holds, and what the kernel keeps away from."""

import ast
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def imported(file: Path) -> set[str]:
    """Top-level packages that a module imports, anywhere in it."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.add(node.module.split(".")[0])
    return found


def test_the_kernel_imports_no_rule() -> None:
    """No module of rmfs_core imports a package of plugins/."""
    rules = {folder.name for folder in (ROOT / "plugins" / "rules").iterdir() if folder.is_dir()}
    for file in (ROOT / "rmfs_core").rglob("*.py"):
        assert not imported(file) & rules, file


def test_rules_import_no_other_rule() -> None:
    """A rule's package depends on the kernel, never on another rule's."""
    rules = {folder.name for folder in (ROOT / "plugins" / "rules").iterdir() if folder.is_dir()}
    for name in rules:
        for file in (ROOT / "plugins" / "rules" / name).rglob("*.py"):
            assert not imported(file) & (rules - {name}), file


def test_importing_the_package_is_cheap() -> None:
    """`import rmfs_core` and the command line's help load neither numpy nor numba nor simpy."""
    code = "import sys, rmfs_core.cli; print([m for m in ('numpy', 'numba', 'simpy', 'mip') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.slow
def test_the_wheel_holds_kernel_rules_and_scenarios(tmp_path: Path) -> None:
    """A wheel built from the checkout has every rule's package, every scenario, and the entry points."""
    command = [sys.executable, "-m", "pip", "wheel", "--no-deps", "--quiet", "--wheel-dir", str(tmp_path), str(ROOT)]
    subprocess.run(command, check=True)
    (wheel,) = tmp_path.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    for folder in (ROOT / "plugins" / "rules").iterdir():
        if (folder / "__init__.py").exists():
            assert f"{folder.name}/__init__.py" in names
    for scenario in (ROOT / "scenarios").rglob("*.toml"):
        assert f"rmfs_scenarios/{scenario.relative_to(ROOT / 'scenarios').as_posix()}" in names
    assert "rmfs_core/hookspecs.py" in names
    assert not any(name.startswith(("tests/", "tools/")) for name in names)
