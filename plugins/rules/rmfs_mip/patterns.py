"""Column generation for the integrated model where the stations are alike, as they are at t = 1.

So it is for split-over-time, which is the same with every line as an order of its own.

A pattern is what one station may get: pods and whole orders that they serve. With S equal stations of C free places,

    min sum_k c_k l_k   s.t.  sum_k l_k = S,   sum_k a_Tk l_k <= n_T for each type T of orders,   l_k >= 0 whole,

where c_k is the number of new pods of pattern k plus W_u for each place it leaves free, and a_Tk how many orders of
type T it takes. It has no symmetry, and its relaxation is close to the optimum.

Patterns are priced exactly: by a search for sets of pods of one size after another (`rmfs_mip.pattern_search`), which
ends because a pattern with k pods is worth at least k; where that takes too long, by the aggregated model of a single
station.

What the relaxation leaves open is settled from its prices: every better solution consists of patterns that are nearly
as good as the best one, so their sets of pods are few, and a small program chooses among them (`choose_among`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mip
import numpy as np
from attrs import define, evolve, field, frozen
from numpy.typing import NDArray

from rmfs_mip.aggregated import Builder
from rmfs_mip.arrays import arrays_of
from rmfs_mip.period import Period
from rmfs_mip.reduction import Reduced
from rmfs_mip.solution import Model, Part
from rmfs_mip.solver import Limits, Program, new_model, optimise

Assigned = tuple[tuple[tuple[int, int], ...], tuple[Part, ...]]
"""Visits (pod, station) and parts."""

MOST_WORK = 2_000_000
"""Steps of the search for sets of pods, each a fraction of a microsecond, before the aggregated model prices."""
KEPT = 60
"""Sets of pods of each size that become patterns in one round."""
CLOSE_SETS = (100, 500, 2000)
"""Sets of pods from which a better solution, if there is one, is put together: first the best few, then more."""
CLOSE = 1e-6
SAFE = 1e-4
"""What rounding may add to a bound; far more than it does."""


@frozen
class Pattern:
    """Pods (positions) and orders (type to number) of one station, and what they cost."""

    pods: tuple[int, ...]
    orders: tuple[tuple[int, int], ...]
    cost: float


@define
class Priced:
    """Good patterns at the current prices, and a bound on the value of any pattern (None: not known)."""

    patterns: list[tuple[float, Pattern]]
    bound: float | None


def alike(reduced: Reduced) -> bool:
    """Whether column generation applies: integrated, and several interchangeable stations."""
    return reduced.model is Model.INTEGRATED and reduced.interchangeable and len(reduced.capacities) > 1


def lines_as_orders(period: Period) -> Period:
    """Return the period in which every line is an order of its own: what split-over-time makes of it."""
    n = len(period.line_sku)
    return evolve(period, orders=tuple(range(n)), line_order=np.arange(n), begun=())


def orders_of_lines(period: Period, parts: tuple[Part, ...]) -> tuple[Part, ...]:
    """Return the parts of the real orders, from those of `lines_as_orders`."""
    skus: dict[tuple[int, int], list[int]] = {}
    for part in parts:
        skus.setdefault((int(period.line_order[part.order]), part.station), []).extend(part.skus)
    return tuple(Part(order, station, tuple(sorted(held))) for (order, station), held in sorted(skus.items()))


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
        What is left of the time limit; None for none.
    """

    reduced: Reduced
    weight: float
    limits: Limits
    seconds_left: Callable[[], float | None]
    patterns: list[Pattern] = field(factory=list)
    known: set[tuple[tuple[int, ...], tuple[tuple[int, int], ...]]] = field(factory=set)
    bound: float = float("-inf")
    grown: bool = False
    least: float = float("-inf")
    prices: NDArray[np.float64] = field(factory=lambda: np.zeros(0))
    pricing: Pricing = field(init=False)

    def __attrs_post_init__(self) -> None:
        self.pricing = Pricing(self.reduced, self.weight, self.limits)
        self.add(Pattern((), (), self.weight * self.room))

    @property
    def room(self) -> int:
        """C."""
        return self.reduced.capacities[0]

    @property
    def counts(self) -> NDArray[np.int64]:
        """n_T."""
        return np.array([len(kind.orders) for kind in self.reduced.types], dtype=np.int64)

    def add(self, pattern: Pattern) -> bool:
        """Take in a pattern; return whether it is new."""
        key = pattern.pods, pattern.orders
        if key in self.known:
            return False
        self.known.add(key)
        self.patterns.append(pattern)
        return True

    def run(self) -> None:
        """Generate patterns until none has negative reduced cost (or the time is up)."""
        pricing = self.pricing
        prices, convexity = np.zeros(len(self.reduced.types)), float("inf")
        while True:
            priced = pricing.by_sets(prices, convexity)
            if not self._take(priced, prices, convexity) and priced.bound is None:
                proven = pricing.by_model(prices, self.seconds_left())
                if proven is None or not self._take(proven, prices, convexity):
                    return
            elif not self.grown:
                return
            left = self.seconds_left()
            if left is not None and left <= 0:
                return
            prices, convexity = self._relaxation()

    def _take(self, priced: Priced, prices: NDArray[np.float64], convexity: float) -> bool:
        """Take in patterns with negative reduced cost and the bound; return whether there were new ones."""
        if priced.bound is not None:
            bound = float(prices @ self.counts) + len(self.reduced.capacities) * priced.bound
            if bound > self.bound:
                self.bound, self.prices, self.least = bound, prices, priced.bound
        new = [self.add(p) for value, p in priced.patterns if value < convexity - CLOSE]
        self.grown = any(new)
        return self.grown

    def _master(self, *, whole: bool) -> tuple[mip.Model, list[mip.Var], mip.Constr, dict[int, mip.Constr]]:
        model = new_model(self.limits)
        kind = mip.INTEGER if whole else mip.CONTINUOUS
        stations = len(self.reduced.capacities)
        chosen = [model.add_var(obj=p.cost, ub=stations, var_type=kind) for p in self.patterns]
        convexity = model.add_constr(mip.LinExpr(chosen, [1.0] * len(chosen), -stations, "="))
        taking: dict[int, tuple[list[mip.Var], list[float]]] = {}
        for variable, pattern in zip(chosen, self.patterns, strict=True):
            for number, orders in pattern.orders:
                variables, factors = taking.setdefault(number, ([], []))
                variables.append(variable)
                factors.append(float(orders))
        counts = self.counts
        rows = {
            number: model.add_constr(mip.LinExpr(variables, factors, -float(counts[number]), "<"))
            for number, (variables, factors) in sorted(taking.items())
        }
        return model, chosen, convexity, rows

    def _relaxation(self) -> tuple[NDArray[np.float64], float]:
        """Solve the relaxation over the patterns so far; return the types' prices (<= 0) and the stations'."""
        model, _, convexity, rows = self._master(whole=False)
        model.optimize()
        prices = np.zeros(len(self.reduced.types))
        for number, row in rows.items():
            prices[number] = min(row.pi, 0.0)
        return prices, float(convexity.pi)

    def whole(self) -> Assigned | None:
        """Return visits (pod, station) and parts of the best choice of whole patterns, or None when time is up."""
        model, _, _, _ = self._master(whole=True)
        outcome = optimise(model, self.limits, absolute_gap=0.9, seconds=self.seconds_left())
        if outcome.values is None:
            return None
        used = [p for p, value in zip(self.patterns, outcome.values, strict=True) for _ in range(round(value))]
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

    pods: tuple[int, ...]
    stations: int
    orders: dict[int, int] = field(factory=dict)  # type -> column


