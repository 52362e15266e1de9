"""Fill in what belongs to the benchmark set: checksums, bounds, and the table of best known values on its page.

    python tools/benchmark_set.py --bounds              # bounds.json, minutes
    python tools/benchmark_set.py --add FILE            # claims of `rmfs benchmark`, each made again first
    python tools/benchmark_set.py                       # the page

The set is frozen: checksums are only ever compared (tests/plugins/rmfs_commands/benchmark/test_benchmark.py).
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from rmfs_commands.benchmark import claims, sets, table
from rmfs_commands.bounds import bounds_of
from rmfs_commands.results.files import to_json

PAGE = Path("docs/reference/benchmark-set.md")
FOLDER = Path(claims.__file__).parent
BEGIN, END = "% table: python tools/benchmark_set.py\n", "% end of the table\n"


def main() -> None:
    """Do what the arguments say."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--bounds", action="store_true")
    parser.add_argument("--add", type=Path)
    given = parser.parse_args()
    chosen = sets.benchmark_set()
    if given.bounds:
        found = {}
        for one in chosen.instances.values():
            proven = bounds_of(one.scenario, one.objectives)
            found[one.name] = {bound.metric: bound.value for bound in proven if bound.value is not None}
            print(one.name, found[one.name], flush=True)
        lines = ",\n".join(f" {to_json(name)}: {to_json(values)}" for name, values in found.items())
        (FOLDER / sets.BOUNDS_FILE).write_text(f"{{\n{lines}\n}}\n", "utf-8")
    known = claims.read_claims()
    if given.add is not None:
        before = known
        known = claims.without_beaten(known + claims.read_claims(given.add), chosen)
        for claim in (claim for claim in known if claim not in before):
            with TemporaryDirectory() as folder:
                claims.repeat(claim, chosen, Path(folder))
        (FOLDER / claims.FILE).write_text("".join(map(claims.claim_line, known)), "utf-8")
    instances = list(chosen.instances.values())
    text = page_table(instances, list(table.best_known(instances, known)))
    page = PAGE.read_text("utf-8")
    pattern = f"(?<={re.escape(BEGIN)}).*(?={re.escape(END)})"
    PAGE.write_text(re.sub(pattern, lambda _: f"\n{text}\n", page, flags=re.DOTALL), "utf-8")


def page_table(instances: Sequence[sets.Frozen], found: Sequence[table.Best]) -> str:
    """Return best known values as a table in Markdown, a row for each instance, with gaps and letters of the rules."""
    makers = {one.claim.made_by: "" for one in found}
    letters: Mapping[str, str] = {name: chr(97 + i) for i, name in enumerate(sorted(makers))}
    by = {(one.instance.name, one.objective): one for one in found}

    def cell(name: str, objective: str) -> str:
        one = by.get((name, objective))
        if one is None:
            return ""
        gap = "" if one.gap is None else f" (+{100 * one.gap:,.0f} %)"
        marks = "*" * one.claim.offline + "?" * (not one.verified)
        return f"{table.told(objective, one.value)}{gap} {letters[one.claim.made_by]}{marks}"

    lines = ["| instance | " + " | ".join(label.lower() for label in table.LABELS.values()) + " |"]
    lines.append("|---|" + "---:|" * len(table.LABELS))
    lines += [f"| {one.name} | " + " | ".join(cell(one.name, key) for key in table.LABELS) + " |" for one in instances]
    legend = ", ".join(f"{letter} {'a plan' if name == 'plan' else f'`{name}`'}" for name, letter in letters.items())
    unverified = "" if all(one.verified for one in found) else ", ? unverified"
    return "\n".join([*lines, "", f"Made by: {legend}; * offline{unverified}.", ""])


if __name__ == "__main__":
    main()
