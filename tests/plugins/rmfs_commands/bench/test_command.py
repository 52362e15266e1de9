"""``rmfs bench``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.bench import worlds
from rmfs_commands.bench.command import ROLES, WORLDS
from rmfs_commands.cli.main import main

FEW = ("--set", "instance.orders=10", "--world", "small")
RULES = """
@define
class Nothing:
    "POA: assigns nothing, so the run stands still."

    @hookimpl
    def assign_orders(self, warehouse):
        return []


INTERRUPTS = iter([KeyboardInterrupt])


@define
class Interrupted:
    "POA: somebody presses Ctrl-C while it thinks for the first time."

    @hookimpl
    def assign_orders(self, warehouse):
        for interrupt in INTERRUPTS:
            raise interrupt
        return []


@define
class Endless(Nothing):
    "POA: needs unlimited stock."

    needs = ("unlimited stock",)


@define
class Both:
    "POA and PPS: the first of everything."

    @hookimpl
    def assign_orders(self, warehouse):
        return assign_best_pairs(warehouse, lambda _: np.zeros(len(warehouse.backlog), dtype=np.int64))

    @hookimpl
    def select_pods(self, warehouse, max_fetches):
        return send_pods(warehouse, max_fetches, lambda station, pods: pods[0])
"""


def bench(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Run rules against each other: exit code, output with blanks drawn together, errors."""
    code = 0
    try:
        main(["bench", *arguments])
    except SystemExit as stop:
        code = int(stop.code or 0)
    out, err = capsys.readouterr()
    return code, "\n".join(" ".join(line.split()) for line in out.splitlines()), err


@pytest.fixture
def acme(install: Any) -> None:
    """Install the rules above, as another distribution."""
    head = "import numpy as np\nfrom rmfs_core.rule_helpers import assign_best_pairs, send_pods\n"
    names = {name.lower(): f"acme_rules:{name}" for name in ("Nothing", "Interrupted", "Endless", "Both")}
    install("acme", names, acme_rules=head + RULES)


def test_what_can_be_chosen() -> None:
    """The command offers the worlds that there are, and rules of every decision."""
    assert tuple(worlds.WORLDS) == WORLDS
    robots_and_orders = ["POA", "PPS", "POA+PPS", "PR", "TA", "PP"]
    others = ["ROA", "RPS", "ROA+RPS", "activation", "idle", "repositioning", "filter"]
    assert [role.label for role in ROLES] == [*robots_and_orders, *others]


def test_side_by_side(capsys: pytest.CaptureFixture[str]) -> None:
    """Rules that decide the same share a table; its figures are the means of those of the runs."""
    asked = ("first-come", "two-stage", "nearest-pod", *FEW, "--seed", "1", "--seed", "2")
    code, out, _ = bench(capsys, *asked)
    assert code == 0
    assert "POA, POA+PPS in world small, mean over seeds 1, 2" in out
    assert "PPS in world small, mean over seeds 1, 2" in out
    code, machines, _ = bench(capsys, *asked, "--json")
    assert code == 0
    content = json.loads(machines)
    assert (content["format"], content["version"]) == ("rmfs-bench", 1)
    runs = content["runs"]
    assert [(run["rule"], run["seed"]) for run in runs] == [(rule, seed) for rule in asked[:3] for seed in (1, 2)]
    assert all(run["calls"] > 0 and run["seconds"] > 0 and run["status"] == "complete" for run in runs)
    visits = (runs[0]["metrics"]["psv_per_order"] + runs[1]["metrics"]["psv_per_order"]) / 2
    assert next(line for line in out.splitlines() if line.startswith("first-come")).split()[1] == f"{visits:.2f}"


def test_the_others_are_fixed(capsys: pytest.CaptureFixture[str]) -> None:
    """A run of the bench is the run of the scenario with the fixed rules and the one that is compared."""
    _, machines, _ = bench(capsys, "nearest-pod", *FEW, "--seed", "3", "--json")
    fixed = ("poa=pod-match", "pps=nearest-pod", "pr=nearest", "ta=nearest-robot", "pp=free-flow")
    overrides = ["instance.orders=10", *(f"rules.{rule}" for rule in fixed)]
    result = rmfs_core.run("examples/small", seed=3, overrides=overrides)
    (run,) = json.loads(machines)["runs"]
    assert run["metrics"] == {name: result.metrics[name] for name in run["metrics"]}


