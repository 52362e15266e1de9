"""`rmfs tune`: ranges, the search, and what is left of its gain on other seeds."""

import csv
import json
import tomllib
from pathlib import Path
from statistics import fmean
from types import SimpleNamespace
from typing import Any

import pytest
from attrs import evolve

from calling import exit_code
from cases import cases
from rmfs_commands.details.loading import load_result
from rmfs_commands.experiments import Experiment
from rmfs_commands.tuning import searching
from rmfs_commands.tuning.searching import Search, Trial, objectives_of
from rmfs_commands.tuning.space import make_space
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import load_scenario

RULE = '''
from attrs import frozen, field
from attrs.validators import ge, in_, le, and_
from rmfs import hookimpl, OrderAssignment

@frozen
class Slow:
    """Assigns the oldest order that fits, to the best station where `good` is high."""

    good: float = field(default=0.5, validator=and_(ge(0), le(1)))
    level: int = field(default=4, validator=ge(1))
    eager: bool = False
    odd: float = 0.0
    way: str = field(default="up", validator=in_(("up", "down")))

    def __attrs_post_init__(self) -> None:
        if self.good > 0.9 and self.eager:
            raise ValueError("expected less of `good` with `eager`")

    @hookimpl
    def assign_orders(self, warehouse):
        stations = warehouse.stations if self.good > 0.3 else warehouse.stations[-1:]
        for order in warehouse.backlog:
            for station in stations:
                if warehouse.fits(order, station):
                    return [OrderAssignment(order.id, station.id)]
        return []
'''


@pytest.fixture
def scenario(tmp_path: Path) -> Path:
    (tmp_path / "slow.py").write_text(RULE, encoding="utf-8")
    file = tmp_path / "day.toml"
    text = """seed = 3
[instance]
orders = 30
skus = 10
pods = 12
[layout]
stations_east = 2
[robots]
count = 4
[rules]
poa = "./slow.py:Slow"
pps = "demand"
"""
    file.write_text(text, encoding="utf-8")
    return file


def space_of(file: Path, searched: tuple[str, ...] = (), given: tuple[str, ...] = ()) -> Any:
    scenario = load_scenario(file)
    return make_space(RuleSet.load(scenario.rules, scenario.folder), scenario.rules, searched, given)


def test_ranges_that_are_known(scenario: Path) -> None:
    """A share is searched from 0 to 1, a positive number around its value, what is listed as it is; 0 tells nothing."""
    space = space_of(scenario, ("poa",))
    assert [(one.key, one.shown, one.log) for one in space.parameters] == [
        ("poa.good", "0..1", False),
        ("poa.level", "1..32", True),
        ("poa.eager", "false, true", False),
        ("poa.way", '"up", "down"', False),
    ]
    assert space.left == ("poa.odd",)
    given = space_of(scenario, ("poa",), ("poa.odd=-1..2.5", "poa.level=2,5"))
    assert [one.shown for one in given.parameters] == ["0..1", "2, 5", "false, true", '"up", "down"', "-1..2.5"]
    fragment = given.fragment({"poa.level": 5, "poa.odd": 2.0})
    written = tomllib.loads(fragment)["rules"]
    assert written["poa"] == {"rule": "./slow.py:Slow", "level": 5, "odd": 2.0}
    assert written["pps"] == "demand"


