"""Recorders, rows of tables, how metrics are shown; and running a scenario through the library and into a folder."""

import gzip
import hashlib
import json
import math
import re
import signal
import sys
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn
from xml.etree import ElementTree

import numpy as np
import pytest
from attrs import define, evolve, field

import rmfs_core
from calling import refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.details.loading import load_result
from rmfs_commands.instances.tables import ORDER_COLUMNS, Tables
from rmfs_commands.results.figures import show
from rmfs_commands.results.recorders import load_recorder
from rmfs_core import InputError, OrderAssignment, RuleError, hookimpl, load_scenario
from rmfs_core.errors import RunError
from rmfs_core.events import DecisionMade, Event, OrderAssigned, OrderCompleted
from rmfs_core.info import RunInfo
from rmfs_core.results.catalogue import Metric
from rmfs_core.roles import Role
from rmfs_core.scenario.model import RunSection
from rmfs_core.warehouse import WarehouseView
from saying import said

Install = Callable[..., None]
Record = Callable[[str], None]
FEW = ["instance.orders=2"]

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


@pytest.fixture
def record(install: Install) -> Record:
    """Install a distribution with a recorder of a source."""
    return lambda source: install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=source)


def test_a_third_partys_recorder_is_switched_on_by_its_name(record: Record, tmp_path: Path) -> None:
    record(RECORDER)
    rmfs_core.run("examples/small", out=tmp_path, record=["acme-log"])
    assert (tmp_path / "acme.txt").read_text(encoding="utf-8") == "recorded"
    rmfs_core.run("examples/small", out=tmp_path)
    assert not (tmp_path / "acme.txt").exists()


def test_only_recorders_that_are_switched_on_are_imported(record: Record, tmp_path: Path) -> None:
    record(RECORDER)
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
    ("class Recorder:\n    file = 'result.json'", "as `file`, a plain name that no file of results has"),
    (
        "class Recorder:\n    file = 'a.txt'\n    def __init__(self, path): pass",
        "cannot be made: TypeError: Recorder.__init__() missing 1 required positional argument: 'path'",
    ),
    ("class Recorder:\n    file = 'a.txt'\n    def __init__(self): exit()", "cannot be made: SystemExit"),
    ("class Recorder:\n    file = 'a.txt'", "observer Recorder: it implements no observer hook"),
)
def test_a_broken_recorder_costs_one_sentence(source, problem, record, tmp_path, capsys) -> None:
    record(source)
    command = ["run", "examples/small", "--quiet", "--out", str(tmp_path / "out"), "--record", "acme-log"]
    (line,) = refused(capsys, main, command).splitlines()
    assert problem in line
    assert not (tmp_path / "out").exists()
    assert rmfs_core.run("examples/small", out=tmp_path / "out", record=["trace"]).status == "complete"
    assert (tmp_path / "out" / "trace.jsonl.gz").exists()


def test_a_recorder_that_raises_is_named(record: Record, tmp_path: Path) -> None:
    source = RECORDER.replace('(run.out / self.file).write_text("recorded")', "return 1 / 0")
    record(source)
    with pytest.raises(rmfs_core.RuleError, match=r'^recorder "acme-log" \(acme 1.0\), run_started, .* ZeroDivision'):
        rmfs_core.run("examples/small", out=tmp_path, record=["acme-log"])
    assert (tmp_path / "result.json").exists()


@cases(
    "file", "", ".", "..", "../up.txt", "/tmp.txt", "a/b.txt", "a/", ".hidden", "nul\0.txt", "a" * 300, "Orders.csv", 3
)
def test_a_recorder_names_one_plain_file(file: object, record: Record) -> None:
    record(writing(file))
    with pytest.raises(InputError, match=r'recorder "acme-log" \(acme 1.0\) is no recorder: expected a class with'):
        load_recorder("acme-log")


