"""TOML text to values and back. (The standard library reads TOML but does not write it; files need few lines.)"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from typing import Any

MOST_NESTED = 50
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def read_toml(text: str) -> dict[str, Any]:
    """Return what ``text`` says; raise ValueError where it is no TOML, or has what Python does not read."""
    too_deep = ValueError(f"found more than {MOST_NESTED} lists or tables in one another")
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # of `int`
        raise ValueError("found a number of more than 4,300 digits") from None
    except RecursionError:
        raise too_deep from None
    level: list[Any] = [document]
    for _ in range(MOST_NESTED):
        inner = [one.values() if isinstance(one, dict) else one for one in level if isinstance(one, (dict, list))]
        if not (level := [value for values in inner for value in values]):
            return document
    raise too_deep


def toml_text(text: str) -> str:
    """Return ``text`` in double quotes."""
    quoted = json.dumps(text, ensure_ascii=False)
    return quoted if quoted.isprintable() else "".join(map(_escaped, quoted))


def _escaped(sign: str) -> str:
    """Return a sign as it is where it shows; one that would steer a terminal as TOML escapes it."""
    number = ord(sign)
    return sign if sign.isprintable() else f"\\u{number:04x}" if number < 1 << 16 else f"\\U{number:08x}"


def toml_key(key: str) -> str:
    """Return a key, in quotes where TOML wants them."""
    return key if _BARE.fullmatch(key) else toml_text(key)


def toml_value(value: Any) -> str:
    """Return a value on one line: tables inline, in the order of their keys."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return toml_text(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(toml_value(entry) for entry in value)}]"
    if isinstance(value, Mapping):
        entries = ", ".join(f"{toml_key(key)} = {toml_value(entry)}" for key, entry in value.items())
        return f"{{ {entries} }}" if entries else "{}"
    # Numbers, and TOML's dates and times, whose str() is what TOML reads.
    return repr(value) if isinstance(value, (int, float)) else str(value)


def shown(value: Any) -> str:
    """Return a value as it stands in the file, cut short, to be shown in a message. (TOML has no null, JSON does.)"""
    try:
        text = "null" if value is None else toml_value(value)
    except RecursionError:
        text = "lists or tables in one another"
    return text if len(text) <= 60 else f"{text[:57]}..."
