"""Hold two saved benchmark results against each other, and name what became slower by more than the noise.

Usage: python tools/compare_benchmarks.py [--threshold 0.1] BEFORE.json AFTER.json

Both were saved by pytest-benchmark (`make bench OPTIONS=--benchmark-json=FILE`). A benchmark became slower when both of
these hold:

1. The middle halves of its rounds do not overlap: the lower quartile after is above the upper quartile before. Half of
   the rounds lie between their quartiles, whatever single rounds some other program disturbed.
2. The median grew by at least the threshold, 10 % unless said otherwise: between two runs the memory layout and the
   clock of the machine differ, which moves all rounds of a run together, so that rounds do not show it.

It became faster when the same holds the other way round. With fewer than five rounds a benchmark has no quartiles to
speak of: it is named as not judged. Exit codes: 0 nothing became slower, 1 something did, 2 the input is wrong.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import frozen

LEAST_ROUNDS = 5
UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, "us"), (1e-9, "ns"))


class WrongInputError(Exception):
    """A file is no saved result of pytest-benchmark; the text says which and why."""


@frozen
class Rounds:
    """The rounds of a benchmark: their number, and median and quartiles of their seconds."""

    rounds: int
    median: float
    q1: float
    q3: float

    def __attrs_post_init__(self) -> None:
        if not (0 < self.median < math.inf and self.q1 <= self.median <= self.q3 < math.inf):
            raise ValueError("median and quartiles are no positive numbers in order")


@frozen
class Change:
    """A benchmark that both files have."""

    name: str
    before: Rounds
    after: Rounds

    @property
    def ratio(self) -> float:
        """Median after over median before."""
        return self.after.median / self.before.median

    def verdict(self, threshold: float) -> str:
        """``"slower"``, ``"faster"``, ``"same"``, or ``"not judged"`` where rounds are too few."""
        if min(self.before.rounds, self.after.rounds) < LEAST_ROUNDS:
            return "not judged"
        if self.after.q1 > self.before.q3 and self.ratio >= 1 + threshold:
            return "slower"
        if self.after.q3 < self.before.q1 and self.ratio <= 1 / (1 + threshold):
            return "faster"
        return "same"


def read(path: Path) -> dict[str, Rounds]:
    """Return the benchmarks of a saved result by their full names.

    Raises
    ------
    WrongInputError
        When the file cannot be read or is something else.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise WrongInputError(f"{path}: cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise WrongInputError(f"{path}: this is no JSON: {error}") from error
    if not isinstance(content, Mapping) or not isinstance(content.get("benchmarks"), list):
        raise WrongInputError(f"{path}: expected a result that pytest-benchmark saved, with the key `benchmarks`")
    return dict(_rounds(f"{path}, benchmarks[{i}]", entry) for i, entry in enumerate(content["benchmarks"]))


def _rounds(place: str, entry: Any) -> tuple[str, Rounds]:
    try:
        stats = entry["stats"]
        rounds = Rounds(int(stats["rounds"]), *(float(stats[key]) for key in ("median", "q1", "q3")))
        return str(entry["fullname"]), rounds
    except (KeyError, TypeError, ValueError) as error:
        raise WrongInputError(f"{place}: this is no saved benchmark: {error}") from error


def report(before: Mapping[str, Rounds], after: Mapping[str, Rounds], threshold: float) -> tuple[list[str], bool]:
    """Return the lines to print, and whether something became slower."""
    changes = [Change(name, before[name], after[name]) for name in before if name in after]
    by_verdict: dict[str, list[Change]] = {}
    for change in sorted(changes, key=lambda change: (-change.ratio, change.name)):
        by_verdict.setdefault(change.verdict(threshold), []).append(change)
    lines = []
    for verdict in ("slower", "faster"):
        for change in by_verdict.get(verdict, ()):
            figures = f"{shown(change.before.median)} -> {shown(change.after.median)}"
            lines.append(f"{verdict}: {change.name}: {figures} ({change.ratio:.2f} times)")
    lines += [f"not judged, fewer than {LEAST_ROUNDS} rounds: {c.name}" for c in by_verdict.get("not judged", ())]
    lines += [f"only before: {name}" for name in before if name not in after]
    lines += [f"only after: {name}" for name in after if name not in before]
    counts = ", ".join(f"{len(by_verdict.get(verdict, ()))} {verdict}" for verdict in ("slower", "faster", "same"))
    return [*lines, f"{len(changes)} benchmarks in both: {counts}."], "slower" in by_verdict


def shown(seconds: float) -> str:
    """Return a duration in the unit that suits it."""
    size, unit = next(((size, unit) for size, unit in UNITS if seconds >= size), UNITS[-1])
    return f"{seconds / size:.3g} {unit}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare the two files of the command line; return the exit code."""
    description, _, criterion = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        description=description, epilog=criterion, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("before", type=Path, metavar="BEFORE.json")
    parser.add_argument("after", type=Path, metavar="AFTER.json")
    parser.add_argument("--threshold", type=float, default=0.1, help="least growth of the median (default 0.1: 10 %%)")
    given = parser.parse_args(arguments)
    if not 0 <= given.threshold < math.inf:
        parser.error(f"expected a threshold >= 0, found {given.threshold}")
    try:
        before, after = read(given.before), read(given.after)
    except WrongInputError as error:
        print(f"Error: {error}", file=sys.stderr)
        return 2
    lines, slower = report(before, after, given.threshold)
    print("\n".join(lines))
    return int(slower)


if __name__ == "__main__":
    sys.exit(main())
