"""The rule set without split orders that serves orders arriving over time best."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from rmfs_core.scenario.tomltext import toml_value

SERVING: Final[Mapping[str, Any]] = {
    "rules.poa": {"rule": "pod-match", "spread": 0.5},
    "rules.pps": "completes",
}
"""Scenario keys that select it. It was chosen in several warehouses: see docs/how-to/which-rule.md."""


def serving_lines() -> str:
    """Return the lines that select it in the section ``[rules]`` of a scenario file."""
    return "\n".join(f"{key.removeprefix('rules.')} = {toml_value(choice)}" for key, choice in SERVING.items())


def serving_options() -> str:
    """Return the options that select it on a command line."""
    return " ".join(
        f"--set '{key}={toml_value(choice) if isinstance(choice, Mapping) else choice}'"
        for key, choice in SERVING.items()
    )
