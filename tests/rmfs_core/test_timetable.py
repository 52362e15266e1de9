"""Timetables: what holds at which time of the day."""

from __future__ import annotations

import numpy as np
import pytest

from rmfs_core.timetable import ALWAYS, DAY, Span, Timetable, first_common, read_spans

MINUTE = 60_000
HOUR = 60 * MINUTE


def timetable(*spans: Span, most: int | None = None, zero: int = 0) -> Timetable:
    """Return the timetable of spans."""
    return Timetable(read_spans(spans, most), zero)


def test_a_span_begins_with_its_first_tick_and_ends_before_its_last() -> None:
    """From 6 to 22, every day."""
    hours = timetable(("06:00", "22:00"))
    at = [6 * HOUR - 1, 6 * HOUR, 22 * HOUR - 1, 22 * HOUR, DAY + 6 * HOUR]
    assert [hours.at(tick) for tick in at] == [0, 1, 1, 0, 1]
    assert hours.next_change(0) == 6 * HOUR
    assert hours.next_change(6 * HOUR) == 22 * HOUR
    assert hours.next_change(22 * HOUR) == DAY + 6 * HOUR


def test_a_span_may_go_past_midnight() -> None:
    """A night shift is one span."""
    night = timetable(("22:00", "06:00"))
    assert [night.at(hour * HOUR) for hour in (0, 5, 6, 21, 22, 24, 30)] == [1, 1, 0, 0, 1, 1, 0]


def test_the_largest_number_counts_where_spans_overlap() -> None:
    """All 8 robots by day, 3 by night, and 5 in the evening, when the night has begun."""
    hours = timetable(("06:00", "18:00"), ("18:00", "06:00", 3), ("18:00", "20:00", 5), most=8)
    assert [hours.at(hour * HOUR) for hour in (5, 6, 17, 18, 19, 20)] == [3, 8, 8, 5, 5, 3]
    assert hours.next_change(17 * HOUR) == 18 * HOUR


def test_spans_that_touch_are_no_change() -> None:
    """A shift takes over from another; a whole day never changes."""
    shifts = timetable(("06:00", "14:00"), ("14:00", "22:00"))
    assert shifts.next_change(6 * HOUR) == 22 * HOUR
    assert timetable(("00:00", "24:00")).next_change(0) is None
    assert timetable(("22:00", "06:00"), ("06:00", "22:00")).next_change(5) is None


def test_a_run_may_begin_at_any_time_of_the_day() -> None:
    """One that begins at half past five sees stations open after half an hour."""
    hours = timetable(("06:00", "22:00"), zero=5 * HOUR + 30 * MINUTE)
    assert (hours.at(0), hours.next_change(0)) == (0, 30 * MINUTE)


@pytest.mark.parametrize("seed", range(20))
def test_between_changes_nothing_changes(seed: int) -> None:
    """Gone through minute by minute, random timetables change when they say, and at no other time."""
    rng = np.random.default_rng(seed)
    times = [f"{minute // 60:02}:{minute % 60:02}" for minute in rng.choice(1440, 2 * (1 + seed % 4), replace=False)]
    spans = [(*times[i : i + 2], int(rng.integers(3))) for i in range(0, len(times), 2)]
    hours = timetable(*spans, most=2, zero=int(rng.integers(1440)) * MINUTE)
    numbers = [hours.at(minute * MINUTE) for minute in range(2 * 1440)]
    changes = [i * MINUTE for i in range(1, len(numbers)) if numbers[i] != numbers[i - 1]]
    found, tick = [], hours.next_change(0)
    while tick is not None and tick < 2 * DAY:
        found.append(tick)
        tick = hours.next_change(tick)
    assert found == changes


@pytest.mark.parametrize(
    "span",
    [
        ("06:00",),
        ("6:00", "22:00"),
        ("06:00", "24:01"),
        ("06:60", "22:00"),
        ("06:00", "06:00"),
        ("06:00", 22),
        ("06:00", "22:00", "x"),
        ("06:00", "22:00", -1),
        ("06:00", "22:00", 1, 1),
        (),
    ],
)
def test_what_is_no_span_is_told(span: Span) -> None:
    """Times of the day that differ, and a number of robots that there are."""
    with pytest.raises(
        ValueError, match=r'expected spans of two times .*"06:00", "22:00".* whole number >= 0; found \['
    ):
        read_spans([span], 8)


def test_no_more_robots_come_than_there_are() -> None:
    """A scenario may be run with fewer robots than its night shift has."""
    assert timetable(("22:00", "06:00", 9), most=8).at(0) == 8


def test_stations_have_no_number() -> None:
    """They are open or not."""
    with pytest.raises(
        ValueError, match=r"two times of the day that differ, such as .*; found \['06:00', '07:00', 1\]"
    ):
        read_spans([("06:00", "07:00", 1)])


@pytest.mark.parametrize(
    ("stations", "robots", "first"),
    [
        ([ALWAYS], [ALWAYS], 0),
        ([timetable(("06:00", "10:00"))], [ALWAYS], 6 * HOUR),
        ([timetable(("06:00", "10:00"))], [timetable(("09:00", "16:00"), most=4)], 9 * HOUR),
        ([timetable(("06:00", "10:00"))], [timetable(("10:00", "06:00"), most=4)], None),
        ([timetable(("06:00", "10:00")), ALWAYS], [timetable(("10:00", "06:00"), most=4)], 0),
        ([ALWAYS], [timetable(("06:00", "10:00", 0), most=4)], None),
        ([timetable(("06:00", "10:00")), timetable(("22:00", "02:00"))], [timetable(("01:00", "03:00"))], HOUR),
        ([timetable(("06:00", "10:00"), zero=8 * HOUR)], [timetable(("05:00", "07:00"), zero=8 * HOUR)], 22 * HOUR),
    ],
)
def test_when_one_of_each_group_is_there_first(
    stations: list[Timetable], robots: list[Timetable], first: int | None
) -> None:
    """From time 0 of the run on, which may be any time of the day; None where they never meet."""
    assert first_common(stations, robots) == first
