"""A comparison on the terminal."""

from __future__ import annotations

import re

from attrs import evolve
from rich.console import Console

from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.report import print_comparison
from rmfs_commands.experiments.report.numbers import NO_TEST
from rmfs_commands.experiments.report.terminal import MOST_ERRORS
from rmfs_core.results.catalogue import Metric

FAILURE = "rule <b>bad</b> & worse: no idea"
"""Error of the run that failed."""


def printed(result: ExperimentResult, width: int) -> str:
    """Return what the terminal shows."""
    console = Console(width=width, record=True, quiet=False, file=None, force_terminal=False)
    with console.capture() as capture:
        print_comparison(console, result, result.comparison())
    return capture.get()


def test_the_terminal_shows_runs_and_comparisons(result: ExperimentResult) -> None:
    """At 120 columns every figure has its interval, and a failed run its error; no line is longer."""
    text = printed(result, 120)
    assert f"Failed: orders=100, bad, seed 3: {FAILURE}" in text
    assert re.search(r"good +3 +3\.200 +\+1\.000 \(no interval\) +- +\+45\.5 % \[", text)
    assert re.search(r"bad +2 \(1 left out\) +4\.150 ", text)
    assert "Picker utilisation (%)" in text
    assert re.search(r"overall *\n.*\n.*\n +bad +2 \(2 left out\) +4\.150 ", text)
    assert max(map(len, text.splitlines())) <= 120


def test_a_narrow_terminal_has_relative_differences_alone(result: ExperimentResult) -> None:
    """At 80 columns no name or interval is broken; differences from 0 are absolute, since they are no share of it."""
    text = printed(result, 80)
    assert re.search(r"good +3 +3\.200 +\+45\.5 % \[\+38\.1, \+52\.9\] +0\.001", text)
    assert re.search(r"good +3 +2\.0 +\+2\.0 \[", text.partition("Most split orders open")[2])
    assert max(map(len, text.splitlines())) <= 80


def test_two_seeds_have_no_intervals(result: ExperimentResult) -> None:
    """Nor p: a sentence says why."""
    result.rows[:] = [row for row in result.rows if row["seed"] < 3]
    for width in (80, 120):
        text = printed(result, width)
        assert re.search(r"good +2 +3\.150 +(\+1\.000 +)?\+46\.5 % *\n", text.replace("\u2212", "-"))
        assert "p (Holm)" not in text
        assert NO_TEST in " ".join(text.split())


def test_orders_of_one_day_are_told(result: ExperimentResult) -> None:
    """Where seeds do not repeat the demand; there is nothing to tell without p."""
    told = "come from a file and are the same for every seed"
    assert told not in " ".join(printed(result, 120).split())
    some = evolve(result, fixed=frozenset({"orders=50"}))
    assert f" Orders of orders=50 and overall {told}" in " ".join(printed(some, 120).split())
    day = evolve(result, fixed=frozenset({"orders=50", "orders=100"}))
    assert f" Orders {told}" in " ".join(printed(day, 120).split())
    day.rows[:] = [row for row in day.rows if row["seed"] < 3]
    assert told not in " ".join(printed(day, 120).split())


def test_other_signs_of_the_two_differences_are_told(result: ExperimentResult) -> None:
    """Less by 9 of 100, more by a half of 2: the means are less, the shares more on average."""
    for row in result.rows:
        if row["status"] != "failed":
            base = 100 if row["instance.orders"] == 100 else 2
            row["pile_on"] = row["seed"] / 1000 + (base if row["rule_set"] == "base" else {2: 3, 100: 91}[base])
    text = " ".join(printed(result, 80).split())
    assert "good, overall: the means differ by \u22124.000" in text
    assert "the other way round than the relative difference" in text
    assert "good, orders=50: the means" not in text
    assert "\u22124.000 (no interval), the other way round" in text
    for row in result.rows:
        if row["rule_set"] == "good" and row["status"] != "failed":
            row["pile_on"] += row["seed"] / 100
    assert re.search(r"\], p [<.0-9 ]+, the other way round", " ".join(printed(result, 80).split()))


def test_fronts_follow_the_metrics(with_front: ExperimentResult) -> None:
    """With the means of who is best in both; here the baseline has least of either."""
    text = printed(with_front, 80).partition("None beats these in both")[2]
    assert re.search(r"Rule set +Pile-on +Picker utilisation \(%\)", text)
    assert re.search(r"orders=50 *\n +base +2\.200 +52\.00 *\n +orders=100 *\n +base", text)


def test_metrics_of_observers_are_shown_as_they_describe_them(result: ExperimentResult) -> None:
    """With label, unit and digits; a dash where no run has the figure."""
    for row in result.rows:
        if row["status"] != "failed" and row["rule_set"] != "good":
            row["balance"] = -row["pile_on"]
    described = {"balance": Metric("balance", "Balance of work", "kJ", 1, "What it costs.")}
    shown = evolve(result, experiment=evolve(result.experiment, metrics=("balance",)), measures=described)
    block = printed(shown, 100).partition("Balance of work (kJ)")[2]
    assert re.search(r"orders=50 *\n +base +-2\.20 +baseline *\n +good +0 \(3 left out\) +- +-", block)


def test_not_all_failures_are_listed(result: ExperimentResult) -> None:
    """A few with their errors, the number of the others."""
    for row in result.rows[: MOST_ERRORS + 1]:
        row |= {"status": "failed", "error": "no idea"}
    text = printed(result, 100)
    assert text.count("Failed: ") == MOST_ERRORS
    assert "and 2 more failed runs." in text


def test_how_many_times_the_bound_is_shown(bounded: ExperimentResult) -> None:
    """In a column of the metrics that have a bound, with a sentence of what it is."""
    text = printed(bounded, 120)
    assert re.search(r"Rule set +Seeds +Mean +x bound +Difference ", text)
    assert text.count("x bound") == 1 + 1
    assert re.search(r"base +2\.200 +1\.76 +baseline", text)
    assert re.search(r"good +3 +3\.200 +2\.56 +\+1\.000", text)
    assert "what no rules can beat" in text
    assert max(map(len, text.splitlines())) <= 120


def test_without_bounds_nothing_is_said_of_them(result: ExperimentResult) -> None:
    """Neither column nor sentence."""
    assert "bound" not in printed(result, 120)
