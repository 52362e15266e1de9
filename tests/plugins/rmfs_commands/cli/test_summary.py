"""The table of metrics at the end of a run."""

from __future__ import annotations

import re

import pytest
from attrs import evolve
from rich.console import Console

import rmfs_core
from rmfs_commands.cli.summary import PROFILE, gaps_of, print_profile, print_summary
from rmfs_commands.details.catalogue import METRICS
from rmfs_core.results import Result
from rmfs_core.results.catalogue import Metric


@pytest.fixture(scope="module")
def result() -> Result:
    """Return the result of a small run."""
    return rmfs_core.run("examples/small", overrides=["instance.orders=5", "rules.pp=free-flow"])


def summary(result: Result, width: int = 100) -> str:
    """Return what is printed on a console of this width."""
    console = Console(width=width, force_terminal=False)
    with console.capture() as capture:
        print_summary(console, "small", result)
    return capture.get()


@pytest.mark.parametrize("width", [60, 80, 100, 200])
def test_every_metric_has_its_place(result: Result, width: int) -> None:
    """Whatever the width, but for simulated time, which the makespan says; no line is longer than the console."""
    text = summary(result, width)
    for group in METRICS.values():
        for metric in group:
            assert (metric.label.strip() in text) == (metric.name != "simulated_s"), metric.name
    assert max(map(len, text.splitlines())) <= width
    assert "small, seed 1: complete" in text


def test_a_narrow_console_has_one_column(result: Result) -> None:
    """Else there are two side by side."""
    assert not re.search(r"Orders completed .* Picks ", summary(result, 60))
    assert any("Orders" in line and "Pods" in line for line in summary(result, 100).splitlines())


def test_a_run_with_orders_left_has_no_makespan(result: Result) -> None:
    """But the time that it was simulated for."""
    left = evolve(result, status="partial", metrics={**result.metrics, "makespan_s": None, "simulated_s": 99.5})
    text = summary(left)
    assert "Makespan" not in text
    assert re.search(r"Simulated time +99\.5 +s", text)
    assert "seed 1: partial" in text


def test_figures_of_observers_are_shown_as_they_describe_them(result: Result) -> None:
    """With label, unit and digits; by their name where they do not."""
    described = {"balance": Metric("balance", "Balance of work", "kJ", 1, "What it costs.")}
    own = evolve(result, metrics={**result.metrics, "balance": 2.25, "bare": 3}, described=described)
    text = summary(own)
    assert "Observers" in text
    assert re.search(r"Balance of work +2\.2 +kJ", text)
    assert re.search(r"bare +3", text)
    assert "Observers" not in summary(result)


def test_the_profile_says_where_the_time_went(result: Result) -> None:
    """Seconds and shares of all parts; the hooks with most time first."""
    seconds = dict.fromkeys(PROFILE, 0.0) | {"queries": 3.0, "rules": 1.0}
    timing = {**result.timing, "profile_s": seconds, "hook_s": {"plan_path": 0.5, "assign_orders": 2.0}}
    console = Console(width=100, force_terminal=False)
    with console.capture() as capture:
        print_profile(console, evolve(result, timing=timing))
    text = capture.get()
    assert re.search(r"Path queries +3\.000 +75\.0", text)
    assert all(label in text for label in PROFILE.values())
    assert text.index("in assign_orders") < text.index("in plan_path")


class Watching:
    """Observer whose metric looks like markup."""

    measures = (Metric("waits", "Waits [s] [/nope]", "[red]", 0),)

    @rmfs_core.hookimpl
    def measured(self) -> dict[str, float | None]:
        """Measure something."""
        return {"waits": 3}


def test_a_label_is_no_markup(capsys: pytest.CaptureFixture[str]) -> None:
    """An observer's metric is shown as it is called."""
    result = rmfs_core.run("examples/small", overrides=["instance.orders=2"], observers=[Watching()])
    print_summary(Console(width=100), "small", result)
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "Waits" in line]
    assert "Waits [s] [/nope]" in line
    assert "[red]" in line


def row(status: str, objective: float | None, bound: float | None) -> dict[str, object]:
    """Return a decision's row of periods.csv."""
    return {"status": status, "objective": objective, "bound": bound, "stopped_early": status in ("effort", "stopped")}


def test_gaps_of_a_run() -> None:
    """Decisions that ended at their effort are counted, and the largest gap is that of any solve that a limit ended."""
    rows = [row("optimal", 4, 4), row("effort", 10, 9), row("stopped", 8, 6), row("effort", 5, None)]
    assert gaps_of(rows) == {"ended_at_effort": 2, "largest_gap": pytest.approx(25)}


def test_nothing_is_said_where_all_is_proven() -> None:
    """Without such solves there is no line for them."""
    assert gaps_of([row("optimal", 4, 4), row("decided", None, None)]) == {}


def test_no_gap_without_a_bound() -> None:
    """Where no bound is known there is a count, but no gap."""
    assert gaps_of([row("stopped", 4, None)]) == {"ended_at_effort": 0}
