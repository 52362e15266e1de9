"""The environment: a run as an episode, one choice a step."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from attrs import frozen
from numpy.typing import NDArray

from rmfs_commands.gym.choices import FEATURES, Choice, Feature, Table
from rmfs_commands.gym.episode import Episode
from rmfs_commands.gym.policy import MOST_SHOWN, MOST_WAYS
from rmfs_commands.gym.rewards import REWARDS, Reward, rewarded, weighted
from rmfs_core import InputError, Result, Scenario, load_scenario
from rmfs_core.roles import Role
from rmfs_core.wording import listed, shown_short

Observation = NDArray[np.float32] | dict[str, NDArray[np.float32]]

MOST_RUNS = 20
"""Runs that `DecisionEnv.reset` draws until one has a choice."""

ID = "rmfs/Decision-v0"
"""Under which Gymnasium knows the environment, once this module is imported:
``rmfs_commands.gym.env:rmfs/Decision-v0``.
"""


@frozen
class Snapshot:
    """Point of an episode: the run of a seed, and the slots chosen in it so far. It can be pickled.

    Parameters
    ----------
    seed
        The run's seed.
    slots
        The actions so far, in their order.
    digest
        Digest of the choice to be made.
    """

    seed: int
    slots: tuple[int, ...]
    digest: str


class DecisionEnv(gymnasium.Env[Observation, np.int64]):
    """A run in which the caller makes one kind of decision or several, as `make` says.

    An action is a slot (`Choice`). Which slots may be chosen is in ``info["action_mask"]`` (int8, as
    `gymnasium.spaces.Discrete.sample` takes it) and in `action_masks` (bool, as sb3-contrib asks for it). For one that
    may not be chosen the next one that may be is taken, beginning again at 0 after the last; ``info["action"]`` has the
    slot that was. With several kinds of decisions, each has slots of its own, one kind after another; an observation
    is a dictionary by kind, all zero except for the kind that is to be decided, ``info["decides"]``.

    An episode is over (``terminated``) when every order is complete, and cut off (``truncated``) at ``run.until_s``.
    ``reset(seed=...)`` begins that of a seed: orders, pods and all others' draws are those of ``rmfs run --seed``.
    The first one without is that of the scenario's seed; those after it are drawn, from the last seed given. A run in
    which nothing is to be chosen is no episode: another seed is drawn, or `InputError` raised for one that was given.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 (Gymnasium declares it so)

    def __init__(
        self,
        scenario: Scenario | str | Path,
        decides: str | Sequence[str] = "PPS",
        *,
        overrides: Sequence[str] = (),
        seed: int | None = None,
        reward: str | Reward | Mapping[str | Reward, float] = "visits",
        orders_shown: int = 50,
        pods_shown: int = 3,
        may_wait: bool = False,
        features: Sequence[Feature] = (),
        allow_inline_rules: bool = True,
    ) -> None:
        if isinstance(overrides, str):  # a sequence of letters
            raise InputError("overrides", f"found {shown_short(overrides)}; expected a list of such texts")
        if isinstance(scenario, Scenario) and overrides:
            raise InputError("overrides", "expected a scenario file with them; change a Scenario with attrs.evolve")
        self.scenario = load_scenario(scenario, overrides, seed) if not isinstance(scenario, Scenario) else scenario
        if seed is not None:
            self.scenario = self.scenario.with_seed(seed)
        self._decides = _roles(decides, self.scenario)
        self._reward = _reward(reward)
        for name, number, most in (
            ("orders_shown", orders_shown, MOST_SHOWN),
            ("pods_shown", pods_shown, MOST_WAYS),
        ):
            if not isinstance(number, int) or isinstance(number, bool) or not 1 <= number <= most:
                raise InputError(name, f"found {shown_short(number)}; expected a whole number from 1 to {most:,}")
        own = tuple(features) if isinstance(features, Sequence) else (features,)
        table = Table(orders_shown, pods_shown, may_wait, own)
        self._options = table, allow_inline_rules
        probe = Episode(self.scenario, self._decides, *self._options)  # what is wrong with it is said now
        self._nothing = [table.nothing(role, probe.simulation.view) for role in self._decides]
        spaces: dict[str, gymnasium.Space[Any]] = {
            choice.decides.label: gymnasium.spaces.Box(0.0, 1.0, choice.observation.shape, np.float32)
            for choice in self._nothing
        }
        self._several = not isinstance(decides, str)
        space: Any = gymnasium.spaces.Dict(spaces) if self._several else spaces[self._decides[0].label]
        self.observation_space = space
        self._begins, self._slots_in_all = dict[Role, int](), 0
        for choice in self._nothing:
            self._begins[choice.decides] = self._slots_in_all
            self._slots_in_all += len(choice.mask)
        self.action_space = gymnasium.spaces.Discrete(self._slots_in_all)
        self._episode: Episode | None = None
        self._choice: Choice | None = None
        self._begun, self._mask = False, np.zeros(self._slots_in_all, np.bool_)
        self._seed, self._slots, self._time_s = self.scenario.seed, list[int](), 0.0
        self._result: Result | None = None
        super().reset(seed=self.scenario.seed)

    @property
    def choice(self) -> Choice:
        """The choice to be made now: the pods, robots, locations or orders that the slots of its kind stand for."""
        return self._choice or self._nothing[0]

    @property
    def first_slot(self) -> int:
        """The slot of the environment that is the first one of ``choice``: 0 with a single kind of decisions."""
        return self._begins[self.choice.decides]

    @property
    def result(self) -> Result | None:
        """Result that `rmfs_core.run` would return for the last complete episode; None before."""
        return self._result

    def action_masks(self) -> NDArray[np.bool_]:
        """Return which slots may be chosen now."""
        return self._mask.copy()

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002 (there are none)
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode, and end the one under way, if any."""
        super().reset(seed=seed)
        for _ in range(MOST_RUNS):
            self._begin(self._next_seed() if seed is None else seed)
            if self._choice is not None:
                return self._observed(), {**self._info(0.0), "seed": self._seed}
            self.close()
            if seed is not None:
                break
        labels = listed([role.label for role in self._decides], "or")
        which = f"the run of seed {self._seed}" if seed is not None else f"none of {MOST_RUNS} runs"
        found = "asks nothing" if seed is not None else "asks anything"
        raise InputError("reset", f"{which} {found} of {labels}; expected a longer run, or other decisions")

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Choose a slot, and let the run go on to the next choice."""
        if self._episode is None:
            raise InputError("step", "no episode is under way; expected `reset` first")
        if not self.action_space.contains(action):
            expected = f"expected a whole number from 0 to {self._slots_in_all - 1}"
            raise InputError("action", f"found {shown_short(action)}; {expected}")
        slot, episode, before_s = self._allowed(int(action)), self._episode, self._time_s
        self._go_on(episode, slot)
        over = self._choice is None
        if over:  # also when the reward raises
            self._episode = None
            self._result = episode.result()
        reward = rewarded(self._reward, episode.heard())
        info = {**self._info(self._time_s - before_s), "action": slot}
        return self._observed(), reward, over and episode.complete, over and not episode.complete, info

    def snapshot(self) -> Snapshot:
        """Return where the episode under way is, for `restore`: what was chosen so far."""
        if self._choice is None:
            raise InputError("snapshot", "no episode is under way; expected `reset` first")
        return Snapshot(self._seed, tuple(self._slots), self._digest())

    def restore(self, snapshot: Snapshot) -> tuple[Observation, dict[str, Any]]:
        """Go back, or on, to where an episode was, and end the one under way; return what `reset` would there.

        The run is made again from its beginning with what was chosen, so it is exactly the same one, and takes as long
        as it took to come there. A snapshot may be of another environment that was made alike.

        Raises
        ------
        InputError
            When it is no `Snapshot`, or the run comes to another choice: with another scenario, or where a rule decides
            by the clock.
        """
        if not isinstance(snapshot, Snapshot):
            raise InputError("restore", f"found {shown_short(snapshot)}; expected a `Snapshot`")
        self._begin(snapshot.seed)
        for slot in snapshot.slots:
            if self._choice is None or self._episode is None or slot not in range(self._slots_in_all):
                break
            if self._allowed(slot) == slot:
                self._go_on(self._episode, slot)
                self._episode.heard()
        if self._choice is None or (self._slots, self._digest()) != ([*snapshot.slots], snapshot.digest):
            self.close()
            expected = "expected the same scenario and arguments, and rules without time limits"
            raise InputError("restore", f"the run of the snapshot comes to another choice here; {expected}")
        return self._observed(), {**self._info(0.0), "seed": self._seed}

    def close(self) -> None:
        """End the episode under way, if any."""
        episode, self._episode, self._choice = self._episode, None, None
        self._mask = np.zeros(self._slots_in_all, np.bool_)
        if episode is not None:
            episode.close()

    def _next_seed(self) -> int:
        return int(self.np_random.integers(1 << 31)) if self._begun else self.scenario.seed

    def _begin(self, seed: int) -> None:
        self.close()
        self._begun, self._seed, self._slots = True, seed, []
        self._episode = Episode(self.scenario.with_seed(seed), self._decides, *self._options)
        self._go_on(self._episode)

    def _go_on(self, episode: Episode, slot: int | None = None) -> None:
        if slot is not None:
            self._slots.append(slot)
            slot -= self.first_slot
        try:
            self._choice = choice = episode.go_on(slot)
        except BaseException:
            self.close()
            raise
        self._time_s = episode.simulation.view.now_s
        if self._several or choice is None:
            self._mask = np.concatenate([self._shown(nothing).mask for nothing in self._nothing])
        else:
            self._mask = choice.mask

    def _allowed(self, slot: int) -> int:
        mask = self._mask
        return slot if mask[slot] else int((slot + np.roll(mask, -slot).argmax()) % len(mask))

    def _shown(self, nothing: Choice) -> Choice:
        """Return the choice to be made, if it is of the kind of one that stands for nothing; else that."""
        return self._choice if self._choice is not None and self._choice.decides is nothing.decides else nothing

    def _digest(self) -> str:
        choice = self.choice
        told = f"{choice.decides} {self._time_s} {choice.observation.shape}".encode()
        return hashlib.sha256(told + choice.mask.tobytes() + choice.observation.tobytes()).hexdigest()

    def _observed(self) -> Observation:
        if not self._several:
            return self.choice.observation.copy()
        return {nothing.decides.label: self._shown(nothing).observation.copy() for nothing in self._nothing}

    def _info(self, passed_s: float) -> dict[str, Any]:
        return {
            "action_mask": self._mask.astype(np.int8),
            "decides": "" if self._choice is None else self._choice.decides.label,
            "dt": passed_s,
            "time_s": self._time_s,
        }


