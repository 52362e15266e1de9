import numpy as np

from rmfs_core.traffic import Occupancy, Reservations


def stay(cell: int, since: int, until: int) -> Occupancy:
    """Return what a robot occupies that stays in one cell from one tick to another."""
    return Occupancy(*(np.array([value], dtype=np.int64) for value in (cell, since, until)))


def hold_until(table: Reservations, owner: int, cell: int, since: int, until: int) -> None:
    table.add(owner, stay(cell, since, until))
