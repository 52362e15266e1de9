"""How times are written."""

from __future__ import annotations

from zoneinfo import ZoneInfo

import pytest

from rmfs_commands.convert.time_formats import (
    ABSOLUTE,
    LOCAL,
    OF_DAY,
    SECONDS,
    Moment,
    UnusableError,
    checked_pattern,
    guessed,
    reader_of,
)
from rmfs_core.errors import InputError

MARCH = 1_709_251_200_000
"""2024-03-01 00:00 UTC in ticks since 1970."""
HOUR = 3_600_000
BERLIN = ZoneInfo("Europe/Berlin")


@pytest.mark.parametrize(
    ("text", "pattern", "kind", "tick", "ahead"),
    [
        ("0", None, SECONDS, 0, 0),
        ("12.3456", None, SECONDS, 12_346, 0),  # to the tick
        ("12,5", "seconds", SECONDS, 12_500, 0),
        ("2024-03-01", None, LOCAL, MARCH, 0),
        ("2024-03-01 06:05:30.250", None, LOCAL, MARCH + 21_930_250, 0),
        ("2024-03-01T06:05:30+02:00", None, ABSOLUTE, MARCH + 14_730_000, 2 * HOUR),
        ("2024-03-01T06:05:30Z", None, ABSOLUTE, MARCH + 21_930_000, 0),
        ("01.03.2024 06.05", "%d.%m.%Y %H.%M", LOCAL, MARCH + 21_900_000, 0),
        ("2024-03-01 06:00 -0330", "%Y-%m-%d %H:%M %z", ABSOLUTE, MARCH + 34_200_000, -12_600_000),
        ("06:05", "%H:%M", OF_DAY, 21_900_000, 0),
        ("060530", "%H%M%S", OF_DAY, 21_930_000, 0),
        ("20240301", "%Y%m%d", LOCAL, MARCH, 0),
        ("20240301.0", "%Y%m%d", LOCAL, MARCH, 0),
        ("240301", "%y%m%d", LOCAL, MARCH, 0),
        ("45352.25", "spreadsheet", LOCAL, MARCH + 6 * HOUR, 0),
        ("45352,2569444444", "spreadsheet", LOCAL, MARCH + 22_200_000, 0),
        ("1709251200", "unix", ABSOLUTE, MARCH, 0),
        ("1709251200.5", "unix", ABSOLUTE, MARCH + 500, 0),
        ("1709251200500", "unix-ms", ABSOLUTE, MARCH + 500, 0),
    ],
)
def test_a_time_is_read(text: str, pattern: str | None, kind: str, tick: int, ahead: int) -> None:
    """With its kind, and how far its clock is ahead of UTC."""
    assert reader_of(pattern, None)(text) == (kind, Moment(tick, ahead))


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        *((text, None) for text in ("yesterday", "", "-5", "2024-02-30", "1609112200000x", "06:10", "12,5")),
        ("1709251200", "%S"),
        ("2024301", "%Y%m%d"),  # a month of one digit
        ("20240301 11000", "%Y%m%d %H%M%S"),  # 01:10:00 or 11:00:00
        ("2024-03-01", "unix"),
        ("20240230", "%Y%m%d"),
    ],
)
def test_what_is_no_time_is_refused(text: str, pattern: str | None) -> None:
    """As a ValueError of its own."""
    with pytest.raises(ValueError, match=r"^"):
        reader_of(pattern, None)(text)


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("1900-01-01T06:00", None),
        ("9999-12-31", None),
        ("0", "unix"),
        ("0", "spreadsheet"),
        ("99991231", "%Y%m%d"),
    ],
)
def test_what_stands_for_no_time_is_refused(text: str, pattern: str | None) -> None:
    """Years that no order is of."""
    with pytest.raises(UnusableError, match=r"^a time that stands for none \(before 1971 or after 2099\)$"):
        reader_of(pattern, None)(text)


@pytest.mark.parametrize(
    ("text", "hours", "ahead"),
    [
        ("2024-03-31T01:30", 0.5, 1),
        ("2024-03-31T03:30", 1.5, 2),
        ("2024-03-31T03:30+02:00", 1.5, 2),
        ("2024-03-31T01:30Z", 1.5, 2),  # the clock of the zone, not that of the text
        ("2024-10-27T02:30", 5040.5, 2),  # twice: the first
        ("2024-10-27T02:30+01:00", 5041.5, 1),
        ("2024-10-27T03:30", 5042.5, 1),
    ],
)
def test_a_zone_knows_the_days_of_the_clock_change(text: str, hours: float, ahead: int) -> None:
    """Times without an offset are of the zone; all are shown by its clock."""
    kind, moment = reader_of(None, BERLIN)(text)
    assert (kind, moment) == (ABSOLUTE, Moment(1_711_843_200_000 + int(hours * HOUR), ahead * HOUR))


def test_an_hour_that_is_skipped_is_no_time() -> None:
    """No clock of the zone showed it."""
    with pytest.raises(UnusableError, match="a time that the clock skips"):
        reader_of(None, BERLIN)("2024-03-31T02:30")


@pytest.mark.parametrize(
    ("texts", "guess"),
    [
        (["01.03.2024 06:10", "13.03.2024 06:10"], '; perhaps --time-format "%d.%m.%Y %H:%M"'),
        (["03/04/2024"], "; perhaps --time-format %d/%m/%Y or --time-format %m/%d/%Y"),
        (["03/14/2024"], "; perhaps --time-format %m/%d/%Y"),
        (["1709251200000"], "; perhaps --time-format unix-ms"),
        (["2024-03-01"], "; perhaps without --time-format"),
        (["06:10"], "; perhaps --time-format %H:%M"),
        (["yesterday"], ""),
        ([], ""),
    ],
)
def test_formats_are_guessed(texts: list[str], guess: str) -> None:
    """Those that read all of the texts; three at most."""
    assert guessed(texts) == guess


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("%Y-%m-%d %Z", "found %Z: names of zones are not the same everywhere; expected %z (+0200), or --zone"),
        ("%d.%m. %H:%M", "found '%d.%m. %H:%M', which has no year; expected %Y"),
        ("%H:%M %z", "found '%H:%M %z', which has no year; expected %Y"),
        *(
            (text, f"found {text!r}; expected a format such as")
            for text in ("%Q", "%Y %", "%d %d %Y", "", "iso", "%%Z")
        ),
    ],
)
def test_a_format_that_cannot_be_used_is_refused(text: str, problem: str) -> None:
    """Before anything is read."""
    with pytest.raises(InputError) as caught:
        checked_pattern(text)
    assert str(caught.value).startswith(f"--time-format: {problem}")


@pytest.mark.parametrize("text", ["seconds", "unix", "%d.%m.%Y %H:%M", "%H:%M", "100%% %Y-%m-%d"])
def test_formats_that_can_be_used(text: str) -> None:
    """They stay as they are."""
    assert checked_pattern(text) == text
