"""Running experiments: in processes or on a cluster, stored, computed again, shown."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import psutil
import pytest
from attrs import define, evolve, field
from rich.console import Console

import rmfs_core
from rmfs_commands.details.metrics import Metrics
from rmfs_commands.experiments import Experiment, Job, Row, RuleSetChoice, Watcher, run_experiment
from rmfs_commands.experiments.experiment import HORIZON_METRICS
from rmfs_commands.experiments.local import LocalWorkers
from rmfs_commands.experiments.progress import ExperimentLines, ExperimentPanel
from rmfs_commands.experiments.running import open_workers
from rmfs_commands.experiments.store import RunStore
from rmfs_core.errors import InputError, RunError
from rmfs_core.results.catalogue import Metric
from tiny import TWO_RULES

Write = Callable[..., Experiment]
Rows = list[dict[str, Any]]


class Recorder(Watcher):
    def __init__(self) -> None:
        self.told: list[str] = []

    def started(self, total: int, stored: int, slots: int) -> None:
        self.told.append(f"started {total} {stored} {slots}")

    def run_repeated(self, job: Job, problem: str) -> None:
        self.told.append(f"repeated {job.rule_set} {job.seed}: {problem}")

    def ended(self) -> None:
        self.told.append("ended")


MEASURING = '''
from attrs import define
from rmfs_core import hookimpl
from rmfs_core.events import RobotMoved
from rmfs_core.results.catalogue import Metric
@define
class Legs:
    """Counts the legs that robots drive; ``seed`` is called like a column of the table."""
    measures = (Metric("legs_driven", "Legs driven", "legs", 1, "Legs of all robots."),)
    driven: int = 0
    @hookimpl
    def on_event(self, event):
        self.driven += isinstance(event, RobotMoved)
    @hookimpl
    def measured(self):
        return {"legs_driven": self.driven, "half": self.driven / 2, "seed": -5.5}
'''
MEASURED = """
base = "tiny.toml"
seeds = [1, 2]
baseline = "watched"
metrics = ["legs_driven", "half"]
[[rule_sets]]
name = "watched"
rules.observers = ["./legs.py:Legs"]
[[rule_sets]]
name = "first-come"
rules.poa = "first-come"
rules.observers = ["./legs.py:Legs"]
[[rule_sets]]
name = "unwatched"
"""


def without_timing(rows: Rows) -> Rows:
    kept = {*Metrics().measured(), "instance", "scenario", "rule_set", "seed", "status", "error", "error_kind", "key"}
    return [{name: value for name, value in row.items() if name in kept} for row in rows]


@pytest.mark.slow
def test_rows_are_what_single_runs_measure(experiment: Write, folder: Path, tmp_path: Path) -> None:
    begun: list[tuple[int, str]] = []

    class Following(Watcher):
        def run_started(self, job: Job) -> None:
            begun.append((job.seed, job.rule_set))

    result = run_experiment(experiment(), store=tmp_path / "runs", jobs=1, watcher=Following())
    assert begun == [(1, "pod-match"), (1, "first-come"), (2, "pod-match"), (2, "first-come")]
    keys = [job.key for job in experiment().jobs()]
    assert {path.name for path in (tmp_path / "runs").glob("*/*")} == {*keys}
    files = {path.name for path in (tmp_path / "runs" / keys[0][:2] / keys[0]).iterdir()}
    assert {"result.json", "orders.csv", "visits.csv", "periods.csv", "run.json"} <= files
    row = result.rows[3]
    alone = rmfs_core.run(folder / "tiny.toml", seed=2, overrides=["rules.poa=first-come"])
    assert {name: row[name] for name in alone.metrics} == alone.metrics
    assert (row["instance"], row["scenario"], row["status"], row["error"]) == ("tiny", "tiny", "complete", None)
    assert not result.failed
    table = result.table()
    assert table["rule_set"] == ["pod-match", "pod-match", "first-come", "first-come"]
    assert table["seed"] == [1, 2, 1, 2]
    assert len({len(column) for column in table.values()}) == 1


@pytest.mark.slow
def test_workers_may_serve_one_experiment_after_another(experiment: Write, tmp_path: Path) -> None:
    opened = open_workers(1)
    with closing(opened):
        first = run_experiment(experiment(), store=tmp_path / "first", workers=opened)
        assert not opened.closed
        again = run_experiment(experiment(), store=tmp_path / "again", workers=opened)
    assert opened.closed
    assert without_timing(first.rows) == without_timing(again.rows)
    assert again.computed == 4


@pytest.mark.slow
def test_workers_are_closed_when_an_experiment_ends_early(experiment: Write, tmp_path: Path) -> None:
    class Impatient(Watcher):
        def run_finished(self, job: Job, row: Row) -> None:
            raise KeyboardInterrupt

    opened = open_workers(1)
    with pytest.raises(KeyboardInterrupt):
        run_experiment(experiment(), store=tmp_path / "runs", workers=opened, watcher=Impatient())
    assert opened.closed


@pytest.mark.slow
def test_what_is_stored_is_not_computed_again(experiment: Write, tmp_path: Path) -> None:
    first = run_experiment(experiment(), store=tmp_path / "runs", jobs=1)
    more = evolve(experiment(), seeds=(1, 2, 3))
    recorder = Recorder()
    second = run_experiment(more, store=tmp_path / "runs", jobs=1, watcher=recorder)
    assert (first.computed, second.computed, len(second.rows)) == (4, 2, 6)
    assert recorder.told == ["started 6 4 1", "ended"]
    assert [row for row in second.rows if row["seed"] < 3] == first.rows
    assert run_experiment(more, store=tmp_path / "runs").computed == 0


@pytest.mark.slow
def test_equal_rule_sets_are_computed_once(experiment: Write, tmp_path: Path) -> None:
    one = experiment()
    twice = evolve(one, rule_sets=(*one.rule_sets, RuleSetChoice("again", {"rules.poa": "first-come"})))
    result = run_experiment(twice, store=tmp_path / "runs", jobs=1)
    assert (len(result.rows), result.computed) == (6, 4)
    again = [row for row in result.rows if row["rule_set"] == "again"]
    assert [{**row, "rule_set": "first-come"} for row in again] == result.rows[2:4]


RULE = """
from attrs import define
from rmfs_core import hookimpl
from its_helper import number
@define
class Mine:
    @hookimpl
    def choose_storage_location(self, warehouse):
        return sorted(warehouse.free_storage_locations)[number()]
