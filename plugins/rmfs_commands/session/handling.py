"""Facts, each by its kind: what they change, or contradict; what is in doubt since then."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

from rmfs_commands.session.correcting import CorrectedFloor
from rmfs_commands.session.facts import ContradictionError
from rmfs_commands.session.floor import AWAITED
from rmfs_commands.session.packing import FloorPacking
from rmfs_core.clock import to_ticks
from rmfs_core.warehouse import UNLIMITED, Order, Pod, Robot, Station
from rmfs_core.world import CellKind, Instance, Layout, OrderData


class Handling:
    """Facts that change a floor; each method that handles a kind says whether rules have something to decide then."""

    _instance: Instance
    _layout: Layout
    _floor: CorrectedFloor

    def _begin_to_handle(self) -> None:
        """Let nothing be in doubt, on a floor that is new."""
        warehouse = self._floor.warehouse
        self._doubtful: dict[tuple[str, str], str] = {}
        self._passing: set[str] = set()  # pods that are in doubt until their robot is heard of
        self._given: OrderedDict[int, dict[str, Any]] = OrderedDict()  # commands that can be refused
        self._failed: set[str] = set()
        self._heard: dict[int, int] = {}
        self._skus = {name: i for i, name in enumerate(self._instance.skus)}
        self._orders: dict[str, Order] = {}
        self._by_name: dict[str, dict[str, Any]] = {
            "pod": {pod.name: pod for pod in warehouse.pods},
            "robot": {robot.name: robot for robot in warehouse.robots},
            "station": {station.name: station for station in warehouse.stations},
        }

    # What is out of order

    def _doubt(self, concern: tuple[str, str], why: str) -> None:
        """Keep what a contradiction concerns, and offer it to no rule."""
        if concern in self._doubtful:
            return
        kind, name = concern
        one: Any = self._orders.get(name) if kind == "order" else self._by_name.get(kind, {}).get(name)
        if one is not None:
            self._doubtful[concern] = why
            match kind:
                case "robot":
                    self._floor.warehouse.put_in_service(one, False)
                case "pod":
                    self._floor.lock(one)
                case "station":
                    self._floor.close(one, True)
                case _:
                    self._floor.hide(one)

    def _trust(self, kind: str, name: str) -> None:
        """Let rules have again what was in doubt."""
        if self._doubtful.pop((kind, name), None) is not None:
            match kind:
                case "pod":
                    self._floor.unlock(self._by_name["pod"][name])
                    self._passing.discard(name)
                case "station":
                    self._floor.close(self._by_name["station"][name], False)
                case "order":
                    self._floor.unhide(self._orders[name])

    def _held(self, kind: str, name: str) -> dict[str, Any]:
        """Return what a pod in doubt holds, which the state does not show."""
        if kind != "pod":
            return {}
        held, _ = self._floor.locked[self._by_name["pod"][name].id]
        skus = self._instance.skus
        return {"contents": {skus[sku]: None if items >= UNLIMITED else items for sku, items in held.items()}}

    def _hear(self, robot: Robot) -> None:
        """Take note that a robot is heard of: its pod is in doubt no more, if it was for that."""
        self._heard[robot.id] = self._floor.now
        if robot.task is not None and robot.name not in self._failed:
            pod = self._floor.warehouse.pods[robot.task].name
            if pod in self._passing:
                self._trust("pod", pod)

    # Facts, each by its kind

    def _named(self, kind: str, name: str) -> Any:
        if (found := self._by_name[kind].get(name)) is None:
            raise ContradictionError(f'there is no {kind} "{name}"')
        return found

    def _sku(self, name: str) -> int:
        if name not in self._skus:
            raise ContradictionError(f'there is no SKU "{name}"')
        return self._skus[name]

    def _carried(self, pod: str) -> tuple[Pod, Robot]:
        found: Pod = self._named("pod", pod)
        if found.robot is None:
            raise ContradictionError(f'pod "{pod}" is no robot\'s task', ("pod", pod))
        robot = self._floor.warehouse.robots[found.robot]
        self._hear(robot)
        return found, robot

    def _awaited(self, robot: Robot, kind: str, what: str, pod: str) -> Any:
        """Return what the story of a robot waits for, if it is this."""
        waits = self._floor.waits
        if (wait := waits.get((kind, robot.id))) is None:
            others = [AWAITED[one] for one, who in waits if who == robot.id and one != "release"]
            then = f"expected {others[0]} first" if others else "expected nothing of it"
            raise ContradictionError(f"{what}; {then}", ("pod", pod), ("robot", robot.name))
        return wait.what

    def _order_arrived(
        self, order: str, lines: Mapping[str, int], due_s: float | None = None, priority: int = 0
    ) -> bool:
        if order in self._orders:
            raise ContradictionError(f'order "{order}" has arrived before', ("order", order))
        given = tuple((self._sku(sku), number) for sku, number in lines.items())
        due = None if due_s is None else to_ticks(due_s)
        data = OrderData(order, arrival_tick=self._floor.now, lines=given, due_tick=due, priority=priority)
        self._orders[order] = self._floor.add_order(data)
        self._floor.arrive(self._orders[order])
        return True

    def _order_cancelled(self, order: str) -> bool:
        if (found := self._orders.get(order)) is None:
            raise ContradictionError(f'there is no order "{order}"')
        if found.cancelled or found.complete:
            raise ContradictionError(f'order "{order}" is {"cancelled" if found.cancelled else "complete"} already')
        if found.parts:
            raise ContradictionError(f'order "{order}" is begun, and picked on')
        self._trust("order", order)
        if self._floor.withdraw(found):
            del self._orders[order]
            return True
        return self._floor.cancel(found)

    def _robot_at(self, robot: str, cell: int, heading: int | None = None, charge: float | None = None) -> None:
        found: Robot = self._named("robot", robot)
        kinds = self._layout.kind
        if cell >= len(kinds) or kinds[cell] == CellKind.WALL:
            raise ContradictionError(f"robot {robot} cannot stand in cell {cell}", ("robot", robot))
        self._hear(found)
        self._floor.drive(found, cell, found.heading if heading is None else heading, charge)

    def _robot_charged(self, robot: str) -> None:
        found: Robot = self._named("robot", robot)
        if ("charge", found.id) not in self._floor.waits:
            raise ContradictionError(f"robot {robot} is not to be charged now", ("robot", robot))
        self._hear(found)
        self._floor.charged(found)

    def _stands(self, robot: Robot, cell: Any) -> None:
        """Let a robot be where it lifts its pod or sets it down, if a late fact had it elsewhere."""
        if robot.cell != cell:
            self._floor.drive(robot, cell, robot.heading)

    def _pod_lifted(self, pod: str) -> None:
        found, robot = self._carried(pod)
        self._awaited(robot, "lift", f'pod "{pod}" is not to be lifted now', pod)
        self._stands(robot, found.location)
        self._floor.happens("lift", robot.id)

    def _bound(self, pod: str, station: str) -> tuple[Robot, Station]:
        _, robot = self._carried(pod)
        at: Station = self._named("station", station)
        goal = self._awaited(robot, "queue", f'pod "{pod}" is not on its way to a station', pod)
        if goal != at.id:
            found = self._floor.warehouse.stations[goal].name
            raise ContradictionError(f'pod "{pod}" is bound for station {found}, not for {station}', ("pod", pod))
        return robot, at

    def _pod_queued(self, pod: str, station: str) -> None:
        robot, at = self._bound(pod, station)
        if robot in at.line:
            raise ContradictionError(f'pod "{pod}" stands in the line of station {station} already')
        self._floor.queue(robot, at)

    def _pod_at_station(self, pod: str, station: str) -> None:
        robot, at = self._bound(pod, station)
        if (at.line or (robot,))[0] is not robot:
            first = self._floor.warehouse.robots[at.line[0].id]
            told = f"robot {first.name} is before it at station {station}"
            raise ContradictionError(told, ("pod", pod), ("station", station))
        if not at.line:
            self._floor.queue(robot, at)
        self._floor.happens("queue", robot.id)

    def _picked(self, pod: str, order: str, sku: str) -> None:
        _, robot = self._carried(pod)
        if ("picker", robot.id) in self._floor.waits:
            raise ContradictionError(f'the item before it is not handled yet; pod "{pod}" waits', ("pod", pod))
        self._awaited(robot, "pick", f'nothing is to be picked from pod "{pod}" now', pod)
        number, item = self._floor.wanted[robot.id]
        expected = self._floor.warehouse.orders[number].name, self._instance.skus[item]
        if (order, sku) != expected:
            told = f'SKU "{expected[1]}" for order "{expected[0]}"'
            raise ContradictionError(f'from pod "{pod}" {told} is to be picked', ("order", order), ("pod", pod))
        self._floor.picked(robot)

    def _handled(self, station: str) -> None:
        at: Station = self._named("station", station)
        self._floor.handled(at)

    def _pod_stored(self, pod: str, cell: int) -> bool:
        found, robot = self._carried(pod)
        if robot.name in self._failed and found.location is None:
            self._floor.rescue(robot, found, cell)
            self._trust("pod", pod)
            return True
        self._awaited(robot, "set", f'pod "{pod}" is not to be set down now', pod)
        goal = self._floor.stories[robot.id][2]
        if goal != cell:
            raise ContradictionError(f'pod "{pod}" is to be set down in cell {goal}, not {cell}', ("pod", pod))
        self._stands(robot, goal)
        self._floor.happens("set", robot.id)
        return False

    def _bundle_arrived(self, bundle: str, sku: str, items: int) -> None:
        warehouse = self._floor.warehouse
        if not warehouse.storing:
            raise ContradictionError("no station stores bundles")
        there = (*warehouse.bundles.values(), *(one for at in warehouse.storing for one in at.bundles))
        if any(one.name == bundle for one in there):
            raise ContradictionError(f'bundle "{bundle}" has arrived before, and is not stored yet')
        self._floor.bring(self._sku(sku), items, bundle)

    def _bundle_stored(self, pod: str, bundle: str) -> None:
        found, robot = self._carried(pod)
        self._awaited(robot, "stow", f'no bundle is to be stored on pod "{pod}" now', pod)
        if (expected := self._floor.wanted[robot.id][1]) != bundle:
            raise ContradictionError(f'bundle "{expected}" is to be stored on pod "{pod}"', ("pod", pod))
        station = self._floor.warehouse.stations[found.bound_for[0]]
        self._floor.warehouse.occupy_picker(station, self._floor.now)
        self._floor.happens("stow", robot.id)

    def _robot_failed(self, robot: str) -> bool:
        found: Robot = self._named("robot", robot)
        self._failed.add(robot)
        if found.in_service:
            self._floor.warehouse.put_in_service(found, False)
        if found.task is None:
            return False
        pod = self._floor.warehouse.pods[found.task]
        if pod.location is not None:
            self._floor.take_back_task(found, pod)
        elif ("pod", pod.name) not in self._doubtful:
            self._passing.add(pod.name)
            self._doubt(("pod", pod.name), f"robot {robot} has failed with it")
        return True

    def _robot_back(self, robot: str) -> bool:
        found: Robot = self._named("robot", robot)
        self._failed.discard(robot)
        self._doubtful.pop(("robot", robot), None)
        self._floor.warehouse.put_in_service(found, True)
        self._hear(found)
        return True

    def _station_opened(self, station: str) -> bool:
        self._doubtful.pop(("station", station), None)
        return self._staff(station, True)

    def _station_closed(self, station: str) -> bool:
        return self._staff(station, False)

    def _short(self, pod: str, sku: str, counted: int) -> bool:
        return self._counted(pod, {sku: counted})

    def _stock(self, pod: str, contents: Mapping[str, int]) -> bool:
        found: Pod = self._named("pod", pod)
        known = {self._instance.skus[sku]: 0 for sku in found.contents}
        return self._counted(pod, {**known, **contents})

    def _counted(self, pod: str, contents: Mapping[str, int]) -> bool:
        found: Pod = self._named("pod", pod)
        counted = {self._sku(sku): items for sku, items in contents.items()}
        if self._instance.unlimited_stock:
            raise ContradictionError("the stock of this hall is unlimited, and nothing is counted")
        if strange := [sku for sku in counted if sku not in found.contents]:
            told = f'pod "{pod}" was never given SKU "{self._instance.skus[strange[0]]}"; expected bundle_stored'
            raise ContradictionError(told, ("pod", pod))
        self._trust("pod", pod)
        self._floor.recount(found, counted)
        return True

    def _part_arrived(self, tote: int) -> None:
        self._packs("convey", tote, f"tote {tote} is not on its way to a packing station")

    def _part_packed(self, tote: int) -> None:
        self._packs("put", tote, f"tote {tote} is not being put into a box")

    def _order_packed(self, order: str) -> None:
        found = self._orders.get(order)
        self._packs("pack", -1 if found is None else found.id, f'order "{order}" is not being packed', ("order", order))

    def _packs(self, kind: str, who: int, problem: str, *concerns: tuple[str, str]) -> None:
        packing = self._floor.packing
        if not isinstance(packing, FloorPacking) or not packing.happens(kind, who):
            raise ContradictionError(problem, *concerns)
        self._floor.settle()

    def _pod_locked(self, pod: str) -> bool:
        self._named("pod", pod)
        self._doubt(("pod", pod), "it was locked")
        self._passing.discard(pod)
        return True

    def _pod_unlocked(self, pod: str) -> bool:
        self._named("pod", pod)
        self._trust("pod", pod)
        return True

    def _order_back(self, order: str) -> bool:
        if order not in self._orders:
            raise ContradictionError(f'there is no order "{order}"')
        self._trust("order", order)
        return True

    def _cell_blocked(self, cell: int) -> bool:
        if ("cell", str(cell)) not in self._doubtful:
            self._floor.block(cell)
            self._doubtful["cell", str(cell)] = "it was blocked"
        return True

    def _cell_free(self, cell: int) -> bool:
        if self._doubtful.pop(("cell", str(cell)), None) is not None:
            self._floor.unblock(cell)
        return True

    def _command_refused(self, command: int, why: str) -> bool:
        if (given := self._given.get(command)) is None:
            raise ContradictionError(f"command {command} was not given, or long ago")
        kind, told = given["kind"], f"command {command} ({given['kind']}) was refused: {why}"
        robot: Any = self._by_name["robot"].get(str(given.get("robot")))
        pod: Any = self._by_name["pod"].get(str(given.get("pod")))
        over = ContradictionError(f"command {command} is done, or was taken back")
        match kind:
            case "assign":
                if self._floor.packing is not None:
                    raise ContradictionError("an order that is bound for a packing station cannot be taken back")
                order, station = self._orders.get(given["order"]), self._by_name["station"][given["station"]]
                if order is None or order.id in self._floor.hidden:
                    raise over
                self._floor.take_back_part(order, station, given["part"])
                self._doubt(("order", order.name), told)
            case "fetch" | "lift" | "go_on" | "store" | "move_pod":
                self._take_back(kind, robot, pod, given, over, told)
            case "move_robot":
                if robot.goal != given["cell"]:
                    raise over
                self._floor.take_back_move(robot)
                self._doubt(("robot", robot.name), told)
            case "pick_next":
                if pod.robot is None or self._wanted(pod.robot) != (given["order"], given["sku"]):
                    raise over
                self._doubt(("pod", pod.name), told)
            case _:
                raise ContradictionError(f"{kind} cannot be taken back")
        del self._given[command]
        return True

    def _take_back(
        self, kind: str, robot: Robot, pod: Pod, given: Mapping[str, Any], over: ContradictionError, told: str
    ) -> None:
        floor = self._floor
        story = floor.stories.get(robot.id, ("",))
        lifted, bound = pod.location is None, pod.bound_for[:1]
        if robot.task != pod.id or (kind != "move_pod" and lifted == (kind in ("fetch", "lift"))):
            raise over
        if kind == "go_on":
            if [floor.warehouse.stations[at].name for at in bound] != [given["station"]] or robot.pod is None:
                raise over
            floor.take_back_trip(robot, pod)
        elif kind == "store" or (kind == "move_pod" and lifted):
            if story[-1] != given["cell"]:
                raise over
            floor.store_elsewhere(robot, pod)
            self._doubtful["cell", str(given["cell"])] = told
            return
        else:
            floor.take_back_task(robot, pod)
        self._doubt(("robot", robot.name), told)

    def _wanted(self, robot: int) -> tuple[str, str] | None:
        """Return names of the order and SKU that are to be picked from a robot's pod now."""
        if ("pick", robot) not in self._floor.waits:
            return None
        order, sku = self._floor.wanted[robot]
        return self._floor.warehouse.orders[order].name, self._instance.skus[sku]

    def _staff(self, station: str, staffed: bool) -> bool:
        self._floor.close(self._named("station", station), not staffed)
        return True
