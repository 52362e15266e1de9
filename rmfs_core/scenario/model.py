"""The sections of a scenario file as attrs classes. Every key's meaning, unit and range is written here once:
reading, ``rmfs scenario show``, the JSON Schema and the documentation take it from these classes.

The defaults are the paper's parameters (Section 4.1 and Appendix D).
"""

# ruff: noqa: RUF009
# (`key` is attrs' `field` with its documentation: it makes a field, not a default.)

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from attrs import Factory, evolve, field, frozen

from rmfs_core.scenario.checks import (
    ALLOWANCE,
    CAPACITY,
    COST,
    DURATION,
    MAYBE_NO_TIME,
    MOVING,
    POSITIVE,
    POWER,
    SHARE,
    OneOf,
    Spans,
    at_least,
    key,
    within,
)
from rmfs_core.scenario.service import SPEEDS, ServiceTime, Speed
from rmfs_core.scenario.source import Source
from rmfs_core.timetable import Span

MOST_ORDERS, MOST_PODS, MOST_CELLS, MOST_ITEMS, MOST_GIGABYTES = 2_000_000, 100_000, 1_000_000, 1_000_000_000, 8
"""Of what a scenario asks for; the memory of orders, lines and what is on pods is estimated for all together."""
MANY = at_least(1, MOST_PODS)


@frozen
class Arrivals:
    """When orders arrive. The paper has all of them at the start."""

    process: str = key(
        "`start`: every order is there at t = 0. `poisson`: exponential times between arrivals. `day`: times drawn "
        "independently within 24 hours. `refill`: the next order arrives whenever fewer than `backlog` are waiting. "
        "(Orders from a file arrive at the times the file gives; with `refill`, in their order, none is cancelled.)",
        "start",
        check=OneOf("start", "poisson", "day", "refill"),
    )
    orders_per_hour: float | None = key("Mean arrival rate of `poisson`", None, unit="1/h", check=within(0.001, 1e6))
    profile: tuple[float, ...] | str | None = key("Weights of the hours from midnight on, or a CSV hour,weight", None)
    backlog: int | None = key("Orders that `refill` keeps waiting", None, check=at_least(1, MOST_ORDERS))

    def __attrs_post_init__(self) -> None:
        if (self.process == "poisson") != (self.orders_per_hour is not None):
            raise ValueError('expected `orders_per_hour` with process "poisson", and only there')
        if (self.process == "refill") != (self.backlog is not None):
            raise ValueError('expected `backlog` with process "refill", and only there')
        if self.profile is not None and self.process in ("start", "refill"):
            raise ValueError('expected `profile` with process "poisson" or "day", and only there')
        hours = self.profile if isinstance(self.profile, tuple) else (1,) * 24
        if len(hours) != 24 or min(hours) < 0 or max(hours) > 1e9 or not any(hours):
            raise ValueError(f"expected 24 weights from 0 to 1e9 as `profile`, not all 0, found {list(hours)}")


@frozen
class Due:
    """When generated orders are due, counted from their arrival."""

    allowance_s: float = key("Time that an order has", unit="s", check=ALLOWANCE)
    spread_s: float = key("How much that time is shorter or longer at most: uniform", 0.0, unit="s", check=ALLOWANCE)
    priority_share: float = key("Share of orders with priority 1; the others have 0", 0.0, check=within(0, 1))
    priority_allowance_s: float | None = key("Time of those; left out: as the others", None, unit="s", check=ALLOWANCE)


@frozen
class Departures:
    """When trucks leave: an order is due when the first one leaves that it can still go with."""

    times: tuple[str | float, ...] | Mapping[str, tuple[str | float, ...]] = key(
        'Times of every day, `["14:00", "18:30"]`, or seconds from time 0; or a table of routes, `{ N = ["14:00"] }`'
    )
    column: str | None = key("Column of the orders' file with each order's route; nothing in it: never due", None)
    cutoff_s: float = key("How long before a truck leaves its last orders arrive", 0.0, unit="s", check=ALLOWANCE)


@frozen
class SkuDemand:
    """How often generated order lines want each SKU: Zipf's law, shifted as Mandelbrot has it."""

    exponent: float = key("The n-th SKU has the weight 1/(n + shift)^exponent", check=within(0, 2))
    shift: float = key("The larger, the less apart are the first SKUs", 0.0, check=within(0, 1e6))
    groups: int | None = key("Groups of SKUs bought together; left out: none", None, check=at_least(1, MOST_ORDERS))
    together: float = key("Share of lines drawn from the group of a line before it", 0.5, check=within(0, 1))


