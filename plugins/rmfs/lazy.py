"""Names that are imported from elsewhere when they are first used."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path


class Names:
    """Imports from other packages in the stub of a module. (`lazy_loader` does so within one package alone.)

    Parameters
    ----------
    file
        The module's. In its ``.pyi`` stands ``from PACKAGE import NAME as NAME`` for each, or ``from PACKAGE import *``
        for all of the package's ``__all__``.
    """

    def __init__(self, file: str) -> None:
        self._where = {
            name: node.module
            for node in ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8")).body
            if isinstance(node, ast.ImportFrom) and node.module
            for alias in node.names
            for name in (import_module(node.module).__all__ if alias.name == "*" else [alias.name])
        }

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._where))

    def get(self, name: str) -> object:
        """Import what has a name."""
        if name not in self._where:
            raise AttributeError(f"module 'rmfs' has no attribute '{name}'")
        return getattr(import_module(self._where[name]), name)
