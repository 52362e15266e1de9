"""Old names of what is elsewhere now, until 0.3.0."""

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
