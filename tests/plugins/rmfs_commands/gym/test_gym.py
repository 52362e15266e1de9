"""The environment: observations, actions, rewards; episodes, policies as rules, and the rule ``learned``."""

import gc
import json
import math
import pickle
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from attrs import define, evolve
from greenlet import getcurrent, greenlet
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from hypothesis import given, settings
from hypothesis import strategies as st

import rmfs_commands.gym
import rmfs_core
from bad_rules import write_rule
from cases import cases
from copying import COPIES, Policy, copy_of
from rmfs_commands.gym import FEATURES, Choice, Learned, PolicyRule, RowNetwork, write_networks
from rmfs_commands.gym.choices import Feature, PodChoices, Table, of_locations, of_orders, of_robots
from rmfs_commands.gym.covering import of_orders_and_pods
from rmfs_commands.gym.env import ID, DecisionEnv
from rmfs_commands.gym.episode import Episode
from rmfs_commands.gym.rewards import Step
from rmfs_commands.testing import check_rule, small_world
from rmfs_core import InputError, RuleError, load_scenario
from rmfs_core.roles import Role
from rmfs_core.warehouse import Warehouse, WarehouseView

FEW = ["instance.orders=10", "rules.pp=free-flow"]


def first(_observation: Any, mask: Any) -> int:
    return int(np.argmax(mask))


def made(decides: Any = "PPS", **given: Any) -> DecisionEnv:
    return rmfs_commands.gym.make("examples/small", decides, **{"overrides": FEW} | given)


def played(env: DecisionEnv, policy: Policy = first, **reset: Any) -> list[tuple[Any, float, int]]:
    """Play an episode; return what each step observed, its reward, and the slot that was chosen."""
    observation, info = env.reset(**reset)
    steps = []
    over = False
    while not over:
        slot = policy(observation, info["action_mask"])
        observation, reward, terminated, truncated, info = env.step(slot)
        assert info["action"] == slot
        steps.append((observation, reward, slot))
        over = terminated or truncated
    return steps


def same(one: Sequence[tuple[Any, float, int]], other: Sequence[tuple[Any, float, int]]) -> bool:
    return len(one) == len(other) and all(
        np.array_equal(a[0], b[0]) and a[1:] == b[1:] for a, b in zip(one, other, strict=True)
    )


@pytest.mark.parametrize("decides", ["POA", "PPS", "PR", "TA", "POA+PPS", ["PPS", "TA"]])
def test_gymnasium_finds_nothing_wrong(decides: Any) -> None:
    env = gymnasium.make(f"rmfs_commands.gym.env:{ID}", scenario="examples/small", decides=decides, overrides=FEW)
    check_env(env.unwrapped)
    env.close()


@pytest.mark.parametrize(("decides", "rule"), COPIES)
def test_a_policy_that_copies_a_rule_gives_the_rules_files(decides: str, rule: str, tmp_path: Path) -> None:
    """Visits and orders are byte for byte those of the rule itself; only POA is asked more often."""
    key = decides.lower()
    overrides = ["instance.orders=25", f"rules.{key}={rule}"]
    env = made(decides, overrides=overrides)
    played(env, copy_of(decides, rule))
    env.result.save(tmp_path / "gym")
    by_rule = rmfs_core.run("examples/small", overrides=overrides, out=tmp_path / "rule")
    for file in ("orders.csv", "visits.csv"):
        assert (tmp_path / "gym" / file).read_bytes() == (tmp_path / "rule" / file).read_bytes()
    differing = {name for name, number in by_rule.metrics.items() if env.result.metrics[name] != number}
    assert differing <= ({"periods"} if decides == "POA" else set())
    assert env.result.timing.keys() == by_rule.timing.keys()
    assert env.result.timing["profile_s"].keys() == by_rule.timing["profile_s"].keys()
    assert env.result.versions == {**by_rule.versions, "Caller": "object of rmfs_commands.gym.episode"}
    assert env.result.hook_calls.keys() == by_rule.hook_calls.keys()
    assert getattr(env.result.scenario.rules, key).rule == "Caller"


def test_seeds_of_episodes() -> None:
    env = made()
    once, other, again = (played(env, seed=seed) for seed in (5, 6, 5))
    assert same(once, again)
    assert not same(once, other)
    assert (env.result.seed, env.result.metrics["orders_total"]) == (5, 10)

    def seeds(**given: Any) -> list[int]:
        env = made(**given)
        return [env.reset()[1]["seed"] for _ in range(3)]

    of_scenario, of_nine = seeds(), seeds(seed=9)
    assert (of_scenario[0], of_nine[0]) == (1, 9)
    assert (len({*of_scenario, *of_nine}), seeds(seed=1)) == (6, of_scenario)
    env = made()
    env.reset(seed=9)
    assert [env.reset()[1]["seed"] for _ in range(2)] == of_nine[1:]


def test_masks_and_slots() -> None:
    env = made()
    _, info = env.reset()
    mask, allowed = env.action_masks(), sorted(env.choice.options)
    assert (info["action_mask"].dtype, mask.dtype) == (np.int8, np.bool_)
    assert np.flatnonzero(mask).tolist() == np.flatnonzero(info["action_mask"]).tolist() == allowed
    assert env.action_space.sample(mask=info["action_mask"]) in env.choice.options
    gap = next((a, b) for a, b in pairwise(allowed) if b > a + 1)
    assert env.step(gap[0] + 1)[-1]["action"] == gap[1]
    for forbidden in range(0, env.action_space.n, 5):
        env.reset(seed=1)
        taken = env.step(forbidden)[-1]["action"]
        assert taken == next((slot for slot in allowed if slot >= forbidden), allowed[0])


