"""From a scenario's parameters to an instance of a rule's class."""

from __future__ import annotations

import inspect
import re
import typing
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import attrs

from rmfs_core.entrypoints import hints_of, kinds_of
from rmfs_core.errors import InputError, refusing
from rmfs_core.rules.parts import FileProblem, find_file, parts_now
from rmfs_core.scenario.structuring import strict_converter
from rmfs_core.scenario.tomltext import shown
from rmfs_core.wording import did_you_mean, listed

MOST, MOST_NESTED = 1e12, 20
"""Numbers are smaller: rules count in 64 bits (infinite: if metadata has ``infinite``); tables in one another."""
_WORDS = {int: "a whole number", float: "a number", str: "a text", bool: "true or false", type(None): "nothing"}
_WORDS[Path] = "the name of a file"


def _file(value: Any, kind: Any) -> Any:
    """`Path`, `Path | str`, `Path | None`: a text is the name of a file."""
    if isinstance(value, str):
        return find_file(value)
    others: Any = typing.Union[tuple(part for part in kinds_of(kind) if part is not Path) or typing.Never]  # noqa: UP007
    return _converter.structure(value, others)


_converter = strict_converter()
_converter.register_structure_hook(Path, _file)
_converter.register_structure_hook_func(lambda kind: Path in kinds_of(kind), _file)


def parameters_of(rule: type) -> dict[str, attrs.Attribute[Any]]:
    """Return the fields of a rule's class that a scenario can set, by the name used there."""
    return {field.alias or field.name: field for field in attrs.fields(rule) if field.init}


def values_of(rule: object) -> dict[str, Any]:
    """Return the parameters of a rule's object that are not its class's defaults, as a scenario would have them."""
    values = {name: (field, plain(getattr(rule, field.name))) for name, field in parameters_of(type(rule)).items()}
    return {name: value for name, (field, value) in values.items() if value != plain(field.default)}


def plain(value: Any, around: int = 0) -> Any:
    """Return a value as a scenario has it: a path as text, ``<type>`` for no plain value, such as a function."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Path):
        return value.as_posix()
    if isinstance(value, list | tuple) and around < MOST_NESTED:
        return [plain(entry, around + 1) for entry in value]
    if isinstance(value, Mapping) and around < MOST_NESTED:
        return {str(key): plain(entry, around + 1) for key, entry in value.items()}
    return f"<{type(value).__name__}>"


def build(rule: type, values: Mapping[str, Any], place: str, rule_name: str) -> Any:
    """Return a new instance of a rule's class with these parameters; raise `InputError` where one is wrong."""
    valid = parameters_of(rule)
    for name in values:
        if name not in valid:
            unknown = f"{rule_name} has no parameter `{name}`{did_you_mean(name, valid)}"
            has = f"valid parameters are {listed(valid)}" if valid else "it has no parameters"
            raise InputError(f"{place}.{name}", f"{unknown}; {has}")
    for name, field in valid.items():
        if field.default is attrs.NOTHING and name not in values:
            raise InputError(f"{place}.{name}", f"{rule_name} needs the parameter `{name}`, which is missing")
    hints = type_hints(rule)
    parts_now().classes.append(rule)
    named = {name: field.default for name, field in valid.items() if isinstance(field.default, Path)}
    given = {**{name: str(default) for name, default in named.items()}, **values}
    ready = {name: _structure(valid[name], hints, value, f"{place}.{name}") for name, value in given.items()}
    with refusing(place, f"{rule_name} cannot be created:", but=InputError):
        try:
            return rule(**ready)
        except (ValueError, TypeError) as error:
            _blame_parameter(rule, ready, place)
            raise InputError(place, f"{rule_name}: {_text(error)}") from error


@lru_cache(maxsize=256)
def type_hints(rule: type) -> Mapping[str, Any]:
    """Return the types of a rule's fields; one whose name is imported under TYPE_CHECKING alone is left out."""
    hints = (hints_of(inspect.get_annotations(cls), cls.__module__) for cls in reversed(rule.__mro__))
    return {name: hint for found in hints for name, hint in found.items()}


def _structure(field: attrs.Attribute[Any], hints: Mapping[str, Any], value: Any, place: str) -> Any:
    kind = hints.get(field.name)
    if (field.converter is not None and not _names_files(kind)) or kind is None or kind is Any:
        return value
    try:
        structured = _converter.structure(value, kind)
    except FileProblem as error:
        raise InputError(place, str(error)) from None
    except Exception as error:
        raise InputError(place, f"expected {type_name(kind)}, found {shown(value)}") from error
    fits = not isinstance(structured, int | float) or abs(structured) < MOST  # NaN does not
    if not fits and not (structured == float("inf") and field.metadata.get("infinite")):
        raise InputError(place, f"expected {type_name(kind)} below {MOST:g}, found {shown(value)}")
    return structured


def _names_files(kind: Any) -> bool:
    return kind is Path or any(map(_names_files, typing.get_args(kind)))


def type_name(kind: Any) -> str:
    """Name a parameter's type for people: ``a whole number``, ``a number or nothing``, ``one of "a", "b"``."""
    if kind in _WORDS:
        return _WORDS[kind]
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if (kinds := kinds_of(kind)) != (kind,):
        return listed(map(type_name, kinds), "or")
    if origin is typing.Literal:
        return f"one of {', '.join(map(shown, arguments))}"
    if origin is tuple and arguments[1:] != (...,):
        return f"a list of {listed(type_name(part) for part in arguments)}"
    if origin in (list, tuple):
        return f"a list, each {type_name(arguments[0])}"
    return getattr(kind, "__name__", str(kind))


def _blame_parameter(rule: type, values: Mapping[str, Any], place: str) -> None:
    """Raise `InputError` with the parameter's own place if one validator alone refuses its value."""
    for name, field in parameters_of(rule).items():
        if field.validator is None or name not in values:
            continue
        try:
            with attrs.validators.disabled():
                instance = rule(**values)
        except Exception:  # the class refuses the values for another reason, which the caller reports
            return
        value = getattr(instance, field.name)
        try:
            field.validator(instance, field, value)
        except (ValueError, TypeError) as error:
            text = _text(error)
            found = "" if "found" in text or repr(value) in text else f", found {shown(value)}"
            raise InputError(f"{place}.{name}", f"{text}{found}") from error


def _text(error: Exception) -> str:
    """Return the sentence of a validator's error; attrs' own carry more arguments than the text, and name the field."""
    text = " ".join(str(error.args[0] if error.args else error).split()) or type(error).__name__
    return re.sub(r"^'\w+' must be ([<>]=? \S+): (.*)$", r"expected a number \1, found \2", text)
