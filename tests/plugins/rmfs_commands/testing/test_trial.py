"""One run of a rule in a trial world: what happened, what was wrong, and how long its calls took."""

from __future__ import annotations

import re
from typing import Any, ClassVar

import pytest
from attrs import define, field

from rmfs_commands.testing import trial
from rmfs_commands.testing.trial import CallTimes, Outcome, WatchedRule, run_trial
from rmfs_commands.testing.trial_worlds import TrialWorld, trial_worlds
from rmfs_core import InputError, Leg, OrderAssignment, Path, hookimpl
from rmfs_core.events import DecisionMade, OrderCompleted
from rmfs_core.info import Question, RunInfo
from rmfs_core.roles import Role

WORLD = trial_worlds()[0]
"""One station, ten orders."""


def tried(rule: Any, *roles: Role, world: TrialWorld = WORLD) -> tuple[Outcome, dict[str, CallTimes]]:
    """Run a world with a rule in these roles; return what came of it and the times of its calls."""
    times: dict[str, CallTimes] = {}
    return run_trial(world, WatchedRule(rule, times), roles), times


@define
class First:
    """POA: the first order that fits."""

    @hookimpl
    def assign_orders(self, warehouse):
        station = warehouse.stations[0]
        return [OrderAssignment(order.id, 0) for order in warehouse.backlog if warehouse.fits(order, station)][:1]


def test_all_events_are_kept() -> None:
    """Every order is completed, and what the wall clock says is left out: two runs have equal events."""
    outcome, times = tried(First(), Role.POA)
    assert outcome.problems == ()
    assert sum(isinstance(event, OrderCompleted) for event in outcome.events) == len(WORLD.instance.orders)
    decisions = [event for event in outcome.events if isinstance(event, DecisionMade)]
    assert {event.rule for event in decisions if event.decides is Role.POA} == {"First"}
    assert {event.wall_s for event in decisions} == {0.0}
    assert outcome.events == tried(First(), Role.POA)[0].events
    assert times.keys() == {"assign_orders"}
    assert times["assign_orders"].calls == sum(event.decides is Role.POA for event in decisions)


def test_call_times_add_up() -> None:
    """Number, sum, and the longest."""
    times = CallTimes()
    for seconds in (0.25, 1.0, 0.5):
        times.add(seconds)
    assert (times.calls, times.total_s, times.longest_s) == (3, 1.75, 1.0)


@define
class Watching(First):
    """POA that observes, and notes what it is told."""

    told: list[str] = field(factory=list)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        self.told.append("run_started")

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        self.told.append("rule_asked")

    @hookimpl
    def rule_answered(self, question: Question, answer: object) -> None:
        self.told.append("rule_answered")

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        self.told.append(status)

    @hookimpl
    def measured(self) -> dict[str, float]:
        self.told.append("measured")
        return {}


def test_a_rule_that_observes_is_told_everything() -> None:
    """From the start to the end, also what other rules are asked."""
    rule = Watching()
    outcome, times = tried(rule, Role.POA, Role.OBSERVER)
    assert outcome.problems == ()
    assert rule.told[0] == "run_started"
    assert rule.told[-2:] == ["complete", "measured"]
    assert rule.told.count("rule_asked") == rule.told.count("rule_answered") > times["assign_orders"].calls


@define
class Choosy(First):
    """POA that is told of completed orders alone, or has a function called for each."""

    hears: Any = (OrderCompleted,)
    heard: list[int] = field(factory=list)

    @hookimpl
    def on_event(self, event: OrderCompleted) -> None:
        self.heard.append(event.order)


def test_a_rule_hears_what_it_listens_to() -> None:
    """As in a run: events of these kinds, or a call of the functions named for them in place of the hook."""
    tuple_of_kinds, mapping, heard = Choosy(), Choosy(), []
    mapping.hears = {OrderCompleted: [lambda event: heard.append(event.order)]}
    for rule in (tuple_of_kinds, mapping):
        outcome, times = tried(rule, Role.POA, Role.OBSERVER)
        assert outcome.problems == ()
        assert times["on_event"].calls == len(WORLD.instance.orders)
    assert tuple_of_kinds.heard == heard != []
    assert mapping.heard == []


def test_a_function_that_is_told_of_events_is_watched() -> None:
    """What it changes of the view is a mutation."""
    rule = Choosy()
    watched = WatchedRule(rule, {})
    rule.hears = {OrderCompleted: [lambda _: object.__setattr__(watched.view.pods[0], "name", "mine")]}
    (kind, problem), *_ = run_trial(WORLD, watched, (Role.POA, Role.OBSERVER)).problems
    assert (kind, problem[:24]) == ("mutation of the view", "on_event changed name of")


