"""Memory of rules: written into its state, and given back to the rules of a run that goes on from there.

A rule that remembers has two methods: ``memory()`` returns it as JSON's objects, lists and values, and
``remember(memory, warehouse)`` takes it back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from numbers import Integral
from typing import Any

import attrs

from rmfs_commands.states.names import Names
from rmfs_core.errors import InputError
from rmfs_core.wording import raised, shown_short

FORGETFUL = ("rmfs_rules.switch",)
"""Modules of shipped rules that remember, and tell nobody; what others keep is computed anew."""


def labelled(rules: Any) -> Iterator[tuple[str, Any]]:
    """Yield the rules that decide, each by what it decides and its name, and its number where some are the same."""
    found: dict[str, int] = {}
    for rule in rules.deciding:
        label = f"{rule.role.label} {rule.name}"
        found[label] = found.get(label, 0) + 1
        yield label if found[label] == 1 else f"{label} {found[label]}", rule


def memories(rules: Any) -> dict[str, Any]:
    """Return what each rule of a run remembers; InputError where one does not say."""
    found = {}
    for label, rule in labelled(rules):
        kind = type(rule.instance)
        if callable(getattr(rule.instance, "memory", None)):  # else it is a parameter of that name
            found[label] = _remembered(rule)
        elif kind.__module__ in FORGETFUL or not kind.__module__.startswith("rmfs_rules."):
            kept = [field.name for field in attrs.fields(kind) if not field.init]
            if kept:
                expected = "expected a rule that remembers nothing, or has the methods `memory` and `remember`"
                found_ = f"{rule.describe()} keeps data that no state holds ({kept[0]})"
                raise InputError(f"rules.{rule.role.key}", f"{found_}; {expected}")
    return found


def _remembered(rule: Any) -> Any:
    """Return what a rule remembers; InputError where that is nothing that a state gives back as it was."""
    place = f"rules.{rule.role.key}"
    try:
        memory = rule.instance.memory()
    except Exception as error:
        raise InputError(place, f"{rule.describe()}, memory: raised {raised(error, rule.instance)}") from error
    if not _is_json(memory):
        expected = "expected texts, finite numbers, truth values, None, and lists of such or dicts with texts as keys"
        raise InputError(place, f"{rule.describe()}, memory: returned {shown_short(memory)}; {expected}")
    return memory


def _is_json(value: object) -> bool:
    if isinstance(value, dict):
        return all(isinstance(key, str) and _is_json(entry) for key, entry in value.items())
    if isinstance(value, list | tuple):
        return all(map(_is_json, value))
    return isinstance(value, str | Integral | None) or (isinstance(value, float) and math.isfinite(value))


def remind(rules: Any, memory: Mapping[str, Any], warehouse: Any, names: Names) -> None:
    """Let rules remember what a state tells; a rule of another name begins afresh."""
    for label, rule in labelled(rules):
        if label in memory and hasattr(rule.instance, "remember"):
            try:
                rule.instance.remember(memory[label], warehouse)
            except (TypeError, ValueError, LookupError, AttributeError, ArithmeticError):
                names.wrong(
                    ("run", "memory", label), f"expected the memory that {rule.describe()} writes, found other data"
                )