def _roles(decides: str | Sequence[str], scenario: Scenario) -> tuple[Role, ...]:
    roles = {role.label: role for role in FEATURES}
    found: list[Role] = []
    for label in [decides] if isinstance(decides, str) or not isinstance(decides, Sequence) else decides:
        if label not in [*roles]:
            expected = f"expected {listed(roles, 'or')}, which are decided one choice at a time"
            raise InputError("decides", f"found {shown_short(label)}; {expected}")
        found.append(roles[label])
    if not found or len({*found}) < len(found) or any({*role.excludes} & {*found} for role in found):
        expected = "expected one kind or several, each once, and POA+PPS in place of POA and PPS"
        raise InputError("decides", f"found {shown_short(decides)}; {expected}")
    for role in found:
        if role in Role.POA_PPS.excludes and scenario.rules.poa_pps is not None and {*Role.POA_PPS.excludes} - {*found}:
            joint = scenario.rules.poa_pps.rule
            raise InputError(
                "rules.poa_pps", f'"{joint}" decides {role.label} with the rest; expected `rules.poa` and `rules.pps`'
            )
    return tuple(found)


def _reward(reward: str | Reward | Mapping[str | Reward, float]) -> Reward:
    if callable(reward):
        return reward
    if isinstance(reward, Mapping):
        if not reward:
            raise InputError("reward", "found no reward in the mapping; expected one or several, each with its weight")
        for part, weight in reward.items():
            _reward(part)
            if isinstance(weight, bool) or not isinstance(weight, int | float) or not math.isfinite(weight):
                raise InputError("reward", f"found the weight {shown_short(weight)}; expected a number")
        return weighted(reward)
    if reward not in [*REWARDS]:
        expected = f"expected {listed([*map(repr, REWARDS), 'a function of a Step'], 'or')}"
        raise InputError("reward", f"found {shown_short(reward)}; {expected}")
    return REWARDS[reward]


gymnasium.register(ID, entry_point=f"{__name__}:{DecisionEnv.__name__}")