@cases(
    "scenario reward total",
    ("examples/poisson", "visits", lambda metrics: metrics["pod_station_visits"]),
    ("examples/replenished", "visits", lambda metrics: metrics["pod_station_visits"]),  # without those for bundles
    ("examples/poisson", "turnover", lambda metrics: metrics["turnover_s"] * metrics["orders_completed"] / 3600),
    ("examples/poisson", "distance", lambda metrics: metrics["distance_m"] / 1000),
    ("examples/poisson", lambda step: -1, lambda metrics: None),
)
@pytest.mark.parametrize("decides", ["POA", "TA"])
def test_the_rewards_of_an_episode_add_up(scenario: str, reward: Any, total: Any, decides: str) -> None:
    more = ["instance.orders=40"] if scenario == "examples/replenished" else []
    env = rmfs_commands.gym.make(scenario, decides, overrides=[*FEW, *more], reward=reward)
    steps = played(env)
    expected = total(env.result.metrics)
    assert sum(step[1] for step in steps) == pytest.approx(-len(steps) if expected is None else -expected)


def test_a_reward_function_is_told_what_happened_since_the_last_choice() -> None:
    told: list[tuple[int, int, list[int], int]] = []

    def reward(step: Step) -> float:
        told.append((step.since_tick, step.warehouse.now_tick, [e.tick for e in step.events], step.orders_open))
        return 0.0

    env = made(reward=reward)
    played(env)
    assert (told[0][0], told[-1][1] / 1000, told[-1][3]) == (0, env.result.metrics["makespan_s"], 0)
    assert all(before[1] == after[0] for before, after in pairwise(told))
    assert all(since <= tick <= now for since, now, ticks, _ in told for tick in ticks)
    assert told[0][2]
    assert max(orders_open for *_, orders_open in told) == 10


def test_a_run_that_is_cut_off_has_no_choice_at_its_end() -> None:
    env = made(overrides=[*FEW, "run.until_s=100"])
    env.reset()
    over = (False, False)
    while over == (False, False):
        _, _, *over, info = env.step(env.action_space.sample())
        over = tuple(over)
    assert (over, info["time_s"], env.result.status) == ((False, True), 100, "horizon")
    assert not info["action_mask"].any()


def test_reset_never_begins_a_run_without_a_choice() -> None:
    """A seed that was given is refused; of seeds that are drawn, those whose run asks nothing are passed over."""
    nothing = made("PR", overrides=[*FEW, "run.until_s=15"])
    with pytest.raises(InputError, match="reset: the run of seed 7 asks nothing of PR; expected a longer run"):
        nothing.reset(seed=7)
    with pytest.raises(InputError, match="reset: none of 20 runs asks anything of PR; expected a longer run"):
        nothing.reset()
    env = made("PR", overrides=[*FEW, "run.until_s=90"])
    asked, refused = set(), set()
    for seed in range(8):
        try:
            asked.add(env.reset(seed=seed)[1]["seed"])
        except InputError:
            refused.add(seed)
    assert (asked, refused) == ({1, 2, 5}, {0, 3, 4, 6, 7})
    env.reset(seed=1)
    assert all(env.reset()[1]["action_mask"].any() for _ in range(5))


def test_several_kinds_of_decisions_alternate(tmp_path: Path) -> None:
    """A caller that chooses as two rules do gives their files byte for byte; only slots of the kind asked are allowed.

    A sum of rewards has weights, and the seconds between choices add up to the run's.
    """
    overrides = ["instance.orders=25", "rules.poa=pod-match", "rules.pps=completes"]
    weights = {"visits": 2.0, "distance": 0.5, (lambda step: 1.0): 0.25}
    env = rmfs_commands.gym.make("examples/small", ["PPS", "POA"], overrides=overrides, reward=weights)
    begins = {"PPS": 0, "POA": 30}
    copies = {kind: copy_of(kind, rule) for kind, rule in (("POA", "pod-match"), ("PPS", "completes"))}
    observation, info = env.reset()
    kinds, total, passed_s, over = [], 0.0, info["dt"], False
    while not over:
        kind = info["decides"]
        kinds.append(kind)
        assert env.observation_space.contains(observation)
        assert [label for label, shown in observation.items() if shown.any()] == [kind]
        assert env.first_slot == begins[kind]
        assert np.flatnonzero(info["action_mask"]).tolist() == [
            begins[kind] + slot for slot in sorted(env.choice.options)
        ]
        before_s, slot = info["time_s"], copies[kind](observation[kind], env.choice.mask) + begins[kind]
        observation, reward, terminated, truncated, info = env.step(slot)
        assert (info["action"], info["dt"]) == (slot, info["time_s"] - before_s)
        total, passed_s, over = total + reward, passed_s + info["dt"], terminated or truncated
    assert (kinds[0], {*kinds}, kinds.count("POA"), info["decides"]) == ("POA", {"POA", "PPS"}, 25, "")
    assert kinds != sorted(kinds)
    metrics = env.result.metrics
    expected = 0.25 * len(kinds) - 2 * metrics["pod_station_visits"] - 0.5 * metrics["distance_m"] / 1000
    assert (total, passed_s) == (pytest.approx(expected), pytest.approx(info["time_s"]))
    env.result.save(tmp_path / "gym")
    rmfs_core.run("examples/small", overrides=overrides, out=tmp_path / "rule")
    for file in ("orders.csv", "visits.csv"):
        assert (tmp_path / "gym" / file).read_bytes() == (tmp_path / "rule" / file).read_bytes()


