"""Compressed files of JSON objects, as recorders write them."""

import gzip
import json
from pathlib import Path

import pytest
from attrs import evolve

from rmfs_commands.trace.json_lines import JsonLinesFile, beside_results, read_json_lines
from rmfs_core import InputError
from rmfs_core.info import RunInfo


def test_lines_are_read_as_written(tmp_path: Path) -> None:
    """Equal lines are equal bytes, whatever the name; what is discarded leaves nothing, what is committed stays."""
    for name in ("a.gz", "b.gz"):
        file = JsonLinesFile(tmp_path / name)
        file.write({"x": 1})
        file.write({"y": "ä"})
        file.commit()
        file.discard()
    JsonLinesFile(tmp_path / "c.gz").discard()
    assert [line for _, line in read_json_lines(tmp_path / "a.gz")] == [{"x": 1}, {"y": "ä"}]
    assert (tmp_path / "a.gz").read_bytes() == (tmp_path / "b.gz").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.gz", "b.gz"]


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"this is text", "no gzip file"),
        (gzip.compress(json.dumps({"a": "b" * 5000}).encode(), mtime=0)[:-12], "cut off"),
        (None, "cannot be read"),
    ],
)
def test_a_file_that_is_no_such_file(tmp_path: Path, content: bytes | None, problem: str) -> None:
    """Text, half a file and no file are told apart."""
    path = tmp_path / "lines.gz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=problem):
        list(read_json_lines(path))


def test_lines_have_their_place(tmp_path: Path) -> None:
    """Each with its file and number, those before a wrong one too."""
    path = tmp_path / "lines.gz"
    path.write_bytes(gzip.compress(b'{"x": 1}\n{"y": 2}\n[3]\n'))
    lines = read_json_lines(path)
    assert [next(lines)[0], next(lines)[0]] == [f"{path}, line 1", f"{path}, line 2"]
    with pytest.raises(InputError) as caught:
        next(lines)
    assert str(caught.value) == f"{path}, line 3: expected a JSON object, found list"


def test_what_nobody_commits_is_gone(tmp_path: Path) -> None:
    """A file has no name while it is written, and leaves nothing when its writer is gone."""
    file = JsonLinesFile(tmp_path / "lines.gz")
    file.write({"x": 1})
    assert not (tmp_path / "lines.gz").exists()
    del file
    assert list(tmp_path.iterdir()) == []


def test_recorders_write_beside_the_results(tiny: RunInfo, tmp_path: Path) -> None:
    """A run that keeps none is refused."""
    assert beside_results(evolve(tiny, out=tmp_path), "lines.gz") == tmp_path / "lines.gz"
    with pytest.raises(InputError, match=r"^lines.gz: is written beside the results; expected a run with a folder for"):
        beside_results(tiny, "lines.gz")


@pytest.mark.parametrize(("limit", "line"), [("MOST_OF_A_LINE", 2), ("MOST_OF_A_FILE", 3)])
def test_a_file_that_is_larger_than_memory_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limit: str, line: int
) -> None:
    """A small file may hold a line, or lines, of gigabytes; it is read no further."""
    with gzip.open(tmp_path / "large.gz", "wt") as stream:
        stream.write("{}\n" + '{"a": "' + "x" * 90 + '"}\n{"b": 1}\n')
    monkeypatch.setattr(f"rmfs_commands.trace.json_lines.{limit}", {"MOST_OF_A_LINE": 50, "MOST_OF_A_FILE": 105}[limit])
    with pytest.raises(InputError, match=f"large.gz, line {line}: the file is too large to be read; expected at most"):
        list(read_json_lines(tmp_path / "large.gz"))
