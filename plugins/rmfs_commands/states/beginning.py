"""A run that begins in a state: the entry point ``state`` of the group ``rmfs.processes``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import evolve, frozen

from rmfs_commands.cli.map_drawing import draw_map
from rmfs_commands.states.deciding import restored_generator
from rmfs_commands.states.mementos import memento_of, time_of
from rmfs_commands.states.memory import labelled, remind
from rmfs_commands.states.names import Names
from rmfs_commands.states.opening import opening_events
from rmfs_commands.states.packed import TASKS, check_stations, fit_packing
from rmfs_commands.states.plain import Memento, PackingMemento, RobotMemento
from rmfs_commands.states.rebuilding import layout_of
from rmfs_commands.states.restoring import ContradictionError, restore
from rmfs_commands.states.resuming import resume
from rmfs_commands.states.state import LayoutState, PodState, RunState, State
from rmfs_commands.states.state_json import read_json, state_from_dict
from rmfs_commands.states.under_way import under_way
from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.entrypoints import process
from rmfs_core.errors import InputError
from rmfs_core.events import Event
from rmfs_core.scenario import Scenario
from rmfs_core.simulation.going import Going
from rmfs_core.simulation.setup import Opening, open_warehouse
from rmfs_core.warehouse import Station, Warehouse
from rmfs_core.world import NORTH, Instance, Layout, OrderData

MOST_S = 100_000_000
"""Seconds, three years, that a state may be later than time 0: seconds since 1970 are too many to count hours in."""


@frozen(eq=False)
class Begun:
    """The middle of a run, in which another begins.

    Parameters
    ----------
    scenario
        The scenario, whose metrics count from the state's time on.
    instance
        The orders of the state, and later ones; pods with what is on them.
    opening
        The warehouse as it is.
    state, names
        State as read, and its names.
    going, stories
        Processes under way, and tasks of robots: kind, pod or cell, and so on.
    """

    scenario: Scenario
    instance: Instance
    opening: Opening
    state: State
    names: Names
    going: Sequence[Going]
    stories: Mapping[int, tuple[Any, ...]]

    @property
    def decided(self) -> bool:
        """Whether rules have decided all that they can at this time."""
        return self.state.run is not None

    @property
    def visits(self) -> int:
        """Visits so far."""
        return 0 if self.state.run is None else self.state.run.visits

    @property
    def periods(self) -> int:
        """Periods so far."""
        parts = (part.period for order in self.opening.warehouse.arrived.values() for part in order.parts)
        return max(parts, default=0) if self.state.run is None else self.state.run.periods

    @property
    def wakes(self) -> int | None:
        """Tick at which rules want to be woken up."""
        told = self.state.run
        return None if told is None or told.wakes_s is None else to_ticks(told.wakes_s)

    def tell(self, tell: Callable[[Event], None]) -> None:
        """Tell observers how things came to be as they are."""
        for event in opening_events(self.opening.warehouse, self.state, self.names, self.stories, self.going):
            tell(event)

    def resume(self, run: Any) -> None:
        """Let a run go on."""
        resume(run, self)

    def recall(self, run: Any) -> None:
        """Give rules and services what they had: random generators, what they remember, what was drawn."""
        if (told := self.state.run) is None:
            return
        rules = dict(labelled(run.rules))
        for label, random in told.random.items():
            if label in rules:
                run.context.stream(rules[label]).bit_generator.state = restored_generator(random).bit_generator.state
        remind(run.rules, told.memory, run.view, self.names)
        services = run.services
        for what, number in told.drawn.items():
            services.begun[tuple(int(one) if one.isdecimal() else one for one in what.split(" "))] = number
        services.last.update({self.names.stations[name]: tuple(last) for name, last in told.begun.items()})


def read(scenario: Scenario, content: object = None, name: str | None = None) -> tuple[State, str]:
    """Return the state that a scenario names, or that of a ``content``, and what messages call it."""
    if isinstance(content, State) and name is not None:
        return content, name
    path = Path(scenario.folder) / (scenario.instance.state_file or "")
    name = str(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)
    return state_from_dict(read_json(path) if content is None else content, name), name


def begins_at(scenario: Scenario) -> int:
    """Return the tick at which a run of a scenario begins."""
    return 0 if scenario.instance.state_file is None else time_of(read(scenario)[0])


def begin(
    scenario: Scenario, instance: Instance, layout: Layout, content: object = None, name: str | None = None
) -> Begun:
    """Return what a run begins in.

    Parameters
    ----------
    scenario, layout
        Stations, robots and the grid; the state has to fit them.
    instance
        The scenario's own, of which the orders are used that arrive later.
    content, name
        A state, or the same as JSON's objects, lists and values, and what messages call it; None: the one that
        ``instance.state_file`` names.

    Raises
    ------
    InputError
        Where the state is none, contradicts itself, or does not fit the scenario.
    """
    (state, name), fresh = read(scenario, content, name), open_warehouse(scenario, instance, layout)
    names = Names(state, name)
    if not 0 <= (now_s := time_of(state) / TICKS_PER_S) <= MOST_S:
        expected = f"expected seconds since a run's time 0, not more than {MOST_S:,}"
        names.wrong(("time_s",), f"found {now_s:,.10g}; {expected}")
    state = _placed(state, names, fresh.warehouse, layout)
    names = Names(state, name)
    given, later = _orders(state, instance), _later(state, instance, scenario)
    skus = tuple(dict.fromkeys([*names.skus, *(instance.skus if later or instance.levels else ())]))
    memento = _fitting(evolve(memento_of(state, names, layout), skus=skus), state, scenario, fresh, names)
    known = tuple(evolve(one.data, **given[one.data.name]) for one in memento.orders)
    ids = {sku: i for i, sku in enumerate(skus)}
    coming = tuple(evolve(one, lines=tuple((ids[instance.skus[sku]], n) for sku, n in one.lines)) for one in later)
    sizes, levels = _by_sku(skus, instance, names)
    memento = evolve(memento, orders=tuple(map(_with_data, memento.orders, known)), sizes=memento.sizes or sizes)
    instance = evolve(
        instance,
        skus=skus,
        orders=(*known, *coming),
        pods=tuple(p.data for p in memento.pods),
        sizes=sizes,
        levels=levels,
    )
    waits = scenario.rules.wait_for_stock is not False
    makes_battery = _battery(scenario, fresh)
    try:
        warehouse = restore(
            memento, fresh.warehouse.travel, coming, makes_battery, wait_for_stock=waits, restocked=instance.restocked
        )
    except ContradictionError as error:
        names.wrong(names.path(error.path), error.problem)
    fit_packing(warehouse, state, names)
    _complete(warehouse, state, names)
    if not instance.restocked:
        _check_stock(warehouse, memento, coming, names)
    opening = Opening(warehouse, (), fresh.hours, fresh.services)
    begins = warehouse.now + (
        state.run is not None
    )  # rules have decided all that they can at the tick of a run's state
    counted = max(scenario.run.warmup_s or 0, begins / TICKS_PER_S)
    going, stories = under_way(state, names, warehouse, restocked=instance.restocked)
    scenario = evolve(scenario, run=evolve(scenario.run, warmup_s=counted or None))
    until_s = scenario.run.until_s
    if until_s is not None and to_ticks(until_s) <= warehouse.now:
        found = f"found {until_s:g}, but the state is of {warehouse.now / TICKS_PER_S:g} s"
        raise InputError("run.until_s", f"{found}; expected a later time, counted from time 0 as in the state")
    return Begun(scenario, instance, opening, state, names, going, stories)


def _check_stock(warehouse: Warehouse, memento: Memento, coming: Sequence[OrderData], names: Names) -> None:
    """Refuse an order of a SKU that is on no pod: nothing would ever be picked for it."""
    held, skus = {sku for pod in memento.pods for sku, _ in pod.data.contents}, memento.skus
    there = [order for order in warehouse.arrived.values() if not order.cancelled]  # also orders that wait for stock
    wanted = [(order.name, line.sku) for order in there for line in order.open_lines]
    wanted += [(one.order.name, one.sku) for station in warehouse.stations for one in station.open_requests]
    for order, sku in wanted:
        if sku not in held:
            names.wrong(("orders", order, "lines"), f'SKU "{skus[sku]}" is on no pod')
    for one in coming:
        if (lacking := next((sku for sku, _ in one.lines if sku not in held), None)) is not None:
            wants = f'of SKU "{skus[lacking]}", which order "{one.name}" of the scenario wants'
            names.wrong(("pods",), f"found none {wants}; expected the scenario's pods, or other orders")


def _check_capacity(name: str, state: State, own: Station, names: Names) -> None:
    """Refuse a capacity other than the scenario's; a state that a run saved may go on with another."""
    told, unit = state.stations[name], "order_capacity" if own.counts_orders else "item_capacity"
    if state.run is not None or not told.picks or getattr(told, unit) == own.capacity:
        return
    key = "item_capacity" if told.order_capacity is None else "order_capacity"
    expected = f"expected the scenario's stations.{unit} = {own.capacity}"
    names.wrong(("stations", name, key), f"found {getattr(told, key)}; {expected}")


