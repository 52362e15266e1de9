"""Where stations count orders: the aggregated form, a bound and quick solutions, and lines that take no further slot.

A part of an order takes one slot, however many lines it has, and costs as many visits as it takes to bring these. So
nothing of `proof.steps` that counts items holds there; the steps are these:

1. `by_nothing`, as there.
2. `by_slots`. From below: a station at which too few orders find a line that is there already needs a visit, or leaves
   slots free. From above: slots are filled with what is there, then pod by pod.
3. `by_patterns`, as there: where each order goes to one station, it takes one slot, whatever its lines.
4. `by_solver`, as there, with orders of several lines told apart (`PartsBuilder`).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from attrs import evolve
from numpy.typing import NDArray

from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.placing import short_of
from rmfs_rules.mip.period.reduction import OrderType, Reduced
from rmfs_rules.mip.period.solution import Model, Part, Solution, unused
from rmfs_rules.mip.proof.aggregated import Builder, Gains
from rmfs_rules.mip.proof.proof import Proof
from rmfs_rules.mip.proof.stocked import Shelf


def builder_of(reduced: Reduced, weight: float, splits: int | None, gains: Gains | None = None) -> Builder:
    """Return what builds the aggregated form of a reduced period.

    Parameters
    ----------
    reduced
        The period.
    weight
        W_u.
    splits
        How many orders may newly be split; None for any number.
    gains
        The second objective; None to minimise objective (1).
    """
    apart = reduced.period.counting_orders and reduced.model is not Model.INTEGRATED
    return (PartsBuilder if apart else Builder)(reduced, weight, splits, gains)


class PartsBuilder(Builder):
    """Builds the aggregated form where stations count orders and orders may be split.

    Orders of one line are counted by type, y_Ts. For the lines i of any other order o: y_ios, and y_os for its part.
    """

    def _orders(self) -> None:
        fresh: list[int] = []
        for number, kind in enumerate(self.reduced.types):
            if len(kind.lines) == 1 and (self.splits is None or kind.begun or not self._incomplete(kind)):
                self._whole_type(number, kind)
                continue
            for order in kind.orders:
                fresh += self._order(kind, order)
        if self.splits is not None and fresh:
            self.model.program.row(fresh, [1.0] * len(fresh), "<", self.splits)  # (18)

    def _order(self, kind: OrderType, order: int) -> list[int]:
        """Add an order's lines and parts; return the column that says whether it is newly split, where that counts."""
        program = self.model.program
        by_line = [self._line(order, line) for line in kind.lines]
        among = self.reduced.model is Model.SPLIT_AMONG_STATIONS
        if among and not all(by_line):
            return []
        chosen = program.column() if among else -1
        for columns in by_line:
            if among:
                program.row([*columns.values(), chosen], [1.0] * len(columns) + [-1.0], "=", 0.0)  # (11)
            elif columns:
                program.row(list(columns.values()), [1.0] * len(columns), "<", 1.0)  # (11.1)
        limited = self.splits is not None and not kind.begun
        parts = {}
        for station in range(len(self.reduced.capacities)):
            there = [columns[station] for columns in by_line if station in columns]
            if there and (limited or station in self.reduced.period.counting_orders):
                parts[station] = self._part(order, station, there)
        if not limited or not parts:
            return []
        split = program.column()  # y_o^l
        program.row([*parts.values(), split], [1.0] * len(parts) + [1.0 - len(parts)], "<", 1.0)  # (3.2), (16)
        if not among:
            for part in parts.values():
                if self._incomplete(kind):
                    program.row([part, split], [1.0, -1.0], "<", 0.0)
                for columns in by_line:
                    there = list(columns.values())
                    program.row([part, split, *there], [1.0, -1.0] + [-1.0] * len(there), "<", 0.0)
        return [split]

    def _line(self, order: int, line: tuple[int, int]) -> dict[int, int]:
        """Add y_ios; return the columns by station."""
        sku, quantity = line
        columns = {}
        for station, room in enumerate(self.reduced.period.rooms):
            if quantity <= room and self._obtainable(station, [line]):
                column = self.model.lines[order, station, sku] = self.model.program.column()
                if station not in self.reduced.period.counting_orders:
                    self._take(station, column, quantity)
                self._gain(column, quantity, order)
                self._need(station, sku, column, 1, quantity)
                columns[station] = column
        return columns

    def _part(self, order: int, station: int, lines: Sequence[int]) -> int:
        """Add y_os of an order some of whose lines can be at a station."""
        part = self.model.program.column()
        for column in lines:
            self.model.program.row([column, part], [1.0, -1.0], "<", 0.0)  # (2.1)
        self.model.program.row([*lines, part], [1.0] * len(lines) + [-1.0], ">", 0.0)  # (13)
        if station in self.reduced.period.counting_orders:
            self._take(station, part, self.reduced.period.slots(order, station, 0))
        return part


