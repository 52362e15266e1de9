"""Experiment files: what they may say, and what is said about what they may not."""

from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_commands.experiments import Experiment, load_experiment, shipped_experiments
from rmfs_core.errors import InputError
from rmfs_core.scenario import shipped_scenarios

Write = Callable[..., Experiment]

FULL = """
name = "full"
description = "Everything that a file can say."
scenarios = ["tiny.toml", "examples/small"]
seeds = { first = 5, count = 3 }
baseline = "a"
metrics = ["pile_on", "decision_s_per_order"]
by = ["scenario", "hall"]

[axes]
instance.orders = [4, 5]
"rules.poa" = ["pod-match", { rule = "first-come" }]
hall = [
  { label = "small", "robots.count" = 2, layout.block_rows = 3 },
  { label = "large", robots = { count = 3 }, layout = { block_rows = 4 } },
]

[[rule_sets]]
name = "a"

[[rule_sets]]
name = "b"
"rules.pps" = "nearest-pod"
[rule_sets.rules]
filters = [{ rule = "most-covered", n = 5 }]
pr.rule = "random"
"""


def test_everything_that_a_file_can_say(experiment: Write) -> None:
    """Nested, dotted and quoted keys mean the same; every combination of axes, rule sets and seeds is a run."""
    read = experiment(FULL)
    assert (read.name, read.seeds, read.by) == ("full", (5, 6, 7), ("scenario", "hall"))
    assert [base.name for base in read.bases] == ["tiny", "examples/small"]
    assert [axis.name for axis in read.axes] == ["instance.orders", "rules.poa", "hall"]
    assert read.axes[2].points[0].changes == {"robots.count": 2, "layout.block_rows": 3}
    assert read.axes[2].points[1].changes == {"robots.count": 3, "layout.block_rows": 4}
    assert read.rule_sets[1].changes == {
        "rules.pps": "nearest-pod",
        "rules.filters": [{"rule": "most-covered", "n": 5}],
        "rules.pr": {"rule": "random"},
    }
    jobs = read.jobs()
    assert len(jobs) == 2 * (2 * 2 * 2) * 2 * 3
    last = jobs[-1]
    assert last.instance == 'examples/small, orders=5, poa={ rule = "first-come" }, hall=large'
    assert (last.rule_set, last.seed, last.scenario.seed) == ("b", 7, 7)
    assert last.axes == {
        "scenario": "examples/small",
        "instance.orders": 5,
        "rules.poa": '{ rule = "first-come" }',
        "hall": "large",
    }
    assert (last.scenario.robots.count, last.scenario.layout.block_rows) == (3, 4)
    assert last.scenario.rules.poa is not None
    assert (last.scenario.rules.poa.rule, last.scenario.rules.pr.rule) == ("first-come", "random")


def test_the_name_is_the_files_unless_it_says_otherwise(experiment: Write) -> None:
    """An experiment without a name is called like its file."""
    assert experiment(name="my-trial.toml").name == "my-trial"


def test_lists_of_rules_make_a_rule_set_for_each_choice(experiment: Write) -> None:
    """Named by what differs; other keys, and lists that a scenario has itself, are common to all of them."""
    read = experiment(
        'base = "tiny.toml"\nseeds = [1]\nbaseline = "x"\n[[rule_sets]]\nname = "x"\n'
        '[[rule_sets]]\n[rule_sets.rules]\npoa = ["pod-match", "first-come"]\n'
        'pps = ["demand", { rule = "completes", count_backlog = true }]\nfilters = [{ rule = "most-covered", n = 5 }]\n'
        '[[rule_sets]]\nname = "late"\nrules.pr = ["nearest", "random"]\n'
    )
    assert [one.name for one in read.rule_sets] == [
        "x",
        "pod-match + demand",
        "pod-match + completes (count_backlog = true)",
        "first-come + demand",
        "first-come + completes (count_backlog = true)",
        "late: nearest",
        "late: random",
    ]
    assert read.rule_sets[4].changes == {
        "rules.poa": "first-come",
        "rules.pps": {"rule": "completes", "count_backlog": True},
        "rules.filters": [{"rule": "most-covered", "n": 5}],
    }
    assert len(read.jobs()) == 7