def _with_data(order: Any, data: OrderData) -> Any:
    return evolve(order, data=data)


def _battery(scenario: Scenario, fresh: Opening) -> Any:
    if scenario.robots.battery is None:
        return None
    return process("battery", "robots.battery")(scenario, fresh.warehouse.travel)


def _placed(state: State, names: Names, fresh: Warehouse, layout: Layout) -> State:
    """Return a state with the scenario's grid, and with cells for all pods and robots."""
    if len(state.stations) != len(fresh.stations):
        own_names = ", ".join(f'"{station.name}"' for station in fresh.stations)
        found = f"found {len(state.stations)}; expected the scenario's {len(fresh.stations)}: {own_names}"
        names.wrong(("stations",), found)
    if state.layout is not None:
        told = draw_map(layout_of(state.layout, layout.stations[0].places, names.source))
        if told != draw_map(layout):
            names.wrong(("layout",), "found another grid than the scenario's; expected the same, or none")
    else:
        state = evolve(state, layout=LayoutState(map=tuple(draw_map(layout).splitlines())))
    carried = {pod for station in state.stations.values() for pod in station.line}
    robots = state.robots or {}
    carried |= {
        one.task for one in robots.values() if one.task is not None and state.pods.get(one.task, _NONE).cell is None
    }
    taken = {*state.empty_pods, *state.reserved, *(pod.cell for pod in state.pods.values())}
    free = (cell for cell in dict.fromkeys((*fresh.homes, *layout.storage_locations)) if cell not in taken)
    pods = {}
    for name, pod in state.pods.items():
        if pod.cell is None and name not in carried:
            if (cell := next(free, None)) is None:
                most = f"found {len(state.pods)}; the layout has {len(layout.storage_locations)} storage locations"
                names.wrong(("pods",), f"{most}, {len(taken)} of them taken")
            pods[name] = evolve(pod, cell=cell)
        else:
            pods[name] = pod if pod.cell is not None or pod.home is not None else evolve(pod, home=fresh.homes[0])
    return evolve(state, pods=pods)


