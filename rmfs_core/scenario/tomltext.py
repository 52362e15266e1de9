"""Values as TOML text. (The standard library reads TOML but does not write it; scenario files need few lines.)"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

_BARE = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(text: str) -> str:
    """Return ``text`` in double quotes."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


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
    text = "null" if value is None else toml_value(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
