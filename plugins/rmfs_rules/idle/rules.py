"""The rules: where robots rest, and when they charge."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, ClassVar

from attrs import define

from rmfs_core import RobotMove, hookimpl
from rmfs_rules.helpers.parameters import SHARE, SHARE_ABOVE_0, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Robot, WarehouseView


@define
class Stay:
    """Leave robots where they are: in the storage location where they set down a pod, under it.

    That is what happens without a rule, too.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    needs: ClassVar[tuple[str, ...]] = ("no batteries",)

    @hookimpl
    def idle_robots(self) -> Sequence[RobotMove]:
        """Send nobody anywhere."""
        return []


@define
class RestNearest:
    """Let robots rest where no pod stands: then they make way for nobody who comes for a pod.

    A robot that rests under a pod goes to the free storage location without one that it reaches first. Ties go to the
    lowest cell index, robots are asked by id.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    needs: ClassVar[tuple[str, ...]] = ("no batteries",)

    @hookimpl
    def idle_robots(self, warehouse: WarehouseView) -> Sequence[RobotMove]:
        """Send robots to the nearest free locations."""
        return _to_free(warehouse, lambda robot: _times(warehouse, robot))


@define
class RestMiddle:
    """Let robots rest where no pod stands, near the middle of the layout: from there no pod is far.

    A robot that rests under a pod goes to the free storage location without one that is nearest to the middle of the
    grid, along rows and columns. Ties go to the lowest cell index, robots are asked by id.

    References
    ----------
    M. Merschformann, L. Xie, H. Li: RAWSim-O: a simulation framework for robotic mobile fulfillment systems.
    Logistics Research 11, 8, 2018. https://doi.org/10.23773/2018_8
    """

    needs: ClassVar[tuple[str, ...]] = ("no batteries",)

    @hookimpl
    def idle_robots(self, warehouse: WarehouseView) -> Sequence[RobotMove]:
        """Send robots to the free locations in the middle."""
        layout = warehouse.travel.layout
        middle = layout.height // 2 * layout.width + layout.width // 2
        return _to_free(warehouse, lambda _: lambda cell: layout.distance(cell, middle))


@define
class ChargeWhenLow:
    """Send robots to a charger when their batteries are down to a share, and let them charge up to another.

    Of the robots without a task whose charge is below ``low`` (or too low for a task), the one with the least charge
    goes first, to the free charger that it reaches first; it takes no task until its charge is ``full``. Where no
    charger is left for one, robots that rest at a charger with a ``full`` battery make way: to the nearest free storage
    location, if possible one without a pod. All others stay where they are. Ties go to the lowest id and cell index.

    References
    ----------
    B. Zou, X. Xu, Y. Gong, R. de Koster: Evaluating battery charging and swapping strategies in a robotic mobile
    fulfillment system. European Journal of Operational Research 267(2), 2018. https://doi.org/10.1016/j.ejor.2017.12.008
    """

    low: float = parameter(0.3, SHARE, "Charge below which a robot goes")
    full: float = parameter(0.8, SHARE_ABOVE_0, "Charge up to which it stays")

    def __attrs_post_init__(self) -> None:
        if self.low >= self.full:
            raise ValueError(f"expected low below full, found low = {self.low} and full = {self.full}")

    @hookimpl
    def idle_robots(self, warehouse: WarehouseView) -> Sequence[RobotMove]:
        """Send robots to chargers, and away from them."""
        chargers = warehouse.chargers
        charged = [(robot.charge, robot) for robot in warehouse.resting_robots]
        wanting = [
            (charge, robot.id, robot)
            for charge, robot in charged
            if charge is not None and (charge < self.low or robot.low) and robot.cell not in chargers
        ]
        if not wanting:
            return []
        cells = warehouse.free_rest_cells
        free = [cell for cell in cells if cell in chargers]
        moves = []
        for _, _, robot in sorted(wanting)[: len(free)]:
            times = _times(warehouse, robot)
            nearest = min(free, key=lambda cell, times=times: (times(cell), cell))  # type: ignore[misc]
            free.remove(nearest)
            moves.append(RobotMove(robot.id, nearest, self.full))
        done = [r for charge, r in charged if r.cell in chargers and charge is not None and charge >= self.full]
        without_pod = {*warehouse.free_storage_locations}
        places = [cell for cell in cells if cell not in chargers]
        for robot in done[: min(len(wanting) - len(moves), len(places))]:
            times = _times(warehouse, robot)
            place = min(places, key=lambda cell, times=times: (cell not in without_pod, times(cell), cell))  # type: ignore[misc]
            places.remove(place)
            moves.append(RobotMove(robot.id, place))
        return moves


def _times(warehouse: WarehouseView, robot: Robot) -> Callable[[int], int]:
    """Return the driving time of a robot to each cell."""
    ticks = warehouse.travel.times_from(robot.cell, robot.heading, False)
    return lambda cell: int(ticks[cell])


def _to_free(warehouse: WarehouseView, cost_of: Callable[[Robot], Callable[[int], int]]) -> list[RobotMove]:
    """Send each robot that rests under a pod to the free location without one that costs it least."""
    without_pod = {*warehouse.free_storage_locations}
    beneath = [robot for robot in warehouse.idle_robots if robot.cell not in without_pod]
    if not beneath:
        return []
    free = [cell for cell in warehouse.free_rest_cells if cell in without_pod]
    moves = []
    for robot in beneath[: len(free)]:
        cost = cost_of(robot)
        best = min(free, key=lambda cell, cost=cost: (cost(cell), cell))  # type: ignore[misc]
        free.remove(best)
        moves.append(RobotMove(robot.id, best))
    return moves
