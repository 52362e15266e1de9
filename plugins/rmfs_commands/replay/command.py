"""`rmfs replay`: watch a recorded run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_commands.cli.options import NumberRange, WholeNumberRange, quiet_option
from rmfs_commands.cli.screen import tell

if TYPE_CHECKING:
    from rmfs_commands.replay.reading import Replay

PAGE, PICTURES = "replay.html", "frames"
VIDEO_S = 30


@click.command(short_help="Write a recorded run as a page to watch.")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.argument("other", metavar="[OTHER]", required=False, type=click.Path(path_type=Path))
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    metavar="PATH",
    help=f"File of the page, or folder of the pictures. [default: DIR/{PAGE}, DIR/{PICTURES}]",
)
@click.option("--frames", type=WholeNumberRange(1, 10_000), metavar="N", help="Write N pictures (PNG), not a page.")
@click.option(
    "--video", type=click.Path(path_type=Path), metavar="FILE", help="Write a GIF, or an MP4 by ffmpeg, not a page."
)
@click.option("--from", "begin_s", type=NumberRange(min=0), metavar="S", help="Begin pictures at S seconds.")
@click.option("--to", "end_s", type=NumberRange(min=0), metavar="S", help="End pictures at S seconds.")
@click.option(
    "--speed",
    type=NumberRange(min=0, min_open=True),
    metavar="X",
    help=f"Simulated seconds per second of the video. [default: a video of {VIDEO_S} s]",
)
@quiet_option
def replay(
    folder: Path,
    other: Path | None,
    out: Path | None,
    frames: int | None,
    video: Path | None,
    begin_s: float | None,
    end_s: float | None,
    speed: float | None,
    quiet: bool,
) -> None:
    """Write the run in DIR as a page: the warehouse, robots, pods and orders in motion.

    DIR is what `rmfs run --trace --out DIR` wrote, or a trace file. With OTHER, another run, both are shown side by
    side on one clock. The page is one HTML file that needs no network. What was recorded with `--record-decisions` says
    in it why something was done. With `--frames` or `--video` pictures of the run are written, for slides.
    """
    from rmfs_commands.cli.pages import check_target
    from rmfs_commands.replay.page import page
    from rmfs_commands.replay.reading import read_replay
    from rmfs_commands.results.files import write_text
    from rmfs_commands.trace import fitting
    from rmfs_core.errors import InputError

    if frames is not None and video is not None:
        raise InputError("--video", "found with --frames; expected one of them")
    if video is not None:
        from rmfs_commands.replay.video import kind_of

        if out is not None:
            raise InputError("--out", f"found with --video {video}, which says itself where to; expected one of them")
        kind_of(video)  # what cannot be written is said before the trace is read
    elif speed is not None:
        raise InputError("--speed", "found without --video; expected it there alone")
    if frames is None and video is None and (begin_s is not None or end_s is not None):
        option = "--to" if begin_s is None else "--from"
        raise InputError(option, "found without --frames or --video; expected it with one of them")
    replays = [read_replay(one) for one in (folder, other) if one is not None]
    beside = folder if folder.is_dir() else folder.parent
    with fitting(folder, "shown"):
        if frames is not None:
            target = out or beside / PICTURES
            _frames(replays, target, frames, _span(replays, begin_s, end_s))
            said = f"{frames} picture{'s' if frames > 1 else ''} in {target}."
        elif video is not None:
            _video(replays, video, speed, _span(replays, begin_s, end_s))
            said = f"A video in {video}."
        else:
            target = out or beside / PAGE
            check_target(target)
            write_text(target, page(replays))
            said = f"Open {target} in a browser."
    if not quiet:
        tell(said)


def _span(replays: list[Replay], begin_s: float | None, end_s: float | None) -> tuple[int, int]:
    """Return first and last tick of the pictures."""
    from rmfs_core.clock import to_seconds, to_ticks
    from rmfs_core.errors import InputError

    last = max(replay.tick for replay in replays)
    begin = 0 if begin_s is None else to_ticks(begin_s)
    end = last if end_s is None else to_ticks(end_s)
    for option, value in (("--from", begin), ("--to", end)):
        if value > last:
            raise InputError(f"{option} {to_seconds(value):g}", f"the run ends at {to_seconds(last):g} s")
    if begin > end:
        raise InputError(f"--to {to_seconds(end):g}", f"expected a time from {to_seconds(begin):g} s on")
    return begin, end


def _frames(replays: list[Replay], folder: Path, number: int, span: tuple[int, int]) -> None:
    from rmfs_commands.replay.frames import pictures
    from rmfs_commands.replay.video import PICTURE_WIDTH, write_pictures

    begin, end = span
    ticks = [begin + (end - begin) * i // max(number - 1, 1) for i in range(number)]
    write_pictures(folder, pictures(replays, ticks, PICTURE_WIDTH), number)


def _video(replays: list[Replay], file: Path, speed: float | None, span: tuple[int, int]) -> None:
    from rmfs_commands.replay.frames import pictures
    from rmfs_commands.replay.video import MOST, RATES, WIDTHS, kind_of, write_video
    from rmfs_core.clock import TICKS_PER_S
    from rmfs_core.errors import InputError

    begin, end = span
    kind = kind_of(file)
    step = (end - begin) / (VIDEO_S * RATES[kind]) if speed is None else TICKS_PER_S * speed / RATES[kind]
    number = int(min((end - begin) / step, 1e9)) + 1 if step else 1
    if number > MOST[kind]:
        made = f"makes {number:,} pictures; expected at most {MOST[kind]:,}"
        raise InputError(f"--speed {speed:g}", f"{made}, by a higher speed or a shorter time")
    ticks = (min(round(begin + i * step), end) for i in range(number))
    write_video(file, pictures(replays, ticks, WIDTHS[kind]))
