"""Rules that choose where pods and bundles are stored, and which pods are moved, by hand; test_oracles.py has more."""

from typing import Any

import pytest

from cases import cases
from rmfs_commands.layouts import parse_map
from rmfs_commands.testing import check_rule, small_instance, small_layout, small_world
from rmfs_core.motion import Motion
from rmfs_core.warehouse import Pod, Station, Warehouse, WarehouseView
from rmfs_core.world import NORTH
from rmfs_core.world.travel import travel_on
from rmfs_rules.classes import Cache, Utility
from rmfs_rules.classes.locations import Locations
from rmfs_rules.fixed import Fixed
from rmfs_rules.nearest import Nearest
from rmfs_rules.replenishment import (
    Correlated,
    EmptiestPod,
    LeastDemand,
    NearestPodWithRoom,
    PodFirst,
    SameSku,
    SpreadSku,
    TurnoverPod,
)
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


def test_places_with_empty_pods_are_none() -> None:
    layout = small_layout(1)
    locations = layout.storage_locations
    station = Station(0, layout.stations[0], 9, False, 3)
    instance = small_instance({}, {"p": ["a"]})
    world = Warehouse(instance, travel_on(layout, Motion()), [station], [], locations[:1], blocked=locations[1:5])
    assert not {*Locations.of(WarehouseView(world)).cells.tolist()} & {*locations[1:5]}


def test_a_large_cache_conforms() -> None:
    assert check_rule(Cache(share=1.0, threshold=0.1)).findings == ()


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


def ticks(world: Warehouse, pod: Pod, station: Station) -> int:
    return int(world.travel.times_to(station.cell, True)[pod.cell].min())


@cases(
    "rule expected",
    (EmptiestPod(), "D"),  # 9 of 10 free
    (NearestPodWithRoom(), "A"),
    (SameSku(), "C"),  # 4 of SKU a
    (SpreadSku(), "A"),  # none, as D, but A is nearer
    (Correlated(), "D"),  # has SKU c, which two orders want together with a; b is wanted with it once
    (LeastDemand(), "A"),  # nobody wants SKU d
    (TurnoverPod(borders=(0.25, 1.0)), "B"),  # a is the fastest SKU, and B the fastest pod
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else value,
)
def test_by_hand(rule: Any, expected: str) -> None:
    orders = {"1": {"a": 3, "c": 1}, "2": {"a": 3, "c": 1}, "3": {"a": 1, "b": 2}}
    pods = {"A": {"d": 3}, "B": {"a": 1, "b": 3}, "C": {"a": 4}, "D": {"c": 1}}
    world = small_world(orders, pods, bundle_capacity=2, pod_capacity=10)
    station = world.stations[0]
    assert min(world.pods, key=lambda pod: ticks(world, pod, station)).name == "A"
    world.assign_bundle(world.bundle_arrives(1, 2), station)  # SKUs are d, a, b, c
    (chosen,) = rule.select_replenishment_pods(WarehouseView(world), 1)
    assert world.pods[chosen.pod].name == expected


@cases(
    "rule wrong problem",
    (Cache, {"share": 1.5}, "'share' must be"),
    (Cache, {"threshold": -1}, "'threshold' must be"),
    (Utility, {"corridor": 0}, "'corridor' must be"),
    (Utility, {"buffer": -0.1}, "'buffer' must be"),
    (Utility, {"weight_speed": -1}, "'weight_speed' must be"),
    (TurnoverPod, {"borders": (0.5, 0.4, 1.0)}, "expected shares above 0 that rise to 1"),
    (PodFirst, {"pod": "first-come"}, "first-come"),
)
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, Any], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        rule(**wrong)