@frozen
class Replenishment:
    """Where bundles come from: replenishment orders, each of items of one SKU, to be stored on one pod."""

    process: str = key(
        "`none`. `reorder-point`: a SKU of which at most `reorder_point` items are left, on pods and on order, is "
        "ordered up to `order_up_to`. `file`: as `file` says. `poisson`: exponential times between arrivals, SKUs "
        "drawn by how many items the orders want",
        "none",
        check=OneOf("none", "reorder-point", "file", "poisson"),
    )
    reorder_point: float | None = key("s, where the file of SKUs has none", None, check=ALLOWANCE)
    order_up_to: float | None = key("S, where the file of SKUs has none", None, check=ALLOWANCE)
    unit: str = key("s and S are `items`, or `days` of demand, its mean", "items", check=OneOf("items", "days"))
    lead_s: float = key("Time from order to arrival", 0.0, unit="s", check=ALLOWANCE)
    file: str | None = key("CSV with columns bundle,arrival_s,sku,items", None)
    bundles_per_hour: float | None = key("Mean arrival rate of `poisson`", None, unit="1/h", check=within(0.001, 1e6))
    bundle_items: int | None = key("Items of the largest bundle; `poisson`: each", None, check=at_least(1, MOST_ITEMS))

    def __attrs_post_init__(self) -> None:
        poisson = self.process == "poisson"
        if poisson != (self.bundles_per_hour is not None) or (poisson and self.bundle_items is None):
            raise ValueError(
                'expected `bundles_per_hour` and `bundle_items` with process "poisson", the first only there'
            )
        if (self.process == "file") != (self.file is not None):
            raise ValueError('expected `file` with process "file", and only there')
        if self.reorder_point is not None and self.order_up_to is not None and self.order_up_to <= self.reorder_point:
            raise ValueError(
                f"expected order_up_to > reorder_point, found {self.order_up_to:g} <= {self.reorder_point:g}"
            )


@frozen
class Scale:
    """A day drawn from the orders of a file, another by each seed: whole orders, at about their times of the day."""

    by: float = key("How often each order comes, in the mean", 1.0, check=within(0.001, 1000))
    peaks: tuple[str, ...] = key('More often at some time of the day, or less: `["17:00-20:00=2"]` is twice', ())


