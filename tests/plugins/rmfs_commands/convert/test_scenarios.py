"""Scenarios for converted orders and pods."""

from __future__ import annotations

import tomllib

import pytest

from rmfs_commands.convert.scenarios import scenario_of


@pytest.mark.parametrize("pods", [1, 100, 5000])
def test_a_scenario_has_room_for_the_pods(pods: int) -> None:
    """More storage locations than pods, blocks of eight."""
    scenario = tomllib.loads(scenario_of(pods))
    assert 8 * scenario["layout"]["block_rows"] * scenario["layout"]["block_columns"] > pods
    assert "start" not in scenario["instance"]


def test_time_zero_is_written() -> None:
    """Where it is known."""
    scenario = tomllib.loads(scenario_of(5, "2024-07-01T00:00:00+02:00"))
    assert scenario["instance"]["start"] == "2024-07-01T00:00:00+02:00"
