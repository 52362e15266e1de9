"""The warehouse at time 0."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from bad_rules import write_rule
from rmfs_commands.testing import small_instance, small_layout
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import (
    InstanceSection,
    LayoutSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    Scenario,
    StationsSection,
)
from rmfs_core.simulation.setup import motion_of, open_warehouse
from rmfs_core.warehouse import Warehouse
from rmfs_core.world import Instance


def test_a_need_that_is_not_met_is_refused(tiny_run: Callable[..., Any], tmp_path: Path) -> None:
    """A rule that declares unlimited stock as its need is not run on an instance with finite stock."""
    name = write_rule(tmp_path, "poa", "return []")
    (tmp_path / "bad.py").write_text(
        (tmp_path / "bad.py").read_text().replace("class Bad:", "class Bad:\n    needs = ('unlimited stock',)")
    )
    with pytest.raises(InputError, match=r"rules\.poa: rule .* needs pods whose SKUs never run out, but"):
        tiny_run(small_instance({"1": ["a"]}, {"p": {"a": 3}}), poa=name)


RULES = RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand"))
PODS = small_instance({"1": ["a"]}, {"p": ["a"], "q": ["a"], "r": ["a"]})


def scenario(seed: int = 1, **sections: Any) -> Scenario:
    """Return a scenario for two stations with queues of three, three robots, and half of the locations filled."""
    given = {
        "layout": LayoutSection(pod_fill=0.5),
        "robots": RobotsSection(count=3),
        "stations": StationsSection(queue_length=3),
    }
    return Scenario(rules=RULES, seed=seed, **(given | sections))


def refusal(given: Scenario, instance: Instance = PODS) -> str:
    """Return why a warehouse cannot be opened."""
    with pytest.raises(InputError) as caught:
        open_warehouse(given, instance, small_layout(2))
    return str(caught.value)


def test_pods_and_robots_get_places_of_their_own() -> None:
    """All in storage locations, no two pods in one; empty pods stand in the way until the share is reached."""
    layout = small_layout(2)
    locations = layout.storage_locations
    world = open_warehouse(scenario(), PODS, layout).warehouse
    places = [*world.homes, *world.blocked]
    assert len(places) == len(set(places)) == len(locations) // 2
    assert set(places) | set(world.free_locations) == set(locations)
    assert not set(places) & set(world.free_locations)
    robots = [robot.cell for robot in world.robots]
    assert len(set(robots)) == 3
    assert set(robots) <= set(locations)
    assert robots != list(world.homes)  # where they stand has nothing to do with where the first pods do
    assert [pod.location for pod in world.pods] == list(world.homes)


def placed(*places: tuple[int, int]) -> Instance:
    """Return the instance with pods that a file gives places, rows and columns from 1."""
    pods = zip(PODS.pods, places, strict=True)
    return evolve(PODS, pods=tuple(evolve(pod, place=(*at, f"line {at}")) for pod, at in pods))


def test_pods_and_robots_stand_where_files_say(tmp_path: Path) -> None:
    """Pods in storage locations; robots, the first `count` of them, anywhere but in walls; empty pods beside them."""
    layout = small_layout(2)
    cells = layout.storage_locations[3:6]
    at = [(cell // layout.width + 1, cell % layout.width + 1) for cell in cells]
    (tmp_path / "robots.csv").write_text("robot,row,column\n" + "".join(f"{i},2,{i}\n" for i in range(1, 6)))
    given = evolve(scenario(robots=RobotsSection(count=3, file="robots.csv")), folder=str(tmp_path))
    world = open_warehouse(given, placed(*at), layout).warehouse
    assert world.homes == cells
    assert len({*world.homes, *world.blocked}) == len(layout.storage_locations) // 2
    assert [robot.cell for robot in world.robots] == [layout.width, layout.width + 1, layout.width + 2]


def test_places_that_nothing_can_stand_in_are_refused(tmp_path: Path) -> None:
    """No storage location, one that another pod has, one beyond the layout; too few robots, and two in a cell."""
    layout = small_layout(2)
    first = layout.storage_locations[0]
    good, floor = (first // layout.width + 1, first % layout.width + 1), (1, 1)
    expected = "; expected a storage location that no line before names"
    assert refusal(scenario(), placed(good, floor, good)) == f"line (1, 1): found row 1, column 1{expected}"
    assert refusal(scenario(), placed(good, good, floor)).endswith(expected)
    assert refusal(scenario(), placed((1, layout.width + good[1]), good, floor)).endswith(expected)
    file = tmp_path / "robots.csv"
    file.write_text("robot,row,column\n1,2,1\n2,2,1\n")
    given = evolve(scenario(robots=RobotsSection(count=2, file="robots.csv")), folder=str(tmp_path))
    assert refusal(given) == (
        f"{file}, line 3: found row 2, column 1; expected a cell of the layout, no wall, that no line before names"
    )
    file.write_text("robot,row,column\n1,2,1\n")
    assert refusal(given) == "robots.count: found 2; robots.csv places 1"


def test_more_pods_with_contents_than_the_share_all_stand_there() -> None:
    """The share is of pods in all, with contents or not."""
    world = open_warehouse(scenario(layout=LayoutSection(pod_fill=0.01)), PODS, small_layout(2)).warehouse
    assert (len(world.homes), world.blocked) == (3, ())


def test_places_depend_on_the_seed_alone() -> None:
    """Pods stand in the same places whatever robots there are, and the other way round: runs are compared in pairs."""
    layout = small_layout(2)

    def opened(given: Scenario) -> Warehouse:
        return open_warehouse(given, PODS, layout).warehouse

    one, other = opened(scenario()), opened(scenario(robots=RobotsSection(count=5), layout=LayoutSection(pod_fill=0.9)))
    assert one.homes == other.homes
    assert [robot.cell for robot in one.robots] == [robot.cell for robot in other.robots][:3]
    again = opened(scenario(seed=2))
    assert again.homes != one.homes
    assert [robot.cell for robot in again.robots] != [robot.cell for robot in one.robots]


def test_robots_move_as_the_scenario_says() -> None:
    """Every key of the section that is about motion."""
    section = RobotsSection(acceleration_m_per_s2=0.5, top_speed_m_per_s=2.0, full_turn_s=4.0, lift_s=3.0)
    motion = motion_of(section)
    assert (motion.acceleration_m_per_s2, motion.top_speed_m_per_s) == (0.5, 2.0)
    assert (motion.turn_ticks(0, 2), motion.lift_ticks) == (2000, 3000)
    assert (
        open_warehouse(scenario(robots=section), small_instance({}, {}), small_layout()).warehouse.travel.motion
        == motion
    )


@pytest.mark.parametrize(
    ("stations", "expected"),
    [
        (StationsSection(queue_length=3, item_capacity=7), [(7, False), (7, False)]),
        (StationsSection(queue_length=3, item_capacity=(7, 2)), [(7, False), (2, False)]),
        (StationsSection(queue_length=3, item_capacity=7, order_capacity=4), [(4, True), (4, True)]),
        (StationsSection(queue_length=3, order_capacity=(4, 5)), [(4, True), (5, True)]),
    ],
)
def test_stations_count_items_or_orders(stations: StationsSection, expected: list[tuple[int, bool]]) -> None:
    """One capacity for all, or each its own; orders count where they are given."""
    world = open_warehouse(scenario(stations=stations), PODS, small_layout(2)).warehouse
    assert [(station.capacity, station.counts_orders) for station in world.stations] == expected
    assert [station.queue_length for station in world.stations] == [3, 3]


@pytest.mark.parametrize(
    ("sections", "message"),
    [
        (
            {"robots": RobotsSection(count=99)},
            "robots.count: found 99 robots; the layout has 80 storage locations to park them",
        ),
        (
            {"stations": StationsSection(item_capacity=(1, 2, 3))},
            "stations.item_capacity: found 3 capacities, but the layout has 2 picking stations",
        ),
        (
            {"stations": StationsSection(order_capacity=(1,))},
            "stations.order_capacity: found 1 capacities, but the layout has 2 picking stations",
        ),
        (
            {"instance": InstanceSection(pods_at_stations={"3": ("p",)})},
            "instance.pods_at_stations.3: no station 3; expected 1 to 2",
        ),
        (
            {"instance": InstanceSection(pods_at_stations={"west": ("p",)})},
            "instance.pods_at_stations.west: no station west; expected 1 to 2",
        ),
        (
            {
                "instance": InstanceSection(pods_at_stations={"2": ("p", "q", "r")}),
                "stations": StationsSection(queue_length=1),
            },
            "instance.pods_at_stations.2: found 3 pods; the station and its queue hold 2",
        ),
        (
            {
                "instance": InstanceSection(pods_at_stations={"1": ("p",), "2": ("q",)}),
                "robots": RobotsSection(count=1),
            },
            "instance.pods_at_stations: found 2 pods at stations, but robots.count = 1; each needs a robot",
        ),
    ],
)
def test_what_has_no_place_is_refused(sections: dict[str, Any], message: str) -> None:
    """The key is named, with what was found and what there is room for."""
    assert refusal(scenario(**sections)) == message


def test_more_pods_than_storage_locations_are_refused() -> None:
    """Both numbers are named."""
    many = small_instance({}, {str(i): ["a"] for i in range(81)})
    assert refusal(scenario(), many) == "instance.pods: found 81 pods, but the layout has 80 storage locations"


def test_pods_at_stations_are_told_first_in_line_first() -> None:
    """By the ids of station and pod; they are placed when the run begins."""
    at = InstanceSection(pods_at_stations={"2": ("r", "p"), "1": ("q",)})
    opening = open_warehouse(scenario(instance=at), PODS, small_layout(2))
    assert opening.at_stations == ((1, 2), (1, 0), (0, 1))
    assert all(pod.location is not None for pod in opening.warehouse.pods)
