"""From a state to the warehouse that it describes, and the read-only view of it that a rule is given."""

from __future__ import annotations

from functools import lru_cache
from typing import NoReturn, TypeVar

from attrs import frozen

from rmfs_core.clock import to_ticks
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.warehouse import Pod, Robot, Station, Warehouse, WarehouseView
from rmfs_core.world import Instance, Layout, OrderData, PodData, block_map, check_layout, parse_map
from rmfs_core.world.travel import travel_on
from rmfs_states.names import Names
from rmfs_states.placing import place_pods_and_robots
from rmfs_states.requesting import assign_parts, promise_items
from rmfs_states.state import LayoutState, State
from rmfs_states.state_json import place_of

QUEUE_LENGTH = 12
"""Pods that can wait at a station that does not say how many: the paper's number."""


Part = TypeVar("Part", Robot, Station)


class LacksError(Exception):
    """A rule asked for something that the state does not tell."""


@frozen(eq=False)
class Scene:
    """A state come alive.

    Parameters
    ----------
    state
        The state.
    names
        Its names and their ids.
    instance
        Its orders and pods, whatever has become of them.
    warehouse
        Made from it and shared with nobody, so a decision can be tried out on it.
    view
        What the rule is given.
    shown
        Ids of the orders in ``view.backlog`` where prefilters left some out, else None.
    period
        Number of the period that is decided.
    """

    state: State
    names: Names
    instance: Instance
    warehouse: Warehouse
    view: WarehouseView
    shown: frozenset[int] | None
    period: int


class _WithoutPlaces(WarehouseView):
    """The view of a state without a layout: places have no meaning, and a rule that asks for them is told so."""

    __slots__ = ()

    @property
    def travel(self) -> NoReturn:
        """There is no grid."""
        raise LacksError("driving times")

    @property
    def free_storage_locations(self) -> NoReturn:
        """There are no places."""
        raise LacksError("storage locations")

    @property
    def blocked_locations(self) -> NoReturn:
        """There are no places."""
        raise LacksError("storage locations")

    def home(self, pod: Pod) -> NoReturn:  # noqa: ARG002
        """There are no places."""
        raise LacksError("storage locations")


def open_state(state: State, source: str = "state") -> Scene:
    """Return the warehouse that a state describes.

    Parameters
    ----------
    state
        The state.
    source
        What a message calls where it comes from.

    Raises
    ------
    InputError
        With the path of the key, where the state contradicts itself or names what it does not list.
    """
    names = Names(state, source)
    instance = _instance(state, names)
    layout = _layout(state, names)
    warehouse = Warehouse(
        instance,
        travel_on(layout, state.motion.motion()),
        _stations(state, names, layout),
        [_called(Robot(i, 0, 1), name) for i, name in enumerate(state.robots or ())],
        layout.storage_locations[: len(state.pods)],
    )
    warehouse.now = _now(state, names)
    for order in warehouse.orders:
        warehouse.order_arrives(order)
    assign_parts(warehouse, names, state)
    place_pods_and_robots(warehouse, names, state)
    promise_items(warehouse, names, state)
    shown = _shown(state, names, warehouse)
    backlog = None if shown is None else [order for order in warehouse.backlog if order.id in shown]
    view = (_WithoutPlaces if state.layout is None else WarehouseView)(warehouse, backlog)
    return Scene(state, names, instance, warehouse, view, shown, _period(state, warehouse))


def _period(state: State, warehouse: Warehouse) -> int:
    if state.ask.period is not None:
        return state.ask.period
    return 1 + max((part.period for order in warehouse.orders for part in order._parts), default=0)


def _shown(state: State, names: Names, warehouse: Warehouse) -> frozenset[int] | None:
    if state.backlog is None:
        return None
    shown = [names.order(order, "backlog", i) for i, order in enumerate(state.backlog)]
    for i, order in enumerate(shown):
        if not warehouse.in_backlog(warehouse.orders[order]):
            names.wrong(("backlog", i), f'names order "{state.backlog[i]}", which has no open line left')
    return frozenset(shown)


def _now(state: State, names: Names) -> int:
    """Return the time now in ticks."""
    latest = max((order.arrival_s for order in state.orders.values()), default=0.0)
    if state.time_s is not None and latest > state.time_s:
        names.wrong(("time_s",), f"found {state.time_s}, but an order arrives at {latest}; expected none later")
    return to_ticks(latest if state.time_s is None else state.time_s)


def _instance(state: State, names: Names) -> Instance:
    orders = []
    for name in names.orders:
        order = state.orders[name]
        lines = tuple((names.sku(sku, "orders", name, "lines", sku), n) for sku, n in order.lines.items())
        orders.append(OrderData(name, to_ticks(order.arrival_s), lines))
    pods = []
    for name, pod in state.pods.items():
        contents = tuple((names.sku(sku, "pods", name, "contents", sku), n) for sku, n in pod.contents.items())
        pods.append(PodData(name, contents))
    return Instance(tuple(names.skus), tuple(orders), tuple(pods))


def _layout(state: State, names: Names) -> Layout:
    """Return the grid; without one in the state, a stand-in with places enough, which rules do not get to see."""
    if not state.stations:
        names.wrong(("stations",), "found none; expected at least one picking station")
    if state.layout is None:
        return _stand_in(len(state.stations), len(state.pods))
    longest = max(station.queue_length or QUEUE_LENGTH for station in state.stations.values())
    layout = _layout_of(state.layout, longest, place_of(names.source, ("layout",)))
    if len(layout.stations) != len(state.stations):
        names.wrong(
            ("stations",), f"found {len(state.stations)}; expected {len(layout.stations)}, as the layout has them"
        )
    return layout


@lru_cache(maxsize=4)
def _layout_of(given: LayoutState, queue_length: int, place: str) -> Layout:
    if given.map is not None:
        layout = parse_map("\n".join(given.map), f"{place}.map")
    else:
        assert given.blocks is not None
        layout = parse_map(block_map(given.blocks, queue_length, f"{place}.blocks"), place)
    check_layout(layout, place)
    return layout


@lru_cache(maxsize=4)
def _stand_in(stations: int, pods: int) -> Layout:
    rows = 2 * stations + 1
    section = LayoutSection(block_rows=rows, block_columns=1 + pods // (8 * rows), stations_east=stations)
    return parse_map(block_map(section, QUEUE_LENGTH), "stand-in")


def _stations(state: State, names: Names, layout: Layout) -> list[Station]:
    stations = []
    for i, (name, given) in enumerate(state.stations.items()):
        cells = layout.stations[i]
        most = None if state.layout is None else len(cells.queue)
        queue_length = given.queue_length or most or QUEUE_LENGTH
        if most is not None and queue_length > most:
            names.wrong(("stations", name, "queue_length"), f"found {queue_length}; the layout has {most} cells")
        capacity = given.order_capacity or given.item_capacity
        assert capacity is not None  # the model has one of them
        station = Station(i, cells, capacity, given.order_capacity is not None, queue_length)
        stations.append(_called(station, name))
    return stations


def _called(part: Part, name: str) -> Part:
    """Give a new robot or station the name that the state has for it; it is read-only from then on."""
    object.__setattr__(part, "name", name)
    return part
