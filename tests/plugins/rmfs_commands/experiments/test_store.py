"""Finished runs on disk: there whole, or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_commands.experiments import Experiment
from rmfs_commands.experiments.outcome import Outcome, simulate
from rmfs_commands.experiments.store import RunStore
from rmfs_core.errors import InputError

Write = Callable[..., Experiment]


def test_half_a_run_does_not_count(experiment: Write, tmp_path: Path) -> None:
    """What a kill leaves behind while a run is written is not taken for the run."""
    job = experiment().jobs()[0]
    runs = RunStore(tmp_path / "runs")
    half = tmp_path / "runs" / f".{job.key}.0123456789ab.part"
    half.mkdir()
    (half / "result.json").write_text("{", encoding="utf-8")
    assert job not in runs
    runs.save(job, simulate(job))
    assert job in runs
    assert runs.row(job)["status"] == "complete"
    RunStore(tmp_path / "runs")
    assert [path.name for path in runs.folder.iterdir()] == [job.key]


def test_a_run_that_another_process_stored_meanwhile_stays(experiment: Write, tmp_path: Path) -> None:
    """Saving a run that is there already changes nothing and leaves nothing behind."""
    job = experiment().jobs()[0]
    runs = RunStore(tmp_path / "runs")
    runs.save(job, simulate(job))
    before = runs.row(job)
    runs.save(job, simulate(job))
    assert runs.row(job) == before
    assert len(list((tmp_path / "runs").iterdir())) == 1


def test_a_run_is_read_back_as_its_row(experiment: Write, tmp_path: Path) -> None:
    """With its labels, figures, and what is known besides; under the run's key, for who looks there with its name."""
    job = experiment().jobs()[0]
    runs = RunStore(tmp_path / "new" / "runs")
    outcome = simulate(job)
    runs.save(job, outcome)
    row = runs.row(job)
    assert outcome.result is not None
    assert (row["rule_set"], row["seed"], row["key"]) == ("pod-match", 1, job.key)
    assert (row["run_s"], row["picks"]) == (outcome.run_s, outcome.result.metrics["picks"])
    assert json.loads((runs.folder / job.key / "run.json").read_text(encoding="utf-8"))["run"] == str(job)


def test_a_run_without_a_result_is_not_stored(experiment: Write, tmp_path: Path) -> None:
    """There is nothing to keep."""
    job = experiment().jobs()[0]
    runs = RunStore(tmp_path / "runs")
    with pytest.raises(ValueError, match="a run without a result has nothing to be stored"):
        runs.save(job, Outcome(None, "it died", "WorkerDiedError"))
    assert list(runs.folder.iterdir()) == []


def test_what_cannot_be_written_leaves_nothing(
    experiment: Write, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk, or Ctrl-C while a run is written."""
    job = experiment().jobs()[0]
    runs = RunStore(tmp_path / "runs")
    outcome = simulate(job)
    for error in (OSError("no space left"), KeyboardInterrupt()):

        def fail(path: Path, text: str, error: BaseException = error) -> None:
            raise error

        monkeypatch.setattr("rmfs_commands.experiments.store.write_text", fail)
        with pytest.raises(type(error)):
            runs.save(job, outcome)
        assert list(runs.folder.iterdir()) == []


def changed(folder: Path, name: str, text: str | None) -> None:
    """Change a file of a stored run, or delete it: ``/`` tells what is replaced from what takes its place."""
    file = folder / name
    if text is None:
        file.unlink()
    elif "/" in text:
        before, after = text.split("/")
        content = file.read_text(encoding="utf-8")
        assert before in content
        file.write_text(content.replace(before, after, 1), encoding="utf-8")
    else:
        file.write_text(text, encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "text", "problem"),
    [
        ("result.json", "{", ""),
        ("result.json", "[]", ""),
        ("result.json", '"picks": /"picks": 1', ": result.json was changed"),
        ("result.json", '"key": "/"key": "0', ": it is the run 0{key}"),
        ("result.json", '"run.json": "sha256:/"run.json": "sha256:0', ": run.json was changed"),
        ("run.json", "{}", ": run.json was changed"),
        ("run.json", '"run_s": /"run_s": 1', ": run.json was changed"),
        ("run.json", None, ""),
        ("orders.csv", ",/,1", ": orders.csv was changed"),
        ("visits.csv", None, ""),
    ],
)
def test_a_run_that_was_changed_is_noticed(
    experiment: Write, tmp_path: Path, name: str, text: str | None, problem: str
) -> None:
    """Whichever of its files; what is computed again takes its place."""
    job = experiment().jobs()[0]
    runs = RunStore(tmp_path / "runs")
    outcome = simulate(job)
    runs.save(job, outcome)
    changed(runs.folder / job.key, name, text)
    sentence = f"{runs.folder / job.key}: is not as it was stored{problem.format(key=job.key)}"
    assert runs.problem(job) == sentence
    with pytest.raises(InputError) as caught:
        runs.row(job)
    assert str(caught.value) == sentence
    runs.save(job, outcome)
    assert runs.problem(job) is None
    assert [path.name for path in runs.folder.iterdir()] == [job.key]


def test_the_run_of_another_key_is_noticed(experiment: Write, tmp_path: Path) -> None:
    """A folder that was renamed holds what it held."""
    one, other = experiment().jobs()[:2]
    runs = RunStore(tmp_path / "runs")
    runs.save(one, simulate(one))
    (runs.folder / one.key).rename(runs.folder / other.key)
    assert str(runs.problem(other)).endswith(f": is not as it was stored: it is the run {one.key}")


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    """A file is in the way."""
    (tmp_path / "runs").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="expected a folder"):
        RunStore(tmp_path / "runs")