_NONE = PodState({})


def _orders(state: State, instance: Instance) -> dict[str, dict[str, Any]]:
    """Return what only the scenario knows of the state's orders, by name."""
    known = {order.name: order for order in instance.orders}
    return {
        name: {"cancelled_tick": order.cancelled_tick, "route": order.route} if (order := known.get(name)) else {}
        for name in state.orders
    }


def _later(state: State, instance: Instance, scenario: Scenario) -> list[OrderData]:
    """Return the scenario's orders that arrive later."""
    now = time_of(state)
    given, refilled = scenario.instance, scenario.instance.arrivals.backlog is not None
    later = [one for one in instance.orders if refilled or one.arrival_tick > now]
    if refilled or given.orders_file is not None:  # an order of that name is the one that the state has
        return [one for one in later if one.name not in state.orders]
    return [evolve(one, name=f"{one.name}*" if one.name in state.orders else one.name) for one in later]


def _by_sku(
    skus: Sequence[str], instance: Instance, names: Names
) -> tuple[tuple[int, ...], tuple[tuple[int, int], ...]]:
    """Return sizes and levels of SKUs; InputError where the scenario has some, but not of all that the state names."""
    ids = {sku: i for i, sku in enumerate(instance.skus)}
    if (instance.sizes or instance.levels) and (unknown := [sku for sku in skus if sku not in ids]):
        names.wrong(("skus",), f'names SKU "{unknown[0]}", of which the scenario has no size or reorder point')
    of = [ids[sku] for sku in skus] if instance.sizes or instance.levels else []
    return tuple(instance.sizes[i] for i in of if instance.sizes), tuple(
        instance.levels[i] for i in of if instance.levels
    )


