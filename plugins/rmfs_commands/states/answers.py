"""Questions to rules and their answers in states, as JSON objects with names."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from rmfs_commands.instances.tables import finite
from rmfs_commands.processes.packing import apply_packing, next_tasks
from rmfs_commands.states.written import WrittenAnswer
from rmfs_core.clock import to_seconds
from rmfs_core.decisions import (
    BundleAssignment,
    BundleDecision,
    JointDecision,
    Leg,
    OrderAssignment,
    Path,
    PodMove,
    PodTrip,
    RobotMove,
    SolveReport,
    StoreBundle,
    TaskAssignment,
)
from rmfs_core.errors import is_interrupt
from rmfs_core.roles import Role
from rmfs_core.simulation import applying, checks
from rmfs_core.simulation.asking import ImpossibleError, instance_of, sequence_of
from rmfs_core.warehouse import Order, WarehouseView
from rmfs_core.wording import did_you_mean

if TYPE_CHECKING:
    from rmfs_commands.states.rebuilding import OpenState


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
        Kind of the decision; not a filter or an observer.
    answer
        The rule's answer.
    arguments
        Arguments of its hook besides the warehouse and a random generator; of packing and PP.
    """
    handed = arguments or {}
    try:
        if decides is Role.PP:
            return _path(answer)
        if decides is Role.PACKING:
            return _packing(warehouse, handed["orders"], answer)
        if decides is Role.PACKING_TASK:
            checks.known("task", answer, handed["tasks"])
            return {"task": checks.whole("task", answer)}
        return _WRITERS[decides](warehouse, skus, answer)
    except BaseException as error:  # whatever objects of the answer raise: a run ends with an error then, which says it
        if is_interrupt(error):
            raise
        return None


def given_in(opened: OpenState, role: Role) -> dict[str, Any]:
    """Return what a hook is given in a state besides the warehouse and the random generator; not of PP."""
    asked, warehouse = opened.state.ask, opened.warehouse
    if role in (Role.PPS, Role.RPS, Role.ROA_RPS):
        fetches = asked.max_fetches
        if fetches is None and (opened.state.robots is None or asked.role is Role.POA_PPS):
            fetches = len(opened.view.free_pods)  # no robots are told of, or the trips may wait for them
        if fetches is None:
            fetches = max(len(opened.view.idle_robots) - len(warehouse.waiting), 0)
        return {"max_fetches": fetches}
    if role is Role.MOVE:
        idle = max(len(opened.view.idle_robots) - len(warehouse.waiting), 0)
        if asked.max_moves is not None and asked.max_moves > idle:
            expected = f"expected at most {idle}, the number of idle robots that no pod waits for"
            opened.names.wrong(("ask", "max_moves"), f"found {asked.max_moves}; {expected}")
        most = max(min(idle, warehouse.spare_locations), 0)
        return {"max_moves": most if asked.max_moves is None else asked.max_moves}
    if role in (Role.PACKING, Role.PACKING_TASK):
        return _packing_in(opened, role)
    if role is Role.PR:
        if asked.pod is None:
            opened.names.wrong(("ask", "pod"), "is missing; expected the pod to store")
        pod = warehouse.pods[opened.names.pod(asked.pod, "ask", "pod")]
        if pod.location is not None:
            opened.names.wrong(("ask", "pod"), f'pod "{asked.pod}" is stored; expected one that a robot carries')
        return {"pod": pod}
    return {}


def _packing_in(opened: OpenState, role: Role) -> dict[str, Any]:
    """Return the orders to be bound for packing stations; or the station where a packer is free, and its tasks."""
    asked, warehouse, names = opened.state.ask, opened.warehouse, opened.names
    if not warehouse.packing:
        names.wrong(("packing",), "is missing; expected the packing stations")
    if role is Role.PACKING:
        orders = [order for order in warehouse.orders if order.parts and order.packing is None]
        if asked.orders is not None:
            orders = [warehouse.orders[names.order(one, "ask", "orders", i)] for i, one in enumerate(asked.orders)]
        for order in orders:
            if not order.parts or order.packing is not None:
                why = "is bound for a packing station" if order.parts else "has no part that is assigned"
                names.wrong(("ask", "orders"), f'names order "{order.name}", which {why}')
        return {"orders": tuple(orders)}
    at = next((station.id for station in warehouse.packing if next_tasks(station)), 0)
    station = warehouse.packing[at if asked.station is None else names.packing(asked.station, "ask", "station")]
    if not (tasks := next_tasks(station)):
        names.wrong(("ask", "station"), f"no packer is free for a task at packing station {station.label}")
    return {"station": station, "tasks": tasks}


def forget(*_: object) -> None:
    """Nobody is told, and no robot sets off: the state is only looked at."""


class Ids(Protocol):
    """Ids by the names that an answer uses."""

    pods: dict[str, int]
    stations: dict[str, int]
    orders: dict[str, int]
    skus: dict[str, int]


def answer_from(written: WrittenAnswer, decides: Role, warehouse: WarehouseView, ids: Ids) -> object:
    """Return what a rule would have returned whose answer is written.

    Parameters
    ----------
    written
        The answer, without its report.
    decides
        Decision that was asked for.
    warehouse, ids
        Where, and what the names stand for there.

    Raises
    ------
    ImpossibleError
        For a name that is not there, or a decision without an answer.
    """
    return _READERS[decides](written, warehouse, ids)


