"""Maximum flow from SKU demand to stations with free places, by its minimum cuts.

SKUs that the same set of stations covers are interchangeable, so demand is summed by that set, a bit mask: with S
stations there are 2^S masks and as many cuts, few enough to look at all of them (S = 4: sixteen). A cut A of the
stations bounds the flow by the places of A plus the demand that some station outside A covers.

A scarce SKU is a case for itself: each pod that has it counts with its free items and the stations where it is, and the
cut bounds what flows of the SKU by its demand and by the items of the pods that are at some station outside A.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from attrs import evolve, frozen
from numpy.typing import NDArray

from rmfs_mip.period.period import Preference, Stock
from rmfs_mip.period.reduction import Reduced, masks_of
from rmfs_mip.period.solution import Visits

MOST_STATIONS = 8
"""More stations with free places than this have too many cuts; the solver takes over."""

LARGE = 50_000
"""Pods times SKUs above which only what is there is looked at."""

Floats = NDArray[np.float64]


@lru_cache(maxsize=MOST_STATIONS + 1)
def _outside(stations: int) -> Floats:
    """Return a table of masks by cuts: 1 where a station of the mask lies outside the cut."""
    sets = np.arange(1 << stations)
    table: Floats = ((sets[:, None] & ~sets[None, :]) != 0).astype(np.float64)
    return table


@lru_cache(maxsize=256)
def _places(capacities: tuple[int, ...]) -> Floats:
    """Return the places of every cut."""
    sets = np.arange(1 << len(capacities))
    inside = (sets[:, None] >> np.arange(len(capacities))) & 1
    return inside.astype(np.float64) @ np.array(capacities, dtype=np.float64)


def _sums(of: NDArray[np.int64], numbers: Floats, length: int) -> Floats:
    return np.bincount(of, weights=numbers, minlength=length).astype(np.float64, copy=False)


@frozen(eq=False)
class Scarce:
    """The scarce SKUs of a network: their demand, and the free items of the pods.

    Parameters
    ----------
    demand
        Items wanted of each of them; here they have numbers of their own.
    pod, sku, number
        Free items f_ip.
    at
        Per pod the bit mask of the stations where it is.
    """

    demand: Floats
    pod: NDArray[np.int64]
    sku: NDArray[np.int64]
    number: Floats
    at: NDArray[np.int64]

    @classmethod
    def of(cls, reduced: Reduced, demand: Floats) -> Scarce | None:
        """Return them for a period and the demand of all SKUs, or None when nothing is scarce."""
        items, scarce = reduced.period.stock.items, reduced.scarce
        if items is None or not len(scarce):
            return None
        kept = reduced.is_scarce[items.sku]
        at = np.zeros(len(reduced.period.stock.pods), dtype=np.int64)
        for station, pods in enumerate(reduced.period.inbound):
            at[list(pods)] |= 1 << station
        sku = np.searchsorted(scarce, items.sku[kept])
        return cls(demand[scarce], items.pod[kept], sku, items.number[kept].astype(np.float64), at)

    def by_cut(self, stations: int) -> Floats:
        """Return for each SKU and cut the items on pods that are at some station outside: (SKUs, cuts)."""
        return self._summed(self.at[self.pod], stations) @ _outside(stations)

    def _summed(self, mask: NDArray[np.int64], stations: int) -> Floats:
        sets = 1 << stations
        sums = _sums(self.sku * sets + mask, self.number, len(self.demand) * sets)
        return sums.reshape(len(self.demand), sets)

    def flow(self, stations: int) -> Floats:
        """Return for each cut what flows of all these SKUs to stations outside, at most."""
        flow: Floats = np.minimum(self.by_cut(stations), self.demand[:, None]).sum(axis=0)
        return flow

    def with_one_more(self, station: int, stations: int) -> tuple[Floats, Floats]:
        """Return what `flow` gains by each pod at a station, (pods, cuts), and what it newly covers of the demand."""
        before, outside = self.by_cut(stations), _outside(stations)
        mask, demand, pods = self.at[self.pod], self.demand[self.sku, None], len(self.at)
        more = self.number[:, None] * (outside[mask | (1 << station)] - outside[mask])
        now = before[self.sku]
        gain = np.minimum(now + more, demand) - np.minimum(now, demand)
        gains = np.zeros((pods, gain.shape[1]))
        np.add.at(gains, self.pod, gain)
        new = np.where(mask >> station & 1, 0.0, np.minimum(self.number, np.maximum(demand - now[:, :1], 0.0)[:, 0]))
        return gains, _sums(self.pod, new, pods)

    def within(self, cut: int) -> tuple[float, Floats]:
        """Return what the pods in a set of stations cover, and what each other pod may bring besides."""
        inside = (self.at[self.pod] & cut) != 0
        there = _sums(self.sku, self.number * inside, len(self.demand))
        left = self.demand - np.minimum(there, self.demand)
        brought = np.where(inside, 0.0, np.minimum(self.number, left[self.sku]))
        brings = _sums(self.pod, brought, len(self.at))
        return float((self.demand - left).sum()), brings

    def adding(self, pod: int, station: int) -> Scarce:
        """Return them with one more visit."""
        at = self.at.copy()
        at[pod] |= 1 << station
        return evolve(self, at=at)


@frozen(eq=False)
class Network:
    """Demand for single items, and which stations cover it.

    Parameters
    ----------
    capacities
        Free places of each station.
    demand
        Items wanted per SKU that can be brought to a station, none of the scarce SKUs.
    stock
        Contents of the pods.
    mask
        Bit s set where station s covers the SKU.
    target
        Places that shall be filled; some pods can.
    scarce
        The scarce SKUs; None where there are none.
    """

    capacities: tuple[int, ...]
    demand: Floats
    stock: Stock
    mask: NDArray[np.int64]
    target: int
    scarce: Scarce | None = None

    @classmethod
    def of(cls, reduced: Reduced) -> Network:
        """Return demand and stations of a period."""
        scarce = Scarce.of(reduced, reduced.demand)
        return cls(
            reduced.reachable,
            reduced.demand if scarce is None else np.where(reduced.is_scarce, 0.0, reduced.demand),
            reduced.period.stock,
            masks_of(reduced.period.covered),
            min(reduced.reachable_sum, reduced.deliverable),
            scarce,
        )

    def with_demand_of(self, reduced: Reduced, lines: Sequence[int]) -> Network:
        """Return the network with the demand of some lines (positions) alone, and as many places to fill as it can."""
        assert self.scarce is not None
        period = reduced.period
        demand = _sums(period.line_sku[lines], period.line_quantity[lines].astype(np.float64), len(self.demand))
        scarce = evolve(self.scarce, demand=demand[reduced.scarce])
        target = min(self.target, int(np.minimum(demand, period.supply).sum()))
        return evolve(self, demand=np.where(reduced.is_scarce, 0.0, demand), target=target, scarce=scarce)

    def bins(self) -> Floats:
        """Return the demand by mask."""
        bins = np.bincount(self.mask, weights=self.demand, minlength=1 << len(self.capacities))
        return bins.astype(np.float64, copy=False)

    def flow(self) -> int:
        """Return how many places the covered demand fills."""
        stations = len(self.capacities)
        by_cut = _places(self.capacities) + self.bins() @ _outside(stations)
        if self.scarce is not None:
            by_cut = by_cut + self.scarce.flow(stations)
        return int(by_cut.min())

    def flows_with_one_more(self) -> tuple[Floats, Floats]:
        """Return the flow with each pod added to each station, and the demand it newly covers: (stations, pods)."""
        stations = len(self.capacities)
        sets = 1 << stations
        by_mask = np.zeros((len(self.mask), sets))
        by_mask[np.arange(len(self.mask)), self.mask] = self.demand
        carried = self._carried(by_mask)
        bins = by_mask.sum(axis=0)
        places, flows, gains = _places(self.capacities), [], []
        if self.scarce is not None:
            places = places + self.scarce.flow(stations)
        for station in range(stations):
            without = np.flatnonzero((np.arange(sets) >> station) & 1 == 0)
            moved = np.zeros_like(carried)
            moved[:, without] = -carried[:, without]
            moved[:, without | (1 << station)] += carried[:, without]
            by_cut, gain = places + (bins + moved) @ _outside(stations), carried[:, without].sum(axis=1)
            if self.scarce is not None:
                more, new = self.scarce.with_one_more(station, stations)
                by_cut, gain = by_cut + more, gain + new
            flows.append(by_cut.min(axis=1))
            gains.append(gain)
        return np.array(flows), np.array(gains)

    def _carried(self, by_mask: Floats) -> Floats:
        """Return the demand of each pod's SKUs by mask: (pods, masks)."""
        pod, sku = self.stock.entries
        pods, sets = len(self.stock.pods), by_mask.shape[1]
        if pods * len(by_mask) <= LARGE:
            return self.stock.holds @ by_mask
        carried = np.zeros((pods, sets))
        for mask in np.flatnonzero(by_mask.any(axis=0)).tolist():
            carried[:, mask] = np.bincount(pod, weights=by_mask[sku, mask], minlength=pods)
        return carried

    def adding(self, pod: int, station: int) -> Network:
        """Return the network with one more visit."""
        mask = self.mask.copy()
        mask[self.stock.skus_of(pod)] |= 1 << station
        scarce = None if self.scarce is None else self.scarce.adding(pod, station)
        return Network(self.capacities, self.demand, self.stock, mask, self.target, scarce)


