"""Column generation for the integrated model where the stations are alike, as they are at t = 1.

So it is for split-over-time, which is the same with every line as an order of its own.

A pattern is what one station may get: pods and whole orders that they serve. With S equal stations of C free slots,

    min sum_k c_k l_k   s.t.  sum_k l_k = S,   sum_k a_Tk l_k <= n_T for each type T of orders,   l_k >= 0 whole,

where c_k is the number of new pods of pattern k plus W_u for each slot it leaves free, and a_Tk how many orders of
type T it takes. It has no symmetry, and its relaxation is close to the optimum.

Patterns are priced exactly (`proof.pricing`), so each round ends in a lower bound.

What the relaxation leaves open is settled from its prices: every better solution consists of patterns that are nearly
as good as the best one, so their sets of pods are few, and a small program chooses among them (`choose_among`).

Where SKUs are scarce, patterns leave that aside, which bounds from below all the same; the small program does not.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import mip
import numpy as np
from attrs import define, evolve, field
from numpy.typing import NDArray

from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Assigned, Model, Part, parts_from
from rmfs_rules.mip.printed.solver import Limits, new_model, optimise
from rmfs_rules.mip.proof.pricing import CLOSE, SAFE, CloseSet, Pattern, Priced, Pricing
from rmfs_rules.mip.proof.program import Program

STEPS_PER_ENTRY = 10
"""Effort of an entry of the relaxation: building takes longer than solving."""
STEPS_PER_CHOICE = 125
"""Effort of an entry where whole patterns are chosen."""
LEAST_ENTRIES = 4000
"""Entries among which whole patterns are chosen even where no effort is left."""


def alike(reduced: Reduced) -> bool:
    """Whether column generation applies: integrated, and several interchangeable stations.

    With scarce SKUs they are only if there is no pod yet: what a pod has is not at each station that it is bound for.
    """
    if len(reduced.scarce) and any(reduced.period.inbound):
        return False
    return reduced.model is Model.INTEGRATED and reduced.interchangeable and len(reduced.capacities) > 1


def lines_as_orders(period: Period) -> Period:
    """Return the period in which every line is an order of its own: what split-over-time makes of it."""
    n = len(period.line_sku)
    return evolve(period, orders=tuple(range(n)), line_order=np.arange(n), begun=())


def orders_of_lines(period: Period, parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """Return the parts of the real orders, from those of `lines_as_orders`."""
    order_of = period.line_order.tolist()
    return parts_from(sorted((order_of[part.order], part.station, sku) for part in parts for sku in part.skus))


@define
class ColumnGeneration:
    """Generates patterns until their relaxation is solved.

    Parameters
    ----------
    reduced
        The period.
    weight
        W_u.
    limits
        Solver and limits.
    seconds_left
        Seconds left of the time limit; None for none.

    Attributes
    ----------
    patterns
        Those found so far.
    bound
        The best bound on the relaxation so far, without the pods of P_s.
    least, prices
        With which it was found: no pattern is worth less than ``least`` at these prices of the types.
    pricing
        The search for patterns.
    """

    reduced: Reduced
    weight: float
    limits: Limits
    seconds_left: Callable[[], float | None]
    patterns: list[Pattern] = field(factory=list, init=False)
    bound: float = field(default=float("-inf"), init=False)
    least: float = field(default=float("-inf"), init=False)
    prices: NDArray[np.float64] = field(factory=lambda: np.zeros(0), init=False)
    pricing: Pricing = field(init=False)
    _known: set[tuple[tuple[int, ...], tuple[tuple[int, int], ...]]] = field(factory=set, init=False)
    _grown: bool = field(default=False, init=False)

    def __attrs_post_init__(self) -> None:
        self.pricing = Pricing(self.reduced, self.weight, self.limits)
        self._add(Pattern((), (), self.weight * self.pricing.room))

    def _add(self, pattern: Pattern) -> bool:
        """Take in a pattern; return whether it is new."""
        key = pattern.pods, pattern.orders
        if key in self._known:
            return False
        self._known.add(key)
        self.patterns.append(pattern)
        return True

    def run(self) -> None:
        """Generate patterns until none has negative reduced cost (or the time is up)."""
        prices, convexity = np.zeros(len(self.reduced.types)), float("inf")
        while True:
            priced = self.pricing.by_sets(prices, convexity)
            if not self._take(priced, prices, convexity) and priced.bound is None:
                proven = self.pricing.by_model(prices, self.seconds_left())
                if proven is None or not self._take(proven, prices, convexity):
                    return
            elif not self._grown:
                return
            left = self.seconds_left()
            if (left is not None and left <= 0) or not self._affordable():
                return
            prices, convexity = self._relaxation()

    def _affordable(self) -> bool:
        """Whether the relaxation can be solved once more; it is taken from the effort."""
        entries = sum(1 + len(pattern.orders) for pattern in self.patterns)
        steps = entries * STEPS_PER_ENTRY
        if not self.limits.effort.allows(steps):
            return False
        self.limits.effort.take(steps)
        return True

    def _take(self, priced: Priced, prices: NDArray[np.float64], convexity: float) -> bool:
        """Take in patterns with negative reduced cost and the bound; return whether there were new ones."""
        if priced.bound is not None:
            bound = float(prices @ self.pricing.counts) + len(self.reduced.capacities) * priced.bound
            if bound > self.bound:
                self.bound, self.prices, self.least = bound, prices, priced.bound
        new = [self._add(p) for value, p in priced.patterns if value < convexity - CLOSE]
        self._grown = any(new)
        return self._grown

    def _values(self, patterns: list[Pattern]) -> list[float]:
        """Return what the patterns cost at the prices."""
        dear = {number: price for number, price in enumerate(self.prices.tolist()) if price}
        return [p.cost - sum(dear.get(t, 0.0) * n for t, n in p.orders) for p in patterns]

    def _as_effort_allows(self, patterns: list[Pattern]) -> list[Pattern]:
        """Return the cheapest patterns, in their order, among which the effort allows to choose; it is taken."""
        effort, sizes = self.limits.effort, np.array([1 + len(p.orders) for p in patterns])
        room = max(effort.left / STEPS_PER_CHOICE, LEAST_ENTRIES)
        if sizes.sum() > room:
            effort.short = True
            cheapest = np.argsort(np.round(self._values(patterns), 6), kind="stable")
            kept = np.sort(cheapest[np.cumsum(sizes[cheapest]) <= room])
            patterns, sizes = [patterns[place] for place in kept.tolist()], sizes[kept]
        effort.take(float(sizes.sum()) * STEPS_PER_CHOICE)
        return patterns

    def _master(
        self, patterns: list[Pattern], *, whole: bool
    ) -> tuple[mip.Model, list[mip.Var], mip.Constr, dict[int, mip.Constr]]:
        model = new_model(self.limits)
        kind = mip.INTEGER if whole else mip.CONTINUOUS
        stations = len(self.reduced.capacities)
        chosen = [model.add_var(obj=p.cost, ub=stations, var_type=kind) for p in patterns]
        convexity = model.add_constr(mip.LinExpr(chosen, [1.0] * len(chosen), -stations, "="))
        taking: dict[int, tuple[list[mip.Var], list[float]]] = {}
        for variable, pattern in zip(chosen, patterns, strict=True):
            for number, orders in pattern.orders:
                variables, factors = taking.setdefault(number, ([], []))
                variables.append(variable)
                factors.append(float(orders))
        counts = self.pricing.counts
        rows = {
            number: model.add_constr(mip.LinExpr(variables, factors, -float(counts[number]), "<"))
            for number, (variables, factors) in sorted(taking.items())
        }
        return model, chosen, convexity, rows

    def _relaxation(self) -> tuple[NDArray[np.float64], float]:
        """Solve the relaxation over the patterns so far; return the types' prices (<= 0) and the stations'."""
        model, _, convexity, rows = self._master(self.patterns, whole=False)
        model.optimize()
        prices = np.zeros(len(self.reduced.types))
        for number, row in rows.items():
            prices[number] = min(row.pi, 0.0)
        return prices, float(convexity.pi)

    def whole(self) -> Assigned | None:
        """Return visits (pod, station) and parts of the best choice of whole patterns, or None when time is up."""
        patterns = self._as_effort_allows(self.patterns)
        if not patterns:
            return None
        model, _, _, _ = self._master(patterns, whole=True)
        outcome = optimise(model, self.limits, absolute_gap=0.9, seconds=self.seconds_left())
        if outcome.values is None:
            return None
        used = [p for p, value in zip(patterns, outcome.values, strict=True) for _ in range(round(value))]
        return self.assigned(used)

    def assigned(self, used: list[Pattern]) -> Assigned:
        """Return visits (pod, station) and parts of a pattern for each station."""
        visits: list[tuple[int, int]] = []
        parts: list[Part] = []
        left = [list(kind.orders) for kind in self.reduced.types]
        for station, pattern in enumerate(used):
            visits += [(pod, station) for pod in pattern.pods]
            for number, orders in pattern.orders:
                skus = tuple(sku for sku, _ in self.reduced.types[number].lines)
                parts += [Part(left[number].pop(0), station, skus) for _ in range(orders)]
        return tuple(visits), tuple(parts)


@define
class _SetChoice:
    """How many stations get a set of pods, and which orders they take: columns of a program."""

    worth: float
    pods: tuple[int, ...]
    stations: int
    orders: dict[int, int] = field(factory=dict)  # type -> column


def choose_among(
    generation: ColumnGeneration, sets: list[CloseSet], value: float, seconds: float | None
) -> tuple[Assigned | None, bool]:
    """Return a solution of a given value in which every station gets one of the given sets of pods.

    Stations with the same set share their slots in the program; whether each order finds a whole slot is looked at
    afterwards.

    Parameters
    ----------
    generation
        The relaxation, with its bound and the prices behind it.
    sets
        The sets of pods.
    value
        Highest cost of the solution, without the pods of P_s.
    seconds
        Seconds left of the time limit; None for none.

    Returns
    -------
    found, proven
        None when nothing costs as little, or the time was up; whether the answer is proven.
    """
    if not sets:
        return None, True
    reduced, weight = generation.reduced, generation.weight
    stations, room = len(reduced.capacities), reduced.capacities[0]
    program, choices = _set_program(reduced, sets, weight)
    costs = [(column, cost) for column, cost in enumerate(program.cost) if cost]
    program.constant = weight * room * stations
    program.row([c for c, _ in costs], [cost for _, cost in costs], "<", value - program.constant)
    _add_prices(generation, program, choices, value)
    outcome = program.solve(generation.limits, absolute_gap=0.9, seconds=seconds)
    if outcome.values is None:
        return None, outcome.bound == float("inf")
    used: list[Pattern] = []
    for choice in choices:
        taken = {t: round(outcome.values[column]) for t, column in choice.orders.items()}
        packed = _pack(reduced, taken, round(outcome.values[choice.stations]))
        if packed is None:
            return None, False
        used += [Pattern(choice.pods, tuple(Counter(kinds).items()), choice.worth) for kinds in packed]
    return generation.assigned(used), outcome.optimal


def _set_program(reduced: Reduced, sets: list[CloseSet], weight: float) -> tuple[Program, list[_SetChoice]]:
    period, stations, room = reduced.period, len(reduced.capacities), reduced.capacities[0]
    program = Program()
    choices: list[_SetChoice] = []
    for worth, pods in sets:
        choice = _SetChoice(worth, pods, program.column(cost=float(len(pods)), upper=stations))
        choices.append(choice)
        at_hand = period.covered[0] | period.stock.on(pods)
        filling = {choice.stations: -float(room)}
        for t, kind in enumerate(reduced.types):
            upper = min(len(kind.orders), room // kind.size)
            if upper and all(at_hand[sku] for sku, _ in kind.lines):
                column = choice.orders[t] = program.column(cost=-weight * kind.size, upper=float(len(kind.orders)))
                program.row([column, choice.stations], [1.0, -float(upper)], "<", 0.0)
                filling[column] = float(kind.size)
        program.row(list(filling), list(filling.values()), "<", 0.0)
    program.row([choice.stations for choice in choices], [1.0] * len(choices), "=", stations)
    for t, kind in enumerate(reduced.types):
        columns = [choice.orders[t] for choice in choices if t in choice.orders]
        if columns:
            program.row(columns, [1.0] * len(columns), "<", len(kind.orders))
    if len(reduced.scarce):
        _add_stock(reduced, program, choices)
    return program, choices


def _add_prices(generation: ColumnGeneration, program: Program, choices: list[_SetChoice], value: float) -> None:
    """Let every station have a pattern that is close enough, and none better than the best of its set.

    What a solution costs more than the bound is what its patterns are worth more than the least one, and the prices of
    the orders that it leaves.
    """
    reduced, room = generation.reduced, generation.pricing.room
    slack = value - generation.bound + SAFE
    limit = generation.least + slack
    sizes = np.array([kind.size for kind in reduced.types])
    worths = (generation.weight * sizes + generation.prices).tolist()
    for choice in choices:
        nothing = len(choice.pods) + generation.weight * room  # what the pods are worth without an order
        columns = [*choice.orders.values(), choice.stations]
        taken = [worths[t] for t in choice.orders]
        program.row(columns, [*taken, limit - nothing], ">", 0.0)
        program.row(columns, [*taken, choice.worth - nothing - SAFE], "<", 0.0)
    for t, price in enumerate((-generation.prices).tolist()):
        columns = [choice.orders[t] for choice in choices if t in choice.orders]
        least = len(reduced.types[t].orders) - int(slack / price) if price > SAFE else 0
        if least > 0 and columns:
            program.row(columns, [1.0] * len(columns), ">", least)


def _add_stock(reduced: Reduced, program: Program, choices: list[_SetChoice]) -> None:
    """Let the stations of a choice take scarce SKUs from its pods, and all stations no more than a pod has."""
    shared: dict[tuple[int, int], list[int]] = {}
    held = {pod: reduced.period.stock.items_on(pod) for pod in {pod for choice in choices for pod in choice.pods}}
    for choice in choices:
        taking: dict[int, dict[int, float]] = {}
        for t, column in choice.orders.items():
            for sku, quantity in reduced.types[t].lines:
                if reduced.is_scarce[sku]:
                    taking.setdefault(sku, {})[column] = float(quantity)
        for sku, taken in taking.items():
            for pod in choice.pods:
                if sku in held[pod]:
                    given = program.column(upper=float(held[pod][sku]), whole=False)
                    program.row([given, choice.stations], [1.0, -program.upper[given]], "<", 0.0)
                    taken[given] = -1.0
                    shared.setdefault((pod, sku), []).append(given)
            program.row(list(taken), list(taken.values()), "<", 0.0)
    for (pod, sku), columns in shared.items():
        if len(columns) > 1:
            program.row(columns, [1.0] * len(columns), "<", held[pod][sku])


def _pack(reduced: Reduced, taken: dict[int, int], stations: int) -> list[list[int]] | None:
    """Give each order (by type) a station, largest first; None when that does not fit."""
    rooms = [reduced.capacities[0]] * stations
    packed: list[list[int]] = [[] for _ in rooms]
    for t in sorted(taken, key=lambda t: (-reduced.types[t].size, t)):
        size = reduced.types[t].size
        for _ in range(taken[t]):
            station = next((s for s, free in enumerate(rooms) if free >= size), None)
            if station is None:
                return None
            rooms[station] -= size
            packed[station].append(t)
    return packed
