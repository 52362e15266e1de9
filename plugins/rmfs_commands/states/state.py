"""The format of decision states, version 2: every key with its meaning, unit and default.

Version 1, which is read too, has no due times, priorities, items in hand and opening hours, and nothing of
replenishment or packing; a state without is written as version 1.

Orders, pods, stations, robots and SKUs are called by their names; the order in which a state lists them is the order
of their ids, by which rules break ties. What a warehouse management system does not know it leaves out.
"""

# ruff: noqa: RUF009
# (`key` is attrs' `field` with its documentation: it makes a field, not a default.)

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from attrs import frozen

from rmfs_commands.cli.options import DECIDING
from rmfs_commands.cli.schema import schema_of
from rmfs_core.motion import Motion
from rmfs_core.roles import Role
from rmfs_core.scenario.checks import DURATION, MAYBE_NO_TIME, MOVING, Check, at_least, key, within
from rmfs_core.scenario.model import LayoutSection, PackingSection
from rmfs_core.wording import listed

FORMAT = "rmfs-state"
VERSIONS = (1, 2)
ASKED = (*DECIDING, Role.PP)
"""The decisions that can be asked of a state; those of PP are not recorded."""
DECIDES = tuple(role.label for role in ASKED)
"""Their names."""

FACTS = ("promises", "next", "arrivals", "leaving")
"""Facts that the kernel works out from a state, and that can be asked for besides a decision."""

KINDS = (
    *("leg", "wait", "drive", "room", "line", "lift", "set", "picker", "pick", "stow", "charge"),
    *("release", "handled", "bundle", "alarm", "arrivals", "bundles", "hours"),
    *("outages", "tote", "totes", "conveyor", "put", "pack", "packers"),
)
"""Kinds of things that may be going on."""

MOST = 1_000_000_000
"""Largest number of items, capacity and the like that a state may have."""


def _one_of(*values: str | int) -> Check:
    return Check(listed(map(str, values), "or"), lambda value: value in values, {"enum": list(values)})


def _number(least: int, most: int = MOST) -> Check:
    """Return the check for a whole number that is no nonsense: sums of such numbers fit into 64 bits."""
    schema = {"minimum": least, "maximum": most}
    return Check(f"a whole number from {least} to {most:,}", lambda value: least <= value <= most, schema)


_TIME = within(-1e10, 1e10)
"""Check for a time in seconds: it can be counted in ticks."""
_ITEMS = Check(
    f"numbers of items from 0 to {MOST:,}, or null",
    lambda held: all(n is None or 0 <= n <= MOST for n in held.values()),
)
_SIZES = Check(f"sizes from 1 to {MOST:,}", lambda sizes: all(1 <= n <= MOST for n in sizes.values()))
_QUANTITIES = Check(
    f"one line or more, with quantities from 1 to {MOST:,}",
    lambda lines: bool(lines) and all(1 <= n <= MOST for n in lines.values()),
)


@frozen
class LayoutState:
    """The grid: the rows of a text map, or the numbers of the block layout."""

    map: tuple[str, ...] | None = key("Rows of a text map, north at the top, signs as in `layout.map_file`", None)
    blocks: LayoutSection | None = key("Numbers of the block layout, as in a scenario's `layout`", None)

    def __attrs_post_init__(self) -> None:
        if (self.map is None) == (self.blocks is None):
            raise ValueError("expected either `map` or `blocks`")
        if self.blocks is not None and self.blocks.map_file is not None:
            raise ValueError("expected no `map_file` in a state; give the rows of the map as `map`")


@frozen
class MotionState:
    """How robots move, for driving times."""

    acceleration_m_per_s2: float = key("Acceleration and deceleration", 1.0, unit="m/s^2", check=MOVING)
    top_speed_m_per_s: float = key("Top speed", 1.5, unit="m/s", check=MOVING)
    full_turn_s: float = key("Time of a full turn on the spot", 2.5, unit="s", check=DURATION)
    lift_s: float = key("Time to lift a pod, and to set it down", 2.2, unit="s", check=MAYBE_NO_TIME)

    def motion(self) -> Motion:
        """Return the kinematics."""
        return Motion(self.acceleration_m_per_s2, self.top_speed_m_per_s, self.full_turn_s, self.lift_s)


