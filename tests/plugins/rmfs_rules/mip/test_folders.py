"""The folders of rmfs_rules.mip import one way, so that each can be read without those that stand on it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import rmfs_rules.mip

ROOT = Path(rmfs_rules.mip.__file__).parent
MODULES = sorted(path.relative_to(ROOT) for path in ROOT.rglob("*.py") if path.name != "__init__.py")
ARROWS = {
    "period": {"period"},
    "printed": {"printed", "period"},
    "compiled": {"compiled", "period"},
    "proof": {"proof", "printed", "compiled", "period"},
    "": {"", "proof", "printed", "compiled", "period"},
}


def imports_of(source: str, package: str) -> Iterator[tuple[str, str]]:
    """Yield the modules of a package that a source imports, anywhere in it, and the name that it takes from each."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == package:
            yield from ((node.module or "", alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names if alias.name.partition(".")[0] == package)


def folder_of(module: str) -> str:
    """Return the folder of rmfs_rules.mip that a module lies in; empty for the top."""
    parts = module.split(".")[1:]
    return parts[0] if parts and (ROOT / parts[0]).is_dir() else ""


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_arrows_point_one_way(module: Path) -> None:
    """Also within functions and for types alone."""
    source = (ROOT / module).read_text(encoding="utf-8")
    folder = module.parts[0] if len(module.parts) > 1 else ""
    assert {folder_of(target) for target, _ in imports_of(source, "rmfs_rules.mip")} <= ARROWS[folder]


@pytest.mark.parametrize("module", MODULES, ids=str)
def test_no_private_name_is_imported(module: Path) -> None:
    """Neither from another module here nor from the kernel."""
    source = (ROOT / module).read_text(encoding="utf-8")
    named = [
        f"{target}.{name}"
        for package in ("rmfs_rules.mip", "rmfs_core")
        for target, name in imports_of(source, package)
    ]
    assert [name for name in named if "._" in name] == []


def test_modules_form_no_circle() -> None:
    """Modules can be put into an order in which each imports earlier ones only."""
    left = {}
    for module in MODULES:
        source = (ROOT / module).read_text(encoding="utf-8")
        name = ".".join(("rmfs_rules.mip", *module.with_suffix("").parts))
        left[name] = {
            whole
            for target, taken in imports_of(source, "rmfs_rules.mip")
            for whole in (target, f"{target}.{taken}")
            if (ROOT / Path(*whole.split(".")[1:])).with_suffix(".py").is_file()
        }
    while left:
        ready = {name for name, targets in left.items() if not targets & left.keys()}
        assert ready, f"these import each other: {sorted(left)}"
        left = {name: targets for name, targets in left.items() if name not in ready}
