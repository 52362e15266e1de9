"""Maximum flow from SKU demand to stations with free places, by its minimum cuts.

SKUs that the same set of stations covers are interchangeable, so demand is summed by that set, a bit mask: with S
stations there are 2^S masks and as many cuts, few enough to look at all of them (S = 4: sixteen). A cut A of the
stations bounds the flow by the places of A plus the demand that some station outside A covers.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_mip.period.period import Preference
from rmfs_mip.period.reduction import Reduced, masks_of
from rmfs_mip.period.solution import Visits

MOST_STATIONS = 8
"""More stations with free places than this have too many cuts; the solver takes over."""

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


@frozen(eq=False)
class Network:
    """Demand for single items, and which stations cover it.

    Parameters
    ----------
    capacities
        Free places of each station.
    demand
        Items wanted per SKU that can be brought to a station.
    holds
        Contents of the pods, shape (pods, SKUs).
    mask
        Bit s set where station s covers the SKU.
    target
        Places that shall be filled; some pods can.
    """

    capacities: tuple[int, ...]
    demand: Floats
    holds: Floats
    mask: NDArray[np.int64]
    target: int

    @classmethod
    def of(cls, reduced: Reduced) -> Network:
        """Return demand and stations of a period."""
        return cls(
            reduced.reachable,
            reduced.demand,
            reduced.period.stock.holds,
            masks_of(reduced.period.covered),
            min(reduced.reachable_sum, int(reduced.demand.sum())),
        )

    def bins(self) -> Floats:
        """Return the demand by mask."""
        bins = np.bincount(self.mask, weights=self.demand, minlength=1 << len(self.capacities))
        return bins.astype(np.float64, copy=False)

    def flow(self) -> int:
        """Return how many places the covered demand fills."""
        stations = len(self.capacities)
        return int((_places(self.capacities) + self.bins() @ _outside(stations)).min())

    def flows_with_one_more(self) -> tuple[Floats, Floats]:
        """Return the flow with each pod added to each station, and the demand it newly covers: (stations, pods)."""
        stations = len(self.capacities)
        sets = 1 << stations
        by_mask = np.zeros((len(self.mask), sets))
        by_mask[np.arange(len(self.mask)), self.mask] = self.demand
        carried = self.holds @ by_mask
        bins = by_mask.sum(axis=0)
        flows, gains = [], []
        for station in range(stations):
            without = np.flatnonzero((np.arange(sets) >> station) & 1 == 0)
            moved = np.zeros_like(carried)
            moved[:, without] = -carried[:, without]
            moved[:, without | (1 << station)] += carried[:, without]
            flows.append((_places(self.capacities) + (bins + moved) @ _outside(stations)).min(axis=1))
            gains.append(carried[:, without].sum(axis=1))
        return np.array(flows), np.array(gains)

    def adding(self, pod: int, station: int) -> Network:
        """Return the network with one more visit."""
        mask = np.where(self.holds[pod] > 0, self.mask | (1 << station), self.mask)
        return Network(self.capacities, self.demand, self.holds, mask, self.target)


def fewest_visits(network: Network) -> int:
    """Bound from below how many more visits it takes to fill ``target`` places.

    For a set A of stations: at least ``target`` less the places outside A have to be filled in A. What A covers now,
    and with each visit of a new pod at most the demand of its SKUs that A does not cover yet (all visits of the pod
    together) and no more than a station holds, has to reach that. Visits to disjoint sets add up.
    """
    stations = len(network.capacities)
    every = (1 << stations) - 1
    total, target = sum(network.capacities), network.target
    least = [0] * (every + 1)
    for cut in range(1, every + 1):
        room = sum(c for s, c in enumerate(network.capacities) if cut >> s & 1)
        reached = (network.mask & cut) != 0
        short = target - (total - room) - network.demand[reached].sum()
        bound = 0
        if short > 0:
            largest = max(c for s, c in enumerate(network.capacities) if cut >> s & 1)
            brings = network.holds @ np.where(reached, 0.0, network.demand)
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
