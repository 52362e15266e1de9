"""Joint POA+PPS rules ``integrated``, ``split-among-stations`` and ``split-over-time``."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from attrs import define, evolve, validators

from rmfs_core import JointDecision, OrderAssignment, PodTrip, SolveReport, hookimpl
from rmfs_rules.helpers import OVERSIZE_WAIT_S
from rmfs_rules.helpers.oversize import Oversize, with_oversize
from rmfs_rules.helpers.packing import MOST_WORK, room_to_split
from rmfs_rules.helpers.parameters import AT_LEAST_1, NOT_NEGATIVE, POSITIVE, parameter
from rmfs_rules.mip.compiled import warm_up
from rmfs_rules.mip.period.effort import Effort
from rmfs_rules.mip.period.period import Period, Preference, Stock
from rmfs_rules.mip.period.solution import Model, Solution
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits, check_installed
from rmfs_rules.mip.proof.parts import with_joining_lines
from rmfs_rules.mip.proof.steps import proof_of
from rmfs_rules.mip.proof.ties import break_ties

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView
    from rmfs_core.world.travel import Travel


@define(kw_only=True)
class _Joint:
    """Code shared by the three rules: parameters, and the way from the warehouse to a decision."""

    model: ClassVar[Model]
    splits_over_time: ClassVar[bool] = False
    libraries: ClassVar[tuple[str, ...]] = ("highspy", "mip")

    formulation: Literal["aggregated", "paper"] = parameter(
        "aggregated",
        validators.in_(("aggregated", "paper")),
        '"aggregated" (same optimum, much faster) or "paper" (one variable and row as printed, for study)',
    )
    solver: Literal["highs", "cbc", "gurobi"] = parameter(
        "highs",
        validators.in_(("highs", "cbc", "gurobi")),
        '"highs", "cbc" or "gurobi" (where installed), through python-mip',
    )
    threads: int = parameter(
        1, AT_LEAST_1, "Threads of the solver. With one, the same seed gives the same result everywhere"
    )
    max_seconds: float | None = parameter(
        None,
        validators.optional(POSITIVE),
        "Wall-clock limit for one period. A period that it ends is marked as stopped early; none by default",
    )
    effort: int | None = parameter(
        None,
        validators.optional(NOT_NEGATIVE),
        "Steps that may be done to prove one period, about a microsecond each; the same on every machine. A "
        "period that uses them up is marked as ended by its effort, with the best decision, its bound and its gap. "
        "By default 1,200 million with up to 100 pods and 100 SKUs (180 million where W_u is no whole number, or "
        "where C limits splits between stations that are alike), else 2 million",
    )
    gap: float = parameter(0.0, NOT_NEGATIVE, "Relative gap at which a solve may stop; such a period is marked, too")
    unused_capacity_weight: float = parameter(
        2.0, POSITIVE, "W_u in the objective (1): what a slot that stays unused costs, in pod-station visits"
    )
    tie_break: Literal["solver", "oldest", "demand", "finish"] = parameter(
        "solver",
        validators.in_(("solver", "oldest", "demand", "finish")),
        'Which of the many optima is taken: "solver" (whichever is found first, as in the paper), "oldest" '
        '(among the optima the oldest orders first), "demand" (the new pods with the most items that the backlog '
        'wants), "finish" (for split-over-time: lines that finish orders). The optimum of (1) is never given up; '
        'with "oldest" and "demand", runs of hundreds of orders can take minutes',
    )
    preferred_pods: Literal["idle", "bound", "any", "random"] = parameter(
        "idle",
        validators.in_(("idle", "bound", "any", "random")),
        'Which of the pods that serve as well the aggregated form sends first: "idle" (bound for no '
        'station), "bound" (for some station), "any" (no preference), "random" (an order drawn anew in each '
        "period). Decides ties only; with a W_u that is not whole, only where no solver is needed",
    )
    max_wait_s: float = parameter(
        OVERSIZE_WAIT_S,
        NOT_NEGATIVE,
        "Seconds in the backlog after which the oldest order that is too large for the model (more items "
        "than any station takes; for split-among-stations, than all take together; if orders are split, in one "
        "line) gets a station of its own: one takes nothing else until it is empty, and then that order alone",
    )

    def __attrs_post_init__(self) -> None:
        if self.formulation == "paper" and self.tie_break != "solver":
            raise ValueError('tie_break needs formulation = "aggregated"; the printed models leave ties to the solver')
        if self.tie_break == "finish" and self.model is not Model.SPLIT_OVER_TIME:
            raise ValueError('tie_break = "finish" is for split-over-time; the other models take orders whole')
        if self.formulation == "paper" and self.preferred_pods != "idle":
            raise ValueError('preferred_pods needs formulation = "aggregated"; the printed models have no such choice')
        if self.formulation == "paper" and self.effort is not None:
            raise ValueError('effort needs formulation = "aggregated"; the printed models go to the solver as a whole')
        check_installed(self.solver)

    def _room(self, _warehouse: WarehouseView) -> tuple[bool, int | None]:
        """Return whether orders are ever split, and how many more may be now; None: any number."""
        return False, None

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView, rng: np.random.Generator) -> JointDecision:
        """Solve one period; it may be that of an order too large for any station to take it together with others."""
        stock, (splits, room) = Stock.of(warehouse), self._room(warehouse)
        capacity = None if room is None else warehouse.split_orders_open + room
        large = Oversize.of(warehouse, self.max_wait_s, splits=splits, over_time=self.model is Model.SPLIT_OVER_TIME)

        def decide(without: Station | None) -> JointDecision:
            """Solve the period of all orders, with a station that takes nothing now."""
            period = Period.of(warehouse, stock, packing=capacity is not None, without=without)
            if self.preferred_pods != "idle":
                period = evolve(period, preference=self._preference(period, rng))
            return _decision(period, self.solve(period, capacity)) if period.stations else JointDecision()

        decision = with_oversize(warehouse, large, decide, lambda large: self._alone(warehouse, stock, large))
        ended_early = decision.report is not None and decision.report.stopped_early and not decision.assignments
        if not ended_early or any(station.load for station in warehouse.stations):
            return decision
        return self._any_order(warehouse, stock, decision)

    def _any_order(self, warehouse: WarehouseView, stock: Stock, decision: JointDecision) -> JointDecision:
        """Return the oldest order that the largest station can take whole, where the search has ended with none.

        Nothing is at the stations, so nothing else would ever happen.
        """
        station = max(warehouse.stations, key=lambda station: (station.free_capacity, -station.id))
        fitting = (order for order in warehouse.backlog if station.open and warehouse.fits(order, station))
        tried = (self._alone(warehouse, stock, Oversize(order, station, True)) for order in fitting)
        return next((found for found in tried if found.assignments), decision)

    def _alone(self, warehouse: WarehouseView, stock: Stock, large: Oversize) -> JointDecision:
        """Assign all that is left of an order to an empty station, or nothing."""
        period = Period.alone(warehouse, stock, large.order, large.station)
        limits = Limits(self.solver, self.threads, self.max_seconds, self.gap)
        solution = proof_of(period, Model.INTEGRATED, max(self.unused_capacity_weight, 2), limits).run()
        return _decision(period, solution)

    def prepare(self, travel: Travel) -> None:  # noqa: ARG002
        """Load the compiled searches, or compile them."""
        if self.formulation == "aggregated":
            warm_up.load()

    def solve(self, period: Period, packing: int | None = None) -> Solution:
        """Solve a period and check the solution by the printed constraints.

        Parameters
        ----------
        period
            The period.
        packing
            C: split orders that may be open at once; None: any number.

        Raises
        ------
        RuntimeError
            When the solution violates one: no decision is better than a wrong one.
        """
        limits = Limits(self.solver, self.threads, self.max_seconds, self.gap)
        weight = self.unused_capacity_weight
        if self.formulation == "paper":
            solution = solve_printed(period, self.model, weight, limits, packing)
        else:
            proof = proof_of(period, self.model, weight, limits, packing)
            proof.limits = evolve(limits, effort=Effort.for_period(period, self.effort, hard=proof.hard))
            proof.run()
            solution = break_ties(proof, self.tie_break)
        solution = with_joining_lines(period, solution, self.model)
        wrong = violation(period, solution, self.model, weight, packing)
        if wrong is not None:
            raise RuntimeError(f"the solution violates the printed model: {wrong}")
        return solution

    def _preference(self, period: Period, rng: np.random.Generator) -> Preference:
        if self.preferred_pods == "random":
            return Preference(rng.random(len(period.stock.pods)))
        if self.preferred_pods == "bound":
            return Preference(1 - period.idle, once_sent=1.0)
        return Preference(np.ones(len(period.stock.pods)))


@define(kw_only=True)
class _Split(_Joint):
    """Code shared by the two rules that split orders."""

    packing_capacity: int | None = parameter(
        None,
        validators.optional(NOT_NEGATIVE),
        "C: split orders that may be open at once (18); by default as many as there are boxes for",
    )
    packing_work_s: float = parameter(0.0, NOT_NEGATIVE, f"{MOST_WORK}, as if C were reached; 0: no such limit", "s")

    def _room(self, warehouse: WarehouseView) -> tuple[bool, int | None]:
        return self.packing_capacity != 0, room_to_split(warehouse, self.packing_capacity, self.packing_work_s)


def _decision(period: Period, solution: Solution) -> JointDecision:
    assignments = tuple(
        OrderAssignment(period.orders[part.order], period.stations[part.station], part.skus)
        for part in sorted(solution.parts, key=lambda part: (part.order, part.station))
    )
    trips = tuple(
        PodTrip(period.stock.pods[pod], period.stations[station])
        for pod, station in solution.visits
        if pod not in period.inbound[station]
    )
    status = solution.how if solution.stopped_early else "optimal"
    report = SolveReport(status, float(solution.objective), float(solution.bound), solution.stopped_early)
    return JointDecision(assignments, trips, report)


@define(kw_only=True)
class Integrated(_Joint):
    """Assign whole orders and select pods together, with the fewest pod-station visits.

    Minimises (1) ``sum of x_ps + W_u * sum of u_s`` over the pods p sent to or already at the stations s and the slots
    u_s that stay free there, such that each assigned order goes to one station (2), (3), no station gets more items
    than it has slots (4), and each of its SKUs is on a pod there (5), (6).

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems.
    arXiv:1902.03092, 2019. https://doi.org/10.48550/arXiv.1902.03092
    Section 3.2, (1) to (10).
    """

    model: ClassVar[Model] = Model.INTEGRATED
    whole_orders: ClassVar[bool] = True


@define(kw_only=True)
class SplitAmongStations(_Split):
    """As ``integrated``, but the lines of an order may go to several stations, all in the same period.

    (2) and (3) give way to (2.1), (3.1), (11) to (14): an assigned order has each line at exactly one station. With a
    packing capacity, (16) to (18) hold besides: no more orders may be split than the packing stations can hold.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems.
    arXiv:1902.03092, 2019. https://doi.org/10.48550/arXiv.1902.03092
    Section 3.3, (1) to (14) with (2.1) and (3.1); Section 4.3 for the packing capacity, (3.2) and (16) to (20).
    """

    model: ClassVar[Model] = Model.SPLIT_AMONG_STATIONS


@define(kw_only=True)
class SplitOverTime(_Split):
    """As ``split-among-stations``, but lines of an order may also stay in the backlog for later periods.

    (11) gives way to (11.1) and (15): a line of an assigned order is at one station or goes back to the backlog. With a
    packing capacity, an order of which a line goes back is split, too.

    References
    ----------
    L. Xie, N. Thieme, R. Krenzler, H. Li: Efficient order picking methods in robotic mobile fulfillment systems.
    arXiv:1902.03092, 2019. https://doi.org/10.48550/arXiv.1902.03092
    Section 3.4, (1) to (15) with (2.1), (3.1) and (11.1); Section 4.3 for the packing capacity, (3.2) and (16) to (20).
    """

    model: ClassVar[Model] = Model.SPLIT_OVER_TIME
    splits_over_time: ClassVar[bool] = True
