"""The answer for people, and as files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rmfs_commands.cli.screen import say
from rmfs_commands.cli.serving import SERVING, serving_options
from rmfs_commands.results.files import json_ready, output_folder, staged, to_csv, to_json, write_text
from rmfs_commands.sizing.judging import Verdict
from rmfs_commands.sizing.robust import UNDER, under_spread_and_failures
from rmfs_commands.sizing.searching import BOXES
from rmfs_core.wording import listed

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from rmfs_commands.sizing.sizing import Answer, OtherRules
    from rmfs_commands.sizing.target import Target
    from rmfs_commands.sizing.trials import Candidate
    from rmfs_core.scenario import Scenario

ANSWER_FILE, CANDIDATES_FILE, ROBUST_FILE = "answer.json", "candidates.csv", "robust-candidates.csv"
RUNS_FOLDER, ROBUST_FOLDER = "runs", "robust-runs"
COLUMNS = ("mean", "low", "high", "seeds", "verdict", "fewest", "reason")

Costs = tuple[float, float]
"""Of a robot and of a station, or of a box and of a packer."""


def verdict_of(candidate: Candidate, target: Target) -> str:
    """Return what was found of a size, in words."""
    one = candidate.estimate
    figures = "" if one is None else f" {target.shown(one.mean)} [{target.shown(one.low)}, {target.shown(one.high)}],"
    reason = f": {candidate.reason}" if candidate.reason else ""
    seeds = f" {candidate.seeds} seeds," if candidate.seeds else ""
    return f"{figures}{seeds} {candidate.verdict.value}{reason}".strip()


def table_of(answer: Answer) -> Table:
    """Return every size that was judged; after those of a number of stations, why it has none that counts."""
    from rich.text import Text

    from rmfs_commands.cli.screen import new_table

    target = answer.target
    table = new_table(f"{target.label}, at most {target.with_unit(target.most)}")
    for name in (*(name.capitalize() for name in _names(answer)), "Mean", "Interval", "Seeds"):
        table.add_column(name, justify="right", no_wrap=True)
    priced = answer.least_per_order is not None
    if priced:
        table.add_column("Cost per order", justify="right")
    table.add_column("Verdict", overflow="fold")
    for found in answer.found:
        for one in answer.candidates:
            if one.first != found.first:
                continue
            mean = interval = ""
            if one.estimate is not None:
                mean, low, high = map(target.shown, (one.estimate.mean, one.estimate.low, one.estimate.high))
                interval = f"[{low}, {high}]"
            best = one in answer.frontier
            verdict = f"{one.verdict.value}, fewest" if best else one.verdict.value
            verdict += f": {one.reason}" if one.reason else ""
            cells = str(one.first), str(one.second), mean, interval, str(one.seeds or "")
            cost = answer.costs.get((one.first, one.second))
            more = ["" if cost is None else f"{cost:,.4f}"] * priced
            table.add_row(*cells, *more, Text(verdict), style="bold green" if best else "")
        if found.reason:
            table.add_row(str(found.first), *[""] * (4 + priced), Text(found.reason))
    return table


def _names(answer: Answer) -> tuple[str, str]:
    """Return what is counted, for columns and keys: stations and robots, or packers and boxes."""
    return answer.things.first[1], answer.things.second[1]


def rows_of(answer: Answer) -> Iterator[dict[str, Any]]:
    """Yield a row for every size that was judged."""
    for one in answer.candidates:
        known = one.estimate
        yield {
            **dict(zip(_names(answer), (one.first, one.second), strict=True)),
            "mean": known and known.mean,
            "low": known and known.low,
            "high": known and known.high,
            "seeds": one.seeds,
            "verdict": one.verdict.value,
            **({} if answer.least_per_order is None else {"cost_per_order": answer.costs.get((one.first, one.second))}),
            "fewest": one in answer.frontier,
            "reason": one.reason,
        }


def sentences_of(answer: Answer, costs: Costs | None) -> Iterator[str]:
    """Yield the answer in one sentence, and what one should know besides."""
    target = answer.target
    limit, sure = target.with_unit(target.most), f"{100 * target.confidence:g} %"
    asked = f"{target.label}, at most {limit} with {sure} confidence"
    counted = answer.things.counted
    if answer.frontier:
        yield f"{asked}: {', or '.join(counted(one.first, one.second, ' with ') for one in answer.frontier)}."
    else:
        yield f"{asked}: none of the sizes is shown to be enough."
    cheapest = answer.cheapest(*costs) if costs else None
    if cheapest is not None:
        one, cost = cheapest
        yield f"The cheapest of these costs {cost:,.12g}: {counted(one.first, one.second, ' with ')}."
    if (least := answer.least_per_order) is not None:
        one, cost = least
        size = counted(one.first, one.second, " with ")
        unknown = [f"{first} with {second} ({why})" for (first, second), why in answer.unknown_beside_least.items()]
        beside = (
            f"one {answer.things.first[0]} or {answer.things.second[0]} more or less costs no less, or is not enough"
        )
        beside += f"; not known: {listed(unknown)}" if unknown else ""
        yield f"Of the sizes tried that are enough, an order costs least with {size}: {cost:,.4f}; {beside}."
    if answer.undecided:
        sizes = [f"{one.first} with {one.second}" for one in answer.undecided]
        yield f"Undecided after {len(target.seeds)} seeds: {listed(sizes)}; more --seeds may tell."
    if answer.things is BOXES:
        yield "Packers and boxes are those of each packing station."
        if {one.boxes for one in answer.candidates} - {None} == {0}:
            yield "No order was split in these runs, so that with these rules the number of boxes makes no difference."
    if answer.other_rules is not None:
        yield other_rules(answer, answer.other_rules)
    if answer.at_once:
        yield "All orders are there at once: turn-over says how fast the backlog is worked off, not how a load is kept."


def other_rules(answer: Answer, other: OtherRules) -> str:
    """Return whether it is the rules that fail the target in a size, or the hardware."""
    size = answer.things.counted(other.judged.first, other.judged.second, " with ")
    judged = verdict_of(other.judged, answer.target)
    found = f"The scenario's rules fail with {size}; with {serving_options()}: {judged}."
    if other.judged.verdict is Verdict.PASSES:
        return f"{found} The rules fail there, not the hardware."
    return found if other.least is None else f"{found} Any rules: {answer.target.with_unit(other.least)} or more."


def content_of(answer: Answer, costs: Costs | None) -> dict[str, Any]:
    """Return the answer as plain values."""
    target = answer.target
    cheapest = answer.cheapest(*costs) if costs else None
    names = _names(answer)
    rows = list(rows_of(answer))
    content: dict[str, Any] = {
        "scenario": answer.scenario,
        "metric": target.metric,
        "most": target.most,
        "confidence": target.confidence,
        "seeds": list(target.seeds),
        "frontier": [row for row in rows if row["fewest"]],
    }
    if costs is not None:
        content["costs"] = {answer.things.second[0]: costs[0], answer.things.first[0]: costs[1]}
        best = cheapest and (cheapest[0].first, cheapest[0].second)
        content["cheapest"] = best and cheapest and {**dict(zip(names, best, strict=True)), "cost": cheapest[1]}
    if (least := answer.least_per_order) is not None:
        size = dict(zip(names, (least[0].first, least[0].second), strict=True))
        content["least_per_order"] = {**size, "cost_per_order": least[1]}
    content[names[0]] = [
        {names[0]: found.first, names[1]: found.second, "reason": found.reason} for found in answer.found
    ]
    content["candidates"] = rows
    if answer.other_rules is not None:
        judged = answer.other_rules.judged
        size = dict(zip(names, (judged.first, judged.second), strict=True))
        verdict = {"verdict": judged.verdict.value, "seeds": judged.seeds, "least": answer.other_rules.least}
        content["other_rules"] = {"set": SERVING, **size, **verdict}
    content["notes"] = list(sentences_of(answer, costs))
    return content


def asked(scenario: Scenario, folder: Path, *, robust: bool, notes: Console) -> Iterator[tuple[Scenario, Path]]:
    """Yield what is sized, and where its runs are kept: the scenario, then perhaps under spread and failures."""
    yield scenario, folder / RUNS_FOLDER
    if robust:
        say(notes, f"{UNDER}:")
        yield under_spread_and_failures(scenario), folder / ROBUST_FOLDER


def print_answers(console: Console, answers: Sequence[Answer], costs: Costs | None) -> None:
    """Print each answer; the second is that under spread and failures."""
    for answer, heading in zip(answers, ("", f"\n{UNDER}\n"), strict=False):
        if heading:
            console.print(heading, markup=False)
        console.print(table_of(answer))
        for sentence in sentences_of(answer, costs):
            console.print(sentence, markup=False)


def files_of(answers: Sequence[Answer]) -> list[str]:
    """Return the files that are written for one answer, or for two, and the folders of their runs."""
    several = len(answers) > 1
    files = [ANSWER_FILE, CANDIDATES_FILE, *[ROBUST_FILE] * several]
    return [*files, f"{RUNS_FOLDER}/", *[f"{ROBUST_FOLDER}/"] * several]


def content_of_all(answers: Sequence[Answer], costs: Costs | None) -> dict[str, Any]:
    """Return the answer as plain values; a second one, under spread and failures, as `robust`."""
    first, *others = (content_of(answer, costs) for answer in answers)
    return first | ({"robust": others[0]} if others else {})


def write_answers(answers: Sequence[Answer], costs: Costs | None, folder: Path) -> None:
    """Write answer.json and the candidates of each answer, all or none."""
    with staged(output_folder(folder)) as path:
        for answer, file in zip(answers, (CANDIDATES_FILE, ROBUST_FILE), strict=False):
            more = () if answer.least_per_order is None else ("cost_per_order",)
            write_text(path / file, to_csv((*_names(answer), *COLUMNS, *more), rows_of(answer)))
        write_text(path / ANSWER_FILE, to_json(json_ready(content_of_all(answers, costs)), indent=2) + "\n")
