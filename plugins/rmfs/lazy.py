"""Names that are imported from elsewhere when they are first used."""

from __future__ import annotations

import ast
from collections.abc import Callable
from importlib import import_module
from pathlib import Path


def names_of(file: str) -> tuple[Callable[[str], object], list[str]]:
    """Return a module's ``__getattr__`` and names: what the stub beside it imports from other packages.

    `lazy_loader` does the same for names of one's own package alone.

    Parameters
    ----------
    file
        The module's. In its ``.pyi`` stands ``from PACKAGE import NAME as NAME`` for each.
    """
    where = {
        alias.name: node.module
        for node in ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8")).body
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }

    def get(name: str) -> object:
        if name not in where:
            raise AttributeError(f"module 'rmfs' has no attribute '{name}'")
        return getattr(import_module(where[name]), name)

    return get, sorted(where)


def module_of(target: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return the ``__getattr__`` and ``__dir__`` of a module that has the names of another."""
    return lambda name: getattr(import_module(target), name), lambda: dir(import_module(target))
