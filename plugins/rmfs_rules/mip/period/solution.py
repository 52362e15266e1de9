"""Decision of a period: which lines go to which station with which pods, and what that costs by (1)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from enum import StrEnum

from attrs import frozen

from rmfs_rules.mip.period.period import Period


class Model(StrEnum):
    """The paper's three models, by the rule names."""

    INTEGRATED = "integrated"
    SPLIT_AMONG_STATIONS = "split-among-stations"
    SPLIT_OVER_TIME = "split-over-time"


Visits = tuple[tuple[int, int], ...]
"""(pod, station), both as positions, with x_ps = 1."""


@frozen
class Part:
    """Lines of an order that are assigned to a station: y_ios = 1 for these SKUs.

    Parameters
    ----------
    order, station
        Their positions in the period.
    skus
        SKU ids of the lines.
    """

    order: int
    station: int
    skus: tuple[int, ...]


def parts_from(lines: Iterable[tuple[int, int, int]]) -> tuple[Part, ...]:
    """Return the parts of lines (order, station, SKU), in the order of the first line of each."""
    skus: dict[tuple[int, int], list[int]] = {}
    for order, station, sku in lines:
        skus.setdefault((order, station), []).append(sku)
    return tuple(Part(order, station, tuple(held)) for (order, station), held in skus.items())


Assigned = tuple[Visits, tuple[Part, ...]]
"""New visits, and the lines that they and the pods of P_s serve."""


@frozen
class Solution:
    """Values of the decision variables.

    Parameters
    ----------
    parts
        Assigned lines.
    visits
        (pod, station) with x_ps = 1, those of P_s included.
    objective
        Value of the objective (1).
    bound
        Proven lower bound of it.
    how
        Step that found it: ``"flow"``, ``"bounds"``, ``"greedy"``, ``"search"``, ``"patterns"``, ``"solver"``, or, if
        something came before the proof, ``"effort"`` (it was used up) or ``"stopped"`` (another limit).
    """

    parts: tuple[Part, ...]
    visits: Visits
    objective: float
    bound: float
    how: str

    @property
    def stopped_early(self) -> bool:
        """Whether a limit ended the solve before the proof."""
        return self.how in ("effort", "stopped")


def is_whole(weight: float) -> bool:
    """Whether the objective (1) with this W_u is always a whole number."""
    return float(weight).is_integer()


def objective_of(period: Period, parts: tuple[Part, ...], visits: int, weight: float) -> float:
    """Return objective (1): visits plus W_u for every slot that stays free (see `Period.factors`)."""
    return visits + weight * unused(period, parts)


def unused(period: Period, parts: tuple[Part, ...]) -> int:
    """Return the sum of u_s, each times the station's factor."""
    if not period.counting_orders:
        return sum(period.capacities) - items_of(period, parts)
    free = list(period.capacities)
    for part in parts:
        free[part.station] -= period.slots(part.order, part.station, items_of(period, (part,)))
    return sum(factor * slots for factor, slots in zip(period.factors, free, strict=True))


def items_of(period: Period, parts: tuple[Part, ...]) -> int:
    """Return the number of items of parts."""
    if period.single_items:
        return sum(len(part.skus) for part in parts)
    return sum(dict(period.lines_of(part.order))[sku] for part in parts for sku in part.skus)


def is_useful(period: Period, pod: int, station: int, parts: tuple[Part, ...]) -> bool:
    """Whether a pod has a SKU that parts at a station need. What a limit cut short may send others, too."""
    skus = {*period.stock.skus_of(pod).tolist()}
    return any(part.station == station and sku in skus for part in parts for sku in part.skus)


def newly_split(period: Period, parts: tuple[Part, ...]) -> list[int]:
    """Return the orders (positions) with y_o^l = 1.

    They are at several stations, or have lines left in the backlog, and were whole until now.
    """
    stations: dict[int, set[int]] = {}
    lines: Counter[int] = Counter()
    for part in parts:
        stations.setdefault(part.order, set()).add(part.station)
        lines[part.order] += len(part.skus)
    return [
        order
        for order, at in stations.items()
        if not period.begun_before(order) and (len(at) > 1 or lines[order] < len(period.lines_of(order)))
    ]
