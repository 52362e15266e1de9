"""Sentences that help with a misspelt name."""

from __future__ import annotations

import pytest

from rmfs_core.wording import (
    did_you_mean,
    first_few,
    listed,
    nearest,
    one_line,
    sentence,
    shortened,
    shown_short,
    visible,
)


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


def test_the_same_name_in_other_letters_comes_before_near_ones() -> None:
    """Capital letters for small ones, and the other way round."""
    assert did_you_mean("fracht", ["FRACHT", "frachts"]) == " (did you mean `FRACHT`?)"
    assert did_you_mean("MUG", ["mug", "MUGS"]) == " (did you mean `mug`?)"


def test_where_none_is_near_the_shortest_that_begin_so_are_offered() -> None:
    """At most three; one letter is no beginning."""
    names = ["late_percent", "late_orders", "late_x_and_long", "late_y_and_longer", "other"]
    assert did_you_mean("late", names) == " (did you mean `late_orders`, `late_percent` or `late_x_and_long`?)"
    assert did_you_mean("A4", ["A4094", "A2", "B"]) == " (did you mean `A4094`?)"
    assert did_you_mean("l", names) == ""
    assert did_you_mean("", names) == ""


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


@pytest.mark.parametrize(
    "value",
    ["`{}`", '"{}"', "'{}'", "[{}]", '"a \\" b {}"', "{}", "key = '{}' of it"],
)
def test_a_long_value_is_shortened(value: str) -> None:
    """Quoted or not; what is around it stays."""
    for long in (10_000 * "x", 1_000 * "with blanks "):
        if " " in long and not any(mark in value for mark in "`\"'"):
            continue
        text = f"s.toml, line 3, `rules.poa`: found {value.format(long)}; expected one of `a`, `b`"
        told = shortened(text)
        assert len(told) < 520
        assert told.startswith("s.toml, line 3, `rules.poa`: found ")
        assert told.endswith("; expected one of `a`, `b`") or value in ("{}", "[{}]")
        assert " ... " in told


def test_what_is_not_long_stays() -> None:
    """However many values there are, and whatever stands between them; apostrophes are no quotes."""
    text = "; ".join(f"`{name}` and \"{name}\", the rules' own, do not know what isn't there" for name in "abcdefgh")
    assert len(text) > 400
    assert shortened(text) == text
    assert shortened("short") == "short"


def test_signs_that_would_steer_a_terminal_show() -> None:
    """Control signs, and those that turn the direction; lines, tabs and letters of any script stay."""
    assert visible("a\x1b[31m\x07\u202e\x9b\x7f") == r"a\x1b[31m\x07\u202e\x9b\x7f"
    assert visible("größe\tΩ 東\nnext") == "größe\tΩ 東\nnext"


def test_a_long_text_of_an_exception_is_cut() -> None:
    """Its beginning and its end are enough."""
    assert len(one_line(ValueError(5_000 * "word "))) < 540


def test_an_exception_that_ends_the_process_as_it_is_shown() -> None:
    """It cannot."""

    class MonsterError(Exception):
        def __str__(self) -> str:
            raise SystemExit

        __repr__ = __str__

    assert one_line(MonsterError()) == "MonsterError"
    assert shown_short(MonsterError()) == "a MonsterError"