def test_waiting(scenario: Path) -> None:
    """A caller that never waits has the run without waiting; one that waits whenever it may has another run.

    It is allowed while a robot has a task. A rule that waits does what its choices in the environment do.
    """
    seen: list[WarehouseView] = []
    watching = [Feature("seen", "nothing", None, lambda warehouse, _: seen.append(warehouse) or 0.0)]
    for decides in ("POA", "PPS", "POA+PPS", "TA"):
        plain = made(decides)
        env = made(decides, may_wait=True, features=watching)
        last, steps = plain.action_space.n, played(plain)
        assert env.action_space.n == last + 1
        assert [step[1:] for step in played(env)] == [step[1:] for step in steps]
        assert env.result.visits == plain.result.visits
        waited, over, (observation, info) = 0, False, env.reset()
        while not over:
            able = any(robot.task is not None for robot in seen[-1].robots)
            assert info["action_mask"][last] == able
            assert (env.choice.options.get(last, 0) is None) == able
            assert observation[:, -1].nonzero()[0].tolist() == [last] * able
            waited += able
            observation, _, over, _, info = env.step(last if able else first(observation, info["action_mask"]))
        assert waited > 5
        assert env.result.status == "complete"
        assert env.result.visits != plain.result.visits
    assert rmfs_commands.gym.make("examples/small", "PR", may_wait=True).action_space.n == 120
    patient = (scenario.parent / "policy.py").read_text().replace("min(choice.options)", "max(choice.options)")
    (scenario.parent / "patient.py").write_text(patient)
    env = rmfs_commands.gym.make(scenario, "PPS", overrides=["rules.poa=pod-match"], may_wait=True)
    played(env, lambda _, mask: int(np.flatnonzero(mask)[-1]))
    rule = 'rules.pps={rule = "./patient.py:Policy", may_wait = true}'
    assert rmfs_core.run(scenario, overrides=["rules.poa=pod-match", rule]).visits == env.result.visits


def test_features_of_ones_own() -> None:
    own = [
        Feature("number", "the pod's id", 10, lambda warehouse, choice: [pod.id for pod in choice.options.values()]),
        Feature("busy", "share of the robots with a task", None, lambda w, _: 1 - len(w.idle_robots) / len(w.robots)),
    ]
    env = made(features=own, may_wait=True)
    for observation, *_ in [(env.reset()[0],), *played(env)[:-1]]:
        assert env.observation_space.contains(observation)
        known, slots = len(FEATURES[Role.PPS]), np.flatnonzero(observation[:30].any(axis=1))
        assert observation.shape == (31, known + 3)
        assert observation[slots, known] == pytest.approx(slots / (slots + 10))
        here = [*slots, 30] if observation[30].any() else slots
        assert observation[here, known + 1] == pytest.approx(1 - observation[here, known - 1])


@cases(
    "returned",
    lambda warehouse, choice: [0.5],
    lambda warehouse, choice: 1.5,
    lambda warehouse, choice: "a",
    lambda warehouse, choice: float("nan"),
)
def test_a_feature_that_is_no_share_is_named(returned: Any) -> None:
    env = made(features=[Feature("odd", "", None, returned)])
    with pytest.raises(
        RuleError, match=r"feature 'odd': returned .*; expected one number of 0 to 1, or one for each of"
    ):
        env.reset()
    env = made(features=[Feature("odd", "", None, lambda warehouse, choice: 1 / 0)])
    with pytest.raises(RuleError, match=r"feature 'odd': raised ZeroDivisionError: .* \(\S+test_gym\.py, line \d+\)"):
        env.reset()


@settings(max_examples=8, deadline=None)
@given(st.data())
def test_after_a_restore_the_same_actions_give_the_same_run(data: Any) -> None:
    decides, may_wait = data.draw(st.sampled_from(["PPS", "POA+PPS", ["POA", "PPS", "TA"]])), data.draw(st.booleans())
    given_: dict[str, Any] = {"overrides": ["instance.orders=6", "rules.pps=random"], "may_wait": may_wait}
    env, other = (rmfs_commands.gym.make("examples/small", decides, **given_) for _ in range(2))
    draw = np.random.default_rng(data.draw(st.integers(0, 9)))

    def to_the_end(env: DecisionEnv, slots: Sequence[int] | None = None) -> tuple[list[Any], Any, Any]:
        steps, over, taken = [], False, iter(slots or ())
        while not over:
            slot = next(taken) if slots else int(draw.choice(np.flatnonzero(env.action_masks())))
            observation, reward, terminated, truncated, info = env.step(slot)
            steps.append((slot, pickle.dumps((observation, reward, sorted(info.items(), key=lambda item: item[0])))))
            over = terminated or truncated
        return steps, env.result.orders, env.result.visits

    env.reset(seed=data.draw(st.integers(0, 9)))
    for _ in range(data.draw(st.integers(0, 12))):
        if env.choice.options and not env.step(int(draw.choice(np.flatnonzero(env.action_masks()))))[2]:
            continue
        return
    snapshot, shown = env.snapshot(), pickle.dumps(env.choice.observation)
    expected = to_the_end(env)
    env.reset(seed=3)
    to_the_end(env)
    for one, there in ((env, snapshot), (other, pickle.loads(pickle.dumps(snapshot)))):
        _, info = one.restore(there)
        assert (pickle.dumps(one.choice.observation), one.snapshot()) == (shown, snapshot)
        assert np.array_equal(info["action_mask"], one.action_masks())
        assert to_the_end(one, [slot for slot, _ in expected[0]]) == expected


