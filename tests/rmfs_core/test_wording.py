"""Sentences that help with a misspelt name."""

from __future__ import annotations

import pytest

from rmfs_core.wording import did_you_mean, first_few, listed, nearest, one_line, sentence, shown_short


@pytest.mark.parametrize(
    ("names", "text"), [([], "nothing"), (["a"], "a"), (["a", "b"], "a and b"), (["a", "b", "c"], "a, b and c")]
)
def test_names_are_listed_as_in_a_sentence(names: list[str], text: str) -> None:
    """Commas, and a word before the last one; a word for none."""
    assert listed(names) == text
    assert listed(iter(names), "or") == text.replace(" and ", " or ")


def test_long_lists_are_cut_short() -> None:
    """Five, and how many are left; exactly five are all shown."""
    assert first_few(list("abcdefg")) == "a, b, c, d, e and 2 more"
    assert first_few(list("abcde")) == "a, b, c, d and e"


def test_near_names_are_offered_and_far_ones_are_not() -> None:
    """The nearest first, at most three; nothing where none is like it."""
    assert did_you_mean("cuont", ["count", "lift_s"]) == " (did you mean `count`?)"
    assert did_you_mean("paper-25", ["paper-2000", "paper-250", "x"]) == " (did you mean `paper-250` or `paper-2000`?)"
    assert did_you_mean("aaaa", ["aaab", "aaac", "aaad", "aaae"]).count("`") == 6
    assert did_you_mean("xyzzy", ["count"]) == ""


def test_where_none_is_near_all_are_named() -> None:
    """In the order of the alphabet; nothing is said where there are none."""
    assert nearest("cuont", ["lift_s", "count"]) == " (did you mean `count`?)"
    assert nearest("xyzzy", ["lift_s", "count"]) == "; expected one of `count`, `lift_s`"
    assert nearest("xyzzy", []) == ""


def test_an_exception_is_one_line() -> None:
    """Its class, and its text without line breaks; the class alone where there is no text."""
    assert one_line(ValueError("two\n   lines")) == "ValueError: two lines"
    assert one_line(KeyError("a")) == "KeyError: 'a'"
    assert one_line(SystemExit()) == "SystemExit"


def test_a_value_that_cannot_be_shown_has_its_type() -> None:
    """A message about it is a sentence all the same."""

    class Mute:
        def __repr__(self) -> str:
            raise RuntimeError

    nested: list[object] = []
    for _ in range(100_000):
        nested = [nested]
    assert shown_short(Mute()) == "a Mute"
    assert shown_short(object()) == "<object object>", "in every run"
    assert shown_short(nested) == "a list with hundreds in one another"


def test_a_message_is_one_line_that_can_be_shown() -> None:
    """Line breaks become blanks, what a terminal would obey is escaped, a long quotation loses its middle."""
    assert sentence("Error: x.toml: found \x1b[31m\n\t\ud800é") == "Error: x.toml: found \\x1b[31m \\ud800é"
    cut = sentence(f"Error: found {'9' * 5000}; expected a number")
    assert len(cut) < 1200
    assert cut.startswith("Error: found 999")
    assert cut.endswith("999; expected a number")
