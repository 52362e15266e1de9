"""Driving paths planned for all robots at once: what is asked, what is refused, and who is put off how often."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path as File
from typing import Any, ClassVar

import pytest
from attrs import define

import rmfs_core
from corridor import CORRIDOR, INSTANCE
from rmfs_core import Leg, Path, hookimpl
from rmfs_core.errors import InputError, RuleError
from rmfs_core.events import OrderCompleted
from rmfs_core.scenario.model import RuleChoice
from rmfs_core.traffic import FleetTraffic, Query, occupancy, timed_path
from rmfs_rules.sipp import Pbs, Sipp

RULE = """
from attrs import define
from rmfs_core import Leg, Path, hookimpl

@define
class Mine:
    reserves = "fleet"

    @hookimpl
    def {hook}(self, warehouse, queries, traffic):
        found = {{}}
        for query in queries:
            loaded = query.loaded
            found[query.robot] = Path(warehouse.travel.fastest_path(query.cell, query.heading, query.goal, loaded))
        return {answer}
"""


def mine(folder: File, answer: str = "found", hook: str = "plan_paths") -> RuleChoice:
    """Write a rule that heeds nobody and answers so."""
    (folder / "mine.py").write_text(RULE.format(answer=answer, hook=hook), encoding="utf-8")
    return RuleChoice("./mine.py:Mine")


def test_robots_pass_a_corridor_for_one(tiny_run: Callable[..., Any]) -> None:
    """Where only one robot at a time can pass, the others wait where they block nobody."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=3, layout=CORRIDOR, queue_length=1, pp="pbs")
    tiny.simulation.run()
    assert len(tiny.recorder.of(OrderCompleted)) == 16


@pytest.mark.parametrize(
    ("answer", "problem"),
    [
        ("{}", r"left out robot \d, which needs a path"),
        ("list(found.values())", r"returned list .*; expected dict"),
        ("{robot: path.legs for robot, path in found.items()}", r"returned tuple .*; expected Path"),
        ("{**found, 17: Path(())}", "answered for 17, a robot that it was not asked for"),
        (
            "{robot: Path(path.legs[:1]) for robot, path in found.items()}",
            "a path that ends at row .*, not at its goal",
        ),
    ],
)
def test_answers_that_cannot_be_driven_are_refused(
    answer: str, problem: str, tiny_run: Callable[..., Any], tmp_path: File
) -> None:
    """The rule is named, with its hook and what was wrong."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=1, pp=mine(tmp_path, answer))
    with pytest.raises(RuleError, match=rf"mine.py.*, plan_paths, at 0\.000 s: .*{problem}"):
        tiny.simulation.run()


def test_paths_are_held_against_each_other(tiny_run: Callable[..., Any], tmp_path: File) -> None:
    """Paths of one answer may hit each other as little as what others have reserved."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=4, layout=CORRIDOR, queue_length=1, pp=mine(tmp_path))
    with pytest.raises(RuleError, match=r"plan_paths, .* a path that hits a reservation: robot \d has row \d+"):
        tiny.simulation.run()


def test_a_rule_for_fleets_has_the_hook_for_them(tiny_run: Callable[..., Any], tmp_path: File) -> None:
    """Which hook goes with what a rule reserves is said before the run."""
    (tmp_path / "mine.py").write_text(RULE.format(answer="found", hook="plan_path").replace("queries, ", ""))
    expected = r"rules.pp: rule .* has reserves = 'fleet' and no hook `plan_paths`, which that goes with"
    with pytest.raises(InputError, match=expected):
        tiny_run(INSTANCE, capacity=3, robots=1, pp=RuleChoice("./mine.py:Mine"))


@define
class LetsOthersWait:
    """Plans as `pbs`, and lets whoever may keep its path wait a second longer each time."""

    reserves: ClassVar[str] = "fleet"
    put_off: ClassVar[dict[int, int]] = {}
    most: ClassVar[list[int]] = []

    @hookimpl
    def plan_paths(self, queries: Sequence[Query], traffic: FleetTraffic) -> dict[int, Path]:
        """Plan for all anew, those who set out first; count how often each may be put off on the way to one goal."""
        table, paths = traffic.table.copy(), Pbs(most_nodes=0).plan_paths(queries, traffic)
        for query in queries:
            if query.robot in paths:
                self.put_off[query.robot] = 0
                path = Sipp().search(traffic.roads, table, query)
                assert path is not None
                table.release(query.robot)
                if query.robot in traffic.under_way:
                    table.add(query.robot, traffic.under_way[query.robot])
                table.add(query.robot, occupancy(traffic.roads, path))
        for query in queries:
            if query.robot in traffic.arrives:
                later = Sipp().search(traffic.roads, table, query)
                assert later is not None
                first, *rest = later.legs
                waits = Path((Leg(first.to, first.wait_ticks + 1000), *rest))
                taken = occupancy(traffic.roads, timed_path(traffic.roads, query, waits.legs))
                if table.is_free(query.robot, taken):
                    paths[query.robot] = waits
                    table.release(query.robot)
                    if query.robot in traffic.under_way:
                        table.add(query.robot, traffic.under_way[query.robot])
                    table.add(query.robot, taken)
                    self.put_off[query.robot] += 1
                    self.most.append(self.put_off[query.robot])
        return paths


def test_nobody_is_put_off_for_ever() -> None:
    """A robot arrives later as often as there are robots at most; all arrive, though their rule lets them wait."""
    LetsOthersWait.put_off.clear()
    LetsOthersWait.most.clear()
    overrides = ["robots.count=3", "stations.pick_s=1"]
    result = rmfs_core.run("examples/small", rules={"pp": LetsOthersWait()}, overrides=overrides)
    assert result.status == "complete"
    assert max(LetsOthersWait.most) == 3
