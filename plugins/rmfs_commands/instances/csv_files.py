"""Orders, pods, SKUs and bundles from CSV files, with the line of whatever is wrong.

It is the entry point ``csv`` of the group ``rmfs.formats``: what reads the files that a scenario names.
"""

from __future__ import annotations

import csv
import math
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from pathlib import Path
from typing import Any, TextIO

from attrs import evolve

from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.instances.days import drawn  # noqa: F401 (the kernel looks for it here)
from rmfs_commands.instances.departures import TIMES, departing  # noqa: F401 (likewise)
from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import Departures, Replenishment, Scenario
from rmfs_core.timetable import DAY
from rmfs_core.wording import counted, did_you_mean, listed, sentence
from rmfs_core.world import BundleData, Instance, OrderData, PodData
from rmfs_core.world.instance_making import Wrong, refuse

ORDER_COLUMNS = ("order", "arrival_s", "sku", "quantity")
POD_COLUMNS = ("pod", "sku", "quantity")
PLACE_COLUMNS = ("row", "column")  # which pods may have besides
BUNDLE_COLUMNS = ("bundle", "arrival_s", "sku", "items")
SKU_COLUMNS = ("size", "reorder_point", "order_up_to")  # which a file of SKUs may have besides
DUE_COLUMNS = ("due_s", "priority")  # which orders may have besides
CANCELLED_COLUMNS = ("cancelled_s",)  # and these
_DATES = {"arrival_s": "arrival", "due_s": "due", "cancelled_s": "cancelled"}  # ISO 8601 instead of seconds
_NAMES = ("bundle", "order", "pod", "robot", "sku")
_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}  # that are taken for commas elsewhere
_WARNED, _MOST_OF_A_LINE = set[str](), 1_000_000  # signs: a device may have no line's end
_kept: ContextVar[list[str] | None] = ContextVar("kept", default=None)
MOST_ITEMS_OF_LINE = 1_000_000  # of a row: with more a run would go on for years
TEN_YEARS = 3_653 * DAY  # what comes later has a wrong year, or counts from 1970

Place = tuple[int, int, str]  # as in PodData
_WHOLE = re.compile(r"[0-9]{1,10}")  # sums of them over a file fit into 64 bits
_NUMBER = re.compile(r"[0-9]{1,12}(\.[0-9]*)?([eE][+-]?[0-9]{1,2})?|\.[0-9]+")


def read_instance(
    orders_file: Path,
    pods_file: Path,
    start: str | None = None,
    wrong: Wrong = refuse,
    departures: Departures | None = None,
) -> Instance:
    """Read orders and pods.

    Orders get their ids in the order of arrival, then of first appearance in the file; pods in the order of first
    appearance; SKUs in natural order of their names (``A2`` before ``A10``).

    Parameters
    ----------
    orders_file
        CSV with the columns ``order,arrival_s,sku,quantity``, one line of an order a row, and perhaps ``due_s``,
        ``priority`` (higher first) and ``cancelled_s``, empty where an order has none. ``arrival``, ``due`` and
        ``cancelled`` instead of the columns with ``_s`` are times as ISO 8601. Other columns are ignored, and named on
        standard error, as is the first order whose rows are not adjacent; a SKU that comes twice in an order is one
        line of both quantities.
    pods_file
        CSV with the columns ``pod,sku,quantity``, and perhaps ``row`` and ``column`` of the storage location in which
        the pod stands at time 0. An empty quantity is an unlimited number of items.
    start
        Time 0 as ISO 8601; None: midnight before the earliest of the times that are dates, by the clock of its offset.
    wrong
        Called with each mistake: an `InputError` with file, line and column. It raises the first unless told otherwise.
    departures
        Whose column of the orders' file has the route of each order; None: orders have none.
    """
    orders, pods = read_orders(orders_file, Calendar(start), wrong, departures), _read_pods(pods_file, wrong)
    names = {sku for _, lines in orders for sku in lines} | {sku for _, pod in pods.values() for sku in pod}
    skus = tuple(sorted(names, key=_natural))
    id_of = {sku: i for i, sku in enumerate(skus)}
    return Instance(
        skus=skus,
        orders=tuple(
            evolve(order, lines=tuple((id_of[sku], quantity) for sku, quantity in lines.items()))
            for order, lines in orders
        ),
        pods=tuple(
            PodData(name, tuple((id_of[sku], quantity) for sku, quantity in contents.items()), place)
            for name, (place, contents) in pods.items()
        ),
    )


