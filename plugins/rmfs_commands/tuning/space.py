"""Parameters that are searched over, and their ranges."""

from __future__ import annotations

import re
import tomllib
import typing
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Self

import attrs
from attrs import frozen

from rmfs_commands.experiments import Axis, experiment_file
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.rules import RuleSet
from rmfs_core.rules.parameters import MOST, parameters_of, type_hints
from rmfs_core.scenario.structuring import KeyProblem
from rmfs_core.scenario.tomltext import shown, toml_value
from rmfs_core.scenario.writing import plain
from rmfs_core.wording import did_you_mean, listed

WIDER = 8
"""A parameter without a range is searched from its value over this to its value times this, on a log scale."""
_RANGE = re.compile(r"(?P<low>[-+.\deE]+)\.\.(?P<high>[-+.\deE]+)")

Values = Mapping[str, Any]
"""A value for each parameter, by its key: ``pps.max_wait_s``."""


@frozen
class Parameter:
    """A parameter of a rule, and what is tried for it.

    Parameters
    ----------
    key
        Key of the rule in ``[rules]`` and name of the parameter: ``pps.max_wait_s``.
    now
        Value that the scenario has.
    low, high
        Ends of the range of a number; None where ``choices`` are tried.
    whole
        Whether only whole numbers are tried.
    log
        Whether numbers are tried on a log scale.
    choices
        Values instead of a range.
    """

    key: str
    now: Any
    low: float | None = None
    high: float | None = None
    whole: bool = False
    log: bool = False
    choices: tuple[Any, ...] = ()

    @property
    def shown(self) -> str:
        """The values that are tried: ``60..1200``, ``random, lowest``."""
        return f"{self.low:g}..{self.high:g}" if self.low is not None else ", ".join(map(shown, self.choices))

    @property
    def holds_now(self) -> bool:
        """Whether the scenario's value is among those tried."""
        if self.low is None or self.high is None:
            return self.now in self.choices
        return isinstance(self.now, int | float) and self.low <= self.now <= self.high

    def checked(self, attribute: attrs.Attribute[Any], place: str) -> Self:
        """Return the parameter; raise `InputError` where the rule refuses an end of the range or a choice."""
        for value in self.choices or (self.low, self.high):
            given = int(value) if self.whole and value is not None else value
            if not _accepts(attribute, given):
                raise InputError(
                    place, f"the rule refuses {shown(given)} for `{self.key}`; `rmfs rules` says what it takes"
                )
        return self


@frozen
class Space:
    """The parameters that are searched, and the rules that they belong to.

    Parameters
    ----------
    parameters
        By key.
    rules
        A table for each rule that has parameters here, by its key in ``[rules]`` of the scenario.
    others
        Everything else in that section.
    left
        Keys of parameters that have no range of their own.
    """

    parameters: tuple[Parameter, ...]
    rules: Mapping[str, Mapping[str, Any]]
    others: Mapping[str, Any]
    left: tuple[str, ...] = ()

    def changes(self, values: Values) -> dict[str, Any]:
        """Return the scenario keys that give the rules these values: ``rules.pps`` and a table."""
        found = {key: dict(table) for key, table in self.rules.items()}
        for key, value in values.items():
            rule, _, name = key.partition(".")
            found[rule][name] = value
        return {f"rules.{key}": table for key, table in found.items()}

    def fragment(self, values: Values) -> str:
        """Return the section of a scenario file with all rules, and these values."""
        tuned = {key.removeprefix("rules."): table for key, table in self.changes(values).items()}
        given = {**tuned, **self.others}.items()
        return "[rules]\n" + "".join(f"{key} = {toml_value(value)}\n" for key, value in given if value != [])


def make_space(rules: RuleSet, scenario_rules: Any, searched: Sequence[str], given: Sequence[str]) -> Space:
    """Return what is searched.

    Parameters
    ----------
    rules
        The scenario's rules.
    scenario_rules
        Its section ``[rules]``.
    searched
        Keys of rules of which all parameters with a known range are searched.
    given
        Parameters with their ranges: ``pps.max_wait_s=60..1200``, ``pod-index``'s ``poa_pps.most_pods=2,3,4``.

    Raises
    ------
    InputError
        When there is no such rule or parameter, a range is none, or nothing is left to search.
    """
    tunable: dict[str, Any] = {role.key: bound for role, bound in _single(rules)}
    found: dict[str, Parameter] = {}
    left: list[str] = []
    for key in searched:
        if key not in tunable:
            raise _unknown("--rules", key, tunable)
        for name, attribute in parameters_of(type(tunable[key])).items():
            parameter = _with_known_range(tunable[key], f"{key}.{name}", attribute)
            if parameter is None:
                left.append(f"{key}.{name}")
            else:
                found[parameter.key] = parameter
    for text in given:
        parameter = _given(text, tunable)
        found[parameter.key] = parameter
        left = [key for key in left if key != parameter.key]
    if not found:
        raise InputError("--rules", "no parameter has a range; expected `--parameter pps.NAME=LOW..HIGH`")
    tables = {}
    for key in dict.fromkeys(parameter.partition(".")[0] for parameter in found):
        choice = getattr(scenario_rules, key)
        tables[key] = {"rule": choice.rule, **choice.parameters}
    others = {key: value for key, value in plain(scenario_rules).items() if key not in tables}
    return Space(tuple(found.values()), tables, others, tuple(left))


