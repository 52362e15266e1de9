"""The tables next to a trace, compared with what the trace amounts to."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.case import Case
from rmfs_commands.validation.departures import departures_of
from rmfs_commands.validation.details import delays_of
from rmfs_commands.validation.packed import packing_of
from rmfs_commands.validation.restocking import bundles_of, stock_of
from rmfs_commands.validation.results import orders_of, periods_of, visits_of
from rmfs_commands.validation.stock import lets_wait
from rmfs_commands.validation.tables import Row, hours_of, robots_of, stations_of
from rmfs_core.errors import InputError

FILES: Mapping[str, tuple[str, Callable[[Trace], Iterable[Row]]]] = {
    "orders.csv": ("order", orders_of),
    "visits.csv": ("visit", visits_of),
    "periods.csv": ("period", periods_of),
    "delays.csv": ("order", delays_of),
    "hours.csv": ("hour", hours_of),
    "stations.csv": ("station", stations_of),
    "robots.csv": ("robot", robots_of),
    "bundles.csv": ("bundle", bundles_of),
    "stock.csv": ("hour", stock_of),
    "packing.csv": ("order", packing_of),
    "departures.csv": ("departure", departures_of),
}
"""Of each table the first column, whose values name its rows, and what works its rows out."""

OF_ITS_WHOLE_TIME: tuple[str, ...] = ("delays.csv", "stock.csv")
"""Tables that know more of the time before a run that begins in a state than its trace does."""


def check_files(case: Case, folder: Path) -> None:
    """Add a fault for each figure in the tables of a folder that the trace contradicts; tables may be missing.

    Raises
    ------
    InputError
        When a file cannot be read.
    """
    unknown = OF_ITS_WHOLE_TIME if case.trace.state is not None else ()
    if unknown and lets_wait(case.trace):
        unknown = (*unknown, "stations.csv")  # when orders joined the backlog
    for name, (key, work_out) in FILES.items():
        if (folder / name).exists() and name not in unknown:
            rows = _rows(folder / name)
            expected = [*islice(work_out(case.trace), len(rows) + 1)]  # one more than there are is enough to differ
            for sentence in _differences(name, key, rows, expected):
                case.add("table", case.trace.tick, sentence)


def _rows(file: Path) -> list[dict[str, Any]]:
    try:
        return list(csv.DictReader(io.StringIO(file.read_text(encoding="utf-8"))))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(str(file), f"cannot be read: {error}") from error


def _differences(name: str, key: str, rows: list[dict[str, Any]], expected: list[Row]) -> list[str]:
    if [row.get(key) for row in rows] != [str(row[key]) for row in expected]:
        return [f"{name} lists other {key}s than the trace"]
    found = []
    for row, worked_out in zip(rows, expected, strict=True):
        for column, value in worked_out.items():
            if (told := _told(row, column)) != ("" if value is None else str(value)):
                tells = f"{name} has {told or 'nothing'} as {column} of {key} {row[key]}"
                found.append(f"{tells}; the trace amounts to {'nothing' if value is None else value}")
    return found


def _told(row: Mapping[str, Any], column: str) -> str | None:
    """Return the text of a column, or the sum of two: ``robot_s + pod_s``."""
    texts = [row.get(part) for part in column.split(" + ")]
    if len(texts) == 1 or not all(texts):
        return texts[0]
    try:
        return str(round(sum(map(float, filter(None, texts))), 3))
    except ValueError:
        return " + ".join(map(str, texts))
