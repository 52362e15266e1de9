"""Tests of the command, called as `rmfs` calls it."""

import pytest
import rmfs


def test_rmfs_has_it(capsys: pytest.CaptureFixture[str]) -> None:
    """It is listed with the others. (Its distribution has to be installed.)"""
    rmfs.main(["--help"])
    assert "  the-rule " in capsys.readouterr().out


def test_it_prints_the_metric_of_each_run(capsys: pytest.CaptureFixture[str]) -> None:
    """Two seeds, two lines."""
    rmfs.main(["the-rule", "examples/small", "--seeds", "2", "--metric", "picks"])
    picks = rmfs.run("examples/small", seed=1).metrics["picks"]
    first, second = capsys.readouterr().out.splitlines()
    assert first == f"seed 1: picks {picks}"
    assert second.startswith("seed 2: picks ")


def test_an_unknown_metric_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    """One sentence, exit code 2."""
    with pytest.raises(SystemExit) as stop:
        rmfs.main(["the-rule", "examples/small", "--metric", "span"])
    assert stop.value.code == 2
    assert "--metric: expected one of orders_completed" in capsys.readouterr().err
