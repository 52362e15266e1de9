"""The files made of tables, written all together or not at all, and the sentences about them."""

from __future__ import annotations

import csv
import io
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from pathlib import Path

from attrs import frozen

from rmfs_commands.cli.loads import HOUR, Demand, Load, load_sentences, told_hours
from rmfs_commands.cli.screen import tell
from rmfs_commands.convert.history import Learned
from rmfs_commands.convert.lines import LACK, OrderLines, Sku
from rmfs_commands.convert.names import short
from rmfs_commands.convert.placement import items_on
from rmfs_commands.convert.scenarios import (
    MOST_PEAK_PERCENT,
    MOST_PERCENT,
    ROBOTS_PER_STATION,
    SHIFT_H,
    Opens,
    Size,
    quiet_hours,
    scenario_of,
    size_for,
)
from rmfs_commands.convert.shares import warn_of_share
from rmfs_commands.convert.stock_table import StockTable
from rmfs_commands.convert.time_formats import Moment
from rmfs_commands.convert.times import offset
from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.results.files import AtomicFile, staged, write_text
from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.timetable import DAY
from rmfs_core.wording import counted, listed

LARGEST = 5
"""Lines that are named, those with most items."""

MANY = 5
"""Items of a line, on average, from which on times of single items make most of the pickers' time."""

SCENARIO = "scenario.toml"

LEFT_OUT = "left-out.csv"
"""Order lines that stock cannot serve."""

_DIFFERENT = (
    ("times", "times", "the earliest"),
    ("dues", "due times", "the earliest"),
    ("priorities", "priorities", "the highest"),
    ("routes", "routes", "the first by name"),
)


@frozen
class Stock:
    """Where SKUs stand.

    Parameters
    ----------
    skus
        The SKUs.
    held
        The SKUs of each pod, as positions in ``skus``.
    items
        Least number of items of a SKU on each of its pods.
    learned
        The orders or popularity that placed them.
    """

    skus: Sequence[Sku]
    held: Sequence[Sequence[int]]
    items: int
    learned: Learned


def checked_start(start: str | None) -> str | None:
    """Return a time 0 as `rmfs convert orders` writes it; raise an `InputError` for one that no scenario takes."""
    try:
        Calendar(start).zero()
    except InputError as error:
        raise InputError("--start", error.problem) from None
    return None if start is None else datetime.fromisoformat(start).isoformat()


def write_pods(stock: StockTable, folder: Path, start: str | None = None, opens: Sequence[Opens] = ()) -> None:
    """Write pods.csv, and a scenario where there is none and pods stand anywhere; say what is in them."""
    own, scenario = stock.columns.row is not None, folder / SCENARIO
    made = not own and not scenario.exists()
    for option, given, key in (("--start", start, "instance.start"), ("--open", opens, "stations.open")):
        if given and not made:
            why = f"{scenario} is there already" if not own else "pods with locations get no scenario.toml"
            raise InputError(option, f"{why}; expected no {option} (a scenario has it as `{key}`)")
    with staged(folder) as place:
        _write_csv(place / "pods.csv", stock.lines())
        if made:
            demand, wanted = _demand_of(folder / "orders.csv")
            size, found = (None, []) if demand is None else size_for(len(stock.pods), demand, start, opens)
            write_text(place / SCENARIO, scenario_of(len(stock.pods), start, size=size, opens=opens))
    for sentence in stock.sentences():
        tell(sentence)
    warn_of_share(stock.file, stock)
    tell(f"Wrote {folder / 'pods.csv'}: {stock.total()}.")
    if made:
        tell(f"Wrote {scenario}; {_next_step(stock, folder, wanted)}")
        for sentence in [] if size is None or demand is None else _reckoning(size, found, demand, start, opens):
            tell(sentence)
        if start is None:
            tell("Its time 0 is a midnight; for orders with dates, give --start (`instance.start`).")


