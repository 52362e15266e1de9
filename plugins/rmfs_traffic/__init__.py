"""Robots in each other's way: when a path occupies which cell, and the table of who has reserved what."""

from rmfs_core.decisions import Rows, ends_of
from rmfs_traffic.passing import PassingTimes, passing_s
from rmfs_traffic.paths import FOREVER, Occupancy, Query, Stop, TimedPath, drive, occupancy, run_between, timed_path
from rmfs_traffic.reservations import FleetTraffic, Intervals, Reservations, ReservedError, Traffic
from rmfs_traffic.roads import Roads, Tracks, roads_on

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
    "Rows",
    "Stop",
    "TimedPath",
    "Tracks",
    "Traffic",
    "drive",
    "ends_of",
    "occupancy",
    "passing_s",
    "roads_on",
    "run_between",
    "timed_path",
]
