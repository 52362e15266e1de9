"""What the observer holds to."""

import pytest
from rmfs_testing import check_rule
from the_rule import TheRule

import rmfs_core


def test_it_conforms() -> None:
    """It only looks on, in every small world."""
    print(check_rule(TheRule()))


def test_the_counts_add_up_to_the_picks_of_the_run(capsys: pytest.CaptureFixture[str]) -> None:
    """Two stations share them, and the counts are printed."""
    observer = TheRule()
    result = rmfs_core.run("examples/small", observers=[observer])
    assert sum(observer.picks.values()) == result.metrics["picks"]
    assert capsys.readouterr().out.startswith("Picks by station: 1: ")
