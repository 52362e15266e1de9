"""Orders on their way to be packed: what a state tells of them, whether it can be, and a run that goes on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from attrs import evolve

from rmfs_commands.processes.events import OrderPacked, PackingAssigned, PackingStarted, PartArrived, PartPut, PartSent
from rmfs_commands.processes.packing import task_ticks
from rmfs_commands.states.names import Names
from rmfs_commands.states.state import PackedState, RunState, State
from rmfs_core import events
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.scenario.model import PackingSection
from rmfs_core.simulation.going import Going
from rmfs_core.warehouse import Order, PackingTask, Warehouse
from rmfs_core.wording import counted

if TYPE_CHECKING:
    from rmfs_core.simulation.engine import Simulation

TASKS = "put", "pack"
KINDS = ("tote", "totes", "conveyor", *TASKS, "packers")
"""Kinds of what is going on between the last pick and a packed order."""


def told_of(run: Simulation) -> dict[str, Any]:
    """Return the keys of a state's `run` that only packing has; none without."""
    packing = run.packing
    if packing is None:
        return {}
    waiting = [task.tote for station in run.warehouse.packing for task in station.tasks if task.kind == "put"]
    return {"totes": packing.number, "puts_s": {str(tote): to_seconds(packing.puts[tote]) for tote in waiting}}


def in_totes(run: Simulation) -> list[Going]:
    """Return the totes at picking stations that take more items."""
    totes = [] if run.packing is None else run.packing.totes
    return [Going("tote", station=at, order=o.id, items=n) for at, tote in enumerate(totes) for o, n in tote.items()]


def check_stations(state: State, section: PackingSection | None, number: int, names: Names) -> None:
    """Check that a state has the scenario's number of packing stations, or tells of none, and its kind of totes."""
    if (told := state.packing) is None:
        return
    if (found := len(told.stations)) != number or section is None:
        names.wrong(("packing", "stations"), f"found {found}; expected the scenario's packing stations: {number}")
    if state.run is not None and told.section.tote != section.tote:
        expected = f'expected the scenario\'s packing.tote = "{section.tote}"'
        names.wrong(("packing", "section", "tote"), f'found "{told.section.tote}"; {expected}')


def fit_packing(warehouse: Warehouse, state: State, names: Names) -> None:
    """Check that orders that are begun are bound for packing stations, and number totes that have no number."""
    if not warehouse.packing:
        return
    for order in warehouse.arrived.values():
        at = order.packing
        if order.parts and at is None:
            expected = "expected the packing station of an order of which a part is assigned"
            names.wrong(("orders", order.name, "packing"), f"is missing; {expected}")
        if at is not None and at.packed and not order.complete:
            names.wrong(("orders", order.name, "packing", "packed"), "found true for an order that is not picked")
    for i, station in enumerate(warehouse.packing):
        if station.free_boxes < 0:
            held, boxes = station.section.boxes - station.free_boxes, station.section.boxes
            expected = f"expected at most the scenario's packing.boxes = {boxes}"
            names.wrong(("packing", "stations", i, "orders"), f"found {held} orders that have a box; {expected}")
    if state.run is None:
        numbered = iter(range(1, 1 << 62))
        for i, station in enumerate(warehouse.packing):
            tasks = tuple(task._replace(tote=next(numbered)) for task in station.tasks)
            working = tuple((task._replace(tote=next(numbered)), end_s) for task, end_s in station.working)
            warehouse.packing[i] = evolve(station, tasks=tasks, working=working)
            for crew, kinds, most in _crews(station.section):
                if (busy := sum(task.kind in kinds for task, _ in working)) > most:
                    names.wrong(
                        ("packing", "stations", i, "working"), f"found {busy} tasks of {crew}; expected at most {most}"
                    )


def _crews(section: PackingSection) -> tuple[tuple[str, Sequence[str], int], ...]:
    """Return who does which tasks, and how many they are."""
    if not section.sorters:
        return (("packers", TASKS, section.packers),)
    return ("sorters", ("put",), section.sorters), ("packers", ("pack",), section.packers)


