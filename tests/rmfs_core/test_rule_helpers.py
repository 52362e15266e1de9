"""What rules share, under the kernel's name."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import rmfs_core.rule_helpers as offered
import rmfs_rules.helpers


def test_it_offers_the_functions_themselves() -> None:
    """Not copies: a rule that imports from either has the same function."""
    assert set(rmfs_rules.helpers.__all__) <= set(dir(offered))
    assert all(getattr(offered, name) is getattr(rmfs_rules.helpers, name) for name in rmfs_rules.helpers.__all__)


def test_editors_and_type_checkers_are_told_the_same_names() -> None:
    """The stub has every name, and no other: all that the package offers."""
    stub = ast.parse(Path(offered.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    assert [ast.unparse(node) for node in stub.body] == ["from rmfs_rules.helpers import *"]


def test_a_misspelt_function_is_an_error_as_of_any_module() -> None:
    """So that ``from rmfs_core.rule_helpers import ...`` fails where it stands."""
    with pytest.raises(AttributeError, match="send_pod"):
        _ = offered.send_pod  # type: ignore[attr-defined]
    with pytest.raises(ImportError):
        exec("from rmfs_core.rule_helpers import send_pod")
