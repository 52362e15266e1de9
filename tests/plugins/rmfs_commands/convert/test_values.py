"""Times, quantities and names in the notations of many countries, and how many rows may be left out."""

import time
from zoneinfo import ZoneInfo

import pytest

from calling import refusal
from cases import cases
from rmfs_commands.convert.names import Names
from rmfs_commands.convert.numeric_dates import NumericDates, looks_of
from rmfs_commands.convert.quantities import Quantities
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
from rmfs_commands.convert.times import Clock, offset

MARCH = 1_709_251_200_000
"""2024-03-01 00:00 UTC in ticks since 1970."""
DATES = "dates without an offset"


@cases(
    "text midnight shown",
    ("2024-03-01T06:05:30.5", MARCH, "2024-03-01T00:00:00"),
    ("2024-03-01", MARCH, "2024-03-01T00:00:00"),
    ("2024-02-29T23:59:59.999", MARCH - 86_400_000, "2024-02-29T00:00:00"),
    ("2024-03-01T00:30+02:00", MARCH - 7_200_000, "2024-03-01T00:00:00+02:00"),
    ("2024-02-29T23:30-03:30", MARCH - 86_400_000 + 12_600_000, "2024-02-29T00:00:00-03:30"),
    ("90000", 0, "0 s"),
)
def test_days_begin_at_midnight_of_their_own_clock(text: str, midnight: int, shown: str) -> None:
    clock = Clock()
    found = clock.midnight_before(clock.read(text))
    assert (found.tick, clock.iso(found)) == (midnight, shown)


def test_times_as_text() -> None:
    """Fractions only where there are some; times of the day without a date."""
    clock = Clock()
    assert clock.iso(clock.read("12.5")) == "12.5 s"
    clock = Clock(["%H:%M"])
    assert clock.iso(clock.read("06:05")) == "06:05:00"
    assert clock.of_day
    assert (offset(-12_600_000), offset(1_172_000)) == ("-03:30", "+00:19:32")


@cases(
    "pattern row text tick",
    (None, "2024-03-05", "2024-03-01T06:00", MARCH + 21_600_000),
    ("%d.%m.%Y", "05.03.2024", "01.03.2024", MARCH),
    ("%d.%m.%Y", "05.03.2024", "2024-03-01", MARCH),
    (None, "2024-03-05T06:00Z", "2024-03-01T02:00+02:00", MARCH),
    (None, "700", "60", 60_000),
    (None, "2024-03-05 060000", "20240301", MARCH),
    ("%Y%m%d %H%M%S", "20240305 060000", "20240301", MARCH),
)
def test_a_time_of_an_option(pattern: str | None, row: str, text: str, tick: int) -> None:
    clock = Clock(pattern and [pattern])
    clock.read(row)
    assert clock.option("--from", text).tick == tick


@cases(
    "row text problem",

        ("2024-03-05", "5", f'found "5", but the times of the table are {DATES}; expected'),
        ("2024-03-05", "2024-03-01T06Z", f'found "2024-03-01T06Z", but the times of the table are {DATES}; expected'),
        ("2024-03-05T00:00Z", "2024-03-01", 'found "2024-03-01", but the times of the table are dates with an offset;'),
        ("7", "2024-03-01", 'found "2024-03-01", but the times of the table are seconds; expected'),
        ("7", "noon", 'found "noon"; expected a time such as 2024-03-01T06:00, or as --time-format has it'),
        ("7", "1900-01-01", 'found "1900-01-01"; expected a time such as 2024-03-01T06:00, or as --time-format has it'),
)  # fmt: skip
def test_a_time_of_another_kind_than_the_table_is_refused(row: str, text: str, problem: str) -> None:
    clock = Clock()
    clock.read(row)
    assert refusal(lambda: clock.option("--from", text)).startswith(f"--from: {problem}")


@pytest.mark.parametrize("machine", ["UTC", "America/New_York", "Asia/Kolkata"])
def test_the_machine_has_no_time_zone(monkeypatch: pytest.MonkeyPatch, machine: str) -> None:
    monkeypatch.setenv("TZ", machine)
    time.tzset()
    try:
        assert Clock().read("2024-03-01T06:00") == Moment(MARCH + 21_600_000)
        assert Clock(["%d.%m.%Y"]).read("01.03.2024") == Moment(MARCH)
        assert Clock(["unix"]).read("1709251200") == Moment(MARCH)
        assert Clock(None, ZoneInfo("Asia/Tokyo")).read("2024-03-01T09:00") == Moment(MARCH, 32_400_000)
    finally:
        monkeypatch.undo()
        time.tzset()


