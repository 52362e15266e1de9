"""Path planning by itself: a map, robots with a trip each, a planner; no orders, no pods.

A library use, in four lines::

    roads = roads_of_map(read_map("hall.map"))
    planner = find_planner("sipp", {}, np.random.default_rng(1))
    plans = plan_trips(roads, planner, random_trips(roads, 20, 1, "hall.map"))
    assert not collisions(roads, [plan.path for plan in plans])
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
