"""The few changes of the pods as they are that pay most: two SKUs exchanged, or two pods."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_commands.slotting.placing import DRAWS, MOVES, Placement, Placer, cells_of
from rmfs_commands.slotting.surrogate import Shelves
from rmfs_core.randomness import stream
from rmfs_core.world import Layout

TRIED = 2_000
"""Exchanges that are tried for each change."""


@frozen
class Change:
    """A change.

    Parameters
    ----------
    pod, other
        Names of the two pods.
    sku, other_sku
        Names of the SKUs that are exchanged; None: the pods exchange their storage locations.
    items
        Items that are carried.
    saved_s
        Seconds of driving that it saves a day, by the orders that it was chosen by.
    cost_s
        Seconds of driving and handling that it takes, once.
    """

    pod: str
    other: str
    sku: str | None
    other_sku: str | None
    items: int
    saved_s: float
    cost_s: float

    @property
    def pays_days(self) -> float:
        """After how many days it has paid for itself."""
        return self.cost_s / self.saved_s

    def __str__(self) -> str:
        what = f"pods {self.pod} and {self.other} exchange their storage locations"
        if self.sku is not None:
            what = f"{self.sku} of pod {self.pod} and {self.other_sku} of pod {self.other}"
        times = f"takes {self.cost_s:,.0f} s, saves {self.saved_s:,.0f} s a day by the history"
        return f"{what}: {times}, pays after {self.pays_days:,.1f} days"


@frozen(eq=False)
class Floor:
    """Where pods stand, and what ways take.

    Parameters
    ----------
    layout
        The layout.
    seconds
        To the stations from each of its storage locations.
    visit_s
        Of a visit, to a station and back, with lifting and setting down.
    handle_s
        Of an item that is handled.
    stays
        Whether a pod is always stored where it stood at first, so that this location matters.
    """

    layout: Layout
    seconds: NDArray[np.float64]
    visit_s: float
    handle_s: float
    stays: bool


def best_changes(placer: Placer, floor: Floor, number: int, seed: int) -> tuple[Placement, list[Change], list[int]]:
    """Return the pods after changes, each the one with the shortest time to pay; the changes; and the cells.

    Cells are those where pods stand afterwards; empty where that is anywhere.
    """
    past, now = placer.past, placer.now()
    shelves, pods = placer.stock.shelves(now.contents), past.instance.pods
    a_day = floor.visit_s * len(past.baskets) / past.days / placer.seen.orders
    cells = cells_of(pods, floor.layout)
    rng, found = stream(seed, "slotting moves"), list[Change]()
    for _ in range(number):
        exchange = _best_exchange(placer, shelves, rng.random((TRIED, DRAWS)), floor, a_day)
        move = _best_move(placer, shelves, cells, floor) if floor.stays and cells else None
        both = [one for one in (exchange, move) if one is not None]
        if not both:
            break
        change, places = min(both, key=lambda one: one[0].pays_days)
        found.append(change)
        if change.sku is not None:
            shelves.exchange(*places)
        else:
            one, other = places
            cells[one], cells[other] = cells[other], cells[one]
    return placer.judged(MOVES, placer.with_items(now.contents, shelves)), found, cells


def _best_exchange(
    placer: Placer, shelves: Shelves, draws: NDArray[np.float64], floor: Floor, a_day: float
) -> tuple[Change, list[int]] | None:
    """Return the exchange of two SKUs that pays soonest, with its pods and positions; None where none saves a visit."""
    instance, stock = placer.past.instance, placer.stock
    gains = shelves.gains(placer.seen, draws)
    gains = gains[gains[:, 0] > 0]
    if not len(gains):
        return None
    skus = shelves.held[gains[:, 1], gains[:, 2]], shelves.held[gains[:, 3], gains[:, 4]]
    loads = shelves.loads[gains[:, 1], gains[:, 2]], shelves.loads[gains[:, 3], gains[:, 4]]
    sizes = np.array(stock.sizes)
    items = loads[0] // sizes[skus[0]] + loads[1] // sizes[skus[1]]
    cost = 2 * floor.visit_s + floor.handle_s * items
    best = int(np.argmin(cost / gains[:, 0]))
    saved, pod, at, other, there = gains[best].tolist()
    sku, second = (instance.skus[int(of[best])] for of in skus)
    pods = instance.pods[pod].name, instance.pods[other].name
    change = Change(*pods, sku, second, int(items[best]), saved * a_day, float(cost[best]))
    return change, [pod, at, other, there]


def _best_move(placer: Placer, shelves: Shelves, cells: Sequence[int], floor: Floor) -> tuple[Change, list[int]] | None:
    """Return the two pods whose exchange saves most driving, which takes a visit's driving each; None where none."""
    near = dict(zip(floor.layout.storage_locations, floor.seconds.tolist(), strict=True))
    way = np.array([near[cell] for cell in cells])
    past = placer.past
    visits = shelves.visits(placer.seen)[1] * len(past.baskets) / past.days / placer.seen.orders
    saved = 2 * np.subtract.outer(visits, visits) * np.subtract.outer(way, way)
    one, other = (int(at) for at in np.unravel_index(int(saved.argmax()), saved.shape))
    if saved[one, other] <= 0:
        return None
    pods = past.instance.pods
    change = Change(pods[one].name, pods[other].name, None, None, 0, float(saved[one, other]), 2 * floor.visit_s)
    return change, [one, other]
