"""Scenario keys as an experiment file writes them, nested or dotted, to dotted keys and values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rmfs_core.scenario import RuleChoice, Scenario
from rmfs_core.scenario.structuring import KeyProblem, fields_of, section_class
from rmfs_core.wording import nearest

SCENARIO_KEYS = tuple(name for name in fields_of(Scenario) if name != "seed")
"""First parts of the keys that an experiment may set; seeds are the experiment's own."""


def changes_of(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return dotted scenario keys and their values.

    Parameters
    ----------
    table
        Nested tables, or dotted keys in quotes, or both: ``{"rules": {"poa": "first-come"}, "robots.count": 4}``.

    Raises
    ------
    KeyProblem
        For a key that no scenario has.
    """
    found: dict[str, Any] = {}
    for key, value in table.items():
        for dotted, entry in _descend(Scenario, (), key.split("."), value):
            if dotted in found:
                raise KeyProblem("found this key twice; expected it once", tuple(dotted.split(".")))
            found[dotted] = entry
    return found


def _descend(cls: type | None, above: tuple[str, ...], keys: list[str], value: Any) -> Iterator[tuple[str, Any]]:
    """Follow one key down the sections of a scenario (``cls``; None below a rule, whose parameters only it knows)."""
    key, rest = keys[0], keys[1:]
    path = (*above, key)
    below: type | None = None
    if cls is not None:
        valid = fields_of(cls) if above else SCENARIO_KEYS
        if key not in valid:
            raise KeyProblem(f"unknown key{nearest(key, valid)}", path)
        below = section_class(cls, key)
    within = None if below is RuleChoice else below
    if rest:
        yield from _descend(within, path, rest, value)
    elif isinstance(value, Mapping) and below is not None and "rule" not in value:
        for inner, entry in value.items():
            yield from _descend(within, path, inner.split("."), entry)
    else:
        yield ".".join(path), value
