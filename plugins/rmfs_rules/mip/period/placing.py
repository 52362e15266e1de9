"""Placing lines of one item at stations one by one, moving earlier ones where that helps (augmenting paths).

Which lines can be placed at the same time is a gammoid: taking every line that still finds a slot and an item, oldest
first, ends with as many items as any choice, and among those with the oldest. Whether the pods that are sent have
enough for what is assigned is settled the same way, SKU by SKU (`short_of`).
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable, Mapping, Sequence

from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.solution import Part, Visits

ENDLESS = 1 << 40
"""More items than any period takes."""

_Node = tuple[str, int, int]


class Slots:
    """Free slots of stations, items of sources, and which lines were placed where, from which source.

    Lines of a kind are interchangeable. Each kind has some sources of its items, and each source is at some stations.

    Parameters
    ----------
    capacities
        Free slots of each station.
    items
        By kind the number of items at each of its sources.
    at
        The stations of each source.
    """

    def __init__(
        self, capacities: Sequence[int], items: dict[int, dict[int, int]], at: Mapping[int, Sequence[int]]
    ) -> None:
        self.free, self._left, self._at = list(capacities), items, at
        self._taken: list[dict[tuple[int, int], int]] = [{} for _ in self.free]  # station: (kind, source) -> items

    @classmethod
    def covered(cls, capacities: Sequence[int], masks: Iterable[int]) -> Slots:
        """Return slots for kinds that are the bit masks of the stations that cover them: each is its own source."""
        kinds, stations = {*masks}, range(len(capacities))
        at = {mask: [station for station in stations if mask >> station & 1] for mask in kinds}
        return cls(capacities, {mask: {mask: ENDLESS} for mask in kinds}, at)

    @classmethod
    def from_stock(cls, period: Period, visits: Visits) -> Slots:
        """Return the slots of a period with new visits; kinds are SKUs, and sources the pods that have them."""
        at, items = stations_of(period, visits), dict[int, dict[int, int]]()
        for pod in sorted(at):
            for sku, number in period.stock.items_on(pod).items():
                items.setdefault(sku, {})[pod] = number
        return cls(period.capacities, items, at)

    def add(self, kind: int) -> bool:
        """Find a slot and an item for a line of a kind, moving others where that helps; return whether there is one."""
        start: _Node = ("kind", kind, -1)
        came: dict[_Node, _Node] = {start: start}
        queue = deque([start])
        while queue:
            node = queue.popleft()
            if node[0] == "station" and self.free[node[1]] > 0:
                self.free[node[1]] -= 1
                while node != start:
                    self._shift(came[node], node)
                    node = came[node]
                return True
            for following in self._after(node):
                if following not in came:
                    came[following] = node
                    queue.append(following)
        return False

    def _after(self, node: _Node) -> Iterable[_Node]:
        """Return where flow can go on from a kind, a kind at a source, or a station."""
        what, number, source = node
        if what == "kind":
            return [("source", number, other) for other, left in self._left.get(number, {}).items() if left > 0]
        if what == "station":
            return [("source", kind, other) for (kind, other), items in self._taken[number].items() if items]
        taken: list[_Node] = [("station", station, -1) for station in self._at[source]]
        if any(self._taken[station].get((number, source)) for station in self._at[source]):
            taken.append(("kind", number, -1))
        return taken

    def _shift(self, before: _Node, node: _Node) -> None:
        """Let one item more flow between two nodes, or one less back."""
        if before[0] == "kind":
            self._left[node[1]][node[2]] -= 1
        elif node[0] == "kind":
            self._left[before[1]][before[2]] += 1
        elif node[0] == "station":
            taken, key = self._taken[node[1]], before[1:]
            taken[key] = taken.get(key, 0) + 1
        else:
            self._taken[before[1]][node[1:]] -= 1

    def add_all(self, kinds: Sequence[int]) -> bool:
        """Find slots for all lines of an order, by their kinds, or change nothing; return whether there were."""
        free, left = self.free[:], {kind: dict(sources) for kind, sources in self._left.items()}
        taken = [dict(items) for items in self._taken]
        if all(self.add(kind) for kind in kinds):
            return True
        self.free, self._left, self._taken = free, left, taken
        return False

    def take(self, kind: int, preferred: Sequence[int]) -> int:
        """Take a placed line of a kind out and return its station.

        Parameters
        ----------
        kind
            The kind.
        preferred
            Stations that go first, where lines of the kind stand there.

        Raises
        ------
        ValueError
            When no line of the kind is left.
        """
        for station in (*preferred, *range(len(self.free))):
            for (held, source), items in self._taken[station].items():
                if held == kind and items:
                    self._taken[station][held, source] -= 1
                    return int(station)
        raise ValueError("no line of this kind was placed")


def stations_of(period: Period, visits: Visits) -> dict[int, list[int]]:
    """Return the stations of each pod (positions) that is at some, with new visits counted in."""
    at: dict[int, list[int]] = {}
    for station, pods in enumerate(period.inbound):
        for pod in pods:
            at.setdefault(pod, []).append(station)
    for pod, station in visits:
        if station not in at.setdefault(pod, []):
            at[pod].append(station)
    return at


def short_of(period: Period, visits: Visits, parts: tuple[Part, ...]) -> int | None:
    """Return a SKU of which the pods have too few free items for what is assigned, or None.

    Parameters
    ----------
    period
        The period.
    visits
        (pod, station); those of P_s need not be named.
    parts
        Assigned lines.
    """
    if period.stock.number is None:
        return None
    wanted: dict[int, Counter[int]] = {}
    for part in parts:
        quantity = dict(period.lines_of(part.order))
        for sku in part.skus:
            wanted.setdefault(sku, Counter())[part.station] += quantity.get(sku, 0)
    having: dict[int, list[tuple[int, list[int]]]] = {sku: [] for sku in wanted}
    for pod, stations in sorted(stations_of(period, visits).items()):
        for sku, number in period.stock.items_on(pod).items():
            if sku in having:
                having[sku].append((number, stations))
    return next((sku for sku in sorted(wanted) if not _enough(wanted[sku], len(period.stations), having[sku])), None)


def _enough(wanted: Counter[int], stations: int, pods: Sequence[tuple[int, list[int]]]) -> bool:
    """Whether pods (free items, stations) can bring each of so many stations what it wants of a SKU."""
    total = sum(wanted.values())
    if all(any(s in at and number >= total for number, at in pods) for s in wanted):
        return True
    items, at = {pod: number for pod, (number, _) in enumerate(pods)}, {pod: at for pod, (_, at) in enumerate(pods)}
    slots = Slots([wanted[station] for station in range(stations)], {0: items}, at)
    return all(slots.add(0) for _ in range(total))
