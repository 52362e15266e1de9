"""Files appear whole or not at all; recorders, rows, wall-clock figures, and how metrics are shown."""

import json
import math
import os
import re
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import rmfs_core
from calling import refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.instances.tables import ORDER_COLUMNS, PERIOD_COLUMNS, VISIT_COLUMNS, Tables
from rmfs_core import InputError
from rmfs_core.errors import RunError
from rmfs_core.events import DecisionMade, ItemPicked, OrderAssigned, OrderCompleted, VisitEnded, VisitStarted
from rmfs_core.info import RunInfo
from rmfs_core.results.catalogue import TIMING, Metric, by_heading, described_by, show
from rmfs_core.results.files import (
    AtomicFile,
    clean,
    json_ready,
    output_folder,
    removed_if_empty,
    staged,
    to_csv,
    to_json,
    write_text,
)
from rmfs_core.results.recorders import load_recorder
from rmfs_core.results.timing import timing
from rmfs_core.roles import Role
from saying import said

Install = Callable[..., None]

not_root = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="permissions do not hold the superuser"
)


def test_a_file_is_replaced_as_a_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "first\n")
    write_text(path, "sec\u00f6nd\n")
    assert path.read_bytes() == "sec\u00f6nd\n".encode()
    assert list(tmp_path.iterdir()) == [path]
    path = tmp_path / "a.txt"
    write_text(path, "old")
    with pytest.raises(ZeroDivisionError), AtomicFile(path) as stream:
        stream.write(b"half")
        raise ZeroDivisionError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_new_file_is_not_there_before_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "old")
    with AtomicFile(path) as stream:
        stream.write(b"new")
        stream.flush()
        assert path.read_text() == "old"
    assert path.read_text() == "new"


def test_what_no_file_can_be_is_named(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    with pytest.raises(InputError, match="a folder has that name"):
        write_text(tmp_path / "a", "text")
    assert list(tmp_path.iterdir()) == [tmp_path / "a"]
    with pytest.raises(InputError, match="cannot be written") as caught:
        write_text(tmp_path / "none" / "a.txt", "text")
    assert caught.value.place.endswith("a.txt")


@pytest.fixture
def small_files() -> Iterator[int]:
    most, hard = 10_000, resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    yield most
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))


@pytest.mark.parametrize("size", [10_001, 1_000_000])  # found out when the file is closed, or while it is written
def test_what_does_not_fit_leaves_the_old_file(tmp_path: Path, small_files: int, size: int) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "old")
    assert said(InputError, write_text, path, "x" * size) == f"{path}: cannot be written: File too large"
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_links_pipes_and_devices_are_followed(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    for name in ("old", "new"):
        (tmp_path / "link").unlink(missing_ok=True)
        (tmp_path / "link").symlink_to(Path("there") / name)
        (tmp_path / "there" / "old").write_text("old")
        write_text(tmp_path / "link", "mine")
        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "there" / name).read_text() == "mine"
    assert {path.name for path in (tmp_path / "there").iterdir()} == {"old", "new"}
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    write_text(pipe, "text")
    reader.join(timeout=10)
    assert read == ["text"]
    assert pipe.is_fifo()
    write_text("/dev/null", "text")
    assert Path("/dev/null").is_char_device()
    with pytest.raises(InputError, match="/dev/full: cannot be written: No space left on device"):
        write_text("/dev/full", "text")
    write_text(tmp_path / ("\N{SNOWMAN}" * 85), "text")
    with pytest.raises(InputError, match="cannot be written: File name too long"):
        write_text(tmp_path / ("x" * 256), "text")


WRITER = """
import sys, time
from pathlib import Path
from rmfs_core.results.files import AtomicFile, staged
folder = Path(sys.argv[1])
with AtomicFile(folder / "file.txt") as stream, staged(folder) as hidden:
    (hidden / "orders.csv").write_text("new")
    print("ready", flush=True)
    time.sleep(60)
"""


def test_what_a_killed_process_has_left_is_cleaned(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path)], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"ready\n"
        clean(tmp_path)
        assert len(list(tmp_path.iterdir())) == 2
        process.send_signal(signal.SIGKILL)
    (tmp_path / ".mine.part").write_text("mine")
    clean(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".mine.part"]


