"""``rmfs explain``: why was this decided."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rmfs_commands.cli import completion
from rmfs_commands.cli.options import WholeNumberRange, json_option, no_inline_option
from rmfs_commands.cli.screen import output_console, print_json, say
from rmfs_core.roles import Role

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_commands.states import Answer, Outcome, Recorded, Recording
    from rmfs_commands.states.deciding import BundleOutcome
    from rmfs_core.scenario import RuleChoice


@click.command(short_help="Say why something was decided in a run.")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "--period", type=WholeNumberRange(min=1), metavar="N", help="Explain how orders were assigned in period N."
)
@click.option("--decision", type=WholeNumberRange(min=1), metavar="K", help="Explain decision number K, of any kind.")
@click.option("--order", metavar="NAME", help="Show why an order waited, and the decisions on it.")
@click.option("--pod", metavar="NAME", help="Show where a pod was sent, fetched and stored.")
@click.option(
    "--against",
    "against",
    multiple=True,
    metavar="RULE",
    shell_complete=completion.rules,
    help="Show the decision of this rule in the same state: a name, a table as in scenario files "
    '(`{ rule = "demand", ... }`), or a POA and a PPS rule (`pod-match + demand`). Repeatable.',
)
@click.option(
    "--state", "state_file", type=click.Path(path_type=Path), metavar="FILE", help="File to write the state to."
)
@click.option("--limit", type=WholeNumberRange(min=1), default=10, show_default=True, help="Orders to show at most.")
@no_inline_option
@json_option
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
    as_json: bool,
) -> None:
    """Say why something was decided in the run in DIR, which `rmfs run --record-decisions` wrote.

    Shows the state that the rule saw, its decision, the objective and bound of its model, and what other rules would
    have decided there. Without an option it counts the decisions.
    """
    from rmfs_commands.results.files import to_json, write_text
    from rmfs_commands.states import explain_tables as tables
    from rmfs_commands.states import read_recording

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
    console = output_console()
    with _whole(console, recording):
        if order is not None:
            _tell(console, recording, "order", order, as_json)
        elif pod is not None:
            _tell(console, recording, "pod", pod, as_json)
        elif as_json and not (period or decision):
            print_json(tables.overview(recording))
        elif not (period or decision):
            tables.print_overview(console, recording)
        else:
            explained, others = _find(recording, period, decision)
            compared = [(text, _alternative(text, explained, allow_inline=not no_inline_rules)) for text in against]
            if as_json:
                print_json(_plain(explained, compared, others))
            else:
                _print(console, explained, recording.choice_of(explained), compared, limit)
                tables.print_others(console, others)
            if state_file is not None:
                write_text(state_file, to_json(explained.content, indent=1) + "\n")
                if not as_json:
                    how = f"`rmfs decide {state_file} --rule RULE` asks a rule again."
                    say(console, f"State written to {state_file}; {how}")


@contextmanager
def _whole(console: Console, recording: Recording) -> Iterator[None]:
    """Print all or nothing; raise `InputError` where a decision is not what rmfs records."""
    from rmfs_core.errors import InputError
    from rmfs_core.wording import one_line

    try:
        with console.capture() as printed:
            yield
    except (KeyError, TypeError, AttributeError, ValueError, IndexError, OverflowError, StopIteration) as error:
        problem = f"a decision is not what rmfs has recorded ({one_line(error)})"
        raise InputError(str(recording.file), problem) from error
    console.file.write(printed.get())


def _tell(console: Console, recording: Recording, kind: str, name: str, as_json: bool) -> None:
    """Tell what was decided for an order or a pod."""
    from rmfs_commands.states import explain_tables as tables
    from rmfs_commands.states.stories import order_story, pod_story
    from rmfs_commands.states.trucks import truck_of

    _know(recording, kind, name)
    told = list((order_story if kind == "order" else pod_story)(recording, name))
    truck = truck_of(recording, name) if kind == "order" else None
    if as_json:
        print_json({kind: name, "episodes": told} | ({} if truck is None else {"truck": truck}))
    else:
        tables.print_story(console, f"{kind} {name}", told)
        if truck is not None:
            say(console, truck["words"])


def _print(
    console: Console,
    explained: Recorded,
    choice: RuleChoice,
    compared: list[tuple[str, Answer]],
    limit: int,
) -> None:
    from rmfs_commands.states import explain_tables as tables

    tables.print_decision(console, explained, choice, explained.state(), limit)
    if compared:
        tables.print_comparison(console, explained, _outcome(explained), compared)


def _outcome(explained: Recorded) -> Outcome | BundleOutcome | None:
    from rmfs_commands.states.deciding import outcome_of

    if explained.decision is None:
        return None
    return outcome_of(explained.state(), explained.decides, explained.decision, explained.place)


def _plain(explained: Recorded, compared: list[tuple[str, Answer]], others: list[Recorded]) -> dict[str, Any]:
    """Return a decision, what other rules would have decided, and the pod selections after it, as plain values."""
    return {
        **_decided(explained),
        "report": explained.report,
        "outcome": _outcome(explained),
        "against": [
            {"rule": text, "decision": one.decision, "report": one.report, "outcome": one.outcome}
            for text, one in compared
        ],
        "then": [_decided(one) for one in others],
        "state": explained.content,
    }


def _decided(recorded: Recorded) -> dict[str, Any]:
    return {
        "number": recorded.number,
        "period": recorded.period,
        "time_s": recorded.time_s,
        "decides": recorded.decides.label,
        "rule": recorded.rule,
        "decision": recorded.decision,
    }


def _alternative(text: str, explained: Recorded, *, allow_inline: bool) -> Answer:
    from rmfs_commands.cli.choices import parse_choice
    from rmfs_commands.states.deciding import decide_instead

    parts = [text] if text.lstrip().startswith("{") else text.split("+")
    place = f"--against {text}"
    choices = [parse_choice(part.strip(), place) for part in parts]
    return decide_instead(
        explained.state(), choices, explained.decides, allow_inline=allow_inline, source=explained.place, place=place
    )


def _find(recording: Recording, period: int | None, number: int | None) -> tuple[Recorded, list[Recorded]]:
    """Return the decision to explain, and the PPS decisions between it and the next period when one is asked for."""
    from rmfs_core.errors import InputError

    found: Recorded | None = None
    others: list[Recorded] = []
    last, periods, first = 0, 0, 0
    for recorded in recording:
        last, periods = recorded.number, max(periods, recorded.period)
        first = first or (recorded.period if recorded.decides.assigns else 0)
        if recorded.number == number or (recorded.period == period and recorded.decides.assigns):
            found = recorded
        elif recorded.period == period and recorded.decides is Role.PPS:
            others.append(recorded)
        if found is not None and (number is not None or recorded.period > found.period):
            break
    if found is not None:
        return found, others
    if period is not None:
        raise InputError(f"--period {period}", f"there is none; the run has {_numbered('period', periods, first)}")
    raise InputError(f"--decision {number}", f"there is none; the run has {_numbered('decision', last)}")


def _numbered(what: str, last: int, first: int = 1) -> str:
    return f"{what}s {first or 1} to {last}" if last else f"no {what}"


def _know(recording: Recording, kind: str, name: str) -> None:
    """Raise `InputError` for an order or pod that the run does not have."""
    from rmfs_core.errors import InputError
    from rmfs_core.wording import did_you_mean, first_few

    names: list[str] = []
    for recorded in recording:
        names = list(recorded.content[f"{kind}s"])
    if name not in names:
        near = did_you_mean(name, names) or (f"; expected one such as {first_few(names)}" if names else "")
        raise InputError(f"--{kind} {name}", f"the run has no {kind} of that name{near}")
