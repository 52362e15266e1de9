"""A literal version of pod-index, after the formulas of its docstring, one line and one pod after another."""

import math
from collections import Counter
from math import exp
from typing import Any

from oracles.orders import free_on, wants
from oracles.worlds import Moment
from rmfs_core import JointDecision, OrderAssignment, PodTrip
from rmfs_core.warehouse import UNLIMITED, Order, Pod, Station, WarehouseView
from rmfs_rules.pod_index import PodIndex

Line = tuple[Order, int, int]
"""Order, SKU and items."""
CLOSE = 1e-9


class Literal:
    """A period in plain Python; ``without`` takes nothing."""

    def __init__(self, rule: PodIndex, warehouse: WarehouseView, without: Station | None = None) -> None:
        self.rule, self.warehouse, self.stations = rule, warehouse, warehouse.stations
        self.lines = [(order, line.sku, line.quantity) for order in warehouse.backlog for line in order.open_lines]
        self.order_lines = {order: [line for line in self.lines if line[0] is order] for order in warehouse.backlog}
        self.room = [0 if station is without else station.free_capacity for station in self.stations]
        self.load = [station.load for station in self.stations]
        self.inbound = [len(station.inbound_pods) for station in self.stations]
        self.placed = [{o for o in warehouse.backlog if o.has_place_at(station.id)} for station in self.stations]
        picking = {pod: [at for at in pod.bound_for if at < len(self.stations)] for pod in warehouse.pods}
        self.last = {pod: stations[-1] for pod, stations in picking.items() if stations}
        self.movable = {*warehouse.free_pods, *warehouse.leaving_pods}
        self.taken: list[tuple[Line, int]] = []
        self.trips: list[tuple[Pod, int]] = []
        arrivals = [order.arrival_s for order in warehouse.orders]
        self.waits = rule.urge_s > 0 and arrivals[-1] > arrivals[0]
        self.split_before = {order for order in warehouse.backlog if order.parts}
        self.room_to_split = self.room_at_first()
        self.share = {sku: self.share_of(sku) for _, sku, _ in self.lines}

    def room_at_first(self) -> float:
        """How many more orders may be split: by the rule's own limit, the boxes, and the packers' work."""
        room, boxes, work_s, crew = math.inf, 0, 0.0, 0
        if self.rule.packing_capacity is not None:
            room = max(self.rule.packing_capacity - self.warehouse.split_orders_open, 0)
        for station in self.warehouse.packing_stations:
            times = station.section
            boxes, crew = boxes + station.free_boxes, crew + times.packers + times.sorters
            work_s += sum(times.pack_s + times.pack_item_s * order.items for order in station.orders)
            work_s += sum(times.tote_s + times.put_s * order.items for order in station.orders if order.split)
        busy = crew > 0 and 0 < self.rule.packing_work_s < work_s / crew
        return 0 if busy else min(room, boxes) if crew else room

    def free(self, pod: Pod, sku: int) -> int:
        """Free items of a SKU on a pod."""
        return pod.free_items(sku) if sku in pod.contents else 0

    def here(self, station: int, sku: int) -> int:
        """Free items of a SKU at a station that no line has taken."""
        held = sum(self.free(pod, sku) for pod, at in self.last.items() if at == station)
        return held - sum(items for (_, other, items), at in self.taken if (other, at) == (sku, station))

    def share_of(self, sku: int) -> float:
        """Seconds of a visit for a line of a SKU."""
        there = any(self.here(station.id, sku) > 0 for station in self.stations)
        number = [
            sum(self.free(pod, other) > 0 for _, other, _ in self.lines)
            for pod in self.warehouse.pods
            if self.free(pod, sku) > 0
        ]
        visit_s = self.rule.again * self.rule.cost_s if there else self.rule.cost_s
        return visit_s / max(number) if number else 0.0

    def worth(self, line: Line) -> float:
        """``w`` of a line."""
        rule, order, left = self.rule, line[0], 0.0
        for one in self.order_lines[order]:
            if one in self.lines:
                left += rule.handle_s * one[2] + self.share[one[1]]
        factor = float(rule.priority_factor) ** order.priority
        if order.due_s is not None:
            slack_s = max(order.due_s - self.warehouse.now_s, 0.0)
            factor = (1.0 + (rule.due_factor - 1.0) * exp(-slack_s / rule.due_s)) * factor
        return float((rule.handle_s * line[2] + self.share[line[1]]) / (left**rule.finish / factor))

    def split(self, order: Order) -> bool:
        parts = {at for (other, _, _), at in self.taken if other is order}
        rest = any(other is order for other, _, _ in self.lines)
        return order in self.split_before or len(parts) > 1 or (bool(parts) and rest)

    def fits(self, line: Line, station: int) -> bool:
        order, _, items = line
        if self.room_to_split < math.inf:
            new = sum(self.split(other) for other in self.order_lines if other not in self.split_before)
            if new >= self.room_to_split and not self.split(order) and len(self.order_lines[order]) > 1:
                return False
        if self.stations[station].counts_orders:
            return self.room[station] > 0 or order in self.placed[station]
        return items <= self.room[station]

    def best(self, station: int, brought: Pod | None = None) -> tuple[Line | None, float]:
        """The covered line of the largest worth; one that a pod has brought, where there is one."""
        best, most = None, 0.0
        for line in self.lines:
            here = self.here(station, line[1])
            before = 0 if brought is None else here - self.free(brought, line[1])
            if before < line[2] <= here and self.fits(line, station) and (best is None or self.worth(line) > most):
                best, most = line, self.worth(line)
        return best, most

    def index(self, pod: Pod, station: int) -> float:
        """The largest ratio over all sets of lines that a pod would cover (of scarce stock, one item each)."""
        rule, gaining, largest = self.rule, [], 0.0
        for line in self.lines:
            _, sku, items = line
            if items > self.here(station, sku) and self.free(pod, sku) > 0 and self.fits(line, station):
                covered = any(items <= self.here(other.id, sku) for other in self.stations if other.id != station)
                gaining.append((line, self.worth(line) * (rule.elsewhere if covered else 1.0)))
        # Of a SKU the lines that are worth most come first; then those that are worth most for each item
        number, seconds, total = {sku: 0 for _, sku, _ in self.lines}, rule.visit_s, 0.0
        few = []
        for (_, sku, items), worth in sorted(gaining, key=lambda pair: -pair[1]):
            number[sku] += items
            if number[sku] <= self.free(pod, sku) + self.here(station, sku):
                few.append((worth / items, worth, items))
        for _, worth, items in sorted(few, reverse=True):
            total += worth
            seconds += rule.handle_s * items
            largest = max(largest, total / seconds)
        return largest

    def able(self, station: int) -> list[Pod]:
        rule, capacity = self.rule, self.stations[station].capacity
        need, now_s = 0.0, self.warehouse.now_s
        if self.waits and any(self.load):
            need = rule.urge_s * (1 + (rule.full - 1) * min(self.load[station], capacity) / capacity)
        return [
            pod
            for pod in self.warehouse.pods
            if pod in self.movable
            and self.last.get(pod) != station
            and (ages := [now_s + rule.base_s - o.arrival_s for o, sku, _ in self.lines if self.free(pod, sku) > 0])
            and round(1000 * sum(ages)) >= int(1000 * need)
        ]

    def ticks(self, pod: Pod, station: int) -> tuple[int, int]:
        """How soon a pod is at a station, and its id."""
        times = self.warehouse.travel.times_to(self.stations[station].cell, True)
        return int(times[pod.cell].min()), pod.id

    def pods_for(self, station: int, line: Line | None, most: float) -> tuple[list[Pod], Line | None]:
        """The pods to be sent, and the line that only all of them bring."""
        able = self.able(station)
        bound = 0.0 if line is None else self.rule.stay * most / (self.rule.handle_s * line[2])
        index = {pod: self.index(pod, station) for pod in able}
        index = {pod: ratio for pod, ratio in index.items() if ratio > bound * (1 + CLOSE)}
        if index:
            least = (1 - (CLOSE if self.inbound[station] else max(CLOSE, self.rule.near))) * max(index.values())
            good = [pod for pod, ratio in index.items() if ratio > least]
            return [min(good, key=lambda pod: self.ticks(pod, station))], None
        if line is None:
            for one in self.lines:
                _, sku, items = one
                missing = items - self.here(station, sku)
                held = sum(max(self.free(pod, sku), 0) for pod in able)
                if items > 1 and missing > 0 and self.fits(one, station) and held >= missing:
                    sent = []
                    while missing > 0:
                        sent.append(min(able, key=lambda pod: (-self.free(pod, sku), *self.ticks(pod, station))))
                        able.remove(sent[-1])
                        missing -= self.free(sent[-1], sku)
                    return sent, one
        return [], None

    def take(self, line: Line, station: int) -> None:
        order, sku, items = line
        places = items
        if self.stations[station].counts_orders:
            places = int(order not in self.placed[station])
            self.placed[station].add(order)
        self.room[station] -= places
        self.load[station] += places
        self.lines.remove(line)
        self.taken.append((line, station))
        self.movable -= {p for p, at in self.last.items() if at == station and 0 < self.free(p, sku) < UNLIMITED}

    def decide(self) -> tuple[list[tuple[int, int, int]], list[tuple[int, int]]]:
        """Return what is taken, (order, station, SKU), and what is sent, (pod, station)."""
        going_on = [station.id for station in self.stations if self.room[station.id] > 0]
        while going_on:
            for station in sorted(going_on, key=lambda at: (self.inbound[at], at)):
                line, most = self.best(station)
                if self.inbound[station] < self.rule.most_pods:
                    pods, only = self.pods_for(station, line, most)
                    for pod in pods:
                        self.last[pod] = station
                        self.inbound[station] += 1
                        self.movable.remove(pod)
                        self.trips.append((pod, station))
                    if pods:
                        line = only or self.best(station, pods[0])[0]
                if line is not None:
                    self.take(line, station)
                if line is None or not (self.room[station] > 0 or self.stations[station].counts_orders):
                    going_on.remove(station)
        taken = [(order.id, at, sku) for (order, sku, _), at in self.taken]
        return taken, [(pod.id, at) for pod, at in self.trips]


