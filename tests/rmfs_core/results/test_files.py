"""Files appear whole or not at all."""

import json
import os
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from rmfs_core import InputError
from rmfs_core.results.files import (
    AtomicFile,
    clean,
    json_ready,
    output_folder,
    removed_if_empty,
    staged,
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


@pytest.fixture
def small_files() -> Iterator[int]:
    """Let no file grow larger than this."""
    most, hard = 10_000, resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    yield most
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))


@pytest.mark.parametrize("size", [10_001, 1_000_000])  # found out when the file is closed, or while it is written
def test_what_does_not_fit_leaves_the_old_file(tmp_path: Path, small_files: int, size: int) -> None:
    """A sentence names the file."""
    path = tmp_path / "a.txt"
    write_text(path, "old")
    with pytest.raises(InputError) as caught:
        write_text(path, "x" * size)
    assert str(caught.value) == f"{path}: cannot be written: File too large"
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_is_followed(tmp_path: Path) -> None:
    """The file that it leads to is replaced, or made; the link stays."""
    (tmp_path / "there").mkdir()
    for name in ("old", "new"):
        (tmp_path / "link").unlink(missing_ok=True)
        (tmp_path / "link").symlink_to(Path("there") / name)
        (tmp_path / "there" / "old").write_text("old")
        write_text(tmp_path / "link", "mine")
        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "there" / name).read_text() == "mine"
    assert {path.name for path in (tmp_path / "there").iterdir()} == {"old", "new"}


def test_a_pipe_is_written_to(tmp_path: Path) -> None:
    """Whoever reads at its end gets the text; it stays a pipe."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    write_text(pipe, "text")
    reader.join(timeout=10)
    assert read == ["text"]
    assert pipe.is_fifo()


def test_a_device_is_written_to() -> None:
    """It is none of our files: nothing takes its place."""
    write_text("/dev/null", "text")
    assert Path("/dev/null").is_char_device()
    with pytest.raises(InputError, match="/dev/full: cannot be written: No space left on device"):
        write_text("/dev/full", "text")


def test_a_name_of_any_length(tmp_path: Path) -> None:
    """The longest that there can be is written; what is longer is told."""
    write_text(tmp_path / ("\N{SNOWMAN}" * 85), "text")
    with pytest.raises(InputError, match="cannot be written: File name too long"):
        write_text(tmp_path / ("x" * 256), "text")


WRITER = """
import sys, time
from pathlib import Path
from rmfs_core.results.files import AtomicFile, staged
folder = Path(sys.argv[1])
with AtomicFile(folder / "file.txt") as stream, staged(folder) as hidden:
    (hidden / "orders.csv").write_text("new")
    print("ready", flush=True)
    time.sleep(60)
"""


def test_what_a_killed_process_has_left_is_cleaned(tmp_path: Path) -> None:
    """Nothing is touched as long as it lives."""
    with subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path)], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        clean(tmp_path)
        assert len(list(tmp_path.iterdir())) == 2
        process.send_signal(signal.SIGKILL)
    (tmp_path / ".mine.part").write_text("mine")
    clean(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".mine.part"]


def test_staged_files_take_their_places_together(tmp_path: Path) -> None:
    """When the block ends well; what is there and is not replaced stays."""
    for name in ("orders.csv", "mine.txt"):
        (tmp_path / name).write_text("old")
    (tmp_path / "link.csv").symlink_to("mine.txt")
    with staged(tmp_path) as hidden:
        for name in ("orders.csv", "link.csv", "sub/more.csv"):
            (hidden / name).parent.mkdir(exist_ok=True)
            (hidden / name).write_text("new")
        assert (tmp_path / "orders.csv").read_text() == "old"
    texts = {path.name: path.read_text() for path in tmp_path.rglob("*") if path.is_file()}
    assert texts == {"orders.csv": "new", "mine.txt": "new", "link.csv": "new", "more.csv": "new"}
    assert (tmp_path / "link.csv").is_symlink()
    with pytest.raises(ZeroDivisionError), staged(tmp_path) as hidden:
        (hidden / "orders.csv").write_text("half")
        raise ZeroDivisionError
    assert (tmp_path / "orders.csv").read_text() == "new"
    assert not list(tmp_path.glob(".*"))


def test_what_was_whole_is_put_in_place_by_the_next(tmp_path: Path) -> None:
    """A process that is killed while files take their places leaves some of them behind."""
    (tmp_path / "orders.csv").write_text("new")
    left = tmp_path / ".files.0123456789ab.whole"
    left.mkdir()
    (left / "result.json").write_text("new")
    clean(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["orders.csv", "result.json"]


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


def test_half_a_character_is_escaped(tmp_path: Path) -> None:
    """A parameter from a file name, say, may have what UTF-8 has not; a run's files are not lost for it."""
    write_text(tmp_path / "a.json", to_json({"name": "a\udc80"}))
    assert json.loads((tmp_path / "a.json").read_text(encoding="utf-8")) == {"name": "a\udc80"}


def test_infinite_parameters_become_texts() -> None:
    """A rule's parameter may be infinite; JSON has no number for that."""
    assert json_ready({"window_s": float("inf"), "list": [1.5, float("-inf")]}) == {
        "window_s": "inf",
        "list": [1.5, "-inf"],
    }


def test_a_new_folder_in_which_nothing_is_left_is_removed(tmp_path: Path) -> None:
    """Also by an interrupt, with those above it; not one that was there before, nor one with a file."""
    old, new, full = tmp_path / "old", tmp_path / "new", tmp_path / "full"
    old.mkdir()
    for folder in (old, new / "newer", full):
        with pytest.raises(KeyboardInterrupt), removed_if_empty(folder):
            output_folder(folder)
            if folder is full:
                (folder / "a").touch()
            raise KeyboardInterrupt
    assert [folder.exists() for folder in (old, new, full)] == [True, False, True]
