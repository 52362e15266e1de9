"""The files made of order lines, and the sentences about them."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from rmfs_commands.convert.cleaning import Choice, Cleaner, Columns, Reader
from rmfs_commands.convert.history import Learned
from rmfs_commands.convert.lines import OrderLines, Span
from rmfs_commands.convert.tables import Table
from rmfs_commands.convert.times import Clock
from rmfs_commands.convert.writing import Stock, write


def converted(folder: Path, *rows: str, pattern: str | None = None, start: str | None = None) -> list[str]:
    """Write what rows are (order, SKU, time) and return the names of the files."""
    file = folder / "lines.csv"
    file.write_text("o,s,t\n" + "".join(f"{row}\n" for row in rows), encoding="utf-8")
    reader = Reader(Clock(pattern))
    with OrderLines(Cleaner(Columns("o", "s", "t"), reader, Choice())) as lines:
        lines.read(Table(file))
        zero = lines.gather(Span(start=None if start is None else reader.clock.option("--start", start)))
        skus = lines.skus()
        stock = Stock(skus, [[*range(len(skus))]], 5, Learned("random", None))
        (folder / "out").mkdir()
        write(lines, folder / "out", zero, stock)
    return sorted(path.name for path in (folder / "out").iterdir())


@pytest.mark.parametrize(
    ("time", "pattern", "given", "start"),
    [
        ("2024-07-01T06:00+02:00", None, None, "2024-07-01T00:00:00+02:00"),
        ("2024-07-01T06:00", None, "2024-07-01T05:30", "2024-07-01T05:30:00"),
        ("21600", None, None, None),
        ("06:00", "%H:%M", None, None),
        ("06:00", "%H:%M", "05:30", "2000-01-01T05:30:00"),
    ],
)
def test_time_zero_is_written_where_it_is_known(
    tmp_path: Path, time: str, pattern: str | None, given: str | None, start: str | None
) -> None:
    """With its offset from UTC; times of the day have a day of their own."""
    assert converted(tmp_path, f"1,a,{time}", pattern=pattern, start=given) == [
        "orders.csv",
        "pods.csv",
        "scenario.toml",
    ]
    scenario = tomllib.loads((tmp_path / "out" / "scenario.toml").read_text(encoding="utf-8"))
    assert scenario["instance"].get("start") == start
    arrival = 1800 if given else 21_600
    assert (tmp_path / "out" / "orders.csv").read_text(encoding="utf-8").splitlines()[1] == f"1,{arrival},a,1"


def test_what_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Rows without an entry, names respelled, clocks that differ, the largest lines, and a warning."""
    rows = [
        "1,cafe\u0301,2024-07-01T06:00+02:00",
        "1,caf\u00e9,2024-07-01T06:00Z",
        ",,",
        "2,tea,noon",
        "1,,2024-07-01T06:00Z",
    ]
    converted(tmp_path, *rows)
    told = capsys.readouterr()
    assert told.out.splitlines() == [
        "Read 4 rows, and 1 without any entry.",
        'Left out: 1 row with no time that can be read: row 4 "noon".',
        'Left out: 1 row with no SKU: row 5 "1".',
        "Left out: 1 order with no row that is kept.",
        "Shortened: 1 order without a line that is left out (--whole-orders).",
        "Names with accents apart from their letters (NFD): 1; they are spelled as one sign (NFC).",
        "SKUs that an order repeats: 1 row; quantities are added up.",
        "Lines with different times: 1 order; the earliest is the order's.",
        "Times with offsets from UTC of +00:00 and +02:00: hours of the day are by the clock of time 0 (--start).",
        "Largest lines: 2 of caf\u00e9 (order 1).",
        f"Wrote {tmp_path}/out/orders.csv: 1 order, 1 line, 2 items of 1 SKU; "
        "time 0 is 2024-07-01T00:00:00+02:00 (`instance.start`), the last order arrives 6.0 hours later.",
        f"Wrote {tmp_path}/out/pods.csv: 1 pod with 1 place.",
        f"Wrote {tmp_path}/out/scenario.toml; run it with: rmfs run {tmp_path}/out/scenario.toml",
    ]
    assert told.err == f"Warning: 50 % of the rows of {tmp_path}/lines.csv are left out (2 of 4).\n"


def test_names_with_commas_and_quotes_are_quoted(tmp_path: Path) -> None:
    """In both files."""
    converted(tmp_path, '1,"a, ""b""",5')
    assert (tmp_path / "out" / "pods.csv").read_text(encoding="utf-8") == 'pod,sku,quantity\nP1,"a, ""b""",5\n'
    assert '1,5,"a, ""b""",1\n' in (tmp_path / "out" / "orders.csv").read_text(encoding="utf-8")
