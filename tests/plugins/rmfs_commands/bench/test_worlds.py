"""Worlds of benchmarks: what is compared plays its role, and everything else is the same for all."""

from __future__ import annotations

from pathlib import Path

import pytest

from rmfs_commands.bench.worlds import FIXED, WORLDS, keys_of, world_with
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice, load_scenario


def names(world: str, role: Role, *overrides: str) -> dict[str, object]:
    """Return the rules of a world by key, with a rule called ``new`` in a role."""
    rules = world_with(world, role, RuleChoice("new"), overrides).rules
    found = {
        key: getattr(rules, key)
        for key in (*PLAIN, "roa", "rps", "roa_rps")
        if getattr(rules, key) is not None or key in PLAIN
    }
    return {
        key: choice.rule if isinstance(choice, RuleChoice) else [one.rule for one in choice] if choice else choice
        for key, choice in found.items()
    }


PLAIN = {
    "poa": "pod-match",
    "pps": "demand",
    "poa_pps": None,
    "pr": "nearest",
    "ta": "nearest-robot",
    "pp": "free-flow",
    "filters": (),
}


@pytest.mark.parametrize(
    ("role", "changed"),
    [
        (Role.POA, {"poa": "new"}),
        (Role.PPS, {"pps": "new"}),
        (Role.PR, {"pr": "new"}),
        (Role.TA, {"ta": "new"}),
        (Role.PP, {"pp": "new"}),
        (Role.FILTER, {"filters": ["new"]}),
        (Role.POA_PPS, {"poa_pps": "new", "poa": None, "pps": None}),
    ],
)
def test_a_rule_takes_its_place_and_no_other(role: Role, changed: dict[str, object]) -> None:
    """A joint rule takes two."""
    assert names("small", role) == PLAIN | changed
    assert set(keys_of(role)) == {key for key in changed if key in PLAIN}
    assert keys_of(role)[0] == role.key


@pytest.mark.parametrize(
    ("role", "changed"),
    [
        (Role.ROA, {"roa": "new", "rps": "emptiest-pod"}),
        (Role.RPS, {"roa": "first-bundle", "rps": "new"}),
        (Role.ROA_RPS, {"roa_rps": "new"}),
    ],
)
def test_a_rule_for_bundles_has_bundles_to_decide_about(role: Role, changed: dict[str, object]) -> None:
    """Its world is replenished, as no other is; the user may change how."""
    assert names("small", role) == PLAIN | changed
    assert keys_of(role)[0] == role.key
    scenario = world_with("small", role, RuleChoice("new"), ["instance.replenishment.lead_s=60"])
    assert scenario.instance.replenishment is not None
    assert (scenario.instance.replenishment.process, scenario.instance.replenishment.lead_s) == ("reorder-point", 60)
    assert world_with("small", Role.POA, RuleChoice("new")).instance.replenishment is None


@pytest.mark.parametrize("world", WORLDS)
def test_a_world_is_its_scenario_with_fixed_rules(world: str) -> None:
    """Layout, robots, stations, orders and pods are those of the shipped scenario; no filter of it is left."""
    given, made = load_scenario(WORLDS[world]), world_with(world, Role.POA, RuleChoice("new"))
    assert (made.instance, made.layout, made.robots, made.stations) == (
        given.instance,
        given.layout,
        given.robots,
        given.stations,
    )
    assert names(world, Role.POA) == PLAIN | {"poa": "new"}
    assert FIXED.keys() == {Role.POA, Role.PPS, Role.PR, Role.TA, Role.PP}


def test_overrides_change_the_world_or_a_fixed_rule() -> None:
    """As `--set` of `rmfs run`; a wrong one is refused."""
    scenario = world_with("small", Role.POA, RuleChoice("new"), ["instance.orders=3", "rules.pp=sipp"])
    assert (scenario.instance.orders, scenario.rules.pp) == (3, RuleChoice("sipp"))
    with pytest.raises(InputError, match="unknown key"):
        world_with("small", Role.POA, RuleChoice("new"), ["instance.order=3"])


def test_rules_from_files_are_looked_up_where_the_command_is_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not beside the shipped scenario."""
    monkeypatch.chdir(tmp_path)
    assert Path(world_with("small", Role.POA, RuleChoice("./mine.py:Mine")).folder) == tmp_path