@frozen
class PodState:
    """A pod with contents."""

    contents: Mapping[str, int | None] = key("Items of each SKU on the pod; null: it never runs out", check=_ITEMS)
    cell: int | None = key(
        "Cell of the storage location it stands in (row * width + column, from 0 in the north-west); "
        "left out while a robot carries it, and where the state has no layout",
        None,
        check=_number(0),
    )
    home: int | None = key("Cell of the storage location it stood in at first; left out: `cell`", None)
    bound_for: tuple[str, ...] | None = key(
        "Stations it is at or bound for, in the order of its visits; left out: as the stations' `inbound` have it", None
    )
    capacity: int | None = key("Space on it, in the unit of `sizes`; left out: any amount", None, check=_number(1))


@frozen
class RequestState:
    """An item that is still to be picked at a station."""

    order: str = key("Order it is for")
    sku: str = key("SKU")
    pod: str | None = key("Inbound pod that the item is promised from; left out: the first that has one free", None)
    id: int | None = key("Number of the request; left out: counted on", None, check=_number(0))


@frozen
class InHandState:
    """An item that is picked and still to be handled."""

    order: str = key("Order it is for")
    sku: str = key("SKU")


@frozen
class StationState:
    """A station: for picking with a capacity for items or orders, for replenishment with one for bundles."""

    item_capacity: int | None = key("Items that may be assigned at a time", None, unit="items", check=_number(1))
    order_capacity: int | None = key(
        "Orders that may be assigned at a time, instead of `item_capacity`", None, unit="orders", check=_number(1)
    )
    queue_length: int | None = key(
        "Pods that can wait besides the one being worked on; left out: as the layout has it, or 12",
        None,
        check=_number(1),
    )
    requests: tuple[RequestState, ...] = key("Items to pick there, the oldest first", ())
    in_hand: InHandState | None = key(
        "Item that is picked and whose order uses capacity until it is handled (`stations.release`); left out: none",
        None,
    )
    inbound: tuple[str, ...] | None = key(
        "Pods at the station or bound for it, as their trips were decided; left out: the pods of `line`", None
    )
    line: tuple[str, ...] = key("Pods at the station (first) and in its queue", ())
    queue_room: int | None = key(
        "Pods that could still set out for it; left out: what `line` leaves", None, check=_number(0)
    )
    picker_free_s: float | None = key(
        "When the picker will have handled the item in hand; left out: now", None, unit="s", check=_TIME
    )
    staffed: bool = key("Whether it is open by its timetable; false: it takes no new orders", True)
    in_service: bool = key("Whether it works; false: it has failed, and takes no new orders", True)
    active: bool = key("Whether the activation rule has it take orders; false: it takes no new orders", True)
    changes_s: float | None = key(
        "When its timetable closes it next, or opens it, where it is not staffed; left out: never",
        None,
        unit="s",
        check=_TIME,
    )

    @property
    def needs_version_2(self) -> bool:
        """Whether it tells what version 1 does not know."""
        others = (self.in_hand, self.picker_free_s, self.changes_s)
        return any(other is not None for other in others) or not (self.staffed and self.active and self.in_service)

    bundle_capacity: int | None = key(
        "Bundles that may be assigned at a time; left out: nothing is stored there", None, check=_number(1)
    )

    @property
    def picks(self) -> bool:
        """Whether orders are picked at it."""
        return self.item_capacity is not None or self.order_capacity is not None

    def __attrs_post_init__(self) -> None:
        both = self.item_capacity is not None and self.order_capacity is not None
        if both or not (self.picks or self.bundle_capacity):
            raise ValueError("expected either `item_capacity` or `order_capacity`")


@frozen
class PartState:
    """Part of an order that one period assigned to a station."""

    station: str = key("The station")
    skus: tuple[str, ...] = key("SKUs of the lines assigned; each line goes to one station whole")
    period: int | None = key(
        "Number of the period; what a period assigns to a station is one part, which keeps its capacity until all of "
        "it is done. Left out: the first that has no other part of the order at the station",
        None,
        check=_number(1),
    )


@frozen
class OrderPackingState:
    """Where an order is packed, and how far that is."""

    station: str = key("Packing station: its number, from 1")
    box: int | None = key("Number of its box there, from 0; left out: it is not split", None, check=_number(0))
    first_part_s: float | None = key("When its first part came there; left out: none has", None, unit="s", check=_TIME)
    items_in_box: int = key("Its items in its box", 0, check=_number(0))
    expected_s: float | None = key(
        "When it would be packed if no other part came and a packer were free", None, unit="s", check=_TIME
    )
    packed: bool = key("Whether it is packed", False)


