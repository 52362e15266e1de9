"""`rmfs bench`: the worlds that are timed, and the report of the times."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import pytest

import rmfs_core
from bad_rules import write_rule
from calling import exit_code, refusal, refused
from cases import cases
from rmfs_commands.bench import command
from rmfs_commands.bench.bench import QUALITY, WARM_UP_ORDERS, bench, contestant
from rmfs_commands.bench.command import ROLES
from rmfs_commands.bench.fixture import rule_benchmark
from rmfs_commands.bench.worlds import FIXED, WORLDS, keys_of, world_with
from rmfs_commands.cli.main import main
from rmfs_commands.details.catalogue import METRICS
from rmfs_core.decisions import PodTrip
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice, RulesSection, load_scenario
from rmfs_rules.demand import Demand

FEW = ["instance.orders=9"]
FIRST = """
        fits = ((o, s) for o in warehouse.backlog for s in warehouse.stations if warehouse.fits(o, s))
        return [OrderAssignment(o.id, s.id) for o, s in fits][:1]
"""
RULES = """
import json
from pathlib import Path
@define
class Counts:
    "PR: the first free location; notes how many orders its run has."
    file: str
    @hookimpl
    def run_started(self, run):
        with Path(self.file).open("a") as file:
            file.write(f"{len(run.instance.orders)} {run.scenario.seed}\\n")
    @hookimpl
    def choose_storage_location(self, warehouse): return min(warehouse.free_storage_locations)
@define
class Both:
    "POA and PPS, and neither well."
    @hookimpl
    def assign_orders(self, warehouse): return []
    @hookimpl
    def select_pods(self, warehouse): return []
@define
class Endless(Both):
    "POA: needs unlimited stock."
    needs = ("unlimited stock",)
