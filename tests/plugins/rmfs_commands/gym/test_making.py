"""Making an environment, and what is said where that cannot be done."""

from __future__ import annotations

import sys

import pytest

import rmfs_commands.gym
from rmfs_core import InputError


def test_an_environment_is_made_of_a_scenario() -> None:
    """It has a slot for each of the scenario's 30 pods, and nothing is under way."""
    env = rmfs_commands.gym.make("examples/small", "PPS")
    assert env.action_space.n == 30
    assert not env.action_masks().any()


@pytest.mark.parametrize("missing", ["gymnasium", "greenlet"])
def test_packages_that_are_missing_are_named(missing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """With what to install; features and `PolicyRule` are there without them."""
    for module in ("rmfs_commands.gym.env", "rmfs_commands.gym.episode"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(InputError, match=r"rmfs.gym: needs further packages; expected `pip install 'rmfs\[gym\]'`"):
        rmfs_commands.gym.make("examples/small", "PPS")