def test_a_snapshot_fits_the_environment_it_is_of() -> None:
    env = made()
    with pytest.raises(InputError, match="snapshot: no episode is under way; expected `reset` first"):
        env.snapshot()
    env.reset()
    for _ in range(8):
        env.step(0)
    snapshot = env.snapshot()
    for world in (["instance.orders=9"], ["run.until_s=10"], ["stations.item_capacity=5"]):
        other = made(overrides=[*FEW, *world])
        with pytest.raises(InputError, match="restore: the run of the snapshot comes to another choice here; expected"):
            other.restore(env.snapshot())
        with pytest.raises(InputError, match="step: no episode is under way"):
            other.step(0)
    for slots in ((-1,), (30,), ("a",)):
        with pytest.raises(InputError, match="restore: the run of the snapshot comes to another choice here; expected"):
            env.restore(evolve(snapshot, slots=slots))
    with pytest.raises(InputError, match="restore: found 3; expected a `Snapshot`"):
        env.restore(3)


@pytest.mark.parametrize("kind", [SyncVectorEnv, pytest.param(AsyncVectorEnv, marks=pytest.mark.slow)])
def test_vectors_of_environments(kind: Any) -> None:
    alone = made()
    envs = kind([made] * 2)
    _, infos = envs.reset(seed=3)
    assert infos["seed"].tolist() == [3, 4]
    expected = played(alone, seed=4)
    ended = 0
    for number in range(3 * len(expected)):
        observations, rewards, terminated, truncated, infos = envs.step(np.argmax(infos["action_mask"], axis=1))
        if number < len(expected):
            assert np.array_equal(observations[1], expected[number][0])
            assert rewards[1] == expected[number][1]
        ended += int(terminated.sum())
        assert not truncated.any()
    assert ended >= 4
    assert [result.status for result in envs.get_attr("result")] == ["complete"] * 2
    envs.close()


def simulations() -> int:
    gc.collect()
    return sum(type(thing).__name__ == "Simulation" for thing in gc.get_objects())


def test_an_abandoned_episode_leaves_nothing_behind() -> None:
    before = simulations()
    env: DecisionEnv | None = made()
    for _ in range(2):
        env.reset()
        env.step(0)
        assert simulations() == before + 1
    env.close()
    env.close()
    with pytest.raises(InputError, match="no episode is under way"):
        env.step(0)
    env.reset()
    env.step(0)
    env = None
    assert simulations() == before


def test_an_episode_can_follow_one_that_failed(tmp_path: Path) -> None:
    write_rule(tmp_path, "pr", "return warehouse.free_storage_locations[0] if warehouse.now_s < 0 else -1")
    scenario = tmp_path / "scenario.toml"
    scenario.write_text('[instance]\norders = 10\n[rules]\npoa = "pod-match"\npps = "demand"\npp = "free-flow"\n')
    env = rmfs_commands.gym.make(scenario, "PPS", overrides=[f"rules.pr={tmp_path}/bad.py:Bad"])
    for _ in range(2):
        with pytest.raises(RuleError, match=r"choose_storage_location, at .* s: stores pod .* not on the grid"):
            played(env)
        with pytest.raises(InputError, match="step: no episode is under way; expected `reset` first"):
            env.step(0)


def test_an_episode_belongs_to_the_thread_that_began_it() -> None:
    env = made()
    env.reset()
    with ThreadPoolExecutor(1) as thread:
        with pytest.raises(InputError, match="step: the episode was begun in another thread; expected `reset` in this"):
            thread.submit(env.step, 0).result()
        assert thread.submit(played, env).result()
    assert played(env)


@pytest.mark.parametrize("parts", [1, 2])
@pytest.mark.parametrize("reward", [None, 10**400, float("nan"), float("inf"), "3"])
def test_a_reward_that_is_no_number_is_named(reward: Any, parts: int) -> None:
    given: Any = (lambda step: reward) if parts == 1 else {"visits": 1, lambda step: reward: 1}
    env = made(reward=given)
    env.reset()
    with pytest.raises(InputError, match=r"reward: returned \S+; expected a number"):
        env.step(0)


def test_a_reward_that_fails_at_the_last_choice_leaves_the_result() -> None:
    plain = made()
    played(plain)
    env = made(reward=lambda step: 0.0 if env.choice.mask.any() else 1 / 0)
    with pytest.raises(ZeroDivisionError):
        played(env)
    assert env.result.orders == plain.result.orders
    with pytest.raises(InputError, match="step: no episode is under way; expected `reset` first"):
        env.step(0)


@pytest.mark.parametrize("action", [-1, 30, 0.5, "0", None, np.array([1])])
def test_an_action_that_is_no_slot_is_named(action: Any) -> None:
    env = made()
    env.reset()
    with pytest.raises(InputError, match=r"action: found .*; expected a whole number from 0 to 29"):
        env.step(action)
    env.step(np.int64(3))


