"""Writing the state in which ``run.until_s`` ends a run: the entry point ``states`` of the group ``rmfs.formats``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rmfs_commands.processes.events import OrderPacked, PackingAssigned, PackingStarted, PartArrived
from rmfs_commands.results.files import AtomicFile, to_json, write_text
from rmfs_commands.states.memory import labelled, memories
from rmfs_commands.states.packed import TASKS, told_of
from rmfs_commands.states.recording import generator_state
from rmfs_commands.states.resuming import going_on
from rmfs_commands.states.snapshots import Snapshots
from rmfs_core.clock import to_seconds
from rmfs_core.errors import InputError
from rmfs_core.events import (
    BundleAssigned,
    Event,
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCancelled,
    OrderCompleted,
    VisitStarted,
)
from rmfs_core.hookspecs import hookimpl
from rmfs_core.scenario import Scenario, located

if TYPE_CHECKING:
    from rmfs_core.simulation.engine import Simulation

COUNTED = "items", "tote", "visit", "picks", "overtaken"
"""Numbers of what is going on that have the same name in a state."""


def saver(path: str | Path, scenario: Scenario) -> Saver:
    """Return what writes the state of a run to a file; InputError where that cannot be."""
    with located(scenario):
        if scenario.run.until_s is None:
            raise InputError(
                "run.until_s", "found none; expected the time at which the run ends and its state is saved"
            )
    file = Path(path)
    if file.is_file() or file.is_dir() or not file.exists():  # to see that it can be written: no pipe or device
        AtomicFile(file).discard()
    return Saver(file)


class Saver:
    """Observer that keeps when orders and bundles were assigned, orders complete or cancelled, and visits began, and
    writes the state.

    Parameters
    ----------
    path
        The file.
    """

    def __init__(self, path: Path) -> None:
        self._path, self.saved = path, False
        self._assigned: dict[int, int] = {}
        self._completed: dict[int, int] = {}
        self._cancelled: dict[int, int] = {}
        self._bundles: dict[int, int] = {}
        self._visits: dict[int, int] = {}
        self._picked: dict[int, ItemPicked] = {}
        self._packing: dict[int, dict[str, Any]] = {}

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Keep when it was."""
        if isinstance(event, ItemPicked):
            self._picked[event.station] = event
        elif isinstance(event, OrderAssigned) and event.complete:
            self._assigned[event.order] = event.tick
        elif isinstance(event, OrderCompleted):
            self._completed[event.order] = event.tick
        elif isinstance(event, OrderCancelled):
            self._cancelled[event.order] = event.tick
        elif isinstance(event, BundleAssigned):
            self._bundles[event.bundle] = event.tick
        elif isinstance(event, VisitStarted):
            self._visits[event.visit] = event.tick
        elif isinstance(event, PackingAssigned):
            self._packing[event.order] = {"bound_s": to_seconds(event.tick), "parts_s": []}
        elif isinstance(event, PartArrived):
            self._packing[event.order]["parts_s"].append(to_seconds(event.tick))
        elif isinstance(event, PackingStarted | OrderPacked):
            began = isinstance(event, PackingStarted)
            self._packing[event.order]["begun_s" if began else "packed_s"] = to_seconds(event.tick)

    def save(self, run: Simulation) -> None:
        """Write the state of a run that stands between two ticks."""
        with located(run.scenario):
            state = self.state(run)
        write_text(self._path, to_json(state, indent=1) + "\n")
        self.saved = True

    def state(self, run: Simulation) -> dict[str, Any]:
        """Return it as JSON's objects, lists and values."""
        snapshots, warehouse, now = Snapshots(run.info), run.warehouse, run.warehouse.now
        for order in warehouse.arrived:
            snapshots.told(OrderArrived(now, order))
        snapshots.look({})
        state = snapshots.state | {"version": 2}
        for order in warehouse.arrived.values():  # with scarce stock, too
            state["orders"][order.name]["waits_for_stock"] = order.waits_for_stock
        names = {order.id: order.name for order in warehouse.orders}
        stations = {station.name: warehouse.picker_free(station) for station in warehouse.stations}
        batteries = {robot.name: warehouse.battery_of(robot) for robot in warehouse.robots}
        services, rules = run.services, run.rules
        state["run"] = {
            "going": [*self._going(run, names)],
            "visits": run.visits,
            "periods": run.context.asker.period,
            "bundles": warehouse.bundles_so_far,
            "assigned_s": {names[order]: to_seconds(tick) for order, tick in self._assigned.items()},
            "completed_s": {names[order]: to_seconds(tick) for order, tick in self._completed.items()},
            "pickers_s": {name: to_seconds(tick) for name, tick in stations.items() if tick > now},
            "joules": {name: (one.joules, to_seconds(one.since)) for name, one in batteries.items() if one is not None},
            "random": {
                label: generator_state(run.context.stream(rule).bit_generator.state) for label, rule in labelled(rules)
            },
            "memory": memories(rules),
        }
        if run.decisions.alarm is not None:
            state["run"]["wakes_s"] = to_seconds(run.decisions.alarm)
        state["run"] |= told_of(run)
        if self._cancelled:
            state["run"]["cancelled_s"] = {names[order]: to_seconds(tick) for order, tick in self._cancelled.items()}
        if bundles := [bundle for station in warehouse.storing for bundle in station.bundles]:
            state["run"]["bundles_s"] = {bundle.name: to_seconds(self._bundles[bundle.id]) for bundle in bundles}
        if run.outages is not None:
            state["run"]["outages"] = run.outages.memory()
        if run.packing is not None:
            state["run"]["packing"] = {names[order]: told for order, told in self._packing.items()}
        if services.begun:
            state["run"]["drawn"] = {" ".join(map(str, what)): number for what, number in services.begun.items()}
            state["run"]["begun"] = {warehouse.stations[at].name: last for at, last in services.last.items()}
        return state

    def _going(self, run: Simulation, names: dict[int, str]) -> Iterator[dict[str, Any]]:
        warehouse, skus = run.warehouse, run.info.instance.skus
        for one in going_on(run):
            told: dict[str, Any] = {"kind": one.kind}
            if one.robot is not None:
                robot = warehouse.robots[one.robot]
                told |= {"robot": robot.name, **_story(run.stories.get(robot.id), robot.task, robot.goal)}
            if one.station is not None and one.kind in (*TASKS, "packers"):
                told["packing"] = warehouse.packing[one.station].label
            elif one.station is not None:
                told["station"] = warehouse.stations[one.station].name
            told |= {} if one.order is None else {"order": names[one.order]}
            told |= {} if one.sku is None else {"sku": skus[one.sku]}
            told |= {name: value for name in COUNTED if (value := getattr(one, name))}
            if one.visit in self._visits:  # not one that was over when the run began, of which an item is in hand
                told["visit_since_s"] = to_seconds(self._visits[one.visit])
            told |= {"since_s": to_seconds(one.since)} if one.since else {}
            told |= {"until_s": to_seconds(one.tick)} if one.tick else {}
            yield told | ({"legs": [[cell, to_seconds(wait)] for cell, wait in one.legs]} if one.legs else {})
        for at, last in self._picked.items():
            if last.picker_free_tick > warehouse.now and warehouse.stations[at].in_hand is None:
                item = {"station": warehouse.stations[at].name, "order": names[last.order], "sku": skus[last.sku]}
                times = {"since_s": to_seconds(last.start_tick), "until_s": to_seconds(last.picker_free_tick)}
                yield {"kind": "handled", **item, **times}


def _story(story: tuple[Any, ...] | None, task: int | None, goal: int | None) -> dict[str, Any]:
    """Return the entries of a robot's story; none for a story that is over."""
    if story is None or (task is None and goal is None):
        return {}
    kind, *what = story
    if kind == "rest":
        return {"story": kind, "cell": what[0], "charge": what[1]}
    return {"story": kind} if kind == "transport" else {"story": kind, "cell": what[1]}
