"""Experiment files: what they may say, and the runs that they come down to."""

import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from attrs import evolve

from cases import cases
from rmfs_commands.experiments import Experiment, load_experiment, shipped_experiments
from rmfs_commands.experiments.experiment import DEFAULT_METRICS, HORIZON_METRICS, PACKING_METRICS
from rmfs_commands.experiments.resolving import resolve
from rmfs_core.errors import InputError
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario, load_scenario, scenario_from_dict
from tiny import TWO_RULES

Write = Callable[..., Experiment]


def test_a_metric_that_nobody_measures_is_named(experiment: Write, folder: Path) -> None:
    one = experiment()
    place = rf"^{folder}/experiment.toml, metrics"
    with pytest.raises(InputError, match=rf'{place}: there is no metric "pileon" \(did you mean `pile_on`\?\)'):
        evolve(one, metrics=("pileon",)).jobs()
    with pytest.raises(InputError, match=r'^--most psv=3: there is no metric "psv" \(did you mean `psv_per_order`\?\)'):
        evolve(one, metrics=("psv",), metrics_place="--most psv=3").jobs()
    with pytest.raises(InputError, match=r'"depth_s" \(did you mean `mean_depth_s_of_all`\?\)$'):
        evolve(one, metrics=("depth_s",)).check_metrics(["mean_depth_s_of_all", "picks"])
    with pytest.raises(InputError, match=r'there is no metric "run_s"'):
        evolve(one, metrics=("run_s",)).check_metrics(["run_s", "picks"])
    evolve(one, metrics=("own",)).check_metrics(["own"])


