"""Sentences for people, and errors by who has to mend them."""

import pytest

from cases import cases
from rmfs_core.errors import is_interrupt
from rmfs_core.wording import did_you_mean, first_few, nearest, one_line, sentence, shortened, shown_short, visible


def test_what_is_named() -> None:
    assert first_few(list("abcdefg")) == "a, b, c, d, e and 2 more"
    assert first_few(list("abcde")) == "a, b, c, d and e"
    assert nearest("xyzzy", []) == ""
    assert len(one_line(ValueError(5_000 * "word "))) < 540


LATE = ["late_percent", "late_orders", "late_x_and_long", "late_y_and_longer", "other"]


@cases(
    "name names offered",
    ("cuont", ["count", "lift_s"], "`count`"),
    ("paper-25", ["paper-2000", "paper-250", "x"], "`paper-250` or `paper-2000`"),
    ("aaaa", ["aaab", "aaac", "aaad", "aaae"], "`aaae`, `aaad` or `aaac`"),
    ("fracht", ["FRACHT", "frachts"], "`FRACHT`"),  # the same in other letters, alone
    ("MUG", ["mug", "MUGS"], "`mug`"),
    ("late", LATE, "`late_orders`, `late_percent` or `late_x_and_long`"),  # none is near: what begins so
    ("A4", ["A4094", "A2", "B"], "`A4094`"),
    ("l", LATE, ""),  # one letter is no beginning
    ("", LATE, ""),
    ("xyzzy", ["count"], ""),
)
def test_near_names_are_offered_and_far_ones_are_not(name: str, names: list[str], offered: str) -> None:
    assert did_you_mean(name, names) == (f" (did you mean {offered}?)" if offered else "")


class MonsterError(Exception):
    def __str__(self) -> str:
        raise SystemExit

    __repr__ = __str__


def test_messages_can_be_shown() -> None:
    nested: list[object] = []
    for _ in range(100_000):
        nested = [nested]
    assert (one_line(MonsterError()), shown_short(MonsterError())) == ("MonsterError", "a MonsterError")
    assert shown_short(object()) == "<object object>", "in every run"
    assert shown_short(nested) == "a list with hundreds in one another"
    assert sentence("Error: x.toml: found \x1b[31m\n\t\ud800é") == "Error: x.toml: found \\x1b[31m \\ud800é"
    cut = sentence(f"Error: found {'9' * 5000}; expected a number")
    assert len(cut) < 1200
    assert cut.startswith("Error: found 999")
    assert cut.endswith("999; expected a number")


@pytest.mark.parametrize("value", ["`{}`", '"{}"', "'{}'", "[{}]", '"a \\" b {}"', "{}", "key = '{}' of it"])
def test_a_long_value_is_shortened(value: str) -> None:
    for long in (10_000 * "x", 1_000 * "with blanks "):
        if " " in long and not any(mark in value for mark in "`\"'"):
            continue
        text = f"s.toml, line 3, `rules.poa`: found {value.format(long)}; expected one of `a`, `b`"
        told = shortened(text)
        assert len(told) < (280 if any(mark in value for mark in "`\"'") else 520)
        assert told.startswith("s.toml, line 3, `rules.poa`: found ")
        assert told.endswith("; expected one of `a`, `b`") or value in ("{}", "[{}]")
        assert " ... " in told


def test_what_is_long_or_steers_a_terminal_is_changed() -> None:
    text = "; ".join(f"`{name}` and \"{name}\", the rules' own, do not know what isn't there" for name in "abcdefgh")
    assert len(text) > 400
    assert (shortened(text), shortened("short")) == (text, "short")
    assert visible("a\x1b[31m\x07\u202e\x9b\x7f") == r"a\x1b[31m\x07\u202e\x9b\x7f"
    assert visible("größe\tΩ 東\nnext") == "größe\tΩ 東\nnext"


def test_an_interrupt_is_known_in_what_python_makes_of_it() -> None:
    """One within compiled code is a SystemError, with the interrupt as its cause; any other SystemError is none."""
    within = SystemError("returned a result with an exception set")
    assert not is_interrupt(within)
    within.__cause__ = KeyboardInterrupt()
    assert is_interrupt(within)
    assert is_interrupt(KeyboardInterrupt())
    assert not is_interrupt(None)