def choose_among(
    reduced: Reduced, sets: list[tuple[int, ...]], weight: float, limits: Limits, seconds: float | None, most: float
) -> tuple[Assigned | None, bool]:
    """Return the best solution in which every station gets one of the given sets of pods, and whether that is proven.

    The solution is None when none costs at most ``most`` (without the pods of P_s), or the time was up. Stations with
    the same set share their places in the program; whether each order finds a whole place is looked at afterwards.
    """
    stations, room = len(reduced.capacities), reduced.capacities[0]
    program, choices = _set_program(reduced, sets, weight)
    costs = [(column, cost) for column, cost in enumerate(program.cost) if cost]
    program.constant = weight * room * stations
    program.row([c for c, _ in costs], [cost for _, cost in costs], "<", most - program.constant)
    outcome = program.solve(limits, absolute_gap=0.9, seconds=seconds)
    if outcome.values is None:
        return None, outcome.bound == float("inf")
    visits: list[tuple[int, int]] = []
    parts: list[Part] = []
    left = [list(kind.orders) for kind in reduced.types]
    first = 0
    for choice in choices:
        number = round(outcome.values[choice.stations])
        taken = {t: round(outcome.values[column]) for t, column in choice.orders.items()}
        packed = _pack(reduced, taken, number)
        if packed is None:
            return None, False
        for station, kinds in enumerate(packed, first):
            visits += [(pod, station) for pod in choice.pods]
            parts += [Part(left[t].pop(0), station, tuple(sku for sku, _ in reduced.types[t].lines)) for t in kinds]
        first += number
    return (tuple(visits), tuple(parts)), outcome.optimal


