"""Activation rules ``all``, ``backlog-threshold`` and ``constant-ratio``: which stations take orders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define, field

from rmfs_core import hookimpl
from rmfs_rules.helpers.parameters import AT_LEAST_1, NOT_NEGATIVE, SHARE_ABOVE_0, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView

CLOSE_BELOW = 0.7
"""Share of the active stations' capacity in use below which one is closed."""


def _ids(stations: Sequence[Station]) -> list[int]:
    return [station.id for station in stations]


def _staffed(warehouse: WarehouseView) -> list[Station]:
    """Return the stations whose timetables have them open, in the order in which they are activated.

    The largest come first, so that no order waits for a station that is large enough and stays closed.
    """
    staffed = (station for station in warehouse.stations if station.staffed)
    return sorted(staffed, key=lambda station: (-station.capacity, station.id))


@define
class All:
    """Activate every station: each takes orders whenever its timetable has it open.

    The same as no activation rule; there to be compared with the others.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8 (station activation "activate all")
    """

    @hookimpl
    def activate_stations(self, warehouse: WarehouseView) -> Sequence[int]:
        """Activate them all."""
        return _ids(warehouse.stations)


@define
class ConstantRatio:
    """Activate a fixed share of the stations.

    Of the n stations that their timetables have open, the max(1, floor(ratio * n)) with the highest capacity are active
    (ties: lowest id).

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8 (station activation "constant ratio", whose code has
    the default, and activates none where the share comes to less than one)
    """

    ratio: float = parameter(0.5, SHARE_ABOVE_0, "The share")

    @hookimpl
    def activate_stations(self, warehouse: WarehouseView) -> Sequence[int]:
        """Activate the first ones."""
        staffed = _staffed(warehouse)
        return _ids(staffed[: max(1, math.floor(self.ratio * len(staffed)))])


@define
class BacklogThreshold:
    """Open a station when many orders wait, close one when stations have little to do.

    Of the stations that their timetables have open, all are active at first. At most once in ``timeout_s``,

        more    if the backlog has more than ``open_above`` orders, one more is activated: that with the highest
                capacity (ties: lowest id)
        fewer   if the load of the active ones is less than 0.7 times their capacity, the one that would be activated
                last is active no longer

    and nothing changes where both hold. ``least`` of them stay active, or all if they are fewer.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8 (station activation "backlog threshold", whose code
    has the defaults; ``least`` is added, for there a backlog below the threshold may wait forever)
    """

    open_above: int = parameter(50, NOT_NEGATIVE, "Orders in the backlog above which another station is activated")
    timeout_s: float = parameter(600.0, NOT_NEGATIVE, "Time between two changes", "s")
    least: int = parameter(1, AT_LEAST_1, "How many stations are always active")
    _changed_s: float = field(init=False, default=-math.inf, repr=False, eq=False)

    @hookimpl
    def run_started(self) -> None:
        """Forget when the last run changed anything."""
        self._changed_s = -math.inf

    def memory(self) -> float | None:
        """Return when it last changed anything, for the state of a run."""
        return None if math.isinf(self._changed_s) else self._changed_s

    def remember(self, memory: float | None, warehouse: WarehouseView) -> None:  # noqa: ARG002
        """Take that back."""
        self._changed_s = -math.inf if memory is None else float(memory)

    @hookimpl
    def activate_stations(self, warehouse: WarehouseView) -> Sequence[int]:
        """Keep the active ones, except for one more or less."""
        active = {station.id for station in warehouse.stations if station.active}
        staffed = _staffed(warehouse)
        working = [station for station in staffed if station.active]
        resting = [station for station in staffed if not station.active]
        missing = max(self.least - len(working), 0)
        active.update(_ids(resting[:missing]))
        if missing or warehouse.now_s - self._changed_s < self.timeout_s:
            return sorted(active)
        more = warehouse.backlog_size > self.open_above
        room = sum(station.capacity for station in working)
        fewer = sum(station.load for station in working) < CLOSE_BELOW * room
        if more and not fewer and resting:
            active.add(resting[0].id)
            self._changed_s = warehouse.now_s
        elif fewer and not more and len(working) > self.least:
            active.remove(working[-1].id)
            self._changed_s = warehouse.now_s
        return sorted(active)
