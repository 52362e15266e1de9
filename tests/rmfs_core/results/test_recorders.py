"""Recorders: which files are theirs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import rmfs_core
from rmfs_core.errors import InputError
from rmfs_core.results.recorders import load_recorder

RECORDER = """
@define
class Recorder:
    file = {file!r}

    @hookimpl
    def run_started(self, run):
        (run.out / self.file).write_text("recorded")
"""
GROUP = "rmfs.recorders"
Install = Callable[..., None]


@pytest.mark.parametrize(
    "file",
    ["", ".", "..", "../up.txt", "/tmp.txt", "a/b.txt", "a/", ".hidden", "nul\0.txt", "a" * 300, "Orders.csv", 3],
)
def test_a_recorder_names_one_plain_file(file: object, install: Install) -> None:
    """Anything else is refused: it could be a folder, elsewhere, too long, or a file of the results."""
    install("acme", {"acme-log": "acme_log:Recorder"}, group=GROUP, acme_log=RECORDER.format(file=file))
    with pytest.raises(InputError, match=r'recorder "acme-log" \(acme 1.0\) is no recorder: expected a class with'):
        load_recorder("acme-log")


def test_two_recorders_of_one_file_are_not_switched_on_together(install: Install, tmp_path: Path) -> None:
    """One would replace what the other wrote."""
    install("acme", {"acme-log": "acme_log:Recorder"}, group=GROUP, acme_log=RECORDER.format(file="trace.jsonl.gz"))
    expected = (
        r'recorder "trace" \(rmfs .*\) and recorder "acme-log" \(acme 1.0\) write the same file, trace.jsonl.gz; '
    )
    with pytest.raises(InputError, match=expected):
        rmfs_core.run("examples/small", out=tmp_path / "out", record=["trace", "acme-log"])
    assert not (tmp_path / "out").exists()


def test_a_file_that_no_run_has_written_is_left_alone(install: Install, tmp_path: Path) -> None:
    """Neither deleted nor replaced; among the results of an earlier run it is a recorder's."""
    install("acme", {"acme-log": "acme_log:Recorder"}, group=GROUP, acme_log=RECORDER.format(file="notes.txt"))
    mine = tmp_path / "out" / "notes.txt"
    mine.parent.mkdir()
    mine.write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"found a file notes\.txt that no run of rmfs has written"):
        rmfs_core.run("examples/small", out=mine.parent, record=["acme-log"])
    rmfs_core.run("examples/small", overrides=["instance.orders=2"], out=mine.parent)
    assert mine.read_text(encoding="utf-8") == "mine"
    rmfs_core.run("examples/small", overrides=["instance.orders=2"], out=mine.parent)
    assert not mine.exists()
