"""`rmfs convert pods`: from a table of stock to pods.csv."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet
import pytest

import rmfs_core
from rmfs_commands.cli.main import main
from rmfs_core.scenario import load_scenario

STOCK = "Bin,Article,Qty\nA-1,tea,4\nA-2,mug,3\nA-1,mug,1\nA-3,spoon,0\n"
COLUMNS = ("--pod", "Bin", "--sku", "Article", "--quantity", "Qty")
PODS = "pod,sku,quantity\nA-1,tea,4\nA-1,mug,1\nA-2,mug,3\nA-3,spoon,0\n"


def convert(folder: Path, *options: str, text: str = STOCK) -> Path:
    """Convert a table; return the folder that was written to."""
    (folder / "stock.csv").write_text(text, encoding="utf-8")
    main(["convert", "pods", str(folder / "stock.csv"), *COLUMNS, "--out", str(folder / "out"), *options])
    return folder / "out"


def test_orders_run_on_the_stock_of_the_warehouse(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Orders and pods of two tables, in one folder, with a scenario for that many pods."""
    lines = tmp_path / "lines.csv"
    lines.write_text("o,s\n1,tea\n1,mug\n2,mug\n", encoding="utf-8")
    main(["convert", "orders", str(lines), "--order", "o", "--sku", "s", "--out", str(tmp_path / "out")])
    out = convert(tmp_path)
    assert (out / "pods.csv").read_text(encoding="utf-8") == PODS
    assert f"Wrote {out / 'pods.csv'}: 3 pods, 8 items of 2 SKUs.\n" in (told := capsys.readouterr().out)
    assert f"Wrote {out / 'scenario.toml'}; run it with: rmfs run {out / 'scenario.toml'}\n" in told
    result = rmfs_core.run(out / "scenario.toml")
    assert (result.status, result.metrics["picks"]) == ("complete", 3)


def test_a_scenario_that_is_there_stays(tmp_path: Path) -> None:
    """Also with --force, which replaces pods.csv; and pods in places of their own have none made up."""
    out = convert(tmp_path)
    (out / "scenario.toml").write_text("mine", encoding="utf-8")
    convert(tmp_path, "--force", text=STOCK.replace("4", "5"))
    assert (out / "scenario.toml").read_text(encoding="utf-8") == "mine"
    assert "A-1,tea,5" in (out / "pods.csv").read_text(encoding="utf-8")
    (tmp_path / "placed").mkdir()
    placed = convert(
        tmp_path / "placed", "--row", "y", "--column", "x", text="Bin,Article,Qty,y,x\nA,tea,4,2,3\nB,tea,1,2,4\n"
    )
    assert [file.name for file in placed.iterdir()] == ["pods.csv"]
    assert (placed / "pods.csv").read_text() == "pod,sku,quantity,row,column\nA,tea,4,2,3\nB,tea,1,2,4\n"


def test_parquet_tables_give_the_same(tmp_path: Path) -> None:
    """With whole numbers and decimals as quantities."""
    bins, skus, items = ["A-1", "A-2", "A-1", "A-3"], ["tea", "mug", "mug", "spoon"], [4.0, 3.0, 1.0, 0.0]
    table = pa.table({"Bin": bins, "Article": skus, "Qty": items})
    pyarrow.parquet.write_table(table, tmp_path / "stock.parquet")
    main(["convert", "pods", str(tmp_path / "stock.parquet"), *COLUMNS, "--out", str(tmp_path)])
    assert (tmp_path / "pods.csv").read_text(encoding="utf-8") == PODS


@pytest.mark.parametrize(
    ("text", "options", "sentence"),
    [
        (STOCK, ["--row", "y"], "--row: found no --column; expected both, or neither"),
        (STOCK, ["--column", "x"], "--column: found no --row; expected both, or neither"),
        ("Bin,Article,Qty\nA,tea,1\nB,tea,-1\nC,tea,x\n", [], "2 of 3 rows would be left out: 2 rows with a quantity"),
        (STOCK, ["--decimal", ".", "--thousands", "."], "--decimal, --thousands: found"),
        ('Bin,Article,Qty\nA,tea,"4,00"\nB,mug,"3,00"\n', ["--decimal", "."], '"3,00"; perhaps --decimal ,'),
        (STOCK, ["--start", "noon"], '--start: expected a time in ISO 8601, such as 2024-03-01T06:30, found "noon"'),
        (
            "Bin,Article,Qty\nA,tea,4\nB,tea,5\n",
            ["--start", "2024-03-01", "--row", "Qty", "--column", "Qty"],
            "--start: pods with places get no scenario.toml; expected no --start",
        ),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, options: list[str], sentence: str
) -> None:
    """Exit code 2, and nothing is written: no folder is made."""
    with pytest.raises(SystemExit) as stopped:
        convert(tmp_path, *options, text=text)
    assert stopped.value.code == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_time_0_of_orders_with_dates_is_given(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The scenario has it; without it, that is said. A scenario that is there is not changed."""
    out = convert(tmp_path)
    assert "Its time 0 is a midnight; for orders with dates, give --start" in capsys.readouterr().out
    (out / "scenario.toml").unlink()
    convert(tmp_path, "--force", "--start", "2024-03-01T06:00+01:00")
    assert "midnight" not in capsys.readouterr().out
    (out / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,tea,1\n", encoding="utf-8")
    assert load_scenario(out / "scenario.toml").instance.start == "2024-03-01T06:00+01:00"
    with pytest.raises(SystemExit):
        convert(tmp_path, "--force", "--start", "2024-03-01")
    assert "scenario.toml is there already; expected no --start" in capsys.readouterr().err


def test_files_that_are_there_are_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without --force nothing is replaced."""
    out = convert(tmp_path)
    with pytest.raises(SystemExit):
        convert(tmp_path, text="Bin,Article,Qty\nZ,tea,1\n")
    assert "--force replaces it" in capsys.readouterr().err
    assert (out / "pods.csv").read_text(encoding="utf-8") == PODS
