"""Code shared by rules: classes, parameters, late and oversize orders, pods that are sent; searches."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
import pytest
from attrs import define, fields, validators
from hypothesis import given
from hypothesis import strategies as st

from cases import cases
from reserving import EVEN, hold_until, stay
from rmfs_commands.layouts import parse_map
from rmfs_commands.testing import small_world
from rmfs_core import JointDecision, OrderAssignment
from rmfs_core.decisions import PodTrip
from rmfs_core.warehouse import Pod, Station, Warehouse, WarehouseView
from rmfs_core.world.travel import travel_on
from rmfs_rules.helpers import nearest_free_location, send_pods, ticks_to_station
from rmfs_rules.helpers.classes import by_share, class_borders, turn
from rmfs_rules.helpers.late import SHUT, assign_late, late
from rmfs_rules.helpers.oversize import Oversize, with_oversize
from rmfs_rules.helpers.parameters import parameter
from rmfs_rules.helpers.searching import free_for_good, gap_at, search_once
from rmfs_rules.sipp.windows import narrow
from rmfs_rules.whca.compiled import last_end
from rmfs_traffic import FOREVER, Reservations, roads_on
from standing import put_at_station


@define
class Cut:
    """A rule with classes."""

    borders: tuple[float, ...] = class_borders("pods")


def test_classes_are_cut_and_looked_at_in_turn() -> None:
    assert by_share(np.array([3, 0, 4, 1, 2]), (0.4, 0.6, 1.0)).tolist() == [0, 2, 2, 0, 1]
    assert by_share(np.arange(3), (0.01, 1.0)).tolist() == [1, 1, 1]
    away = np.array([-2, -1, 0, 1, 2])
    assert turn(away, better_first=True).argsort().tolist() == [2, 1, 3, 0, 4]
    assert turn(away, better_first=False).argsort().tolist() == [2, 3, 1, 4, 0]


@cases(
    "borders", (), (0.5,), (0.3, 0.3, 1.0), (0.5, 0.2, 1.0), (0.0, 1.0), ids=["none", "short", "equal", "falling", "0"]
)
def test_borders_have_to_rise_to_1(borders: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="expected shares above 0 that rise to 1"):
        Cut(borders)


@define
class Mine:
    """A rule with two parameters."""

    share: float = parameter(0.5, [validators.gt(0), validators.le(1)], "How much of it")
    window_s: float = parameter(20.0, None, "How long", "s", infinite=True)


def test_default_check_meaning_and_unit() -> None:
    assert (Mine().share, Mine(1).window_s) == (0.5, 20.0)
    for share in (0, 2):
        with pytest.raises(ValueError, match="'share' must be"):
            Mine(share)
    told = [dict(field.metadata) for field in fields(Mine)]
    assert told == [{"doc": "How much of it"}, {"unit": "s", "doc": "How long", "infinite": True}]


def test_who_waits_too_long() -> None:
    """With a limit all who reach it; without, only the oldest if it is larger than any station, after ten minutes."""
    world = small_world({"1": ["a"], "2": {"a": 4}, "3": {"a": 5}}, {"p": ["a"]}, capacities=[3, 3])
    view = WarehouseView(world)
    world.now = 599_999
    assert late(view, 600) == []
    world.now = 600_000
    assert late(view, 600) == [0, 1, 2]
    assert late(view, None) == []  # an older one waits
    world.assign(world.orders[0], world.stations[0], [0])
    world.now = 599_999
    assert late(view, None) == []
    world.now = 600_000
    assert late(view, None) == [1]
    world.assign(world.orders[1], world.stations[1], [0])
    assert late(view, None) == []  # one station at a time picks such orders


def free_after(world: Warehouse, max_wait_s: float | None, *fitting: int) -> tuple[list[int], list[int]]:
    asked: list[int] = []

    def assign(place: int) -> bool:
        asked.append(place)
        return place in fitting

    free = np.array([station.free_capacity for station in world.stations])
    assign_late(WarehouseView(world), max_wait_s, free, assign)
    return asked, free.tolist()


def test_each_order_that_fits_nowhere_keeps_a_station() -> None:
    """That with most room of those that could take it: 2 wants three items, 3 wants one."""
    world = small_world({"1": ["a"], "2": {"a": 3}, "3": ["a"]}, {"p": ["a"]}, capacities=[2, 3, 4])
    assert free_after(world, 0, 0) == ([0, 1, 2], [2, SHUT, SHUT])
    assert free_after(world, 0, 0, 1, 2) == ([0, 1, 2], [2, 3, 4])


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
def test_what_is_too_large_depends_on_how_orders_are_split(large, integrated, among_stations, over_time) -> None:
    """Whole orders go to one station, split ones to all at once, or line by line."""
    world = world_of(FITS, large)
    for way, expected in zip(WAYS, (integrated, among_stations, over_time), strict=True):
        oversize = found(world, **way)
        assert (None if oversize is None else oversize.order.name) == ("1" if expected else None), way


def test_what_is_left_when_all_stations_are_empty_is_any_large_order() -> None:
    """Its lines may not fit the stations together; with anything at a station it is not known that they never will."""
    world = world_of(FITS, {"a": 3, "b": 3}, LONG_LINE)
    left = Oversize.left(WarehouseView(world))
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


def busy(pods: dict[str, list[str]], *wanted: list[str]) -> Warehouse:
    world = small_world(
        {str(i): skus for i, skus in enumerate(wanted)}, pods, capacities=[9] * len(wanted), robots=len(wanted)
    )
    for order, station in zip(world.orders, world.stations, strict=True):
        world.assign(order, station, [line.sku for line in order.open_lines])
    return world


def first(station: Station, pods: Sequence[Pod], wanted: Mapping[int, int]) -> Pod:
    return pods[0]


def trips(found: list[PodTrip]) -> list[tuple[int, int]]:
    return [(one.pod, one.station) for one in found]


def test_the_station_with_fewest_pods_chooses_next() -> None:
    """Then the one with most uncovered requests, then the lowest id."""
    world = WarehouseView(busy({"p": ["a"], "q": ["b"], "r": ["c"], "s": ["d"]}, ["a", "b"], ["c", "d"]))
    assert trips(send_pods(world, 9, first)) == [(0, 0), (2, 1), (1, 0), (3, 1)]
    world = WarehouseView(busy({"p": ["a"], "q": ["b"], "r": ["c"]}, ["a"], ["b", "c"]))
    assert trips(send_pods(world, 9, first)) == [(1, 1), (0, 0), (2, 1)]


def test_no_more_stored_pods_are_sent_than_robots_can_fetch() -> None:
    """A pod that leaves a station needs no robot, but goes to one other station only."""
    world = busy({"p": ["c"], "q": ["a"]}, ["a"], ["c"], ["c"])
    assert trips(send_pods(WarehouseView(world), 1, first)) == [(1, 0)]
    put_at_station(world, 0, 0)
    assert trips(send_pods(WarehouseView(world), 0, first)) == [(0, 1)]
    assert trips(send_pods(WarehouseView(world), 1, first)) == [(0, 1), (1, 0)]


def test_only_pods_that_serve_an_uncovered_request_are_offered() -> None:
    """By id, not those that are bound for somewhere already, with what no pod serves yet: also none sent just now."""
    world = busy({"p": ["x"], "q": ["a"], "r": ["a", "b"], "s": ["b", "c"], "t": ["a"]}, ["a", "b", "c"])
    world.bind(world.pods[4], world.stations[0])  # covers a
    sku = {name: line.sku for name, line in zip("abc", world.orders[0].lines, strict=True)}
    offered: list[tuple[list[int], dict[int, int]]] = []

    def choose(station: Station, pods: Sequence[Pod], wanted: Mapping[int, int]) -> Pod:
        offered.append(([pod.id for pod in pods], dict(wanted)))
        return pods[0]

    assert trips(send_pods(WarehouseView(world), 9, choose)) == [(2, 0), (3, 0)]
    assert offered == [([2, 3], {sku["b"]: 1, sku["c"]: 1}), ([3], {sku["c"]: 1})]


def test_the_way_to_a_station_is_timed_with_the_pod() -> None:
    """From where the pod is, with the heading that is best for it."""
    world = WarehouseView(small_world({}, {"p": ["a"]}, capacities=(6, 4)))
    pod = world.pods[0]
    for station in world.stations:
        ways = [world.travel.ticks(pod.cell, heading, station.cell, True) for heading in range(4)]
        assert ticks_to_station(world, pod, station) == min(ways) < max(ways)


def test_a_pod_goes_to_the_free_location_its_robot_reaches_first() -> None:
    """By driving time with the pod, not by distance; it says nothing of a pod that nobody carries."""
    warehouse = small_world({}, {"p": ["a"], "q": ["b"]}, capacities=(9, 9))
    put_at_station(warehouse, 0, 1)
    world = WarehouseView(warehouse)
    pod, robot = world.pods[0], world.robots[world.pods[0].robot]
    times = {cell: world.travel.ticks(pod.cell, robot.heading, cell, True) for cell in world.free_storage_locations}
    assert nearest_free_location(world, pod) == min(times, key=lambda cell: (times[cell], cell))
    assert len({*times.values()}) > 1
    with pytest.raises(AssertionError, match="is being carried"):
        nearest_free_location(world, world.pods[1])


ME = 0
HELD = st.lists(st.tuples(st.integers(0, 2), st.integers(0, 30), st.integers(1, 8)), max_size=8)


def table_with(held: list[tuple[int, int, int]], cell: int = 1) -> Reservations:
    """Return a table of three cells in which owners have one as said (owner, since, how long), unless another does."""
    table = Reservations(3)
    for owner, since, length in held:
        if table.is_free(owner, stay(cell, since, since + length)):
            hold_until(table, owner, cell, since, since + length)
    return table


def free(table: Reservations, since: int, until: int, cell: int = 1) -> bool:
    return table.is_free(ME, stay(cell, since, until))


@given(HELD, st.integers(0, 40))
def test_a_gap_is_where_nobody_else_has_the_cell(held: list[tuple[int, int, int]], tick: int) -> None:
    """It ends where somebody else comes; ticks of one gap have one number, which no other gap has."""
    table = table_with(held)
    number, end = gap_at(1, tick, ME, table.arrays)
    assert (number < 0) == (end < 0) == (not free(table, tick, tick + 1))
    if number >= 0:
        assert free(table, tick, end)
        assert end == FOREVER or not free(table, end, end + 1)
        for other in range(41):
            if free(table, other, other + 1):
                same = free(table, min(tick, other), max(tick, other) + 1)
                assert (gap_at(1, other, ME, table.arrays)[0] == number) == same


@given(HELD)
def test_a_cell_is_free_for_good_after_all_others(held: list[tuple[int, int, int]]) -> None:
    """Own reservations do not count; `last_end` looks at everybody's, but not at what never ends."""
    table = table_with(held)
    others = [until for owner, _, until in table.reserved(1) if owner != ME]
    assert free_for_good(1, ME, table.arrays) == max(others, default=0)
    assert last_end(table.arrays) == max((until for _, _, until in table.reserved(1)), default=0)
    table.hold(5, 2, 3)
    assert free_for_good(2, ME, table.arrays) == FOREVER
    assert last_end(table.arrays) == max((until for _, _, until in table.reserved(1)), default=0)