def on_the_way(warehouse: Warehouse, names: Names) -> list[Going]:
    """Return the totes and tasks of a state that tells no more: totes leave where all is picked, tasks end in time."""
    now, found = warehouse.now, list[Going]()
    for station in warehouse.packing:
        for task, end_s in station.working:
            ends = max(to_ticks(end_s), now + 1)
            since = min(now, ends - to_ticks(task.duration_s))
            found.append(
                Going(task.kind, station=station.id, order=task.order.id, tote=task.tote, since=since, tick=ends)
            )
    for order in warehouse.arrived.values() if warehouse.packing else ():
        if order.packing is None or order.packing.packed:
            continue
        there, released = _at_station(warehouse, order), _released(warehouse, order)
        for at in sorted(released, key=order.has_place_at):  # what is picked where nothing is left came first
            came = min(there, released[at])
            there -= came
            if left := released[at] - came:
                tick = 0 if order.has_place_at(at) else now + 1
                found.append(Going("tote", station=at, order=order.id, items=left, tick=tick))
        if there:
            items = sum(released.values())
            problem = f"found {items + there} items in the box and in tasks; expected at most {items}, which are picked"
            names.wrong(("orders", order.name, "packing"), problem)
        _check_tasks(order, names, warehouse)
    return found


def _released(warehouse: Warehouse, order: Order) -> dict[int, int]:
    """Return how many items of an order each picking station has put into totes."""
    found: Counter[int] = Counter()
    for part in order.parts:
        found[part.station] += part.items - part.unpicked_items
    for station in warehouse.stations:
        if station.in_hand is not None and station.in_hand[0] == order.id:
            found[station.id] -= 1
    return found


def _at_station(warehouse: Warehouse, order: Order) -> int:
    """Return how many items of an order are at its packing station."""
    at = order.packing
    assert at is not None
    kind = "pack" if at.box is None else "put"
    tasks = [task for task in _tasks(warehouse, at.station) if task.order is order and task.kind == kind]
    return at.items_in_box + sum(task.items for task in tasks)


def _tasks(warehouse: Warehouse, at: int) -> list[PackingTask]:
    station = warehouse.packing[at]
    return [*station.tasks, *(task for task, _ in station.working)]


def check_packing(state: State, names: Names, warehouse: Warehouse, going: Sequence[Going]) -> None:
    """Check that every item that was picked is in one place, and that every task that is being done ends.

    Raises
    ------
    InputError
        For the first thing that cannot be.
    """
    told = state.run
    assert told is not None
    for i, one in enumerate(going):
        if one.kind in KINDS:
            _check_one(one, ("run", "going", i), names, warehouse, going)
    for at, station in enumerate(warehouse.packing):
        path = ("packing", "stations", at)
        doing = Counter((one.kind, one.order, one.tote) for one in going if one.kind in TASKS and one.station == at)
        working = Counter((task.kind, task.order.id, task.tote) for task, _ in station.working)
        if doing != working:
            names.wrong((*path, "working"), "expected one entry in `run.going` for each task that is being done")
    waiting = {str(task.tote) for station in warehouse.packing for task in station.tasks if task.kind == "put"}
    if waiting != {*told.puts_s}:
        named = ", ".join(sorted(waiting, key=int)) or "none"
        names.wrong(("run", "puts_s"), f"expected the totes whose items wait to be put into a box: {named}")
    totes = [one.tote for one in going if one.kind == "conveyor"]
    totes += [task.tote for at in range(len(warehouse.packing)) for task in _tasks(warehouse, at) if task.kind == "put"]
    if len({*totes}) < len(totes):
        names.wrong(("run", "going"), "found a tote that is in two places; expected each in one")
    if (largest := max(totes, default=0)) > told.totes:
        names.wrong(("run", "totes"), f"found {told.totes}; expected at least {largest}, the number of a tote")
    for order in warehouse.arrived.values() if warehouse.packing else ():
        if order.packing is not None and not order.packing.packed:
            _check_order(order, names, warehouse, going)
    for name, past in told.packing.items():
        bound = warehouse.orders[names.order(name, "run", "packing", name)].packing
        times = [past.bound_s, *past.parts_s, *(t for t in (past.begun_s, past.packed_s) if t is not None)]
        if bound is None or times != sorted(times) or times[-1] > to_seconds(warehouse.now):
            expected = "expected an order with `packing`, and times up to the state's that follow each other"
            names.wrong(("run", "packing", name), f"found {shown(times)}; {expected}")
        if bound.packed != (past.packed_s is not None):
            expected = "expected it for an order that is packed, and for no other"
            names.wrong(("run", "packing", name, "packed_s"), expected)