def test_two_recorders_of_one_file_are_not_switched_on_together(record: Record, tmp_path: Path) -> None:
    record(writing("trace.jsonl.gz"))
    expected = r'recorder "trace" \(rmfs .*\) and recorder "acme-log" \(acme 1.0\) write the same file, trace.jsonl'
    with pytest.raises(InputError, match=expected):
        rmfs_core.run("examples/small", out=tmp_path / "out", record=["trace", "acme-log"])
    assert not (tmp_path / "out").exists()


def test_a_file_that_no_run_has_written_is_left_alone(record: Record, tmp_path: Path) -> None:
    record(writing("notes.txt"))
    mine = tmp_path / "out" / "notes.txt"
    mine.parent.mkdir()
    mine.write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"found a file notes\.txt that no run of rmfs has written"):
        rmfs_core.run("examples/small", out=mine.parent, record=["acme-log"])
    rmfs_core.run("examples/small", overrides=FEW, out=mine.parent)
    assert mine.read_text(encoding="utf-8") == "mine"
    rmfs_core.run("examples/small", overrides=FEW, out=mine.parent)
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
    result = rmfs_core.run("examples/small", overrides=FEW)
    assert result.status == "complete"
    assert "acme_one" not in result.metrics
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith('Left out: observer acme-watch: observer "acme-watch" (acme 1.0)')
    assert problem in line


def test_the_version_of_an_observer_of_every_run_is_kept(install: Install) -> None:
    source = WATCHER.replace("FILES", "()")
    install("acme", {"acme-watch": "acme_watch:Watcher"}, group="rmfs.observers", acme_watch=source)
    result = rmfs_core.run("examples/small", overrides=FEW)
    assert (result.metrics["acme_one"], result.versions["acme"]) == (1, "1.0")


