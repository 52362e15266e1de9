"""Choices of an order, its station and the pods that it needs there: POA and PPS in one."""

from __future__ import annotations

from typing import Any

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_commands.gym.choices import PLAIN, Choice, Pairs, Table, idle_share, pairs_in
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.roles import Role
from rmfs_core.warehouse import WarehouseView

Ints = NDArray[np.int64]


def of_orders_and_pods(warehouse: WarehouseView, table: Table = PLAIN) -> Choice | None:
    """Choose an order, its station, and the pods that are sent there for it; None where no order fits anywhere.

    Slots are the pairs of POA, each in ``table.pods_shown`` ways. Where the pods inbound to the station have all items
    of the order, there is one way: no pod is sent. Else each way begins with another pod: those that have most of the
    missing items, of equals most items that are wanted anywhere, then the lowest id. To the first one the pod is added
    that has most of what is still missing, by the same order, until nothing is.
    """
    pairs = pairs_in(warehouse, table.orders_shown)
    if pairs is None:
        return None
    search, options, kept = _Search(warehouse, pairs), {}, []
    stations = warehouse.stations
    for way in search.ways(table.pods_shown):
        row, station = int(pairs.row[way.pair]), stations[int(pairs.station[way.pair])]
        slot = (row * len(stations) + station.id) * table.pods_shown + way.rank
        options[slot] = pairs.orders[row], station, tuple(warehouse.pods[pod] for pod in way.pods)
        kept.append(way)
    if not options:
        return None
    values = [value[[way.pair for way in kept]] for value in pairs.values]
    return table.choice(Role.POA_PPS, warehouse, options, [*values, *search.values(kept), idle_share(warehouse)])


@frozen
class _Way:
    """Pods that are sent for a pair of order and station, by id, none where those inbound are enough."""

    pair: int
    rank: int
    pods: tuple[int, ...]


