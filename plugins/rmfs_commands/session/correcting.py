"""A floor that takes back: what was decided, what a pod holds, what rules are shown."""

from __future__ import annotations

from bisect import insort
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rmfs_commands.session.facts import ContradictionError
from rmfs_commands.session.floor import AbandonedError, AbortedError, Floor
from rmfs_core.events import PodStored
from rmfs_core.simulation.applying import tell_open
from rmfs_core.warehouse import UNLIMITED, Order, Pod, Request, Robot, Station

AT_STATION = ("pick", "picker", "stow")
"""Kinds of what goes on while a pod stands at a station."""


class CorrectedFloor(Floor):
    """A floor on which not everything goes as it was decided. No round runs in its methods.

    Attributes
    ----------
    locked
        By pod, the items per SKU that nobody is shown, and the space that is kept free of bundles.
    hidden
        Orders that no rule is shown, by id.
    corrected
        Ids of orders and of pods that are other than events have told.
    followers
        Objects whose method ``corrected`` is told of these before rules are asked again.
    """

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.locked: dict[int, tuple[Mapping[int, int], int]] = {}
        self.hidden: dict[int, Order] = {}
        self.corrected: tuple[set[int], set[int]] = set(), set()
        self.followers: list[Any] = []

    def tell_corrected(self) -> None:
        """Tell those who follow the state what no event tells of."""
        if any(self.corrected):
            for one in self.followers:
                one.corrected(*self.corrected)
            for ids in self.corrected:
                ids.clear()

    def settle(self) -> None:
        """Let everything happen that takes no time."""
        self.tell_corrected()
        super().settle()

    def round(self) -> None:
        """Let rules decide."""
        self.tell_corrected()
        super().round()

    # What pods hold

    def lock(self, pod: Pod) -> None:
        """Let a pod hold nothing as far as rules and requests know, and take no bundle."""
        if pod.id in self.locked:
            return
        held, space = dict(pod.contents), pod.free_space
        kept = max(space, 0) if space < UNLIMITED else 0
        self.locked[pod.id] = held, kept
        self.warehouse.unlimited_stock = False
        self._count(pod, dict.fromkeys(held, 0), space - kept)

    def unlock(self, pod: Pod) -> None:
        """Let a pod hold again what it held."""
        if pod.id in self.locked:
            held, kept = self.locked.pop(pod.id)
            self.warehouse.unlimited_stock = self.info.instance.unlimited_stock and not self.locked
            there = {sku: items + (pod.contents[sku] if items < UNLIMITED else 0) for sku, items in held.items()}
            self._count(pod, there, pod.free_space + kept)

    def recount(self, pod: Pod, contents: Mapping[int, int]) -> None:
        """Let a pod hold so many items of SKUs that it has held before."""
        gained = {sku: items - pod.contents[sku] for sku, items in contents.items()}
        space = pod.free_space - sum(self.warehouse.sizes[sku] * items for sku, items in gained.items())
        self._count(pod, contents, min(space, UNLIMITED))
        if self.supply is not None:
            self.supply.waits_no_more(gained.items())
            self.supply.restock(gained)

    def _count(self, pod: Pod, contents: Mapping[int, int], space: int) -> None:
        warehouse, gained = self.warehouse, {sku: items - pod.contents[sku] for sku, items in contents.items()}
        for sku, items in contents.items():
            promised = sum(one.items for one in self._promised(pod, sku))
            for _ in range(promised - items):
                warehouse.promises.withdraw(self._promised(pod, sku)[-1])
        warehouse.recount(pod, contents, space)
        self.corrected[1].add(pod.id)
        for station in pod.bound_for:
            warehouse.promises.promise_items(pod, warehouse.stations[station])
        if warehouse.claims is not None:
            served = warehouse.claims.give(*gained.items())
            warehouse.backlog.add(*served)
            self._in_stock(served)
            self._let_wait([sku for sku, items in gained.items() if items < 0])
        self._check_pick(pod)

    def _promised(self, pod: Pod, sku: int) -> list[Request]:
        """Return the requests that a pod's items are promised to, youngest last."""
        at = (self.warehouse.stations[station] for station in pod.bound_for)
        return [one for station in at for one in station.open_requests if one.pod is pod and one.sku == sku]

    def _let_wait(self, skus: Iterable[int]) -> None:
        """Let orders wait for stock that is not there any more: the youngest of which nothing is assigned."""
        claims, backlog, left = self.warehouse.claims, self.warehouse.backlog.orders, list[Order]()
        assert claims is not None
        for sku in skus:
            for order in reversed(backlog):
                if claims.unclaimed[sku] >= 0:
                    break
                if not order.parts and order not in left and any(line.sku == sku for line in order.lines):
                    left.append(order)
                    for line in order.open_lines:
                        claims.claim(line.sku, -line.quantity)
        if not left:
            return
        wait = [order for order in reversed(left) if not claims.serve(order)]
        self.corrected[0].update(order.id for order in wait)
        self._show(order for order in backlog if order not in wait)
        for order in wait if self.supply is not None else ():
            self.supply.order_waits(order.lines)

    def _check_pick(self, pod: Pod) -> None:
        """Give up the pick from a pod that is under way, if its item is not promised from there any more."""
        robot = pod.robot
        if robot is None or ("pick", robot) not in self.waits:
            return
        order, sku = self.wanted[robot]
        if not any(one.order.id == order for one in self._promised(pod, sku)):
            self.waits.pop(("pick", robot)).event.fail(AbortedError())
            self.settle()

    # What rules are shown

    def hide(self, order: Order) -> None:
        """Let no rule see an order."""
        self.hidden[order.id] = order
        if order in self.warehouse.backlog:
            self._show(other for other in self.warehouse.backlog if other is not order)

    def unhide(self, order: Order) -> None:
        """Let rules see an order again."""
        there = order.id in self.warehouse.arrived and order.open_lines and not order.waits_for_stock
        if self.hidden.pop(order.id, None) is not None and there:
            self._show([*self.warehouse.backlog, order])

    def forget(self, order: Order) -> None:
        """Forget an order that is complete, or has not come into the backlog."""
        self.warehouse.arrived.pop(order.id, None)
        self.book.forget(order.id)
        self.hidden.pop(order.id, None)
        self.corrected[0].discard(order.id)

    def withdraw(self, order: Order) -> bool:
        """Let an order leave, and return True, if it waits for its turn to come into the backlog."""
        if order.id in self.warehouse.arrived:
            return False
        self._coming.remove(order)
        self.forget(order)
        self.completed += 1
        return True

    def _arrive(self, order: Order) -> bool:
        super()._arrive(order)
        if order.id in self.hidden:
            self.hide(order)
        return True

    def _show(self, orders: Iterable[Order]) -> None:
        shown = sorted(orders, key=lambda order: (order.arrival_tick, order.id))
        self.warehouse.backlog = type(self.warehouse.backlog)(self.warehouse.n_skus)
        self.warehouse.backlog.add(*shown)
        self.warehouse.changes += 1

    def _in_stock(self, served: Iterable[Order]) -> None:
        super()._in_stock(served := list(served))
        for order in served:
            if order.id in self.hidden:
                self.hide(order)

    def close(self, station: Station, closed: bool) -> None:
        """Let a station take no order, or again: until its timetable closes it, where that has it open."""
        was_open = station.open
        timed = station.id in self.hours
        (self.closed.add if closed else self.closed.discard)(station.id)
        (self.opened.add if timed and not closed else self.opened.discard)(station.id)
        self.warehouse.staff(station, *(self.shifts.staffed(station.id) if timed else (not closed, None)))
        if station in self.warehouse.picking:  # observers hear of no hours of the others, which take no orders
            tell_open(self.warehouse, station, was_open, self._tell)

    def block(self, cell: int) -> None:
        """Let no pod be brought to a storage location."""
        if cell not in self.warehouse.free_locations:
            raise ContradictionError(f"cell {cell} is no free storage location")
        self.warehouse.reserve(cell)

    def unblock(self, cell: int) -> None:
        """Let pods be brought to a storage location again."""
        self.warehouse.reserved.discard(cell)
        insort(self.warehouse.free_locations, cell)

    # What was decided

    def take_back_task(self, robot: Robot, pod: Pod) -> None:
        """Let a robot that has not lifted its pod have no task; the pod waits for another."""
        story = self.stories[robot.id]
        self._abandon(robot, pod)
        cell, home = robot.cell, pod.location
        assert home is not None
        if story[0] == "move":
            self.unblock(story[2])
        # as if it had been lifted and set down, which the warehouse knows how to do
        self.warehouse.move(robot, home, robot.heading)
        self.warehouse.lift(robot, pod)
        self.warehouse.reserve(home)
        self.warehouse.store(robot, pod)
        self.warehouse.move(robot, cell, robot.heading)
        self._is_free(robot)

    def take_back_trip(self, robot: Robot, pod: Pod) -> None:
        """Let a pod under way not go to its next station; it is stored."""
        self._abandon(robot, pod)
        self._unbind(robot, pod, self.warehouse.stations[pod.bound_for[0]])
        self.env.process(self.put_away(robot, pod))
        self.settle()

    def store_elsewhere(self, robot: Robot, pod: Pod) -> None:
        """Let a pod be stored in another cell; the one that it was to be stored in stays reserved."""
        self._abandon(robot, pod)
        self.env.process(self.put_away(robot, pod))
        self.settle()

    def take_back_move(self, robot: Robot) -> None:
        """Let a robot that was sent somewhere stay where it is."""
        self._abandon(robot, None)
        self.warehouse.send(robot, None)
        self._is_free(robot)

    def take_back_part(self, order: Order, station: Station, period: int) -> None:
        """Let a part of an order not be picked at a station; no rule is shown the order."""
        part = order.part_of(station.id, period)
        if part is None or part.unpicked_items < part.items:
            raise ContradictionError(f'order "{order.name}" is begun, and picked on')
        self._uncover(station, lambda one: one.part is part and one.pod is not None)
        self.warehouse.unassign(part)
        self.corrected[0].add(order.id)
        self.hidden[order.id] = order
        self._show(other for other in self.warehouse.backlog if other is not order)
        for pod in station.inbound_pods:
            self.warehouse.promises.promise_items(pod, station)
            self._check_pick(pod)

    def rescue(self, robot: Robot, pod: Pod, cell: int) -> None:
        """Let a pod that a robot carries stand in a storage location: somebody has brought it there."""
        warehouse, story = self.warehouse, self.stories[robot.id]
        goal = story[2] if story[0] in ("store", "move") else None
        if cell != goal:
            self.block(cell)
        self._abandon(robot, pod)
        for station in pod.bound_for:
            self._unbind(robot, pod, warehouse.stations[station])
        if goal is not None and cell != goal:
            self.unblock(goal)
        at = robot.cell
        warehouse.move(robot, cell, robot.heading)
        warehouse.store(robot, pod)
        self._tell(PodStored(self.now, self.now, robot=robot.id, pod=pod.id, cell=cell))
        warehouse.move(robot, at, robot.heading)
        self._is_free(robot)

    def _abandon(self, robot: Robot, pod: Pod | None) -> None:
        """End a robot's story, and give back the slot that it has in a station's line."""
        kinds = [kind for kind, who in self.waits if who == robot.id and kind != "release"]
        ended = [self.waits.pop((kind, robot.id)).event for kind in kinds]
        for line in self.waiting_for_slot:
            for one in [one for one in line if one[1] is robot]:
                line.remove(one)
                ended.append(one[0])
        for event in ended:
            event.fail(AbandonedError())
        self.settle()
        if pod is not None and pod.bound_for and self.stories[robot.id][0] == "transport":
            station = self.warehouse.stations[pod.bound_for[0]]
            if {"lift", "queue", *AT_STATION} & {*kinds}:
                self._give_slot(station)
            if {"pick", "stow"} & {*kinds}:
                self.warehouse.occupy_picker(station, self.now)

    def _give_slot(self, station: Station) -> None:
        if waiting := self.waiting_for_slot[station.id]:
            waiting.pop(0)[0].succeed()
        else:
            self.warehouse.give_up_slot(station)

    def _unbind(self, robot: Robot, pod: Pod, station: Station) -> None:
        """Let a pod not be bound for a station; what it promised there is uncovered."""
        self._uncover(station, lambda one: one.pod is pod)
        if robot not in station.line:
            self.warehouse.join_line(robot, station)
        self.warehouse.leave(robot, pod, station)
        if any(bundle.station == station.id for bundle in pod.bundles):  # they have its space, and are stored later
            self.warehouse.bind(pod, station)

    def _uncover(self, station: Station, which: Callable[[Request], bool]) -> None:
        """Take back what was promised to requests of a station."""
        while (one := next(filter(which, station.open_requests), None)) is not None:
            self.warehouse.promises.withdraw(one)
