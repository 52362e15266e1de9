"""Which packing station an order is bound for, and what a packer does next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define

from rmfs_core import hookimpl
from rmfs_rules.helpers.packing import bound_for

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, PackingTask, WarehouseView


@define
class LeastReserved:
    """Send an order to the packing station with the fewest boxes reserved.

    A split order goes to the station with the fewest boxes reserved (of equals, the one with the fewest orders bound
    for it), any other to the station with the fewest orders bound for it (of equals, the one with the fewest boxes
    reserved). Ties go to the lowest id. Of several orders each counts for the next.

    References
    ----------
    R. L. Graham: Bounds on multiprocessing timing anomalies. SIAM Journal on Applied Mathematics 17, 416-429, 1969.
    https://doi.org/10.1137/0117039 (list scheduling: the next job to the least loaded machine)
    """

    @hookimpl
    def assign_packing(self, warehouse: WarehouseView, orders: Sequence[Order]) -> Sequence[int]:
        """Choose by load alone."""
        return bound_for(warehouse, orders, lambda _order, _station: 0.0)


@define
class PackFirst:
    """Pack the order that waits longest; put parts into boxes only while none waits to be packed.

    Packing frees boxes, putting fills them.

    References
    ----------
    J. Gallien, T. Weber: To wave or not to wave? Order release policies for warehouses with an automated sorter.
    Manufacturing & Service Operations Management 12, 642-662, 2010. https://doi.org/10.1287/msom.1100.0291 (what
    happens where orders that are not complete fill all slots)
    """

    @hookimpl
    def choose_packing_task(self, tasks: Sequence[PackingTask]) -> int:
        """Choose the first order to pack, or else the first part."""
        return min(range(len(tasks)), key=lambda i: tasks[i].kind != "pack")


@define
class DueFirst:
    """Do what belongs to the order that is due first, whether to put or to pack.

    Orders without a due time come last. Of equals, those of the highest priority come first, then what waits longest.

    References
    ----------
    J. R. Jackson: Scheduling a production line to minimize maximum tardiness. Management Sciences Research Project,
    Research Report 43, University of California, Los Angeles, 1955.

    S. S. Panwalkar, W. Iskander: A survey of scheduling rules. Operations Research 25(1), 45-61, 1977.
    https://doi.org/10.1287/opre.25.1.45
    """

    @hookimpl
    def choose_packing_task(self, tasks: Sequence[PackingTask]) -> int:
        """Choose by due time."""
        due = [math.inf if task.order.due_s is None else task.order.due_s for task in tasks]
        return min(range(len(tasks)), key=lambda i: (due[i], -tasks[i].order.priority))


@define
class Shortest:
    """Do what takes the least time; of equals, what waits longest.

    References
    ----------
    W. E. Smith: Various optimizers for single-stage production. Naval Research Logistics Quarterly 3, 59-66, 1956.
    https://doi.org/10.1002/nav.3800030106 (shortest processing time first: the least mean time in the system)
    """

    @hookimpl
    def choose_packing_task(self, tasks: Sequence[PackingTask]) -> int:
        """Choose by duration."""
        return min(range(len(tasks)), key=lambda i: tasks[i].duration_s)