def by_slots(proof: Proof) -> None:
    """Bound by the slots that cannot be filled without a visit; fill them with what is there, then pod by pod."""
    proof.bound = max(proof.bound, _least(proof.reduced, proof.weight))
    whole = Reduced(proof.reduced.period, Model.INTEGRATED)  # what it assigns keeps any limit on split orders
    for reduced in (proof.reduced, whole)[: 1 if proof.splits is None else 2]:
        filling = _Filling(reduced)
        filling.fill()
        proof.offer((), filling.parts, "bounds")
        if not proof.proven:
            filling.send(proof.weight)
            proof.offer(tuple(filling.visits), filling.parts, "bounds")


def _least(reduced: Reduced, weight: float) -> float:
    """Return a bound of objective (1)."""
    period, kept = reduced.period, reduced.candidates
    order, sku, n = period.line_order[kept], period.line_sku[kept], len(period.orders)
    lines = np.bincount(order, minlength=n)
    free, visits, most = 0, 0, 0
    for station, (room, factor) in enumerate(zip(period.capacities, period.factors, strict=True)):
        if station not in period.counting_orders:
            most += room
            continue
        takes = np.array([(o, station) not in period.joined for o in range(n)], dtype=np.bool_)
        there = np.bincount(order, weights=period.covered[station][sku], minlength=n)
        served = (there == lines) if reduced.model is Model.INTEGRATED else (there > 0)
        filled = min(room, int((takes & (lines > 0)).sum()))
        free += factor * (room - filled)
        visits += filled > int((takes & served & (lines > 0)).sum()) and weight * factor >= 1
        most += filled
    least = period.visits_before + weight * free + visits
    parts = int((lines > 0).sum()) if reduced.model is Model.INTEGRATED else int(lines.sum())
    if len(period.counting_orders) == len(period.capacities) and parts < most:
        least = max(least, period.visits_before + weight * period.factors[0] * (sum(period.capacities) - parts))
    return float(least)


