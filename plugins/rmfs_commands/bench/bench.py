"""Running rules in the same worlds, and what each run measured."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from attrs import evolve, frozen

from rmfs_commands.bench.worlds import keys_of, world_with
from rmfs_commands.cli.single_rule import load_rule
from rmfs_core import run
from rmfs_core.errors import InputError, RunError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice, Scenario

ROLES = tuple(role for role in Role if role is not Role.OBSERVER)
QUALITY = {
    "psv_per_order": "Visits\n/order",
    "pile_on": "Pile-on",
    "distance_per_order_m": "Metres\n/order",
    "turnover_s": "Turn-over\n(s)",
}
"""The metrics by which rules are compared, from `rmfs_commands.details.catalogue`, and their headings."""

WARM_UP_ORDERS, WARM_UP_S = 8, 300.0


@frozen
class Contestant:
    """A rule that takes part.

    Parameters
    ----------
    text
        As it was named.
    choice
        The rule and its parameters.
    role
        The role it plays.
    distribution, version
        Where it comes from.
    """

    text: str
    choice: RuleChoice
    role: Role
    distribution: str
    version: str

    @property
    def decides(self) -> str:
        """Its decisions, for people."""
        return self.role.label

    @property
    def field(self) -> str:
        """Role in which it is compared: a joint rule replaces a POA and a PPS rule, so it competes with POA rules."""
        return "POA, POA+PPS" if self.role.assigns else self.decides


@frozen
class Measured:
    """One run of a rule in a world.

    Parameters
    ----------
    rule, decides, world, seed
        Which run.
    status
        ``"complete"``, ``"horizon"``, ``"partial"`` or ``"failed"``.
    metrics
        The metrics of `QUALITY` by name; the same each time. None where nothing was completed.
    calls, seconds
        How often the rule was asked, and the wall-clock seconds that took; they differ from time to time.
    error
        Why the run failed.
    """

    rule: str
    decides: str
    world: str
    seed: int
    status: str
    metrics: dict[str, float | None]
    calls: int
    seconds: float
    error: str | None = None


def contestant(text: str, choice: RuleChoice, *, decides: Role | None = None, allow_inline: bool = True) -> Contestant:
    """Return a rule that is to take part, checked.

    Parameters
    ----------
    text
        Its name.
    choice
        The rule and its parameters.
    decides
        Role in which to compare a rule that decides several things.
    allow_inline
        Whether rules may be loaded from files.

    Raises
    ------
    InputError
        When there is no such rule, a parameter is wrong, or it decides several things and none is named.
    """
    rule = load_rule(choice, ROLES, allow_inline=allow_inline, preferred=decides)
    return Contestant(text, choice, rule.role, rule.source.distribution, rule.source.version)


def bench(
    contestants: Sequence[Contestant],
    worlds: Sequence[str],
    seeds: Sequence[int],
    *,
    overrides: Sequence[str] = (),
    allow_inline: bool = True,
    before: Callable[[str], None] = lambda _: None,
) -> Iterator[Measured]:
    """Run every rule in every world with every seed, one after another.

    Each rule runs once unmeasured before its turn in a world, in a cut-down version of it, so that importing, compiling
    and filling tables of driving times is not counted.

    Parameters
    ----------
    contestants
        The rules.
    worlds
        Names from `rmfs_commands.bench.WORLDS`, or scenarios.
    seeds
        Seeds: the same orders, pods and robots for all rules.
    overrides
        Change the worlds: ``instance.orders=50``.
    allow_inline
        Whether rules may be loaded from files.
    before
        Told what is about to run.

    Raises
    ------
    InputError
        When a world lacks what a rule needs, or an override names a rule for what all of them decide.
    KeyboardInterrupt
        When one ended a run.
    """
    _check_used(overrides, contestants)
    for world in worlds:
        for one in contestants:
            scenario = world_with(world, one.role, one.choice, overrides)
            _measure(one, world, _cut_down(scenario), allow_inline)
            for seed in seeds:
                before(f"{world}: {one.text}, seed {seed}")
                yield _measure(one, world, scenario.with_seed(seed), allow_inline)


def _cut_down(scenario: Scenario) -> Scenario:
    """Return a world with a few orders; with less time where a file names them."""
    if scenario.instance.orders_file is not None:
        until_s = min(scenario.run.until_s or WARM_UP_S, WARM_UP_S)
        return evolve(scenario, run=evolve(scenario.run, until_s=until_s))
    few = min(WARM_UP_ORDERS, scenario.instance.orders)
    return evolve(scenario, instance=evolve(scenario.instance, orders=few))


def _check_used(overrides: Sequence[str], contestants: Sequence[Contestant]) -> None:
    """Raise InputError for an override that no run would show."""
    replaced = set.intersection(*(set(keys_of(one.role)) for one in contestants))
    for override in overrides:
        section, role, *_ = [*override.partition("=")[0].strip().split("."), ""]
        if section == "rules" and role in replaced:
            raise InputError(
                f"--set {override}",
                f"every rule that is compared replaces `rules.{role}`; expected a rule for another decision",
            )


def _measure(one: Contestant, world: str, scenario: Scenario, allow_inline: bool) -> Measured:
    error = None
    try:
        result = run(scenario, allow_inline_rules=allow_inline)
    except RunError as problem:
        if problem.result is None:
            raise
        error, result = str(problem), problem.result
    if result.interrupted:
        raise KeyboardInterrupt
    hook = one.role.hook
    metrics: dict[str, Any] = {name: result.metrics[name] for name in QUALITY}
    return Measured(
        rule=one.text,
        decides=one.decides,
        world=world,
        seed=scenario.seed,
        status=result.status,
        metrics=metrics,
        calls=result.hook_calls.get(hook, 0),
        seconds=result.timing["hook_s"].get(hook, 0.0),
        error=error,
    )