CLASHING = """
import rmfs_core
from rmfs_core.info import RunInfo
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
        rmfs_core.run("examples/small", overrides=FEW)
    result = caught.value.result
    assert result.metrics["orders_total"] == 2
    assert result.described["picks"].label != "My picks"


def test_rows_of_orders_and_of_a_decision_that_was_stopped(tiny: RunInfo) -> None:
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
    tables.on_event(DecisionMade(3000, 4, Role.POA_PPS, "model", 2, 1, 1, "stopped", 3, -math.inf, True, 0.25))
    (row,) = tables.periods
    assert (row["status"], row["objective"], row["bound"], row["stopped_early"]) == ("stopped", 3.0, None, True)


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


@cases(
    "measures found",
    *((one, repr(one)) for one in ("walks", ("walks",), {"walks": 1}, Metric("walks"))),
    (property(lambda _: {}["none"]), "KeyError('none')"),
)
def test_a_wrong_description_is_refused_before_the_run(measures: object, found: str) -> None:
    walks = type("Walks", (Pressing,), {"measures": measures})(0)
    assert said(InputError, rmfs_core.run, "examples/small", observers=[walks]) == (
        f"class Walks: expected `measures` to be a tuple of rmfs_core.results.catalogue.Metric, found {found:.80}"
    )
    assert walks.heard == [0, 0]


@cases(
    "wrong", {"label": 5}, {"unit": None}, {"label": "two\nlines"}, {"digits": -1}, {"digits": 10**9}, {"digits": "2"}
)
def test_a_metric_is_shown_on_a_line(wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="expected texts of one line and 0 to 15 digits, found Metric"):
        Metric("legs", **wrong)


def test_results_do_not_replace_the_input(tmp_path: Path) -> None:
    main(["generate", "examples/small", "--out", str(tmp_path / "data")])
    before = (tmp_path / "data" / "orders.csv").read_bytes()
    with pytest.raises(rmfs_core.InputError, match=r"results would replace `instance\.orders_file`, orders\.csv"):
        rmfs_core.run(tmp_path / "data" / "scenario.toml", out=tmp_path / "data")
    assert (tmp_path / "data" / "orders.csv").read_bytes() == before


def test_a_run_that_is_refused_leaves_no_folder(tmp_path: Path) -> None:
    (tmp_path / "old").mkdir()
    for folder in ("new", "old"):
        with pytest.raises(rmfs_core.InputError, match="robots"):
            rmfs_core.run("examples/small", overrides=["robots.count=1000"], out=tmp_path / folder)
    assert [path.name for path in tmp_path.iterdir()] == ["old"]


class Observing:
    """Observer that does something in one of its hooks, and has something else to tell."""

    def __init__(self, hook: str, act: Callable[[], object]) -> None:
        self.hook, self.act = hook, act
        self.ended = False

    @rmfs_core.hookimpl
    def run_ended(self) -> None:
        self.ended = True
        if self.hook == "run_ended":
            self.act()

    @rmfs_core.hookimpl
    def measured(self) -> object:
        return self.act() if self.hook == "measured" else {f"by_{self.hook}": 1}


class Summing:
    """Observer that puts into the summary what JSON cannot have."""

    @rmfs_core.hookimpl
    def run_started(self, run: Any) -> None:
        endless: list[object] = []
        endless.append(endless)
        run.summary.update(pairs={(1, 2): 3}, end=endless, good=[1], far={(): math.nan}, many=10**5000, no="\ud800")


def test_a_summary_that_json_cannot_have_does_not_lose_the_run(tmp_path: Path) -> None:
    rmfs_core.run("examples/small", overrides=FEW, out=tmp_path, observers=[Summing()])
    saved = load_result(tmp_path).summary
    assert (saved["pairs"], saved["good"], "<list>" in str(saved["end"])) == ({"(1, 2)": 3}, [1], True)
    assert [saved[name] for name in ("far", "many", "no")] == ["<dict>", "<int>", "<str>"]


def raising(error: BaseException) -> Callable[[], NoReturn]:
    def act() -> NoReturn:
        raise error

    return act


class Pressing:
    """Observer that presses Ctrl-C at an event, the fiftieth or some other, and counts the events that it hears."""

    def __init__(self, times: int, at: int = 50) -> None:
        self.times, self.heard, self.at = times, [0, 0], at
        self.ended: list[tuple[int, str]] = []

    @rmfs_core.hookimpl
    def on_event(self, event: Event) -> None:
        self.heard[0] += 1
        if self.heard[0] == self.at:
            for _ in range(self.times):
                signal.raise_signal(signal.SIGINT)
        self.heard[1] += 1

    @rmfs_core.hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        self.ended.append((tick, status))


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Heed Ctrl-C, which tests in the background ignore; after the test it is handled as before."""
    if sys.platform == "win32":
        pytest.skip("no POSIX signals")
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    after = signal.signal(signal.SIGINT, before)
    assert after is signal.default_int_handler


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize(("times", "heard"), [(1, 0), (2, 1)])
def test_a_run_is_interrupted_between_events(times: int, heard: int, tmp_path: Path) -> None:
    """So that nobody has heard half of one; at the second Ctrl-C at once. Afterwards all is as before."""
    observer = Pressing(times)
    result = rmfs_core.run("examples/small", observers=[observer], out=tmp_path, record=["trace"])
    assert (result.interrupted, result.status) == (True, "partial")
    assert observer.heard[0] - observer.heard[1] == heard
    assert observer.ended == [(round(result.metrics["simulated_s"] * 1000), "partial")]
    assert load_result(tmp_path).status == "partial"
    assert (tmp_path / "trace.jsonl.gz").exists()


@pytest.mark.usefixtures("interruptible")
def test_a_run_whose_last_event_is_interrupted_is_complete() -> None:
    counting = Pressing(0)
    rmfs_core.run("examples/small", observers=[counting])
    result = rmfs_core.run("examples/small", observers=[Pressing(1, at=counting.heard[0])])
    assert (result.interrupted, result.status) == (False, "complete")


def interrupt_compiled() -> None:
    raise SystemError("<function> returned a result with an exception set") from KeyboardInterrupt()


@define
class InCompiledCode:
    """POA rule that is interrupted there when it is asked for the third time."""

    calls: int = 0

    @rmfs_core.hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> list[OrderAssignment]:
        self.calls += 1
        if self.calls == 3:
            interrupt_compiled()
        return [OrderAssignment(warehouse.backlog[0].id, warehouse.stations[0].id)]


