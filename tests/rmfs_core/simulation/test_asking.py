"""Rules that are asked and observers that are told: what they raise ends the run with their name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bad_rules import HOOKS, prepare_bad, what_ends
from rmfs_core.errors import RuleError
from rmfs_core.events import ItemPicked
from rmfs_core.scenario.model import RunSection
from rmfs_testing import small_instance

WHATEVER = [
    *((role, "raise RuntimeError('no idea')", "raised RuntimeError: no idea (") for role in HOOKS),
    *((role, "return None", "returned None; expected ") for role in HOOKS if role != "pr"),
    *((role, "return 'pod'", "returned str 'pod'; expected ") for role in HOOKS if role != "pr"),
    ("pr", "return None", "named cell None; expected a whole number"),
    ("pr", "return 'pod'", "named cell 'pod'; expected a whole number"),
    ("poa", "raise SystemExit(0)", "raised SystemExit: 0 ("),
]


@pytest.mark.parametrize(("role", "body", "message"), WHATEVER)
def test_what_is_no_answer_ends_the_run(
    tiny_run: Callable[..., Any], tmp_path: Path, role: str, body: str, message: str
) -> None:
    """A rule that raises, or returns nothing or the wrong type, is named with what it did, whatever it decides."""
    assert message in what_ends(prepare_bad(tiny_run, tmp_path, role, body), role)


def test_what_was_picked_before_the_error_was_told(tiny_run: Callable[..., Any], tmp_path: Path) -> None:
    """A PR rule that fails when the first pod leaves: the items picked before it are known to the observers."""
    run = prepare_bad(tiny_run, tmp_path, "pr", "return 1 / 0")
    with pytest.raises(RuleError, match=r"raised ZeroDivisionError: division by zero \(.*bad\.py, line 10\)"):
        run.simulation.run()
    assert len(run.recorder.of(ItemPicked)) == 1


@pytest.mark.parametrize("role", HOOKS)
def test_a_rule_that_takes_too_long_is_named_when_a_limit_is_set(
    tiny_run: Callable[..., Any], tmp_path: Path, role: str
) -> None:
    """run.decision_limit_s is checked for each decision; without it nothing depends on the clock."""
    slow = RunSection(decision_limit_s=0.3)
    run = prepare_bad(tiny_run, tmp_path, role, "time.sleep(0.35); return []", run=slow)
    with pytest.raises(
        RuleError, match=rf"{HOOKS[role]}, at \d+\.\d+ s: took \S+ s; the scenario allows run\.decision_l"
    ):
        run.simulation.run()


@pytest.mark.parametrize("hook", ["on_event(self, event)", "run_started(self, run)"])
def test_an_observer_that_raises_is_named(tiny_run: Callable[..., Any], tmp_path: Path, hook: str) -> None:
    """Observers cannot decide anything, but they can fail: the run ends with their name."""
    (tmp_path / "bad.py").write_text(
        "from attrs import define\nfrom rmfs_core import hookimpl\n@define\nclass Bad:\n"
        f"    @hookimpl\n    def {hook}: raise RuntimeError('full')\n",
        encoding="utf-8",
    )
    run = tiny_run(small_instance({"1": ["a"]}, {"p": ["a"]}), observers=["./bad.py:Bad"])
    with pytest.raises(RuleError, match=r'rule "\./bad\.py:Bad" .*RuntimeError: full'):
        run.simulation.run()
