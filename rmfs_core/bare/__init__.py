"""Path planning by itself: a map, robots with a trip each, a planner; no orders, no pods.

A library use, in four lines::

    roads = bare_roads(read_map("hall.map"))
    planner = find_planner("sipp", {}, np.random.default_rng(1)).planner
    plans = plan_trips(roads, planner, random_trips(roads, 20, 1, "hall.map"))
    assert not collisions(roads, [plan.path for plan in plans])
"""

from rmfs_core.bare.collisions import Collision, collisions
from rmfs_core.bare.movingai import Trip, read_map, read_trips
from rmfs_core.bare.planners import find_planner
from rmfs_core.bare.planning import Plan, plan_trips
from rmfs_core.bare.roads import bare_roads
from rmfs_core.bare.trips import random_trips

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
