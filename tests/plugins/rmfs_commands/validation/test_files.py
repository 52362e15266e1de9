"""Tables that every run leaves, held against its trace."""

from __future__ import annotations

import csv
import gzip
import json
import time
from pathlib import Path

import pytest

import rmfs_core
from rmfs_commands.validation import validate_trace
from rmfs_commands.validation.files import FILES
from rmfs_core.errors import InputError
from rmfs_core.results.files import to_csv

SETTINGS = (
    "instance.orders=12",
    'instance.arrivals={process = "poisson", orders_per_hour = 400}',
    "instance.due={allowance_s = 10}",
    "run.warmup_s=30",
    "layout.replenishment_west=1",
    "instance.items_per_sku=3",
    'instance.replenishment={process = "reorder-point", reorder_point = 12, order_up_to = 16}',
    "rules.roa=first-bundle",
    "rules.rps=emptiest-pod",
)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a small run with due times, warm-up, replenishment and trace."""
    folder = tmp_path_factory.mktemp("tables") / "out"
    rmfs_core.run("examples/small", overrides=SETTINGS, out=folder, record=["trace"])
    return folder


@pytest.fixture
def copy(recorded: Path, tmp_path: Path) -> Path:
    """Return a folder with a copy of the run, to be damaged."""
    for name in ("trace.jsonl.gz", "result.json", *FILES):
        (tmp_path / name).write_bytes((recorded / name).read_bytes())
    return tmp_path


def test_a_run_leaves_what_its_trace_amounts_to(recorded: Path) -> None:
    """In a run with a warm-up, and every table is there."""
    assert all((recorded / name).exists() for name in FILES)
    assert not validate_trace(recorded)


@pytest.mark.parametrize("name", FILES)
def test_each_figure_that_was_changed_is_found(copy: Path, name: str) -> None:
    """Column by column, in the last row, with file, column and row."""
    with (copy / name).open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    key, *columns = rows[0]
    for column in columns:
        if column == "seconds":  # of the wall clock, which a trace does not know
            continue
        changed = [*rows[:-1], {**rows[-1], column: "123.5"}]
        (copy / name).write_text(to_csv(list(rows[0]), changed), encoding="utf-8")
        (fault,) = validate_trace(copy)
        assert fault.kind == "table"
        assert fault.sentence.startswith(f"{name} has 123.5 as {column} of {key} {rows[-1][key]}; the trace amounts to")


@pytest.mark.parametrize("name", FILES)
def test_rows_that_are_missing_are_found(copy: Path, name: str) -> None:
    """Once, not for each figure in them."""
    lines = (copy / name).read_text(encoding="utf-8").splitlines(keepends=True)
    (copy / name).write_text("".join(lines[:-1]), encoding="utf-8")
    (fault,) = validate_trace(copy)
    assert fault.sentence == f"{name} lists other {FILES[name][0]}s than the trace"


def test_a_missing_column_is_found(copy: Path) -> None:
    """As nothing, where there should be something."""
    text = (copy / "robots.csv").read_text(encoding="utf-8")
    (copy / "robots.csv").write_text(text.replace("idle_s", "lazy_s"), encoding="utf-8")
    assert "robots.csv has nothing as idle_s of robot 1; the trace amounts to" in validate_trace(copy)[0].sentence


def test_a_file_that_is_no_text_is_refused(copy: Path) -> None:
    """With its name."""
    (copy / "delays.csv").write_bytes(b"\xff\xfe\xff")
    with pytest.raises(InputError, match=r"delays\.csv: cannot be read"):
        validate_trace(copy)


def test_tables_of_a_trace_alone_are_not_needed(copy: Path) -> None:
    """A folder may lack any of them."""
    for name in FILES:
        (copy / name).unlink()
    assert not validate_trace(copy)


def test_a_trace_that_ends_in_thousands_of_years_takes_no_time(copy: Path) -> None:
    """Of hours.csv no more rows are worked out than differ from those that are there."""
    trace = copy / "trace.jsonl.gz"
    *lines, end = gzip.decompress(trace.read_bytes()).decode().splitlines()
    late = json.dumps({**json.loads(end), "tick": 10**15})
    trace.write_bytes(gzip.compress("\n".join([*lines, late, ""]).encode()))
    began = time.process_time()
    assert "hours.csv lists other hours than the trace" in [fault.sentence for fault in validate_trace(copy)]
    assert time.process_time() - began < 5
