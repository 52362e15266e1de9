"""Headers of orders in a table of their own: joined by the order, what has no counterpart is reported."""

from __future__ import annotations

from pathlib import Path

import pytest

import rmfs_core
from rmfs_commands.cli.main import main

HEADS = """\
Document;Created;Promised;Urgency
7;01.03.2024 06:10;01.03.2024 08:00;1
8;01.03.2024 06:05;;
8;01.03.2024 06:20;01.03.2024 09:00;2
9;01.03.2024 07:00;;
10;yesterday;;
;01.03.2024 07:00;;
"""
LINES = """\
Order;Article;Qty
7;tea;1,000
8;mug;2,000
7;spoon;1,000
10;tea;1,000
11;tea;1,000
"""
COLUMNS = ("--order", "Order", "--sku", "Article", "--quantity", "Qty", "--decimal", ",", "--separator", ";")
OF_HEADS = ("--order-key", "Document", "--time", "Created", "--due", "Promised", "--priority", "Urgency")
FORMAT = ("--time-format", "%d.%m.%Y %H:%M")


def convert(folder: Path, *options: str, heads: str = HEADS, lines: str = LINES) -> None:
    """Convert two tables."""
    (folder / "heads.csv").write_text(heads, encoding="utf-8")
    (folder / "lines.csv").write_text(lines, encoding="utf-8")
    tables = [str(folder / "lines.csv"), "--orders", str(folder / "heads.csv")]
    main(["convert", "orders", *tables, *COLUMNS, *FORMAT, "--out", str(folder / "out"), *options])


def test_lines_have_what_their_headers_say(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Times, due times and priorities; of two headers the earliest time and due time and the highest priority."""
    convert(tmp_path, *OF_HEADS)
    assert (tmp_path / "out" / "orders.csv").read_text(encoding="utf-8").splitlines() == [
        "order,arrival_s,sku,quantity,due_s,priority",
        "8,21900,mug,2,32400,2",
        "7,22200,tea,1,28800,1",
        "7,22200,spoon,1,28800,1",
    ]
    told = capsys.readouterr().out
    file = tmp_path / "heads.csv"
    assert f"Read 6 headers of {file}.\n" in told
    assert f'Left out of {file}: 1 row with no time that can be read: row 5 "yesterday".\n' in told
    assert f"Left out of {file}: 1 row with no order: row 6.\n" in told
    assert f'Left out of {file}: 1 order without lines: "9".\n' in told
    assert f'Left out: 2 rows with no header in {file} that is kept: row 4 "10", row 5 "11".\n' in told
    assert "Left out: 2 orders with no row that is kept.\n" in told
    assert "Headers with different times: 1 order; the earliest is the order's.\n" in told


def test_an_order_is_left_out_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One without a header that loses a line as well."""
    convert(tmp_path, *OF_HEADS, lines=LINES + "11;mug;-1,000\n12;mug;-1,000\n7;mug;1,000\n")
    told = capsys.readouterr().out
    assert f"Left out: 2 rows with no header in {tmp_path / 'heads.csv'} that is kept: row 4" in told
    assert "Left out: 3 orders with no row that is kept.\n" in told


def test_orders_of_two_tables_run(tmp_path: Path) -> None:
    """With pods, and the same name for the order in both tables."""
    convert(tmp_path, *OF_HEADS[2:], "--pods", "12", "--skus-per-pod", "1", heads=HEADS.replace("Document", "Order"))
    result = rmfs_core.run(tmp_path / "out" / "scenario.toml")
    assert [order["arrival_s"] for order in result.orders] == [21_900.0, 22_200.0]
    assert result.status == "complete"


@pytest.mark.parametrize(
    ("changed", "options", "sentence"),
    [
        (
            {"lines": LINES.replace("\n", "\n0")[:-1]},
            OF_HEADS,
            'no order of {lines} has a header: found orders "07" and "08" there, and "7", "8" and "9" here',
        ),
        (
            {"heads": "Document;Created\n"},
            OF_HEADS[:4],
            "heads.csv: has no header of an order that could be kept",
        ),
        ({}, OF_HEADS[2:], 'heads.csv, line 1: there is no column "Order"'),
        ({}, (*OF_HEADS[:2], "--time", "Made"), 'heads.csv, line 1: there is no column "Made"'),
        (
            {"lines": LINES + "12;tea;1,000\n13;tea;1,000\n"},
            OF_HEADS,
            "lines.csv: 4 of 7 rows would be left out: 4 rows with no header in ",
        ),
        (
            {"heads": "Document;Created;Promised;Urgency\n7;01.03.2024 06:10;2.3.;1\n8;01.03.2024 06:05;2.3.;2\n"},
            OF_HEADS,
            "heads.csv: would be left empty: 2 rows with a due time that cannot be read: row 1 ",
        ),
        (
            {"heads": HEADS + "11;today;;\n12;today;;\n13;today;;\n"},
            OF_HEADS,
            "heads.csv: 5 of 9 rows would be left out: 4 rows with no time that can be read: ",
        ),
        (
            {"heads": "Document;Created\n7;20240301\n8;20240302\n"},
            (*OF_HEADS[:4], "--time-format", "seconds", "--due", "x"),
            'there is no column "x"',
        ),
    ],
)
def test_what_does_not_fit_together_is_refused(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    changed: dict[str, str],
    options: tuple[str, ...],
    sentence: str,
) -> None:
    """In one sentence with the table; nothing is written."""
    with pytest.raises(SystemExit) as stopped:
        convert(tmp_path, *options, **changed)
    assert stopped.value.code == 2
    assert sentence.format(lines=tmp_path / "lines.csv") in capsys.readouterr().err
    assert not list((tmp_path / "out").glob("*"))


def test_a_key_needs_its_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """--order-key alone would be ignored."""
    with pytest.raises(SystemExit):
        main(["convert", "orders", "x.csv", *COLUMNS, "--order-key", "x", "--out", str(tmp_path)])
    assert "--order-key: found no --orders; expected the table" in capsys.readouterr().err
