"""Classes of what is sorted: shares of all, the best first."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rmfs_rules.helpers.parameters import parameter

Ids = NDArray[np.int64]


def class_borders(of: str) -> Any:
    """Return the parameter ``borders`` of a rule that cuts all of something into classes by `by_share`."""
    return parameter((0.1, 0.3, 1.0), _rise_to_1, f"Where the classes end: shares of all {of}, rising to 1")


def _rise_to_1(_instance: object, _attribute: Any, value: tuple[float, ...]) -> None:
    if not value or value[-1] != 1 or any(a >= b for a, b in zip((0.0, *value), value, strict=False)):
        raise ValueError(f"expected shares above 0 that rise to 1, found {list(value)}")


def by_share(order: Ids, borders: tuple[float, ...]) -> Ids:
    """Cut what is sorted, best first, into classes that end at these shares of all; return the class of each."""
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    ends = [math.floor(border * len(order)) for border in borders[:-1]]
    return np.searchsorted(ends, rank, side="right").astype(np.int64)


def turn(away: Ids, *, better_first: bool) -> Ids:
    """Return when each class or rank is looked at, told by its distance from one's own: that first, then both sides."""
    turns: Ids = 2 * np.abs(away) - ((away < 0) if better_first else (away > 0))
    return turns
