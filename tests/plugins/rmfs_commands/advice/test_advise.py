"""`rmfs advise`: the part of the day that is simulated, the candidates, the answer, the command."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from calling import exit_code, refused
from cases import cases
from rmfs_commands.advice.answer import (
    Best,
    against_whole,
    best,
    best_of_each,
    caption,
    cheapest,
    more,
    sentences_of,
    share,
    table_of,
    with_open_orders,
)
from rmfs_commands.advice.candidates import advice_experiment, lets_split
from rmfs_commands.advice.cutting import cut
from rmfs_commands.cli.main import main
from rmfs_commands.cli.serving import SERVING, serving_lines
from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.compare import Interval
from rmfs_core import Scenario, load_scenario
from rmfs_core.results.catalogue import Metric
from rmfs_core.rules import RuleSet
from rmfs_core.scenario.model import Costs
from rmfs_core.world import make_instance

DAY = ["instance.arrivals.process=day", f"instance.arrivals.profile={[0, 0, 2, 2, 0, 6] + 18 * [0]}"]

PART = ("--set", DAY[0], "--set", f"instance.arrivals.profile={[1, 1, 1, 0, 0, 6] + 18 * [0]}")


@cases(
    "overrides hours until_s told",
    (["instance.orders=40"], None, None, "Simulated: all 40 orders."),
    (["instance.orders=40"], 0.5, 1800, "Simulated: 0.5 hours, in which 40 of 40 orders arrive."),  # all at the start
    (["instance.orders=500"], None, None, "Simulated: all 500 orders."),
    (["instance.orders=50", *DAY], 99, None, "Simulated: all 50 orders."),
    (["instance.orders=50", "run.until_s=8000", *DAY], 99, 8000, "Simulated: 8,000 s, as in the scenario."),
    (["instance.orders=900", *DAY], None, 14_400, "Simulated: 2 hours, in which 343 of 900 orders arrive."),
    (["instance.orders=50", "run.warmup_s=10800", *DAY], 1, 14_400, "Simulated: 1 hour, in which"),
)
def test_a_part_of_the_time_is_simulated(overrides, hours, until_s, told) -> None:
    found = cut(load_scenario("examples/small", overrides), hours)
    assert found.told[0].startswith(told)
    assert ("Hours and numbers of orders are those of the first seed." in found.told) is ("343" in told)
    assert found.scenario.run.until_s == (until_s if until_s is None else pytest.approx(until_s, abs=1800))


def test_a_cut_without_the_busiest_hour_says_so() -> None:
    scenario = load_scenario("examples/small", ["instance.orders=200", *DAY])
    assert "--hours 4 includes it" in cut(scenario, 2).told[-1]
    assert (len(cut(scenario, 3).told), len(cut(scenario, 4.5).told)) == (3, 1)


def test_the_busiest_hour_is_one_of_the_clock() -> None:
    """The first order arrives at half past, and the many of the hour from 05:00 are not divided by that."""
    profile = [0, 0, 0, 1, 0, 6] + 18 * [0]
    over = ["instance.orders=200", DAY[0], f"instance.arrivals.profile={profile}", "instance.start=2026-01-05T03:30:00"]
    scenario = load_scenario("examples/small", over)
    of_hour = sum(5400 <= order.arrival_tick / 1000 < 9000 for order in make_instance(scenario).orders)
    assert (
        f"The busiest hour, from 05:00 on day 1, is not among them: it has {of_hour} orders"
        in cut(scenario, 1).told[-1]
    )
    night = load_scenario("examples/small", [*over[:-1], "instance.start=2026-01-04T23:30:00"])
    assert "The busiest hour, from 05:00 on day 2, is not among them" in cut(night, 1).told[-1]


@cases(
    "hours until_s left",
    (None, 5.5, "1 departure after the end, of {}"),
    (1, 3, "2 departures after the end, of {}"),
    (99, None, ""),
)
def test_a_cut_goes_on_to_the_last_truck_of_the_day(hours: float | None, until_s: float | None, left: str) -> None:
    over = ["instance.orders=900", *DAY, 'instance.departures={times=["05:30"], cutoff_s=60}']
    scenario = load_scenario("examples/small", over)
    found = cut(scenario, hours)
    if until_s is None:
        assert found.told == ("Simulated: all 900 orders.",)
        return
    assert found.scenario.run.until_s == pytest.approx(3600 * until_s, abs=1800)
    end = 1000 * (found.scenario.run.until_s or 0)
    late = sum((order.due_tick or 0) > end for order in make_instance(scenario).orders)
    assert found.told[-1] == f"Left out: {left.format(f'{late} orders')}; `missed_percent` tells nothing of them."


@cases(
    "name overrides split own others",
    ("examples/small", [], False, "pod-match + demand (now)", 5),
    ("examples/small", ["rules.pps=completes"], False, "pod-match + completes (now)", 4),
    ("examples/packing", [], True, "pod-index (now)", 5),
    ("examples/packing", ["rules.poa=first-come", "rules.pps=demand"], True, "first-come + demand (now)", 6),
    ("examples/small", ["rules.poa_pps=integrated"], False, "integrated (now)", 5),
    ("examples/small", ["rules.poa_pps=split-among-stations"], True, "split-among-stations (now)", 6),
)
def test_the_candidates_are_those_that_the_scenario_lets_be(name, overrides, split, own, others) -> None:
    scenario = load_scenario(name, overrides)
    assert lets_split(scenario, RuleSet.load(scenario.rules, ".")) is split
    experiment = advice_experiment(scenario, "hall", (1, 2), split=split)
    assert (experiment.baseline, len(experiment.rule_sets)) == (own, others + 1)
    assert ("packed_s" in experiment.metrics) is (scenario.packing is not None)
    assert len(experiment.jobs()) == 2 * (others + 1)


MEASURED = {name: Metric(name, of_completed=True) for name in ("turnover_p95_s", "packed_s", "packed_p95_s")}
NONE_BEST: dict[str, tuple[float, float]] = {}


@pytest.fixture
def small() -> Scenario:
    return load_scenario("examples/small")


def result_of(
    scenario: Scenario, seeds: int = 4, figures: Mapping[str, tuple[float, float]] = NONE_BEST
) -> ExperimentResult:
    """Return made-up runs: visits and seconds of rule sets by the first word of their names; others have 9 and 900."""
    experiment = advice_experiment(scenario, "hall", tuple(range(seeds)), split=False)
    rows: list[dict[str, Any]] = []
    for one in experiment.rule_sets:
        word = "now" if one.name == experiment.baseline else one.name.split()[0].replace("-", "_")
        visits, turnover = figures.get(word, (9.0, 900.0))
        for seed in range(seeds):
            more = 1 + 0.01 * (seed + len(one.name) % 3 * (-1) ** seed)  # so that differences vary
            row = {"instance": "hall", "scenario": "hall", "rule_set": one.name, "seed": seed, "status": "complete"}
            row |= {"error_kind": None, "psv_per_order": visits * more, "turnover_s": turnover * more}
            rows.append(row | {"turnover_p95_s": 2 * turnover * more})
    return ExperimentResult(experiment, rows)


def best_of(result: ExperimentResult, number: int) -> Best:
    found = best(result, result.experiment.metrics[number])
    assert found is not None
    return found


def answer(result: ExperimentResult, seeds: int = 4) -> list[str]:
    result = against_whole(result)
    return [*sentences_of(best_of_each(result), seeds)]


@cases(
    "figures begins",
    ({"near_best_pod": (1.0, 100.0)}, "Take near-best-pod + completes: no other"),
    ({"now": (1.0, 100.0), "near_best_pod": (1.01, 100.2)}, "Keep pod-match + demand: no other"),
    (
        {"workload": (2.0, 100.0), "common_lines": (1.0, 150.0)},
        "Take workload + lexicographic where orders have to leave soon, common-lines + completes where each pod "
        "visit costs: the second takes 50 % more time, the first makes 100 % more visits.",
    ),
)
def test_the_answer_is_what_no_other_is_shown_to_beat(small, figures, begins) -> None:
    assert answer(result_of(small, figures=figures))[0].startswith(begins)


def test_of_those_that_are_not_told_apart_the_own_one_is_kept(small: Scenario) -> None:
    result = result_of(
        small, figures={"now": (3.0, 100.2), "near_best_pod": (2.9, 100.0), "common_lines": (1.0, 200.0)}
    )
    assert best_of(result, 1).least == "near-best-pod + completes"
    assert answer(result)[0].startswith(
        "Take pod-match + demand (as now) where orders have to leave soon, common-lines"
    )
    assert "takes 100 % " in answer(result)[0]


def test_own_rules_are_not_kept_where_another_set_is_shown_to_be_better(small: Scenario) -> None:
    """Though seeds show no difference from the lowest mean, which varies much."""
    result = result_of(small, figures={"now": (9.0, 100.0), "workload": (9.0, 70.0), "near_best_pod": (9.0, 69.0)})
    for row in result.rows:
        if row["rule_set"].startswith("near-best-pod"):
            row["turnover_s"] += 60 * (-1) ** row["seed"]
    found = best_of(result, 1)
    assert (found.take, found.others) == ("workload + lexicographic", ("near-best-pod + completes",))
    told = answer(result)
    assert told[0].startswith("Take workload + lexicographic: no other rule set is shown")
    assert told[1] == "Against your rules it takes 30 % less time and makes 0 % more visits."


def test_rule_sets_that_are_not_told_apart_win_nothing(small: Scenario) -> None:
    result = result_of(small, figures={"near_best_pod": (1.0, 100.0), "common_lines": (1.001, 150.0)})
    assert answer(result)[0].startswith("Take near-best-pod + completes")
    alike = set(best_of(result, 0).names)
    assert alike == {"near-best-pod + completes", "common-lines + completes"}
    assert answer(result_of(small))[0].startswith(
        "Keep your rules: 4 seeds show no difference between the rule sets; more"
    )
    assert answer(result_of(small, 2), 2) == [
        "2 seeds cannot show a difference between rule sets: take 3 or more with --seeds."
    ]
    first = [{**row, "seed": seed} for row in result.rows if not row["seed"] for seed in range(4)]
    assert (same := evolve(result, rows=first)).repeats and not result.repeats
    assert [*sentences_of(best_of_each(same), 4, repeats=True)] == [
        "In this run common-lines + completes makes the fewest visits and near-best-pod + completes takes the least "
        "time. Every seed gives the same run, so more seeds tell nothing."
    ]
    failed = [row | {"status": "failed", "error": "no"} for row in result.rows]
    assert answer(evolve(result, rows=failed))[0].startswith("No rule set completes all of its runs")


KEEP = " among the rule sets with a mean missed_percent of at most 4"


@cases(
    "limit sentence",
    (None, "Least cost per order: 0.508 (near-best-pod + completes)."),
    (("missed_percent", 4.0), f"Least cost per order{KEEP}: 1.015 (workload + lexicographic)."),
    (("missed_percent", 0.5), "No rule set has a mean missed_percent of at most 0.5."),
)
def test_with_costs_the_cheapest_that_keeps_a_limit_is_named(small, limit, sentence) -> None:
    made = result_of(evolve(small, costs=Costs()), figures={"workload": (9, 100.0), "near_best_pod": (9, 50.0)})
    missed = [1.0 if row["rule_set"].startswith("workload") else 5.0 for row in made.rows]
    costs = [{"cost_per_order": row["turnover_s"] / 100} for row in made.rows]
    rows = [r | c | {"missed_percent": m} for r, c, m in zip(made.rows, costs, missed, strict=True)]
    experiment = evolve(made.experiment, metrics=(*made.experiment.metrics, "missed_percent"))
    assert list(cheapest(evolve(made, experiment=experiment, rows=rows), limit)) == [sentence]


def test_orders_that_a_horizon_leaves_open_count(small: Scenario) -> None:
    result = result_of(small, figures={"near_best_pod": (1.0, 100.0)})
    assert with_open_orders(result) is result
    open_ones = {"status": "horizon", "orders_completed": 10, "open_orders_end": 30, "open_age_sum_h": 10.0}
    rows = [row | open_ones | {"turnover_s": 100.0} for row in result.rows]
    counted = with_open_orders(evolve(result, rows=rows, measures=MEASURED))
    assert counted.experiment.metrics[1] == "turnover_so_far_s"
    assert {row["turnover_so_far_s"] for row in counted.rows} == {(10 * 100 + 36_000) / 40}
    assert "Time: mean of turn-over time (order lead time) so far in s" in caption(counted)
    assert "95th*: of completed orders only." in caption(counted)
    assert "*: of" not in caption(result)
    first = [row for row in result.rows if row["seed"] == result.rows[0]["seed"]]
    assert "Intervals: 95 %" in caption(result)
    few = evolve(result, rows=first)
    assert "Intervals" not in caption(few)
    for one, marked in ((result, True), (few, False)):  # a mark needs the sentence of the caption on it
        assert any("*" in cell for cell in table_of(one, best_of_each(one)).columns[1].cells) == marked


def test_orders_that_are_not_packed_count() -> None:
    experiment = advice_experiment(load_scenario("examples/packing"), "hall", (0, 1, 2), split=False)
    figures = {"psv_per_order": 2.0, "packed_s": 90.0, "packed_p95_s": 99.0, "status": "horizon"}
    figures |= {"orders_packed": 10, "unpacked_end": 30, "unpacked_age_sum_h": 10.0}
    rows = [
        {"instance": "hall", "rule_set": one.name, "seed": seed, "error_kind": None, **figures}
        for one in experiment.rule_sets
        for seed in (0, 1, 2)
    ]
    result = ExperimentResult(experiment, rows, measures=MEASURED)
    assert "Time* and 95th*: of packed orders only." in caption(result)
    counted = with_open_orders(result)
    assert {row["packed_so_far_s"] for row in counted.rows} == {(10 * 90 + 36_000) / 40}
    assert [one.metric for one in best_of_each(counted)] == ["psv_per_order", "packed_so_far_s"]
    assert "Time: mean of the time from arrival to packed so far in s" in caption(counted)
    assert "95th*: of packed orders only." in caption(counted)


@cases(
    "whole told",
    (lambda name: not name.endswith("(now)"), ["4 seeds show no difference between the rule sets that complete"]),
    (lambda name: name.startswith("workload"), ["Only workload + lexicographic completes all of its runs"]),
)
def test_rules_that_fail_are_not_kept(small: Scenario, whole: Callable[[str], bool], told: list[str]) -> None:
    result = result_of(small)
    rows = [row if whole(row["rule_set"]) else row | {"status": "failed", "error": "no"} for row in result.rows]
    first, second = answer(evolve(result, rows=rows))
    assert first.startswith(told[0])
    assert second == "Your own rules do not complete all of their runs."


@cases(
    "found shown",
    (Interval(0.591, -1, 1, 1, 0.369, 0.811, 1), "59 % [37, 81] more time"),
    (Interval(-0.08, -1, 1, 1, -0.12, 0.021, 1), "8 % [-2, 12] less time"),
    (Interval(0.08), "8 % more time"),
)
def test_a_difference_in_words(found: Interval, shown: str) -> None:
    assert more(found, "less", "time").replace("\N{MINUS SIGN}", "-") == shown


@cases(
    "found shown",
    (Interval(None), "-"),
    (Interval(0.124), "+12 %"),
    (Interval(-0.391, -0.5, 0.1, 0.01, -0.441, -0.339, 0.02), "-39 % [-44, -34]"),
    (Interval(-0.001, -1, 1, 1, -0.004, 0.25, 1), "0 % [0, +25]"),
)
def test_shares_are_whole_percent(found: Interval, shown: str) -> None:
    assert share(found).replace("\N{MINUS SIGN}", "-") == shown


def test_the_command_answers_and_goes_on_where_it_stopped(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    quick = ("--set", "instance.orders=6", "--set", "rules.pp=free-flow", "-j", "1", "--seeds", "3")
    assert exit_code("advise", "examples/small", *quick) == 0
    printed = capsys.readouterr()
    assert "pod-match (spread = 0.5) + completes" in printed.out
    assert "rule sets that split orders" in printed.out
    assert exit_code("advise", "examples/small", *quick, "--json") == 0
    again = capsys.readouterr()
    assert "all 18 runs are stored already" in again.err
    content = json.loads(again.out)
    assert content == json.loads((tmp_path / "rmfs-runs" / "advise-small" / "advice.json").read_text("utf-8"))
    assert content["rule_sets"][1]["set"] == SERVING
    assert content["notes"][0] in " ".join(printed.out.split())


@cases(
    "arguments sentence",
    (("--hours", "0"), "expected a number > 0, found 0"),
    (("--seeds", "0"), "expected a whole number from 1 to 1,000, found 0"),
    (("--set", "rules.poa=nobody"), "rules.poa"),
    (("--most", "missed_percent=2"), "expected a scenario with a section `costs` with --most"),
    (("--most", "departed_share=1"), "more of `departed_share` is better; expected one of which less is"),
    (("--most", "late_percent=nan"), "expected a metric and a number, as in --most missed_percent=2, found late_per"),
    (("--most", "nosuch=1", "--set", "costs.kwh=1"), 'there is no metric "nosuch"; `rmfs metrics` lists all'),
    (("--set", "instance.orders=0"), "instance.orders=0: found no orders; expected at least one"),
    (("--hours", "1", "--set", "run.warmup_s=100"), "run.warmup_s=100: no order arrives between the warm-up and"),
    (("--hours", "1", "--set", "run.warmup_s=10800", *PART), "--hours: no order arrives between the warm-up"),
    (("--set", "instance.pods=1000"), "1000 pods, but the layout has"),
)
def test_what_is_wrong_is_one_sentence(arguments, sentence, capsys) -> None:
    assert sentence in refused(capsys, main, ["advise", "examples/small", "--quiet", *arguments])


def test_the_lines_of_a_scenario_select_the_same_rules(tmp_path: Path) -> None:
    file = tmp_path / "hall.toml"
    file.write_text(f"[rules]\n{serving_lines()}\n", encoding="utf-8")
    rules = load_scenario(file).rules
    assert (rules.poa, rules.pps) == (load_scenario("grocery-day").rules.poa, load_scenario("grocery-day").rules.pps)
