"""Orders: arrival, assignment within capacity, completion; and the decisions that assign them."""

from __future__ import annotations

import math

from rmfs_commands.validation.case import Case, Handlers, name_of, seconds
from rmfs_commands.validation.packing import PackingCheck
from rmfs_commands.validation.state import OrderState, State
from rmfs_commands.validation.tables import refilled
from rmfs_core import entrypoints
from rmfs_core.events import (
    BundleArrived,
    BundleAssigned,
    BundleBound,
    DecisionMade,
    OrderArrived,
    OrderAssigned,
    OrderCancelled,
    OrderCompleted,
    OrderInStock,
    TripDecided,
)
from rmfs_core.roles import Role
from rmfs_core.wording import counted, listed, shown_short

TOLERANCE = 1e-6
"""Of solvers, as a share of the objective."""

BUNDLE_DECISIONS = (Role.ROA, Role.RPS, Role.ROA_RPS)
DECISIONS = (Role.POA, Role.PPS, Role.POA_PPS, *BUNDLE_DECISIONS)
REPORTING = (Role.POA_PPS, Role.ROA_RPS)
UNREPORTED = "decided"
LEFT = ("horizon", "partial")
"""How a run ends with orders left, except for errors."""
STATUSES = {"optimal": False, "effort": True, "stopped": True, "heuristic": False}
"""Statuses of rmfs's own rules, and whether a limit has ended the solve then."""


