"""Running a scenario into a folder."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import rmfs_core
from rmfs_core.cli import main


def test_results_never_replace_the_input(tmp_path: Path) -> None:
    """A scenario with an orders.csv of its own is not run into that folder."""
    main(["generate", "examples/small", "--out", str(tmp_path / "data")])
    before = (tmp_path / "data" / "orders.csv").read_bytes()
    with pytest.raises(rmfs_core.InputError, match=r"results would replace `instance\.orders_file`, orders\.csv"):
        rmfs_core.run(tmp_path / "data" / "scenario.toml", out=tmp_path / "data")
    assert (tmp_path / "data" / "orders.csv").read_bytes() == before


def test_results_never_replace_what_is_no_result(tmp_path: Path) -> None:
    """A folder that holds somebody's orders.csv, but no result, is refused; one with a result is used again."""
    (tmp_path / "orders.csv").write_text("mine", encoding="utf-8")
    with pytest.raises(rmfs_core.InputError, match=r"found a file orders\.csv that no run of rmfs has written"):
        rmfs_core.run("examples/small", out=tmp_path)
    assert (tmp_path / "orders.csv").read_text(encoding="utf-8") == "mine"
    for seed in (1, 2):
        rmfs_core.run("examples/small", seed=seed, out=tmp_path / "new")


def test_a_pod_more_than_needed_is_no_error(tmp_path: Path) -> None:
    """A PPS rule may send two pods for one uncovered request: wasteful, not impossible."""
    (tmp_path / "rule.py").write_text(
        "from attrs import define\nfrom rmfs_core import PodTrip, hookimpl\n\n@define\nclass Two:\n"
        "    @hookimpl\n    def select_pods(self, warehouse, max_fetches):\n"
        "        trips, used = [], set()\n"
        "        for station in warehouse.stations:\n"
        "            wanted = {request.sku for request in station.uncovered_requests}\n"
        "            fits = [pod for pod in warehouse.free_pods if wanted & set(pod.contents) and pod.id not in used]\n"
        "            for pod in fits[:2][: max_fetches - len(trips)]:\n"
        "                used.add(pod.id)\n                trips.append(PodTrip(pod.id, station.id))\n"
        "        return trips\n",
        encoding="utf-8",
    )
    (tmp_path / "s.toml").write_text(
        '[instance]\norders = 30\n[rules]\npoa = "pod-match"\npps = "./rule.py:Two"\n', encoding="utf-8"
    )
    assert rmfs_core.run(tmp_path / "s.toml").metrics["orders_completed"] == 30


RECORDER = """
@define
class Recorder:
    file = "acme.txt"

    @hookimpl
    def run_started(self, run):
        (run.out / self.file).write_text("recorded")
"""


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


def test_how_metrics_are_shown_is_checked_before_the_run() -> None:
    """What an observer says of its metrics has to be `Metric`s."""

    class Watching:
        measures = ("legs",)

        @rmfs_core.hookimpl
        def run_started(self) -> None:
            raise AssertionError

    with pytest.raises(rmfs_core.InputError, match=r"class Watching: expected `measures` to be a tuple of .*Metric"):
        rmfs_core.run("examples/small", observers=[Watching()])
