"""One rule set on instances of the set, run as experiments are: finished runs are kept."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import frozen

from rmfs_commands.benchmark.sets import Frozen
from rmfs_commands.experiments import Base, Experiment, ExperimentResult, Job, RuleSetChoice, Watcher, run_experiment
from rmfs_commands.experiments.keys import digest_of, rules_of
from rmfs_commands.instances.overrides import parse_override
from rmfs_commands.instances.toml_lines import read_toml
from rmfs_core.errors import InputError

FIGURES_FILE = "benchmark.json"
"""By it `rmfs cite` knows a folder of runs on the set."""


@frozen
class OneSeedEach(Experiment):
    """An experiment that runs each base with its own seed only."""

    def jobs(self, *, allow_inline_rules: bool = True) -> list[Job]:
        """Return a run for each base."""
        own = {base.name: base.scenario.seed for base in self.bases}
        jobs = super().jobs(allow_inline_rules=allow_inline_rules)
        return [job for job in jobs if job.seed == own[job.axes["scenario"]]]


def rules_given(texts: Sequence[str]) -> dict[str, Any]:
    """Return the rules that texts name: ``poa_pps=pod-index``, or a TOML file with a section ``[rules]``.

    Raises
    ------
    InputError
        When a text is neither.
    """
    found: dict[str, Any] = {}
    given: dict[str, str] = {}
    for text in texts:
        if text.endswith(".toml"):
            try:
                table = read_toml(Path(text).read_bytes().decode("utf-8-sig")).get("rules")
            except (OSError, ValueError) as error:
                raise InputError(text, f"cannot be read: {getattr(error, 'strerror', None) or error}") from error
            if not isinstance(table, Mapping):
                raise InputError(text, "expected a section [rules]")
        else:
            key, _, value = text.partition("=")
            if not key.strip().isidentifier() or not value.strip():
                raise InputError(f"--rules {text}", "expected KEY=RULE, as in poa_pps=pod-index, or a TOML file")
            table = {key.strip(): parse_override(text).value}
        if twice := [key for key in table if key in given]:
            raise InputError("--rules", f"found `{twice[0]}` in {given[twice[0]]} and in {text}; expected it once")
        found |= table
        given |= dict.fromkeys(table, text)
    if not found:
        raise InputError("--rules", "expected KEY=RULE, as in poa_pps=pod-index, or a TOML file with [rules]")
    return found


def figures_of(
    instances: Sequence[Frozen], rules: Mapping[str, Any], result: ExperimentResult, version: str
) -> dict[str, Any]:
    """Return what runs of instances reached, and all that is needed to reach it again: no wall-clock times."""
    reached = {row["scenario"]: row for row in result.rows}
    return {
        "set": version,
        "rules": dict(rules),
        "versions": result.versions,
        "figures": [
            {
                "instance": one.name,
                "seed": one.scenario.seed,
                "checksum": one.checksum,
                "status": (row := reached[one.name])["status"],
                "rules_sha256": digest_of(rules_of(one.with_rules(rules))),
                "run": row["key"],
                **one.reached(row),
            }
            for one in instances
        ],
    }


def run_on(
    instances: Sequence[Frozen],
    rules: Mapping[str, Any],
    store: Path,
    *,
    jobs: int | None = None,
    dask: str | None = None,
    watcher: Watcher | None = None,
    allow_inline_rules: bool = True,
) -> ExperimentResult:
    """Run rules on instances, each with its own seed, as `run_experiment` does; a row's ``scenario`` names it."""
    experiment = OneSeedEach(
        name="benchmark",
        bases=tuple(Base(one.name, one.with_rules(rules)) for one in instances),
        rule_sets=(RuleSetChoice("rules"),),
        seeds=tuple(dict.fromkeys(one.scenario.seed for one in instances)),
        baseline="rules",
    )
    return run_experiment(
        experiment,
        store=store,
        jobs=jobs,
        dask=dask,
        watcher=watcher,
        allow_inline_rules=allow_inline_rules,
    )
