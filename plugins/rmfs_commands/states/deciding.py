"""Asking a rule in a state: its decision, checked as the kernel does, and its outcome."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from attrs import asdict, evolve, field, frozen

from rmfs_commands.cli.single_rule import load_rule
from rmfs_commands.states.answers import APPLIED, answer_from, answer_to_dict, forget, given_in
from rmfs_commands.states.facts import facts_of
from rmfs_commands.states.mementos import due_times
from rmfs_commands.states.paths import check_path, path_wanted
from rmfs_commands.states.rebuilding import LacksError, OpenState, open_state
from rmfs_commands.states.state import RandomState, State
from rmfs_commands.states.written import read_answer
from rmfs_core.errors import InputError, RuleError
from rmfs_core.events import Event, TripDecided
from rmfs_core.randomness import rule_stream
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule
from rmfs_core.scenario.model import RuleChoice, RulesSection, Scenario, StationsSection
from rmfs_core.scenario.source import Source
from rmfs_core.simulation.applying import apply_assignments, apply_replenishment, apply_selection
from rmfs_core.simulation.asking import Asker, ImpossibleError
from rmfs_core.simulation.setup import unmet_needs
from rmfs_core.warehouse import Warehouse


@frozen
class Outcome:
    """Outcome of a decision, in terms that rules share.

    Parameters
    ----------
    orders, items
        Orders that lines were assigned of, and the items of these lines.
    visits
        New pod-station visits: trips decided.
    unused
        Capacity that stays free at the stations: items, or orders with order capacity.
    uncovered
        Open requests that no inbound pod has an item for, afterwards.
    """

    orders: int
    items: int
    visits: int
    unused: int
    uncovered: int


@frozen
class BundleOutcome:
    """Outcome of a decision of ROA, RPS or both, in terms that rules share.

    Parameters
    ----------
    bundles, items
        Bundles that were assigned to stations, and items of bundles that got a pod.
    visits
        New pod-station visits: trips decided.
    unused
        Bundle capacity that stays free at the stations.
    without_pod
        Bundles at stations that no pod is chosen for, afterwards.
    """

    bundles: int
    items: int
    visits: int
    unused: int
    without_pod: int


@frozen
class Answer:
    """A rule's decision in a state.

    Parameters
    ----------
    rule, distribution, version
        The rule, and where it comes from.
    decides
        Kind of the decision.
    decision
        ``assignments``, ``trips``, ``tasks``, ``cell``, ``bundles``, ``stores``, ``active``, ``rests``, ``moves``,
        ``packing``, ``task`` or ``legs``, with names.
    report
        Status, objective, bound, stopped_early, of a rule that reports them.
    outcome
        Outcome of the decision; None for those of robots, locations and stations.
    due
        Orders decided on that have a due time: when, their priority, and what is left until then.
    waiting_for_stock
        Orders that the rule was not shown, because the pods hold too little for them, the oldest first.
    repair
        The PPS rule that sent pods for uncovered requests after a joint decision, and how many: the last of the trips.
    facts
        Facts of the state, before the decision, as ``ask.tell`` names them.
    """

    rule: str
    distribution: str
    version: str
    decides: Role
    decision: dict[str, Any]
    report: dict[str, Any] | None
    outcome: Outcome | BundleOutcome | None
    due: Mapping[str, Mapping[str, float]] = field(factory=dict)
    waiting_for_stock: tuple[str, ...] = ()
    repair: Mapping[str, str | int] | None = None
    facts: dict[str, Any] = field(factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return the answer as `rmfs decide` prints it: JSON's objects, lists and values."""
        asked = {"rule": self.rule, "distribution": self.distribution, "version": self.version}
        found = {
            "due": self.due,
            "waiting_for_stock": [*self.waiting_for_stock],
            "report": self.report,
            "repair": self.repair,
            "outcome": self.outcome and asdict(self.outcome),
        }
        return (
            asked
            | {"decides": self.decides.label}
            | self.decision
            | {key: told for key, told in found.items() if told}
            | self.facts
        )


