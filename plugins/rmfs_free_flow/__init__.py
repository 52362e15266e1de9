import numpy as np
from attrs import define
from rmfs_core import *
from rmfs_core.hookspecs import hookimpl

@define
class FreeFlow:
    @hookimpl
    def plan_path(self, warehouse, robot, goal): return Path(warehouse.travel.fastest_path(robot.cell,robot.heading,goal,robot.pod is not None))
