"""Scores of all pairs of order and station that are kept from call to call: what did not change is not read again."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rmfs_core.decisions import OrderAssignment
from rmfs_rules.helpers.calendars import Calendar
from rmfs_rules.helpers.pair_assigning import NO_LANES, Assigning, Ints, Prefer, Take
from rmfs_rules.helpers.pairs import OVERSIZE_WAIT_S, largest_capacity

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, WarehouseView

Rank = Callable[["Order"], float]


def _doubled(array: NDArray[Any], value: int) -> NDArray[Any]:
    """Return an array with twice the room along its last axis, filled with a value."""
    return np.concatenate([array, np.full_like(array, value)], axis=-1)


def by_due_time(order: Order) -> float:
    """Return when an order is due, in seconds; infinite without a due time."""
    return math.inf if order.due_s is None else order.due_s


class PairScores:
    """How many items of each order of the backlog are available at each station, as on the pods inbound to it.

    ``update`` takes in what a warehouse has become since the last call, in time that depends on what changed and not on
    the size of the backlog; ``assign`` then assigns the best pairs, as `assign_best_pairs` with such scores does.

    Parameters
    ----------
    rank
        Of orders with the same score the one goes first that this is lowest for, as it is when an order joins. Left
        out: the oldest.
    late_first
        Whether orders that are late already go before all others.
    tables
        2: there is a second table of what is available, and ties go first to the order with the largest share of its
        lines whose SKU that table has at the station.

    Attributes
    ----------
    available
        Items by station and SKU that the scores are made of, shape (stations, SKUs).
    """

    def __init__(self, rank: Rank | None = None, *, late_first: bool = False, tables: int = 1) -> None:
        self._log: object = None
        self._rank, self._late_first, self._tables = rank, late_first, tables
        self._now: Ints = np.zeros((tables, 0, 0), np.int64)

    @property
    def available(self) -> Ints:
        """Items by station and SKU that the scores are made of."""
        available: Ints = self._now[0]
        return available

    def load(self) -> None:
        """Load what is compiled, or compile it."""
        self._begin(1, 1, math.inf)
        self._take_in(np.array([[0], [0], [1]]), [], None)
        self._work.note(0, np.ones((1, 1), np.int64), self._now, self._changes, self._recent)
        self._work.lift(np.zeros(1, np.int64), self._orders, self._scores, self._changes, self._recent)
        self.completed(np.ones(1, np.int64))
        self._best(np.ones((5, 1), np.int64), np.zeros(1), np.zeros((2, 0), np.int64), 0)
        self._score(0, 0)
        self._first_drawn(self._draw(1), (0, 0), np.ones((5, 1), np.int64), np.zeros(1), np.zeros((2, 0), np.int64))
        self._log = None

    def decides(self, warehouse: WarehouseView, *available: Ints) -> bool:
        """Update, and say whether `assign` may decide: all orders are shown, and none was assigned in part."""
        if warehouse.filtered:
            return False
        self.update(warehouse, *available)
        return self.whole

    def update(self, warehouse: WarehouseView, *available: Ints) -> None:
        """Take in what joined and left the backlog, and what is available now; left out: what was, nothing at first."""
        log = warehouse.backlog_log()
        if log is not self._log:
            self._begin(len(warehouse.stations), warehouse.n_skus, largest_capacity(warehouse))
            self._log = log
        joined, left = log.joined(self._joined), log.left(self._left)
        if joined.size or left:
            self._take_in(joined, left, warehouse)
        for table, now in enumerate(available):
            self._work.note(table, now, self._now, self._changes, self._recent)
        if self._late_first and len(late := self._due.before(warehouse.now_s)):
            self._late += self._work.lift(late, self._orders, self._scores, self._changes, self._recent)

    def lines_of(self, place: int) -> Iterable[tuple[int, int]]:
        """Yield SKU and number of items of each line of the order at a place."""
        begin, end = self._starts[place : place + 2].tolist()
        yield from zip(*self._lines[1:3, begin:end].tolist(), strict=True)

    def order_at(self, place: int) -> int:
        """Return the id of the order at a place."""
        return int(self._ids[place])

    def place_of(self, order_id: int) -> int:
        """Return the place of an order; it is looked for."""
        return int(np.flatnonzero(self._ids[: self._number] == order_id)[-1])

    @property
    def whole(self) -> bool:
        """Whether no order of the backlog was assigned in part."""
        return not self._parts

    @property
    def oversize(self) -> tuple[int, ...]:
        """Places of the orders of the backlog that are larger than any station, oldest first."""
        return tuple(self._large)

    def change(self, station: int, sku: int, items: int) -> None:
        """Let a station have another number of items of a SKU available, until the next update."""
        self._now[0, station, sku] = items
        changes = int(self._changes[station])
        self._recent[station, changes % self._work.RECENT] = sku
        self._changes[station] = changes + 1

    def completed(self, items: Ints) -> Ints:
        """Return the places of the orders of which a pod has all that is open, if it has so many free items by SKU."""
        held = np.flatnonzero(items)
        places: Ints = self.completed_by(np.zeros_like(held), held, items[held])[1]
        return places

    def completed_by(self, pod: Ints, sku: Ints, items: Ints) -> Ints:
        """Return pairs of pod and place, shape (2, n), of the orders of which pods have all that is open.

        Entries say how many items of a SKU a pod has, sorted by pod, each SKU of a pod once.
        """
        from rmfs_rules.helpers import completing  # compiled, as above

        pairs: Ints = completing.completed_by(pod, sku, items, self._shelves, self._pool, self._orders, self._enough)
        return pairs

    def completed_at(self, station: int, pod: int, items: Ints) -> Ints:
        """Return what `completed` does, and perhaps orders that have left, for the pod that stands at a station.

        While it stands there and has as many items, only orders that joined are looked at.
        """
        known = self._lanes.get(station)
        if known is None or known[0] != pod or not np.array_equal(known[2], items):
            places = self.completed(items)
        elif known[1] < self._number:
            joined = range(known[1], self._number)
            more = [place for place in joined if all(items[sku] >= number for sku, number in self.lines_of(place))]
            places = np.concatenate([known[3], np.array(more, np.int64)])
        else:
            return known[3]
        self._lanes[station] = pod, self._number, items.copy(), places
        return places

    def assign(
        self,
        warehouse: WarehouseView,
        take: Take | None = None,
        prefer: Prefer | None = None,
        *,
        extra: NDArray[np.float64] | None = None,
        max_wait_s: float | None = None,
        fast_lane: int = 0,
        key: int = 0,
    ) -> list[OrderAssignment]:
        """Assign whole orders, again and again the pair with the highest score that fits.

        Parameters
        ----------
        warehouse
            The warehouse as it was at the last update.
        take
            Told of each assignment (station, place of the order) before the next one is chosen, unless nothing more can
            fit.
        prefer
            Which of the stations with an order's highest score takes it (order's id, station): the lowest. Left out, or
            with ties, as `assign_best_pairs` says.
        extra
            What a station adds to the scores of all orders, by station; ``take`` may change it.
        max_wait_s, fast_lane
            As `assign_best_pairs` has them.
        key
            Of orders with the same score the one with the lowest lot goes first, drawn with this number; 0: as ``rank``
            says.
        """
        return Assigning(self, warehouse, take, prefer, extra, max_wait_s, fast_lane, key).done()

    def queue_up(
        self, warehouse: WarehouseView, queued: Mapping[int, int], most: int, without: Sequence[int]
    ) -> Iterator[tuple[int, int]]:
        """Yield the best pairs of orders (places) and open stations (ids), each order once, until all queues are full.

        Orders fit that would fit the station if it were empty; of stations that are alike that with the shortest queue
        goes first.

        Parameters
        ----------
        warehouse
            The warehouse as it was at the last update.
        queued, most
            How many orders queue by station, and may queue at each.
        without
            Places of orders that are left out.
        """
        taken = list(without)
        of_stations = [(s.capacity, s.capacity, -1, s.counts_orders, queued.get(s.id, 0)) for s in warehouse.stations]
        at = np.array(of_stations, np.int64).T.copy()
        self._taken[taken] = True
        try:
            while True:
                at[0] = np.where(at[4] < most, at[1], 0) * [station.open for station in warehouse.stations]
                place, station = self._best(at, np.zeros(len(of_stations)), NO_LANES, 0)
                if place < 0:
                    return
                at[4, station] += 1
                self._taken[place] = True
                taken.append(place)
                yield place, station
        finally:
            self._taken[taken] = False

    # What is kept

    def _begin(self, stations: int, skus: int, largest: float) -> None:
        """Start anew with an empty backlog and nothing available."""
        from rmfs_rules.helpers import pair_search  # compiled: imported when needed, for it takes its time

        self._work: Any = pair_search
        self._joined = self._left = self._parts = self._first = self._number = self._used = 0
        self._arrived, self._end = 0, 1  # orders that draws know of, and the id after the highest of theirs
        self._largest = largest
        self._large: list[int] = []  # places of orders larger than any station, oldest first
        self._due = Calendar()  # of the places of orders, by when they will be late
        self._late = 0  # orders of the backlog that are late, and go first
        self._lanes: dict[int, tuple[int, int, Ints, Ints]] = {}  # by station: see `completed_at`
        sizes = pair_search.SIZES
        self._now = np.zeros((self._tables, stations, skus), np.int64)
        self._changes = np.zeros(stations, np.int64)  # how often what is available has changed
        self._recent = np.zeros((stations, pair_search.RECENT), np.int64)  # the last of these: what it was
        self._seen = np.zeros((stations, sizes), np.int64)  # the same, when the scores of a size were last made
        self._known = np.zeros((self._tables, stations, skus, sizes), np.int64)
        self._shelves = np.zeros((skus, sizes, 3), np.int32)
        self._most = np.zeros(skus, np.int64)  # items that a line of a SKU ever had
        self._lines = np.zeros((4, 256), np.int64)
        self._pool = np.zeros((256, 4), np.int32)
        self._orders = np.zeros((4, 256), np.int32)
        self._ids = np.zeros(256, np.int64)
        self._starts = np.zeros(257, np.int64)  # of each order's lines, and the end of all
        self._taken = np.zeros(256, np.bool_)
        self._enough = np.zeros(256, np.int32)
        self._ranks = np.zeros(256)
        blocks = sizes + 256 // pair_search.BLOCK  # of each size one may be begun
        self._scores = np.full((self._tables, stations + 1, blocks * pair_search.BLOCK), -1, np.int32)
        self._best_values = np.full((2, stations, blocks), -1.0)
        self._blocks: Any = pair_search.Blocks(
            np.full(blocks * pair_search.BLOCK, -1, np.int32),
            np.zeros(blocks, np.int64),
            np.zeros(blocks),
            np.zeros((sizes, blocks), np.int64),
            np.zeros((2, sizes), np.int64),
        )

    def _arrays(self) -> tuple[Any, ...]:
        lines = self._shelves, self._most, self._pool
        return *lines, self._orders, self._scores, self._ranks, self._best_values, self._known

    def _take_in(self, rows: Ints, left: list[int], warehouse: WarehouseView | None) -> None:
        """Take in lines that joined and left."""
        joined, before = rows.shape[1], self._number
        self._make_room(joined)
        if warehouse is not None and (self._rank is not None or self._late_first):
            orders = [warehouse.order(order) for order, _ in groupby(rows[0].tolist())]
            if self._rank is not None:
                self._ranks[before : before + len(orders)] = [self._rank(order) for order in orders]
            due = [(order.due_s, place) for place, order in enumerate(orders, before) if order.due_s is not None]
            if self._late_first:
                self._due.add(due)
        self._number, self._first, largest, parts, late, self._pool, self._used = self._work.update(
            rows, np.array(left, np.int64), self._joined, before, self._first, self._used,
            self._ids, self._starts, self._lines, self._blocks, *self._arrays(),
        )  # fmt: skip
        if largest > self._largest:
            sizes = enumerate(self._orders[1, before : self._number].tolist(), before)
            self._large += [place for place, items in sizes if items > self._largest]
        if self._large:
            self._large = [place for place in self._large if self._orders[0, place]]
        self._late -= late
        self._parts += parts
        self._joined += joined
        self._left += len(left)

    def _make_room(self, joined: int) -> None:
        """Let the arrays have room for so many more lines, each of an order of its own."""
        while self._joined + joined > self._lines.shape[1]:
            self._lines = _doubled(self._lines, 0)
        while self._number + joined > len(self._taken):
            for name in ("_orders", "_taken", "_enough", "_ranks", "_ids"):
                setattr(self, name, _doubled(getattr(self, name), 0))
            self._starts = np.concatenate([self._starts, np.zeros_like(self._starts[1:])])
            self._scores, self._best_values = _doubled(self._scores, -1), _doubled(self._best_values, -1)
            *by_block, counts = self._blocks
            self._blocks = self._work.Blocks(*[_doubled(array, -1) for array in by_block], counts)

    def _best(self, stations: Ints, extra: NDArray[np.float64], lanes: Ints, key: int) -> tuple[int, int]:
        late = self._work.LATE
        limits = min(self._largest, late), late if self._late else self._tables - 1
        found: tuple[int, int] = self._work.best_pair(
            stations, extra, limits, lanes, key, self._ids, self._taken, self._blocks, *self._arrays(),
            self._now, self._changes, self._seen, self._recent,
        )  # fmt: skip
        return found

    def _draw(self, key: int, warehouse: WarehouseView | None = None) -> Ints:
        """Draw orders that go before others which are alike, of all that arrived since the oldest; return their places.

        They are drawn by id, so it makes no difference when they joined; whatever is not here is drawn for nothing.
        """
        from rmfs_rules.helpers import drawing  # compiled, as above

        if warehouse is not None:
            come = warehouse.orders_since(self._arrived)
            self._arrived += len(come)
            self._end = max([self._end, *(order.id + 1 for order in come)])
        ids = self._ids[: self._number]
        drawn: Ints = drawing.draws(key, ids[self._first], self._end)
        places = ids.searchsorted(drawn)
        found: Ints = places[ids.take(places, mode="clip") == drawn]
        return found

    def _first_drawn(
        self, drawn: Ints, than: tuple[int, int], stations: Ints, extra: NDArray[np.float64], lanes: Ints
    ) -> tuple[int, int]:
        """Return the first drawn order that is as good as the best one, and its station; (-1, -1) if none is."""
        from rmfs_rules.helpers import drawing  # compiled, as above

        search: Any = drawing.first_drawn
        *arrays, _, best, known = self._arrays()
        found: tuple[int, int] = search(
            drawn, than, stations, extra, min(self._largest, self._work.LATE), lanes, self._taken, self._blocks,
            *arrays, best, known, self._now, self._changes, self._seen, self._recent,
        )  # fmt: skip
        return found

    def _score(self, place: int, at: int) -> int:
        """Return the score of the order at a place at a station."""
        shelves, most, pool, orders, scores, _, best, known = self._arrays()
        self._work.refresh(
            at, orders[2, place], self._blocks, shelves, most, pool, orders, scores, best, known,
            self._now, self._changes, self._seen, self._recent,
        )  # fmt: skip
        return int(scores[0, at, orders[3, place]])

    def _waiting(self, warehouse: WarehouseView, max_wait_s: float | None) -> Iterator[int]:
        """Yield the places of the orders that have waited too long, oldest first."""
        limit_s = OVERSIZE_WAIT_S if max_wait_s is None else max_wait_s
        for place in self.oversize if max_wait_s is None else range(self._first, self._number):
            if self._orders[0, place]:
                if warehouse.now_s - warehouse.order(self.order_at(place)).arrival_s < limit_s:
                    break
                yield place
