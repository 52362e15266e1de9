import numpy as np

from rmfs_core.motion import Motion
from rmfs_traffic import Occupancy, Reservations

EVEN = Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0, full_turn_s=4.0)
"""A second for each cell and each quarter turn: all that happens, happens on whole seconds."""


def stay(cell: int, since: int, until: int) -> Occupancy:
    """Return what a robot occupies that stays in one cell from one tick to another."""
    return Occupancy(*(np.array([value], dtype=np.int64) for value in (cell, since, until)))


def hold_until(table: Reservations, owner: int, cell: int, since: int, until: int) -> None:
    table.add(owner, stay(cell, since, until))
