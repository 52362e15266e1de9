"""Scenarios to plain tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs

from rmfs_core.scenario.model import RuleChoice, Scenario, replaced_keys
from rmfs_core.scenario.service import ServiceTime
from rmfs_core.scenario.structuring import fields_of


def scenario_to_dict(scenario: Scenario) -> dict[str, Any]:
    """Return every key of a scenario with its value, defaults included; keys that are left out (None) are missing."""
    tables: dict[str, Any] = plain(scenario)
    return tables


def plain(value: Any) -> Any:
    """Return a section or value as TOML and JSON have it: tables, lists and single values."""
    if isinstance(value, RuleChoice):
        return {"rule": value.rule, **plain(value.parameters)} if value.parameters else value.rule
    if isinstance(value, ServiceTime):
        return plain(value.spread)
    if attrs.has(type(value)):
        _, replaced = replaced_keys(value)
        entries = ((key, getattr(value, key)) for key in fields_of(type(value)) if key not in replaced)
        return {key: plain(entry) for key, entry in entries if entry is not None}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    return value
