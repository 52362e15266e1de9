"""Values as TOML has them. (The standard library reads TOML but does not write it; files need few lines.)"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

_BARE = re.compile(r"[A-Za-z0-9_-]+")


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