def _fitting(memento: Memento, state: State, scenario: Scenario, fresh: Opening, names: Names) -> Memento:
    """Return a memento with the stations and robots of the scenario, in the state that is told."""
    stations, robots = fresh.warehouse.stations, fresh.warehouse.robots
    told = []
    for i, (given, own) in enumerate(zip(memento.stations, stations, strict=True)):
        _check_capacity(given.name, state, own, names)
        claimed = given.queue_length + 1 - given.queue_room
        staffed = (True, None) if i not in fresh.hours else (given.staffed, given.changes)
        told.append(
            evolve(
                given,
                capacity=own.capacity,
                counts_orders=own.counts_orders,
                queue_length=own.queue_length,
                queue_room=max(own.queue_length + 1 - claimed, 0),
                bundle_capacity=own.bundle_capacity,
                staffed=staffed[0],
                changes=staffed[1],
                active=given.active if scenario.rules.activate is not None else True,
            )
        )
        if not given.in_service and scenario.stations.outages is None:
            expected = "expected stations.outages in the scenario"
            names.wrong(("stations", given.name, "in_service"), f"found a station that has failed; {expected}")
    found = [_robot(one, scenario, fresh, names) for one in memento.robots]
    if names.tells_robots and len(state.robots or {}) != len(robots):
        names.wrong(
            ("robots",), f"found {len(state.robots or {})}; expected the scenario's robots.count = {len(robots)}"
        )
    if names.tells_robots and len(found) > len(robots):
        tasks = {robot.task for robot in (state.robots or {}).values()}
        name, i, pod = next(
            (name, i, pod) for name, one in state.stations.items() for i, pod in enumerate(one.line) if pod not in tasks
        )
        names.wrong(("stations", name, "line", i), f'names pod "{pod}", which is no robot\'s task')
    taken, number = {one.cell for one in found}, len(robots) - len(found)
    if number < 0:
        names.wrong(("stations",), f"pods in lines need {len(found)} robots; the scenario has {len(robots)}")
    places = [robot.cell for robot in robots if robot.cell not in taken]
    places += [cell for cell in fresh.warehouse.travel.layout.storage_locations if cell not in {*taken, *places}]
    found += [RobotMemento(str(len(found) + 1 + i), places[i], NORTH, None) for i in range(number)]
    charges = scenario.robots.battery
    if memento.chargers_down and (charges is None or charges.charger_outages is None):
        expected = "expected robots.battery.charger_outages in the scenario"
        names.wrong(("chargers_down",), f"found chargers that are out of service; {expected}")
    packing, section = memento.packing, scenario.packing
    check_stations(state, section, len(fresh.warehouse.packing), names)
    if section is not None:
        known = packing or [PackingMemento(section)] * len(fresh.warehouse.packing)
        zeros = [station.hours.zero for station in fresh.warehouse.packing]
        packing = tuple(evolve(one, section=section, zero=zero) for one, zero in zip(known, zeros, strict=True))
    return evolve(memento, stations=tuple(told), robots=tuple(found), packing=packing)


