"""Bundles: they come as the scenario says, are assigned once, and stored once, on a pod with space at their station."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from attrs import define

from rmfs_commands.validation.case import Case, Handlers, seconds
from rmfs_commands.validation.state import State
from rmfs_core.clock import to_ticks
from rmfs_core.events import (
    BundleArrived,
    BundleAssigned,
    BundleBound,
    BundleStored,
    ItemPicked,
    OrderArrived,
    OrderCancelled,
    OrderInStock,
    TripDecided,
    VisitEnded,
)
from rmfs_core.warehouse import Bundle

Came = tuple[int, int, int]  # tick, SKU, items


@define
class _Bundle:
    """State of a bundle."""

    name: str
    sku: int
    items: int
    station: int | None = None
    pod: int | None = None
    stored: bool = False


class BundleCheck:
    """Follows the bundles, the space on pods, and what is in stock and on order."""

    def __init__(self, case: Case, state: State) -> None:
        self.case, self.state = case, state
        instance, asked = case.trace.instance, case.trace.scenario.get("instance", {})
        given: dict[str, Any] = asked.get("replenishment", {})
        self.process, self.lead = given.get("process", "none"), to_ticks(given.get("lead_s", 0.0))
        self.capacity = asked.get("pod_capacity")
        self.sizes = instance.sizes or (1,) * len(instance.skus)
        self.largest = given.get("bundle_items")
        self.bundles: list[_Bundle] = []
        self.expected: Counter[Came] = Counter((b.arrival_tick, b.sku, b.items) for b in instance.bundles)
        self.used = [sum((n or 0) * self.sizes[sku] for sku, n in pod.contents) for pod in instance.pods]
        self.promised: Counter[int] = Counter()
        self.at: Counter[int] = Counter()  # station -> bundles that are assigned and not stored
        self.endless = {sku for pod in instance.pods for sku, number in pod.contents if number is None}
        self.position: Counter[int] = Counter()
        self.wanting: set[int] = set()  # orders that wait for stock
        for pod in instance.pods:
            self.position.update({sku: number or 0 for sku, number in pod.contents})
        for i, used in enumerate(self.used):
            self._fits(0, i, used)
        self.begun = False
        self.handlers: Handlers = {
            BundleArrived: self.arrived,
            BundleAssigned: self.assigned,
            BundleBound: self.bound,
            TripDecided: self.trip,
            BundleStored: self.stored,
            ItemPicked: self.picked,
            OrderArrived: self.order_arrived,
            OrderInStock: self.waits_no_more,
            OrderCancelled: self.waits_no_more,
            VisitEnded: self.left,
        }

    def begin(self, now: int, there: Sequence[Bundle], number: int, ordered: Iterable[Came], waits: list[int]) -> None:
        """Take note of the bundles of a state, on order and of those there, and of the orders that wait for stock."""
        self.bundles = [_Bundle("", 0, 0, stored=True) for _ in range(number)]
        self.expected = Counter({came: n for came, n in self.expected.items() if came[0] > now})
        self.expected.update(ordered)
        self.position.update({sku: 0 for _, sku, _ in ordered})
        for _, sku, items in ordered:
            self.position[sku] += items
        for bundle in there:
            self.position[bundle.sku] += bundle.items
            at, pod = bundle.station, bundle.pod
            self.bundles[bundle.id] = _Bundle(bundle.name, bundle.sku, bundle.items, at, pod)
            self.at.update([] if at is None else [at])
            if pod is not None:
                self.promised[pod] += bundle.size
        self.wanting.update(waits)
        for order in waits:
            for sku, items in self.case.trace.instance.orders[order].lines:
                self.position[sku] -= items

    def _begin(self) -> None:
        """Expect what is ordered when the run begins, after the orders that arrive then."""
        if not self.begun:
            self.begun = True
            for sku in range(len(self.case.trace.instance.levels)):
                self._order(sku, self.case.trace.began)

    def _order(self, sku: int, tick: int) -> None:
        """Expect what is ordered where the inventory position is at the reorder point."""
        levels = self.case.trace.instance.levels
        if not levels or sku in self.endless or self.position[sku] > levels[sku][0]:
            return
        missing = levels[sku][1] - self.position[sku]
        self.position[sku] += missing
        most = min(self.largest or missing, (self.capacity or missing * self.sizes[sku]) // self.sizes[sku])
        full, rest = divmod(missing, max(most, 1))
        self.expected[tick + self.lead, sku, most] += full
        self.expected[tick + self.lead, sku, rest] += rest > 0

    def arrived(self, event: BundleArrived) -> None:
        """Check that a bundle was to come, and now."""
        self._begin()
        case, comes = self.case, f"bundle {event.name} with {event.items} of {self.case.sku(event.sku)} arrives"
        if event.bundle != len(self.bundles):
            case.add("bundle-arrival", event.tick, f"{comes} with id {event.bundle}; expected {len(self.bundles)}")
        came = (event.tick, event.sku, event.items)
        if self.process == "none" or event.items < 1:
            case.add("bundle-arrival", event.tick, f"{comes}; expected none such")
        elif self.process != "poisson":
            if not self.expected[came]:
                case.add("bundle-arrival", event.tick, f"{comes}, which nobody has sent to come now")
            self.expected[came] -= 1
        self.bundles.append(_Bundle(event.name, event.sku, event.items))

    def _known(self, event: BundleAssigned | BundleBound | BundleStored) -> _Bundle | None:
        if 0 <= event.bundle < len(self.bundles):
            return self.bundles[event.bundle]
        self.case.add("unknown-id", event.tick, f"{type(event).__name__} names bundle {event.bundle}; it never arrived")
        return None

    def assigned(self, event: BundleAssigned) -> None:
        """Check that a station has capacity for a bundle without a station."""
        case, bundle = self.case, self._known(event)
        if bundle is None:
            return
        goes = f"bundle {bundle.name} is assigned to {case.station(event.station)}"
        if bundle.station is not None:
            case.add("bundle-twice", event.tick, f"{goes}, after {case.station(bundle.station)}")
            self.at[bundle.station] -= 1
        bundle.station = event.station
        self.at[event.station] += 1
        most = case.trace.stations[event.station].get("bundle_capacity", 0)
        if self.at[event.station] > most:
            case.add("bundle-capacity", event.tick, f"{goes}, which has {self.at[event.station]} then; it holds {most}")

    def bound(self, event: BundleBound) -> None:
        """Check that a pod has space for a bundle without a pod."""
        case, bundle = self.case, self._known(event)
        if bundle is None:
            return
        chosen = f"{case.pod(event.pod)} is chosen for bundle {bundle.name}"
        if bundle.pod is not None:
            case.add("bundle-twice", event.tick, f"{chosen}, after {case.pod(bundle.pod)}")
            self.promised[bundle.pod] -= bundle.items * self.sizes[bundle.sku]
        if bundle.station is None:
            case.add("bundle-elsewhere", event.tick, f"{chosen}, which is at no station")
        bundle.pod = event.pod
        self.promised[event.pod] += bundle.items * self.sizes[bundle.sku]
        self._fits(event.tick, event.pod, self.used[event.pod] + self.promised[event.pod])

    def _fits(self, tick: int, pod: int, used: int) -> None:
        if self.capacity is not None and used > self.capacity:
            held = f"what {self.case.pod(pod)} holds, or is to, takes {used} of space"
            self.case.add("pod-capacity", tick, f"{held}; its capacity is {self.capacity}")

    def _waiting(self, pod: int, station: int) -> list[_Bundle]:
        return [b for b in self.bundles if b.pod == pod and b.station == station and not b.stored]

    def trip(self, event: TripDecided) -> None:
        """Check that a pod that is sent to where nothing is picked has a bundle there."""
        case, picking = self.case, len(self.case.trace.stations) - self.case.layout.replenishing
        if event.station >= picking and not self._waiting(event.pod, event.station):
            sent = f"{case.pod(event.pod)} is sent to {case.station(event.station)}"
            case.add("bundle-elsewhere", event.tick, f"{sent}, where no bundle is for it")

    def stored(self, event: BundleStored) -> None:
        """Check station, time and items, and put them on the pod."""
        case, bundle, station = self.case, self._known(event), self.state.stations[event.station]
        if bundle is None:
            return
        doing = f"bundle {bundle.name} is stored on {case.pod(event.pod)} at {case.station(event.station)}"
        if bundle.stored:
            case.add("bundle-twice", event.tick, f"{doing}, a second time")
        if (bundle.pod, bundle.station) != (event.pod, event.station):
            case.add("bundle-elsewhere", event.tick, f"{doing}, but is for another pod or station")
        if (bundle.sku, bundle.items) != (event.sku, event.items):
            case.add("bundle-items", event.tick, f"{doing} with other items than it came with")
        visit = station.visit
        if (
            visit is None
            or (visit.number, visit.pod) != (event.visit, event.pod)
            or event.start_tick < visit.start_tick
        ):
            case.add("no-visit", event.tick, f"{doing} in visit {event.visit}, which was not under way")
        if event.tick - event.start_tick != (
            ticks := case.services.store(event.station, event.bundle, event.start_tick)[0]
        ):
            taken = seconds(event.tick - event.start_tick)
            case.add("store-time", event.tick, f"{doing} in {taken}; that takes {seconds(ticks)}")
        if event.start_tick < station.picker_free_tick:
            busy = f"but the worker is busy until {seconds(station.picker_free_tick)}"
            case.add("picker-busy", event.tick, f"{doing} from {seconds(event.start_tick)} on, {busy}")
        station.picker_free_tick = max(station.picker_free_tick, event.tick)
        size = event.items * self.sizes[event.sku]
        if not bundle.stored and bundle.pod is not None and bundle.station is not None:
            self.promised[bundle.pod] -= bundle.items * self.sizes[bundle.sku]
            self.at[bundle.station] -= 1
        bundle.stored = True
        self.used[event.pod] += size
        stock = self.state.pods[event.pod].stock
        if (held := stock.get(event.sku, 0)) is not None:
            stock[event.sku] = held + event.items
        self._fits(event.tick, event.pod, self.used[event.pod] + self.promised[event.pod])

    def picked(self, event: ItemPicked) -> None:
        """Note that an item is gone."""
        self._begin()
        if self.state.pods[event.pod].stock.get(event.sku) is not None:
            self.used[event.pod] -= self.sizes[event.sku]
        self.position[event.sku] -= 1
        self._order(event.sku, event.tick)

    def order_arrived(self, event: OrderArrived) -> None:
        """Expect what is ordered for an order that waits for stock."""
        if event.tick > self.case.trace.began:
            self._begin()
        if self.state.orders[event.order].waits:
            self.wanting.add(event.order)
            for sku, items in self.case.trace.instance.orders[event.order].lines:
                self.position[sku] -= items
                self._order(sku, event.tick)

    def waits_no_more(self, event: OrderInStock | OrderCancelled) -> None:
        """Note that an order waits for stock no more."""
        if event.order in self.wanting:
            self.wanting.remove(event.order)
            for sku, items in self.case.trace.instance.orders[event.order].lines:
                self.position[sku] += items

    def left(self, event: VisitEnded) -> None:
        """Check that nothing was to be stored any more."""
        for bundle in self._waiting(event.pod, event.station):
            leaves = f"{self.case.pod(event.pod)} leaves {self.case.station(event.station)}"
            self.case.add("left-early", event.tick, f"{leaves}, where bundle {bundle.name} is to be stored on it")

    def at_end(self) -> None:
        """Check that whatever was to come has come."""
        self._begin()
        end = self.case.trace.tick
        for (tick, sku, items), number in self.expected.items():
            if number > 0 and tick < end:
                missing = f"{number} bundle(s) with {items} of {self.case.sku(sku)} did not arrive"
                self.case.add("bundle-arrival", end, f"{missing} at {seconds(tick)}")