@cases(
    "given said",
    (("--parameter", "poa.good"), "expected RULE.NAME=LOW..HIGH or RULE.NAME=A,B,C"),
    (("--parameter", "poa.godo=0..1", "--runs", "1"), "the rule has no parameter `godo` (did you mean `good`?)"),
    (("--parameter", "pr.x=0..1"), "the rule has no parameter `x`"),
    (
        ("--parameter", "poaa.good=0..1"),
        "of the scenario's rules, poa, pps, pr, ta or pp, found poaa (did you mean `poa`?)",
    ),
    (("--parameter", "poa.good=1..0"), "expected two numbers, the lower one first, found 1..0"),
    (("--parameter", "poa.level=1..2.5"), "expected two whole numbers, the lower one first"),
    (("--parameter", "poa.good=0..2"), "the rule refuses 2.0 for `poa.good`"),
    (("--parameter", "poa.level=0,1"), "the rule refuses 0 for `poa.level`"),
    (("--rules", "poa_pps"), "the scenario's rules, poa, pps, pr, ta or pp, found poa_pps"),
    (("--rules", "pps"), "no parameter has a range"),
    (("--parameter", "poa.good=0-1"), "expected a range such as 0..2, or numbers with commas, found 0-1"),
    ((), "expected --rules or --parameter"),
    (("--parameter", "poa.eager=true,flase"), "expected some of false, true, found true,flase"),
    (("--parameter", "poa.eager=0..1"), "expected some of false, true, found 0..1"),
    (("--parameter", "poa.way=up,don"), 'expected some of "up", "down", found up,don'),
    (("--rules", "poa", "--axis", "instance.skus=5"), "--axis instance.skus=5: expected a list of values, found 5"),
    (("--rules", "poa", "--axis", "instance.skus"), "--axis instance.skus: expected KEY=[A, B], as in"),
    (("--rules", "poa", "--axis", "skus=[5]"), "expected a scenario key"),
    (("--rules", "poa", "--held-back-from", "10"), "found 10; expected seeds apart from the search's, 3 to 10"),
    (("--rules", "poa", "--runs", "79", "--axis", "instance.skus=[8, 9]"), "each on 8 seeds of 2 instances"),
    (
        ("--rules", "poa", "--runs", "39"),
        "--runs: found 39; expected at least 40: the scenario's own values and 4 trials",
    ),
    (("--rules", "poa", "--objective", "decision_s_later"), "expected a metric of the simulation"),
    (("--rules", "poa", "--objective", "turnover=less"), 'there is no metric "turnover"'),
    (("--rules", "poa", "--objective", "periods", "--runs", "1"), "of `periods` is better; expected periods=less or"),
)
def test_what_is_refused(scenario: Path, given: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("tune", str(scenario), *given, "-j", "1", "--out", str(scenario.parent / "out")) == 2
    shown = capsys.readouterr().err
    assert said in " ".join(shown.split())
    assert "Traceback" not in shown


def test_a_search_from_end_to_end(scenario: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It leaves the bad half of a range, goes on after a rule's refusal, and gives the same again without a run."""
    out = scenario.parent / "out"
    call = ("tune", str(scenario), "--set", "rules.poa.good=0.1", "--parameter", "poa.good=0..1", "--parameter")
    call += ("poa.eager=false,true", "--runs", "40", "--seeds", "5", "--held-back", "3", "-j", "1", "--out", str(out))
    assert exit_code(*call) == 0
    capsys.readouterr()
    best = tomllib.loads((out / "tuned.toml").read_text(encoding="utf-8"))["rules"]["poa"]
    assert best["good"] > 0.3
    with (out / "trials.csv").open(encoding="utf-8", newline="") as stream:
        trials = list(csv.DictReader(stream))
    assert sum(int(one["seeds"]) for one in trials) <= 40
    assert trials[0] | {"poa.good": "", "seeds": "5"} == trials[0]
    own = float(trials[0]["turnover_s"])
    for one in trials[1:]:
        refused = float(one["poa.good"]) > 0.9 and one["poa.eager"] == "true"
        assert bool(one["problem"]) == refused
        assert refused or one["seeds"] in ("4", "5")
        if one["seeds"] == "5":
            assert (float(one["turnover_s"]) < own) == (float(one["poa.good"]) > 0.3)
    assert len(list((out / "runs").glob("*/*"))) == sum(int(one["seeds"]) for one in trials) + 6  # none is run twice
    answer = json.loads((out / "answer.json").read_text(encoding="utf-8"))
    after = next(one for one in answer["held_back"] if one["rule_set"] == "tuned")
    assert after["difference"]["mean"] < 0
    assert (out / "report.html").is_file()

    files = {file: file.read_bytes() for file in out.glob("*.*")}
    runs = {file: file.stat().st_mtime_ns for file in (out / "runs").rglob("*") if file.is_file()}
    assert exit_code(*call) == 0
    assert {file: file.read_bytes() for file in out.glob("*.*")} == files
    assert {file: file.stat().st_mtime_ns for file in (out / "runs").rglob("*") if file.is_file()} == runs


def test_a_search_over_instances(scenario: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A figure of a trial is the mean over instances, each of which counts as a run; seeds held back may be others.

    Orders that are left at the horizon are compared as well, and are no objective.
    """
    out = scenario.parent / "out"
    call = ("tune", str(scenario), "--set", "rules.poa.good=0.1", "--parameter", "poa.good=0.5,0.6", "--seeds", "2")
    call += ("--axis", "instance.orders=[9, 30]", "--runs", "20", "--held-back", "3", "--held-back-from", "0")
    assert exit_code(*call, "--set", "run.until_s=800", "-j", "1", "--out", str(out)) == 0
    assert "Backlog at the end" in capsys.readouterr().out
    with (out / "trials.csv").open(encoding="utf-8", newline="") as stream:
        own, *listed = csv.DictReader(stream)
    assert sorted(one["poa.good"] for one in listed) == ["0.5", "0.6"]  # each value of a list once
    runs = [load_result(file.parent) for file in (out / "runs").rglob("result.json")]
    now = [run for run in runs if run.scenario.rules.poa.parameters["good"] == 0.1]
    assert sorted((run.scenario.seed, run.scenario.instance.orders) for run in now) == [
        (seed, orders) for seed in range(5) for orders in (9, 30)
    ]
    searched = [run.metrics["turnover_s"] for run in now if run.scenario.seed >= 3]
    assert float(own["turnover_s"]) == pytest.approx(fmean(searched))


def test_code_that_changes_ends_a_search(
    scenario: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(experiment: Experiment, **_: Any) -> Any:
        own = {"status": "complete", "turnover_s": 9.0}
        other = {"status": "failed", "error": "other code", "error_kind": "VersionError"}
        named = [(one.name, own if one.name == "0" else other) for one in experiment.rule_sets]
        rows = [{"rule_set": name, "seed": seed, **row} for name, row in named for seed in experiment.seeds]
        return SimpleNamespace(rows=rows)

    monkeypatch.setattr(searching, "run_experiment", run)
    out = scenario.parent / "out"
    assert exit_code("tune", str(scenario), "--rules", "poa", "--seeds", "2", "-j", "1", "--out", str(out)) == 1
    assert "Error: other code; the same command goes on" in capsys.readouterr().err
    assert not (out / "tuned.toml").exists()


def test_fronts_and_trials_given_up() -> None:
    """A trial is given up where a finished one is surely better in all objectives; the front has what none beats."""
    nothing: Any = None
    wanted = objectives_of(["turnover_s", "orders_per_hour", "mine=more"])
    assert wanted == {"turnover_s": 1, "orders_per_hour": -1, "mine": -1}
    both = ("turnover_s", "orders_per_hour"), (1, -1)
    search = Search(nothing, "x", nothing, *both, (1, 2, 3, 4), 9, Path(), nothing, nothing, lambda _: None)
    good = Trial(1, {}, [[10.0, 12.0, 14.0, 16.0], [5.0, 5.0, 5.0, 5.0]])
    other = Trial(2, {}, [[8.0, 9.0, 10.0, 11.0], [4.0, 4.0, 4.0, 4.0]])
    beaten = Trial(3, {}, [[11.0, 13.5, 15.0, 17.0], [4.9, 4.8, 4.9, 4.9]])
    unsure = Trial(4, {}, [[30.0, 1.0, 30.0, 1.0], [3.0, 3.0, 3.0, 3.0]])
    partial = Trial(5, {}, [[1.0, 1.0], [9.0, 9.0]])
    assert not search.is_worse(good, good)
    assert search.is_worse(beaten, good)
    assert not search.is_worse(unsure, good)
    assert search.best([good, other, beaten, unsure, partial], 5) == [other, good]
    assert search.best([good, other], 5) == search.best([other, good], 5)


def test_what_is_tried_depends_on_the_sampler_seed(scenario: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def rows(experiment: Experiment, **_: Any) -> Any:
        return SimpleNamespace(
            rows=[{"rule_set": one.name, "seed": 1, "status": "complete", "x": 0.0} for one in experiment.rule_sets]
        )

    monkeypatch.setattr(searching, "run_experiment", rows)
    given, nothing = (load_scenario(scenario), "x", space_of(scenario, ("poa",)), ("x",), (1,), (1,), 5), Any
    search = Search(*given, Path(), nothing, nothing, lambda _: None)
    first, same, another = (
        [trial.values for trial in evolve(search, sampler_seed=seed).trials()] for seed in (1, 1, 2)
    )
    assert len(first) == 5
    assert first == same != another