class OrderCheck:
    """Each order arrives, is assigned line by line, and is complete exactly with its last item."""

    def __init__(self, case: Case, state: State, packing: PackingCheck) -> None:
        self.case = case
        self.state = state
        self.packing = packing
        self.refilled = refilled(case.trace)
        self.done = "handled" if case.keeps_places else "picked"
        self.come = self.waiting = self.closed = 0  # orders so far, those in the backlog, and those closed since then
        self.handlers: Handlers = {
            OrderArrived: self.arrived,
            OrderAssigned: self.assigned,
            DecisionMade: self.decided,
            OrderCompleted: self.completed,
            OrderCancelled: self.cancelled,
        }

    def arrived(self, event: OrderArrived) -> None:
        """Check that an order arrives when it should."""
        order, due = self.state.orders[event.order], self.case.trace.instance.orders[event.order].arrival_tick
        if self.refilled is not None:
            self._refill(event)
        elif order.arrived or event.tick != due:
            again = " again" if order.arrived else ""
            self.case.add(
                "arrival",
                event.tick,
                f"{self.case.order(event.order)} arrives{again}; expected once, at {seconds(due)}",
            )
        order.arrived = True

    def cancelled(self, event: OrderCancelled) -> None:
        """Check that an order leaves when it should, with nothing of it assigned."""
        order, due = self.state.orders[event.order], self._cancelled_tick(event.order)
        why = f"expected that at {seconds(due)}" if due is not None else "expected that never"
        if order.cancelled:
            why = "and was before"
        elif order.begun_tick is not None or not order.arrived:
            why = "but is begun" if order.arrived else "but has not arrived"
        if order.cancelled or order.begun_tick is not None or not order.arrived or event.tick != due:
            self.case.add("cancelled", event.tick, f"{self.case.order(event.order)} is cancelled, {why}")
        order.cancelled = True

    def _cancelled_tick(self, order: int) -> int | None:
        return None if self.refilled is not None else self.case.trace.instance.orders[order].cancelled_tick

    def _refill(self, event: OrderArrived) -> None:
        """Check that an order is the next one, and that a backlog which is kept filled takes it."""
        name = f"{self.case.order(event.order)} arrives"
        if event.order != self.come:
            self.case.add("arrival", event.tick, f"{name} as number {self.come + 1}; expected the orders as they stand")
        elif self.waiting >= (self.refilled or 0):
            self.case.add("arrival", event.tick, f"{name}, but {self.waiting} are in the backlog; that is enough")
        self.come += 1
        self.waiting += 1

    def decided(self, event: DecisionMade) -> None:
        """Check that a backlog that is kept filled was filled when a rule was asked."""
        there = 0 if self.case.trace.floor is not None else self.refilled or 0  # nobody knows when a floor is told
        wanted = min(there, len(self.state.orders) - self.come + self.waiting + self.closed)
        if self.refilled is not None and self.waiting + self.closed < wanted:
            found = f"{counted(self.waiting + self.closed, 'order')} in the backlog"
            what = f"{found} when {event.decides.label} is decided; expected {wanted}"
            self.case.add("arrival", event.tick, what)
        self.closed = 0

    def assigned(self, event: OrderAssigned) -> None:
        """Check the lines that are assigned, and note their part."""
        case, order = self.case, self.state.orders[event.order]
        assigns = f"{case.order(event.order)} is assigned to {case.station(event.station)}"
        if not order.arrived:
            case.add("assigned-before-arrival", event.tick, f"{assigns}, but has not arrived")
        if order.cancelled:
            case.add("cancelled", event.tick, f"{assigns}, but was cancelled")
            order.cancelled = False
        elif order.begun_tick is None:
            order.begun_tick = event.tick
        for sku in event.skus:
            if sku not in order.unassigned:
                why = "has been assigned before" if sku in order.unpicked else "is no line of it"
                case.add("line-assigned", event.tick, f"{assigns} with {case.sku(sku)}, which {why}")
        lines = {sku: order.unassigned.pop(sku) for sku in event.skus if sku in order.unassigned}
        closes = bool(lines) and not order.unassigned
        self.waiting -= closes
        self.closed += closes
        items = sum(lines.values())
        if event.items != items:
            case.add("items", event.tick, f"{assigns} with {counted(items, 'item')}, but {event.items} are reported")
        if event.complete == bool(order.unassigned):
            left = f"{len(order.unassigned)} of its lines are left"
            case.add("complete-flag", event.tick, f"{assigns} with `complete` {str(event.complete).lower()}; {left}")
        if lines:
            self._add_part(event, order, lines)

    def _add_part(self, event: OrderAssigned, order: OrderState, lines: dict[int, int]) -> None:
        """Take up capacity; what one period assigns of an order to a station is one part."""
        case, station = self.case, self.state.stations[event.station]
        header = case.trace.stations[event.station]
        part = (event.station, event.period)
        old, items = order.size[part], sum(lines.values())
        order.part_of |= dict.fromkeys(lines, part)
        order.left[part] += items
        if header["counts_orders"]:  # a later part joins the earlier one, as long as that is there
            order.size[part] = int(not any(at == event.station and size for (at, _), size in order.size.items()) or old)
        else:
            order.size[part] = old + items
        station.open.update(lines)
        station.load += order.size[part] - old
        if station.load > header["capacity"] and not self._alone(order, items, station.load):
            unit = "orders" if header["counts_orders"] else "items"
            case.add(
                "capacity-exceeded",
                event.tick,
                f"{case.order(event.order)} is assigned to {case.station(event.station)}, "
                f"which has {station.load} {unit} then; its capacity is {header['capacity']}",
            )

    def _alone(self, order: OrderState, items: int, load: int) -> bool:
        """Whether all that was left of an order, more than any station takes, went to a station that was empty."""
        sizes = [math.inf if station["counts_orders"] else station["capacity"] for station in self.case.trace.stations]
        refused = self.case.trace.scenario["stations"].get("oversize") == "refuse"
        return not refused and not order.unassigned and load == items > max(sizes)

    def completed(self, event: OrderCompleted) -> None:
        """Check that nothing is left of an order, and that its last item was picked (or handled) just now."""
        order, name = self.state.orders[event.order], self.case.order(event.order)
        left = sum(order.unpicked.values()) + order.in_hand
        if order.completed:
            self.case.add("completed-twice", event.tick, f"{name} is complete again")
        elif left:
            self.case.add(
                "completed-early", event.tick, f"{name} is complete, but {left} of its items are not {self.done}"
            )
        elif event.tick != order.last_tick:
            self.case.add(
                "completed-late",
                event.tick,
                f"{name} is complete, but its last item was {self.done} at {seconds(order.last_tick)}",
            )
        order.completed = True

    def at_end(self) -> None:
        """Check that a complete run left nothing, and that what was picked was told to be complete."""
        tick, status = self.case.trace.tick, self.case.trace.status
        for i, order in enumerate(self.state.orders):
            left, due = sum(order.unpicked.values()) + order.in_hand, self._cancelled_tick(i)
            stays = not order.cancelled and (order.begun_tick is None or order.begun_tick > (due or 0))
            if due is not None and due < tick + (status == "horizon") and stays:
                self.case.add("cancelled", due, f"{self.case.order(i)} is not cancelled, with nothing of it assigned")
            if not (order.completed or order.cancelled) and (status == "complete" or (status in LEFT and not left)):
                self.case.add(
                    "order-left",
                    tick,
                    f"{self.case.order(i)} is not complete at the end ({left} of its items are not {self.done})",
                )
        over = all(order.completed or order.cancelled for order in self.state.orders) and self.packing.all_packed
        if status in LEFT and self.state.orders and over:
            self.case.add("status", tick, f"every order is complete, but the status of the run is {status}")