"""


@pytest.mark.slow
def test_a_rule_from_a_path_whose_code_changed_is_computed_anew(experiment, tmp_path, monkeypatch) -> None:
    path = tmp_path / "path"
    (path / "mine-1.0.dist-info").mkdir(parents=True)
    (path / "mine-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (path / "mine-1.0.dist-info" / "entry_points.txt").write_text("[rmfs.rules]\nmine = its_rule:Mine\n")
    (path / "its_rule.py").write_text(RULE, encoding="utf-8")
    (path / "its_helper.py").write_text("def number():\n    return 0\n", encoding="utf-8")
    monkeypatch.syspath_prepend(path)
    text = 'base = "tiny.toml"\nseeds = {}\nbaseline = "other"\n[[rule_sets]]\nname = "other"\n'
    text += '[[rule_sets]]\nname = "mine"\nrules.pr = "mine"\n'
    before = run_experiment(experiment(text.format("[1]")), store=tmp_path / "runs", jobs=1)
    (path / "its_helper.py").write_text("def number():\n    return -1\n", encoding="utf-8")
    after = run_experiment(experiment(text.format("[1, 2]")), store=tmp_path / "runs", jobs=1)
    assert after.failed == []
    assert (after.computed, after.rows[0]["key"]) == (3, before.rows[0]["key"])
    assert after.rows[2]["distance_m"] != before.rows[1]["distance_m"]
    assert before.rows[1]["key"] not in [row["key"] for row in after.rows]


def deadly(folder: Path, deaths: int) -> str:
    """Return an experiment with a rule set that kills its process so many times."""
    choice = f'{{ rule = "./bad.py:Deadly", counter = "{folder / "count"}", deaths = {deaths} }}'
    return (
        'base = "tiny.toml"\nseeds = [1]\nbaseline = "good"\n[[rule_sets]]\nname = "good"\n'
        f'[[rule_sets]]\nname = "bad"\nrules.pr = {choice}\n'
    )


@pytest.mark.slow
def test_a_run_whose_worker_dies_is_repeated_once(experiment: Write, folder: Path, tmp_path: Path) -> None:
    recorder = Recorder()
    one = experiment(deadly(folder, 1))
    result = run_experiment(one, store=tmp_path / "runs", jobs=2, watcher=recorder)
    assert [row["status"] for row in result.rows] == ["complete", "complete"]
    assert recorder.told[1:] == ["repeated bad 1: its worker process died with SIGKILL(-9)", "ended"]


@pytest.mark.slow
def test_a_run_that_always_kills_its_worker_is_given_up(experiment: Write, folder: Path, tmp_path: Path) -> None:
    """Two deaths make a failed row; no other run is lost. The next time it is tried again: it dies once more."""
    one = experiment(deadly(folder, 3))
    recorder = Recorder()
    result = run_experiment(one, store=tmp_path / "runs", jobs=2, watcher=recorder)
    assert [row["status"] for row in result.rows] == ["complete", "failed"]
    assert "died with SIGKILL(-9); given up" in result.failed[0]["error"]
    assert result.failed[0]["error_kind"] == "WorkerDiedError"
    assert [word[:14] for word in recorder.told[1:-1]] == ["repeated bad 1"]
    again = run_experiment(one, store=tmp_path / "runs", jobs=1)
    assert (again.computed, len(again.failed)) == (1, 0)


def test_runs_that_reach_their_horizon_are_compared(experiment: Write, folder: Path, tmp_path: Path) -> None:
    """Rates are those of the time from the warm-up to the horizon, and what is left is compared without being asked."""
    with (folder / "tiny.toml").open("a", encoding="utf-8") as stream:
        stream.write("\n[run]\nuntil_s = 90\nwarmup_s = 30\n")
    one = experiment()
    assert one.metrics == HORIZON_METRICS
    result = run_experiment(one, store=tmp_path / "runs", jobs=1, bounds=True)
    compared = result.comparison()
    assert {row["status"] for row in result.rows} == {"horizon"}
    assert compared.metrics == (*HORIZON_METRICS, "backlog_end", "open_age_sum_h")
    assert all(one.bound is None and one.pairs == 2 * (one.metric != "turnover_s") for one in compared.paired)
    for row in result.rows:
        assert row["picks_per_hour"] == pytest.approx(row["picks"] * 3600 / 60)
        assert 0 <= row["backlog_end"] <= row["open_orders_end"] <= row["orders_total"] - row["orders_completed"]
        assert row["open_orders_end"] > 0
        assert row["open_age_s"] == row["open_age_max_s"] == 90
        assert row["open_age_sum_h"] == pytest.approx(row["open_orders_end"] * 90 / 3600)


def test_rule_sets_are_measured_over_the_same_time(experiment: Write) -> None:
    one = experiment()
    first, second = one.rule_sets
    limited = evolve(one, rule_sets=(first, evolve(second, changes={**second.changes, "run.until_s": 30.0})))
    with pytest.raises(InputError, match=r'"first-come" on .*`run.until_s` is 30.0, of the first rule set None; ex'):
        limited.jobs()


@pytest.mark.slow
def test_what_an_observer_measures_is_compared(experiment: Write, folder: Path, tmp_path: Path) -> None:
    (folder / "legs.py").write_text(MEASURING, encoding="utf-8")
    one = experiment(MEASURED)
    for computed in (6, 0):  # the second time from the store
        result = run_experiment(one, store=tmp_path / "runs", jobs=1)
        assert result.computed == computed
        first = result.rows[0]
        assert first["legs_driven"] == 2 * first["half"] > 0
        assert (first["seed"], first["metrics.seed"]) == (1, -5.5)
        assert "legs_driven" not in result.rows[-1]
        comparison = result.comparison()
        assert comparison.described("legs_driven").label == "Legs driven"
        assert comparison.described("half") == Metric("half")
        watched, other, unwatched = comparison.of("tiny", "half")
        assert (watched.pairs, other.pairs, unwatched.pairs, unwatched.left_out) == (2, 2, 0, 2)
        assert watched.mean == (result.rows[0]["half"] + result.rows[1]["half"]) / 2
        assert unwatched.mean is None


@pytest.mark.slow
@pytest.mark.parametrize(("metric", "runs"), [("legs_drivn", 2), ("seed", 0)])  # no observer can measure the latter
def test_a_metric_that_nobody_measured_is_named(metric, runs, experiment: Write, folder: Path, tmp_path: Path) -> None:
    (folder / "legs.py").write_text(MEASURING, encoding="utf-8")
    one, there_is_none = experiment(MEASURED.replace("half", metric)), f'line 5, metrics: there is no metric "{metric}"'
    for _ in range(2):  # the second time from the store
        with pytest.raises(InputError, match=there_is_none) as caught:
            run_experiment(one, store=tmp_path / "runs", jobs=1)
        assert f"`{metric}`" not in caught.value.problem  # it is no hint to itself
        assert runs <= len(list((tmp_path / "runs").glob("*/*"))) < (6 if runs else 1)
    fixed = run_experiment(evolve(one, metrics=("legs_driven",)), store=tmp_path / "runs", jobs=1)
    assert 0 < fixed.computed <= 6 - runs
    assert fixed.comparison().metrics == ("legs_driven",)


@pytest.mark.slow
def test_where_every_run_failed_there_is_nothing_to_say_of_metrics(experiment, folder, tmp_path) -> None:
    (folder / "legs.py").write_text(MEASURING, encoding="utf-8")
    text = MEASURED.replace("rules.observers", 'rules.pr = "./bad.py:Raising"\nrules.observers')
    result = run_experiment(
        experiment(text.rpartition("[[rule_sets]]")[0].replace("half", "unheard_of")), store=tmp_path / "runs", jobs=1
    )
    assert len(result.failed) == 4
    assert all(one.mean is None for one in result.comparison().paired)


@pytest.mark.slow
def test_orders_from_a_file_are_the_same_for_every_seed(experiment: Write, tmp_path: Path) -> None:
    text = 'scenarios = ["examples/from-csv", "tiny.toml"]\nseeds = [1]\nbaseline = "a"\n[[rule_sets]]\nname = "a"\n'
    one = experiment(text + 'rules.pp = "free-flow"\n')
    result = run_experiment(one, store=tmp_path / "runs", jobs=1)
    (day,) = {row["instance"] for row in result.rows if "from-csv" in row["instance"]}
    assert result.fixed == {day}
    assert result.comparison().fixed == (day, "overall")


@pytest.mark.slow
def test_what_several_workers_warn_of_is_shown_once(experiment: Write, tmp_path: Path, capfd) -> None:
    for file in (Path(__file__).parents[4] / "scenarios" / "examples").glob("from-csv*"):
        shutil.copy(file, tmp_path)
    text = 'base = "./from-csv.toml"\nseeds = [1, 2]\nbaseline = "a"\n[[rule_sets]]\nname = "a"\n'
    run_experiment(experiment(text), store=tmp_path / "runs", jobs=2)
    (told,) = capfd.readouterr().err.splitlines()
    assert told.endswith("from-csv-orders.csv: ignored `customer`.")


def test_a_killed_helper_of_joblib_is_told_in_a_sentence(experiment, capfd) -> None:
    job = experiment().jobs()[0]
    workers = LocalWorkers(1)
    try:
        assert workers.run(job).result is not None
        for child in psutil.Process().children():
            if "loky.backend.resource_tracker" in " ".join(child.cmdline()):
                child.kill()
        assert workers.run(job).result is not None
    finally:
        workers.close()
    assert capfd.readouterr().err == "A helper process of joblib was killed; it is started anew, and no run is lost.\n"


def test_plain_lines(experiment: Write) -> None:
    console = Console(width=40, force_terminal=False)
    progress = ExperimentLines("trial", console)
    jobs = experiment().jobs()
    with console.capture() as capture:
        progress.started(5, 1, 2)
        progress.run_started(jobs[0])
        progress.run_repeated(jobs[0], "it died")
        progress.run_finished(jobs[0], {"status": "failed", "error": "no idea [of] it"})
        progress.run_started(jobs[1])
        progress.run_finished(jobs[1], {"status": "complete", "simulated_s": 100.0})
        progress.ended()
        progress.bounding(3)
    lines = capture.get().splitlines()
    assert lines[:3] == [
        "trial: 5 runs, 1 of them stored already, 2 at a time",
        "Repeated: tiny, pod-match, seed 1: it died",
        "Failed: tiny, pod-match, seed 1: no idea [of] it",
    ]
    assert lines[3].startswith(" 40 %  2 of 5 runs done, 1 failed, 0 running, - simulated s per s, ")
    assert lines[3].endswith(" left")
    assert lines[4].startswith(" 60 %  3 of 5 runs done, 1 failed, 0 running, ")
    assert lines[5].startswith("3 of 5 runs done, 1 failed, 0 running, ")
    assert lines[6:] == ["trial: bounds of 3 instances and seeds"]


def test_the_live_display(experiment: Write) -> None:
    console = Console(width=100, height=40, force_terminal=True, color_system=None)
    progress = ExperimentPanel("trial", console)
    jobs = experiment().jobs()
    with console.capture() as capture:
        progress.started(40, 10, 4)
        for job in jobs:
            progress.run_started(job)
        progress.run_finished(jobs[0], {"status": "complete", "simulated_s": 100.0})
        progress.run_finished(jobs[1], {"status": "failed", "error": "no idea"})
        console.print(progress.picture())
        progress.ended()
        progress.bounding(3)
    text = capture.get()
    assert text.endswith("trial: bounds of 3 instances and seeds\n")
    assert "12 of 40 (30%)" in text
    assert "2 of 4 at a time" in text
    assert re.search(r"Ends in about +0:0\d:\d\d ", text)
    assert "first-come" in text
    assert "Failed: tiny, pod-match, seed 2: no idea" in text
    assert max(len(line) for line in text.splitlines() if line.startswith("│")) <= 100


LONGER = TWO_RULES.replace("[1, 2]", "{ count = 6 }\naxes = { instance.orders = [100] }")


@define
class Cluster:
    folder: Path
    processes: list[subprocess.Popen[bytes]] = field(factory=list)
    address: str = ""

    def start(self, module: str, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{module}", *arguments]
        with (self.folder / f"{len(self.processes)}.log").open("wb") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder, process_group=0)
        self.processes.append(process)
        return process

    def start_scheduler(self) -> None:
        file = self.folder / "scheduler.json"
        self.start(
            "dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)
        )
        until = time.monotonic() + 60
        while not (file.exists() and '"tcp://' in file.read_text()):
            assert time.monotonic() < until, "the scheduler did not start"
            time.sleep(0.1)
        self.address = file.read_text().partition('"address": "')[2].partition('"')[0]

    def start_worker(self, *arguments: str, threads: int = 1) -> subprocess.Popen[bytes]:
        return self.start("dask_worker", self.address, "--nthreads", f"{threads}", "--no-dashboard", *arguments)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    """Return a scheduler without workers, on this machine alone."""
    folder = tmp_path / "cluster"
    folder.mkdir()
    started = Cluster(folder)
    started.start_scheduler()
    yield started
    for process in started.processes:  # with what a nanny has started
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(timeout=30)


@define
class KillerAfter(Watcher):
    process: subprocess.Popen[bytes]
    runs: int
    done: int = 0

    def run_finished(self, job: Job, row: Row) -> None:
        self.done += 1
        if self.done == self.runs:
            os.kill(self.process.pid, signal.SIGKILL)


@pytest.mark.slow
def test_a_killed_worker_costs_nothing(cluster: Cluster, experiment: Write, tmp_path: Path) -> None:
    workers = [cluster.start_worker("--no-nanny") for _ in range(2)]
    killer = KillerAfter(workers[0], runs=3)
    result = run_experiment(experiment(LONGER), store=tmp_path / "runs", dask=cluster.address, watcher=killer)
    assert workers[0].wait(timeout=30) == -signal.SIGKILL
    assert (len(result.rows), result.failed, result.computed) == (12, [], 12)


@pytest.mark.slow
def test_a_worker_of_several_threads_writes_the_same_bytes(cluster: Cluster, experiment: Write, tmp_path: Path) -> None:
    cluster.start_worker("--no-nanny", threads=4)
    paths = "".join(f'[[rule_sets]]\nname = "{rule}"\nrules.pp = "{rule}"\n' for rule in ("whca-n", "pbs"))
    models = '[[rule_sets]]\nname = "model"\nrules.poa_pps = "split-over-time"\n'
    one = experiment(LONGER + paths + models)
    far = run_experiment(one, store=tmp_path / "cluster-runs", dask=cluster.address)
    near = run_experiment(one, store=tmp_path / "local-runs")
    assert (len(far.rows), far.failed, near.failed) == (30, [], [])
    for job in one.jobs():
        for file in ("orders.csv", "visits.csv"):
            ours, theirs = (RunStore(tmp_path / name).place(job) / file for name in ("cluster-runs", "local-runs"))
            assert ours.read_bytes() == theirs.read_bytes(), (job.rule_set, job.seed, file)


@pytest.mark.slow
def test_a_run_that_kills_every_worker_is_given_up(cluster, experiment, folder, tmp_path) -> None:
    for _ in range(2):
        cluster.start_worker()
    result = run_experiment(experiment(deadly(folder, 99)), store=tmp_path / "runs", dask=cluster.address)
    assert [row["status"] for row in result.rows] == ["complete", "failed"]
    assert "Dask workers died of it" in result.rows[1]["error"]


@pytest.mark.slow
def test_a_killed_scheduler_is_told_in_a_sentence(cluster, experiment, tmp_path, capfd) -> None:
    cluster.start_worker("--no-nanny")
    killer = KillerAfter(cluster.processes[0], runs=2)
    with pytest.raises(RunError, match=f"the Dask scheduler at {cluster.address} is lost; what finished is kept"):
        run_experiment(experiment(LONGER), store=tmp_path / "runs", dask=cluster.address, watcher=killer)
    assert len(list((tmp_path / "runs").glob("*/*"))) >= 2
    assert capfd.readouterr().err == ""


@pytest.mark.slow
def test_a_scheduler_without_workers_is_refused(cluster: Cluster, experiment: Write, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the scheduler has no workers"):
        run_experiment(experiment(), store=tmp_path / "runs", dask=cluster.address)


@pytest.mark.slow
def test_no_scheduler_is_refused(experiment: Write, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no Dask scheduler answers there; expected tcp://host:8786"):
        run_experiment(experiment(), store=tmp_path / "runs", dask="tcp://127.0.0.1:9")
