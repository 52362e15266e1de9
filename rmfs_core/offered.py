"""Names that a plugin offers and the kernel has, too."""

from __future__ import annotations

import importlib
from collections.abc import Callable


def offered(module: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a module that has the names of another one."""
    return lambda name: getattr(importlib.import_module(module), name), lambda: dir(importlib.import_module(module))