def test_an_interrupt_within_compiled_code_is_one(tmp_path: Path) -> None:
    result = rmfs_core.run("examples/small", out=tmp_path, rules={"poa": InCompiledCode()})
    assert (result.interrupted, result.status, result.error) == (True, "partial", None)
    assert load_result(tmp_path).metrics["orders_total"] > 2
    observers = [Observing("measured", interrupt_compiled)]
    result = rmfs_core.run("examples/small", overrides=["instance.orders=3"], observers=observers)
    assert (result.interrupted, result.status, result.error) == (True, "partial", None)


@pytest.mark.parametrize("hook", ["run_ended", "measured"])
def test_an_interrupt_at_the_end_of_a_run_loses_nothing(hook: str, tmp_path: Path) -> None:
    other, interrupted = Observing("nothing", int), Observing(hook, raising(KeyboardInterrupt()))
    few = ["instance.orders=3"]
    result = rmfs_core.run("examples/small", overrides=few, out=tmp_path, observers=[other, interrupted])
    assert (result.interrupted, result.status, other.ended) == (True, "partial", True)
    saved = load_result(tmp_path)
    assert (saved.metrics["orders_completed"], saved.metrics["by_nothing"]) == (3, 1)


@pytest.mark.parametrize("hook", ["run_ended", "measured"])
@pytest.mark.parametrize("error", [SystemExit(3), OSError("disk full")], ids=repr)
def test_an_observer_that_fails_at_the_end_of_a_run_loses_nothing(
    error: BaseException, hook: str, tmp_path: Path
) -> None:
    other, failing = Observing("nothing", int), Observing(hook, raising(error))
    for observers in ([other, failing], [failing, other]):
        other.ended = False
        with pytest.raises(type(error)):
            rmfs_core.run("examples/small", overrides=FEW, out=tmp_path, observers=observers)
        saved = load_result(tmp_path)
        assert (saved.error, saved.metrics["by_nothing"]) == (f"{type(error).__name__}: {error}", 1)
        assert other.ended


class Unreadable(dict[str, int]):
    def items(self) -> NoReturn:
        raise LookupError("not yet")


class Speechless(Exception):  # noqa: N818
    def __str__(self) -> str:
        raise ValueError


NUMBER = "expected an int or float below 2^63, or None."
LETTERS = "expected letters, digits and underscores."


@cases(
    "answer problem",
    (None, "returned None; expected numbers by name."),
    ([("walks", 3)], "returned list [('walks', 3)]; expected numbers by name."),
    ({"walks per h": 3}, f"named a metric 'walks per h'; {LETTERS}"),
    ({"größe": 3}, f"named a metric 'größe'; {LETTERS}"),
    ({"a\n": 1}, rf"named a metric 'a\n'; {LETTERS}"),
    ({3: 3}, f"named a metric 3; {LETTERS}"),
    ({"picks": 3}, "named a metric 'picks', which exists already."),
    ({"wall_s": 3}, "named a metric 'wall_s', which exists already."),
    ({"walks": "3"}, f"measured walks = '3'; {NUMBER}"),
    ({"walks": True}, f"measured walks = True; {NUMBER}"),
    ({"walks": np.bool_(True)}, f"measured walks = True; {NUMBER}"),
    ({"walks": float("inf")}, f"measured walks = inf; {NUMBER}"),
    ({"walks": float("nan")}, f"measured walks = nan; {NUMBER}"),
    ({"walks": 2**63}, f"measured walks = {2**63}; {NUMBER}"),
    (Unreadable(a=1), "returned Unreadable {'a': 1}, which raised LookupError: not yet ("),
)
def test_a_wrong_measurement_is_one_sentence_and_the_others_stay(answer: object, problem: str, tmp_path: Path) -> None:
    observers = [Observing("measured", lambda: answer), Observing("nothing", int)]
    told = said(RuleError, rmfs_core.run, "examples/small", overrides=FEW, out=tmp_path, observers=observers)
    saved = load_result(tmp_path)
    assert (saved.error, saved.metrics["by_nothing"], "walks" in saved.metrics) == (told, 1, False)
    assert re.sub(r"at \d+\.\d+ s", "at ... s", told).startswith(f"observer Observing, measured, at ... s: {problem}")


