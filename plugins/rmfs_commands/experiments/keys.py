"""The identity of a run: the hash that names its folder.

Two runs with the same key give the same metrics, so that one of them need not be computed. What counts is the resolved
scenario, the contents of the files it names, the seed, the versions and the code; where the files are, and in which
order keys were written, does not.
"""

from __future__ import annotations

import hashlib
import json
import os.path
import uuid
from collections.abc import Callable, Mapping
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

from rmfs_commands.instances.overrides import data_files
from rmfs_commands.results.files import json_ready, to_json
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario, scenario_to_dict
from rmfs_core.scenario.rulenames import GivenText, is_inline

KEY_LENGTH = 24
"""Hexadecimal digits: 96 bits, so that a million runs collide with a probability of 1e-17."""


def run_key(scenario: Scenario, versions: Mapping[str, str], sources: Mapping[str, str]) -> Callable[[int], str]:
    """Return the function from a seed to the key of a run.

    Parameters
    ----------
    scenario
        The resolved scenario; its own seed does not count.
    versions
        Of everything that takes part; of a rule's file next to the scenario, the digest.
    sources
        Digests of the code of everything that takes part, see `sources_of`.

    Raises
    ------
    InputError
        When a file that the scenario names cannot be read.
    """
    tables, folder = scenario_to_dict(scenario), Path(scenario.folder)
    for (*sections, name), file in data_files(scenario).items():
        reduce(getitem, sections, tables)[name] = _digest(folder / file, ".".join([*sections, name]))
    for section in (tables["instance"], tables["layout"]):
        if "parameters" in section:
            section["parameters"] = _with_digests(section["parameters"], folder)

    seed = uuid.uuid4().hex  # where the seed goes: the rest is written once for all seeds
    content = {"scenario": {**tables, "seed": seed}, "versions": dict(versions), "sources": dict(sources)}
    text = json.dumps(json_ready(content), sort_keys=True, ensure_ascii=False, default=repr)
    before, after = (part.encode() for part in text.split(f'"{seed}"'))
    return lambda seed: hashlib.sha256(before + b"%d" % seed + after).hexdigest()[:KEY_LENGTH]


def rules_of(scenario: Scenario) -> dict[str, Any]:
    """Return the rules of a scenario as written, by key, without the keys that have none; files with their digests."""
    tables, folder = scenario_to_dict(scenario)["rules"], Path(scenario.folder)
    return {key: _with_digests(value, folder) for key, value in tables.items() if value not in (None, [], ())}


def digest_of(rules: Mapping[str, Any]) -> str:
    """Return the first digits of the SHA-256 of rules as written: a default that is spelled out makes it another."""
    return hashlib.sha256(to_json(rules).encode()).hexdigest()[:12]


def _with_digests(value: Any, folder: Path) -> Any:
    """Return rules or parameters; a text in them that may be the name of a file has the file's digest with it."""
    if isinstance(value, Mapping):
        return {name: _with_digests(entry, folder) for name, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_with_digests(entry, folder) for entry in value]
    if isinstance(value, str) and "\0" not in value:
        file, _, _ = value.rpartition(":") if is_inline(value) and ":" in value else (value, "", "")
        file = os.path.join(value.there if isinstance(value, GivenText) else folder, file)  # noqa: PTH118
        return [value, _digest(Path(file))] if os.path.isfile(file) else value  # noqa: PTH113
    return value


def _digest(file: Path, place: str | None = None) -> str:
    if file.is_char_device() or file.is_fifo():
        raise InputError(place or str(file), f"found {file}, a device; expected a file, which each run can read anew")
    try:
        return f"sha256:{hashlib.sha256(file.read_bytes()).hexdigest()}"
    except (OSError, ValueError) as error:  # ValueError: of a name that no file can have
        problem = f"cannot read {file}: {getattr(error, 'strerror', None) or error}"
        raise InputError(place or str(file), problem) from error