@frozen
class InstanceSection:
    """Orders, SKUs and pods: a generator, by default the paper's (Section 4.1.1), or CSV files."""

    generator: str | None = key("The generator, an entry point of the group `rmfs.instances`; left out: `paper`", None)
    parameters: Mapping[str, Any] = key("What `generator` is handed by name, besides this section", factory=dict)
    orders: int = key("Number of orders |O| to generate", 250, check=at_least(0, MOST_ORDERS))
    skus: int = key("Number of SKUs |I|", 100, check=at_least(1, MOST_ORDERS))
    pods: int = key("Number of pods with contents |P|", 100, check=MANY)
    skus_per_pod: int = key("SKUs per pod, alpha", 3, check=MANY)
    max_lines: int = key(
        "Longest order to generate: order lengths are geometric, truncated to 1..min(|I|, max_lines)",
        15,
        check=at_least(1, MOST_ORDERS),
    )
    lines: tuple[float, ...] | None = key("Weights of orders of 1, 2, ... lines, instead of the geometric ones", None)
    demand: SkuDemand | None = key("Demand of SKUs, instead of the geometric one", None)
    due: Due | None = key("When generated orders are due; left out: whenever", None)
    departures: Departures | None = key("When trucks leave, which is when orders are due; left out: no truck", None)
    start: str | None = key("Time 0 in ISO 8601; left out: midnight, before the first date of the orders' file", None)
    items_per_sku: int | None = key(
        "Items of each SKU on a pod; left out: unlimited, the paper's assumption", None, check=at_least(1, MOST_ITEMS)
    )
    orders_file: str | None = key("CSV with columns order,arrival_s,sku,quantity[,due_s,priority,cancelled_s]", None)
    scale: Scale | None = key("Draw a day from the orders of the file; left out: the orders are as they stand", None)
    pods_file: str | None = key("CSV with columns pod,sku,quantity (empty: unlimited)[,row,column] for pods", None)
    arrivals: Arrivals = key("When generated orders arrive", factory=Arrivals)
    pod_capacity: int | None = key(
        "Space on a pod, in the unit of SKU sizes; left out: any amount", None, check=at_least(1, MOST_ITEMS)
    )
    skus_file: str | None = key("CSV with columns sku[,size][,reorder_point][,order_up_to]; sizes left out: 1", None)
    replenishment: Replenishment | None = key("Where bundles come from; left out: there are none", None)
    state_file: str | None = key(
        "State that the run begins in, a JSON file: time, orders, pods, robots. Orders that arrive later are those of "
        "this section; left out: time 0",
        None,
    )
    pods_at_stations: Mapping[str, tuple[str, ...]] = key(
        "Pods that stand at a station when the run starts: station name to pod names, in the order of the queue",
        factory=dict,
    )

    def __attrs_post_init__(self) -> None:
        if (self.orders_file is None) != (self.pods_file is None):
            raise ValueError("expected `orders_file` and `pods_file` together, or neither")
        if self.scale is not None and self.orders_file is None:
            raise ValueError("expected `orders_file` with `scale`, which draws from its orders")
        if self.due is not None and self.arrivals.backlog is not None:
            raise ValueError('expected no `due` with arrivals of process "refill", whose times nobody knows beforehand')
        valid = self.lines is None or (any(self.lines[: self.skus]) and min(self.lines) >= 0 and max(self.lines) <= 1e9)
        if not valid:
            raise ValueError(f"expected `lines` with weights from 0 to 1e9, not all 0 up to {self.skus} lines (`skus`)")
        if self.orders_file is None and self.skus_per_pod > self.skus:
            raise ValueError(f"expected skus_per_pod <= skus, found {self.skus_per_pod} > {self.skus}")
        if (hours := self.orders / (self.arrivals.orders_per_hour or 1e9)) > 1e6:  # each is a row of hours.csv
            raise ValueError(f"expected orders that arrive within 1,000,000 hours, found about {hours:,.0f}")
        weights = self.lines[: self.skus] if self.lines else (0, 1, 1)  # the geometric orders have 2.5 lines on average
        lines = self.orders * sum(n * weight for n, weight in enumerate(weights, 1)) / sum(weights)
        gigabytes = (2500 * self.orders + 300 * lines + 250 * self.pods * self.skus_per_pod) / 1e9
        if self.orders_file is None and gigabytes > MOST_GIGABYTES:
            found = f"about {gigabytes:,.0f} GB of orders, lines and pods"
            raise ValueError(f"expected at most {MOST_GIGABYTES} GB of memory, found {found}")


@frozen
class LayoutSection:
    """The grid: RAWSim-O's block layout, a text map, or what another generator makes."""

    block_rows: int = key("Rows of blocks of storage locations", 9, check=MANY)
    block_columns: int = key("Columns of blocks", 7, check=MANY)
    block_length: int = key("Storage locations along a block; a block is 2 deep", 4, unit="cells", check=MANY)
    hall_width: int = key("Width of the hall on the east and west side", 5, unit="cells", check=MANY)
    stations_east: int = key("Picking stations on the east side", 4, check=at_least(0, MOST_PODS))
    stations_west: int = key("Picking stations on the west side", 0, check=at_least(0, MOST_PODS))
    replenishment_east: int | None = key("Replenishment stations on the east side", None, check=at_least(0, MOST_PODS))
    replenishment_west: int | None = key("Replenishment stations on the west side", None, check=at_least(0, MOST_PODS))
    queue: str = key(
        "Way through a station's queue: `plain` (all its cells, one after the other), or `shortcut` (as in RAWSim-O: a "
        "shortcut past its two last folds, and a second entrance at its third lane)",
        "shortcut",
        check=OneOf("plain", "shortcut"),
    )
    map_file: str | None = key("Text map to use instead of the block layout, or the file of another generator", None)
    generator: str | None = key(
        "The generator, an entry point of the group `rmfs.layouts`; left out: `text-map` with a map, else `blocks`",
        None,
    )
    parameters: Mapping[str, Any] = key("What `generator` is handed by name, besides this section", factory=dict)
    chargers: int | None = key(
        "Storage locations of the block layout that are chargers instead, spread evenly; left out: none",
        None,
        check=MANY,
    )
    maintenance_cells: int | None = key("Storage locations, the last ones, where robots are repaired", None, check=MANY)
    pod_fill: float = key("Share of the storage locations that hold a pod, with contents or empty", 0.85, check=SHARE)

    def __attrs_post_init__(self) -> None:
        cells = (self.block_rows * 3 + 2) * (self.block_columns * (self.block_length + 1) + 2 * self.hall_width)
        if self.map_file is None and cells > MOST_CELLS:
            raise ValueError(f"expected at most {MOST_CELLS:,} cells in all, found blocks and halls of about {cells:,}")


