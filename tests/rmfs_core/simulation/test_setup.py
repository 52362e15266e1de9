"""The warehouse at time 0."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bad_rules import write_rule
from rmfs_core.errors import InputError
from rmfs_testing import small_instance


def test_a_need_that_is_not_met_is_refused(tiny_run: Callable[..., Any], tmp_path: Path) -> None:
    """A rule that declares unlimited stock as its need is not run on an instance with finite stock."""
    name = write_rule(tmp_path, "poa", "return []")
    (tmp_path / "bad.py").write_text(
        (tmp_path / "bad.py").read_text().replace("class Bad:", "class Bad:\n    needs = ('unlimited stock',)")
    )
    with pytest.raises(InputError, match=r"rules\.poa: rule .* needs pods whose SKUs never run out, but"):
        tiny_run(small_instance({"1": ["a"]}, {"p": {"a": 3}}), poa=name)
