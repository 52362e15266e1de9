"""Driving full paths: robots wait where they block nobody, and overtake on the way to a station."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from corridor import CORRIDOR, INSTANCE, inline
from rmfs_commands.layouts import parse_map
from rmfs_core.errors import RuleError
from rmfs_core.events import Event, OrderCompleted, PodLifted, VisitEnded, VisitStarted
from rmfs_core.simulation.driving.complete import CompleteDriving
from rmfs_core.simulation.driving.reserved import Course
from rmfs_core.traffic import Query
from rmfs_core.world import check_layout


def test_sipp_passes_a_corridor_for_one(tiny_run: Callable[..., Any]) -> None:
    """Where only one robot at a time can pass, `sipp` lets the others wait where they block nobody."""
    check_layout(CORRIDOR, "corridor")
    tiny = tiny_run(INSTANCE, capacity=3, robots=3, layout=CORRIDOR, queue_length=1, pp="sipp")
    tiny.simulation.run()
    assert len(tiny.recorder.of(OrderCompleted)) == 16


class Overtaking:
    """Observer of the order in which pods that came straight from storage are served at each station."""

    def __init__(self) -> None:
        self.lifted: dict[int, int] = {}
        self.served: dict[int, list[int]] = {}
        """When each pod was lifted, by station, as they are served."""

    @rmfs_core.hookimpl
    def on_event(self, event: Event) -> None:
        """Note pods as they are lifted and served."""
        if isinstance(event, PodLifted):
            self.lifted[event.pod] = event.tick
        elif isinstance(event, VisitStarted) and event.pod in self.lifted:
            self.served.setdefault(event.station, []).append(self.lifted.pop(event.pod))


def test_who_comes_first_goes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """Robots with sipp overtake others on the way to a station; where that fails, all reservations are as before."""
    both = CompleteDriving.both
    tried = []

    def checked(driving: CompleteDriving, course: Course, first: Query, ahead: Course, second: Query) -> Any:
        def ahead_of_now() -> list[list[tuple[int, int, int]]]:
            now = driving.run.warehouse.now
            cells = range(driving.roads.cells)
            return [[entry for entry in driving.table.reserved(cell) if entry[2] > now] for cell in cells]

        before = ahead_of_now()
        paths = both(driving, course, first, ahead, second)
        tried.append(paths is not None)
        assert paths is not None or ahead_of_now() == before
        return paths

    monkeypatch.setattr(CompleteDriving, "both", checked)
    observer = Overtaking()
    settings = ["rules.pp=sipp", "robots.count=24", "instance.orders=60", "stations.pick_s=1.0"]
    result = rmfs_core.run("paper-250", seed=2, overrides=settings, observers=[observer])
    assert result.status == "complete"
    assert {True, False} == set(tried)
    assert any(lifted != sorted(lifted) for lifted in observer.served.values())


STRAIGHT = """
#####@@@@...
.....@......
.→→→{}O>>....
.....@......
............
"""


@pytest.mark.parametrize(("sign", "least_ticks"), [("→", 1415 + 2000), ("⇒", 2829)])
def test_the_next_pod_rolls_in_over_a_clear_cell(tiny_run: Callable[..., Any], sign: str, least_ticks: int) -> None:
    """A pod drives off straight; the next comes from rest next to the station, or on the move from farther back."""
    layout = parse_map(STRAIGHT.format(sign), "straight")
    check_layout(layout, "straight")
    tiny = tiny_run(INSTANCE, capacity=3, robots=3, layout=layout, queue_length=3, pp="sipp")
    tiny.simulation.run()
    begins = [event.tick for event in tiny.recorder.of(VisitStarted)][1:]
    ends = [event.tick for event in tiny.recorder.of(VisitEnded)]
    assert min(begin - end for begin, end in zip(begins, ends, strict=False)) == least_ticks


def test_a_full_path_ends_at_the_goal(tiny_run: Callable[..., Any], tmp_path: Path) -> None:
    """A rule that promises full paths and stops short is refused."""
    tiny = tiny_run(INSTANCE, capacity=3, robots=1, pp=inline(tmp_path, "full paths", "legs[:-1]"))
    with pytest.raises(RuleError, match=r"gave robot 1 a path that ends at row .*, not at its goal row|an empty path"):
        tiny.simulation.run()
