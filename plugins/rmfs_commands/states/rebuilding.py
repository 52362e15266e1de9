"""From a state to the warehouse that it describes, and the read-only view of it that a rule is given."""

from __future__ import annotations

from functools import lru_cache
from typing import NoReturn

from attrs import frozen

from rmfs_commands.layouts import block_map, parse_map
from rmfs_commands.states.mementos import QUEUE_LENGTH, Before, memento_of
from rmfs_commands.states.names import Names
from rmfs_commands.states.plain import Memento
from rmfs_commands.states.restoring import ContradictionError, restore
from rmfs_commands.states.state import LayoutState, State
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.scenario.source import Source
from rmfs_core.warehouse import Order, Pod, Warehouse, WarehouseView
from rmfs_core.world import Instance, Layout, check_layout
from rmfs_core.world.travel import travel_on


class LacksError(Exception):
    """A rule asked for something that the state does not tell."""


@frozen(eq=False)
class OpenState:
    """A state that rules can be asked in: a warehouse made from it.

    Parameters
    ----------
    state
        The state.
    names
        Its names and their ids.
    memento
        Plain data that it was made from, with ids.
    instance
        Its orders and pods, whatever has become of them.
    warehouse
        Made from it and shared with nobody, so a decision can be tried out on it.
    view
        The view that the rule gets.
    shown
        Ids of the orders in ``view.backlog`` where prefilters left some out, else None.
    period
        Number of the period that is decided.
    """

    state: State
    names: Names
    memento: Memento
    instance: Instance
    warehouse: Warehouse
    view: WarehouseView
    shown: frozenset[int] | None
    period: int


class _WithoutPlaces(WarehouseView):
    """The view of a state without a layout: cells have no meaning, and a rule that asks for them is told so."""

    __slots__ = ()

    @property
    def travel(self) -> NoReturn:
        """There is no grid."""
        raise LacksError("driving times")

    @property
    def free_storage_locations(self) -> NoReturn:
        """There are no storage locations."""
        raise LacksError("storage locations")

    @property
    def free_rest_cells(self) -> NoReturn:
        """There are no storage locations."""
        raise LacksError("storage locations")

    @property
    def chargers(self) -> NoReturn:
        """There are no storage locations."""
        raise LacksError("chargers")

    @property
    def blocked_locations(self) -> NoReturn:
        """There are no storage locations."""
        raise LacksError("storage locations")

    @property
    def reserved_locations(self) -> NoReturn:
        """There are no storage locations."""
        raise LacksError("storage locations")

    def home(self, pod: Pod) -> NoReturn:  # noqa: ARG002
        """There are no storage locations."""
        raise LacksError("storage locations")


def open_state(state: State, source: str = "state", before: OpenState | None = None) -> OpenState:
    """Return the warehouse that a state describes.

    Parameters
    ----------
    state
        The state.
    source
        Name of its source in messages.
    before
        An earlier state, opened, which is given up: objects that both states have are read no second time.

    Raises
    ------
    InputError
        With the path of the key, where the state contradicts itself or names what it does not list.
    """
    names = Names(state, source)
    layout = _layout(state, names)
    reused: dict[int, Order] = {}
    if before is None:
        memento = memento_of(state, names, layout)
    else:
        memento = memento_of(state, names, layout, Before(before.state, before.names, before.memento))
        reused = dict(zip(map(id, before.memento.orders), before.warehouse.orders, strict=True))
    try:
        warehouse = restore(memento, travel_on(layout, state.motion.motion()), reused=reused)
    except ContradictionError as error:
        names.wrong(names.path(error.path), error.problem)
    warehouse.has_places = state.layout is not None
    instance = Instance(
        memento.skus,
        tuple(o.data for o in memento.orders),
        tuple(p.data for p in memento.pods),
        memento.sizes,
        restocked=bool(warehouse.storing),
    )
    shown = _shown(state, names, warehouse)
    backlog = None if shown is None else [order for order in warehouse.backlog.orders if order.id in shown]
    view = (_WithoutPlaces if state.layout is None else WarehouseView)(warehouse, backlog)
    return OpenState(state, names, memento, instance, warehouse, view, shown, _period(state, memento))


def _period(state: State, memento: Memento) -> int:
    if state.ask.period is not None:
        return state.ask.period
    return 1 + max((part.period for order in memento.orders for part in order.parts), default=0)


def _shown(state: State, names: Names, warehouse: Warehouse) -> frozenset[int] | None:
    if state.backlog is None:
        return None
    shown = [names.order(order, "backlog", i) for i, order in enumerate(state.backlog)]
    for i, order in enumerate(shown):
        if warehouse.orders[order] not in warehouse.backlog:
            names.wrong(("backlog", i), f'names order "{state.backlog[i]}", which has no open line left')
    return frozenset(shown)


def _layout(state: State, names: Names) -> Layout:
    """Return the grid; without one in the state, a stand-in with cells enough, which rules do not see."""
    if not any(station.picks for station in state.stations.values()):
        names.wrong(("stations",), "found none; expected at least one picking station")
    if state.layout is None:
        return _stand_in(len(state.stations), len(state.pods))
    longest = max(station.queue_length or QUEUE_LENGTH for station in state.stations.values())
    layout = layout_of(state.layout, longest, Source(names.source).place_of(("layout",)))
    if len(layout.stations) != len(state.stations):
        names.wrong(
            ("stations",), f"found {len(state.stations)}; expected {len(layout.stations)}, as the layout has them"
        )
    return layout


@lru_cache(maxsize=4)
def layout_of(given: LayoutState, queue_length: int, place: str) -> Layout:
    """Return the grid that a state tells of."""
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
