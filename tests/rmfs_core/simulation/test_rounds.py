"""A decision round: who is asked when, and what becomes of the answers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bad_rules import prepare_bad
from rmfs_core.errors import RuleError
from rmfs_core.events import OrderAssigned


def test_observers_are_told_nothing_of_a_decision_that_is_half_impossible(
    tiny_run: Callable[..., Any], tmp_path: Path
) -> None:
    """The first assignment was fine, the second not: results know of neither."""
    run = prepare_bad(tiny_run, tmp_path, "poa", "return [OrderAssignment(0, 0), OrderAssignment(99, 0)]")
    with pytest.raises(RuleError, match="named order 99"):
        run.simulation.run()
    assert not run.recorder.of(OrderAssigned)
