"""Notes of a run that ends with orders that are not complete."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rmfs_commands.processes.hours import first_common, shifts_of
from rmfs_core.clock import to_seconds
from rmfs_core.rules import RuleSet
from rmfs_core.timetable import Timetable
from rmfs_core.warehouse import Warehouse
from rmfs_core.wording import counted, first_few


def notes(warehouse: Warehouse, hours: Mapping[int | None, Timetable], skus: Sequence[str]) -> Iterator[str]:
    """Yield a sentence for each surprise: no order is complete, or orders wait for stock.

    Parameters
    ----------
    warehouse
        The warehouse at the end.
    hours
        Timetables of stations and robots, as `rmfs_commands.processes.hours.hours_of` returns them.
    skus
        Names of the SKUs.
    """
    if warehouse.orders and not any(order.complete for order in warehouse.arrived.values()):
        yield f"No order is complete at {to_seconds(warehouse.now):.3f} s: {_why_nothing(warehouse, hours)}."
    if lacking := _lacking(warehouse, skus):
        yield f"At the end {lacking}."


def _why_nothing(warehouse: Warehouse, hours: Mapping[int | None, Timetable]) -> str:
    arrived = warehouse.arrived.values()
    if not arrived:
        return f"the first one arrives at {min(order.arrival_s for order in warehouse.orders):.3f} s"
    stations, robots = shifts_of(hours, len(warehouse.picking))
    for what, groups in (
        ("no station is open", [stations]),
        ("no robot is on duty", [robots]),
        ("no robot is on duty while a station is open", [stations, robots]),
    ):
        first = first_common(*groups)
        if first is None or first >= warehouse.now:
            return f"{what} {'at any time' if first is None else f'before {to_seconds(first):.3f} s'}"
    picked = sum(order.items - order.unpicked_items for order in arrived)
    of = f"{len(arrived):,} of {counted(len(warehouse.orders), 'order')}"
    return f"{of} arrived, with {counted(picked, 'item')} picked"


def standstill(warehouse: Warehouse, rules: RuleSet, skus: Sequence[str]) -> str:
    """Return the message of a run in which nothing will ever happen again: what is left, and who was asked."""
    first, then = (rules.activate, *rules.filters), (rules.poa_pps, rules.poa, rules.pps, *rules.deciding_bundles)
    deciding = (*first, *then, rules.ta, rules.move, rules.idle)
    asked = ", ".join(rule.describe() for rule in deciding if rule is not None)
    left = sum(not order.complete for order in warehouse.orders)
    closed = sum(not station.open for station in warehouse.stations)
    uncovered = sum(station.uncovered_items for station in warehouse.stations)
    unpacked = sum(order.complete for station in warehouse.packing for order in station.orders)
    low = sum(robot.low for robot in warehouse.robots)
    off = sum(not robot.on_duty for robot in warehouse.robots)
    down = sum(not robot.in_service for robot in warehouse.robots)
    details = (
        f"{len(warehouse.backlog):,} in the backlog",
        _lacking(warehouse, skus),
        f"{counted(unpacked, 'order')} at packing stations" if unpacked else "",
        f"{counted(closed, 'station')} closed" if closed else "",
        f"{counted(uncovered, 'open request')} that no inbound pod can serve",
        f"{counted(len(warehouse.waiting), 'pod')} waiting for a robot",
        f"{counted(off, 'robot')} off duty" if off else "",
        f"{counted(down, 'robot')} out of service" if down else "",
        f"{counted(low, 'robot')} with too little charge for a task" if low else "",
    )
    return (
        f"The run stands still at {to_seconds(warehouse.now):.3f} s: "
        f"{counted(left, 'order')} {'is' if left == 1 else 'are'} not complete ({'; '.join(filter(None, details))}), "
        f"and no rule decides anything (asked last: {asked}){_too_large(warehouse)}{_without_room(warehouse)}."
    )


def _lacking(warehouse: Warehouse, skus: Sequence[str]) -> str:
    """Say how many orders wait for stock, and of which SKUs; nothing if none does."""
    if warehouse.claims is None or not (number := len(warehouse.claims.waiting)):
        return ""
    missing = [skus[sku] for sku in warehouse.claims.missing]
    what = f"SKU{'s' if len(missing) > 1 else ''} {first_few(missing)}"
    return f"{counted(number, 'order')} {'waits' if number == 1 else 'wait'} for stock of {what}"


def _too_large(warehouse: Warehouse) -> str:
    largest = max([s.capacity for s in warehouse.stations if not s.counts_orders], default=0)
    large = sum(order.open_items > largest > 0 for order in warehouse.backlog.orders)
    if not large:
        return ""
    have = "has" if large == 1 else "have"
    fit = "fits" if large == 1 else "fit"
    return (
        f"; {large:,} in the backlog {have} more than {counted(largest, 'item')} and {fit} an empty station alone, "
        "as `fits` says"
    )


def _without_room(warehouse: Warehouse) -> str:
    """Say which bundles cannot be stored."""
    at_stations = [bundle for station in warehouse.storing for bundle in station.bundles]
    room = max((pod.free_space for pod in warehouse.pods), default=0)
    waiting = [b.name for b in (*warehouse.bundles.values(), *at_stations) if b.pod is None and b.size > room]
    return f"; bundles that fit on no pod: {first_few(waiting)}" if waiting else ""
