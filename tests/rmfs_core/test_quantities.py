"""Ticks, motion, random numbers, and what holds at which time of the day."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases import cases
from rmfs_commands.processes.hours import first_common
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.motion import Motion
from rmfs_core.randomness import stream
from rmfs_core.timetable import DAY, Span, Timetable, read_spans


@pytest.mark.parametrize(("seconds", "ticks"), [(0.0, 0), (2.2, 2200), (0.0004, 0), (0.0006, 1), (1.4142, 1414)])
def test_seconds_are_rounded_to_the_nearest_tick(seconds: float, ticks: int) -> None:
    assert to_ticks(seconds) == ticks


@given(st.integers(0, 100 * 365 * 24 * 3600 * 1000))
def test_no_tick_is_lost_on_the_way_to_seconds_and_back(ticks: int) -> None:
    assert to_ticks(to_seconds(ticks)) == ticks


@cases(
    "metres seconds",
    (1, 2.0),  # triangular: 2 sqrt(1)
    (2, 2 * math.sqrt(2)),
    (2.25, 3.0),  # reaches 1.5 m/s for an instant
    (9, 3 + (9 - 2.25) / 1.5),
)
def test_run_times_of_the_paper(metres: float, seconds: float) -> None:
    """With 1 m/s^2 and 1.5 m/s a run takes 3 + (D - 2.25)/1.5 s from 2.25 m on, and 2 sqrt(D) s below."""
    assert Motion().run_s(metres) == pytest.approx(seconds)


def test_turns_go_the_shorter_way() -> None:
    """A quarter turn takes a quarter of the full turn's 2.5 s, in either direction; half a turn twice that."""
    motion = Motion()
    assert [motion.turn_ticks(0, heading) for heading in range(4)] == [0, 625, 1250, 625]
    assert motion.turn_ticks(3, 0) == 625


@given(acceleration=st.floats(0.1, 5), speed=st.floats(0.1, 5), metres=st.integers(1, 100), parts=st.integers(2, 40))
def test_positions_follow_the_speed_profile(acceleration: float, speed: float, metres: int, parts: int) -> None:
    motion = Motion(acceleration_m_per_s2=acceleration, top_speed_m_per_s=speed)
    total = motion.run_s(metres)
    times = [total * i / parts for i in range(parts + 1)]
    positions = [motion.position_m(metres, time) for time in times]
    assert (positions[0], positions[-1]) == (0, pytest.approx(metres))
    for before, after in pairwise(positions):
        assert -1e-9 <= after - before <= speed * total / parts + 1e-9


def test_every_name_has_a_stream() -> None:
    draws = stream(1, "orders").random(5).tolist()
    assert draws == stream(1, "orders").random(5).tolist()
    assert draws != stream(1, "pods").random(5).tolist()
    assert draws != stream(2, "orders").random(5).tolist()
    assert stream(1, "rule x\udcff").random() != stream(1, "rule x").random()


MINUTE = 60_000
HOUR = 60 * MINUTE


def timetable(*spans: Span, most: int | None = None, zero: int = 0) -> Timetable:
    return Timetable(read_spans(spans, most), zero)


def test_spans() -> None:
    hours = timetable(("06:00", "22:00"))
    at = [6 * HOUR - 1, 6 * HOUR, 22 * HOUR - 1, 22 * HOUR, DAY + 6 * HOUR]
    assert [hours.at(tick) for tick in at] == [0, 1, 1, 0, 1]
    assert (hours.next_change(0), hours.next_change(6 * HOUR)) == (6 * HOUR, 22 * HOUR)
    assert hours.next_change(22 * HOUR) == DAY + 6 * HOUR
    night = timetable(("22:00", "06:00"))
    assert [night.at(hour * HOUR) for hour in (0, 5, 6, 21, 22, 24, 30)] == [1, 1, 0, 0, 1, 1, 0]
    hours = timetable(("06:00", "18:00"), ("18:00", "06:00", 3), ("18:00", "20:00", 5), most=8)
    assert [hours.at(hour * HOUR) for hour in (5, 6, 17, 18, 19, 20)] == [3, 8, 8, 5, 5, 3]
    assert hours.next_change(17 * HOUR) == 18 * HOUR
    assert timetable(("06:00", "14:00"), ("14:00", "22:00")).next_change(6 * HOUR) == 22 * HOUR
    assert timetable(("00:00", "24:00")).next_change(0) is None
    assert timetable(("22:00", "06:00"), ("06:00", "22:00")).next_change(5) is None
    hours = timetable(("06:00", "22:00"), zero=5 * HOUR + 30 * MINUTE)
    assert (hours.at(0), hours.next_change(0)) == (0, 30 * MINUTE)
    assert timetable(("22:00", "06:00", 9), most=8).at(0) == 8


@pytest.mark.parametrize("seed", range(20))
def test_between_changes_nothing_changes(seed: int) -> None:
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


@cases(
    "span",
    *(("06:00",), ("6:00", "22:00"), ("06:00", "24:01"), ("06:60", "22:00"), ("06:00", "06:00"), ("06:00", 22)),
    *(("06:00", "22:00", "x"), ("06:00", "22:00", -1), ("06:00", "22:00", 1, 1), ()),
)
def test_what_is_no_span_is_told(span: Span) -> None:
    expected = r'expected spans of two times .*"06:00", "22:00".* whole number >= 0; found \['
    with pytest.raises(ValueError, match=expected):
        read_spans([span], 8)


def test_stations_have_no_number() -> None:
    with pytest.raises(ValueError, match=r"two times of the day that differ, .*; found \['06:00', '07:00', 1\]"):
        read_spans([("06:00", "07:00", 1)])


@cases(
    "stations robots first",
    ([timetable(("06:00", "10:00"))], [timetable(("10:00", "06:00"), most=4)], None),
    ([timetable(("06:00", "10:00")), timetable(("22:00", "02:00"))], [timetable(("01:00", "03:00"))], HOUR),
    ([timetable(("06:00", "10:00"), zero=8 * HOUR)], [timetable(("05:00", "07:00"), zero=8 * HOUR)], 22 * HOUR),
)
def test_when_one_of_each_is_there_first(stations: list[Timetable], robots: list[Timetable], first: int | None) -> None:
    assert first_common(stations, robots) == first
