"""Descriptions of installed rules, for people and machines."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import attrs
from attrs import frozen

from rmfs_commands.instances.overrides import rule_name_from
from rmfs_core import entrypoints
from rmfs_core.errors import InputError, refusing
from rmfs_core.roles import Role
from rmfs_core.rules.hooks import check_hooks, require_attrs_class, roles_of
from rmfs_core.rules.parameters import parameters_of, plain, type_hints, type_name
from rmfs_core.rules.sources import RuleSource, RuleSources, load_entry
from rmfs_core.scenario.tomltext import toml_value
from rmfs_core.wording import one_line

_SHORT_REFERENCE = re.compile(r"(?:doi\.org/|doi:\s?)(10\.[^\s,;]+)|(arXiv:\d{4}\.\d{4,5})", re.IGNORECASE)


class _Said(str):
    """Text for a default that a scenario cannot have."""


DEPENDS = _Said("(depends on the others)")


@frozen
class Parameter:
    """A parameter of a rule.

    Parameters
    ----------
    name, type
        Its key in a scenario and what it takes, in words.
    required
        Whether a scenario has to give it.
    default
        Its value when the scenario gives none.
    unit, doc
        From the field's metadata, else from the "Parameters" section of the docstring; empty where neither says.
    """

    name: str
    type: str
    required: bool
    default: Any
    unit: str
    doc: str

    def shown(self) -> str:
        """Return the parameter as a table shows it: ``reallocation_s = 30.0 s``."""
        value = "(required)" if self.required else _toml_like(self.default)
        return f"{self.name} = {value} {self.unit}".rstrip()

    def in_scenario(self) -> str:
        """Return the parameter as a line of a scenario has it, a comment where it has no value: ``window_s = 20.0``."""
        value = "(required)" if self.required else _toml_like(self.default)
        return f"{'# ' if value.startswith('(') else ''}{self.name} = {value}"


@frozen
class RuleDescription:
    """An installed rule; ``error`` says why it cannot be used, and then the fields that need its class are empty."""

    name: str
    distribution: str
    version: str
    decides: tuple[str, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    summary: str = ""
    reference: str = ""
    doc: str = ""
    error: str | None = None

    def short_references(self) -> str:
        """Return the DOIs and arXiv numbers in the reference, or its first line where it has none."""
        found = [match[1] or match[2] for match in _SHORT_REFERENCE.finditer(self.reference)]
        return "\n".join(dict.fromkeys(number.rstrip(".") for number in found)) or self.reference.partition("\n")[0]


def installed_rules() -> list[RuleDescription]:
    """Describe every installed rule, by what it decides and by name; rules that cannot be imported carry the error."""
    found = [
        _describe(name, entries[0])
        for name, entries in entrypoints.offers(entrypoints.RULES).items()
        if len(entries) == 1  # each of several that share a name has one of its own, too
    ]
    labels = [role.label for role in Role]
    return sorted(found, key=lambda rule: [labels.index(label) for label in rule.decides] or [len(labels)])


def _describe(name: str, entry: EntryPoint) -> RuleDescription:
    distribution, version = entrypoints.origin(entry)
    try:
        return _described(name, load_entry((entry,), entry.name), entry.name)
    except InputError as error:
        return RuleDescription(name, distribution, version, error=error.problem)
    except Exception as error:  # a class that cannot even be looked at must not hide the others
        return RuleDescription(name, distribution, version, error=one_line(error))


def rule_of_file(name: str, *, allow_inline: bool = True) -> RuleDescription:
    """Describe a class in a file, ``./my_rule.py:MyRule``; raise `InputError` where it is no rule."""
    found = rule_name_from(name, ".", ".")
    place = f"rmfs rules {name}"
    return _described(name, RuleSources(".", allow_inline).find(found, place), place)


def _described(name: str, source: RuleSource, place: str) -> RuleDescription:
    rule = require_attrs_class(place, source.target, source.describe())
    check_hooks(place, rule, rule.__name__)
    doc = inspect.getdoc(rule) or ""
    return RuleDescription(
        name=name,
        distribution=source.distribution,
        version=source.version,
        decides=tuple(role.label for role in roles_of(rule)),
        parameters=tuple(_parameters(rule)),
        summary=doc.partition("\n")[0].replace("``", "`"),
        reference=sections(doc).get("References", ""),
        doc=doc,
    )


def sections(doc: str) -> dict[str, str]:
    """Return the text of each section of a numpydoc docstring by its title."""
    parts = re.split(r"^(\S.*)\n-{3,}\n", doc, flags=re.MULTILINE)
    return {title.strip(): text.strip() for title, text in zip(parts[1::2], parts[2::2], strict=True)}


def _parameters(rule: type) -> Iterator[Parameter]:
    documented = _documented_parameters(sections(inspect.getdoc(rule) or "").get("Parameters", ""))
    hints = type_hints(rule)
    for name, field in parameters_of(rule).items():
        doc = field.metadata.get("doc") or documented.get(name, "")
        in_brackets = re.search(r"\(([^()\s]{1,12})\)\.?$", doc)
        unit = field.metadata.get("unit") or (in_brackets[1] if in_brackets else "")
        required = field.default is attrs.NOTHING
        kind = hints.get(field.name, field.type)
        yield Parameter(name, type_name(kind), required, _default(field), str(unit), str(doc))


def _default(field: attrs.Attribute[Any]) -> Any:
    default: Any = field.default
    if default is attrs.NOTHING:
        return None
    if hasattr(default, "takes_self"):  # attrs.Factory
        if default.takes_self:
            return DEPENDS
        with refusing("rmfs rules", f"the factory of `{field.name}` raised"):
            default = default.factory()
    known = plain(default)
    odd = isinstance(known, str) and not isinstance(default, str | Path)
    return _Said(f"({known[1:-1]})") if odd else known


def _documented_parameters(text: str) -> dict[str, str]:
    """Return the description of each entry of a "Parameters" section: a line with names, then indented lines."""
    found: dict[str, str] = {}
    names: list[str] = []
    for line in text.splitlines():
        if line and not line[0].isspace():
            names = [name.strip() for name in line.partition(":")[0].split(",")]
        elif line.strip():
            found |= {name: f"{found.get(name, '')} {line.strip()}".strip() for name in names}
    return found


def _toml_like(value: Any) -> str:
    """Return a default as a scenario has it; a default of nothing is what a key that is left out stands for."""
    if value is None or isinstance(value, _Said):
        return value or "(not set)"
    try:
        return toml_value(value)
    except TypeError:
        return f"({value})"
