"""A pod that stands at a station, and what a rule assigns in a world made by hand."""

import inspect
from typing import Any

import numpy as np

from rmfs_core.warehouse import Warehouse, WarehouseView


def put_at_station(world: Warehouse, pod_id: int, station_id: int = 0) -> None:
    pod, station = world.pods[pod_id], world.stations[station_id]
    world.place_at_station(next(robot for robot in world.robots if robot.idle), pod, station)


def assigned(world: Warehouse, rule: Any, seed: int = 0) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment; plain numbers, and whole orders."""
    given = {"warehouse": WarehouseView(world), "rng": np.random.default_rng(seed)}
    wanted = inspect.signature(rule.assign_orders).parameters
    answer = rule.assign_orders(**{name: value for name, value in given.items() if name in wanted})
    assert all(type(one.order) is int and type(one.station) is int and one.skus is None for one in answer)
    return [(world.orders[one.order].name, one.station) for one in answer]
