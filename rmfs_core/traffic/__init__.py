"""Robots in each other's way: when a path occupies which cell, and the table of who has reserved what."""

from rmfs_core.traffic.passing import PassingTimes, passing_s
from rmfs_core.traffic.paths import FOREVER, Occupancy, Query, TimedPath, drive, occupancy, run_between, timed_path
from rmfs_core.traffic.reservations import FleetTraffic, Intervals, Reservations, ReservedError, Traffic
from rmfs_core.traffic.roads import Roads, Tracks, roads_on

__all__ = [
    "FOREVER",
    "FleetTraffic",
    "Intervals",
    "Occupancy",
    "PassingTimes",
    "Query",
    "Reservations",
    "ReservedError",
    "Roads",
    "TimedPath",
    "Tracks",
    "Traffic",
    "drive",
    "occupancy",
    "passing_s",
    "roads_on",
    "run_between",
    "timed_path",
]