def axes_of(texts: Sequence[str]) -> tuple[Axis, ...]:
    """Return what texts such as ``instance.skus=[20, 100]`` vary; raise `InputError` where one is none."""
    found: list[Axis] = []
    for text in texts:
        try:
            found += experiment_file.axes_of(tomllib.loads(text))
        except tomllib.TOMLDecodeError:
            raise InputError(f"--axis {text}", "expected KEY=[A, B], as in instance.skus=[20, 100]") from None
        except KeyProblem as problem:
            raise InputError(f"--axis {text}", problem.problem) from None
    return tuple(found)


def _single(rules: RuleSet) -> Iterator[tuple[Role, Any]]:
    """Yield the rules that are alone in their role."""
    for role in Role:
        bound = getattr(rules, role.key, None)
        if bound is not None and not isinstance(bound, list | tuple):
            yield role, bound.instance


def _given(text: str, tunable: Mapping[str, Any]) -> Parameter:
    """Return the parameter that a text names, with its range."""
    place = f"--parameter {text}"
    key, equals, tried = (part.strip() for part in text.partition("="))
    rule, _, name = key.partition(".")
    if not (equals and tried and name):
        raise InputError(place, "expected RULE.NAME=LOW..HIGH or RULE.NAME=A,B,C, as in pps.max_wait_s=60..1200")
    if rule not in tunable:
        raise _unknown(place, rule, tunable)
    valid = parameters_of(type(tunable[rule]))
    if name not in valid:
        raise InputError(
            place, f"the rule has no parameter `{name}`{did_you_mean(name, valid)}; it has {listed(valid)}"
        )
    cls: Any = type(tunable[rule])
    kind = type_hints(cls).get(valid[name].name)
    now = getattr(tunable[rule], valid[name].name)
    words = _words(kind, valid[name])
    match = None if words else _RANGE.fullmatch(tried)
    if match is None:
        choices = tuple(_value(one.strip()) for one in tried.split(","))
        if kind in (int, float) and any(isinstance(one, str) for one in choices):
            raise InputError(place, f"expected a range such as 0..2, or numbers with commas, found {tried}")
        if words and not {*map(repr, choices)} <= {*map(repr, words)}:
            raise InputError(place, f"expected some of {', '.join(map(shown, words))}, found {tried}")
        return Parameter(key, now, choices=choices).checked(valid[name], place)
    try:
        low, high = float(match["low"]), float(match["high"])
    except ValueError:
        low, high = 1.0, 0.0
    kinds = {kind, *typing.get_args(kind)}
    whole = int in kinds and float not in kinds
    if not (-MOST < low < high < MOST) or (whole and not (low.is_integer() and high.is_integer())):
        wanted = "two whole numbers" if whole else "two numbers"
        raise InputError(place, f"expected {wanted}, the lower one first, found {tried}")
    return Parameter(key, now, low, high, whole, low > 0 and high / low > WIDER).checked(valid[name], place)


def _words(kind: Any, attribute: attrs.Attribute[Any]) -> tuple[Any, ...]:
    """Return the values that a parameter may have, if its type or its check lists them."""
    if kind is bool:
        return False, True
    if typing.get_origin(kind) is typing.Literal:
        return typing.get_args(kind)
    return tuple(getattr(attribute.validator, "options", ()))  # of `attrs.validators.in_`


def _unknown(place: str, rule: str, tunable: Mapping[str, Any]) -> InputError:
    keys, near = listed(tunable, "or"), did_you_mean(rule, tunable)
    return InputError(place, f"expected a key of the scenario's rules, {keys}, found {rule}{near}")


def _value(text: str) -> Any:
    """Return a choice as the rule's parameter has it."""
    words = {"true": True, "false": False}
    if text in words:
        return words[text]
    for number in (int, float):
        try:
            return number(text)
        except ValueError:
            continue
    return text


def _with_known_range(rule: Any, key: str, attribute: attrs.Attribute[Any]) -> Parameter | None:
    """Return a parameter whose range its type, its check and its value tell; None for any other."""
    cls: Any = type(rule)
    kind, now = type_hints(cls).get(attribute.name), getattr(rule, attribute.name)
    if words := _words(kind, attribute):
        return Parameter(key, now, choices=words)
    if kind not in (int, float) or not isinstance(now, int | float):
        return None
    if kind is float and 0 <= now <= 1 and _accepts(attribute, 1.0) and not _accepts(attribute, 1.01):  # a share
        return Parameter(key, now, 0.0 if _accepts(attribute, 0.0) else 0.01, 1.0)
    low, high = now / WIDER, now * WIDER
    if kind is int:
        low, high = max(1, int(low)), int(high)
    if not (0 < low < high < MOST and _accepts(attribute, low) and _accepts(attribute, high)):
        return None
    return Parameter(key, now, float(low), float(high), kind is int, log=True)


def _accepts(attribute: attrs.Attribute[Any], value: Any) -> bool:
    """Whether a parameter's own check lets a value pass."""
    if attribute.validator is None:
        return True
    try:
        attribute.validator(None, attribute, value)
    except (TypeError, ValueError):
        return False
    return True