def shown(times: Sequence[float]) -> str:
    """Return times as a message shows them."""
    return ", ".join(f"{second:g}" for second in times)


def _check_one(
    one: Going, path: tuple[str | int, ...], names: Names, warehouse: Warehouse, going: Sequence[Going]
) -> None:
    """Check a tote, a task and the like."""
    if not warehouse.packing:
        names.wrong((*path, "kind"), f'found "{one.kind}", but there are no packing stations')
    if one.order is None:
        return
    order = warehouse.orders[one.order]
    if order.packing is None or order.packing.packed:
        which = "is bound for no packing station" if order.packing is None else "is packed"
        names.wrong((*path, "order"), f'names order "{order.name}", which {which}')
    if one.kind == "tote" and one.station is not None:
        by_visit = warehouse.packing[0].section.tote == "visit" and order.split
        left = order.has_place_at(one.station)
        ends = any(o.station == one.station and o.kind == "totes" for o in going) or any(
            o.picks and o.robot is not None and warehouse.robots[o.robot] in warehouse.stations[one.station].line[:1]
            for o in going
        )
        if not one.tick and not (ends if by_visit else left):
            names.wrong((*path, "until_s"), "is missing; expected it for a tote that takes no more items")
        if one.tick and left and not by_visit:
            names.wrong((*path, "until_s"), "found it for a tote that takes more items; expected none")


def _check_order(order: Order, names: Names, warehouse: Warehouse, going: Sequence[Going]) -> None:
    """Check that all items of an order that are picked are in totes, tasks or its box, and that it will be packed."""
    path, at = ("orders", order.name, "packing"), order.packing
    assert at is not None
    moving = sum(one.items for one in going if one.order == order.id and one.kind in ("tote", "conveyor"))
    there, released = _at_station(warehouse, order), sum(_released(warehouse, order).values())
    if moving + there != released:
        found = f"found {moving + there} items in totes, tasks and the box"
        names.wrong(path, f"{found}; expected {released}, which are picked")
    _check_tasks(order, names, warehouse)


def _check_tasks(order: Order, names: Names, warehouse: Warehouse) -> None:
    """Check that an order of which all items are at its packing station is packed, once, and no other."""
    at, there = order.packing, _at_station(warehouse, order)
    assert at is not None
    tasks = [task.kind for task in _tasks(warehouse, at.station) if task.order is order]
    ready = order.complete and there == order.items and (at.box is None or at.items_in_box == order.items)
    for kind, found, most in (
        ("pack", tasks.count("pack"), int(ready)),
        ("put", tasks.count("put"), 0 if at.box is None else tasks.count("put")),
    ):
        if found != most:
            problem = f'found {counted(found, "task")} of kind "{kind}" for it; expected {most}'
            names.wrong(("orders", order.name, "packing"), problem)


