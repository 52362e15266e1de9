"""Joint POA+PPS rule ``pod-index``."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from attrs import define, field, validators
from numpy.typing import NDArray

from rmfs_core import JointDecision, OrderAssignment, PodTrip, hookimpl
from rmfs_pod_index.compiled import NONE, Contents, Lines, best_covered, best_pods, line_costs, urgent
from rmfs_rule_helpers import ticks_to_station

if TYPE_CHECKING:
    from rmfs_core.traffic import Roads
    from rmfs_core.warehouse import WarehouseView


@define(kw_only=True)
class PodIndex:
    """Take the lines that finish orders, and send the pods that bring most of them in the least time.

    A greedy rule without a solver, for few visits and a short turn-over at once. It may leave lines of an order for
    later. A line of SKU i with q items costs c seconds: handle_s * q, and, where no pod at or bound for a station has
    i, cost_s / (open lines on the pod with most of them that has i). c is fixed at the start of a call. Line l of
    order o is worth

        w = c_l / (sum of c over the open lines of o) ** finish,

    most when it is the last one. The index of a pod for a station is the worth that it brings a second: the largest
    ratio, over the sets of lines that the pod would cover and the station does not, of

        sum of w to visit_s + handle_s * items,

    in which lines that another station covers count ``elsewhere`` times. (Of a SKU of which the pod has too few items,
    the lines that add most come first.)

    Stations take turns, fewest pods first. The one whose turn it is takes the covered line that is worth most. But when
    fewer than most_pods pods are there or on their way, and the largest index of a pod that is stored or leaving is
    above stay * w / (handle_s * q) of that line (above 0 where none is covered), it sends that pod, the nearest of
    equals, and takes its best line. Where neither is to be had, its places stay free. While stations are at work, pods
    wait until it pays: one is sent only when the ages of its open lines, and base_s for each, add up to urge_s.

    A line that no single pod can serve is brought by several, when there is nothing else to send.

    References
    ----------
    W. E. Smith: Various optimizers for single-stage production. Naval Research Logistics Quarterly 3, 59-66, 1956.
    https://doi.org/10.1002/nav.3800030106 (weighted shortest processing time first: the idea behind the index)

    W. Dinkelbach: On nonlinear fractional programming. Management Science 13, 492-498, 1967.
    https://doi.org/10.1287/mnsc.13.7.492 (how the largest ratio is found)
    """

    splits_over_time: ClassVar[bool] = True

    visit_s: float = field(
        default=300.0,
        validator=validators.ge(0),
        metadata={
            "unit": "s",
            "doc": "What a visit counts in a pod's index: the larger, the more lines a pod must bring",
        },
    )
    cost_s: float = field(
        default=1000.0,
        validator=validators.ge(0),
        metadata={
            "unit": "s",
            "doc": "What a visit costs the lines that need it: the larger, the more rare SKUs are worth",
        },
    )
    finish: float = field(
        default=0.7,
        validator=validators.ge(0),
        metadata={
            "doc": "How much more a line is worth the less its order has left: 0 not at all, 1 as in Smith's rule"
        },
    )
    stay: float = field(
        default=1.0,
        validator=validators.ge(0),
        metadata={
            "doc": "How many times better than the best covered line a pod must be: the larger, the fewer visits"
        },
    )
    elsewhere: float = field(
        default=0.5,
        validator=validators.and_(validators.ge(0), validators.le(1)),
        metadata={
            "doc": "What a line that another station covers counts in a pod's index: the smaller, the fewer visits"
        },
    )
    most_pods: int = field(
        default=2,
        validator=validators.ge(1),
        metadata={"doc": "Pods at or bound for a station from which on no further one is sent"},
    )
    urge_s: float = field(
        default=200.0,
        validator=validators.ge(0),
        metadata={"unit": "s", "doc": "What the ages of a pod's lines add up to before it is sent; 0: no waiting"},
    )
    base_s: float = field(
        default=10.0,
        validator=validators.gt(0),
        metadata={"unit": "s", "doc": "What a line counts in `urge_s` besides its age"},
    )
    handle_s: float = field(
        default=13.0,
        validator=validators.gt(0),
        metadata={"unit": "s", "doc": "How long a picker is busy with an item"},
    )
    packing_capacity: int | None = field(
        default=None,
        validator=validators.optional(validators.ge(1)),
        metadata={
            "doc": "Split orders that the packing stations have room for, those already open included; none by default"
        },
    )

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView) -> JointDecision:
        """Take lines and send pods, one after another, until the places are taken or left free."""
        if not any(station.free_capacity > 0 for station in warehouse.stations):
            return JointDecision()
        period = _Period(self, warehouse)
        while period.open:
            period.turn()
        return period.decision()

    def prepare(self, roads: Roads) -> None:  # noqa: ARG002
        """Load the compiled scores, or compile them."""
        zero, one, own = np.zeros(1, np.int64), np.ones(1, np.int64), np.zeros(1, np.int64)
        for shown in (zero, one):
            shown.setflags(write=False)  # as what the view shows; numba compiles for either kind
        lines, pods = Lines(zero, one, own, np.array([0, 1])), Contents(np.array([0, 1]), zero, one)
        fits = np.ones(1, np.bool_)
        worth = line_costs(lines, pods, fits, self.handle_s, self.cost_s)
        best_covered(lines, worth, fits, own)
        best_pods(0.0, own, lines, worth, fits, pods, own, self.handle_s, self.visit_s)
        urgent(own, lines, fits, worth, pods, self.urge_s)


class _Period:
    """A period under construction: what was taken and sent so far, and what that leaves."""

    def __init__(self, rule: PodIndex, warehouse: WarehouseView) -> None:
        self.rule, self.warehouse, self.stations = rule, warehouse, warehouse.stations
        number = len(warehouse.backlog)
        lines, free = warehouse.backlog_lines, warehouse.free_items
        by_sku = np.argsort(lines.sku, kind="stable")
        first = np.searchsorted(lines.sku[by_sku], np.arange(warehouse.n_skus + 1))
        self.order = lines.order
        self.start = np.searchsorted(lines.order, np.arange(number + 1))
        self.lines = Lines(lines.sku, lines.quantity, by_sku, first)
        self.pods = Contents(np.searchsorted(free.pod, np.arange(len(warehouse.pods) + 1)), free.sku, free.number)
        self.available = np.zeros((len(self.stations), warehouse.n_skus), dtype=np.int64)
        for station in self.stations:
            for pod in station.inbound_pods:
                if pod.bound_for[-1] == station.id:  # its free items count once, where it goes last
                    self._bring(pod.id, station.id)
        self.inbound = [len(station.inbound_pods) for station in self.stations]
        self.room = [station.free_capacity for station in self.stations]
        self.open = {station.id for station in self.stations if station.free_capacity > 0}
        here = (self.available > 0).any(axis=0)
        self.cost = line_costs(self.lines, self.pods, here, rule.handle_s, rule.cost_s)
        self.left = np.bincount(self.order, weights=self.cost, minlength=number)
        self.worth = self.cost / self.left[self.order] ** rule.finish
        self.untaken = np.ones(len(self.order), dtype=np.bool_)
        self.packing = _Packing(rule.packing_capacity, warehouse) if rule.packing_capacity is not None else None
        self.parts: dict[tuple[int, int], list[int]] = {}
        self.trips: list[PodTrip] = []

    def turn(self) -> None:
        """Let each station that may go on take a line, fewest pods first."""
        for station in sorted(self.open, key=lambda i: (self.inbound[i], i)):
            line = self._choose(station)
            if line == NONE:
                self.open.remove(station)
            else:
                self._take(line, station)

    def decision(self) -> JointDecision:
        """Return what was chosen, as the kernel takes it."""
        backlog = self.warehouse.backlog
        return JointDecision(
            [OrderAssignment(backlog[order].id, station, tuple(skus)) for (order, station), skus in self.parts.items()],
            self.trips,
        )

    # What may be chosen

    @cached_property
    def candidates(self) -> NDArray[np.int64]:
        """Pods that may be sent, by id."""
        movable = (*self.warehouse.free_pods, *self.warehouse.leaving_pods)
        return np.array(sorted(pod.id for pod in movable), dtype=np.int64)

    @cached_property
    def _ages(self) -> NDArray[np.float64]:
        ages = [self.warehouse.now_s - order.arrival_s for order in self.warehouse.backlog]
        return np.array(ages)[self.order] + self.rule.base_s

    @cached_property
    def _placed(self) -> list[set[int]]:
        """Orders that have a place at each station that counts orders, by their position in the backlog."""
        position = {order.id: i for i, order in enumerate(self.warehouse.backlog)}
        working = [{request.order.id for request in station.open_requests} for station in self.stations]
        return [{position[order] for order in orders & position.keys()} for orders in working]

    def _fits(self, station: int) -> NDArray[np.bool_]:
        """Which lines may be taken and fit the free places of a station."""
        if self.stations[station].counts_orders:
            fits = self.untaken & (np.isin(self.order, list(self._placed[station])) | (self.room[station] > 0))
        else:
            fits = self.untaken & (self.lines.quantity <= self.room[station])
        if self.packing is not None:
            fits &= self.packing.room()[self.order]
        return fits

    def _urgent(self) -> NDArray[np.int64]:
        """Pods that are wanted enough to be sent now: all of them where no station has anything to do."""
        at_work = self.parts or any(station.load for station in self.stations)
        if not (at_work and self.rule.urge_s):
            return self.candidates
        chosen = urgent(self.candidates, self.lines, self.untaken, self._ages, self.pods, self.rule.urge_s)
        waited: NDArray[np.int64] = self.candidates[chosen]
        return waited

    def _choose(self, station: int) -> int:
        """Send a pod to a station if that is better, and return the line to take there; NONE for none."""
        rule, available, quantity = self.rule, self.available[station], self.lines.quantity
        fits = self._fits(station)
        line = int(best_covered(self.lines, self.worth, fits, available))
        if self.inbound[station] >= rule.most_pods:
            return line
        bound = 0.0 if line == NONE else rule.stay * self.worth[line] / (rule.handle_s * quantity[line])
        others = np.delete(self.available, station, axis=0)
        covered = (others[:, self.lines.sku] >= quantity).any(axis=0)
        worth = np.where(covered, rule.elsewhere * self.worth, self.worth)
        pods = best_pods(
            bound, self._urgent(), self.lines, worth, fits, self.pods, available, rule.handle_s, rule.visit_s
        )
        brought = fits & (quantity > available[self.lines.sku])
        if len(pods):
            self._send(self._by_distance(pods, station)[0], station)
        elif line != NONE or not self._gather(brought, station):
            return line
        return int(best_covered(self.lines, self.worth, brought, available))

    def _gather(self, wanted: NDArray[np.bool_], station: int) -> bool:
        """Send the pods that the oldest line needs of which none has enough items; return whether there is one."""
        if self.warehouse.unlimited_stock:
            return False
        entries = np.isin(self.warehouse.free_items.pod, self._urgent())
        items = np.bincount(self.pods.sku[entries], weights=self.pods.items[entries], minlength=self.warehouse.n_skus)
        enough = wanted & (self.lines.quantity <= (self.available[station] + items)[self.lines.sku])
        if not enough.any():
            return False
        line = int(enough.argmax())
        sku, missing = int(self.lines.sku[line]), int(self.lines.quantity[line])
        missing -= int(self.available[station, sku])
        holds = np.flatnonzero(entries & (self.pods.sku == sku) & (self.pods.items > 0))
        held = dict(zip(self.warehouse.free_items.pod[holds].tolist(), self.pods.items[holds].tolist(), strict=True))
        for pod in sorted(self._by_distance(np.array(list(held)), station), key=lambda pod: -held[pod]):
            if missing > 0:
                self._send(pod, station)
                missing -= held[pod]
        return True

    def _by_distance(self, pods: NDArray[np.int64], station: int) -> list[int]:
        if len(pods) == 1:
            return [int(pods[0])]
        given = self.warehouse.pods
        ticks = {int(pod): ticks_to_station(self.warehouse, given[pod], self.stations[station]) for pod in pods}
        return sorted(ticks, key=lambda pod: (ticks[pod], pod))

    # What a choice changes

    def _bring(self, pod: int, station: int, sign: int = 1) -> None:
        entries = slice(self.pods.first[pod], self.pods.first[pod + 1])
        self.available[station, self.pods.sku[entries]] += sign * self.pods.items[entries]

    def _send(self, pod: int, station: int) -> None:
        self.trips.append(PodTrip(pod, station))
        for before in self.warehouse.pods[pod].bound_for[-1:]:
            self._bring(pod, before, -1)
        self._bring(pod, station)
        self.inbound[station] += 1
        self.candidates = self.candidates[self.candidates != pod]

    def _take(self, line: int, station: int) -> None:
        order, quantity = int(self.order[line]), int(self.lines.quantity[line])
        if self.stations[station].counts_orders:
            self.room[station] -= order not in self._placed[station]
            self._placed[station].add(order)
        else:
            self.room[station] -= quantity
        self.parts.setdefault((order, station), []).append(int(self.lines.sku[line]))
        self.untaken[line] = False
        self.available[station, self.lines.sku[line]] -= quantity
        self.left[order] -= self.cost[line]
        others = slice(self.start[order], self.start[order + 1])
        rest = bool(self.untaken[others].any())
        if rest:
            self.worth[others] = self.cost[others] / self.left[order] ** self.rule.finish
        if self.packing is not None:
            self.packing.take(order, rest=rest, parts=sum(of == order for of, _ in self.parts))


class _Packing:
    """Room for split orders at the packing stations."""

    def __init__(self, capacity: int, warehouse: WarehouseView) -> None:
        self.free = capacity - warehouse.split_orders_open
        self.split = np.array([bool(order.parts) for order in warehouse.backlog], dtype=np.bool_)
        self.before = self.split.copy()
        self.single = np.array([len(order.open_lines) == 1 for order in warehouse.backlog], dtype=np.bool_)

    def room(self) -> NDArray[np.bool_]:
        """Which orders may have a line taken: with no room left, those that are split already or have but one line."""
        return self.split | self.single | (self.free > 0)

    def take(self, order: int, *, rest: bool, parts: int) -> None:
        """Count an order in while it has lines left or several parts, and out again when it turns out whole."""
        if not self.before[order]:
            split = rest or parts > 1
            self.free += int(self.split[order]) - int(split)
            self.split[order] = split