def ask(opened: OpenState, rule: BoundRule, given: Mapping[str, Any] | None = None) -> Answer:
    """Ask a rule in a state, and carry out there what it decides: another rule may be asked what comes next.

    Parameters
    ----------
    opened
        The state.
    rule
        The rule.
    given
        Arguments of its hook besides the warehouse and a random generator; None: those that the state says.

    Raises
    ------
    InputError, RuleError
        As `Decider.decide`.
    """
    _check_needs(opened, rule)
    warehouse = opened.warehouse
    arguments = _arguments(opened, rule) if given is None else dict(given)
    asker, facts = Asker(warehouse), facts_of(opened)
    try:
        answer, _ = asker.ask(rule, arguments | {"warehouse": opened.view, "rng": _generator(opened.state, rule)})
    except RuleError as error:
        if isinstance(error.__cause__, LacksError):
            lacks = f"asks for {error.__cause__}, but the state has no layout; expected one (`layout`)"
            raise InputError(opened.names.source, f"{rule.describe()} {lacks}") from error
        raise
    decision = answer_to_dict(opened.view, opened.instance.skus, rule.role, answer, arguments)
    outcome = asker.apply(rule, lambda: carry_out(opened, rule.role, answer, arguments, rule.traits.packing_capacity))
    assert decision is not None  # it could be carried out
    report = decision.pop("report", None)
    due = due_times(opened.state, [given["order"] for given in decision.get("assignments", ())])
    waiting = [order.name for order in opened.view.orders_waiting_for_stock] if rule.role.assigns else []
    asked = rule.name, rule.source.distribution, rule.source.version, rule.role
    return Answer(*asked, decision, report, outcome, due, tuple(waiting), facts=facts)


def repaired(opened: OpenState, answer: Answer) -> Answer:
    """Return a joint decision, carried out, with trips for the requests that no pod is on its way for.

    A joint rule sends pods for what it assigns itself. Requests that other rules left, or that have lost their pod,
    would wait forever; the pods for them wait for robots as those of the decision do.
    """
    named = opened.state.ask.repair or ("none" if opened.state.layout is None else "demand")
    before = answer.outcome
    if answer.decides is not Role.POA_PPS or not isinstance(before, Outcome) or named == "none":
        return answer
    place = Source(opened.names.source).place_of(("ask", "repair"))
    rule = load_rule(RuleChoice(named), (Role.PPS,), allow_inline=False, place=place)
    if not before.uncovered:
        return answer
    more = ask(opened, rule, {"max_fetches": len(opened.view.free_pods)})
    assert isinstance(more.outcome, Outcome)
    trips = more.decision["trips"]
    visits = before.visits + more.outcome.visits
    outcome = evolve(more.outcome, orders=before.orders, items=before.items, visits=visits)
    decision = answer.decision | {"trips": [*answer.decision["trips"], *trips]}
    return evolve(answer, decision=decision, outcome=outcome, repair={"rule": rule.name, "trips": len(trips)})


def decide_instead(
    state: State,
    choices: Sequence[RuleChoice],
    decides: Role,
    *,
    allow_inline: bool = True,
    source: str = "state",
    place: str = "rule",
) -> Answer:
    """Ask what another rule would have decided; or a POA rule and then, where that leads, a PPS rule.

    Parameters
    ----------
    state
        The state.
    choices
        One rule, or a POA and a PPS rule.
    decides
        Kind of the decision made in the state: POA and joint rules answer each other's states.
    allow_inline
        Whether rules may be loaded from files.
    source
        Name of the state's source in messages.
    place
        Name of the choices' source in messages.

    Raises
    ------
    InputError, RuleError
        As `decide`; and for a rule that decides something else.
    """
    roles: list[tuple[Role, ...]] = [(Role.POA, Role.POA_PPS)] if decides.assigns else [(decides,)]
    if decides in (Role.ROA, Role.ROA_RPS):
        roles = [(Role.ROA, Role.ROA_RPS)]
    if len(choices) > 1:
        if not decides.assigns or len(choices) > 2:
            raise InputError(place, f"found {len(choices)} rules to decide {decides.label}; expected one rule")
        roles = [(Role.POA,), (Role.PPS,)]
    rules = [
        load_rule(choice, wanted, allow_inline=allow_inline, place=place, preferred=decides)
        for choice, wanted in zip(choices, roles, strict=True)
    ]
    opened = open_state(state, source)
    answers = [ask(opened, rule) for rule in rules]
    first, last = answers[0], answers[-1]
    if last is first or not (isinstance(first.outcome, Outcome) and isinstance(last.outcome, Outcome)):
        return first
    outcome = evolve(last.outcome, orders=first.outcome.orders, items=first.outcome.items)
    return evolve(first, decides=Role.POA_PPS, decision={**first.decision, **last.decision}, outcome=outcome)


