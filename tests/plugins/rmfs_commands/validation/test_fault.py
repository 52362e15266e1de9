"""Kinds of faults: each has a test that shows it, and each that the code names is one."""

from __future__ import annotations

import re
from pathlib import Path

import rmfs_commands.validation
from rmfs_commands.validation import KINDS, Fault


def test_every_kind_of_fault_is_shown_by_a_test() -> None:
    """A kind is named by a test beside this one, as the fault that a damaged trace has."""
    here = Path(__file__)
    tests = "".join(file.read_text(encoding="utf-8") for file in here.parent.glob("test_*.py") if file != here)
    assert {kind for kind in KINDS if not re.search(rf'"{kind}[":]', tests)} == set()


def test_every_kind_of_fault_is_found_by_a_check() -> None:
    """No kind is described that no check can find."""
    folder = Path(rmfs_commands.validation.__file__).parent
    code = "".join(file.read_text(encoding="utf-8") for file in folder.glob("*.py") if file.name != "fault.py")
    assert {kind for kind in KINDS if f'"{kind}"' not in code} == set()


def test_the_time_of_a_fault() -> None:
    """Ticks are thousandths of a second."""
    assert Fault("wall", 61_098, "robot 1 drives through the wall at row 1, column 1").time_s == 61.098
