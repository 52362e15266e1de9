"""The smallest warehouse that meets a target: worlds, trials, judgement, search; and `rmfs size`."""

import csv
import io
import json
import random
import tomllib
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from attrs import evolve
from rich.console import Console

from bad_rules import write_rule
from calling import exit_code
from cases import cases
from rmfs_commands.bounds import bounds_of
from rmfs_commands.cli.screen import output_console
from rmfs_commands.cli.serving import SERVING
from rmfs_commands.details.catalogue import FROM_ORDERS, MORE_IS_BETTER
from rmfs_commands.experiments import Job, Watcher
from rmfs_commands.experiments.outcome import Outcome, simulate
from rmfs_commands.experiments.resolving import resolve
from rmfs_commands.sizing.judging import Estimate, Verdict, estimate, looks
from rmfs_commands.sizing.notices import Notices
from rmfs_commands.sizing.report import content_of, sentences_of, table_of, write_answers
from rmfs_commands.sizing.robust import FAILURES, under_spread_and_failures
from rmfs_commands.sizing.searching import Found, fewest, frontier, search
from rmfs_commands.sizing.sizing import Answer, size
from rmfs_commands.sizing.target import KNOWN, Target
from rmfs_commands.sizing.trials import Candidate, Trials
from rmfs_commands.sizing.worlds import Worlds
from rmfs_core import Scenario, load_scenario, run
from rmfs_core.errors import InputError, RunError
from rmfs_core.scenario import scenario_from_dict
from rmfs_core.scenario.model import Arrivals, RuleChoice, RunSection, StationsSection
from rmfs_core.scenario.service import ServiceTime, Spread
from rmfs_core.world import make_instance

SEEDS = (1, 2, 3)
FAILS = 'raise ValueError("out of ideas")'