"""


@pytest.fixture
def acme(install: Any) -> None:
    names = {name.lower(): f"acme_rules:{name}" for name in ("Counts", "Both", "Endless")}
    install("acme", names, acme_rules=RULES)


def test_a_contestant_says_what_it_decides(acme: None) -> None:
    first, joint, pps = (contestant(name, RuleChoice(name)) for name in ("first-come", "integrated", "demand"))
    assert [(one.role, one.decides, one.field) for one in (first, joint, pps)] == [
        (Role.POA, "POA", "POA, POA+PPS"),
        (Role.POA_PPS, "POA+PPS", "POA, POA+PPS"),
        (Role.PPS, "PPS", "PPS"),
    ]
    assert first.distribution == "rmfs"
    assert contestant("both", RuleChoice("both"), decides=Role.PPS).role is Role.PPS
    with pytest.raises(InputError, match="decides POA and PPS; say which of them is asked"):
        contestant("both", RuleChoice("both"))
    with pytest.raises(InputError, match="window"):
        contestant("whca-n", RuleChoice("whca-n", {"window": 3}))


def test_every_rule_runs_in_every_world_with_every_seed() -> None:
    told: list[str] = []
    rules = [contestant(name, RuleChoice(name)) for name in ("first-come", "pod-match")]
    runs = list(bench(rules, ["small"], [1, 2], overrides=FEW, before=told.append))
    assert [(run.rule, run.world, run.seed, run.status) for run in runs] == [
        (rule, "small", seed, "complete") for rule in ("first-come", "pod-match") for seed in (1, 2)
    ]
    assert told == [f"small: {run.rule}, seed {run.seed}" for run in runs]
    assert all(run.calls > 0 and run.seconds > 0 and run.error is None for run in runs)
    (run,) = bench([contestant("random", RuleChoice("random"), decides=Role.PR)], ["small"], [5], overrides=FEW)
    rules = ("poa=pod-match", "pps=demand", "pr=random", "ta=nearest-robot", "pp=free-flow")
    expected = rmfs_core.run("examples/small", seed=5, overrides=[*FEW, *(f"rules.{rule}" for rule in rules)])
    assert run.metrics == {name: expected.metrics[name] for name in QUALITY}
    assert QUALITY.keys() <= {metric.name for group in METRICS.values() for metric in group}


def test_a_rule_warms_up_in_a_small_copy_of_the_world(acme: None, tmp_path: Path) -> None:
    file = tmp_path / "runs.txt"
    one = contestant("counts", RuleChoice("counts", {"file": str(file)}))
    assert len(list(bench([one], ["small"], [3, 4], overrides=FEW))) == 2
    orders = [line.split() for line in file.read_text().splitlines()]
    assert [int(number) for number, _ in orders] == [WARM_UP_ORDERS, 9, 9]
    assert [seed for _, seed in orders[1:]] == ["3", "4"]


@cases(
    "rules override key",
    (["pod-match", "first-come"], "rules.poa=first-come", "poa"),
    (["integrated"], "rules.pps=demand", "pps"),
    (["integrated", "demand"], "rules.pps.rule=demand", "pps"),
    (["most-covered"], "rules.filters=[]", "filters"),
)
def test_an_override_that_no_run_would_show_is_refused(rules: list[str], override: str, key: str) -> None:
    parameters = {"most-covered": {"n": 2}}
    ones = [contestant(name, RuleChoice(name, parameters.get(name, {}))) for name in rules]
    assert refusal(lambda: list(bench(ones, ["small"], [1], overrides=[override]))) == (
        f"--set {override}: every rule that is compared replaces `rules.{key}`; expected a rule for another decision"
    )


PLAIN = {
    **{"poa": "pod-match", "pps": "demand", "poa_pps": None},
    **{"pr": "nearest", "ta": "nearest-robot", "pp": "free-flow", "filters": []},
}


def names(world: str, role: Role, *overrides: str) -> dict[str, object]:
    return names_of(world_with(world, role, RuleChoice("new"), overrides).rules)


def names_of(rules: RulesSection) -> dict[str, object]:
    chosen = {key: getattr(rules, key) for key in (*PLAIN, "roa", "rps", "roa_rps")}
    return {
        key: [one.rule for one in choice] if isinstance(choice, tuple) else choice and choice.rule
        for key, choice in chosen.items()
        if key in PLAIN or choice is not None
    }


@cases(
    "role changed",
    (Role.POA, {"poa": "new"}),
    (Role.PPS, {"pps": "new"}),
    (Role.PR, {"pr": "new"}),
    (Role.TA, {"ta": "new"}),
    (Role.PP, {"pp": "new"}),
    (Role.FILTER, {"filters": ["new"]}),
    (Role.POA_PPS, {"poa_pps": "new", "poa": None, "pps": None}),
)
def test_a_rule_takes_its_place_and_no_other(role: Role, changed: dict[str, object]) -> None:
    assert names("small", role) == PLAIN | changed
    assert set(keys_of(role)) == {key for key in changed if key in PLAIN}
    assert keys_of(role)[0] == role.key


@cases(
    "role changed",
    (Role.ROA, {"roa": "new", "rps": "emptiest-pod"}),
    (Role.RPS, {"roa": "first-bundle", "rps": "new"}),
    (Role.ROA_RPS, {"roa_rps": "new"}),
)
def test_a_rule_for_bundles_has_bundles_to_decide_about(role: Role, changed: dict[str, object]) -> None:
    assert (names("small", role), keys_of(role)[0]) == (PLAIN | changed, role.key)
    scenario = world_with("small", role, RuleChoice("new"), ["instance.replenishment.lead_s=60"])
    assert (scenario.instance.replenishment.process, scenario.instance.replenishment.lead_s) == ("reorder-point", 60)
    assert world_with("small", Role.POA, RuleChoice("new")).instance.replenishment is None


@pytest.mark.parametrize("world", WORLDS)
def test_a_world_is_its_scenario_with_fixed_rules(world: str) -> None:
    given, made = load_scenario(WORLDS[world]), world_with(world, Role.POA, RuleChoice("new"))
    for section in ("instance", "layout", "robots", "stations"):
        assert getattr(made, section) == getattr(given, section)
    assert names(world, Role.POA) == PLAIN | {"poa": "new"}
    assert FIXED.keys() == {Role.POA, Role.PPS, Role.PR, Role.TA, Role.PP}


def test_a_scenario_of_ones_own_is_a_world_with_its_own_rules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    mine = write_rule(tmp_path, "poa", FIRST)
    shipped = load_scenario("examples/from-csv")
    world = tmp_path / "there" / "world.toml"
    world.parent.mkdir()
    for file in Path(shipped.folder).glob("from-csv*"):
        shutil.copy(file, world.parent)
    text = (world.parent / "from-csv.toml").read_text(encoding="utf-8")
    world.write_text(f"{text}\n[run]\nuntil_s = 60\n", encoding="utf-8")
    assert names(str(world), Role.PR) == names_of(shipped.rules) | {"pr": "new"}
    joint = tmp_path / "joint.toml"
    joint.write_text('[rules]\npoa_pps = "pod-index"\n', encoding="utf-8")
    assert names(str(joint), Role.PPS) == PLAIN | {"pps": "new", "ta": "balanced", "pp": "sipp"}
    assert names(str(world), Role.ROA) == names_of(shipped.rules) | {"roa": "new", "rps": "emptiest-pod"}
    joint.write_text('[rules]\npoa_pps = "pod-index"\nroa_rps = "pod-first"\n', encoding="utf-8")
    assert names(str(joint), Role.RPS).items() >= {"roa": "first-bundle", "rps": "new"}.items()
    one = contestant("mine", RuleChoice(mine))
    (run,) = bench([one], [str(world)], [1])
    assert (run.status, run.world) == ("horizon", str(world))
    assert run.calls > 0


def test_the_fixture_asks_a_rule_in_the_middle_of_a_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """By name and as an object, beside each other; what it answers is the answer of a run."""
    monkeypatch.chdir(tmp_path)

    class Benchmark:
        extra_info: ClassVar[dict[str, Any]] = {}
        group = ""

        def __call__(self, function: Callable[..., Any], **arguments: Any) -> Any:
            assert function(**arguments) == function(**arguments)
            return arguments["warehouse"].now_s, function(**arguments)

    benchmark = Benchmark()
    measure = rule_benchmark.__wrapped__(benchmark)
    now_s, named = measure("demand", decides="PPS", overrides=FEW, at_s=60)
    assert now_s >= 60
    assert all(isinstance(one, PodTrip) for one in named)
    assert measure(Demand(), decides="PPS", overrides=FEW, at_s=60) == (now_s, named)
    assert benchmark.group == "PPS in small"
    with pytest.raises(ValueError, match="no rule is asked for PPS from 90000 s on in the world small; expected less"):
        measure("demand", decides="PPS", overrides=FEW, at_s=90_000)


def test_worlds_and_rules_can_be_chosen() -> None:
    scenario = world_with("small", Role.POA, RuleChoice("new"), ["instance.orders=3", "rules.pp=sipp"])
    assert (scenario.instance.orders, scenario.rules.pp) == (3, RuleChoice("sipp"))
    with pytest.raises(InputError, match="unknown key"):
        world_with("small", Role.POA, RuleChoice("new"), ["instance.order=3"])
    assert tuple(WORLDS) == command.WORLDS
    assert {*Role} - {*ROLES} == {Role.OBSERVER}


SHORT = ("--set", "instance.orders=10", "--world", "small")


def called(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Run rules against each other: exit code, output with blanks drawn together, errors."""
    code = exit_code("bench", *arguments)
    out, err = capsys.readouterr()
    return code, "\n".join(" ".join(line.split()) for line in out.splitlines()), err


