"""The report of a comparison: numbers, tables, plots, terminal and HTML; `rmfs compare RUN RUN`."""

import csv
import io
import json
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pandas
import pytest
from attrs import evolve
from matplotlib.figure import Figure
from rich.console import Console

import rmfs_core
from calling import exit_code, refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.experiments import Axis, AxisPoint, Base, Experiment, ExperimentResult, RuleSetChoice
from rmfs_commands.experiments.compare import summary
from rmfs_commands.experiments.report import print_comparison, write_report
from rmfs_commands.experiments.report.files import ONE_COLUMN_CM
from rmfs_commands.experiments.report.html import report_html
from rmfs_commands.experiments.report.numbers import CENSORED, MINUS, NO_TEST, OF_MEAN_NOTE, title
from rmfs_commands.experiments.report.plots import MOST_RULE_SETS, Plot, make_plots, plot_of
from rmfs_commands.experiments.report.tables import SUMMARY_COLUMNS, grids, summary_csv, write_parquet
from rmfs_commands.experiments.report.terminal import MOST_ERRORS
from rmfs_core.results.catalogue import Metric
from rmfs_core.scenario import load_scenario


def test_a_title_stands_by_itself() -> None:
    part = Metric(
        "loaded_distance_m", "  with a pod", "m", 0, "Part of the distance driven with a pod. Turns add none."
    )
    assert title(part) == "Part of the distance driven with a pod (m)"


FAILURE = "rule <b>bad</b> & worse: no idea"
"""Error of the run that failed."""


def test_pandas_reads_the_runs(result: ExperimentResult, tmp_path: Path) -> None:
    write_parquet(result, tmp_path / "runs.parquet")
    runs = pandas.read_parquet(tmp_path / "runs.parquet")
    assert runs.shape == (18, 13)
    means = runs.groupby(["instance.orders", "rule_set"])["pile_on"].mean()
    assert (means[50, "good"], runs["pile_on"].isna().sum()) == (pytest.approx(3.2), 1)
    assert (runs["error"].iloc[-1], runs["seed"].dtype) == (FAILURE, "int64")
    assert runs["decision_s_first"].dtype == "float64"


def test_axis_values_of_several_kinds_are_texts(result: ExperimentResult, tmp_path: Path) -> None:
    for row, mixed in zip(result.rows, [1, "start", None] * 6, strict=True):
        row |= {"mixed": mixed, "huge": 2**64}  # which no column of whole numbers has
    write_parquet(result, tmp_path / "runs.parquet")
    runs = pandas.read_parquet(tmp_path / "runs.parquet")
    assert list(runs["mixed"].iloc[:2]) == ["1", "start"]
    assert set(runs["huge"]) == {"18446744073709551616"}


def test_the_summary_has_every_comparison(result: ExperimentResult) -> None:
    rows = list(csv.DictReader(summary_csv(result.comparison()).splitlines()))
    assert (tuple(rows[0]), len(rows)) == (SUMMARY_COLUMNS, 3 * 3 * 3)
    (one,) = [r for r in rows if (r["instances"], r["metric"], r["rule_set"]) == ("overall", "pile_on", "bad")]
    assert (one["seeds"], one["pairs"], one["left_out"], one["runs"], one["failed"]) == ("2", "4", "2", "6", "1")
    assert float(one["difference"]) == pytest.approx(2.0)
    assert (one["p"], one["relative_low_holm"], one["relative_p_holm"]) == ("", "", "")  # two seeds
    (one,) = [r for r in rows if (r["instances"], r["metric"], r["rule_set"]) == ("orders=50", "pile_on", "good")]
    assert (one["seeds"], one["pairs"], one["left_out"], one["runs"], one["failed"]) == ("3", "3", "0", "3", "0")
    assert float(one["relative_low_holm"]) < float(one["relative_low"]) < float(one["relative"])
    assert 0 < float(one["relative_p"]) <= float(one["relative_p_holm"]) < 0.05
    (base,) = [r for r in rows if (r["instances"], r["metric"], r["rule_set"]) == ("overall", "pile_on", "base")]
    assert (base["difference"], base["p"]) == ("", "")


def renamed(result: ExperimentResult, name: str) -> tuple[RuleSetChoice, ...]:
    for row in result.rows:
        row["rule_set"] = f"{name}{row['rule_set']}"
        row["instance"] = f"{name}{row['instance']}"
    return tuple(evolve(one, name=f"{name}{one.name}") for one in result.experiment.rule_sets)


