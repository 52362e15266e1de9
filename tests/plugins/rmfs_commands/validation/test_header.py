"""The header of a trace: what makes it unreadable, and where it contradicts itself."""

from __future__ import annotations

from typing import Any

import pytest
from attrs import evolve

from damage import Damage, assert_found, told
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.header import check_readable
from rmfs_core.errors import InputError
from rmfs_core.motion import Motion
from rmfs_core.world import WEST, OrderData, PodData, StationCells


def other_header_capacity(trace: Trace) -> Trace:
    """Give the stations another capacity than the scenario says."""
    return evolve(trace, stations=tuple({**station, "capacity": 99} for station in trace.stations))


def faster_robots(trace: Trace) -> Trace:
    """Let the robots be faster than the scenario says."""
    return evolve(trace, motion=evolve(trace.motion, lift_s=1.0))


def pods_on_one_another(trace: Trace) -> Trace:
    """Let two pods start in one storage location."""
    return evolve(trace, pods=(trace.pods[0], {**trace.pods[1], "cell": trace.pods[0]["cell"]}, *trace.pods[2:]))


def pod_on_floor(trace: Trace) -> Trace:
    """Let a pod start on the floor."""
    return evolve(trace, pods=({**trace.pods[0], "cell": 0}, *trace.pods[1:]))


DAMAGES: list[tuple[str, Damage, str]] = [
    ("two pods in one place", pods_on_one_another, "location-taken"),
    ("a pod that starts on the floor", pod_on_floor, "no-storage-location"),
    ("a header with another capacity", other_header_capacity, "header"),
    ("a header with faster robots", faster_robots, "header"),
]


@pytest.mark.parametrize(("damage", "kind"), [pytest.param(d, k, id=name) for name, d, k in DAMAGES])
def test_damage_to_a_run_is_found(recorded: Trace, damage: Damage, kind: str) -> None:
    """Whatever is wrong in a run of many orders is among its faults."""
    assert_found(damage(recorded), kind)


def places(trace: Trace, **parts: dict[str, Any]) -> Trace:
    """Return the trace with the first pod, robot or station at its start as said."""
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
        lambda t: evolve(t, instance=evolve(t.instance, orders=(OrderData("A", 0, ((3, 1),)),))),
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
    """A header that names what it does not have is wrong input, told in one sentence."""
    check_readable(day)
    with pytest.raises(InputError) as caught:
        check_readable(damage(day))
    assert str(caught.value) == f"header of the trace: {sentence}"


def slower(trace: Trace) -> Trace:
    """Let the scenario ask for slower robots than there were."""
    return evolve(trace, scenario={**trace.scenario, "robots": {"count": 1, "top_speed_m_per_s": 1.0}})


def queue_back(trace: Trace) -> Trace:
    """Let the queue cell be left to the west, too."""
    moves = trace.layout.moves.copy()
    moves[trace.layout.stations[0].queue[0]] |= 1 << WEST
    return evolve(trace, layout=evolve(trace.layout, moves=moves))


def two_loads(trace: Trace) -> Trace:
    """Let both pods start on one robot, and nothing happen."""
    pods = tuple({**pod, "robot": 0} for pod in trace.pods)
    return evolve(trace, pods=pods, events=(), status="failed")


@pytest.mark.parametrize(
    ("damage", "fault"),
    [
        (slower, "header: top_speed_m_per_s of the robots is 1.5; the scenario says 1.0"),
        (
            lambda t: places(t, stations={"capacity": 16}),
            "header: the capacity of station 1 is 16, not 15",
        ),
        (
            lambda t: evolve(t, blocked=(43,)),
            "no-storage-location: an empty pod stands at row 6, column 4 from the start",
        ),
        (lambda t: evolve(t, blocked=(26,)), "location-taken: pod P1 and an empty pod both stand at row 4, column 3"),
        (queue_back, "header: the way on from row 5, column 7 in the queue of station 1 leads back"),
        (two_loads, "header: robot 1 carries pod P0 and pod P1"),
    ],
)
def test_contradictions_are_told(day: Trace, damage: Damage, fault: str) -> None:
    """Header against scenario, and pods against each other: a fault at the start of the run."""
    assert told(damage(day)) == [fault]


def test_a_capacity_for_each_station_is_understood(day: Trace) -> None:
    """A scenario may list capacities; each station has its own."""
    stations = {**day.scenario["stations"], "item_capacity": [15]}
    assert told(evolve(day, scenario={**day.scenario, "stations": stations})) == []


@pytest.mark.parametrize(("skus", "faults"), [(2, ["header: there are 3 SKUs; the scenario says 2"]), (9, [])])
def test_skus_on_no_pod_may_be_left_out(day: Trace, skus: int, faults: list[str]) -> None:
    """The generator leaves them out; more than the scenario has there cannot be."""
    instance = {**day.scenario.get("instance", {}), "skus": skus}
    assert told(evolve(day, scenario={**day.scenario, "instance": instance})) == faults
