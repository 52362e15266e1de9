"""The cache of machine code on disk, which outlives upgrades, edits and moves of the code that it is made of."""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import sha256
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
from numba.core.caching import FunctionCache


class Cache(FunctionCache):
    """Machine code of one function, which is another one as soon as anything that it is made of is another one.

    Numba itself looks at the file of a function only, not at functions and constants of other files.
    """

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        made_of = repr(list(_parts(self._py_func, set())))
        return *super()._index_key(signature, codegen), sha256(made_of.encode()).hexdigest()

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Return the machine code; None, so that numba compiles anew, where what it names was moved or replaced."""
        try:
            return super().load_overload(signature, target)
        except Exception:  # whatever an old cache leads to: modules and names that are gone, files cut short
            return None

    def save_overload(self, signature: Any, data: Any) -> None:
        """Keep the machine code; begin a new index where numba fails to read the old one, for the same reasons."""
        try:
            super().save_overload(signature, data)
        except OSError:
            raise
        except Exception:
            self.flush()
            super().save_overload(signature, data)


def _parts(function: FunctionType, known: set[FunctionType]) -> Iterator[object]:
    """Yield the sources of a function's machine code: of it and the functions that it calls, and their constants."""
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