def test_offsets() -> None:
    clock = Clock(["%Y%m%d %H%M%S"], ZoneInfo("Europe/Berlin"))
    first = clock.read("20241027 003000")
    start = clock.option("--start", "2024-10-26T23:00+01:00")
    assert clock.iso(start) == "2024-10-26T23:00:00+01:00"
    assert (first.tick - start.tick, clock.iso(first)) == (1_800_000, "2024-10-27T00:30:00+02:00")
    assert clock.option("--start", "2024-10-27").tick == start.tick
    clock = Clock(None, ZoneInfo("Europe/Berlin"))
    clock.read("2024-10-27T06:00")
    assert refusal(lambda: clock.option("--from", "21600")) == (
        '--from: found "21600", but the times of the table are dates; '
        "expected one of that kind, such as 2024-03-01T06:00"
    )


HOUR = 3_600_000
BERLIN = ZoneInfo("Europe/Berlin")


@cases(
    "text pattern kind tick ahead",
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
)
def test_a_time_is_read(text: str, pattern: str | None, kind: str, tick: int, ahead: int) -> None:
    assert reader_of(pattern, None)(text) == (kind, Moment(tick, ahead))


STANDS_FOR_NONE = r"^a time that stands for none \(before 1971 or after 2099\)$"


@cases(
    "text pattern zone error problem",
    *(
        (text, None, None, ValueError, "^")
        for text in ("yesterday", "", "-5", "2024-02-30", "1609112200000x", "06:10", "12,5")
    ),
    ("1709251200", "%S", None, ValueError, "^"),
    ("2024301", "%Y%m%d", None, ValueError, "^"),  # a month of one digit
    ("20240301 11000", "%Y%m%d %H%M%S", None, ValueError, "^"),  # 01:10:00 or 11:00:00
    ("2024-03-01", "unix", None, ValueError, "^"),
    ("20240230", "%Y%m%d", None, ValueError, "^"),
    *((text, None, None, UnusableError, STANDS_FOR_NONE) for text in ("1900-01-01T06:00", "9999-12-31")),
    *(("0", pattern, None, UnusableError, STANDS_FOR_NONE) for pattern in ("unix", "spreadsheet")),
    ("99991231", "%Y%m%d", None, UnusableError, STANDS_FOR_NONE),
    ("2024-03-31T02:30", None, BERLIN, UnusableError, "a time that the clock skips"),
)
def test_what_is_no_time_is_refused(text, pattern, zone, error, problem) -> None:
    with pytest.raises(error, match=problem):
        reader_of(pattern, zone)(text)


@cases(
    "text hours ahead",
    ("2024-03-31T01:30", 0.5, 1),
    ("2024-03-31T03:30", 1.5, 2),
    ("2024-03-31T03:30+02:00", 1.5, 2),
    ("2024-03-31T01:30Z", 1.5, 2),  # the clock of the zone, not that of the text
    ("2024-10-27T02:30", 5040.5, 2),  # twice: the first
    ("2024-10-27T02:30+01:00", 5041.5, 1),
    ("2024-10-27T03:30", 5042.5, 1),
)
def test_a_zone_knows_the_days_of_the_clock_change(text: str, hours: float, ahead: int) -> None:
    kind, moment = reader_of(None, BERLIN)(text)
    assert (kind, moment) == (ABSOLUTE, Moment(1_711_843_200_000 + int(hours * HOUR), ahead * HOUR))


@cases(
    "texts others guess",
    (["01.03.2024 06:10", "13.03.2024 06:10"], (), '; perhaps --time-format "%d.%m.%Y %H:%M"'),
    (["03/04/2024"], (), "; perhaps --time-format %d/%m/%Y or --time-format %m/%d/%Y"),
    (["03/14/2024"], (), "; perhaps --time-format %m/%d/%Y"),
    (["1709251200000"], (), "; perhaps --time-format unix-ms"),
    (["2024-03-01"], (), "; perhaps without --time-format"),
    (["06:10"], (), "; perhaps --time-format %H:%M"),
    (["yesterday"], (), ""),
    ([], (), ""),
    (["13.03.2024"], ("%Y%m%d",), "; perhaps also --time-format %d.%m.%Y"),
    (["13.03.2024"], None, "; perhaps --time-format iso and also --time-format %d.%m.%Y"),
    (["2024-03-13"], ("%d.%m.%Y",), "; perhaps also --time-format iso"),
)
def test_formats_are_guessed(texts: list[str], others: tuple[str, ...] | None, guess: str) -> None:
    assert guessed(texts, others) == guess


@cases(
    "text problem",
    ("%Y-%m-%d %Z", "found %Z: names of zones are not the same everywhere; expected %z (+0200), or --zone"),
    ("%d.%m. %H:%M", "found '%d.%m. %H:%M', which has no year; expected %Y"),
    ("%H:%M %z", "found '%H:%M %z', which has no year; expected %Y"),
    *((text, f"found {text!r}; expected a format such as") for text in ("%Q", "%Y %", "%d %d %Y", "", "ISO", "%%Z")),
)
def test_a_format_that_cannot_be_used_is_refused(text: str, problem: str) -> None:
    assert refusal(lambda: checked_pattern(text)).startswith(f"--time-format: {problem}")


