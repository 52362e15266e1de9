"""The facts of a simulated run, as a floor would send them to a session, and what the run decided."""

from collections.abc import Iterator
from typing import Any

from attrs import asdict

from rmfs import events
from rmfs_core.clock import to_seconds
from rmfs_core.hookspecs import hookimpl
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import load_scenario
from rmfs_core.simulation.engine import Simulation
from rmfs_core.world import make_instance, make_layout

DECISIONS = (
    *(events.OrderAssigned, events.TripDecided, events.TaskAssigned, events.VisitStarted, events.VisitEnded),
    *(events.ItemPicked, events.PodStored, events.BundleAssigned, events.BundleBound, events.OrderInStock),
    *(events.PackingAssigned, events.OrderConsolidated, events.PackingStarted, events.OrderPacked),
    *(events.RobotSent, events.PodMoveDecided, events.OrderCancelled, events.OrderCompleted),
)


class Log:
    """Observer that keeps what is decided, and what follows, in order; times are those at which it was so."""

    def __init__(self) -> None:
        self.rows: list[tuple[Any, ...]] = []

    @hookimpl
    def on_event(self, event: events.Event) -> None:
        if isinstance(event, DECISIONS):
            told = {
                name: value for name, value in asdict(event).items() if name not in ("start_tick", "picker_free_tick")
            }
            self.rows.append((type(event).__name__, *told.values()))
        elif isinstance(event, events.DecisionMade):
            told = asdict(event)
            self.rows.append(("DecisionMade", *(v for k, v in told.items() if not k.endswith("_s"))))


class Told(Simulation):
    """A run that keeps facts of its floor in the order in which they happened."""

    def __init__(self, path: str, overrides: tuple[str, ...] = ()) -> None:
        scenario = load_scenario(path, overrides)
        rules = RuleSet.load(scenario.rules, scenario.folder)
        instance, self.log = make_instance(scenario), Log()
        for observer in (self, self.log):
            rules.register_observer(observer)
        self.facts: list[tuple[int, dict[str, Any]]] = []
        self.charging: set[int] = set()
        super().__init__(scenario, instance, make_layout(scenario), rules)

    def _fact(self, kind: str, **fields: Any) -> None:
        self.facts.append((self.now, {"id": str(len(self.facts)), "kind": kind, **fields}))

    def _is_free(self, robot: Any) -> None:
        if robot.id in self.charging:
            self.charging.remove(robot.id)
            self._fact("robot_charged", robot=robot.name)
        super()._is_free(robot)

    def _release(self, request: Any, handled_tick: int) -> None:
        self._fact("handled", station=self.warehouse.stations[request.station].name)
        super()._release(request, handled_tick)

    @hookimpl
    def on_event(self, event: events.Event) -> None:  # noqa: PLR0912
        data, skus = self.info.instance.orders, self.info.instance.skus
        pods, stations = self.warehouse.pods, self.warehouse.stations
        match event:
            case events.OrderArrived():
                order = data[event.order]
                due = {} if order.due_tick is None else {"due_s": to_seconds(order.due_tick)}
                lines = {skus[sku]: number for sku, number in order.lines}
                self._fact("order_arrived", order=order.name, lines=lines, priority=order.priority, **due)
            case events.OrderCancelled() | events.OrderPacked():
                kind = "order_cancelled" if isinstance(event, events.OrderCancelled) else "order_packed"
                self._fact(kind, order=data[event.order].name)
            case events.RobotMoved():
                robot = self.warehouse.robots[event.robot]
                charge = {} if robot.charge is None else {"charge": robot.charge}
                self._fact("robot_at", robot=robot.name, cell=event.to, heading=event.heading, **charge)
            case events.RobotRested():
                robot = self.warehouse.robots[event.robot]
                if self.warehouse.ticks_to_charge(robot, self.stories[robot.id][2]):
                    self.charging.add(robot.id)
            case events.PodLifted():
                self._fact("pod_lifted", pod=pods[event.pod].name)
            case events.QueueJoined():
                self._fact("pod_queued", pod=pods[event.pod].name, station=stations[event.station].name)
            case events.VisitStarted():
                self._fact("pod_at_station", pod=pods[event.pod].name, station=stations[event.station].name)
            case events.ItemPicked():
                self._fact("picked", pod=pods[event.pod].name, order=data[event.order].name, sku=skus[event.sku])
            case events.PodStored():
                self._fact("pod_stored", pod=pods[event.pod].name, cell=event.cell)
            case events.PartArrived() | events.PartPut():
                self._fact("part_arrived" if isinstance(event, events.PartArrived) else "part_packed", tote=event.tote)
            case events.BundleArrived():
                self._fact("bundle_arrived", bundle=event.name, sku=skus[event.sku], items=event.items)
            case events.BundleStored():
                name = str(event.bundle + 1)
                self._fact("bundle_stored", pod=pods[event.pod].name, bundle=name)

    def batches(self) -> Iterator[dict[str, Any]]:
        """Yield what a floor sends: orders that come at a time together, all else by itself."""
        after, at = 0, 0
        while at < len(self.facts):
            tick, first = self.facts[at]
            end = at + 1
            if first["kind"].startswith("order_"):
                while (
                    end < len(self.facts)
                    and self.facts[end][0] == tick
                    and self.facts[end][1]["kind"].startswith("order_")
                ):
                    end += 1
            yield {"after": after, "time_s": to_seconds(tick), "events": [fact for _, fact in self.facts[at:end]]}
            after, at = after + 1, end
