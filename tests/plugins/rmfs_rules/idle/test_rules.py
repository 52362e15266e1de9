"""Rules for robots without a task."""

from __future__ import annotations

from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.states.plain import Memento
from rmfs_commands.states.restoring import restore
from rmfs_commands.testing import check_rule, small_layout, small_world
from rmfs_core import RobotMove
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_core.world import parse_map
from rmfs_rules.idle import ChargeWhenLow, RestMiddle, RestNearest, Stay

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
def test_it_conforms(rule: object) -> None:
    """Possible, repeatable, and no order starves."""
    check_rule(rule)


def test_a_robot_beneath_a_pod_goes_to_the_nearest_free_location() -> None:
    """By driving time; one that rests where no pod stands stays, and so does one with a battery too low for a task."""
    first, second, last = HALL.storage_locations[0], HALL.storage_locations[1], HALL.storage_locations[-1]
    view = view_of(4, {0: {"cell": first}, 1: {"cell": last}, 2: {"cell": second, "charge": 0.1, "low": True}}, HALL)
    (move,) = RestNearest().idle_robots(view)
    times = view.travel.times_from(first, view.robots[0].heading, False)
    free = [cell for cell in view.free_storage_locations if cell != last]
    assert move == RobotMove(0, min(free, key=lambda cell: (int(times[cell]), cell)))


def test_robots_rest_in_the_middle() -> None:
    """Each in a location of its own, the nearest to the middle of the grid first."""
    first, second, *_ = HALL.storage_locations
    view = view_of(2, {0: {"cell": first}, 1: {"cell": second}}, HALL)
    middle = HALL.height // 2 * HALL.width + HALL.width // 2
    best = sorted(view.free_storage_locations, key=lambda cell: (HALL.distance(cell, middle), cell))
    assert RestMiddle().idle_robots(view) == [RobotMove(0, best[0]), RobotMove(1, best[1])]


def test_those_with_the_least_charge_go_to_the_chargers() -> None:
    """The others wait: two chargers, three robots; nobody with enough goes."""
    cells = HALL.storage_locations
    robots = {i: {"cell": cells[i], "charge": charge} for i, charge in enumerate([0.25, 0.05, 0.2, 0.31])}
    moves = ChargeWhenLow(low=0.3, full=0.9).idle_robots(view_of(5, robots, HALL))
    assert [(move.robot, move.charge) for move in moves] == [(1, 0.9), (2, 0.9)]
    assert {move.cell for move in moves} == {*HALL.chargers}


def test_who_is_charged_makes_way_for_others() -> None:
    """It goes where no pod stands; while nobody waits, and while it still charges, it stays."""
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
    """Their charge is None."""
    assert ChargeWhenLow().idle_robots(view_of(2, {0: {}, 1: {}}, HALL)) == []


@pytest.mark.parametrize(
    ("low", "full", "problem"),
    [(0.5, 0.5, "expected low below full"), (0.1, 1.5, "at most 1"), (-0.1, 0.5, "low")],
)
def test_wrong_parameters(low: float, full: float, problem: str) -> None:
    """What would be right is said."""
    with pytest.raises(ValueError, match=problem):
        ChargeWhenLow(low, full)


def test_a_run_with_few_chargers() -> None:
    """Robots charge, more than once, and every order is completed."""
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
