"""``rmfs convert``: tables of a warehouse management system to the files that a scenario reads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rmfs_cli.options import OutPath
from rmfs_convert.options import clock_of, number_options, quantities_of, table_options, time_options

if TYPE_CHECKING:
    from rmfs_convert.lines import OrderLines, Span
    from rmfs_convert.times import Clock
    from rmfs_convert.writing import Stock

BASKETS = 200_000
"""Orders that are looked at to say which SKUs are bought together."""

MOST_LEFT_OUT = 0.5
"""Share of the rows that may be left out."""


@click.group()
def convert() -> None:
    """Make a scenario's files from the tables of a warehouse."""


@convert.command(short_help="Make orders.csv from a table of order lines.")
@click.argument("table", metavar="LINES", type=click.Path(path_type=Path))
@click.option("--out", required=True, metavar="DIR", type=OutPath(), help="Folder to write to.")
@click.option("--order", required=True, metavar="COL", help="Column with the order's number or name.")
@click.option("--sku", required=True, metavar="COL", help="Column with the SKU.")
@click.option("--time", metavar="COL", help="Column with the time of arrival. [default: all at time 0]")
@click.option("--time-of-day", metavar="COL", help="Column with the time of the day, where --time has the date alone.")
@click.option("--quantity", metavar="COL", help="Column with the items. [default: one each]")
@click.option("--due", metavar="COL", help="Column with the time at which an order is due. [default: none]")
@click.option("--priority", metavar="COL", help="Column with the priority, higher first. [default: none]")
@time_options
@click.option("--from", "begin", metavar="TIME", help="Leave out orders that arrive earlier.")
@click.option("--until", "end", metavar="TIME", help="Leave out orders that arrive then or later.")
@click.option("--start", metavar="TIME", help="Time 0 of the run. [default: the midnight before the first order]")
@table_options
@number_options
@click.option("--leave-out-sku", multiple=True, metavar="SKU", help="Leave out the lines of a SKU; may be repeated.")
@click.option(
    "--most-quantity",
    type=click.IntRange(1, 1_000_000),
    default=1_000_000,
    metavar="N",
    help="Leave out lines of more than N items. [default: 1,000,000, the most that a run takes]",
)
@click.option("--whole-orders", is_flag=True, help="Leave out orders that lose a line.")
@click.option("--pods", type=click.IntRange(1, 1_000_000), metavar="N", help="Put the SKUs on that many pods, too.")
@click.option(
    "--skus-per-pod",
    type=click.IntRange(1, 10_000),
    default=20,
    show_default=True,
    metavar="N",
    help="SKUs on each pod.",
)
@click.option(
    "--items",
    type=click.IntRange(1, 1_000_000),
    default=10,
    show_default=True,
    metavar="N",
    help="Items of a SKU on each of its pods; more where the orders want more than that in all.",
)
@click.option(
    "--placement",
    type=click.Choice(["random", "popularity", "co-purchase"]),
    default="popularity",
    show_default=True,
    help="Which SKUs stand on more pods, and which stand together.",
)
@click.option("--seed", type=click.IntRange(min=0), default=1, show_default=True, help="Seed of the placement.")
@click.option("--force", is_flag=True, help="Replace files, and write also where most rows are left out.")
def orders(table: Path, out: Path, **given: Any) -> None:
    """Make orders.csv from LINES, a table (CSV or Parquet) with one order line a row.

    Rows of one order need not be adjacent, and may be any number: they are sorted on disk. What is left out is said,
    with the reason. With --pods, the SKUs are put on pods as well, and DIR/scenario.toml runs with both.
    """
    from rmfs_convert.cleaning import Choice, Cleaner, Columns, Reader
    from rmfs_convert.lines import OrderLines
    from rmfs_convert.tables import Table
    from rmfs_convert.writing import target, write

    _check_times(given)
    clock, force = clock_of(given["time_format"], given["zone"]), given["force"]
    reader = Reader(clock, quantities_of(given["decimal"], given["thousands"]))
    _span(clock, given)  # what is no time is refused before the table is read
    folder = target(out, pods=given["pods"] is not None, force=force)
    columns = Columns(*(given[name] for name in ("order", "sku", "time", "quantity", "due", "priority", "time_of_day")))
    with OrderLines(Cleaner(columns, reader, Choice(given["leave_out_sku"], given["most_quantity"]))) as lines:
        lines.read(Table(table, given["separator"], given["encoding"]))
        zero = lines.gather(_span(clock, given), given["whole_orders"])
        _check_share(lines, table, force)
        write(lines, folder, zero, _stock(lines, given))


def _check_times(given: dict[str, Any]) -> None:
    """Refuse options about times without a column of times."""
    from rmfs_core.errors import InputError

    if given["time"] is None:
        if given["due"] is not None:
            raise InputError("--due", "found no --time; expected both, since both are counted from time 0")
        names = {
            "time_of_day": "--time-of-day",
            "time_format": "--time-format",
            "zone": "--zone",
            "begin": "--from",
            "end": "--until",
            "start": "--start",
        }
        for name, option in names.items():
            if given[name] is not None:
                raise InputError(option, "found no --time; expected the column that the times are in")


def _span(clock: Clock, given: dict[str, Any]) -> Span:
    from rmfs_convert.lines import Span

    options = (("--from", given["begin"]), ("--until", given["end"]), ("--start", given["start"]))
    return Span(*(None if text is None else clock.option(option, text) for option, text in options))


def _check_share(lines: OrderLines, table: Path, force: bool) -> None:
    """Refuse a table most of whose rows would be left out, though no option asks for that."""
    from rmfs_core.errors import InputError

    left, rows = lines.cleaner.dropped.unasked, lines.cleaner.rows
    if left > MOST_LEFT_OUT * rows and not force:
        found = f"{left:,} of {rows:,} rows would be left out: {'; '.join(lines.cleaner.left_out())}"
        raise InputError(str(table), f"{found}; expected at most half, or --force")


def _stock(lines: OrderLines, given: dict[str, Any]) -> Stock | None:
    """Return where the SKUs stand; None without pods."""
    from rmfs_convert.placement import place
    from rmfs_convert.writing import Stock
    from rmfs_core.randomness import stream

    if given["pods"] is None:
        return None
    placement, skus = given["placement"], lines.skus()
    baskets = lines.baskets(BASKETS) if placement == "co-purchase" else ()
    random = stream(given["seed"], "pod contents")
    held = place(skus, given["pods"], given["skus_per_pod"], placement, random, baskets)
    return Stock(skus, held, given["items"])
