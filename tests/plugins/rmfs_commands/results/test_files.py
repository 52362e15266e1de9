"""Files appear whole or not at all; what a run took by the clock on the wall."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rmfs_commands.results.figures import TIMING
from rmfs_commands.results.files import (
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
from rmfs_commands.results.timing import timing
from rmfs_core import InputError

not_root = pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write to every file"
)


def test_a_file_is_replaced_as_a_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    write_text(path, "first\n")
    with AtomicFile(path) as stream:
        stream.write("sec\u00f6nd\n".encode())
        stream.flush()
        assert path.read_text() == "first\n"
    assert path.read_bytes() == "sec\u00f6nd\n".encode()
    with pytest.raises(ZeroDivisionError), AtomicFile(path) as stream:
        stream.write(b"half")
        raise ZeroDivisionError
    assert path.read_bytes() == "sec\u00f6nd\n".encode()
    write_text(path, json.dumps({"name": "a\udc80"}, ensure_ascii=False))
    assert json.loads(path.read_text(encoding="utf-8")) == {"name": "a\udc80"}  # half a character is escaped
    assert list(tmp_path.iterdir()) == [path]


def test_what_no_file_can_be_is_named(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    with pytest.raises(InputError, match="a folder has that name"):
        write_text(tmp_path / "a", "text")
    assert list(tmp_path.iterdir()) == [tmp_path / "a"]
    with pytest.raises(InputError, match="cannot be written") as caught:
        write_text(tmp_path / "none" / "a.txt", "text")
    assert caught.value.place.endswith("a.txt")


def test_links_and_devices_are_followed(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    for name in ("old", "new"):
        (tmp_path / "link").unlink(missing_ok=True)
        (tmp_path / "link").symlink_to(Path("there") / name)
        (tmp_path / "there" / "old").write_text("old")
        write_text(tmp_path / "link", "mine")
        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "there" / name).read_text() == "mine"
    assert {path.name for path in (tmp_path / "there").iterdir()} == {"old", "new"}
    write_text("/dev/null", "text")
    assert Path("/dev/null").is_char_device()
    with pytest.raises(InputError, match="/dev/full: cannot be written: No space left on device"):
        write_text("/dev/full", "text")
    write_text(tmp_path / ("\N{SNOWMAN}" * 85), "text")
    with pytest.raises(InputError, match="cannot be written: File name too long"):
        write_text(tmp_path / ("x" * 256), "text")


WRITER = """
import sys, time
from pathlib import Path
from rmfs_commands.results.files import AtomicFile, staged
folder = Path(sys.argv[1])
with AtomicFile(folder / "file.txt") as stream, staged(folder) as hidden:
    (hidden / "orders.csv").write_text("new")
    print("ready", flush=True)
    time.sleep(60)
"""


def test_what_a_killed_process_has_left_is_cleaned(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", WRITER, str(tmp_path)], stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"ready\n"
        clean(tmp_path)
        assert len(list(tmp_path.iterdir())) == 2
        process.send_signal(signal.SIGKILL)
    (tmp_path / ".mine.part").write_text("mine")
    whole = tmp_path / ".files.0123456789ab.whole"  # is put in place
    whole.mkdir()
    (whole / "result.json").write_text("new")
    clean(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [".mine.part", "result.json"]


def test_staged_files_take_their_places_together(tmp_path: Path) -> None:
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


def test_output_folders_are_made_and_empty_ones_removed(tmp_path: Path) -> None:
    for _ in range(2):
        assert output_folder(tmp_path / "a" / "b").is_dir()
    (tmp_path / "file").write_text("")
    for name in ("file", "file/below"):
        with pytest.raises(InputError, match="expected a folder"):
            output_folder(tmp_path / name)
    old, new, full = tmp_path / "old", tmp_path / "new", tmp_path / "full"
    old.mkdir()
    for folder in (old, new / "newer", full):
        with pytest.raises(KeyboardInterrupt), removed_if_empty(folder):
            output_folder(folder)
            if folder is full:
                (folder / "a").touch()
            raise KeyboardInterrupt
    assert [folder.exists() for folder in (old, new, full)] == [True, False, True]


@not_root
def test_a_folder_that_may_not_be_written_to(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="cannot be written to"):
        output_folder(tmp_path)
    tmp_path.chmod(0o700)


def test_csv_fields_and_json() -> None:
    rows = [{"a": None, "b": True, "c": 'x,"y"'}, {"a": 0.1, "b": False, "c": "z"}]
    assert to_csv(["a", "b", "c"], rows) == 'a,b,c\n,true,"x,""y"""\n0.1,false,z\n'
    assert to_json({"b": np.int64(3), "a": (1, None)}) == '{"b":3,"a":[1,null]}'
    with pytest.raises(ValueError, match="JSON compliant"):
        to_json(float("nan"))
    endless = json_ready({"window_s": float("inf"), "list": [1.5, float("-inf")]})
    assert endless == {"window_s": "inf", "list": [1.5, "-inf"]}


ORDERS = [{"completed_s": 40.0}, {"completed_s": 70.0}]


def decided(period: int, seconds: float, time_s: float = 0.0) -> dict[str, Any]:
    return {"period": period, "time_s": time_s, "seconds": seconds}


PERIODS = [decided(1, 2.0), decided(1, 1.0), decided(2, 0.5, time_s=45.0)]


def test_solve_times() -> None:
    found = timing(10.0, 0, 0, 70.0, ORDERS, PERIODS)
    assert (found["decision_s_first"], found["decision_s_later"]) == (3.0, 0.5)
    assert found["decision_s_per_order"] == 0.25
    assert found["decision_percent_of_simulated"] == pytest.approx(100 * 0.5 / 70)
    assert (found["wall_s"], found["simulated_s_per_wall_s"]) == (10.0, 7.0)
    found = timing(10.0, 0, 50, 70.0, ORDERS, [*PERIODS, decided(3, 0.25, time_s=60.0)])
    assert (found["decision_s_first"], found["decision_s_later"]) == (3.0, 0.25)
    assert found["decision_s_per_order"] == 0.25
    assert found["decision_percent_of_simulated"] == 100 * 0.25 / 20
    found = timing(10.0, 0, 0, 100.0, [*ORDERS, {"completed_s": None}], PERIODS)
    assert (found["decision_percent_of_simulated"], found["decision_s_per_order"]) == (0.5, 0.25)
    found = timing(0.0, 0, 0, 0.0, [], [])
    assert {name for name, value in found.items() if value is None} == {
        "simulated_s_per_wall_s",
        "decision_s_per_order",
        "decision_percent_of_simulated",
    }
    assert {metric.name for metric in TIMING} == timing(1.0, 0, 0, 0.0, [], []).keys()
