from .collisions import Collision, collisions
from .movingai import Trip, read_map, read_trips
from .planners import find_planner
from .planning import Plan, plan_trips
from .roads import roads_of_map
from .trips import random_trips

__all__ = [
    "Collision",
    "Plan",
    "Trip",
    "collisions",
    "find_planner",
    "plan_trips",
    "random_trips",
    "read_map",
    "read_trips",
    "roads_of_map",
]
