"""How quick an environment is. `make bench` measures; the bar is asserted there only."""

from __future__ import annotations

from time import process_time
from typing import Any

import pytest

import rmfs_commands.gym
import rmfs_core
from copying import copy_of


@pytest.mark.parametrize("decides", ["POA", "PPS", "PR", "TA"])
@pytest.mark.parametrize("world", ["examples/small", "paper-250"])
def test_an_episode_takes_little_longer_than_a_run(benchmark: Any, world: str, decides: str) -> None:
    """Bar: at least 80 % of the speed of the simulation with the rule that the policy copies, its own time included.

    Robots do not see each other (``free-flow``): where paths are planned the simulation takes longer.
    """
    rule = {"POA": "pod-match", "PPS": "nearest-pod", "PR": "nearest", "TA": "nearest-robot"}[decides]
    overrides = ["rules.pp=free-flow", f"rules.{decides.lower()}={rule}"]
    env = rmfs_commands.gym.make(world, decides, overrides=overrides, orders_shown=250)
    policy = copy_of(decides, rule, stations=2 if world == "examples/small" else 4)
    spent: dict[str, list[float]] = {"episode": [], "run": []}

    def episode() -> None:
        observation, info = env.reset(seed=1)
        over = False
        while not over:
            observation, _, terminated, truncated, info = env.step(policy(observation, info["action_mask"]))
            over = terminated or truncated

    def both() -> None:
        for name, play in (("episode", episode), ("run", lambda: rmfs_core.run(world, overrides=overrides))):
            before = process_time()
            play()
            spent[name].append(process_time() - before)

    benchmark.pedantic(both, rounds=5, warmup_rounds=1)
    if benchmark.enabled:
        share = min(spent["run"]) / min(spent["episode"])
        benchmark.extra_info["share_of_speed"] = share
        assert share >= 0.8
