"""Greedy assignment of whole orders: again and again the best pair of order and station."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from attrs import define, field, validators
from numpy.typing import NDArray

from rmfs_core.decisions import OrderAssignment
from rmfs_core.warehouse import columns_of

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import Order, Pod, Station, WarehouseView

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Take = Callable[["Pairs", "Station", int], None]
"""Told of each assignment (station, place of the order) before the next one is chosen, unless nothing more can fit."""
Prefer = Callable[[int, "Station"], int]
"""Of the stations with the highest score of an order (place) that takes it for which this is lowest."""

OVERSIZE_WAIT_S = 600.0
"""How long an order that is larger than any station waits for an empty one before one is emptied for it, by default."""
NO_PLACES, NO_RANKS, NO_FLAGS = np.zeros(0, np.int64), np.zeros(0), np.zeros(0, np.bool_)
NO_RANKS.setflags(write=False)
NOTHING = -1, 0.0
"""Place and score of a station's best order where none fits."""
SHUT = -1
"""Capacity of a station that is kept for an order: not even orders fit that take up none."""


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
        What a SKU counts at most at a station: an order scores the sum over its open lines of min(items, table[station,
        SKU]) there. Shape (stations, n_skus). Left out: all orders score the same. `change` changes it.
    shares
        Of orders with the same score the one goes first with the largest share of its open lines whose SKU has a 1 here
        at the station, not a 0; before ``rank``. Shape (stations, n_skus). Left out: none has any.
    score
        Instead of ``table``: scores of all orders at a station by place; below 0: never there.
    rank
        Of orders with the same score the one with the lowest goes first, by place. Left out: the oldest.
    first
        Orders that go before all others, whatever their scores, by place.
    extra
        What a station adds to the scores of all orders, by station; it may be changed in place.
    fast_lane
        Places that a station with something to do keeps for orders which the pod that is there can complete.

    Attributes
    ----------
    lines
        The open lines.
    taken
        Orders that are assigned in this decision, by place.
    """

    def __init__(
        self,
        warehouse: WarehouseView,
        table: Ints | None = None,
        *,
        shares: Ints | None = None,
        score: Callable[[Station], Floats] | None = None,
        rank: Floats | None = None,
        first: Flags | None = None,
        extra: Floats | None = None,
        fast_lane: int = 0,
    ) -> None:
        from rmfs_rules.helpers import pairs_search  # compiled: imported when needed, for it takes its time

        self._search: Any = pairs_search
        self.warehouse, self.lines, self.stations = warehouse, warehouse.lines, warehouse.stations
        orders = len(self.lines.order_id)
        self._table, self._shares = (
            np.zeros((len(self.stations), 0), np.int64) if counts is None else np.ascontiguousarray(counts, np.int64)
            for counts in (table, shares)
        )
        self._score, self._scores = score, dict[int, Floats]()
        self.taken = np.zeros(orders, np.bool_)
        self._extra = np.zeros(len(self.stations)) if extra is None else extra
        self._order = pairs_search.Order(
            self.taken, NO_FLAGS if first is None else first, NO_RANKS if rank is None else _shown(rank)
        )
        self._zeros = _scratch(orders)
        self._largest = largest_capacity(warehouse)
        self._free = [station.free_capacity for station in self.stations]
        self._load = [station.load for station in self.stations]
        self._placed = places_taken(warehouse)
        self._lane = _FastLane(warehouse, fast_lane) if fast_lane else None
        self._heads: dict[int, tuple[int, float]] = {}  # best order of each station, of those that were looked at
        self._chosen: list[OrderAssignment] = []

    def change(self, station: int, sku: int, items: int) -> None:
        """Let a SKU count another number of items at a station from now on."""
        self._table[station, sku] = items
        self.forget(station)

    def forget(self, station: int) -> None:
        """Look at the scores of a station anew, which have changed."""
        self._heads.pop(station, None)
        self._scores.pop(station, None)

    def add(self, station: int, sku: int, items: int) -> None:
        """Let a SKU count more items at a station from now on; nothing where no orders are picked."""
        if station < len(self._table):
            self.change(station, sku, self._table[station, sku] + items)

    def assign(
        self, take: Take | None = None, prefer: Prefer | None = None, max_wait_s: float | None = None
    ) -> list[OrderAssignment]:
        """Assign orders until nothing fits any more; return what was assigned, in this order.

        Orders that have waited too long go first, oldest first; each that fits nowhere keeps one station, that with
        most room of those that could take it, from taking anything else.

        Parameters
        ----------
        take, prefer
            See there.
        max_wait_s
            How long an order may wait. Left out: as long as it takes, but for an order that is larger than any station,
            which waits `OVERSIZE_WAIT_S`; of these one at a time keeps a station.
        """
        self._assign_waiting(take, prefer, max_wait_s)
        while (pair := self._best()) is not None:
            place, at = pair if prefer is None else (pair[0], self._preferred(pair[0], prefer))
            self._assign(place, at, take)
        return self._chosen

    def _best(self) -> tuple[int, int] | None:
        """Return the order (place) and the station that go next; None when nothing fits."""
        if stale := [at for at in range(len(self.stations)) if at not in self._heads]:
            self._look(stale)
        found = None
        for at, load in enumerate(self._load):
            place, score = self._heads[at]
            if place < 0:
                continue
            first = bool(len(self._order.first) and self._order.first[place])
            rank = self._order.rank[place] if len(self._order.rank) else 0.0
            key = not first, -(score + self._extra[at]), rank, place, load, at
            if found is None or key < found:
                found = key
        return None if found is None else (found[3], found[5])

    def _look(self, stale: list[int]) -> None:
        """Look for the orders that go first at some stations."""
        self._heads |= dict.fromkeys(stale, NOTHING)
        open_to = [at for at in stale if self._free[at] > 0 or (self._free[at] == 0 and at in self._placed)]
        if not open_to:
            return
        spaces = [self._space(at) for at in open_to]
        completed, ends = NO_PLACES, np.zeros(len(open_to), np.int64)
        if self._lane is not None:
            of_pods = [
                NO_PLACES if space.room == space.free else self._lane.completed(at)
                for at, space in zip(open_to, spaces, strict=True)
            ]
            completed, ends = np.concatenate(of_pods), np.cumsum([len(there) for there in of_pods])
        if self._score is not None:
            begin = 0
            for at, space, end in zip(open_to, spaces, ends.tolist(), strict=True):
                rest = self._order, space, self._placed.get(at, NO_FLAGS), completed[begin:end]
                self._heads[at] = self._search.best_by_score(self.lines, self._scored(at), *rest)
                begin = end
            return
        placed = np.zeros((len(open_to), len(self.taken) if self._placed else 0), np.bool_)
        for row, at in enumerate(open_to):
            if at in self._placed:
                placed[row] = self._placed[at]
        told = [(at, s.room, s.free, s.capacity, s.counts_orders) for at, s in zip(open_to, spaces, strict=True)]
        counts = self._search.Counts(self._table, self._shares)
        places, scores = self._search.best_by_skus(
            self.lines, counts, self._zeros, self._order, np.array(told, np.int64), self._largest,
            placed, completed, ends,
        )  # fmt: skip
        self._heads |= zip(open_to, zip(places.tolist(), scores.tolist(), strict=True), strict=True)

    def _scored(self, at: int) -> Floats:
        """Return the scores of all orders at a station where they are no sums over lines."""
        if at not in self._scores and self._score is not None:
            self._scores[at] = np.asarray(self._score(self.stations[at]), np.float64)
        return self._scores[at]

    def _space(self, at: int) -> Any:
        """Return what a station has space for."""
        station, free = self.stations[at], self._free[at]
        room = free if self._lane is None or not self._load[at] else min(free, max(free - self._lane.places, 0))
        return self._search.Space(room, free, station.capacity, self._largest, station.counts_orders)

    def _size(self, place: int, at: int) -> int:
        """Return the capacity that an order takes up at a station."""
        if self.stations[at].counts_orders:
            return int(at not in self._placed or not self._placed[at][place])
        items = int(self.lines.items[place])
        return self.stations[at].capacity if items > self._largest else items

    def _fitting(self, place: int) -> list[int]:
        """Return the stations where an order fits."""
        return [at for at in range(len(self.stations)) if self._fits(place, at)]

    def _fits(self, place: int, at: int) -> bool:
        size, space = self._size(place, at), self._space(at)
        return size <= space.room or (
            self._lane is not None and size <= space.free and place in self._lane.completed(at)
        )

    def _preferred(self, place: int, prefer: Prefer | None) -> int:
        """Return the station that takes an order, of those where it fits."""
        value = {at: self._score_of(place, at) + self._extra[at] for at in self._fitting(place)}

        def key(at: int) -> tuple[int, int, int]:
            return prefer(place, self.stations[at]) if prefer is not None else 0, self._load[at], at

        return min((at for at in value if value[at] == max(value.values())), key=key)

    def _score_of(self, place: int, at: int) -> float:
        """Return the score of an order at a station."""
        if self._score is not None:
            return float(self._scored(at)[place])
        most, shares, lines = self._table[at], self._shares[at], self.lines.of_order(place)
        score = float(sum(min(items, most[sku]) for sku, items in lines)) if len(most) else 0.0
        return score + 0.5 * (sum(shares[sku] for sku, _ in lines) / len(lines)) if len(shares) else score

    def _assign(self, place: int, at: int, take: Take | None) -> None:
        """Assign an order; scores of stations follow."""
        size = self._size(place, at)
        self._chosen.append(OrderAssignment(int(self.lines.order_id[place]), self.stations[at].id))
        self._free[at] -= size
        self._load[at] += size
        self.taken[place] = True
        self._heads = {other: head for other, head in self._heads.items() if other != at and head[0] != place}
        if self._lane is not None:
            for other in self._lane.take(at, self.lines.of_order(place)):
                self._heads.pop(other, None)
        if take is not None and (self._score is not None or self._placed or max(self._free) > 0):
            take(self, self.stations[at], place)

    def _assign_waiting(self, take: Take | None, prefer: Prefer | None, max_wait_s: float | None) -> None:
        """Assign the orders that have waited too long; for those that fit nowhere stations are kept."""
        kept: dict[int, bool] = {}  # stations kept for an order that waits, and whether that is larger than any station
        for place in self._waiting(max_wait_s):
            if self._fitting(place):
                self._assign(place, self._preferred(place, prefer), take)
            elif max_wait_s is not None or not any(kept.values()):
                order = self.warehouse.order(int(self.lines.order_id[place]))
                keep = station_to_keep(self.warehouse, order, dict(enumerate(self._free)), kept)
                if keep is not None:
                    kept[keep], self._free[keep] = bool(self.lines.items[place] > self._largest), SHUT
            if len(kept) == sum(station.open for station in self.stations):
                break

    def _waiting(self, max_wait_s: float | None) -> list[int]:
        """Return the places of the orders that have waited too long, oldest first."""
        lines, limit_s = self.lines, OVERSIZE_WAIT_S if max_wait_s is None else max_wait_s
        if max_wait_s is None and (
            self._largest == math.inf or not len(lines.items) or lines.items.max() <= self._largest
        ):
            return []
        there = lines.items > (self._largest if max_wait_s is None else 0)
        return [*np.flatnonzero(there & (self.warehouse.now_s - lines.arrival_s >= limit_s)).tolist()]


def waiting_limit() -> Any:
    """Return the parameter ``max_wait_s`` of a rule that assigns orders with `assign_best_pairs`."""
    return field(
        default=None,
        validator=validators.optional(validators.ge(0)),
        metadata={
            "doc": "Seconds in the backlog after which an order goes first; while it fits nowhere, the station with "
            "most room of those that could take it takes nothing else. Left out: never, but for orders larger than any "
            f"station, after {OVERSIZE_WAIT_S:g} s, one at a time"
        },
    )


def places_kept(default: int = 0) -> Any:
    """Return the parameter ``fast_lane`` of a rule that assigns orders with `assign_best_pairs`."""
    return field(
        default=default,
        validator=validators.ge(0),
        metadata={
            "doc": "Places that a station with something to do keeps for orders that the pod which is there can "
            "complete at once"
        },
    )


@define
class LaneOptions:
    """Parameters of a rule that assigns whole orders, whatever their order."""

    max_wait_s: float | None = waiting_limit()
    fast_lane: int = places_kept()

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load what is compiled, or compile it."""
        load()

    def assign_by(self, rank: Floats, warehouse: WarehouseView) -> list[OrderAssignment]:
        """Assign orders by rank alone, as `Pairs` says."""
        return Pairs(warehouse, rank=rank, fast_lane=self.fast_lane).assign(max_wait_s=self.max_wait_s)


