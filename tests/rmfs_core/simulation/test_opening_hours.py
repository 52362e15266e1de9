"""Stations that open and close, robots that come and go, and rules that say which stations are active."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cases import cases
from rmfs_commands.testing import small_instance, small_world
from rmfs_commands.testing.traces import Recorder
from rmfs_core.decisions import OrderAssignment
from rmfs_core.errors import InputError, RuleError, StandstillError
from rmfs_core.events import (
    ItemPicked,
    OrderAssigned,
    OrderCompleted,
    PodStored,
    RobotsOnDuty,
    StationClosed,
    StationOpened,
    TaskAssigned,
)
from rmfs_core.scenario.model import RuleChoice, RunSection, Scenario
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.timetable import DAY, Span
from told import Prepare

ONE_ORDER = small_instance({"1": ["a"]}, {"p": ["a"]})

POA = ("pod-match", "first-come", "station-queue", "least-slack")
MINUTE = 60_000


def hours(
    stations: Any = None, robots: tuple[Span, ...] | None = None, start: str | None = None
) -> Callable[[Scenario], Scenario]:
    return lambda scenario: evolve(
        scenario,
        stations=evolve(scenario.stations, open=stations),
        robots=evolve(scenario.robots, available=robots),
        instance=evolve(scenario.instance, start=start),
    )


def test_nothing_is_assigned_before_a_station_opens(tiny_run: Prepare) -> None:
    run = tiny_run(ONE_ORDER, change=hours((("06:00", "22:00"),))).done()
    assert [event.tick for event in run.of(StationClosed)] == [0]
    assert [event.tick for event in run.of(StationOpened)] == [360 * MINUTE]
    assert [event.tick for event in run.of(OrderAssigned)] == [360 * MINUTE]
    assert run.simulation.status == "complete"
    run = tiny_run(ONE_ORDER, change=hours((("06:00", "22:00"),), start="2024-03-01T05:30")).done()
    assert [event.tick for event in run.of(OrderAssigned)] == [30 * MINUTE]
    instance = small_instance({str(i): ["a"] for i in range(4)}, {"p": ["a"], "q": ["a"]})
    run = tiny_run(instance, capacity=(2, 2), robots=2, change=hours({"1": (("06:00", "22:00"),)})).done()
    assert {event.station for event in run.of(OrderAssigned)} == {1}


def test_a_station_that_closes_finishes_what_it_has(tiny_run: Prepare) -> None:
    instance = small_instance({"1": {"a": 10}, "2": ["a"], "3": ["a"]}, {"p": ["a"]})
    run = tiny_run(instance, capacity=10, change=hours((("00:00", "00:01"),))).done()
    assert [event.tick for event in run.of(StationClosed)] == [MINUTE]
    assert [event.tick for event in run.of(OrderAssigned)] == [0, DAY, DAY]
    first = [event.tick for event in run.of(ItemPicked) if event.order == 0]
    assert len(first) == 10
    assert first[-1] > MINUTE
    assert run.simulation.status == "complete"
    run = tiny_run(ONE_ORDER, capacity=(2, 2), change=hours({"1": (("06:00", "22:00"),)}))
    first, second = run.warehouse.stations
    run.simulation.start()
    assert (first.open, first.staffed, first.opens_s, first.closes_s) == (False, False, 21_600, None)
    assert (second.open, second.staffed, second.opens_s, second.closes_s) == (True, True, None, None)
    assert (first.free_capacity, second.free_capacity) == (0, 2)
    while not first.open:
        run.warehouse.advance(int(run.simulation.env.peek()))
        run.simulation.env.step()
    assert (first.opens_s, first.closes_s, first.free_capacity) == (None, 79_200, 2)


def test_robots_off_duty_finish_their_task_and_take_no_other(tiny_run: Prepare) -> None:
    instance = small_instance({str(i): {sku: 2} for i, sku in enumerate("abcdef")}, {sku: sku for sku in "abcdef"})
    robots: tuple[Span, ...] = (("00:00", "00:01"), ("00:01", "24:00", 1))
    run = tiny_run(instance, robots=2, capacity=4, change=hours(robots=robots)).done()
    assert [(event.tick, event.number) for event in run.of(RobotsOnDuty)] == [(MINUTE, 1)]
    tasks = run.of(TaskAssigned)
    assert {event.robot for event in tasks if event.tick < MINUTE} == {0, 1}
    assert {event.robot for event in tasks if event.tick >= MINUTE} == {0}
    assert any(event.robot == 1 and event.tick > MINUTE for event in run.of(PodStored))
    assert not run.warehouse.robots[1].idle
    assert run.simulation.status == "complete"


def test_when_a_run_stands_still(tiny_run: Prepare) -> None:
    change = hours((("06:00", "22:00"),), robots=(("08:00", "09:00", 0),))
    run = tiny_run(ONE_ORDER, change=change)
    with pytest.raises(StandstillError, match=r"stands still at .*: 1 order is not complete.*; \d+ robots? off duty"):
        run.simulation.run()
    assert run.simulation.now <= 4 * DAY
    run = tiny_run(ONE_ORDER, change=hours({})).done()
    assert run.simulation.status == "complete"
    with pytest.raises(InputError, match="found no span for any station; expected one that opens"):
        tiny_run(ONE_ORDER, change=hours({"1": ()}))
    instance = small_instance({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, arrivals_s={"2": 864_000})
    run = tiny_run(instance, change=hours((("06:00", "22:00"),))).done()
    assert run.of(OrderCompleted)[-1].tick > 10 * DAY
    run = tiny_run(ONE_ORDER, change=hours((("06:00", "22:00"),)), run=RunSection(until_s=60)).done()
    assert (run.simulation.status, run.simulation.now) == ("horizon", MINUTE)


def test_a_later_line_of_an_order_joins_its_place_at_a_closed_station() -> None:
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]}, capacities=[2], counts_orders=True)
    station, order = world.stations[0], world.orders[0]
    world.assign(order, station, [0])
    world.staff(station, False, None)
    assert checks.assignment(world, OrderAssignment(0, 0, (1,)), None) == (order, station, [1])
    with pytest.raises(ImpossibleError, match=r"order 2 \(id 1\) to station 1 \(id 0\), which is closed"):
        checks.assignment(world, OrderAssignment(1, 0), None)


ACTIVATING = """
from attrs import define, field
from rmfs_core import hookimpl
@define
class Mine:
    body: str = "return [0]"
    @hookimpl
    def activate_stations(self, warehouse, rng): return {answer}
