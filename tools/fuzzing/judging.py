"""Violations: what may not happen, whatever the input."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

from fuzzing.surfaces import Case
from fuzzing.working import Outcome

EXIT_CODES = (0, 1, 2, 130)
LONGEST = 1500
"""Signs of a sentence; some name a path, and a number as it was given."""

_FRAME = re.compile(r'^ *File "(?P<file>[^"]*)", line \d+,? in (?P<function>.+)$', re.MULTILINE)
_RAISED = re.compile(r"^(?P<name>[A-Za-z_][\w.]*)(:|$)", re.MULTILINE)
_WARNING = re.compile(r"^\S+\.py:\d+: (?P<name>\w+)", re.MULTILINE)
_CHAINED = re.compile(r"\n\n(?:The above exception was|During handling of the above)")
_OURS = re.compile(r"(?:^|/)((?:rmfs_core|plugins|tools)/.*)")
_SHOWN = re.compile(r"[\"'`].*|--set .*|[^\x20-\x7e].*|(?<=: )found.*|\d+")
_FAULTS = {("validate", 1), ("scenario", 2), ("bench", 1)}
"""Commands and exit codes that tell what is wrong as their output."""


def violations(case: Case, outcome: Outcome) -> Iterator[str]:
    """Yield the kind of everything that may not happen: equal texts are one kind."""
    if outcome.code is None:
        what = {"SIGXCPU": "hang: too much CPU time", "no answer": "hang: no answer"}
        how = what.get(outcome.ended_by, f"ended by {outcome.ended_by}")
        yield f"{how}, in {_place(outcome.trace, innermost_first=True)}"
        return
    if outcome.trace:
        yield f"traceback: {_exception(outcome.trace)}"
        return
    if outcome.code not in EXIT_CODES:
        yield f"exit code {outcome.code}"
    if found := _WARNING.search(outcome.errors):
        yield f"warning: {found['name']} in {_place_of(found[0].partition(':')[0])}"
        return
    yield from _of_message(case, outcome)
    yield from _of_output(case, outcome)


def _of_message(case: Case, outcome: Outcome) -> Iterator[str]:
    if outcome.code not in (1, 2):
        return
    lines = outcome.errors.splitlines()
    if not any(line.startswith("Error: ") for line in lines):
        if lines[:1] and lines[0].startswith("Usage: "):
            return
        if (*case.arguments[:1], outcome.code) in _FAULTS and outcome.output:
            return
        yield f"no sentence: {case.surface}, exit code {outcome.code}"
    elif not lines[-1].startswith("Error: "):
        yield f"more than a line: {_shortened(outcome.errors[outcome.errors.index('Error: ') :])}"
    elif len(lines[-1]) > LONGEST:
        yield f"a sentence of {len(lines[-1]) // 1000},000 signs: {_shortened(lines[-1])}"
    elif not lines[-1].replace("\t", " ").isprintable():
        yield f"a sentence with signs that cannot be shown: {_shortened(lines[-1])}"


def _of_output(case: Case, outcome: Outcome) -> Iterator[str]:
    if hidden := [name for name in outcome.left if any(part.startswith(".") for part in name.split("/"))]:
        yield f"left behind: {hidden[0].rpartition('/')[2]}"
    if outcome.code == 2 and outcome.left:
        yield f"exit code 2, but written: {case.arguments[0]}, {outcome.left[0].rpartition('/')[2]}"
    if outcome.code == 0 and "--json" in case.arguments and "--help" not in case.arguments and outcome.output:
        try:
            json.loads(outcome.output, parse_constant=_no_json)
        except ValueError as error:
            yield f"no JSON: {case.arguments[0]}, {_shortened(str(error))}"


def _no_json(name: str) -> None:
    raise ValueError(f"found {name}")


def _exception(trace: str) -> str:
    """Return type and place of an exception; where there are several, of the last but one, which the last one tells."""
    *_, first = _CHAINED.split(trace)[-2:][:1]
    raised = [found["name"] for found in _RAISED.finditer(first) if found["name"] not in ("Traceback", "Error")]
    return f"{raised[-1] if raised else 'unknown'} in {_place(first)}"


def _place(trace: str, *, innermost_first: bool = False) -> str:
    """Return file and function of the innermost frame in code of the project."""
    frames = [(_OURS.search(found["file"]), found["function"]) for found in _FRAME.finditer(trace)]
    ours = [f"{file[1]}, {function}" for file, function in frames if file and not file[1].startswith("tools/")]
    return (ours[0] if innermost_first else ours[-1]) if ours else "code of others"


def _place_of(file: str) -> str:
    found = _OURS.search(file)
    return found[1] if found else file


def _shortened(text: str) -> str:
    """Return a message without what of it is the input's."""
    return _SHOWN.sub("...", text.splitlines()[0])[:80]
