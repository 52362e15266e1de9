"""Scenario files to scenarios."""

from __future__ import annotations

import importlib.util
import os.path
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from attrs import evolve, frozen

from rmfs_core import entrypoints
from rmfs_core.entrypoints import format_module
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import PACKING_RULES, Scenario, replaced_keys
from rmfs_core.scenario.rulenames import check_rule_name, rule_choices
from rmfs_core.scenario.service import with_times
from rmfs_core.scenario.source import Source, undotted
from rmfs_core.scenario.structuring import KeyProblem, fields_of, structure
from rmfs_core.wording import nearest


def load_scenario(path: str | Path, overrides: Sequence[str] = (), seed: int | None = None) -> Scenario:
    """Read a scenario file.

    Parameters
    ----------
    path
        A file, or the name of a shipped scenario: ``paper-250``, ``examples/small``.
    overrides
        ``key=value`` each, as after ``--set``: a dotted key and a TOML value (or a plain text) that replaces the
        file's. Nothing after the ``=`` takes a key out. Files that they name are looked up in the current directory.
    seed
        Replaces the file's seed.

    Returns
    -------
    Scenario
        With ``folder`` set to the file's folder, where the files that it names are looked up.

    Raises
    ------
    InputError
        For the first thing that is wrong in the order of the file.
    """
    given = read_tables(path, overrides, seed)
    try:
        return given.scenario()
    except KeyProblem as problem:
        raise InputError(given.source.place_of(problem.path), problem.problem) from None


@frozen
class Given:
    """A scenario as it was given, not yet checked: nested tables, the scenario's folder, and where they came from."""

    data: dict[str, Any]
    folder: Path
    source: Source

    def scenario(self) -> Scenario:
        """Return the scenario; raise KeyProblem for the first thing that is wrong in the order of the tables."""
        scenario = evolve(structure(with_times(self.data, self.folder)), folder=str(self.folder), source=self.source)
        _check_replaced(scenario, self.data)
        _check_rule_names(scenario)
        return scenario


def read_tables(path: str | Path, overrides: Sequence[str] = (), seed: int | None = None) -> Given:
    """Read a scenario file and apply overrides, as `load_scenario` does; keys and values are not checked."""
    file = _find(path)
    text = _read(file)
    parsed = format_module("overrides").parsed(overrides, Path.cwd(), file.parent) if overrides else ()
    source = Source(str(file), text, tuple((override.text, override.path) for override in parsed))
    try:
        data = format_module("toml").read_toml(text)
    except ValueError as error:
        raise _syntax_error(source.name, error) from None
    data = format_module("overrides").apply_overrides(data, parsed) if overrides else data
    return Given(data if seed is None else {**data, "seed": seed}, file.parent, source)


def scenario_from_dict(data: Mapping[str, Any], folder: str = ".", name: str = "scenario") -> Scenario:
    """Return the scenario that nested tables describe, as `scenario_to_dict` returns them.

    Parameters
    ----------
    data
        Tables and values as tomllib reads them.
    folder
        Where relative file names are looked up.
    name
        Name of the source in messages.
    """
    try:
        return evolve(structure(with_times(data, Path(folder))), folder=folder)
    except KeyProblem as problem:
        raise InputError(Source(name).place_of(problem.path), problem.problem) from None


@contextmanager
def located(scenario: Scenario) -> Iterator[None]:
    """Give every InputError raised within that names a key (``rules.poa``) the file and line of that key as well."""
    try:
        yield
    except InputError as error:
        path, source = undotted(error.place), scenario.source
        if source is None or error.place.startswith(f"{source.name}, ") or path[0] not in fields_of(Scenario):
            raise
        raise InputError(source.place_of(path), error.problem) from error


def _check_replaced(scenario: Scenario, data: Mapping[str, Any]) -> None:
    """Raise KeyProblem for a key that would be ignored in silence, for a file or for want of packing."""
    for name in ("instance", "layout"):
        file, replaced = replaced_keys(getattr(scenario, name))
        for key in data.get(name, {}):
            if key in replaced:
                raise KeyProblem(f"has no effect with `{name}.{file}`; leave one of them out", (name, key))
    for key in data.get("rules", {}) if scenario.packing is None else ():
        if key in PACKING_RULES:
            raise KeyProblem("has no effect without a section `packing`; leave it out", ("rules", key))


def _check_rule_names(scenario: Scenario) -> None:
    """Raise KeyProblem for a rule that is not installed, or whose file does not exist."""
    names = entrypoints.offers(entrypoints.RULES)
    for path, choice in rule_choices(scenario.rules):
        try:
            check_rule_name(choice.rule, Path(scenario.folder), names)
        except KeyProblem as problem:
            raise KeyProblem(problem.problem, ("rules", *path)) from None


def _find(path: str | Path) -> Path:
    file = Path(path)
    if os.path.isfile(file):  # noqa: PTH113 (False for a name that is too long, too)
        return file
    shipped = shipped_scenarios()
    name = file.as_posix().removesuffix(".toml")
    if name in shipped:
        return shipped[name]
    if os.path.isdir(path):  # noqa: PTH112 (likewise)
        raise InputError(str(path), "expected a scenario file, found a folder")
    missing = "there is no such file, and no shipped scenario of that name"
    raise InputError(str(path) or '""', f"{missing}{nearest(name, shipped)}")


def _read(file: Path) -> str:
    try:
        # tomllib refuses the byte order mark that some editors write, and knows no other line end than \n and \r\n.
        return file.read_bytes().decode("utf-8-sig").replace("\r\n", "\n")
    except OSError as error:
        raise InputError(str(file), f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InputError(str(file), f"expected UTF-8 text, found the byte 0x{error.object[error.start]:02x}") from None


def _syntax_error(name: str, error: ValueError) -> InputError:
    """Move the line from the end of tomllib's message to the front."""
    message, place = str(error), name
    if match := re.search(r" \(at line (\d+), column (\d+)\)$", message):
        place, message = f"{name}, line {match[1]}, column {match[2]}", message[: match.start()]
    hint = "; texts need quotes" if message == "Invalid value" else ""
    return InputError(place, f"this is no valid TOML: {message}{hint}")


PACKAGE = "rmfs_scenarios"  # the top-level folder `scenarios`, under the name it is installed by
EXPERIMENTS = "experiments"  # the subfolder of the shipped experiments, which are no scenarios


def shipped_folder() -> Path:
    """Return the folder of the shipped scenarios."""
    package = importlib.util.find_spec(PACKAGE)
    if package is not None and package.submodule_search_locations:
        return Path(next(iter(package.submodule_search_locations)))
    return Path(__file__).parents[2] / "scenarios"  # run from a checkout that is on the path but not installed


def shipped_scenarios() -> dict[str, Path]:
    """Return the files of the shipped scenarios by name (``paper-250``, ``examples/small``), sorted."""
    folder = shipped_folder()
    paths = (path.relative_to(folder) for path in folder.rglob("*.toml"))
    files = {path.with_suffix("").as_posix(): folder / path for path in paths if path.parts[0] != EXPERIMENTS}
    return dict(sorted(files.items()))
