"""Which pod serves what where pods may run out: maximum flows from SKUs over the pods that have them to the stations.

Whether the pods that are sent have enough is settled SKU by SKU (`short_of`); which lines can be placed besides, with
the slots of the stations between them, all at once (`rmfs_rules.mip.period.placing`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.solution import Part, Visits


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
