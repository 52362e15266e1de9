"""TOML tables to scenario classes: strict about keys and types, and exact about where a mistake is.

A cattrs converter with hooks of its own, because cattrs converts `"8"` to 8 and True to 1, and because the first
mistake in the order of the file is the one to report: keys are structured in the order in which they were written.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import attrs
import cattrs

from rmfs_core.scenario.model import RuleChoice, Scenario
from rmfs_core.scenario.service import ServiceTime, Spread
from rmfs_core.scenario.source import KeyPath
from rmfs_core.scenario.tomltext import shown
from rmfs_core.timetable import Span
from rmfs_core.wording import nearest

T = TypeVar("T")
_SUCH = {Span: ' such as ["06:00", "22:00"]', tuple[Span, ...]: ' such as [["06:00", "22:00"]]'}


class KeyProblem(Exception):  # noqa: N818 - who reads turns it into an InputError with the place
    """A value is wrong; ``path`` leads to it from where structuring began."""

    def __init__(self, problem: str, path: KeyPath = ()) -> None:
        super().__init__(problem)
        self.problem = problem
        self.path = path

    def under(self, part: str | int) -> KeyProblem:
        """Return the same problem as seen from one level up."""
        return KeyProblem(self.problem, (part, *self.path))


def structure(data: Mapping[str, Any]) -> Scenario:
    """Return the scenario that ``data`` describes; raise KeyProblem for the first thing that is wrong."""
    return structure_as(Scenario, data)


def structure_as(cls: type[T], data: Any) -> T:
    """Return the object of a class with documented keys that ``data`` describes; raise KeyProblem as `structure`."""
    return _CONVERTER.structure(data, cls)


def fields_of(cls: type) -> dict[str, attrs.Attribute[Any]]:
    """Return the fields of a section class that are keys of the file."""
    return {a.name: a for a in attrs.fields(cls) if not a.metadata.get("internal")}


def section_class(cls: type, key: str) -> type | None:
    """Return the class of the table that ``key`` of a section holds, or None when it holds a value."""
    type_ = get_type_hints(cls)[key]
    kinds = [type_, *get_args(type_)]
    return next((kind for kind in kinds if isinstance(kind, type) and attrs.has(kind)), None)


def strict_converter() -> cattrs.Converter:
    """Return a converter that takes each value as it is written: no text for a number, no truth value for either."""
    converter = cattrs.Converter(forbid_extra_keys=True, detailed_validation=False)

    def exactly(what: str, *kinds: type) -> Callable[[Any, Any], Any]:
        def structure_value(value: Any, _: Any) -> Any:
            if type(value) not in kinds and not (str in kinds and isinstance(value, str)):
                raise KeyProblem(f"expected {what}, found {shown(value)}")
            return kinds[0](value)

        return structure_value

    def sequence(value: Any, type_: Any) -> Any:
        origin, kinds = get_origin(type_), get_args(type_)
        if not isinstance(value, (list, tuple)):
            raise KeyProblem(f"expected a list{_SUCH.get(type_, '')}, found {shown(value)}")
        if origin is list or kinds[1:] == (...,):
            kinds = (kinds[0],) * len(value)
        return origin(_at(i, entry, kind, converter) for i, (entry, kind) in enumerate(zip(value, kinds, strict=True)))

    def table(value: Any, type_: Any) -> dict[str, Any]:
        if not isinstance(value, Mapping):
            raise KeyProblem(f"expected a table, found {shown(value)}")
        return {key: _at(key, entry, get_args(type_)[1], converter) for key, entry in value.items()}

    def union(value: Any, type_: Any) -> Any:
        """`int | tuple[int, ...] | None`: a list goes to the tuple, anything else to the other type."""
        kinds = get_args(type_)
        if value is None and NoneType in kinds:
            return None
        listed = isinstance(value, (list, tuple))
        if {tuple, Mapping} <= {*map(get_origin, kinds)} and not isinstance(value, (tuple, list, Mapping)):
            raise KeyProblem(f"expected a list{_SUCH.get(kinds[0], '')}, or a table of lists, found {shown(value)}")
        kinds = tuple(kind for kind in kinds if kind is not NoneType)
        likely = [kind for kind in kinds if (get_origin(kind) in (list, tuple)) == listed] or [*kinds]
        likely.sort(key=lambda kind: kind is not type(value))
        for kind in likely[:-1]:
            with suppress(KeyProblem):
                return converter.structure(value, kind)
        return converter.structure(value, likely[-1])

    converter.register_structure_hook(int, exactly("a whole number", int))
    converter.register_structure_hook(float, exactly("a number", float, int))
    converter.register_structure_hook(str, exactly("a text in quotes", str))
    converter.register_structure_hook(bool, exactly("true or false", bool))
    for origins, hook in (((list, tuple), sequence), ((Mapping,), table), ((UnionType, Union), union)):
        converter.register_structure_hook_func(_has_origin(*origins), hook)
    return converter


def _has_origin(*origins: Any) -> Callable[[Any], bool]:
    return lambda type_: get_origin(type_) in origins


def _finite(value: Any, _: Any) -> float:
    if type(value) not in (int, float) or not abs(value) <= sys.float_info.max:  # NaN, too
        raise KeyProblem(f"expected a {'finite ' * (type(value) is float)}number, found {shown(value)}")
    return float(value)


def _at(part: str | int, value: Any, type_: Any, converter: cattrs.Converter | None = None) -> Any:
    try:
        return (converter or _CONVERTER).structure(value, type_)
    except KeyProblem as problem:
        raise problem.under(part) from None


def _rule(value: Any, _: Any) -> RuleChoice:
    if isinstance(value, str) and value:
        return RuleChoice(value)
    if not isinstance(value, Mapping):
        expected = 'the name of a rule or a table { rule = "...", parameter = ... }'
        raise KeyProblem(f"expected {expected}, found {shown(value)}")
    if "rule" not in value:
        raise KeyProblem("expected a key `rule` with the name of a rule in addition to the parameters, found none")
    rule = _at("rule", value["rule"], str)
    return RuleChoice(rule, {key: entry for key, entry in value.items() if key != "rule"})


def _service_time(value: Any, _: Any) -> ServiceTime:
    if not isinstance(value, Mapping):
        raise KeyProblem(f"expected a number, or a table {{ mean = ..., cv = ... }}, found {shown(value)}")
    return ServiceTime(_CONVERTER.structure(value, Spread))


def _section(cls: type) -> Callable[[Any, Any], Any]:
    fields, types = fields_of(cls), get_type_hints(cls)

    def structure_section(value: Any, _: Any) -> Any:
        if not isinstance(value, Mapping):
            raise KeyProblem(f"expected a table, found {shown(value)}")
        arguments = {}
        for key, entry in value.items():
            if key not in fields:
                raise KeyProblem(f"unknown key{getattr(cls, f'no_{key}', None) or nearest(key, fields)}", (key,))
            arguments[key] = _at(key, entry, types[key])
            if fields[key].validator is not None:
                try:
                    fields[key].validator(None, fields[key], arguments[key])  # type: ignore[misc]
                except ValueError as problem:
                    raise KeyProblem(str(problem), (key,)) from None
        for key, attribute in fields.items():
            if attribute.default is attrs.NOTHING and key not in value:
                raise KeyProblem("this part is missing", (key,))
        try:
            return cls(**arguments)
        except ValueError as problem:
            raise KeyProblem(str(problem)) from None

    return structure_section


_CONVERTER = strict_converter()
_CONVERTER.register_structure_hook(float, _finite)
_CONVERTER.register_structure_hook_factory(attrs.has, _section)
_CONVERTER.register_structure_hook(RuleChoice, _rule)
_CONVERTER.register_structure_hook(ServiceTime, _service_time)
