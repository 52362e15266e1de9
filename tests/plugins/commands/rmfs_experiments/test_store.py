"""Finished runs on disk: there whole, or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_core.errors import InputError
from rmfs_experiments import Experiment
from rmfs_experiments.outcome import Outcome, simulate
from rmfs_experiments.store import RunStore

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

        monkeypatch.setattr("rmfs_experiments.store.write_text", fail)
        with pytest.raises(type(error)):
            runs.save(job, outcome)
        assert list(runs.folder.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "text"), [("result.json", "{"), ("result.json", "[]"), ("run.json", "{}"), ("run.json", None)]
)
def test_a_run_that_was_changed_is_named(experiment: Write, tmp_path: Path, name: str, text: str | None) -> None:
    """The sentence says what to do."""
    job = experiment().jobs()[0]
    runs = RunStore(tmp_path / "runs")
    runs.save(job, simulate(job))
    file = runs.folder / job.key / name
    file.unlink() if text is None else file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        runs.row(job)
    assert str(caught.value) == (
        f"{runs.folder / job.key}: is not as it was stored; delete the folder, and the run is computed again"
    )


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    """A file is in the way."""
    (tmp_path / "runs").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="expected a folder"):
        RunStore(tmp_path / "runs")
