from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rmfs_commands.testing import small_instance
from rmfs_core.errors import RuleError

HEAD = """
import time
from attrs import define
from rmfs_core import JointDecision, Leg, OrderAssignment, Path, PodMove, PodTrip, RobotMove, SolveReport
from rmfs_core import TaskAssignment, hookimpl

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
    "idle": "idle_robots(self, warehouse)",
    "move": "move_pods(self, warehouse, max_moves)",
    "filters": "filter_backlog(self, warehouse, orders)",
}

HOOKS = {role: signature.split("(")[0] for role, signature in SIGNATURES.items()}


def write_rule(folder: Path, role: str, body: str) -> str:
    (folder / "bad.py").write_text(HEAD.format(signature=SIGNATURES[role], body=body), encoding="utf-8")
    return "./bad.py:Bad"


def prepare_bad(tiny_run: Callable[..., Any], folder: Path, role: str, body: str, **options: object) -> Any:
    instance = small_instance(
        {"one": ["a", "b"], "two": ["a", "b", "c"], "late": ["a"]},
        {"p": ["a"], "q": ["b"], "r": ["c"]},
        arrivals_s={"late": 5000},
    )
    name = write_rule(folder, role, body)
    chosen: dict[str, object] = {role: [name] if role == "filters" else name}
    return tiny_run(instance, capacity=2, **chosen, **options)


def what_ends(run: Any, role: str) -> str:
    """Return what was wrong, after rule, distribution, hook and simulated time, which the error names in this form."""
    with pytest.raises(RuleError) as caught:
        run.simulation.run()
    assert run.simulation.status != "complete"
    named = f'rule "./bad.py:Bad" (bad.py inline), {HOOKS[role]}, at {run.simulation.now / 1000:.3f} s: '
    assert str(caught.value).startswith(named)
    return str(caught.value).removeprefix(named)