def _reckoning(
    size: Size, found: Sequence[Load], demand: Demand, start: str | None, opens: Sequence[Opens]
) -> list[str]:
    """Say what stations and robots were guessed, and what for, and where they are open in quiet nights."""
    guess = f"Guessed {counted(size.stations, 'station')} and {counted(size.robots, 'robot')}"
    aim = f"for loads of at most {MOST_PERCENT} %, and of {MOST_PEAK_PERCENT} % in the peak hour"
    if found[0].percent is None:
        aim = f"that pick within {SHIFT_H} hours what arrives at once"
    limits = {"stations": f"at most {size.stations:,}", "robots": "at most one for two storage locations"}
    capped = [
        f"The load asks for {wanted:,} {what}; {limits[what]} are guessed." for what, wanted in size.capped.items()
    ]
    usual = size.robots == ROBOTS_PER_STATION * size.stations
    aim += f"; robots are {ROBOTS_PER_STATION} for each station" if usual else ""
    said = [f"{guess} {aim}.", *capped, *load_sentences(found)]
    each = demand.items.total() / demand.lines.total()
    if each >= MANY:
        said.append(
            f"A line has {each:,.1f} items on average, and pickers handle each alone; `stations.line_s` with a short "
            "`stations.handle_s` and `pick_s` says what a line takes, and what an item more."
        )
    if not opens and (night := quiet_hours(demand, start)) is not None:
        begin, end = (f"{hour:02}:00" for hour in night)
        quiet = f"though little is ordered from {begin} to {end}"
        said.append(f"Stations are open all day, {quiet}: --open {end}-{begin} says when they are.")
    return said


def _next_step(stock: StockTable, folder: Path, wanted: Mapping[str, int]) -> str:
    """Say how the scenario is run, or what comes before that where the pods hold less than the orders want."""
    orders, held = folder / "orders.csv", stock.held()
    if short := sum(held.get(sku, 0) < items for sku, items in wanted.items()):
        of = f"the pods hold fewer items than the orders want of {short:,} of {counted(len(wanted), 'SKU')}"
        remedy = f"`rmfs convert orders` with --in-stock {folder / 'pods.csv'} --force leaves out what they lack"
        return f"it cannot run yet: {of}; {remedy}"
    needs = "" if orders.exists() else f"; it needs {orders}"
    return f"run it with: rmfs run {folder / SCENARIO}{needs}"


def _demand_of(file: Path) -> tuple[Demand | None, Counter[str]]:
    """Return what orders want that were converted before, and of each SKU; None where there is none."""
    demand, wanted = Demand(), Counter[str]()
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            for row in csv.DictReader(stream):
                demand.add(to_ticks(float(row["arrival_s"])), int(row["quantity"]))
                wanted[row["sku"]] += int(row["quantity"])
    except (OSError, ValueError, KeyError, TypeError, OverflowError, csv.Error):
        return None, Counter()
    return demand if demand.lines else None, wanted


def write(lines: OrderLines, folder: Path, zero: Moment, stock: Stock | None, opens: Sequence[Opens] = ()) -> None:
    """Write the files, all of them or none, and say what is in them and what is not."""
    with staged(folder) as place:
        with AtomicFile(place / "orders.csv") as stream:
            text = io.TextIOWrapper(stream, encoding="utf-8", newline="", write_through=True)
            totals, demand = lines.write(text, zero.tick)
            text.detach()
        told = [] if stock is None else _write_stock(stock, demand, place, folder, _start(lines, zero), opens)
        if lines.lacking is not None:
            _write_csv(place / LEFT_OUT, [("order", "sku", "quantity", "reason"), *lines.lacking])
    _tell_left_out(lines, folder)
    _tell_kept(lines, totals)
    clock, skus = lines.cleaner.reader.clock, len(lines.skus())
    start = " (`instance.start`)" if clock.dated else ""
    tell(
        f"Wrote {folder / 'orders.csv'}: {counted(lines.n_orders, 'order')}, {counted(lines.n_lines, 'line')}, "
        f"{counted(totals['items'], 'item')} of {counted(skus, 'SKU')}; "
        f"{f'{lines.cancelled:,} of the orders may be cancelled; ' if lines.cancelled else ''}"
        f"time 0 is {clock.iso(zero)}{start}, the last order arrives {demand.last / 3_600_000:.1f} hours later."
    )
    for sentence in told:
        tell(sentence)
    if stock is None and clock.dated:
        _warn_of_start(folder / SCENARIO, clock.iso(zero))


def _warn_of_start(scenario: Path, start: str) -> None:
    """Warn where a scenario that stays in the folder has another time 0 than the orders, and with it other hours."""
    try:
        instance = tomllib.loads(scenario.read_text(encoding="utf-8"))["instance"]
        if instance["orders_file"] != "orders.csv":
            return
        found, wanted = instance.get("start"), datetime.fromisoformat(start)
        there = datetime.fromisoformat(found or start[: len("2024-03-01")])
    except (OSError, ValueError, KeyError, TypeError):  # it is refused when it is run
        return
    offsets = {there.utcoffset(), wanted.utcoffset()} - {None}  # only one of them may have one
    if there.replace(tzinfo=None) != wanted.replace(tzinfo=None) or len(offsets) > 1:
        has = "no `instance.start`" if found is None else f'`instance.start` = "{found}"'
        expected = f'expected "{start}", time 0 of these orders: hours and dates would be others'
        tell(f"Warning: {scenario} has {has}; {expected}.", err=True)


