from .collisions import Collision, collisions
from .joint import plan_jointly
from .movingai import Trip, read_map, read_trips
from .planners import find_planner
from .planning import Plan, plan_in_orders, plan_trips, roads_of_map
from .trips import random_trips

__all__ = [
    "Collision",
    "Plan",
    "Trip",
    "collisions",
    "find_planner",
    "plan_in_orders",
    "plan_jointly",
    "plan_trips",
    "random_trips",
    "read_map",
    "read_trips",
    "roads_of_map",
]
