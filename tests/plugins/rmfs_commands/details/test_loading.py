"""Results are read back as they were written, and whatever else is there is named."""

from __future__ import annotations

from pathlib import Path

import pytest

import rmfs_core
from rmfs_commands.details.loading import load_result
from rmfs_core import InputError


def test_what_is_read_is_what_the_run_returned(tmp_path: Path) -> None:
    """Metrics, tables and what is said of the metrics; scenario, versions and times as well."""
    result = rmfs_core.run("examples/small", overrides=["instance.orders=5"], out=tmp_path)
    read = load_result(tmp_path)
    assert (read.metrics, read.orders, read.visits) == (result.metrics, result.orders, result.visits)
    assert (read.periods, read.timing, read.versions) == (result.periods, result.timing, result.versions)
    assert (read.scenario, read.seed, read.status) == (result.scenario, result.seed, result.status)
    assert read.described["makespan_s"] == result.described["makespan_s"]


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("result.json", "{", "result.json, line 1: this is no valid JSON"),
        ("result.json", "[]", "the key `scenario` is missing"),
        ("orders.csv", "order\n", "orders.csv, line 1: expected the columns"),
        ("visits.csv", "visit,pod,station,robot,start_s,end_s,picks\n1,p,1,1,0.0,x,3\n", "visits.csv, line 2"),
        ("visits.csv", "visit,pod,station,robot,start_s,end_s,picks\n1,p\n", "visits.csv, line 2"),
        ("periods.csv", None, "periods.csv: cannot be read"),
    ],
)
def test_a_broken_result(tmp_path: Path, name: str, content: str | None, problem: str) -> None:
    """The message names the file, the line where it is known, and what is wrong."""
    rmfs_core.run("examples/small", overrides=["instance.orders=5"], out=tmp_path / "out")
    (tmp_path / "out" / name).unlink()
    if content is not None:
        (tmp_path / "out" / name).write_text(content)
    with pytest.raises(InputError) as caught:
        load_result(tmp_path / "out")
    assert problem in str(caught.value)