class DecisionCheck:
    """Periods count up, and each decision reports the backlog it saw and the assignments and trips it had."""

    def __init__(self, case: Case, state: State) -> None:
        self.case = case
        self.state = state
        self.period = 0
        self.assignments = 0
        self.trips = 0
        self.backlog = 0
        self.closed = 0  # orders that left the backlog by the decision under way
        self.bundles = self.bundles_assigned = self.bundles_bound = 0
        rules = case.trace.scenario.get("rules", {})
        self.filtered = bool(rules.get("filters"))
        self.named = {role: name_of(rules[role.key]) for role in DECISIONS if rules.get(role.key)}
        self.handlers: Handlers = {
            OrderArrived: self.arrived,
            OrderInStock: self.in_stock,
            OrderAssigned: self.assigned,
            OrderCancelled: self.cancelled,
            TripDecided: self.trip,
            BundleArrived: self.bundle_arrived,
            BundleAssigned: self.bundle_assigned,
            BundleBound: self.bundle_bound,
            DecisionMade: self.decided,
        }

    def bundle_arrived(self, event: BundleArrived) -> None:  # noqa: ARG002
        """Count."""
        self.bundles += 1

    def bundle_assigned(self, event: BundleAssigned) -> None:  # noqa: ARG002
        """Count."""
        self.bundles_assigned += 1

    def bundle_bound(self, event: BundleBound) -> None:  # noqa: ARG002
        """Count."""
        self.bundles_bound += 1

    def arrived(self, event: OrderArrived) -> None:
        """Count, except for an order that waits for stock."""
        self.backlog += not self.state.orders[event.order].waits

    def cancelled(self, event: OrderCancelled) -> None:
        """Count, except for an order that waits for stock."""
        self.backlog -= not self.state.orders[event.order].waits

    def in_stock(self, event: OrderInStock) -> None:  # noqa: ARG002
        """Count."""
        self.backlog += 1

    def assigned(self, event: OrderAssigned) -> None:
        """Check that an assignment belongs to the period under way; its decision is told after it."""
        self.assignments += 1
        self.backlog -= event.complete
        self.closed += event.complete
        if event.period != self.period + 1:
            self.case.add(
                "period",
                event.tick,
                f"{self.case.order(event.order)} is assigned in period {event.period}; expected {self.period + 1}",
            )

    def trip(self, event: TripDecided) -> None:  # noqa: ARG002
        """Count."""
        self.trips += 1

    def decided(self, event: DecisionMade) -> None:
        """Check number and size of a decision."""
        label = event.decides.label
        if event.decides not in DECISIONS:
            expected_of = listed((role.label for role in DECISIONS), "or")
            self.case.add("unknown-id", event.tick, f"a decision on {label}; expected {expected_of}")
        self._report(event)
        of_bundles = event.decides in BUNDLE_DECISIONS
        seen, what = (self.bundles, "bundles") if of_bundles else (self.backlog + self.closed, "orders in the backlog")
        had = (self.bundles_assigned, self.bundles_bound) if of_bundles else (self.assignments, self.trips)
        if event.backlog > seen or (event.backlog < seen and not (self.filtered and not of_bundles)):
            self.case.add(
                "backlog",
                event.tick,
                f"the {label} decision of period {event.period} saw {event.backlog} {what}; there were {seen}",
            )
        expected = self.period + event.decides.assigns
        if event.period != expected:
            self.case.add(
                "period",
                event.tick,
                f"the {label} decision has period {event.period}; expected {expected}",
            )
        if (event.assignments, event.trips) != had:
            self.case.add(
                "decision-size",
                event.tick,
                f"the {label} decision of period {event.period} reports {counted(event.assignments, 'assignment')} "
                f"and {counted(event.trips, 'trip')}; it had {had[0]} and {had[1]}",
            )
        self.period = event.period
        self.bundles -= self.bundles_assigned
        self.assignments = self.trips = self.closed = self.bundles_assigned = self.bundles_bound = 0

    def _report(self, event: DecisionMade) -> None:
        """Check who decided, and what is said of how good the decision is."""
        label, named = event.decides.label, self.named.get(event.decides, event.rule)
        if event.rule != named:
            self.case.add("rule", event.tick, f"{event.rule} decided {label}; the scenario names {named}")
        if problem := misreported(event):
            told = f"the {label} decision of period {event.period} by {event.rule}"
            self.case.add("report", event.tick, f"{told} has {problem}")
        if event.objective is not None and event.bound is not None:
            most = event.objective + TOLERANCE * max(1.0, abs(event.objective))
            if event.bound > most:
                told = f"the {label} decision of period {event.period} has the objective {event.objective}"
                self.case.add("bound", event.tick, f"{told}, below its bound {event.bound}")


def misreported(event: DecisionMade) -> str | None:
    """Return what a decision reports that it cannot have: only decisions on two things at once come with a report."""
    early = "ended early" if event.stopped_early else None
    figures = (("objective", event.objective), ("bound", event.bound), ("solve", early))
    given = next((f"the {name} {value}" for name, value in figures if value is not None), None)
    if event.decides not in REPORTING and event.status != UNREPORTED:
        return f"the status {shown_short(event.status)}; expected '{UNREPORTED}': {event.decides.label} reports nothing"
    if event.status == UNREPORTED:
        return given and f"{given}; expected none from a rule that reports nothing"
    if _is_shipped(event.rule) and event.status not in STATUSES:
        return f"the status {shown_short(event.status)}; expected one of {', '.join(STATUSES)}, {UNREPORTED}"
    if event.status in STATUSES and event.stopped_early != STATUSES[event.status]:
        return f"the status {event.status}, and {'was' if event.stopped_early else 'was not'} stopped early"
    if event.status == "heuristic" and event.bound is not None:
        return f"the bound {event.bound}; expected none from a rule that proves nothing"
    return None


def _is_shipped(rule: str) -> bool:
    """Whether a rule is one of rmfs's own, whose statuses are known."""
    entries = entrypoints.offers(entrypoints.RULES).get(rule, ())
    return len(entries) == 1 and entrypoints.origin(entries[0])[0] == "rmfs"
