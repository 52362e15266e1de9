"""Running experiments: rows, what is stored, what is computed again, and runs that fail."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.details.metrics import Metrics
from rmfs_commands.experiments import Experiment, Job, Row, RuleSetChoice, Watcher, run_experiment
from rmfs_commands.experiments.running import open_workers
from rmfs_core.errors import InputError
from rmfs_core.results.catalogue import Metric

pytestmark = pytest.mark.slow

Write = Callable[..., Experiment]
Rows = list[dict[str, Any]]


class Recorder(Watcher):
    """Remembers what it is told."""

    def __init__(self) -> None:
        self.told: list[str] = []
        self.ran: list[str] = []

    def started(self, total: int, stored: int, slots: int) -> None:
        self.told.append(f"started {total} {stored} {slots}")

    def run_dropped(self, job: Job, problem: str) -> None:
        self.told.append(f"dropped {job.rule_set} {job.seed}: {problem}")

    def run_repeated(self, job: Job, problem: str) -> None:
        self.told.append(f"repeated {job.rule_set} {job.seed}: {problem}")

    def run_finished(self, job: Job, row: dict[str, Any]) -> None:
        self.ran.append(job.key)

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
    """Return rows with what is the same on every run."""
    kept = {*Metrics().measured(), "instance", "scenario", "rule_set", "seed", "status", "error", "error_kind", "key"}
    return [{name: value for name, value in row.items() if name in kept} for row in rows]


def test_rows_are_what_single_runs_measure(experiment: Write, folder: Path, tmp_path: Path) -> None:
    """One row a run, in the order of the jobs, with labels, status, every metric and every timing figure."""
    result = run_experiment(experiment(), store=tmp_path / "runs", jobs=1)
    assert [(row["rule_set"], row["seed"]) for row in result.rows] == [
        ("pod-match", 1),
        ("pod-match", 2),
        ("first-come", 1),
        ("first-come", 2),
    ]
    row = result.rows[3]
    alone = rmfs_core.run(folder / "tiny.toml", seed=2, overrides=["rules.poa=first-come"])
    assert {name: row[name] for name in alone.metrics} == alone.metrics
    timing = {"wall_s", "decision_s_first", "decision_s_later", "run_s", "hook_s.assign_orders", "hook_s.plan_path"}
    assert timing <= row.keys()
    assert (row["instance"], row["scenario"], row["status"], row["error"]) == ("tiny", "tiny", "complete", None)
    assert row["run_s"] >= row["wall_s"] > 0
    assert not result.failed
    table = result.table()
    assert table["seed"] == [1, 2, 1, 2]
    assert len({len(column) for column in table.values()}) == 1


def test_each_run_is_stored_under_its_key(experiment: Write, tmp_path: Path) -> None:
    """The store has a folder for each run, named by its key, with the run's files, and nothing else."""
    one = experiment()
    run_experiment(one, store=tmp_path / "runs", jobs=2)
    assert {path.name for path in (tmp_path / "runs").iterdir()} == {job.key for job in one.jobs()}
    files = {path.name for path in (tmp_path / "runs" / one.jobs()[0].key).iterdir()}
    assert {"result.json", "orders.csv", "visits.csv", "periods.csv", "run.json"} <= files


def test_runs_go_seed_by_seed(experiment: Write, tmp_path: Path) -> None:
    """So the first tell how long all take, whatever the rule set."""
    begun: list[tuple[int, str]] = []

    class Following(Watcher):
        def run_started(self, job: Job) -> None:
            begun.append((job.seed, job.rule_set))

    run_experiment(experiment(), store=tmp_path / "runs", jobs=1, watcher=Following())
    assert begun == [(1, "pod-match"), (1, "first-come"), (2, "pod-match"), (2, "first-come")]


def test_the_number_of_workers_changes_nothing(experiment: Write, tmp_path: Path) -> None:
    """One worker and two give the same rows, but for wall-clock figures."""
    one = run_experiment(experiment(), store=tmp_path / "one", jobs=1)
    two = run_experiment(experiment(), store=tmp_path / "two", jobs=2)
    assert without_timing(one.rows) == without_timing(two.rows)