def test_numbers_of_numpy_are_measurements(tmp_path: Path) -> None:
    walks = {"long": np.int64(3), "short": np.float32(0.5)}
    rmfs_core.run("examples/small", overrides=FEW, out=tmp_path, observers=[Observing("measured", lambda: walks)])
    saved = load_result(tmp_path).metrics
    assert (saved["long"], saved["short"]) == (3, 0.5)


@cases("error shown", (Speechless(), "Speechless"), (LookupError("one\ntwo"), "LookupError: one two"))
def test_what_an_observer_raises_is_kept_on_a_line(error: Exception, shown: str, tmp_path: Path) -> None:
    observers = [Observing("measured", raising(error)), Observing("run_ended", raising(OSError("first")))]
    for named, known in ((observers, "OSError: first"), (observers[:1], shown)):
        with pytest.raises((OSError, type(error))):
            rmfs_core.run("examples/small", overrides=FEW, out=tmp_path, observers=named)
        assert load_result(tmp_path).error == known


@define
class Oldest:
    """A rule that gives the oldest order that fits to the first station with room for it, and counts its decisions."""

    skip: int = 0
    decided: int = field(init=False, default=0)

    @rmfs_core.hookimpl
    def assign_orders(self, warehouse: WarehouseView) -> list[OrderAssignment]:
        self.decided += 1
        for order in warehouse.backlog[self.skip :] or warehouse.backlog:
            for station in warehouse.stations:
                if warehouse.fits(order, station):
                    return [OrderAssignment(order.id, station.id)]
        return []


def test_a_rule_may_be_an_object(tmp_path: Path) -> None:
    rule = Oldest(skip=2)
    result = rmfs_core.run("examples/small", rules={"poa": rule}, out=tmp_path, record=["trace"])
    assert rule.decided == result.hook_calls["assign_orders"] > 0
    told = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert told["scenario"]["rules"]["poa"] == {"rule": "Oldest", "skip": 2}
    assert told["scenario"]["rules"]["pps"] == "demand"
    assert told["versions"]["Oldest"] == f"object of {__name__}"
    assert {row["rule"] for row in result.periods} == {"Oldest", "demand"}
    with gzip.open(tmp_path / "trace.jsonl.gz", "rt", encoding="utf-8") as stream:
        assert json.loads(stream.readline())["scenario"]["rules"]["poa"] == {"rule": "Oldest", "skip": 2}
    main(["validate", str(tmp_path)])


def test_objects_of_installed_rules(tmp_path: Path) -> None:
    rule = import_module("rmfs_rules.random").Random()
    rmfs_core.run("examples/small", rules={"poa": rule}, out=tmp_path / "object", record=["trace"])
    rmfs_core.run("examples/small", overrides=["rules.poa=random"], out=tmp_path / "name", record=["trace"])
    for file in ("orders.csv", "visits.csv", "trace.jsonl.gz"):
        assert (tmp_path / "object" / file).read_bytes() == (tmp_path / "name" / file).read_bytes()
    again = rmfs_core.run(load_result(tmp_path / "object").scenario)
    assert again.metrics == load_result(tmp_path / "name").metrics
    with pytest.raises(rmfs_core.InputError, match=r"^argument rules: expected `poa` and `pps`.* found `poa` alone$"):
        rmfs_core.run("examples/small", overrides=["rules.poa_pps=pod-index"], rules={"poa": Oldest()})
    with pytest.raises(rmfs_core.RuleError, match=r'^rule "Oldest" \(.* object\), assign_orders, at 0\.000 s: raised '):
        rmfs_core.run("examples/small", rules={"poa": Oldest("many")})


def test_a_run_without_a_complete_order_says_why(tmp_path: Path) -> None:
    result = rmfs_core.run("grocery-day", overrides=["run.until_s=3600"], out=tmp_path)
    (note,) = result.notes
    assert note == "No order is complete at 3600.000 s: the first one arrives at 22434.600 s."
    assert json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["notes"] == [note]
    assert load_result(tmp_path).notes == [note]
    assert note in result._repr_html_()
    done = rmfs_core.run("examples/small", overrides=FEW)
    assert (done.notes, "notes" in done.to_dict()) == ([], False)


