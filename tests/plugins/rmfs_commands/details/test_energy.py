"""What driving takes."""

from __future__ import annotations

import pytest

import rmfs_core
from rmfs_commands.details.energy import run_j, turn_j


def test_a_long_run_takes_the_kinetic_energy_of_top_speed_once() -> None:
    """150 kg at 1.5 m/s, over the efficiency of 0.8; the brakes win nothing back."""
    accelerating, rolling = run_j(10, False, 1.0, 1.5)
    assert accelerating == pytest.approx(150 * 1.5**2 / 2 / 0.8)
    assert rolling == pytest.approx(0.015 * 150 * 9.81 * (10 - 1.125) / 0.8)


def test_a_short_run_never_reaches_top_speed() -> None:
    """Over one metre the robot speeds up for half of it."""
    accelerating, rolling = run_j(1, False, 1.0, 1.5)
    assert accelerating == pytest.approx(150 * 1.0 * 0.5 / 0.8)
    assert rolling == pytest.approx(0.015 * 150 * 9.81 * 0.5 / 0.8)


def test_a_pod_takes_four_times_as_much() -> None:
    """600 kg against 150 kg, in runs and in turns; who does not turn takes nothing."""
    assert run_j(7, True, 1.0, 1.5) == pytest.approx([4 * joules for joules in run_j(7, False, 1.0, 1.5)])
    assert turn_j(1, True, 2.5) == pytest.approx(4 * turn_j(1, False, 2.5))
    assert turn_j(0, True, 2.5) == 0


def test_every_run_says_what_an_order_takes() -> None:
    """The parts add up."""
    metrics = rmfs_core.run("examples/small", overrides=["instance.orders=5", "rules.pp=free-flow"]).metrics
    parts = sum(metrics[f"energy_{part}_wh"] for part in ("acceleration", "rolling", "turns", "lifts"))
    assert parts == pytest.approx(metrics["energy_wh"])
    assert metrics["energy_per_order_wh"] == pytest.approx(parts / 5)