def restocked(instance: Instance, scenario: Scenario, wrong: Wrong = refuse) -> Instance:
    """Add to an instance what a scenario and its files know of the SKUs, and of the bundles to come."""
    section, folder = scenario.instance, Path(scenario.folder)
    given = section.replenishment or Replenishment()
    coming = {} if given.file is None else read_bundles(folder / given.file, wrong)
    skus = tuple(dict.fromkeys([*instance.skus, *(sku for _, sku, _, _ in coming.values())]))
    told = {} if section.skus_file is None else read_skus(folder / section.skus_file, wrong)
    ids = {sku: i for i, sku in enumerate(skus)}
    bundles = [
        BundleData(name, arrival_tick=tick, sku=ids[sku], items=items) for name, (tick, sku, items, _) in coming.items()
    ]
    return evolve(
        instance,
        skus=skus,
        sizes=tuple(int(told.get(sku, {}).get("size", 1)) for sku in skus) if told else (),
        bundles=tuple(sorted(bundles, key=lambda bundle: bundle.arrival_tick)),
        levels=tuple(_levels(instance, scenario, given, told)) if given.process == "reorder-point" else (),
        restocked=given.process != "none",
    )


def _levels(
    instance: Instance, scenario: Scenario, given: Replenishment, told: Mapping[str, Mapping[str, float]]
) -> Iterator[tuple[int, int]]:
    """Yield s and S of each SKU in items.

    Where orders do not wait for stock, nothing tells that one lacks some: s is then at least what lets no single order
    line wait forever.
    """
    waits = scenario.rules.wait_for_stock is not False
    wanted, largest = Counter[int](), Counter[int]()
    for order in instance.orders:
        for sku, quantity in order.lines:
            wanted[sku] += quantity
            largest[sku] = max(largest[sku], quantity)
    days = max(max((order.arrival_tick for order in instance.orders), default=0) / to_ticks(86_400), 1)
    for sku, name in enumerate(instance.skus):
        own = told.get(name, {})
        s, up_to = own.get("reorder_point", given.reorder_point), own.get("order_up_to", given.order_up_to)
        if s is None or up_to is None:
            key = "reorder_point" if s is None else "order_up_to"
            raise InputError(
                f"instance.replenishment.{key}", f"expected a number, or one for SKU {name} in the file of SKUs"
            )
        if s >= up_to:
            problem = f"expected order_up_to > reorder_point, found {up_to:g} <= {s:g} for SKU {name}"
            raise InputError("instance.replenishment", problem)
        unit = wanted[sku] / days if given.unit == "days" else 1
        least = math.floor(s * unit) if waits else max(math.floor(s * unit), largest[sku] - 1)
        yield least, max(math.ceil(up_to * unit), least + 1)


def line_of(orders_file: Path, order: str, sku: str | None = None) -> int:
    """Line on which an order of a file that was read appears first, or its first row of a SKU."""
    rows = _rows(orders_file, ORDER_COLUMNS)
    return next(line for line, row in rows if row["order"] == order and sku in (None, row["sku"]))


def read_stock(file: Path) -> dict[str, int | None]:
    """Read how many items of each SKU there are on all pods of a CSV ``pod,sku,quantity``; None: they never run out."""
    stock: dict[str, int | None] = {}
    for _, contents in _read_pods(file, refuse).values():
        for sku, items in contents.items():
            held = stock.get(sku, 0)
            stock[sku] = None if held is None or items is None else held + items
    return stock


