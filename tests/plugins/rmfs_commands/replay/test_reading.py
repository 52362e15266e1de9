"""Reading what a run has recorded, and refusing what is no recorded run."""

from __future__ import annotations

import gzip
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_commands.cli.main import main
from rmfs_commands.replay.reading import read_replay
from rmfs_core import InputError


def test_the_trace_alone(day: Path, tmp_path: Path) -> None:
    """A trace file is enough; there are no metrics then."""
    shutil.copy(day / "trace.jsonl.gz", tmp_path / "other.jsonl.gz")
    found = read_replay(tmp_path / "other.jsonl.gz")
    assert found.metrics == {}
    assert found.name == tmp_path.name


def cut_off(folder: Path) -> None:
    """Take the end of the trace away."""
    file = folder / "trace.jsonl.gz"
    lines = gzip.decompress(file.read_bytes()).splitlines(keepends=True)
    file.write_bytes(gzip.compress(b"".join(lines[:-5])))


def cut_through(folder: Path) -> None:
    """Take the second half of the file away."""
    file = folder / "trace.jsonl.gz"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def other_result(folder: Path) -> None:
    """Put the result of another run beside the trace."""
    file = folder / "result.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    content["scenario"]["rules"]["pps"] = "completes"
    file.write_text(json.dumps(content), encoding="utf-8")


def no_result(folder: Path) -> None:
    """Let the result be something else."""
    (folder / "result.json").write_text("[]", encoding="utf-8")


def other_ids(folder: Path) -> None:
    """Let an event name a pod that is not there."""
    file = folder / "trace.jsonl.gz"
    text = gzip.decompress(file.read_bytes()).decode()
    at = text.index('"e":"trip_decided"')
    file.write_bytes(gzip.compress((text[:at] + text[at:].replace('"pod":', '"pod":9', 1)).encode()))


def other_header(folder: Path) -> None:
    """Let the header have a list for its rules."""
    (folder / "result.json").unlink()
    file = folder / "trace.jsonl.gz"
    header, rest = gzip.decompress(file.read_bytes()).decode().split("\n", 1)
    changed = json.loads(header)
    changed["scenario"]["rules"] = ["nearest"]
    file.write_bytes(gzip.compress(f"{json.dumps(changed)}\n{rest}".encode()))


def test_a_header_that_nothing_has_recorded(day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is only found when the page is made is a sentence, too."""
    shutil.copytree(day, tmp_path, dirs_exist_ok=True)
    other_header(tmp_path)
    with pytest.raises(SystemExit) as stop:
        main(["replay", str(tmp_path)])
    assert stop.value.code == 2
    assert "does not fit together, so that it cannot be shown" in capsys.readouterr().err
    assert not (tmp_path / "replay.html").exists()


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda folder: (folder / "trace.jsonl.gz").unlink(), r"has no trace.jsonl.gz; `rmfs run --trace` records one"),
        (cut_off, r"the trace was cut off here; expected a last line with the event 'end'"),
        (cut_through, r"trace.jsonl.gz, line \d+: the file was cut off here"),
        (other_result, r"another run than trace.jsonl.gz: its rules.pps is 'completes', that of the trace 'demand'"),
        (no_result, "expected a result that rmfs has written, with the key `metrics`"),
        (other_ids, "TripDecided names pod 9"),
    ],
)
def test_what_is_no_recorded_run(day: Path, tmp_path: Path, damage: Callable[[Path], object], sentence: str) -> None:
    """One sentence says what is wrong, and how to get what is missing."""
    shutil.copytree(day, tmp_path, dirs_exist_ok=True)
    damage(tmp_path)
    with pytest.raises(InputError, match=sentence):
        read_replay(tmp_path)
