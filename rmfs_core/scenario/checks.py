"""Checks of single values, each with its sentence and its JSON Schema form."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from attrs import NOTHING, field, frozen

from rmfs_core.timetable import read_spans
from rmfs_core.wording import nearest


def key(doc: str, default: Any = NOTHING, *, unit: str | None = None, check: Any = None, factory: Any = None) -> Any:
    """Field of a scenario section: documented, with its unit and its check. Tables are compared as they are written."""
    eq: Any = True if factory is not dict else lambda table: repr(sorted(table.items()))  # for the hash, too
    return field(default=default, factory=factory, validator=check, eq=eq, metadata={"doc": doc, "unit": unit})


@frozen
class Check:
    """attrs validator that ignores None (a key left out).

    Parameters
    ----------
    expected
        The right value, as the end of the sentence "expected ...".
    holds
        Whether a value is right.
    schema
        The same in JSON Schema.
    """

    expected: str
    holds: Callable[[Any], bool]
    schema: Mapping[str, Any] = field(factory=dict)

    def __call__(self, _instance: object, _attribute: Any, value: Any) -> None:
        """Raise ValueError unless ``value`` is right or None."""
        if value is not None and not self.holds(value):
            shown = list(value) if isinstance(value, tuple) else value
            raise ValueError(f"expected {self.expected}, found {shown}")


def at_least(least: int, most: int | None = None) -> Check:
    """Return the check for a whole number of at least ``least`` and, so that it fits into memory, at most ``most``."""
    if most is None:
        return Check(f"a whole number >= {least}", lambda value: bool(value >= least), {"minimum": least})
    expected = f"a whole number from {least} to {most:,}"
    return Check(expected, lambda value: bool(least <= value <= most), {"minimum": least, "maximum": most})


def within(least: float, most: float) -> Check:
    """Return the check for a number of at least ``least`` and at most ``most``."""
    expected = f"a number from {least:g} to {most:g}"
    return Check(expected, lambda value: bool(least <= value <= most), {"minimum": least, "maximum": most})


class OneOf:
    """attrs validator: one of some words."""

    def __init__(self, *names: str) -> None:
        self.names = names
        self.schema: Mapping[str, Any] = {"enum": list(names)}

    def __call__(self, _instance: object, _attribute: Any, value: Any) -> None:
        """Raise ValueError unless ``value`` is one of the words, or None."""
        if value is not None and value not in self.names:
            raise ValueError(f'found "{value}"{nearest(str(value), self.names)}')


class Spans:
    """attrs validator: spans of times of the day, for all or by name; ``most`` as `read_spans` has it."""

    def __init__(self, most: int | None = None) -> None:
        self.most = most

    def __call__(self, _instance: object, _attribute: Any, value: Any) -> None:
        """Raise ValueError for a span that is none, or where there is none at all."""
        tables = [] if value is None else [*value.values()] if isinstance(value, Mapping) else [value]
        if value is not None and not isinstance(value, Mapping) and not value:
            raise ValueError("found no span of times of the day; expected at least one")
        for spans in tables:
            read_spans(spans, self.most)


def _all_positive(value: int | tuple[int, ...]) -> bool:
    values = value if isinstance(value, tuple) else (value,)
    return bool(values) and all(1 <= number <= 1_000_000_000 for number in values)


POSITIVE = Check("a number > 0 up to 1e10", lambda value: 0 < value <= 1e10, {"exclusiveMinimum": 0, "maximum": 1e10})
# Bounds of what robots and pickers do: nothing is quicker than a tick of 1 ms, no drive too long to count in ticks.
DURATION = within(0.001, 3600)
MAYBE_NO_TIME = within(0, 3600)
ALLOWANCE = within(0, 1e7)
COST = within(0, 1e9)
MOVING = within(0.001, 1000)
POWER = within(0.001, 1e6)
SHARE = Check("a number in (0, 1]", lambda value: 0 < value <= 1, {"exclusiveMinimum": 0, "maximum": 1})
CAPACITY = Check("a whole number from 1 to 1,000,000,000, or a list of them, one per station", _all_positive)