@frozen
class FailuresSection:
    """Failures and repairs: exponential times, drawn for each thing that fails by the seed and their number."""

    no_where = "; what fails ends its task first: robots that stop on their way are not simulated"
    mtbf_h: float = key("Mean time in service until a failure", unit="h", check=within(0.001, 1e6))
    mttr_s: float = key("Mean time from there until it is repaired", unit="s", check=within(0.001, 1e7))


@frozen
class BatterySection:
    """The robots' batteries, which are full at first. Chargers charge the robot that stands there."""

    capacity_wh: float = key("Energy of a full battery", 1000.0, unit="Wh", check=POWER)
    empty_w: float = key("Draw of driving and turning without a pod", 100.0, unit="W", check=POWER)
    loaded_w: float = key("Draw of driving and turning with a pod", 300.0, unit="W", check=POWER)
    lifting_w: float = key("Draw of lifting a pod, and of setting it down", 500.0, unit="W", check=POWER)
    idle_w: float = key(
        "Draw of standing, until there is left what the longest task takes: then the robot sleeps while it stands",
        20.0,
        unit="W",
        check=within(0, 1e6),
    )
    charging_w: float = key("Power of a charger", 2000.0, unit="W", check=POWER)
    detour: float = key(
        "How many times as much as without other robots a robot's ways may take: it takes no task without so much",
        2.0,
        check=within(1, 100),
    )
    charger_outages: FailuresSection | None = key("How often chargers fail: who charges goes on, or waits", None)


@frozen
class RobotsSection:
    """The robots and how they move."""

    count: int = key("Number of robots", 8, check=MANY)
    file: str | None = key("CSV with columns robot,row,column: where robots 1, 2, ... stand at t = 0", None)
    acceleration_m_per_s2: float = key("Acceleration and deceleration", 1.0, unit="m/s^2", check=MOVING)
    top_speed_m_per_s: float = key("Top speed", 1.5, unit="m/s", check=MOVING)
    full_turn_s: float = key("Time of a full turn on the spot", 2.5, unit="s", check=DURATION)
    lift_s: float | ServiceTime = key("Time to lift a pod, and to set it down", 2.2, unit="s", check=MAYBE_NO_TIME)
    available: tuple[Span, ...] | None = key(
        'When robots take tasks, every day: `[["06:00", "22:00"], ["22:00", "06:00", 4]]`, by night robots 1 to 4; '
        "where spans overlap, the larger number counts, `count` at most. Left out: always",
        None,
        check=Spans(MOST_PODS),
    )
    battery: BatterySection | None = key("Batteries; left out: they never run down", None)
    failures: FailuresSection | None = key(
        "How often robots fail: after their task, in a free maintenance cell or where they stand", None
    )
    maintenance: Mapping[str, tuple[Span, ...]] | None = key(
        'When robots are maintained, every day, by robot: `{ 3 = [["02:00", "04:00"]] }`. One finishes its task first',
        None,
        check=Spans(),
    )


