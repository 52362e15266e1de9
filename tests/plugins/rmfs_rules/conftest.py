"""Fixtures for tests of rules."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rmfs_core.warehouse import Warehouse


@pytest.fixture
def put_at_station() -> Callable[[Warehouse, int, int], None]:
    """Return a function that lets a robot stand at a station with a pod: world, pod id, station id."""

    def put(world: Warehouse, pod_id: int, station_id: int) -> None:
        pod, station = world.pods[pod_id], world.stations[station_id]
        world.place_at_station(next(robot for robot in world.robots if robot.idle), pod, station)

    return put