class _Filling:
    """Slots that are filled greedily, the oldest orders first.

    Parameters
    ----------
    reduced
        The period.
    """

    def __init__(self, reduced: Reduced) -> None:
        self.reduced = reduced
        self.visits: list[tuple[int, int]] = []
        self._shelf = Shelf(reduced) if len(reduced.scarce) else None
        self._covered = reduced.period.covered.copy()
        self._free = list(reduced.capacities)
        self._skus: dict[tuple[int, int], list[int]] = {}
        period = reduced.period
        kept = reduced.candidates
        self._order, self._sku, self._quantity = (
            column[kept] for column in (period.line_order, period.line_sku, period.line_quantity)
        )
        self._open = np.ones(len(self._order), dtype=np.bool_)

    @property
    def parts(self) -> tuple[Part, ...]:
        """Assignments so far."""
        return tuple(Part(order, station, tuple(skus)) for (order, station), skus in self._skus.items())

    def fill(self) -> None:
        """Assign what is at the stations."""
        for station in range(len(self._free)):
            self._fill(station)
        if self.reduced.model is Model.SPLIT_AMONG_STATIONS:
            for order in np.unique(self._order[self._open]).tolist():
                if not any(self._free):
                    return
                self._split(order)

    def send(self, weight: float) -> None:
        """Send pods, as long as what they let in is worth more."""
        period = self.reduced.period
        for station, factor in enumerate(period.factors):
            while self._free[station]:
                orders, pods = self._pods(station)
                if not pods or len(pods) > weight * factor * orders:
                    break
                for pod in pods:
                    self.visits.append((pod, station))
                    self._covered[station] |= period.stock.holds[pod] > 0
                    if self._shelf is not None:
                        self._shelf.bring(pod, station)
                before = len(self._skus)
                self._fill(station)
                if len(self._skus) == before:
                    break

    def _there(self, station: int, lines: NDArray[np.int64] | slice = slice(None)) -> NDArray[np.bool_]:
        """Return which lines the pods at a station can serve, each for itself."""
        there: NDArray[np.bool_] = self._covered[station][self._sku[lines]]
        if self._shelf is not None:
            there = self._shelf.supply[station][self._sku[lines]] >= self._quantity[lines]
        return there

    def _fitting(self, station: int) -> NDArray[np.bool_]:
        """Return the open lines that may take a slot at a station: with their whole order or, over time, alone."""
        period, n = self.reduced.period, len(self.reduced.period.orders)
        open_lines = self._open.copy()
        if station in period.counting_orders:
            taken = [order for order, at in (*period.joined, *self._skus) if at == station]
            open_lines &= ~np.isin(self._order, np.array(taken, dtype=np.int64))
            return open_lines
        items = self._quantity
        if self.reduced.model is not Model.SPLIT_OVER_TIME:
            items = np.bincount(self._order, weights=self._quantity, minlength=n)[self._order].astype(np.int64)
        return open_lines & (items <= self._free[station])

    def _fill(self, station: int) -> None:
        """Fill a station with orders, or over time with lines, that its pods serve."""
        over_time, n = self.reduced.model is Model.SPLIT_OVER_TIME, len(self.reduced.period.orders)
        while self._free[station]:
            fitting = self._fitting(station)
            served = fitting & self._there(station)
            some = np.bincount(self._order[served], minlength=n)
            able = some > 0
            if not over_time:
                able &= some == np.bincount(self._order[fitting], minlength=n)
            if not able.any():
                return
            order = int(able.argmax())
            lines = np.flatnonzero(served & (self._order == order))
            if station not in self.reduced.period.counting_orders and over_time:
                lines = lines[:1]
            self._assign(order, station, lines)

    def _split(self, order: int) -> None:
        """Assign an order to several stations that have its lines and slots for its parts, if there are such."""
        lines = np.flatnonzero(self._open & (self._order == order))
        free, at = self._free[:], np.full(len(lines), -1)
        used: list[int] = []
        period = self.reduced.period
        for position, line in enumerate(lines):
            quantity = int(self._quantity[line])
            stations = [s for s in range(len(free)) if self._there(s, lines[position : position + 1])[0]]
            joining = [s for s in stations if s in used and s in period.counting_orders]
            having = [s for s in stations if free[s] >= period.slots(order, s, quantity)]
            if not joining and not having:
                return
            station = joining[0] if joining else max(having, key=lambda s: free[s])
            at[position] = station
            if not joining:
                free[station] -= period.slots(order, station, quantity)
                used.append(station)
        for station in np.unique(at).tolist():
            self._assign(order, station, lines[at == station])

    def _assign(self, order: int, station: int, lines: NDArray[np.int64]) -> None:
        given = list(zip(self._sku[lines].tolist(), self._quantity[lines].tolist(), strict=True))
        self._open[lines] = False
        self._free[station] -= self.reduced.period.slots(order, station, sum(quantity for _, quantity in given))
        self._skus.setdefault((order, station), []).extend(sku for sku, _ in given)
        if self._shelf is not None:
            self._shelf.take(station, given)

    def _pods(self, station: int) -> tuple[int, list[int]]:
        """Return pods to send, and how many orders they let in: the one that lets in most, or those of one order."""
        reduced, n = self.reduced, len(self.reduced.period.orders)
        fitting = self._fitting(station)
        lines = np.flatnonzero(fitting & ~self._there(station))
        if not len(lines):
            return 0, []
        sku, quantity, order = self._sku[lines], self._quantity[lines], self._order[lines]
        left = reduced.period.stock.holds[:, sku] if self._shelf is None else self._shelf.left[:, sku]
        brings = left > 0 if self._shelf is None else left >= quantity
        starts = np.flatnonzero(np.diff(order, prepend=-1))
        brought = np.add.reduceat(brings, starts, axis=1, dtype=np.int64)
        missing = np.bincount(order, minlength=n)[order[starts]]
        over_time = reduced.model is Model.SPLIT_OVER_TIME
        lets_in = (brought > 0 if over_time else brought == missing).sum(axis=1)
        lets_in = np.minimum(lets_in, self._free[station])
        preferred = reduced.period.preferred.pods
        pod = int(np.lexsort((-brings.sum(axis=1), -preferred, -lets_in))[0])
        if lets_in[pod]:
            return int(lets_in[pod]), [pod]
        return 1, self._pods_for(station, lines[order == order[starts[int(missing.argmin())]]])

    def _pods_for(self, station: int, lines: NDArray[np.int64]) -> list[int]:
        """Return pods that bring what a station lacks of some lines; none if there are too few."""
        sku, missing = self._sku[lines], self._quantity[lines].copy()
        if self._shelf is None:
            left = self.reduced.period.stock.holds[:, sku].astype(np.int64) * missing
        else:
            missing -= self._shelf.supply[station][sku]
            left = self._shelf.left[:, sku].copy()
            left[[pod for pod in range(len(left)) if self._shelf.brought(pod, station)]] = 0
        pods: list[int] = []
        while missing.any():
            brings = np.minimum(left, missing).sum(axis=1)
            pod = int(brings.argmax())
            if not brings[pod]:
                return []
            pods.append(pod)
            missing = np.maximum(missing - left[pod], 0).astype(np.int64)
            left[pod] = 0
        return pods


