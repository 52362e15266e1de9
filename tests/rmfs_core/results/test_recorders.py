"""Recorders, rows of tables, and how metrics are shown."""

import math
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

import rmfs_core
from calling import refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.instances.tables import ORDER_COLUMNS, PERIOD_COLUMNS, VISIT_COLUMNS, Tables
from rmfs_commands.results.figures import TIMING, by_heading, show
from rmfs_core import InputError
from rmfs_core.errors import RunError
from rmfs_core.events import DecisionMade, ItemPicked, OrderAssigned, OrderCompleted, VisitEnded, VisitStarted
from rmfs_core.info import RunInfo
from rmfs_core.results.catalogue import Metric, described_by
from rmfs_core.results.recorders import load_recorder
from rmfs_core.roles import Role
from saying import said

Install = Callable[..., None]

RECORDER = """
@define
class Recorder:
    file = "acme.txt"
    @hookimpl
    def run_started(self, run):
        (run.out / self.file).write_text("recorded")
"""


def writing(file: object) -> str:
    return RECORDER.replace('"acme.txt"', repr(file))


def test_a_third_partys_recorder_is_switched_on_by_its_name(install: Install, tmp_path: Path) -> None:
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=RECORDER)
    rmfs_core.run("examples/small", out=tmp_path, record=["acme-log"])
    assert (tmp_path / "acme.txt").read_text(encoding="utf-8") == "recorded"
    rmfs_core.run("examples/small", out=tmp_path)
    assert not (tmp_path / "acme.txt").exists()


def test_only_recorders_that_are_switched_on_are_imported(install: Install, tmp_path: Path) -> None:
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=RECORDER)
    for _ in range(2):
        rmfs_core.run("examples/small", out=tmp_path, record=["trace"])
    assert "acme_log" not in sys.modules
    (tmp_path / "notes.txt").touch()
    rmfs_core.run("examples/small", out=tmp_path, record=["trace"])
    assert "acme_log" in sys.modules
    assert (tmp_path / "notes.txt").exists()


@cases(
    "source problem",
    ("import acme_missing", "cannot be imported from acme_log:Recorder: ModuleNotFoundError"),
    ("raise SystemExit(1)", "cannot be imported from acme_log:Recorder: SystemExit: 1"),
    ("Recorder = 3", "is no recorder: expected a class with the name of its file as `file`"),
    ("class Recorder:\n    pass", "is no recorder: expected a class"),
    ("class Recorder:\n    file = '../up.txt'", "is no recorder: expected a class"),
    ("class Recorder:\n    file = 'result.json'", "is no recorder: expected a class"),
    (
        "class Recorder:\n    file = 'a.txt'\n    def __init__(self, path): pass",
        "cannot be made: TypeError: Recorder.__init__() missing 1 required positional argument: 'path'",
    ),
    ("class Recorder:\n    file = 'a.txt'", "observer Recorder: it implements no observer hook"),
)
def test_a_broken_recorder_costs_one_sentence(source, problem, install, tmp_path, capsys) -> None:
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=source)
    command = ["run", "examples/small", "--quiet", "--out", str(tmp_path / "out"), "--record", "acme-log"]
    (line,) = refused(capsys, main, command).splitlines()
    assert problem in line
    assert not (tmp_path / "out").exists()
    assert rmfs_core.run("examples/small", out=tmp_path / "out", record=["trace"]).status == "complete"
    assert (tmp_path / "out" / "trace.jsonl.gz").exists()


def test_a_recorder_that_raises_is_named(install: Install, tmp_path: Path) -> None:
    source = RECORDER.replace('(run.out / self.file).write_text("recorded")', "return 1 / 0")
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=source)
    with pytest.raises(rmfs_core.RuleError, match=r'^recorder "acme-log" \(acme 1.0\), run_started, .* ZeroDivision'):
        rmfs_core.run("examples/small", out=tmp_path, record=["acme-log"])
    assert (tmp_path / "result.json").exists()


@cases(
    "file", "", ".", "..", "../up.txt", "/tmp.txt", "a/b.txt", "a/", ".hidden", "nul\0.txt", "a" * 300, "Orders.csv", 3
)
def test_a_recorder_names_one_plain_file(file: object, install: Install) -> None:
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=writing(file))
    with pytest.raises(InputError, match=r'recorder "acme-log" \(acme 1.0\) is no recorder: expected a class with'):
        load_recorder("acme-log")


