"""TOML documents: their values, and the line in which a key stands. The entry point ``toml`` of ``rmfs.formats``."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from itertools import takewhile
from operator import eq
from typing import Any

MOST_NESTED = 50
_HEADER = re.compile(r"^\s*\[\[?(?P<keys>[^\]]+)\]\]?\s*(#.*)?$")
_PART = r"(?:[A-Za-z0-9_-]+|\"[^\"\\]*\"|'[^']*')"
_ASSIGNMENT = re.compile(rf"^\s*(?P<keys>{_PART}(?:\s*\.\s*{_PART})*)\s*=")
JSON = (
    "found JSON; `rmfs scenario show DIR` prints the scenario of the run in DIR, and `rmfs run SCENARIO --journal "
    "FILE` runs the day of a hall again"
)


def read_toml(text: str) -> dict[str, Any]:
    """Return what ``text`` says; raise ValueError where it is no TOML, or has what Python does not read."""
    too_deep = ValueError(f"found more than {MOST_NESTED} lists or tables in one another")
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        if text.lstrip().startswith("{"):
            raise ValueError(JSON) from None
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


def _keys(dotted: str) -> tuple[str, ...] | None:
    try:
        nested = tomllib.loads(f"{dotted} = 0")
    except tomllib.TOMLDecodeError:
        return None
    keys = []
    while isinstance(nested, dict):
        (key,) = nested
        keys.append(key)
        nested = nested[key]
    return tuple(keys)


def line_of(text: str, path: tuple[str | int, ...]) -> int | None:
    """Return the line (from 1) of the key at ``path``, or of the nearest table or inline table around it.

    Parameters
    ----------
    text
        A valid TOML document.
    path
        Keys from the top, with list positions as numbers.

    Returns
    -------
    int or None
        None where a plain scan cannot tell: when the text has multi-line strings, which may look like keys.
    """
    if '"""' in text or "'''" in text:
        return None
    wanted = tuple(str(part) for part in path)
    table: tuple[str, ...] = ()
    arrays = Counter[tuple[str, ...]]()
    best, depth = None, 0
    for number, line in enumerate(text.splitlines(), start=1):
        found: tuple[str, ...] | None = None
        if header := _HEADER.match(line):
            table, names = (), _keys(header["keys"]) or ()
            for place, name in enumerate(names, start=1):
                table += (name,)
                arrays[table] += place == len(names) and line.lstrip().startswith("[[")
                table += (str(arrays[table] - 1),) * (arrays[table] > 0)
            found = table
        elif assignment := _ASSIGNMENT.match(line):
            keys = _keys(assignment["keys"])
            found = None if keys is None else table + keys
        if not found:
            continue
        common = sum(takewhile(bool, map(eq, found, wanted)))
        # A longer key under a shorter wanted path (`[rules.poa]` for `rules`) tells where the table begins.
        if common > depth and common in (len(found), len(wanted)):
            best, depth = number, common
    return best