class _Search:
    """Items that orders lack at stations, and how many of them pods have.

    All is in columns: what a pair lacks in one line is an entry, those of a pair one after another.
    """

    def __init__(self, warehouse: WarehouseView, pairs: Pairs) -> None:
        self._warehouse, self._pairs = warehouse, pairs
        lines, stock = warehouse.backlog_lines, warehouse.stock
        have = warehouse.available()
        for station in warehouse.stations:  # what has no pod yet is served first
            for request in station.uncovered_requests:
                have[station.id, request.sku] -= request.items
        self._have, self._demand = have, np.bincount(lines.sku, lines.quantity, warehouse.n_skus).astype(np.int64)
        begin, end = (lines.order.searchsorted(pairs.at, side) for side in ("left", "right"))
        entry, pair = _ranges(begin, end), np.repeat(np.arange(len(begin)), end - begin)
        lacking = lines.quantity[entry] - have[pairs.station[pair], lines.sku[entry]]
        some = lacking > 0
        self._pair, self._lacking, sku = pair[some], lacking[some], lines.sku[entry][some]
        used, self._column = np.unique(sku, return_inverse=True)
        column = np.full(warehouse.n_skus, -1)
        column[used] = np.arange(len(used))
        self._free = np.zeros((len(used), len(warehouse.pods)), np.int64)  # free items of each SKU on each pod
        here = column[stock.sku] >= 0
        self._free[column[stock.sku[here]], stock.pod[here]] = stock.items[here]
        self._may = np.ones((len(warehouse.stations), len(warehouse.pods)), np.bool_)
        for pod in warehouse.pods:
            self._may[[at for at in pod.bound_for if at < len(self._may)], pod.id] = False
        wanted = np.bincount(stock.pod, np.minimum(stock.items, warehouse.open_demand()[stock.sku]), len(self._may[0]))
        self._tie = wanted / (wanted.max(initial=0.0) + 1)

    def ways(self, most: int) -> list[_Way]:
        """Return the ways to serve each pair, by pair, at most so many for each."""
        needy, begin, number = np.unique(self._pair, return_index=True, return_counts=True)
        enough = np.setdiff1d(np.arange(len(self._pairs.at)), needy)
        found = [_Way(pair, 0, ()) for pair in enough.tolist()]
        if not len(needy):
            return found
        scores = self._scores(needy, np.arange(len(self._pair)), self._lacking, begin)
        first = np.argsort(-scores, axis=1, kind="stable")[:, :most]
        which, rank = np.nonzero(np.take_along_axis(scores, first, axis=1) > 0)
        pod = first[which, rank]
        entry = _ranges(begin[which], begin[which] + number[which])  # of all ways, one way after another
        of_way, lacking = np.repeat(np.arange(len(which)), number[which]), self._lacking[entry]
        sent: list[list[int]] = [[one] for one in pod.tolist()]
        dead = np.zeros(len(which), np.bool_)
        under_way = np.arange(len(which))
        while len(under_way):
            chosen = np.full(len(which), -1)
            chosen[under_way] = pod
            lacking = lacking - np.minimum(lacking, self._free[self._column[entry], chosen[of_way]])
            left = lacking > 0
            entry, of_way, lacking = entry[left], of_way[left], lacking[left]
            under_way, begin = np.unique(of_way, return_index=True)
            if not len(under_way):
                break
            scores = self._scores(needy[which[under_way]], entry, lacking, begin)
            for i, way in enumerate(under_way.tolist()):
                scores[i, sent[way]] = 0
            pod = scores.argmax(axis=1)
            able = scores[np.arange(len(pod)), pod] > 0
            dead[under_way[~able]] = True
            keep = able[np.searchsorted(under_way, of_way)]
            entry, of_way, lacking, under_way, pod = (
                entry[keep],
                of_way[keep],
                lacking[keep],
                under_way[able],
                pod[able],
            )
            for way, one in zip(under_way.tolist(), pod.tolist(), strict=True):
                sent[way].append(one)
        known = set()
        for way in np.flatnonzero(~dead).tolist():
            pair, pods = int(needy[which[way]]), tuple(sent[way])
            if (key := (pair, frozenset(pods))) not in known:
                known.add(key)
                found.append(_Way(pair, int(rank[way]), pods))
        return sorted(found, key=lambda way: (way.pair, way.rank))

    def _scores(self, pairs: Ints, entry: Ints, lacking: Ints, begin: Ints) -> NDArray[np.float64]:
        """Return of each pair and pod how many items the pod has of what is lacking, ties less than 1; 0: no use.

        The entries of a pair are those from ``begin`` on to that of the next pair.
        """
        served = np.minimum(lacking[:, None], self._free[self._column[entry]])
        sums = np.add.reduceat(served, begin, axis=0)
        sums *= self._may[self._pairs.station[pairs]]
        return np.where(sums > 0, sums + self._tie, 0.0)

    def values(self, ways: list[_Way]) -> list[Any]:
        """Return the features of ways that POA does not have: pods, further, drive, used."""
        warehouse, stock = self._warehouse, self._warehouse.stock
        cells = np.array([pod.cell for pod in warehouse.pods])
        busy = np.array([pod.location is None or bool(pod.bound_for) for pod in warehouse.pods])
        further, ticks = [], []
        for station in warehouse.stations:
            wanted = np.maximum(self._demand - self._have[station.id], 0)
            further.append(np.bincount(stock.pod, np.minimum(stock.items, wanted[stock.sku]), len(busy)))
            ticks.append(warehouse.travel.times_to(station.cell, True)[cells].min(axis=1))
        of_way = np.repeat(np.arange(len(ways)), [len(way.pods) for way in ways])
        pods = np.array([pod for way in ways for pod in way.pods], np.int64)
        pair = np.array([way.pair for way in ways])
        at = self._pairs.station[pair[of_way]]
        own = np.bincount(self._pair, self._lacking, len(self._pairs.at))[pair]
        number, rest, used = (
            np.bincount(of_way, each, len(ways)) for each in (None, np.array(further)[at, pods], busy[pods])
        )
        farthest = np.zeros(len(ways))
        np.maximum.at(farthest, of_way, np.array(ticks)[at, pods] / TICKS_PER_S)
        return [number, np.maximum(rest - own, 0) * (number > 0), farthest, used / np.maximum(number, 1)]


def _ranges(begin: Ints, end: Ints) -> Ints:
    """Return the whole numbers of several ranges one after another."""
    number = end - begin
    numbers: Ints = np.arange(number.sum()) + np.repeat(begin - (np.cumsum(number) - number), number)
    return numbers
