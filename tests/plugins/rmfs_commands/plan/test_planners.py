"""Planners by name: any PP rule, asked through its hook, and held to what it answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from reserving import hold_until
from rmfs_commands.plan import find_planner, plan_trips, random_trips, read_map, roads_of_map
from rmfs_core.errors import InputError, RunError
from rmfs_core.traffic import Query, Reservations
from rmfs_core.world import EAST, parse_map

ROOM = "type octile\nheight 4\nwidth 8\nmap\n........\n.@@..@@.\n........\nTT....OO\n"
ROADS = roads_of_map(parse_map("......\n......", "hall"))


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A MovingAI map."""
    (tmp_path / "room.map").write_text(ROOM, encoding="utf-8")
    return tmp_path / "room.map"


def rng() -> np.random.Generator:
    """For rules that want one."""
    return np.random.default_rng(0)


def test_a_rule_from_a_file_plans(room: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A user's own class with a search is a planner like the shipped ones."""
    (room.parent / "mine.py").write_text(
        "from attrs import define\nfrom rmfs_rules.sipp import Sipp\n\n\n@define\nclass Mine(Sipp):\n    pass\n",
        encoding="utf-8",
    )
    monkeypatch.chdir(room.parent)
    planner = find_planner("./mine.py:Mine", {}, rng())
    roads = roads_of_map(read_map(room))
    plans = plan_trips(roads, planner, random_trips(roads, 5, 2, "room"))
    assert planner.exclusive
    assert all(plan.arrived for plan in plans)


def test_an_impossible_path_of_a_rule_is_an_error(room: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A rule that answers its hook with nonsense is named."""
    (room.parent / "wild.py").write_text(
        "from attrs import define\nfrom rmfs_core import Leg, Path, hookimpl\n\n\n@define\nclass Wild:\n"
        "    @hookimpl\n    def plan_path(self, goal):\n        return Path((Leg(goal),))\n",
        encoding="utf-8",
    )
    roads = roads_of_map(read_map(room))
    monkeypatch.chdir(room.parent)
    planner = find_planner("./wild.py:Wild", {}, rng())
    with pytest.raises(RunError, match=r"Wild.* gave robot 1 \(id 0\) an impossible path: .* is no straight run"):
        planner.search(roads, Reservations(roads.cells), Query(0, 0, 0, 0, 23))


@pytest.mark.parametrize(("name", "exclusive"), [("sipp", True), ("whca-n", True), ("free-flow", False)])
def test_planners_keep_clear_of_others_or_do_not(name: str, exclusive: bool) -> None:
    """Who reserves waits for the robot in the way; who does not drives through it, as fast as alone."""
    planner = find_planner(name, {}, rng())
    table = Reservations(ROADS.cells)
    hold_until(table, 1, 2, 0, 30_000)
    hold_until(table, 1, 8, 0, 30_000)
    query = Query(0, 0, EAST, 500, 5)
    path = planner.search(ROADS, table, query)
    assert planner.exclusive is exclusive
    assert path is not None
    alone = 500 + ROADS.travel.ticks(0, EAST, 5, False)
    assert (path.end_tick == alone) == (not exclusive)
    empty = planner.search(ROADS, Reservations(ROADS.cells), query)
    assert empty is not None
    assert empty.end_tick == alone


def test_no_path_is_an_answer_of_rules_that_reserve() -> None:
    """Behind a robot that stays there is none."""
    table = Reservations(ROADS.cells)
    table.hold(1, 2, 0)
    table.hold(1, 8, 0)
    assert find_planner("sipp", {}, rng()).search(ROADS, table, Query(0, 0, EAST, 0, 5)) is None


def test_who_plans_for_a_fleet_is_asked_for_one() -> None:
    """The path is that of `sipp`, and leads to the goal; behind a robot that stays there is none."""
    planner, table, query = find_planner("pbs", {}, rng()), Reservations(ROADS.cells), Query(0, 0, EAST, 0, 5)
    assert planner.complete
    assert planner.search(ROADS, table, query) == find_planner("sipp", {}, rng()).search(ROADS, table, query)
    table.hold(1, 2, 0)
    table.hold(1, 8, 0)
    assert planner.search(ROADS, table, query) is None


def test_who_is_there_already_has_nothing_to_drive() -> None:
    """Neither is a rule that does not reserve asked, nor does one that reserves find legs."""
    for name in ("free-flow", "sipp", "pbs"):
        path = find_planner(name, {}, rng()).search(ROADS, Reservations(ROADS.cells), Query(0, 3, EAST, 700, 3))
        assert path is not None
        assert (path.legs, path.end, path.end_tick) == ((), 3, 700)


@pytest.mark.parametrize(
    ("name", "parameters", "problem"),
    [
        ("sip", {}, r'--pp: there is no rule "sip"'),
        ("demand", {}, r"decides PPS; expected a rule for PP"),
        ("whca-n", {"window": 3}, r"--pp.window"),
        ("whca-n", {"window_s": -3.0}, r"expected a number > 0"),
    ],
)
def test_what_is_no_planner_is_refused(name: str, parameters: dict[str, float], problem: str) -> None:
    """As a scenario's `rules.pp` would be, at the place of the option."""
    with pytest.raises(InputError, match=problem):
        find_planner(name, parameters, rng())