@frozen
class StationsSection:
    """The picking stations."""

    item_capacity: int | tuple[int, ...] = key(
        "Items assigned to a station at a time; a list gives each station its own", 15, unit="items", check=CAPACITY
    )
    order_capacity: int | tuple[int, ...] | None = key(
        "Orders assigned to a station at a time; when set, it counts instead of `item_capacity`",
        None,
        unit="orders",
        check=CAPACITY,
    )
    oversize: str = key(
        "An order of more items than any station takes at a time: `alone` (an empty station takes it, and nothing else "
        "until it is picked), or `refuse` (the run does not begin). Rules that split orders assign it part by part",
        "alone",
        check=OneOf("alone", "refuse"),
    )
    queue_length: int | None = key(
        "Pods that can wait at a station, besides the one it works on; left out: 12, or on a text map as many as the "
        "shortest queue has cells, if that is fewer",
        None,
        unit="cells",
        check=at_least(1, 10_000),
    )
    pick_s: float | ServiceTime = key(
        "Time of picking a unit: holds the picker, the pod and its robot", 7.0, unit="s", check=DURATION
    )
    handle_s: float | ServiceTime = key(
        "Time of handling a unit, picking included: holds the picker; the pod may leave after `pick_s`",
        13.0,
        unit="s",
        check=DURATION,
    )
    line_s: float | ServiceTime | None = key(
        "Time of beginning a line in a visit, before its first item: holds the same as `pick_s`; left out: none",
        None,
        unit="s",
        check=MAYBE_NO_TIME,
    )
    order_s: float | ServiceTime | None = key(
        "Time of beginning an order at a station, before its first item there: as `line_s`; left out: none",
        None,
        unit="s",
        check=MAYBE_NO_TIME,
    )
    speed: Mapping[str, Speed] = key(
        "How fast a station's picker is, by station name: all times there are divided by it; left out: 1. Or that of "
        'each shift, every day: `{ 2 = [["06:00", "14:00", 1.1], ["14:00", "22:00", 0.9]] }`; outside of them 1',
        factory=dict,
        check=SPEEDS,
    )
    outages: FailuresSection | None = key(
        "How often picking stations fail: the item in hand is handled, the rest waits, no orders are taken until then",
        None,
    )
    release: str = key(
        "An order is complete, and its capacity free, when its last item is `picked` or, as in RAWSim-O, `handled`",
        "handled",
        check=OneOf("picked", "handled"),
    )
    open: tuple[Span, ...] | Mapping[str, tuple[Span, ...]] | None = key(
        'When stations take orders, every day: `[["06:00", "22:00"]]`, or a table of station names, `{ 2 = [["06:00", '
        '"14:00"]] }`; those it does not name, and all where it is left out, always do. Time 0 is `instance.start`',
        None,
        check=Spans(),
    )

    also_replenish: bool | None = key("Whether bundles are stored at picking stations, too; left out: no", None)
    bundle_capacity: int | None = key(
        "Bundles assigned to a replenishment station at a time; left out: 10", None, check=at_least(1, 10_000)
    )
    store_s: float | ServiceTime | None = key(
        "Time of storing a bundle: holds the worker, the pod and its robot; left out: 10",
        None,
        unit="s",
        check=DURATION,
    )

    def __attrs_post_init__(self) -> None:
        if self.handle_s < self.pick_s:
            raise ValueError(f"expected handle_s >= pick_s, found {self.handle_s} < {self.pick_s}")


@frozen
class PackingSection:
    """Packing stations, where split orders come together in boxes. Times of conveyors and of putting are assumed."""

    stations: int | None = key("Their number; left out: one for each `P` of the map, or else 1", None, check=MANY)
    boxes: int = key("Boxes of each: split orders that it holds", 78, check=MANY)
    packers: int = key("Packers at each", 4, check=MANY)
    sorters: int = key("Those at each who put parts into boxes; 0: packers do", 0, check=at_least(0, MOST_PODS))
    conveyor_s: float | None = key("Time from any picking station; left out: 60", None, unit="s", check=MAYBE_NO_TIME)
    conveyor_speed_m_per_s: float | None = key(
        "Instead of it, the speed along rows and columns of a map with packing stations (`P`)",
        None,
        unit="m/s",
        check=MOVING,
    )
    tote: str = key(
        "What goes into one tote: a `part`, all that a picking station picks of an order until its capacity there is "
        "free, or, of split orders, what it picks in one `visit` of a pod",
        "part",
        check=OneOf("part", "visit"),
    )
    tote_s: float | ServiceTime = key("Time of boxing a part, items aside", 3.0, unit="s", check=MAYBE_NO_TIME)
    put_s: float | ServiceTime = key("Time for each of its items", 4.0, unit="s", check=MAYBE_NO_TIME)
    pack_s: float | ServiceTime = key("Time of packing an order, items aside", 30.0, unit="s", check=MAYBE_NO_TIME)
    pack_item_s: float | ServiceTime = key("Time for each of its items", 5.0, unit="s", check=MAYBE_NO_TIME)
    packing_from: str = key(
        "An order has its box until it is `packed`, or, as the paper counts, `picked`",
        "packed",
        check=OneOf("packed", "picked"),
    )
    open: tuple[Span, ...] | Mapping[str, tuple[Span, ...]] | None = key(
        "When packers begin tasks, every day, as `stations.open`; left out: always", None, check=Spans()
    )

    def __attrs_post_init__(self) -> None:
        if self.conveyor_s is not None and self.conveyor_speed_m_per_s is not None:
            raise ValueError("expected `conveyor_s` or `conveyor_speed_m_per_s`, found both")


