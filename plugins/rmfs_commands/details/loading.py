"""Results of runs, read back from the files that they were saved in."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rmfs_commands.instances.tables import (
    CANCELLED_COLUMNS,
    DUE_COLUMNS,
    ORDER_COLUMNS,
    ROUTE_COLUMNS,
    TABLE_FILES,
    Row,
)
from rmfs_commands.results.recorders import make_observers
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE, Result
from rmfs_core.results.catalogue import described_by
from rmfs_core.scenario import scenario_from_dict


def load_result(folder: str | Path) -> Result:
    """Read a saved result back.

    Raises
    ------
    InputError
        When a file is missing or is not what `Result.save` writes; file and line are named.
    """
    path = Path(folder)
    file = path / RESULT_FILE
    try:
        content = json.loads(_read(file))
    except json.JSONDecodeError as error:
        raise InputError(f"{file}, line {error.lineno}", f"this is no valid JSON: {error.msg}") from error
    expected = ("scenario", "seed", "versions", "status", "metrics", "timing")
    missing = [key for key in expected if not isinstance(content, Mapping) or key not in content]
    if missing:
        raise InputError(str(file), f"the key `{missing[0]}` is missing; expected a result that rmfs has written")
    tables = {table: _read_table(path / name, columns) for table, (name, columns) in TABLE_FILES.items()}
    return Result(
        scenario=scenario_from_dict(content["scenario"], name=f"{file}, scenario"),
        seed=content["seed"],
        versions=content["versions"],
        status=content["status"],
        metrics=content["metrics"],
        timing=content["timing"],
        described=described_by(observer for observer, _ in make_observers(quiet=True)),
        error=content.get("error"),
        notes=list(content.get("notes", [])),
        summary=dict(content.get("summary", {})),
        orders=tables["orders"],
        visits=tables["visits"],
        periods=tables["periods"],
    )


def _read(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(str(file), f"cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise InputError(str(file), f"expected UTF-8 text: {error}") from error


def _read_table(file: Path, columns: Mapping[str, type]) -> list[Row]:
    reader = csv.DictReader(_read(file).splitlines(keepends=True), strict=True)
    if reader.fieldnames is not None and columns is ORDER_COLUMNS and "due_s" in reader.fieldnames:
        columns = {**columns, **DUE_COLUMNS}
    if reader.fieldnames is not None and "route" in reader.fieldnames:
        columns = {**columns, **ROUTE_COLUMNS}
    if reader.fieldnames is not None and "cancelled_s" in reader.fieldnames:
        columns = {**columns, **CANCELLED_COLUMNS}
    if reader.fieldnames is None or list(reader.fieldnames) != list(columns):
        raise InputError(f"{file}, line 1", f"expected the columns {', '.join(columns)}")
    try:
        return [{name: _value(row[name], kind) for name, kind in columns.items()} for row in reader]
    except (ValueError, TypeError, KeyError, csv.Error) as error:
        raise InputError(f"{file}, line {reader.line_num}", f"the row is not as expected: {error}") from error


def _value(text: str, kind: type) -> Any:
    if text == "" and kind is not str:
        return None
    return {"true": True, "false": False}[text] if kind is bool else kind(text)
