"""Picks: from a pod at the station, by a picker with free hands, of an item that was ordered and assigned there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from rmfs_commands.validation.case import Case, Handlers, seconds
from rmfs_commands.validation.state import State
from rmfs_core.clock import to_ticks
from rmfs_core.events import ItemPicked


class PickCheck:
    """Each item of each order line is picked once, where it is assigned, from a pod that has it."""

    def __init__(self, case: Case, state: State) -> None:
        self.case = case
        self.state = state
        self.handlers: Handlers = {ItemPicked: self.picked}
        self._handled_tick = 0  # of the item that is being checked
        self._items, self._visits = Counter[tuple[int, int]](), Counter[tuple[int, int]]()  # of each line, so far
        self._begun: set[tuple[int, int]] = set()  # orders at stations
        self._last: dict[int, tuple[int, ...]] = {}  # visit and line of the last pick at each station
        self._under_way: dict[int, list[int]] = {}  # ticks of picking and handling what was in hand when the run began

    def begin(
        self, drawn: Mapping[tuple[int, ...], int], last: Mapping[int, tuple[int, ...]], under_way: dict[int, list[int]]
    ) -> None:
        """Take note of what was drawn before a run began in a state, by what it was for, and of picks under way."""
        for what, number in drawn.items():
            if len(what) == 2:
                self._items[what[0], what[1]] = number
            elif len(what) == 3:
                self._visits[what[0], what[1]] = number
            elif len(what) == 4:
                self._begun.add((what[0], what[1]))
        self._last.update(last)
        self._under_way = under_way

    def picked(self, event: ItemPicked) -> None:
        """Check a pick."""
        item = (
            f"{self.case.sku(event.sku)} of {self.case.order(event.order)} is picked from {self.case.pod(event.pod)} "
            f"at {self.case.station(event.station)}"
        )
        self._visit(event, item)
        self._times(event, item)
        self._stock(event, item)
        if self._ordered(event, item):
            self._fulfil(event)

    def _visit(self, event: ItemPicked, item: str) -> None:
        visit = self.state.stations[event.station].visit
        if visit is None or (visit.number, visit.pod) != (event.visit, event.pod):
            there = "no pod is" if visit is None else f"{self.case.pod(visit.pod)} with visit {visit.number} is"
            self.case.add("no-visit", event.tick, f"{item} in visit {event.visit}, but {there} there")
        elif event.start_tick < visit.start_tick:
            self.case.add(
                "no-visit",
                event.tick,
                f"{item} from {seconds(event.start_tick)} on, before its visit began at {seconds(visit.start_tick)}",
            )
        if visit is not None:
            visit.picks += 1

    def _times(self, event: ItemPicked, item: str) -> None:
        case, station = self.case, self.state.stations[event.station]
        pick_ticks, handle_ticks = self._expected(event)
        if event.tick - event.start_tick != pick_ticks:
            taken = seconds(event.tick - event.start_tick)
            case.add("pick-time", event.tick, f"{item} in {taken}; that takes {seconds(pick_ticks)}")
        if event.picker_free_tick - event.start_tick != handle_ticks:
            taken = seconds(event.picker_free_tick - event.start_tick)
            case.add("handle-time", event.tick, f"{item} and handled in {taken}; expected {seconds(handle_ticks)}")
        if event.start_tick < station.picker_free_tick:
            case.add(
                "picker-busy",
                event.tick,
                f"{item} from {seconds(event.start_tick)} on, "
                f"but its picker handles another item until {seconds(station.picker_free_tick)}",
            )
        self._handled_tick = event.start_tick + handle_ticks if case.trace.floor is None else event.picker_free_tick
        station.picker_free_tick = max(station.picker_free_tick, self._handled_tick)

    def _expected(self, event: ItemPicked) -> list[int]:
        """Return the ticks of picking and of handling an item, as the seed draws them."""
        if (known := self._under_way.pop(event.station, None)) is not None:
            return known
        services, line, before_s = self.case.services, (event.order, event.sku), 0.0
        seconds = services.item_s(*line, self._items[line])
        self._items[line] += 1
        if self._last.get(event.station) != (event.visit, *line):
            before_s += services.begin_line_s(*line, self._visits[line])
            self._visits[line] += 1
        self._last[event.station] = (event.visit, *line)
        if (event.order, event.station) not in self._begun:
            before_s += services.begin_order_s(event.order, event.station)
        self._begun.add((event.order, event.station))
        speed = services.speed(event.station, event.start_tick)
        return [max(to_ticks((before_s + one_s) / speed), 1) for one_s in seconds]

    def _stock(self, event: ItemPicked, item: str) -> None:
        stock = self.state.pods[event.pod].stock
        if event.sku not in stock:
            self.case.add("sku-not-on-pod", event.tick, f"{item}, which does not hold it")
            return
        number = stock[event.sku]
        if number is None:
            return
        if number <= 0:
            self.case.add("stock-negative", event.tick, f"{item}, which has none left")
        stock[event.sku] = number - 1

    def _ordered(self, event: ItemPicked, item: str) -> bool:
        """Check that an item is wanted; return whether it is."""
        order = self.state.orders[event.order]
        if event.sku not in order.unpicked:
            self.case.add("not-ordered", event.tick, f"{item}, but the order does not have the SKU")
        elif order.unpicked[event.sku] <= 0:
            self.case.add("picked-twice", event.tick, f"{item}, but all its items have been picked")
        elif event.sku not in order.part_of:
            self.case.add("not-assigned", event.tick, f"{item}, but is assigned nowhere")
        elif order.part_of[event.sku][0] != event.station:
            where = self.case.station(order.part_of[event.sku][0])
            self.case.add("not-assigned", event.tick, f"{item}, but is assigned to {where}")
            return True
        else:
            return True
        return False

    def _fulfil(self, event: ItemPicked) -> None:
        """Note that an item is picked, and perhaps still to be handled."""
        order = self.state.orders[event.order]
        order.unpicked[event.sku] -= 1
        self.state.stations[order.part_of[event.sku][0]].open[event.sku] -= 1
        if self.case.keeps_places:
            order.in_hand += 1
            self.state.stations[event.station].in_hand.append((event.order, event.sku, self._handled_tick))
        else:
            self._release(event.order, event.sku, event.tick)

    def until(self, tick: int) -> None:
        """Note what is handled by then: at the latest when capacity is needed that it frees."""
        for station in self.state.stations:
            while station.in_hand and station.in_hand[0][2] <= tick:
                order, sku, done = station.in_hand.pop(0)
                self.state.orders[order].in_hand -= 1
                self._release(order, sku, done)

    def _release(self, number: int, sku: int, tick: int) -> None:
        """Take an item off its part; the last one frees the capacity of the whole part."""
        order = self.state.orders[number]
        part = order.part_of[sku]
        station = self.state.stations[part[0]]
        order.last_tick = max(order.last_tick, tick)  # stations are settled one after the other
        order.left[part] -= 1
        if order.left[part] == 0:
            size = order.size.pop(part)
            joined = [other for other in order.size if other[0] == part[0]]
            if joined and self.case.trace.stations[part[0]]["counts_orders"]:
                order.size[joined[0]] = max(size, order.size[joined[0]])  # the capacity is theirs now
            else:
                station.load -= size