def read_profile(file: Path) -> tuple[float, ...]:
    """Read the weights of the hours of a day from a CSV with the columns ``hour,weight``; hours left out have 0."""
    weights = dict.fromkeys(map(str, range(24)), 0.0)
    for line, row in _rows(file, ("hour", "weight")):
        if row["hour"] not in weights or not _NUMBER.fullmatch(row["weight"]):
            found = f"{row['hour'] or 'nothing'} and {row['weight'] or 'nothing'}"
            raise InputError(f"{file}, line {line}", f"expected an hour from 0 to 23 and a weight >= 0, found {found}")
        weights[row["hour"]] += float(row["weight"])
    if not any(weights.values()):
        raise InputError(str(file), "expected an hour with a weight above 0, found none")
    return tuple(weights.values())


def read_times(file: Path) -> tuple[float, ...]:
    """Read measured times in seconds from a CSV with a column ``seconds``."""
    times = []
    for line, row in _rows(file, ("seconds",)):
        if not _NUMBER.fullmatch(row["seconds"]) or float(row["seconds"]) > 3600:
            found = row["seconds"] or "nothing"
            raise InputError(f"{file}, line {line}", f"expected a number of seconds from 0 to 3600, found {found}")
        times.append(float(row["seconds"]))
    if not times:
        raise InputError(str(file), "expected a time below the header, found none")
    return tuple(times)


def read_bundles(file: Path, wrong: Wrong = refuse) -> dict[str, tuple[int, str, int, str]]:
    """Read tick of arrival, SKU, items and line of bundles by name; a CSV ``bundle,arrival_s,sku,items``."""
    bundles: dict[str, tuple[int, str, int, str]] = {}

    def add(line: int, row: dict[str, str]) -> None:
        place = f"{file}, line {line}"
        tick = _tick(row.get("arrival_s", ""), f"{place}, arrival_s")
        if tick > TEN_YEARS:
            late = f"found {row['arrival_s']}; expected a time within ten years from time 0 on"
            raise InputError(f"{place}, arrival_s", late)
        items = _quantity(row["items"], file, line, "a whole number >= 1", column="items")
        if row["bundle"] in bundles:
            raise InputError(place, f"found bundle {row['bundle']} again; expected each once")
        bundles[row["bundle"]] = tick, row["sku"], items, place

    _each_row(_rows(file, BUNDLE_COLUMNS, (), wrong), add, wrong)
    return bundles


def read_skus(file: Path, wrong: Wrong = refuse) -> dict[str, dict[str, float]]:
    """Read what a CSV ``sku[,size][,reorder_point][,order_up_to]`` says of SKUs; what is left empty is left out."""
    skus: dict[str, dict[str, float]] = {}

    def add(line: int, row: dict[str, str]) -> None:
        told = {name: text for name, text in row.items() if name in SKU_COLUMNS and text}
        for name, text in told.items():
            if name == "size":
                _quantity(text, file, line, "a whole number >= 1", column=name)
            elif not _NUMBER.fullmatch(text) or float(text) > 1e9:
                raise InputError(f"{file}, line {line}, {name}", f'expected a number from 0 to 1e9, found "{text}"')
        if row["sku"] in skus:
            raise InputError(f"{file}, line {line}, sku", f"found SKU {row['sku']} again; expected each once")
        skus[row["sku"]] = {name: float(text) for name, text in told.items()}

    _each_row(_rows(file, ("sku",), SKU_COLUMNS, wrong), add, wrong)
    return skus


