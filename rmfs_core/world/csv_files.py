"""Orders and pods from CSV files, with the line of whatever is wrong."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.world.instance import Instance, OrderData, PodData

if TYPE_CHECKING:
    from _csv import Reader as CsvReader

ORDER_COLUMNS = ("order", "arrival_s", "sku", "quantity")
POD_COLUMNS = ("pod", "sku", "quantity")
_NAMES = ("order", "pod", "sku")

_WHOLE = re.compile(r"[0-9]{1,15}")
_NUMBER = re.compile(r"[0-9]{1,12}(\.[0-9]*)?([eE][+-]?[0-9]{1,2})?|\.[0-9]+")


Wrong = Callable[[InputError], None]
"""What is called with a mistake; when it returns, the row is left out."""


def refuse(error: InputError) -> None:
    """Raise the first mistake."""
    raise error


def read_instance(orders_file: Path, pods_file: Path, wrong: Wrong = refuse) -> Instance:
    """Read orders and pods.

    Orders get their ids in the order of arrival, then of first appearance in the file; pods in the order of first
    appearance; SKUs in natural order of their names (``A2`` before ``A10``).

    Parameters
    ----------
    orders_file
        CSV with the columns ``order,arrival_s,sku,quantity``, one line of an order a row. Other columns are ignored;
        rows of one order need not be adjacent; a SKU that comes twice in an order is one line of both quantities.
    pods_file
        CSV with the columns ``pod,sku,quantity``. An empty quantity is an unlimited number of items.
    wrong
        Called with each mistake: an `InputError` with file, line and column. It raises the first unless told otherwise.
    """
    orders, pods = _read_orders(orders_file, wrong), _read_pods(pods_file, wrong)
    names = {sku for _, lines in orders.values() for sku in lines} | {sku for pod in pods.values() for sku in pod}
    skus = tuple(sorted(names, key=_natural))
    id_of = {sku: i for i, sku in enumerate(skus)}
    by_arrival = sorted(orders.items(), key=lambda order: order[1][0])  # stable: ties by first appearance
    return Instance(
        skus=skus,
        orders=tuple(
            OrderData(name, tick, tuple((id_of[sku], quantity) for sku, quantity in lines.items()))
            for name, (tick, lines) in by_arrival
        ),
        pods=tuple(
            PodData(name, tuple((id_of[sku], quantity) for sku, quantity in contents.items()))
            for name, contents in pods.items()
        ),
    )


def line_of(orders_file: Path, order: str, sku: str | None = None) -> int:
    """Line on which an order of a file that was read appears first, or its first row of a SKU."""
    rows = _rows(orders_file, ORDER_COLUMNS)
    return next(line for line, (name, _, wanted, _) in rows if name == order and sku in (None, wanted))


def _read_orders(file: Path, wrong: Wrong) -> dict[str, tuple[int, dict[str, int]]]:
    orders: dict[str, tuple[int, dict[str, int]]] = {}

    def add(line: int, name: str, arrival: str, sku: str, quantity: str) -> None:
        tick, items = _tick(arrival, file, line), _quantity(quantity, file, line, "a whole number >= 1")
        known_tick, lines = orders.setdefault(name, (tick, {}))
        if tick != known_tick:
            raise InputError(
                f"{file}, line {line}, arrival_s",
                f"expected {known_tick / 1000:g} as in the first row of order {name}, found {arrival}",
            )
        lines[sku] = lines.get(sku, 0) + items

    _each_row(file, ORDER_COLUMNS, add, wrong)
    return orders


def _read_pods(file: Path, wrong: Wrong) -> dict[str, dict[str, int | None]]:
    pods: dict[str, dict[str, int | None]] = {}

    def add(line: int, name: str, sku: str, quantity: str) -> None:
        expected = "a whole number >= 1, or nothing for an unlimited number"
        items = _quantity(quantity, file, line, expected) if quantity else None
        contents = pods.setdefault(name, {})
        held = contents.get(sku, 0)
        contents[sku] = None if held is None or items is None else held + items

    _each_row(file, POD_COLUMNS, add, wrong)
    return pods


def _each_row(file: Path, columns: tuple[str, ...], add: Callable[..., None], wrong: Wrong) -> None:
    for line, row in _rows(file, columns, wrong):
        try:
            add(line, *row)
        except InputError as error:
            wrong(error)


def _rows(file: Path, columns: tuple[str, ...], wrong: Wrong = refuse) -> Iterator[tuple[int, list[str]]]:
    """Yield the line number and the fields of ``columns``, without spaces around them, of every row."""
    try:
        with file.open(encoding="utf-8-sig", newline="") as stream:
            reader = csv.reader(stream, strict=True)
            try:
                yield from _fields(file, reader, columns, wrong)
            except csv.Error as error:
                wrong(InputError(f"{file}, line {reader.line_num}", f"this is no valid CSV: {error}"))
    except OSError as error:
        wrong(InputError(str(file), f"cannot be read: {error.strerror}"))
    except UnicodeDecodeError as error:
        wrong(InputError(str(file), f"expected UTF-8 text, found the byte 0x{error.object[error.start]:02x}"))


def _fields(file: Path, reader: CsvReader, columns: tuple[str, ...], wrong: Wrong) -> Iterator[tuple[int, list[str]]]:
    header = [name.strip() for name in next(reader, [])]
    for column in columns:
        if column not in header:
            found = f"`{','.join(header)}` without `{column}`" if header else "none"
            problem = f"expected a header with the columns {','.join(columns)}, found {found}"
            return wrong(InputError(f"{file}, line 1", problem))
    places = [header.index(column) for column in columns]
    named = [pair for pair in zip(columns, places, strict=True) if pair[0] in _NAMES]
    for row in reader:
        if not row:
            continue
        line = reader.line_num
        if len(row) != len(header):
            wrong(
                InputError(f"{file}, line {line}", f"expected {len(header)} fields as in the header, found {len(row)}")
            )
        elif empty := [column for column, place in named if not row[place].strip()]:
            wrong(InputError(f"{file}, line {line}, {empty[0]}", "expected a name, found nothing"))
        else:
            yield line, [row[place].strip() for place in places]


def _tick(text: str, file: Path, line: int) -> int:
    if _NUMBER.fullmatch(text) and math.isfinite(seconds := float(text)):
        return to_ticks(seconds)
    raise InputError(f"{file}, line {line}, arrival_s", f'expected a number of seconds >= 0, found "{text}"')


def _quantity(text: str, file: Path, line: int, expected: str) -> int:
    if _WHOLE.fullmatch(text) and (quantity := int(text)) >= 1:
        return quantity
    raise InputError(f"{file}, line {line}, quantity", f'expected {expected}, found "{text}"')


def _natural(name: str) -> tuple[list[tuple[int, int | str]], str]:
    """Return a sort key by which numbers within a name count as numbers."""
    parts = re.split(r"([0-9]+)", name)
    return [(0, int(part)) if i % 2 else (1, part) for i, part in enumerate(parts) if part], name
