"""Answers of rules, as JSON objects with names."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rmfs_commands.instances.tables import finite
from rmfs_commands.states.names import Names
from rmfs_core.decisions import (
    BundleAssignment,
    BundleDecision,
    JointDecision,
    OrderAssignment,
    PodMove,
    PodTrip,
    RobotMove,
    SolveReport,
    StoreBundle,
    TaskAssignment,
)
from rmfs_core.roles import Role
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import ImpossibleError, instance_of, sequence_of
from rmfs_core.warehouse import Order, Warehouse, WarehouseView


def answer_to_dict(
    warehouse: WarehouseView,
    skus: Sequence[str],
    decides: Role,
    answer: object,
    arguments: Mapping[str, Any] | None = None,
) -> dict[str, Any] | None:
    """Return a rule's answer with names; None when it is nothing that the rule may answer.

    Parameters
    ----------
    warehouse
        As it was when the rule was asked.
    skus
        SKU names by id.
    decides
        Kind of the decision; not PP, a filter or an observer.
    answer
        The rule's answer.
    arguments
        Arguments of its hook besides the warehouse and a random generator; of packing.
    """
    handed = arguments or {}
    try:
        if decides is Role.PACKING:
            return _packing(warehouse, handed["orders"], answer)
        if decides is Role.PACKING_TASK:
            checks.known("task", answer, handed["tasks"])
            return {"task": checks.whole("task", answer)}
        return _WRITERS[decides](warehouse, skus, answer)
    except ImpossibleError:  # a run ends with an error then, which says what was wrong
        return None


def answer_from_dict(warehouse: Warehouse, names: Names, decides: Role, written: Mapping[str, Any]) -> object:
    """Return the answer that `answer_to_dict` wrote, without a report; KeyError for a name that is not there."""
    assignments = tuple(
        OrderAssignment(names.orders[a["order"]], names.stations[a["station"]], tuple(names.skus[s] for s in a["skus"]))
        for a in written.get("assignments", ())
    )
    trips = tuple(PodTrip(names.pods[t["pod"]], names.stations[t["station"]]) for t in written.get("trips", ()))
    robots = {robot.name: robot.id for robot in warehouse.robots}
    at_stations = (bundle for station in warehouse.storing for bundle in station.bundles)
    ids = {bundle.name: bundle.id for bundle in (*warehouse.bundles.values(), *at_stations)}
    bundles = tuple(
        BundleAssignment(ids[b["bundle"]], names.stations[b["station"]]) for b in written.get("bundles", ())
    )
    stores = tuple(StoreBundle(ids[b["bundle"]], names.pods[b["pod"]]) for b in written.get("stores", ()))
    answers = {
        Role.POA: assignments,
        Role.PPS: trips,
        Role.POA_PPS: JointDecision(assignments, trips),
        Role.PR: written.get("cell"),
        Role.TA: tuple(TaskAssignment(robots[t["robot"]], names.pods[t["pod"]]) for t in written.get("tasks", ())),
        Role.ROA: bundles,
        Role.RPS: stores,
        Role.ROA_RPS: BundleDecision(bundles, stores),
        Role.ACTIVATE: tuple(names.stations[station] for station in written.get("active", ())),
        Role.IDLE: tuple(RobotMove(robots[t["robot"]], t["cell"], t.get("charge")) for t in written.get("rests", ())),
        Role.PACKING: tuple(names.packing(p["station"]) for p in written.get("packing", ())),
        Role.PACKING_TASK: written.get("task"),
        Role.MOVE: tuple(PodMove(names.pods[t["pod"]], t["cell"]) for t in written.get("moves", ())),
    }
    return answers[decides]


def report_to_dict(report: SolveReport) -> dict[str, Any]:
    """Return a solve report; numbers that JSON has no word for are left out (null)."""
    return {
        "status": report.status,
        "objective": finite(report.objective),
        "bound": finite(report.bound),
        "stopped_early": report.stopped_early,
    }


def _joint(warehouse: WarehouseView, skus: Sequence[str], answer: object) -> dict[str, Any]:
    decision = instance_of(answer, JointDecision)
    written = {
        "assignments": _assignments(warehouse, skus, decision.assignments),
        "trips": _trips(warehouse, decision.trips),
    }
    if decision.report is not None:
        written["report"] = report_to_dict(instance_of(decision.report, SolveReport))  # type: ignore[assignment]
    return written


def _both(warehouse: WarehouseView, _: Sequence[str], answer: object) -> dict[str, Any]:
    decision = instance_of(answer, BundleDecision)
    written: dict[str, Any] = {
        "bundles": _bundles(warehouse, decision.assignments),
        "stores": _stores(warehouse, decision.stores),
    }
    if decision.report is not None:
        written["report"] = report_to_dict(instance_of(decision.report, SolveReport))
    return written


def _bundles(warehouse: WarehouseView, answer: object) -> list[dict[str, Any]]:
    stations = [*warehouse.stations, *(s for s in warehouse.replenishment_stations if not s.picks)]
    return [
        {
            "bundle": _bundle(warehouse, given.bundle),
            "station": checks.known("station", given.station, stations).name,
        }
        for given in sequence_of(answer, BundleAssignment)
    ]


def _stores(warehouse: WarehouseView, answer: object) -> list[dict[str, Any]]:
    return [
        {
            "bundle": _bundle(warehouse, given.bundle),
            "pod": checks.known("pod", given.pod, warehouse.pods).name,
        }
        for given in sequence_of(answer, StoreBundle)
    ]


def _bundle(warehouse: WarehouseView, identifier: object) -> str:
    """Return the name of a bundle that is not stored."""
    number = checks.whole("bundle", identifier)
    at_stations = (bundle for station in warehouse.replenishment_stations for bundle in station.bundles)
    for bundle in (*warehouse.bundles, *at_stations):
        if bundle.id == number:
            return bundle.name
    raise ImpossibleError(f"named bundle {number}, which is not there")


def _assignments(warehouse: WarehouseView, skus: Sequence[str], answer: object) -> list[dict[str, Any]]:
    written = []
    assigned: set[tuple[int, int]] = set()
    for given in sequence_of(answer, OrderAssignment):
        order = _order(warehouse, given.order)
        station = checks.known("station", given.station, warehouse.stations)
        open_skus = [line.sku for line in order.open_lines if (order.id, line.sku) not in assigned]
        chosen = open_skus if given.skus is None else [checks.whole("SKU id", sku) for sku in given.skus]
        assigned.update((order.id, sku) for sku in chosen)
        lines = [checks.known("SKU", sku, skus) for sku in chosen]
        written.append({"order": order.name, "station": station.name, "skus": lines})
    return written


def _order(warehouse: WarehouseView, identifier: object) -> Order:
    number = checks.whole("order", identifier)
    try:
        return warehouse.order(number)
    except KeyError:
        raise ImpossibleError(f"named order {number}, which has not arrived") from None


def _trips(warehouse: WarehouseView, answer: object) -> list[dict[str, Any]]:
    return [
        {
            "pod": checks.known("pod", given.pod, warehouse.pods).name,
            "station": checks.known("station", given.station, warehouse.stations).name,
        }
        for given in sequence_of(answer, PodTrip)
    ]


def _tasks(warehouse: WarehouseView, _: Sequence[str], answer: object) -> dict[str, Any]:
    tasks = [
        {
            "robot": checks.known("robot", given.robot, warehouse.robots).name,
            "pod": checks.known("pod", given.pod, warehouse.pods).name,
        }
        for given in sequence_of(answer, TaskAssignment)
    ]
    return {"tasks": tasks}


def _active(warehouse: WarehouseView, _: Sequence[str], answer: object) -> dict[str, Any]:
    given = sequence_of(answer, object)
    return {"active": [checks.known("station", station, warehouse.stations).name for station in given]}


def _rests(warehouse: WarehouseView, _: Sequence[str], answer: object) -> dict[str, Any]:
    rests = [
        {
            "robot": checks.known("robot", given.robot, warehouse.robots).name,
            "cell": checks.whole("cell", given.cell),
            **({} if given.charge is None else {"charge": float(given.charge)}),
        }
        for given in sequence_of(answer, RobotMove)
    ]
    return {"rests": rests}


def _moves(warehouse: WarehouseView, _: Sequence[str], answer: object) -> dict[str, Any]:
    moves = [
        {"pod": checks.known("pod", given.pod, warehouse.pods).name, "cell": checks.whole("cell", given.cell)}
        for given in sequence_of(answer, PodMove)
    ]
    return {"moves": moves}


def _packing(warehouse: WarehouseView, orders: Sequence[Order], answer: object) -> dict[str, Any]:
    given = sequence_of(answer, object)
    if len(given) != len(orders):
        raise ImpossibleError("named another number of packing stations than there are orders")
    stations = [checks.known("packing station", named, warehouse.packing_stations).label for named in given]
    pairs = zip(orders, stations, strict=True)
    return {"packing": [{"order": order.name, "station": station} for order, station in pairs]}


_WRITERS: Mapping[Role, Callable[[WarehouseView, Sequence[str], object], dict[str, Any]]] = {
    Role.POA: lambda warehouse, skus, answer: {"assignments": _assignments(warehouse, skus, answer)},
    Role.PPS: lambda warehouse, _, answer: {"trips": _trips(warehouse, answer)},
    Role.POA_PPS: _joint,
    Role.PR: lambda _warehouse, _skus, answer: {"cell": checks.whole("cell", answer)},
    Role.TA: _tasks,
    Role.ROA: lambda warehouse, _, answer: {"bundles": _bundles(warehouse, answer)},
    Role.RPS: lambda warehouse, _, answer: {"stores": _stores(warehouse, answer)},
    Role.ROA_RPS: _both,
    Role.ACTIVATE: _active,
    Role.IDLE: _rests,
    Role.MOVE: _moves,
}
