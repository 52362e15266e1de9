"""Features by hand, in a world that is written down in two lines."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from rmfs_commands.gym import FEATURES, Choice
from rmfs_commands.gym.choices import PodChoices, nothing, of_locations, of_orders, of_robots, slots_of
from rmfs_commands.testing import small_world
from rmfs_core.roles import Role
from rmfs_core.warehouse import Warehouse, WarehouseView

ORDERS: dict[str, Any] = {"first": ["a", "b"], "second": {"a": 2}, "third": ["c", "d", "e"], "fourth": ["e"]}
PODS: dict[str, Any] = {"p": {"a": 10, "b": 10}, "q": {"b": 1, "c": 1}, "r": {"d": 1, "e": 5}}


@pytest.fixture
def world() -> Warehouse:
    """Two stations with room for four items; ``first`` is assigned to the first, ``p`` is bound for it."""
    world = small_world(ORDERS, PODS, capacities=(4, 4), due_s={"third": 600.0, "fourth": 0.0})
    world.assign(world.orders[0], world.stations[0], list(dict(world.orders[0].lines)), 1)
    world.bind(world.pods[0], world.stations[0])
    return world


def shown(choice: Choice, slot: int) -> dict[str, float]:
    """Return the features of a slot by name; those that are shown as x / (x + half) as x."""
    found = {}
    for feature, value in zip(FEATURES[choice.decides], choice.observation[slot].tolist(), strict=True):
        found[feature.name] = value if feature.half is None else feature.half * value / (1 - value)
    return found


def test_orders_and_stations(world: Warehouse) -> None:
    """Oldest first, each with the stations where it fits; what pods have for it, how it suits, how urgent it is."""
    choice = of_orders(WarehouseView(world), 50)
    assert choice is not None
    assert (choice.decides, choice.subject) == (Role.POA, None)
    named = {slot: (order.name, station.id) for slot, (order, station) in choice.options.items()}
    assert named == {0: ("second", 0), 1: ("second", 1), 3: ("third", 1), 4: ("fourth", 0), 5: ("fourth", 1)}
    assert np.flatnonzero(choice.mask).tolist() == [0, 1, 3, 4, 5]
    assert shown(choice, 0) == pytest.approx(
        {"available": 2, "items": 2, "share": 1, "common": 1, "waited": 0, "urgency": 0, "load": 0.5, "inbound": 1}
    )
    assert shown(choice, 3) == pytest.approx(
        {"available": 0, "items": 3, "share": 0, "common": 0, "waited": 0, "urgency": 0.5, "load": 0, "inbound": 0}
    )
    assert shown(choice, 4)["urgency"] == 1


def test_no_more_orders_than_are_to_be_shown(world: Warehouse) -> None:
    """The oldest that fit anywhere; one that does not fit takes no slot."""
    choice = of_orders(WarehouseView(world), 1)
    assert choice is not None
    assert {order.name for order, _ in choice.options.values()} == {"second"}
    assert len(choice.mask) == 2
    world.assign(world.orders[2], world.stations[1], [2, 3, 4], 1)
    choice = of_orders(WarehouseView(world), 2)
    assert choice is not None
    assert [(order.name, station.id) for order, station in choice.options.values()] == [
        ("second", 0),
        ("fourth", 0),
        ("fourth", 1),
    ]


def test_no_choice_where_no_order_fits(world: Warehouse) -> None:
    """Both stations have room for one item, and the order that is left has two."""
    world.assign(world.orders[2], world.stations[1], [2, 3, 4], 1)
    world.assign(world.orders[3], world.stations[0], [4], 1)
    assert of_orders(WarehouseView(world), 50) is None


def test_pods_for_a_station(world: Warehouse) -> None:
    """What a pod can serve and complete, how much it is wanted, how far it is; what was chosen before is served."""
    world.assign(world.orders[2], world.stations[1], [2, 3, 4], 1)
    world.assign(world.orders[3], world.stations[1], [4], 1)
    view = WarehouseView(world)
    choices, station, candidates = PodChoices(view), view.stations[1], view.pods[1:]
    choice = choices.among(station, candidates)
    assert (choice.decides, choice.subject) == (Role.PPS, station)
    assert choice.options == {1: view.pods[1], 2: view.pods[2]}
    drive_s = view.travel.times_to(station.cell, True)[view.pods[2].cell].min() / 1000
    assert shown(choice, 1) | {"drive": 0} == pytest.approx(
        {"serves": 1, "completes": 0, "wanted": 2 / 3, "drive": 0, "leaving": 0, "lacking": 4, "inbound": 0, "idle": 1}
    )
    assert shown(choice, 2) == pytest.approx(
        {
            "serves": 3,
            "completes": 1,  # the fourth order, not the third, which needs c, too
            "wanted": 1,
            "drive": drive_s,
            "leaving": 0,
            "lacking": 4,
            "inbound": 0,
            "idle": 1,
        },
        rel=1e-5,
    )
    assert not choice.observation[0].any()
    choices.take(station, view.pods[2])
    after = shown(choices.among(station, candidates[:1]), 1)
    assert (after["serves"], after["completes"], after["lacking"], after["inbound"]) == pytest.approx((1, 1, 1, 1))


def test_locations_for_a_pod(world: Warehouse) -> None:
    """Every free storage location has the slot of its place among all, and how far it is from the pod and stations."""
    robot, pod = world.robots[0], world.pods[0]
    world.take_task(robot, pod)
    world.lift(robot, pod)
    view = WarehouseView(world)
    choice = of_locations(view, pod)
    locations = view.travel.layout.storage_locations
    assert {slot: locations[slot] for slot in choice.options} == choice.options
    assert tuple(choice.options.values()) == view.free_storage_locations
    home = locations.index(view.home(pod))
    assert [slot for slot in choice.options if shown(choice, slot)["home"]] == [home]
    far = max(choice.options, key=lambda slot: shown(choice, slot)["drive"])
    ticks = view.travel.times_from(pod.cell, robot.heading, True)[locations[far]]
    assert shown(choice, far)["drive"] == pytest.approx(ticks / 1000, rel=1e-4)
    nearest = min(view.travel.times_to(s.cell, True)[locations[far]].min() for s in view.stations)
    assert shown(choice, far)["station"] == pytest.approx(nearest / 1000, rel=1e-4)
    assert shown(choice, far)["wanted"] == pytest.approx(1)  # four items: of q and r two and three are wanted
    assert shown(choice, far)["idle"] == 0.5


def test_robots_for_a_pod(world: Warehouse) -> None:
    """How far each is from the pod, and the pod from its station."""
    view = WarehouseView(world)
    pod, (robot, _) = view.pods[0], view.robots
    choice = of_robots(view, pod, view.robots)
    assert choice.options == dict(enumerate(view.robots))
    travel = view.travel
    expected = {
        "drive": travel.ticks(robot.cell, robot.heading, pod.cell, False) / 1000,
        "carry": travel.times_to(view.stations[0].cell, True)[pod.cell].min() / 1000,
        "line": 0,
        "waiting": 1,
        "idle": 1,
    }
    assert shown(choice, 0) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("decides", "slots"), [(Role.POA, 14), (Role.PPS, 3), (Role.TA, 2), (Role.PR, None)], ids=str)
def test_a_run_that_is_over_has_nothing_to_choose(world: Warehouse, decides: Role, slots: int | None) -> None:
    """The slots are those of every choice before, and all are empty."""
    view = WarehouseView(world)
    number = slots_of(decides, view, 7)
    assert number == (slots or len(view.travel.layout.storage_locations))
    choice = nothing(decides, number)
    assert choice.observation.shape == (number, len(FEATURES[decides]))
    assert not choice.observation.any()
    assert not choice.mask.any()


def test_features_are_told_apart_by_name() -> None:
    """Each decision's names are there once."""
    for features in FEATURES.values():
        assert len({feature.name for feature in features}) == len(features)