def _assignments_from(written: WrittenAnswer, ids: Ids) -> tuple[OrderAssignment, ...]:
    return tuple(
        OrderAssignment(
            _id("order", one.order, ids.orders),
            _id("station", one.station, ids.stations),
            None if one.skus is None else tuple(_id("SKU", sku, ids.skus) for sku in one.skus),
        )
        for one in written.assignments
    )


def _trips_from(written: WrittenAnswer, ids: Ids) -> tuple[PodTrip, ...]:
    return tuple(
        PodTrip(_id("pod", one.pod, ids.pods), _id("station", one.station, ids.stations)) for one in written.trips
    )


def _bundles_from(written: WrittenAnswer, warehouse: WarehouseView, ids: Ids) -> tuple[BundleAssignment, ...]:
    named = _bundles_there(warehouse)
    return tuple(
        BundleAssignment(_id("bundle", one.bundle, named), _id("station", one.station, ids.stations))
        for one in written.bundles
    )


def _stores_from(written: WrittenAnswer, warehouse: WarehouseView, ids: Ids) -> tuple[StoreBundle, ...]:
    named = _bundles_there(warehouse)
    return tuple(StoreBundle(_id("bundle", one.bundle, named), _id("pod", one.pod, ids.pods)) for one in written.stores)


def _robots(warehouse: WarehouseView) -> dict[str, int]:
    return {robot.name: robot.id for robot in warehouse.robots}


def _bundles_there(warehouse: WarehouseView) -> dict[str, int]:
    at_stations = (bundle for station in warehouse.replenishment_stations for bundle in station.bundles)
    return {bundle.name: bundle.id for bundle in (*warehouse.bundles, *at_stations)}


def _id(kind: str, name: str, ids: Mapping[str, int]) -> int:
    if name not in ids:
        raise ImpossibleError(f'named {kind} "{name}", which is not there{did_you_mean(name, ids)}')
    return ids[name]


def _given(key: str, value: int | None) -> int:
    if value is None:
        raise ImpossibleError(f"answered without `{key}`; expected a whole number")
    return value


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
    for name, known in _bundles_there(warehouse).items():
        if known == number:
            return name
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


def _path(answer: object) -> dict[str, Any]:
    """Return a path; without legs where the rule finds none, and where the robot is there already."""
    legs = () if answer is None else [instance_of(leg, Leg) for leg in instance_of(answer, Path).legs]
    waits = [to_seconds(checks.whole("wait_ticks", leg.wait_ticks)) for leg in legs]
    cells = [checks.whole("cell", leg.to) for leg in legs]
    return {"legs": [{"cell": cell, "wait_s": wait_s} for cell, wait_s in zip(cells, waits, strict=True)]}


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

_READERS: Mapping[Role, Callable[[WrittenAnswer, WarehouseView, Ids], object]] = {
    Role.POA: lambda written, _, ids: _assignments_from(written, ids),
    Role.PPS: lambda written, _, ids: _trips_from(written, ids),
    Role.POA_PPS: lambda written, _, ids: JointDecision(_assignments_from(written, ids), _trips_from(written, ids)),
    Role.PR: lambda written, _warehouse, _ids: _given("cell", written.cell),
    Role.TA: lambda written, warehouse, ids: tuple(
        TaskAssignment(_id("robot", one.robot, _robots(warehouse)), _id("pod", one.pod, ids.pods))
        for one in written.tasks
    ),
    Role.ROA: _bundles_from,
    Role.RPS: _stores_from,
    Role.ROA_RPS: lambda *given: BundleDecision(_bundles_from(*given), _stores_from(*given)),
    Role.ACTIVATE: lambda written, _, ids: tuple(_id("station", one, ids.stations) for one in written.active),
    Role.IDLE: lambda written, warehouse, _: tuple(
        RobotMove(_id("robot", one.robot, _robots(warehouse)), one.cell, one.charge) for one in written.rests
    ),
    Role.MOVE: lambda written, _, ids: tuple(PodMove(_id("pod", one.pod, ids.pods), one.cell) for one in written.moves),
    Role.PACKING: lambda written, warehouse, _: tuple(
        _id("packing station", one.station, {station.label: station.id for station in warehouse.packing_stations})
        for one in written.packing
    ),
    Role.PACKING_TASK: lambda written, _warehouse, _ids: _given("task", written.task),
}

APPLIED: Mapping[Role, Callable[..., object]] = {
    Role.PR: lambda warehouse, answer, pod: checks.storage_location(warehouse, pod, answer),
    Role.TA: partial(applying.apply_tasks, keep=forget, start=forget),
    Role.ACTIVATE: partial(applying.apply_activation, keep=forget),
    Role.IDLE: partial(applying.apply_rests, keep=forget, start=forget),
    Role.MOVE: partial(applying.apply_moves, keep=forget, start=forget),
    Role.PACKING: partial(apply_packing, keep=forget),
    Role.PACKING_TASK: lambda _, answer, tasks, **_given: checks.known("task", answer, tasks),
}
"""How decisions without an `Outcome` are checked and applied: functions of warehouse, answer, hook's arguments."""

ARGUMENTS: Mapping[str, Callable[[Any], object]] = {
    "max_fetches": int,
    "max_moves": int,
    "pod": lambda pod: pod.name,
    "orders": lambda orders: [order.name for order in orders],
    "station": lambda station: station.label,
}
"""How arguments of hooks are written, under their names, in ``ask``."""