def test_side_by_side(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("first-come", "two-stage", "nearest-pod", *SHORT, "--seed", "1", "--seed", "2")
    code, out, _ = called(capsys, *asked)
    assert code == 0
    assert "POA, POA+PPS in world small, mean over seeds 1, 2" in out
    assert "PPS in world small, mean over seeds 1, 2" in out
    code, machines, _ = called(capsys, *asked, "--json")
    assert code == 0
    content = json.loads(machines)
    assert (content["format"], content["version"]) == ("rmfs-bench", 1)
    runs = content["runs"]
    assert [(run["rule"], run["seed"]) for run in runs] == [(rule, seed) for rule in asked[:3] for seed in (1, 2)]
    assert all(run["calls"] > 0 and run["seconds"] > 0 and run["status"] == "complete" for run in runs)
    visits = (runs[0]["metrics"]["psv_per_order"] + runs[1]["metrics"]["psv_per_order"]) / 2
    assert next(line for line in out.splitlines() if line.startswith("first-come")).split()[1] == f"{visits:.2f}"


def test_runs_that_fail_or_are_interrupted(acme: None, tmp_path, monkeypatch, capsys) -> None:
    code, out, err = called(capsys, "both", "first-come", "--decides", "POA", *SHORT, "--seed", "1")
    assert code == 1
    assert "both 1 of 1 failed - - -" in out
    assert next(line for line in out.splitlines() if line.startswith("first-come")).count("-") == 1
    assert "both, small, seed 1 failed: The run stands still" in err
    monkeypatch.chdir(tmp_path)
    code, out, err = called(capsys, write_rule(tmp_path, "poa", "raise KeyboardInterrupt"), "first-come", *SHORT)
    assert (code, out) == (130, "")
    assert "Interrupted." in err


@cases(
    "arguments problem",
    (("first-comes",), "did you mean `first-come`"),
    (("endless", "--decides", "POA", "--set", "instance.items_per_sku=5"), "needs pods whose SKUs never run out"),
    (("pod-match", "--set", "rules.poa=first-come"), "replaces `rules.poa`"),
    (("demand", "--world", "tiny"), "tiny: there is no such file, and no shipped"),
    (("./x.py:X", "--no-inline-rules"), "--no-inline-rules refuses"),
)
def test_wrong_input(acme: None, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], problem: str) -> None:
    assert problem in refused(capsys, main, ["bench", *arguments])


