"""Simulate comparisons whose truth is known: how often do intervals hold it, and how often are there false alarms?

``python tools/coverage_study.py [--repeats N]`` makes up runs, compares them with the code of ``rmfs compare``, counts.
In a made-up run, all instances of a seed share what their orders do to a rule set, as they do in a comparison; pooling
all pairs as if they were independent is shown beside. Exit code 1 when an interval for one comparison holds the truth
in other than 95 +- 1.5 % of the repeats, one for all comparisons at once in less, when there are false alarms after
Holm's correction in more than 5 + 1.5 %, or when an interval and its p-value contradict each other.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from attrs import define, frozen

from rmfs_commands.experiments.compare import CONFIDENCE, Interval, Paired, interval, summary

BASELINE, METRIC = "baseline", "figure"
TOLERANCE = 0.015
OF_SEED, OF_RUN = 0.10, 0.05
"""Standard deviations of a rule set's relative difference: what all instances of a seed share, and what none do."""


@frozen
class Setting:
    """Made-up runs.

    Parameters
    ----------
    seeds, instances
        How many.
    effects
        True relative differences from the baseline, one for each rule set.
    """

    seeds: int
    instances: int
    effects: tuple[float, ...]

    def __str__(self) -> str:
        effects = ", ".join(f"{100 * effect:g} %" for effect in self.effects)
        return f"{self.seeds} seeds, {self.instances} instances, true differences {effects}"


SETTINGS = (
    Setting(5, 4, (0.05,)),
    Setting(10, 4, (0.0,)),
    Setting(5, 1, (0.05,)),
    Setting(5, 4, (0.0, 0.0, 0.0, 0.0)),
    Setting(10, 4, (0.0, 0.0, 0.3, -0.3)),
    Setting(10, 4, (0.1, 0.2, 0.3, -0.3)),
)


@define
class Counts:
    """How often something was so, over the repeats of a setting."""

    repeats: int = 0
    comparisons: int = 0
    held: int = 0
    relative_held: int = 0
    pooled_held: int = 0
    all_held: int = 0
    false_alarms: int = 0
    contradictions: int = 0


def rows_of(setting: Setting, random: np.random.Generator) -> Iterator[dict[str, Any]]:
    """Yield the rows of made-up runs: instances differ in size, seeds in how hard they are."""
    for seed in range(setting.seeds):
        shared = random.normal(0.0, OF_SEED, len(setting.effects))
        hardness = random.normal(1.0, 0.03)
        for instance in range(setting.instances):
            figure = 100.0 * (1 + instance) * hardness
            differences = [0.0, *(setting.effects + shared + random.normal(0.0, OF_RUN, len(setting.effects)))]
            for number, difference in enumerate(differences):
                name = f"rules {number}" if number else BASELINE
                run = {"instance": f"instance {instance}", "rule_set": name, "seed": seed, "status": "complete"}
                yield {**run, METRIC: figure * (1 + difference)}


def study(setting: Setting, repeats: int, seed: int = 1) -> Counts:
    """Return the counts of a setting."""
    random = np.random.default_rng([seed, *str(setting).encode()])
    mean_figure = 100.0 * (1 + setting.instances) / 2
    counts = Counts()
    for _ in range(repeats):
        rows = list(rows_of(setting, random))
        compared = summary(rows, BASELINE, [METRIC], by=())
        found = [one for one in compared.of(compared.instance_sets[-1], METRIC) if one.rule_set != BASELINE]
        counts.repeats += 1
        counts.comparisons += len(found)
        _count(counts, found, setting.effects, mean_figure)
        counts.pooled_held += sum(
            _holds(pooled(rows, one), truth) for one, truth in zip(found, setting.effects, strict=True)
        )
    return counts


def _count(counts: Counts, found: Sequence[Paired], effects: Sequence[float], mean_figure: float) -> None:
    together = list(zip(found, effects, strict=True))
    counts.held += sum(_holds(one.difference, truth * mean_figure) for one, truth in together)
    counts.relative_held += sum(_holds(one.relative, truth) for one, truth in together)
    counts.all_held += all(_holds(of_all(one.relative), truth) for one, truth in together)
    counts.false_alarms += any(truth == 0 and (one.relative.p_holm or 0) <= 1 - CONFIDENCE for one, truth in together)
    counts.contradictions += sum(contradicts(part) for one in found for part in (one.difference, one.relative))


def pooled(rows: Sequence[dict[str, Any]], one: Paired) -> Interval:
    """Return the relative difference's interval as if every pair were independent of every other."""
    figure = {(row["rule_set"], row["instance"], row["seed"]): row[METRIC] for row in rows}
    keys = [(row["instance"], row["seed"]) for row in rows if row["rule_set"] == BASELINE]
    return interval([figure[one.rule_set, *key] / figure[BASELINE, *key] - 1 for key in keys])


def of_all(found: Interval) -> Interval:
    """Return the interval that holds for all comparisons at once."""
    return Interval(found.mean, found.low_holm, found.high_holm)


def contradicts(found: Interval) -> bool:
    """Whether an interval says something else than its p-value, alone or among all comparisons."""
    sure, sure_holm = (found.p or 0) <= 1 - CONFIDENCE, (found.p_holm or 0) <= 1 - CONFIDENCE
    within = (found.low_holm or 0) < 0 < (found.high_holm or 0)
    return sure == _holds(found, 0.0) or sure_holm == within


def _holds(found: Interval, truth: float) -> bool:
    return found.low is not None and found.high is not None and found.low <= truth <= found.high


def wrong(counts: Counts) -> list[str]:
    """Return what is not as promised."""
    shares = {
        "difference": counts.held / counts.comparisons,
        "relative difference": counts.relative_held / counts.comparisons,
    }
    found = [f"{name}: held in {share:.1%}" for name, share in shares.items() if abs(share - CONFIDENCE) > TOLERANCE]
    if counts.all_held / counts.repeats < CONFIDENCE - TOLERANCE:
        found.append(f"all at once: held in {counts.all_held / counts.repeats:.1%}")
    if counts.false_alarms / counts.repeats > 1 - CONFIDENCE + TOLERANCE:
        found.append(f"false alarms: {counts.false_alarms / counts.repeats:.1%}")
    if counts.contradictions:
        found.append(f"contradictions: {counts.contradictions}")
    return found


def main() -> None:
    """Study every setting and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=2000)
    repeats = parser.parse_args().repeats
    problems = []
    print("| runs | difference | relative | all at once | false alarms (Holm) | pooled pairs |")
    print("|---|---:|---:|---:|---:|---:|")
    for setting in SETTINGS:
        counts = study(setting, repeats)
        of_comparisons = [counts.held, counts.relative_held]
        shares = [f"{100 * held / counts.comparisons:.1f} %" for held in of_comparisons]
        shares += [f"{100 * number / counts.repeats:.1f} %" for number in (counts.all_held, counts.false_alarms)]
        shares += [f"{100 * counts.pooled_held / counts.comparisons:.1f} %"]
        print(f"| {setting} | {' | '.join(shares)} |", flush=True)
        problems += [f"{setting}: {problem}" for problem in wrong(counts)]
    if problems:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
