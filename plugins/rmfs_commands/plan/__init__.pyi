from .collisions import Collision, collisions
from .movingai import Trip, read_map, read_trips
from .planners import find_planner
from .planning import Plan, plan_in_orders, plan_trips, roads_of_map
from .priorities import plan_by_priorities
from .trips import random_trips

__all__ = [
    "Collision",
    "Plan",
    "Trip",
    "collisions",
    "find_planner",
    "plan_by_priorities",
    "plan_in_orders",
    "plan_trips",
    "random_trips",
    "read_map",
    "read_trips",
    "roads_of_map",
]
