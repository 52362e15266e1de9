"""A policy as a rule: the same choices as in the environment, in any run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from attrs import define

import rmfs_commands.gym
import rmfs_core
from rmfs_commands.gym import FEATURES, Choice, PolicyRule
from rmfs_commands.testing import check_rule
from rmfs_core import InputError, RuleError
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
        """Look at the mask alone."""
        return int(choice.mask.argmax())


def test_it_keeps_to_what_every_rule_promises() -> None:
    """Whatever the world: one station or several, finite stock, orders larger than any station."""

    @define
    class Checked(First):
        decides = tuple(FEATURES)

    assert check_rule(Checked()).decides == ("POA", "PPS", "PR", "TA")


@pytest.mark.parametrize("role", FEATURES)
def test_it_chooses_as_in_the_environment(scenario: Path, role: Role) -> None:
    """The same choices one after the other, and so the same run."""
    overrides = [f"rules.{role.key}=./policy.py:Policy"] if role in (Role.POA, Role.PPS) else []
    env = rmfs_commands.gym.make(scenario, role.label, overrides=overrides)
    over, env_info = False, env.reset()[1]
    while not over:
        *_, terminated, truncated, env_info = env.step(int(env_info["action_mask"].argmax()))
        over = terminated or truncated
    assert env.result is not None
    policy = (scenario.parent / "policy.py").read_text()
    (scenario.parent / "any.py").write_text(policy.replace("(Role.POA, Role.PPS)", f"(Role.{role.name},)"))
    by_rule = rmfs_core.run(scenario, overrides=[f"rules.{role.key}=./any.py:Policy"])
    assert by_rule.orders == env.result.orders
    assert by_rule.visits == env.result.visits


def test_it_is_a_rule_of_a_scenario(scenario: Path) -> None:
    """From a file beside it, with parameters, for what it says that it decides."""
    result = rmfs_core.run(scenario)
    assert result.status == "complete"
    assert [row["decides"] for row in result.periods].count("POA") == 10  # one order at a time
    assert rmfs_core.run(scenario, overrides=["rules.pps=./policy.py:Policy"]).status == "complete"
    with pytest.raises(InputError, match="decides POA and PPS, with its parameters; expected PR"):
        rmfs_core.run(scenario, overrides=["rules.pr=./policy.py:Policy"])


def test_of_how_many_orders_it_chooses_is_a_parameter(scenario: Path) -> None:
    """One of many slots for one order alone, which is the oldest."""
    policy = '{rule = "./policy.py:Policy", orders_shown = 1}'
    by_age = rmfs_core.run(scenario, overrides=[f"rules.poa={policy}"])
    assigned = [row["assigned_s"] for row in by_age.orders]
    assert assigned == sorted(assigned)
    with pytest.raises(InputError, match=r"rules\.poa\.orders_shown"):
        rmfs_core.run(scenario, overrides=[f"rules.poa={policy.replace('= 1', '= 0')}"])


@pytest.mark.parametrize("slot", ["99", "-1"])
def test_a_slot_that_stands_for_nothing_is_named(scenario: Path, slot: str) -> None:
    """The run ends with the rule's name and what it chose."""
    sentence = f"chose slot {slot}; expected one of the .* slots of 100 that `mask` allows"
    with pytest.raises(RuleError, match=sentence):
        rmfs_core.run(scenario, overrides=[f'rules.poa={{rule = "./policy.py:Policy", slot = {slot}}}'])


def test_a_choice_that_is_no_number_is_named() -> None:
    """So is one of numpy's that is none, and a policy that forgets to return anything."""

    @define
    class Forgetful(PolicyRule):
        decides = (Role.PPS,)

        def choose(self, choice: Choice) -> Any:
            return None

    with pytest.raises(AssertionError, match="chose slot None; expected one of"):
        check_rule(Forgetful())
