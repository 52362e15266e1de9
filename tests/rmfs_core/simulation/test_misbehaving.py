"""Rules that misbehave in every way: each ends the run with one error that names rule, hook, time and fault."""

from collections.abc import Callable
from pathlib import Path

import pytest

from rmfs_core.errors import InputError, RuleError
from rmfs_core.events import ItemPicked, OrderAssigned
from rmfs_core.scenario.model import RunSection
from rmfs_testing import small_instance

Prepare = Callable[..., "TinyRun"]  # type: ignore[name-defined]  # noqa: F821

HEAD = """
import time
from attrs import define
from rmfs_core import JointDecision, Leg, OrderAssignment, Path, PodTrip, SolveReport, TaskAssignment, hookimpl

@define
class Bad:
    @hookimpl
    def {signature}:
        {body}
"""

SIGNATURES = {
    "poa": "assign_orders(self, warehouse)",
    "pps": "select_pods(self, warehouse, max_fetches)",
    "poa_pps": "assign_orders_and_pods(self, warehouse)",
    "pr": "choose_storage_location(self, warehouse, pod)",
    "ta": "assign_tasks(self, warehouse)",
    "pp": "plan_path(self, warehouse, robot, goal)",
    "filters": "filter_backlog(self, warehouse, orders)",
}
HOOKS = {role: signature.split("(")[0] for role, signature in SIGNATURES.items()}

WRONG = [
    # Whatever the hook: raising, None, a wrong type
    *((role, "raise RuntimeError('no idea')", "raised RuntimeError: no idea (") for role in SIGNATURES),
    *((role, "return None", "returned None; expected ") for role in SIGNATURES if role != "pr"),
    *((role, "return 'pod'", "returned str 'pod'; expected ") for role in SIGNATURES if role != "pr"),
    ("pr", "return None", "named cell None; expected a whole number"),
    ("pr", "return 'pod'", "named cell 'pod'; expected a whole number"),
    # POA
    ("poa", "return [3]", "returned a sequence with int 3 in it; expected OrderAssignment only"),
    ("poa", "return [OrderAssignment(9, 0)]", "named order 9, which does not exist; ids are 0 to 2"),
    ("poa", "return [OrderAssignment('1', 0)]", "named order '1'; expected a whole number"),
    ("poa", "return [OrderAssignment(0, 5)]", "named station 5, which does not exist; ids are 0 to 0"),
    (
        "poa",
        "return [OrderAssignment(1, 0)]",
        "assigned order two (id 1) to station 1 (id 0): it takes 3 items, but only 2 of 2 are free",
    ),
    (
        "poa",
        "return [OrderAssignment(0, 0), OrderAssignment(0, 0)]",
        "assigned order one (id 0) to station 1 (id 0), but the order has no open line left",
    ),
    (
        "poa",
        "return [OrderAssignment(0, 0, skus=(2,))]",
        "assigned SKU id 2 of order one (id 0), which is no open line of it",
    ),
    (
        "poa",
        "return [OrderAssignment(0, 0, skus=())]",
        "assigned SKUs () of order one (id 0); expected one or more, each once",
    ),
    (
        "poa",
        "return [OrderAssignment(2, 0)]",
        "assigned order late (id 2) to station 1 (id 0), but the order was not in the backlog it was shown",
    ),
    ("poa", "return [OrderAssignment(0.0, 0)]", "named order 0.0; expected a whole number"),
    ("poa", "return [OrderAssignment(True, 0)]", "named order True; expected a whole number"),
    (
        "poa",
        "return [OrderAssignment(0, 0, skus=5)]",
        "assigned SKUs 5 of order one (id 0); expected a sequence of ids",
    ),
    ("poa", "return [OrderAssignment(0, 0, skus=(0.0,))]", "named SKU id 0.0; expected a whole number"),
    ("poa", "raise SystemExit(0)", "raised SystemExit: 0 ("),
    # PPS
    ("pps", "return [PodTrip(9, 0)]", "named pod 9, which does not exist; ids are 0 to 2"),
    (
        "pps",
        "return [PodTrip(0, 0), PodTrip(0, 0)]",
        "sent pod p (id 0) to station 1 (id 0), where it already is or is bound for",
    ),
    (
        "pps",
        "return [PodTrip(2, 0)]",
        "sent pod r (id 2) to station 1 (id 0), but it holds no item of any request uncovered there",
    ),
    (
        "pps",
        "return [PodTrip(0, 0), PodTrip(1, 0)] if max_fetches == 1 else []",
        "sent 2 stored pods on their way; at most 1 robots can start",
    ),
    # POA and PPS together
    ("poa_pps", "return []", "returned list []; expected JointDecision"),
    (
        "poa_pps",
        "return JointDecision([OrderAssignment(0, 0)], [])",
        "assigned order one (id 0) to station 1 (id 0), but no pod there or bound for it has an item of SKU id 0 left",
    ),
    ("poa_pps", "return JointDecision([], [PodTrip(0, 7)])", "named station 7, which does not exist; ids are 0 to 0"),
    ("poa_pps", "return JointDecision([OrderAssignment(1, 0)], [PodTrip(0, 0)])", "it takes 3 items, but only 2 of 2"),
    (
        "poa_pps",
        "return JointDecision([], [PodTrip(2, 0)])",
        "sent pod r (id 2) to station 1 (id 0), but it holds no item of any request open there",
    ),
    ("poa_pps", "return JointDecision([], [], report='fine')", "returned str 'fine'; expected SolveReport"),
    ("poa_pps", "return JointDecision([], [], SolveReport('optimal', objective='x'))", "objective is 'x'; expected a"),
    # PR
    ("pr", "return 2.5", "named cell 2.5; expected a whole number"),
    ("pr", "return -1", "stores pod p (id 0) at cell -1, which is not on the grid"),
    ("pr", "return warehouse.stations[0].cell", "which is no storage location"),
    ("pr", "return warehouse.home(warehouse.pods[1])", "which is taken"),
    # TA
    ("ta", "return [TaskAssignment(4, 0)]", "named robot 4, which does not exist; ids are 0 to 0"),
    (
        "ta",
        "return [TaskAssignment(0, 2)]",
        "gave pod r (id 2) to robot 1 (id 0), but the pod does not wait for a robot",
    ),
    ("ta", "return [TaskAssignment(0, 0), TaskAssignment(0, 1)]", "gave pod q (id 1) to robot 1 (id 0), which is busy"),
    # PP
    ("pp", "return Path()", "gave robot 1 (id 0) an empty path to "),
    ("pp", "return Path([Leg(-5)])", "sent robot 1 (id 0) to cell -5, which is not on the grid"),
    ("pp", "return Path([Leg(robot.cell)])", "gave robot 1 (id 0) a leg that waits 0 ticks and goes nowhere"),
    ("pp", "return Path([Leg(robot.cell, 10**14)])", "gave robot 1 (id 0) a leg that waits 100000000000000 ticks"),
    ("pp", "return Path([Leg(robot.cell, 0.5)])", "named wait_ticks 0.5; expected a whole number"),
    ("pp", "return Path([Leg(None)])", "named cell None; expected a whole number"),
    ("pp", "return Path([Leg(robot.cell, 60000)])", "without arriving (run.standstill_s)"),
    ("pp", "return Path([3])", "returned a path with int 3 in it; expected Leg only"),
    ("pp", "return Path([Leg(warehouse.stations[0].cell)])", "gave robot 1 (id 0) an impossible path: "),
    # Filter
    ("filters", "return orders + orders[:1] + (warehouse.orders[0],) + tuple('x')", "in it; expected Order only"),
]


