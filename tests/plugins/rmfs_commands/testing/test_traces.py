"""The validation of recorded runs is one of the tools for tests of rules."""

from __future__ import annotations

import json
from pathlib import Path

import rmfs_commands.validation
import rmfs_core.testing


def test_a_recorded_run_is_validated_by_the_name_that_tests_of_rules_know(tmp_path: Path) -> None:
    """A good run has no fault; a result that counts a pick too many is one."""
    rmfs_core.run(
        "examples/small", overrides=["instance.orders=4", "rules.pp=free-flow"], out=tmp_path, record=["trace"]
    )
    assert rmfs_core.testing.validate_trace(tmp_path) == []
    file = tmp_path / "result.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    content["metrics"]["picks"] += 1
    file.write_text(json.dumps(content), encoding="utf-8")
    (fault,) = rmfs_core.testing.validate_trace(tmp_path)
    assert isinstance(fault, rmfs_core.testing.Fault)
    assert fault.kind == "metric"
    assert rmfs_core.testing.Fault is rmfs_commands.validation.Fault
