"""What a run shows while it goes on."""

import io

import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from rmfs_commands.cli.progress import (
    MOST_SLOTS,
    RISING,
    RISING_ASCII,
    RunCounts,
    RunLines,
    RunPanel,
    Throughput,
    about,
    robots_by_state,
    run_display,
    waits_for,
)
from rmfs_core import hookimpl
from rmfs_core.events import (
    BundleAssigned,
    BundleStored,
    Event,
    ItemPicked,
    OrderCompleted,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.info import RunInfo
from rmfs_core.results.running import run

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
    for text in (
        "1 of 2 (50%)",
        "0:00:21",
        "0 fetch, 0 carry, 0 in line, 2 idle",
        "Pile-on",
        "2.00",
        "Ends in about",
        "0/4",
        "Inbound",
    ):
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


@given(st.lists(st.integers(0, 10_000_000), max_size=60).map(sorted))
def test_every_pick_is_in_the_throughput_once(ticks: list[int]) -> None:
    """However long a run gets, there are few slots, and no pick is lost."""
    throughput = Throughput(slot_s=1)
    for tick in ticks:
        throughput.add(tick)
    assert sum(throughput.picks) == len(ticks)
    assert len(throughput.picks) <= MOST_SLOTS
    assert len(throughput.line(10_000_000, 10, RISING)) in ((0,) if not ticks else range(11))


def test_the_throughput_of_two_minutes_and_an_idle_third() -> None:
    """As high as the most picks of a slot; the figure is that of the last whole slot, or of what there is."""
    throughput = Throughput()
    throughput.add(1000)
    assert throughput.an_hour(30_000) == 120
    assert throughput.line(30_000, 10, RISING) == ""
    throughput.add(61_000)
    throughput.add(62_000)
    assert (throughput.line(185_000, 10, RISING), throughput.an_hour(185_000)) == ("▄█ ", 0)
    assert (throughput.line(125_000, 10, RISING_ASCII), throughput.an_hour(125_000)) == ("=@", 120)


def test_what_stations_wait_for() -> None:
    """Orders, a pod, a robot for it, its way: that of all which is nearest."""
    seen: set[str] = set()

    class Looking:
        @hookimpl
        def run_started(self, run: RunInfo) -> None:
            self.run = run

        @hookimpl
        def on_event(self, event: Event) -> None:
            states = robots_by_state(self.run)
            assert sum(states.values()) == len(self.run.warehouse.robots)
            assert min(states.values()) >= 0
            for station in self.run.warehouse.stations:
                words = waits_for(self.run, station).split()
                seen.add(" ".join(word for word in words if not word.strip(",").isdigit()))

    run("examples/small", overrides=["instance.orders=15", "robots.count=1"], observers=[Looking()])
    assert seen == {"orders", "a pod", "a robot for pod", "pod being fetched", "pod carried", "pod in line"}


class Watching:
    """Observer that keeps what a terminal would show, and what robots were seen doing."""

    def __init__(self) -> None:
        self.panel = RunPanel("day", Console(file=io.StringIO(), force_terminal=True, width=110, height=40))
        self.robots: set[str] = set()
        self.shown: set[str] = set()

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        self.run = run
        self.panel.run_started(run)

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.panel.on_event(event)
        states = robots_by_state(self.run, self.panel.counts.moving)
        assert sum(states.values()) == len(self.run.warehouse.robots)
        self.robots |= {state for state, number in states.items() if number}
        if isinstance(event, BundleStored | BundleAssigned | VisitEnded):
            picture = io.StringIO()
            Console(file=picture, width=110).print(self.panel.picture())
            self.shown |= {" ".join(line.strip("│ \n").split()) for line in picture.getvalue().splitlines()}

    @hookimpl
    def run_ended(self) -> None:
        self.panel.run_ended()


CHARGING = (
    "layout.chargers=1",
    "robots.battery={capacity_wh=70, idle_w=200, charging_w=8000}",
    "rules.idle=charge-when-low",
)


def test_robots_that_charge_rest_move_pods_or_are_off_duty_do_not_fetch() -> None:
    """Each is counted as what it does; a closed station waits for nothing."""
    hours = ("robots.available=[['00:00', '23:00', 3]]", "stations.open={2=[['00:03', '23:00']]}")
    seen = Watching()
    settings = ("instance.orders=40", "rules.pp=free-flow", "rules.move=utility", *CHARGING, *hours)
    run("examples/small", overrides=settings, observers=[seen])
    assert seen.robots >= {"fetch", "carry", "in line", "move pods", "go to rest", "charge", "off duty"}
    assert any(line.startswith("2 ") and line.endswith(" closed") for line in seen.shown)
    assert any(line.startswith("Robots ") and ", 1 off duty, " in line for line in seen.shown)


def test_stations_that_store_are_shown() -> None:
    """With their bundles, and what they wait for; what waits for a station is counted."""
    seen = Watching()
    run("examples/replenished", overrides=["rules.pp=free-flow", "instance.orders=60"], observers=[seen])
    assert any(line.startswith("3 ") and "1/10" in line for line in seen.shown)
    assert any(line.startswith("3 ") and line.endswith(" bundles") for line in seen.shown)
    assert any(" Bundles 0 wait, 4 stored" in f" {line}" for line in seen.shown)
    assert "2 stations, 1 replenishment station, 6 robots" in about(seen.run)
