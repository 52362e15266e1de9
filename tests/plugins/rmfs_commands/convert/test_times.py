"""Times of one table: of one kind, by one clock."""

from __future__ import annotations

import time
from zoneinfo import ZoneInfo

import pytest

from rmfs_commands.convert.time_formats import Moment
from rmfs_commands.convert.times import Clock, ClockError, offset
from rmfs_core.errors import InputError

MARCH = 1_709_251_200_000
"""2024-03-01 00:00 UTC in ticks since 1970."""
DATES = "dates without an offset"


@pytest.mark.parametrize(
    ("first", "then", "found", "before"),
    [
        ("5", "2024-03-01", DATES, "seconds"),
        ("2024-03-01", "5", "seconds", DATES),
        ("2024-03-01T00:00Z", "2024-03-01", DATES, "dates with an offset"),
    ],
)
def test_a_table_has_one_kind_of_time(first: str, then: str, found: str, before: str) -> None:
    """Mixed, they could not be put in order."""
    clock = Clock()
    clock.read(first)
    with pytest.raises(ClockError) as caught:
        clock.read(then)
    assert str(caught.value) == f"found {found} where the rows before have {before}; expected one kind of time"
    assert clock.read(first) is not None


def test_what_is_no_time_does_not_settle_the_kind() -> None:
    """A table may begin with a time that cannot be read."""
    clock = Clock()
    with pytest.raises(ValueError, match=r"."):
        clock.read("tomorrow")
    assert not clock.dated
    assert clock.read("7") == Moment(7000)


@pytest.mark.parametrize(
    ("text", "midnight", "shown"),
    [
        ("2024-03-01T06:05:30.5", MARCH, "2024-03-01T00:00:00"),
        ("2024-03-01", MARCH, "2024-03-01T00:00:00"),
        ("2024-02-29T23:59:59.999", MARCH - 86_400_000, "2024-02-29T00:00:00"),
        ("2024-03-01T00:30+02:00", MARCH - 7_200_000, "2024-03-01T00:00:00+02:00"),
        ("2024-02-29T23:30-03:30", MARCH - 86_400_000 + 12_600_000, "2024-02-29T00:00:00-03:30"),
        ("90000", 0, "0 s"),
    ],
)
def test_days_begin_at_midnight_of_their_own_clock(text: str, midnight: int, shown: str) -> None:
    """Seconds begin at 0; texts are of the kind of the table."""
    clock = Clock()
    found = clock.midnight_before(clock.read(text))
    assert (found.tick, clock.iso(found)) == (midnight, shown)


def test_times_as_text() -> None:
    """Fractions only where there are some; times of the day without a date."""
    clock = Clock()
    assert clock.iso(clock.read("12.5")) == "12.5 s"
    clock = Clock("%H:%M")
    assert clock.iso(clock.read("06:05")) == "06:05:00"
    assert clock.of_day
    assert offset(-12_600_000) == "-03:30"
    assert offset(1_172_000) == "+00:19:32"


@pytest.mark.parametrize(
    ("pattern", "row", "text", "tick"),
    [
        (None, "2024-03-05", "2024-03-01T06:00", MARCH + 21_600_000),
        ("%d.%m.%Y", "05.03.2024", "01.03.2024", MARCH),
        ("%d.%m.%Y", "05.03.2024", "2024-03-01", MARCH),
        (None, "2024-03-05T06:00Z", "2024-03-01T02:00+02:00", MARCH),
        (None, "700", "60", 60_000),
        (None, "2024-03-05 060000", "20240301", MARCH),
        ("%Y%m%d %H%M%S", "20240305 060000", "20240301", MARCH),
    ],
)
def test_a_time_of_an_option(pattern: str | None, row: str, text: str, tick: int) -> None:
    """Written as in the table, or in ISO 8601."""
    clock = Clock(pattern)
    clock.read(row)
    assert clock.option("--from", text).tick == tick


@pytest.mark.parametrize(
    ("row", "text", "problem"),
    [
        ("2024-03-05", "5", f'found "5", but the times of the table are {DATES}; expected'),
        ("2024-03-05", "2024-03-01T06Z", f'found "2024-03-01T06Z", but the times of the table are {DATES}; expected'),
        ("2024-03-05T00:00Z", "2024-03-01", 'found "2024-03-01", but the times of the table are dates with an offset;'),
        ("7", "2024-03-01", 'found "2024-03-01", but the times of the table are seconds; expected'),
        ("7", "noon", 'found "noon"; expected a time such as 2024-03-01T06:00, or as --time-format has it'),
        ("7", "1900-01-01", 'found "1900-01-01"; expected a time such as 2024-03-01T06:00, or as --time-format has it'),
    ],
)  # fmt: skip
def test_a_time_of_another_kind_than_the_table_is_refused(row: str, text: str, problem: str) -> None:
    """With what was expected."""
    clock = Clock()
    clock.read(row)
    with pytest.raises(InputError) as caught:
        clock.option("--from", text)
    assert str(caught.value).startswith(f"--from: {problem}")


@pytest.mark.parametrize("machine", ["UTC", "America/New_York", "Asia/Kolkata"])
def test_the_machine_has_no_time_zone(monkeypatch: pytest.MonkeyPatch, machine: str) -> None:
    """What is read depends on the table and on the options alone."""
    monkeypatch.setenv("TZ", machine)
    time.tzset()
    try:
        assert Clock().read("2024-03-01T06:00") == Moment(MARCH + 21_600_000)
        assert Clock("%d.%m.%Y").read("01.03.2024") == Moment(MARCH)
        assert Clock("unix").read("1709251200") == Moment(MARCH)
        assert Clock(None, ZoneInfo("Asia/Tokyo")).read("2024-03-01T09:00") == Moment(MARCH, 32_400_000)
    finally:
        monkeypatch.undo()
        time.tzset()


def test_numbers_without_a_format_are_counted() -> None:
    """Those that are said to be seconds are not."""
    clock = Clock()
    clock.read("20240229")
    assert clock.numbers.question() is not None
    clock = Clock("seconds")
    clock.read("20240229")
    assert clock.numbers.question() is None


def test_an_offset_of_an_option_is_kept() -> None:
    """Time 0 may have the clock after a change, so that hours of the day are those of the shifts of that day."""
    clock = Clock("%Y%m%d %H%M%S", ZoneInfo("Europe/Berlin"))
    first = clock.read("20241027 003000")
    start = clock.option("--start", "2024-10-26T23:00+01:00")
    assert clock.iso(start) == "2024-10-26T23:00:00+01:00"
    assert (first.tick - start.tick, clock.iso(first)) == (1_800_000, "2024-10-27T00:30:00+02:00")
    assert clock.option("--start", "2024-10-27").tick == start.tick


def test_offsets_of_a_zone_are_not_the_tables() -> None:
    """What would be right is a date as the table has it."""
    clock = Clock(None, ZoneInfo("Europe/Berlin"))
    clock.read("2024-10-27T06:00")
    with pytest.raises(InputError) as caught:
        clock.option("--from", "21600")
    assert str(caught.value) == (
        '--from: found "21600", but the times of the table are dates; '
        "expected one of that kind, such as 2024-03-01T06:00"
    )
