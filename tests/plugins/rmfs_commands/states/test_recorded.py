"""Recorded decisions, read back one after another."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from pathlib import Path
from shutil import copytree
from typing import Any

import pytest

from rmfs_commands.states import Recording, read_recording
from rmfs_commands.states.recording import RECORDING_FILE
from rmfs_core.errors import InputError


@pytest.fixture
def damaged(record: Callable[..., Recording], tmp_path: Path) -> Callable[..., Path]:
    """Return a function that writes the lines of a recording, changed, to another folder."""

    def write(change: Callable[[list[dict[str, Any]]], list[Any]]) -> Path:
        file = record().file
        folder = copytree(file.parent, tmp_path / "run", dirs_exist_ok=True)
        lines = [json.loads(line) for line in gzip.decompress(file.read_bytes()).decode().splitlines()]
        text = "".join(f"{json.dumps(line)}\n" for line in change(lines))
        (folder / RECORDING_FILE).write_bytes(gzip.compress(text.encode()))
        return folder

    return write


def test_decisions_are_gone_through_in_order(record: Callable[..., Recording]) -> None:
    """Numbered from 1, time and period never going back; again and again from the first."""
    recording = record()
    found = list(recording)
    assert [one.number for one in found] == list(range(1, len(found) + 1))
    assert [one.time_s for one in found] == sorted(one.time_s for one in found)
    assert [one.period for one in found] == sorted(one.period for one in found)
    assert {one.decides.label for one in found} >= {"POA", "PPS", "PR", "TA"}
    assert [one.content for one in recording] == [one.content for one in found]
    assert found[2].place == f"{recording.file}, line 4"
    assert found[0].state().time_s == found[0].time_s


def test_the_rule_that_decided_is_the_scenarios(record: Callable[..., Recording]) -> None:
    """With its parameters."""
    recording = record()
    for one in recording:
        assert recording.choice_of(one).rule == one.rule


def test_a_file_is_as_good_as_its_folder(record: Callable[..., Recording]) -> None:
    """Both lead to the same decisions."""
    recording = record()
    assert next(iter(read_recording(recording.file))).content == next(iter(recording)).content


def test_a_run_without_recorded_decisions_is_refused(tmp_path: Path) -> None:
    """The sentence says how to have them."""
    with pytest.raises(InputError, match="found no recorded decisions; run the scenario with `--record-decisions`"):
        read_recording(tmp_path)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda header: header | {"format": "other"}, "line 1"),
        (lambda header: header | {"version": 99}, "99"),
        (lambda header: {key: value for key, value in header.items() if key != "state"}, "lacks `scenario` or `state`"),
        (lambda header: header | {"scenario": 5}, "lacks `scenario` or `state`"),
    ],
)
def test_a_header_that_is_none_is_refused(
    damaged: Callable[..., Path], change: Callable[..., Any], problem: str
) -> None:
    """Before any decision is read."""
    with pytest.raises(InputError) as caught:
        read_recording(damaged(lambda lines: [change(lines[0]), *lines[1:]]))
    assert problem in str(caught.value)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda line: line | {"decides": "lunch"}, "no role is called 'lunch'"),
        (
            lambda line: {key: value for key, value in line.items() if key != "rule"},
            "this is no recorded decision: it lacks rule",
        ),
        (lambda line: line | {"change": 5}, "change: expected a JSON object, found 5"),
        (lambda line: line | {"decision": "POA"}, "decision: expected a JSON object, found 'POA'"),
        (lambda line: line | {"rule": ["demand"]}, "line 4, rule: expected a rule's name, found ['demand']"),
        (lambda line: line | {"report": [1]}, "report: expected a JSON object, found [1]"),
        (lambda line: 5, "expected a JSON object, found int"),
    ],
)
def test_a_line_that_is_no_decision_is_named(
    damaged: Callable[..., Path], change: Callable[..., Any], problem: str
) -> None:
    """Those before it are read."""
    recording = read_recording(damaged(lambda lines: [*lines[:3], change(lines[3]), *lines[4:]]))
    found = iter(recording)
    assert [next(found).number, next(found).number] == [1, 2]
    with pytest.raises(InputError) as caught:
        next(found)
    assert "line 4" in str(caught.value)
    assert problem in str(caught.value)
