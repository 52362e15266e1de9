"""Rules for robots and stations: who fetches which pod, where robots rest and charge, which stations are active."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy as np
import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st

import rmfs_core
from rmfs_commands.layouts import parse_map
from rmfs_commands.states.plain import Memento
from rmfs_commands.states.restoring import restore
from rmfs_commands.testing import check_rule, small_layout, small_world
from rmfs_core import RobotMove
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.activation import All, BacklogThreshold, ConstantRatio
from rmfs_rules.assignment import Assignment
from rmfs_rules.balanced import Balanced
from rmfs_rules.balanced.sharing import drive, middle_last, share_out
from rmfs_rules.idle import ChargeWhenLow, RestMiddle, RestNearest, Stay
from rmfs_rules.nearest_robot import NearestRobot


def decide(world: Warehouse, rule: Any) -> list[tuple[int, int]]:
    """Return (robot, pod) of each task."""
    return [(task.robot, task.pod) for task in rule.assign_tasks(WarehouseView(world))]


def three_waiting(robots: int = 3) -> Warehouse:
    """Return a world in which pods 2, 0 and 1 wait in this order; the robot with the highest id is nearest to all."""
    world = small_world({}, {"p": ["a"], "q": ["a"], "r": ["a"]}, robots=robots)
    for pod in (2, 0, 1):
        world.bind(world.pods[pod], world.stations[0])
    return world


def test_the_pod_that_waits_longest_gets_the_nearest_robot() -> None:
    """Robots 0, 1, 2 are 13.6, 13.0 and 12.3 s from pod 0, and in the same order from the others."""
    assert decide(three_waiting(), NearestRobot()) == [(2, 2), (1, 0), (0, 1)]


def test_pods_wait_when_there_are_more_of_them() -> None:
    assert decide(three_waiting(robots=1), NearestRobot()) == [(0, 2)]


def test_busy_robots_get_nothing() -> None:
    world = three_waiting()
    world.take_task(world.robots[2], world.pods[2])
    assert decide(world, NearestRobot()) == [(1, 0), (0, 1)]


def test_ties_go_to_the_lowest_id() -> None:
    world = three_waiting(robots=2)
    world.move(world.robots[1], world.robots[0].cell, world.robots[0].heading)
    assert decide(world, NearestRobot()) == [(0, 2), (1, 0)]


def waiting_world(robots: int, pods: int, seed: int = 0) -> Warehouse:
    """Return a world in which pods wait in a random order, and robots stand in random aisles."""
    rng = np.random.default_rng(seed)
    world = small_world({}, {str(i): ["a"] for i in range(pods)}, robots=robots)
    for pod in rng.permutation(pods).tolist():
        world.bind(world.pods[pod], world.stations[0])
    for robot in world.robots:
        world.move(robot, int(rng.choice(world.travel.layout.storage_locations)), int(rng.integers(4)))
    return world


def ticks_of(world: Warehouse, robot: int, pod: int) -> int:
    """Driving time of a robot to a pod."""
    at = world.robots[robot]
    return world.travel.ticks(at.cell, at.heading, world.pods[pod].cell, False)


def test_the_sum_of_drives_counts() -> None:
    world = small_world({}, {str(i): ["a"] for i in range(16)}, robots=2)
    first, last = world.pods[0], world.pods[15]
    for pod in (first, last):
        world.bind(pod, world.stations[0])
    times = [world.travel.times_to(pod.cell, False) for pod in (first, last)]
    cells = world.travel.layout.storage_locations

    def both(one: int, other: int) -> tuple[int, int]:
        straight = times[0][one, 0] + times[1][other, 0]
        return int(straight), int(times[0][other, 0] + times[1][one, 0])

    near, far = next(
        (one, other)
        for one in cells
        for other in cells
        if times[0][one, 0] < times[0][other, 0] and both(one, other)[0] > both(one, other)[1]
    )
    world.move(world.robots[0], near, 0)
    world.move(world.robots[1], far, 0)
    assert sorted(decide(world, Assignment())) == [(0, 15), (1, 0)]


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(("robots", "pods"), [(1, 1), (3, 3), (5, 3), (3, 6)])
def test_no_other_pairs_drive_less(seed: int, robots: int, pods: int) -> None:
    world = waiting_world(robots, pods, seed)
    found = decide(world, Assignment())
    served = [pod.id for pod in world.waiting.values()][: min(robots, pods)]
    assert {pod for _, pod in found} == set(served)
    assert len({robot for robot, _ in found}) == len(found) == len(served)
    best = min(
        sum(ticks_of(world, robot, pod) for robot, pod in zip(chosen, served, strict=True))
        for chosen in permutations(range(robots), len(served))
    )
    assert sum(ticks_of(world, robot, pod) for robot, pod in found) == best


def storing_world(robots: int, *waiting: int) -> Warehouse:
    """Return a world in which robot 1 brings pod 0 back and stood by pod 11 last; the others are idle, by pod 1."""
    world = small_world({}, {str(i): ["a"] for i in range(12)}, robots=robots)
    station, storing = world.stations[0], world.robots[1]
    world.place_at_station(storing, world.pods[0], station)
    world.leave(storing, world.pods[0], station)
    for pod in waiting:
        world.bind(world.pods[pod], station)
    for robot in world.robots:
        world.move(robot, world.pods[11 if robot is storing else 1].cell, 0)
    return world


def test_an_idle_robot_may_stay_for_it() -> None:
    world = storing_world(3, 1, 11)
    assert [pod for _, pod in decide(world, Assignment(defer_s=1))] == [1]
    assert [pod for _, pod in sorted(decide(world, Assignment(defer_s=1000)), key=lambda pair: pair[1])] == [1, 11]


def test_the_pod_that_waits_longest_is_not_deferred() -> None:
    """Robot 1 would be there at once."""
    world = storing_world(2, 11)
    assert decide(world, Assignment(defer_s=0)) == [(0, 11)]


def test_assignment_conforms_with_deferral() -> None:
    assert check_rule(Assignment(defer_s=0.0)).findings == ()


def test_a_time_below_zero_is_refused() -> None:
    with pytest.raises(ValueError, match="'defer_s' must be >= 0"):
        Assignment(defer_s=-1)


def test_where_no_pod_waits_there_is_no_task() -> None:
    assert decide(waiting_world(2, 0), Assignment()) == []
    assert decide(waiting_world(2, 0), Assignment(defer_s=5.0)) == []


STATIONS = 3
"""Stations 0, 1 and 2 from north to south; all robots stand in the south-east, robot 0 nearest to every station."""


def world_with(*requests: int, robots: int = 4) -> Warehouse:
    """Return a world with an open request at each of these stations; pod i is the one for order i."""
    orders = {str(i): [f"s{i}"] for i in range(8)}
    world = small_world(orders, {f"p{i}": [f"s{i}"] for i in range(8)}, capacities=[9] * STATIONS, robots=robots)
    for order, station in enumerate(requests):
        world.assign(world.orders[order], world.stations[station], [world.orders[order].lines[0].sku])
        world.bind(world.pods[order], world.stations[station])
    return world


def test_a_robot_fetches_the_longest_waiting_pod_of_its_own_station() -> None:
    world = world_with(0, 2, 0, 2)
    rule = Balanced()
    assert sorted(decide(world, rule), key=lambda task: task[1]) == [(2, 0), (0, 1), (3, 2), (1, 3)]
    assert rule.station_of == {0: 2, 1: 2, 2: 0, 3: 0}


def test_a_robot_without_work_helps_the_nearest_station() -> None:
    world = world_with(0, 1, 2, robots=3)
    rule = Balanced()
    rule.assign_tasks(WarehouseView(world))
    own = {station: robot for robot, station in rule.station_of.items()}
    world.take_task(world.robots[own[0]], world.pods[2])
    world.take_task(world.robots[own[1]], world.pods[0])
    assert decide(world, rule) == [(own[2], 1)]


def test_without_help_a_pod_waits_for_a_robot_of_its_station() -> None:
    world = world_with(0, 2, 2, 2)
    rule, helping = Balanced(help_others=False), Balanced()
    for either in (rule, helping):
        either.assign_tasks(WarehouseView(world))
    own = [robot for robot, station in rule.station_of.items() if station == 2]
    world.take_task(world.robots[own[0]], world.pods[0])
    world.take_task(world.robots[own[1]], world.pods[1])
    assert decide(world, rule) == []
    assert [pod for _, pod in decide(world, helping)] == [2, 3]


def test_a_station_without_robots_is_served_all_the_same() -> None:
    world = world_with(0, 1, 2, robots=1)
    rule = Balanced(help_others=False)
    assert decide(world, rule) == [(0, 2)]
    robot, pod = world.robots[0], world.pods[2]
    world.take_task(robot, pod)
    world.lift(robot, pod)
    world.join_line(robot, world.stations[2])
    world.leave(robot, pod, world.stations[2])
    world.store(robot, pod)
    assert rule.station_of == {0: 2}
    assert decide(world, rule) == [(0, 1)]


def test_shares_are_kept_for_a_while() -> None:
    """Station 1 becomes active; it gets its share when 30 s have passed, and again 30 s after that at the earliest."""
    world = world_with(0)
    rule = Balanced()
    decide(world, rule)
    assert set(rule.station_of.values()) == {0}
    world.assign(world.orders[5], world.stations[1], [5])
    world.advance(29_999)
    decide(world, rule)
    assert set(rule.station_of.values()) == {0}
    world.advance(30_000)
    decide(world, rule)
    assert sorted(rule.station_of.values()) == [0, 0, 1, 1]
    world.assign(world.orders[6], world.stations[2], [6])
    world.advance(59_999)
    decide(world, rule)
    assert sorted(rule.station_of.values()) == [0, 0, 1, 1]
    world.advance(60_000)
    decide(world, rule)
    assert sorted(rule.station_of.values()) == [0, 1, 2, 2]


def test_another_run_starts_without_shares() -> None:
    """What an instance has worked out in one warehouse counts for nothing in the next, whatever the time there."""
    rule = Balanced()
    decide(world_with(0, 0, 1), rule)
    world = world_with(1, 2)
    assert decide(world, rule) == decide(world, Balanced())
    assert set(rule.station_of.values()) == {1, 2}


@pytest.mark.parametrize("value", [-1.0, float("inf"), float("nan")])
def test_the_time_between_reallocations_is_checked(value: float) -> None:
    with pytest.raises(ValueError, match="expected a number >= 0, found"):
        Balanced(reallocation_s=value)


def nothing_to_do(robots: int = 4) -> Warehouse:
    """Return a world of three stations in which nothing is to be done."""
    return small_world({}, {"p": ["a"]}, capacities=[9] * STATIONS, robots=robots)


def shares(world: Warehouse, before: dict[int, int], stations: list[int]) -> list[int]:
    """Return how many robots each station gets."""
    after = share_out(WarehouseView(world), before, stations)
    return [sum(station == own for own in after.values()) for station in range(STATIONS)]


def test_stations_are_ranked_by_their_distance_from_the_middle() -> None:
    view = WarehouseView(nothing_to_do())
    assert middle_last(view, {0, 1, 2}) == [2, 0, 1]


@pytest.mark.parametrize(
    ("robots", "stations", "expected"),
    [
        (4, [2, 0, 1], [1, 1, 2]),  # the remainder goes to the first of the ranking
        (5, [2, 0, 1], [2, 1, 2]),
        (4, [0, 1], [2, 2, 0]),  # only active stations get any
        (2, [2, 0, 1], [1, 0, 1]),  # fewer robots than stations
        (3, [1], [0, 3, 0]),
    ],
)
def test_robots_are_shared_out_evenly(robots: int, stations: list[int], expected: list[int]) -> None:
    world = nothing_to_do(robots)
    assert shares(world, {}, stations) == expected
    assert shares(world, dict.fromkeys(range(robots), 0), stations) == expected
    assert shares(world, {robot: robot % STATIONS for robot in range(robots)}, stations) == expected


def test_only_robots_that_have_to_move_do() -> None:
    view = WarehouseView(nothing_to_do())
    assert share_out(view, {0: 1, 1: 1, 2: 1, 3: 2}, [2, 1]) == {0: 2, 1: 1, 2: 1, 3: 2}


@given(
    robots=st.integers(1, 6),
    stations=st.permutations(range(STATIONS)).flatmap(lambda order: st.integers(1, STATIONS).map(lambda n: order[:n])),
    before=st.dictionaries(st.integers(0, 5), st.integers(0, STATIONS - 1)),
)
def test_shares_differ_by_one_at_most(robots: int, stations: list[int], before: dict[int, int]) -> None:
    before = {robot: station for robot, station in before.items() if robot < robots}
    view = WarehouseView(nothing_to_do(robots))
    after = share_out(view, before, stations)
    each, more = divmod(robots, len(stations))
    assert sorted(after) == list(range(robots))
    assert [list(after.values()).count(station) for station in stations] == [
        each + (rank < more) for rank in range(len(stations))
    ]
    assert share_out(view, after, stations) == after


def test_a_drive_is_as_long_as_its_time_without_a_pod() -> None:
    view = WarehouseView(nothing_to_do())
    robot = view.robots[0]
    for station in view.stations:
        expected = view.travel.ticks(robot.cell, robot.heading, station.cell, False)
        assert drive(view, robot, station.id) == (expected, station.id)
    assert min(range(STATIONS), key=lambda station: drive(view, robot, station)) == 2


HALL = parse_map("..........\n.###.####.\n..........\n.CC..####.\n.......qqO\n..........\n", "hall")


def view_of(pods: int, robots: dict[int, dict[str, Any]], layout: Any = None) -> WarehouseView:
    """Return a warehouse with pods in the first storage locations, and robots as told, by id."""
    layout = layout or small_layout()
    world = small_world({}, {str(i): ["a"] for i in range(pods)}, robots=len(robots), layout=layout)
    memento = Memento.of(WarehouseView(world), ["a"] if pods else [])
    told = tuple(evolve(robot, **robots[i]) for i, robot in enumerate(memento.robots))
    opened: Warehouse = restore(evolve(memento, robots=told), world.travel)
    return WarehouseView(opened)


@pytest.mark.parametrize("rule", [Stay(), RestNearest(), RestMiddle(), ChargeWhenLow()])
def test_rules_for_idle_robots_conform(rule: object) -> None:
    check_rule(rule)


def test_a_robot_beneath_a_pod_goes_to_the_nearest_free_location() -> None:
    first, second, last = HALL.storage_locations[0], HALL.storage_locations[1], HALL.storage_locations[-1]
    view = view_of(4, {0: {"cell": first}, 1: {"cell": last}, 2: {"cell": second, "charge": 0.1, "low": True}}, HALL)
    (move,) = RestNearest().idle_robots(view)
    times = view.travel.times_from(first, view.robots[0].heading, False)
    free = [cell for cell in view.free_storage_locations if cell != last]
    assert move == RobotMove(0, min(free, key=lambda cell: (int(times[cell]), cell)))


def test_robots_rest_in_the_middle() -> None:
    first, second, *_ = HALL.storage_locations
    view = view_of(2, {0: {"cell": first}, 1: {"cell": second}}, HALL)
    middle = HALL.height // 2 * HALL.width + HALL.width // 2
    best = sorted(view.free_storage_locations, key=lambda cell: (HALL.distance(cell, middle), cell))
    assert RestMiddle().idle_robots(view) == [RobotMove(0, best[0]), RobotMove(1, best[1])]


def test_those_with_the_least_charge_go_to_the_chargers() -> None:
    cells = HALL.storage_locations
    robots = {i: {"cell": cells[i], "charge": charge} for i, charge in enumerate([0.25, 0.05, 0.2, 0.31])}
    moves = ChargeWhenLow(low=0.3, full=0.9).idle_robots(view_of(5, robots, HALL))
    assert [(move.robot, move.charge) for move in moves] == [(1, 0.9), (2, 0.9)]
    assert {move.cell for move in moves} == {*HALL.chargers}


def test_who_is_charged_makes_way_for_others() -> None:
    one, other = HALL.chargers
    cells = HALL.storage_locations
    charged, charging = {"cell": one, "charge": 0.9}, {"cell": other, "charge": 0.5}
    waits = {"cell": cells[0], "charge": 0.1}
    view = view_of(3, {0: charged, 1: charging, 2: waits}, HALL)
    (move,) = ChargeWhenLow().idle_robots(view)
    assert (move.robot, move.charge) == (0, None)
    assert move.cell in view.free_storage_locations
    assert ChargeWhenLow().idle_robots(view_of(3, {0: charged, 1: charging}, HALL)) == []


def test_robots_without_batteries_never_charge() -> None:
    assert ChargeWhenLow().idle_robots(view_of(2, {0: {}, 1: {}}, HALL)) == []


@pytest.mark.parametrize(
    ("low", "full", "problem"), [(0.5, 0.5, "expected low below full"), (0.1, 1.5, "at most 1"), (-0.1, 0.5, "low")]
)
def test_shares_of_charge_are_checked(low: float, full: float, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        ChargeWhenLow(low, full)


def test_a_run_with_few_chargers() -> None:
    overrides = [
        "layout.chargers=1",
        "rules.idle=charge-when-low",
        "robots.battery={capacity_wh=55, loaded_w=900, charging_w=20000}",
        "robots.battery.detour=1.2",
        "rules.pp=free-flow",
    ]
    result = rmfs_core.run("examples/small", overrides=overrides)
    assert result.status == "complete"
    assert result.metrics["charges"] > 4
    assert 0 <= result.metrics["charge_lowest_percent"] < 80


def waiting(orders: int = 0, capacities: tuple[int, ...] = (5, 5, 5, 5)) -> Warehouse:
    """Return a world with so many orders in the backlog."""
    return small_world({str(i): ["a"] for i in range(orders)}, {"p": ["a"]}, capacities=capacities)


def active(rule: Any, warehouse: Warehouse) -> list[int]:
    """Ask a rule, activate what it says, and return that."""
    chosen = list(rule.activate_stations(WarehouseView(warehouse)))
    for station in warehouse.stations:
        warehouse.activate(station, station.id in chosen)
    return chosen


def test_all_is_all() -> None:
    closed = waiting()
    closed.staff(closed.stations[2], False, None)
    assert active(All(), closed) == [0, 1, 2, 3]


@pytest.mark.parametrize(("ratio", "expected"), [(1.0, 4), (0.75, 3), (0.74, 2), (0.5, 2), (0.25, 1), (0.1, 1)])
def test_a_share_of_the_stations_is_rounded_down_but_never_to_none(ratio: float, expected: int) -> None:
    assert active(ConstantRatio(ratio), waiting()) == list(range(expected))


def test_the_share_is_that_of_the_stations_that_are_staffed_the_largest_first() -> None:
    warehouse = waiting(capacities=(5, 5, 9, 7))
    warehouse.staff(warehouse.stations[2], False, None)
    assert active(ConstantRatio(), warehouse) == [3]


def test_a_long_backlog_opens_a_station_and_little_to_do_closes_one() -> None:
    warehouse, rule = waiting(orders=12), BacklogThreshold(open_above=10, least=2)
    assert active(rule, warehouse) == [0, 1, 2, 3]  # much waits and nothing is to be done: nothing changes
    for order in warehouse.orders[:3]:
        warehouse.assign(order, warehouse.stations[0], [0])
    assert active(rule, warehouse) == [0, 1, 2]
    assert active(rule, warehouse) == [0, 1, 2]
    warehouse.advance(599_000)
    assert active(rule, warehouse) == [0, 1, 2]
    warehouse.advance(600_000)
    assert active(rule, warehouse) == [0, 1]
    warehouse.advance(1_200_000)
    assert active(rule, warehouse) == [0, 1]


def test_one_more_is_opened_when_the_others_are_busy() -> None:
    warehouse, rule = waiting(orders=30), BacklogThreshold(open_above=10)
    for i, order in enumerate(warehouse.orders[:10]):
        warehouse.assign(order, warehouse.stations[i // 5], [0])
    for station in warehouse.stations[2:]:
        warehouse.activate(station, False)
    assert active(rule, warehouse) == [0, 1, 2]


def test_when_a_shift_begins_some_stations_are_active_at_once() -> None:
    warehouse = waiting()
    for station in warehouse.stations:
        warehouse.staff(station, station.id >= 2, None)
        warehouse.activate(station, station.id < 2)
    assert active(BacklogThreshold(), warehouse) == [0, 1, 2]


def test_an_activation_rule_forgets_the_run_before() -> None:
    warehouse, rule = waiting(), BacklogThreshold()
    warehouse.advance(700_000)
    assert active(rule, warehouse) == [0, 1, 2]
    rule.run_started()
    assert active(rule, waiting()) == [0, 1, 2]


def test_stations_close_when_there_is_little_to_do_and_open_again() -> None:
    overrides = ["instance.orders=40", "instance.arrivals={process='poisson', orders_per_hour=60}"]
    rule = "rules.activate={rule='backlog-threshold', open_above=1, timeout_s=60}"
    all_of_them = rmfs_core.run("examples/small", overrides=[*overrides, "rules.activate=all"])
    by_load = rmfs_core.run("examples/small", overrides=[*overrides, rule])
    assert all_of_them.status == by_load.status == "complete"
    assert (by_load.metrics["station_open_h"] or 0) < 0.8 * (all_of_them.metrics["station_open_h"] or 0)


@pytest.mark.slow
@pytest.mark.parametrize("rule", [All(), ConstantRatio(), BacklogThreshold(open_above=2, timeout_s=10)])
def test_activation_rules_conform(rule: object) -> None:
    check_rule(rule)
