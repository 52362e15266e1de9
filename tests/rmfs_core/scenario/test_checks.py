"""Checks of single values: one sentence each, and the same in JSON Schema."""

from __future__ import annotations

from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_core.scenario.checks import (
    CAPACITY,
    DURATION,
    MAYBE_NO_TIME,
    MOVING,
    POSITIVE,
    SHARE,
    Check,
    OneOf,
    at_least,
    within,
)

NUMBERS = [at_least(1), at_least(0), within(0.5, 2), POSITIVE, DURATION, MAYBE_NO_TIME, MOVING, SHARE]


def refusal(check: Any, value: object) -> str | None:
    """Return what a check says of a value; None when it is right."""
    try:
        check(None, None, value)
    except ValueError as error:
        return str(error)
    return None


@pytest.mark.parametrize(
    ("check", "right", "wrong", "message"),
    [
        (at_least(1), 1, 0, "expected a whole number >= 1, found 0"),
        (within(0.5, 2), 2, 2.5, "expected a number from 0.5 to 2, found 2.5"),
        (within(0.5, 2), 0.5, 0.4, "expected a number from 0.5 to 2, found 0.4"),
        (POSITIVE, 1e-9, 0, "expected a number > 0 up to 1e10, found 0"),
        (POSITIVE, 1e10, 1.7e308, "expected a number > 0 up to 1e10, found 1.7e+308"),
        (DURATION, 0.001, 0, "expected a number from 0.001 to 3600, found 0"),  # a tick at least
        (MAYBE_NO_TIME, 0, -0.1, "expected a number from 0 to 3600, found -0.1"),
        (MOVING, 1000, 1001, "expected a number from 0.001 to 1000, found 1001"),
        (SHARE, 1, 0, "expected a number in (0, 1], found 0"),
        (SHARE, 0.01, 1.01, "expected a number in (0, 1], found 1.01"),
        (
            CAPACITY,
            1,
            0,
            "expected a whole number from 1 to 1,000,000,000, or a list of them, one per station, found 0",
        ),
        (
            CAPACITY,
            (1, 2),
            (1, 0),
            "expected a whole number from 1 to 1,000,000,000, or a list of them, one per station, found [1, 0]",
        ),
        (
            CAPACITY,
            (1,),
            (),
            "expected a whole number from 1 to 1,000,000,000, or a list of them, one per station, found []",
        ),
        (OneOf("start", "poisson"), "start", "strat", 'found "strat" (did you mean `start`?)'),
        (OneOf("start", "poisson"), "poisson", "x", 'found "x"; expected one of `poisson`, `start`'),
    ],
)
def test_a_wrong_value_is_one_sentence(check: Any, right: object, wrong: object, message: str) -> None:
    """What would be right and what was found, lists as the file has them; the bounds themselves are right."""
    assert refusal(check, right) is None
    assert refusal(check, wrong) == message


def test_a_key_that_was_left_out_is_not_checked() -> None:
    """None stands for it."""
    assert refusal(Check("anything", lambda value: False), None) is None
    assert refusal(CAPACITY, None) is None


@given(
    value=st.floats(allow_nan=False, allow_infinity=False) | st.integers(-10, 10_000), check=st.sampled_from(NUMBERS)
)
def test_the_schema_says_the_same(value: float, check: Check) -> None:
    """Whoever validates a file with the JSON Schema gets the same answer."""
    by_schema = jsonschema.Draft202012Validator(dict(check.schema)).is_valid(value)
    assert by_schema == (refusal(check, value) is None)
