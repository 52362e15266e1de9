"""Options that commands on tables share, and their checks."""

from __future__ import annotations

import codecs
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeVar

import click

from rmfs_core.errors import InputError

if TYPE_CHECKING:
    from zoneinfo import ZoneInfo

    from rmfs_commands.convert.quantities import Quantities
    from rmfs_commands.convert.tables import Chosen

F = TypeVar("F", bound=Callable[..., Any])

_NO_SEPARATOR = '"\r\n\0 '


def _separator(_ctx: click.Context, _param: click.Parameter, text: str) -> str:
    from rmfs_commands.convert.csv_tables import SEPARATORS

    sign = SEPARATORS.get(text, "\t" if text == "\\t" else text)
    if len(sign) != 1 or not sign.isascii() or sign.isalnum() or sign in _NO_SEPARATOR:
        expected = f"expected one sign of ASCII, such as ;, or one of {', '.join(SEPARATORS)}"
        raise InputError("--separator", f"found {text!r}; {expected}")
    return sign


def _encoding(_ctx: click.Context, _param: click.Parameter, name: str) -> str:
    try:
        with suppress(UnicodeError):
            b"a".decode(name)  # what is no encoding of texts is refused here, too
        codecs.getincrementaldecoder(name)
        return codecs.lookup(name).name
    except (LookupError, ValueError):
        raise InputError("--encoding", f"found {name!r}; expected utf-8, utf-16, cp1252 or the like") from None


def _zone(_ctx: click.Context, _param: click.Parameter, name: str | None) -> ZoneInfo | None:
    from zoneinfo import ZoneInfo, available_timezones

    from rmfs_core.wording import did_you_mean

    if name is None:
        return None
    if name not in (known := available_timezones()):
        meant = did_you_mean(name, known)
        raise InputError("--zone", f"there is no time zone {name!r}{meant}; expected a name such as Europe/Berlin")
    return ZoneInfo(name)


def _patterns(_ctx: click.Context, _param: click.Parameter, texts: tuple[str, ...]) -> tuple[str, ...] | None:
    from rmfs_commands.convert.time_formats import checked_pattern

    return tuple(map(checked_pattern, texts)) or None


def _opens(_ctx: click.Context, _param: click.Parameter, texts: tuple[str, ...]) -> tuple[tuple[str, str], ...] | None:
    from rmfs_core.timetable import read_spans
    from rmfs_core.wording import shown_short

    spans = []
    for text in texts:
        begin, _, end = text.partition("-")
        try:
            read_spans([(begin, end)])
        except ValueError:
            found = f"found {shown_short(text)}; expected two times of the day, such as 06:00-22:00"
            raise InputError("--open", found) from None
        spans.append((begin, end))
    return tuple(spans) or None


def _only(_ctx: click.Context, param: click.Parameter, texts: tuple[str, ...]) -> Chosen | None:
    from rmfs_commands.convert.headers import plain
    from rmfs_core.wording import shown_short

    chosen: dict[str, frozenset[str]] = {}
    for text in texts:
        column, sign, value = text.partition("=")
        if not (sign and column.strip()):
            found = f"found {shown_short(text)}; expected a column and a value, such as status=open"
            raise InputError(param.opts[0], found)
        chosen[plain(column)] = chosen.get(plain(column), frozenset()) | {plain(value)}
    return chosen or None


def open_option(command: F) -> F:
    """Add ``--open``: when stations are open."""
    option = click.option(
        "--open",
        multiple=True,
        metavar="SPAN",
        callback=_opens,
        help="Hours in which stations are open every day, such as 06:00-22:00, for scenario.toml, which `convert "
        "orders` writes with --pods; may be repeated. [default: all day]",
    )
    return option(command)


def table_options(command: F) -> F:
    """Add ``--separator`` and ``--encoding``: how the fields of a CSV file are written."""
    separator = click.option(
        "--separator",
        default="comma",
        show_default=True,
        metavar="SIGN",
        callback=_separator,
        help="Between the fields of a CSV file: a sign, or comma, semicolon, tab or bar.",
    )
    encoding = click.option(
        "--encoding",
        default="utf-8",
        show_default=True,
        metavar="NAME",
        callback=_encoding,
        help="Encoding of the texts: utf-8, utf-16, cp1252 or the like.",
    )
    return separator(encoding(command))


def only_option(command: F, name: str = "--only", of: str = "") -> F:
    """Add ``--only``: which rows of a table are read."""
    option = click.option(
        name,
        multiple=True,
        metavar="COL=VALUE",
        callback=_only,
        help=f"Read only the rows{of} with that value in a column, such as status=open; may be repeated: rows with one "
        "of the values of each column.",
    )
    return option(command)


def number_options(command: F) -> F:
    """Add ``--decimal`` and ``--thousands``: how quantities are written."""
    decimal = click.option(
        "--decimal",
        type=click.Choice([".", ","]),
        help="Sign before fractions of quantities. [default: asked where it matters]",
    )
    thousands = click.option(
        "--thousands",
        type=click.Choice([".", ",", " ", "'"]),
        help="Sign between thousands of quantities. [default: any but the decimal sign]",
    )
    return decimal(thousands(command))


def time_options(command: F) -> F:
    """Add ``--time-format`` and ``--zone``: how times are written."""
    pattern = click.option(
        "--time-format",
        metavar="FORMAT",
        multiple=True,
        callback=_patterns,
        help="Format of times: as %d.%m.%Y %H:%M, or seconds, unix, unix-ms, spreadsheet or iso. May be repeated: a "
        "time is read by the first that fits. [default: ISO 8601, or seconds]",
    )
    zone = click.option(
        "--zone",
        metavar="ZONE",
        callback=_zone,
        help="Time zone of the warehouse, such as Europe/Berlin: of times without an offset from UTC, and of the hours "
        "of the day. [default: as the times are written]",
    )
    return pattern(zone(command))


def quantities_of(given: Mapping[str, Any]) -> Quantities:
    """Return a reader of quantities with the signs that are given; InputError when they are the same."""
    from rmfs_commands.convert.quantities import Quantities

    decimal, thousands = given["decimal"], given["thousands"]
    if decimal is not None and decimal == thousands:
        raise InputError("--decimal, --thousands", f'found "{decimal}" for both; expected two signs')
    return Quantities(decimal, thousands)


def needs(given: Mapping[str, Any], option: str, other: str, expected: str) -> None:
    """Raise an `InputError` where an option is given without another one."""
    if given[option] is not None and given[other] is None:
        raise InputError(spelled(option), f"found no {spelled(other)}; expected {expected}")


def spelled(option: str) -> str:
    """Return an option as it is typed."""
    return f"--{option.replace('_', '-')}"
