"""Times of benchmarks in releases, in yardsticks, and whether one has become slower since."""

import json
from collections.abc import Callable
from pathlib import Path

HISTORY = Path(__file__).parents[1] / "benchmarks" / "history.json"
THRESHOLD = 0.1
"""Growth over the last release that is named."""
TRIES = 3


def of_last_release(benchmark: str) -> tuple[str, float | None]:
    """Return the last release in the history and what a benchmark took then, None where it was not measured."""
    history: dict[str, dict[str, float]] = json.loads(HISTORY.read_text(encoding="utf-8"))
    release = [*history][-1]
    return release, history[release].get(benchmark)


def held_against_release(benchmark: str, measure: Callable[[], float]) -> tuple[float, str | None]:
    """Measure; return the least that it took, and a sentence where that is more than in the last release.

    What seems slower is measured again: another program may have been in the way, and never makes anything faster.
    """
    release, before = of_last_release(benchmark)
    least = measure()
    for _ in range(TRIES - 1):
        if before is None or least <= before * (1 + THRESHOLD):
            return least, None
        least = min(least, measure())
    if before is None or least <= before * (1 + THRESHOLD):
        return least, None
    return (
        least,
        f"slower: {benchmark}: {before:.1f} yardsticks in {release}, {least:.1f} now ({least / before:.2f} times)",
    )
