"""Disks that are full, names that are too long, and other reasons why nothing can be written: nothing is lost."""

import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from calling import exit_code
from cases import cases
from rmfs_commands.reproduction import choose_parts, reproduce
from rmfs_core.errors import InputError
from tiny import TINY, TWO_RULES

COMMANDS = {
    "run": ("run", "tiny.toml", "--out", "out", "--quiet"),
    "recorded": ("run", "tiny.toml", "--out", "out", "--quiet", "--trace"),
    "compare": ("compare", "trial.toml", "--out", "out", "--jobs", "1", "--quiet"),
    "generate": ("generate", "tiny.toml", "--out", "out", "--force"),
}
LIMIT = 100
"""Bytes that a file may have where nothing shall fit: less than any file of results."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.toml").write_text(TINY, encoding="utf-8")
    (tmp_path / "trial.toml").write_text(TWO_RULES, encoding="utf-8")
    return tmp_path


@pytest.fixture
def small_files() -> Iterator[None]:
    hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))


def contents(folder: Path) -> dict[str, bytes]:
    return {file.relative_to(folder).as_posix(): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def is_told(capsys: pytest.CaptureFixture[str], *texts: str) -> None:
    """Check that the last line on standard error is one sentence that holds texts."""
    err = capsys.readouterr().err
    assert "Traceback" not in err
    last = err.splitlines()[-1]
    assert last.startswith("Error: ")
    for text in texts:
        assert text in last


@pytest.mark.parametrize("name", ["run", "recorded", "compare", "generate"])
def test_what_does_not_fit_is_told_and_loses_nothing(name, folder, capsys, request) -> None:
    assert exit_code(*COMMANDS[name]) == 0
    before = contents(folder)
    capsys.readouterr()
    request.getfixturevalue("small_files")
    other = ("--set", "instance.orders=7") if name != "compare" else ()
    if name == "compare":
        text = (folder / "trial.toml").read_bytes().replace(b"[1, 2]", b"[1, 2, 3]")
        (folder / "trial.toml").unlink()
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(text), resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
        (folder / "trial.toml").write_bytes(text)
        before["trial.toml"] = text
    assert exit_code(*COMMANDS[name], *other) in (1, 2)
    is_told(capsys, "File too large")
    assert contents(folder) == before


@pytest.mark.parametrize("name", ["run", "compare", "generate"])
@cases("out text", ("x" * 300, "File name too long"), ("tiny.toml", "expected a folder"), ("tiny.toml/a", "expected"))
def test_where_nothing_can_be_written_is_told_at_once(name, out, text, folder, capsys) -> None:
    before = contents(folder)
    arguments = [out if argument == "out" else argument for argument in COMMANDS[name]]
    assert exit_code(*arguments) == 2
    is_told(capsys, text)
    assert contents(folder) == before


@pytest.mark.parametrize(("out", "text"), [("x" * 300, "File name too long"), ("tiny.toml", "expected a folder")])
def test_a_reproduction_that_cannot_be_kept_is_not_begun(out: str, text: str) -> None:
    with pytest.raises(InputError, match=text):
        reproduce(choose_parts(("examples",)), Path(out), jobs=1)


def test_a_folder_in_place_of_a_file_is_told_before_the_run(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(*COMMANDS["run"]) == 0
    (folder / "out" / "delays.csv").unlink()
    (folder / "out" / "delays.csv").mkdir()
    before = contents(folder)
    assert exit_code(*COMMANDS["run"], "--seed", "2") == 2
    is_told(capsys, "out/delays.csv: cannot be written: a folder has that name")
    assert contents(folder) == before


def test_links_in_the_folder_of_results_are_followed(folder: Path) -> None:
    assert exit_code(*COMMANDS["run"]) == 0
    (folder / "out" / "orders.csv").rename(folder / "elsewhere.csv")
    (folder / "out" / "orders.csv").symlink_to("../elsewhere.csv")
    before = (folder / "elsewhere.csv").read_bytes()
    assert exit_code(*COMMANDS["run"], "--seed", "2") == 0
    assert (folder / "out" / "orders.csv").is_symlink()
    assert (folder / "elsewhere.csv").read_bytes() != before


def test_a_killed_run_leaves_what_was_there_and_the_next_cleans_up(folder: Path) -> None:
    assert exit_code(*COMMANDS["run"]) == 0
    before = contents(folder / "out")
    long = ["run", "tiny.toml", "--out", "out", "--quiet", "--trace", "--set", "instance.orders=2000"]
    with subprocess.Popen([sys.executable, "-c", "from rmfs_commands.cli.main import main; main()", *long]) as process:
        until = time.monotonic() + 60
        while not list((folder / "out").glob(".*/.trace*")):
            assert process.poll() is None
            assert time.monotonic() < until
            time.sleep(0.02)
        process.send_signal(signal.SIGKILL)
    left = contents(folder / "out")
    assert {name: content for name, content in left.items() if not name.startswith(".")} == before
    assert left.keys() != before.keys()
    assert exit_code(*COMMANDS["run"], "--seed", "2") == 0
    assert contents(folder / "out").keys() == before.keys()
    assert not list((folder / "out").glob(".*"))


def test_a_pipe_as_the_file_of_a_state_stays_a_pipe(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert exit_code("run", "tiny.toml", "--out", "out", "--quiet", "--record-decisions") == 0
    os.mkfifo(folder / "pipe")
    with subprocess.Popen(["cat", "pipe"], stdout=subprocess.PIPE) as reader:
        assert exit_code("explain", "out", "--decision", "1", "--state", "pipe") == 0
        assert reader.stdout.read().startswith(b"{")
    assert (folder / "pipe").is_fifo()


@pytest.mark.parametrize("command", ["replay", "validate", "cite", "compare", "run"])
def test_a_name_that_no_file_can_have_is_no_file(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(command, "x" * 300) == 2
    is_told(capsys, "xxx")


def test_a_base_that_no_file_can_have_is_no_scenario(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "trial.toml").write_text(TWO_RULES.replace("tiny.toml", "9" * 400), encoding="utf-8")
    assert exit_code("compare", "trial.toml") == 2
    is_told(capsys, "there is no scenario 999")


def test_links_that_lead_round_are_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "orders.csv").symlink_to(folder / "orders.csv")
    (folder / "pods.csv").write_text("pod,sku,quantity\np,s,\n", encoding="utf-8")
    files = ("--set", "instance.orders_file=orders.csv", "--set", "instance.pods_file=pods.csv")
    assert exit_code("run", "examples/small", *files, "--out", "out", "--quiet") == 2
    is_told(capsys, "orders.csv")
    assert not (folder / "out").exists()
