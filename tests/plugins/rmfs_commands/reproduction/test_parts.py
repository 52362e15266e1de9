"""The parts of a reproduction and their experiments."""

import pytest

from rmfs_commands.reproduction.extensions import PREFILTER, prefiltered
from rmfs_commands.reproduction.instance_sets import METHODS, SIX_ORDERS
from rmfs_commands.reproduction.parts import PARTS, choose_parts, experiment_of
from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario

RUNS = {"examples": 5, "instances": 1200, "packing": 240, "prefilter": 880, "large": 320}


def test_runs_of_each_part(jobs) -> None:
    """24 instances x 5 rule sets x 10 seeds, and so on; all runs of a part differ."""
    assert {part: len(found) for part, found in jobs.items()} == RUNS
    assert {part: len({job.key for job in found}) for part, found in jobs.items()} == RUNS


def test_rule_sets_are_those_the_tables_look_for() -> None:
    """Names in the shipped files are names in the code."""
    names = {part.name: [rule_set.name for rule_set in experiment_of(part).rule_sets] for part in PARTS}
    assert names["large"] == list(METHODS)
    assert sorted(names["instances"]) == sorted([*METHODS, SIX_ORDERS])
    assert names["packing"] == ["sequential", "split-among-stations", "packing-10"]
    assert names["prefilter"] == ["sequential", "split-among-stations", *map(prefiltered, PREFILTER)]


def test_parts_share_runs(jobs) -> None:
    """What packing and prefilter are compared with is computed once, for the 24 instances."""
    keys = {part: {job.key for job in found} for part, found in jobs.items()}
    assert len(keys["packing"] & keys["instances"]) == 160
    assert len(keys["prefilter"] & keys["instances"]) == 160


def test_rules_are_those_of_the_shipped_scenarios(jobs) -> None:
    """The four methods on 100 SKUs, 100 pods and alpha 3 are the scenarios paper-250-* and paper-2000-*."""
    for base, part, instance in (
        ("paper-250", "instances", "orders=250, skus=100, pods=100, skus_per_pod=3"),
        ("paper-2000", "large", "skus=100, pods=100, skus_per_pod=3"),
    ):
        ours = {job.rule_set: job.scenario for job in jobs[part] if job.instance == instance and job.seed == 1}
        for method in METHODS:
            name = base if method == "sequential" else f"{base}-{method}"
            assert ours[method] == load_scenario(name)


def test_quick_is_one_seed_of_the_smallest_set() -> None:
    """Eight instances of 50 orders under five rule sets, and the five examples."""
    parts = choose_parts(quick=True)
    jobs = {part.name: experiment_of(part, quick=True).jobs() for part in parts}
    assert {name: len(found) for name, found in jobs.items()} == {"examples": 5, "instances": 40}
    assert {job.scenario.instance.orders for job in jobs["instances"]} == {50}


def test_parts_in_their_order() -> None:
    """Whatever the order on the command line; all without names."""
    assert [part.name for part in choose_parts(("large", "packing"))] == ["packing", "large"]
    assert choose_parts() == list(PARTS)


@pytest.mark.parametrize(
    ("only", "quick", "message"),
    [
        (("larg",), False, 'there is no part "larg" .did you mean `large`'),
        (("large",), True, "large has no part in --quick, which is examples and instances"),
    ],
)
def test_wrong_parts(only: tuple[str, ...], quick: bool, message: str) -> None:
    """Misspelt, or not in a quick reproduction."""
    with pytest.raises(InputError, match=message):
        choose_parts(only, quick)
