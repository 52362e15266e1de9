"""Times of services: drawn by what they are for, by line, by order, by station; what rules see of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from attrs import evolve

import rmfs_core
from cases import cases
from rmfs_commands.testing import small_instance, small_layout
from rmfs_commands.validation import validate_trace
from rmfs_core import hookimpl
from rmfs_core.errors import InputError
from rmfs_core.events import ItemPicked, OrderPacked, PodLifted, PodStored
from rmfs_core.randomness import keyed_stream
from rmfs_core.scenario import Scenario, StationsSection, load_scenario, scenario_from_dict, scenario_to_dict
from rmfs_core.scenario.service import ServiceTime, Spread, drawn
from rmfs_core.simulation.services import Services
from saying import said
from told import Prepare

LINES = small_instance({"1": {"a": 2, "b": 1}, "2": {"a": 1}}, {"p": ["a"], "q": ["b"]})
VARYING = ("stations.pick_s={mean=6.0, cv=0.5}", "stations.handle_s={mean=11.0, cv=1.0, distribution='gamma'}")


def stations(**keys: Any) -> Callable[[Scenario], Scenario]:
    return lambda scenario: evolve(scenario, stations=evolve(scenario.stations, **keys))


def lasts(events: list[ItemPicked]) -> list[tuple[float, float]]:
    """Return seconds of picking and of handling, in the order of the picks."""
    return [((e.tick - e.start_tick) / 1000, (e.picker_free_tick - e.start_tick) / 1000) for e in events]


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


def test_compared_rules_meet_the_same_draws() -> None:
    found = []
    for poa in ("pod-match", "first-come"):
        told: dict[tuple[int, int, int], tuple[float, float]] = {}

        class Picks:
            @hookimpl
            def on_event(self, event: object, told: Any = told) -> None:
                if isinstance(event, ItemPicked):
                    key = event.order, event.sku, sum(known[:2] == (event.order, event.sku) for known in told)
                    told[key] = lasts([event])[0]

        scenario = load_scenario("examples/small", [*VARYING, f"rules.poa={poa}"])
        rmfs_core.run(scenario, observers=[Picks()])
        found.append(told)
    assert list(found[0]) != list(found[1])
    assert dict(sorted(found[0].items())) == dict(sorted(found[1].items()))
    assert len(set(found[0].values())) > 20


def test_no_spread_is_the_number(tmp_path: Path) -> None:
    for name, pick in (("number", "6.0"), ("table", "{mean=6.0, cv=0}")):
        rmfs_core.run("examples/small", overrides=[f"stations.pick_s={pick}"], out=tmp_path / name)
    for file in ("orders.csv", "visits.csv", "delays.csv"):
        assert (tmp_path / "number" / file).read_bytes() == (tmp_path / "table" / file).read_bytes()


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
    assert lasts(run.of(ItemPicked)) == expected


def test_a_shift_has_its_speed(tiny_run: Prepare) -> None:
    """Picks take 7 s: until 10 s past the start at half the speed, from then on at twice, outside of both at 1."""
    shifts = (("00:00", "00:01", 0.5), ("00:01", "00:02", 2.0))
    orders = small_instance({str(i): ["a"] for i in range(12)}, {"p": ["a"]})
    run = tiny_run(orders, layout=small_layout(1), change=stations(speed={"1": shifts})).done()
    picks = {(e.start_tick // 60_000, e.tick - e.start_tick) for e in run.of(ItemPicked)}
    assert picks == {(0, 14_000), (1, 3_500), (2, 7_000)}


def test_lifts_and_packing_are_drawn_by_what_they_are_for_and_expected_by_their_means(tmp_path: Path) -> None:
    """Rules see mean times of tasks, and compared rules meet the same times."""
    over = (
        "robots.lift_s={mean=3.0, cv=1.0}",
        "packing.pack_s={mean=30.0, cv=0.5}",
        "packing.pack_item_s={times=[4.0, 6.0]}",
        "packing.tote_s={mean=3.0, distribution='exponential'}",
        "packing.put_s={mean=4.0, cv=0.5, distribution='gamma'}",
    )
    found: list[dict[str, dict[Any, list[int]]]] = []
    for number, pps in enumerate(("demand", "completes")):
        lasts: dict[str, dict[Any, list[int]]] = {"lift": {}, "pack": {}}

        class Watcher:
            @hookimpl
            def run_started(self, run: Any) -> None:
                self.view = run.warehouse

            @hookimpl
            def on_event(self, event: Any, lasts: Any = lasts) -> None:
                for station in self.view.packing_stations:
                    for task in (*station.tasks, *(task for task, _ in station.working)):
                        base, each = (3, 4) if task.kind == "put" else (30, 5)
                        assert task.duration_s == base + each * task.items
                if isinstance(event, PodLifted | PodStored):
                    lasts["lift"].setdefault(event.pod, []).append(event.tick - event.start_tick)
                if isinstance(event, OrderPacked):
                    lasts["pack"][event.order] = [event.tick - event.start_tick]

        out = tmp_path / str(number)
        rules = [f"rules.pps={pps}", "rules.poa=pod-match", "rules.poa_pps="]
        rmfs_core.run("examples/packing", overrides=[*over, *rules], observers=[Watcher()], out=out, record=["trace"])
        assert validate_trace(out) == []
        found.append(lasts)
    one, other = found
    assert one["pack"] == other["pack"]
    assert len({ticks for times in one["pack"].values() for ticks in times}) > 10
    for pod in one["lift"].keys() & other["lift"].keys():
        assert all(a == b for a, b in zip(one["lift"][pod], other["lift"][pod], strict=False))


def test_rules_see_what_is_expected_and_no_draw(tiny_run: Prepare) -> None:
    varying = ServiceTime(Spread(times=(20.0, 30.0)))  # 25 s on average, never
    run, seen = tiny_run(LINES, layout=small_layout(1), change=stations(handle_s=varying)), list[float]()

    class Watcher:
        @hookimpl
        def on_event(self, event: object) -> None:
            if isinstance(event, ItemPicked):
                seen.append(run.warehouse.stations[0].picker_free_s - event.start_tick / 1000)

    run.simulation.rules.register_observer(Watcher())
    run.done()
    assert seen == pytest.approx([25.0] * 4)
    assert {handling for _, handling in lasts(run.of(ItemPicked))} == {20.0, 30.0}


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
    for given in ("6", "{mean=6, cv=1}"):
        rules = '[rules]\npoa = "pod-match"\npps = "demand"\n'
        (tmp_path / "own.toml").write_text(f"{rules}[stations]\npick_s = {given}\n")
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


def test_an_unknown_station_has_no_speed() -> None:
    with pytest.raises(InputError, match=r"stations.speed.9: no station 9; expected 1 to 2"):
        rmfs_core.run("examples/small", overrides=["stations.speed={9=2}"])


def test_lifts_that_vary_need_robots_without_batteries() -> None:
    """A battery keeps back enough for the longest task."""
    with pytest.raises(InputError, match=r"expected a number of seconds as `robots.lift_s`"):
        rmfs_core.run("examples/charging", overrides=["robots.lift_s={mean=2, cv=1}"])
