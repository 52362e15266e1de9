"""JSON merge patches."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.states.patches import difference, patched

values = st.recursive(
    st.booleans() | st.integers() | st.text(max_size=3) | st.lists(st.integers(), max_size=3),
    lambda inner: st.dictionaries(st.text("abc", max_size=2), inner, max_size=4),
    max_leaves=8,
)
objects = st.dictionaries(st.text("abc", max_size=2), values, max_size=4)


@given(objects, objects)
def test_the_difference_leads_from_one_to_the_other(before: dict[str, Any], after: dict[str, Any]) -> None:
    """Patching with the difference gives the later object, and leaves the earlier one alone."""
    copy = repr(before)
    assert patched(before, difference(before, after)) == after
    assert repr(before) == copy


@pytest.mark.parametrize(
    ("before", "patch", "after"),
    [  # from RFC 7396, Appendix A
        ({"a": "b"}, {"a": "c"}, {"a": "c"}),
        ({"a": "b"}, {"b": "c"}, {"a": "b", "b": "c"}),
        ({"a": "b"}, {"a": None}, {}),
        ({"a": ["b"]}, {"a": "c"}, {"a": "c"}),
        ({"a": {"b": "c"}}, {"a": {"b": "d", "c": None}}, {"a": {"b": "d"}}),
        ({"e": None}, {"a": 1}, {"e": None, "a": 1}),
        ({}, {"a": {"bb": {"ccc": None}}}, {"a": {"bb": {}}}),
    ],
)
def test_the_standards_examples(before: dict[str, Any], patch: dict[str, Any], after: dict[str, Any]) -> None:
    """Patches mean what RFC 7396 says."""
    assert patched(before, patch) == after


def test_nothing_changed_is_an_empty_patch() -> None:
    """Two equal objects differ in nothing, also where values are null."""
    assert difference({"a": {"b": None}, "c": [1]}, {"a": {"b": None}, "c": [1]}) == {}