READING = """
from __future__ import annotations
from typing import TYPE_CHECKING
from attrs import define
from rmfs_core import hookimpl
if TYPE_CHECKING:
    from pathlib import Path
@define
class Reading:
    file: Path
    more: Path | None = None
    @hookimpl
    def choose_storage_location(self, warehouse):
        free = sorted(warehouse.free_storage_locations)
        return free[int(self.file.read_text()) % len(free)]
"""


def test_files_of_parameters_stand_in_the_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    rules = '[rules]\npoa = "pod-match"\npps = "demand"\npp = "free-flow"\n'
    text = f'[instance]\norders = 5\n{rules}pr = {{ rule = "./r.py:Reading", file = "w.txt" }}\n'
    (folder / "s.toml").write_text(text, encoding="utf-8")
    (folder / "r.py").write_text(READING, encoding="utf-8")
    (folder / "w.txt").write_text("0", encoding="utf-8")
    (tmp_path / "w.txt").write_text("40", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    digests = [f"sha256:{hashlib.sha256(content).hexdigest()}" for content in (b"0", b"40")]
    plain = rmfs_core.run("folder/s.toml", out="out")
    assert json.loads((tmp_path / "out" / "result.json").read_text("utf-8"))["versions"]["w.txt"] == digests[0]
    given = rmfs_core.run("folder/s.toml", overrides=["rules.pr.file=w.txt", "rules.pr.more=folder/w.txt"])
    outside = str(tmp_path / "w.txt")
    assert (given.versions[outside], given.versions["w.txt"]) == (digests[1], digests[0])
    assert given.scenario.rules.pr.parameters == {"file": outside, "more": "w.txt"}
    assert {type(name) for name in given.scenario.rules.pr.parameters.values()} == {str}
    assert given.metrics["distance_m"] != plain.metrics["distance_m"]
    monkeypatch.syspath_prepend(folder)
    rule = import_module("r").Reading(Path("w.txt"))
    told = rmfs_core.run("folder/s.toml", rules={"pr": rule})
    assert (told.versions[outside], told.metrics) == (digests[1], given.metrics)
    (folder / "w.txt").unlink()
    problem = said(rmfs_core.InputError, rmfs_core.run, "folder/s.toml", out="new")
    assert problem == "folder/s.toml, line 7, rules.pr.file: there is no file folder/w.txt"
    assert not (tmp_path / "new").exists()


FAILING_RULE = """
import attrs
from rmfs_core import Path, hookimpl
@attrs.define
class Failing:
    @hookimpl
    def plan_path(self, warehouse, robot, goal):
        if any(order.unpicked_items < order.items for order in warehouse.orders):
            raise ValueError("out of ideas")
        return Path(warehouse.travel.fastest_path(robot.cell, robot.heading, goal, robot.pod is not None))
"""
FILES = {f"{name}.csv" for name in ("orders", "visits", "periods", "hours", "stations", "robots", "delays")}
FILES |= {"result.json"}


def test_saved_and_loaded(tmp_path: Path) -> None:
    result = rmfs_core.run("examples/small", overrides=FEW, out=tmp_path / "out")
    assert (result.status, result.error, result.timing["wall_s"] > 0) == ("complete", None, True)
    assert result.timing["hook_s"].keys() >= {"assign_orders", "select_pods"}
    loaded = load_result(tmp_path / "out")
    assert {path.name for path in (tmp_path / "out").iterdir()} == FILES
    assert loaded.to_dict() == result.to_dict()
    assert (loaded.orders, loaded.visits, loaded.periods) == (result.orders, result.visits, result.periods)
    assert loaded.scenario == result.scenario
    assert json.loads((tmp_path / "out" / "result.json").read_text())["scenario"]["stations"]["item_capacity"] == 15


def test_seed_overrides_and_limit_count() -> None:
    first = rmfs_core.run("examples/small", overrides=["instance.orders=4"], seed=3)
    again = rmfs_core.run(load_scenario("examples/small", ["instance.orders=4"]), seed=3)
    assert (first.seed, first.metrics["orders_total"], first.metrics) == (3, 4, again.metrics)
    with pytest.raises(InputError, match="expected a scenario file"):
        rmfs_core.run(load_scenario("examples/small"), overrides=["seed=2"])
    scenario = evolve(load_scenario("examples/small"), run=RunSection(until_s=60.0))
    result = rmfs_core.run(scenario)
    assert (result.status, result.interrupted) == ("horizon", False)
    assert (result.metrics["makespan_s"], result.metrics["simulated_s"]) == (None, 60.0)
    assert result.metrics["orders_completed"] < 10
    with pytest.raises(InputError, match="folder"):
        rmfs_core.run("examples/small", record=["trace"])


def test_no_orders_at_all(tmp_path: Path) -> None:
    result = rmfs_core.run("examples/small", overrides=["instance.orders=0"], out=tmp_path / "out")
    assert result.status == "complete"
    assert result.metrics["turnover_s"] is None
    assert load_result(tmp_path / "out").orders == []


def test_a_failed_run_keeps_what_was_measured_and_its_rule_is_found_again(tmp_path, monkeypatch) -> None:
    (tmp_path / "failing.py").write_text(FAILING_RULE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    failing = f"{tmp_path}/failing.py"
    with pytest.raises(RuleError, match="out of ideas") as caught:
        rmfs_core.run("examples/small", overrides=["rules.pp=./failing.py:Failing"], out=tmp_path / "out")
    result, saved = caught.value.result, load_result(tmp_path / "out")
    assert result.status == "failed"
    assert result.metrics["picks"] > 0
    assert (saved.to_dict(), saved.error) == (result.to_dict(), str(caught.value))
    assert saved.scenario.rules.pp.rule == f"{failing}:Failing"
    assert saved.versions[failing].startswith("sha256:")
    monkeypatch.chdir(tmp_path / "out")
    with pytest.raises(RuleError, match="out of ideas") as caught:
        rmfs_core.run(saved.scenario)
    assert caught.value.result.versions == saved.versions
    with pytest.raises(InputError, match="--no-inline-rules refuses"):
        rmfs_core.run(saved.scenario, allow_inline_rules=False)


def test_a_notebook_shows_status_and_metrics() -> None:
    class Counting:
        measures = (Metric("legs", "Legs", "m", 1, group="Drives"), Metric("hidden", group=None))

        @hookimpl
        def measured(self) -> dict[str, float]:
            return {"bare": 1, "legs": 2.25, "hidden": 7.0}

    result = rmfs_core.run("examples/small", observers=[Counting()])
    shown = [text.strip() for text in ElementTree.fromstring(result._repr_html_()).itertext()]
    assert shown[:2] == ["complete", ", seed 1"]
    assert shown[2:5] == ["Orders", "Orders completed", "50"]
    at = shown.index("Picker utilisation")
    assert shown[at + 1 : at + 3] == ["78.8", "%"]
    assert shown[shown.index("Drives") :] == ["Drives", "Legs", "2.2", "m"]
    assert shown[shown.index("bare") - 1 :][:3] == ["Observers", "bare", "1"]
    assert "hidden" not in shown


def test_a_notebook_takes_no_text_of_a_file_for_html(tmp_path: Path) -> None:
    rmfs_core.run("examples/small", out=tmp_path)
    file = tmp_path / "result.json"
    told = json.loads(file.read_text(encoding="utf-8"))
    evil = "<script>alert(1)</script>"
    told |= {"status": evil, "error": evil, "seed": evil}
    told["metrics"] |= {evil: 1, "picks": evil, "makespan_s": None}
    file.write_text(json.dumps(told), encoding="utf-8")
    shown = load_result(tmp_path)._repr_html_()
    assert "<script" not in shown
    assert shown.count("&lt;script&gt;alert(1)&lt;/script&gt;") == 5
    ElementTree.fromstring(shown)
