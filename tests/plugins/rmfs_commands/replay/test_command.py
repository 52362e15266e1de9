"""`rmfs replay`: what it writes, and what it says."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image, ImageSequence

from rmfs_commands.cli.main import main


def called(*arguments: str) -> int:
    """Return the exit code of a command line."""
    try:
        main(["replay", *arguments])
    except SystemExit as stop:
        return int(stop.code or 0)
    return 0


def test_a_page_beside_the_run(day: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is written into the run's folder, and said to be there."""
    assert called(str(day)) == 0
    page = day / "replay.html"
    assert capsys.readouterr().out == f"Open {page} in a browser.\n"
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    page.unlink()


def test_two_runs_in_a_file_of_ones_own(
    day: Path, short: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both are in it; nothing is said with --quiet."""
    assert called(str(day), str(short), "--out", str(tmp_path / "both.html"), "--quiet") == 0
    assert capsys.readouterr().out == ""
    assert "<title>day and short</title>" in (tmp_path / "both.html").read_text(encoding="utf-8")


def test_pictures_from_a_time_to_another(day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The first is of the first time, the last of the last."""
    assert called(str(day), "--frames", "2", "--from", "60", "--to", "120", "--out", str(tmp_path)) == 0
    assert capsys.readouterr().out == f"2 pictures in {tmp_path}.\n"
    assert sorted(file.name for file in tmp_path.iterdir()) == ["frame-001.png", "frame-002.png"]


def test_a_video(day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Ten seconds at five times the speed are two seconds, and the last picture."""
    file = tmp_path / "x.gif"
    assert called(str(day), "--video", str(file), "--from", "60", "--to", "70", "--speed", "5") == 0
    assert capsys.readouterr().out == f"A video in {file}.\n"
    with Image.open(file) as found:
        assert sum(frame.info["duration"] for frame in ImageSequence.Iterator(found)) == 2100


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("nowhere",), "nowhere: cannot be read"),
        (("DAY", "nowhere"), "nowhere: cannot be read"),
        (("DAY", "--video", "x.webm"), "found the ending '.webm'; expected .gif or .mp4"),
        (("DAY", "--video", "x.gif", "--frames", "3"), "--video: found with --frames; expected one of them"),
        (("DAY", "--video", "x.gif", "--out", "y"), "--out: found with --video x.gif"),
        (("DAY", "--speed", "3"), "--speed: found without --video"),
        (("DAY", "--to", "3"), "--to: found without --frames or --video"),
        (("DAY", "--video", "x.gif", "--speed", "1e-9"), "pictures; expected at most 2,000, by a higher speed or a"),
        (("DAY", "--frames", "3", "--from", "99999"), "--from 99999: the run ends at "),
        (("DAY", "--frames", "3", "--from", "9", "--to", "8"), "--to 8: expected a time from 9 s on"),
        (("DAY", "--out", "DAY"), "cannot be written: a folder has that name"),
    ],
)
def test_what_cannot_be_done(
    day: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], sentence: str
) -> None:
    """One sentence, exit code 2."""
    assert called(*(str(day) if argument == "DAY" else argument for argument in arguments)) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert len(said.splitlines()) == 1
