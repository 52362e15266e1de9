"""Making environments, where Gymnasium is installed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rmfs_core import InputError, Scenario

if TYPE_CHECKING:
    from rmfs_commands.gym.env import DecisionEnv
    from rmfs_commands.gym.rewards import Reward


def make(
    scenario: Scenario | str | Path,
    decides: str = "PPS",
    *,
    overrides: Sequence[str] = (),
    seed: int | None = None,
    reward: str | Reward = "visits",
    orders_shown: int = 50,
    allow_inline_rules: bool = True,
) -> DecisionEnv:
    """Return a Gymnasium environment: the caller makes one kind of decision, the scenario's rules make all others.

    Parameters
    ----------
    scenario
        A scenario, its file, or the name of a shipped one.
    decides
        The caller's decisions: ``"POA"``, ``"PPS"``, ``"PR"`` or ``"TA"``. The scenario's rule for it is not asked.
    overrides
        ``key=value`` each, replacing values of the file; not for a `Scenario` object (see `attrs.evolve`).
    seed
        Replaces the scenario's seed, which is that of the first episode.
    reward
        ``"visits"`` (minus the pod-station visits), ``"turnover"`` (minus the hours that orders were open) or
        ``"distance"`` (minus the kilometres driven) since the action, or a function of a `Step`.
    orders_shown
        Of how many orders POA chooses: the oldest that fit anywhere.
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
        allow_inline_rules=allow_inline_rules,
    )
