"""What an experiment consists of, what it refuses, and the runs that it comes down to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from rmfs_commands.experiments import Axis, AxisPoint, Base, Experiment, RuleSetChoice
from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario


def points(key: str, *values: Any) -> tuple[AxisPoint, ...]:
    """Return the points of an axis that is a scenario key."""
    return tuple(AxisPoint(f"{key}={value}", value, {key: value}) for value in values)


@pytest.fixture
def one(folder: Path) -> Experiment:
    """Return an experiment of two instances, two rule sets and two seeds."""
    return Experiment(
        name="trial",
        bases=(Base("tiny", load_scenario(folder / "tiny.toml")),),
        rule_sets=(RuleSetChoice("plain"), RuleSetChoice("other", {"rules.poa": "first-come"})),
        seeds=(3, 5),
        baseline="plain",
        axes=(Axis("instance.orders", points("instance.orders", 4, 6)),),
        folder=str(folder),
        place="trial.toml",
    )


def test_every_combination_is_a_run(one: Experiment) -> None:
    """By instance, rule set and seed; each has its own scenario, with the axis, the rules and the seed."""
    jobs = one.jobs()
    assert [(job.instance, job.rule_set, job.seed) for job in jobs] == [
        (f"instance.orders={orders}", rule_set, seed)
        for orders in (4, 6)
        for rule_set in ("plain", "other")
        for seed in (3, 5)
    ]
    last = jobs[-1]
    assert (last.scenario.instance.orders, last.scenario.seed) == (6, 5)
    assert last.scenario.rules.poa is not None
    assert last.scenario.rules.poa.rule == "first-come"
    assert last.axes == {"scenario": "tiny", "instance.orders": 6}
    assert str(last) == "instance.orders=6, other, seed 5"
    assert len({job.key for job in jobs}) == len(jobs)


def test_an_instance_is_called_by_what_tells_it_apart(one: Experiment) -> None:
    """By its base where there are several, or nothing else; by its axis values where there is one."""
    base = one.bases[0]
    two = (base, evolve(base, name="again"))
    assert {job.instance for job in evolve(one, axes=()).jobs()} == {"tiny"}
    assert {
        job.instance for job in evolve(one, bases=two, axes=(Axis("robots.count", points("robots.count", 1)),)).jobs()
    } == {
        "tiny, robots.count=1",
        "again, robots.count=1",
    }


def test_equal_runs_have_equal_keys(one: Experiment) -> None:
    """Whatever their rule set is called."""
    same = evolve(one, rule_sets=(*one.rule_sets, RuleSetChoice("again", {"rules.poa": "first-come"})))
    keys = {name: [job.key for job in same.jobs() if job.rule_set == name] for name in ("plain", "other", "again")}
    assert keys["other"] == keys["again"] != keys["plain"]


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"seeds": ()}, "seeds: expected at least one, found none"),
        ({"seeds": (1, 2, 1)}, "seeds: 1 is there twice; expected different ones"),
        ({"metrics": ("picks", "picks")}, "metrics: picks is there twice; expected different ones"),
        ({"bases": ()}, "scenarios: expected at least one, found none"),
        ({"baseline": "plan"}, 'baseline: there is no rule set "plan" (did you mean `plain`?)'),
        ({"by": ("instance.order",)}, 'by: there is no axis "instance.order" (did you mean `instance.orders`?)'),
        ({"axes": (Axis("robots.count", ()),)}, "axes.robots.count: expected at least one, found none"),
        (
            {"axes": (Axis("seed", points("robots.count", 1)),)},
            "axes.seed: the table has another column of that name; expected another one",
        ),
        (
            {"axes": (Axis("pile_on", points("robots.count", 1)),)},
            "axes.pile_on: the table has another column of that name; expected another one",
        ),
        (
            {"axes": (Axis("a", points("robots.count", 1)), Axis("b", points("robots.count", 2)))},
            "axes.b: sets `robots.count`, which axis a sets too",
        ),
        (
            {"axes": (Axis("a", points("rules.poa", "first-come")),)},
            'rule_sets: "other" sets `rules.poa`, which is an axis; leave one of them out',
        ),
    ],
)
def test_what_is_missing_or_there_twice_is_refused(one: Experiment, changes: dict[str, Any], problem: str) -> None:
    """One sentence with the key."""
    with pytest.raises(InputError) as caught:
        evolve(one, **changes)
    assert str(caught.value) == problem


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"rules.poa": "fist-come"}, 'there is no rule "fist-come"'),
        ({"robots.count": 0}, "robots.count"),
        ({"robots.cont": 1}, "unknown key"),
    ],
)
def test_a_rule_set_that_makes_no_scenario_is_named(one: Experiment, changes: dict[str, Any], problem: str) -> None:
    """With the instance."""
    wrong = evolve(one, rule_sets=(RuleSetChoice("plain"), RuleSetChoice("wrong", changes)))
    with pytest.raises(InputError) as caught:
        wrong.jobs()
    assert 'trial.toml, rule set "wrong" on instance.orders=4' in str(caught.value)
    assert problem in str(caught.value)


def test_a_metric_that_nobody_measures_is_named(one: Experiment) -> None:
    """What a run is labelled with is none either."""
    with pytest.raises(
        InputError, match=r'^trial.toml, metrics: there is no metric "pileon" \(did you mean `pile_on`\?\)'
    ):
        evolve(one, metrics=("pileon",)).jobs()
    with pytest.raises(InputError, match=r'^--most psv=3: there is no metric "psv" \(did you mean `psv_per_order`\?\)'):
        evolve(one, metrics=("psv",), metrics_place="--most psv=3").jobs()
    with pytest.raises(InputError, match=r'there is no metric "run_s"'):
        evolve(one, metrics=("run_s",)).check_metrics(["run_s", "picks"])
    evolve(one, metrics=("own",)).check_metrics(["own"])


def test_files_that_code_is_loaded_from_are_named(one: Experiment, folder: Path) -> None:
    """Of rule sets, axes and lists, each once; installed rules are in none. They can be refused."""
    assert one.rule_files() == []
    loads = evolve(
        one,
        axes=(Axis("r", points("rules.pr", "./bad.py:Raising", "nearest")),),
        rule_sets=(
            RuleSetChoice("plain", {"rules.filters": ["./filters.py:A", {"rule": "./filters.py:B"}]}),
            RuleSetChoice("other", {"rules.poa": {"rule": "first-come"}}),
        ),
    )
    assert loads.rule_files() == [str(folder / "bad.py"), str(folder / "filters.py")]
    with pytest.raises(InputError, match="--no-inline-rules"):
        evolve(loads, rule_sets=one.rule_sets).jobs(allow_inline_rules=False)