@pytest.mark.parametrize("text", ["seconds", "unix", "%d.%m.%Y %H:%M", "%H:%M", "100%% %Y-%m-%d"])
def test_formats_that_can_be_used(text: str) -> None:
    assert checked_pattern(text) == text


@cases(
    "text options",
    ("20240229", ["%Y%m%d"]),
    ("20240229.0", ["%Y%m%d"]),
    ("99991231", ["%Y%m%d"]),
    ("00000000", ["%Y%m%d"]),
    ("240229", ["%y%m%d"]),
    ("061012", ["%y%m%d", "%H%M%S"]),
    ("45351.25", ["spreadsheet"]),
    ("1709251200", ["unix"]),
    ("1709251200000", ["unix-ms"]),
    ("20240229061000", ["%Y%m%d%H%M%S"]),
    ("202402290610", ["%Y%m%d%H%M"]),
    ("240229061000", ["%y%m%d%H%M%S"]),
    # seconds
    ("0", []),
    ("36525", []),
    ("54789", []),
    ("241329", []),
    ("20241329", []),
    ("17092512", []),
    ("315619200", []),
)
def test_what_a_number_may_be(text: str, options: list[str]) -> None:
    assert [look.option for look in looks_of(text)] == options


@cases(
    "texts question",
    (
        ["20240229"] * 9 + ["0"],
        'found numbers such as "20240229" in row 1, which may be dates as YYYYMMDD (--time-format %Y%m%d), '
        "or seconds (--time-format seconds)",
    ),
    (
        ["061012", "101112"],
        'found numbers such as "061012" in row 1, which may be dates as YYMMDD (--time-format %y%m%d) or '
        "times of the day as HHMMSS (--time-format %H%M%S), or seconds (--time-format seconds)",
    ),
    (["20240229"] * 8 + ["0"], None),  # fewer than nine of ten
    (["151617", "235959"], None),  # times of the day begin with 0 somewhere
    ([], None),
)
def test_most_of_a_column_has_to_look_like_dates(texts: list[str], question: str | None) -> None:
    numbers = NumericDates()
    for row, text in enumerate(texts, 1):
        numbers.note(text, row)
    assert numbers.question() == question


def test_another_decimal_sign_is_guessed_by_what_it_reads() -> None:
    assert Quantities(".").guessed(["x", "1,00"]) == "; perhaps --decimal ,"
    assert Quantities(",").guessed(["1.00"]) == "; perhaps --decimal ."
    assert Quantities(".").guessed(["1,50", "-1,00", ""]) == ""
    assert Quantities().guessed(["1,00"]) == ""


@cases(
    "text decimal thousands number",
    ("12", None, None, 12),
    ("007", None, None, 7),
    ("1.0", None, None, 1),
    ("1,00", None, None, 1),
    ("1.", None, None, 1),
    ("1.5", None, None, None),
    ("2,5", None, None, None),
    ("1.234,00", None, None, 1234),
    ("1,234.00", None, None, 1234),
    ("1.234.567", None, None, 1_234_567),
    ("1 000", None, None, 1000),
    ("1\u202f000,0", None, None, 1000),
    ("1'000", None, None, 1000),
    ("0.500", None, None, None),  # no number of thousands begins with 0
    ("1234,000", None, None, 1234),
    ("12,34", None, None, None),
    # known signs
    ("1.000", ".", None, 1),
    ("1.000", ",", None, 1000),
    ("1,000", ".", None, 1000),
    ("1,000", ".", "'", None),  # a comma is neither
    ("1.000", None, ".", 1000),
    ("1.000", None, ",", 1),
    ("1.000", None, " ", 1),
    # no whole numbers
    ("", None, None, None),
    ("-3", None, None, None),
    ("3-", None, None, None),
    ("(2)", None, None, None),
    ("1e3", None, None, None),
    ("2 pcs", None, None, None),
    ("\u0663", None, None, None),
    ("9" * 16, None, None, None),
)
def test_a_number_is_read(text: str, decimal: str | None, thousands: str | None, number: int | None) -> None:
    quantities = Quantities(decimal, thousands)
    assert quantities.whole(text, 1) == number
    quantities.ask("lines.csv", "Menge")


def test_what_can_be_read_in_two_ways_is_asked() -> None:
    quantities = Quantities()
    found = [quantities.whole(text, row) for row, text in enumerate(("1", "1.000", "2,5", "12.000"), 1)]
    assert found == [1, None, None, None]
    assert refusal(lambda: quantities.ask("lines.csv", "Menge")) == (
        'lines.csv, row 2, Menge: found "1.000", which may be 1 or 1000 (row 3 has "2,5"); '
        "expected --decimal . if the point is before fractions, or --decimal , if the comma is"
    )


def test_one_name_has_one_spelling() -> None:
    names = Names()
    given = (" A 1 ", "cafe\u0301", "caf\u00e9", "two\r\nlines", "A  1", "\u00a0x")
    assert [*map(names.clean, given)] == ["A 1", "caf\u00e9", "caf\u00e9", "two lines", "A  1", "x"]
    assert names.respelled == 1
