"""Tests of the observer."""

from pathlib import Path

import pytest
import rmfs
from rmfs.testing import check_rule

from the_rule import TheRule


def test_it_conforms() -> None:
    """It only looks on, in every small world."""
    print(check_rule(TheRule()))


def test_the_busiest_station_is_measured() -> None:
    """Two stations share the picks of the run."""
    observer = TheRule()
    result = rmfs.run("examples/small", observers=[observer])
    assert sum(observer.picks.values()) == result.metrics["picks"]
    share = max(observer.picks.values()) / result.metrics["picks"]
    assert 50 <= result.metrics["busiest_station_percent"] == pytest.approx(100 * share)


def test_the_counts_are_written_beside_the_results(tmp_path: Path) -> None:
    """A line for each station."""
    rmfs.run("examples/small", out=tmp_path, observers=[TheRule()])
    first, *lines = (tmp_path / "the_rule.csv").read_text(encoding="utf-8").splitlines()
    assert first == "station,picks"
    assert [line.partition(",")[0] for line in lines] == ["1", "2"]
