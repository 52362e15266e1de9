"""Making environments, where Gymnasium is installed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rmfs_core import InputError, Scenario

if TYPE_CHECKING:
    from rmfs_commands.gym.choices import Feature
    from rmfs_commands.gym.env import DecisionEnv
    from rmfs_commands.gym.rewards import Reward


def make(
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
) -> DecisionEnv:
    """Return a Gymnasium environment: the caller makes some kinds of decisions, the scenario's rules make all others.

    Parameters
    ----------
    scenario
        A scenario, its file, or the name of a shipped one.
    decides
        The caller's decisions: ``"POA"``, ``"PPS"``, ``"POA+PPS"``, ``"PR"`` or ``"TA"``, or a list of several, which
        are then asked as the run comes to them. The scenario's rules for them are not asked.
    overrides
        ``key=value`` each, replacing values of the file; not for a `Scenario` object (see `attrs.evolve`).
    seed
        Replaces the scenario's seed, which is that of the first episode.
    reward
        ``"visits"`` (minus the pod-station visits), ``"turnover"`` (minus the hours that orders were open) or
        ``"distance"`` (minus the kilometres driven) since the action, or a function of a `Step`; or a mapping from
        these to weights: their weighted sum.
    orders_shown
        Of how many orders POA and POA+PPS choose: the oldest that fit anywhere.
    pods_shown
        In how many ways POA+PPS can serve an order at a station, each with another pod first.
    may_wait
        Whether the last slot of POA, PPS, POA+PPS and TA stands for waiting; it may be chosen while a robot has a task.
    features
        Features of one's own, in each kind of choice: columns after those of `FEATURES`.
    allow_inline_rules
        Whether code may be loaded from files: rules such as ``./file.py:Class``.

    Raises
    ------
    InputError
        When an argument or the scenario is wrong, or Gymnasium and greenlet are not installed.
    """
    try:
        from rmfs_commands.gym.env import DecisionEnv
    except ImportError as error:
        raise InputError("rmfs.gym", f"needs further packages; expected `pip install 'rmfs[gym]'` ({error})") from error
    return DecisionEnv(
        scenario,
        decides,
        overrides=overrides,
        seed=seed,
        reward=reward,
        orders_shown=orders_shown,
        pods_shown=pods_shown,
        may_wait=may_wait,
        features=features,
        allow_inline_rules=allow_inline_rules,
    )
