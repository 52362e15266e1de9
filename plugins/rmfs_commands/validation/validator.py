"""All checks over one trace."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rmfs_commands.trace.reader import KnownIds, Trace
from rmfs_commands.trace.writer import EVENTS
from rmfs_commands.validation.begun import FOLLOWED, Beginning, opening_of
from rmfs_commands.validation.case import Case, seconds
from rmfs_commands.validation.collisions import find_collisions
from rmfs_commands.validation.fault import OF_FIGURES, OF_FLOOR, Fault
from rmfs_commands.validation.files import check_files
from rmfs_commands.validation.header import check_header, check_readable
from rmfs_commands.validation.lines import LineCheck
from rmfs_commands.validation.metrics import compare
from rmfs_commands.validation.motion import MotionCheck, WayCheck
from rmfs_commands.validation.opening import check_opening, made_alike
from rmfs_commands.validation.orders import DecisionCheck, OrderCheck
from rmfs_commands.validation.outages import OutageCheck
from rmfs_commands.validation.packing import PackingCheck
from rmfs_commands.validation.picking import PickCheck
from rmfs_commands.validation.pods import PodCheck
from rmfs_commands.validation.replenishing import BundleCheck
from rmfs_commands.validation.resting import RestCheck
from rmfs_commands.validation.shifts import ShiftCheck
from rmfs_commands.validation.state import State
from rmfs_commands.validation.stock import StockCheck
from rmfs_core.clock import to_ticks
from rmfs_core.events import Event


def faults_of(
    trace: Trace,
    result: Mapping[str, Any] | None = None,
    *,
    collisions: bool | None = None,
    tables: Path | None = None,
) -> list[Fault]:
    """Return everything that is wrong with a trace, in the order of time.

    Parameters
    ----------
    trace
        The trace.
    result
        Content of result.json; its metrics are compared with those of the trace when given.
    collisions
        Whether no two robots may hold a cell at once, or pass in a queue. None: unless the scenario's PP rule ignores
        other robots.
    tables
        The run's folder; the tables there are compared when given.

    Raises
    ------
    InputError
        When the header lacks what a validation needs.
    """
    check_readable(trace)
    case = Case(trace)
    check_header(case)
    if made_alike(trace, result):
        check_opening(case)
    if trace.floor is not None:
        collisions = False
    state = State(trace)
    begun, rest = opening_of(case)
    if collisions is None:
        collisions = case.avoids_collisions
    packing = PackingCheck(case)
    lines, orders = LineCheck(case, state, collisions=collisions), OrderCheck(case, state, packing)
    pods = PodCheck(case, state)
    picks, bundles, shifts = PickCheck(case, state), BundleCheck(case, state), ShiftCheck(case, state)
    stock, decisions, outages = StockCheck(case, state), DecisionCheck(case, state), OutageCheck(case, state)
    # The way is checked while a robot is still where its run starts, the decision before its parts take up capacity,
    # and which orders wait for stock before what is on order for them.
    checks = (
        WayCheck(case, state),
        MotionCheck(case, state),
        pods,
        stock,
        bundles,
        lines,
        picks,
        decisions,
        shifts,
        orders,
        RestCheck(case, state),
        packing,
        outages,
    )
    handlers: dict[type[Event], list[Callable[[Any], None]]] = {kind: [] for kind in EVENTS.values()}
    for check in checks:
        for kind, handler in check.handlers.items():
            handlers[kind].append(handler)
    if begun is not None:
        past = trace.events[: len(trace.events) - len(rest.events)]
        _begin(case, handlers, past)
        beginning = Beginning(case, state, begun)
        beginning.of_lines(lines)
        beginning.of_pods(pods)
        beginning.of_picks(picks)
        beginning.of_orders(orders, decisions)
        beginning.of_stock(stock)
        beginning.of_bundles(bundles)
        beginning.of_packing(packing)
        beginning.of_outages(outages)
    whole = _follow(case, rest, handlers, picks)
    lines.at_end()
    orders.at_end()
    pods.at_end()
    bundles.at_end()
    stock.at_end()
    shifts.at_end()
    packing.at_end()
    outages.at_end()
    if whole:
        if collisions:
            find_collisions(case, state)
        if result is not None:
            compare(case, result)
        if tables is not None:
            check_files(case, tables)
    return sorted(filter(partial(_counts, trace), case.faults), key=lambda fault: fault.tick)


def _counts(trace: Trace, fault: Fault) -> bool:
    """Whether a fault is one: of a real day only what its floor did not decide, until it corrected what was known."""
    if trace.floor is None or fault.kind in OF_FIGURES:
        return True
    corrected_s = trace.floor["corrected_s"]
    return fault.kind not in OF_FLOOR and (corrected_s is None or fault.tick < to_ticks(corrected_s))


def _begin(case: Case, handlers: Mapping[type[Event], list[Callable[[Any], None]]], past: Sequence[Event]) -> None:
    """Let checks know what a run that begins in a state tells of robots and stations; it is not checked."""
    faults = [*case.faults]
    for event in past:
        for handle in handlers[type(event)] if isinstance(event, FOLLOWED) else ():
            handle(event)
    case.faults[:] = faults


def _follow(
    case: Case, rest: Trace, handlers: Mapping[type[Event], list[Callable[[Any], None]]], picks: PickCheck
) -> bool:
    """Hand each event to its checks; return whether all of them name only what exists."""
    ids = KnownIds(case.trace)
    now, whole = case.trace.began, True
    for event in rest.events:
        unknown = ids.unknown(event)
        if unknown is not None:
            case.add("unknown-id", event.tick, f"{type(event).__name__} names {unknown}, which does not exist")
            whole = False
            continue
        if event.tick < now:
            case.add(
                "time-order",
                event.tick,
                f"{type(event).__name__} at {seconds(event.tick)} stands below an event of {seconds(now)}",
            )
        now = max(now, event.tick)
        picks.until(now)
        for handle in handlers[type(event)]:
            handle(event)
    if case.trace.tick < now:
        case.add("time-order", now, f"the last event is later than the end of the run at {seconds(case.trace.tick)}")
    _check_end(case, now)
    return whole


def _check_end(case: Case, last: int) -> None:
    """A run is over with the last thing that happens in it, or when the scenario's time is up."""
    tick, until = case.trace.tick, case.trace.scenario.get("run", {}).get("until_s")
    ends = f"the run ends at {seconds(tick)}"
    if until is not None and tick > to_ticks(until):
        case.add("end", tick, f"{ends}; run.until_s is {until}")
    elif case.trace.status == "horizon" and (until is None or tick < to_ticks(until)):
        case.add("end", tick, f"{ends} with the status horizon; run.until_s is {until}")
    elif case.trace.status == "complete" and case.trace.instance.orders and tick > last and not case.trace.floor:
        case.add("end", tick, f"{ends}, complete, but nothing has happened since {seconds(last)}")
