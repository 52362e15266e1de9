"""The JSON Schema of scenario files, for editors, from the same classes that read them."""

from __future__ import annotations

from collections.abc import Mapping
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import attrs

from rmfs_commands.cli.toml_scenario import describe
from rmfs_core.scenario.model import RuleChoice, Scenario
from rmfs_core.scenario.service import ServiceTime, Spread
from rmfs_core.scenario.structuring import fields_of
from rmfs_core.scenario.writing import plain

_SINGLE = {int: "integer", float: "number", str: "string", bool: "boolean"}
_RULE_TABLE = {
    "type": "object",
    "description": "A rule and its parameters",
    "properties": {"rule": {"type": "string", "minLength": 1}},
    "required": ["rule"],
}


def scenario_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of scenario files."""
    return {
        **schema_of(Scenario, "rmfs scenario"),
        "$defs": {
            "rule": {
                "description": "A rule's name, ./file.py:Class, or a table of the rule and its parameters",
                "anyOf": [{"type": "string", "minLength": 1}, _RULE_TABLE],
            }
        },
    }


def schema_of(cls: type, title: str) -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a class with documented keys, and those of its parts."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": title, **_section(cls)}


def _section(cls: type) -> dict[str, Any]:
    types = get_type_hints(cls)
    fields = fields_of(cls)
    schema: dict[str, Any] = {
        "type": "object",
        "description": " ".join((cls.__doc__ or "").partition("\n\n")[0].split()),
        "properties": {key: _key(attribute, types[key]) for key, attribute in fields.items()},
        "additionalProperties": False,
    }
    if required := [key for key, attribute in fields.items() if attribute.default is attrs.NOTHING]:
        schema["required"] = required
    return schema


def _key(attribute: attrs.Attribute[Any], type_: Any) -> dict[str, Any]:
    schema = {**_type(type_), "description": describe(attribute.metadata)}
    checked = schema["anyOf"][0] if ServiceTime in get_args(type_) else schema
    checked.update(getattr(attribute.validator, "schema", {}))
    default = attribute.default
    if default is not attrs.NOTHING and default is not None and not isinstance(default, attrs.Factory):  # type: ignore[arg-type]
        schema["default"] = plain(default)
    return schema


def _type(type_: Any) -> dict[str, Any]:
    if type_ is Any or type_ in _SINGLE:
        return {} if type_ is Any else {"type": _SINGLE[type_]}
    if type_ is RuleChoice:
        return {"$ref": "#/$defs/rule"}
    if attrs.has(type_) or type_ is ServiceTime:
        return _section(Spread if type_ is ServiceTime else type_)
    arguments = get_args(type_)
    if get_origin(type_) in (UnionType, Union):
        kinds = [_type(kind) for kind in arguments if kind is not NoneType]
        return kinds[0] if len(kinds) == 1 else {"anyOf": kinds}
    if get_origin(type_) is tuple:
        return {"type": "array", "items": _type(arguments[0])}
    if get_origin(type_) is Mapping:
        values = _type(arguments[1])
        if NoneType in get_args(arguments[1]):  # in TOML there is none; as a value in JSON it has a meaning of its own
            values = {"anyOf": [values, {"type": "null"}]}
        return {"type": "object", "additionalProperties": values}
    raise TypeError(f"no JSON Schema for {type_}")
