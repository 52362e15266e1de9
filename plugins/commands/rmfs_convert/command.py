"""``rmfs convert``: tables of a warehouse management system to the files that a scenario reads."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_cli.options import OutPath

if TYPE_CHECKING:
    from rmfs_convert.lines import OrderLines, Sku

BASKETS = 200_000
"""Orders that are looked at to say which SKUs are bought together."""

_DIFFERENT = (
    ("times", "times", "the earliest"),
    ("dues", "due times", "the earliest"),
    ("priorities", "priorities", "the highest"),
)


@click.group()
def convert() -> None:
    """Make a scenario's files from the tables of a warehouse."""


@convert.command(short_help="Make orders.csv from a table of order lines.")
@click.argument("table", metavar="LINES", type=click.Path(path_type=Path))
@click.option("--out", required=True, metavar="DIR", type=OutPath(), help="Folder to write to.")
@click.option("--order", "order_column", required=True, metavar="COL", help="Column with the order's number or name.")
@click.option("--sku", "sku_column", required=True, metavar="COL", help="Column with the SKU.")
@click.option("--time", "time_column", metavar="COL", help="Column with the time of arrival. [default: all at time 0]")
@click.option("--quantity", "quantity_column", metavar="COL", help="Column with the items. [default: one each]")
@click.option(
    "--due", "due_column", metavar="COL", help="Column with the time at which an order is due. [default: none]"
)
@click.option(
    "--priority", "priority_column", metavar="COL", help="Column with the priority, higher first. [default: none]"
)
@click.option(
    "--time-format", metavar="FORMAT", help="How times are written: %d.%m.%Y %H:%M. [default: ISO 8601, or seconds]"
)
@click.option("--from", "begin", metavar="TIME", help="Leave out orders that arrive earlier.")
@click.option("--until", "end", metavar="TIME", help="Leave out orders that arrive then or later.")
@click.option("--start", metavar="TIME", help="Time 0 of the run. [default: the midnight before the first order]")
@click.option("--separator", default=",", show_default=True, metavar="SIGN", help="Between the fields of a CSV file.")
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
@click.option("--force", is_flag=True, help="Replace files that are there already.")
def orders(
    table: Path,
    out: Path,
    order_column: str,
    sku_column: str,
    time_column: str | None,
    quantity_column: str | None,
    due_column: str | None,
    priority_column: str | None,
    time_format: str | None,
    begin: str | None,
    end: str | None,
    start: str | None,
    separator: str,
    pods: int | None,
    skus_per_pod: int,
    items: int,
    placement: str,
    seed: int,
    force: bool,
) -> None:
    """Make orders.csv from LINES, a table (CSV or Parquet) with one order line a row.

    Rows of one order need not be adjacent, and may be any number: they are sorted on disk. What is left out is said,
    with the reason. With --pods, the SKUs are put on pods as well, and DIR/scenario.toml runs with both.
    """
    from rmfs_convert.lines import Columns, OrderLines
    from rmfs_convert.times import Clock
    from rmfs_core.errors import InputError
    from rmfs_core.results.files import output_folder

    if len(separator) != 1 or not separator.isascii():
        raise InputError("--separator", f"found {separator!r}; expected one sign of ASCII, such as ; or a tab")
    if due_column is not None and time_column is None:
        raise InputError("--due", "found no --time; expected both, since both are counted from time 0")
    folder = output_folder(out)
    files = ("orders.csv", *(("pods.csv", "scenario.toml") if pods is not None else ()))
    there = [str(folder / name) for name in files if (folder / name).exists()]
    if there and not force:
        raise InputError(", ".join(there), "found a file of that name; --force replaces it")
    clock = Clock(time_format)
    with OrderLines(clock) as lines:
        columns = Columns(order_column, sku_column, time_column, quantity_column, due_column, priority_column)
        lines.read(table, columns, separator)
        first = lines.gather(_time(clock, "--from", begin), _time(clock, "--until", end))
        zero = _time(clock, "--start", start)
        zero = clock.midnight_before(first) if zero is None else zero
        if zero > first:
            raise InputError("--start", f"found {start}, but the first order arrives at {clock.iso(first)}")
        skus = lines.skus()
        held = None if pods is None else _placed(lines, skus, pods, skus_per_pod, placement, seed)
        _write(lines, folder, zero, skus, held, items)