def test_staged_files_take_their_places_together(tmp_path: Path) -> None:
    for name in ("orders.csv", "mine.txt"):
        (tmp_path / name).write_text("old")
    (tmp_path / "link.csv").symlink_to("mine.txt")
    with staged(tmp_path) as hidden:
        for name in ("orders.csv", "link.csv", "sub/more.csv"):
            (hidden / name).parent.mkdir(exist_ok=True)
            (hidden / name).write_text("new")
        assert (tmp_path / "orders.csv").read_text() == "old"
    texts = {path.name: path.read_text() for path in tmp_path.rglob("*") if path.is_file()}
    assert texts == {"orders.csv": "new", "mine.txt": "new", "link.csv": "new", "more.csv": "new"}
    assert (tmp_path / "link.csv").is_symlink()
    with pytest.raises(ZeroDivisionError), staged(tmp_path) as hidden:
        (hidden / "orders.csv").write_text("half")
        raise ZeroDivisionError
    assert (tmp_path / "orders.csv").read_text() == "new"
    assert not list(tmp_path.glob(".*"))


def test_what_was_whole_is_put_in_place_by_the_next(tmp_path: Path) -> None:
    (tmp_path / "orders.csv").write_text("new")
    left = tmp_path / ".files.0123456789ab.whole"
    left.mkdir()
    (left / "result.json").write_text("new")
    clean(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["orders.csv", "result.json"]


def test_output_folders_are_made_and_empty_ones_removed(tmp_path: Path) -> None:
    assert output_folder(tmp_path / "a" / "b").is_dir()
    assert output_folder(tmp_path / "a" / "b").is_dir()
    old, new, full = tmp_path / "old", tmp_path / "new", tmp_path / "full"
    old.mkdir()
    for folder in (old, new / "newer", full):
        with pytest.raises(KeyboardInterrupt), removed_if_empty(folder):
            output_folder(folder)
            if folder is full:
                (folder / "a").touch()
            raise KeyboardInterrupt
    assert [folder.exists() for folder in (old, new, full)] == [True, False, True]


@pytest.mark.parametrize("name", ["file", "file/below"])
def test_a_file_where_a_folder_should_be(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="expected a folder"):
        output_folder(tmp_path / name)


@not_root
def test_a_folder_that_may_not_be_written_to(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="cannot be written to"):
        output_folder(tmp_path)
    tmp_path.chmod(0o700)


def test_csv_fields_and_json() -> None:
    rows = [{"a": None, "b": True, "c": 'x,"y"'}, {"a": 0.1, "b": False, "c": "z"}]
    assert to_csv(["a", "b", "c"], rows) == 'a,b,c\n,true,"x,""y"""\n0.1,false,z\n'
    assert to_json({"b": np.int64(3), "a": (1, None)}) == '{"b":3,"a":[1,null]}'
    with pytest.raises(ValueError, match="JSON compliant"):
        to_json(float("nan"))
    endless = json_ready({"window_s": float("inf"), "list": [1.5, float("-inf")]})
    assert endless == {"window_s": "inf", "list": [1.5, "-inf"]}


def test_half_a_character_is_escaped(tmp_path: Path) -> None:
    write_text(tmp_path / "a.json", to_json({"name": "a\udc80"}))
    assert json.loads((tmp_path / "a.json").read_text(encoding="utf-8")) == {"name": "a\udc80"}


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
    assert result.metrics["acme_one"] == 1
    assert result.versions["acme"] == "1.0"


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


ORDERS = [{"completed_s": 40.0}, {"completed_s": 70.0}]


def decided(period: int, seconds: float, time_s: float = 0.0) -> dict[str, Any]:
    return {"period": period, "time_s": time_s, "seconds": seconds}


PERIODS = [decided(1, 2.0), decided(1, 1.0), decided(2, 0.5, time_s=45.0)]


def test_solve_times() -> None:
    found = timing(10.0, 70.0, 0, ORDERS, PERIODS)
    assert (found["decision_s_first"], found["decision_s_later"]) == (3.0, 0.5)
    assert found["decision_s_per_order"] == 0.25
    assert found["decision_percent_of_simulated"] == pytest.approx(100 * 0.5 / 70)
    assert (found["wall_s"], found["simulated_s_per_wall_s"]) == (10.0, 7.0)
    found = timing(10.0, 70.0, 50, ORDERS, [*PERIODS, decided(3, 0.25, time_s=60.0)])
    assert (found["decision_s_first"], found["decision_s_later"]) == (3.0, 0.25)
    assert found["decision_s_per_order"] == 0.25
    assert found["decision_percent_of_simulated"] == 100 * 0.25 / 20
    found = timing(10.0, 100.0, 0, [*ORDERS, {"completed_s": None}], PERIODS)
    assert found["decision_percent_of_simulated"] == 0.5
    assert found["decision_s_per_order"] == 0.25
    found = timing(0.0, 0.0, 0, [], [])
    assert {name for name, value in found.items() if value is None} == {
        "simulated_s_per_wall_s",
        "decision_s_per_order",
        "decision_percent_of_simulated",
    }
    assert {metric.name for metric in TIMING} == timing(1.0, 0.0, 0, [], []).keys()


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
