"""A decision round: activation, POA (or the joint rule), PPS, ROA, RPS, TA, moves, rests: asked, checked, applied."""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from functools import partial
from typing import Any

from rmfs_core.decisions import BundleDecision, JointDecision
from rmfs_core.events import DecisionMade
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule
from rmfs_core.simulation import checks
from rmfs_core.simulation.applying import (
    apply_activation,
    apply_assignments,
    apply_moves,
    apply_replenishment,
    apply_rests,
    apply_selection,
    apply_tasks,
)
from rmfs_core.simulation.asking import ImpossibleError, sequence_of
from rmfs_core.simulation.context import RunContext
from rmfs_core.simulation.going import Going
from rmfs_core.warehouse import Order, Pod, Robot, WarehouseView


class Decisions:
    """Asks the rules of a run and applies what they decide.

    Parameters
    ----------
    run
        The run.
    start_task, start_move, start_rest
        Set a robot off to fetch a pod, to carry one elsewhere, and to rest somewhere.
    assigned
        Is called with each POA or joint decision that was carried out, unless it decided nothing.
    """

    def __init__(
        self,
        run: RunContext,
        start_task: Callable[[Robot, Pod], None],
        start_move: Callable[[Robot, Pod, int], None],
        start_rest: Callable[[Robot, int, float], None],
        assigned: Callable[[JointDecision], None],
    ) -> None:
        self._run = run
        self._start_task, self._start_move, self._start_rest = start_task, start_move, start_rest
        self._assigned, self._for_bundles = assigned, run.rules.deciding_bundles
        self.warehouse, self.rules, self.asker = run.warehouse, run.rules, run.asker
        assigning = run.rules.poa_pps or run.rules.poa
        assert assigning is not None
        self.assigning: BoundRule = assigning
        self._waking = list({id(rule.instance): rule for rule in run.rules.deciding if rule.wake is not None}.values())
        self.alarm: int | None = None
        """Tick at which the last answers want to be woken up."""
        self._alarms: set[int] = set()
        self.alarms_in_a_row = 0

    def round(self, *, by_clock: bool = False) -> None:
        """Decide all that can be decided now, and hear when to do so again; ``by_clock``: nothing else happened."""
        self.alarms_in_a_row = self.alarms_in_a_row + 1 if by_clock else 0
        if (rule := self.rules.activate) is not None:
            active, _ = self._run.ask(rule)
            self._run.apply(rule, apply_activation, active)
        while self.warehouse.fits_smallest(single_line=self.assigning.traits.splits_over_time):
            if (decision := self._assign_orders()) is None:
                break
            self._assigned(decision)
        if self.rules.pps is not None:
            self._select_pods(self.rules.pps)
        if self._for_bundles:
            self._replenish()
        self._assign_tasks()
        if self.rules.move is not None:
            self._move_pods(self.rules.move)
        if self.rules.idle is not None:
            self._rest_robots(self.rules.idle)
        if self._waking:
            self._set_alarm()

    def storage_location(self, pod: Pod) -> int:
        """Ask PR where a pod goes back to, and keep the location free for it."""
        rule = self.rules.pr
        answer, _ = self._run.ask(rule, pod=pod)
        location = self.asker.apply(rule, lambda: checks.storage_location(self.warehouse, pod, answer))
        self.warehouse.reserve(location)
        return location

    # POA and the joint rule

    def _assign_orders(self) -> JointDecision | None:
        """Ask for one period; return what was decided, None for nothing."""
        view, shown, filtering_s = self._shown_backlog()
        seen = view.backlog_size
        if not seen:
            return None
        rule = self.assigning
        self.asker.period += 1
        answer, seconds = self._run.ask(rule, view)
        joint, packing, period = rule is self.rules.poa_pps, rule.traits.packing_capacity, self.asker.period
        asked = {"joint": joint, "shown": shown, "period": period, "packing_capacity": packing}
        decision = self._run.apply(rule, apply_assignments, answer, **asked)
        self._tell_decision(rule, seen, decision, filtering_s + seconds)
        return decision if decision.assignments or decision.trips else None

    def _shown_backlog(self) -> tuple[WarehouseView, Container[int] | None, float]:
        """Pass the backlog through the prefilters; return the view, the ids shown (None: all), and the seconds."""
        if not self.rules.filters:
            return self._run.view, None, 0.0
        orders, total = self.warehouse.backlog.orders, 0.0
        for rule in self.rules.filters:
            answer, seconds = self._run.ask(rule, orders=orders)
            orders = self.asker.apply(rule, partial(_kept, answer, orders))
            total += seconds
        return WarehouseView(self.warehouse, orders), {order.id for order in orders}, total

    # PPS

    def _select_pods(self, rule: BoundRule) -> None:
        max_fetches = self._max_fetches()
        if not (max_fetches or self.warehouse.leaving_pods()):
            return
        if not any(station.uncovered_items for station in self.warehouse.stations):
            return
        answer, seconds = self._run.ask(rule, max_fetches=max_fetches)
        decision = self._run.apply(rule, apply_selection, answer, max_fetches=max_fetches)
        self._tell_decision(rule, len(self.warehouse.backlog), decision, seconds)

    def _max_fetches(self) -> int:
        """How many robots could start now."""
        return max(len(self.warehouse.idle) - len(self.warehouse.waiting), 0)

    # ROA and RPS

    def _replenish(self) -> None:
        warehouse = self.warehouse
        for rule in self._for_bundles:
            assigns = bool(warehouse.bundles) and any(s.free_bundle_capacity > 0 for s in warehouse.storing)
            selects = any(bundle.pod is None for station in warehouse.storing for bundle in station.bundles)
            if not (assigns if rule.role is Role.ROA else selects or (rule.role is Role.ROA_RPS and assigns)):
                continue
            waiting, most = len(warehouse.bundles), self._max_fetches()
            arguments: dict[str, Any] = {} if rule.role is Role.ROA else {"max_fetches": most}
            answer, seconds = self._run.ask(rule, self._run.view, **arguments)
            decision = self._run.apply(rule, apply_replenishment, answer, role=rule.role, max_fetches=most)
            self._tell_decision(rule, waiting, decision, seconds)

    # TA

    def _assign_tasks(self) -> None:
        if not self.warehouse.waiting or not self.warehouse.idle:
            return
        rule = self.rules.ta
        answer, _ = self._run.ask(rule)
        self._run.apply(rule, apply_tasks, answer, start=self._start_task)

    # Robots that TA has left without a task

    def _move_pods(self, rule: BoundRule) -> None:
        most = min(self._max_fetches(), self.warehouse.spare_locations)
        if most > 0:
            answer, _ = self._run.ask(rule, max_moves=most)
            self._run.apply(rule, apply_moves, answer, max_moves=most, start=self._start_move)

    def _rest_robots(self, rule: BoundRule) -> None:
        if any(robot.resting for robot in self.warehouse.robots):
            answer, _ = self._run.ask(rule)
            self._run.apply(rule, apply_rests, answer, start=self._start_rest)

    # Time

    def _set_alarm(self) -> None:
        """Ask when to wake up. No alarm is taken back: one that is not what the last answers say rings for nothing."""
        self.alarm = min((tick for tick in map(self._wake_tick, self._waking) if tick is not None), default=None)
        if self.alarm is not None and self.alarm not in self._alarms:
            self.ring_at(self.alarm)

    def ring_at(self, tick: int, *, wanted: bool = True) -> None:
        """Wake up at a tick, if no answer until then says otherwise."""
        self._alarms.add(tick)
        self.alarm = tick if wanted else self.alarm
        self._run.after(tick - self.warehouse.now, Going("alarm", tick=tick)).callbacks.append(self._ring)

    def _wake_tick(self, rule: BoundRule) -> int | None:
        answer, _ = self._run.ask(rule, hook=rule.wake)
        return self.asker.apply(rule, lambda: checks.wake_tick(self.warehouse.now, answer), rule.wake)

    def _ring(self, _: object) -> None:
        self._alarms.remove(self.warehouse.now)
        if self.warehouse.now == self.alarm:
            self.round(by_clock=True)

    def _tell_decision(
        self, rule: BoundRule, backlog: int, decision: JointDecision | BundleDecision, seconds: float
    ) -> None:
        trips = decision.trips if isinstance(decision, JointDecision) else decision.stores
        now, period, assigned, sent = self.warehouse.now, self.asker.period, len(decision.assignments), len(trips)
        status, objective, bound, early = "decided", None, None, False
        if (report := decision.report) is not None:
            status, objective, bound, early = report.status, report.objective, report.bound, report.stopped_early
        event = DecisionMade(
            now, period, rule.role, rule.name, backlog, assigned, sent, status, objective, bound, early, seconds
        )
        self._run.tell(event)


def _kept(answer: object, before: Sequence[Order]) -> tuple[Order, ...]:
    """Check a filter's answer; return it oldest first."""
    kept = sequence_of(answer, Order)
    allowed = set(before)
    for order in kept:
        if order not in allowed:
            raise ImpossibleError(f"returned order {order.name}, which it was not given")
    chosen = set(kept)
    return tuple(order for order in before if order in chosen)