def test_workers_may_serve_one_experiment_after_another(experiment: Write, tmp_path: Path) -> None:
    """They are the caller's to close."""
    opened = open_workers(1)
    with closing(opened):
        first = run_experiment(experiment(), store=tmp_path / "first", workers=opened)
        assert not opened.closed
        again = run_experiment(experiment(), store=tmp_path / "again", workers=opened)
    assert opened.closed
    assert without_timing(first.rows) == without_timing(again.rows)
    assert again.computed == 4


def test_workers_are_closed_when_an_experiment_ends_early(experiment: Write, tmp_path: Path) -> None:
    """Whatever is under way stops with it."""

    class Impatient(Watcher):
        def run_finished(self, job: Job, row: Row) -> None:
            raise KeyboardInterrupt

    opened = open_workers(1)
    with pytest.raises(KeyboardInterrupt):
        run_experiment(experiment(), store=tmp_path / "runs", workers=opened, watcher=Impatient())
    assert opened.closed


def test_what_is_stored_is_not_computed_again(experiment: Write, tmp_path: Path) -> None:
    """More seeds and another rule set add runs; those that are there stay as they are."""
    first = run_experiment(experiment(), store=tmp_path / "runs", jobs=1)
    more = evolve(experiment(), seeds=(1, 2, 3))
    recorder = Recorder()
    second = run_experiment(more, store=tmp_path / "runs", jobs=1, watcher=recorder)
    assert (first.computed, second.computed, len(second.rows)) == (4, 2, 6)
    assert recorder.told == ["started 6 4 1", "ended"]
    assert [row for row in second.rows if row["seed"] < 3] == first.rows
    assert run_experiment(more, store=tmp_path / "runs").computed == 0


def test_equal_rule_sets_are_computed_once(experiment: Write, tmp_path: Path) -> None:
    """Two names for the same rules are two rows of one run."""
    one = experiment()
    twice = evolve(one, rule_sets=(*one.rule_sets, RuleSetChoice("again", {"rules.poa": "first-come"})))
    result = run_experiment(twice, store=tmp_path / "runs", jobs=1)
    assert (len(result.rows), result.computed) == (6, 4)
    again = [row for row in result.rows if row["rule_set"] == "again"]
    assert [{**row, "rule_set": "first-come"} for row in again] == result.rows[2:4]


def test_a_stored_run_that_was_changed_is_computed_again(experiment: Write, tmp_path: Path) -> None:
    """Who watches is told; its row is the one that it had."""
    first = run_experiment(experiment(), store=tmp_path / "runs", jobs=1)
    job = experiment().jobs()[1]
    file = tmp_path / "runs" / job.key / "result.json"
    file.write_text(file.read_text(encoding="utf-8").replace('"picks": ', '"picks": 9', 1), encoding="utf-8")
    recorder = Recorder()
    again = run_experiment(experiment(), store=tmp_path / "runs", jobs=1, watcher=recorder)
    assert recorder.told[0] == f"dropped {job.rule_set} {job.seed}: {file.parent}: is not as it was stored: " + (
        "result.json was changed"
    )
    assert recorder.ran == [job.key]
    assert without_timing(again.rows) == without_timing(first.rows)


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