@frozen
class TaskState:
    """A task that waits for a packer, or is being done."""

    kind: str = key("`put` (a tote into the order's box) or `pack`", check=_one_of("put", "pack"))
    order: str = key("The order")
    tote: int = key("The tote, or the one of the order that came last", 0, check=_number(0))
    items: int = key("Number of items", 1, check=_number(1))
    duration_s: float = key("How long it takes", 0.0, unit="s", check=_TIME)
    since_s: float = key("Since when it waits", 0.0, unit="s", check=_TIME)
    until_s: float | None = key("When it will be done; left out: it waits", None, unit="s", check=_TIME)


@frozen
class PackingStationState:
    """A packing station."""

    orders: tuple[str, ...] | None = key(
        "Orders that are bound for it and not packed, as that was decided; left out: in the order of `orders`", None
    )
    tasks: tuple[TaskState, ...] = key("What waits for a packer, the longest waiting first", ())
    working: tuple[TaskState, ...] = key("What is being done", ())
    zero_s: float = key("Time of the day at time 0, in seconds from midnight; hours count from it", 0.0, check=_TIME)


@frozen
class PackingState:
    """The packing stations."""

    section: PackingSection = key("Boxes, packers and times, as in a scenario's `packing`", factory=PackingSection)
    stations: tuple[PackingStationState, ...] = key("Packing stations", (PackingStationState(),))

    def __attrs_post_init__(self) -> None:
        if not self.stations:
            raise ValueError("expected one packing station or more in `stations`")


@frozen
class OrderState:
    """A pick order that has arrived."""

    lines: Mapping[str, int] = key("Items wanted of each SKU", check=_QUANTITIES)
    arrival_s: float = key("When it arrived", 0.0, unit="s", check=_TIME)
    due_s: float | None = key("When it shall be complete; left out: whenever", None, unit="s", check=_TIME)
    priority: int = key("How urgent it is, higher first", 0, check=_number(0))
    waits_for_stock: bool | None = key(
        "Whether it waits for stock, so that no rule is shown it; left out: it does if what the pods hold, less the "
        "stations' requests, is too little for it; orders that are begun take their share first, then the older ones",
        None,
    )
    parts: tuple[PartState, ...] | None = key(
        "What was assigned so far, also what is picked already; left out: the lines that stations have requests of. "
        "Every other line is open: in the backlog",
        None,
    )
    cancelled: bool = key("Whether it has left before anything of it was assigned: none of its lines is open", False)
    packing: OrderPackingState | None = key(
        "Where it is packed; left out: no part of it is assigned, or there are no packing stations", None
    )


@frozen
class BundleState:
    """A bundle that has arrived and is not stored yet."""

    name: str = key("Name")
    sku: str = key("SKU")
    items: int = key("Number of items", check=_number(1))
    arrival_s: float = key("When it arrived", 0.0, unit="s", check=_TIME)
    station: str | None = key("Station that it is assigned to; left out: none", None)
    pod: str | None = key("Pod that it will be stored on, which is bound for the station; left out: none", None)
    id: int | None = key("Number of the bundle; left out: counted on", None, check=_number(0))


@frozen
class RobotState:
    """A robot."""

    cell: int | None = key("Cell where it stands; left out where the state has no layout", None, check=_number(0))
    heading: int = key("0 east, 1 north, 2 west, 3 south", 1, check=_one_of(0, 1, 2, 3))
    task: str | None = key("Pod it carries or is on its way to fetch; left out: none", None)
    on_duty: bool = key("Whether it takes tasks; false: it finishes the one that it has", True)
    in_service: bool = key("Whether it works; false: it has failed, or is maintained", True)
    goal: int | None = key(
        "Cell that it was sent to without a task, or charges in; left out: none", None, check=_number(0)
    )
    charge: float | None = key("What is in its battery, 0 to 1; left out: it has none", None, check=within(0, 1))
    low: int = key("1 where its charge is too low for a task", 0, check=_one_of(0, 1))


