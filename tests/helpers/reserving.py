import numpy as np

from rmfs_core.motion import Motion
from rmfs_traffic import Occupancy, Reservations

EVEN = Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0, full_turn_s=4.0)
"""A second for each cell and each quarter turn: all that happens, happens on whole seconds."""


def occupy(*intervals: tuple[int, int, int]) -> Occupancy:
    """Return what a robot occupies: cells, each from one tick to another."""
    return Occupancy(*(np.array(column, dtype=np.int64) for column in zip(*intervals, strict=True)))


def stay(cell: int, since: int, until: int) -> Occupancy:
    return occupy((cell, since, until))


def hold_until(table: Reservations, owner: int, cell: int, since: int, until: int) -> None:
    table.add(owner, stay(cell, since, until))
