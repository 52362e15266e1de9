"""Bounds that no rules can beat, for the figures of runs; kept in the store, the same for all rule sets."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from attrs import evolve

from rmfs_commands.bounds import bounds_of
from rmfs_commands.experiments.compare import BOUND
from rmfs_commands.experiments.experiment import Job
from rmfs_commands.experiments.keys import run_key
from rmfs_commands.experiments.rows import Row
from rmfs_commands.experiments.sources import sources_of_world
from rmfs_commands.experiments.watching import Watcher
from rmfs_commands.results.files import output_folder, to_json, write_text
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import RuleChoice, RulesSection

BOUNDS_FOLDER = "bounds"
PACKAGES, LIBRARIES = ("rmfs_commands.bounds", "rmfs_commands.instances", "rmfs_core"), ("highspy", "numpy")
"""Code that computes bounds, with its imports: other code or versions make other bounds."""

_ANY = RuleChoice("any")
_NO_RULES = RulesSection(poa=_ANY, pps=_ANY, roa=_ANY, rps=_ANY)


def add_bounds(jobs: Sequence[Job], rows: Sequence[Row], store: Path, watcher: Watcher) -> None:
    """Put the bounds of each run into its row, under the names of their metrics behind `BOUND`.

    Parameters
    ----------
    jobs, rows
        Runs, and what came of them.
    store
        Folder of finished runs; the bounds are kept in a folder in it.
    watcher
        Is told how many have to be computed.
    """
    folder = output_folder(store / BOUNDS_FOLDER)
    versions = {name: version(name) for name in LIBRARIES}
    of_seed: dict[tuple[str, str], Callable[[int], str]] = {}
    different: dict[str, Job] = {}
    keys = []
    for job in jobs:
        world = job.instance, job.rule_set
        if world not in of_seed:
            moving = None if job.scenario.rules.move is None else _ANY  # all that bounds depend on of the rules
            counted = evolve(job.scenario, rules=evolve(_NO_RULES, move=moving))
            of_seed[world] = run_key(counted, versions, sources_of_world(counted, PACKAGES))
        keys.append(of_seed[world](job.seed))
        different.setdefault(keys[-1], job)
    found = {key: _stored(folder / f"{key}.json") for key in different}
    missing = [key for key, bounds in found.items() if bounds is None]
    if missing:
        watcher.bounding(len(missing))
    for key in missing:
        found[key] = _computed(different[key])
        write_text(folder / f"{key}.json", to_json({"bounds": found[key], "digest": _digest(found[key])}, indent=2))
    for key, row in zip(keys, rows, strict=True):
        if row["status"] != "horizon":  # orders left need not be served, so that all may be less
            row.update(found[key] or {})


def _computed(job: Job) -> dict[str, float | None]:
    try:
        return {f"{BOUND}{bound.metric}": bound.value for bound in bounds_of(job.scenario)}
    except InputError:  # why the run failed, too: its row says so
        return {}


def _stored(file: Path) -> dict[str, float | None] | None:
    """Read bounds; None where there are none, or they are not what was stored."""
    try:
        content = json.loads(file.read_text("utf-8"))
        bounds: dict[str, float | None] = content["bounds"]
        return bounds if content["digest"] == _digest(bounds) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _digest(bounds: Any) -> str:
    return f"sha256:{hashlib.sha256(to_json(bounds).encode()).hexdigest()}"
