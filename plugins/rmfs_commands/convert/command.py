"""``rmfs convert``: tables of a warehouse management system to the files that a scenario reads."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rmfs_commands.cli.options import OutPath, WholeNumberRange
from rmfs_commands.convert.options import (
    needs,
    number_options,
    only_option,
    open_option,
    quantities_of,
    spelled,
    table_options,
    time_options,
)
from rmfs_commands.convert.pods_command import pods as pods_command

if TYPE_CHECKING:
    from rmfs_commands.convert.lines import OrderLines, Span
    from rmfs_commands.convert.time_formats import Moment
    from rmfs_commands.convert.times import Clock
    from rmfs_commands.convert.writing import Stock

BASKETS = 200_000
"""Orders that are looked at to say which SKUs are bought together."""

LEARNING = "co-purchase"
"""The placement where there is a history, unless told."""

OF_DAY = (
    "Column with the time of the day, where --time has the date alone; --time-format is of both with a blank between."
)

OF_TIMES = ("time_of_day", "time_format", "zone", "due", "cancelled", "from", "until", "start", "history_until")
"""Options that need --time."""

NOT_OF_HISTORY = ("time", *OF_TIMES, "priority", "route", "orders", "order_key", "only_orders", "in_stock")
"""Options that do not matter for a table of history."""


@click.group()
def convert() -> None:
    """Make a scenario's files from the tables of a warehouse."""


convert.add_command(pods_command)