def _robot(robot: RobotMemento, scenario: Scenario, fresh: Opening, names: Names) -> RobotMemento:
    """Return a robot as the scenario has robots."""
    if not (robot.in_service or scenario.robots.failures or scenario.robots.maintenance):
        expected = "expected robots.failures or robots.maintenance in the scenario"
        names.wrong(("robots", robot.name, "in_service"), f"found a robot that is out of service; {expected}")
    if robot.cell < 0:
        names.wrong(("robots", robot.name, "cell"), "is missing; expected the cell where it stands")
    robot = robot if None in fresh.hours else evolve(robot, on_duty=True)
    return robot if scenario.robots.battery is not None else evolve(robot, charge=None, low=False)


def _complete(warehouse: Warehouse, state: State, names: Names) -> None:
    """Tell what no memento has: what is in batteries, until when pickers are busy, how many bundles there were."""
    told, robots, now_s = state.run or RunState(), state.robots or {}, warehouse.now / TICKS_PER_S
    known = {robot.name: robot for robot in warehouse.robots}
    for name, (_, since_s) in told.joules.items():
        if name not in known:
            names.wrong(("run", "joules", name), f'names robot "{name}", which the state does not list')
        if since_s > now_s:
            names.wrong(("run", "joules", name), f"found {since_s:g}, which is later than the state's time")
    orders = {name: order.arrival_s for name, order in state.orders.items()}
    bundles = {bundle.name: bundle.arrival_s for bundle in state.bundles or ()}
    for key, kind, arrived in (
        *((key, "order", orders) for key in ("assigned_s", "completed_s", "cancelled_s")),
        ("bundles_s", "bundle", bundles),
    ):
        for name, at_s in getattr(told, key).items():
            if name not in arrived:
                names.wrong(("run", key, name), f'names {kind} "{name}", which the state does not list')
            if not arrived[name] <= at_s <= now_s:
                expected = f"expected a time from the {kind}'s arrival to the state's, {now_s:g}"
                names.wrong(("run", key, name), f"found {at_s:g}; {expected}")
    for robot in warehouse.robots:
        if (battery := warehouse.battery_of(robot)) is not None:
            given = robots.get(robot.name)
            share = 1.0 if given is None or given.charge is None else given.charge
            joules, since_s = told.joules.get(robot.name, (share * battery.capacity_j, now_s))
            battery.joules, battery.since = min(joules, battery.capacity_j), to_ticks(since_s)
    for name, until_s in told.pickers_s.items():
        station = warehouse.stations[names.station(name, "run", "pickers_s", name)]
        if to_ticks(until_s) <= warehouse.now:
            names.wrong(("run", "pickers_s", name), f"found {until_s:g}, which is not later than the state's time")
        warehouse.occupy_picker(station, to_ticks(until_s), to_ticks(station.picker_free_s))
    _check_services(told, warehouse, names)
    warehouse.bundles_so_far = max(warehouse.bundles_so_far, told.bundles)


def _check_services(told: RunState, warehouse: Warehouse, names: Names) -> None:
    """Check what service times were drawn for, and the last pick of stations: else others would be drawn."""
    orders, skus, stations = len(names.orders), len(names.skus), len(names.stations)
    for name, last in told.begun.items():
        names.station(name, "run", "begun", name)
        most = (told.visits + 1, orders, skus)
        if len(last) != 3 or not all(0 <= one < number for one, number in zip(last, most, strict=True)):
            names.wrong(("run", "begun", name), f"found {[*last]}; expected the ids of a visit, an order and a SKU")
    kinds = ((len(warehouse.pods),), (orders, skus), (orders, skus, 1), (orders, stations, 1, 1))
    of_packing = ((orders,), (orders, 1))
    for what in told.drawn:
        kind, _, rest = what.partition(" ")
        ids, among = (rest.split(" "), of_packing) if kind in TASKS else (what.split(" "), kinds)
        known = next((kind for kind in among if len(kind) == len(ids)), ())
        if not known or not all(map(_is_id, ids, known)):
            expected = "expected ids: pod, or order and SKU, with 0 of a visit; order and station, with 0 0; or put or "
            expected += "pack, and order, also with 0"
            names.wrong(("run", "drawn", what), f'found "{what}"; {expected}')


def _is_id(text: str, number: int) -> bool:
    return text.isdecimal() and int(text) < number and text == str(int(text))