def _set_program(reduced: Reduced, sets: list[tuple[int, ...]], weight: float) -> tuple[Program, list[_SetChoice]]:
    period, stations, room = reduced.period, len(reduced.capacities), reduced.capacities[0]
    program = Program.empty()
    choices: list[_SetChoice] = []
    for pods in sets:
        choice = _SetChoice(pods, program.column(cost=float(len(pods)), upper=stations))
        choices.append(choice)
        at_hand = period.covered[0] | period.stock.holds[list(pods)].any(axis=0)
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
    return program, choices


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


class Pricing:
    """Finds the patterns of least value ``c_k - sum_T price_T a_Tk``."""

    def __init__(self, reduced: Reduced, weight: float, limits: Limits) -> None:
        self.reduced, self.weight, self.limits = reduced, weight, limits
        period, types = reduced.period, reduced.types
        covered = period.covered[0]
        self.room = reduced.capacities[0]
        self.sizes = np.array([kind.size for kind in types], dtype=np.int64)
        self.counts = np.array([len(kind.orders) for kind in types], dtype=np.int64)
        self.missing = [[sku for sku, _ in kind.lines if not covered[sku]] for kind in types]
        self.arrays, self.pods = arrays_of(reduced)
        skus = np.split(self.arrays.pod_sku, self.arrays.pod_start[1:-1])
        self.brings = [held.tolist() for held in skus] if self.pods else []
        type_of = {order: t for t, kind in enumerate(types) for order in kind.orders}
        self.type_of = np.array([type_of[order] for order in reduced.orders], dtype=np.int64)

    def by_sets(self, prices: NDArray[np.float64], limit: float) -> Priced:
        """Return the best patterns worth less than ``limit``; without a bound where not all could be tried."""
        values = self.weight * self.sizes + prices
        most = float(self.weight * self.room)
        found: list[tuple[float, Pattern]] = []
        least = limit = min(most, limit)
        for number in range(len(self.pods) + 1):
            if number >= least - CLOSE:  # a pattern with so many pods is worth at least as much
                return Priced(found, least)
            sets = self._sets(number, values, number + most - limit, KEPT)
            if sets is None:
                return Priced(found, None)
            for worth, chosen in sets:
                least = min(least, number + most - worth)
                found.append((number + most - worth, self._pattern(chosen, values)))
        return Priced(found, least)

    def close_sets(self, prices: NDArray[np.float64], limit: float) -> tuple[list[tuple[int, ...]], bool]:
        """Return the sets of pods (positions) with a pattern worth at most ``limit``, best first, and if these are all.

        No more than the last of `CLOSE_SETS` are returned.
        """
        values = self.weight * self.sizes + prices
        most, kept = self.weight * self.room, CLOSE_SETS[-1]
        close: list[tuple[float, tuple[int, ...]]] = []
        complete = True
        for number in range(min(len(self.pods), int(limit + SAFE)) + 1):
            sets = self._sets(number, values, number + most - limit - SAFE, kept)
            complete = complete and sets is not None and len(sets) < kept
            for worth, chosen in sets or []:
                close.append((number + most - worth, tuple(self.pods[place] for place in chosen)))
        close.sort()
        return [pods for _, pods in close[:kept]], complete and len(close) <= kept

    def _sets(
        self, number: int, values: NDArray[np.float64], least: float, kept: int
    ) -> list[tuple[float, list[int]]] | None:
        """Return the best sets of pods worth at least ``least``, None when they are too many to search."""
        from rmfs_mip import pattern_search

        work = np.zeros(1, dtype=np.int64)
        values = values[self.type_of]
        worths, sets = pattern_search.best_sets(self.arrays, number, values, least, kept, work, MOST_WORK)
        if work[0] > MOST_WORK:
            return None
        return sorted((worth, chosen) for worth, chosen in zip(worths.tolist(), sets.tolist(), strict=True))

    def _pattern(self, chosen: Sequence[int], values: NDArray[np.float64]) -> Pattern:
        """Return the best pattern of a set of pods (numbers of classes)."""
        at_hand = {sku for number in chosen for sku in self.brings[number]}
        able = [t for t, missing in enumerate(self.missing) if values[t] > 0 and at_hand.issuperset(missing)]
        items = [t for t in able for _ in range(min(int(self.counts[t]), self.room // int(self.sizes[t])))]
        table = np.zeros((len(items) + 1, self.room + 1))
        for row, number in enumerate(items):
            size = int(self.sizes[number])
            table[row + 1] = table[row]
            table[row + 1, size:] = np.maximum(table[row, size:], table[row, : self.room + 1 - size] + values[number])
        orders: dict[int, int] = {}
        place = self.room
        for row in range(len(items), 0, -1):
            if table[row, place] > table[row - 1, place]:
                orders[items[row - 1]] = orders.get(items[row - 1], 0) + 1
                place -= int(self.sizes[items[row - 1]])
        return self._costed(tuple(self.pods[number] for number in chosen), orders)

    def _costed(self, pods: tuple[int, ...], orders: dict[int, int]) -> Pattern:
        taken = sum(int(self.sizes[number]) * n for number, n in orders.items())
        return Pattern(pods, tuple(sorted(orders.items())), len(pods) + self.weight * (self.room - taken))

    def by_model(self, prices: NDArray[np.float64], seconds: float | None) -> Priced | None:
        """Return the best pattern, whatever the number of its pods; None when the time is up before it is proven."""
        period = self.reduced.period
        one = evolve(period, stations=period.stations[:1], capacities=period.capacities[:1], inbound=period.inbound[:1])
        model = Builder(Reduced(one, Model.INTEGRATED), self.weight).build()
        for column in model.x.values():
            model.program.cost[column] = 1.0
        for (number, _), column in model.y.items():
            model.program.cost[column] = -self.weight * float(self.sizes[number]) - float(prices[number])
        model.program.constant = self.weight * self.room
        outcome = model.program.solve(self.limits, absolute_gap=CLOSE, seconds=seconds)
        if outcome.values is None or not outcome.optimal:
            return None
        pods = tuple(pod for (pod, _), column in model.x.items() if outcome.values[column] > 0.5)
        orders = {t: round(outcome.values[c]) for (t, _), c in model.y.items() if outcome.values[c] > 0.5}
        return Priced([(outcome.objective, self._costed(pods, orders))], min(outcome.bound, outcome.objective))