def decided(now: Moment, rule: PodIndex, without: Station | None = None) -> JointDecision:
    """Decide about all lines that fit a station beside others; where no order may be split, about a whole one."""
    period = Literal(rule, now.warehouse, without)
    room = period.room_to_split
    taken, trips = period.decide()
    parts: dict[tuple[int, int], list[int]] = {}
    for order, at, sku in taken:
        parts.setdefault((order, at), []).append(sku)
    if not taken and not trips and room == 0 and now.warehouse.packing_stations:
        return whole(now, rule, without)
    return JointDecision(
        [OrderAssignment(order, at, tuple(skus)) for (order, at), skus in parts.items()],
        [PodTrip(*trip) for trip in trips],
    )


def whole(now: Moment, rule: PodIndex, without: Station | None) -> JointDecision:
    """The order of which fewest lines lack a pod at a station; the oldest, then where the fewest pods are."""
    able = []
    for at, order in enumerate(now.backlog):
        for station in now.stations:
            there = free_there(now, station)
            lacking = sum(there[sku] < items for sku, items in wants(order).items())
            pods = len(station.inbound_pods)
            places = 1 if station.counts_orders else order.open_items
            if (
                station is not without
                and 0 < station.free_capacity >= places
                and (not lacking or pods < rule.most_pods)
            ):
                able.append((lacking, at, pods, station.id, order))
    for *_, station_id, order in sorted(able, key=lambda one: one[:4]):
        if (decision := alone(now, order, now.stations[station_id])).assignments:
            return decision
    stations = [station for station in now.stations if station.open]
    largest = math.inf if now.stations[0].counts_orders else max(station.capacity for station in now.stations)
    large = [order for order in now.backlog if order.open_items > largest]
    if large and stations and not any(station.load for station in now.stations):
        return alone(now, large[0], stations[0])
    return JointDecision()