def _time(clock: object, option: str, text: str | None) -> int | None:
    from rmfs_convert.times import Clock
    from rmfs_core.errors import InputError

    assert isinstance(clock, Clock)
    if text is None:
        return None
    for pattern in dict.fromkeys((clock.pattern, None)):
        try:
            return Clock(pattern).tick(text)
        except ValueError:
            continue
    raise InputError(option, f'expected a time such as 2024-03-01T06:00, or as --time-format has it, found "{text}"')


def _placed(
    lines: OrderLines, skus: list[Sku], pods: int, skus_per_pod: int, placement: str, seed: int
) -> list[list[int]]:
    from rmfs_convert.placement import place
    from rmfs_core.randomness import stream

    baskets = lines.baskets(BASKETS) if placement == "co-purchase" else ()
    return place(skus, pods, skus_per_pod, placement, stream(seed, "pod contents"), baskets)


def _write(
    lines: OrderLines, folder: Path, zero: int, skus: list[Sku], held: list[list[int]] | None, items: int
) -> None:
    """Write the files, each whole or not at all, and say what is in them and what is not."""
    import io

    from rmfs_convert.placement import items_on
    from rmfs_core.results.files import AtomicFile, write_text
    from rmfs_core.wording import counted

    with AtomicFile(folder / "orders.csv") as stream:
        text = io.TextIOWrapper(stream, encoding="utf-8", newline="", write_through=True)
        totals = lines.write(text, zero)
        text.detach()
    click.echo(f"Read {lines.rows:,} rows.")
    for what, found in (("Left out", lines.dropped), ("Left empty", lines.emptied)):
        for reason, dropped in found.items():
            examples = ", ".join(f"row {row}" + (f' "{text}"' if text else "") for row, text in dropped.examples)
            click.echo(f"{what}: {dropped.rows:,} with {reason}" + (f": {examples}" if examples else "") + ".")
    if lines.joined:
        click.echo(f"SKUs that an order repeats: {counted(lines.joined, 'row')}; quantities are added up.")
    for what, kind, chosen in _DIFFERENT:
        if lines.several[what]:
            click.echo(
                f"Lines with different {kind}: {counted(lines.several[what], 'order')}; {chosen} is the order's."
            )
    if totals["early"]:
        click.echo(f"Due before time 0: {counted(totals['early'], 'order')}; 0 is written.")
    click.echo(
        f"Wrote {folder / 'orders.csv'}: {counted(lines.n_orders, 'order')}, {counted(lines.n_lines, 'line')}, "
        f"{counted(totals['items'], 'item')} of {counted(len(skus), 'SKU')}; "
        f"time 0 is {lines.clock.iso(zero)}, the last order arrives {totals['last'] / 3_600_000:.1f} hours later."
    )
    if held is None:
        return
    number, raised = items_on(skus, held, items)
    rows = [f"P{i},{_field(skus[sku].name)},{number[sku]}\n" for i, pod in enumerate(held, 1) for sku in pod]
    write_text(folder / "pods.csv", "pod,sku,quantity\n" + "".join(rows))
    write_text(folder / "scenario.toml", _scenario(len(held)))
    more = f"; of {raised:,} SKUs more than {items:,} on a pod, since the orders want more" if raised else ""
    click.echo(f"Wrote {folder / 'pods.csv'}: {len(held):,} pods with {len(rows):,} places{more}.")
    click.echo(f"Wrote {folder / 'scenario.toml'}; run it with: rmfs run {folder / 'scenario.toml'}")


def _field(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if any(sign in name for sign in ',"\r\n') else name


def _scenario(pods: int) -> str:
    """Return a scenario with a block layout that has room for the pods, and a station and eight robots for each 100."""
    from math import ceil, sqrt

    blocks = ceil(pods / 0.85 / 8)
    rows = max(2 * ceil(sqrt(blocks / 2.5) / 2) + 1, 3)
    columns = max(ceil(blocks / rows), 2)
    stations = max(1, min(ceil(pods / 100), (rows - 1) // 2))
    return f"""# Orders and pods made by `rmfs convert orders`. The layout, its stations and
# robots are a guess.

seed = 1

[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"

[layout]
block_rows = {rows}
block_columns = {columns}
stations_east = {stations}

[robots]
count = {max(4, 8 * stations)}

[stations]
item_capacity = 100

[rules]
poa = "pod-match"
pps = "demand"
"""
