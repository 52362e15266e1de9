"""Put the figures and pictures of leagues and studies into docs/paper/league and docs/paper/study.

Usage: python tools/update_comparisons.py DIR...

Each DIR is what `rmfs compare EXPERIMENT --bounds --out DIR` has written. A comparison with fronts is a league: a table
of figures for each instance set, and the pictures of the fronts. One without is a study: what each rule set changes,
with the intervals that hold for all of them at once. docs/paper/league.md and study.md, which say what the figures
mean, are yours to bring up to date.
"""

from __future__ import annotations

import csv
import itertools
import shutil
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

PAPER = Path(__file__).resolve().parent.parent / "docs" / "paper"
COLUMNS = {
    "psv_per_order": ("Visits /order", 1, 3),
    "distance_per_order_m": ("Metres /order", 1, 1),
    "turnover_s": ("Turn-over (s)", 1, 0),
    "turnover_p95_s": ("95 % (s)", 1, 0),
    "makespan_s": ("Makespan (s)", 1, 0),
    "packed_s": ("Packed (s)", 1, 0),
    "packed_p95_s": ("Packed, 95 % (s)", 1, 0),
    "boxes_max": ("Boxes at most", 1, 0),
    "packer_utilisation_percent": ("Packers busy (%)", 1, 0),
}
"""Heading, factor and digits of each metric."""
Row = Mapping[str, str]
Front = tuple[str, str]


def report(rows: Sequence[Row], name: str, fronts: Sequence[Front]) -> str:
    """Return the tables of an experiment as Markdown, its pictures beside it."""
    parts = []
    for instances in dict.fromkeys(row["instances"] for row in rows if row["instances"] != "overall"):
        figures: dict[str, dict[str, Row]] = {}
        for row in rows:
            if row["instances"] == instances:
                figures.setdefault(row["rule_set"], {})[row["metric"]] = row
        parts.append(_table(instances.partition("=")[2], figures, fronts))
    pictures = [f"![Rule sets that none beats]({name}-{'-'.join(front)}.png)\n" for front in fronts]
    return "\n".join([*pictures, *parts])


def _table(title: str, figures: Mapping[str, Mapping[str, Row]], fronts: Sequence[Front]) -> str:
    """Return the rule sets of an instance set, those with fewest visits first, with the fronts that each is on."""
    on_front = {COLUMNS[front[0]][0].partition(" ")[0].lower(): _front(figures, *front) for front in fronts}
    metrics = list(next(iter(figures.values())))
    columns = [COLUMNS[metric] for metric in metrics]
    bounded = [metric for metric in metrics if any(found[metric].get("times_bound") for found in figures.values())]
    bounds = [f"{COLUMNS[metric][0].partition(' ')[0]}, x bound" for metric in bounded]
    heads = ["Rule set", *(heading for heading, _, _ in columns), *bounds, "Not done", "Front"]
    lines = [f"### {title}\n", _line(heads), _line(["---", *["---:"] * (len(heads) - 2), "---"])]
    for rule_set in sorted(figures, key=lambda one: float(figures[one]["psv_per_order"]["mean"] or "inf")):
        found = figures[rule_set]
        cells = [_shown(found[metric]["mean"], *COLUMNS[metric][1:]) for metric in metrics]
        times = [_shown(found[metric].get("times_bound", ""), 1, 2) for metric in bounded]
        some = found["psv_per_order"]
        on = [front for front, rule_sets in on_front.items() if rule_set in rule_sets]
        lines.append(_line([rule_set, *cells, *times, str(int(some["runs"]) - int(some["complete"])), ", ".join(on)]))
    return "\n".join([*lines, ""])


def _front(figures: Mapping[str, Mapping[str, Row]], first: str, second: str) -> set[str]:
    """Return the rule sets that none beats in two metrics."""
    points = {
        rule_set: (float(found[first]["mean"]), float(found[second]["mean"]))
        for rule_set, found in figures.items()
        if found[first]["mean"] and found[second]["mean"]
    }
    return {
        rule_set
        for rule_set, (x, y) in points.items()
        if not any(a <= x and b <= y and (a, b) != (x, y) for a, b in points.values())
    }


def _shown(value: str, factor: float, digits: int) -> str:
    return f"{factor * float(value):,.{digits}f}" if value else "-"


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


def effects(rows: Sequence[Row]) -> str:
    """Return what each rule set changes against the baseline: overall, and by metric for each instance set."""
    baseline = rows[0]["baseline"]
    found = {(row["instances"], row["metric"], row["rule_set"]): row for row in rows}
    instances, metrics, every = (list(dict.fromkeys(key[part] for key in found)) for part in range(3))
    others, sets = [rule_set for rule_set in every if rule_set != baseline], instances[:-1]
    runs = found[instances[-1], metrics[0], baseline]
    heads = [COLUMNS[metric][0].removesuffix(" /order").removesuffix(" (s)") for metric in metrics]
    parts = [f"### Against {baseline}, {runs['runs']} runs each\n", _line(["Rule set", *heads]), _ruled(len(heads))]
    parts += [_line([who, *(_effect(found[instances[-1], metric, who]) for metric in metrics)]) for who in others]
    if len(sets) > 1:
        for metric in metrics:
            heading, factor, digits = COLUMNS[metric]
            parts += [f"\n### {heading}\n", _line(["", baseline, *others]), _ruled(len(others) + 1)]
            for each in sets:
                base = _shown(found[each, metric, baseline]["mean"], factor, digits)
                cells = [_effect(found[each, metric, who]) for who in others]
                parts.append(_line([each.partition("=")[2], base, *cells]))
    return "\n".join([*parts, ""])


def _ruled(columns: int) -> str:
    return _line(["---", *["---:"] * columns])


def _effect(row: Row) -> str:
    low, high = (f"{100 * float(row[f'relative_{end}_holm']):+.0f}" for end in ("low", "high"))
    return f"{100 * float(row['relative']):+.0f} % [{low}, {high}]".replace(" ", "\u00a0")  # in one line


def update(folder: Path, paper: Path) -> None:
    """Write an experiment's report, and copy its pictures."""
    name = folder.resolve().name
    with (folder / "summary.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    fronts = []
    for first, second in itertools.permutations(dict.fromkeys(row["metric"] for row in rows), 2):
        if (folder / "plots" / f"front.{first}.{second}.png").is_file():
            fronts.append((first, second))
    to = paper / ("league" if fronts else "study")
    to.mkdir(parents=True, exist_ok=True)
    (to / f"{name}.md").write_text(report(rows, name, fronts) if fronts else effects(rows), encoding="utf-8")
    for front in fronts:
        shutil.copyfile(folder / "plots" / f"front.{'.'.join(front)}.png", to / f"{name}-{'-'.join(front)}.png")


def main() -> int:
    """Update the checkout from the folders on the command line."""
    folders = [Path(folder) for folder in sys.argv[1:]]
    if not folders or not all((folder / "summary.csv").is_file() for folder in folders):
        print("expected folders that `rmfs compare --out` has written", file=sys.stderr)
        return 2
    for folder in folders:
        update(folder, PAPER)
    return 0


if __name__ == "__main__":
    sys.exit(main())
