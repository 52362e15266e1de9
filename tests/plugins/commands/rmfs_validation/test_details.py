"""Metrics and delays that every run leaves, held against its trace."""

from __future__ import annotations

from pathlib import Path

import pytest

import rmfs_core
from rmfs_core.errors import InputError
from rmfs_trace import read_trace
from rmfs_validation import validate_trace
from rmfs_validation.details import PARTS, delays_of, recompute_details

LATE = (
    "instance.orders=12",
    'instance.arrivals={process = "poisson", orders_per_hour = 400}',
    "instance.due={allowance_s = 10}",
    "run.warmup_s=30",
)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a small run with due times, warm-up and trace."""
    folder = tmp_path_factory.mktemp("details") / "out"
    rmfs_core.run("examples/small", overrides=LATE, out=folder, record=["trace"])
    return folder


def test_a_run_says_what_its_trace_amounts_to(recorded: Path) -> None:
    """Nothing is found; what is worked out anew is what the run measured."""
    assert not validate_trace(recorded)
    found = recompute_details(read_trace(recorded / "trace.jsonl.gz"))
    assert found["late_orders"]
    measured = rmfs_core.run("examples/small", overrides=LATE).metrics
    assert {name: measured[name] for name in found} == pytest.approx(found)


def test_an_orders_times_add_up(recorded: Path) -> None:
    """To its turn-over time, to the millisecond."""
    delays = delays_of(read_trace(recorded / "trace.jsonl.gz"))
    assert len(delays) == 12
    for times in delays.values():
        assert sum(times[part] or 0 for part in PARTS) == pytest.approx(times["turnover_s"], abs=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("\n1,", "\none,", "delays.csv lists other orders than the trace"),
        (",", ",7", "delays.csv has 7"),
    ],
)
def test_what_was_changed_by_hand_is_found(recorded: Path, tmp_path: Path, old: str, new: str, sentence: str) -> None:
    """An order's name, and a time."""
    for name in ("trace.jsonl.gz", "result.json", "delays.csv"):
        (tmp_path / name).write_bytes((recorded / name).read_bytes())
    header, _, rows = (tmp_path / "delays.csv").read_text(encoding="utf-8").partition("\n")
    (tmp_path / "delays.csv").write_text(header + ("\n" + rows).replace(old, new, 1), encoding="utf-8")
    faults = validate_trace(tmp_path)
    assert [fault.kind for fault in faults] == ["delay"]
    assert sentence in str(faults[0])


def test_a_file_that_is_no_text_is_refused(recorded: Path, tmp_path: Path) -> None:
    """With its name."""
    for name in ("trace.jsonl.gz", "result.json"):
        (tmp_path / name).write_bytes((recorded / name).read_bytes())
    (tmp_path / "delays.csv").write_bytes(b"\xff\xfe\xff")
    with pytest.raises(InputError, match=r"delays\.csv: cannot be read"):
        validate_trace(tmp_path)