def test_the_answer_is_that_of_the_whole_grid(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    backlog = evolve(poisson, instance=evolve(poisson.instance, arrivals=Arrivals(), orders=10))
    worlds = Worlds(backlog, SEEDS)
    values = {
        sizes: [run(worlds.of_size(*sizes), seed=seed).metrics["turnover_p95_s"] for seed in SEEDS]
        for sizes in product((1, 2), range(1, 4))
    }
    found: list[list[tuple[int, int]]] = []
    for most in (290.0, 230.0, 170.0):
        target = Target("turnover_p95_s", most, confidence=0.8, seeds=SEEDS)
        answer = size(backlog, "hall", target, store=tmp_path, workers=here, stations=(1, 2), robots=(1, 3))
        assert answer.at_once
        best: list[tuple[int, int]] = []
        for (stations, robots), of_seeds in values.items():
            enough = estimate(of_seeds, 0.8, 1).verdict(most) is Verdict.PASSES
            if enough and all(robots < fewer for _, fewer in best):
                best.append((stations, robots))
        found.append([(one.first, one.second) for one in answer.frontier])
        assert found[-1] == best
    assert found == [[(1, 2)], [(2, 3)], []]
    assert len({job.key for job in here.jobs}) == len(here.jobs)


def test_stations_that_cannot_keep_up_are_left_out(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    target = Target("turnover_p95_s", 3600, seeds=SEEDS)
    arrivals = Arrivals(process="poisson", orders_per_hour=250)
    busy = evolve(poisson, instance=evolve(poisson.instance, arrivals=arrivals))
    answer = size(busy, "hall", target, store=tmp_path, workers=here, stations=(1, 6), robots=(4, 4))
    reasons = {found.first: found.reason for found in answer.found}
    assert "busy" in str(reasons[1])
    assert "at most 2 fit" in str(reasons[5])
    assert (reasons[2], reasons[3]) == (None, "saves no robot")
    assert {(one.first, one.second) for one in answer.candidates} == {(2, 4)}
    assert [(one.first, one.second) for one in answer.frontier] == [(2, 4)]


@cases(
    "of_others verdict told",
    (100.0, Verdict.PASSES, "passes. The rules fail there, not the hardware."),
    (800.0, Verdict.FAILS, "fails. Any rules: "),
)
def test_where_rules_fail_those_that_serve_best_are_tried(poisson, here, tmp_path, of_others, verdict, told) -> None:
    def made_up(job: Job) -> Outcome:
        outcome = simulate(job)
        assert outcome.result is not None
        own = job.scenario.rules == poisson.rules
        outcome.result.metrics["turnover_s"] = (900.0 if own else of_others) + job.seed
        return outcome

    here.run = made_up
    target = Target("turnover_s", 500, seeds=SEEDS)
    answer = size(poisson, "hall", target, store=tmp_path, workers=here, stations=(2, 2), robots=(2, 3))
    assert answer.frontier == ()
    assert answer.other_rules is not None
    judged = answer.other_rules.judged
    assert (judged.first, judged.second, judged.verdict) == (2, 3, verdict)
    broken = evolve(answer.other_rules, judged=evolve(judged, failed=2))
    assert (answer.failed, evolve(answer, other_rules=broken).failed) == (0, 2)
    sentences = list(sentences_of(answer, None))
    assert sentences[1].startswith(
        "The scenario's rules fail with 2 stations with 3 robots; with --set 'rules.poa={ rule"
    )
    assert told in sentences[1]
    assert content_of(answer, None)["other_rules"]["verdict"] == verdict.value
    served = resolve(poisson, SERVING, ".", "hall")
    again = size(served, "hall", target, store=tmp_path, workers=here, stations=(2, 2), robots=(2, 3))
    assert again.other_rules is None


def test_rooms_and_maps(here: Any, tmp_path: Path) -> None:
    scenario = load_scenario("examples/text-map", ["instance.orders=8", "rules.pp=free-flow"])
    target = Target("turnover_p95_s", 5000, seeds=(1, 2))
    with pytest.raises(InputError, match="--stations: the map of the scenario has"):
        size(scenario, "map", target, store=tmp_path, workers=here, stations=(1, 9))
    answer = size(scenario, "map", target, store=tmp_path, workers=here, robots=(2, 2))
    assert [one.second for one in answer.frontier] == [2]


def answer_of(*frontier: tuple[int, int], undecided: tuple[tuple[int, int], ...] = ()) -> Answer:
    best = tuple(Candidate(*one, Verdict.PASSES, 4, Estimate(1, 1, 1)) for one in frontier)
    open_ones = tuple(Candidate(*one, Verdict.UNDECIDED, 16, Estimate(1, 1, 1)) for one in undecided)
    found = tuple(Found(*one) for one in frontier)
    return Answer("hall", Target("turnover_s", 1), found, best, (*best, *open_ones), at_once=False)


def test_what_is_not_known_beside_the_cheapest() -> None:
    """It has the most robots of the range, a station more is undecided, and one less is too busy for any robots."""
    enough = [Candidate(2, robots, Verdict.PASSES, costs=(cost,)) for robots, cost in ((2, 1.5), (3, 1.0))]
    found = (Found(1, None, "too busy"), Found(2, 2), Found(3, None, "undecided"))
    asked = "hall", Target("turnover_s", 1), found, tuple(enough[:1])
    answer = Answer(*asked, (*enough, Candidate(3, 3, Verdict.UNDECIDED, 2)), at_once=False)
    assert answer.unknown_beside_least == {(2, 4): "not tried", (3, 3): "undecided"}
    told = "or is not enough; not known: 2 with 4 (not tried) and 3 with 3 (undecided)."
    assert any(sentence.endswith(told) for sentence in sentences_of(answer, None))
    whole = (Candidate(2, 4, Verdict.FAILS), Candidate(3, 3, Verdict.FAILS))
    assert Answer(*asked, (*enough, *whole), at_once=False).unknown_beside_least == {}


def test_what_is_cheapest() -> None:
    answer = answer_of((2, 9), (3, 7), (4, 6))
    sizes = {costs: answer.cheapest(*costs) for costs in ((10, 1), (1, 10), (1, 2))}
    found = {costs: priced and ((priced[0].first, priced[0].second), priced[1]) for costs, priced in sizes.items()}
    assert found == {(10, 1): ((4, 6), 64), (1, 10): ((2, 9), 29), (1, 2): ((2, 9), 13)}
    assert answer_of().cheapest(1, 1) is None
    answer = answer_of((2, 9), (3, 7), undecided=((2, 8), (3, 8), (4, 7), (4, 6)))
    assert [(one.first, one.second) for one in answer.undecided] == [(2, 8), (4, 6)]


def test_the_search_goes_on() -> None:
    assert fewest(lambda n: n >= 10 and n != 12, 1, 40, 16, 3) == 10
    assert fewest(lambda n: n in (5, 7, 9) or n > 10, 1, 40, 16, 4) == 5
    assert frontier([Found(2, 5), Found(1, 4), Found(3, 3)]) == (Found(1, 4), Found(3, 3))


@pytest.mark.parametrize("seed", range(40))
def test_the_frontier_is_that_of_the_whole_grid(seed: int) -> None:
    rng = random.Random(seed)
    stations = sorted(rng.sample(range(1, 12), rng.randint(1, 9)))
    needs = dict(zip(stations, sorted((rng.randint(1, 40) for _ in stations), reverse=True), strict=True))
    tried: set[tuple[int, int]] = set()

    def passes(number: int, robots: int) -> bool:
        tried.add((number, robots))
        return robots >= needs[number]

    least, most = rng.randint(1, 5), rng.randint(20, 32)
    found = search(passes, stations, (least, most), (rng.randint(1, 12), rng.randint(1, 32)))
    best: list[tuple[int, int]] = []
    for number in stations:
        robots = next((n for n in range(least, most + 1) if n >= needs[number]), None)
        if robots is not None and all(robots < other for _, other in best):
            best.append((number, robots))
    assert [(one.first, one.second) for one in frontier(found)] == best
    assert [one.first for one in found] == stations
    assert all((one.second is None) == (one.reason is not None) for one in found)
    assert len(tried) < 0.4 * len(stations) * (most - least + 1) + 10


def test_what_is_left_out_has_its_reason() -> None:
    needs = {1: 99, 2: 99, 3: 12, 4: 8, 5: 8}
    found = search(lambda number, robots: robots >= needs[number], [1, 2, 3, 4, 5], (1, 16), (4, 8))
    assert found == (
        Found(1, None, "not tried: 2 stations are not shown to be enough"),
        Found(2, None, "no number of robots up to 16 is shown to be enough"),
        Found(3, 12),
        Found(4, 8),
        Found(5, None, "saves no robot"),
    )
    assert frontier(found) == (found[2], found[3])


def test_the_interval_by_hand() -> None:
    """Mean 10, standard deviation 2, four seeds: the 95 % quantile of Student's t with 3 degrees is 2.353.

    With two looks each has half of the 5 %, and the quantile is 3.182.
    """
    values = [8.0, 8.0, 12.0, 12.0]
    once, twice = estimate(values, 0.95, 1), estimate(values, 0.95, 2)
    error = (16 / 3) ** 0.5 / 2
    assert (once.mean, once.low, once.high) == pytest.approx((10, 10 - 2.3534 * error, 10 + 2.3534 * error), abs=1e-3)
    assert twice.high == pytest.approx(10 + 3.1824 * error, abs=1e-3)


@pytest.mark.parametrize(
    ("most", "verdict"),
    [(12, Verdict.PASSES), (11, Verdict.PASSES), (10, Verdict.UNDECIDED), (9, Verdict.UNDECIDED), (8.9, Verdict.FAILS)],
)
def test_a_verdict_needs_a_whole_interval(most: float, verdict: Verdict) -> None:
    assert Estimate(10, 9, 11).verdict(most) is verdict


def test_it_errs_no_more_often_than_it_says() -> None:
    """Of means a trifle above the limit at most 5 % pass at any of three looks; and not all of that is given away."""
    random = np.random.default_rng(1)
    passed = 0
    for _ in range(400):
        values = random.normal(100.001, 15, 16).tolist()
        verdicts = [estimate(values[:n], 0.95, 3).verdict(100) for n in looks(16)]
        passed += next((one for one in verdicts if one is not Verdict.UNDECIDED), None) is Verdict.PASSES
    assert 0.015 * 400 < passed < 0.06 * 400


def test_names_of_metrics() -> None:
    target = Target("turnover_p95_s", 900)
    assert (target.label, target.with_unit(612.345)) == ("Turn-over time, p95", "612.3 s")
    assert Target("late_percent", 2).with_unit(2) == "2.0 %"
    assert [Target("late_packed", most).with_unit(1.75) for most in (2, 0.25)] == ["1.8", "1.75"]
    assert Target("late_percent", 2).label == "Late orders, of those due"
    assert Target("turnover_backlog_p95_s", 2).label == "Turn-over time, in the backlog, p95"
    assert Target("empty_distance_m", 2).label == "Distance, empty"
    assert not [name for name in KNOWN if Target(name, 2).label.startswith(" ")]
    target = Target("my_waits", 3)
    assert (target.label, target.with_unit(3)) == ("my_waits", "3.000")


def test_what_can_be_asked_of_a_limit(poisson: Scenario) -> None:
    orders = [make_instance(poisson)]
    assert KNOWN.keys() >= MORE_IS_BETTER | FROM_ORDERS
    for metric in (*MORE_IS_BETTER, "on_time_percent_priority_12"):
        with pytest.raises(InputError, match=f"--most {metric}=2: more of `{metric}` is better; expected"):
            Target(metric, 2).check(orders)
    for metric in FROM_ORDERS:
        with pytest.raises(InputError, match=f"`{metric}` is the same for every number of robots"):
            Target(metric, 2).check(orders)
    own = {"stations": "cost_pickers_per_order", "robots": "cost_robots_per_order", "packers": "cost_packers_per_order"}
    for thing, metric in own.items():
        for raised in ("cost_total", "cost_per_order", metric):
            with pytest.raises(InputError, match=f"more {thing} raise `{raised}`; expected a metric .* costs least"):
                Target(raised, 2).check(orders, [thing, "boxes"])
        Target(metric, 2).check(orders, {*own} - {thing})
    with pytest.raises(InputError, match="more stations or robots raise `cost_total`"):
        Target("cost_total", 2).check(orders, ["stations", "robots"])
    Target("cost_total", 2).check(orders, ["boxes"])
    Target("turnover_p95_s", 2).check(orders)
    Target("my_waits", 2).check(orders)
    for metric in ("turnover_p95_s", "late_percent", "stock_outs"):
        with pytest.raises(InputError, match=f"--most {metric}=-2: `{metric}` is never below 0; expected a number >="):
            Target(metric, -2).check(orders)
    Target("psv_per_order", 0).check(orders)
    Target("my_waits", -2).check(orders)
    due = [make_instance(load_scenario("grocery-day", ["instance.orders=20"]))]
    for metric in ("late_percent", "late_orders", "tardiness_s", "tardiness_p95_s"):
        Target(metric, 2).check(due)
        with pytest.raises(InputError, match=f"these runs have no `{metric}`: no order has a due time"):
            Target(metric, 2).check(orders)


def trials(scenario: Scenario, target: Target, store: Path, here: Any, told: list[Candidate] | None = None) -> Trials:
    tell = (lambda _: None) if told is None else told.append
    return Trials(Worlds(scenario, target.seeds[:4]), "hall", target, store, here, Watcher(), tell)


def test_clear_and_close_cases(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    told: list[Candidate] = []
    judge = trials(poisson, Target("turnover_p95_s", 5000), tmp_path, here, told)
    assert judge.passes(2, 3) and judge.passes(2, 3)
    (one,) = told
    sized = judge.worlds.of_size(2, 3)
    values = [run(sized, seed=seed).metrics["turnover_p95_s"] for seed in (1, 2, 3, 4)]
    assert one == Candidate(2, 3, Verdict.PASSES, 4, estimate(values, 0.95, 3))
    assert len(here.jobs) == 4
    seeds = tuple(range(1, 9))
    exact = trials(poisson, Target("turnover_s", 1e6, seeds=seeds), tmp_path, here).worlds.of_size(2, 2)
    mean = sum(run(exact, seed=seed).metrics["turnover_s"] for seed in seeds) / len(seeds)
    judge = trials(poisson, Target("turnover_s", mean, seeds=seeds), tmp_path, here)
    assert not judge.passes(2, 2)
    found = judge.judged[2, 2]
    assert (found.verdict, found.seeds) == (Verdict.UNDECIDED, 8)


def test_runs_that_are_stored_or_fail(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    trials(poisson, Target("turnover_p95_s", 5000), tmp_path, here).passes(2, 3)
    judge = trials(poisson, Target("turnover_s", 4000), tmp_path, here)
    assert judge.passes(2, 3)
    assert len(here.jobs) == 4
    short = evolve(poisson, run=RunSection(until_s=300))
    judge = trials(short, Target("turnover_p95_s", 5000), tmp_path, here)
    assert not judge.passes(2, 3)
    expected = Candidate(2, 3, Verdict.FAILS, 4, None, "seed 1 ends with orders left")
    assert judge.judged[2, 3] == expected
    rules = evolve(poisson.rules, pr=RuleChoice(write_rule(tmp_path, "pr", FAILS)))
    judge = trials(
        evolve(poisson, rules=rules, folder=str(tmp_path)), Target("turnover_s", 5000), tmp_path / "runs", here
    )
    assert not judge.passes(2, 3)
    found = judge.judged[2, 3]
    assert (found.verdict, found.failed) == (Verdict.FAILS, 4)
    assert "out of ideas" in str(found.reason)


def test_a_run_without_a_result_ends_the_search(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    here.run = lambda job: Outcome(None, "its worker process died", "WorkerDiedError")
    judge = trials(poisson, Target("turnover_s", 5000), tmp_path, here)
    with pytest.raises(RunError, match="2 stations, 3 robots, seed 1: its worker process died"):
        judge.passes(2, 3)
    assert judge.judged == {}


def test_what_is_impossible_is_not_run(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    judge = trials(poisson, Target("turnover_p95_s", 1), tmp_path, here)
    assert not judge.passes(2, 3)
    assert str(judge.judged[2, 3].reason).startswith("whatever the rules, it is ")
    assert here.jobs == []


def test_a_metric_that_runs_do_not_have(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="=5: these runs have no `bundle_turnover_s`: nothing in"):
        trials(poisson, Target("bundle_turnover_s", 5), tmp_path, here).passes(2, 3)


def sides(worlds: Worlds, stations: int) -> tuple[int, int]:
    layout = worlds.of_size(stations, 1).layout
    return layout.stations_east, layout.stations_west


def test_sides_of_the_hall(poisson: Scenario) -> None:
    assert [sides(Worlds(poisson, [1]), n) for n in (1, 2, 3, 4)] == [(1, 0), (2, 0), (2, 1), (2, 2)]
    both = evolve(poisson, layout=evolve(poisson.layout, stations_east=1, stations_west=1))
    assert [sides(Worlds(both, [1]), n) for n in (1, 2, 3, 4)] == [(0, 1), (1, 1), (2, 1), (2, 2)]
    worlds = Worlds(poisson, [1])
    assert worlds.changes(3, 7) == {"layout.stations_east": 2, "layout.stations_west": 1, "robots.count": 7}
    assert worlds.of_size(3, 7).robots.count == 7
    worlds, target = Worlds(poisson, [1]), Target("turnover_p95_s", 1e6)
    assert "81 robots; the layout has 80 storage locations" in str(worlds.obstacle(2, 81, target))
    listed = Worlds(evolve(poisson, stations=StationsSection(item_capacity=(15, 10))), [1])
    assert listed.obstacle(2, 2, target) is None
    assert "found 2 capacities, but the layout has 3" in str(listed.obstacle(3, 2, Target("late_percent", 2)))


def test_what_no_rules_can_keep_needs_no_run(poisson: Scenario) -> None:
    worlds = Worlds(poisson, [1, 2, 3])
    bounds = [
        bound.value
        for seed in (1, 2, 3)
        for bound in bounds_of(worlds.of_size(2, 2).with_seed(seed))
        if bound.metric == "turnover_p95_s" and bound.value is not None
    ]
    easiest = min(bounds)
    reason = worlds.obstacle(2, 2, Target("turnover_p95_s", easiest - 0.1))
    assert reason == f"whatever the rules, it is {easiest:,.1f} s or more"
    assert worlds.obstacle(2, 2, Target("turnover_p95_s", easiest + 0.1)) is None
    assert easiest < run(worlds.of_size(2, 2)).metrics["turnover_p95_s"]


@cases(
    "begun items_s lines_s orders_s told",
    ({}, 13.0, 0.0, 0.0, "{:.0f} items per hour at 13 s each"),
    (
        {"line_s": 2.0, "order_s": 4.0, "speed": {"1": 0.5, "2": 2.0}},
        *(6.5, 1.0, 2.0),
        "{:.0f} items per hour at 6.5 s each, {:.0f} lines per hour at 1 s each and 250 orders per hour at 2 s each",
    ),
)
def test_pickers_that_cannot_keep_up(poisson, begun, items_s, lines_s, orders_s, told) -> None:
    """Items an hour times 13 s is more than an hour has, for so many pickers, and what is begun comes on top."""
    arrivals = Arrivals(process="poisson", orders_per_hour=250)
    stations = evolve(poisson.stations, **begun)
    worlds = Worlds(evolve(poisson, instance=evolve(poisson.instance, arrivals=arrivals), stations=stations), [1, 2])
    orders = [order for instance in worlds.instances for order in instance.orders]
    items = 250 * sum(order.items for order in orders) / len(orders)
    lines = 250 * sum(len(order.lines) for order in orders) / len(orders)
    percent = (items * items_s + lines * lines_s + 250 * orders_s) / 36
    assert 100 < percent < 200
    assert worlds.overload(1) == f"{told.format(items, lines)} keep each picker busy for {percent:.0f} % of the time"
    assert worlds.overload(2) is None


@pytest.mark.parametrize("process", ["start", "day"])
def test_a_load_that_ends_overloads_nobody(process: str, poisson: Scenario) -> None:
    ending = evolve(poisson, instance=evolve(poisson.instance, arrivals=Arrivals(process=process)))
    worlds = Worlds(ending, [1])
    assert worlds.overload(1) is None
    assert worlds.at_once == (process == "start")


def test_only_what_is_out_of_the_ordinary_is_said() -> None:
    text = io.StringIO()
    notices = Notices(Console(file=text, width=40))
    job = cast(Any, "hall, 2 stations, 3 robots, seed 1")
    notices.started(4, 0, 1)
    notices.run_started(job)
    notices.run_dropped(job, "is not as it was stored")
    notices.run_repeated(job, "its worker process died")
    notices.ended()
    assert text.getvalue().splitlines() == [
        f"Computed again: {job}: is not as it was stored",
        f"Repeated: {job}: its worker process died",
    ]


def test_robust_keeps_what_the_scenario_says() -> None:
    given = load_scenario("examples/poisson", ["stations.pick_s={mean=5, cv=2}", "robots.failures={mtbf_h=1,mttr_s=9}"])
    robust = under_spread_and_failures(given)
    assert (robust.stations.pick_s, robust.robots) == (given.stations.pick_s, given.robots)
    assert robust.stations.handle_s == ServiceTime(Spread(mean=13.0, cv=0.5))
    assert robust.stations.outages == FAILURES


QUICK = ("--stations", "2", "--robots", "2", "--seeds", "2", "--jobs", "1")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with a scenario and a rule that fails."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    (tmp_path / "hall.toml").write_text(POISSON, encoding="utf-8")
    write_rule(tmp_path, "pr", FAILS)
    return tmp_path


size_code = partial(exit_code, "size")


def test_the_answer_is_printed_and_kept(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert size_code("hall.toml", "--p95", "5000", *QUICK) == 0
    printed = capsys.readouterr()
    assert "Turn-over time, p95, at most 5,000.0 s with 95 % confidence: 2 stations with 2 robots." in printed.out
    assert printed.err.splitlines()[-1].startswith("2 stations, 2 robots: ")
    out = folder / "rmfs-runs" / "size-hall"
    assert {path.name for path in out.iterdir()} == {"runs", "answer.json", "candidates.csv"}
    before = {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")}
    text = (out / "answer.json").read_text("utf-8")
    assert size_code("hall.toml", "--p95", "5000", *QUICK) == 0
    assert capsys.readouterr().out == printed.out
    assert (out / "answer.json").read_text("utf-8") == text
    assert {path: path.stat().st_mtime_ns for path in (out / "runs").rglob("*")} == before
    costs = ("--robot-cost", "2", "--station-cost", "3")
    assert size_code("hall.toml", "--most", "psv_per_order=99", *costs, "--json", *QUICK) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["metric"] == "psv_per_order"
    assert content["cheapest"] == {"stations": 2, "robots": 2, "cost": 10}


def test_packers_and_boxes_are_sized(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("--packers", "1-2", "--boxes", "1-3", "--seeds", "2", "--jobs", "1", "--set", "packing.conveyor_s=20")
    costs = ("--robot-cost", "2", "--station-cost", "3", "--set", "rules.poa_pps=pod-index")
    without = ("--set", "rules.poa=", "--set", "rules.pps=")
    assert size_code("hall.toml", "--p95", "5000", *asked, *costs, *without, "--json") == 0
    printed = capsys.readouterr()
    assert printed.err.splitlines()[0].startswith("2 packers, 3 boxes: ")
    content = json.loads(printed.out)
    assert content["metric"] == "packed_p95_s"
    assert [row["boxes"] for row in content["packers"]] == [None, 1]
    assert "keep each packer busy for 1" in content["packers"][0]["reason"]
    assert content["cheapest"] == {"packers": 2, "boxes": 1, "cost": 8}
    assert "Packers and boxes are those of each packing station." in content["notes"]
    whole = "No order was split in these runs, so that with these rules the number of boxes makes no difference."
    assert whole not in content["notes"]
    assert size_code("hall.toml", "--p95", "5000", *asked, "--json") == 0
    assert whole in json.loads(capsys.readouterr().out)["notes"]


def test_with_costs_the_cheapest_size_is_sought_beside_the_fewest_robots(folder, capsys) -> None:
    prices = ("--set", "costs={picker_per_h=60, robot_per_h=1}", "--set", "instance.arrivals={process='start'}")
    asked = ("--stations", "2", "--robots", "1-6", "--seeds", "2", "--jobs", "1", "--json")
    assert size_code("hall.toml", "--most", "turnover_s=5000", *asked, *prices) == 0
    content = json.loads(capsys.readouterr().out)
    costs = {row["robots"]: row["cost_per_order"] for row in content["candidates"]}
    best = content["least_per_order"]["robots"]
    assert content["frontier"][0]["robots"] == 1 < best  # with more robots people go home earlier
    assert costs[best] == min(costs.values()) == content["least_per_order"]["cost_per_order"]
    assert {best - 1, min(best + 1, 6)} <= costs.keys()
    assert f"an order costs least with 2 stations with {best} robots: {costs[best]:,.4f}" in content["notes"][1]
    table = (folder / "rmfs-runs" / "size-hall" / "candidates.csv").read_text("utf-8")
    assert table.splitlines()[0].endswith(",reason,cost_per_order")


def test_a_run_that_fails_ends_with_code_1(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    failing = ("--set", "rules.pr=./bad.py:Bad", "--out", "out")
    assert size_code("hall.toml", "--mean", "5000", *failing, *QUICK) == 1
    printed = capsys.readouterr()
    assert "Loading code from bad.py." in printed.err
    assert "2 runs failed; out/answer.json says why." in printed.err
    assert "out of ideas" in (folder / "out" / "candidates.csv").read_text("utf-8")
    assert size_code("hall.toml", "--mean", "5000", "--no-inline-rules", *failing, *QUICK) == 2


@cases(
    "arguments sentence",
    ((), "expected one of --p95, --mean and --most"),
    (("--p95", "900", "--mean", "300"), "expected one of --p95, --mean and --most"),
    (("--p95", "0"), "expected a number > 0, found 0"),
    (("--p95", "inf"), "expected a number, as in --p95 900"),
    (("--most", "late_percent"), "expected a number, as in --p95 900 or --most late_percent=2"),
    (("--most", "late_percent=few"), "found late_percent=few"),
    (
        ("--most", "late_percnt=2", *QUICK),
        '--most late_percnt=2: there is no metric "late_percnt" (did you mean `late_percent`',
    ),
    (("--p95", "900", "--robots", "0-4"), "expected a number from 1 on, or two such as 2-6, found 0-4"),
    (("--p95", "900", "--stations", "5-2"), "or two such as 2-6, found 5-2"),
    (("--p95", "900", "--stations", "2-9999"), "--stations: found 9,999; expected 200 at most"),
    (("--p95", "900", "--robots", "1-999"), "--robots: found 999; the layout has 80 storage locations"),
    (("--p95", "900", "--robot-cost", "3"), "--robot-cost and --station-cost together, or neither"),
    (("--p95", "900", "--set", "instance.pods=1000"), "1000 pods, but the layout has"),
    (("--most", "cost_pickers_per_order=2", "--robots", "4"), "more stations raise `cost_pickers_per_order`; expected"),
    (("--p95", "900", "--boxes", "4"), "--packers, --boxes: the scenario has no packing stations; expected one with a"),
    (("--p95", "900", "--boxes", "4", "--robots", "4"), "expected --stations and --robots, or --packers and --boxes"),
    (("--p95", "9", "--boxes", "999999", "--set", "packing.boxes=1"), "--boxes: found 999,999; expected 100,000 at"),
)
def test_wrong_input_is_one_sentence(arguments, sentence, folder, capsys) -> None:
    assert size_code("hall.toml", *arguments) == 2
    err = capsys.readouterr().err
    assert sentence in err
    assert "Traceback" not in err


TARGET = Target("turnover_p95_s", 900, seeds=(1, 2, 3, 4))
PASSES = Candidate(2, 9, Verdict.PASSES, 4, Estimate(612.34, 500, 700))
UNDECIDED = Candidate(2, 8, Verdict.UNDECIDED, 4, Estimate(880, 700, 1060))
PARTIAL = Candidate(3, 8, Verdict.FAILS, 4, None, "seed 3 ends with orders left")
ANSWER = Answer(
    "hall",
    TARGET,
    (Found(1, None, "too busy"), Found(2, 9), Found(3, None, "saves no robot")),
    (PASSES,),
    (UNDECIDED, PASSES, PARTIAL),
    at_once=False,
)


def test_the_table_has_every_size(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    output_console().print(table_of(ANSWER))
    rows = [line.split(maxsplit=6) for line in capsys.readouterr().out.splitlines()]
    assert rows[0] == ["Turn-over", "time,", "p95,", "at", "most", "900.0", "s"]
    assert rows[2] == ["Stations", "Robots", "Mean", "Interval", "Seeds", "Verdict"]
    assert rows[4:9] == [
        ["1", "too", "busy"],
        ["2", "8", "880.0", "[700.0,", "1,060.0]", "4", "undecided"],
        ["2", "9", "612.3", "[500.0,", "700.0]", "4", "passes, fewest"],
        ["3", "8", "4", "fails:", "seed", "3", "ends with orders left"],
        ["3", "saves", "no", "robot"],
    ]
    monkeypatch.setenv("COLUMNS", "60")
    key = "layout.stations_east_of_the_hall"
    output_console().print(table_of(evolve(ANSWER, found=(Found(2, 9), Found(5, None, key)))))
    assert key in "".join(line[46:].strip() for line in capsys.readouterr().out.splitlines())  # not cut off


def test_the_answer_in_one_sentence() -> None:
    assert list(sentences_of(ANSWER, (1, 10))) == [
        "Turn-over time, p95, at most 900.0 s with 95 % confidence: 2 stations with 9 robots.",
        "The cheapest of these costs 29: 2 stations with 9 robots.",
        "Undecided after 4 seeds: 2 with 8; more --seeds may tell.",
    ]
    nothing = Answer("hall", TARGET, (Found(1, None, "too busy"),), (), (), at_once=True)
    none, backlog = sentences_of(nothing, (1, 10))
    assert none.endswith("none of the sizes is shown to be enough.")
    assert backlog.startswith("All orders are there at once")


def test_files_have_the_same(tmp_path: Path) -> None:
    write_answers([ANSWER], (1, 10), tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"answer.json", "candidates.csv"}
    with (tmp_path / "candidates.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["stations"], row["robots"], row["mean"], row["fewest"]) for row in rows] == [
        ("2", "8", "880", "false"),
        ("2", "9", "612.34", "true"),
        ("3", "8", "", "false"),
    ]
    content = json.loads((tmp_path / "answer.json").read_text("utf-8"))
    assert content == content_of(ANSWER, (1, 10))
    assert content["cheapest"] == {"stations": 2, "robots": 9, "cost": 29}
    assert [one["robots"] for one in content["frontier"]] == [9]
    assert [one["reason"] for one in content["stations"]] == ["too busy", None, "saves no robot"]
    assert "cheapest" not in content_of(ANSWER, None)


POISSON = """
[instance]
orders = 16
skus = 8
pods = 6
skus_per_pod = 3
[instance.arrivals]
process = "poisson"
orders_per_hour = 150
[layout]
block_rows = 5
block_columns = 2
stations_east = 2
[robots]
count = 2
[rules]
poa = "pod-match"
pps = "demand"
pp = "free-flow"
"""


class Here:
    """Workers that are this process: nothing has to be started."""

    count = 1
    closed = False

    def __init__(self) -> None:
        self.jobs: list[Job] = []

    def run(self, job: Job) -> Outcome:
        self.jobs.append(job)
        return simulate(job)

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def here() -> Here:
    return Here()


@pytest.fixture
def poisson() -> Scenario:
    return scenario_from_dict(tomllib.loads(POISSON))
