"""One run of a rule in a trial world, with every call of the rule watched."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import pluggy
from attrs import define, evolve, field, frozen

from rmfs_commands.testing.snapshot import Snapshot
from rmfs_commands.testing.traces import Recorder
from rmfs_commands.testing.trial_worlds import LONGEST_S, PLAIN_RULES
from rmfs_core.errors import RuleError, StandstillError
from rmfs_core.events import Event
from rmfs_core.hookspecs import hookimpl
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule, RuleSet
from rmfs_core.rules.hooks import OBSERVER_HOOKS, marked_methods, new_manager
from rmfs_core.rules.sources import RuleSource
from rmfs_core.rules.traits import RuleTraits
from rmfs_core.scenario.model import PACKING_RULES, RuleChoice
from rmfs_core.scenario.rulenames import rule_choices
from rmfs_core.simulation.engine import Simulation
from rmfs_core.wording import counted, listed

if TYPE_CHECKING:
    from rmfs_commands.testing.trial_worlds import TrialWorld
    from rmfs_core.info import Question, RunInfo
    from rmfs_core.warehouse import WarehouseView

MOST_CALLS = 5_000
"""Decisions after which a run counts as one that gets nowhere; a trial world needs a few dozen of a rule."""

IMPOSSIBLE = "impossible decision"
RAISED = "exception"
STARVED = "starved order"
MUTATED = "mutation of the view"
IMPOSSIBLE_TRACE = "impossible trace"

UNCHARGED = ' (a rule that sends no robot to a charger says so by needs = ("no batteries",))'
"""Hint for rules for idle robots if orders starve in a world with batteries."""


class _EndlessError(Exception):
    """The rule was asked so often that the run gets nowhere; the text says what."""


@define(eq=False)
class CallTimes:
    """How long the calls of a hook took: their number, and wall-clock seconds in all and of the longest."""

    calls: int = 0
    total_s: float = 0.0
    longest_s: float = 0.0

    def add(self, seconds: float) -> None:
        """Count a call."""
        self.calls += 1
        self.total_s += seconds
        self.longest_s = max(self.longest_s, seconds)


@frozen(eq=False)
class Outcome:
    """Outcome of a run: all events, and problems as (kind, problem)."""

    events: tuple[Event, ...]
    problems: tuple[tuple[str, str], ...]


@define(eq=False)
class WatchedRule:
    """A rule on a plugin manager of its own, on which each call is timed and compared with the view before it.

    Parameters
    ----------
    instance
        The rule.
    times
        Where the calls are counted, by hook.
    """

    instance: Any
    times: dict[str, CallTimes]
    manager: pluggy.PluginManager = field(init=False, factory=new_manager)
    view: WarehouseView | None = field(init=False, default=None)
    mutation: str | None = field(init=False, default=None)
    asked: Counter[str] = field(init=False, factory=Counter)
    _before: Snapshot | None = field(init=False, default=None)
    _started: float = field(init=False, default=0.0)

    def __attrs_post_init__(self) -> None:
        self.manager.register(self.instance, type(self.instance).__name__)
        self.manager.add_hookcall_monitoring(self._before_call, self._after_call)

    def bound(self, role: Role) -> BoundRule:
        """Return the rule as the kernel knows it."""
        kind = type(self.instance)
        traits = RuleTraits.of(self.instance, f"class {kind.__name__}", "it")
        hook: pluggy.HookCaller = getattr(self.manager.hook, traits.hook(role))
        source = RuleSource(kind.__name__, kind, kind.__module__, "under test")
        wakes = self.manager.hook.wake_at if self.manager.hook.wake_at.get_hookimpls() else None
        return BoundRule(role, source, self.instance, traits, hook, wakes, call=hook)

    def begin(self, view: WarehouseView) -> None:
        """Forget the run before this one."""
        self.view, self.mutation, self.asked = view, None, Counter()

    def tell(self, function: Callable[[Event], object], event: Event) -> None:
        """Call a function that the rule's ``hears`` names, instead of its hook and watched like it."""
        self._before_call("on_event", function, {})
        function(event)
        self._after_call(None, "on_event", function, {})

    def _before_call(self, name: str, _methods: object, arguments: Mapping[str, Any]) -> None:
        if name not in OBSERVER_HOOKS:
            if self.asked.total() == MOST_CALLS:
                calls = listed(f"{hook} {counted(times, 'time')}" for hook, times in self.asked.most_common())
                raise _EndlessError(f"it was asked {calls}, until {self.view.now_s if self.view else 0:.3f} s")
            self.asked[name] += 1
        if self.view is not None and self.mutation is None:
            self._before = Snapshot.of(self.view, arguments.get("traffic"))
        self._started = time.perf_counter()

    def _after_call(self, _outcome: object, name: str, methods: object, arguments: Mapping[str, Any]) -> None:
        if not methods:
            return
        self.times.setdefault(name, CallTimes()).add(time.perf_counter() - self._started)
        if self.view is None or self._before is None or self.mutation is not None:
            return
        changed = self._before.first_change(Snapshot.of(self.view, arguments.get("traffic")))
        if changed is not None:
            self.mutation = f"{name} changed {changed} at {self.view.now_s:.3f} s"