@define
class PairOptions(LaneOptions):
    """Parameters of a rule that assigns pairs of order and station by a score."""

    tie_break: str = field(
        default="oldest",
        validator=validators.in_(("oldest", "due", "random")),
        metadata={"doc": "Which of the orders that are alike goes first: the oldest, the one due first, or one by lot"},
    )
    late_first: bool = field(
        default=False, metadata={"doc": "Whether orders that are late already go before all others"}
    )

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


class _FastLane:
    """Places that stations keep for what the pods that stand there can complete at once.

    Parameters
    ----------
    warehouse
        The warehouse now.
    places
        How many places each station keeps.
    """

    def __init__(self, warehouse: WarehouseView, places: int) -> None:
        self._warehouse, self.places = warehouse, places
        self._pods = {at: pod for at, station in enumerate(warehouse.stations) if (pod := pod_at(warehouse, station))}
        self._left = {pod.id: {sku: pod.free_items(sku) for sku in pod.contents} for pod in self._pods.values()}
        self._completed: dict[int, Ints] = {}

    def completed(self, at: int) -> Ints:
        """Return the places of the orders that the pod at a station can complete."""
        from rmfs_rules.helpers import pairs_search  # as above

        if at not in self._pods:
            return NO_PLACES
        if at not in self._completed:
            left = np.array([*self._left[self._pods[at].id].items()], np.int64).reshape(-1, 2).T.copy()
            self._completed[at] = pairs_search.completed_by(self._warehouse.lines, *left)
        return self._completed[at]

    def take(self, at: int, lines: Iterable[tuple[int, int]]) -> list[int]:
        """Let the pods at or bound for a station serve lines there; return the stations whose pods have less now."""
        if self._warehouse.unlimited_stock:
            return []
        changed = [other for other, pod in self._pods.items() if self._warehouse.stations[at].id in pod.bound_for]
        for other in changed:
            self._completed.pop(other, None)
            for sku, items in lines:
                left = self._left[self._pods[other].id]
                left[sku] = left.get(sku, 0) - items
        return changed


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
    if not warehouse.backlog_size:
        return []
    places = np.flatnonzero(warehouse.lines.open_lines)
    position = np.cumsum(warehouse.lines.open_lines > 0) - 1

    def by_place(values: NDArray[Any], kind: Any) -> NDArray[Any]:
        spread = np.zeros(len(position), kind)
        spread[places] = values
        return spread

    def take(pairs: Pairs, station: Station, place: int) -> None:
        for changed in assigned(station, int(position[place])) if assigned is not None else ():
            pairs.forget(changed)

    pairs = Pairs(
        warehouse,
        score=lambda station: by_place(score(station), np.float64),
        rank=None if rank is None else by_place(rank, np.float64),
        first=None if first is None else by_place(first, np.bool_),
        fast_lane=fast_lane,
    )
    told: Prefer | None = None if prefer is None else lambda place, at: prefer(int(position[place]), at)
    return pairs.assign(take, told, max_wait_s)