def test_the_quick_part_is_two_seeds_and_the_first_value_of_each_axis(experiment: Write) -> None:
    """All rule sets on every base."""
    quick = experiment(FULL).quick()
    assert quick.seeds == (5, 6)
    assert {(job.axes["instance.orders"], job.axes["hall"]) for job in quick.jobs()} == {(4, "small")}
    assert len(quick.jobs()) == 2 * 2 * 2


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("seeds =", "seedz =", "seedz: unknown key (did you mean `seeds`?)"),
        ("seeds = [1, 2]", "", "seeds: this part is missing"),
        ("seeds = [1, 2]", "seeds = []", "line 3, seeds: expected at least one, found none"),
        ("seeds = [1, 2]", "seeds = [1, 1]", "seeds: 1 is there twice"),
        ("seeds = [1, 2]", "seeds = [1, -2]", "whole numbers >= 0"),
        ("seeds = [1, 2]", 'seeds = ["1"]', "whole numbers >= 0"),
        ("seeds = [1, 2]", "seeds = { first = 1, cuont = 2 }", "{ first = 1, count = 10 }"),
        ("seeds = [1, 2]", "seeds = { first = 1, count = 0 }", "{ first = 1, count = 10 }"),
        ("seeds = [1, 2]", "seeds = { count = 1000000000 }", "at most 100,000 seeds, found 1,000,000,000"),
        ("seeds = [1, 2]", "seeds = 3", "{ first = 1, count = 10 }, found 3"),
        ("seeds = [1, 2]", "seeds = [1, 9223372036854775808]", "whole numbers up to 9223372036854775807, found 92"),
        ("seeds = [1, 2]", "seeds = { first = 9223372036854775807, count = 2 }", "found 9223372036854775808"),
        ('baseline = "pod-match"', "", "baseline: this part is missing"),
        ('baseline = "pod-match"', 'baseline = "pod-mtach"', 'no rule set "pod-mtach" (did you mean `pod-match`?)'),
        ('name = "first-come"', 'name = "pod-match"', "line 7, rule_sets[1]: pod-match is there twice"),
        ('name = "first-come"', "", "expected a `name` in each [[rule_sets]], found none in number 2"),
        ("rules.poa =", "rules.pao =", 'rule set "first-come": unknown key (did you mean `poa`?)'),
        ("rules.poa =", "ruls.poa =", 'rule set "first-come": unknown key (did you mean `rules`?)'),
        ("rules.poa =", "seed = 4\nrules.poa =", 'rule set "first-come": unknown key'),
        ('base = "tiny.toml"', "", "expected either `base`, a scenario, or `scenarios`"),
        ('base = "tiny.toml"', 'base = "tiny.toml"\nscenarios = ["tiny.toml"]', "expected either `base`"),
        ('base = "tiny.toml"', "scenarios = []", "scenarios: expected at least one"),
        ('base = "tiny.toml"', 'base = "papr-250"', "did you mean `paper-250`"),
        ('base = "tiny.toml"', "base = 3", "base: expected a text in quotes, found 3"),
        ("seeds =", 'by = ["orders"]\nseeds =', 'there is no axis "orders"'),
        ("seeds =", 'fronts = "pile_on"\nseeds =', 'fronts: expected a list of pairs of metrics, found "pile_on"'),
        ("seeds =", 'fronts = [["pile_on"]]\nseeds =', "fronts: expected a list of pairs of metrics"),
        (
            "seeds =",
            'fronts = [["pile_on", "pile-on"]]\nseeds =',
            '"pile-on" is not one of `metrics` (did you mean `pile_on`?)',
        ),
        ("seeds =", 'name = "a/b"\nseeds =', "name: expected letters, digits"),
        ("[[rule_sets]]", "[axes]\ninstance.orders = []\n[[rule_sets]]", "axes.instance.orders: expected at least one"),
        ("[[rule_sets]]", "[axes]\ninstance.orders = 4\n[[rule_sets]]", "expected a list of values, found 4"),
        (
            "[[rule_sets]]",
            "[axes]\ninstance.ordres = [4]\n[[rule_sets]]",
            "unknown key (did you mean `orders` or `pods`?)",
        ),
        ("[[rule_sets]]", "[axes]\nsize = [4]\n[[rule_sets]]", "list of tables { label = ..., key = ... }"),
        ("[[rule_sets]]", '[axes]\nsize = [{ "robots.count" = 4 }]\n[[rule_sets]]', "expected a `label`"),
        (
            "[[rule_sets]]",
            '[axes]\nstatus = [{ label = "x", "robots.count" = 4 }]\n[[rule_sets]]',
            "the table has another column of that name",
        ),
        (
            "[[rule_sets]]",
            '[axes]\nrobots.count = [2]\nsize = [{ label = "x", "robots.count" = 4 }]\n[[rule_sets]]',
            "sets `robots.count`, which axis robots.count sets too",
        ),
        (
            "[[rule_sets]]",
            '[axes]\nrules.poa = ["first-come"]\n[[rule_sets]]',
            "which is an axis; leave one of them out",
        ),
        ("[[rule_sets]]", "[axes]\nseed = [1, 2]\n[[rule_sets]]", "axes.seed: seeds are no axis"),
        ("[[rule_sets]]", "[[rule_sets]", "this is no valid TOML"),
    ],
)
def test_mistakes_are_named(experiment: Write, folder: Path, old: str, new: str, problem: str) -> None:
    """One sentence says where the mistake is and what would be right."""
    text = (
        'base = "tiny.toml"\n\nseeds = [1, 2]\nbaseline = "pod-match"\n[[rule_sets]]\nname = "pod-match"\n'
        '[[rule_sets]]\nname = "first-come"\nrules.poa = "first-come"\n'
    )
    assert old in text
    with pytest.raises(InputError) as caught:
        experiment(text.replace(old, new, 1))
    assert str(caught.value).startswith(str(folder / "experiment.toml"))
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("rules", "problem"),
    [
        ('rules.poa = "frist-come"', 'rules.poa: there is no rule "frist-come"'),
        ('rules.poa = { rule = "first-come", speed = 3 }', "speed"),
        ("robots.count = 0", "robots.count: expected a whole number from 1 to 100,000, found 0"),
        ('rules.poa = "./none.py:Rule"', "none.py"),
        ('layout.map_file = "none.txt"', "cannot read"),
        ('rules.poa_pps = "integrated"\nrules.poa = "first-come"', "expected either `poa_pps`"),
        ("robots.count.x = 3", "robots.count: expected a whole number, found { x = 3 }"),
    ],
)
def test_what_makes_no_scenario_is_named_before_anything_runs(experiment: Write, rules: str, problem: str) -> None:
    """A rule set that makes the scenario wrong is an error that names file, rule set, instance and key."""
    read = experiment(
        'base = "tiny.toml"\nseeds = [1]\nbaseline = "a"\n'
        f'[axes]\ninstance.skus = [8]\n[[rule_sets]]\nname = "a"\n[[rule_sets]]\nname = "b"\n{rules}\n'
    )
    with pytest.raises(InputError, match='rule set "b" on skus=8, ') as caught:
        read.jobs()
    assert problem in str(caught.value)


def test_files_that_are_not_there(tmp_path: Path) -> None:
    """A missing file, a folder and a misspelt shipped name are told apart."""
    with pytest.raises(InputError, match="found a folder"):
        load_experiment(tmp_path)
    with pytest.raises(InputError, match="did you mean `small-rules`"):
        load_experiment("smal-rules")


@pytest.mark.parametrize("name", shipped_experiments())
def test_shipped_experiments_are_fit_to_run(name: str) -> None:
    """Every shipped experiment reads, and each of its rule sets makes a scenario on each instance."""
    assert load_experiment(name).jobs()


def test_shipped_experiments_are_no_scenarios() -> None:
    """Experiments do not turn up among the shipped scenarios."""
    assert shipped_experiments()
    assert not any("experiment" in name for name in shipped_scenarios())
