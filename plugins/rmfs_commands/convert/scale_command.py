"""``rmfs scale``: another day's orders, drawn from those of a file."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from rmfs_commands.cli.options import NumberRange, OutPath, WholeNumberRange


@click.command(short_help="Draw another day from a file of orders: growth, peaks.")
@click.argument("orders", metavar="ORDERS", type=click.Path(path_type=Path))
@click.option("--out", required=True, metavar="FILE", type=OutPath(), help="File to write the orders to.")
@click.option(
    "--by",
    type=NumberRange(0.001, 1000),
    default=1.0,
    metavar="X",
    help="Mean number of copies of each order; below 1 some are left out. [default: 1]",
)
@click.option(
    "--peak",
    "peaks",
    multiple=True,
    metavar="HH:MM-HH:MM=X",
    help="X times as many orders at that time of the day; 0: none. May be repeated; where two hold, both count.",
)
@click.option("--route", metavar="COL", help="Column with the route of `instance.departures`. [default: none]")
@click.option("--start", metavar="TIME", help="Time 0, as the scenario's `instance.start`. [default: midnight]")
@click.option("--seed", type=WholeNumberRange(min=0), default=1, show_default=True, help="Seed of the draw.")
@click.option("--force", is_flag=True, help="Replace a file that is there already.")
def scale(
    orders: Path,
    out: Path,
    by: float,
    peaks: tuple[str, ...],
    route: str | None,
    start: str | None,
    seed: int,
    *,
    force: bool,
) -> None:
    """Write a day that a seed draws from ORDERS, a file as `instance.orders_file` names one.

    Whole orders are drawn, with their lines, priorities, routes, and times until they are due or cancelled. They arrive
    at about their times of the day. The scenario key `instance.scale` draws the same way with a run's seed.
    """
    from attrs import evolve

    from rmfs_commands.cli.csv_writing import orders_csv
    from rmfs_commands.cli.file_writing import write_files
    from rmfs_commands.cli.screen import tell
    from rmfs_commands.instances.calendar import Calendar
    from rmfs_commands.instances.csv_files import read_orders
    from rmfs_commands.instances.days import draw_day, read_peaks
    from rmfs_core.errors import InputError
    from rmfs_core.randomness import stream
    from rmfs_core.scenario.model import Departures
    from rmfs_core.wording import counted
    from rmfs_core.world import Instance

    spans, calendar = read_peaks(peaks, "--peak"), Calendar(start)
    try:
        zero = calendar.time_of_day()
    except InputError as error:
        raise InputError("--start", error.problem) from None
    if not str(orders).isprintable():
        raise InputError("ORDERS", f"expected a name that can be printed in a line, found {str(orders)!r}")
    if not orders.is_file():
        raise InputError("ORDERS", f"there is no file {orders}")
    departures = None if route is None else Departures((), column=route)
    ids: dict[str, int] = {}
    try:
        read = read_orders(orders, calendar, departures=departures)
    except InputError as error:
        raise InputError("--route", error.problem) if error.place == "instance.departures.column" else error from None
    given = [
        evolve(order, lines=tuple((ids.setdefault(sku, len(ids)), items) for sku, items in lines.items()))
        for order, lines in read
    ]
    found = draw_day(given, by, spans, stream(seed, "drawn day"), zero, "--by")
    options = ["--by", f"{by:g}", *(text for peak in peaks for text in ("--peak", peak))]
    given_once = ("--route", route), ("--start", start)
    options += [text for name, told in given_once if told is not None for text in (name, told)]
    command = shlex.join(["rmfs", "scale", orders.name, *options, "--seed", str(seed)])
    totals = f"{counted(len(found), 'order')} of {len(given):,}"
    comment = f"# {totals} drawn by `{command}`; times count from {start or 'midnight'}.\n"
    content = comment + orders_csv(Instance(tuple(ids), found, ()), route)
    write_files(out.parent, {out.name: content.encode()}, force=force)
    lines = sum(len(order.lines) for order in found)
    items = sum(order.items for order in found)
    tell(f"Wrote {out}: {totals}, {counted(lines, 'line')}, {counted(items, 'item')}.")