def test_two_recorders_of_one_file_are_not_switched_on_together(install: Install, tmp_path: Path) -> None:
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=writing("trace.jsonl.gz"))
    expected = r'recorder "trace" \(rmfs .*\) and recorder "acme-log" \(acme 1.0\) write the same file, trace.jsonl'
    with pytest.raises(InputError, match=expected):
        rmfs_core.run("examples/small", out=tmp_path / "out", record=["trace", "acme-log"])
    assert not (tmp_path / "out").exists()


def test_a_file_that_no_run_has_written_is_left_alone(install: Install, tmp_path: Path) -> None:
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=writing("notes.txt"))
    mine = tmp_path / "out" / "notes.txt"
    mine.parent.mkdir()
    mine.write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"found a file notes\.txt that no run of rmfs has written"):
        rmfs_core.run("examples/small", out=mine.parent, record=["acme-log"])
    rmfs_core.run("examples/small", overrides=["instance.orders=2"], out=mine.parent)
    assert mine.read_text(encoding="utf-8") == "mine"
    rmfs_core.run("examples/small", overrides=["instance.orders=2"], out=mine.parent)
    assert not mine.exists()


WATCHER = """from rmfs_core import hookimpl
class Watcher:
    files = FILES
    @hookimpl
    def measured(self): return {"acme_one": 1}
"""


@cases(
    "source problem",
    ("import acme_missing", " cannot be imported from acme_watch:Watcher: ModuleNotFoundError"),
    ("class Watcher:\n    def __init__(self, path): pass", " cannot be made: TypeError"),
    (WATCHER.replace("FILES", "'a.csv'"), ": expected `files` to be a tuple of plain names, none that of a file of "),
    (WATCHER.replace("FILES", "('Result.json',)"), "results; found ('Result.json',)"),
    (WATCHER.replace("FILES", "('../a.csv',)"), "results; found ('../a.csv',)"),
)
def test_a_broken_observer_of_every_run_costs_a_sentence(source, problem, install, capsys) -> None:
    install("acme", {"acme-watch": "acme_watch:Watcher"}, group="rmfs.observers", acme_watch=source)
    result = rmfs_core.run("examples/small", overrides=["instance.orders=2"])
    assert result.status == "complete"
    assert "acme_one" not in result.metrics
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith('Left out: observer acme-watch: observer "acme-watch" (acme 1.0)')
    assert problem in line


def test_the_version_of_an_observer_of_every_run_is_kept(install: Install) -> None:
    source = WATCHER.replace("FILES", "()")
    install("acme", {"acme-watch": "acme_watch:Watcher"}, group="rmfs.observers", acme_watch=source)
    result = rmfs_core.run("examples/small", overrides=["instance.orders=2"])
    assert (result.metrics["acme_one"], result.versions["acme"]) == (1, "1.0")


CLASHING = """
import rmfs_core
from rmfs_core.results.catalogue import Metric
class Watcher:
    files = ()
    measures = (Metric("picks", "My picks"),)
    @rmfs_core.hookimpl
    def run_started(self):
        if HOOK == "run_started":
            raise KeyError("no")
    @rmfs_core.hookimpl
    def measured(self): return {"picks": 1} if HOOK == "measured" else {}
"""


@pytest.mark.parametrize("hook", ["run_started", "measured"])
def test_what_anothers_observer_does_wrong_takes_no_metric_away(hook: str, install: Install) -> None:
    source = CLASHING.replace("HOOK", repr(hook))
    install("acme", {"zebra": "acme_watch:Watcher"}, group="rmfs.observers", acme_watch=source)
    with pytest.raises(RunError, match=r'observer "zebra" \(acme 1.0\)') as caught:
        rmfs_core.run("examples/small", overrides=["instance.orders=2"])
    result = caught.value.result
    assert result.metrics["orders_total"] == 2
    assert result.described["picks"].label != "My picks"


def test_an_order_that_was_split_and_one_that_never_left_the_backlog(tiny: RunInfo) -> None:
    tables = Tables()
    tables.run_started(tiny)
    tables.on_event(OrderAssigned(1000, 0, 1, skus=(0,), items=1, period=1, complete=False))
    tables.on_event(OrderAssigned(2000, 0, 0, skus=(1,), items=1, period=2, complete=True))
    tables.on_event(OrderCompleted(9000, 0))
    first, second = tables.orders
    times = {"assigned_s": 2.0, "completed_s": 9.0, "turnover_s": 9.0}
    assert first == times | {
        **{"order": "first", "arrival_s": 0.0, "items": 2, "lines": 2, "parts": 2, "stations": "2 1"},
        **{"turnover_backlog_s": 2.0, "turnover_station_s": 7.0},
    }
    assert (second["order"], second["arrival_s"], second["items"], second["lines"]) == ("second", 5.0, 2, 1)
    assert (second["parts"], second["stations"], second["completed_s"], second["turnover_s"]) == (0, "", None, None)
    assert list(first) == list(ORDER_COLUMNS)


