"""A base scenario and the keys that axes and rule sets set: the scenario of a run."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from attrs import evolve

from rmfs_commands.instances.overrides import Override, apply_overrides, data_files, given_in
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario, scenario_from_dict, scenario_to_dict
from rmfs_core.scenario.model import replaced_keys
from rmfs_core.scenario.rulenames import file_name_from, is_inline, rule_choices
from rmfs_core.scenario.tomltext import shown

STATE = "instance.state_file"
Changes = Mapping[str, Any]
"""Dotted scenario keys (``rules.poa``) and their values."""


def resolve(base: Scenario, changes: Changes, folder: str, place: str) -> Scenario:
    """Return the base with keys changed.

    Setting ``rules.poa_pps`` takes ``rules.poa`` and ``rules.pps`` out, and the other way round.

    Parameters
    ----------
    base
        The scenario to start from.
    changes
        Dotted keys and values.
    folder
        Where files that the changes name are looked up; files that the base names are next to the base. Files of data
        and code all have to be in one folder, except for a state that the changes name.
    place
        Its name in messages.

    Raises
    ------
    InputError
        When the result is no scenario.
    """
    overrides = []
    for key, value in changes.items():
        path = tuple(key.split("."))
        named = given_in(value, path, folder) if path[0] == "rules" else value
        overrides.append(Override(f"{key} = {shown(value)}", path, named))
    with located_in(place):
        data = scenario_to_dict(base)
        data["rules"] = given_in(data["rules"], ("rules",), base.folder)
        data = apply_overrides(data, overrides)
    scenario = scenario_from_dict(data, base.folder, place)
    for override in overrides:
        section, *rest = override.path
        file, replaced = replaced_keys(getattr(scenario, section))
        if rest and rest[0] in replaced:
            raise InputError(f"{place}, {'.'.join(override.path)}", f"has no effect with `{section}.{file}`")
    folders = {os.path.realpath(named_in): named_in for named_in in _folders(scenario, changes, folder)}
    if isinstance(state := changes.get(STATE), str):
        folders = folders or {folder: folder}
        own = file_name_from(state, folder, next(iter(folders.values())))
        scenario = evolve(scenario, instance=evolve(scenario.instance, state_file=own))
    if len(folders) > 1:
        raise InputError(
            place, f"names files in {' and in '.join(folders.values())}; expected the scenario next to the experiment"
        )
    return evolve(scenario, folder=next(iter(folders.values()), base.folder))


@contextmanager
def located_in(place: str) -> Iterator[None]:
    """Name ``place`` in front of the place of every InputError raised within."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{place}, {error.place.removeprefix('--set ')}", error.problem) from error


def _folders(scenario: Scenario, changes: Changes, folder: str) -> Iterator[str]:
    """Yield the folder of every file that the scenario names: the experiment's where the changes name it."""
    for path in data_files(scenario):
        if ".".join(path) == STATE and STATE in changes:
            continue  # it may be anywhere
        named = (".".join(path[:length]) for length in range(1, len(path) + 1))
        yield folder if any(key in changes for key in named) else scenario.folder
    for (role, *_), choice in rule_choices(scenario.rules):
        if is_inline(choice.rule):
            yield folder if changes.keys() & {f"rules.{role}", f"rules.{role}.rule"} else scenario.folder
