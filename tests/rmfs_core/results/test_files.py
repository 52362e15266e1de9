"""Files appear whole or not at all."""

import os
from pathlib import Path

import numpy as np
import pytest

from rmfs_core import InputError
from rmfs_core.results.files import (
    AtomicFile,
    json_ready,
    output_folder,
    to_csv,
    to_json,
    write_text,
)

not_root = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="permissions do not hold the superuser"
)


def test_a_file_is_replaced_as_a_whole(tmp_path: Path) -> None:
    """Writing again replaces what was there and leaves nothing beside it."""
    path = tmp_path / "a.txt"
    write_text(path, "first\n")
    write_text(path, "sec\u00f6nd\n")
    assert path.read_bytes() == "sec\u00f6nd\n".encode()
    assert list(tmp_path.iterdir()) == [path]


def test_an_error_while_writing_leaves_the_old_file(tmp_path: Path) -> None:
    """What was written before the error is gone, and the file of that name is as it was."""
    path = tmp_path / "a.txt"
    write_text(path, "old")
    with pytest.raises(ZeroDivisionError), AtomicFile(path) as stream:
        stream.write(b"half")
        raise ZeroDivisionError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_the_new_file_is_not_there_before_it_is_whole(tmp_path: Path) -> None:
    """While it is written, a reader sees the old content."""
    path = tmp_path / "a.txt"
    write_text(path, "old")
    with AtomicFile(path) as stream:
        stream.write(b"new")
        stream.flush()
        assert path.read_text() == "old"
    assert path.read_text() == "new"


def test_a_name_that_a_folder_has(tmp_path: Path) -> None:
    """A file cannot take a folder's name; nothing is left beside it."""
    (tmp_path / "a").mkdir()
    with pytest.raises(InputError, match="a folder has that name"):
        write_text(tmp_path / "a", "text")
    assert list(tmp_path.iterdir()) == [tmp_path / "a"]


def test_a_folder_that_is_missing(tmp_path: Path) -> None:
    """The message names the file."""
    with pytest.raises(InputError, match="cannot be written") as caught:
        write_text(tmp_path / "none" / "a.txt", "text")
    assert caught.value.place.endswith("a.txt")


def test_output_folders_are_made(tmp_path: Path) -> None:
    """A folder of several new parts is made, and one that is there is fine."""
    assert output_folder(tmp_path / "a" / "b").is_dir()
    assert output_folder(tmp_path / "a" / "b").is_dir()


@pytest.mark.parametrize("name", ["file", "file/below"])
def test_a_file_where_a_folder_should_be(tmp_path: Path, name: str) -> None:
    """A file in the way is an input error."""
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="expected a folder"):
        output_folder(tmp_path / name)


@not_root
def test_a_folder_that_may_not_be_written_to(tmp_path: Path) -> None:
    """It is refused before anything is run for it."""
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="cannot be written to"):
        output_folder(tmp_path)
    tmp_path.chmod(0o700)


def test_csv_fields() -> None:
    """None is empty, truth values are words, and texts are quoted where they must be."""
    rows = [{"a": None, "b": True, "c": 'x,"y"'}, {"a": 0.1, "b": False, "c": "z"}]
    assert to_csv(["a", "b", "c"], rows) == 'a,b,c\n,true,"x,""y"""\n0.1,false,z\n'


def test_json_takes_what_a_run_may_hold() -> None:
    """Numpy integers become integers; NaN is refused rather than written."""
    assert to_json({"b": np.int64(3), "a": (1, None)}) == '{"b":3,"a":[1,null]}'
    with pytest.raises(ValueError, match="JSON compliant"):
        to_json(float("nan"))


def test_infinite_parameters_become_texts() -> None:
    """A rule's parameter may be infinite; JSON has no number for that."""
    assert json_ready({"window_s": float("inf"), "list": [1.5, float("-inf")]}) == {
        "window_s": "inf",
        "list": [1.5, "-inf"],
    }
