"""A solution of one period's model, in positions of its `Period`."""

from __future__ import annotations

from enum import StrEnum

from attrs import frozen

from rmfs_mip.period import Period


class Model(StrEnum):
    """The paper's three models, by the rule names."""

    INTEGRATED = "integrated"
    SPLIT_AMONG_STATIONS = "split-among-stations"
    SPLIT_OVER_TIME = "split-over-time"


@frozen
class Part:
    """Lines of an order that are assigned to a station: y_ios = 1 for these SKUs."""

    order: int
    station: int
    skus: tuple[int, ...]


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
        What proved it: ``"flow"``, ``"bounds"``, ``"search"``, ``"patterns"``, ``"solver"``, or
        ``"stopped"`` where a limit came first.
    """

    parts: tuple[Part, ...]
    visits: tuple[tuple[int, int], ...]
    objective: float
    bound: float
    how: str

    @property
    def stopped_early(self) -> bool:
        """Whether a limit ended the solve before the proof."""
        return self.how == "stopped"


def is_useful(period: Period, pod: int, station: int, parts: tuple[Part, ...]) -> bool:
    """Whether a pod has a SKU that parts at a station need. What a limit cut short may send others, too."""
    skus = period.stock.contents[pod]
    return any(part.station == station and sku in skus for part in parts for sku in part.skus)


def objective_of(period: Period, parts: tuple[Part, ...], visits: int, weight: float) -> float:
    """Objective (1): visits plus W_u for every place that stays free."""
    taken = sum(items_of(period, part) for part in parts)
    return visits + weight * (sum(period.capacities) - taken)


def items_of(period: Period, part: Part) -> int:
    """Number of items of a part."""
    quantity = dict(period.lines_of(part.order))
    return sum(quantity[sku] for sku in part.skus)
