"""Orders that no joint rule can assign beside others, in a world of two stations with two and four places."""

from collections.abc import Mapping, Sequence

from cases import cases
from rmfs_commands.testing import small_world
from rmfs_core import JointDecision, OrderAssignment
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.helpers.oversize import Oversize, with_oversize

FITS = {"a": 4}
SPREAD = {"a": 3, "b": 3}
"""More than the larger station takes, no more than both together."""
TOO_MANY = {"a": 3, "b": 3, "c": 1}
LONG_LINE = {"a": 5}


def world_of(
    *orders: Mapping[str, int], capacities: tuple[int, ...] = (2, 4), counts_orders: bool = False
) -> Warehouse:
    named = {str(number): lines for number, lines in enumerate(orders)}
    return small_world(named, {"p": ["a", "b", "c"]}, capacities=capacities, counts_orders=counts_orders)


def found(
    world: Warehouse, max_wait_s: float = 600, *, splits: bool = False, over_time: bool = False
) -> Oversize | None:
    return Oversize.of(WarehouseView(world), max_wait_s, splits=splits, over_time=over_time)


WAYS: tuple[dict[str, bool], ...] = ({}, {"splits": True}, {"splits": True, "over_time": True})
"""How orders are split: not at all, among stations, over time."""


@cases(
    "large integrated among_stations over_time",
    (FITS, False, False, False),
    (SPREAD, True, False, False),
    ({"a": 4, "b": 1}, True, False, False),  # its longest line just fits
    (TOO_MANY, True, True, False),  # over time, its rest waits in the backlog
    (LONG_LINE, True, True, True),  # no rule splits a line
)
def test_what_is_too_large_depends_on_how_orders_are_split(
    large: Mapping[str, int], integrated: bool, among_stations: bool, over_time: bool
) -> None:
    """Whole orders go to one station, split ones to all at once, or line by line."""
    world = world_of(FITS, large)
    for way, expected in zip(WAYS, (integrated, among_stations, over_time), strict=True):
        oversize = found(world, **way)
        assert (None if oversize is None else oversize.order.name) == ("1" if expected else None), way


def test_what_is_left_when_all_stations_are_empty_is_any_large_order() -> None:
    """Its lines may not fit the stations together; with anything at a station it is not known that they never will."""
    world = world_of(FITS, {"a": 3, "b": 3}, LONG_LINE)
    left = Oversize.left(WarehouseView(world))
    assert left is not None
    assert (left.order.name, left.station.id) == ("1", 0)
    world.assign(world.orders[0], world.stations[1], [0])
    assert Oversize.left(WarehouseView(world)) is None
    assert Oversize.left(WarehouseView(world_of(FITS))) is None


NOTHING, OTHERS, LARGE = (JointDecision([OrderAssignment(i, 0) for i in orders]) for orders in ([], [0], [1]))


@cases(
    "now_s load others alone expected without",
    (0, False, OTHERS, LARGE, OTHERS, [None]),  # it waits while others can be assigned
    (0, False, NOTHING, LARGE, LARGE, [None]),
    (0, True, NOTHING, LARGE, NOTHING, [None]),  # its station is not empty
    (600, True, OTHERS, LARGE, OTHERS, [0]),  # and is kept for it from now on
    (600, True, NOTHING, LARGE, NOTHING, [0]),
    (600, False, OTHERS, LARGE, LARGE, []),
    (600, False, OTHERS, NOTHING, OTHERS, [None]),  # free items are not enough: all stations are for others
)
def test_a_large_order_goes_alone_when_nothing_else_can_or_it_has_waited(
    now_s: float,
    load: bool,
    others: JointDecision,
    alone: JointDecision,
    expected: JointDecision,
    without: Sequence[int | None],
) -> None:
    """Order 1; the station with the lowest load is 0."""
    world, asked = world_of({"a": 1}, LONG_LINE, {"a": 1}, {"a": 1}), []
    if load:
        for position, station in ((2, 0), (3, 1)):
            world.assign(world.orders[position], world.stations[station], [0])
    world.now = round(now_s * 1000)

    def decide(kept: object) -> JointDecision:
        asked.append(None if kept is None else world.stations.index(kept))
        return others

    decision = with_oversize(WarehouseView(world), found(world, splits=True), decide, lambda large: alone)
    assert decision == expected
    assert asked == list(without)


def test_an_order_that_nothing_can_assign_goes_alone_at_last() -> None:
    """Two lines that do not fit the stations together, though all places are as many."""
    world = world_of({"a": 3, "b": 3})
    assert found(world, splits=True) is None
    decision = with_oversize(WarehouseView(world), None, lambda _: NOTHING, lambda large: LARGE)
    assert decision == LARGE