@cases(
    "given sentence",
    (
        {"decides": "PP"},
        "decides: found 'PP'; expected POA, PPS, PR, TA or POA.PPS, which are decided one choice at a time",
    ),
    ({"decides": ["PPS", 3]}, r"decides: found 3; expected POA, PPS, PR, TA or POA.PPS"),
    ({"decides": []}, r"decides: found \[\]; expected one kind or several, each once"),
    ({"decides": ["POA", "POA+PPS"]}, "decides: found .*; expected .* and POA.PPS in place of POA and PPS"),
    ({"reward": "money"}, "reward: found 'money'; expected 'visits', 'turnover', 'distance' or a function of a St"),
    ({"orders_shown": 0}, "orders_shown: found 0; expected a whole number from 1 to 10,000"),
    ({"orders_shown": True}, "orders_shown: found True; expected a whole number from 1 to 10,000"),
    ({"orders_shown": 10**12}, "orders_shown: found 10+; expected a whole number from 1 to 10,000"),
    ({"scenario": "examples/smal"}, "examples/smal.*did you mean `examples/small`"),
    ({"overrides": ["instance.orders=-1"]}, "instance.orders"),
    ({"overrides": ["rules.poa_pps=lns"]}, 'rules.poa_pps: "lns" decides PPS with the rest; expected `rules.poa` a'),
    ({"overrides": "rules.pp=free-flow"}, "overrides: found 'rules.pp=free-flow'; expected a list"),
    ({"seed": -1}, "seed"),
    ({"pods_shown": 101}, "pods_shown: found 101; expected a whole number from 1 to 100"),
    ({"reward": {"money": 1}}, "reward: found 'money'; expected 'visits'"),
    ({"reward": {"visits": "1"}}, "reward: found the weight '1'; expected a number"),
    ({"reward": {}}, "reward: found no reward in the mapping; expected one or several, each with its weight"),
    ({"may_wait": "no"}, "may_wait: found 'no'; expected True or False"),
    ({"features": [Feature("x", "")]}, "features: found Feature.*; expected `Feature`s with a function as `of`"),
    ({"features": [Feature("serves", "", None, len)]}, "features: found a second feature 'serves'; expected a name of"),
    ({"features": [Feature("x", "", None, len)] * 2}, "features: found a second feature 'x'; expected a name of its"),
)
def test_what_is_wrong_is_said_at_once(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        rmfs_commands.gym.make(**{"scenario": "examples/small", "decides": "PPS"} | given)


def test_environments_are_made_of_scenarios() -> None:
    scenario = rmfs_core.load_scenario("examples/small", FEW)
    of_file = rmfs_commands.gym.make("examples/small", "TA", overrides=FEW)
    assert same(played(of_file), played(rmfs_commands.gym.make(scenario, "TA")))
    with pytest.raises(InputError, match="overrides: expected a scenario file with them"):
        rmfs_commands.gym.make(scenario, "TA", overrides=FEW)
    env = rmfs_commands.gym.make("examples/small", "PPS")
    assert env.action_space.n == 30
    assert not env.action_masks().any()
    filtered = [*FEW, 'rules.filters=[{rule = "most-covered", n = 1}]']
    env = rmfs_commands.gym.make("examples/small", "POA", overrides=filtered)
    env.reset()
    assert {slot // 2 for slot in env.choice.options} == {0}


def test_every_observation_lies_within_its_space() -> None:
    worlds = [
        ["instance.items_per_sku=3", "instance.due={allowance_s=60}"],
        ["instance.lines=[0,0,0,0,1]", "stations.item_capacity=4"],
        ["stations.order_capacity=2"],
    ]
    for world in worlds:
        for decides, features in FEATURES.items():
            env = made(decides.label, overrides=[*FEW, *world])
            for observation, *_ in played(env):
                assert env.observation_space.contains(observation)
                assert observation.shape[1] == len(features)


@pytest.mark.parametrize("missing", ["gymnasium", "greenlet"])
def test_packages_that_are_missing_are_named(missing: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("rmfs_commands.gym.env", "rmfs_commands.gym.episode"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(InputError, match=r"rmfs.gym: needs further packages; expected `pip install 'rmfs\[gym\]'`"):
        rmfs_commands.gym.make("examples/small", "PPS")


ORDERS: dict[str, Any] = {"first": ["a", "b"], "second": {"a": 2}, "third": ["c", "d", "e"], "fourth": ["e"]}
PODS: dict[str, Any] = {"p": {"a": 10, "b": 10}, "q": {"b": 1, "c": 1}, "r": {"d": 1, "e": 5}}


@pytest.fixture
def world() -> Warehouse:
    """Two stations with room for four items; ``first`` is assigned to the first, ``p`` is bound for it."""
    world = small_world(ORDERS, PODS, capacities=(4, 4), due_s={"third": 600.0, "fourth": 0.0})
    world.assign(world.orders[0], world.stations[0], list(dict(world.orders[0].lines)), 1)
    world.bind(world.pods[0], world.stations[0])
    return world


def shown(choice: Choice, slot: int) -> dict[str, float]:
    found = {}
    for feature, value in zip(FEATURES[choice.decides], choice.observation[slot].tolist(), strict=True):
        found[feature.name] = value if feature.half is None else feature.half * value / (1 - value)
    return found


def test_orders_and_stations(world: Warehouse) -> None:
    choice = of_orders(WarehouseView(world))
    assert (choice.decides, choice.subject) == (Role.POA, None)
    named = {slot: (order.name, station.id) for slot, (order, station) in choice.options.items()}
    assert named == {0: ("second", 0), 1: ("second", 1), 3: ("third", 1), 4: ("fourth", 0), 5: ("fourth", 1)}
    assert np.flatnonzero(choice.mask).tolist() == [0, 1, 3, 4, 5]
    assert shown(choice, 0) == pytest.approx(
        {"available": 2, "items": 2, "share": 1, "common": 1, "waited": 0, "urgency": 0, "load": 0.5, "inbound": 1}
    )
    assert shown(choice, 3) == pytest.approx(
        {"available": 0, "items": 3, "share": 0, "common": 0, "waited": 0, "urgency": 0.5, "load": 0, "inbound": 0}
    )
    assert shown(choice, 4)["urgency"] == 1


def test_no_more_orders_than_are_to_be_shown(world: Warehouse) -> None:
    choice = of_orders(WarehouseView(world), Table(orders_shown=1))
    assert {order.name for order, _ in choice.options.values()} == {"second"}
    assert len(choice.mask) == 2
    world.assign(world.orders[2], world.stations[1], [2, 3, 4], 1)
    choice = of_orders(WarehouseView(world), Table(orders_shown=2))
    named = [(order.name, station.id) for order, station in choice.options.values()]
    assert named == [("second", 0), ("fourth", 0), ("fourth", 1)]
    world.assign(world.orders[1], world.stations[0], [0], 1)
    world.assign(world.orders[3], world.stations[1], [4], 1)
    assert of_orders(WarehouseView(world)) is None


def test_pods_for_a_station(world: Warehouse) -> None:
    world.assign(world.orders[2], world.stations[1], [2, 3, 4], 1)
    world.assign(world.orders[3], world.stations[1], [4], 1)
    view = WarehouseView(world)
    choices, station, candidates = PodChoices(view), view.stations[1], view.pods[1:]
    choice = choices.among(station, candidates)
    assert (choice.decides, choice.subject) == (Role.PPS, station)
    assert choice.options == {1: view.pods[1], 2: view.pods[2]}
    drive_s = view.travel.times_to(station.cell, True)[view.pods[2].cell].min() / 1000
    assert shown(choice, 1) | {"drive": 0} == pytest.approx(
        {"serves": 1, "completes": 0, "wanted": 2 / 3, "drive": 0, "leaving": 0, "lacking": 4, "inbound": 0, "idle": 1}
    )
    # it completes the fourth order, not the third, which needs c, too
    of_third = {"serves": 3, "completes": 1, "wanted": 1, "drive": drive_s, "leaving": 0, "lacking": 4}
    assert shown(choice, 2) == pytest.approx(of_third | {"inbound": 0, "idle": 1}, rel=1e-5)
    assert not choice.observation[0].any()
    choices.take(station, view.pods[2])
    after = shown(choices.among(station, candidates[:1]), 1)
    assert (after["serves"], after["completes"], after["lacking"], after["inbound"]) == pytest.approx((1, 1, 1, 1))


def ways(view: WarehouseView, most: int) -> dict[int, tuple[str, int, tuple[int, ...]]]:
    """Return the options of POA+PPS by a plain search: order, station and pods by slot."""
    stations, found = view.stations, {}
    orders = [order for order in view.backlog if any(view.fits(order, station) for station in stations)]
    wanted = view.open_demand()
    worth = {pod.id: sum(min(pod.free_items(sku), int(wanted[sku])) for sku in pod.contents) for pod in view.pods}
    for row, order in enumerate(orders):
        for station in stations:
            if not view.fits(order, station):
                continue
            have = view.available()[station.id]
            needed = {line.sku: line.quantity - int(have[line.sku]) for line in order.open_lines}
            pods = [pod for pod in view.pods if station.id not in pod.bound_for]

            def served(pod: Any, needed: dict[int, int]) -> int:
                return sum(min(pod.free_items(sku), items) for sku, items in needed.items() if items > 0)

            def best(needed: dict[int, int], pods: list[Any] = pods) -> list[Any]:
                able = [pod for pod in pods if served(pod, needed)]
                return sorted(able, key=lambda pod: (-served(pod, needed), -worth[pod.id], pod.id))

            slot = (row * len(stations) + station.id) * most
            if all(items <= 0 for items in needed.values()):
                found[slot] = (order.name, station.id, ())
                continue
            sets = set()
            for rank, pod in enumerate(best(needed)[:most]):
                sent, left, next_one = [], dict(needed), pod
                while next_one is not None:
                    sent.append(next_one.id)
                    left = {sku: items - next_one.free_items(sku) for sku, items in left.items()}
                    next_one = next((pod for pod in best(left) if pod.id not in sent), None)
                if all(items <= 0 for items in left.values()) and frozenset(sent) not in sets:
                    sets.add(frozenset(sent))
                    found[slot + rank] = (order.name, station.id, tuple(sent))
    return found


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_orders_with_the_pods_that_they_need(data: Any) -> None:
    items = st.integers(1, 3)
    skus = st.dictionaries(st.sampled_from("abcde"), items, min_size=1)
    orders = {f"o{i}": held for i, held in enumerate(data.draw(st.lists(skus, min_size=1, max_size=4)))}
    pods = {f"p{i}": held for i, held in enumerate(data.draw(st.lists(skus, max_size=6)))} | {
        "all": dict.fromkeys("abcde", 99)
    }
    world = small_world(orders, pods, capacities=(8, 5))
    for pod, station in data.draw(st.sets(st.tuples(st.integers(0, len(pods) - 1), st.integers(0, 1)), max_size=2)):
        if not world.pods[pod].bound_for:
            world.bind(world.pods[pod], world.stations[station])
    view, most = WarehouseView(world), data.draw(st.integers(1, 4))
    choice = of_orders_and_pods(view, Table(pods_shown=most))
    expected = ways(view, most)
    if choice is None:
        assert not expected
        return
    told = {
        slot: (order.name, station.id, tuple(pod.id for pod in sent))
        for slot, (order, station, sent) in choice.options.items()
    }
    assert told == expected
    wanted = sum((Counter(dict(view.order(order.id).lines)) for order in view.backlog), Counter())
    plain = of_orders(view)
    for slot, (order, station, sent) in choice.options.items():
        row, have = shown(choice, slot), view.available()[station.id]
        pair = slot // most
        assert choice.observation[slot, :8].tolist() == plain.observation[pair].tolist()
        drive_s = max((view.travel.times_to(station.cell, True)[pod.cell].min() / 1000 for pod in sent), default=0)
        more = sum(min(pod.free_items(sku), max(wanted[sku] - have[sku], 0)) for pod in sent for sku in pod.contents)
        own = sum(max(line.quantity - have[line.sku], 0) for line in order.open_lines)
        used = sum(bool(pod.bound_for) for pod in sent) / max(len(sent), 1)
        expected_row = {"pods": len(sent), "further": max(more - own, 0) if sent else 0, "drive": drive_s, "used": used}
        assert {name: row[name] for name in expected_row} == pytest.approx(expected_row, rel=1e-4, abs=1e-6)


def test_locations_for_a_pod(world: Warehouse) -> None:
    robot, pod = world.robots[0], world.pods[0]
    world.take_task(robot, pod)
    world.lift(robot, pod)
    view = WarehouseView(world)
    choice = of_locations(view, pod)
    locations = view.travel.layout.storage_locations
    assert {slot: locations[slot] for slot in choice.options} == choice.options
    assert tuple(choice.options.values()) == view.free_storage_locations
    home = locations.index(view.home(pod))
    assert [slot for slot in choice.options if shown(choice, slot)["home"]] == [home]
    far = max(choice.options, key=lambda slot: shown(choice, slot)["drive"])
    ticks = view.travel.times_from(pod.cell, robot.heading, True)[locations[far]]
    assert shown(choice, far)["drive"] == pytest.approx(ticks / 1000, rel=1e-4)
    nearest = min(view.travel.times_to(s.cell, True)[locations[far]].min() for s in view.stations)
    assert shown(choice, far)["station"] == pytest.approx(nearest / 1000, rel=1e-4)
    assert shown(choice, far)["wanted"] == pytest.approx(1)  # four items: of q and r two and three are wanted
    assert shown(choice, far)["idle"] == 0.5


def test_robots_for_a_pod(world: Warehouse) -> None:
    view = WarehouseView(world)
    pod, (robot, _) = view.pods[0], view.robots
    choice = of_robots(view, pod, view.robots)
    assert choice.options == dict(enumerate(view.robots))
    travel = view.travel
    expected = {
        "drive": travel.ticks(robot.cell, robot.heading, pod.cell, False) / 1000,
        "carry": travel.times_to(view.stations[0].cell, True)[pod.cell].min() / 1000,
        "line": 0,
        "waiting": 1,
        "idle": 1,
    }
    assert shown(choice, 0) == pytest.approx(expected, rel=1e-4)


POLICY = """
from attrs import define
from rmfs_core.roles import Role
from rmfs_commands.gym import PolicyRule
@define
class Policy(PolicyRule):
    decides = (Role.POA, Role.PPS)
    def choose(self, choice):
        return min(choice.options)
"""


@cases(
    "given sentence",
    ({"half": 0}, "feature 'x': half: found 0; expected a number above 0, or None for a share"),
    ({"half": "a"}, "feature 'x': half: found 'a'; expected a number above 0"),
    ({"of": "abc"}, "feature 'x': of: found 'abc'; expected a function"),
)
def test_a_feature_that_cannot_be_shown_is_named(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        Feature("x", "", **given)


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "policy.py").write_text(POLICY)
    file = tmp_path / "scenario.toml"
    file.write_text(
        "[instance]\norders = 10\nskus = 20\npods = 30\n[layout]\nblock_rows = 5\nblock_columns = 3\n"
        'stations_east = 2\n[rules]\npoa = "./policy.py:Policy"\npps = "demand"\npp = "free-flow"\n'
    )
    return file


def policy(*roles: Role, choose: Callable[[Choice], Any] = lambda choice: int(choice.mask.argmax())) -> PolicyRule:
    """Return a rule that decides so, by default on the first slot."""

    @define
    class Choosing(PolicyRule):
        decides = roles

        def choose(self, choice: Choice) -> int:
            return choose(choice)

    return Choosing()


def test_it_keeps_to_what_every_rule_promises() -> None:
    assert check_rule(policy(*FEATURES)).decides == ("POA", "PPS", "POA+PPS", "PR", "TA")


@pytest.mark.parametrize("role", FEATURES)
def test_it_chooses_as_in_the_environment(role: Role) -> None:
    env = made(role.label)
    played(env)
    by_rule = rmfs_core.run("examples/small", overrides=FEW, rules={role.key: policy(role)})
    assert (by_rule.orders, by_rule.visits) == (env.result.orders, env.result.visits)


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


@pytest.mark.parametrize("slot", [99, -1, None])
def test_a_slot_that_stands_for_nothing_is_named(slot: int | None) -> None:
    sentence = f"chose slot {slot}; expected one of the .* slots of 100 that `mask` allows"
    with pytest.raises(RuleError, match=sentence):
        rmfs_core.run("examples/small", overrides=FEW, rules={"poa": policy(Role.POA, choose=lambda _: slot)})


def test_who_lets_it_go_on_is_asked() -> None:
    episode = Episode(load_scenario("examples/small", FEW), [Role.TA])
    choice = episode.go_on()
    elsewhere = greenlet(episode.go_on, getcurrent())
    choice = elsewhere.switch(min(choice.options))
    assert episode.go_on(min(choice.options)) is not None


FIFTEEN = ["instance.orders=15", "rules.pp=free-flow"]


def test_a_network_scores_each_row_by_itself() -> None:
    """With 2 features and 1 unit: 3 x - y + 2 tanh(x + 4 y - 1). Ties go to the lowest slot, masked slots to nobody."""
    network = RowNetwork.of([3, -1, 1, 4, -1, 2], 2)
    rows = np.array([[0.0, 1.0], [0.3, 0.0], [1.0, 1.0], [0.5, 0.5], [0.5, 0.5]], np.float32)
    scores = [3 * x - y + 2 * math.tanh(x + 4 * y - 1) for x, y in rows.tolist()]
    assert scores.index(max(scores)) == 2
    assert network.best(rows, np.ones(5)) == 2
    assert network.best(rows, np.array([1, 1, 0, 1, 1])) == 3
    assert network.best(rows, np.array([1, 1, 0, 0, 0])) == max((0, 1), key=scores.__getitem__)
    assert network.best(np.vstack([rows] * 40), np.arange(200) >= 100) == 102
    assert (RowNetwork.size(2, 1), RowNetwork.size(8, 0), RowNetwork.of(range(8), 8).outer.size) == (6, 8, 0)
    last_digits = RowNetwork.of([1, 1 + 1e-12, 1 + 1e-6], 3)  # processors may tell apart the first two, or not
    assert last_digits.best(np.eye(3, dtype=np.float32), np.array([1, 1, 0])) == 0
    assert last_digits.best(np.eye(3, dtype=np.float32), np.ones(3)) == 2


def test_weights_of_a_scenario(tmp_path: Path) -> None:
    weights = [0.0] * 8
    weights[[feature.name for feature in FEATURES[Role.PPS]].index("drive")] = -1.0
    write_networks(tmp_path / "near.json", {"PPS": weights})
    rule = f'rules.pps={{rule = "learned", weights = "{tmp_path}/near.json"}}'
    learned = rmfs_core.run("examples/small", overrides=[*FIFTEEN, rule])
    nearest = rmfs_core.run("examples/small", overrides=[*FIFTEEN, "rules.pps=nearest-pod"])
    assert (learned.orders, learned.visits) == (nearest.orders, nearest.visits)
    assert any("near.json" in name for name in learned.versions)
    with pytest.raises(InputError, match=r"the features of PPS are .*; expected serves, .*, idle, wait"):
        rmfs_core.run("examples/small", overrides=[*FIFTEEN, rule.replace("}", ", may_wait = true}")])
    write_networks(tmp_path / "near.json", {"PPS": [*weights, -9]}, may_wait=True)
    waiting = rmfs_core.run("examples/small", overrides=[*FIFTEEN, rule.replace("}", ", may_wait = true}")])
    assert (waiting.orders, waiting.visits) == (nearest.orders, nearest.visits)
    write_networks(tmp_path / "near.json", {"PPS": weights})
    joint = rmfs_core.load_scenario("paper-250", [rule.replace("rules.pps", "rules.poa_pps"), *FIFTEEN])
    with pytest.raises(RuleError, match=r"its file has no network for POA\+PPS; expected one that was trained for it"):
        rmfs_core.run(joint)


@cases(
    "weights sentence",
    ({"PPS": [1.0, 2, 3]}, "weights of PPS: expected 8 finite numbers, and 10 more for each hidden unit, found 3"),
    ({"PPS": [math.nan] * 8}, "weights of PPS: expected 8 finite numbers"),
    ({"PPS": "abc"}, "weights of PPS: "),
    ({"pps": [0.0] * 8}, "weights: found 'pps'; expected POA, PPS, PR, TA or POA.PPS"),
)
def test_weights_that_no_network_has_are_not_written(weights: Any, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=sentence):
        write_networks(tmp_path / "odd.json", {"POA": [0.0] * 8, **weights})
    assert not [*tmp_path.iterdir()]


@cases(
    "told sentence",
    ("[]", "odd.json holds no weights of networks; expected a file of `rmfs.gym.write_networks`"),
    ("{", "odd.json holds no weights of networks"),
    ({"PR+TA": {}}, "no role is called 'PR.TA'"),
    ({"PPS": {"features": ["a"], "weights": [1]}}, "the features of PPS are .'a'.; expected serves, completes"),
    (
        {"PPS": {"features": ["a"], "weights": [1, 2]}},
        "expected 1 finite numbers, and 3 more for each hidden unit, fou",
    ),
    ({"PPS": {"features": ["a"], "weights": [math.nan]}}, "expected 1 finite numbers"),
    ({"PPS": {"features": ["a"], "weights": [[1]]}}, "expected 1 finite numbers"),
    ({"PPS": {"weights": [1]}}, "holds no weights of networks"),
)
def test_a_file_without_networks_is_named(told: Any, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "odd.json"
    file.write_text(told if isinstance(told, str) else json.dumps(told))
    with pytest.raises(ValueError, match=sentence):
        Learned(weights=file)
    with pytest.raises(InputError, match=f'rule "learned" .rmfs [^:]*: .*{sentence}'):
        rmfs_core.run("examples/small", overrides=[f'rules.pps={{rule="learned",weights="{file}"}}'])


@pytest.mark.parametrize("decides", Learned.decides)
def test_the_shipped_weights_give_more_than_chance(decides: Role) -> None:
    by_rule = rmfs_core.run(rmfs_core.load_scenario("examples/small", FIFTEEN), rules={decides.key: Learned()})
    by_chance = rmfs_core.run("examples/small", overrides=[*FIFTEEN, "rules.pps=random"])
    assert by_rule.metrics["psv_per_order"] < by_chance.metrics["psv_per_order"]
