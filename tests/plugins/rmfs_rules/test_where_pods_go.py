"""Rules that choose where pods are stored, and which are moved: against their definitions in plain Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.layouts import parse_map
from rmfs_commands.testing import check_rule, small_instance, small_layout, small_world
from rmfs_core import PodMove, hookimpl
from rmfs_core.info import Question
from rmfs_core.motion import Motion
from rmfs_core.roles import Role
from rmfs_core.warehouse import Station, Warehouse, WarehouseView
from rmfs_core.world import NORTH
from rmfs_core.world.travel import travel_on
from rmfs_rules.classes import Cache, TurnoverClasses, Utility
from rmfs_rules.classes.moving import Pause, nearest_to
from rmfs_rules.classes.places import NO_STATION, Places
from rmfs_rules.classes.worth import combined, movable
from rmfs_rules.fixed import Fixed
from rmfs_rules.nearest import Nearest
from standing import put_at_station


def test_the_location_with_the_shortest_loaded_drive_is_chosen() -> None:
    world = small_world({}, {"p": ["a"], "q": ["a"]})
    put_at_station(world, 0, 0)
    pod = world.pods[0]
    heading = world.robots[0].heading
    by_time = {cell: world.travel.ticks(pod.cell, heading, cell, True) for cell in world.free_locations}
    chosen = Nearest().choose_storage_location(WarehouseView(world), pod)
    assert type(chosen) is int
    assert by_time[chosen] == min(by_time.values())
    assert pod.cell == world.stations[0].cell
    assert world.pods[1].cell not in by_time


def test_turns_count_and_ties_go_to_the_lowest_cell() -> None:
    layout = parse_map("...#...\n.......\n#..O..#\n...q...\n.......\n#######", "cross")
    world = small_world({}, {"p": ["a"]}, robots=1, layout=layout)
    pod, robot = world.pods[0], world.robots[0]
    world.bind(pod, world.stations[0])
    world.take_task(robot, pod)
    world.lift(robot, pod)
    north, west, east = layout.storage_locations[:3]
    world.move(robot, west + 3 - 7, NORTH)  # in the middle of the second row
    assert Nearest().choose_storage_location(WarehouseView(world), pod) == north
    world.reserve(north)
    times = world.travel.times_from(robot.cell, NORTH, True)
    assert times[west] == times[east]
    assert Nearest().choose_storage_location(WarehouseView(world), pod) == west


def test_a_pod_goes_back_to_where_it_stood() -> None:
    world = small_world({}, {"p": ["a"], "q": ["a"]})
    put_at_station(world, 1, 0)
    home = world.homes[1]
    assert Fixed().choose_storage_location(WarehouseView(world), world.pods[1]) == home


def test_it_goes_to_the_nearest_free_place_when_its_home_is_taken() -> None:
    world = small_world({}, {"p": ["a"], "q": ["a"]})
    put_at_station(world, 1, 0)
    world.reserve(world.homes[1])
    view = WarehouseView(world)
    chosen = Fixed().choose_storage_location(view, world.pods[1])
    assert chosen == Nearest().choose_storage_location(view, world.pods[1]) != world.homes[1]


def places(stations: int = 2) -> tuple[Places, WarehouseView]:
    """Return the places of a world with so many stations."""
    view = WarehouseView(small_world({}, {"p": ["a"]}, capacities=[9] * stations))
    return Places.of(view), view


def test_places_are_all_storage_locations_with_their_drives() -> None:
    found, view = places()
    assert found.cells.tolist() == sorted(view.travel.layout.storage_locations)
    for station in view.stations:
        drives = [view.travel.times_to(station.cell, True)[cell].min() for cell in found.cells.tolist()]
        assert found.ticks[station.id].tolist() == drives
    assert found.nearest_ticks.tolist() == [min(pair) for pair in zip(*found.ticks.tolist(), strict=True)]


def test_places_with_empty_pods_are_none() -> None:
    layout = small_layout(1)
    locations = layout.storage_locations
    station = Station(0, layout.stations[0], 9, False, 3)
    instance = small_instance({}, {"p": ["a"]})
    world = Warehouse(instance, travel_on(layout, Motion()), [station], [], locations[:1], blocked=locations[1:5])
    assert not {*Places.of(WarehouseView(world)).cells.tolist()} & {*locations[1:5]}


def test_places_with_the_same_drive_have_the_same_rank() -> None:
    found, _ = places()
    drives = sorted(set(found.nearest_ticks.tolist()))
    assert found.ranks().tolist() == [drives.index(drive) for drive in found.nearest_ticks.tolist()]
    assert len(drives) < len(found.cells)


OF_THREE = {"1": {"a": 3}, "2": {"b": 1, "a": 1}, "3": {"c": 2}}
THREE_PODS = {"p": {"a": 2, "c": 1}, "q": {"b": 9}, "r": {"z": 9}}


def half_served() -> Warehouse:
    """Return a world in which pod p is to serve order 3, as far as it can."""
    made = small_world(OF_THREE, THREE_PODS)
    made.assign(made.orders[2], made.stations[0], [1])
    made.bind(made.pods[0], made.stations[0])
    return made


def test_both_are_shares_of_the_largest() -> None:
    view = WarehouseView(half_served())
    assert combined(view, 1, 0).tolist() == [1, 0.25, 0]
    assert combined(view, 0, 1).tolist() == [1, 0.5, 0]
    assert combined(view, 2, 1).tolist() == [3, 1, 0]


def test_nothing_was_ordered() -> None:
    view = WarehouseView(small_world({}, THREE_PODS))
    assert combined(view, 1, 1).tolist() == [0, 0, 0]


def test_a_pod_that_a_robot_fetches_may_not_be_moved() -> None:
    made = half_served()
    made.waiting[made.pods[1].id] = made.pods[1]
    made.take_task(made.robots[0], made.pods[1])  # to be carried elsewhere, without a visit
    assert movable(WarehouseView(made)).tolist() == [False, False, True]


def drive(world: Warehouse, cell: int) -> int:
    """Driving time with a pod from a cell to the nearest station."""
    return min(int(world.travel.times_to(station.cell, True)[cell].min()) for station in world.stations)


def trip(world: Warehouse, cell: int) -> int:
    """Driving time of pod 0 to a cell."""
    return world.travel.ticks(world.pods[0].cell, world.robots[0].heading, cell, True)


def decide(world: Warehouse, rule: Any) -> int:
    """Return where pod 0 is stored."""
    chosen = rule.choose_storage_location(WarehouseView(world), world.pods[0])
    assert type(chosen) is int
    return chosen


def test_speed_and_demand_can_be_told_apart() -> None:
    world = small_world({"1": {"a": 3}, "2": {"b": 1}}, {"p": ["a"], "q": ["b"]})
    world.assign(world.orders[0], world.stations[0], [0])
    put_at_station(world, 0, 0)
    (request,) = world.stations[0].open_requests
    for _ in range(request.items):
        world.fulfil(request, world.pods[0])
    best = min(world.free_locations, key=lambda cell: (drive(world, cell), trip(world, cell)))
    fast = Utility(weight_speed=1, weight_demand=0, corridor=1, buffer=1)
    slow = Utility(weight_speed=0, weight_demand=1, corridor=1, buffer=1)
    assert drive(world, decide(world, fast)) == drive(world, best) < drive(world, decide(world, slow))


@pytest.mark.parametrize(
    ("rule", "wrong"),
    [
        (Cache, {"share": 1.5}),
        (Cache, {"threshold": -1}),
        (Utility, {"corridor": 0}),
        (Utility, {"buffer": -0.1}),
        (Utility, {"weight_speed": -1}),
    ],
)
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, float]) -> None:
    (name,) = wrong
    with pytest.raises(ValueError, match=f"'{name}' must be"):
        rule(**wrong)


def test_a_large_cache_conforms() -> None:
    assert check_rule(Cache(share=1.0, threshold=0.1)).findings == ()


class Doubter:
    """Observer that has each place chosen once more, by a rule that remembers nothing."""

    def __init__(self, rule: type[Any]) -> None:
        self.rule, self.places = rule, 0

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        if question.decides is Role.PR:
            assert answer == self.rule().choose_storage_location(question.warehouse, question.arguments["pod"])
            self.places += 1


@pytest.mark.parametrize("rule", [TurnoverClasses, Cache, Utility])
@pytest.mark.parametrize("scenario", ["examples/small", "examples/replenished"])
def test_what_is_kept_decides_as_what_is_read_anew(rule: type[Any], scenario: str) -> None:
    doubter = Doubter(rule)
    rules = {"pr": (chosen := rule()), **({"move": chosen} if hasattr(chosen, "move_pods") else {})}
    overrides = ["run.until_s=3000", "rules.pp=free-flow", "robots.count=8"]
    rmfs_core.run(scenario, overrides=overrides, rules=rules, observers=[doubter])
    assert doubter.places > 10


def far_wanted(wanted: int, pods: int = 20) -> Warehouse:
    """Return a warehouse in which the last pods, far from the station, are wanted: the last one most."""
    contents = {str(i): [f"s{i}"] for i in range(pods)}
    orders = {f"{i}-{n}": [f"s{pods - 1 - i}"] for i in range(wanted) for n in range(wanted - i)}
    return small_world(orders, contents, layout=small_layout(1, block_columns=3))


def after(warehouse: Warehouse, moves: list[PodMove]) -> None:
    """Let robots carry out moves."""
    for move in moves:
        pod, robot = warehouse.pods[move.pod], warehouse.robots[0]
        warehouse.waiting[pod.id] = pod
        warehouse.take_task(robot, pod)
        warehouse.reserve(move.cell)
        warehouse.lift(robot, pod)
        warehouse.move(robot, move.cell, robot.heading)
        warehouse.store(robot, pod)


def test_utility_moves_the_worst_misplaced_first() -> None:
    warehouse = far_wanted(4)
    view, rule = WarehouseView(warehouse), Utility(retry_s=10)
    places = Places.of(view)
    rank = dict(zip(places.cells.tolist(), places.ranks().tolist(), strict=True))
    (first,) = rule.move_pods(view, 1)
    assert rank[first.cell] != rank[warehouse.pods[first.pod].cell]
    moved = 0
    while moves := rule.move_pods(view, 1):
        after(warehouse, moves)
        moved += 1
        assert moved < 100
    assert moved > 1


def test_cache_fills_and_clears() -> None:
    warehouse = far_wanted(3)
    view, rule = WarehouseView(warehouse), Cache(free_places=2)
    places = Places.of(view)
    owner = dict(zip(places.cells.tolist(), places.caches(rule.share).tolist(), strict=True))
    for _ in range(50):
        moves = rule.move_pods(view, 2)
        assert len(moves) <= 2
        for move in moves:
            useful = bool(view.open_demand()[min(warehouse.pods[move.pod].contents)])
            assert (owner[move.cell] != NO_STATION) == useful
        after(warehouse, moves)
        if not moves:
            break
    assert not moves
    free = sum(owner[cell] != NO_STATION for cell in view.free_storage_locations)
    inside = [pod for pod in view.pods if owner[pod.cell] != NO_STATION]
    assert free >= 2 or not any(not view.open_demand()[min(pod.contents)] for pod in inside)


@pytest.mark.parametrize("rule", [Utility(retry_s=60), Cache(retry_s=60)])
def test_it_looks_again_after_a_pause(rule: Utility | Cache) -> None:
    warehouse = small_world({}, {str(i): ["a"] for i in range(len(small_layout().storage_locations))})
    view = WarehouseView(warehouse)
    assert rule.wake_at(view) is None
    assert rule.move_pods(view, 2) == []
    assert rule.wake_at(view) == 60
    warehouse.advance(60_000)
    assert rule.wake_at(view) is None
    assert WarehouseView(small_world({}, {"p": ["a"]})) is not view
    assert rule.wake_at(WarehouseView(small_world({}, {"p": ["a"]}))) is None, "another run"


def test_pauses_begin_where_nothing_is_moved() -> None:
    view = WarehouseView(small_world({}, {"p": ["a"]}))
    pause, move = Pause(), PodMove(0, 1)
    assert pause.after(view, 5, lambda: [move]) == [move]
    assert pause.until_s(view) is None
    assert pause.after(view, 5, list) == []
    assert pause.until_s(view) == 5
    assert pause.after(view, 5, lambda: [move]) == []


def test_the_nearest_place_is_that_of_the_pod() -> None:
    warehouse = small_world({}, {"p": ["a"]})
    view, pod = WarehouseView(warehouse), warehouse.pods[0]
    cells = list(view.free_storage_locations)
    ticks = {c: min(warehouse.travel.ticks(pod.cell, h, c, True) for h in range(4)) for c in cells}
    assert nearest_to(view, pod.cell, np.array(cells)) == min(cells, key=lambda cell: (ticks[cell], cell))
