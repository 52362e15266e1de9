"""Loading searches from numba's cache without what numba compiles with: a third of the CPU time of a short run."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from types import ModuleType, SimpleNamespace
from typing import Any

NAMED_ALONE = (
    *("numba.cpython.builtins", "numba.cpython.heapq", "numba.cpython.listobj", "numba.cpython.unicode"),
    *("numba.np.arraymath", "numba.np.arrayobj", "numba.np.npyimpl"),
)
"""Modules of which machine code that was compiled with them needs no more than the name."""


@contextmanager
def loading_alone(missed: Callable[[str], bool] | None = None) -> Iterator[None]:
    """Let what is cached load alone, meanwhile; who compiles all the same, then or later, imports what that takes.

    Parameters
    ----------
    missed
        Told the module of each function that is not in the cache; returns whether to look again.
    """
    from numba.core.registry import cpu_target
    from numba.core.runtime.nrt import rtsys

    cache: Any = import_module("numba.core.caching").Cache
    environment: Any = import_module("numba.core.environment")
    load, modules = cache.load_overload, environment.importlib

    def load_alone(cached: Any, signature: Any, target: Any) -> Any:
        """Load without a refresh, except for the counting of who refers to arrays."""
        target.refresh = partial(rtsys.initialize, target)
        try:
            found = load(cached, signature, target)
            if found is None and missed is not None and missed(vars(cached)["_py_func"].__module__):
                found = load(cached, signature, target)
            return found
        finally:
            vars(target).pop("refresh", None)

    def imported(name: str) -> ModuleType:
        """Return a module that something cached was compiled with: an empty one where its name is enough."""
        if name in NAMED_ALONE:
            return sys.modules.get(name) or ModuleType(name)
        if name.startswith("numba"):  # others, also those that extend numba, make known what machine code calls
            type(cpu_target.target_context).refresh(cpu_target.target_context)
        return import_module(name)

    cache.load_overload = load_alone
    environment.importlib = SimpleNamespace(import_module=imported)
    try:
        yield
    finally:
        cache.load_overload, environment.importlib = load, modules
