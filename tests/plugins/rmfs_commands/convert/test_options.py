"""Options that commands on tables share."""

from __future__ import annotations

from typing import Any
from zoneinfo import ZoneInfo

import click
import pytest

from rmfs_commands.convert.options import needs, number_options, quantities_of, table_options, time_options
from rmfs_core.errors import InputError


def given(*arguments: str) -> dict[str, Any]:
    """Return what a command with all of the options is handed."""

    @click.command()
    @table_options
    @number_options
    @time_options
    def command(**options: Any) -> dict[str, Any]:
        return options

    found: dict[str, Any] = command.main(list(arguments), standalone_mode=False)
    return found


def test_without_options() -> None:
    """A CSV file as most programs write it, and nothing known of its numbers."""
    assert given() == {
        "separator": ",",
        "encoding": "utf-8",
        "decimal": None,
        "thousands": None,
        "time_format": None,
        "zone": None,
    }


@pytest.mark.parametrize(
    ("arguments", "value"),
    [
        *((("--separator", text), "\t") for text in ("tab", "\t", "\\t")),
        (("--separator", "semicolon"), ";"),
        (("--separator", "|"), "|"),
        (("--encoding", "UTF8"), "utf-8"),
        (("--encoding", "latin-1"), "iso8859-1"),
        (("--zone", "Europe/Berlin"), ZoneInfo("Europe/Berlin")),
        (("--time-format", "unix"), "unix"),
        (("--decimal", ","), ","),
    ],
)
def test_values(arguments: tuple[str, str], value: object) -> None:
    """Signs and encodings may be named in several ways."""
    assert given(*arguments)[arguments[0][2:].replace("-", "_")] == value


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        *(
            (
                ("--separator", text),
                f"found {text!r}; expected one sign of ASCII, such as ;, or one of comma, semicolon",
            )
            for text in ("\u00e9", "::", "", '"', "\n", "a")
        ),
        *(
            (("--encoding", text), f"found {text!r}; expected utf-8, utf-16, cp1252 or the like")
            for text in ("foo", "rot13", "", "a\0b")
        ),
        (("--zone", "Europe/Berln"), "there is no time zone 'Europe/Berln' (did you mean `Europe/Berlin`"),
        (("--zone", "America"), "there is no time zone 'America'"),
        (("--time-format", "%H:%M %Z"), "found %Z: names of zones are not the same everywhere"),
    ],
)
def test_what_is_wrong_is_refused(arguments: tuple[str, str], problem: str) -> None:
    """In one sentence with the option."""
    with pytest.raises(InputError) as caught:
        given(*arguments)
    assert str(caught.value).startswith(f"{arguments[0]}: {problem}")


def test_quantities_have_two_signs() -> None:
    """One before fractions, another between thousands."""
    assert quantities_of({"decimal": ",", "thousands": "."}).whole("1.000", 1) == 1000
    with pytest.raises(InputError, match=r'^--decimal, --thousands: found "," for both; expected two signs$'):
        quantities_of({"decimal": ",", "thousands": ","})


def test_an_option_that_needs_another() -> None:
    """Both, or the second alone, or neither."""
    for both in (
        {"order_key": "a", "orders": "b"},
        {"order_key": None, "orders": "b"},
        dict.fromkeys(("order_key", "orders")),
    ):
        needs(both, "order_key", "orders", "the table")
    with pytest.raises(InputError, match=r"^--order-key: found no --orders; expected the table$"):
        needs({"order_key": "a", "orders": None}, "order_key", "orders", "the table")
