"""Which pod serves what where pods may run out: maximum flows from SKUs over the pods that have them to the stations.

Whether the pods that are sent have enough is settled SKU by SKU (`short_of`); which lines can be placed besides, with
the slots of the stations between them, all at once (`SlotsFromStock`).
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable, Sequence

from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.solution import Part, Visits

_Node = tuple[str, int, int]


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
    return next((sku for sku in sorted(wanted) if not _enough(wanted[sku], having[sku])), None)


def _enough(wanted: Counter[int], pods: Sequence[tuple[int, list[int]]]) -> bool:
    """Whether pods (free items, stations) can bring each station what it wants of a SKU, by augmenting paths."""
    total = sum(wanted.values())
    if all(any(s in at and number >= total for number, at in pods) for s in wanted):
        return True
    taken: list[Counter[int]] = [Counter() for _ in pods]

    def takes(station: int, seen: set[int]) -> bool:
        for pod, (number, at) in enumerate(pods):
            if pod in seen or station not in at:
                continue
            seen.add(pod)
            if taken[pod].total() < number:
                taken[pod][station] += 1
                return True
            for other in [s for s, n in taken[pod].items() if n and s != station]:
                if takes(other, seen):
                    taken[pod][other] -= 1
                    taken[pod][station] += 1
                    return True
        return False

    return all(takes(station, set()) for station, number in wanted.items() for _ in range(number))


class SlotsFromStock:
    """Free slots of stations, free items of pods, and which lines of one item were placed where, from which pod.

    Adding single items one by one, as long as there is a way, ends with as many as any choice, and among those with the
    first: which of them can be placed together is a gammoid.

    Parameters
    ----------
    period
        The period.
    visits
        New visits.
    """

    def __init__(self, period: Period, visits: Visits) -> None:
        self.free = list(period.capacities)
        self._at = stations_of(period, visits)
        self._left: dict[int, dict[int, int]] = {}  # SKU -> pod -> free items
        for pod in sorted(self._at):
            for sku, number in period.stock.items_on(pod).items():
                self._left.setdefault(sku, {})[pod] = number
        self._taken: list[dict[tuple[int, int], int]] = [{} for _ in self.free]  # station: (SKU, pod) -> items

    def add(self, sku: int) -> bool:
        """Find a slot and a pod for an item of a SKU, moving others where that helps; return whether there is one."""
        start: _Node = ("sku", sku, -1)
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
        """Return where flow can go on from a SKU, a SKU on a pod, or a station."""
        kind, number, pod = node
        if kind == "sku":
            return [("pod", number, other) for other, left in self._left.get(number, {}).items() if left > 0]
        if kind == "station":
            return [("pod", sku, other) for (sku, other), items in self._taken[number].items() if items]
        taken: list[_Node] = [("station", station, -1) for station in self._at[pod]]
        if any(self._taken[station].get((number, pod)) for station in self._at[pod]):
            taken.append(("sku", number, -1))
        return taken

    def _shift(self, before: _Node, node: _Node) -> None:
        """Let one item more flow between two nodes, or one less back."""
        if before[0] == "sku":
            self._left[node[1]][node[2]] -= 1
        elif node[0] == "sku":
            self._left[before[1]][before[2]] += 1
        elif node[0] == "station":
            taken, key = self._taken[node[1]], before[1:]
            taken[key] = taken.get(key, 0) + 1
        else:
            self._taken[before[1]][node[1:]] -= 1

    def add_all(self, skus: Sequence[int]) -> bool:
        """Find slots for all lines of an order, or change nothing; return whether there were."""
        free, left = self.free[:], {sku: dict(pods) for sku, pods in self._left.items()}
        taken = [dict(items) for items in self._taken]
        if all(self.add(sku) for sku in skus):
            return True
        self.free, self._left, self._taken = free, left, taken
        return False

    def take(self, sku: int, preferred: Sequence[int]) -> int:
        """Take a placed item of a SKU out and return its station.

        Parameters
        ----------
        sku
            The SKU.
        preferred
            Stations that go first, where items of the SKU are.

        Raises
        ------
        ValueError
            When no item of the SKU is left.
        """
        for station in (*preferred, *range(len(self.free))):
            for (held, pod), items in self._taken[station].items():
                if held == sku and items:
                    self._taken[station][held, pod] -= 1
                    return int(station)
        raise ValueError("no item of this SKU was placed")
