"""The parameters that POA rules share, for rules that keep scores from call to call."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from attrs import Factory, define, field
from numpy.typing import NDArray

from rmfs_core.decisions import OrderAssignment
from rmfs_rules.helpers.options import LaneOptions, PairOptions, lot_key
from rmfs_rules.helpers.pair_assigning import Ints, Prefer, Take
from rmfs_rules.helpers.pair_scores import PairScores, by_due_time

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import Order, WarehouseView


@define
class KeptLanes(LaneOptions):
    """Parameters of a rule that keeps an account of the orders, and ranks them alike at all stations."""

    scores: PairScores = field(
        init=False, default=Factory(lambda rule: PairScores(rule.rank), takes_self=True), repr=False, eq=False
    )
    """The account."""

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        self.scores.load()

    def rank(self, order: Order) -> float:
        """Which orders go first: those with the lowest number."""
        raise NotImplementedError

    def keeps(self, warehouse: WarehouseView) -> bool:
        """Take in what changed, and say whether `assign_kept` may decide."""
        return self.scores.decides(warehouse)

    def assign_kept(self, warehouse: WarehouseView) -> list[OrderAssignment]:
        """Assign the orders as they are ranked, by what is kept."""
        return self.scores.assign(warehouse, max_wait_s=self.max_wait_s, fast_lane=self.fast_lane)


def _of_options(options: PairOptions) -> PairScores:
    return PairScores(by_due_time if options.tie_break == "due" else None, late_first=options.late_first)


@define
class KeptPairs(PairOptions):
    """Parameters of a rule that keeps the scores of pairs of order and station."""

    scores: PairScores = field(init=False, default=Factory(_of_options, takes_self=True), repr=False, eq=False)
    """The scores, for a ``take`` that changes them: `PairScores.lines_of`, `PairScores.change`."""

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        self.scores.load()

    def keeps(self, warehouse: WarehouseView, *available: Ints) -> bool:
        """Take in what changed, as `PairScores.update` does, and say whether `assign_kept` may decide."""
        return self.scores.decides(warehouse, *available)

    def assign_kept(
        self,
        warehouse: WarehouseView,
        rng: np.random.Generator,
        take: Take | None = None,
        prefer: Prefer | None = None,
        extra: NDArray[np.float64] | None = None,
    ) -> list[OrderAssignment]:
        """Assign the best pairs by the scores that are kept, as `PairScores.assign` does with these parameters."""
        return self.scores.assign(
            warehouse,
            take,
            prefer,
            extra=extra,
            max_wait_s=self.max_wait_s,
            fast_lane=self.fast_lane,
            key=lot_key(rng) if self.tie_break == "random" else 0,
        )
