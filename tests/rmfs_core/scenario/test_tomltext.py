"""Values as TOML text."""

from __future__ import annotations

import datetime
import tomllib
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_core.scenario.tomltext import read_toml, shown, toml_key, toml_text, toml_value

TEXTS = st.text(st.characters(codec="utf-8"))
VALUES = st.recursive(
    st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | TEXTS | st.dates(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=8,
)


@given(VALUES)
@settings(max_examples=40)
def test_values_read_back(value: Any) -> None:
    """What the standard library reads of the text is the value, infinities and control characters included."""
    assert tomllib.loads(f"x = {toml_value(value)}")["x"] == value


@given(TEXTS)
@settings(max_examples=40)
def test_keys_read_back(key: str) -> None:
    """Any text can be a key, also the empty one and one with dots."""
    assert tomllib.loads(f"{toml_key(key)} = 1") == {key: 1}


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "true"),
        (3, "3"),
        (0.1, "0.1"),
        ('a\n"b" ü', '"a\\n\\"b\\" ü"'),
        ((1, "a"), '[1, "a"]'),
        ({"rule": "x", "a b": [{}]}, '{ rule = "x", "a b" = [{}] }'),
        (datetime.date(2026, 1, 31), "2026-01-31"),
    ],
)
def test_values_are_on_one_line(value: object, text: str) -> None:
    """As short as TOML allows, tables inline."""
    assert toml_value(value) == text


def test_keys_are_quoted_only_where_they_must_be() -> None:
    """Letters, digits, dashes and underscores need no quotes."""
    assert [toml_key(key) for key in ("pick_s", "a-1", "1", "a.b", "")] == ["pick_s", "a-1", "1", '"a.b"', '""']
    assert toml_text("a\x7fb") == '"a\\u007fb"'  # which JSON would leave as it is, and TOML forbids


def test_messages_show_a_value_cut_short() -> None:
    """At most 60 characters, the last three of them dots; nothing is null, which TOML has no word for."""
    assert shown(None) == "null"
    assert shown("x" * 58) == f'"{"x" * 58}"'
    cut = shown("x" * 59)
    assert (len(cut), cut[-4:]) == (60, "x...")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("x = ", "Invalid value"),
        (f"x = {'9' * 5000}", "found a number of more than 4,300 digits"),
        (f"x = {'[' * 60}{']' * 60}", "found more than 50 lists or tables in one another"),
        (f"x = {'{a = ' * 60}1{'}' * 60}", "found more than 50 lists or tables in one another"),
        (f"x = {'[' * 2000}{']' * 2000}", "found more than 50 lists or tables in one another"),
    ],
    ids=["no value", "digits", "lists", "tables", "too many for Python"],
)
def test_what_cannot_be_read_is_a_value_error(text: str, problem: str) -> None:
    """So is what Python would not read: endless numbers, endless nesting."""
    with pytest.raises(ValueError, match=problem):
        read_toml(text)


def test_what_can_be_read_is_read() -> None:
    """Tables and lists in one another, as deep as anybody needs."""
    assert read_toml(f"x = {'[' * 40}{']' * 40}\n[a.b]\nc = 1")["a"] == {"b": {"c": 1}}


def test_a_value_that_is_too_deep_is_shown_in_words() -> None:
    """JSON may be as deep."""
    nested: list[Any] = []
    for _ in range(990):
        nested = [nested]
    assert shown(nested) == "lists or tables in one another"
