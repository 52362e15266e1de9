"""What a run shows while it goes on."""

import io

import pytest
from attrs import evolve
from rich.console import Console

from rmfs_cli.progress import RunCounts, RunLines, RunPanel, run_display
from rmfs_core.events import ItemPicked, OrderCompleted, VisitStarted
from rmfs_core.info import RunInfo

HIDE_CURSOR, SHOW_CURSOR, ERASE_LINE = "\x1b[?25l", "\x1b[?25h", "\x1b[1A\x1b[2K"

EVENTS = (
    VisitStarted(1000, 1, robot=0, pod=0, station=1),
    ItemPicked(8000, 1000, 14_000, visit=1, station=1, pod=0, order=0, sku=0),
    ItemPicked(21_000, 14_000, 27_000, visit=1, station=1, pod=0, order=0, sku=1),
    OrderCompleted(21_000, 0),
)


def test_plain_lines_tell_the_same_of_equal_runs(tiny: RunInfo) -> None:
    """One line at the start, one when a further tenth of the orders is complete, one at the end; no wall-clock time."""
    stream = io.StringIO()
    progress = run_display(Console(file=stream, width=20), "a [run]")
    assert isinstance(progress, RunLines)
    progress.run_started(tiny)
    for event in EVENTS:
        progress.on_event(event)
    progress.run_ended(21_000, "partial")
    assert stream.getvalue().splitlines() == [
        "a [run]: 2 orders, 2 SKUs, 2 pods, 2 stations, 2 robots, seed 7",
        " 50 %  0:00:21 simulated, 2 picks, 1.00 visits per order, pile-on 2.00",
        "partial: 1 of 2 orders, 0:00:21 simulated",
    ]


def test_plain_lines_fit_80_columns(tiny: RunInfo) -> None:
    """With 10,000 orders, days of simulated time and a long name, too."""
    stream = io.StringIO()
    progress = RunLines("paper-2000-split-among-stations", Console(file=stream))
    progress.run_started(evolve(tiny, instance=evolve(tiny.instance, orders=tiny.instance.orders * 5000)))
    progress.counts = RunCounts(total=10_000, orders=8999, picks=99_998, visits=99_999, picks_at=[0, 0])
    progress.counts.stopped_early = 1000
    for event in EVENTS[1:2] + EVENTS[3:]:
        progress.on_event(evolve(event, tick=359_999_000))
    progress.run_ended(359_999_000, "complete")
    lines = stream.getvalue().splitlines()
    assert lines == [
        "paper-2000-split-among-stations: 10,000 orders, 2 SKUs, 2 pods, 2 stations, 2",
        "  robots, seed 7",
        " 90 %  99:59:59 simulated, 99,999 picks, 11.11 visits per order, pile-on 1.00",
        "complete: 9,000 of 10,000 orders, 99:59:59 simulated, 1,000 solves stopped early",
    ]
    assert max(map(len, lines)) <= 80


@pytest.mark.parametrize("width", [80, 120])
def test_the_live_display_fits_the_terminal(tiny: RunInfo, width: int) -> None:
    """On a terminal, orders, figures and every station's state are shown without cutting anything off."""
    stream = io.StringIO()
    progress = run_display(Console(file=stream, force_terminal=True, width=width, height=30), "small")
    assert isinstance(progress, RunPanel)
    progress.run_started(tiny)
    for event in EVENTS:
        progress.on_event(event)
    picture = io.StringIO()
    Console(file=picture, width=width).print(progress.picture())
    progress.run_ended()
    shown = picture.getvalue()
    for text in ("1 of 2 (50%)", "0:00:21", "0 busy, 2 idle", "Pile-on", "2.00", "Ends in about", "0/4", "Inbound"):
        assert text in shown
    assert "…" not in shown
    assert max(map(len, shown.splitlines())) <= width


def test_the_live_display_can_be_closed_twice(tiny: RunInfo) -> None:
    """The terminal is given back once, with its cursor and without the panel, whatever ended the run."""
    stream = io.StringIO()
    progress = RunPanel("small", Console(file=stream, force_terminal=True, width=80, height=30))
    progress.run_started(tiny)
    assert (stream.getvalue().count(HIDE_CURSOR), stream.getvalue().count(SHOW_CURSOR)) == (1, 0)
    progress.close()
    given_back = stream.getvalue()
    assert given_back.count(SHOW_CURSOR) == 1
    assert given_back.endswith(ERASE_LINE)
    progress.close()
    assert stream.getvalue() == given_back
