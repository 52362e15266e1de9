"""States that are kept."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_commands.serve.warehouses import MOST_KEPT, StaleError, Warehouses
from rmfs_core.errors import InputError

STATE: dict[str, Any] = {"pods": {"P": {"contents": {"tea": 2, "milk": None}}}, "orders": {"A": {}}}


@pytest.fixture
def kept() -> Warehouses:
    """Return what has one state."""
    kept = Warehouses()
    kept.keep("w", "r1", STATE)
    return kept


def test_a_change_of_the_last_state(kept: Warehouses) -> None:
    """It leads to the next, and leaves the last as it was until the next is kept."""
    change = {"orders": {"A": None, "B": {}}, "pods": {"P": {"contents": {"tea": 1}}}}
    after = kept.changed("w", "r1", change, "r2")
    assert after == {"pods": {"P": {"contents": {"tea": 1, "milk": None}}}, "orders": {"B": {}}}
    assert kept.changed("w", "r1", {}, "r2") == STATE
    kept.keep("w", "r2", after)
    with pytest.raises(StaleError, match=r'^request, base: found "r1"; the last state is "r2"; expected'):
        kept.changed("w", "r1", {}, "r3")


def test_the_same_change_again(kept: Warehouses) -> None:
    """Who did not get the answer may ask again: the change is not made twice."""
    assert kept.changed("w", "r0", {"orders": None}, "r1") == STATE


def test_what_is_not_kept(kept: Warehouses) -> None:
    """The warehouses asked of last are kept, so many and no more."""
    for i in range(MOST_KEPT - 1):
        kept.keep(str(i), "r1", STATE)
    kept.keep("w", "r2", STATE)
    kept.keep("one more", "r1", STATE)
    assert kept.changed("w", "r2", {}, "r3") == STATE
    with pytest.raises(StaleError, match='no state of "0" is kept; expected the whole state first'):
        kept.changed("0", "r1", {}, "r2")


@pytest.mark.parametrize("pod", ["P", "Q"])
def test_null_is_no_stock(kept: Warehouses, pod: str) -> None:
    """In a merge patch null takes away: a SKU that never runs out cannot be said, and is not lost without a word."""
    change = {"pods": {pod: {"contents": {"jam": None}}}}
    with pytest.raises(InputError, match=rf"^change, pods.{pod}.contents.jam: null takes a SKU off a pod"):
        kept.changed("w", "r1", change, "r2")
    taken = kept.changed("w", "r1", {"pods": {"P": {"contents": {"milk": None}}}}, "r2")
    assert taken["pods"]["P"] == {"contents": {"tea": 2}}
