"""``rmfs convert pods``: stock of a warehouse to pods.csv."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from rmfs_cli.options import OutPath
from rmfs_convert.options import number_options, quantities_of, table_options


@click.command(short_help="Make pods.csv from a table of stock.")
@click.argument("table", metavar="STOCK", type=click.Path(path_type=Path))
@click.option("--out", required=True, metavar="DIR", type=OutPath(), help="Folder to write to.")
@click.option("--pod", required=True, metavar="COL", help="Column with the pod, or the location that becomes one.")
@click.option("--sku", required=True, metavar="COL", help="Column with the SKU.")
@click.option("--quantity", metavar="COL", help="Column with the items. [default: never run out]")
@click.option("--row", metavar="COL", help="Column with the row of the map where the pod stands. [default: anywhere]")
@click.option("--column", metavar="COL", help="Column with the column of the map. [default: anywhere]")
@table_options
@number_options
@click.option("--force", is_flag=True, help="Replace files, and write also where most rows are left out.")
def pods(table: Path, out: Path, **given: Any) -> None:
    """Make pods.csv from STOCK, a table (CSV or Parquet) with the items of a SKU on a pod in each row.

    Rows of one pod need not be adjacent. What is left out is said, with the reason. Where DIR has no scenario.toml, one
    is written for that many pods, and the orders.csv that `rmfs convert orders` makes; with places in the map there is
    none, since the map is yours.
    """
    from rmfs_convert.stock_table import StockColumns, StockTable
    from rmfs_convert.tables import Table
    from rmfs_convert.writing import check_share, target, write_pods
    from rmfs_core.errors import InputError
    from rmfs_core.results.files import removed_if_empty

    for option, other in (("row", "column"), ("column", "row")):
        if given[option] is not None and given[other] is None:
            raise InputError(f"--{option}", f"found no --{other}; expected both, or neither")
    columns = StockColumns(*(given[name] for name in ("pod", "sku", "quantity", "row", "column")))
    stock = StockTable(columns, quantities_of(given["decimal"], given["thousands"]))
    with removed_if_empty(out):
        folder = target(out, ("pods.csv",), force=given["force"])
        stock.read(Table(table, given["separator"], given["encoding"]))
        check_share(table, stock.rows, stock.dropped.unasked, stock.left_out(), force=given["force"])
        write_pods(stock, folder)
