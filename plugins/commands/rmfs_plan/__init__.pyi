from .collisions import Collision, collisions
from .movingai import Trip, read_map, read_trips
from .planners import find_planner
from .planning import Plan, bare_roads, plan_trips
from .trips import random_trips

__all__ = [
    "Collision",
    "Plan",
    "Trip",
    "bare_roads",
    "collisions",
    "find_planner",
    "plan_trips",
    "random_trips",
    "read_map",
    "read_trips",
]