def write_rule(folder: Path, role: str, body: str) -> str:
    """Write an inline rule and return what the scenario calls it."""
    (folder / "bad.py").write_text(HEAD.format(signature=SIGNATURES[role], body=body), encoding="utf-8")
    return "./bad.py:Bad"


def prepare_bad(tiny_run: Prepare, folder: Path, role: str, body: str, **options: object) -> "TinyRun":  # type: ignore[name-defined]  # noqa: F821
    """Prepare a run of three orders in which one rule is bad."""
    instance = small_instance(
        {"one": ["a", "b"], "two": ["a", "b", "c"], "late": ["a"]},
        {"p": ["a"], "q": ["b"], "r": ["c"]},
        arrivals_s={"late": 5000},
    )
    name = write_rule(folder, role, body)
    chosen: dict[str, object] = {role: [name] if role == "filters" else name}
    if "at most 1 robots" in str(options.pop("expected", "")):
        options["robots"] = 1
    return tiny_run(instance, capacity=2, **chosen, **options)


@pytest.mark.parametrize(("role", "body", "message"), WRONG)
def test_a_wrong_decision_ends_the_run_with_its_reason(
    tiny_run: Prepare, tmp_path: Path, role: str, body: str, message: str
) -> None:
    """The error names the rule with its distribution and version, the hook, the simulated time, and what was wrong."""
    run = prepare_bad(tiny_run, tmp_path, role, body)
    with pytest.raises(RuleError) as caught:
        run.simulation.run()
    text = str(caught.value)
    time = f"{run.simulation.now / 1000:.3f} s"
    assert text.startswith(f'rule "./bad.py:Bad" (bad.py inline), {HOOKS[role]}, at {time}: ')
    assert message in text
    assert run.simulation.status != "complete"


