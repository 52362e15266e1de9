"""Compressed files of JSON objects, as recorders write them."""

from pathlib import Path

from rmfs_trace.json_lines import JsonLinesFile, read_json_lines


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