@frozen
class AskState:
    """Subject of the question, if the rest of the state does not say it."""

    decides: str | None = key(
        listed((f"`{label}`" for label in DECIDES), "or"),
        None,
        check=_one_of(*DECIDES),
    )
    period: int | None = key(
        "Number of the period; left out: one more than the latest that assigned anything", None, check=_number(0)
    )
    max_fetches: int | None = key(
        "PPS, RPS, ROA+RPS: stored pods that may be sent; left out: idle robots less waiting pods, no limit where "
        "robots are not listed",
        None,
        check=_number(0),
    )
    max_moves: int | None = key(
        "Repositioning: pods that may be moved; at most, and where it is left out: idle robots less waiting pods",
        None,
        check=_number(0),
    )
    pod: str | None = key("PR: the pod to store", None)
    robot: str | None = key("PP: the robot that needs a path", None)
    goal: int | None = key("PP: the cell it has to reach; the others stand where they are", None, check=_number(0))
    orders: tuple[str, ...] | None = key(
        "Packing: the orders; left out: orders that are begun and bound for no packing station", None
    )
    station: str | None = key(
        "Packing task: the packing station where a packer is free; left out: the first with tasks for one", None
    )

    repair: str | None = key(
        "POA+PPS: installed PPS rule that sends pods for requests that have none on its way, after the decision; "
        "`none`: nobody does; left out: `demand`, and `none` where the state has no layout",
        None,
    )
    tell: tuple[str, ...] = key(
        f"Facts of the state to tell besides: {listed([f'`{fact}`' for fact in FACTS])}",
        (),
        check=Check(
            f"{listed(FACTS, 'or')}, each once", lambda told: {*told} <= {*FACTS} and len({*told}) == len(told)
        ),
    )

    @property
    def role(self) -> Role | None:
        """Subject of the question."""
        return None if self.decides is None else Role.labelled(self.decides)


@frozen
class RandomState:
    """State of the rule's random generator, numpy's PCG64. Numbers of 128 bits are texts."""

    state: str = key("State")
    increment: str = key("Increment")
    has_uint32: int = key("Whether half a number is left over: 0 or 1", 0, check=_one_of(0, 1))
    uinteger: int = key("That half", 0, check=_number(0, (1 << 32) - 1))

    def __attrs_post_init__(self) -> None:
        for text in (self.state, self.increment):
            if not (text.isascii() and text.isdecimal() and int(text) < 1 << 128):
                raise ValueError(f'expected texts of decimal digits, numbers below 2^128, found "{text}"')


