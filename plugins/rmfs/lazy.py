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
        stub = ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))
        imports = [node for node in stub.body if isinstance(node, ast.ImportFrom) and node.module]
        named = [(alias.name, str(node.module)) for node in imports for alias in node.names]
        self._where = {name: module for name, module in named if name != "*"}
        self._whole = [module for name, module in named if name == "*"]

    def _look(self) -> None:
        """Import the packages of which all names are there, and note these."""
        while self._whole:
            module = self._whole.pop()
            self._where.update(dict.fromkeys(import_module(module).__all__, module))

    def __iter__(self) -> Iterator[str]:
        self._look()
        return iter(sorted(self._where))

    def get(self, name: str) -> object:
        """Import what has a name."""
        if name not in self._where:
            self._look()
        if name not in self._where:
            raise AttributeError(f"module 'rmfs' has no attribute '{name}'")
        return getattr(import_module(self._where[name]), name)
