"""Joint POA+PPS rule ``pod-index``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from attrs import define, field, validators

from rmfs_core import JointDecision, OrderAssignment, PodTrip, hookimpl
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.warehouse import CAPACITY, UNLIMITED, columns_of, shown, stock_of
from rmfs_rules.helpers import OVERSIZE_WAIT_S
from rmfs_rules.helpers.oversize import Oversize, with_oversize
from rmfs_rules.helpers.packing import MOST_WORK, room_to_split
from rmfs_rules.helpers.pairs import places_taken
from rmfs_rules.helpers.parameters import AT_LEAST_1, NOT_NEGATIVE, POSITIVE, SHARE, parameter
from rmfs_rules.helpers.sending import load
from rmfs_rules.pod_index.alone import assign_alone, assign_whole
from rmfs_rules.pod_index.period import MOST_STEPS, NEVER, NONE, Ints, Weights, next_urgent
from rmfs_rules.pod_index.turns import decide

if TYPE_CHECKING:
    from rmfs_core.warehouse import Station, WarehouseView
    from rmfs_core.world.travel import Travel

MOST_SECONDS = 4096
"""Of how many seconds the power is kept in a table."""
NOTHING, NOWHERE = JointDecision(), np.zeros((0, 0), np.bool_)


@define(kw_only=True)
class PodIndex:
    """Take the lines that finish orders, and send the pods that bring most of them in the least time.

    A greedy rule without a solver, for few visits and a short turn-over at once. It may leave lines of an order for
    later. A line of SKU i with q items costs c seconds: handle_s * q, and cost_s / (open lines on the pod with most of
    them that has i), that times ``again`` where a pod at or bound for a station has i. c is fixed at the start of a
    call. Line l of order o is worth

        w = c_l / (sum of c over the open lines of o) ** finish,

    most when it is the last one, times priority_factor ** (its order's priority) and, with a due time,
    1 + (due_factor - 1) * exp(-max(seconds until it is due, 0) / due_s). The index of a pod for a station is the worth
    that it brings a second: the largest ratio, over the sets of lines that the pod would cover and the station does
    not, of

        sum of w to visit_s + handle_s * items,

    in which lines that another station covers count ``elsewhere`` times. (Of a SKU of which the pod has too few items,
    the lines that add most come first.)

    Stations take turns, fewest pods first. The one whose turn it is takes the covered line that is worth most. But when
    fewer than most_pods pods are there or on their way, and the largest index of a pod that is stored or leaving is
    above stay * w / (handle_s * q) of that line (above 0 where none is covered), it sends that pod, the nearest of
    equals, and takes its best line. A station that no pod is at or bound for waits for the first one: there pods whose
    index is less by up to the share ``near`` count as equals. Where neither is to be had, its slots stay free. While
    stations are at work, and once orders have come after the first ones, pods wait until it pays: one is sent only when
    the ages of its open lines, and base_s for each, add up to

        urge_s * (1 + (full - 1) * share of the station's slots that are taken);

    the rule wakes up then.

    A line that no single pod can serve is brought by several, when there is nothing else to send.

    Where an order can only be split while a box is free at the packing stations (or ``packing_capacity`` allows it), it
    is begun only then. Nor is an order split while the orders that are bound for the packing stations are more than
    ``packing_work_s`` seconds of work for each packer: where packers are what orders wait for, putting only keeps them
    from packing. When no order can be split and nothing else can be taken, an order is taken whole: the one of which
    the fewest lines lack a pod at or bound for a station where it fits. One of more items than any station takes
    goes to an empty station alone when all stations are empty.

    Lines of more items than any station takes are left for last. What is left of such an order goes to an empty
    station, which takes nothing else, when nothing else can be assigned or the order has waited for max_wait_s.

    References
    ----------
    W. E. Smith: Various optimizers for single-stage production. Naval Research Logistics Quarterly 3, 59-66, 1956.
    https://doi.org/10.1002/nav.3800030106 (weighted shortest processing time first: the idea behind the index)

    W. Dinkelbach: On nonlinear fractional programming. Management Science 13, 492-498, 1967.
    https://doi.org/10.1287/mnsc.13.7.492 (how the largest ratio is found)

    A. P. J. Vepsalainen, T. E. Morton: Priority rules for job shops with weighted tardiness costs. Management Science
    33, 1035-1047, 1987. https://doi.org/10.1287/mnsc.33.8.1035 (how a job is worth more the sooner it is due)
    """

    splits_over_time: ClassVar[bool] = True

    visit_s: float = parameter(
        300.0, NOT_NEGATIVE, "What a visit counts in a pod's index: the larger, the more lines a pod must bring", "s"
    )
    cost_s: float = parameter(
        1000.0, NOT_NEGATIVE, "What a visit costs the lines that need it: the larger, the more rare SKUs are worth", "s"
    )
    finish: float = parameter(
        0.85,
        NOT_NEGATIVE,
        "How much more a line is worth the less its order has left: 0 not at all, 1 as in Smith's rule",
    )
    stay: float = parameter(
        1.0,
        NOT_NEGATIVE,
        "How many times better than the best covered line a pod must be: the larger, the fewer visits",
    )
    elsewhere: float = parameter(
        0.7, SHARE, "What a line that another station covers counts in a pod's index: the smaller, the fewer visits"
    )
    most_pods: int = parameter(2, AT_LEAST_1, "Pods at or bound for a station from which on no further one is sent")
    urge_s: float = parameter(
        250.0,
        NOT_NEGATIVE,
        "What the ages of a pod's lines add up to before it is sent to a station with nothing to do: the "
        "larger, the fewer visits; 0: no waiting",
        "s",
    )
    full: float = parameter(31.0, AT_LEAST_1, "How many times as much it takes at a station that is all but full")
    base_s: float = parameter(10.0, POSITIVE, "What a line counts in `urge_s` besides its age", "s")
    handle_s: float = parameter(13.0, POSITIVE, "How long a picker is busy with an item", "s")
    near: float = parameter(
        0.2,
        SHARE,
        "By what share the index of a station's first pod may be less than the largest one if the pod is "
        "nearer: the larger, the less a station waits, and the more visits",
    )
    again: float = parameter(
        0.0,
        SHARE,
        "What share of `cost_s` also counts for lines of a SKU that a station has, whose pod would have to come again: "
        "larger than 0 for fewer visits, 0.3 where all orders are there at the start",
    )
    packing_capacity: int | None = parameter(
        None,
        validators.optional(AT_LEAST_1),
        "Split orders that may be open at once; by default as many as packing stations have boxes for",
    )
    packing_work_s: float = parameter(400.0, NOT_NEGATIVE, f"{MOST_WORK}; 0: no such limit", "s")

    priority_factor: float = parameter(
        2.0, POSITIVE, "How many times more a line is worth with each step of its order's priority"
    )
    due_factor: float = parameter(3.0, AT_LEAST_1, "How many times more a line is worth when its order is due or late")
    due_s: float = parameter(
        1800.0, POSITIVE, "How long before an order is due what its lines are worth more has fallen to 37 %", "s"
    )
    max_wait_s: float = parameter(
        OVERSIZE_WAIT_S,
        NOT_NEGATIVE,
        "Seconds in the backlog after which the oldest order with a line of more items than any station "
        "takes gets a station of its own: one takes nothing else until it is empty, and then that order alone",
        "s",
    )
    _weights: Weights = field(init=False, eq=False, repr=False)
    _stations: tuple[Station, ...] = field(default=(), init=False, eq=False, repr=False)
    _ticks: Ints = field(init=False, eq=False, repr=False)  # driving times to these, which never change in a run

    def __attrs_post_init__(self) -> None:
        """Make of the parameters what compiled code takes."""
        self._weights = Weights(
            **{name: float(getattr(self, name)) for name in Weights._fields[:11]},
            most_pods=self.most_pods,
            urge_ticks=to_ticks(self.urge_s),
            base_ticks=to_ticks(self.base_s),
            priority=np.array([float(self.priority_factor) ** steps for steps in range(-MOST_STEPS, MOST_STEPS + 1)]),
            least=np.power(np.arange(MOST_SECONDS, dtype=np.float64), max(self.finish, 0.0)),  # below 0: refused
        )

    def prepare(self, travel: Travel) -> None:
        """Load the compiled period, or compile it, and search for the ways to the stations."""
        load()
        lines, stock, stations = columns_of((), 1), stock_of((), 1), shown(np.zeros(1, CAPACITY))
        state = tuple(lines), tuple(stock), tuple(self._weights), stations, 0
        decide(*state, NONE, NOWHERE, np.zeros((1, 1), np.int64), 0)
        next_urgent(*state)
        for station in travel.layout.stations:
            travel.times_to(station.station, True)

    @hookimpl
    def assign_orders_and_pods(self, warehouse: WarehouseView) -> JointDecision:
        """Take lines and send pods, one after another, until the slots are taken or left free."""
        if not warehouse.backlog_size:
            return NOTHING
        lines = warehouse.lines
        if lines.quantity[lines.quantity.argmax()] <= warehouse.largest_capacity:  # `max` takes ten times as long
            return self._decide(warehouse)
        return with_oversize(
            warehouse,
            Oversize.of(warehouse, self.max_wait_s, splits=True, over_time=True),
            lambda without: self._decide(warehouse, without),
            lambda large: assign_alone(warehouse, large.order, large.station),
        )

    @hookimpl
    def wake_at(self, warehouse: WarehouseView) -> float | None:
        """Return when the ages of the lines of a pod will add up, if a station could take it then."""
        if not warehouse.backlog_size or not self._waits(warehouse):
            return None
        tick = next_urgent(*self._state(warehouse))
        return None if tick == NEVER else to_seconds(tick)

    def _decide(self, warehouse: WarehouseView, without: Station | None = None) -> JointDecision:
        """Decide about all orders that need no station of their own; ``without`` takes nothing now."""
        if self._stations is not warehouse.stations:
            self._stations, travel = warehouse.stations, warehouse.travel
            self._ticks = np.array([travel.times_to(at.cell, True).min(axis=1) for at in self._stations])
        room = room_to_split(warehouse, self.packing_capacity, self.packing_work_s)
        takes, sends = decide(
            *self._state(warehouse),
            NONE if without is None else without.id,
            places_taken(warehouse) if warehouse.largest_capacity == UNLIMITED else NOWHERE,
            self._ticks,
            UNLIMITED if room is None else room,
        )
        if len(takes) or len(sends):
            parts: dict[tuple[int, int], list[int]] = {}
            for at, order, sku in takes.tolist():
                parts.setdefault((order, at), []).append(sku)
            assigned = [OrderAssignment(order, at, tuple(skus)) for (order, at), skus in parts.items()]
            return JointDecision(assigned, [PodTrip(pod, at) for pod, at in sends.tolist()])
        if room != 0 or warehouse.free_boxes is None:
            return NOTHING
        decided = assign_whole(warehouse, self.most_pods, without)
        if not decided.assignments and (large := Oversize.left(warehouse)) is not None:
            decided = assign_alone(warehouse, large.order, large.station)
        return decided

    def _state(self, warehouse: WarehouseView) -> tuple[Any, ...]:
        """Return the arguments that `decide` and `next_urgent` begin with."""
        weights = self._weights if self._waits(warehouse) else self._weights._replace(urge_ticks=0)
        return tuple(warehouse.lines), tuple(warehouse.stock), tuple(weights), warehouse.capacities, warehouse.now_tick

    def _waits(self, warehouse: WarehouseView) -> bool:
        """Whether pods wait until they are wanted enough: once orders have come after the first ones, more may come."""
        lines, first_s = warehouse.lines, warehouse.order(0).arrival_s
        if lines.arrival_s[-1] == first_s and warehouse.orders[-1].arrival_s == first_s:  # `orders` takes its time
            return False
        return self._weights.urge_ticks > 0
