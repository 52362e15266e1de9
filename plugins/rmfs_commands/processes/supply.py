"""Where bundles come from: a file, chance, or orders that are placed where stock has run low."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import dropwhile
from typing import Any

import numpy as np

from rmfs_core.clock import to_ticks
from rmfs_core.events import BundleArrived
from rmfs_core.randomness import stream
from rmfs_core.scenario.model import Replenishment, Scenario
from rmfs_core.simulation.driving.base import Process
from rmfs_core.simulation.going import Going
from rmfs_core.warehouse import UNLIMITED, OrderLine, Warehouse
from rmfs_core.world import BundleData, Instance


class Supply:
    """Bundles brought to a warehouse, by ``instance.replenishment``.

    A bundle has at most ``bundle_items`` items, and no more than a pod can hold. The inventory position counts items
    on pods, in bundles that are there, and on order, less those wanted by orders that wait for stock. The reorder point
    is compared with it, so nothing is ordered twice.

    Parameters
    ----------
    scenario, instance
        Inputs of the run.
    """

    def __init__(self, scenario: Scenario, instance: Instance) -> None:
        self._given, self._instance = scenario.instance.replenishment or Replenishment(), instance
        self.lead_ticks = to_ticks(self._given.lead_s)
        self._rng = stream(scenario.seed, "bundles")
        room, largest = scenario.instance.pod_capacity or UNLIMITED, self._given.bundle_items or UNLIMITED
        self._sizes = instance.sizes or (1,) * len(instance.skus)
        self._largest = [min(largest, room // size) for size in self._sizes]
        self.least_space = 0
        """Space of the smallest bundle that may come by chance."""
        self._position = [0] * len(instance.skus)
        for pod in instance.pods:
            for sku, items in pod.contents:
                self._position[sku] += UNLIMITED if items is None else items

    def coming(self) -> Iterator[BundleData]:
        """Yield bundles in order of arrival that come whatever happens in the warehouse; by chance, forever."""
        yield from self._instance.bundles
        if self._given.bundles_per_hour is not None:
            wanted = np.zeros(len(self._instance.skus))
            for order in self._instance.orders:
                for sku, quantity in order.lines:
                    wanted[sku] += quantity
            weights = wanted if wanted.any() else wanted + 1
            chances = weights.cumsum()
            self.least_space = min(self._largest[sku] * self._sizes[sku] for sku in np.flatnonzero(weights).tolist())
            time_s = 0.0
            while True:
                time_s += self._rng.exponential(3600 / self._given.bundles_per_hour)
                sku = int(np.searchsorted(chances, self._rng.random() * chances[-1], side="right"))
                yield BundleData("", arrival_tick=to_ticks(time_s), sku=sku, items=self._largest[sku])

    def order(self, sku: int) -> list[int]:
        """Return the items of each bundle of a SKU that is ordered now."""
        if not self._instance.levels or self._position[sku] > self._instance.levels[sku][0]:
            return []
        missing = self._instance.levels[sku][1] - self._position[sku]
        self._position[sku] += missing
        full, rest = divmod(missing, self._largest[sku])
        return [self._largest[sku]] * full + [rest] * (rest > 0)

    def knows(self, warehouse: Warehouse, ordered: Iterable[tuple[int, int]]) -> None:
        """Take note of bundles that are there, of SKUs and items that are on order, and of orders that wait."""
        there = (*warehouse.bundles.values(), *(bundle for at in warehouse.storing for bundle in at.bundles))
        self.waits_no_more([*ordered, *((bundle.sku, bundle.items) for bundle in there)])
        for order in warehouse.claims.waiting.values() if warehouse.claims is not None else ():
            self.waits(order.lines)

    def picked(self, sku: int) -> None:
        """Take note that an item was picked."""
        self._position[sku] -= 1

    def waits(self, lines: Iterable[OrderLine]) -> None:
        """Take note that an order waits for stock."""
        for sku, items in lines:
            self._position[sku] -= items

    def waits_no_more(self, lines: Iterable[tuple[int, int]]) -> None:
        """Take note that an order waits for stock no more."""
        for sku, items in lines:
            self._position[sku] += items


class Bundles(Supply):
    """Bundles that arrive in a run.

    Parameters
    ----------
    run
        The run, a `Simulation`.
    """

    def __init__(self, run: Any) -> None:
        super().__init__(run.scenario, run.info.instance)
        self._run = run

    def follow(self) -> Process:
        """Order what has run low at the start, and let bundles arrive that come whatever happens."""
        run = self._run
        self.restock(range(run.warehouse.n_skus))
        begin = run.now if run.context.begun else -1
        for bundle in dropwhile(lambda one: one.arrival_tick <= begin, self.coming()):
            yield run.context.after(bundle.arrival_tick - run.now, Going("bundles"))
            bundle_arrives(run, bundle.sku, bundle.items, bundle.name)
            if run.env.peek() == math.inf and self._is_full():
                return  # what comes changes nothing any more

    def item_picked(self, sku: int) -> None:
        """Count an item that was picked, and order more where its SKU runs low."""
        self.picked(sku)
        self.restock([sku])

    def order_waits(self, lines: Sequence[OrderLine]) -> None:
        """Count an order that waits for stock, and order what it lacks."""
        self.waits(lines)
        self.restock(sku for sku, _ in lines)

    def restock(self, skus: Iterable[int]) -> None:
        """Let what is ordered of SKUs that run low arrive after the lead time."""
        for sku in skus:
            for items in self.order(sku):
                self.comes(Going("bundle", sku=sku, items=items, tick=self._run.now + self.lead_ticks))

    def comes(self, going: Going) -> None:
        """Let a bundle that is ordered arrive at its time."""
        arrived = self._run.context.after(going.tick - self._run.now, going)
        arrived.callbacks.append(lambda _: bundle_arrives(self._run, going.sku or 0, going.items))

    def _is_full(self) -> bool:
        """Whether no bundle can be stored, also of those to come, which take ``least_space`` at least."""
        warehouse = self._run.warehouse
        room, storing = max((pod.free_space for pod in warehouse.pods), default=0), warehouse.storing
        takes = any(station.free_bundle_capacity > 0 for station in storing) and self.least_space <= room
        return not takes and all(b.pod is None and b.size > room for station in storing for b in station.bundles)


def bundle_arrives(run: Any, sku: int, items: int, name: str = "") -> None:
    """Let a bundle arrive in a run, and rules decide."""
    bundle = run.warehouse.bundle_arrives(sku, items, name)
    run.context.tell(BundleArrived(tick=run.now, bundle=bundle.id, name=bundle.name, sku=sku, items=items))
    run.decisions.round(by_clock=True)