@pytest.mark.parametrize("name", ["=cmd|' /C calc'!A0", "+1", "-1", "@sum(a)", "\t=x", " =x"])
def test_no_name_is_a_formula(result: ExperimentResult, tmp_path: Path, name: str) -> None:
    rule_sets = renamed(result, name)
    one = evolve(result, experiment=evolve(result.experiment, baseline=f"{name}base", rule_sets=rule_sets))
    rows = list(csv.DictReader(io.StringIO(summary_csv(one.comparison()), newline="")))
    assert rows[0]["instances"] == f"'{name}orders=50"
    assert {row["rule_set"] for row in rows} == {f"'{name}{end}" for end in ("base", "good", "bad")}
    assert rows[0]["baseline"] == f"'{name}base"
    assert float(rows[1]["difference"]) == pytest.approx(1.0)
    write_parquet(one, tmp_path / "runs.parquet")
    assert pandas.read_parquet(tmp_path / "runs.parquet")["rule_set"].iloc[0] == f"{name}base"


def plots_of(result: ExperimentResult, **changes: Any) -> list[Any]:
    changed = evolve(result, experiment=evolve(result.experiment, **changes))
    return make_plots(changed.rows, changed.comparison())


def test_a_plot_of_differences_and_one_for_each_metric(result: ExperimentResult) -> None:
    plots = plots_of(result)
    assert [plot.name for plot in plots] == ["differences", *result.experiment.metrics]
    assert [plot.title for plot in plots][:2] == ["Differences from base", "Pile-on"]
    assert all((plot.png, plot.pdf) == (b"", b"") and b"<svg" in plot.svg for plot in plots)
    plots = make_plots(result.rows, result.comparison(), 3.3)
    assert all(plot.png.startswith(b"\x89PNG") and b"<svg" in plot.svg for plot in plots)
    assert all(plot.pdf.startswith(b"%PDF") for plot in plots)


def test_many_rule_sets_have_no_plots_of_single_runs(result: ExperimentResult) -> None:
    rule_sets = tuple(RuleSetChoice(f"rules {number}") for number in range(MOST_RULE_SETS + 1))
    rows = [dict(result.rows[0], rule_set=one.name, seed=seed) for one in rule_sets for seed in (1, 2)]
    rows[-1] = dict(rows[-1], pile_on=100.0)
    changed = evolve(result, rows=rows)
    fronts = (("pile_on", "picker_utilisation"),)
    differences, front = plots_of(changed, rule_sets=rule_sets, baseline="rules 0", fronts=fronts)
    assert (differences.name, front.name) == ("differences", "front.pile_on.picker_utilisation")
    named = re.findall(r">\d+ (rules \d+)</text>", front.svg.decode())
    assert named == ["rules 0", f"rules {MOST_RULE_SETS}"]  # the baseline, and the only one on the front


NAMES = (
    "$\\frac{1$",
    "_hidden",
    "a\nb",
    "a\x00\x1bb",
    "\ud800",
    "{x} %s \\alpha",
    "\N{DEVANAGARI DIGIT ONE}",
    "n" * 300,
)