def read_orders(
    file: Path, calendar: Calendar, wrong: Wrong = refuse, departures: Departures | None = None
) -> list[tuple[OrderData, dict[str, int]]]:
    """Return each order, still without lines, and its quantities by SKU; by arrival, then by first appearance."""
    dates = {date: partial(calendar.tick, column=date) for date in _DATES.values()}
    seconds = {column: partial(_tick, date=date) for column, date in _DATES.items()}
    read: dict[str, Callable[[str, str], Any]] = {**seconds, "priority": _priority, **dates}
    orders: dict[str, tuple[int, dict[str, str], dict[str, Any], dict[str, int]]] = {}
    column_of_routes = None if departures is None else departures.column
    if departures is not None and column_of_routes is not None:
        if column_of_routes in (*ORDER_COLUMNS, *read):
            problem = f"found `{column_of_routes}`, which has another meaning; expected a column of routes"
            raise InputError("instance.departures.column", problem)
        read[column_of_routes] = partial(_route, departures)

    def add(line: int, row: dict[str, str]) -> None:
        told = {
            column: read[column](text, f"{file}, line {line}, {column}")
            if text or column in ("arrival", "arrival_s")
            else None
            for column, text in row.items()
            if column in read
        }
        items = _quantity(row["quantity"], file, line, "a whole number >= 1")
        if items > MOST_ITEMS_OF_LINE:
            found = f"found {items:,} items; expected at most {MOST_ITEMS_OF_LINE:,}"
            raise InputError(f"{file}, line {line}, quantity", found)
        _, first, first_told, lines = orders.setdefault(row["order"], (line, row, told, {}))
        for column, value in told.items():
            if value != first_told[column]:
                expected = f"expected {first[column] or 'nothing'} as in the first row of order {row['order']}"
                raise InputError(f"{file}, line {line}, {column}", f"{expected}, found {row[column] or 'nothing'}")
        lines[row["sku"]] = lines.get(row["sku"], 0) + items

    needed = ORDER_COLUMNS if column_of_routes is None else (*ORDER_COLUMNS, column_of_routes)
    _each_row(_returning(_rows(file, needed, (*DUE_COLUMNS, *CANCELLED_COLUMNS), wrong), file, "order"), add, wrong)
    zero = calendar.zero(_DATES.values())
    found = []
    for name, (line, row, told, lines) in orders.items():
        arrival, due, cancelled = (
            told.get(column) if (tick := told.get(date)) is None else tick - zero for column, date in _DATES.items()
        )
        if arrival is None or not 0 <= arrival <= TEN_YEARS:
            column = "arrival" if "arrival" in row else "arrival_s"
            problem = f"found {row[column]}; expected a time within ten years from time 0 (`instance.start`) on"
            wrong(InputError(f"{file}, line {line}, {column}", problem))
        elif cancelled is not None and cancelled < arrival:
            column = "cancelled" if "cancelled" in row else "cancelled_s"
            problem = f"found {row[column]}; expected a time not before the order arrives, or nothing"
            wrong(InputError(f"{file}, line {line}, {column}", problem))
        else:
            later: dict[str, Any] = {"due_tick": due, "cancelled_tick": cancelled}
            later["route"] = told.get(column_of_routes or "")
            priority = told.get("priority") or 0
            found.append((OrderData(name, arrival_tick=arrival, lines=(), priority=priority, **later), lines))
    return sorted(found, key=lambda order: order[0].arrival_tick)


def read_robots(file: Path) -> list[Place]:
    """Read where robots stand at time 0 from a CSV with the columns ``robot,row,column``; they are called 1, 2, ..."""
    rows = list(_rows(file, ("robot", *PLACE_COLUMNS)))
    for number, (line, row) in enumerate(rows, 1):
        if row["robot"] != str(number):
            raise InputError(f"{file}, line {line}, robot", f'expected {number}, found "{row["robot"]}"')
    return [_place(row, file, line) for line, row in rows]


def _place(row: dict[str, str], file: Path, line: int) -> Place:
    at, along = (_quantity(row[name], file, line, "a whole number >= 1", 1, name) for name in PLACE_COLUMNS)
    return at, along, f"{file}, line {line}"


