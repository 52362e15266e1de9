"""Output of commands: tables, progress, metrics and notes."""

import csv
import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st
from rich import box
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

import rmfs_core
from cases import cases
from rmfs_commands.cli.grids import Grid, file_name, grid_csv
from rmfs_commands.cli.latex import COLUMN_PT, TEXT_PT, latex_text, to_latex, width_pt, write_grid
from rmfs_commands.cli.main import main
from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.progress import (
    RISING,
    RISING_ASCII,
    RunCounts,
    RunLines,
    RunPanel,
    Throughput,
    about,
    robots_by_state,
    run_display,
    waits_for,
)
from rmfs_commands.cli.screen import new_table, output_console, print_named, say
from rmfs_commands.cli.summary import PROFILE, gaps_of, print_profile, print_summary
from rmfs_commands.cli.trimming import WithoutTrailingBlanks
from rmfs_commands.cli.visible import VisibleSigns
from rmfs_commands.cli.waiting import StockWaits
from rmfs_commands.details.catalogue import METRICS
from rmfs_core import hookimpl
from rmfs_core.events import (
    BundleAssigned,
    BundleStored,
    Event,
    ItemPicked,
    OrderCompleted,
    OrderInStock,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.results import Result
from rmfs_core.results.catalogue import Metric
from rmfs_core.results.running import run

NAMES = ("short", "a-rule-with-a-very-long-name-of-someone-else", '{ rule = "split-among-stations", max_seconds = 10 }')
FIGURES = 6


def printed(width: int, *, boxed: bool) -> list[str]:
    table = Table(box=box.SIMPLE_HEAD if boxed else None, title="Runs")
    table.add_column("Rule")
    for number in range(FIGURES):
        table.add_column(f"figure\n{number}", justify="right")
    for name in NAMES:
        table.add_row(name, *(f"{1000.25 + number}" for number in range(FIGURES)))
    stream = io.StringIO()
    print_named(Console(file=stream, width=width), table)
    return stream.getvalue().splitlines()


@pytest.mark.parametrize("boxed", [True, False])
@pytest.mark.parametrize("width", [80, 140])
def test_names_and_figures_are_whole(width: int, boxed: bool) -> None:
    lines = printed(width, boxed=boxed)
    assert max(map(len, lines)) <= width
    assert not any("…" in line for line in lines)
    for name in NAMES:
        (at,) = [number for number, line in enumerate(lines) if name in line]
        row = lines[at] if width == 140 else lines[at + 1]
        assert row.split()[-FIGURES:] == [f"{1000.25 + number}" for number in range(FIGURES)]
        assert width == 140 or lines[at] == name
    assert width == 140 or "Rule" in lines[:3]  # what the names are stands above them


def test_a_pipe_is_80_columns_wide(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("os.get_terminal_size", lambda _=0: os.terminal_size((140, 40)))
    monkeypatch.delenv("COLUMNS", raising=False)
    table = new_table("Words")
    table.add_column("Name")
    table.add_column("What")
    table.add_row("a-name", 40 * "word ")
    output_console().print(table)
    assert 60 < max(map(len, lines := capsys.readouterr().out.splitlines())) <= 80
    assert [line for line in lines if line != line.rstrip()] == []
    assert lines[0] == "Words"
    monkeypatch.setenv("COLUMNS", "120")
    output_console().print(table)
    assert 100 < max(map(len, capsys.readouterr().out.splitlines())) <= 120


HIDE_CURSOR, SHOW_CURSOR, ERASE_LINE = "\x1b[?25l", "\x1b[?25h", "\x1b[1A\x1b[2K"

EVENTS = (
    VisitStarted(1000, 1, robot=0, pod=0, station=1),
    ItemPicked(8000, 1000, 14_000, visit=1, station=1, pod=0, order=0, sku=0),
    ItemPicked(21_000, 14_000, 27_000, visit=1, station=1, pod=0, order=0, sku=1),
    OrderCompleted(21_000, 0),
)


def test_plain_lines_fit_80_columns(tiny: RunInfo) -> None:
    stream = io.StringIO()
    progress = run_display(Console(file=stream), "paper-2000-split-among-stations")
    assert isinstance(progress, RunLines)
    progress.run_started(evolve(tiny, instance=evolve(tiny.instance, orders=tiny.instance.orders * 5000)))
    progress.counts = RunCounts(total=10_000, orders=8999, picks=99_998, visits=99_999, picks_at=[0, 0])
    progress.counts.stopped_early = 1000
    for event in EVENTS[1:2] + EVENTS[3:]:
        progress.on_event(evolve(event, tick=359_999_000))
    progress.run_ended(359_999_000, "complete")
    lines = stream.getvalue().splitlines()
    assert lines == [
        "paper-2000-split-among-stations: 10,000 orders, 2 SKUs, 2 pods, 2 stations, 2",
        "  robots, seed 7",
        " 90 %  99:59:59 simulated, 99,999 picks, 11.11 visits per order, pile-on 1.00",
        "complete: 9,000 of 10,000 orders, 99:59:59 simulated, 1,000 solves stopped early",
    ]
    assert max(map(len, lines)) <= 80


@pytest.mark.parametrize("width", [80, 120])
def test_the_live_display_fits_the_terminal(tiny: RunInfo, width: int) -> None:
    stream = io.StringIO()
    progress = run_display(Console(file=stream, force_terminal=True, width=width, height=30), "small")
    assert isinstance(progress, RunPanel)
    progress.run_started(tiny)
    for event in EVENTS:
        progress.on_event(event)
    picture = io.StringIO()
    Console(file=picture, width=width).print(progress.picture())
    progress.run_ended()
    shown = picture.getvalue()
    for text in (
        "1 of 2 (50%)",
        "0:00:21",
        "0 fetch, 0 carry, 0 in line, 2 idle",
        "Pile-on",
        "2.00",
        "Ends in about",
        "0/4",
        "Inbound",
    ):
        assert text in shown
    assert "…" not in shown
    assert max(map(len, shown.splitlines())) <= width


def test_the_live_display_can_be_closed_twice(tiny: RunInfo) -> None:
    stream = io.StringIO()
    progress = RunPanel("small", Console(file=stream, force_terminal=True, width=80, height=30))
    progress.run_started(tiny)
    assert (stream.getvalue().count(HIDE_CURSOR), stream.getvalue().count(SHOW_CURSOR)) == (1, 0)
    progress.close()
    given_back = stream.getvalue()
    assert given_back.count(SHOW_CURSOR) == 1
    assert given_back.endswith(ERASE_LINE)
    progress.close()
    assert stream.getvalue() == given_back


def test_the_throughput_of_two_minutes_and_an_idle_third() -> None:
    """As high as the most picks of a slot; the figure is that of the last whole slot, or of what there is."""
    throughput = Throughput()
    throughput.add(1000)
    assert (throughput.an_hour(30_000), throughput.line(30_000, 10, RISING)) == (120, "")
    throughput.add(61_000)
    throughput.add(62_000)
    assert (throughput.line(185_000, 10, RISING), throughput.an_hour(185_000)) == ("▄█ ", 0)
    assert (throughput.line(125_000, 10, RISING_ASCII), throughput.an_hour(125_000)) == ("=@", 120)


class Watching:
    """Observer that keeps what a terminal would show, what robots were seen doing, and what stations waited for."""

    def __init__(self) -> None:
        self.panel = RunPanel("day", Console(file=io.StringIO(), force_terminal=True, width=110, height=40))
        self.robots: set[str] = set()
        self.waits: set[str] = set()
        self.shown: set[str] = set()

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        self.run = run
        self.panel.run_started(run)

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.panel.on_event(event)
        states = robots_by_state(self.run, self.panel.counts.moving)
        assert sum(states.values()) == len(self.run.warehouse.robots)
        assert min(states.values()) >= 0
        self.robots |= {state for state, number in states.items() if number}
        self.waits |= {re.sub(r" \d+,?", "", waits_for(self.run, one)) for one in self.run.warehouse.stations}
        if isinstance(event, BundleStored | BundleAssigned | VisitEnded):
            picture = io.StringIO()
            Console(file=picture, width=110).print(self.panel.picture())
            self.shown |= {" ".join(line.strip("│ \n").split()) for line in picture.getvalue().splitlines()}

    @hookimpl
    def run_ended(self) -> None:
        self.panel.run_ended()


CHARGING = (
    "layout.chargers=1",
    "robots.battery={capacity_wh=70, idle_w=200, charging_w=8000}",
    "rules.idle=charge-when-low",
)


def test_what_stations_wait_for() -> None:
    seen = Watching()
    run("examples/small", overrides=["instance.orders=15", "robots.count=1"], observers=[seen])
    assert seen.waits == {"orders", "a pod", "a robot for pod", "pod being fetched", "pod carried", "pod in line"}


def test_what_robots_and_stations_do_is_shown() -> None:
    hours = ("robots.available=[['00:00', '23:00', 3]]", "stations.open={2=[['00:03', '23:00']]}")
    seen = Watching()
    settings = ("instance.orders=40", "rules.pp=free-flow", "rules.move=utility", *CHARGING, *hours)
    run("examples/small", overrides=settings, observers=[seen])
    assert seen.robots >= {"fetch", "carry", "in line", "move pods", "go to rest", "charge", "off duty"}
    assert any(line.startswith("2 ") and line.endswith(" closed") for line in seen.shown)
    assert any(line.startswith("Robots ") and ", 1 off duty, " in line for line in seen.shown)
    seen = Watching()
    run("examples/replenished", overrides=["rules.pp=free-flow", "instance.orders=60"], observers=[seen])
    assert any(line.startswith("3 ") and "1/10" in line for line in seen.shown)
    assert any(line.startswith("3 ") and line.endswith(" bundles") for line in seen.shown)
    assert any(" Bundles 0 wait, 4 stored" in f" {line}" for line in seen.shown)
    assert "2 stations, 1 replenishment station, 6 robots" in about(seen.run)
    seen = Watching()
    run("examples/packing", overrides=["rules.pp=free-flow", "instance.orders=20"], observers=[seen])
    assert "Packing 6 totes on conveyors, 8 waiting, 2 of 2 packers at work" in seen.shown
    assert "Packed 7 orders" in seen.shown
    assert any(line.endswith("Boxes in use 10 of 20") for line in seen.shown)
    seen, often = Watching(), "{mtbf_h=0.02, mttr_s=60}"
    charging = (*CHARGING, f"robots.battery.charger_outages={often}", "robots.battery.capacity_wh=90")
    settings = ("instance.orders=40", "rules.pp=free-flow", *charging, f"stations.outages={often}")
    run("examples/small", overrides=settings, observers=[seen])
    assert "Chargers 1 in service, 0 out of service" in seen.shown
    assert any(line.startswith("Chargers 0 in service, 1 out of service: row ") for line in seen.shown)
    assert any(line.endswith(" its repair") for line in seen.shown)


@pytest.fixture(scope="module")
def result() -> Result:
    return rmfs_core.run("examples/small", overrides=["instance.orders=5", "rules.pp=free-flow"])


def summary(result: Result, width: int = 100) -> str:
    console = Console(width=width, force_terminal=False)
    with console.capture() as capture:
        print_summary(console, "small", result)
    return capture.get()


@pytest.mark.parametrize("width", [60, 80, 100, 200])
def test_every_metric_has_its_place(result: Result, width: int) -> None:
    text = summary(result, width)
    for group in METRICS.values():
        for metric in group:
            assert (metric.label.strip() in text) == (metric.name != "simulated_s"), metric.name
    assert max(map(len, text.splitlines())) <= width
    assert "small, seed 1: complete" in text


def test_a_summary_shows_what_there_is(result: Result, capsys: pytest.CaptureFixture[str]) -> None:
    assert not re.search(r"Orders completed .* Picks ", summary(result, 60))
    assert any("Orders" in line and "Pods" in line for line in summary(result, 100).splitlines())
    left = evolve(result, status="partial", metrics={**result.metrics, "makespan_s": None, "simulated_s": 99.5})
    text = summary(left)
    assert "Makespan" not in text
    assert re.search(r"Simulated time +99\.5 +s", text)
    assert "seed 1: partial" in text
    described = {"balance": Metric("balance", "Balance of work", "kJ", 1, "What it costs.")}
    own = evolve(result, metrics={**result.metrics, "balance": 2.25, "bare": 3}, described=described)
    text = summary(own)
    assert "Observers" in text
    assert re.search(r"Balance of work +2\.2 +kJ", text)
    assert re.search(r"bare +3", text)
    assert "Observers" not in summary(result)
    marked = {"waits": Metric("waits", "Waits [s] [/nope]", "[red]", 0)}
    own = evolve(result, metrics={**result.metrics, "waits": 3}, described=marked)
    print_summary(Console(width=100), "small", own)
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "Waits" in line]
    assert "Waits [s] [/nope]" in line
    assert "[red]" in line


def test_the_profile_says_where_the_time_went(result: Result) -> None:
    seconds = dict.fromkeys(PROFILE, 0.0) | {"queries": 3.0, "rules": 1.0}
    timing = {**result.timing, "profile_s": seconds, "hook_s": {"plan_path": 0.5, "assign_orders": 2.0}}
    console = Console(width=100, force_terminal=False)
    with console.capture() as capture:
        print_profile(console, evolve(result, timing=timing))
    text = capture.get()
    assert re.search(r"Path queries +3\.000 +75\.0", text)
    assert all(label in text for label in PROFILE.values())
    assert text.index("in assign_orders") < text.index("in plan_path")


def row(status: str, objective: float | None, bound: float | None) -> dict[str, object]:
    return {"status": status, "objective": objective, "bound": bound, "stopped_early": status in ("effort", "stopped")}


@cases(
    "rows gaps",
    (
        [row("optimal", 4, 4), row("effort", 10, 9), row("stopped", 8, 6), row("effort", 5, None)],
        {"ended_at_effort": 2, "largest_gap": pytest.approx(25)},
    ),
    ([row("optimal", 4, 4), row("decided", None, None)], {}),
    ([row("stopped", 4, None)], {"ended_at_effort": 0}),
)
def test_gaps_of_a_run(rows: list[dict[str, object]], gaps: dict[str, object]) -> None:
    assert gaps_of(rows) == gaps


def test_orders_that_waited_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    waits = StockWaits()
    assert waits.sentence == ""
    waits.on_event(OrderInStock(tick=5, order=2))
    assert waits.sentence == "1 order waited for stock (stock_s in delays.csv)."
    waits.on_event(OrderInStock(tick=5, order=3))
    assert waits.sentence == "2 orders waited for stock (stock_s in delays.csv)."
    scarce = ("--set", "instance.replenishment.reorder_point=1", "--set", "instance.replenishment.order_up_to=6")
    main(["run", "examples/replenished", *scarce, "--out", str(tmp_path)])
    with (tmp_path / "delays.csv").open(encoding="utf-8", newline="") as file:
        waited = sum(float(row["stock_s"] or 0) > 0 for row in csv.DictReader(file))
    assert waited > 1
    assert f"\n{waited} orders waited for stock (stock_s in delays.csv).\n" in capsys.readouterr().out
    main(["run", "examples/small", "--out", str(tmp_path / "small")])
    assert "waited for stock" not in capsys.readouterr().out


def trimmed_text(what: RenderableType, *, end: str = "\n", styled: bool = False) -> str:
    stream = io.StringIO()
    console = Console(file=stream, width=20, force_terminal=styled, color_system="standard" if styled else None)
    console.push_render_hook(WithoutTrailingBlanks())
    console.print(what, end=end)
    return stream.getvalue()


def test_lines_and_styles_stay() -> None:
    assert trimmed_text(Text("asks: "), end="") == "asks:"
    words = Text.assemble(("red ", "red"), ("bold ", "bold"), ("   ", "underline"))
    assert trimmed_text(words, styled=True) == "\x1b[31mred \x1b[0m\x1b[1mbold\x1b[0m\n"
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, color_system="standard")
    console.push_render_hook(VisibleSigns())
    console.print(Text("a\x1bb", style="red"))
    assert stream.getvalue() == "\x1b[31ma\\x1bb\x1b[0m\n"


