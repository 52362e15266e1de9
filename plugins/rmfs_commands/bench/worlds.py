"""The worlds of benchmarks: three sizes, and rules for every decision that is not the one compared."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from attrs import evolve

from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice, Scenario, load_scenario
from rmfs_core.scenario.rulenames import is_inline

WORLDS = {"small": "examples/small", "250": "paper-250", "2000": "paper-2000"}
"""Name of a world to the shipped scenario that has its layout, robots, stations, orders and pods."""

FIXED = {
    Role.POA: "pod-match",
    Role.PPS: "demand",
    Role.PR: "nearest",
    Role.TA: "nearest-robot",
    Role.PP: "free-flow",
}
"""The rule for each decision that is not compared. Robots do not see each other: quick, and the same for all."""

BUNDLES = {Role.ROA: "first-bundle", Role.RPS: "emptiest-pod"}
"""The same for what is decided only where a rule for it is compared."""

REPLENISHED = (
    "instance.items_per_sku=6",
    "instance.pod_capacity=60",
    "instance.replenishment.process=reorder-point",
    "instance.replenishment.reorder_point=20",
    "instance.replenishment.order_up_to=60",
    "instance.replenishment.bundle_items=12",
    "instance.replenishment.lead_s=300",
    "layout.replenishment_west=1",
)
"""Changes in such a world: stock runs out, and is ordered."""


def keys_of(role: Role) -> tuple[str, ...]:
    """Return the keys below ``rules`` that a rule in a role replaces: its own first."""
    return role.key, *(other.key for other in role.excludes if other in FIXED or other in BUNDLES)


def world_with(world: str, role: Role, choice: RuleChoice, overrides: Sequence[str] = ()) -> Scenario:
    """Return a world in which a rule plays its role, and the fixed rules all others.

    For a rule that decides ROA or RPS it is replenished; for one that decides packing it has a packing station.

    Parameters
    ----------
    world
        One of `WORLDS`, with `FIXED` for all other decisions; or a scenario (a file, or the name of a shipped one),
        with its own rules for them.
    role
        Role of the rule; one for POA+PPS replaces two.
    choice
        The rule.
    overrides
        ``key=value`` each, changing the world (``instance.orders=50``) or a fixed rule (``rules.pp=sipp``).
    """
    replenished = role is Role.ROA_RPS or role in BUNDLES
    first, *others = keys_of(role)
    playing: dict[str, Any] = dict.fromkeys(others) | {first: (choice,) if role is Role.FILTER else choice}
    if world not in WORLDS:
        own = load_scenario(world, overrides)
        if is_inline(choice.rule):  # it is looked up where the command is given; what the scenario names, in its folder
            there = evolve(choice, rule=str(Path.cwd() / choice.rule))
            playing[first] = (there,) if role is Role.FILTER else there
        playing = dict.fromkeys(other.key for other in role.excludes) | playing
        if own.rules.poa_pps and role in (Role.POA, Role.PPS):
            playing = {one.key: RuleChoice(FIXED[one]) for one in (Role.POA, Role.PPS)} | playing
        if own.rules.roa is None and role in BUNDLES:
            playing = {one.key: RuleChoice(name) for one, name in BUNDLES.items()} | playing
        return evolve(own, rules=evolve(own.rules, **playing), source=None)
    named = FIXED | BUNDLES if replenished else FIXED
    fixed = [f"rules.{other}={name}" for other, name in named.items()]
    stock = REPLENISHED if replenished else ()
    packed = ["packing={}"] if role in (Role.PACKING, Role.PACKING_TASK) else []
    scenario = load_scenario(WORLDS[world], [*fixed, "rules.filters=[]", *stock, *packed, *overrides])
    rules = evolve(scenario.rules, **playing)
    # Rules from files are looked up where the command is given; the worlds themselves name no files.
    return evolve(scenario, rules=rules, folder=str(Path.cwd()), source=None)
