"""Several files: all of them or none."""

from __future__ import annotations

from pathlib import Path

import pytest

from rmfs_commands.cli.file_writing import write_files
from rmfs_core.errors import InputError


def test_files_are_written_with_their_folders(tmp_path: Path) -> None:
    """The folder is made; what is there is replaced only when asked."""
    write_files(tmp_path / "new", {"a.txt": b"1", "rules/b.py": b"2"}, force=False)
    assert (tmp_path / "new" / "rules" / "b.py").read_bytes() == b"2"
    with pytest.raises(InputError, match=r"new/a.txt: found a file of that name; --force replaces it"):
        write_files(tmp_path / "new", {"a.txt": b"3", "c.txt": b"4"}, force=False)
    assert not (tmp_path / "new" / "c.txt").exists()
    write_files(tmp_path / "new", {"a.txt": b"3"}, force=True)
    assert (tmp_path / "new" / "a.txt").read_bytes() == b"3"


def test_a_folder_in_the_way_is_refused(tmp_path: Path) -> None:
    """Before anything is written."""
    (tmp_path / "a.txt").mkdir()
    with pytest.raises(InputError, match="cannot be written: a folder has that name"):
        write_files(tmp_path, {"b.txt": b"", "a.txt": b""}, force=True)
    assert not (tmp_path / "b.txt").exists()
