"""Compiling with numba, whose cache on disk outlives upgrades, edits and moves of the code that it is made of.

A process may leave open at first whether it compiles functions that may be interpreted (`decide_later`): importing
numba and loading machine code takes longer than a small run does without. What they return is the same.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

__all__ = ["decide_later", "helper", "inlined", "interpret", "is_interpreting", "njit"]


class _Mode:
    """Mode of this process, for functions that are left open.

    Attributes
    ----------
    later, interpreting
        Whether it is left open if they are compiled, and whether those left open are interpreted.
    helpers
        Helpers left open, which only functions call that may be interpreted, too.
    announce
        Is called before anything that was left open is compiled, once.
    """

    later = interpreting = False
    announce: Callable[[], object] | None = None
    helpers: ClassVar[list[_Open]] = []


def decide_later() -> None:
    """Leave open, from now on, whether functions are compiled: those called are, unless `interpret` comes before."""
    _Mode.later = True


def interpret(announce: Callable[[], object]) -> bool:
    """Interpret what was left open and may be interpreted, from now on; return whether anything was left open.

    ``announce`` is called before something else is compiled, once.
    """
    _Mode.interpreting, _Mode.announce = _Mode.later, announce
    for helper in _Mode.helpers:
        helper.replace(helper.py_func)
    return _Mode.interpreting


def is_interpreting() -> bool:
    """Whether functions that may be interpreted are."""
    return _Mode.interpreting


class _Open:
    """A function of which it is open whether it is compiled.

    Parameters
    ----------
    function
        The function.
    compiled
        Returns it compiled.
    may
        Whether it may be interpreted.
    """

    def __init__(self, function: Callable[..., Any], compiled: Callable[[Any], Any], may: bool) -> None:
        self.py_func, self._compiled, self._may = function, compiled, may

    @cached_property
    def dispatcher(self) -> Any:
        """The compiled function, which replaces this object in the modules that have it."""
        announce, _Mode.announce = _Mode.announce, None
        if announce is not None:
            announce()
        found = self._compiled(self.py_func)
        self.replace(found)
        return found

    def replace(self, function: Any) -> None:
        """Put another function in place of this object in the modules that have it."""
        for module in list(sys.modules.values()):
            names = getattr(module, "__dict__", {})
            if names.get(self.py_func.__name__) is self:
                names[self.py_func.__name__] = function

    def __call__(self, *arguments: Any) -> Any:
        """Call the function, interpreted or compiled."""
        return _plain(self.py_func(*arguments)) if _Mode.interpreting and self._may else self.dispatcher(*arguments)

    def __getattr__(self, name: str) -> Any:
        """Return what only the compiled function has; ``_numba_type_`` lets numba call it from others."""
        return getattr(self.dispatcher, name)


def _plain(found: Any) -> Any:
    """Return numbers as compiled code returns them."""
    if isinstance(found, np.generic) and found.dtype.names is None:
        return found.item()
    return tuple(map(_plain, found)) if type(found) is tuple else found


def njit(*, cache: bool, interpreted: bool = False, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function as ``numba.njit`` does, with these options.

    Parameters
    ----------
    cache
        Keep the machine code on disk. It is compiled anew when the function, one that it calls, or a constant of these
        changes, in whichever file it is.
    interpreted
        Whether it may be interpreted in a small run. It must return the same then, to the last bit: its numbers may not
        overflow, it may not add up arrays by numpy, draw random numbers, or take long with small arrays. It calls
        only functions that may be interpreted, and a function that may not calls none of those made by `helper`.
    options
        Those of ``numba.njit``.
    """

    def compiled(function: Callable[..., Any]) -> Any:
        import numba

        from rmfs_core.jit_cache import Cache

        dispatcher = numba.njit(**options)(function)
        if cache and hasattr(dispatcher, "enable_caching"):  # not where NUMBA_DISABLE_JIT is set
            make: Any = Cache  # numba's caches have no types
            dispatcher._cache = make(function)
        return dispatcher

    def left_open(function: Callable[..., Any]) -> Any:
        if not _Mode.later:
            return compiled(function)
        helps = interpreted and "forceinline" in options
        if helps and _Mode.interpreting:
            return function
        made = _Open(function, compiled, interpreted)
        if helps:
            _Mode.helpers.append(made)
        return made

    return left_open


inlined = njit(cache=True, forceinline=True, _nrt=False)
"""Compile a helper into the searches that call it.

A search hands a dozen arrays from helper to helper. Calls with so many arguments, and numba's counting of references to
each array (``_nrt``), would take longer than most helpers do. A helper compiled so creates no arrays.
"""
helper = njit(cache=True, interpreted=True, forceinline=True, _nrt=False)
"""The same for a helper of searches that may be interpreted."""