def _write_csv(file: Path, rows: Iterable[Sequence[object]]) -> None:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    write_text(file, text.getvalue())


def _start(lines: OrderLines, zero: Moment) -> str | None:
    """Return `instance.start` for time 0; None where times are no dates and begin at midnight."""
    clock = lines.cleaner.reader.clock
    if clock.dated:
        return clock.iso(zero)
    return f"2000-01-01T{clock.iso(zero)}" if clock.of_day and zero.tick % DAY else None


def _write_stock(
    stock: Stock, demand: Demand, place: Path, folder: Path, start: str | None, opens: Sequence[Opens]
) -> list[str]:
    number, raised = items_on(stock.skus, stock.held, stock.items)
    pods = [(f"P{i}", stock.skus[sku].name, number[sku]) for i, pod in enumerate(stock.held, 1) for sku in pod]
    _write_csv(place / "pods.csv", [("pod", "sku", "quantity"), *pods])
    size, found = size_for(len(stock.held), demand, start, opens)
    write_text(place / SCENARIO, scenario_of(len(stock.held), start, stock.learned.sentence(), size, opens))
    wanted = "since the orders want more"
    more = f"; of {counted(raised, 'SKU')} more than {stock.items:,} on a pod, {wanted}" if raised else ""
    places = sum(map(len, stock.held))
    learned = stock.learned.sentence()
    return [
        *([] if learned is None else [learned]),
        f"Wrote {folder / 'pods.csv'}: {counted(len(stock.held), 'pod')} with {counted(places, 'place')}{more}.",
        f"Wrote {folder / SCENARIO}; run it with: rmfs run {folder / SCENARIO}",
        *_reckoning(size, found, demand, start, opens),
    ]


def tell_history(past: OrderLines) -> None:
    """Print how many rows of a table of history were read, and which were left out."""
    for sentence in past.cleaner.sentences(f" of {past.file}"):
        tell(sentence)
    warn_of_share(past.file, past.cleaner)


def _tell_left_out(lines: OrderLines, folder: Path) -> None:
    if lines.heads is not None:
        for sentence in lines.heads.sentences():
            tell(sentence)
        warn_of_share(lines.heads.file, lines.heads.cleaner)
    for sentence in lines.cleaner.sentences():
        tell(sentence)
    for reason, number in lines.left_out.items():
        tell(f"Left out: {counted(number, 'order')} with {reason}.")
    if lines.lacking:
        orders, skus, quantities = zip(*(one[:3] for one in lines.lacking if one[3] == LACK), strict=True)
        of = f"{counted(sum(quantities), 'item')} of {counted(len({*skus}), 'SKU')}"
        found = f"{counted(len(skus), 'line')} of {counted(len({*orders}), 'order')}, {of}"
        tell(f"Left out for lack of stock: {found}; {folder / LEFT_OUT} names them.")
    if lines.shortened:
        tell(f"Shortened: {counted(lines.shortened, 'order')} lost a line (--whole-orders leaves them out).")
    warn_of_share(lines.file, lines.cleaner)


def _tell_kept(lines: OrderLines, totals: Counter[str]) -> None:
    if number := lines.cleaner.reader.names.respelled:
        tell(f"Names with accents apart from their letters (NFD): {number:,}; they are spelled as one sign (NFC).")
    if lines.joined:
        tell(f"SKUs that an order repeats: {counted(lines.joined, 'row')}; quantities are added up.")
    of = "Lines" if lines.heads is None else "Headers"
    for what, kind, chosen in _DIFFERENT:
        if (several := lines.several[what]).rows:
            apart = f", up to {told_hours(lines.most_apart / HOUR)} apart" if what == "times" else ""
            told = f"{of} with different {kind}: {counted(several.rows, 'order')}{several.shown()}{apart}"
            tell(f"{told}; {chosen} is the order's.")
    for what, before, then in (
        ("Due", lines.due_before, "late whenever they are completed"),
        ("Cancelled", lines.cancelled_before, "cancelled as they arrive"),
    ):
        if before.rows:
            tell(f"{what} before they arrive: {counted(before.rows, 'order')}{before.shown()}; they are {then}.")
    if totals["early"]:
        tell(f"Due before time 0: {counted(totals['early'], 'order')}; 0 is written.")
    if len(lines.offsets) > 1:
        found = listed(map(offset, lines.offsets))
        tell(f"Times with offsets from UTC of {found}: hours of the day are by the clock of time 0 (--start).")
    largest = (f"{items:,} of {short(sku)} (order {short(name)})" for name, sku, items in lines.largest(LARGEST))
    tell(f"Largest lines: {', '.join(largest)}.")