"""


def activated(tiny_run: Prepare, folder: Path, answer: str, **more: Any) -> Any:
    (folder / "mine.py").write_text(ACTIVATING.format(answer=answer), encoding="utf-8")
    instance = small_instance({str(i): ["a"] for i in range(4)}, {"p": ["a"], "q": ["a"]})
    return tiny_run(instance, capacity=(2, 2), robots=2, activate=RuleChoice("./mine.py:Mine"), **more)


def test_a_rule_says_which_stations_are_active(tiny_run: Prepare, tmp_path: Path) -> None:
    run = activated(tiny_run, tmp_path, "[int(warehouse.now_s < 30)]").done()
    changes = [event for event in run.events if isinstance(event, StationOpened | StationClosed)]
    assert (changes[0].tick, changes[0].station, type(changes[0])) == (0, 0, StationClosed)
    later = [(event.station, type(event)) for event in changes[1:]]
    assert later == [(0, StationOpened), (1, StationClosed)]
    assigned = [(event.station, event.tick < 30_000) for event in run.of(OrderAssigned)]
    assert all(station == early for station, early in assigned)
    run = activated(tiny_run, tmp_path, "[0, 1]", change=hours({"1": (("06:00", "22:00"),)})).done()
    assert {event.station for event in run.of(OrderAssigned)} == {1}
    assert not run.of(StationOpened)
    with pytest.raises(StandstillError, match=r"4 in the backlog; 2 stations closed; .*asked last: rule .*Mine"):
        activated(tiny_run, tmp_path, "[]").simulation.run()


@cases(
    "answer problem",
    ("[2]", "activate_stations, at 0.000 s: named station 2, which does not exist; ids are 0 to 1"),
    ("[True]", "named station True; expected a whole number"),
    ("None", "returned None; expected a sequence"),
    ("'01'", "returned str '01'; expected a sequence"),
)
def test_an_impossible_activation_ends_the_run(tiny_run: Prepare, tmp_path: Path, answer: str, problem: str) -> None:
    with pytest.raises(RuleError, match=problem):
        activated(tiny_run, tmp_path, answer).simulation.run()


TIMES = st.integers(0, 95).map(lambda quarter: f"{quarter // 4:02}:{quarter % 4 * 15:02}")
SPANS = st.lists(st.tuples(TIMES, TIMES).filter(lambda span: span[0] != span[1]), min_size=1, max_size=3)


@settings(deadline=None, max_examples=25, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_whatever_the_hours_every_order_is_completed_in_time(tiny_run: Prepare, data: st.DataObject) -> None:
    """As long as a station and a robot are there at some time of the day; and its trace has no fault.

    The station without a table of its own, the second, is always open: what fits waits for robots alone.
    """
    arrivals = {str(i): data.draw(st.integers(0, 100_000)) for i in range(8)}
    instance = small_instance({i: ["a", "b"] for i in arrivals}, {"p": ["a"], "q": ["b"]}, arrivals_s=arrivals)
    robots = tuple((*span, data.draw(st.integers(0, 2))) for span in data.draw(SPANS))
    robots += (("03:00", "03:15", 1),)
    stations = data.draw(st.one_of(SPANS.map(tuple), SPANS.map(lambda spans: {"1": tuple(spans)})))
    active = data.draw(st.sampled_from([{}, {"activate": "constant-ratio"}, {"activate": "backlog-threshold"}]))
    rules = {"pp": data.draw(st.sampled_from(["free-flow", "sipp"])), "poa": data.draw(st.sampled_from(POA)), **active}
    run = tiny_run(instance, capacity=(4, 4), robots=2, change=hours(stations, robots), **rules)
    recorder = Recorder()
    run.simulation.rules.register_observer(recorder)
    run.simulation.run()
    assert run.simulation.status == "complete"
    assert recorder.faults(run.simulation.now, "complete", rules, collisions=rules["pp"] == "sipp") == []