@pytest.mark.parametrize(("name", "row"), [("all.csv", "small,first-come,"), ("all.tex", "& small & first-come &")])
def test_a_table_for_a_paper(name: str, row: str, tmp_path: Path) -> None:
    main(
        ["bench", "pod-match", "first-come", "--decides", "POA", *SHORT, "--seed", "1", "--table", str(tmp_path / name)]
    )
    assert row in (tmp_path / name).read_text(encoding="utf-8")


def test_runs_that_end_at_their_horizon_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Their figures per order are of completed orders: below the table, and in the caption of a paper's."""
    said = "1 of 1 run ended at the horizon (run.until_s) with orders left: visits, metres and turn-over time"
    short, file = (*SHORT, "--seed", "1"), tmp_path / "all.tex"
    _, out, _ = called(capsys, "first-come", *short)
    assert "horizon" not in out
    _, out, _ = called(capsys, "first-come", *short, "--set", "run.until_s=60", "--table", str(file))
    assert said in " ".join(out.split())
    assert said in file.read_text(encoding="utf-8").replace(r"\_", "_")


@cases(
    "table problem",
    ("none/all.csv", "expected a file in a folder that is there"),
    ("all.xls", "expected a name that ends in .tex or .csv, found all.xls"),
)
def test_a_table_that_cannot_be_written_is_refused_before_the_runs(tmp_path, capsys, table, problem) -> None:
    assert problem in refused(capsys, main, ["bench", "pod-match", *SHORT, "--table", str(tmp_path / table)])
