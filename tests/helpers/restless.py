"""A rule that keeps robots on the move: the more they drive, the sooner their batteries run down."""

from collections.abc import Sequence

import numpy as np
from attrs import define

from rmfs_core import PodMove, RobotMove, hookimpl
from rmfs_core.warehouse import WarehouseView


@define
class Restless:
    """Send robots anywhere, and pods, too; robots that are low to a charger, others away from there for them."""

    often: float = 0.5

    @hookimpl
    def idle_robots(self, warehouse: WarehouseView, rng: np.random.Generator) -> Sequence[RobotMove]:
        free, moves = list(warehouse.free_rest_cells), []
        chargers = {*warehouse.travel.layout.chargers}
        robots = warehouse.resting_robots
        waiting = any(robot.low and robot.cell not in chargers for robot in robots)
        for robot in robots:
            leave = waiting and robot.cell in chargers
            cells = [cell for cell in free if (cell in chargers) >= robot.low and not (leave and cell in chargers)]
            if cells and (robot.low or leave or rng.random() < self.often) and not (robot.low and leave):
                cell = int(rng.choice(cells))
                free.remove(cell)
                moves.append(RobotMove(robot.id, cell, float(rng.random()) if cell in chargers else None))
        return moves

    @hookimpl
    def move_pods(self, warehouse: WarehouseView, max_moves: int, rng: np.random.Generator) -> Sequence[PodMove]:
        pods = [pod for pod in warehouse.free_pods if pod.robot is None]
        free = warehouse.free_storage_locations
        if not pods or not free or not max_moves or rng.random() > self.often:
            return []
        return [PodMove(int(rng.choice([pod.id for pod in pods])), int(rng.choice(free)))]


@define
class FirstFree:
    """Send robots to the first free storage locations, which is where pods go, too."""

    @hookimpl
    def choose_storage_location(self, warehouse: WarehouseView) -> int:
        return warehouse.free_storage_locations[0]

    @hookimpl
    def idle_robots(self, warehouse: WarehouseView) -> Sequence[RobotMove]:
        places = {*warehouse.free_storage_locations[:3]}
        free = [cell for cell in warehouse.free_rest_cells if cell in places]
        robots = [robot for robot in warehouse.resting_robots if robot.cell not in places]
        return [RobotMove(robot.id, cell) for robot, cell in zip(robots, free, strict=False)]