def _read_pods(file: Path, wrong: Wrong) -> dict[str, tuple[Place | None, dict[str, int | None]]]:
    pods: dict[str, tuple[Place | None, dict[str, int | None]]] = {}

    def add(line: int, row: dict[str, str]) -> None:
        expected = "a whole number >= 0, or nothing for an unlimited number"
        items = _quantity(row["quantity"], file, line, expected, least=0) if row["quantity"] else None
        place = _place(row, file, line) if any(column in row for column in PLACE_COLUMNS) else None
        (first, contents), sku = pods.setdefault(row["pod"], (place, {})), row["sku"]
        if place and first and place[:2] != first[:2]:
            raise InputError(place[2], f"found row {place[0]}, column {place[1]}; expected the location of {first[2]}")
        held = contents.get(sku, 0)
        if items != 0 or sku in contents:
            contents[sku] = None if held is None or items is None else held + items

    _each_row(_returning(_rows(file, POD_COLUMNS, PLACE_COLUMNS, wrong), file, "pod"), add, wrong)
    return pods


Row = tuple[int, dict[str, str]]


def _each_row(rows: Iterator[Row], add: Callable[[int, dict[str, str]], None], wrong: Wrong) -> None:
    for line, row in rows:
        try:
            add(line, row)
        except InputError as error:
            wrong(error)


def csv_records(stream: TextIO, file: Path, separator: str = ",") -> Iterator[tuple[int, list[str]]]:
    """Yield each record of a CSV file that is not an empty line, after the number of its last line.

    Raises
    ------
    InputError
        When a quote is not closed or not doubled, or a field has no end; with the line in which the record begins.
    """
    reader = csv.reader(iter(partial(stream.readline, _MOST_OF_A_LINE), ""), delimiter=separator, strict=True)
    line = 0
    try:
        for record in reader:
            line = reader.line_num
            if record:
                yield line, record
    except csv.Error as error:
        found = f"a field of more than {csv.field_size_limit():,} characters; expected a shorter one"
        if "expected after" in str(error):
            within = f" (line {reader.line_num})" if reader.line_num > line + 1 else ""
            found = f"a quote within a field in quotes{within}; expected it doubled"
        elif "end of data" in str(error):
            found = "a quote that is never closed; expected another at the end of the field"
        raise InputError(f"{file}, line {line + 1}", f"found {found}") from None


def _rows(file: Path, columns: Sequence[str], optional: Sequence[str] = (), wrong: Wrong = refuse) -> Iterator[Row]:
    """Yield the line number and the fields, without spaces around them, of every row, in the order of the columns."""
    try:
        with file.open(encoding="utf-8-sig", newline="") as stream:
            records = csv_records(stream, file)
            try:
                line, names = next(records, (1, []))
                while names and names[0].startswith("# "):  # a comment, which says where the file comes from
                    line, names = next(records, (line + 1, []))
                header = [name.strip() for name in names]
                places = {name: header.index(name) for name in _chosen(file, line, header, columns, optional)}
                yield from _fields(file, records, places, len(header), wrong)
            except InputError as error:  # after it no row can be read
                wrong(error)
    except UnicodeDecodeError as error:
        how = 'save it as UTF-8 (in a spreadsheet: "CSV UTF-8")'
        wrong(InputError(str(file), f"expected UTF-8 text, found the byte 0x{error.object[error.start]:02x}; {how}"))
    except (OSError, ValueError) as error:  # ValueError: of a name that no file can have
        wrong(InputError(str(file), f"cannot be read: {getattr(error, 'strerror', error)}"))


def _fields(
    file: Path, records: Iterator[tuple[int, list[str]]], places: dict[str, int], number: int, wrong: Wrong
) -> Iterator[Row]:
    for line, row in records:
        fields = {column: row[place].strip() for column, place in places.items()} if len(row) == number else {}
        if not fields:
            wrong(InputError(f"{file}, line {line}", f"expected {number} fields as in the header, found {len(row)}"))
        elif empty := [column for column in places if column in _NAMES and not fields[column]]:
            wrong(InputError(f"{file}, line {line}, {empty[0]}", "expected a name, found nothing"))
        else:
            yield line, fields


