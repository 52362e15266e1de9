"""The answer, for people and as files."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from attrs import asdict, evolve, frozen

from rmfs_commands.cli.not_simulated import NOT_SIMULATED
from rmfs_commands.cli.pages import render
from rmfs_commands.experiments.compare import CONFIDENCE
from rmfs_commands.experiments.report import numbers
from rmfs_commands.experiments.report.plots import make_plots
from rmfs_commands.results.files import json_ready, output_folder, staged, to_csv, to_json, write_text
from rmfs_commands.slotting.judging import OWN, RULES, Judged
from rmfs_commands.slotting.making import Made
from rmfs_commands.slotting.past import Past
from rmfs_commands.slotting.placing import HELD_BACK, NOW
from rmfs_core.scenario.tomltext import toml_text
from rmfs_core.wording import counted

if TYPE_CHECKING:
    from rich.console import Console

PODS_FILE, FRAGMENT_FILE, ANSWER_FILE, CHANGES_FILE = "pods.csv", "slotted.toml", "answer.json", "changes.csv"
REPORT_FILE = "report.html"
TEMPLATE = Path(__file__).parent / "report.html.j2"


@frozen(eq=False)
class Answer:
    """The answer.

    Parameters
    ----------
    name
        Of the scenario.
    past
        The history and the later days.
    made
        The placements.
    judged
        The runs.
    """

    name: str
    past: Past
    made: Made
    judged: Judged

    @property
    def learned(self) -> str:
        """A sentence on the history and the days judged on."""
        past = self.past
        orders, days = counted(len(past.baskets), "order"), counted(past.days, "day")
        first, last = past.later[0].name, past.later[-1].name
        later = f"{len(past.later)} later days ({first} to {last})" if len(past.later) > 1 else f"1 later day ({first})"
        return f"Learned from {orders} of {days}; judged on {later}."

    def sentences(self) -> Iterator[str]:
        """Yield the answer for each set of rules, then what one should know besides."""
        chosen, now = self.made.chosen, self.made.placements[0]
        if chosen.name == NOW:
            yield "No placement needs fewer visits than the pods as they are, by the orders it is chosen by."
        for rules, instances in self.judged.sets():
            if chosen.name != NOW:
                yield f"{_whose(rules)}, {chosen.name}: {figures_of(self.judged, instances, chosen.name)}."
        part = f"the last {100 * HELD_BACK:g} % of the history, where"
        if not self.made.holds_back:
            part = "all of the history, too short to hold back a part;"
        at_a_time = f"{counted(self.made.batch, 'order')} at a station at a time (as they are: {now.held_back:.3f})"
        yield (
            f"Chosen by {part} {chosen.name} needs {chosen.held_back:.3f} visits per order, {at_a_time}. The runs had "
            "no part in it."
        )
        yield self.learned
        if not self.past.dated:
            yield "Its times are seconds from a time 0 of its own: that it is earlier than the days is not checked."
        yield from self.made.notes


def _whose(rules: str) -> str:
    return "The scenario's rules" if rules == OWN else rules


def figures_of(judged: Judged, instances: str, placement: str) -> str:
    """Return what a placement changes in each metric, with interval, and whether that may be chance."""
    told = []
    for metric in judged.comparison.metrics:
        shown_as = judged.comparison.described(metric)
        one = next(one for one in judged.comparison.of(instances, metric) if one.rule_set == placement)
        p = one.relative.p_holm
        figure = numbers.relative(one) if one.relative.mean is not None else ""
        doubt = ", which may be chance" if p is not None and p > 1 - CONFIDENCE else ""
        told.append(f"{numbers.title(shown_as).partition(' (')[0].lower()} {figure or 'not known'}{doubt}")
    return "; ".join(told)


def rows_of(answer: Answer) -> Iterator[dict[str, Any]]:
    """Yield the figures of each metric, set of rules and placement."""
    comparison = answer.judged.comparison
    for metric in comparison.metrics:
        for rules, instances in answer.judged.sets():
            for one in comparison.of(instances, metric):
                yield {
                    "metric": metric,
                    RULES: rules,
                    "placement": one.rule_set,
                    f"{answer.judged.unit}s": one.seeds,
                    "mean": one.mean,
                    "difference": asdict(one.difference),
                    "relative": asdict(one.relative),
                    "left_out": one.left_out,
                }


def content_of(answer: Answer) -> dict[str, Any]:
    """Return the answer for machines."""
    experiment = answer.judged.result.experiment
    return {
        "scenario": answer.name,
        "chosen": answer.made.chosen.name,
        "told": list(answer.sentences()),
        "history": {"orders": len(answer.past.baskets), "days": answer.past.days},
        "judged_on": [day.name for day in answer.past.later],
        "seeds": experiment.seeds,
        "batch": answer.made.batch,
        "placements": [
            {
                "name": one.name,
                "visits_seen": one.seen,
                "visits_held_back": one.held_back if answer.made.holds_back else None,
            }
            for one in answer.made.placements
        ],
        "compared": list(rows_of(answer)),
        "changes": [{**asdict(one), "pays_days": one.pays_days} for one in answer.made.changes],
        "versions": answer.judged.result.versions,
    }


def write(answer: Answer, folder: Path) -> list[str]:
    """Write the chosen pods, a section for the scenario, the changes, the answer and the page; return their names."""
    fragment = "".join(f"# {line}\n" for line in answer.sentences())
    texts = {
        PODS_FILE: answer.made.pods[answer.made.chosen.name],
        FRAGMENT_FILE: f"{fragment}[instance]\npods_file = {toml_text(PODS_FILE)}\n",
        ANSWER_FILE: to_json(json_ready(content_of(answer)), indent=2) + "\n",
        REPORT_FILE: page(answer),
    }
    if answer.made.changes:
        rows = [{**asdict(one), "pays_days": one.pays_days} for one in answer.made.changes]
        texts[CHANGES_FILE] = to_csv(list(rows[0]), rows)
    else:
        (folder / CHANGES_FILE).unlink(missing_ok=True)  # of an earlier answer
    with staged(output_folder(folder)) as path:
        for name, text in texts.items():
            write_text(path / name, text)
    return list(texts)


def page(answer: Answer) -> str:
    """Return the answer as one HTML page."""
    judged = answer.judged
    comparison = judged.comparison
    kept = tuple(instances for _, instances in judged.sets())
    plots = make_plots([], evolve(comparison, instance_sets=kept))
    return render(
        TEMPLATE,
        answer=answer,
        sentences=list(answer.sentences()),
        judged=judged,
        comparison=comparison,
        numbers=numbers,
        counted=counted,
        whose=_whose,
        plots={plot.name: plot.svg for plot in plots},
        versions=", ".join(f"{name} {version[:19]}" for name, version in judged.result.versions.items()),
        not_simulated=NOT_SIMULATED,
    )


def show(console: Console, answer: Answer) -> None:
    """Print the answer."""
    from rich.text import Text

    from rmfs_commands.cli.screen import new_table, print_named, say

    made = new_table("Visits per order, quick figure")
    for name in ("Placement", "History", *["Held back"] * answer.made.holds_back):
        made.add_column(name, justify="left" if name == "Placement" else "right")
    for made_one in answer.made.placements:
        style = "bold green" if made_one is answer.made.chosen else ""
        held_back = [f"{made_one.held_back:.3f}"] * answer.made.holds_back
        made.add_row(Text(made_one.name), f"{made_one.seen:.3f}", *held_back, style=style)
    print_named(console, made)
    comparison = answer.judged.comparison
    for metric in comparison.metrics:
        shown_as = comparison.described(metric)
        table = new_table(numbers.heading(comparison, metric))
        table.add_column("Placement")
        for name in (f"{answer.judged.unit.capitalize()}s", "Mean", "Change", "p (Holm)"):
            table.add_column(name, justify="right")
        for rules, instances in answer.judged.sets():
            table.add_row(Text(_whose(rules), "cyan"))
            for one in comparison.of(instances, metric):
                style = "bold green" if one.rule_set == answer.made.chosen.name else ""
                cells = (
                    ["", ""]
                    if one.rule_set == NOW
                    else [numbers.relative(one), numbers.probability(one.relative.p_holm)]
                )
                table.add_row(
                    Text(f"  {one.rule_set}"),
                    numbers.seeds(one),
                    numbers.value(shown_as, one.mean),
                    *cells,
                    style=style,
                )
        print_named(console, table)
    for number, change in enumerate(answer.made.changes, 1):
        say(console, f"{number}. {change}")
    for row in answer.judged.result.failed[:5]:
        say(console, f"Failed: {row['instance']}, {row['rule_set']}, seed {row['seed']}: {row['error']}", "red")
    for line in answer.sentences():
        say(console, line)
