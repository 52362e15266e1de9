"""Files of a run in its folder, read for a report."""

from __future__ import annotations

import csv
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import frozen

from rmfs_commands.details.loading import load_result
from rmfs_commands.details.observer import DELAYS, DEPARTURES, HOURS, PACKING, ROBOTS, STATIONS
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.report.hall import Floor
from rmfs_commands.states.recorded import Recording, read_recording
from rmfs_commands.states.recording import RECORDING_FILE
from rmfs_commands.trace.writer import FILE as TRACE_FILE
from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE, Result

Row = Mapping[str, Any]

COLUMNS: Mapping[str, Collection[str]] = {
    HOURS: ("hour", "orders_in", "orders_out", "picks", "backlog"),
    STATIONS: ("station", "picks", "visits", "busy_s", "waiting_s", "idle_s", "queue_mean", "queue_max"),
    ROBOTS: ("robot", "distance_m", "idle_s", "waiting_s"),
    DELAYS: ("order", "turnover_s", "backlog_s", "handling_s"),
    DEPARTURES: ("route", "leaves_s", "orders", "departed", "missed", "open", "departed_share", "late_mean_s"),
    PACKING: ("order", "packing_station", "parts", "first_part_s", "last_part_s", "packing_s", "packed_s"),
}
"""Columns that each table must have."""
NAMES = ("order", "robot", "station", "packing_station", "route", "departure")


@frozen(eq=False)
class Run:
    """A run with its files.

    Parameters
    ----------
    name
        Of its folder.
    result
        result.json with orders.csv and visits.csv.
    hours, stations, robots, delays, packing, departures
        Rows of the tables, times in seconds; ``packing`` is None without packing stations, ``departures`` without
        trucks.
    replay, floor
        The trace, and what robots did in each cell; None where no trace was recorded.
    recording
        The decisions; None where they were not recorded.
    """

    name: str
    result: Result
    hours: Sequence[Row]
    stations: Sequence[Row]
    robots: Sequence[Row]
    delays: Sequence[Row]
    packing: Sequence[Row] | None
    departures: Sequence[Row] | None
    replay: Replay | None
    floor: Floor | None
    recording: Recording | None


def read_run(folder: Path) -> Run:
    """Read a run's folder.

    Raises
    ------
    InputError
        When it is no run's, or a file is missing, damaged, or of another run.
    """
    if not (folder / RESULT_FILE).is_file():
        expected = "expected the folder of a run, as `rmfs run --out DIR` writes it"
        raise InputError(str(folder), f"has no {RESULT_FILE}; {expected}")
    result = load_result(folder)
    hours, stations, robots, delays = (_table(folder / name) for name in (HOURS, STATIONS, ROBOTS, DELAYS))
    packing = None if result.scenario.packing is None else _table(folder / PACKING)
    departures = None if result.scenario.instance.departures is None else _table(folder / DEPARTURES)
    orders = [row["order"] for row in result.orders]
    if sorted(orders) != sorted(row["order"] for row in delays):
        raise InputError(str(folder / DELAYS), "has other orders than orders.csv; expected files of one run")
    replay = floor = recording = None
    if (folder / TRACE_FILE).exists():
        floor = Floor(to_ticks(result.scenario.run.warmup_s or 0))
        replay = read_replay(folder, floor)
    if (folder / RECORDING_FILE).exists():
        recording = read_recording(folder)
    name = folder.resolve().name
    return Run(name, result, hours, stations, robots, delays, packing, departures, replay, floor, recording)


def _table(file: Path) -> list[Row]:
    """Return the rows of a table: names as they are, numbers, and None for an empty field."""
    try:
        with file.open(encoding="utf-8", newline="") as stream:
            reader = csv.DictReader(stream, strict=True)
            missing = [name for name in COLUMNS[file.name] if name not in (reader.fieldnames or ())]
            if missing:
                raise InputError(f"{file}, line 1", f"has no column {missing[0]}; expected a file of `rmfs run`")
            try:
                return [{name: _value(name, text) for name, text in row.items()} for row in reader]
            except (ValueError, TypeError, csv.Error) as error:
                problem = f"the row is not as expected: {error}"
                raise InputError(f"{file}, line {reader.line_num}", problem) from error
    except UnicodeDecodeError as error:
        raise InputError(str(file), f"expected UTF-8 text: {error}") from error
    except OSError as error:
        problem = f"cannot be read: {error.strerror or error}; expected a file of `rmfs run`"
        raise InputError(str(file), problem) from error


def _value(name: str, text: str) -> str | float | None:
    if name in NAMES:
        return text
    return float(text) if text else None