@frozen
class Costs:
    """Costs, in any currency. People are paid while their stations are open, or finish what they have."""

    picker_per_h: float = key("A picker, one at each picking station", 0.0, unit="1/h", check=COST)
    packer_per_h: float = key("A packer or sorter", 0.0, unit="1/h", check=COST)
    replenisher_per_h: float = key("A worker, one at each replenishment station", 0.0, unit="1/h", check=COST)
    robot_per_h: float = key("A robot, whether or not it is on duty", 0.0, unit="1/h", check=COST)
    robot_per_year: float = key("A robot, besides or instead, by the year", 0.0, unit="1/year", check=COST)
    hours_per_year: float = key("Hours that share what a year costs", 8760.0, unit="h", check=within(1, 8784))
    kwh: float = key("Electricity", 0.0, unit="1/kWh", check=COST)
    late_order: float = key("An order that is late", 0.0, check=COST)
    late_h: float = key("An hour by which an order is late", 0.0, unit="1/h", check=COST)


@frozen
class RuleChoice:
    """A rule by its entry-point name, or ``./file.py:Class`` in the scenario's folder, and its parameters."""

    rule: str
    parameters: Mapping[str, Any] = Factory(dict)


@frozen
class RulesSection:
    """Which rule decides what. Give `poa` and `pps`, or `poa_pps`; with replenishment `roa` and `rps`, or `roa_rps`."""

    poa: RuleChoice | None = key("Pick order assignment: orders to stations", None)
    pps: RuleChoice | None = key("Pick pod selection: pods to stations", None)
    poa_pps: RuleChoice | None = key("A joint rule for both, instead of `poa` and `pps`", None)
    pr: RuleChoice = key("Pod repositioning: where a pod goes back to", RuleChoice("nearest"))
    ta: RuleChoice = key("Task allocation: tasks to robots", RuleChoice("balanced"))
    pp: RuleChoice = key("Path planning", RuleChoice("sipp"))
    roa: RuleChoice | None = key("Replenishment order assignment: bundles to replenishment stations", None)
    rps: RuleChoice | None = key("Replenishment pod selection: bundles to pods", None)
    roa_rps: RuleChoice | None = key("A joint rule for both, instead of `roa` and `rps`", None)
    activate: RuleChoice | None = key("Activation: which stations take orders; left out: all that are open", None)
    idle: RuleChoice | None = key("Robots without a task: where they rest and charge; left out: where they are", None)
    move: RuleChoice | None = key("Active repositioning: idle robots carry stored pods elsewhere; left out: none", None)
    packing: RuleChoice | None = key(
        'Which packing station an order is bound for; left out, with packing stations: "least-reserved"', None
    )
    packing_task: RuleChoice | None = key('What a packer does next; left out, with packing: "first-come"', None)
    wait_for_stock: bool | None = key(
        "Whether an order that the pods hold too little for stays out of the backlog until bundles are stored; left "
        "out: yes",
        None,
    )
    filters: tuple[RuleChoice, ...] = key("Backlog prefilters, applied in this order", ())
    observers: tuple[RuleChoice, ...] = key("Observers to register, besides those of every run", ())

    def __attrs_post_init__(self) -> None:
        if self.poa_pps is not None and (self.poa is not None or self.pps is not None):
            raise ValueError("expected either `poa_pps` or `poa` and `pps`, found both")
        if self.poa_pps is None and (self.poa is None or self.pps is None):
            alone = f", found `{'pps' if self.poa is None else 'poa'}` alone" if self.poa or self.pps else ""
            raise ValueError(f"expected `poa` and `pps`, or `poa_pps`{alone}")
        if (self.roa is None) != (self.rps is None) or (self.roa_rps and (self.roa or self.rps)):
            found = ", ".join(f"`{name}`" for name in ("roa", "rps", "roa_rps") if getattr(self, name))
            raise ValueError(f"expected `roa` and `rps`, or `roa_rps`, found {found}")
        if (most := max(len(self.filters), len(self.observers))) > 50:
            raise ValueError(f"expected at most 50 `filters` and as many `observers`, found {most:,}")