@pytest.mark.parametrize("width", [80, 140])
def test_long_names_of_rules_are_whole(
    width: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 80 columns a name that has no room beside the figures stands above them."""
    monkeypatch.setenv("COLUMNS", str(width))
    name = '{ rule = "most-covered", n = 3 }'
    code, out, _ = bench(capsys, name, *FEW, "--seed", "1")
    assert code == 0
    assert max(map(len, out.splitlines())) <= width
    assert sum(line.strip().startswith(name) for line in out.splitlines()) == 1


@pytest.mark.parametrize(
    ("rule", "field"),
    [("fixed", "PR"), ("balanced", "TA"), ("sipp", "PP"), ('{ rule = "most-covered", n = 2 }', "filter")],
)
def test_every_kind_of_rule(capsys: pytest.CaptureFixture[str], rule: str, field: str) -> None:
    """Rules of every decision can be measured, with parameters."""
    code, out, _ = bench(capsys, rule, *FEW, "--seed", "1")
    assert code == 0
    assert f"{field} in world small, seed 1" in out


def test_rules_of_other_distributions(acme: None, capsys: pytest.CaptureFixture[str]) -> None:
    """Any installed distribution's rules take part; one that decides several things is told in what."""
    code, out, _ = bench(capsys, "both", "pod-match", "--decides", "POA", *FEW, "--seed", "1")
    assert code == 0
    assert sum(line.startswith(("both", "pod-match")) for line in out.splitlines()) == 2
    code, _, err = bench(capsys, "both", *FEW)
    assert code == 2
    assert "decides POA and PPS; say which of them is asked" in err


def test_a_run_that_fails(acme: None, capsys: pytest.CaptureFixture[str]) -> None:
    """The other rules' figures are shown all the same; exit code 1, and what went wrong."""
    code, out, err = bench(capsys, "nothing", "first-come", *FEW, "--seed", "1")
    assert code == 1
    assert "nothing 1 of 1 failed - - -" in out
    assert next(line for line in out.splitlines() if line.startswith("first-come")).count("-") == 1
    assert "nothing, small, seed 1 failed: The run stands still" in err


def test_an_interrupt_ends_it(acme: None, capsys: pytest.CaptureFixture[str]) -> None:
    """At once, in the run that warms a rule up, too: no further run, exit code 130."""
    code, out, err = bench(capsys, "interrupted", "first-come", *FEW)
    assert (code, out) == (130, "")
    assert "Interrupted." in err


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (("first-comes",), "did you mean `first-come`"),
        (("endless", "--set", "instance.items_per_sku=5"), "needs pods whose SKUs never run out"),
        (("integrated", "--set", "instance.order=5"), "unknown key"),
        (("pod-match", "--set", "rules.poa=first-come"), "takes the place of `rules.poa`"),
        (("pod-match", "--set", "rules.poa.name=first-come"), "takes the place of `rules.poa`"),
        (("integrated", "pod-match", "--set", "rules.poa=first-come"), "takes the place of `rules.poa`"),
        (("demand", "--world", "tiny"), "Invalid value for '--world'"),
        (("./x.py:X", "--no-inline-rules"), "--no-inline-rules refuses"),
        ((), "Missing argument"),
    ],
)
def test_wrong_input(acme: None, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], problem: str) -> None:
    """What is wrong is one sentence; exit code 2."""
    code, out, err = bench(capsys, *arguments)
    assert (code, out) == (2, "")
    assert problem in err


@pytest.mark.parametrize(("name", "row"), [("all.csv", "small,first-come,"), ("all.tex", "& small & first-come &")])
def test_a_table_for_a_paper(name: str, row: str, tmp_path: Path) -> None:
    """Every figure that is shown, in one table, as the file's ending says."""
    main(["bench", "pod-match", "first-come", *FEW, "--seed", "1", "--table", str(tmp_path / name)])
    assert row in (tmp_path / name).read_text(encoding="utf-8")


def test_a_table_in_no_folder_is_refused_before_the_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing is printed then."""
    with pytest.raises(SystemExit) as end:
        main(["bench", "pod-match", *FEW, "--table", str(tmp_path / "none" / "all.csv")])
    assert end.value.code == 2
    said = capsys.readouterr()
    assert "expected a file in a folder that is there" in said.err
    assert said.out == ""


def test_a_table_of_another_kind_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Before anything is run."""
    with pytest.raises(SystemExit) as stop:
        main(["bench", "pod-match", *FEW, "--table", str(tmp_path / "all.xls")])
    assert stop.value.code == 2
    assert "expected a name that ends in .tex or .csv, found all.xls" in capsys.readouterr().err
