"""Call every command with inputs that were made wrong: nothing may break, hang, or answer without a clear sentence.

``python tools/fuzz.py [--seed S] [--cases N]`` makes cases from small valid inputs (scenarios, CSV files, maps, states,
recordings, experiments, arguments), the same for the same seed, and does them in a process with limits. Looked for are
tracebacks, exit codes other than 0, 1, 2 and 130, more than 10 s of CPU or 2 GB of memory, errors that are not one
line, and output by halves. Each kind is told once, with a command that repeats its first case alone:
``python tools/fuzz.py --seed S --case N``. Exit code 1 when there was any.
"""

from __future__ import annotations

import argparse
import os
import shlex
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy is imported: threads do not survive the copy of a process

from attrs import Factory, define

from fuzzing.bases import make_bases
from fuzzing.judging import violations
from fuzzing.surfaces import Case, make_case
from fuzzing.working import Call, Outcome, outcomes, write_files
from rmfs_commands.cli.main import main as rmfs


@define
class Found:
    """Findings.

    Parameters
    ----------
    cases
        Numbers of the cases of each kind of violation.
    codes
        How often each exit code was.
    cpu_s
        CPU time by surface, and by case.
    """

    cases: dict[str, list[int]] = Factory(dict)
    codes: dict[int | None, int] = Factory(dict)
    cpu_s: dict[str, list[float]] = Factory(dict)


def scan(
    numbers: Sequence[int],
    make: Callable[[int], Case],
    call: Call = rmfs,
    each: Callable[[int, Case, Outcome, list[str]], None] | None = None,
) -> Found:
    """Do cases and return what was found in them."""
    found = Found()
    for number, case, outcome in outcomes(numbers, make, call):
        kinds = list(dict.fromkeys(violations(case, outcome)))
        for kind in kinds:
            found.cases.setdefault(kind, []).append(number)
        found.codes[outcome.code] = found.codes.get(outcome.code, 0) + 1
        found.cpu_s.setdefault(case.surface, []).append(outcome.cpu_s)
        if each is not None:
            each(number, case, outcome, kinds)
    return found


def show(number: int, case: Case, outcome: Outcome, kinds: list[str]) -> None:
    """Print a case and what came of it."""
    print(f"case {number}, {case.surface}: rmfs {shlex.join(case.arguments)[:2000]!r}")
    for name, text in (("output", outcome.output), ("errors", outcome.errors), ("traceback", outcome.trace)):
        if text:
            print(f"--- {name}\n{text[:5000].rstrip().encode('utf-8', 'backslashreplace').decode()}")
    print(f"--- exit code {outcome.code} {outcome.ended_by}, {outcome.cpu_s:.2f} s, new files: {outcome.left}")
    print("\n".join(f"!!! {kind}" for kind in kinds) or "nothing wrong")


def main(arguments: Sequence[str] | None = None) -> None:
    """Do the cases and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=1000, help="how many, from the first on")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--case", type=int, help="do this one alone, and show it")
    parser.add_argument("--files", type=Path, help="write the files of --case there")
    parser.add_argument("--only", metavar="SURFACE", help="leave out cases of other surfaces")
    parser.add_argument("--times", action="store_true", help="show where the time went")
    given = parser.parse_args(arguments)
    bases = make_bases()

    def make(number: int) -> Case:
        return make_case(bases, given.seed, number)

    if given.case is not None:
        if given.files is not None:
            given.files.mkdir()
            write_files(make(given.case), given.files)
        sys.exit(1 if scan([given.case], make, each=show).cases else 0)
    began = time.perf_counter()
    numbers = range(given.first, given.first + given.cases)
    found = scan([number for number in numbers if given.only in (None, make(number).surface)], make)
    report(found, given.seed, time.perf_counter() - began)
    if given.times:
        for surface, each in sorted(found.cpu_s.items(), key=lambda item: -sum(item[1])):
            mean, most = sum(each) / len(each), max(each)
            print(f"{surface}: {len(each)} cases, {sum(each):.1f} s, {mean:.3f} s each, {most:.1f} s at most")
    sys.exit(1 if found.cases else 0)


def report(found: Found, seed: int, wall_s: float) -> None:
    """Print every kind once, the most frequent first."""
    number = sum(found.codes.values())
    codes = ", ".join(f"{code}: {count}" for code, count in sorted(found.codes.items(), key=lambda item: str(item[0])))
    print(f"{number} cases in {wall_s:.0f} s; exit codes {codes}; {len(found.cases)} kinds of violations")
    for kind, cases in sorted(found.cases.items(), key=lambda item: -len(item[1])):
        print(f"{len(cases)} x {kind}\n    python tools/fuzz.py --seed {seed} --case {cases[0]}")


if __name__ == "__main__":
    main()
