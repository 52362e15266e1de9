"""Costs of a run, in all and by order, worked out anew from a trace."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from rmfs_commands.processes.events import OrderPacked, StationDown, StationUp
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.packed import packers_ticks
from rmfs_commands.validation.robots import recompute_robots
from rmfs_commands.validation.tables import (
    HOUR,
    changes_of,
    due_in,
    measured_from,
    packing_hours,
    robots_of,
)
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import (
    BundleStored,
    ItemPicked,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    RobotMoved,
    StationClosed,
    StationOpened,
)
from rmfs_core.scenario import scenario_from_dict
from rmfs_core.scenario.model import BatterySection


def recompute_costs(trace: Trace) -> dict[str, float | None]:
    """Every metric of costs by name."""
    scenario = scenario_from_dict(trace.scenario, name="header of the trace")
    costs, begin = scenario.costs, measured_from(trace)
    kind = OrderCompleted if scenario.packing is None else OrderPacked
    done = {event.order: event.tick for event in trace.events if isinstance(event, kind)}
    end = max(begin, trace.tick)
    hours = (end - begin) / HOUR
    assert costs is not None
    parts = {"pickers": costs.picker_per_h * _pickers(trace, begin, end) / HOUR}
    if scenario.packing is not None:
        open_ticks = scenario.packing.sorters * sum(_open(one, begin, end) for one in packing_hours(trace))
        parts["packers"] = costs.packer_per_h * (packers_ticks(trace, begin, end)[0] + open_ticks) / HOUR
    if trace.layout.replenishing:
        parts["replenishers"] = costs.replenisher_per_h * hours * trace.layout.replenishing
    parts["robots"] = (costs.robot_per_h + costs.robot_per_year / costs.hours_per_year) * hours * len(trace.robots)
    battery = scenario.robots.battery
    wh = recompute_robots(trace, begin, 1)["energy_wh"] if battery is None else _drawn(trace, battery, begin, end)
    parts["energy"] = costs.kwh * (wh or 0) / 1000
    if any(order.due_tick is not None for order in trace.instance.orders):
        late = [ticks for i, due in due_in(trace, done).items() if (ticks := done.get(i, end) - due) > 0]
        parts["lateness"] = costs.late_order * len(late) + costs.late_h * sum(late) / HOUR
    number, total = sum(tick >= begin for tick in done.values()), sum(parts.values())
    each = {f"cost_{part}_per_order": cost / number if number else None for part, cost in parts.items()}
    return {"cost_total": total, "cost_per_order": total / number if number else None, **each}


def _pickers(trace: Trace, begin: int, end: int) -> int:
    """Return the ticks in which picking stations are open, have items to pick, have one in hand or store, summed.

    An outage counts like the time in which it begins.
    """
    picking = len(trace.stations) - trace.layout.replenishing
    changes: list[list[tuple[int, int]]] = [[(0, 1)] for _ in range(picking)]
    outages: list[StationDown | StationUp] = []
    for event in trace.events:
        if getattr(event, "station", picking) >= picking:
            continue
        match event:
            case StationOpened() | OrderAssigned():
                more = event.items if isinstance(event, OrderAssigned) else 1
                changes[event.station].append((event.tick, more))
            case StationClosed():
                changes[event.station].append((event.tick, -1))
            case StationDown() | StationUp():
                outages.append(event)
            case ItemPicked():
                changes[event.station] += [(event.tick, -1), (event.start_tick, 1), (event.picker_free_tick, -1)]
            case BundleStored():
                changes[event.station] += [(event.start_tick, 1), (event.tick, -1)]
    paid = set[int]()
    for event in outages:  # only now, when what was in hand then is known
        of = changes[event.station]
        if isinstance(event, StationDown) and sum(change for tick, change in of if tick < event.tick) > 0:
            paid.add(event.station)
            of.append((event.tick, 1))
        elif event.station in paid and isinstance(event, StationUp):
            paid.remove(event.station)
            of.append((event.tick, -1))
    return sum(_above_zero(sorted(of), begin, end) for of in changes)


def _above_zero(changes: list[tuple[int, int]], begin: int, end: int) -> int:
    """Return the ticks between two times in which a number that changes is above 0."""
    number = found = since = 0
    for tick, change in (*changes, (end, 0)):
        if number > 0:
            found += max(min(tick, end) - max(since, begin), 0)
        number, since = number + change, tick
    return found


def _open(hours: Any, begin: int, end: int) -> int:
    """Return the ticks between two times in which a packing station is open."""
    ticks = [0, *changes_of(hours, end), end]
    return sum(max(b - max(a, begin), 0) for a, b in pairwise(ticks) if hours.at(a))


def _drawn(trace: Trace, battery: BatterySection, begin: int, end: int) -> float:
    """Return what batteries gave, in Wh."""
    empty = loaded = lifts = 0
    for event in trace.events:
        if event.tick >= begin and isinstance(event, RobotMoved):
            ticks = event.turn_ticks + trace.motion.run_ticks(trace.layout.distance(event.origin, event.to))
            empty, loaded = empty + ticks * (event.pod is None), loaded + ticks * (event.pod is not None)
        lifts += event.tick >= begin and isinstance(event, PodLifted)
    lifting = 2 * lifts * trace.motion.lift_ticks
    charging = TICKS_PER_S * sum(float(row["charging_s"] or 0) for row in robots_of(trace))
    standing = max(len(trace.robots) * (end - begin) - charging - empty - loaded - lifting, 0)
    watts = (
        (battery.empty_w, empty),
        (battery.loaded_w, loaded),
        (battery.lifting_w, lifting),
        (battery.idle_w, standing),
    )
    return sum(power * ticks for power, ticks in watts) / HOUR