@pytest.mark.parametrize("name", NAMES)
def test_names_may_have_any_sign(result: ExperimentResult, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    rule_sets = renamed(result, name)
    plots = plots_of(result, rule_sets=rule_sets, baseline=f"{name}base", metrics=("pile_on",))
    assert [plot.name for plot in plots] == ["differences", "pile_on"]
    assert [ElementTree.fromstring(plot.svg).tag for plot in plots] == ["{http://www.w3.org/2000/svg}svg"] * 2
    assert capsys.readouterr().err == ""


def test_a_plot_that_fails_costs_that_plot_only(capsys: pytest.CaptureFixture[str]) -> None:
    def draw() -> Figure:
        raise ValueError("no\nidea")

    assert plot_of("mine", "My plot", draw) is None
    assert capsys.readouterr().err == "Left out: the plot mine cannot be drawn: ValueError: no idea\n"
    drawn = plot_of("mine", "My plot", Figure)
    assert drawn is not None
    assert drawn.title == "My plot"


def printed(result: ExperimentResult, width: int) -> str:
    console = Console(width=width, record=True, quiet=False, file=None, force_terminal=False)
    with console.capture() as capture:
        print_comparison(console, result, result.comparison())
    return capture.get()


def test_the_terminal_shows_runs_and_comparisons(result: ExperimentResult) -> None:
    text = printed(result, 120)
    assert f"Failed: orders=100, bad, seed 3: {FAILURE}" in text
    assert re.search(r"good +3 +3\.200 +\+1\.000 \(no interval\) +- +\+45\.5 % *\n", text)
    assert re.search(r"bad +2 \(1 left out\) +4\.150 ", text)
    assert "Picker utilisation (%)" in text
    assert re.search(r"overall *\n.*\n.*\n +bad +2 \(2 left out\) +4\.150 ", text)
    assert max(map(len, text.splitlines())) <= 120


def test_two_seeds_have_no_intervals(result: ExperimentResult) -> None:
    result.rows[:] = [row for row in result.rows if row["seed"] < 3]
    for width in (80, 120):
        text = printed(result, width)
        assert re.search(r"good +2 +3\.150 +\+1\.000 +\+46\.5 % *\n", text.replace("\u2212", "-"))
        assert "p (Holm)" not in text
        assert NO_TEST in " ".join(text.split())
    page = page_of(result)
    assert "(no interval)</td><td>-</td>" in page
    assert not re.search(r"\[[^<]*\]</td>|<td>(&lt; )?0\.\d+</td>\s*<td>[+\u2212]", page)
    assert NO_TEST in page


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
    page = page_of(result)
    assert "has the highest pile-on: 51.002; next is good with \u22124.000." in page
    assert "\u22124.000 (no interval), the other way round" in page
    for row in result.rows:
        if row["rule_set"] == "good" and row["status"] != "failed":
            row["pile_on"] += row["seed"] / 100
    assert re.search(r"\], p [<.0-9 ]+, the other way round", " ".join(printed(result, 80).split()))


def test_fronts_follow_the_metrics(with_front: ExperimentResult) -> None:
    text = printed(with_front, 80).partition("None beats these in both")[2]
    assert re.search(r"Rule set +Pile-on +Picker utilisation \(%\)", text)
    assert re.search(r"orders=50 *\n +bad +4\.200 +72\.00 *\n +orders=100 *\n +good", text)


def test_many_failures_are_cut_off_and_leave_no_empty_tables(result: ExperimentResult) -> None:
    for row in result.rows[:MOST_ERRORS]:
        row |= {"status": "failed", "error": "no idea"}
    text = printed(result, 100)
    assert text.count("Failed: ") == MOST_ERRORS
    assert "and 1 more failed run." in text
    failed = evolve(result, rows=[row | {"status": "failed", "error": "no idea"} for row in result.rows])
    text, page = printed(failed, 100), page_of(failed)
    assert "All runs failed: there is nothing to compare." in text
    assert "18 of 18 runs failed: there is nothing to compare." in page
    assert "Turn-over time" not in text + page.partition("<h2>What was run</h2>")[0]


def test_how_many_times_the_bound_is_shown(result: ExperimentResult) -> None:
    """As if less pile-on were better, and no rules could beat 1.25."""
    for row in result.rows:
        row["bound.pile_on"] = 1.25
    text = printed(result, 120)
    assert re.search(r"Rule set +Seeds +Mean +x bound +Difference ", text)
    assert text.count("x bound") == 1 + 1
    assert re.search(r"base +3 +2\.200 +1\.76 +baseline", text)
    assert re.search(r"good +3 +3\.200 +2\.56 +\+1\.000", text)
    assert "what no rules can beat" in text
    assert max(map(len, text.splitlines())) <= 120
    page = page_of(result)
    assert page.count("<th>Times the bound</th>") == 1
    assert '<td>2.200</td><td>1.250</td><td>1.76</td><td class="dim">baseline</td>' in re.sub(r"\n\s*", "", page)
    assert page.count('colspan="9"') == 3
    assert "what no rules can beat" in page
    for row in result.rows:
        del row["bound.pile_on"]
    assert "bound" not in page_of(result)


def page_of(result: ExperimentResult) -> str:
    plots = [Plot(name, name, b"<svg/>", b"", b"") for name in ("differences", *result.experiment.metrics)]
    return report_html(result, result.comparison(), plots)


def fact(result: ExperimentResult, name: str) -> str:
    """Return what the report says of the experiment under a name."""
    found = re.search(rf"<dt>{re.escape(name)}</dt><dd>(.*?)</dd>", page_of(result), re.DOTALL)
    assert found is not None, name
    return found[1].strip()


def test_the_report_needs_nothing_else(result: ExperimentResult) -> None:
    page = page_of(result)
    assert page.count('src="data:image/svg+xml;base64,') == 1 + 3
    assert not re.search(r'(src|href)="(?!data:|#)', page)
    assert not re.search(r"https?:", re.sub(r"base64,[A-Za-z0-9+/=]+", "", page))
    assert "Is &lt;more&gt; better?" in page
    assert "rule &lt;b&gt;bad&lt;/b&gt; &amp; worse: no idea" in page
    assert "2 (2 left out)" in page


def with_figures(result: ExperimentResult, **figures: list[float]) -> ExperimentResult:
    """Return complete runs of three rule sets whose means are these; seeds differ by 0.1 but in the baseline."""
    rows = []
    for place, row in enumerate(result.rows):
        rule_set, apart = place // 3 % 3, (row["seed"] - 2) / 10
        shown = {name: of[rule_set] + (apart if rule_set else 0) for name, of in figures.items()}
        rows.append(row | {"status": "complete", "error": None} | shown)
    return evolve(result, rows=rows, experiment=evolve(result.experiment, metrics=tuple(figures)))


@cases(
    "metric means way sentence",
    ("turnover_s", [20.0, 10.0, 30.0], "less", "good has the lowest turn-over time: 10.00 s, -50.0 % against base (p"),
    ("pile_on", [2.0, 1.0, 4.0], "more", "bad has the highest pile-on: 4.000, +100.0 % against base (p "),
    (
        "picker_utilisation",
        [2.0, 1.0, 4.0],
        "more",
        "bad has the highest picker utilisation: 400.00 %, +200.00 points ",
    ),
    ("makespan_s", [1.0, 2.0, 4.0], "less", "base, the baseline, has the lowest makespan: 1.00 s; next is good with"),
    (
        "makespan_s",
        [9.0, 9.0, 8.99],
        "less",
        "bad has the lowest makespan: 8.99 s, -0.1 % against base (p = 1.000); that",
    ),
    ("picks", [2.0, 1.0, 4.0], None, None),  # the same whatever the rules
    ("packer_utilisation_percent", [2.0, 1.0, 4.0], None, None),  # busy packers are neither better nor worse
    ("balance", [2.0, 1.0, 4.0], None, None),  # nobody knows which way is better
)
def test_the_page_begins_with_the_answer(result, metric, means, way, sentence) -> None:
    one = with_figures(result, **{metric: means})
    found = re.search(r'<p class="answer">(.*?)</p>', page_of(one))
    answer = unescape(found[1]).replace(MINUS, "-") if found else ""
    assert answer.startswith(sentence or "") and bool(answer) == bool(sentence), answer
    for plot in plots_of(one, metrics=(metric,)):  # an axis says the same
        assert {says for says in ("less", "more") if f"{says} is better" in plot.svg.decode()} == {way} - {None}


def test_the_table_of_ends_is_last_unless_runs_failed(result: ExperimentResult) -> None:
    ends = "<h2>How the runs ended</h2>"
    failed, complete = page_of(result), page_of(with_figures(result, pile_on=[1.0, 2.0, 3.0]))
    assert failed.index("1 of 18 runs failed.") < failed.index(ends) < failed.index('<h2 id="pile_on">')
    assert complete.index("<h2>How to read this</h2>") < complete.index(ends)
    assert "<h2" not in complete.partition(ends)[2]


def test_many_runs_make_a_small_page(result: ExperimentResult) -> None:
    rows = [row | {"seed": row["seed"] + 3 * i} for i in range(200) for row in result.rows[:9]]
    few, many = ({plot.name: plot.svg for plot in plots_of(evolve(result, rows=of))} for of in (rows[:90], rows))
    assert b"<image" not in few["pile_on"]
    assert b"<image" in many["pile_on"]
    assert len(many["pile_on"]) < 100_000
    sets = [row | {"instance": f"{row['instance']}-{i}"} for i in range(100) for row in result.rows]
    page = page_of(evolve(result, rows=sets))
    assert "Tables are of all 200 instance sets together; summary.csv has each of them." in page
    assert (page.count("<tr>"), page.count('<span class="bad">')) == (4 * (1 + 3), 100)


def test_orders_of_one_day_are_told_beside_every_p(result: ExperimentResult) -> None:
    told = "Orders come from a file and are the same for every seed"
    assert told not in page_of(result)
    assert page_of(evolve(result, fixed=frozenset({"orders=50", "orders=100"}))).count(told) == 3
    told = "come from a file and are the same for every seed"
    assert told not in " ".join(printed(result, 120).split())
    some = evolve(result, fixed=frozenset({"orders=50"}))
    assert f" Orders of orders=50 and overall {told}" in " ".join(printed(some, 120).split())
    day = evolve(result, fixed=frozenset({"orders=50", "orders=100"}))
    assert f" Orders {told}" in " ".join(printed(day, 120).split())
    day.rows[:] = [row for row in day.rows if row["seed"] < 3]
    assert told not in " ".join(printed(day, 120).split())


def captions(metrics: dict[str, tuple[list[float | None], list[float | None]]], status: str) -> dict[str, str]:
    """Return the captions of tables of the figures of a baseline and of another rule set."""
    rows = [
        {"instance": "i", "rule_set": name, "seed": seed, "status": status}
        | {metric: values[number][seed] for metric, values in metrics.items()}
        for number, name in enumerate(("base", "other"))
        for seed in range(len(next(iter(metrics.values()))[0]))
    ]
    names = list(metrics)
    compared = summary(rows, "base", names, fronts=[(names[0], names[-1])])
    return {name: grid.title for name, grid in grids(compared).items()}


def test_captions_say_what_a_table_has() -> None:
    close = [0.5, 9.0, 10.0, 11.0, 9.0, 10.0], [0.7, 11.0, 13.0, 12.0, 12.0, 12.0]
    found = captions({"makespan_s": ([None] * 6, [None] * 6), "picks": close}, "horizon")
    assert found["makespan_s"] == (
        "Makespan (s): means, and differences from base. No rule set has a mean: pairs of all seeds are left out."
    )
    assert found["picks"].startswith("Picks: means over 6 seeds, and differences from base with simultaneous 95 %")
    assert found["picks"].endswith(f"after Holm. {OF_MEAN_NOTE}")
    away = captions({"picks": ([10.0, 11.0, 12.0], [12.0, 12.0, 15.0])}, "complete")["picks"]
    assert away.endswith("after Holm.")


def test_fronts_are_tables_whose_caption_explains_the_mark(with_front: ExperimentResult) -> None:
    figures: list[float | None] = [1.0, 2.0, 3.0]
    metrics = {"turnover_s": (figures, figures), "picks": (figures, figures)}
    front = "front.turnover_s.picks"
    assert captions(metrics, "horizon")[front].endswith(CENSORED)
    assert CENSORED not in captions(metrics, "complete")[front]
    page = page_of(with_front)
    assert "<h2>Picker utilisation (%) against Pile-on</h2>" in page
    front = page.partition("None beats these in both")[2]
    assert "<td>bad</td><td>4.200</td><td>72.00</td>" in front  # more is better in both
    assert "<td>base</td>" not in front


def test_the_report_says_what_was_run(result: ExperimentResult) -> None:
    assert (fact(result, "Runs"), fact(result, "Scenarios")) == ("18", "small")
    assert fact(result, "instance.orders") == "50, 100"
    assert fact(result, "Rule sets") == "base, good, bad"
    assert fact(result, "Versions") == "rmfs 0.1.0"
    hashed = evolve(result, versions={"my_rule.py": "sha256:" + "0123456789ab" * 5})
    assert fact(hashed, "Versions") == "my_rule.py sha256:0123456789ab"


def test_the_same_runs_give_the_same_files(result: ExperimentResult, tmp_path: Path) -> None:
    for name in ("one", "two"):
        write_report(result, result.comparison(), tmp_path / name)
    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*.*"))
    assert len(files) == 4 + 3 * 5 + 3  # differences are two plots: one would be higher than a page
    for file in files:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes(), file
    names = {file.as_posix() for file in files}
    assert {"summary.csv", "runs.parquet", "report.html", "plots/differences.svg", "plots/pile_on.png"} <= names


LONG = "a rule set with a name that is as long as somebody wants it to be"
PAPER = r"""\documentclass%s{article}
\usepackage[utf8]{inputenc}
\usepackage{booktabs,graphicx}
\begin{document}
%s
\end{document}
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no pdflatex: Debian's texlive-latex-recommended")
@pytest.mark.parametrize(("options", "width_cm"), [("", 12.0), ("[a4paper,twocolumn]", ONE_COLUMN_CM)])
def test_tables_and_plots_fit_into_a_paper(with_front, tmp_path, options, width_cm) -> None:
    for row in with_front.rows:
        row["rule_set"] = LONG if row["rule_set"] == "good" else row["rule_set"]
        row["status"] = "horizon" if row["status"] == "complete" else row["status"]
        row |= {"turnover_s": 1e6 * row["seed"] ** 2 * len(row["rule_set"]), "open_age_sum_h": row["seed"] // 2}
        row["backlog_end"] = row["seed"]
    rule_sets = tuple(evolve(one, name=LONG) if one.name == "good" else one for one in with_front.experiment.rule_sets)
    metrics = (*with_front.experiment.metrics, "turnover_s")
    one = evolve(with_front, experiment=evolve(with_front.experiment, rule_sets=rule_sets, metrics=metrics))
    write_report(one, one.comparison(), tmp_path, width_cm)
    tables = sorted(path.name for path in (tmp_path / "tables").iterdir())
    plots = sorted(path.name for path in (tmp_path / "plots").glob("*.pdf"))
    assert len(tables) == 7
    assert {"differences.pdf", "differences-2.pdf"} < {*plots}  # one would be higher than a page
    parts = [rf"\input{{tables/{name}}}\clearpage" for name in tables]
    parts += [rf"\noindent\includegraphics{{{{plots/{name[:-4]}}}.pdf}}\clearpage" for name in plots]
    parts += [rf"\ref{{tab:{name[:-4]}}}" for name in tables]
    (tmp_path / "paper.tex").write_text(PAPER % (options, "\n".join(parts)), encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "paper.tex"]
    for _ in range(2):  # the second time with the numbers of the labels
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, errors="replace")
        assert done.returncode == 0, done.stdout
    wide = [line for line in done.stdout.splitlines() if "Overfull" in line or "undefined" in line]
    assert wide == []


def test_an_observers_metric_is_called_what_it_likes(result, tmp_path, capsys) -> None:
    label = "Price [s] [/nope] in $^$"
    rows = [row | {"differences": row["seed"] * 1.5} for row in result.rows]
    experiment = evolve(result.experiment, metrics=("differences", "pile_on"))
    measures = {"differences": Metric("differences", label)}
    one = evolve(result, rows=rows, experiment=experiment, measures=measures)
    comparison = one.comparison()
    write_report(one, comparison, tmp_path)
    print_comparison(Console(width=120, markup=False), one, comparison)  # as `output_console` has it
    assert label in capsys.readouterr().out
    plots = {path.name for path in (tmp_path / "plots").glob("*.svg")}
    assert plots == {"differences.svg", "metrics.differences.svg", "pile_on.svg"}
    assert len(set(re.findall(r'<img src="([^"]+)"', (tmp_path / "report.html").read_text("utf-8")))) == 3


def runs(folder: Path, *overrides: str) -> list[str]:
    found = [str(folder / "one"), str(folder / "other")]
    for out, more in zip(found, ((), overrides), strict=True):
        rmfs_core.run(load_scenario("examples/small", ["instance.orders=3", *more]), out=out)
    return found


def test_metrics_and_what_differs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folders = runs(tmp_path, "rules.pps=completes", "robots.count=2")
    assert exit_code("compare", *folders, "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["names"] == folders
    assert found["differs"] == {"rules.pps": ["demand", "completes"], "robots.count": [4, 2]}
    read = [json.loads((Path(out) / "result.json").read_text(encoding="utf-8"))["metrics"] for out in folders]
    assert found["metrics"]["turnover_s"] == [one["turnover_s"] for one in read]
    assert exit_code("compare", *folders) == 0
    shown = capsys.readouterr().out
    assert "Both runs have the same orders, pods and stations." in shown
    assert 'rules.pps: "demand" and "completes"' in shown
    file = Path(folders[0], "result.json")
    file.write_text(json.dumps(json.loads(file.read_text(encoding="utf-8")) | {"summary": {"floor": {}}}))
    assert exit_code("compare", *folders) == 0
    assert f"{folders[0]}: orders are those of a real day" in " ".join(capsys.readouterr().out.split())


def test_what_the_summary_of_a_run_shows_is_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    over = ["instance.orders=3", "instance.due.allowance_s=60", "costs.picker_per_h=1", "packing.stations=1"]
    rmfs_core.run(load_scenario("examples/small", over), out=tmp_path / "one")
    assert exit_code("compare", *[str(tmp_path / "one")] * 2) == 0
    shown = capsys.readouterr().out
    for label in ("Turn-over time (s)", "Late orders", "Time to packed (s)", "Cost per order", "  pickers"):
        assert f" {label} " in shown
    assert "Energy" not in shown


def test_another_seed_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("compare", *runs(tmp_path, "seed=9")) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert "may have other orders, pods or stations, because they differ in seed." in told


def test_of_files_only_the_names_are_known(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folders = runs(tmp_path, "robots.count=2")
    for folder, start in zip(folders, ("2024-03-01", "2024-03-01T00:00:00"), strict=True):
        file = Path(folder) / "result.json"
        told = json.loads(file.read_text(encoding="utf-8"))
        told["scenario"]["instance"] |= {"orders_file": "o.csv", "arrivals": {"profile": "day.csv"}, "start": start}
        file.write_text(json.dumps(told), encoding="utf-8")
    assert exit_code("compare", *folders) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "same files in instance.arrivals.profile, instance.orders_file; their contents are not compared." in shown
    assert "instance.start" not in shown
    told["scenario"]["instance"]["state_file"], told["scenario"]["run"]["warmup_s"] = "s.json", 60
    file.write_text(json.dumps(told), encoding="utf-8")
    assert exit_code("compare", *folders, "--json") == 0  # the state's time is no warm-up that was asked for
    assert {*json.loads(capsys.readouterr().out)["differs"]} == {"robots.count", "instance.state_file"}
    assert "the same orders" not in shown


def test_wrong_calls_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = runs(tmp_path)[0]
    assert "there is no result.json" in refused(capsys, main, ["compare", one, str(tmp_path)])
    for more in (["--quick"], ["--width", "7.7"], ["--no-inline-rules"]):
        assert "no options but --json and --quiet" in refused(capsys, main, ["compare", one, one, *more])
    (tmp_path / "result.json").write_text('{"metrics": {}, "seed": 1, "status": "complete", "versions": {}}')
    told = refused(capsys, main, ["compare", one, str(tmp_path)])
    assert "expected `scenario`, `seed`, `status` and `versions`" in told
    assert "expected an experiment, a file or one of" in refused(capsys, main, ["compare", one, one, one])


@pytest.fixture
def result() -> ExperimentResult:
    """Return an experiment of two instances, three rule sets and three seeds, with made-up figures; one run failed."""
    experiment = Experiment(
        name="trial",
        description="Is <more> better?",
        bases=(Base("small", load_scenario("examples/small")),),
        axes=(Axis("instance.orders", tuple(AxisPoint(f"orders={n}", n, {"instance.orders": n}) for n in (50, 100))),),
        rule_sets=tuple(RuleSetChoice(name) for name in ("base", "good", "bad")),
        seeds=(1, 2, 3),
        baseline="base",
        metrics=("pile_on", "picker_utilisation", "split_orders_open_max"),
    )
    rows: list[dict[str, Any]] = []
    for orders in (50, 100):
        for place, rule_set in enumerate(("base", "good", "bad")):
            for seed in (1, 2, 3):
                figures = {
                    "pile_on": 2.0 + place + seed / 10,
                    "picker_utilisation": 0.5 + place / 10 + seed / 100,
                    "split_orders_open_max": place * seed,
                    "decision_s_first": None,
                }
                named = {"instance": f"orders={orders}", "scenario": "small", "instance.orders": orders}
                named |= {"rule_set": rule_set, "seed": seed, "status": "complete", "error": None, "error_kind": None}
                rows.append(named | figures | {"key": f"{orders}{place}{seed}"})
    failed = {"status": "failed", "error": FAILURE, "error_kind": "RuleError"}
    rows[-1] = {name: rows[-1][name] for name in ("instance", "instance.orders", "rule_set", "seed", "key")} | failed
    return ExperimentResult(experiment, rows, {"rmfs": "0.1.0"}, 18)


@pytest.fixture
def with_front(result: ExperimentResult) -> ExperimentResult:
    """Return the same with a front of two metrics."""
    return evolve(result, experiment=evolve(result.experiment, fronts=(("pile_on", "picker_utilisation"),)))
