"""Times of services: a number of seconds, or a mean around which single services spread."""

# (`key` is attrs' `field` with its documentation: it makes a field, not a default.)

from __future__ import annotations

from collections.abc import Mapping
from math import log, sqrt
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Any

from attrs import frozen

from rmfs_core.entrypoints import format_module
from rmfs_core.errors import InputError
from rmfs_core.scenario.checks import Check, OneOf, key, within
from rmfs_core.timetable import read_spans

if TYPE_CHECKING:
    import numpy as np

Speed = float | tuple[tuple[str | float, ...], ...]
"""Of a picker: a number, or one for each of some spans of the day."""
NO_SPREAD = 1e-6
"""A coefficient of variation below this is none."""
MAY_SPREAD = {
    "stations": ("pick_s", "handle_s", "store_s", "line_s", "order_s"),
    "packing": ("tote_s", "put_s", "pack_s", "pack_item_s"),
    "robots": ("lift_s",),
}
"""Keys whose times may vary, by section."""
TIMES = Check("times from 0 to 3600, at least one", lambda value: bool(value) and 0 <= min(value) <= max(value) <= 3600)


@frozen
class Spread:
    """A distribution of times."""

    mean: float | None = key("Mean; left out with `times` or `file`", None, unit="s", check=within(0.001, 3600))
    cv: float | None = key(
        "Coefficient of variation, standard deviation per mean, of `lognormal` and `gamma`", None, check=within(0, 10)
    )
    distribution: str | None = key(
        "Left out: `lognormal`, or `empirical` (one of the `times`, each as likely) with `times` or `file`",
        None,
        check=OneOf("lognormal", "gamma", "exponential", "empirical"),
    )
    times: tuple[float, ...] | None = key("Measured times", None, unit="s", check=TIMES)
    file: str | None = key("CSV with a column `seconds`; its values become `times` when it is read", None)

    def __attrs_post_init__(self) -> None:
        measured = self.times is not None or self.file is not None
        kind = self.distribution or ("empirical" if measured else "lognormal")
        if measured != (kind == "empirical") or (self.times is not None and self.file is not None):
            raise ValueError('expected `times` or `file` with distribution "empirical", and only there')
        if measured == (self.mean is not None):
            raise ValueError("expected `mean`, or else `times` or `file`")
        if (self.cv is not None) != (kind in ("lognormal", "gamma")):
            raise ValueError('expected `cv` with distribution "lognormal" or "gamma", and only there')
        object.__setattr__(self, "distribution", kind)


class ServiceTime(float):
    """A mean time in seconds that knows how single services spread around it; None: not at all.

    Parameters
    ----------
    spread
        The distribution.
    """

    spread: Spread

    def __new__(cls, spread: Spread) -> ServiceTime:
        """Return the mean of a distribution."""
        new = super().__new__(cls, fmean(spread.times or (0.0,)) if spread.mean is None else spread.mean)
        new.spread = spread
        return new

    def __getnewargs__(self) -> tuple[Spread]:  # type: ignore[override]
        """Return what a copy is made of."""
        return (self.spread,)

    def __eq__(self, other: object) -> bool:
        """Whether the other spreads in the same way."""
        return isinstance(other, ServiceTime) and self.spread == other.spread

    def __ne__(self, other: object) -> bool:
        """Whether it does not."""
        return not self == other

    __hash__ = float.__hash__

    def __repr__(self) -> str:
        return f"ServiceTime({self.spread!r})"

    __str__ = float.__repr__


def drawn(seconds: ServiceTime, rng: np.random.Generator) -> float:
    """Return the time of one service in seconds."""
    spread, mean = seconds.spread, float(seconds)
    if spread.cv is not None and spread.cv < NO_SPREAD:
        return mean
    if spread.times is not None:
        return float(spread.times[int(rng.integers(len(spread.times)))])
    if (cv := spread.cv) is None:
        return float(rng.exponential(mean))
    if spread.distribution == "gamma":
        return float(rng.gamma(1 / cv**2, mean * cv**2))
    variance = log(1 + cv**2)
    return float(rng.lognormal(log(mean) - variance / 2, sqrt(variance)))


def speeds_of(speed: Speed) -> tuple[tuple[tuple[int, int, int], ...], tuple[float, ...]]:
    """Return spans that number their speeds from 1; the first is that of no span. ValueError for wrong ones."""
    shifts = speed if isinstance(speed, tuple) else ()
    speeds = [1.0 if isinstance(speed, tuple) else speed, *(span[-1] for span in shifts if len(span) == 3)]
    numbers = tuple(float(one) for one in speeds if not isinstance(one, str) and 0.01 <= one <= 100)
    if len(numbers) <= len(shifts):
        spans = 'spans such as ["06:00", "14:00", 0.9]'
        raise ValueError(f"expected a table of names, each with a number from 0.01 to 100, or with {spans}")
    return read_spans([(*map(str, span[:2]), n) for n, span in enumerate(shifts, 1)], len(shifts)), numbers


SPEEDS = Check(
    "speeds",
    lambda table: all(map(speeds_of, table.values())),
    {"additionalProperties": {"anyOf": [{"type": "number", "minimum": 0.01, "maximum": 100}, {"type": "array"}]}},
)


def with_times(data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """Return the tables of a scenario with the times instead of the files that hold them.

    Raises
    ------
    InputError
        When a file is wrong.
    """
    changed = dict(data)
    for section, keys in MAY_SPREAD.items():
        if isinstance(table := data.get(section), Mapping):
            times = {key: _read(table[key], folder, f"{section}.{key}.file") for key in keys if key in table}
            changed[section] = {**table, **times}
    return changed


def _read(value: Any, folder: Path, key: str) -> Any:
    """Read measured times where a value names their file and nothing that they contradict."""
    if not isinstance(value, Mapping) or not isinstance(file := value.get("file"), str) or "times" in value:
        return value
    if not (folder / file).is_file():
        raise InputError(key, f"there is no file {file}")
    times = format_module("csv").read_times(folder / file)
    return {key: entry for key, entry in value.items() if key != "file"} | {"times": [*times]}
