"""Greedy assignment of whole orders: again and again the best pair of order and station."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import define, validators
from numpy.typing import NDArray

from rmfs_core.decisions import OrderAssignment
from rmfs_core.warehouse import CAPACITY, UNLIMITED, Order, columns_of, shown
from rmfs_core.world import OrderData
from rmfs_rules.helpers import pairs_search as search
from rmfs_rules.helpers.late import OVERSIZE_WAIT_S, assign_late
from rmfs_rules.helpers.parameters import NOT_NEGATIVE, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Pod, Station, WarehouseView
    from rmfs_core.world.travel import Travel

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Take = Callable[["Pairs", "Station", int], None]
"""Told of each assignment (station, row of the order) before the next one is chosen, unless nothing more can fit."""
Prefer = Callable[[int, "Station"], int]
"""Of the stations with the highest score of an order (row) that takes it for which this is lowest."""

AT_ONCE = 64
"""Pairs that one compiled search assigns, where nobody is told of each."""


class Pairs:
    """One decision by the scores of pairs of order and station. It holds for one call, as the columns do.

    Of the pairs that fit, the one with the highest value goes next: score and ``extra``. Ties go to the order with the
    lowest ``rank``, to the oldest, to the station with the lowest load, to the lowest id. An order that is larger than
    any station fits an empty one.

    Parameters
    ----------
    warehouse
        The warehouse now.
    table
        Largest worth of a SKU at a station: an order scores the sum over its open lines of min(items, table[station,
        SKU]) there. Shape (stations, n_skus). Left out: all orders score the same. `change` changes it.
    scores
        Instead of ``table``: scores of all orders at each station, below 0: never there; shape (stations, orders), by
        row. Whoever changes it says so (`forget`).
    rank
        Of orders with the same score the one with the lowest goes first, by row. Left out: the oldest.
    first
        Orders that go before all others, whatever their scores, by row.
    extra
        Addition of each station to the scores of all orders, by station, float64; it may be changed in place.
    fast_lane
        Slots that a station with something to do keeps for orders which the pod that is there can complete.
    queues
        Instead of stations, their queues: free slots and length of each, by station. An order takes one slot.

    Attributes
    ----------
    lines
        The open lines.
    taken
        Orders that are assigned in this decision, by row.
    """

    def __init__(
        self,
        warehouse: WarehouseView,
        table: Ints | None = None,
        *,
        scores: Floats | None = None,
        rank: Floats | None = None,
        first: Flags | None = None,
        extra: Floats | None = None,
        fast_lane: int = 0,
        queues: tuple[list[int], list[int]] | None = None,
    ) -> None:
        self.warehouse, self.lines, self.stations = warehouse, warehouse.lines, warehouse.stations
        orders, number, self._queued = len(self.lines.items), len(self.stations), queues is not None
        nothing = np.zeros((number, 0), np.int64)
        self.taken = np.zeros(orders, np.bool_)
        self._scores = search.Scores(
            nothing if table is None else np.array(table, np.int64, order="C"),
            nothing.astype(np.float64) if scores is None else _own(scores),
            np.zeros(orders),
        )
        self._order = search.Precedence(
            self.taken,
            _NONE_FIRST if first is None else np.array(first, np.bool_),
            _NO_RANK if rank is None else shown(np.asarray(rank, np.float64)),
        )
        capacities, heads = warehouse.capacities.copy(), np.zeros(number, search.HEAD)
        if queues is not None:
            capacities["free"], capacities["load"] = queues
            capacities["counts_orders"] = 1
        self._free = capacities["free"]
        coming, (of_pod, skus, items) = _NOTHING, _NO_STOCK
        if fast_lane:
            stock = warehouse.stock
            of_pod, skus, items = stock.of_pod, stock.sku, stock.items.copy()
            pods = [pod_at(warehouse, station) for station in self.stations]
            heads["pod"] = [-1 if pod is None else pod.id for pod in pods]
            coming = np.array([[pod is not None and s.id in pod.bound_for for s in self.stations] for pod in pods])
        self._at = search.Stations(
            capacities,
            heads,
            warehouse.largest_capacity,
            np.zeros(number) if extra is None else _own(extra),
            nothing.astype(np.bool_) if self._queued else places_taken(warehouse),
            fast_lane,
            coming,
            of_pod,
            skus,
            items,
        )
        self._chosen: list[OrderAssignment] = []

    def change(self, station: int, sku: int, items: int) -> None:
        """Let a SKU count another number of items at a station from now on."""
        self._scores.table[station, sku] = items
        self.forget(station)

    def add(self, station: int, sku: int, items: int) -> None:
        """Let a SKU count more items at a station from now on; nothing where no orders are picked."""
        if station < len(self._scores.table):
            self.change(station, sku, self._scores.table[station, sku] + items)

    def forget(self, station: int) -> None:
        """Look at the scores of a station anew, which have changed."""
        self._at.heads["known"][station] = False

    def assign(
        self, take: Take | None = None, prefer: Prefer | None = None, max_wait_s: float | None = None
    ) -> list[OrderAssignment]:
        """Assign orders until nothing fits any more; return what was assigned, in this order.

        Orders that have waited too long go first, oldest first; each that fits nowhere keeps one station, that with
        most capacity of those that could take it, from taking anything else.

        Parameters
        ----------
        take, prefer
            See there.
        max_wait_s
            How long an order may wait. Left out: see `late`.
        """

        told = self.lines, self._scores, self._order, self._at
        plain = tuple(map(tuple, told))  # named tuples take compiled functions twice as long to read

        def assign(row: int) -> bool:
            at = self._preferred(row, prefer)
            if at >= 0:
                search.assign(self.lines, self._order, self._at, row, at)
                self._tell(row, at, take)
            return at >= 0

        if not self._queued:  # nobody is late for a queue
            assign_late(self.warehouse, max_wait_s, self._free, assign)
        most, found = 1 if take is not None else AT_ONCE, True
        while found and self._may_fit():
            if prefer is not None:
                row, _ = search.best_pair(*told)
                found = row >= 0 and assign(row)
                continue
            pairs = search.assign_best(plain, most).tolist()
            for row, at in pairs:
                self._tell(row, at, take)
            found = len(pairs) == most
        return self._chosen

    def _may_fit(self) -> bool:
        """Whether an order may fit anywhere: a station has a free slot, or an order a slot at one."""
        return bool(self._at.placed.shape[1] or max(self._free.tolist(), default=0) > 0)

    def _preferred(self, row: int, prefer: Prefer | None) -> int:
        """Return the station that takes an order, of those where it fits; -1: it fits nowhere."""
        values = search.values_of(self.lines, self._scores, row, self._at).tolist()
        best = [at for at, value in enumerate(values) if value == max(values) > -math.inf]

        def key(at: int) -> tuple[int, int, int]:
            return prefer(row, self.stations[at]) if prefer is not None else 0, int(self._at.capacities["load"][at]), at

        return min(best, key=key, default=-1)

    def _tell(self, row: int, at: int, take: Take | None) -> None:
        """Record the assignment of an order, and call ``take``."""
        self._chosen.append(OrderAssignment(int(self.lines.order_id[row]), self.stations[at].id))
        if take is not None and (self._scores.given.shape[1] or self._may_fit()):
            take(self, self.stations[at], row)


def waiting_limit() -> Any:
    """Return the parameter ``max_wait_s`` of a rule that assigns orders with `assign_best_pairs`."""
    return parameter(
        None,
        validators.optional(NOT_NEGATIVE),
        "Seconds in the backlog after which an order goes first; while it fits nowhere, the station with "
        "most capacity that could take it takes nothing else. Left out: never, except for orders larger than any "
        f"station, after {OVERSIZE_WAIT_S:g} s, the oldest first; one station at a time picks such orders",
    )


def places_kept(default: int = 0) -> Any:
    """Return the parameter ``fast_lane`` of a rule that assigns orders with `assign_best_pairs`."""
    return parameter(
        default,
        NOT_NEGATIVE,
        "Slots that a station with something to do keeps for orders that the pod which is there can complete at once",
    )


@define
class LaneOptions:
    """Parameters of a rule that assigns whole orders, whatever their order."""

    max_wait_s: float | None = waiting_limit()
    fast_lane: int = places_kept()

    def prepare(self, travel: Travel) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        load()

    def assign_by(self, rank: Floats, warehouse: WarehouseView) -> list[OrderAssignment]:
        """Assign orders by rank alone, as `Pairs` says."""
        return Pairs(warehouse, rank=rank, fast_lane=self.fast_lane).assign(max_wait_s=self.max_wait_s)


@define
class PairOptions(LaneOptions):
    """Parameters of a rule that assigns pairs of order and station by a score."""

    tie_break: str = parameter(
        "oldest",
        validators.in_(("oldest", "due", "random")),
        "Which of the orders that are alike goes first: the oldest, the one due first, or one by lot",
    )
    late_first: bool = parameter(False, None, "Whether orders that are late already go before all others")

    def assign(
        self,
        warehouse: WarehouseView,
        rng: np.random.Generator,
        table: Ints | None = None,
        take: Take | None = None,
        prefer: Prefer | None = None,
        *,
        extra: Floats | None = None,
    ) -> list[OrderAssignment]:
        """Assign the best pairs by what SKUs count at stations, as `Pairs` says."""
        lines = warehouse.lines
        rank = lines.due_s if self.tie_break == "due" else None
        if self.tie_break == "random":  # a lot for each order that is there, so that others make no difference
            there = lines.open_lines > 0
            rank = np.zeros(len(there))
            rank[there] = rng.random(np.count_nonzero(there))
        pairs = Pairs(
            warehouse,
            table,
            rank=rank,
            first=lines.due_s < warehouse.now_s if self.late_first else None,
            extra=extra,
            fast_lane=self.fast_lane,
        )
        return pairs.assign(take, prefer, self.max_wait_s)


def assign_best_pairs(
    warehouse: WarehouseView,
    score: Callable[[Station], NDArray[Any]],
    assigned: Callable[[Station, int], Iterable[int]] | None = None,
    *,
    max_wait_s: float | None = None,
    rank: NDArray[Any] | None = None,
    first: Flags | None = None,
    prefer: Callable[[int, Station], int] | None = None,
    fast_lane: int = 0,
) -> list[OrderAssignment]:
    """Assign whole orders greedily: again and again the pair of order and station with the highest score.

    As `Pairs` does, for scores that are no sums over lines; ``max_wait_s`` and ``fast_lane`` are explained there.
    Orders are told by their position in the backlog.

    Parameters
    ----------
    warehouse
        The warehouse now.
    score
        Scores of all orders of the backlog at a station, by position; below 0: never there.
    assigned
        Told of each assignment (station, position of the order in the backlog) before the next one is chosen; returns
        the ids of the stations whose scores it changes. Left out: scores stay.
    max_wait_s, fast_lane
        See `Pairs`.
    rank
        Which of two orders with the same score goes first, by position: the lower one. Left out: the older one.
    first
        Orders that go before all others, whatever their scores, by position.
    prefer
        Which of the stations with an order's highest score takes it (position of the order, station): the lowest, ties
        as `Pairs` says.

    Returns
    -------
    list[OrderAssignment]
        The assignments in the order in which they were chosen.
    """
    rows, stations = np.flatnonzero(warehouse.lines.open_lines), warehouse.stations
    position = np.cumsum(warehouse.lines.open_lines > 0) - 1
    scores = np.full((len(stations), len(position)), -1.0)

    def by_place(values: NDArray[Any] | None, kind: Any) -> Any:
        spread = np.zeros(len(position), kind)
        spread[rows] = 0 if values is None else values
        return None if values is None else spread

    def take(pairs: Pairs, station: Station, row: int) -> None:
        for changed in assigned(station, int(position[row])) if assigned is not None else ():
            scores[changed, rows] = score(stations[changed])
            pairs.forget(changed)

    if not len(rows):
        return []
    for station in stations:
        if station.free_capacity or warehouse.split_orders_open:  # a full one may take orders that have a slot there
            scores[station.id, rows] = score(station)
    pairs = Pairs(
        warehouse, scores=scores, rank=by_place(rank, np.float64), first=by_place(first, np.bool_), fast_lane=fast_lane
    )
    told: Prefer | None = None if prefer is None else lambda row, at: prefer(int(position[row]), at)
    return pairs.assign(take, told, max_wait_s)


def load() -> None:
    """Load what is compiled, or compile it, by a decision on one order without items at one station."""
    none = np.zeros((1, 0), np.int64)
    lines = columns_of([Order(0, OrderData("", arrival_tick=0, lines=()), int)], 1)
    scores = search.Scores(none, none.astype(np.float64), np.zeros(1))
    order = search.Precedence(np.zeros(1, np.bool_), np.zeros(0, np.bool_), _NO_RANK)
    rows = np.zeros(1, CAPACITY), np.zeros(1, search.HEAD)
    at = search.Stations(*rows, UNLIMITED, np.zeros(1), none.view(np.bool_), 0, _NOTHING, *_NO_STOCK)
    search.assign_best((tuple(lines), tuple(scores), tuple(order), tuple(at)), 1)
    search.best_pair(lines, scores, order, at)
    search.values_of(lines, scores, 0, at)
    search.assign(lines, order, at, 0, 0)


def _own(values: Floats) -> Floats:
    """Return an array that is changed in place as compiled functions take it; ValueError for another kind."""
    if values.dtype != np.float64 or not values.flags.writeable:
        found = f"found {values.dtype}, {'' if values.flags.writeable else 'not '}writeable"
        raise ValueError(f"{found}; expected float64, writeable")
    return values


def pod_at(warehouse: WarehouseView, station: Station) -> Pod | None:
    """Return the pod that stands at a station, not in its queue."""
    if not station.line or station.line[0].cell != station.cell or station.line[0].pod is None:
        return None
    return warehouse.pods[station.line[0].pod]


def places_taken(warehouse: WarehouseView) -> Flags:
    """Return which orders have a slot at stations that count orders, shape (stations, orders); (stations, 0): none."""
    lines, stations = warehouse.lines, warehouse.stations
    begun = lines.begun.tolist() if warehouse.split_orders_open else []
    if not begun:
        return np.zeros((len(stations), 0), np.bool_)
    placed = np.zeros((len(stations), len(lines.items)), np.bool_)
    for row in begun:
        order = warehouse.order(int(lines.order_id[row]))
        placed[:, row] = [station.counts_orders and order.has_place_at(station.id) for station in stations]
    return placed


_NOTHING, _NONE_FIRST = np.zeros((0, 0), np.bool_), np.zeros(0, np.bool_)
_NO_RANK = shown(np.zeros(0))  # compiled functions take one kind of array, and due times are for looking only
_NO_STOCK = shown(np.zeros(1, np.int64)), shown(np.zeros(0, np.int64)), np.zeros(0, np.int64)
