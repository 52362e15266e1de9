"""Experiment files to experiments."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from operator import attrgetter
from pathlib import Path
from typing import Any

from rmfs_commands.experiments.changes import SCENARIO_KEYS, changes_of
from rmfs_commands.experiments.experiment import (
    DEFAULT_METRICS,
    HORIZON_METRICS,
    SECTION_METRICS,
    Axis,
    AxisPoint,
    Base,
    Experiment,
    RuleSetChoice,
)
from rmfs_commands.instances.toml_lines import read_toml
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.scenario import load_scenario, shipped_scenarios
from rmfs_core.scenario.reading import EXPERIMENTS, shipped_folder
from rmfs_core.scenario.source import KeyPath, Source
from rmfs_core.scenario.structuring import KeyProblem
from rmfs_core.scenario.tomltext import shown
from rmfs_core.wording import did_you_mean, nearest

KEYS = ("name", "description", "base", "scenarios", "axes", "rule_sets", "seeds", "baseline", "metrics", "by", "fronts")
ONE_RULE = tuple(f"rules.{role.key}" for role in Role if not role.many)
"""Scenario keys that name one rule: a list of them makes several rule sets."""
MOST_SEEDS = 100_000
"""A typing error must not fill the memory with runs."""
LARGEST = 2**63 - 1
"""The largest whole number that a column of runs.parquet can have."""


def shipped_experiments() -> dict[str, Path]:
    """Return the files of the shipped experiments by name, sorted."""
    return {path.stem: path for path in sorted((shipped_folder() / EXPERIMENTS).glob("*.toml"))}


def load_experiment(path: str | Path) -> Experiment:
    """Read an experiment file.

    Parameters
    ----------
    path
        A file, or the name of a shipped experiment.

    Raises
    ------
    InputError
        When something is wrong; file, line where it is known, and key are named.
    """
    file = _find(Path(path))
    try:
        text = file.read_bytes().decode("utf-8-sig").replace("\r\n", "\n")
        data = read_toml(text)
    except OSError as error:
        raise InputError(str(file), f"cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise InputError(str(file), f"expected UTF-8 text: {error.reason}") from error
    except ValueError as error:
        raise InputError(str(file), f"this is no valid TOML: {error}") from error
    source = Source(str(file), text)
    try:
        return _experiment(data, file, source.place_of(("metrics",)))
    except KeyProblem as problem:
        raise InputError(source.place_of(problem.path), problem.problem) from None


def _find(path: Path) -> Path:
    if os.path.isfile(path):  # noqa: PTH113 (False for a name that is too long, too)
        return path
    shipped = shipped_experiments()
    name = path.as_posix().removesuffix(".toml")
    if name in shipped:
        return shipped[name]
    if os.path.isdir(path):  # noqa: PTH112 (as above)
        raise InputError(str(path), "expected an experiment file, found a folder")
    raise InputError(
        str(path), f"there is no such file, and no shipped experiment of that name{nearest(name, shipped)}"
    )


def _experiment(data: Mapping[str, Any], file: Path, metrics_place: str) -> Experiment:
    for key in data:
        if key not in KEYS:
            raise KeyProblem(f"unknown key{nearest(key, KEYS)}", (key,))
    for key in ("rule_sets", "seeds", "baseline"):
        if key not in data:
            raise KeyProblem("this part is missing", (key,))
    name = _text(data, "name", file.stem)
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]*", name):
        raise KeyProblem(f"expected letters, digits, `.`, `_` and `-`, found {shown(name)}", ("name",))
    bases = tuple(_bases(data, file.parent))
    try:
        axes = tuple(axes_of(_table(data.get("axes", {}), ("axes",))))
        rule_sets = tuple(_rule_sets(data["rule_sets"]))
        changes = [point.changes for axis in axes for point in axis.points]
        changes += [rule_set.changes for rule_set in rule_sets]
        limited = any(base.scenario.run.until_s is not None for base in bases)
        usual = HORIZON_METRICS if limited or any("run.until_s" in one for one in changes) else DEFAULT_METRICS
        for section, more in SECTION_METRICS.items():
            has = any(attrgetter(section)(base.scenario) is not None for base in bases)
            if has or any(key.startswith(section) for one in changes for key in one):
                usual += more
        return Experiment(
            name=name,
            description=_text(data, "description", ""),
            bases=bases,
            axes=axes,
            rule_sets=rule_sets,
            seeds=_seeds(data["seeds"]),
            baseline=_text(data, "baseline", ""),
            metrics=_texts(data, "metrics", usual),
            by=_texts(data, "by", ()),
            fronts=_fronts(data.get("fronts", [])),
            folder=str(file.parent),
            place=str(file),
            metrics_place=metrics_place,
        )
    except InputError as error:
        first, _, rest = error.place.partition(".")
        raise KeyProblem(error.problem, (first, rest) if rest else (first,)) from None


def _text(data: Mapping[str, Any], key: str, default: str) -> str:
    value = data.get(key, default)
    if not isinstance(value, str):
        raise KeyProblem(f"expected a text in quotes, found {shown(value)}", (key,))
    return value


def _texts(data: Mapping[str, Any], key: str, default: tuple[str, ...]) -> tuple[str, ...]:
    value = data.get(key, list(default))
    if not isinstance(value, list) or not all(isinstance(entry, str) for entry in value):
        raise KeyProblem(f"expected a list of texts in quotes, found {shown(value)}", (key,))
    return tuple(value)


def _table(value: Any, path: KeyPath) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise KeyProblem(f"expected a table, found {shown(value)}", path)
    return value


def _bases(data: Mapping[str, Any], folder: Path) -> Iterator[Base]:
    if ("base" in data) == ("scenarios" in data):
        raise KeyProblem("expected either `base`, a scenario, or `scenarios`, a list of them", ())
    key = "base" if "base" in data else "scenarios"
    names = (_text(data, key, ""),) if key == "base" else _texts(data, key, ())
    for name in names:
        shipped = shipped_scenarios()
        beside = folder / name
        is_file = os.path.isfile(beside)  # noqa: PTH113 (as above)
        if not is_file and name.removesuffix(".toml") not in shipped:
            raise KeyProblem(
                f"there is no scenario {name} in {folder}, and none of that name is shipped{nearest(name, shipped)}",
                (key,),
            )
        found = beside if is_file else shipped[name.removesuffix(".toml")]
        yield Base(name.removesuffix(".toml"), load_scenario(found))


def _seeds(value: Any) -> tuple[int, ...]:
    expected = "expected a list of whole numbers >= 0, or { first = 1, count = 10 }"
    if isinstance(value, Mapping):
        if value.keys() - {"first", "count"} or "count" not in value:
            raise KeyProblem(f"{expected}, found {shown(value)}", ("seeds",))
        first, count = value.get("first", 1), value["count"]
        if type(first) is not int or type(count) is not int or first < 0 or count < 1:
            raise KeyProblem(f"{expected}, found {shown(value)}", ("seeds",))
        if count > MOST_SEEDS:
            raise KeyProblem(f"expected at most {MOST_SEEDS:,} seeds, found {count:,}", ("seeds",))
        value = range(first, first + count)
    if not isinstance(value, list | range) or not all(type(seed) is int and seed >= 0 for seed in value):
        raise KeyProblem(f"{expected}, found {shown(value)}", ("seeds",))
    _check_storable(value, ("seeds",))
    return tuple(value)


def _check_storable(values: Iterable[Any], path: KeyPath) -> None:
    """Raise KeyProblem for a whole number that no column of the table of runs can have."""
    for value in values:
        if isinstance(value, int) and not -LARGEST <= value <= LARGEST:
            raise KeyProblem(f"expected whole numbers up to {LARGEST}, found {shown(value)}", path)


def _fronts(value: Any) -> tuple[tuple[str, str], ...]:
    pairs = value if isinstance(value, list) else [value]
    for pair in pairs:
        if not isinstance(pair, list) or len(pair) != 2 or not all(isinstance(one, str) for one in pair):
            raise KeyProblem(f"expected a list of pairs of metrics, found {shown(value)}", ("fronts",))
    return tuple((first, second) for first, second in pairs)


def _rule_sets(value: Any) -> Iterator[RuleSetChoice]:
    if not isinstance(value, list):
        raise KeyProblem("expected one or more tables [[rule_sets]]", ("rule_sets",))
    names = set()
    for place, entry in enumerate(value):
        table = dict(_table(entry, ("rule_sets", place)))
        name = table.pop("name", "")
        try:
            changes = changes_of(table)
        except KeyProblem as problem:
            named = f'rule set "{name}": ' if name else ""
            raise KeyProblem(f"{named}{problem.problem}", ("rule_sets", place, *problem.path)) from None
        several = {key: found for key, found in changes.items() if key in ONE_RULE and isinstance(found, list)}
        if not isinstance(name, str) or not (name or several):
            raise KeyProblem(
                f"expected a `name` in each [[rule_sets]], found none in number {place + 1}", ("rule_sets",)
            )
        for choice in itertools.product(*several.values()):
            labels = " + ".join(map(label_of, choice))
            whole = ": ".join(part for part in (name, labels) if part)
            if whole in names:
                raise KeyProblem(f"found {whole} twice; expected each once", ("rule_sets", place))
            names.add(whole)
            yield RuleSetChoice(whole, changes | dict(zip(several, choice, strict=True)))


def label_of(choice: Any) -> str:
    """Return what one of several rules adds to the name of its rule set: its name, and the parameters that it has."""
    if not isinstance(choice, Mapping):
        return str(choice)
    parameters = [f"{key} = {shown(entry)}" for key, entry in choice.items() if key != "rule"]
    return " ".join([str(choice.get("rule", "")), *([f"({', '.join(parameters)})"] if parameters else [])])


def axes_of(table: Mapping[str, Any]) -> Iterator[Axis]:
    """Yield the axes of `[axes]`: scenario keys, dotted or nested, and groups of keys under a name of their own."""
    for key, value in table.items():
        if key.split(".")[0] not in SCENARIO_KEYS:
            yield _group(key, value)
            continue
        for dotted, values in _flat(changes_of({key: value})):
            if not isinstance(values, list):
                raise KeyProblem(f"expected a list of values, found {shown(values)}", ("axes", key))
            _check_storable(values, ("axes", key))
            yield Axis(dotted, tuple(_point(dotted, entry) for entry in values))


def _flat(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield dotted keys and values, of tables in a table (``instance.parameters``) as well."""
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield from _flat({f"{key}.{inner}": entry for inner, entry in value.items()})
        else:
            yield key, value


def _point(key: str, value: Any) -> AxisPoint:
    text = value if isinstance(value, str) else shown(value)
    return AxisPoint(
        f"{key.rpartition('.')[2]}={text}", text if isinstance(value, list | dict) else value, {key: value}
    )


def _group(name: str, value: Any) -> Axis:
    path = ("axes", name)
    if name == "seed":
        raise KeyProblem("seeds are no axis; expected them as `seeds` above it", path)
    if not isinstance(value, list) or not all(isinstance(entry, Mapping) for entry in value):
        raise KeyProblem(
            "expected a scenario key, or a list of tables { label = ..., key = ... }"
            f"{did_you_mean(name, SCENARIO_KEYS)}",
            path,
        )
    points = []
    for entry in value:
        keys = dict(entry)
        label = keys.pop("label", None)
        if not isinstance(label, str | int | float) or label == "":
            raise KeyProblem(f"expected a `label` in each table, found none in {shown(entry)}", path)
        _check_storable([label], path)
        try:
            points.append(AxisPoint(f"{name}={label}", label, changes_of(keys)))
        except KeyProblem as problem:
            raise KeyProblem(problem.problem, (*path, *problem.path)) from None
    return Axis(name, tuple(points))