@convert.command(short_help="Make orders.csv from a table of order lines.")
@click.argument("table", metavar="LINES", type=click.Path(path_type=Path))
@click.option("--out", required=True, metavar="DIR", type=OutPath(), help="Folder to write to.")
@click.option("--order", required=True, metavar="COL", help="Column with the order's number or name.")
@click.option("--sku", required=True, metavar="COL", help="Column with the SKU.")
@click.option("--time", metavar="COL", help="Column with the time of arrival. [default: all at time 0]")
@click.option("--time-of-day", metavar="COL", help=OF_DAY)
@click.option("--quantity", metavar="COL", help="Column with the items. [default: one each]")
@click.option("--due", metavar="COL", help="Column with the time at which an order is due. [default: none]")
@click.option("--priority", metavar="COL", help="Column with the priority, higher first. [default: none]")
@click.option("--cancelled", metavar="COL", help="Column with the time at which an order is cancelled. [default: none]")
@click.option("--route", metavar="COL", help="Column with the route of `instance.departures`. [default: none]")
@click.option(
    "--orders",
    metavar="TABLE",
    type=click.Path(path_type=Path),
    help="Table with a header for each order: --time, --due, --priority, --cancelled, --route are columns of it.",
)
@click.option("--order-key", metavar="COL", help="Column of --orders with the order. [default: as --order]")
@partial(only_option, name="--only-orders", of=" of --orders")
@only_option
@time_options
@click.option("--from", metavar="TIME", help="Leave out orders that arrive earlier.")
@click.option("--until", metavar="TIME", help="Leave out orders that arrive then or later.")
@click.option("--start", metavar="TIME", help="Time 0 of the run. [default: the midnight before the first order]")
@table_options
@number_options
@click.option("--leave-out-sku", multiple=True, metavar="SKU", help="Leave out the lines of a SKU; may be repeated.")
@click.option(
    "--most-quantity",
    type=WholeNumberRange(1, 1_000_000),
    default=1_000_000,
    metavar="N",
    help="Leave out lines of more than N items. [default: 1,000,000, the most that a run takes]",
)
@click.option(
    "--whole-orders", is_flag=True, help="Leave out orders that lose a line, other than one of --leave-out-sku."
)
@click.option(
    "--in-stock",
    metavar="PODS",
    type=click.Path(path_type=Path),
    help="Leave out lines, by arrival, for which PODS, a pods.csv, holds too few items; DIR/left-out.csv names them, "
    "and with --whole-orders the other lines of their orders.",
)
@click.option("--pods", type=WholeNumberRange(1, 1_000_000), metavar="N", help="Put the SKUs on that many pods, too.")
@click.option(
    "--skus-per-pod",
    type=WholeNumberRange(1, 10_000),
    default=20,
    show_default=True,
    metavar="N",
    help="SKUs on each pod.",
)
@click.option(
    "--items",
    type=WholeNumberRange(1, 1_000_000),
    default=10,
    show_default=True,
    metavar="N",
    help="Items of a SKU on each of its pods; more where the orders want more than that in all.",
)
@click.option(
    "--placement",
    type=click.Choice(["random", "popularity", "co-purchase"]),
    help=f"Which SKUs stand on more pods, and which stand together. [default: {LEARNING} with a history, else random]",
)
@click.option(
    "--history",
    metavar="TABLE",
    type=click.Path(path_type=Path),
    help="Place by the order lines of another table, with columns of the same names.",
)
@click.option(
    "--history-until", metavar="TIME", help="Place by the orders that arrive earlier, and run the later ones."
)
@open_option
@click.option("--seed", type=WholeNumberRange(min=0), default=1, show_default=True, help="Seed of the placement.")
@click.option("--force", is_flag=True, help="Replace files, and write also where most rows are left out.")
def orders(table: Path, out: Path, **given: Any) -> None:
    """Make orders.csv from LINES, a table (CSV or Parquet) with one order line per row.

    Rows of one order need not be adjacent, and may be any number: they are sorted on disk. Every row left out is
    reported with its reason. With --pods, the SKUs are put on pods as well, and DIR/scenario.toml runs with both.
    """
    from rmfs_commands.cli.file_writing import writable_folder
    from rmfs_commands.convert.shares import check_emptied, check_share
    from rmfs_commands.convert.tables import check_there
    from rmfs_commands.convert.times import Clock
    from rmfs_commands.convert.writing import tell_history, write
    from rmfs_commands.results.files import removed_if_empty

    _check_options(given)
    _span(Clock(given["time_format"], given["zone"]), given)  # what is no time is refused before a table is read
    check_there(table, given["orders"], given["history"], given["in_stock"])
    names = ["orders.csv", *(("pods.csv", "scenario.toml") if given["pods"] is not None else ())]
    names += ["left-out.csv"] * (given["in_stock"] is not None)
    with ExitStack() as stack:
        stack.enter_context(removed_if_empty(out))
        folder = writable_folder(out, names, force=given["force"])
        lines, zero = _read(stack, table, given)
        lines.cleaner.check_choice(lambda: [sku.name for sku in lines.skus()])
        check_share(table, lines.cleaner, force=given["force"])
        check_emptied(table, lines.cleaner, force=given["force"])
        past = None
        if given["history"] is not None:
            past = _read_history(stack, given)
            check_share(given["history"], past.cleaner, force=given["force"])
        elif given["history_until"] is not None:
            past, _ = _read(stack, table, given, past=True)
        write(lines, folder, zero, _stock(lines, past, table, given), given["open"] or ())
        if past is not None and given["history"] is not None:
            tell_history(past)


def _read(stack: ExitStack, table: Path, given: dict[str, Any], past: bool = False) -> tuple[OrderLines, Moment]:
    """Return the orders of a table, and of that with their headers if there is one; and time 0.

    These are the orders that are run, or else those of the past.
    """
    from attrs import evolve

    from rmfs_commands.convert.cleaning import Choice, Cleaner, Columns, Reader
    from rmfs_commands.convert.lines import OrderLines
    from rmfs_commands.convert.shares import check_emptied, check_share
    from rmfs_commands.convert.tables import Table
    from rmfs_commands.convert.times import Clock
    from rmfs_commands.instances.csv_files import read_stock

    clock = Clock(given["time_format"], given["zone"])
    reader = Reader(clock, quantities_of(given), quantities_of(given))
    names = ("order", "sku", "time", "quantity", "due", "priority", "time_of_day", "cancelled", "route")
    columns = Columns(*(given[name] for name in names))
    heads = None
    if given["orders"] is not None:
        heads = evolve(columns, order=given["order_key"] or columns.order, sku=None, quantity=None)
        columns = Columns(columns.order, columns.sku, quantity=columns.quantity)
    how = given["separator"], given["encoding"]
    choice = Choice(given["leave_out_sku"], given["most_quantity"])
    lines = stack.enter_context(OrderLines(Cleaner(columns, reader, choice)))
    if heads is not None:
        own = Cleaner(heads, reader, Choice(first_rows=given["orders"].resolve() == table.resolve()))
        headers = Table(given["orders"], *how, given["only_orders"], "--only-orders")
        lines.read_heads(headers, own)
        check_share(given["orders"], own, force=given["force"])
        check_emptied(given["orders"], own, force=given["force"])
    lines.read(Table(table, *how, given["only"]))
    in_stock = None if past or given["in_stock"] is None else read_stock(given["in_stock"])
    return lines, lines.gather(_span(clock, given, past), given["whole_orders"], in_stock)


