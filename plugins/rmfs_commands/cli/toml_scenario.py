"""A scenario as TOML text that reads back as an equal scenario."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import attrs

from rmfs_core.scenario import RuleChoice, Scenario
from rmfs_core.scenario.model import replaced_keys
from rmfs_core.scenario.structuring import fields_of
from rmfs_core.scenario.tomltext import toml_key, toml_value
from rmfs_core.scenario.writing import plain


def to_toml(scenario: Scenario, *, comments: bool = True) -> str:
    """Return the fully resolved scenario as a TOML document.

    Parameters
    ----------
    scenario
        The scenario.
    comments
        Whether each key is preceded by what it means and its unit.
    """
    return "\n".join(_section_lines((), scenario, comments)).strip("\n") + "\n"


def describe(metadata: Mapping[str, Any]) -> str:
    """Return the meaning of a key with its unit."""
    unit = f" ({metadata['unit']})" if metadata.get("unit") else ""
    return f"{metadata['doc']}{unit}"


def _section_lines(path: tuple[str, ...], section: object, comments: bool) -> list[str]:
    """Values first, then the tables below: TOML wants a table's own keys before those of the next header."""
    values: list[str] = []
    tables: list[str] = []
    _, replaced = replaced_keys(section)
    for key, attribute in fields_of(type(section)).items():
        value = getattr(section, key)
        if value is None or key in replaced:
            continue
        below = attrs.has(type(value)) and not isinstance(value, RuleChoice)
        lines = tables if below else values
        if below:
            lines.append("")
        if comments:
            lines += textwrap.wrap(
                describe(attribute.metadata),
                100,
                initial_indent="# ",
                subsequent_indent="# ",
                break_on_hyphens=False,
            )
        if below:
            lines.append(f"[{'.'.join((*path, key))}]")
            lines += _section_lines((*path, key), value, comments)
        else:
            lines.append(f"{toml_key(key)} = {toml_value(plain(value))}")
    return values + tables