def test_files_that_code_is_loaded_from_are_named(experiment: Write, folder: Path) -> None:
    assert experiment().rule_files() == []
    axis = '[axes]\nrules.pr = ["./bad.py:Raising", "nearest"]\n'
    text = TWO_RULES.replace("[[rule_sets]]", f"{axis}[[rule_sets]]", 1)
    loads = experiment(text + 'rules.filters = ["./filters.py:A", { rule = "./filters.py:B" }]\n')
    assert loads.rule_files() == [str(folder / "bad.py"), str(folder / "filters.py")]
    with pytest.raises(InputError, match="--no-inline-rules"):
        loads.jobs(allow_inline_rules=False)


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
instance.parameters.pace_s = [10]
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
"rules.ta.reallocation_s" = 5
[rule_sets.rules]
filters = [{ rule = "most-covered", n = 5 }]
pr.rule = "random"
"""


def test_everything_that_a_file_can_say(experiment: Write) -> None:
    read = experiment(FULL)
    assert (read.name, read.seeds, read.by) == ("full", (5, 6, 7), ("scenario", "hall"))
    assert [base.name for base in read.bases] == ["tiny", "examples/small"]
    assert [axis.name for axis in read.axes] == ["instance.orders", "instance.parameters.pace_s", "rules.poa", "hall"]
    assert read.axes[3].points[0].changes == {"robots.count": 2, "layout.block_rows": 3}
    assert read.axes[3].points[1].changes == {"robots.count": 3, "layout.block_rows": 4}
    assert read.rule_sets[1].changes == {
        "rules.pps": "nearest-pod",
        "rules.filters": [{"rule": "most-covered", "n": 5}],
        "rules.pr": {"rule": "random"},
        "rules.ta.reallocation_s": 5,
    }
    jobs = read.jobs()
    assert len(jobs) == 2 * (2 * 2 * 2) * 2 * 3
    last = jobs[-1]
    assert last.instance == 'examples/small, orders=5, pace_s=10, poa={ rule = "first-come" }, hall=large'
    assert (last.rule_set, last.seed, last.scenario.seed) == ("b", 7, 7)
    assert last.axes == {
        "scenario": "examples/small",
        "instance.orders": 5,
        "instance.parameters.pace_s": 10,
        "rules.poa": '{ rule = "first-come" }',
        "hall": "large",
    }
    assert (last.scenario.robots.count, last.scenario.layout.block_rows) == (3, 4)
    assert (last.scenario.rules.poa.rule, last.scenario.rules.pr.rule) == ("first-come", "random")


DUE_METRICS = ("missed_percent", "cost_per_order")


@cases(
    "more metrics",
    ("", DEFAULT_METRICS),
    ("[axes]\nrun.until_s = [60]\n", HORIZON_METRICS),
    ("[axes]\npacking.packers = [1, 2]\n", (*DEFAULT_METRICS, *PACKING_METRICS)),
    ("[axes]\ninstance.departures.cutoff_s = [60]\ncosts.late_h = [1]\n", (*DEFAULT_METRICS, *DUE_METRICS)),
    ('[axes]\ntimes = [{ label = "short", run.until_s = 60 }]\n', HORIZON_METRICS),
)
def test_metrics_are_those_of_a_horizon_where_an_axis_sets_one(experiment, more, metrics) -> None:
    text = 'base = "tiny.toml"\nseeds = [1]\nbaseline = "a"\n[[rule_sets]]\nname = "a"\n'
    assert experiment(text + more).metrics == metrics


def test_lists_of_rules_make_a_rule_set_for_each_choice(experiment: Write) -> None:
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
    quick = experiment(FULL).quick()
    assert quick.seeds == (5, 6)
    assert {(job.axes["instance.orders"], job.axes["hall"]) for job in quick.jobs()} == {(4, "small")}
    assert len(quick.jobs()) == 2 * 2 * 2


@cases(
    "old new problem",
    ("seeds =", "seedz =", "seedz: unknown key (did you mean `seeds`?)"),
    ("seeds = [1, 2]", "", "seeds: this part is missing"),
    ("seeds = [1, 2]", "seeds = []", "line 3, seeds: expected at least one, found none"),
    ("seeds = [1, 2]", "seeds = [1, 1]", "seeds: found 1 twice"),
    ("seeds = [1, 2]", "seeds = [1, -2]", "whole numbers >= 0"),
    ("seeds = [1, 2]", "seeds = { first = 1, cuont = 2 }", "{ first = 1, count = 10 }"),
    ("seeds = [1, 2]", "seeds = { first = 1, count = 0 }", "{ first = 1, count = 10 }"),
    ("seeds = [1, 2]", "seeds = { count = 1000000000 }", "at most 100,000 seeds, found 1,000,000,000"),
    ("seeds = [1, 2]", "seeds = 3", "{ first = 1, count = 10 }, found 3"),
    ("seeds = [1, 2]", "seeds = [1, 9223372036854775808]", "whole numbers up to 9223372036854775807, found 92"),
    ("seeds = [1, 2]", "seeds = { first = 9223372036854775807, count = 2 }", "found 9223372036854775808"),
    ('baseline = "pod-match"', "", "baseline: this part is missing"),
    ('baseline = "pod-match"', 'baseline = "pod-mtach"', 'no rule set "pod-mtach" (did you mean `pod-match`?)'),
    ('name = "first-come"', 'name = "pod-match"', "line 7, rule_sets[1]: found pod-match twice"),
    ('name = "first-come"', "", "expected a `name` in each [[rule_sets]], found none in number 2"),
    ("rules.poa =", "rules.pao =", 'rule set "first-come": unknown key (did you mean `poa`?)'),
    ('name = "first-come"', 'poa = ["first-come"]', "rule_sets[1].poa: unknown key; expected one of `costs`"),
    ("rules.poa =", "ruls.poa =", 'rule set "first-come": unknown key (did you mean `rules`?)'),
    ('base = "tiny.toml"', "", "expected either `base`, a scenario, or `scenarios`"),
    ('base = "tiny.toml"', 'base = "tiny.toml"\nscenarios = ["tiny.toml"]', "expected either `base`"),
    ('base = "tiny.toml"', "scenarios = []", "scenarios: expected at least one"),
    ('base = "tiny.toml"', 'base = "papr-250"', "did you mean `paper-250`"),
    ('base = "tiny.toml"', "base = 3", "base: expected a text in quotes, found 3"),
    ("seeds =", 'by = ["orders"]\nseeds =', 'there is no axis "orders"'),
    ("seeds =", 'metrics = ["picks", "picks"]\nseeds =', "metrics: found picks twice; expected each once"),
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
    ("[[rule_sets]]", "[axes]\ninstance.ordres = [4]\n[[rule_sets]]", "unknown key (did you mean `orders` or `pods`?)"),
    ("[[rule_sets]]", "[axes]\nsize = [4]\n[[rule_sets]]", "list of tables { label = ..., key = ... }"),
    ("[[rule_sets]]", '[axes]\nsize = [{ "robots.count" = 4 }]\n[[rule_sets]]', "expected a `label`"),
    (
        "[[rule_sets]]",
        '[axes]\nstatus = [{ label = "x", "robots.count" = 4 }]\n[[rule_sets]]',
        "the summary has a column of that name",
    ),
    (
        "[[rule_sets]]",
        '[axes]\nrobots.count = [2]\nsize = [{ label = "x", "robots.count" = 4 }]\n[[rule_sets]]',
        "sets `robots.count`, which axis robots.count sets too",
    ),
    ("[[rule_sets]]", '[axes]\nrules.poa = ["first-come"]\n[[rule_sets]]', "which is an axis; leave one of them out"),
    ("[[rule_sets]]", "[axes]\nseed = [1, 2]\n[[rule_sets]]", "axes.seed: seeds are no axis"),
    ("[[rule_sets]]", "[[rule_sets]", "this is no valid TOML"),
    (
        "rules.poa =",
        '"robots.count" = 4\nrobots = { count = 5 }\nrules.poa =',
        'rule_sets[1].robots.count: rule set "first-come": found this key twice',
    ),
)
def test_mistakes_are_named(experiment: Write, folder: Path, old: str, new: str, problem: str) -> None:
    assert old in TWO_RULES
    with pytest.raises(InputError) as caught:
        experiment(TWO_RULES.replace(old, new, 1))
    assert str(caught.value).startswith(str(folder / "experiment.toml"))
    assert problem in str(caught.value)
    assert "\n" not in str(caught.value)


@cases(
    "rules problem",
    ('rules.poa = "frist-come"', 'rules.poa: there is no rule "frist-come"'),
    ("robots.count = 0", "robots.count: expected a whole number from 1 to 100,000, found 0"),
    ('rules.poa = "./none.py:Rule"', "none.py"),
    ('rules.poa_pps = "integrated"\nrules.poa = "first-come"', "expected either `poa_pps`"),
)
def test_what_makes_no_scenario_is_named_before_anything_runs(experiment: Write, rules: str, problem: str) -> None:
    read = experiment(
        'base = "tiny.toml"\nseeds = [1]\nbaseline = "a"\n'
        f'[axes]\ninstance.skus = [8]\n[[rule_sets]]\nname = "a"\n[[rule_sets]]\nname = "b"\n{rules}\n'
    )
    with pytest.raises(InputError, match='rule set "b" on skus=8, ') as caught:
        read.jobs()
    assert problem in str(caught.value)


def test_files_that_are_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="found a folder"):
        load_experiment(tmp_path)
    with pytest.raises(InputError, match="did you mean `small-rules`"):
        load_experiment("smal-rules")


@pytest.mark.parametrize("name", shipped_experiments())
def test_shipped_experiments_are_fit_to_run(name: str) -> None:
    assert load_experiment(name).jobs()


@pytest.fixture
def tiny(folder: Path) -> Scenario:
    return load_scenario(folder / "tiny.toml")


def test_single_parameters_of_the_bases_rule_can_be_set(tiny: Scenario) -> None:
    one = resolve(tiny, {"rules.ta": {"rule": "balanced", "reallocation_s": 5.0, "help_others": False}}, ".", "test")
    two = resolve(one, {"rules.ta.reallocation_s": 7.0}, ".", "test")
    assert dict(two.rules.ta.parameters) == {"reallocation_s": 7.0, "help_others": False}
    assert not resolve(two, {"rules.ta": "balanced"}, ".", "test").rules.ta.parameters


def test_files_in_two_folders_are_refused(folder: Path) -> None:
    shipped = load_scenario("examples/from-csv")
    with pytest.raises(InputError, match=r"names files in .* and in "):
        resolve(shipped, {"rules.pr": "./bad.py:Raising"}, str(folder), "test")
    begun = resolve(shipped, {"instance.state_file": "s.json"}, str(folder), "test")  # but for a state
    assert (begun.folder, begun.instance.state_file) == (shipped.folder, str((folder / "s.json").resolve()))


def test_keys_that_would_be_ignored_are_refused() -> None:
    with pytest.raises(InputError, match=r"instance.orders: has no effect with `instance.orders_file`"):
        resolve(load_scenario("examples/from-csv"), {"instance.orders": 3}, ".", "test")


def test_files_of_parameters_are_where_they_are_named(folder: Path) -> None:
    """Those of the base beside it, though the scenario's folder is another one; what changes name beside these."""
    (folder / "base").mkdir()
    (folder / "w.txt").write_text("2", encoding="utf-8")
    data = tomllib.loads((folder / "tiny.toml").read_text("utf-8"))
    data["rules"]["observers"] = [{"rule": "seen", "file": "w.txt"}]
    base = scenario_from_dict(data, str(folder / "base"))
    reading = {"rules.pr": {"rule": "./bad.py:Reading", "weights": "w.txt"}}
    scenario = resolve(base, reading, str(folder), "test")
    assert scenario.folder == str(folder)
    assert scenario.rules.observers[0].parameters["file"].there == str(folder / "base")
    loaded = RuleSet.load(evolve(scenario.rules, observers=()), scenario.folder)
    assert [(one.name, one.file) for one in loaded.files] == [("w.txt", folder / "w.txt")]
