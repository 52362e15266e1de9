"""The recorded decisions of a run as columns."""

from __future__ import annotations

import gzip
import json
import shutil
from itertools import accumulate
from pathlib import Path

import pytest

from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.replay.recorded import recorded_decisions
from rmfs_commands.states.recorded import read_recording
from rmfs_core import InputError
from rmfs_core.clock import to_ticks


def test_each_decision_has_what_was_decided(day: Path, replay: Replay) -> None:
    """When, who, how many orders it saw, and each thing that was decided."""
    columns = replay.decisions
    assert columns is not None
    recorded = list(read_recording(day))
    assert list(accumulate(columns["tick"])) == [to_ticks(one.time_s) for one in recorded]
    assert [columns["texts"][text] for text in columns["rule"]] == [one.rule for one in recorded]
    assert [columns["texts"][text] for text in columns["decides"]] == [one.decides.label for one in recorded]
    trips = [(t["pod"], t["station"]) for one in recorded for t in (one.decision or {}).get("trips", ())]
    pods, stations = replay.start.instance.pods, replay.start.stations
    assert trips == [
        (pods[one].name, stations[other]["name"])
        for what, one, other in zip(columns["what"], columns["one"], columns["other"], strict=True)
        if what == 1
    ]
    assert columns["backlog"][0] == 20
    assert columns["backlog"][-1] == 0


def test_bundles_rests_and_moves(restocked: Path) -> None:
    """Who stores what where, who rests where, and which pods are carried elsewhere; of bundles, how many wait."""
    replay = read_replay(restocked)
    columns, names = replay.decisions, replay.columns.bundles()
    assert columns is not None
    parts = list(zip(columns["what"], columns["one"], columns["other"], strict=True))
    pods = {pod.name: i for i, pod in enumerate(replay.start.instance.pods)}
    recorded = [one.decision or {} for one in read_recording(restocked)]
    bundles = [(names.index(b["bundle"]), int(b["station"]) - 1) for one in recorded for b in one.get("bundles", ())]
    stores = [(names.index(b["bundle"]), pods[b["pod"]]) for one in recorded for b in one.get("stores", ())]
    rests = [(int(r["robot"]) - 1, r["cell"]) for one in recorded for r in one.get("rests", ())]
    moves = [(pods[m["pod"]], m["cell"]) for one in recorded for m in one.get("moves", ())]
    for what, expected in ((3, bundles), (4, stores), (5, rests), (6, moves)):
        assert [(one, other) for code, one, other in parts if code == what] == expected != []
    labels = [columns["texts"][text] for text in columns["decides"]]
    waiting = [n for label, n in zip(labels, columns["backlog"], strict=True) if label == "ROA"]
    assert min(waiting) >= 1


def test_nothing_recorded(short: Path) -> None:
    """A run without recorded decisions is shown without."""
    assert read_replay(short).decisions is None


def test_decisions_of_another_run(day: Path, tmp_path: Path, replay: Replay) -> None:
    """What names an order that the trace does not have is of another run."""
    shutil.copytree(day, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "decisions.jsonl.gz"
    lines = gzip.decompress(file.read_bytes()).decode().splitlines()
    changed = json.loads(lines[1])
    changed["decision"]["assignments"][0]["order"] = "none of these"
    lines[1] = json.dumps(changed)
    file.write_bytes(gzip.compress("\n".join(lines).encode()))
    with pytest.raises(InputError, match="line 2: is no decision of the run that the trace tells of"):
        recorded_decisions(tmp_path, replay.start)
