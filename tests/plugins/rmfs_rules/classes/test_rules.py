"""PR rules station-based, turnover-classes, cache and utility: parameters, and what they keep from call to call."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.testing import check_rule, small_world
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.classes import Cache, TurnoverClasses, Utility

PutAtStation = Callable[[Warehouse, int, int], None]


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


def test_speed_and_demand_can_be_told_apart(put_at_station: PutAtStation) -> None:
    """Nothing of `a` is open any more: by speed pod 0 comes before pod 1, by demand after it."""
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
    """Before the run."""
    (name,) = wrong
    with pytest.raises(ValueError, match=f"'{name}' must be"):
        rule(**wrong)


def test_a_large_cache_conforms() -> None:
    """Every place belongs to one."""
    assert check_rule(Cache(share=1.0, threshold=0.1)).findings == ()


class Doubter:
    """Observer that has each place chosen once more, by a rule that remembers nothing."""

    def __init__(self, rule: type[Any]) -> None:
        self.rule, self.places = rule, 0

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        if question.decides is Role.PR:
            assert answer == self.rule().choose_storage_location(question.warehouse, question.arguments["pod"])
            self.places += 1


@pytest.mark.parametrize("rule", [TurnoverClasses, Cache, Utility])
@pytest.mark.parametrize("scenario", ["examples/small", "examples/replenished"])
def test_what_is_kept_decides_as_what_is_read_anew(rule: type[Any], scenario: str) -> None:
    """In whole runs: orders arrive, and pods come and go, are moved, and are given SKUs that they never held."""
    doubter = Doubter(rule)
    rules = {"pr": (chosen := rule()), **({"move": chosen} if hasattr(chosen, "move_pods") else {})}
    overrides = ["run.until_s=3000", "rules.pp=free-flow", "robots.count=8"]
    rmfs_core.run(scenario, overrides=overrides, rules=rules, observers=[doubter])
    assert doubter.places > 10