@frozen
class RunSection:
    """When to stop, and limits."""

    until_s: float | None = key("Time at which the run ends even if orders are left", None, unit="s", check=POSITIVE)
    warmup_s: float | None = key("Simulated time from which on metrics count", None, unit="s", check=POSITIVE)
    standstill_s: float = key(
        "Simulated time in which a robot on its way may come no nearer to its goal; after that the run ends with an "
        "error. At least ten times what driving across the layout takes",
        3600.0,
        unit="s",
        check=POSITIVE,
    )
    decision_limit_s: float | None = key(
        "Wall-clock limit of a single decision; a rule that takes longer is ended, and the run with an error. Compiled "
        "code is ended when it returns to Python; on Windows every rule. Off when left out",
        None,
        unit="s",
        check=POSITIVE,
    )


GENERATED = frozenset(
    ("generator", "parameters", "orders", "skus", "pods", "skus_per_pod", "max_lines", "items_per_sku", "arrivals")
) | {"lines", "demand", "due"}
DRAWN = frozenset(
    ("block_rows", "block_columns", "block_length", "hall_width", "stations_east", "stations_west", "queue")
) | {"replenishment_east", "replenishment_west", "chargers", "maintenance_cells"}


def replaced_keys(section: object) -> tuple[str, frozenset[str]]:
    """Return the key of a section that names a file, and the keys that have no meaning with it."""
    if isinstance(section, InstanceSection) and section.orders_file is not None:
        return "orders_file", GENERATED - ({"arrivals"} if section.arrivals.backlog is not None else set())
    if isinstance(section, LayoutSection) and section.map_file is not None:
        return "map_file", DRAWN
    return "", frozenset()


PACKING_RULES = {"packing": RuleChoice("least-reserved"), "packing_task": RuleChoice("first-come")}


@frozen
class Scenario:
    """A whole run: what is there, which rules decide, and the seed of every random stream.

    Not keys of the file: ``folder`` is where relative file names are looked up, ``source`` what messages take the line
    of a wrong value from.
    """

    rules: RulesSection = key("Decision rules")
    seed: int = key("Seed of every random stream", 1, check=at_least(0))
    instance: InstanceSection = key("Orders, SKUs, pods", factory=InstanceSection)
    layout: LayoutSection = key("The grid", factory=LayoutSection)
    robots: RobotsSection = key("Robots", factory=RobotsSection)
    stations: StationsSection = key("Picking stations", factory=StationsSection)
    packing: PackingSection | None = key("Packing stations; left out: there are none", None)
    costs: Costs | None = key("What things cost; left out: nothing is said of it", None)
    run: RunSection = key("Stopping and limits", factory=RunSection)
    folder: str = field(default=".", eq=False, metadata={"internal": True})
    source: Source | None = field(default=None, eq=False, repr=False, metadata={"internal": True})

    def __attrs_post_init__(self) -> None:
        given, rules = self.instance.replenishment, self.rules
        if given is not None and given.process != "none" and rules.roa is None and rules.roa_rps is None:
            problem = "expected `rules.roa` and `rules.rps`, or `rules.roa_rps`, with the replenishment process"
            raise ValueError(f'{problem} "{given.process}"')
        chosen: dict[str, Any] = {key: getattr(rules, key) or usual for key, usual in PACKING_RULES.items()}
        if self.packing is None and (other := [one.rule for key, one in chosen.items() if one != PACKING_RULES[key]]):
            raise ValueError(f'expected a section `packing` with the rule "{other[0]}" of packing stations')
        # What decides at packing stations unless the scenario says so
        object.__setattr__(self, "rules", evolve(rules, **(dict.fromkeys(chosen) if self.packing is None else chosen)))

    def with_seed(self, seed: int) -> Scenario:
        """Return the same scenario with another seed."""
        return evolve(self, seed=seed)
