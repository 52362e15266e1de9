"""Names of what is elsewhere: old ones, until 0.3.0, and those that a plugin's offers have in the kernel."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable, Mapping


def former(old: str, new: str | Mapping[str, str]) -> Callable[[str], object]:
    """Return the ``__getattr__`` of a module all of whose names are in another one now, or some of them; it warns."""

    def find(name: str) -> object:
        module = new if isinstance(new, str) else new.get(name)
        if module is None:
            raise AttributeError(f"module {old!r} has no attribute {name!r}")
        found = getattr(importlib.import_module(module), name)
        warnings.warn(f"{old}.{name} is in {module} now", FutureWarning, stacklevel=2)
        return found

    return find


def offered(module: str) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a module that has the names of another one."""
    return lambda name: getattr(importlib.import_module(module), name), lambda: dir(importlib.import_module(module))
