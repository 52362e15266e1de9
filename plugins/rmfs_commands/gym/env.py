"""The environment: a run as an episode, one choice a step."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from rmfs_commands.gym.choices import FEATURES, Choice, nothing, slots_of
from rmfs_commands.gym.episode import Episode
from rmfs_commands.gym.policy import MOST_SHOWN
from rmfs_commands.gym.rewards import REWARDS, Reward, Step
from rmfs_core import InputError, Result, Scenario, load_scenario
from rmfs_core.roles import Role
from rmfs_core.wording import listed, shown_short

ID = "rmfs/Decision-v0"
"""Under which Gymnasium knows the environment, once this module is imported:
``rmfs_commands.gym.env:rmfs/Decision-v0``.
"""


class DecisionEnv(gymnasium.Env[NDArray[np.float32], np.int64]):
    """A run in which the caller makes one kind of decision, as `make` says.

    An action is a slot (`Choice`). Which slots may be chosen is in ``info["action_mask"]`` (int8, as
    `gymnasium.spaces.Discrete.sample` takes it) and in `action_masks` (bool, as sb3-contrib asks for it). For one that
    may not be chosen the next one that may be is taken, beginning again at 0 after the last; ``info["action"]`` has the
    slot that was.

    An episode is over (``terminated``) when every order is complete, and cut off (``truncated``) at ``run.until_s``.
    ``reset(seed=...)`` begins that of a seed: orders, pods and all others' draws are those of ``rmfs run --seed``.
    The first one without is that of the scenario's seed; those after it are drawn, from the last seed given.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 (Gymnasium declares it so)

    def __init__(
        self,
        scenario: Scenario | str | Path,
        decides: str = "PPS",
        *,
        overrides: Sequence[str] = (),
        seed: int | None = None,
        reward: str | Reward = "visits",
        orders_shown: int = 50,
        allow_inline_rules: bool = True,
    ) -> None:
        if isinstance(overrides, str):  # a sequence of letters
            raise InputError("overrides", f"found {shown_short(overrides)}; expected a list of such texts")
        if isinstance(scenario, Scenario) and overrides:
            raise InputError("overrides", "expected a scenario file with them; change a Scenario with attrs.evolve")
        self.scenario = load_scenario(scenario, overrides, seed) if not isinstance(scenario, Scenario) else scenario
        if seed is not None:
            self.scenario = self.scenario.with_seed(seed)
        self._decides = _role(decides, self.scenario)
        self._reward = _reward(reward)
        if not isinstance(orders_shown, int) or isinstance(orders_shown, bool) or not 1 <= orders_shown <= MOST_SHOWN:
            expected = f"expected a whole number from 1 to {MOST_SHOWN:,}"
            raise InputError("orders_shown", f"found {shown_short(orders_shown)}; {expected}")
        self._options = orders_shown, allow_inline_rules
        probe = Episode(self.scenario, self._decides, *self._options)  # what is wrong with it is said now
        slots = slots_of(self._decides, probe.simulation.view, orders_shown)
        self.observation_space = gymnasium.spaces.Box(0.0, 1.0, (slots, len(FEATURES[self._decides])), np.float32)
        self.action_space = gymnasium.spaces.Discrete(slots)
        self._nothing = nothing(self._decides, slots)
        self._episode: Episode | None = None
        self._choice: Choice | None = None
        self._begun = False
        self._result: Result | None = None
        super().reset(seed=self.scenario.seed)

    @property
    def choice(self) -> Choice:
        """The choice to be made now: the pods, robots, locations or orders that the slots stand for."""
        return self._choice or self._nothing

    @property
    def result(self) -> Result | None:
        """Result that `rmfs_core.run` would return for the last complete episode; None before."""
        return self._result

    def action_masks(self) -> NDArray[np.bool_]:
        """Return which slots may be chosen now."""
        return self.choice.mask.copy()

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002 (there are none)
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin an episode, and end the one under way, if any."""
        super().reset(seed=seed)
        if seed is None:
            seed = int(self.np_random.integers(1 << 31)) if self._begun else self.scenario.seed
        self.close()
        self._begun = True
        self._episode = episode = Episode(self.scenario.with_seed(seed), self._decides, *self._options)
        self._go_on(episode)
        return self._observed(), {**self._info(episode), "seed": seed}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Choose a slot, and let the run go on to the next choice."""
        if self._episode is None:
            raise InputError("step", "no episode is under way; expected `reset` first")
        if not self.action_space.contains(action):
            expected = f"expected a whole number from 0 to {len(self.choice.mask) - 1}"
            raise InputError("action", f"found {shown_short(action)}; {expected}")
        slot, episode = self._allowed(int(action)), self._episode
        if self._choice is not None:  # else the run was over before there was anything to choose
            self._go_on(episode, slot)
        reward = self._rewarded(episode.heard())
        info = {**self._info(episode), "action": slot}
        if self._choice is not None:
            return self._observed(), reward, False, False, info
        self._episode = None
        self._result = episode.result()
        return self._observed(), reward, episode.complete, not episode.complete, info

    def close(self) -> None:
        """End the episode under way, if any."""
        episode, self._episode, self._choice = self._episode, None, None
        if episode is not None:
            episode.close()

    def _go_on(self, episode: Episode, slot: int | None = None) -> None:
        try:
            self._choice = episode.go_on(slot)
        except BaseException:
            self.close()
            raise

    def _allowed(self, slot: int) -> int:
        mask = self.choice.mask
        if mask.any() and not mask[slot]:
            slot = int((slot + np.roll(mask, -slot).argmax()) % len(mask))
        return slot

    def _rewarded(self, step: Step) -> float:
        reward = self._reward(step)
        try:
            return float(reward)
        except (TypeError, ValueError, OverflowError):
            raise InputError("reward", f"returned {shown_short(reward)}; expected a number") from None

    def _observed(self) -> NDArray[np.float32]:
        return self.choice.observation.copy()

    def _info(self, episode: Episode) -> dict[str, Any]:
        return {"action_mask": self.choice.mask.astype(np.int8), "time_s": episode.simulation.view.now_s}


def _role(decides: str, scenario: Scenario) -> Role:
    roles = {role.label: role for role in FEATURES}
    if decides not in [*roles]:
        expected = f"expected {listed(roles, 'or')}, which are decided one choice at a time"
        raise InputError("decides", f"found {shown_short(decides)}; {expected}")
    role = roles[decides]
    if role in Role.POA_PPS.excludes and scenario.rules.poa_pps is not None:
        joint = scenario.rules.poa_pps.rule
        raise InputError(
            "rules.poa_pps", f'"{joint}" decides {decides} with the rest; expected `rules.poa` and `rules.pps`'
        )
    return role


def _reward(reward: str | Reward) -> Reward:
    if callable(reward):
        return reward
    if reward not in [*REWARDS]:
        expected = f"expected {listed([*map(repr, REWARDS), 'a function of a Step'], 'or')}"
        raise InputError("reward", f"found {shown_short(reward)}; {expected}")
    return REWARDS[reward]


gymnasium.register(ID, entry_point=f"{__name__}:{DecisionEnv.__name__}")