def test_observers_are_told_nothing_of_a_decision_that_is_half_impossible(tiny_run: Prepare, tmp_path: Path) -> None:
    """The first assignment was fine, the second not: results know of neither."""
    run = prepare_bad(tiny_run, tmp_path, "poa", "return [OrderAssignment(0, 0), OrderAssignment(99, 0)]")
    with pytest.raises(RuleError, match="named order 99"):
        run.simulation.run()
    assert not run.recorder.of(OrderAssigned)


def test_numpy_integers_are_ids_too(tiny_run: Prepare, tmp_path: Path) -> None:
    """A rule that finds its answer with argmax need not convert it."""
    body = "import numpy as np; return [OrderAssignment(np.int64(o.id), np.int64(0)) for o in warehouse.backlog[:1]]"
    run = prepare_bad(tiny_run, tmp_path, "poa", body)
    with pytest.raises(RuleError, match="it takes 3 items"):  # only because the order is too large
        run.simulation.run()
    assert len(run.recorder.of(OrderAssigned)) >= 1


def test_a_need_that_is_not_met_is_refused(tiny_run: Prepare, tmp_path: Path) -> None:
    """A rule that declares unlimited stock as its need is not run on an instance with finite stock."""
    name = write_rule(tmp_path, "poa", "return []")
    (tmp_path / "bad.py").write_text(
        (tmp_path / "bad.py").read_text().replace("class Bad:", "class Bad:\n    needs = ('unlimited stock',)")
    )
    with pytest.raises(InputError, match=r"rules\.poa: rule .* needs pods whose SKUs never run out, but"):
        tiny_run(small_instance({"1": ["a"]}, {"p": {"a": 3}}), poa=name)


def test_what_was_picked_before_the_error_was_told(tiny_run: Prepare, tmp_path: Path) -> None:
    """A PR rule that fails when the first pod leaves: the items picked before it are known to the observers."""
    run = prepare_bad(tiny_run, tmp_path, "pr", "return 1 / 0")
    with pytest.raises(RuleError, match=r"raised ZeroDivisionError: division by zero \(.*bad\.py, line 10\)"):
        run.simulation.run()
    assert len(run.recorder.of(ItemPicked)) == 1


@pytest.mark.parametrize("role", SIGNATURES)
def test_a_rule_that_takes_too_long_is_named_when_a_limit_is_set(tiny_run: Prepare, tmp_path: Path, role: str) -> None:
    """run.decision_limit_s is checked for each decision; without it nothing depends on the clock."""
    slow = RunSection(decision_limit_s=0.3)
    run = prepare_bad(tiny_run, tmp_path, role, "time.sleep(0.35); return []", run=slow)
    with pytest.raises(
        RuleError, match=rf"{HOOKS[role]}, at \d+\.\d+ s: took \S+ s; the scenario allows run\.decision_l"
    ):
        run.simulation.run()


@pytest.mark.parametrize("role", SIGNATURES)
def test_a_misspelt_hook_is_refused_before_the_run(tiny_run: Prepare, tmp_path: Path, role: str) -> None:
    """A method marked as hook that no hook has the name of: the error names the class and the nearest hook."""
    hook = HOOKS[role]
    (tmp_path / "bad.py").write_text(
        "from attrs import define\nfrom rmfs_core import hookimpl\n@define\nclass Bad:\n"
        f"    @hookimpl\n    def {hook}x(self, warehouse): return []\n",
        encoding="utf-8",
    )
    chosen = {role: ["./bad.py:Bad"] if role == "filters" else "./bad.py:Bad"}
    with pytest.raises(InputError) as caught:
        tiny_run(small_instance({"1": ["a"]}, {"p": ["a"]}), **chosen)
    assert "Bad" in str(caught.value)
    assert f"{hook}x" in str(caught.value)
    assert hook in str(caught.value).replace(f"{hook}x", "")


@pytest.mark.parametrize("hook", ["on_event(self, event)", "run_started(self, run)"])
def test_an_observer_that_raises_is_named(tiny_run: Prepare, tmp_path: Path, hook: str) -> None:
    """Observers cannot decide anything, but they can fail: the run ends with their name."""
    (tmp_path / "bad.py").write_text(
        "from attrs import define\nfrom rmfs_core import hookimpl\n@define\nclass Bad:\n"
        f"    @hookimpl\n    def {hook}: raise RuntimeError('full')\n",
        encoding="utf-8",
    )
    run = tiny_run(small_instance({"1": ["a"]}, {"p": ["a"]}), observers=["./bad.py:Bad"])
    with pytest.raises(RuleError, match=r'rule "\./bad\.py:Bad" .*RuntimeError: full'):
        run.simulation.run()