def with_joining_lines(period: Period, solution: Solution, model: Model) -> Solution:
    """Return a solution with the lines besides that take no further slot and no visit: one that costs the same.

    Over time, one line of an order takes the slot that all of it could have; where an order has a slot, or gets one,
    whatever else of it the pods at the station have goes there too.

    Parameters
    ----------
    period
        The period.
    solution
        A solution of it.
    model
        Of which model.
    """
    if model is not Model.SPLIT_OVER_TIME or not period.counting_orders:
        return solution
    new = tuple((pod, station) for pod, station in solution.visits if pod not in period.inbound[station])
    covered = period.covered_with(new)
    skus = {(part.order, part.station): list(part.skus) for part in solution.parts}
    assigned = {(part.order, sku) for part in solution.parts for sku in part.skus}
    for order, station in sorted({*skus, *period.joined}):
        if station not in period.counting_orders:
            continue
        for sku, _ in period.lines_of(order):
            if covered[station, sku] and (order, sku) not in assigned:
                there = [Part(o, s, (sku,)) for (o, s), given in skus.items() if sku in given]
                if short_of(period, solution.visits, (*there, Part(order, station, (sku,)))) is None:
                    assigned.add((order, sku))
                    skus.setdefault((order, station), []).append(sku)
    parts = tuple(Part(order, station, tuple(given)) for (order, station), given in skus.items())
    joined = evolve(solution, parts=parts)
    assert unused(period, parts) == unused(period, solution.parts)
    return joined