EVIL = "\x1b[31mred\x1b]0;title\x07\u202egnp\x9b2J"
SHOWN = r"\x1b[31mred\x1b]0;title" + r"\x07\u202egnp\x9b2J"


def test_no_name_steers_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    table = new_table()
    table.add_column("Order")
    table.add_row(Text(EVIL.replace("\x07", "")))
    console = output_console()
    console.print(table)
    say(console, f"one\n{EVIL.replace(chr(7), '')}")
    say(notes_console(), EVIL.replace("\x07", ""))
    printed = capsys.readouterr()
    shown = SHOWN.replace(r"\x07", "")
    assert printed.out.count(shown) == 2
    assert f"one\n{shown}\n" in printed.out
    assert printed.err.rstrip("\n").replace("\n", "") == shown
    for sign in "\x1b\x07\u202e\x9b":
        assert sign not in printed.out + printed.err


@pytest.mark.parametrize("ends", ["2>/dev/full", "2>&-", "2>&1 >/dev/null | true"])
def test_a_run_goes_on_when_nobody_reads_what_it_says(ends: str, tmp_path: Path) -> None:
    program = f"{sys.executable} -c 'from rmfs_commands.cli.main import main; main()'"
    call = f"set -o pipefail; {program} run examples/small --set instance.orders=20 --out out {ends}"
    subprocess.run(["bash", "-c", call], cwd=tmp_path, check=True, capture_output=True)
    result = json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))
    assert (result["status"], result["metrics"]["orders_completed"]) == ("complete", 20)