def test_a_rule_from_a_path_whose_code_changed_is_computed_anew(
    experiment: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its version says nothing, nor is it its own file that changed. With one more seed no row is of the older code."""
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
    assert after.computed == 3
    assert after.rows[0]["key"] == before.rows[0]["key"]
    assert after.rows[2]["distance_m"] != before.rows[1]["distance_m"]
    assert before.rows[1]["key"] not in [row["key"] for row in after.rows]


FAILING = """
base = "tiny.toml"
seeds = [1, 2]
baseline = "good"
[[rule_sets]]
name = "good"
[[rule_sets]]
name = "bad"
rules.pr = { rule = "./bad.py:%s" }
"""


def test_a_run_that_fails_is_a_row_with_its_error(experiment: Write, tmp_path: Path) -> None:
    """A rule that raises fails its own runs; they are stored, since they would end the same way again."""
    one = experiment(FAILING % "Raising")
    result = run_experiment(one, store=tmp_path / "runs", jobs=2)
    assert [row["status"] for row in result.rows] == ["complete", "complete", "failed", "failed"]
    assert result.failed[0]["error_kind"] == "RuleError"
    assert "no idea" in result.failed[0]["error"]
    assert result.failed[0]["picks"] > 0
    assert run_experiment(one, store=tmp_path / "runs").computed == 0


def test_a_run_without_a_result_is_a_row_too(experiment: Write, tmp_path: Path) -> None:
    """Orders that do not fit the station are found only when the run begins; the run is tried again the next time."""
    one = experiment(
        'base = "tiny.toml"\nseeds = [1]\nbaseline = "good"\n[[rule_sets]]\nname = "good"\n'
        '[[rule_sets]]\nname = "narrow"\nstations.item_capacity = 1\nstations.oversize = "refuse"\n'
    )
    result = run_experiment(one, store=tmp_path / "runs", jobs=1)
    assert [row["status"] for row in result.rows] == ["complete", "failed"]
    assert result.rows[1]["error_kind"] == "InputError"
    assert "item_capacity" in result.rows[1]["error"]
    assert result.table()["picks"][1] is None
    assert run_experiment(one, store=tmp_path / "runs", jobs=1).computed == 1


def deadly(folder: Path, deaths: int) -> str:
    """Return an experiment whose rule set "bad" kills its worker so many times."""
    choice = f'{{ rule = "./bad.py:Deadly", counter = "{folder / "count"}", deaths = {deaths} }}'
    return (FAILING % "x").replace('{ rule = "./bad.py:x" }', choice)


def test_a_run_whose_worker_dies_is_repeated_once(experiment: Write, folder: Path, tmp_path: Path) -> None:
    """A worker that is killed is told of, its run is done again, and all rows are there."""
    recorder = Recorder()
    one = evolve(experiment(deadly(folder, 1)), seeds=(1,))
    result = run_experiment(one, store=tmp_path / "runs", jobs=2, watcher=recorder)
    assert [row["status"] for row in result.rows] == ["complete", "complete"]
    assert recorder.told[1:] == ["repeated bad 1: its worker process died with SIGKILL(-9)", "ended"]


def test_a_run_that_always_kills_its_worker_is_given_up(experiment: Write, folder: Path, tmp_path: Path) -> None:
    """Two deaths make a failed row; no other run is lost. The next time it is tried again: it dies once more."""
    one = evolve(experiment(deadly(folder, 3)), seeds=(1,))
    recorder = Recorder()
    result = run_experiment(one, store=tmp_path / "runs", jobs=2, watcher=recorder)
    assert [row["status"] for row in result.rows] == ["complete", "failed"]
    assert "died with SIGKILL(-9); given up" in result.failed[0]["error"]
    assert result.failed[0]["error_kind"] == "WorkerDiedError"
    assert [word[:14] for word in recorder.told[1:-1]] == ["repeated bad 1"]
    again = run_experiment(one, store=tmp_path / "runs", jobs=1)
    assert (again.computed, len(again.failed)) == (1, 0)


def test_inline_rules_can_be_refused(experiment: Write, tmp_path: Path) -> None:
    """Nothing is run when a rule set loads code from a file and that is refused; the files can be named before."""
    one = experiment(FAILING % "Raising")
    assert [Path(file).name for file in one.rule_files()] == ["bad.py"]
    with pytest.raises(InputError, match="--no-inline-rules"):
        run_experiment(one, store=tmp_path / "runs", allow_inline_rules=False)
    assert not (tmp_path / "runs").exists()


def test_means_are_of_complete_runs(experiment: Write, tmp_path: Path) -> None:
    """A run with orders left has no makespan, and its other figures are of a part: its pair is left out and counted."""
    limited = '[[rule_sets]]\nname = "limited"\nrun.until_s = 30\n'
    text = f'base = "tiny.toml"\nseeds = [1, 2]\nbaseline = "whole"\n[[rule_sets]]\nname = "whole"\n{limited}'
    result = run_experiment(experiment(text), store=tmp_path / "runs", jobs=1)
    compared = result.comparison()
    name = compared.instance_sets[-1]
    whole, limited_runs = compared.of(name, "makespan_s")
    assert (whole.pairs, limited_runs.pairs, limited_runs.left_out, limited_runs.mean) == (2, 0, 2, None)
    assert compared.of(name, "picker_utilisation")[1].pairs == 0
    assert [one.partial for one in compared.counted if one.instances == name] == [0, 2]


def test_what_an_observer_measures_is_compared(experiment: Write, folder: Path, tmp_path: Path) -> None:
    """Its figures stand in the rows and are compared, described or not; where a run has none, there is none."""
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


@pytest.mark.parametrize("metric", ["legs_drivn", "seed", "hook_s.plan_path"])
def test_a_metric_that_nobody_measured_is_named(metric: str, experiment: Write, folder: Path, tmp_path: Path) -> None:
    """Where observers measure, what there is is known after a run of each; these runs are kept."""
    (folder / "legs.py").write_text(MEASURING, encoding="utf-8")
    one = experiment(MEASURED.replace("half", metric))
    for _ in range(2):  # the second time from the store
        with pytest.raises(
            InputError, match=f'experiment.toml, line 5, metrics: there is no metric "{metric}"'
        ) as caught:
            run_experiment(one, store=tmp_path / "runs", jobs=1)
        assert f"`{metric}`" not in caught.value.problem  # it is no hint to itself
        assert 2 <= len(list((tmp_path / "runs").iterdir())) < 6
    fixed = run_experiment(evolve(one, metrics=("legs_driven",)), store=tmp_path / "runs", jobs=1)
    assert 0 < fixed.computed <= 4
    assert fixed.comparison().metrics == ("legs_driven",)


def test_a_metric_that_nobody_can_measure_is_named_before_anything_is_run(experiment: Write, tmp_path: Path) -> None:
    """No rule or observer measures: what there is is the kernel's."""
    one = evolve(experiment(), metrics=("pileon",))
    with pytest.raises(InputError, match=r'toml, metrics: there is no metric "pileon" \(did you mean `pile_on`\?\)'):
        run_experiment(one, store=tmp_path / "runs", jobs=1)
    assert not (tmp_path / "runs").exists()


def test_where_every_run_failed_there_is_nothing_to_say_of_metrics(
    experiment: Write, folder: Path, tmp_path: Path
) -> None:
    """The failures are what matters: the comparison has no figures, and complains of none."""
    (folder / "legs.py").write_text(MEASURING, encoding="utf-8")
    text = MEASURED.replace("rules.observers", 'rules.pr = "./bad.py:Raising"\nrules.observers')
    result = run_experiment(
        experiment(text.rpartition("[[rule_sets]]")[0].replace("half", "unheard_of")),
        store=tmp_path / "runs",
        jobs=1,
    )
    assert len(result.failed) == 4
    assert all(one.mean is None for one in result.comparison().paired)


def test_orders_from_a_file_are_the_same_for_every_seed(experiment: Write, tmp_path: Path) -> None:
    """The result says of which instances; drawn ones are none of them."""
    text = 'scenarios = ["examples/from-csv", "tiny.toml"]\nseeds = [1]\nbaseline = "a"\n[[rule_sets]]\nname = "a"\n'
    one = experiment(text + 'rules.pp = "free-flow"\n')
    result = run_experiment(one, store=tmp_path / "runs", jobs=1)
    (day,) = {row["instance"] for row in result.rows if "from-csv" in row["instance"]}
    assert result.fixed == {day}
    assert result.comparison().fixed == (day, "overall")
