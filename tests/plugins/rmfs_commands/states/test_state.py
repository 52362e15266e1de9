"""The format of decision states: what each part may be."""

from __future__ import annotations

import pytest
from jsonschema import Draft202012Validator

from rmfs_commands.states.state import DECIDES, LayoutState, MotionState, RandomState, StationState, state_schema
from rmfs_core.motion import Motion
from rmfs_core.scenario.model import LayoutSection


def test_the_decisions_that_can_be_asked() -> None:
    """Paths, filters and observers are not among them."""
    of_orders = ("POA", "PPS", "POA+PPS", "PR", "TA")
    assert (*of_orders, "ROA", "RPS", "ROA+RPS", "activation", "idle", "repositioning") == DECIDES


def test_robots_move_as_in_the_paper_unless_it_is_said() -> None:
    """The defaults are the kernel's."""
    assert MotionState().motion() == Motion()
    assert MotionState(top_speed_m_per_s=2.0).motion() == Motion(top_speed_m_per_s=2.0)


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (LayoutState, "expected either `map` or `blocks`"),
        (lambda: LayoutState(("..",), LayoutSection()), "expected either `map` or `blocks`"),
        (lambda: LayoutState(blocks=LayoutSection(map_file="a.txt")), "expected no `map_file` in a state"),
        (StationState, "expected either `item_capacity` or `order_capacity`"),
        (lambda: StationState(4, 2), "expected either `item_capacity` or `order_capacity`"),
        (lambda: RandomState("12", "x"), 'numbers below 2^128, found "x"'),
        (lambda: RandomState("-1", "1"), 'numbers below 2^128, found "-1"'),
        (lambda: RandomState(str(1 << 128), "1"), "numbers below 2^128"),
    ],
)
def test_what_excludes_each_other_is_refused(make: object, problem: str) -> None:
    """One of two, neither both nor none; numbers of 128 bits as texts."""
    assert callable(make)
    with pytest.raises(ValueError) as caught:
        make()
    assert problem in str(caught.value)


def test_the_limits_themselves_are_allowed() -> None:
    """The largest number of 128 bits, a block layout, a capacity in orders."""
    assert RandomState(str((1 << 128) - 1), "0").has_uint32 == 0
    assert LayoutState(blocks=LayoutSection()).map is None
    assert StationState(order_capacity=1).item_capacity is None


def test_the_schema_takes_states_and_nothing_else(by_hand: dict[str, object], at_work: dict[str, object]) -> None:
    """It is a schema of draft 2020-12; a wrong number, key or decision is marked."""
    schema = state_schema()
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema)
    for good in (by_hand, at_work):
        assert validator.is_valid(good)
    for changed in (
        {"version": 3},
        {"pods": 5},
        {"weather": "fine"},
        {"stations": {"north": {"item_capacity": 0}}},
        {"ask": {"decides": "lunch"}},
        {"robots": {"r1": {"heading": 4}}},
    ):
        assert not validator.is_valid({**by_hand, **changed}), changed
