"""Stock of a warehouse: rows of a table, brought together by pod."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from rmfs_commands.convert import stock_table
from rmfs_commands.convert.quantities import Quantities
from rmfs_commands.convert.stock_table import StockColumns, StockTable
from rmfs_commands.convert.tables import Table
from rmfs_core.errors import InputError

COLUMNS = StockColumns("bin", "sku", "qty")
PLACED = StockColumns("bin", "sku", "qty", "y", "x")


def read(folder: Path, rows: Sequence[str], columns: StockColumns = COLUMNS, decimal: str | None = None) -> StockTable:
    """Read a table of these rows: bin, SKU, items, and perhaps row and column."""
    file = folder / "stock.csv"
    header = "bin;sku;qty" + (";y;x" if columns.row else "")
    file.write_text("".join(f"{row}\n" for row in (header, *rows)), encoding="utf-8")
    stock = StockTable(columns, Quantities(decimal))
    stock.read(Table(file, ";"))
    return stock


def test_rows_of_a_pod_are_brought_together(tmp_path: Path) -> None:
    """Wherever they stand; a SKU that comes twice is added up, and pods keep their order."""
    stock = read(tmp_path, ["B;tea;1.200", "A;jam;3", "B;jam;2", "B; tea ;5"], decimal=",")
    assert list(stock.lines()) == [("pod", "sku", "quantity"), ("B", "tea", 1205), ("B", "jam", 2), ("A", "jam", 3)]
    assert list(stock.sentences()) == ["Read 4 rows.", "SKUs that a pod repeats: 1 row; quantities are added up."]
    assert stock.total() == "2 pods, 1,210 items of 2 SKUs"


def test_each_row_left_out_has_its_reason(tmp_path: Path) -> None:
    """A quantity below 0, parts, none; no pod, no SKU; a header that comes again."""
    rows = ["A;tea;4", "A;jam;-2", "A;jam;1,5", "A;jam;", ";jam;1", "A;;1", "bin;sku;qty", "A;jam;9000000000", ";;"]
    stock = read(tmp_path, rows, decimal=",")
    assert stock.rows == 8
    assert [part for _, part in stock.dropped.parts()] == [
        '3 rows with a quantity that is no whole number from 0 on: row 2 "-2", row 3 "1,5", row 4',
        "1 row with no pod: row 5",
        '1 row with no SKU: row 6 "A"',
        "1 row with the header again: row 7",
        '1 row with more than 1,000,000,000 items: row 8 "9000000000"',
    ]
    assert list(stock.lines())[1:] == [("A", "tea", 4)]


def test_pods_without_items_stay(tmp_path: Path) -> None:
    """They stand in the way, in their places; SKUs of which nothing is left are not on pods."""
    stock = read(tmp_path, ["A;tea;0;1;2", "B;tea;0;3;4", "B;jam;1;3;4"], PLACED)
    assert list(stock.lines()) == [
        ("pod", "sku", "quantity", "row", "column"),
        ("A", "tea", 0, 1, 2),
        ("B", "jam", 1, 3, 4),
    ]
    assert "Empty: 1 pod." in list(stock.sentences())


def test_without_quantities_nothing_runs_out(tmp_path: Path) -> None:
    """As pods.csv has it: an empty quantity."""
    stock = read(tmp_path, ["A;tea;7"], StockColumns("bin", "sku"))
    assert list(stock.lines())[1:] == [("A", "tea", "")]
    assert stock.total() == "1 pod, any number of items of 1 SKU"


@pytest.mark.parametrize(
    ("rows", "columns", "sentence"),
    [
        (
            ["A;tea;1;1;2", "A;jam;1;1;3"],
            PLACED,
            "row 2: found pod 'A' in row 1, column 3; expected row 1, column 2",
        ),
        (
            ["A;tea;1;1;2", "B;jam;1;1;2"],
            PLACED,
            "row 2: found pods 'A' and 'B' in row 1, column 2; expected a place",
        ),
        (["A;tea;1;0;2"], PLACED, "row 1: found '0' and '2' as row and column; expected whole numbers from 1 on"),
        (["A;tea;1;;2"], PLACED, "row 1: found nothing and '2' as row and column"),
        (
            ["A;tea;-1"],
            COLUMNS,
            "has no pod that could be kept: 1 row with a quantity that is no whole number from 0 on",
        ),
        ([], COLUMNS, "has no pod that could be kept: it has no rows"),
        (["A;tea;1.000"], COLUMNS, 'row 1, qty: found "1.000", which may be 1 or 1000'),
        (["A;tea;1"], StockColumns("bin", "article"), 'line 1: there is no column "article"'),
        (["A;tea;1", "B;tea;1", "C;tea;1"], COLUMNS, "row 3: found more than 2 pods; expected at most that many"),
    ],
)
def test_what_run_would_refuse_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: list[str], columns: StockColumns, sentence: str
) -> None:
    """With the row, what was found and what would be right."""
    monkeypatch.setattr(stock_table, "MOST_PODS", 2)
    with pytest.raises(InputError) as caught:
        read(tmp_path, rows, columns)
    assert str(caught.value).startswith(f"{tmp_path / 'stock.csv'}")
    assert sentence in str(caught.value)
