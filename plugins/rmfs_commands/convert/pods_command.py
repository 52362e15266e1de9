"""``rmfs convert pods``: stock of a warehouse to pods.csv."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from rmfs_commands.cli.options import OutPath
from rmfs_commands.convert.options import needs, number_options, only_option, open_option, quantities_of, table_options


@click.command(short_help="Make pods.csv from a table of stock.")
@click.argument("table", metavar="STOCK", type=click.Path(path_type=Path))
@click.option("--out", required=True, metavar="DIR", type=OutPath(), help="Folder to write to.")
@click.option("--pod", required=True, metavar="COL", help="Column with the pod, or the location that becomes one.")
@click.option("--sku", required=True, metavar="COL", help="Column with the SKU.")
@click.option("--quantity", metavar="COL", help="Column with the items. [default: never run out]")
@click.option("--row", metavar="COL", help="Column with the row of the map where the pod stands. [default: anywhere]")
@click.option("--column", metavar="COL", help="Column with the column of the map. [default: anywhere]")
@click.option(
    "--start", metavar="TIME", help="Time 0 of the orders, as `rmfs convert orders` says it; for scenario.toml."
)
@only_option
@open_option
@table_options
@number_options
@click.option("--force", is_flag=True, help="Replace files, and write also where most rows are left out.")
def pods(table: Path, out: Path, **given: Any) -> None:
    """Make pods.csv from STOCK, a table (CSV or Parquet) with the items of a SKU on a pod in each row.

    Rows of one pod need not be adjacent. Every row left out is reported with its reason. Where DIR has no
    scenario.toml, one is written for that many pods and the orders.csv that `rmfs convert orders` makes, unless the
    pods have locations in a map.
    """
    from rmfs_commands.cli.file_writing import writable_folder
    from rmfs_commands.convert.shares import check_share
    from rmfs_commands.convert.stock_table import StockColumns, StockTable
    from rmfs_commands.convert.tables import Table, check_there
    from rmfs_commands.convert.writing import checked_start, write_pods
    from rmfs_commands.results.files import removed_if_empty

    needs(given, "row", "column", "both, or neither")
    needs(given, "column", "row", "both, or neither")
    start = checked_start(given["start"])
    check_there(table)
    columns = StockColumns(*(given[name] for name in ("pod", "sku", "quantity", "row", "column")))
    stock = StockTable(columns, quantities_of(given))
    with removed_if_empty(out):
        folder = writable_folder(out, ("pods.csv",), force=given["force"])
        stock.read(Table(table, given["separator"], given["encoding"], given["only"]))
        check_share(table, stock, force=given["force"])
        write_pods(stock, folder, start, given["open"] or ())
