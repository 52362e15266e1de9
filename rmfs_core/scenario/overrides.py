"""`--set key=value`: values that replace those of the file."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from typing import Any

import attrs
from attrs import frozen

from rmfs_core.errors import InputError
from rmfs_core.scenario.checks import nearest
from rmfs_core.scenario.model import RuleChoice, Scenario
from rmfs_core.scenario.structuring import fields_of, section_class
from rmfs_core.scenario.tomltext import shown


@frozen
class Override:
    """One ``--set``.

    Parameters
    ----------
    text
        As given: ``rules.poa.rule=first-come``. The value is TOML, or else a plain text; nothing after the ``=``
        takes the key out, so that its default counts again (``rules.poa=`` makes room for ``rules.poa_pps``).
    path
        The keys before the ``=``.
    value
        The value, or None to take the key out.
    """

    text: str
    path: tuple[str, ...]
    value: Any

    @property
    def place(self) -> str:
        """How a message names it."""
        return f"--set {self.text}"


def parse_override(text: str) -> Override:
    """Return the override that ``text`` stands for; raise InputError when it has no ``key=value`` form."""
    dotted, equals, raw = text.partition("=")
    path = tuple(part.strip() for part in dotted.split("."))
    if not equals or not all(path):
        raise InputError(f"--set {text}", "expected key=value, such as instance.orders=50")
    return Override(text, path, _value(raw.strip()))


def _value(raw: str) -> Any:
    if not raw:
        return None
    try:
        document = tomllib.loads(f"value = {raw}")
    except tomllib.TOMLDecodeError:
        return raw
    # More than one key: the text had a line break in it and only looked like TOML.
    return document["value"] if len(document) == 1 else raw


def apply_overrides(data: dict[str, Any], overrides: Sequence[Override]) -> dict[str, Any]:
    """Return ``data`` with the overrides applied, one after another."""
    for override in overrides:
        data = _applied(data, override, override.path)
    return data


def _applied(table: dict[str, Any], override: Override, path: tuple[str, ...]) -> dict[str, Any]:
    key, rest = path[0], path[1:]
    if not rest and override.value is None:
        _check_known(override)
        return {name: value for name, value in table.items() if name != key}
    if not rest:
        return {**table, key: override.value}
    inner = table.get(key, {})
    if isinstance(inner, str) and override.path[0] == "rules":
        inner = {"rule": inner}  # `poa = "pod-match"` stands for `poa = { rule = "pod-match" }`
    if not isinstance(inner, dict):
        within = ".".join(override.path[: -len(rest)])
        raise InputError(override.place, f"`{within}` has no keys of its own, it is {shown(inner)}")
    return {**table, key: _applied(inner, override, rest)}


def _check_known(override: Override) -> None:
    """Refuse to take out a key that no scenario has: nothing else would ever notice the misspelling."""
    cls: type | None = Scenario
    for key in override.path:
        if cls is None or not attrs.has(cls) or cls is RuleChoice:
            return  # names of stations or of a rule's parameters, which only others know
        if key not in fields_of(cls):
            raise InputError(override.place, f"unknown key `{key}`{nearest(key, fields_of(cls))}")
        cls = section_class(cls, key)
