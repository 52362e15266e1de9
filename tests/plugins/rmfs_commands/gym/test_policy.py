"""Episodes, and policies as rules."""

from pathlib import Path
from typing import Any

import pytest
from attrs import define
from greenlet import getcurrent, greenlet

import rmfs_commands.gym
import rmfs_core
from rmfs_commands.gym import FEATURES, Choice, PolicyRule
from rmfs_commands.gym.episode import Episode
from rmfs_commands.testing import check_rule
from rmfs_core import InputError, RuleError, Scenario, load_scenario
from rmfs_core.events import TaskAssigned
from rmfs_core.roles import Role

POLICY = """
from attrs import define
from rmfs_core.roles import Role
from rmfs_commands.gym import PolicyRule

@define
class Policy(PolicyRule):
    decides = (Role.POA, Role.PPS)
    slot: int | None = None

    def choose(self, choice):
        return min(choice.options) if self.slot is None else self.slot
"""


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Ten orders, and a policy beside the scenario, in the current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "policy.py").write_text(POLICY)
    file = tmp_path / "scenario.toml"
    file.write_text(
        "[instance]\norders = 10\nskus = 20\npods = 30\n[layout]\nblock_rows = 5\nblock_columns = 3\n"
        'stations_east = 2\n[rules]\npoa = "./policy.py:Policy"\npps = "demand"\npp = "free-flow"\n'
    )
    return file


@define
class First(PolicyRule):
    """A policy that takes the first slot."""

    def choose(self, choice: Choice) -> int:
        return int(choice.mask.argmax())


def test_it_keeps_to_what_every_rule_promises() -> None:
    @define
    class Checked(First):
        decides = tuple(FEATURES)

    assert check_rule(Checked()).decides == ("POA", "PPS", "PR", "TA")


@pytest.mark.parametrize("role", FEATURES)
def test_it_chooses_as_in_the_environment(scenario: Path, role: Role) -> None:
    overrides = [f"rules.{role.key}=./policy.py:Policy"] if role in (Role.POA, Role.PPS) else []
    env = rmfs_commands.gym.make(scenario, role.label, overrides=overrides)
    over, env_info = False, env.reset()[1]
    while not over:
        *_, terminated, truncated, env_info = env.step(int(env_info["action_mask"].argmax()))
        over = terminated or truncated
    policy = (scenario.parent / "policy.py").read_text()
    (scenario.parent / "any.py").write_text(policy.replace("(Role.POA, Role.PPS)", f"(Role.{role.name},)"))
    by_rule = rmfs_core.run(scenario, overrides=[f"rules.{role.key}=./any.py:Policy"])
    assert by_rule.orders == env.result.orders
    assert by_rule.visits == env.result.visits


def test_it_is_a_rule_of_a_scenario(scenario: Path) -> None:
    result = rmfs_core.run(scenario)
    assert result.status == "complete"
    assert [row["decides"] for row in result.periods].count("POA") == 10  # one order at a time
    assert rmfs_core.run(scenario, overrides=["rules.pps=./policy.py:Policy"]).status == "complete"
    with pytest.raises(InputError, match="decides POA and PPS, with its parameters; expected PR"):
        rmfs_core.run(scenario, overrides=["rules.pr=./policy.py:Policy"])
    policy = '{rule = "./policy.py:Policy", orders_shown = 1}'
    by_age = rmfs_core.run(scenario, overrides=[f"rules.poa={policy}"])
    assigned = [row["assigned_s"] for row in by_age.orders]
    assert assigned == sorted(assigned)
    with pytest.raises(InputError, match=r"rules\.poa\.orders_shown"):
        rmfs_core.run(scenario, overrides=[f"rules.poa={policy.replace('= 1', '= 0')}"])


@pytest.mark.parametrize("slot", ["99", "-1"])
def test_a_slot_that_stands_for_nothing_is_named(scenario: Path, slot: str) -> None:
    sentence = f"chose slot {slot}; expected one of the .* slots of 100 that `mask` allows"
    with pytest.raises(RuleError, match=sentence):
        rmfs_core.run(scenario, overrides=[f'rules.poa={{rule = "./policy.py:Policy", slot = {slot}}}'])


def test_a_choice_that_is_no_number_is_named() -> None:
    @define
    class Forgetful(PolicyRule):
        decides = (Role.PPS,)

        def choose(self, choice: Choice) -> Any:
            return None

    with pytest.raises(AssertionError, match="chose slot None; expected one of"):
        check_rule(Forgetful())


PLACE = ["instance.orders=10", "rules.pp=free-flow"]


@pytest.fixture
def small() -> Scenario:
    return load_scenario("examples/small", PLACE)


def to_its_end(episode: Episode) -> int:
    """Choose the first slot until the run is over; return how many choices there were."""
    number, choice = 0, episode.go_on()
    while choice is not None:
        number, choice = number + 1, episode.go_on(min(choice.options))
    return number


def test_it_stops_at_each_choice_and_goes_on(small: Scenario) -> None:
    episode = Episode(small, Role.TA, 50)
    assert not episode.complete
    choices = to_its_end(episode)
    assert choices == sum(isinstance(event, TaskAssigned) for event in episode.heard().events)
    assert episode.complete


def test_its_result_is_one_of_a_run(small: Scenario) -> None:
    episode = Episode(small, Role.PPS, 50)
    to_its_end(episode)
    result, by_run = episode.result(), rmfs_core.run(small)
    assert result.status == "complete"
    assert result.metrics.keys() == by_run.metrics.keys()
    assert result.timing.keys() == by_run.timing.keys()
    assert result.timing["profile_s"].keys() == by_run.timing["profile_s"].keys()
    assert result.versions == {**by_run.versions, "Caller": "object of rmfs_commands.gym.episode"}
    assert result.hook_calls.keys() == by_run.hook_calls.keys()
    assert {row["order"] for row in result.orders} == {row["order"] for row in by_run.orders}
    assert result.scenario.rules.pps.rule == "Caller"
    assert result.periods[1]["rule"] == "Caller"


def test_what_is_heard_is_heard_once(small: Scenario) -> None:
    episode = Episode(small, Role.PPS, 50)
    choice = episode.go_on()
    first = episode.heard()
    assert (first.since_tick, first.orders_open) == (0, 10)
    assert first.events
    assert episode.heard().events == ()
    while choice is not None:
        before = episode.simulation.now
        choice = episode.go_on(min(choice.options))
        step = episode.heard()
        assert step.since_tick == before
        assert all(before <= event.tick <= step.warehouse.now_tick for event in step.events)
    assert step.orders_open == 0


@pytest.mark.parametrize("steps", [0, 1, 5])
def test_closing_ends_it_wherever_it_is(small: Scenario, steps: int) -> None:
    episode = Episode(small, Role.POA, 50)
    slot = None
    for _ in range(steps):
        choice = episode.go_on(slot)
        slot = min(choice.options)
    episode.heard()
    episode.close()
    episode.close()
    assert episode.heard().events == ()
    assert not episode.complete


def test_who_lets_it_go_on_is_asked(small: Scenario) -> None:
    episode = Episode(small, Role.TA, 50)
    choice = episode.go_on()
    elsewhere = greenlet(episode.go_on, getcurrent())
    choice = elsewhere.switch(min(choice.options))
    assert episode.go_on(min(choice.options)) is not None