def free_there(now: Moment, station: Station) -> Counter[int]:
    """Free items of the pods that are at or bound for a station."""
    there = Counter[int]()
    for pod in now.world.pods:
        if station.id in pod.bound_for:
            there += free_on(pod)
    return there


def alone(now: Moment, order: Order, station: Station) -> JointDecision:
    """All that is left of an order to a station, and the pods with most of what is missing there."""
    missing, trips = wants(order) - free_there(now, station), []
    able = [pod for pod in now.world.pods if pod.location is not None and not pod.bound_for]
    able += [pod for pod in now.world.leaving_pods() if station.id not in pod.bound_for]
    while missing:
        brings = [(-(free_on(pod) & missing).total(), now.ticks(pod, station), pod.id) for pod in able]
        if not brings or min(brings)[0] == 0:
            return JointDecision()
        best = now.world.pods[min(brings)[2]]
        able.remove(best)
        missing -= free_on(best)
        trips.append(PodTrip(best.id, station.id))
    return JointDecision([OrderAssignment(order.id, station.id)], trips)


def pod_index(now: Moment, told: Any, **parameters: Any) -> JointDecision:
    """Lines for stations; an order with a line that no station takes goes alone, at last or when it has waited."""
    rule, stations = PodIndex(**parameters), [station for station in now.stations if station.open]
    largest = math.inf if now.stations[0].counts_orders else max(station.capacity for station in now.stations)
    large = [order for order in now.backlog if any(line.quantity > largest for line in order.open_lines)]
    if not now.backlog:
        return JointDecision()
    if not large or not stations:
        return decided(now, rule)
    order, station = large[0], min(stations, key=lambda station: (station.load, station.id))
    waited = now.now_s - order.arrival_s >= rule.max_wait_s
    if waited and not station.load and (decision := alone(now, order, station)).assignments:
        return decision
    kept = waited and station.load > 0
    decision = decided(now, rule, station if kept else None)
    if decision.assignments or station.load:
        return decision
    if waited:  # it cannot be served; another one that is too large for any station may
        others = [order for order in now.backlog if order.open_items > largest]
        order = others[0]
        if any(station.load for station in now.stations):
            return decision
    return alone(now, order, station)


def wake_at(now: Moment, told: Any, **parameters: Any) -> float | None:
    """When the ages of a pod's open lines, and ``base_s`` for each, add up to enough, if a station takes pods then."""
    rule, arrivals = PodIndex(**parameters), [order.arrival_s for order in now.world.arrived.values()]
    taking = [s for s in now.stations if s.free_capacity and len(s.inbound_pods) < rule.most_pods]
    if not now.backlog or not rule.urge_s or not any(s.load for s in now.stations) or arrivals[-1] == arrivals[0]:
        return None
    needs = [int(1000 * rule.urge_s * (1 + (rule.full - 1) * min(s.load, s.capacity) / s.capacity)) for s in taking]
    times = []
    for pod in now.world.pods:
        lines = [order.arrival_tick for order in now.backlog for sku in wants(order) if pod.free_items(sku) > 0]
        if lines and needs:
            tick = math.ceil((min(needs) + sum(lines)) / len(lines) - 1000 * rule.base_s)
            times += [tick / 1000] if tick > now.world.now else []
    return min(times, default=None)
