"""Stations that open and close, robots that come and go; times of services, by what they are drawn for."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attrs import evolve
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import rmfs_core
from cases import cases
from rmfs_commands.processes.events import OrderPacked
from rmfs_commands.testing import small_instance, small_layout, small_world
from rmfs_commands.testing.traces import Recorder
from rmfs_commands.validation import validate_trace
from rmfs_core import events, hookimpl
from rmfs_core.decisions import OrderAssignment
from rmfs_core.errors import InputError, RuleError, StandstillError
from rmfs_core.randomness import keyed_stream
from rmfs_core.scenario import Scenario, StationsSection, load_scenario, scenario_from_dict, scenario_to_dict
from rmfs_core.scenario.model import RuleChoice, RunSection
from rmfs_core.scenario.service import ServiceTime, Spread, drawn
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.simulation.services import Services
from rmfs_core.timetable import DAY
from saying import said
from told import Prepare

ONE_ORDER = small_instance({"1": ["a"]}, {"p": ["a"]})

POA = ("pod-match", "first-come", "station-queue", "least-slack")
MINUTE = 60_000


def hours(stations: Any = None, robots: Any = None, start: str | None = None) -> Callable[[Scenario], Scenario]:
    return lambda scenario: evolve(
        scenario,
        stations=evolve(scenario.stations, open=stations),
        robots=evolve(scenario.robots, available=robots),
        instance=evolve(scenario.instance, start=start),
    )


def test_nothing_is_assigned_before_a_station_opens(tiny_run: Prepare) -> None:
    run = tiny_run(ONE_ORDER, change=hours((("06:00", "22:00"),))).done()
    assert [event.tick for event in run.of(events.StationClosed)] == [0]
    assert [event.tick for event in run.of(events.StationOpened)] == [360 * MINUTE]
    assert [event.tick for event in run.of(events.OrderAssigned)] == [360 * MINUTE]
    assert run.simulation.status == "complete"
    run = tiny_run(ONE_ORDER, change=hours((("06:00", "22:00"),), start="2024-03-01T05:30")).done()
    assert [event.tick for event in run.of(events.OrderAssigned)] == [30 * MINUTE]
    instance = small_instance({str(i): ["a"] for i in range(4)}, {"p": ["a"], "q": ["a"]})
    run = tiny_run(instance, capacity=(2, 2), robots=2, change=hours({"1": (("06:00", "22:00"),)})).done()
    assert {event.station for event in run.of(events.OrderAssigned)} == {1}
    run = tiny_run(ONE_ORDER, change=hours((("06:00", "22:00"),)))
    run.simulation.start()
    assert [(one.opens_s, one.closes_s) for one in run.warehouse.stations] == [(21_600, None)]


def test_when_a_run_stands_still(tiny_run: Prepare) -> None:
    change = hours((("06:00", "22:00"),), robots=(("08:00", "09:00", 0),))
    run = tiny_run(ONE_ORDER, change=change)
    with pytest.raises(StandstillError, match=r"stands still at .*: 1 order is not complete.*; \d+ robots? off duty"):
        run.simulation.run()
    assert run.simulation.now <= 4 * DAY
    assert tiny_run(ONE_ORDER, change=hours({})).done().simulation.status == "complete"
    with pytest.raises(InputError, match="found no span for any station; expected one that opens"):
        tiny_run(ONE_ORDER, change=hours({"1": ()}))
    instance = small_instance({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, arrivals_s={"2": 864_000})
    run = tiny_run(instance, change=hours((("06:00", "22:00"),))).done()
    assert run.of(events.OrderCompleted)[-1].tick > 10 * DAY
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
from rmfs_core import events, hookimpl
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
    changes = [event for event in run.events if isinstance(event, events.StationOpened | events.StationClosed)]
    assert (changes[0].tick, changes[0].station, type(changes[0])) == (0, 0, events.StationClosed)
    later = [(event.station, type(event)) for event in changes[1:]]
    assert later == [(0, events.StationOpened), (1, events.StationClosed)]
    assigned = [(event.station, event.tick < 30_000) for event in run.of(events.OrderAssigned)]
    assert all(station == early for station, early in assigned)
    run = activated(tiny_run, tmp_path, "[0, 1]", change=hours({"1": (("06:00", "22:00"),)})).done()
    assert {event.station for event in run.of(events.OrderAssigned)} == {1}
    assert not run.of(events.StationOpened)
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


LINES = small_instance({"1": {"a": 2, "b": 1}, "2": {"a": 1}}, {"p": ["a"], "q": ["b"]})
VARYING = ("stations.pick_s={mean=6.0, cv=0.5}", "stations.handle_s={mean=11.0, cv=1.0, distribution='gamma'}")


def stations(**keys: Any) -> Callable[[Scenario], Scenario]:
    return lambda scenario: evolve(scenario, stations=evolve(scenario.stations, **keys))


def lasts(picks: list[events.ItemPicked]) -> list[tuple[float, float]]:
    """Return seconds of picking and of handling, in the order of the picks."""
    return [((e.tick - e.start_tick) / 1000, (e.picker_free_tick - e.start_tick) / 1000) for e in picks]


@cases(
    "spread cv",
    (Spread(mean=8.0, cv=0.5), 0.5),
    (Spread(mean=8.0, cv=2.0), 2.0),
    (Spread(mean=8.0, cv=0.7, distribution="gamma"), 0.7),
    (Spread(mean=8.0, distribution="exponential"), 1.0),
    (Spread(times=(4.0, 12.0, 8.0)), 0.408),
    (Spread(mean=8.0, cv=0.0), 0.0),
    (Spread(mean=8.0, cv=1e-200, distribution="gamma"), 0.0),
)
def test_draws_have_the_mean_and_the_spread_that_was_asked_for(spread: Spread, cv: float) -> None:
    times = np.array([drawn(ServiceTime(spread), keyed_stream(5, "trial", number)) for number in range(20_000)])
    assert times.mean() == pytest.approx(8, rel=0.06)
    assert times.std() / times.mean() == pytest.approx(cv, rel=0.12)


def test_each_draw_is_of_its_own_whatever_was_drawn_before() -> None:
    section = StationsSection(pick_s=ServiceTime(Spread(mean=7.0, cv=1.0)))
    one, other = (Services(section, 3, 2) for _ in range(2))
    items = [(order, sku, number) for order in range(3) for sku in range(3) for number in range(2)]
    drawn_first = {item: one.item_s(*item) for item in items}
    assert {item: other.item_s(*item) for item in reversed(items)} == drawn_first
    assert len(set(drawn_first.values())) == len(items)
    assert Services(section, 4, 2).item_s(0, 0, 0) != one.item_s(0, 0, 0)
    assert all(pick <= handle for pick, handle in drawn_first.values())


@cases(
    "keys expected",
    ({}, [(7, 13), (7, 13), (7, 13), (7, 13)]),
    ({"line_s": 2.0}, [(9, 15), (7, 13), (9, 15), (9, 15)]),  # of order 1 two a, of order 2 one a; then b
    ({"order_s": 4.0}, [(11, 17), (7, 13), (11, 17), (7, 13)]),
    ({"line_s": 2.0, "order_s": 4.0, "speed": {"1": 2.0}}, [(6.5, 9.5), (3.5, 6.5), (6.5, 9.5), (4.5, 7.5)]),
    ({"order_s": ServiceTime(Spread(times=(4.0,)))}, [(11, 17), (7, 13), (11, 17), (7, 13)]),
)
def test_times_by_line_order_and_station(keys, expected, tiny_run) -> None:
    run = tiny_run(LINES, layout=small_layout(1), poa="first-come", change=stations(**keys)).done()
    assert lasts(run.of(events.ItemPicked)) == expected


def test_a_shift_has_its_speed(tiny_run: Prepare) -> None:
    """Picks take 7 s: until 10 s past the start at half the speed, from then on at twice, outside of both at 1."""
    shifts = (("00:00", "00:01", 0.5), ("00:01", "00:02", 2.0))
    orders = small_instance({str(i): ["a"] for i in range(12)}, {"p": ["a"]})
    run = tiny_run(orders, layout=small_layout(1), change=stations(speed={"1": shifts})).done()
    picks = {(e.start_tick // 60_000, e.tick - e.start_tick) for e in run.of(events.ItemPicked)}
    assert picks == {(0, 14_000), (1, 3_500), (2, 7_000)}


def test_rules_see_mean_times_of_packing_tasks(tmp_path: Path) -> None:
    over = (
        *("robots.lift_s={mean=3.0, cv=1.0}", "packing.pack_s={mean=30.0, cv=0.5}"),
        *("packing.pack_item_s={times=[4.0, 6.0]}", "packing.tote_s={mean=3.0, distribution='exponential'}"),
        *("packing.put_s={mean=4.0, cv=0.5, distribution='gamma'}", "rules.poa=pod-match", "rules.pps=demand"),
    )
    packed = set()

    class Watcher:
        @hookimpl
        def run_started(self, run: Any) -> None:
            self.view = run.warehouse

        @hookimpl
        def on_event(self, event: Any) -> None:
            for station in self.view.packing_stations:
                for task in (*station.tasks, *(task for task, _ in station.working)):
                    base, each = (3, 4) if task.kind == "put" else (30, 5)
                    assert task.duration_s == base + each * task.items
            if isinstance(event, OrderPacked):
                packed.add(event.tick - event.start_tick)

    observers = [Watcher()]
    rmfs_core.run("examples/packing", overrides=over, observers=observers, out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []  # which draws times by what they are for, whatever rules decide
    assert len(packed) > 10


def test_rules_see_what_is_expected_and_no_draw(tiny_run: Prepare) -> None:
    varying = ServiceTime(Spread(times=(20.0, 30.0)))  # 25 s on average, never
    run, seen = tiny_run(LINES, layout=small_layout(1), change=stations(handle_s=varying)), list[float]()

    class Watcher:
        @hookimpl
        def on_event(self, event: object) -> None:
            if isinstance(event, events.ItemPicked):
                seen.append(run.warehouse.stations[0].picker_free_s - event.start_tick / 1000)

    run.simulation.rules.register_observer(Watcher())
    run.done()
    assert seen == pytest.approx([25.0] * 4)
    assert {handling for _, handling in lasts(run.of(events.ItemPicked))} == {20.0, 30.0}


@pytest.mark.parametrize("name", ["examples/small", "examples/replenished"])
def test_the_validator_draws_the_same(name: str, tmp_path: Path) -> None:
    more = ("stations.line_s=1.5", "stations.order_s={mean=2, distribution='exponential'}", "stations.speed={1=1.5}")
    store = ("stations.store_s={mean=8, cv=0.3}",)
    rmfs_core.run(name, overrides=[*VARYING, *more, *store], out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []


def test_measured_times_of_a_file_become_part_of_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "picks.csv").write_text("seconds\n4.5\n9\n7.5\n")
    table = {"rules": {"poa": "pod-match", "pps": "demand"}, "stations": {"pick_s": {"file": "picks.csv"}}}
    scenario = scenario_from_dict(table, str(tmp_path))
    assert (float(scenario.stations.pick_s), scenario.stations.pick_s == 7.0) == (7.0, False)
    written = scenario_to_dict(scenario)
    assert written["stations"]["pick_s"] == {"distribution": "empirical", "times": [4.5, 9.0, 7.5]}
    assert scenario_from_dict(written) == evolve(scenario, folder=".")
    for time in ("6", "{mean=6, cv=1}"):
        rules = '[rules]\npoa = "pod-match"\npps = "demand"\n'
        (tmp_path / "own.toml").write_text(f"{rules}[stations]\npick_s = {time}\n")
        override = [f"stations.pick_s.file={tmp_path / 'picks.csv'}"]
        assert load_scenario(tmp_path / "own.toml", override).stations.pick_s == scenario.stations.pick_s
    missing = table | {"stations": {"pick_s": {"file": "none.csv"}}}
    assert said(InputError, scenario_from_dict, missing) == "stations.pick_s.file: there is no file none.csv"
    (tmp_path / "picks.csv").write_text("seconds\n4.5\nlong\n")
    with pytest.raises(InputError, match=r"picks.csv, line 3: expected a number of seconds from 0 to 3600, found long"):
        scenario_from_dict(table, str(tmp_path))


@cases(
    "keys sentence",
    ({"pick_s": "long"}, 'stations.pick_s: expected a number, or a table { mean = ..., cv = ... }, found "long"'),
    (
        {"pick_s": {"mean": 7}},
        'stations.pick_s: expected `cv` with distribution "lognormal" or "gamma", and only there',
    ),
    ({"pick_s": {"cv": 0.5}}, "stations.pick_s: expected `mean`, or else `times` or `file`"),
    ({"pick_s": {"mean": 7, "times": [7]}}, "stations.pick_s: expected `mean`, or else `times` or `file`"),
    (
        {"pick_s": {"mean": 7, "cv": 0.5, "distribution": "gama"}},
        'stations.pick_s.distribution: found "gama" (did you mean `gamma`?)',
    ),
    ({"pick_s": {"mean": 0, "cv": 0.5}}, "stations.pick_s.mean: expected a number from 0.001 to 3600, found 0.0"),
    ({"pick_s": {"times": []}}, "stations.pick_s.times: expected times from 0 to 3600, at least one, found []"),
    ({"pick_s": {"mean": 20, "cv": 1}}, "stations: expected handle_s >= pick_s, found 13.0 < 20.0"),
    ({"speed": {"1": 0}}, "stations.speed: expected a table of names, each with a number from 0.01 to 100"),
    ({"speed": {"1": [["06:00", "14:00"]]}}, 'or with spans such as ["06:00", "14:00", 0.9]'),
    ({"speed": {"1": [["06:00", "6", 1.0]]}}, "stations.speed: expected spans of two times of the day"),
)
def test_wrong_times_are_said(keys: dict[str, Any], sentence: str) -> None:
    table = {"rules": {"poa": "pod-match", "pps": "demand"}, "stations": keys}
    assert sentence in said(InputError, scenario_from_dict, table)


@cases(
    "name override problem",
    ("small", "stations.speed={9=2}", "stations.speed.9: no station 9; expected 1 to 2"),
    # a battery keeps back enough for the longest task
    ("charging", "robots.lift_s={mean=2, cv=1}", "expected a number of seconds as `robots.lift_s`"),
)
def test_times_that_no_world_has_are_refused(name: str, override: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        rmfs_core.run(f"examples/{name}", overrides=[override])