def outcome_of(
    state: State, decides: Role, decision: Mapping[str, Any], source: str = "state"
) -> Outcome | BundleOutcome | None:
    """Return what a decision comes to that was made in a state.

    Raises
    ------
    InputError
        When it cannot have been made there.
    """
    opened = open_state(state, source)
    try:
        answer = answer_from(read_answer(decision), decides, opened.view, opened.names)
        return carry_out(opened, decides, answer, given_in(opened, decides), None)
    except (ImpossibleError, InputError) as error:
        raise InputError(source, f"the decision does not belong to the state: {error}") from error


def _check_needs(opened: OpenState, rule: BoundRule) -> None:
    """Refuse a rule that needs what the state does not have, as a scenario would be refused."""
    counts_orders = any(station.counts_orders for station in opened.warehouse.stations)
    stations = StationsSection(order_capacity=1 if counts_orders else None, oversize="alone")  # sizes: nobody's need
    scenario = Scenario(RulesSection(poa_pps=RuleChoice("")), stations=stations)
    for problem in unmet_needs(rule, opened.names.source, scenario, opened.instance):
        raise problem


def _arguments(opened: OpenState, rule: BoundRule) -> dict[str, Any]:
    """Return what the rule's hook is given besides the warehouse and the random generator."""
    if rule.role in (Role.PR, Role.IDLE, Role.MOVE, Role.PP) and opened.state.layout is None:
        raise InputError(
            opened.names.source,
            f"{rule.describe()} decides {rule.role.label}, but the state has no layout; expected one",
        )
    if rule.role is Role.PP:
        return path_wanted(opened, rule)
    return given_in(opened, rule.role)


def _generator(state: State, rule: BoundRule) -> np.random.Generator:
    if state.random is None:
        return rule_stream(state.seed, rule.role, rule.name)
    return restored_generator(state.random)


def restored_generator(random: RandomState) -> np.random.Generator:
    """Return the random generator that a state tells of."""
    bits = np.random.PCG64(0)
    bits.state = {
        "bit_generator": "PCG64",
        "state": {"state": int(random.state), "inc": int(random.increment)},
        "has_uint32": random.has_uint32,
        "uinteger": random.uinteger,
    }
    return np.random.Generator(bits)


def carry_out(
    opened: OpenState, role: Role, answer: object, arguments: Mapping[str, Any], packing_capacity: int | None
) -> Outcome | BundleOutcome | None:
    """Check a decision and apply it to the state's warehouse, as in a run; return what it comes to.

    None for decisions of robots, locations and stations.

    Raises
    ------
    ImpossibleError
        When it cannot be carried out.
    """
    warehouse = opened.warehouse
    if role is Role.PP:
        check_path(warehouse, answer, **arguments)
        return None
    if (apply := APPLIED.get(role)) is not None:
        apply(warehouse, answer, **arguments)
        return None
    if role in (Role.ROA, Role.RPS, Role.ROA_RPS):
        return _replenished(opened, role, answer, arguments.get("max_fetches", 0))
    open_before = _open_items(warehouse)
    if role is Role.PPS:
        decision = apply_selection(warehouse, answer, keep=forget, **arguments)
    else:
        decision = apply_assignments(
            warehouse,
            answer,
            joint=role is Role.POA_PPS,
            shown=opened.shown,
            period=opened.period,
            packing_capacity=packing_capacity,
            keep=forget,
        )
    return Outcome(
        orders=len({given.order for given in decision.assignments}),
        items=open_before - _open_items(warehouse),
        visits=len(decision.trips),
        unused=sum(station.free_capacity for station in warehouse.picking),
        uncovered=sum(station.uncovered_items for station in warehouse.stations),
    )


def _open_items(warehouse: Warehouse) -> int:
    return sum(items * orders for items, orders in warehouse.backlog.sizes.items())


def _replenished(opened: OpenState, role: Role, answer: object, max_fetches: int) -> BundleOutcome:
    warehouse = opened.warehouse
    told: list[Event] = []
    decision = apply_replenishment(warehouse, answer, role=role, max_fetches=max_fetches, keep=told.append)
    at_stations = [bundle for station in warehouse.storing for bundle in station.bundles]
    chosen = {store.bundle for store in decision.stores}
    return BundleOutcome(
        bundles=len(decision.assignments),
        items=sum(bundle.items for bundle in at_stations if bundle.id in chosen),
        visits=sum(isinstance(event, TripDecided) for event in told),
        unused=sum(station.free_bundle_capacity for station in warehouse.storing),
        without_pod=sum(bundle.pod is None for bundle in at_stations),
    )
