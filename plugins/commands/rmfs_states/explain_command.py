"""``rmfs explain``: why was this decided."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_cli.screen import table_console

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_core.scenario import RuleChoice
    from rmfs_states import Answer, Recorded, Recording, State
    from rmfs_states.stories import Episode

PIPE_WIDTH = 120
"""Columns of the tables where the output is no terminal."""


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option("--period", type=click.IntRange(min=1), metavar="N", help="Explain how orders were assigned in period N.")
@click.option("--decision", type=click.IntRange(min=1), metavar="K", help="Explain decision number K, of any kind.")
@click.option("--order", metavar="NAME", help="Tell why an order waited, and what was decided for it.")
@click.option("--pod", metavar="NAME", help="Tell where a pod was sent, fetched and stored.")
@click.option(
    "--against",
    "against",
    multiple=True,
    metavar="RULE",
    help="What would this rule have decided in the same state? A name, a table as in scenario files "
    '(`{ rule = "demand", ... }`), or a POA and a PPS rule (`pod-match + demand`). Repeatable.',
)
@click.option("--state", "state_file", type=click.Path(path_type=Path), metavar="FILE", help="Write the state there.")
@click.option("--limit", type=click.IntRange(min=1), default=10, show_default=True, help="Orders to show at most.")
@click.option("--no-inline-rules", is_flag=True, help="Refuse rules from files.")
def explain(
    folder: Path,
    period: int | None,
    decision: int | None,
    order: str | None,
    pod: str | None,
    against: tuple[str, ...],
    state_file: Path | None,
    limit: int,
    no_inline_rules: bool,
) -> None:
    """Say why something was decided in the run in DIR, which `rmfs run --record-decisions` wrote.

    Shows the state that the rule saw, its decision, the objective and bound of its model, and what other rules would
    have decided there. Without an option it counts the decisions.
    """
    from rmfs_states import explain_tables as tables
    from rmfs_states import read_recording
    from rmfs_states.stories import order_story, pod_story

    chosen = [
        name
        for name, value in (("--period", period), ("--decision", decision), ("--order", order), ("--pod", pod))
        if value
    ]
    if len(chosen) > 1:
        raise click.UsageError(f"{chosen[0]} and {chosen[1]} exclude each other.")
    if (against or state_file) and not (period or decision):
        raise click.UsageError("--against and --state need --period or --decision.")
    recording = read_recording(folder)
    console = table_console(PIPE_WIDTH)
    if order is not None:
        _know(recording, "order", order)
        tables.print_story(console, f"order {order}", _told(recording, order_story, order))
    elif pod is not None:
        _know(recording, "pod", pod)
        tables.print_story(console, f"pod {pod}", _told(recording, pod_story, pod))
    elif period is None and decision is None:
        tables.print_overview(console, recording)
    else:
        explained, others = _find(recording, period, decision)
        choice = recording.choice_of(explained)
        _explain(console, explained, choice, against, state_file, limit, allow_inline=not no_inline_rules)
        tables.print_others(console, others)


def _explain(
    console: Console,
    explained: Recorded,
    choice: RuleChoice,
    against: tuple[str, ...],
    state_file: Path | None,
    limit: int,
    *,
    allow_inline: bool,
) -> None:
    from rmfs_core.results.files import to_json, write_text
    from rmfs_states import explain_tables as tables
    from rmfs_states.deciding import outcome_of

    state = explained.state()
    answers = [_alternative(state, text, explained, allow_inline=allow_inline) for text in against]
    if state_file is not None:
        write_text(state_file, to_json(explained.content, indent=1) + "\n")
    outcome = None
    if explained.decision is not None:
        outcome = outcome_of(state, explained.decides, explained.decision, explained.place)
    tables.print_decision(console, explained, choice, state, limit)
    if answers:
        tables.print_comparison(console, explained, outcome, list(zip(against, answers, strict=True)))
    if state_file is not None:
        click.echo(f"State written to {state_file}; `rmfs decide {state_file} --rule RULE` asks a rule again.")


def _alternative(state: State, text: str, explained: Recorded, *, allow_inline: bool) -> Answer:
    from rmfs_cli.choices import parse_choice
    from rmfs_states.deciding import decide_instead

    parts = [text] if text.lstrip().startswith("{") else text.split("+")
    place = f"--against {text}"
    choices = [parse_choice(part.strip(), place) for part in parts]
    return decide_instead(
        state, choices, explained.decides, allow_inline=allow_inline, source=explained.place, place=place
    )


def _find(recording: Recording, period: int | None, number: int | None) -> tuple[Recorded, list[Recorded]]:
    """Return the decision to explain, and the PPS decisions between it and the next period when one is asked for."""
    from rmfs_core.errors import InputError
    from rmfs_states.stories import ASSIGNING

    found: Recorded | None = None
    others: list[Recorded] = []
    last, periods = 0, 0
    for recorded in recording:
        last, periods = recorded.number, max(periods, recorded.period)
        if recorded.number == number or (recorded.period == period and recorded.decides in ASSIGNING):
            found = recorded
        elif recorded.period == period and recorded.decides == "PPS":
            others.append(recorded)
        if found is not None and (number is not None or recorded.period > found.period):
            break
    if found is not None:
        return found, others
    if period is not None:
        raise InputError(f"--period {period}", f"there is none; the run has periods 1 to {periods}")
    raise InputError(f"--decision {number}", f"there is none; the run has decisions 1 to {last}")


def _know(recording: Recording, kind: str, name: str) -> None:
    """Raise `InputError` for an order or pod that the run does not have."""
    from rmfs_core.errors import InputError
    from rmfs_core.wording import did_you_mean

    names: list[str] = []
    for recorded in recording:
        names = list(recorded.content[f"{kind}s"])
    if name not in names:
        range_ = f"; they are called {names[0]} to {names[-1]}" if names else ""
        raise InputError(f"--{kind} {name}", f"the run has no {kind} of that name{did_you_mean(name, names) or range_}")


def _told(
    recording: Recording, story: Callable[[Iterable[Recorded], str], Iterable[Episode]], name: str
) -> list[Episode]:
    from rmfs_core.errors import InputError

    try:
        return list(story(recording, name))
    except (KeyError, TypeError, AttributeError, StopIteration) as error:
        raise InputError(str(recording.file), f"a decision lacks {error}; expected what rmfs has recorded") from error