@given(
    HELD,
    st.lists(st.tuples(st.integers(0, 5), st.integers(0, 9)), min_size=1, max_size=4),
    st.integers(0, 4),
    st.integers(1, 5),
)
def test_windows_are_narrowed_to_departures_that_are_free(held, pieces, enter, stay) -> None:
    table, leave = table_with(held), enter + stay
    low, high = np.zeros((2, 64), np.int64), np.zeros((2, 64), np.int64)
    at = 0
    for i, (apart, length) in enumerate(pieces):
        low[0, i], high[0, i] = at + apart, at + apart + length
        at += apart + length + 2
    n = narrow(low, high, 0, len(pieces), 1, 1, enter, leave, ME, table.arrays)
    before = {t for i in range(len(pieces)) for t in range(low[0, i], high[0, i] + 1)}
    windows = [(int(low[1, i]), int(high[1, i])) for i in range(n)]
    assert {t for begin, end in windows for t in range(begin, end + 1)} == {
        t for t in before if free(table, t + enter, t + leave)
    }
    assert windows == sorted(windows)
    assert all(end < begin for (_, end), (begin, _) in pairwise(windows))


def test_a_search_is_tried_once_where_nothing_is_reserved() -> None:
    asked = []
    roads = roads_on(travel_on(parse_map("......\n.#..#.\nqO....", "yard"), EVEN))
    search_once(lambda _, table, query: asked.append((int(table.arrays.count.sum()), query.cell, query.goal)), roads)
    locations = roads.layout.storage_locations
    assert asked == [(0, locations[0], locations[-1])]
