"""A literal version of pod-index, after the formulas of its docstring, one line and one pod after another."""

from __future__ import annotations

from itertools import combinations
from math import exp

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
        self.placed = [{request.order for request in station.open_requests} for station in self.stations]
        self.last = {pod: pod.bound_for[-1] for pod in warehouse.pods if pod.bound_for}
        self.movable = {*warehouse.free_pods, *warehouse.leaving_pods}
        self.taken: list[tuple[Line, int]] = []
        self.trips: list[tuple[Pod, int]] = []
        arrivals = [order.arrival_s for order in warehouse.orders]
        self.waits = rule.urge_s > 0 and arrivals[-1] > arrivals[0]
        self.split_before = {order for order in warehouse.backlog if order.parts}
        self.split_open = warehouse.split_orders_open
        self.share = {sku: self.share_of(sku) for _, sku, _ in self.lines}

    def free(self, pod: Pod, sku: int) -> int:
        """Free items of a SKU on a pod."""
        return pod.free_items(sku) if sku in pod.contents else 0

    def here(self, station: int, sku: int) -> int:
        """Free items of a SKU at a station that no line has taken."""
        held = sum(self.free(pod, sku) for pod, at in self.last.items() if at == station)
        return held - sum(items for (_, other, items), at in self.taken if (other, at) == (sku, station))

    def share_of(self, sku: int) -> float:
        """Seconds of a visit for a line of a SKU."""
        if any(self.here(station.id, sku) > 0 for station in self.stations):
            return 0.0
        number = [
            sum(self.free(pod, other) > 0 for _, other, _ in self.lines)
            for pod in self.warehouse.pods
            if self.free(pod, sku) > 0
        ]
        return self.rule.cost_s / max(number) if number else 0.0

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
        """Whether an order is split by now."""
        parts = {at for (other, _, _), at in self.taken if other is order}
        rest = any(other is order for other, _, _ in self.lines)
        return order in self.split_before or len(parts) > 1 or (bool(parts) and rest)

    def fits(self, line: Line, station: int) -> bool:
        """Whether a station can take a line."""
        order, _, items = line
        if self.rule.packing_capacity is not None:
            new = sum(self.split(other) for other in self.order_lines if other not in self.split_before)
            full = self.split_open + new >= self.rule.packing_capacity
            if full and not self.split(order) and len(self.order_lines[order]) > 1:
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
        """The largest ratio over all sets of lines that a pod would cover."""
        rule, gaining, largest = self.rule, [], 0.0
        for line in self.lines:
            _, sku, items = line
            if items > self.here(station, sku) and self.free(pod, sku) > 0 and self.fits(line, station):
                covered = any(items <= self.here(other.id, sku) for other in self.stations if other.id != station)
                gaining.append((line, self.worth(line) * (rule.elsewhere if covered else 1.0)))
        for number in range(1, len(gaining) + 1):
            for chosen in combinations(gaining, number):
                used: dict[int, int] = {}
                for (_, sku, items), _ in chosen:
                    used[sku] = used.get(sku, 0) + items
                if all(items <= self.free(pod, sku) + self.here(station, sku) for sku, items in used.items()):
                    seconds = rule.visit_s + rule.handle_s * sum(used.values())
                    largest = max(largest, sum(worth for _, worth in chosen) / seconds)
        return largest

    def able(self, station: int) -> list[Pod]:
        """Pods that may be sent to a station."""
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
        """Assign a line."""
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