GRID = Grid(
    "Visits & more",
    ("50 % of them.",),
    ("Rule set", "Mean"),
    [("pod-match_2", "0.90 ± 0.1"), ("[x]", "−1")],  # noqa: RUF001
    right=(1,),
)
COMMANDS = re.compile(r"\\text\w+\{\}|\{\\char34\}|\\[&%$#_]|\$(?:\\pm|\\times|-)\$")
"""Signs of LaTeX in a text: signs by name, signs that are written with a backslash, and three in formulas."""


def test_latex() -> None:
    assert to_latex(GRID, "a b") == "\n".join(
        [
            r"\begin{table}",
            r"  \centering",
            r"  \caption{Visits \& more}",
            r"  \label{tab:a-b}",
            r"  \footnotesize",
            r"  \setlength{\tabcolsep}{3pt}",
            r"  \begin{tabular}{@{}lr@{}}",
            r"    \toprule",
            r"    Rule set & Mean \\",
            r"    \midrule",
            r"    pod-match\_2 & 0.90 $\pm$ 0.1 \\",
            r"    {[x]} & $-$1 \\",
            r"    \bottomrule",
            r"  \end{tabular}",
            r"  % 50 % of them.",
            r"\end{table}",
            "",
        ]
    )


@cases(
    "names figures kind parts broken",
    (["first-come"], 3, "table", 1, False),
    (["first-come"], 6, "table*", 1, False),
    (["a rule set with a name that is as long as somebody wants it to be"], 6, "table*", 1, True),
    (["first-come"], 12, "table*", 2, False),
)
def test_a_table_fits_into_a_column_or_into_the_text(names, figures, kind, parts, broken) -> None:
    figure = "1,234.56"
    grid = Grid("", (), ("Rule set", *["Mean"] * figures), [(*names, *[figure] * figures)], range(1, figures + 1))
    text = to_latex(grid, "a")
    assert text.startswith(rf"\begin{{{kind}}}")
    assert text.count("toprule") == text.count("Rule set") == parts
    assert (r"\begin{tabular}[t]" in text) == broken
    whole = width_pt(names[0]) + figures * (width_pt(figure) + 6)
    assert (whole <= COLUMN_PT, whole <= TEXT_PT) == (kind == "table", parts == 1 and not broken)


@given(st.text())
def test_no_text_is_a_command(text: str) -> None:
    assert not set(COMMANDS.sub("", latex_text(text))) & set("\\{}&%$#_^\n")


def test_files_of_grids(tmp_path: Path) -> None:
    grid = Grid("", (), ("Rule\nset", "p", "p"), [("=1+1", "+3 %", "-")], right=(1, 2))
    assert list(csv.reader(io.StringIO(grid_csv(grid)))) == [["Rule set", "p", "p"], ["'=1+1", "+3 %", "-"]]
    for name, content in (("a.tex", to_latex(GRID, "a")), ("a.csv", grid_csv(GRID))):
        write_grid(GRID, tmp_path / name)
        assert (tmp_path / name).read_text(encoding="utf-8") == content
    assert file_name("Tables 1 and 2, Figure 9: instances (all)") == "tables-1-and-2"
    assert file_name("Section 4.2: picks") == "section-4-2"
