"""`--set key=value`: values that replace those of the file."""

from __future__ import annotations

import os.path
from collections.abc import Iterable, Mapping, Sequence
from datetime import date, time
from functools import reduce
from pathlib import Path
from typing import Any

import attrs
from attrs import evolve, frozen

from rmfs_commands.instances.toml_lines import read_toml
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.scenario.model import DRAWN, GENERATED, RuleChoice, Scenario
from rmfs_core.scenario.rulenames import GivenText, file_name_from, is_inline
from rmfs_core.scenario.service import MAY_SPREAD
from rmfs_core.scenario.structuring import fields_of, section_class
from rmfs_core.scenario.tomltext import shown
from rmfs_core.wording import nearest

DATA_FILES: Mapping[tuple[str, ...], frozenset[str]] = {
    ("instance", "orders_file"): GENERATED,
    ("instance", "pods_file"): GENERATED,
    ("instance", "arrivals", "profile"): frozenset(),
    ("instance", "skus_file"): frozenset(),
    ("instance", "state_file"): frozenset(),
    ("instance", "replenishment", "file"): frozenset(),
    ("layout", "map_file"): DRAWN,
    ("robots", "file"): frozenset(),
    **{(section, key, "file"): frozenset((key,)) for section, keys in MAY_SPREAD.items() for key in keys},
}
"""Path of the key of every file with data that a scenario may name, and the keys that it replaces."""


@frozen
class Override:
    """One ``--set``.

    Parameters
    ----------
    text
        As given: ``rules.poa.rule=first-come``. The value is TOML, or else a plain text; nothing after the ``=``, or
        ``None`` or ``null``, takes the key out, so that its default counts again.
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
    return Override(text, path, _value(raw.strip(), f"--set {text}"))


def parsed(texts: Iterable[str], there: Path, folder: Path) -> list[Override]:
    """Return the overrides that texts stand for, with files of ``there``, for a scenario in ``folder``."""
    return [anchored(parse_override(text), there, folder) for text in texts]


def _value(raw: str, place: str) -> Any:
    if raw in ("", "None", "null"):  # TOML has no word for nothing; a text of these letters has quotes
        return None
    try:
        document = read_toml(f"value = {raw}")
    except ValueError as error:
        if raw[0] in "{[":
            raise InputError(place, f"this is no valid TOML value: {error}; texts in it need quotes") from None
        return raw
    value = document["value"]
    # More than one key: the text had a line break in it and only looked like TOML. Scenarios have times as texts.
    return raw if len(document) > 1 or isinstance(value, date | time) else value


def apply_overrides(data: dict[str, Any], overrides: Sequence[Override]) -> dict[str, Any]:
    """Return ``data`` with the overrides applied, one after another.

    Setting ``rules.poa_pps`` takes the rules of ``rules.poa`` and ``rules.pps`` out, and the other way round; setting a
    file of data takes out what ``data`` says of how to make the same; with a text map, also how long queues are.
    """
    rules = data.get("rules")
    if isinstance(rules, dict):
        chosen = {part for one in overrides if (part := _chosen(one)) is not None}
        replaced = {other for role in Role if role.key in chosen for other in role.excludes}
        data = {**data, "rules": {role: choice for role, choice in rules.items() if role not in replaced}}
    for override in overrides:
        section = data.get(override.path[0])
        if override.path in DATA_FILES and override.value is not None and isinstance(section, dict):
            arrivals = section.get("arrivals")
            kept = {"arrivals"} if isinstance(arrivals, dict) and "backlog" in arrivals else set()
            rest = {key: value for key, value in section.items() if key not in DATA_FILES[override.path] - kept}
            data = {**data, override.path[0]: rest}
    drawn = [one for one in overrides if one.path == ("layout", "map_file") and one.value is not None]
    queues = [evolve(one, path=("stations", "queue_length"), value=None) for one in drawn]
    for override in (*queues, *overrides):
        data = _applied(data, override, override.path)
    return data


def data_files(scenario: Scenario) -> dict[tuple[str, ...], str]:
    """Return the files with data that a scenario names, by the paths of their keys."""
    whole: Any = scenario
    named = {path: reduce(lambda part, key: getattr(part, key, None), path, whole) for path in DATA_FILES}
    return {path: name for path, name in named.items() if isinstance(name, str)}


def _chosen(override: Override) -> str | None:
    """Return the role that an override names a rule for."""
    names_rule = len(override.path) == 2 or override.path[2:] == ("rule",)
    return override.path[1] if override.path[0] == "rules" and names_rule and override.value is not None else None


def anchored(override: Override, there: Path, folder: Path) -> Override:
    """Return an override for a scenario in ``folder``; the files that it names are looked up in ``there``."""

    def within(value: Any, path: tuple[str, ...]) -> Any:
        """Go down to the names of files; a list's entries are where the list is."""
        if isinstance(value, list):
            return [within(entry, path) for entry in value]
        if isinstance(value, dict):
            return {key: within(entry, (*path, key)) for key, entry in value.items()}
        if not isinstance(value, str):
            return value
        if path[0] == "rules" and path[2:] in ((), ("rule",)):
            return rule_name_from(value, there, folder)
        named = path in DATA_FILES or (path[1:2] == ("parameters",) and os.path.isfile(there / value))  # noqa: PTH113
        return file_name_from(value, there, folder) if named else value

    value = within(override.value, override.path)
    if override.path[0] == "rules" and not there.samefile(folder):
        value = given_in(value, override.path, str(there))
    return evolve(override, value=value)


def rule_name_from(name: str, there: str | Path, folder: str | Path) -> str:
    """Return what a scenario in ``folder`` calls the rule of this name in ``there``: only a file's name changes."""
    file, colon, class_name = name.rpartition(":")
    if not colon or not is_inline(name):
        return name
    found = file_name_from(file, there, folder)
    return f"{found if Path(found).is_absolute() else f'./{found}'}:{class_name}"


def given_in(value: Any, path: tuple[str, ...], there: str) -> Any:
    """Return the value of a key below ``rules`` with the texts of parameters as given in ``there``.

    Names of rules stay as they are, and so do texts that were given elsewhere.
    """
    if isinstance(value, list):
        return [given_in(entry, path, there) for entry in value]
    if isinstance(value, dict):
        return {key: given_in(entry, (*path, key), there) for key, entry in value.items()}
    plain = isinstance(value, str) and not isinstance(value, GivenText)
    return GivenText(value, there) if plain and path[2:] not in ((), ("rule",)) else value


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
        within, whole = ".".join(override.path[: -len(rest)]), f"; expected a table, as {{ {'.'.join(rest)} = [] }}"
        is_list = f"it is {shown(inner)}{whole if isinstance(inner, list) else ''}"
        raise InputError(override.place, f"`{within}` has no keys of its own, {is_list}")
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