def load() -> None:
    """Load what is compiled, or compile it, by decisions without orders."""
    from rmfs_rules.helpers import pairs_search  # as above

    search: Any = pairs_search
    lines = columns_of((), 1)
    order, table = search.Order(NO_FLAGS, NO_FLAGS, NO_RANKS), np.zeros((1, 1), np.int64)
    spaces, placed, ends = np.zeros((1, 5), np.int64), np.zeros((1, 0), np.bool_), np.zeros(1, np.int64)
    search.best_by_skus(lines, search.Counts(table, table), np.zeros(0), order, spaces, 1.0, placed, NO_PLACES, ends)
    search.completed_by(lines, NO_PLACES, NO_PLACES)


def station_to_keep(
    warehouse: WarehouseView, order: Order, free: Mapping[int, int], kept: Container[int]
) -> int | None:
    """Return the station with most room of those that could take an order if they took nothing else."""
    room = {station.id: free.get(station.id, 0) for station in warehouse.stations}
    lacking = {
        station.id: warehouse.size_at(order, station) - room[station.id]
        for station in warehouse.stations
        if station.open and station.id not in kept
    }
    able = [i for i in lacking if lacking[i] <= warehouse.stations[i].capacity - room[i]]
    return min(able, key=lambda identifier: (lacking[identifier], identifier), default=None)


