"""Compiling with numba, whose cache on disk outlives upgrades, edits and moves of the code that it is made of."""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import sha256
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
from numba import njit
from numba.core import caching

__all__ = ["inlined", "njit"]

_OPTIONS: dict[str, Any] = {"cache": True, "forceinline": True, "_nrt": False}
inlined = njit(**_OPTIONS)
"""Compile a helper into the searches that call it.

A search hands a dozen arrays from helper to helper. Calls with so many arguments, and numba's counting of references to
each array (``_nrt``), would take longer than most helpers do. A helper compiled so creates no arrays.
"""


def _parts(function: FunctionType, known: set[FunctionType]) -> Iterator[object]:
    """Yield what machine code of a function is made of: what it and those that it calls do, and their constants."""
    if function in known:
        return
    known.add(function)
    yield _done(function.__code__)
    names = sorted(set(_names(function.__code__)))
    values = [(name, function.__globals__.get(name)) for name in names]
    values += zip(
        function.__code__.co_freevars, (cell.cell_contents for cell in function.__closure__ or ()), strict=True
    )
    for module in [value for _, value in values if isinstance(value, ModuleType)]:
        if module.__name__.partition(".")[0] not in ("math", "numba", "numpy"):  # whose versions numba asks for
            values += [(name, vars(module).get(name)) for name in names]
    for name, given in values:
        value = getattr(given, "py_func", getattr(given, "__wrapped__", given))  # of what is compiled, or an intrinsic
        if isinstance(value, FunctionType):
            yield from _parts(value, known)
        elif isinstance(value, type):
            yield name, getattr(value, "__match_args__", None)
        elif isinstance(value, bool | int | float | str | tuple | np.number | np.dtype):
            yield name, value
        elif isinstance(value, np.ndarray):
            yield name, str(value.dtype), value.shape, sha256(value.tobytes()).hexdigest()


def _done(code: CodeType) -> tuple[object, ...]:
    """Return what code does with which constants and names; sets in one order, whatever the process."""
    constants: list[object] = []
    for constant in code.co_consts:
        within = sorted(map(repr, constant)) if isinstance(constant, frozenset) else constant
        constants.append(_done(constant) if isinstance(constant, CodeType) else within)
    return code.co_code, constants, code.co_names


def _names(code: CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _names(constant)


def _begin(cache: Any, function: Any, _begin: Any = caching.Cache.__init__) -> None:
    _begin(cache, function)
    cache.function = function


def _of_all(cache: Any, signature: Any) -> Any:
    """Return a signature that changes with a function or constant of another file: numba looks at a function's own."""
    if not hasattr(cache, "function"):  # compiled by others, before this module was there
        return signature
    try:
        made_of = repr(list(_parts(cache.function, set())))
    except Exception:  # what others compile may name whatever there is
        return signature
    return signature, sha256(made_of.encode()).hexdigest()


def _load(cache: Any, signature: Any, *target: Any, _load: Any = caching.Cache.load_overload) -> Any:
    """Let numba compile anew where it fails to load what it has cached, of code that was moved or replaced since."""
    try:
        return _load(cache, _of_all(cache, signature), *target)
    except Exception:  # whatever an old cache leads to: modules and names that are gone, files cut short
        return None


def _save(cache: Any, signature: Any, *data: Any, _save: Any = caching.Cache.save_overload) -> None:
    _save(cache, _of_all(cache, signature), *data)


def _save_anew(file: Any, *arguments: Any, _save: Any = caching.IndexDataCacheFile.save) -> None:
    """Let numba begin a new index where it fails to read the one of what it has cached, for the same reasons."""
    try:
        _save(file, *arguments)
    except OSError:
        raise
    except Exception:
        file.flush()
        _save(file, *arguments)


caching.Cache.__init__ = _begin  # type: ignore[method-assign]
caching.Cache.load_overload = _load  # type: ignore[method-assign]
caching.Cache.save_overload = _save  # type: ignore[method-assign]
caching.IndexDataCacheFile.save = _save_anew  # type: ignore[method-assign]