def test_tables_of_visits_and_decisions(tiny: RunInfo) -> None:
    tables = Tables()
    tables.run_started(tiny)
    tables.on_event(VisitStarted(1000, 1, robot=1, pod=1, station=0))
    tables.on_event(VisitStarted(2000, 2, robot=0, pod=0, station=1))
    tables.on_event(ItemPicked(8000, 1000, 14_000, visit=1, station=0, pod=1, order=0, sku=1))
    tables.on_event(VisitEnded(8000, 1, pod=1, station=0, picks=1, next_station=None))
    first, second = tables.visits
    assert list(first.values()) == [1, "q", "1", "2", 1.0, 8.0, 1]
    assert [second[key] for key in ("pod", "station", "robot", "end_s", "picks")] == ["p", "2", "1", None, 0]
    assert list(first) == list(VISIT_COLUMNS)
    tables = Tables()
    tables.run_started(tiny)
    tables.on_event(DecisionMade(3000, 4, Role.POA_PPS, "model", 2, 1, 1, "stopped", 3, -math.inf, True, 0.25))
    (row,) = tables.periods
    assert (row["period"], row["time_s"], row["objective"], row["bound"]) == (4, 3.0, 3.0, None)
    assert (row["status"], row["stopped_early"]) == ("stopped", True)
    assert list(row) == list(PERIOD_COLUMNS)
    assert list(row)[-1] == "seconds"


@cases(
    "metric value text",
    (Metric("walked_m", digits=1), 12345.678, "12,345.7"),
    (Metric("walked_m"), 0.005, "0.01"),
    (Metric("walks", digits=0), 12345, "12,345"),
    (Metric("walks", digits=2), 7, "7"),  # a whole number is shown whole
    (Metric("walks"), None, "-"),
    (Metric("busy", unit="%", digits=1, scale=100), 0.4567, "45.7"),  # a share, shown in percent
    (Metric("busy", scale=100), None, "-"),
)
def test_values_are_shown_for_people(metric: Metric, value: float | None, text: str) -> None:
    assert show(metric, value) == text


def test_every_figure_is_described_once_under_its_heading() -> None:
    names = [metric.name for metric in TIMING]
    assert len(names) == len(set(names))
    for metric in TIMING:
        assert re.fullmatch(r"[a-z][a-z0-9_]*", metric.name)
        assert metric.meaning.endswith("."), metric.name
    walks, runs = Metric("walks", group="Ways"), Metric("runs", group="Ways")
    hidden, absent = Metric("hidden", group=None), Metric("absent", group="Nowhere")
    described = {metric.name: metric for metric in (walks, runs, hidden, absent)}
    found = by_heading(["bare", "runs", "hidden", "walks"], described)
    assert found == {"Observers": [Metric("bare")], "Ways": [walks, runs]}
    assert list(found) == ["Observers", "Ways"]


def test_observers_describe_what_they_measure() -> None:
    walks, runs = Metric("walks"), Metric("runs")
    found = described_by([object(), SimpleNamespace(measures=(walks,)), SimpleNamespace(measures=[runs])])
    assert found == {"walks": walks, "runs": runs}
    walks = Metric("walks", "Walks")
    found = described_by([SimpleNamespace(measures=(walks,)), SimpleNamespace(measures=(Metric("walks"),))])
    assert found == {"walks": walks}
    assert Metric("queries").label == "queries"
    assert Metric("queries", "Path queries").label == "Path queries"


@pytest.mark.parametrize("measures", ["walks", ("walks",), {"walks": 1}, Metric("walks")])
def test_a_wrong_description_is_refused(measures: object) -> None:
    class Walks:
        def __init__(self) -> None:
            self.measures = measures

    assert said(InputError, described_by, [Walks()]) == (
        f"class Walks: expected `measures` to be a tuple of rmfs_core.results.catalogue.Metric, found {measures!r:.80}"
    )


@cases(
    "wrong", {"label": 5}, {"unit": None}, {"label": "two\nlines"}, {"digits": -1}, {"digits": 10**9}, {"digits": "2"}
)
def test_a_metric_is_shown_on_a_line(wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="expected texts of one line and 0 to 15 digits, found Metric"):
        Metric("legs", **wrong)


def test_measures_that_cannot_be_read_are_one_sentence() -> None:
    class Watching:
        @property
        def measures(self) -> tuple[Metric, ...]:
            raise LookupError("none")

    expected = r"class Watching: expected `measures` to be .*, found LookupError\('none'\)"
    with pytest.raises(InputError, match=expected):
        described_by([Watching()])
