"""The start of a run held against what its scenario makes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.trace import read_trace
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.case import Case
from rmfs_commands.validation.opening import check_opening, made_alike
from rmfs_core.world import StationCells


def faults(trace: Trace) -> list[str]:
    """Return the sentences on the start."""
    case = Case(trace)
    check_opening(case)
    return [fault.sentence for fault in case.faults]


def says(trace: Trace, section: str, **keys: object) -> Trace:
    """Return the trace with other keys in a section of its scenario."""
    return evolve(trace, scenario={**trace.scenario, section: {**trace.scenario[section], **keys}})


def test_a_run_starts_as_its_scenario_says(recorded: Trace) -> None:
    """A block layout with generated orders is made anew, whole."""
    assert faults(recorded) == []


@pytest.mark.parametrize(
    "overrides",
    [
        ("instance.pods_at_stations={2 = ['4'], 1 = ['1', '2']}",),
        ("layout.pod_fill=1.0",),
        ("robots.count=40",),
    ],
)
def test_places_are_made_anew(tmp_path: Path, overrides: tuple[str, ...]) -> None:
    """Pods at stations from the start with their robots, no free place, and robots at many places."""
    few = ("instance.orders=2", "rules.pp=free-flow", *overrides)
    rmfs_core.run("examples/small", overrides=few, out=tmp_path, record=["trace"])
    assert faults(read_trace(tmp_path / "trace.jsonl.gz")) == []


def test_a_map_is_read_from_the_header(tmp_path: Path) -> None:
    """The file need not be there; other text is another layout, and shorter queues are told."""
    few = ("instance.orders=2", "rules.pp=free-flow")
    rmfs_core.run("examples/text-map", overrides=few, out=tmp_path, record=["trace"])
    trace = read_trace(tmp_path / "trace.jsonl.gz")
    assert trace.map_text is not None
    assert faults(trace) == []
    assert faults(evolve(trace, map_text=None)) == []
    assert faults(evolve(trace, map_text=trace.map_text.replace("<", ".", 1))) == [
        "row 3, column 16 is left by 14; the scenario says 15, and 1 more"
    ]
    assert faults(evolve(trace, map_text=f"{trace.map_text}@@@@@@@@@@@@@@@@@@@@")) == [
        "the layout has 20 x 10 cells; the scenario says 20 x 11"
    ]
    assert faults(says(trace, "stations", queue_length=4)) == [
        "nothing can be run as the scenario says: stations.queue_length: found 4, but the queue of station 1 in "
        "text-map-hall.txt has 3 cells; expected at most that many"
    ]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda t: evolve(t, scenario={**t.scenario, "seed": 9}), "the orders are others than the scenario makes: "),
        (lambda t: evolve(t, robots=t.robots[:-1]), "the places of robots are 3; the scenario makes 4"),
        (lambda t: evolve(t, blocked=t.blocked[1:]), "the empty pods are "),
        (
            lambda t: evolve(
                t, layout=evolve(t.layout, stations=(t.layout.stations[0], StationCells(0, t.layout.stations[1].queue)))
            ),
            "stations and queues have other cells than the scenario says",
        ),
        (lambda t: says(t, "robots", count=-1), "nothing can be run as the scenario says: header of the trace"),
    ],
)
def test_other_starts_are_told(recorded: Trace, change: Callable[[Trace], Trace], sentence: str) -> None:
    """With what there is and what there would be."""
    assert [told for told in faults(change(recorded)) if told.startswith(sentence)]


def test_only_what_the_same_versions_recorded_is_made_anew(recorded: Trace) -> None:
    """The header says which; if it does not, the result beside it."""
    assert made_alike(recorded, None)
    assert not made_alike(evolve(recorded, versions={**recorded.versions, "numpy": "1.0"}), None)
    untold = evolve(recorded, versions={})
    assert not made_alike(untold, None)
    assert made_alike(untold, {"versions": {**recorded.versions, "click": "8"}})
