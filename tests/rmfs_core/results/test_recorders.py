"""Recorders: switched on by their names, and what is left of those that are not."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import rmfs_core
from rmfs_commands.cli.main import main
from rmfs_core.errors import InputError, RunError
from rmfs_core.results.recorders import load_recorder

RECORDER = """
@define
class Recorder:
    file = "acme.txt"

    @hookimpl
    def run_started(self, run):
        (run.out / self.file).write_text("recorded")
"""


def writing(file: object) -> str:
    """Source of a recorder of a file."""
    return RECORDER.replace('"acme.txt"', repr(file))


def test_a_third_partys_recorder_is_switched_on_by_its_name(install: Callable[..., None], tmp_path: Path) -> None:
    """It writes beside the results; a run that does not record it deletes what it wrote before."""
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=RECORDER)
    rmfs_core.run("examples/small", out=tmp_path, record=["acme-log"])
    assert (tmp_path / "acme.txt").read_text(encoding="utf-8") == "recorded"
    rmfs_core.run("examples/small", out=tmp_path)
    assert not (tmp_path / "acme.txt").exists()


def test_only_recorders_that_are_switched_on_are_imported(install: Callable[..., None], tmp_path: Path) -> None:
    """Others are when the folder holds a file that one of them may have left."""
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=RECORDER)
    for _ in range(2):
        rmfs_core.run("examples/small", out=tmp_path, record=["trace"])
    assert "acme_log" not in sys.modules
    (tmp_path / "notes.txt").touch()
    rmfs_core.run("examples/small", out=tmp_path, record=["trace"])
    assert "acme_log" in sys.modules
    assert (tmp_path / "notes.txt").exists()


@pytest.mark.parametrize(
    ("source", "problem"),
    [
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
    ],
)
def test_a_broken_recorder_costs_one_sentence(
    source: str, problem: str, install: Callable[..., None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 2 before anything is run; who does not ask for it does not notice."""
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=source)
    with pytest.raises(SystemExit) as stop:
        main(["run", "examples/small", "--quiet", "--out", str(tmp_path / "out"), "--record", "acme-log"])
    assert stop.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert problem in line
    assert not (tmp_path / "out").exists()
    assert rmfs_core.run("examples/small", out=tmp_path / "out", record=["trace"]).status == "complete"
    assert (tmp_path / "out" / "trace.jsonl.gz").exists()


def test_a_recorder_that_raises_is_named(install: Callable[..., None], tmp_path: Path) -> None:
    """The run ends with one error that says whose it is; what was measured is kept."""
    source = RECORDER.replace('(run.out / self.file).write_text("recorded")', "return 1 / 0")
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=source)
    with pytest.raises(rmfs_core.RuleError, match=r'^recorder "acme-log" \(acme 1.0\), run_started, .* ZeroDivision'):
        rmfs_core.run("examples/small", out=tmp_path, record=["acme-log"])
    assert (tmp_path / "result.json").exists()


@pytest.mark.parametrize(
    "file",
    ["", ".", "..", "../up.txt", "/tmp.txt", "a/b.txt", "a/", ".hidden", "nul\0.txt", "a" * 300, "Orders.csv", 3],
)
def test_a_recorder_names_one_plain_file(file: object, install: Callable[..., None]) -> None:
    """Anything else is refused: it could be a folder, elsewhere, too long, or a file of the results."""
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=writing(file))
    with pytest.raises(InputError, match=r'recorder "acme-log" \(acme 1.0\) is no recorder: expected a class with'):
        load_recorder("acme-log")


def test_two_recorders_of_one_file_are_not_switched_on_together(install: Callable[..., None], tmp_path: Path) -> None:
    """One would replace what the other wrote."""
    install("acme", {"acme-log": "acme_log:Recorder"}, group="rmfs.recorders", acme_log=writing("trace.jsonl.gz"))
    expected = (
        r'recorder "trace" \(rmfs .*\) and recorder "acme-log" \(acme 1.0\) write the same file, trace.jsonl.gz; '
    )
    with pytest.raises(InputError, match=expected):
        rmfs_core.run("examples/small", out=tmp_path / "out", record=["trace", "acme-log"])
    assert not (tmp_path / "out").exists()


def test_a_file_that_no_run_has_written_is_left_alone(install: Callable[..., None], tmp_path: Path) -> None:
    """Neither deleted nor replaced; among the results of an earlier run it is a recorder's."""
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
    def measured(self):
        return {"acme_one": 1}
"""


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("import acme_missing", " cannot be imported from acme_watch:Watcher: ModuleNotFoundError"),
        ("class Watcher:\n    def __init__(self, path): pass", " cannot be made: TypeError"),
        (
            WATCHER.replace("FILES", "'a.csv'"),
            ": expected `files` to be a tuple of plain names, none that of a file of ",
        ),
        (WATCHER.replace("FILES", "('Result.json',)"), "results; found ('Result.json',)"),
        (WATCHER.replace("FILES", "('../a.csv',)"), "results; found ('../a.csv',)"),
    ],
)
def test_a_broken_observer_of_every_run_costs_a_sentence(
    source: str, problem: str, install: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    """The run goes on without it."""
    install("acme", {"acme-watch": "acme_watch:Watcher"}, group="rmfs.observers", acme_watch=source)
    result = rmfs_core.run("examples/small", overrides=["instance.orders=2"])
    assert result.status == "complete"
    assert "acme_one" not in result.metrics
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith('Left out: observer acme-watch: observer "acme-watch" (acme 1.0)')
    assert problem in line


def test_the_version_of_an_observer_of_every_run_is_kept(install: Callable[..., None]) -> None:
    """What it measures is part of the results, as what rules decide is."""
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
def test_what_anothers_observer_does_wrong_takes_no_metric_away(hook: str, install: Callable[..., None]) -> None:
    """Whatever its name: it is told after those of rmfs, and blamed; nor does it describe what they measure."""
    source = CLASHING.replace("HOOK", repr(hook))
    install("acme", {"zebra": "acme_watch:Watcher"}, group="rmfs.observers", acme_watch=source)
    with pytest.raises(RunError, match=r'observer "zebra" \(acme 1.0\)') as caught:
        rmfs_core.run("examples/small", overrides=["instance.orders=2"])
    result = caught.value.result
    assert result is not None
    assert result.metrics["orders_total"] == 2
    assert result.described["picks"].label != "My picks"
