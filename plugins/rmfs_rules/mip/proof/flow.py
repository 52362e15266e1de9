"""Maximum flow from SKU demand to stations with free slots, by its minimum cuts.

SKUs that the same set of stations covers are interchangeable, so demand is summed by that set, a bit mask: with S
stations there are 2^S masks and as many cuts, few enough to look at all of them (S = 4: sixteen). A cut A of the
stations bounds the flow by the slots of A plus the demand that some station outside A covers.

A scarce SKU is a case for itself: each pod that has it counts with its free items and the stations where it is, and the
cut bounds what flows of the SKU by its demand and by the items of the pods that are at some station outside A.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from attrs import evolve, frozen
from numpy.typing import NDArray

from rmfs_rules.mip.period.period import Preference, Stock
from rmfs_rules.mip.period.reduction import Reduced, masks_of
from rmfs_rules.mip.period.solution import Visits

MOST_STATIONS = 8
"""More stations with free slots than this have too many cuts; the solver takes over."""

Floats = NDArray[np.float64]


def _within(numbers: Floats, stations: int) -> Floats:
    """Return for each row and each set of stations the sum over the masks within the set: (rows, sets)."""
    sums = numbers.copy()
    for station in range(stations):
        halves = sums.reshape(-1, 2, 1 << station)
        halves[:, 1] += halves[:, 0]
    return sums.reshape(-1, 1 << stations)


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
        Free items f_ip of what is wanted, sorted by pod.
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
        stock, scarce = reduced.period.stock, reduced.scarce
        if stock.number is None or not len(scarce):
            return None
        kept = (reduced.is_scarce & (demand > 0))[stock.sku]
        at = np.zeros(len(stock.pods), dtype=np.int64)
        for station, pods in enumerate(reduced.period.inbound):
            at[list(pods)] |= 1 << station
        sku = np.searchsorted(scarce, stock.sku[kept])
        return cls(demand[scarce], stock.pod[kept], sku, stock.number[kept].astype(np.float64), at)

    def by_cut(self, stations: int) -> Floats:
        """Return for each SKU and cut the items on pods that are at some station outside: (SKUs, cuts)."""
        sets = 1 << stations
        sums = _sums(self.sku * sets + self.at[self.pod], self.number, len(self.demand) * sets)
        within = _within(sums, stations)
        outside: Floats = within[:, -1:] - within
        return outside

    def flow(self, stations: int) -> Floats:
        """Return for each cut what flows of all these SKUs to stations outside, at most."""
        flow: Floats = np.minimum(self.by_cut(stations), self.demand[:, None]).sum(axis=0)
        return flow

    def brought(self, cuts: NDArray[np.int64], stations: int) -> Floats:
        """Return what `flow` gains at some cuts by each pod at a station outside: (pods, cuts).

        A pod that is at a station outside already adds no SKU.
        """
        covered = self.by_cut(stations)[self.sku][:, cuts]
        brought = np.minimum(self.number[:, None], np.maximum(self.demand[self.sku, None] - covered, 0.0))
        brought[(self.at[self.pod, None] & ~cuts) != 0] = 0.0
        gains = np.zeros((len(self.at), len(cuts)))
        if len(self.pod):
            first = np.flatnonzero(np.diff(self.pod, prepend=-1))  # they are sorted by pod
            gains[self.pod[first]] = np.add.reduceat(brought, first)
        return gains

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
        Free slots of each station.
    demand
        Items wanted per SKU that can be brought to a station, none of the scarce SKUs.
    stock
        Contents of the pods.
    mask
        Bit s set where station s covers the SKU.
    target
        Slots that shall be filled; some pods can.
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
        """Return the network with the demand of some lines (positions) alone, and as many slots to fill as it can."""
        assert self.scarce is not None
        period = reduced.period
        demand = _sums(period.line_sku[lines], period.line_quantity[lines].astype(np.float64), len(self.demand))
        scarce = evolve(self.scarce, demand=demand[reduced.scarce])
        target = min(self.target, int(np.minimum(demand, period.supply).sum()))
        return evolve(self, demand=np.where(reduced.is_scarce, 0.0, demand), target=target, scarce=scarce)

    def by_cut(self) -> Floats:
        """Return for each set of stations its slots and the demand that some other station covers."""
        stations = len(self.capacities)
        numbers = -_sums(self.mask, self.demand, 1 << stations)
        covered = -numbers.sum()
        numbers[1 << np.arange(stations)] += self.capacities
        by_cut: Floats = covered + _within(numbers, stations)[0]
        return by_cut if self.scarce is None else by_cut + self.scarce.flow(stations)

    def flow(self) -> int:
        """Return how many slots the covered demand fills."""
        return int(self.by_cut().min())

    def brought(self, cuts: NDArray[np.int64]) -> Floats:
        """Return what each pod at a station outside adds to each of some cuts: (pods, cuts)."""
        stations, pods = len(self.capacities), len(self.stock.pods)
        kept = self.demand[self.stock.sku] > 0
        pod, sku = self.stock.pod[kept], self.stock.sku[kept]
        masks = np.flatnonzero(np.bincount(self.mask))
        kind = np.searchsorted(masks, self.mask[sku])
        carried = _sums(pod * len(masks) + kind, self.demand[sku], pods * len(masks)).reshape(pods, len(masks))
        more: Floats = carried @ (masks[:, None] & ~cuts == 0).astype(np.float64)
        return more if self.scarce is None else more + self.scarce.brought(cuts, stations)

    def flows_with_one_more(self) -> tuple[Floats, Floats]:
        """Return the flow up to the target with each pod added to each station, and the demand that is new there.

        Both have the shape (stations, pods). Only cuts below the target matter.
        """
        by_cut, sets = self.by_cut(), 1 << np.arange(len(self.capacities))
        cuts = np.flatnonzero(by_cut < self.target)
        more = self.brought(np.append(cuts, sets.sum() - sets))
        now, target = by_cut[cuts], float(self.target)
        after = more[:, : len(cuts)] + now
        flows = [
            np.minimum(after[:, outside].min(axis=1, initial=target), now[~outside].min(initial=target))
            for outside in cuts & sets[:, None] == 0
        ]
        return np.array(flows), more[:, len(cuts) :].T

    def adding(self, pod: int, station: int) -> Network:
        """Return the network with one more visit."""
        mask = self.mask.copy()
        mask[self.stock.skus_of(pod)] |= 1 << station
        scarce = None if self.scarce is None else self.scarce.adding(pod, station)
        return Network(self.capacities, self.demand, self.stock, mask, self.target, scarce)


def fewest_visits(network: Network) -> int:
    """Bound from below how many more visits it takes to fill ``target`` slots.

    For a set A of stations: at least ``target`` less the slots outside A have to be filled in A. What A covers now,
    and with each visit of a new pod at most the demand of its SKUs that A does not cover yet (all visits of the pod
    together) and no more than a station holds, has to reach that. Visits to disjoint sets add up. Of a scarce SKU a
    pod brings no more than its free items.
    """
    every = (1 << len(network.capacities)) - 1
    short = network.target - network.by_cut()
    lacking = np.flatnonzero(short > 0)
    least = [0] * (every + 1)
    for rest, brought in zip(lacking.tolist(), network.brought(lacking).T, strict=True):
        cut = every ^ rest
        largest = max(c for s, c in enumerate(network.capacities) if cut >> s & 1)
        brings = brought[brought > 0]
        gains = np.concatenate([np.clip(brings - n * largest, 0, largest) for n in range(cut.bit_count())])
        steps = np.cumsum(np.sort(gains)[::-1])
        least[cut] = int(np.searchsorted(steps, short[rest] - 1e-9)) + 1
    for cut in range(1, every + 1):
        bound = least[cut]
        part = (cut - 1) & cut
        while part:
            bound = max(bound, least[part] + least[cut ^ part])
            part = (part - 1) & cut
        least[cut] = bound
    return least[every]


def greedy_visits(network: Network, preference: Preference) -> tuple[Visits, Network]:
    """Add, one at a time, the visit that fills the most slots until ``target`` are full.

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
        first = np.broadcast_to(preferred, flows.shape)
        best = np.lexsort((-gains.ravel(), -first.ravel(), -flows.ravel()))[0]
        station, pod = divmod(int(best), flows.shape[1])
        network = network.adding(pod, station)
        visits.append((pod, station))
        if preference.once_sent is not None:
            preferred[pod] = preference.once_sent
        flow = int(flows[station, pod])
    return tuple(visits), network
