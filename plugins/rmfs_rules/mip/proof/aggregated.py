"""The models in the aggregated form: same optimum as the printed one, far fewer columns and rows.

- x_cs: a class of new pods is sent to a station.
- y_Ts: how many orders of a type go to a station as a whole; n_T: how many are split.
- q_ks: how many lines of a kind (SKU and number of items) that split orders have go to a station.
- z_is: whether a SKU that P_s does not cover is brought to a station; where one class alone brings it, that is x_cs.
- f_ips: how many items of a scarce SKU a station takes from a pod (q_ips of the printed form); lines of such a kind are
  then counted in whole numbers, too.

Where stations count orders, parts of split orders are told apart, see `proof.parts`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from attrs import define, evolve, field
from numpy.typing import NDArray

from rmfs_rules.mip.period.decoding import Counts, parts_of
from rmfs_rules.mip.period.period import Line
from rmfs_rules.mip.period.reduction import OrderType, Reduced
from rmfs_rules.mip.period.solution import Model, Part, Visits, is_whole, unused
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.program import Program

PREFERENCE = 1e-3
"""Most that the least preferred pod costs more than the one preferred most."""
CLOSE = 1e-6
"""Objectives that differ by less are the same."""
MOST_PREFERENCE = 0.1
"""Most that all pods together cost more: with a whole W_u far less than any difference in (1)."""


@define
class Aggregated:
    """The program and where its variables are.

    Parameters
    ----------
    program
        Columns and rows.
    x
        (pod, station) to column; the pod stands for its class.
    y
        (type, station) to column.
    n
        Type to column.
    q
        (kind of line, station) to column.
    lines
        (order, station, SKU) to column, where lines are told apart.
    chosen
        (order, SKU) to column, where it matters which lines of split orders are taken.
    splits
        How many orders may newly be split; None for any number.
    """

    program: Program
    splits: int | None = None
    x: dict[tuple[int, int], int] = field(factory=dict)
    y: dict[tuple[int, int], int] = field(factory=dict)
    n: dict[int, int] = field(factory=dict)
    q: dict[tuple[Line, int], int] = field(factory=dict)
    lines: dict[tuple[int, int, int], int] = field(factory=dict)
    chosen: dict[tuple[int, int], int] = field(factory=dict)

    def counts(self, values: Sequence[float]) -> Counts:
        """Return what the values of the columns say."""
        chosen = frozenset(key for key, column in self.chosen.items() if values[column] > 0.5)
        return Counts(
            visits=tuple(sorted(key for key, column in self.x.items() if values[column] > 0.5)),
            whole={key: round(values[column]) for key, column in self.y.items()},
            split={kind: round(values[column]) for kind, column in self.n.items()},
            lines={key: round(values[column]) for key, column in self.q.items()},
            splits_limited=self.splits is not None,
            placed=tuple(key for key, column in self.lines.items() if values[column] > 0.5),
            chosen=chosen if self.chosen else None,
        )


@define
class Gains:
    """Terms of the second objective of a tie-break (to be maximised); see `proof.ties`.

    Parameters
    ----------
    pod
        Per visit of a new pod, by its position.
    order
        Per item of an order, by its position.
    lines
        Per line of an order, by the number of its lines that are still open then: the last one is worth ``lines(1)``.
    """

    pod: NDArray[np.float64] | None = None
    order: NDArray[np.float64] | None = None
    lines: Callable[[int], float] | None = None


class Builder:
    """Builds the aggregated form of a reduced period.

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
    sending
        Whether pods may be sent to stations where they are not.
    """

    def __init__(
        self,
        reduced: Reduced,
        weight: float,
        splits: int | None = None,
        gains: Gains | None = None,
        *,
        sending: bool = True,
    ) -> None:
        self.reduced = reduced
        self.weight = weight
        self.splits = splits if reduced.model is not Model.INTEGRATED else 0
        self.gains = gains
        self.sending = sending
        self.model = Aggregated(Program(), self.splits)
        self.objective: dict[int, float] = {}  # objective (1), without its constant
        stations = range(len(reduced.capacities))
        self._filling: list[dict[int, float]] = [{} for _ in stations]  # columns and items that take slots
        self._brought: list[dict[int, int]] = [{} for _ in stations]  # uncovered SKU -> column that makes it available
        self._using: list[dict[int, dict[int, float]]] = [{} for _ in stations]  # scarce SKU -> columns that take items
        self._most = unused(reduced.period, ())
        self._constant = reduced.period.visits_before + weight * self._most

    def build(self) -> Aggregated:
        """Return the model."""
        for station in range(len(self.reduced.capacities) if self.sending else 0):
            self._pods(station)
        self._orders()
        self._limits()
        if len(self.reduced.scarce):
            self._scarce_skus()
        program = self.model.program
        if self.gains is None:
            for column, cost in self.objective.items():
                program.cost[column] = cost
            if is_whole(self.weight):  # else (1) may differ by less than that
                extra = min(PREFERENCE, MOST_PREFERENCE / max(self._most, 1))
                for (pod, _), column in self.model.x.items():
                    program.cost[column] += extra * (1 - self.reduced.period.preferred.pods[pod])
            program.constant = self._constant
        return self.model

    def limit_objective(self, least: float, most: float) -> None:
        """Add rows that keep objective (1) from ``least`` to ``most``."""
        columns, costs = list(self.objective), list(self.objective.values())
        if least == most:
            self.model.program.row(columns, costs, "=", least - self._constant)
            return
        if least > float("-inf"):
            self.model.program.row(columns, costs, ">", least - self._constant)
        if most < float("inf"):
            self.model.program.row(columns, costs, "<", most - self._constant)

    # Columns

    def _pods(self, station: int) -> None:
        """x and z of a station."""
        reduced, program = self.reduced, self.model.program
        period = reduced.period
        wanted = reduced.wanted(station) & (~period.covered[station] | reduced.is_scarce)
        gains = None if self.gains is None else self.gains.pod
        value = period.preferred.pods if gains is None else gains + period.preferred.pods / 2
        bringing: dict[int, list[int]] = {}
        for pod in reduced.classes(wanted, value):
            if pod in period.inbound[station]:
                continue  # it would bring scarce SKUs only, and is there already
            column = self.model.x[pod, station] = program.column()
            self.objective[column] = 1.0
            if gains is not None:
                program.cost[column] = -float(gains[pod])
            for sku in period.stock.skus_of(pod).tolist():
                if wanted[sku]:
                    bringing.setdefault(sku, []).append(column)
        for sku, columns in sorted(bringing.items()):
            if period.covered[station, sku]:
                continue  # scarce, and so a matter of `_scarce_skus`
            if len(columns) == 1:
                self._brought[station][sku] = columns[0]
                continue
            z = self._brought[station][sku] = program.column(whole=False)
            program.row([*columns, z], [1.0] * len(columns) + [-1.0], ">", 0.0)  # (5)

    def _orders(self) -> None:
        """All columns that assign orders."""
        if self.splits is not None:
            self._whole_orders()
        if self.reduced.model is not Model.INTEGRATED and (
            self.splits != 0 or any(kind.begun for kind in self.reduced.types)
        ):
            self._split_orders()

    def _whole_orders(self) -> None:
        """y: orders (or what is left of them) that go to one station."""
        for number, kind in enumerate(self.reduced.types):
            if kind.begun and self.reduced.model is not Model.INTEGRATED:
                continue  # it is split already: its lines go where they like
            if self.reduced.model is Model.SPLIT_OVER_TIME and self._incomplete(kind):
                continue  # a line of it has to stay, so it would be split
            self._whole_type(number, kind)

    def _whole_type(self, number: int, kind: OrderType) -> None:
        for station, room in enumerate(self.reduced.capacities):
            slots = self.reduced.period.slots(kind.orders[0], station, kind.size)
            most = min(len(kind.orders), room // slots) if slots else len(kind.orders)
            if most < 1 or not self._obtainable(station, kind.lines):
                continue
            column = self.model.y[number, station] = self.model.program.column(upper=most)
            self._take(station, column, slots)
            self._gain(column, sum(quantity for _, quantity in kind.lines), kind.orders[0])
            if self.gains is not None and self.gains.lines is not None:
                self.model.program.cost[column] = -sum(self._worths(kind))
            for sku, quantity in kind.lines:
                self._need(station, sku, column, most, quantity)

    def _incomplete(self, kind: OrderType) -> bool:
        return len(kind.lines) < len(self.reduced.period.lines[kind.orders[0]])

    def _obtainable(self, station: int, lines: Sequence[Line]) -> bool:
        covered = self.reduced.period.covered[station]
        return all(covered[sku] or sku in self._brought[station] for sku, _ in lines)

    def _split_orders(self) -> None:
        """n and q."""
        free: dict[Line, int] = {}  # lines that are there without a decision
        chosen: dict[Line, list[int]] = {}  # columns that decide how many lines of a kind are assigned
        fresh: list[int] = []
        for number, kind in enumerate(self.reduced.types):
            column = None
            if not self._freely_split(kind):
                if not self._splittable(kind):
                    continue
                column = self._split_type(number, kind)
                if not kind.begun:
                    fresh.append(column)
            elif not self._ranked:
                for line in kind.lines:
                    free[line] = free.get(line, 0) + len(kind.orders)
                continue
            if self._ranked or column is None:
                by_line = [self._ranked_line(line, kind, column) for line in kind.lines]
                self._gain_of_lines(kind, by_line)
            else:
                by_line = [column] * len(kind.lines)
            for line, of_line in zip(kind.lines, by_line, strict=True):
                chosen.setdefault(line, []).append(of_line)
        for line in sorted({*free, *chosen}):
            self._flows(line, free.get(line, 0), chosen.get(line, []))
        if self.splits is not None and fresh:
            self.model.program.row(fresh, [1.0] * len(fresh), "<", self.splits)  # (18)

    @property
    def _ranked(self) -> bool:
        """Whether single lines are worth something: split over time, with a second objective about orders."""
        gains = self.gains
        about_orders = gains is not None and (gains.order is not None or gains.lines is not None)
        return self.reduced.model is Model.SPLIT_OVER_TIME and about_orders

    def _freely_split(self, kind: OrderType) -> bool:
        """Whether any of the lines may be assigned anywhere, or not."""
        return self.reduced.model is Model.SPLIT_OVER_TIME and (kind.begun or self.splits is None)

    def _splittable(self, kind: OrderType) -> bool:
        if self.splits is None or kind.begun:
            return True
        return self.splits > 0 and (len(kind.lines) > 1 or self._incomplete(kind))

    def _split_type(self, number: int, kind: OrderType) -> int:
        most = len(kind.orders)
        if self.reduced.model is Model.SPLIT_AMONG_STATIONS:
            most = min(most, sum(self.reduced.capacities) // kind.size)
        column = self.model.n[number] = self.model.program.column(upper=most)
        if self.reduced.model is Model.SPLIT_AMONG_STATIONS:
            self._gain(column, kind.size, kind.orders[0])
        return column

    def _ranked_line(self, line: Line, kind: OrderType, of_type: int | None = None) -> int:
        column = self.model.program.column()
        self._gain(column, line[1], kind.orders[0])
        if of_type is not None:
            self.model.program.row([column, of_type], [1.0, -1.0], "<", 0.0)
        return column

    def _flows(self, line: Line, free: int, chosen: list[int]) -> None:
        reduced, program = self.reduced, self.model.program
        sku, quantity = line
        supply = free + int(sum(program.upper[column] for column in chosen))
        columns = []
        for station, room in enumerate(reduced.capacities):
            most = min(supply, room // quantity)
            if most < 1 or not self._obtainable(station, [line]):
                continue
            whole = not reduced.period.single_items or len(reduced.scarce) > 0
            column = self.model.q[line, station] = program.column(upper=most, whole=whole)
            self._take(station, column, quantity)
            self._need(station, sku, column, most, quantity)
            columns.append(column)
        factors = [1.0] * len(columns) + [-1.0] * len(chosen)
        at_most = reduced.model is Model.SPLIT_OVER_TIME and not self._ranked
        if columns or chosen:
            program.row([*columns, *chosen], factors, "<" if at_most else "=", free)  # (11), (11.1)

    def _take(self, station: int, column: int, slots: int) -> None:
        self._filling[station][column] = float(slots)
        self.objective[column] = -self.weight * self.reduced.period.factors[station] * slots

    def _gain(self, column: int, items: int, order: int) -> None:
        if self.gains is not None and self.gains.order is not None:
            self.model.program.cost[column] = -float(self.gains.order[order]) * items

    def _worths(self, kind: OrderType) -> list[float]:
        """Return what the first line of an order that is taken is worth, the second one, and so on."""
        assert self.gains is not None and self.gains.lines is not None
        left = len(self.reduced.period.lines[kind.orders[0]])
        return [self.gains.lines(left - taken) for taken in range(len(kind.lines))]

    def _gain_of_lines(self, kind: OrderType, columns: Sequence[int]) -> None:
        """Count the lines of an order that are taken, one after the other: each may be worth more than the last."""
        if self.gains is None or self.gains.lines is None:
            return
        program = self.model.program
        for (sku, _), column in zip(kind.lines, columns, strict=True):
            self.model.chosen[kind.orders[0], sku] = column
        counting = [program.column(cost=-worth) for worth in self._worths(kind)]
        program.row([*columns, *counting], [1.0] * len(columns) + [-1.0] * len(counting), "=", 0.0)
        for before, after in pairwise(counting):
            program.row([after, before], [1.0, -1.0], "<", 0.0)

    def _need(self, station: int, sku: int, column: int, most: int, items: int) -> None:
        if self.reduced.is_scarce[sku]:
            self._using[station].setdefault(sku, {})[column] = float(items)
        available = self._brought[station].get(sku)
        if available is not None:
            self.model.program.row([column, available], [1.0, -float(most)], "<", 0.0)  # (5)

    def _scarce_skus(self) -> None:
        """Add what stations take of scarce SKUs from each pod, which is at most what it has."""
        program, period, stock = self.model.program, self.reduced.period, self.reduced.period.stock
        assert stock.number is not None
        taken: dict[tuple[int, int], list[int]] = {}  # by station and SKU
        kept = self.reduced.is_scarce[stock.sku]
        entries = zip(stock.pod[kept].tolist(), stock.sku[kept].tolist(), stock.number[kept].tolist(), strict=True)
        for pod, sku, number in entries:
            columns = []
            for station, room in enumerate(self.reduced.period.rooms):
                sent = self.model.x.get((pod, station))
                there = pod in period.inbound[station]
                if sku not in self._using[station] or (sent is None and not there):
                    continue
                column = program.column(upper=float(min(number, room)), whole=False)
                if not there and sent is not None:
                    program.row([column, sent], [1.0, -program.upper[column]], "<", 0.0)
                taken.setdefault((station, sku), []).append(column)
                columns.append(column)
            if sum(program.upper[column] for column in columns) > number:
                program.row(columns, [1.0] * len(columns), "<", number)
        for station, using in enumerate(self._using):
            for sku, columns_and_items in using.items():
                giving = taken.get((station, sku), [])
                factors = [*columns_and_items.values(), *([-1.0] * len(giving))]
                program.row([*columns_and_items, *giving], factors, "<", 0.0)

    def _limits(self) -> None:
        program = self.model.program
        for station, room in enumerate(self.reduced.capacities):
            taking = self._filling[station]
            if sum(program.upper[column] * items for column, items in taking.items()) > room:
                program.row(list(taking), list(taking.values()), "<", room)  # (4)
        for number, kind in enumerate(self.reduced.types):
            stations = range(len(self.reduced.capacities))
            columns = [self.model.y[number, s] for s in stations if (number, s) in self.model.y]
            if number in self.model.n:
                columns.append(self.model.n[number])
            if sum(program.upper[column] for column in columns) > len(kind.orders):
                program.row(columns, [1.0] * len(columns), "<", len(kind.orders))  # (3)


def assigned_with(
    reduced: Reduced, visits: Visits, weight: float, splits: int | None, limits: Limits, target: int
) -> tuple[bool, tuple[Part, ...] | None]:
    """Return whether it is known if some visits fill so many slots with the items that the pods have, and how.

    Parameters
    ----------
    reduced
        The period.
    visits
        New visits.
    weight
        W_u.
    splits
        How many orders may newly be split; None for any number.
    limits
        Solver and limits.
    target
        Slots to fill.
    """
    period = reduced.period
    inbound = [set(pods) for pods in period.inbound]
    for pod, station in visits:
        inbound[station].add(pod)
    stock = period.stock
    if stock.number is not None:
        there = np.array(sorted(set().union(*inbound)), dtype=np.int64)
        stock = stock.with_items(np.where(np.isin(stock.pod, there), stock.number, 0))
    sent = evolve(period, stock=stock, inbound=tuple(tuple(sorted(pods)) for pods in inbound))
    left = Reduced(sent, reduced.model)
    if not left.candidates.any():
        return True, () if target <= 0 else None
    builder = Builder(left, weight, splits, sending=False)
    model = builder.build()
    if not builder.objective:
        return True, () if target <= 0 else None
    most = sent.visits_before + weight * (sum(period.capacities) - target)
    builder.limit_objective(float("-inf"), most + CLOSE)
    outcome = model.program.solve(limits, absolute_gap=weight * sum(period.capacities))
    if outcome.values is None:
        return outcome.bound == float("inf"), None
    return True, parts_of(left, model.counts(outcome.values))