def _chosen(
    file: Path, line: int, header: Sequence[str], columns: Sequence[str], optional: Sequence[str]
) -> Iterator[str]:
    """Yield the columns to read; name unused ones, once."""
    known = (*columns, *optional)
    read = {column: name for column in known for name in (_DATES.get(column, column), column) if name in header}
    needed = columns if "row" in columns or not read.keys() & PLACE_COLUMNS else (*columns, *PLACE_COLUMNS)
    for column in needed:
        if column not in read:
            found = f"`{','.join(header)}` without `{column}`" if any(header) else "none"
            if len(header) == 1 and (other := [name for sign, name in _SEPARATORS.items() if sign in header[0]]):
                found = f"`{header[0]}`: fields are separated by commas, not by {other[0]}"
            expected = f"a header with the columns {','.join(needed)}"
            raise InputError(f"{file}, line {line}", f"expected {expected}, found {found}")
    if twice := [name for name in read.values() if header.count(name) > 1]:
        raise InputError(f"{file}, line {line}, {twice[0]}", "found this column twice; expected each once")
    left = [f"`{name}`{did_you_mean(name, known)}" for name in dict.fromkeys(header) if name not in read.values()]
    if optional and left:
        warn(f"{file}: ignored {listed(left)}.")
    yield from read.values()


def warn(told: str) -> None:
    """Print a sentence on standard error, or give it to who keeps them, the first time only."""
    if told not in _WARNED:
        _WARNED.add(told)
        kept = _kept.get()
        if kept is None:
            print(sentence(told), file=sys.stderr)
        else:
            kept.append(told)


@contextmanager
def warnings_kept() -> Iterator[list[str]]:
    """Keep what `warn` would print: another process has the screen, and shows it."""
    told: list[str] = []
    token = _kept.set(told)
    try:
        yield told
    finally:
        _kept.reset(token)


def _returning(rows: Iterator[Row], file: Path, what: str) -> Iterator[Row]:
    """Pass rows on, and warn of names that appear again after rows of others: perhaps these are two orders, or pods."""
    last, known, again = "", set[str](), dict[str, int]()
    for line, row in rows:
        if (name := row[what]) != last:
            if name in known:
                again.setdefault(name, line)
            known.add(name)
            last = name
        yield line, row
    if again:
        name, line = next(iter(again.items()))
        others = f"; so are those of {counted(len(again) - 1, f'more {what}')}" if len(again) > 1 else ""
        found = f"{what} {name} appears again after rows of other {what}s, and its rows are read as one {what}"
        warn(f"{file}, line {line}: {found}{others}.")


def _tick(text: str, place: str, date: str = "") -> int:
    """Return seconds in ticks; a column of the name ``date``, if any, would have dates."""
    if _NUMBER.fullmatch(text) and math.isfinite(seconds := float(text)):
        return to_ticks(seconds)
    better = f", or dates in a column `{date}`" if date and re.match(r"\d{4}-\d\d-\d\d", text) else ""
    raise InputError(place, f'expected a number of seconds >= 0{better}, found "{text}"')


def _priority(text: str, place: str) -> int:
    if _WHOLE.fullmatch(text):
        return int(text)
    raise InputError(place, f'expected a whole number of at most ten digits, or nothing for 0, found "{text}"')


def _route(departures: Departures, text: str, place: str) -> str:
    if isinstance(departures.times, Mapping) and text not in departures.times:
        raise InputError(place, f"found {text}, which `{TIMES}` has not{did_you_mean(text, departures.times)}")
    return text


def _quantity(text: str, file: Path, line: int, expected: str, least: int = 1, column: str = "quantity") -> int:
    if _WHOLE.fullmatch(text) and (quantity := int(text)) >= least:
        return quantity
    digits = ", of at most ten digits" * (len(text) > 10)
    raise InputError(f"{file}, line {line}, {column}", f'expected {expected}{digits}, found "{text}"')


def _natural(name: str) -> tuple[list[tuple[int, int, str]], str]:
    """Return a sort key by which numbers within a name, of any length, count as numbers."""
    parts = [part.lstrip("0") if i % 2 else part for i, part in enumerate(re.split(r"([0-9]+)", name))]
    return [(0, len(part), part) if i % 2 else (1, 0, part) for i, part in enumerate(parts) if part or i % 2], name