def fewest_visits(network: Network) -> int:
    """Bound from below how many more visits it takes to fill ``target`` places.

    For a set A of stations: at least ``target`` less the places outside A have to be filled in A. What A covers now,
    and with each visit of a new pod at most the demand of its SKUs that A does not cover yet (all visits of the pod
    together) and no more than a station holds, has to reach that. Visits to disjoint sets add up. Of a scarce SKU a
    pod brings no more than its free items.
    """
    stations = len(network.capacities)
    every = (1 << stations) - 1
    total, target = sum(network.capacities), network.target
    least = [0] * (every + 1)
    for cut in range(1, every + 1):
        room = sum(c for s, c in enumerate(network.capacities) if cut >> s & 1)
        reached = (network.mask & cut) != 0
        short = target - (total - room) - network.demand[reached].sum()
        there, scarce = (0.0, None) if network.scarce is None else network.scarce.within(cut)
        short -= there
        bound = 0
        if short > 0:
            largest = max(c for s, c in enumerate(network.capacities) if cut >> s & 1)
            brings = network.stock.sums(np.where(reached, 0.0, network.demand))
            if scarce is not None:
                brings = brings + scarce
            gains = np.concatenate([np.clip(brings - n * largest, 0, largest) for n in range(cut.bit_count())])
            steps = np.cumsum(np.sort(gains)[::-1])
            bound = int(np.searchsorted(steps, short - 1e-9)) + 1
        part = (cut - 1) & cut
        while part:
            bound = max(bound, least[part] + least[cut ^ part])
            part = (part - 1) & cut
        least[cut] = bound
    return least[every]


def greedy_visits(network: Network, preference: Preference) -> tuple[Visits, Network]:
    """Add, one at a time, the visit that fills the most places until ``target`` are full.

    Ties: the pod that is preferred, most demand, first station and pod.

    Parameters
    ----------
    network
        The period before any new visit.
    preference
        Which pods are preferred.

    Returns
    -------
    visits, network
        The new visits, and the network with them.
    """
    visits: list[tuple[int, int]] = []
    flow, preferred = network.flow(), preference.pods.copy()
    while flow < network.target:
        flows, gains = network.flows_with_one_more()
        flows = np.minimum(flows, network.target)
        first = np.broadcast_to(preferred, flows.shape)
        best = np.lexsort((-gains.ravel(), -first.ravel(), -flows.ravel()))[0]
        station, pod = divmod(int(best), flows.shape[1])
        network = network.adding(pod, station)
        visits.append((pod, station))
        if preference.once_sent is not None:
            preferred[pod] = preference.once_sent
        flow = int(flows[station, pod])
    return tuple(visits), network