_LEGS = Check(
    "pairs of a cell and the seconds of waiting before it",
    lambda legs: all(len(leg) == 2 and leg[0] == leg[0] // 1 >= 0 and 0 <= leg[1] <= 1e10 for leg in legs),
)
_TIMES = Check("times from -1e10 to 1e10", lambda times: all(abs(second) <= 1e10 for second in times.values()))
_JOULES = Check(
    "pairs of the joules in a battery, 0 or more, and a time",
    lambda held: all(len(one) == 2 and one[0] >= 0 and abs(one[1]) <= 1e10 for one in held.values()),
)
_PUTS = Check(
    "seconds from 0 to 1e10, by numbers of totes",
    lambda puts: all(tote.isdecimal() and len(tote) < 19 and 0 <= put_s <= 1e10 for tote, put_s in puts.items()),
)
_DRAWN = Check(
    f"numbers from 0 to {MOST:,}, by words and numbers below 2^63",
    lambda drawn: all(
        0 <= number <= MOST and all(len(part) < 19 for part in what.split(" ")) for what, number in drawn.items()
    ),
)

STORIES = ("transport", "store", "move", "rest")


@frozen
class GoingState:
    """Something that is going on; `rmfs_core.simulation.going.Going` has the kinds."""

    kind: str = key("What it is", check=_one_of(*KINDS))
    robot: str | None = key("Robot that does it", None)
    station: str | None = key("Station where an item is handled, or a tote is", None)
    packing: str | None = key("Packing station of a task, or that opens: its number, from 1", None)
    order: str | None = key("Order of a tote, or of an item that is handled, and done when it was picked", None)
    tote: int = key("Number of a tote on a conveyor, or of a task at work", 0, check=_number(0))
    sku: str | None = key("SKU of an item or a bundle", None)
    items: int = key("Items of a bundle that is ordered, or in a tote", 0, check=_number(0))
    visit: int = key("Number of the visit", 0, check=_number(0))
    visit_since_s: float = key("When that began", 0.0, unit="s", check=within(0, 1e10))
    picks: int = key("Picks in it so far", 0, check=_number(0))
    since_s: float = key("When it began", 0.0, unit="s", check=within(0, 1e10))
    until_s: float = key("When it ends; left out: when something else happens", 0.0, unit="s", check=_TIME)
    legs: tuple[tuple[float, ...], ...] = key("Cell and wait (s) of each leg that is not driven yet", (), check=_LEGS)
    overtaken: int = key("How often it was overtaken in its line", 0, check=_number(0))
    story: str | None = key("What the robot does: `transport`, `store`, `move`, `rest`", None, check=_one_of(*STORIES))
    cell: int | None = key("Cell where that ends", None, check=_number(0))
    charge: float = key("Share of the battery's capacity until which it rests", 0.0, check=within(0, 1))


@frozen
class PackedState:
    """Times of an order on its way to be packed."""

    bound_s: float = key("When it was bound for its packing station", 0.0, unit="s", check=within(0, 1e10))
    parts_s: tuple[float, ...] = key(
        "When its parts came there (s)", (), check=Check("times up to 1e10", lambda at: all(0 <= s <= 1e10 for s in at))
    )
    begun_s: float | None = key("When packing began", None, unit="s", check=within(0, 1e10))
    packed_s: float | None = key("When it was packed", None, unit="s", check=within(0, 1e10))


@frozen
class OutageState:
    """When a robot, station or charger fails next, or works again."""

    of: str = key("`robot`, `station` or `charger`", check=_one_of("robot", "station", "charger"))
    id: int = key("Its number in the order of the state, of chargers in that of their cells, from 0", check=_number(0))
    number: int = key("How often it has been out of service, and worked again", 0, check=_number(0))
    planned: bool = key("Whether it is being maintained", False)
    fails_s: float | None = key("When it fails next; left out: never", None, unit="s", check=within(0, 1e10))
    repair_s: float = key("How long that repair takes", 0.0, unit="s", check=within(0, 1e10))
    until_s: float | None = key(
        "Until when it is out of service; left out: it works, or is maintained without end", None, unit="s", check=_TIME
    )


@frozen
class RunState:
    """Facts that only a run that goes on from here needs, as `rmfs run --save-state` writes them."""

    going: tuple[GoingState, ...] = key("What is going on: in the order in which it ends, then what waits", ())
    visits: int = key("Visits so far", 0, check=_number(0))
    periods: int = key("Periods so far", 0, check=_number(0))
    bundles: int = key("Bundles that have arrived so far", 0, check=_number(0))
    wakes_s: float | None = key("When rules want to be woken up", None, unit="s", check=_TIME)
    assigned_s: Mapping[str, float] = key("When the last line of an order was assigned", factory=dict, check=_TIMES)
    completed_s: Mapping[str, float] = key("When an order was complete", factory=dict, check=_TIMES)
    cancelled_s: Mapping[str, float] = key("When an order was cancelled", factory=dict, check=_TIMES)
    bundles_s: Mapping[str, float] = key("When a bundle was assigned to its station", factory=dict, check=_TIMES)
    pickers_s: Mapping[str, float] = key(
        "When a station's picker will be free, where that is known", factory=dict, check=_TIMES
    )
    joules: Mapping[str, tuple[float, ...]] = key(
        "What was in a robot's battery, and when (s)", factory=dict, check=_JOULES
    )
    random: Mapping[str, RandomState] = key("Random generators of rules", factory=dict)
    drawn: Mapping[str, int] = key(
        "How many service times were drawn, by what they were for", factory=dict, check=_DRAWN
    )
    begun: Mapping[str, tuple[int, ...]] = key("Visit, order and SKU of a station's last pick (ids)", factory=dict)
    memory: Mapping[str, Any] = key("What rules remember", factory=dict)
    outages: tuple[OutageState, ...] = key("Robots, stations and chargers that fail or are maintained", ())
    totes: int = key("Totes sent to packing stations so far", 0, check=_number(0))
    puts_s: Mapping[str, float] = key(
        "How long it takes to put the items of a tote into a box, of those that wait for that",
        factory=dict,
        check=_PUTS,
    )
    packing: Mapping[str, PackedState] = key(
        "Orders that are bound for packing stations, as that was decided", factory=dict
    )


@frozen
class State:
    """The warehouse as a rule sees it when it is asked."""

    pods: Mapping[str, PodState] = key("Pods with contents, by name")
    stations: Mapping[str, StationState] = key(
        "Stations, by name, stations that only store last; with a layout, in the order of its stations, row by "
        "row from the north-west"
    )
    orders: Mapping[str, OrderState] = key("Orders that have arrived, by name; orders that are done may be left out")
    format: str = key(f"`{FORMAT}`", FORMAT, check=_one_of(FORMAT))
    version: int = key(
        f"Version of the format: {listed(map(str, VERSIONS), 'or')}", VERSIONS[-1], check=_one_of(*VERSIONS)
    )
    time_s: float | None = key("Time now; left out: the latest arrival", None, unit="s", check=_TIME)
    skus: tuple[str, ...] | None = key("SKUs; left out: in the order in which pods and orders name them", None)
    layout: LayoutState | None = key("The grid; left out: rules cannot ask for locations and driving times", None)
    motion: MotionState = key("How robots move", factory=MotionState)
    robots: Mapping[str, RobotState] | None = key(
        "Robots by name; left out, as many as carry the pods in the stations' lines", None
    )
    waiting: tuple[str, ...] | None = key(
        "Stored pods bound for a station that no robot fetches yet, the longest waiting first; left out: as listed",
        None,
    )
    empty_pods: tuple[int, ...] = key("Cells of storage locations that hold an empty pod", ())
    reserved: tuple[int, ...] = key("Cells of storage locations that a pod is on its way to", ())
    bundles: tuple[BundleState, ...] | None = key(
        "Bundles that are not stored yet, the oldest first; those at a station, and for a pod, as that was decided; "
        "left out: none",
        None,
    )
    packing: PackingState | None = key("Packing stations; left out: there are none", None)
    sizes: Mapping[str, int] | None = key("Space that an item of a SKU takes on a pod; left out: 1", None, check=_SIZES)
    backlog: tuple[str, ...] | None = key(
        "Orders that the rule is shown; left out: all that have open lines (recorded where prefilters are in use)", None
    )
    ask: AskState = key("What is asked", factory=AskState)
    seed: int = key("Seed of the rule's random generator, where `random` is left out", 1, check=at_least(0))
    random: RandomState | None = key("State of the rule's random generator, where it has drawn already", None)
    chargers_down: tuple[int, ...] = key("Cells of chargers that are out of service", ())
    run: RunState | None = key(
        "What a run that goes on from here needs besides; left out: rules are asked first, and robots set out from "
        "where they stand",
        None,
    )

    def __attrs_post_init__(self) -> None:
        if self.version == VERSIONS[0] and any(o.due_s is not None or o.priority for o in self.orders.values()):
            raise ValueError("found `due_s` or `priority` in a state of version 1; expected version 2 with them")
        if self.version == VERSIONS[0] and any(s.in_hand is not None for s in self.stations.values()):
            raise ValueError("found `in_hand` in a state of version 1; expected version 2 with it")
        hours = [s.needs_version_2 for s in self.stations.values()]
        hours += [not (robot.on_duty and robot.in_service) for robot in (self.robots or {}).values()]
        if self.version == VERSIONS[0] and any(hours):
            raise ValueError(
                "found opening hours, or a busy picker, in a state of version 1; expected version 2 with them"
            )
        if self.version == VERSIONS[0] and any(o.waits_for_stock is not None for o in self.orders.values()):
            raise ValueError("found `waits_for_stock` in a state of version 1; expected version 2 with it")
        if self.version == VERSIONS[0] and any(o.cancelled for o in self.orders.values()):
            raise ValueError("found `cancelled` in a state of version 1; expected version 2 with it")
        stores = any(s.bundle_capacity for s in self.stations.values())
        if self.version == VERSIONS[0] and (stores or self.bundles is not None):
            raise ValueError(
                "found `bundle_capacity` or `bundles` in a state of version 1; expected version 2 with them"
            )
        if self.version == VERSIONS[0] and self.chargers_down:
            raise ValueError("found `chargers_down` in a state of version 1; expected version 2 with it")
        if self.version == VERSIONS[0] and self.packing is not None:
            raise ValueError("found `packing` in a state of version 1; expected version 2 with it")
        if self.version == VERSIONS[0] and self.run is not None:
            raise ValueError("found `run` in a state of version 1; expected version 2 with it")


def state_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of decision states."""
    return schema_of(State, "rmfs decision state")
