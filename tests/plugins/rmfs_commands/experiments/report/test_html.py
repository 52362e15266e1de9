"""The report of a comparison as one HTML file."""

from __future__ import annotations

import re

from attrs import evolve

from rmfs_commands.experiments import ExperimentResult
from rmfs_commands.experiments.report.html import report_html
from rmfs_commands.experiments.report.numbers import NO_TEST
from rmfs_commands.experiments.report.plots import Plot
from rmfs_core.results.catalogue import Metric


def page_of(result: ExperimentResult) -> str:
    """Return the report with empty pictures."""
    plots = [Plot(name, name, b"<svg/>", b"", b"") for name in ("differences", *result.experiment.metrics)]
    return report_html(result, result.comparison(), plots)


def fact(result: ExperimentResult, name: str) -> str:
    """Return what the report says of the experiment under a name."""
    found = re.search(rf"<dt>{re.escape(name)}</dt><dd>(.*?)</dd>", page_of(result), re.DOTALL)
    assert found is not None, name
    return found[1].strip()


def test_the_report_needs_nothing_else(result: ExperimentResult) -> None:
    """It loads nothing: every picture is in it; texts from outside are escaped; failures are told."""
    page = page_of(result)
    assert page.count('src="data:image/svg+xml;base64,') == 1 + 3
    assert not re.search(r'(src|href)="(?!data:|#)', page)
    assert "http" not in re.sub(r"base64,[A-Za-z0-9+/=]+", "", page)
    assert "Is &lt;more&gt; better?" in page
    assert "rule &lt;b&gt;bad&lt;/b&gt; &amp; worse: no idea" in page
    assert "2 (2 left out)" in page


def test_what_tells_nothing_is_the_same_as_on_the_terminal(result: ExperimentResult) -> None:
    """Two seeds: neither interval nor p in any cell."""
    result.rows[:] = [row for row in result.rows if row["seed"] < 3]
    page = page_of(result)
    assert "(no interval)</td><td>-</td>" in page
    assert not re.search(r"\[[^<]*\]</td>|<td>(&lt; )?0\.\d+</td>\s*<td>[+\u2212]", page)
    assert NO_TEST in page


def test_orders_of_one_day_are_told_beside_every_p(result: ExperimentResult) -> None:
    """Once with each metric."""
    told = "Orders come from a file and are the same for every seed"
    assert told not in page_of(result)
    assert page_of(evolve(result, fixed=frozenset({"orders=50", "orders=100"}))).count(told) == 3


def test_fronts_are_tables_too(with_front: ExperimentResult) -> None:
    """Of each instance set the rule sets that none beats in both."""
    page = page_of(with_front)
    assert "<h2>Picker utilisation (%) against Pile-on</h2>" in page
    assert page.partition("None beats these in both")[2].count("<td>base</td><td>2.200</td><td>52.00</td>") == 3


def test_a_plot_that_is_missing_is_left_out(result: ExperimentResult) -> None:
    """The report has its table all the same."""
    page = report_html(result, result.comparison(), [])
    assert "<img" not in page
    assert page.count("<table>") == 1 + 3


def test_the_report_says_what_was_run(result: ExperimentResult) -> None:
    """Runs, scenarios, axes, seeds, rule sets, versions; a digest among these is cut off."""
    assert fact(result, "Runs") == "18"
    assert fact(result, "Scenarios") == "small"
    assert fact(result, "instance.orders") == "50, 100"
    assert fact(result, "Rule sets") == "base, good, bad"
    assert fact(result, "Versions") == "rmfs 0.1.0"
    hashed = evolve(result, versions={"my_rule.py": "sha256:" + "0123456789ab" * 5})
    assert fact(hashed, "Versions") == "my_rule.py sha256:0123456789ab"


def test_seeds_in_a_row_are_a_span(result: ExperimentResult) -> None:
    """Others are listed."""
    for seeds, text in (
        ((1, 2, 3), "1 to 3"),
        ((1, 2), "1, 2"),
        ((1, 2, 4), "1, 2, 4"),
        ((3, 2, 1), "3, 2, 1"),
        ((1, 2, 10**15), "1, 2, 1000000000000000"),
    ):
        assert fact(evolve(result, experiment=evolve(result.experiment, seeds=seeds)), "Seeds") == text


def test_metrics_of_observers_are_shown_as_they_describe_them(result: ExperimentResult) -> None:
    """Label, unit and meaning where there are some, else the name."""
    for row in result.rows:
        if row["status"] != "failed":
            row |= {"balance": -row["pile_on"], "bare": 0.5}
    described = {"balance": Metric("balance", "Balance of work", "kJ", 1, "What it costs.")}
    shown = evolve(result, experiment=evolve(result.experiment, metrics=("balance", "bare")), measures=described)
    page = page_of(shown)
    assert ">Balance of work (kJ)</h2>" in page
    assert "What it costs." in page
    assert ">bare</h2>" in page


def test_bounds_have_columns_of_their_metric(bounded: ExperimentResult) -> None:
    """The bound, and how many times it a figure is; other metrics have no such columns, nor a report without bounds."""
    page = page_of(bounded)
    assert page.count("<th>Times the bound</th>") == 1
    assert '<td>2.200</td><td>1.250</td><td>1.76</td><td class="dim">baseline</td>' in re.sub(r"\n\s*", "", page)
    assert page.count('colspan="9"') == 3
    assert "what no rules can beat" in page
    for row in bounded.rows:
        del row["bound.pile_on"]
    assert "bound" not in page_of(bounded)
