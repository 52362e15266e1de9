"""A schedule made beforehand, and the rule that replays it through the hooks that every rule has."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from attrs import define, field

from rmfs_core import JointDecision, OrderAssignment, PodTrip, hookimpl
from rmfs_core.errors import InputError
from rmfs_core.wording import counted
from rmfs_core.world import make_instance, make_layout

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo
    from rmfs_core.scenario import Scenario
    from rmfs_core.warehouse import Station, WarehouseView

REPLAY = "Replay"
"""Name of the rule in results."""

Visit = tuple[int, tuple[tuple[int, int], ...]]
"""A pod (its id), and the lines that it serves: order and SKU (ids) of each."""
Plan = tuple[tuple[Visit, ...], ...]
"""The visits at each picking station, first to last."""


def plan_of(rule: Any, scenario: Scenario, place: str) -> Plan:
    """Return the plan of a table of the rule `REPLAY`.

    Raises
    ------
    InputError
        When it has none, or one that does not serve each line of the scenario once, from a pod with its SKU, at the
        picking stations.
    """
    given = rule.get("plan") if isinstance(rule, Mapping) else None
    try:
        plan = tuple(
            tuple((pod, tuple((order, sku) for order, sku in lines)) for pod, lines in visits) for visits in given or ()
        )
    except (TypeError, ValueError):
        plan = ()
    served = [(pod, *line) for visits in plan for pod, lines in visits for line in lines]
    if not served or not all(type(number) is int for line in served for number in line):
        expected = "expected a list for each picking station, of visits [pod, [[order, SKU], ...]], as ids"
        raise InputError(place, f"found a plan of another form; {expected}")
    instance, layout = make_instance(scenario), make_layout(scenario)
    if len(plan) != (stations := len(layout.stations) - layout.replenishing):
        raise InputError(place, f"found {counted(len(plan), 'list')}; expected {stations}, one a picking station")
    holds = {(pod, sku) for pod, data in enumerate(instance.pods) for sku, _ in data.contents}
    for pod, order, sku in served:
        if (pod, sku) not in holds:
            raise InputError(place, f"takes SKU {sku} of order {order} from pod {pod}, which does not hold it")
    wanted = Counter((order, sku) for order, data in enumerate(instance.orders) for sku, _ in data.lines)
    found = Counter((order, sku) for _, order, sku in served)
    if wrong := sorted((found - wanted) | (wanted - found)):
        order, sku = wrong[0]
        times = f"{found[wrong[0]]} times, expected {wanted[wrong[0]]}"
        raise InputError(place, f"serves SKU {sku} of order {order} {times}")
    return plan


@define
class Replay:
    """Assign the lines of a plan in its order, as many as fit at a station, and send the pod of each.

    A joint rule (POA+PPS). A pod that is at the station already, or bound for it, is not sent again. Where its station
    is full, a line waits, and all lines of the station after it.

    Parameters
    ----------
    plan
        The visits of each picking station: pod, and order and SKU of its lines. Ids.
    """

    plan: Sequence[Sequence[tuple[int, Sequence[tuple[int, int]]]]]
    splits_over_time: ClassVar[bool] = True
    _next: list[int] = field(init=False, factory=list)
    _lines: list[list[tuple[int, int, int]]] = field(init=False, factory=list)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:  # noqa: ARG002
        """Begin the plan anew."""
        self._lines = [[(pod, *line) for pod, lines in visits for line in lines] for visits in self.plan]
        self._next = [0] * len(self._lines)

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView) -> JointDecision:
        """Go on with the plan at every station with free capacity."""
        assigned: dict[tuple[int, int], int] = {}
        trips: dict[tuple[int, int], None] = {}
        for station in warehouse.stations[: len(self._lines)]:
            self._go_on(warehouse, station, assigned, trips)
        return JointDecision(
            [OrderAssignment(order, station, (sku,)) for (station, order), sku in assigned.items()],
            [PodTrip(pod, station) for station, pod in trips],
        )

    def _go_on(
        self,
        warehouse: WarehouseView,
        station: Station,
        assigned: dict[tuple[int, int], int],
        trips: dict[tuple[int, int], None],
    ) -> None:
        at, lines, free = station.id, self._lines[station.id], station.free_capacity
        inbound = {pod.id for pod in station.inbound_pods}
        while self._next[at] < len(lines):
            pod, number, sku = lines[self._next[at]]
            if (
                at,
                number,
            ) in assigned:  # in the next period: capacity of its own, free as soon as it is done
                return
            order = warehouse.order(number)
            size = 1
            if not station.counts_orders:
                size = next(line.quantity for line in order.lines if line.sku == sku)
            elif order.has_place_at(at):
                size = 0
            if size > free:
                return
            free -= size
            assigned[at, number] = sku
            if pod not in inbound:
                trips[at, pod] = None
            self._next[at] += 1
