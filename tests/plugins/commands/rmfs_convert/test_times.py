"""Times of order lines: dates, seconds, and tables that mix them."""

from __future__ import annotations

import pytest

from rmfs_convert.times import Clock, ClockError

MARCH = 1_709_251_200_000
"""2024-03-01 00:00 UTC in ticks since 1970."""


@pytest.mark.parametrize(
    ("text", "pattern", "tick"),
    [
        ("0", None, 0),
        ("12.3456", None, 12_346),  # to the tick
        ("2024-03-01", None, MARCH),
        ("2024-03-01T06:05:30", None, MARCH + 21_930_000),
        ("2024-03-01 06:05:30.250", None, MARCH + 21_930_250),
        ("2024-03-01T06:05:30+02:00", None, MARCH + 14_730_000),
        ("2024-03-01T06:05:30Z", None, MARCH + 21_930_000),
        ("01.03.2024 06.05", "%d.%m.%Y %H.%M", MARCH + 21_900_000),
        ("1709251200", "%S", None),  # a pattern is followed, also where the text is a number
        ("1969-12-31T23:59:59", None, -1000),
        ("yesterday", None, None),
        ("", None, None),
        ("-5", None, None),
        ("2024-02-30", None, None),
    ],
)
def test_a_time_is_read(text: str, pattern: str | None, tick: int | None) -> None:
    """ISO 8601 or seconds, or as the pattern says; what is no time is an error of its own."""
    clock = Clock(pattern)
    if tick is None:
        with pytest.raises(ValueError, match=r"."):
            clock.tick(text)
    else:
        assert clock.tick(text) == tick


@pytest.mark.parametrize(
    ("first", "then", "found", "before"),
    [
        ("5", "2024-03-01", "dates without a zone", "seconds"),
        ("2024-03-01", "5", "seconds", "dates without a zone"),
        ("2024-03-01T00:00Z", "2024-03-01", "dates without a zone", "dates with a zone"),
    ],
)
def test_a_table_has_one_kind_of_time(first: str, then: str, found: str, before: str) -> None:
    """Mixed, they could not be put in order."""
    clock = Clock()
    clock.tick(first)
    with pytest.raises(ClockError) as caught:
        clock.tick(then)
    assert str(caught.value) == f"found {found} where the rows before have {before}; expected one kind of time"
    assert clock.tick(first) is not None


def test_what_is_no_time_does_not_settle_the_kind() -> None:
    """A table may begin with a time that cannot be read."""
    clock = Clock()
    with pytest.raises(ValueError, match=r"."):
        clock.tick("tomorrow")
    assert not clock.dated
    assert clock.tick("7") == 7000


def test_days_begin_at_midnight_and_seconds_at_zero() -> None:
    """Midnight itself is its own; texts are in the kind of the table."""
    clock = Clock()
    tick = clock.tick("2024-03-01T06:05:30.5")
    assert clock.dated
    assert clock.midnight_before(tick) == clock.midnight_before(MARCH) == MARCH
    assert clock.midnight_before(MARCH - 1) == MARCH - 86_400_000
    assert clock.iso(MARCH) == "2024-03-01 00:00:00"
    assert clock.iso(tick) == "2024-03-01 06:05:30.500000"
    clock = Clock()
    assert clock.midnight_before(clock.tick("90000")) == 0
    assert clock.iso(12_500) == "12.5 s"
