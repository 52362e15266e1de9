"""The start of a run: what its header names, where everything is, and what its scenario makes."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from calling import refusal
from cases import cases
from damage import Damage, told
from rmfs_commands.trace import read_trace
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.case import Case, avoids_collisions
from rmfs_commands.validation.header import check_readable
from rmfs_commands.validation.opening import check_opening, made_alike
from rmfs_commands.validation.state import State
from rmfs_core.errors import InputError
from rmfs_core.motion import Motion
from rmfs_core.world import WEST, OrderData, PodData, StationCells


def test_stations_of_the_scenario(day: Trace) -> None:
    stations = {name: value for name, value in day.scenario["stations"].items() if name != "queue_length"}
    shortest = min(len(cells.queue) for cells in day.layout.stations)
    assert Case(evolve(day, scenario={**day.scenario, "stations": stations})).queue_length == shortest < 12
    stations = {**day.scenario["stations"], "item_capacity": [15]}
    assert told(evolve(day, scenario={**day.scenario, "stations": stations})) == []


@pytest.mark.parametrize("key", ["pick_s", "handle_s"])
def test_a_scenario_without_its_stations_is_refused(day: Trace, key: str) -> None:
    stations = {name: value for name, value in day.scenario["stations"].items() if name != key}
    with pytest.raises(InputError, match=f"^header of the trace: the scenario lacks '{key}' among its stations$"):
        Case(evolve(day, scenario={**day.scenario, "stations": stations}))


@cases(
    "rules expected",
    ({"pp": "free-flow"}, False),
    ({"pp": {"rule": "free-flow"}}, False),
    ({"pp": "sipp"}, True),
    ({"pp": {"rule": "whca-n", "window_s": 9}}, True),
    ({}, True),
)
def test_only_free_flow_ignores_other_robots(day: Trace, rules: Mapping[str, Any], expected: bool) -> None:
    """Written by its name or as a table; whoever plans in another way is held to it."""
    assert avoids_collisions(evolve(day, scenario={**day.scenario, "rules": rules})) is expected


HERE = 27
"""Where P0 stands at the start of the day."""


@pytest.fixture
def state(day: Trace) -> State:
    return State(evolve(day, robots=(*day.robots, {"cell": 0, "heading": 2})))


def test_pods_may_be_at_a_station_from_the_start(day: Trace) -> None:
    at_station, in_queue = {"cell": 39, "heading": 0}, {"cell": 38, "heading": 0}
    pods = ({"cell": 38, "robot": 0, "bound_for": [0]}, {"cell": 39, "robot": 1, "bound_for": [0]})
    state = State(evolve(day, robots=(in_queue, at_station), pods=pods))
    assert state.stations[0].line == [1, 0]
    assert state.stored == {}
    assert [(robot.pod, robot.task) for robot in state.robots] == [(0, 0), (1, 1)]
    assert [(pod.bound, pod.next_station) for pod in state.pods] == [([(0, 0)], 0)] * 2


def test_who_has_a_pod(state: State) -> None:
    state.take(0, 0)
    state.take(1, 0)
    assert (state.robots[0].pod, state.robots[1].pod, state.pods[0].robot) == (None, 0, 1)
    state.take(1, 1)
    assert (state.pods[0].robot, state.pods[1].robot, state.robots[1].pod) == (None, 1, 1)
    state.take(1, None)
    assert (state.pods[1].robot, state.robots[1].pod) == (None, None)
    state.put(1, HERE)
    state.take(0, 0)
    assert state.stored[HERE] == 1


def places(trace: Trace, **parts: dict[str, Any]) -> Trace:
    return evolve(trace, **{name: ({**getattr(trace, name)[0], **part},) for name, part in parts.items()})


UNREADABLE: list[tuple[Damage, str]] = [
    (lambda t: places(t, robots={"cell": 48}), "found cell 48; expected a whole number from 0 to 47"),
    (lambda t: places(t, robots={"cell": "a"}), "found cell 'a'; expected a whole number from 0 to 47"),
    (lambda t: places(t, robots={"heading": 4}), "found heading 4; expected a whole number from 0 to 3"),
    (lambda t: evolve(t, blocked=(-1,)), "found cell -1; expected a whole number from 0 to 47"),
    (lambda t: places(t, pods={"robot": 1}), "found robot 1; expected a whole number from 0 to 0"),
    (lambda t: places(t, pods={"bound_for": [1]}), "found station 1; expected a whole number from 0 to 0"),
    (
        lambda t: evolve(t, layout=evolve(t.layout, stations=(StationCells(39, (99,)),))),
        "found cell of a station 99; expected a whole number from 0 to 47",
    ),
    (
        lambda t: evolve(t, instance=evolve(t.instance, orders=(OrderData("A", arrival_tick=0, lines=((3, 1),)),))),
        "found SKU 3; expected a whole number from 0 to 2",
    ),
    (
        lambda t: evolve(t, instance=evolve(t.instance, pods=(PodData("P0", ((5, None),)),))),
        "found SKU of a pod 5; expected a whole number from 0 to 2",
    ),
    (lambda t: evolve(t, stations=()), "found 0 stations, but the layout has 1"),
    (
        lambda t: evolve(t, motion=Motion(top_speed_m_per_s=0)),
        "found Motion(acceleration_m_per_s2=1.0, top_speed_m_per_s=0, full_turn_s=2.5, lift_s=2.2); "
        "expected an acceleration and a top speed above 0",
    ),
]


@pytest.mark.parametrize(("damage", "sentence"), UNREADABLE)
def test_what_names_nothing_is_refused(day: Trace, damage: Damage, sentence: str) -> None:
    check_readable(day)
    assert refusal(lambda: check_readable(damage(day))) == f"header of the trace: {sentence}"


def slower(trace: Trace) -> Trace:
    return evolve(trace, scenario={**trace.scenario, "robots": {"count": 1, "top_speed_m_per_s": 1.0}})


def queue_back(trace: Trace) -> Trace:
    moves = trace.layout.moves.copy()
    moves[trace.layout.stations[0].queue[0]] |= 1 << WEST
    return evolve(trace, layout=evolve(trace.layout, moves=moves))


def two_loads(trace: Trace) -> Trace:
    pods = tuple({**pod, "robot": 0} for pod in trace.pods)
    return evolve(trace, pods=pods, events=(), status="failed")


@cases(
    "damage fault",
    (slower, "header: top_speed_m_per_s of the robots is 1.5; the scenario says 1.0"),
    (lambda t: places(t, stations={"capacity": 16}), "header: the capacity of station 1 is 16, not 15"),
    (lambda t: evolve(t, blocked=(43,)), "no-storage-location: an empty pod stands at row 6, column 4 from the start"),
    (lambda t: evolve(t, blocked=(26,)), "location-taken: pod P1 and an empty pod both stand at row 4, column 3"),
    (queue_back, "header: the way on from row 5, column 7 in the queue of station 1 leads back"),
    (two_loads, "header: robot 1 carries pod P0 and pod P1"),
)
def test_contradictions_are_told(day: Trace, damage: Damage, fault: str) -> None:
    assert told(damage(day)) == [fault]


@pytest.mark.parametrize(("skus", "faults"), [(2, ["header: there are 3 SKUs; the scenario says 2"]), (9, [])])
def test_skus_on_no_pod_may_be_left_out(day: Trace, skus: int, faults: list[str]) -> None:
    instance = {**day.scenario.get("instance", {}), "skus": skus}
    assert told(evolve(day, scenario={**day.scenario, "instance": instance})) == faults


def faults(trace: Trace) -> list[str]:
    case = Case(trace)
    check_opening(case)
    return [fault.sentence for fault in case.faults]


def says(trace: Trace, section: str, **keys: object) -> Trace:
    return evolve(trace, scenario={**trace.scenario, section: {**trace.scenario[section], **keys}})


def test_starts_are_made_anew(recorded: Trace) -> None:
    assert faults(recorded) == []
    assert made_alike(recorded, None)
    assert not made_alike(evolve(recorded, versions={**recorded.versions, "numpy": "1.0"}), None)
    untold = evolve(recorded, versions={})
    assert not made_alike(untold, None)
    assert made_alike(untold, {"versions": {**recorded.versions, "click": "8"}})


def test_a_map_is_read_from_the_header(tmp_path: Path) -> None:
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


@cases(
    "change sentence",
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
)
def test_other_starts_are_told(recorded: Trace, change: Callable[[Trace], Trace], sentence: str) -> None:
    """With what there is and what there would be."""
    assert [told for told in faults(change(recorded)) if told.startswith(sentence)]