@define
class Wrong:
    """POA that does what it is told to."""

    doing: str

    @hookimpl
    def assign_orders(self, warehouse):
        match self.doing:
            case "nothing":
                return []
            case "no station":
                return [OrderAssignment(warehouse.backlog[0].id, 7)]
            case "raise":
                raise KeyError("tea")
            case _:
                return 5


@define
class Renames(First):
    """POA that changes what it sees, and then raises."""

    raises: bool = False

    @hookimpl
    def assign_orders(self, warehouse):
        object.__setattr__(warehouse.pods[0], "name", "mine")
        if self.raises:
            raise ValueError("no idea")
        return First.assign_orders(self, warehouse)


@pytest.mark.parametrize(
    ("rule", "kinds", "problem"),
    [
        (Wrong("nothing"), ["starved order"], "stands still"),
        (Wrong("no station"), ["impossible decision"], "named station 7, which does not exist"),
        (Wrong("five"), ["impossible decision"], "int"),
        (Wrong("raise"), ["exception"], "KeyError"),
        (Renames(), ["mutation of the view"], "assign_orders changed name of pod mine (id 0) at 0.000 s"),
    ],
    ids=["nothing", "no station", "five", "raise", "renames"],
)
def test_what_is_wrong_has_its_kind(rule: Any, kinds: list[str], problem: str) -> None:
    """And a sentence that says what happened."""
    outcome, _ = tried(rule, Role.POA)
    assert [kind for kind, _ in outcome.problems] == kinds
    assert problem in outcome.problems[0][1]


def test_a_mutation_comes_first() -> None:
    """It may well be the cause of the other."""
    rule = Renames(raises=True)
    outcome, _ = tried(rule, Role.POA)
    assert "exception" in [kind for kind, _ in outcome.problems]


def test_a_run_that_gets_nowhere_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """After so many decisions, whatever else happens."""
    monkeypatch.setattr(trial, "MOST_CALLS", 3)
    outcome, times = tried(First(), Role.POA)
    ((kind, problem),) = outcome.problems
    assert kind == "starved order"
    said = r"after 3 decisions the run is not over: it was asked assign_orders 3 times, until [\d.]+ s"
    assert re.fullmatch(said, problem)
    assert times["assign_orders"].calls == 3


@define
class Sleepless(First):
    """POA that assigns nothing and wakes up every second."""

    @hookimpl
    def assign_orders(self):
        return []

    @hookimpl
    def wake_at(self, warehouse):
        return warehouse.now_s + 1


def test_a_rule_that_only_wakes_up_is_told_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """How often it was asked, and until when; nothing of where it was stopped."""
    monkeypatch.setattr(trial, "MOST_CALLS", 30)
    ((kind, problem),) = tried(Sleepless(), Role.POA)[0].problems
    assert kind == "starved order"
    assert "wake_at 15 times" in problem
    assert problem.endswith(", until 15.000 s")


def test_an_instance_may_run_again() -> None:
    """Its decisions are counted anew, and a mutation of the run before is forgotten."""
    rule = WatchedRule(First(), {})
    for _ in range(2):
        assert run_trial(WORLD, rule, (Role.POA,)).problems == ()
    assert rule.asked.total() == rule.times["assign_orders"].calls // 2


@define
class Needy(First):
    """POA with an attribute that the kernel does not understand."""

    needs: ClassVar[tuple[str, ...]] = ("magic",)


def test_a_trait_that_is_none_is_refused() -> None:
    """As when a scenario names the rule."""
    with pytest.raises(InputError, match=r"class Needy: .*needs = \('magic',\)"):
        tried(Needy(), Role.POA)


@define
class Ruthless:
    """PP that takes from the other robots what they have reserved, and drives as if it were alone."""

    reserves: ClassVar[str] = "full paths"

    @hookimpl
    def plan_path(self, warehouse, robot, goal, traffic):
        for other in warehouse.robots:
            if other is not robot:
                traffic.table.release(other.id)
        query = traffic.query
        legs = warehouse.travel.fastest_path(query.cell, query.heading, query.goal, query.loaded)
        return Path(legs or [Leg(query.cell)])


def test_where_robots_drive_is_validated() -> None:
    """What slips past the kernel's checks, here by a change of its table, shows in what the robots did."""
    outcome, _ = tried(Ruthless(), Role.PP, world=trial_worlds()[1])
    (mutation, _), (kind, problem) = outcome.problems
    assert (mutation, kind) == ("mutation of the view", "impossible trace")
    assert re.fullmatch(r"at [\d.]+ s robot \d and robot \d (both hold|drive through) .* more\)", problem)
