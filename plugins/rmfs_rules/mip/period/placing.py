"""Placing lines at stations one by one, moving earlier ones where that frees a slot (augmenting paths).

Which lines can be placed at the same time is a transversal matroid: taking every line that still finds a slot, oldest
first, ends with as many items as any choice, and among those with the oldest.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence


class Slots:
    """Free slots of stations and how many lines of each kind stand where.

    A kind is the bit mask of the stations that cover it; lines of one kind are interchangeable.

    Parameters
    ----------
    capacities
        Free slots of each station.
    """

    def __init__(self, capacities: Sequence[int]) -> None:
        self.free = list(capacities)
        self.at: list[dict[int, int]] = [{} for _ in capacities]

    def add(self, mask: int) -> bool:
        """Find a slot for a line of a kind, a bit mask; return whether there was one."""
        start = [s for s in range(len(self.free)) if mask >> s & 1]
        came: dict[int, tuple[int, int]] = dict.fromkeys(start, (-1, mask))  # station before, and kind moved in
        queue = deque(start)
        while queue:
            station = queue.popleft()
            if self.free[station] > 0:
                self._shift(station, came)
                return True
            for kind, number in self.at[station].items():
                if number:
                    for other in range(len(self.free)):
                        if kind >> other & 1 and other not in came:
                            came[other] = (station, kind)
                            queue.append(other)
        return False

    def add_all(self, masks: Sequence[int]) -> bool:
        """Find slots for all lines of an order, by their kinds, or change nothing; return whether there were."""
        before = self.free[:], [dict(kinds) for kinds in self.at]
        if all(self.add(mask) for mask in masks):
            return True
        self.free, self.at = before
        return False

    def _shift(self, station: int, came: dict[int, tuple[int, int]]) -> None:
        self.free[station] -= 1
        while station >= 0:
            before, kind = came[station]
            self.at[station][kind] = self.at[station].get(kind, 0) + 1
            if before >= 0:
                self.at[before][kind] -= 1
            station = before

    def take(self, mask: int, preferred: Sequence[int]) -> int:
        """Take a placed line of a kind out and return its station.

        Parameters
        ----------
        mask
            The kind.
        preferred
            Stations that go first, where lines of the kind stand there.

        Raises
        ------
        ValueError
            When no line of the kind is left.
        """
        stations: tuple[int, ...] = (*preferred, *range(len(self.free)))
        for station in stations:
            if self.at[station].get(mask, 0) > 0:
                self.at[station][mask] -= 1
                return station
        raise ValueError("no line of this kind was placed")