def largest_capacity(warehouse: WarehouseView) -> float:
    """Return the items that the largest station can take; without limit where one counts orders."""
    return max(
        (math.inf if station.counts_orders else station.capacity for station in warehouse.stations), default=math.inf
    )


def pod_at(warehouse: WarehouseView, station: Station) -> Pod | None:
    """Return the pod that stands at a station, not in its queue."""
    if not station.line or station.line[0].cell != station.cell or station.line[0].pod is None:
        return None
    return warehouse.pods[station.line[0].pod]


def places_taken(warehouse: WarehouseView) -> dict[int, Flags]:
    """Return which orders have a place at stations that count orders, by station and place; none: left out."""
    placed: dict[int, Flags] = {}
    if not warehouse.split_orders_open:
        return placed
    lines = warehouse.lines
    for place in lines.begun.tolist():
        order = warehouse.order(int(lines.order_id[place]))
        for station in warehouse.stations:
            if station.counts_orders and order.has_place_at(station.id):
                placed.setdefault(station.id, np.zeros(len(lines.items), np.bool_))[place] = True
    return placed


_zeros = [np.zeros(1024)]


def _scratch(length: int) -> Floats:
    """Return an array of zeros that all decisions share: compiled code fills it with zeros again when it is done."""
    if length > len(_zeros[0]):
        _zeros[0] = np.zeros(2 * length)
    return _zeros[0]


def _shown(array: NDArray[Any]) -> NDArray[Any]:
    """Return a view of an array, for looking only, so that compiled functions take one kind of it."""
    view = array[:]
    view.setflags(write=False)
    return view