@define(eq=False, slots=False)
class _Forwarding:
    """Observer that tells the watched rule what happens. An error in it names a line of the rule's module."""

    rule: WatchedRule

    def __attrs_post_init__(self) -> None:
        self.__module__ = type(self.rule.instance).__module__

    @property
    def hears(self) -> object:
        """Events that the rule listens to."""
        heard = getattr(self.rule.instance, "hears", None)
        if not isinstance(heard, Mapping):
            return heard
        return {kind: [partial(self.rule.tell, function) for function in called] for kind, called in heard.items()}

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        self.rule.manager.hook.run_started(run=run)

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.rule.manager.hook.on_event(event=event)

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        self.rule.manager.hook.rule_asked(question=question)

    @hookimpl
    def rule_answered(self, question: Question, answer: object) -> None:
        self.rule.manager.hook.rule_answered(question=question, answer=answer)

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        self.rule.manager.hook.run_ended(tick=tick, status=status)

    @hookimpl
    def measured(self) -> object:
        answers = self.rule.manager.hook.measured()
        return answers[0] if answers else {}


def run_trial(world: TrialWorld, rule: WatchedRule, roles: tuple[Role, ...]) -> Outcome:
    """Run a world with a rule in these roles, and the plain rules in the others."""
    rules = _rules(world, rule, roles)
    recorder = Recorder()
    rules.register_observer(recorder)
    simulation = Simulation(world.scenario, world.instance, world.layout, rules)
    rule.begin(simulation.view)
    try:
        simulation.run()
        _, errors = simulation.context.observers.end(simulation.status)
        problems = [_problem(error) for error in errors[:1]]
        problems += _incomplete(simulation) if world.scenario.run.until_s == LONGEST_S else []
        if Role.PP in roles:
            problems += _impossible(simulation, recorder, rule, roles)
    except Exception as error:
        problems = [_problem(error)]
    if Role.IDLE in roles and world.scenario.robots.battery is not None:
        problems = [(kind, problem + UNCHARGED * (kind == STARVED)) for kind, problem in problems]
    if rule.mutation is not None:  # first: it may well be the cause of the others
        problems.insert(0, (MUTATED, rule.mutation))
    return Outcome(tuple(recorder.events), tuple(problems))


@cache
def _plain_rules(named: tuple[tuple[str, str], ...], splits: bool) -> RuleSet:
    """Return the rules around the one under test; they remember nothing of a run, so all runs share them."""
    chosen: dict[str, Any] = {**PACKING_RULES, **{key: RuleChoice(name) for key, name in named}}
    plain = evolve(PLAIN_RULES, **chosen)
    if splits:
        plain = evolve(plain, poa=None, pps=None, poa_pps=RuleChoice("pod-index"))
    return RuleSet.load(plain, ".", allow_inline=False)


def _rules(world: TrialWorld, rule: WatchedRule, roles: tuple[Role, ...]) -> RuleSet:
    whole = {Role.POA, Role.PPS, Role.POA_PPS} & {*roles}
    splits = world.scenario.packing is not None and Role.PACKING in roles and not whole
    plain = _plain_rules(tuple((str(key), one.rule) for (key,), one in rule_choices(world.scenario.rules)), splits)
    observes = bool(OBSERVER_HOOKS & marked_methods(rule.instance).keys())
    chosen: dict[str, Any] = {role.key: rule.bound(role) for role in roles if not role.many}
    excluded = [other.key for role in roles for other in role.excludes]
    rules = evolve(
        plain,
        pm=new_manager(),
        filters=(rule.bound(Role.FILTER),) if Role.FILTER in roles else plain.filters,
        **{key: chosen.pop(key) for key in ("pr", "ta", "pp") if key in chosen},
        others={**plain.others, **dict.fromkeys(excluded), **chosen},
    )
    if observes:
        rules.register_observer(_Forwarding(rule), rule.bound(Role.OBSERVER).describe())
    return rules


def _problem(error: BaseException) -> tuple[str, str]:
    while isinstance(error.__cause__, type(error)):  # simpy raises what a process raised anew
        error = error.__cause__
    if isinstance(error, StandstillError):
        return STARVED, str(error)
    if isinstance(error.__cause__, _EndlessError):
        return STARVED, f"after {MOST_CALLS:,} decisions the run is not over: {error.__cause__}"
    if isinstance(error, RuleError) and error.__cause__ is None:
        return IMPOSSIBLE, str(error)
    return RAISED, str(error) if isinstance(error, RuleError) else f"{type(error).__name__}: {error}"


def _impossible(
    simulation: Simulation, recorder: Recorder, rule: WatchedRule, roles: tuple[Role, ...]
) -> list[tuple[str, str]]:
    """Validate the trace of a run whose robots drove as the rule planned."""
    bound = rule.bound(Role.PP)
    named = {role.key: bound.name for role in roles if role not in (Role.FILTER, Role.OBSERVER)}
    avoids = bound.traits.reserves is not None
    faults = recorder.faults(simulation.now, simulation.status, named, collisions=avoids)
    if not faults:
        return []
    more = f" (and {len(faults) - 1} more)" if len(faults) > 1 else ""
    return [(IMPOSSIBLE_TRACE, f"at {faults[0].time_s:.3f} s {faults[0].sentence}{more}")]


def _incomplete(simulation: Simulation) -> list[tuple[str, str]]:
    left = [order.name for order in simulation.warehouse.orders if order.unpicked_items]
    left = left or [order.name for station in simulation.warehouse.packing for order in station.orders]
    if not left:
        return []
    return [(STARVED, f"orders {', '.join(left)} are not complete after {simulation.view.now_s:.0f} s")]