def resume_packing(run: Simulation, begun: Any) -> None:
    """Let packing have what it had, before anything goes on."""
    told, packing = begun.state.run or RunState(), run.packing
    if packing is None:
        return
    packing.puts.update({int(tote): to_ticks(put_s) for tote, put_s in told.puts_s.items()})
    tasks = [task for at in range(len(run.warehouse.packing)) for task in _tasks(run.warehouse, at)]
    packing.number = max([told.totes, *(task.tote for task in tasks)])
    for station in run.warehouse.packing:
        for task in station.tasks:
            if task.kind == "put" and task.tote not in packing.puts:
                packing.puts[task.tote] = task_ticks(run.services, station.section, "put", task.order.id, task.items)


def go_on(run: Simulation, going: Going) -> Any:
    """Return the process of something that goes on; a function where there is none, and None for an open tote."""
    packing, warehouse = run.packing, run.warehouse
    assert packing is not None
    if going.kind == "totes":
        return packing.visit_ended(going.station or 0, going.tick)
    if going.kind == "packers":
        return partial(packing.open_later, going.station or 0, going.tick)
    order, at = warehouse.orders[going.order or 0], going.station or 0
    if going.kind == "tote" and not going.tick:
        packing.totes[at][order] = going.items
        return None
    if going.kind == "tote":
        return packing.send(order, going.items, at, going.tick)
    if going.kind == "conveyor":
        return packing.convey(order, going.items, going.tote, going.since, going.tick)
    known = (going.kind, order, going.tote)
    task = next(task for task, _ in warehouse.packing[at].working if task[:3] == known)
    return packing.work(at, task, going.since, going.tick)


def begin_tasks(run: Simulation, going: Sequence[Going]) -> None:
    """Let packers begin what waits, where a scenario has more of them than the state had, or opens a station."""
    told = {one.station for one in going if one.kind == "packers"}
    for station in run.warehouse.packing:
        if run.packing is not None and (station.id not in told or station.hours.at(run.now)):
            run.packing.begin_tasks(station.id)


def packing_events(warehouse: Warehouse, told: RunState, going: Sequence[Going], over: int) -> Iterator[events.Event]:
    """Yield what has happened at packing stations, of each order in the order of time; by ``over`` where not told."""
    known = [warehouse.orders[i] for i in _in_order(warehouse, told)]
    ready = {task.order: to_ticks(task.since_s) for at in warehouse.packing for task in at.tasks if task.kind == "pack"}
    begun = {one.order: one.since for one in going if one.kind == "pack"}
    for station in warehouse.packing:
        ready |= {task.order: to_ticks(task.since_s) for task, _ in station.working if task.kind == "pack"}
    for order in known:
        at = order.packing
        assert at is not None
        one, own = told.packing.get(order.name, PackedState(order.arrival_s)), (order.id, at.station)
        yield PackingAssigned(to_ticks(one.bound_s), *own, at.box)
        parts = one.parts_s or (() if at.first_part_s is None else (at.first_part_s,))
        for tick in map(to_ticks, parts):
            yield PartSent(tick, *own, order.stations[0], 0, 0)
            yield PartArrived(tick, *own, 0, 0)
        if order in ready and at.box is not None:
            yield PartPut(ready[order], ready[order], *own, 0, 0)
        ends = max(over, order.arrival_tick) if one.packed_s is None else to_ticks(one.packed_s)
        begins = to_ticks(one.begun_s) if one.begun_s is not None else begun.get(order.id, ends if at.packed else None)
        if begins is not None:
            yield PackingStarted(begins, *own)
        if at.packed and begins is not None:
            yield OrderPacked(ends, begins, *own)
    for one_going in going:
        if one_going.kind == "conveyor":
            bound = warehouse.packing_of(warehouse.orders[one_going.order or 0]).station
            what = one_going.order or 0, bound, 0, one_going.tote, one_going.items
            yield PartSent(one_going.since, *what)


def _in_order(warehouse: Warehouse, told: RunState) -> Mapping[int, None]:
    """Return the ids of orders that are bound for packing stations, in the order in which that was decided."""
    names = {order.name: order.id for order in warehouse.arrived.values()}
    bound = {names[name]: None for name in told.packing if name in names}
    return bound | {order.id: None for order in warehouse.arrived.values() if order.packing is not None}