def _read_history(stack: ExitStack, given: dict[str, Any]) -> OrderLines:
    """Return the orders of a table of history; what is wrong with it is told with how it is read."""
    from rmfs_core.errors import InputError

    table: Path = given["history"]
    try:
        past, _ = _read(stack, table, given | dict.fromkeys(NOT_OF_HISTORY))
        past.cleaner.unused = []  # times, which do not matter, and what the order lines have, too
    except InputError as error:
        if not table.is_file():
            raise
        how = "--history is read with the columns, the separator and the encoding of the order lines"
        raise InputError(error.place, f"{error.problem} ({how})") from None
    return past


def _check_options(given: dict[str, Any]) -> None:
    """Refuse options that do not go together."""
    from rmfs_core.errors import InputError

    for option in OF_TIMES:
        needs(given, option, "time", "the column that the times are in")
    needs(given, "order_key", "orders", "the table with headers that it is a column of")
    needs(given, "only_orders", "orders", "the table of which only some rows are read")
    needs(given, "open", "pods", "both, since scenario.toml has the hours (or `rmfs convert pods --open`)")
    if given["pods"] is not None and given["in_stock"] is not None:
        raise InputError("--in-stock", "found --pods, too, whose pods hold all that is ordered; expected one of them")
    for option in ("history", "history_until"):
        needs(given, option, "pods", "both, since the history says what stands on them")
        if given[option] is not None and given["placement"] == "random":
            found = "found --placement random, which learns nothing; expected another placement"
            raise InputError(spelled(option), found)
    if given["history"] is not None and given["history_until"] is not None:
        raise InputError("--history-until", "found --history, too; expected one of them")


def _span(clock: Clock, given: dict[str, Any], past: bool = False) -> Span:
    """Return the span of the orders that are run, or else of those of the past."""
    from rmfs_commands.convert.lines import Span

    begin, end, start, until = (
        None if given[name] is None else clock.option(spelled(name), given[name])
        for name in ("from", "until", "start", "history_until")
    )
    return Span(begin, until, options="--from, --history-until") if past else Span(begin, end, start, until)


def _stock(lines: OrderLines, past: OrderLines | None, table: Path, given: dict[str, Any]) -> Stock | None:
    """Return where the SKUs stand, as orders of the past would have them; None without pods."""
    from rmfs_commands.convert.history import Learned, merged
    from rmfs_commands.convert.placement import place
    from rmfs_commands.convert.writing import Stock
    from rmfs_core.randomness import stream

    if given["pods"] is None:
        return None
    placement = given["placement"] or ("random" if past is None else LEARNING)
    skus, source, forgotten = lines.skus(), None, 0
    if past is not None:
        forgotten = _forget(past, lines, given) if given["history"] is not None else 0
        source = given["history"] or f"{table} before {given['history_until']}"
        skus = merged(skus, past.skus())
    baskets = (past or lines).baskets(BASKETS) if placement == "co-purchase" else ()
    random = stream(given["seed"], "pod contents")
    held = place(skus, [given["skus_per_pod"]] * given["pods"], placement, random, baskets)
    orders, unknown = (past or lines).n_orders, sum(sku.lines == 0 for sku in skus)
    learned = Learned(placement, None if source is None else str(source), orders, forgotten, len(skus), unknown)
    return Stock(skus, held, given["items"], learned)


def _forget(past: OrderLines, lines: OrderLines, given: dict[str, Any]) -> int:
    """Leave out of the history the orders that are run; return how many."""
    from rmfs_core.errors import InputError

    found = past.forget(lines.names())
    if not past.n_orders:
        raise InputError(str(given["history"]), f"all its orders ({found:,}) are run; expected other orders")
    return found
