"""Random small periods, periods written by hand, and a brute force over all decisions."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, product
from typing import Any

import numpy as np
from attrs import evolve

from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.solution import Model


def holding(pods: Sequence[Sequence[int] | Mapping[int, int]], n_skus: int) -> Stock:
    """Return pods with unlimited items of some SKUs each, or with so many of each."""
    finite = any(isinstance(held, Mapping) for held in pods)
    entries = [(p, i, held[i] if finite else 1) for p, held in enumerate(pods) for i in sorted(held)]
    pod, sku, number = np.array([entry for entry in entries if entry[2]], np.int64).reshape(-1, 3).T
    return Stock(range(len(pods)), n_skus, pod, sku, number if finite else None)


def period_of(
    orders: Sequence[Sequence[int]],
    pods: Sequence[Sequence[int] | Mapping[int, int]],
    slots: Sequence[int] = (3,),
    there: Sequence[Sequence[int]] = (),
    n_skus: int = 9,
    **changes: Any,
) -> Period:
    """Return a period of lines of one item.

    From the SKUs of each order, those of each pod or its numbers of items, the free slots of each station and the pods
    there, and what else is so.
    """
    lines = [(order, sku, 1) for order, skus in enumerate(orders) for sku in skus]
    return Period(
        holding(pods, n_skus),
        tuple(range(len(slots))),
        tuple(slots),
        tuple(map(tuple, there))[: len(slots)] or ((),) * len(slots),
        tuple(range(len(orders))),
        *zip(*lines, strict=True),
        **{"busy": tuple(sorted({pod for at in there for pod in at}))} | changes,
    )


def random_period(seed: int) -> Period:
    """Return a small period: pods at stations, begun orders, stations with one slot, SKUs on no pod, quantities."""
    rng = np.random.default_rng(seed)
    n_skus, n_pods, n_orders, n_stations = (int(rng.integers(*span)) for span in ((3, 9), (2, 7), (1, 8), (1, 4)))
    contents = [tuple(sorted({int(i) for i in rng.integers(0, n_skus, rng.integers(1, 4))})) for _ in range(n_pods)]
    most_items = 3 if seed % 5 == 0 else 1
    lines = []
    for order in range(n_orders):
        skus = rng.choice(n_skus, size=min(int(rng.geometric(0.4)), n_skus), replace=False)
        lines += [(order, int(sku), int(rng.integers(1, most_items + 1))) for sku in sorted(skus)]
    capacity = (1, 3, 7)[seed % 3]
    inbound = [tuple(sorted(rng.choice(n_pods, rng.integers(0, 3), replace=False).tolist())) for _ in range(n_stations)]
    return Period(
        holding(contents, n_skus),
        tuple(range(n_stations)),
        tuple(int(c) for c in rng.integers(1, capacity + 1, n_stations)),
        tuple(inbound),
        tuple(range(n_orders)),
        *np.array(lines, dtype=np.int64).T,
        busy=tuple(sorted({pod for pods in inbound for pod in pods})),
        begun=tuple(bool(b) for b in rng.integers(0, 2, n_orders)) if seed % 2 else (),
        split_open=int(rng.integers(0, 3)),
    )


def splitting_period(seed: int, orders: int, stations: int, skus: int) -> Period:
    """Return orders of one to five lines that want splitting, with no pods at the stations (as at t = 1) or some."""
    rng = np.random.default_rng(seed)
    longest = min(5, skus // 2)
    lines = [sorted(rng.choice(skus, int(rng.integers(1, longest + 1)), replace=False).tolist()) for _ in range(orders)]
    contents = tuple(tuple(sorted(rng.choice(skus, 2 + seed % 2, replace=False).tolist())) for _ in range(8))
    inbound = tuple((int(pod),) if seed % 2 else () for pod in rng.integers(0, 8, stations))
    return period_of(
        lines,
        contents,
        (longest,) * stations if seed % 3 else (longest + 1, *[2] * (stations - 1)),
        inbound,
        skus,
        begun=tuple(bool(b) for b in rng.random(orders) < 0.3) if seed % 4 > 1 else (),
        split_open=seed % 3,
    )


def scarce_period(seed: int) -> Period:
    """Return a period that is small enough to try everything, whose pods run out, some of them at several stations."""
    rng = np.random.default_rng((9, seed))
    n_skus, n_pods, n_stations = (int(rng.integers(*span)) for span in ((2, 6), (2, 5), (1, 4)))
    most_lines = int(np.log(2000) / np.log(n_stations + 1))
    most_items, most_free = (3, 5) if seed % 4 == 0 else (1, 3)
    lines: list[tuple[int, int, int]] = []
    order = 0
    while len(lines) < most_lines:
        skus = rng.choice(n_skus, size=min(int(rng.geometric(0.5)), n_skus, most_lines - len(lines)), replace=False)
        lines += [(order, int(sku), int(rng.integers(1, most_items + 1))) for sku in sorted(skus)]
        order += 1
    held = [rng.choice(n_skus, size=min(int(rng.integers(1, 4)), n_skus), replace=False) for _ in range(n_pods)]
    items = [{int(sku): int(rng.integers(0, most_free)) for sku in skus} for skus in held]
    inbound = [tuple(sorted(rng.choice(n_pods, rng.integers(0, 3), replace=False).tolist())) for _ in range(n_stations)]
    return Period(
        holding(items, n_skus),
        tuple(range(n_stations)),
        tuple(int(c) for c in rng.integers(1, 6, n_stations)),
        tuple(inbound) if seed % 3 else ((),) * n_stations,
        tuple(range(order)),
        *np.array(lines, dtype=np.int64).T,
        busy=tuple(sorted({pod for pods in inbound for pod in pods})) if seed % 3 else (),
        begun=tuple(bool(b) for b in rng.integers(0, 2, order)) if seed % 2 else (),
        split_open=int(rng.integers(0, 3)),
    )


def putwall_period(seed: int) -> Period:
    """Return a small period, scarce stock or not, whose stations count orders, in every fifth only some of them do."""
    rng = np.random.default_rng((14, seed))
    period = scarce_period(seed)
    stations = range(len(period.stations))
    counting = frozenset(s for s in stations if seed % 5 or rng.random() < 0.5)
    begun = period.begun or (False,) * len(period.orders)
    at = [(o, s) for o, before in enumerate(begun) for s in sorted(counting) if before and rng.random() < 0.5]
    stock = period.stock
    return evolve(
        period,
        capacities=tuple(int(c) for c in rng.integers(1, 5, len(stations))),
        stock=stock if seed % 2 else evolve(stock, number=None),
        counting_orders=counting,
        joined=frozenset(at),
    )


def made_alike(period: Period) -> Period:
    """Return a period with all stations like its first: as at t = 1, though with pods there."""
    n = len(period.stations)
    return evolve(period, capacities=period.capacities[:1] * n, inbound=period.inbound[:1] * n)


def brute_force(period: Period, model: Model, weight: float, splits: int | None = None) -> float:
    """Return the least objective (1) over all assignments with so many new splits, each with its cheapest pods."""
    stations = range(len(period.stations))
    cheapest = [_cheapest(period, station) for station in stations]
    best = float("inf")
    for choice in product(*(list(choices(lines, len(stations), model)) for lines in period.lines)):
        items = [0] * len(stations)
        skus: list[set[int]] = [set() for _ in stations]
        for lines, where in zip(period.lines, choice, strict=True):
            for (sku, quantity), station in zip(lines, where, strict=True):
                if station is not None:
                    items[station] += quantity
                    skus[station].add(sku)
        few = splits is None or new_splits(period, choice) <= splits
        if few and all(items[s] <= period.capacities[s] for s in stations):
            pods = sum(cheapest[s](frozenset(skus[s])) for s in stations)
            best = min(best, period.visits_before + pods + weight * (sum(period.capacities) - sum(items)))
    return best


def brute_force_from_stock(period: Period, model: Model, weight: float, splits: int | None = None) -> float:
    """Return the least objective (1) over all assignments and all sets of visits whose pods have enough items.

    They have when no group of stations wants more of a SKU than the pods have that are at one of them.
    """
    stations, n_skus = range(len(period.stations)), period.stock.n_skus
    groups = range(1, 1 << len(stations))
    free = np.zeros((len(period.stock.pods), n_skus), dtype=np.int64)
    stock = period.stock
    free[stock.pod, stock.sku] = 99 if stock.number is None else stock.number
    largest = max(sum(quantity for _, quantity in lines) for lines in period.lines)
    worth = np.array([largest if s in period.counting_orders else 1 for s in stations])
    there = [sum(1 << s for s, pods in enumerate(period.inbound) if pod in pods) for pod in range(len(free))]
    by_number: dict[int, list[np.ndarray]] = {}
    for at in product(*([m for m in range(1 << len(stations)) if m & before == before] for before in there)):
        reach = np.array([[mask & group != 0 for mask in at] for group in groups], dtype=np.int64)
        number = sum(mask.bit_count() for mask in at) - sum(mask.bit_count() for mask in there)
        by_number.setdefault(number, []).append(reach @ free)
    brought = [np.array(by_number[number]) for number in sorted(by_number)]
    best = float("inf")
    for choice in product(*(list(choices(lines, len(stations), model)) for lines in period.lines)):
        wanted = np.zeros((len(stations), n_skus), dtype=np.int64)
        at: set[tuple[int, int]] = set()
        for order, (lines, where) in enumerate(zip(period.lines, choice, strict=True)):
            for (sku, quantity), station in zip(lines, where, strict=True):
                if station is not None:
                    wanted[station, sku] += quantity
                    at.add((order, station))
        if splits is not None and new_splits(period, choice) > splits:
            continue
        slots = wanted.sum(axis=1)
        for s in period.counting_orders:
            slots[s] = sum(station == s and (order, s) not in period.joined for order, station in at)
        if (slots > period.capacities).any():
            continue
        value = period.visits_before + weight * (worth * (period.capacities - slots)).sum()
        by_group = np.array([wanted[[s for s in stations if group >> s & 1]].sum(axis=0) for group in groups])
        for number, tables in enumerate(brought):
            if value + number >= best:
                break
            if (tables >= by_group).all(axis=(1, 2)).any():
                best = value + number
    return float(best)


def choices(lines, n_stations: int, model: Model) -> Iterator[tuple[int | None, ...]]:
    """Yield for each line of an order its station, None for the backlog."""
    if model is Model.INTEGRATED:
        yield from ((s,) * len(lines) for s in (None, *range(n_stations)))
    elif model is Model.SPLIT_AMONG_STATIONS:
        yield (None,) * len(lines)
        yield from product(range(n_stations), repeat=len(lines))
    else:
        yield from product((None, *range(n_stations)), repeat=len(lines))


def new_splits(period: Period, choice: tuple[tuple[int | None, ...], ...]) -> int:
    """Count the orders that are at several stations, or partly in the backlog, and were whole until now."""
    return sum(len(set(where)) > 1 and not (period.begun and period.begun[order]) for order, where in enumerate(choice))


def _cheapest(period: Period, station: int):
    """Return a function from SKUs to the fewest new pods that bring those that P_s does not have."""
    there = {sku for pod in period.inbound[station] for sku in period.stock.skus_of(pod).tolist()}
    known: dict[frozenset[int], float] = {}

    def fewest(skus: frozenset[int]) -> float:
        missing = skus - there
        if missing not in known:
            sets = [{*period.stock.skus_of(pod).tolist()} for pod in period.stock.pods]
            numbers = range(len(missing) + 1)
            enough = (n for n in numbers for chosen in combinations(sets, n) if missing <= set().union(*chosen))
            known[missing] = next(enough, float("inf"))
        return known[missing]

    return fewest
