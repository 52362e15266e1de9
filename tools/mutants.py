"""How strong the tests are: one-line mutants of kernel and rules, drawn from a seed, and the share that tests kill.

    python tools/mutants.py --seed 1 --count 60 [--near]

Each mutant is one change of one expression: a comparison, an operator, a constant, ``and`` for ``or``, a condition
turned round. The tests of the file's own folder run first, with those of whole runs; the first failure kills the
mutant. What survives is tried by all fast tests (not with ``--near``), and printed with its line. The checkout is
copied; nothing here is changed. Sixty mutants take hours.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
MUTATED = ("rmfs_core", "plugins/rmfs_rules", "plugins/rmfs_traffic")
WHOLE_RUNS = ("tests/plugins/rmfs_rules/test_oracles.py", "tests/rmfs_core/simulation", "tests/test_reproducible.py")
LIMIT_S = 1200
SWAPPED: dict[type[ast.AST], str] = {
    ast.Lt: "<=",
    ast.LtE: "<",
    ast.Gt: ">=",
    ast.GtE: ">",
    ast.Eq: "!=",
    ast.NotEq: "==",
    ast.Is: "is not",
    ast.IsNot: "is",
    ast.In: "not in",
    ast.NotIn: "in",
    ast.Add: "-",
    ast.Sub: "+",
    ast.Mult: "//",
    ast.FloorDiv: "*",
    ast.And: "or",
    ast.Or: "and",
}


class Mutant(NamedTuple):
    """A change of a file.

    Parameters
    ----------
    file
        The file, from the root.
    line
        Number of the line.
    begin, end
        Span that is replaced, in bytes of the file.
    before, after
        Its text, and what takes its place.
    """

    file: str
    line: int
    begin: int
    end: int
    before: str
    after: str


def mutants_of(file: Path) -> Iterator[Mutant]:
    """Yield the mutants of a file."""
    content = file.read_bytes()
    starts = [0]
    for row in content.splitlines(keepends=True):
        starts.append(starts[-1] + len(row))

    def place(line: int, column: int) -> int:
        return starts[line - 1] + column

    def changed(node: ast.expr, begin: int, end: int, after: str) -> Iterator[Mutant]:
        before = content[begin:end].decode()
        if "\n" not in before and before.strip() != after.strip():
            yield Mutant(file.relative_to(ROOT).as_posix(), node.lineno, begin, end, before, after)

    def joined(node: ast.expr, left: ast.expr, right: ast.expr, operator: type[ast.AST]) -> Iterator[Mutant]:
        """Change what stands between two operands, unless a parenthesis does, too."""
        begin, end = place(left.end_lineno or 0, left.end_col_offset or 0), place(right.lineno, right.col_offset)
        if not re.search(rb"[()]", content[begin:end]):
            yield from changed(node, begin, end, f" {SWAPPED[operator]} ")

    tree = ast.parse(content)
    how = ("cache", "interpreted")  # whether compiled code is stored, or may be left out, no result shows
    kept = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.keyword) and node.arg in how}
    for node in ast.walk(tree):
        if not isinstance(node, ast.expr) or id(node) in kept:
            continue
        begin, end = place(node.lineno, node.col_offset), place(node.end_lineno or 0, node.end_col_offset or 0)
        match node:
            case ast.Compare(left=left, ops=[operator], comparators=[right]) if type(operator) in SWAPPED:
                yield from joined(node, left, right, type(operator))
            case ast.BinOp(left=left, op=operator, right=right) if type(operator) in SWAPPED:
                yield from joined(node, left, right, type(operator))
            case ast.BoolOp(op=operator, values=[left, right]):
                yield from joined(node, left, right, type(operator))
            case ast.Constant(value=bool(value)):
                yield from changed(node, begin, end, str(not value))
            case ast.Constant(value=int(value)):
                yield from changed(node, begin, end, str(value + 1))
            case ast.UnaryOp(op=ast.Not()):
                yield from changed(node, begin, begin + len("not "), content[begin + 3 : begin + 4].decode().strip())
            case ast.IfExp(test=test):
                at = place(test.lineno, test.col_offset), place(test.end_lineno or 0, test.end_col_offset or 0)
                yield from changed(test, *at, f"not ({content[slice(*at)].decode()})")


def tests_of(file: str) -> list[str]:
    """Return the tests that look at a file most closely: those of its folder, those that name it, or those above."""
    package = Path(file).parent
    while not (ROOT / "tests" / package).is_dir():
        named = re.compile(rf"\b{package.parent.name}\.{package.name}\b")
        beside = sorted((ROOT / "tests" / package.parent).glob("test_*.py"))
        found = [one for one in beside if named.search(one.read_text(encoding="utf-8"))]
        if found:
            return [*(one.relative_to(ROOT).as_posix() for one in found), *WHOLE_RUNS]
        package = package.parent
    return [(Path("tests") / package).as_posix(), *WHOLE_RUNS]


def is_killed(copy: Path, tests: list[str], jobs: int) -> bool:
    """Whether tests fail, or take too long, in a copy of the checkout."""
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, (copy, copy / "plugins")))}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-m", "not slow", "-n", str(jobs), "-p", "no:cacheprovider"]
    with subprocess.Popen(
        [*command, *tests],
        cwd=copy,
        env=variables,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=True,
    ) as done:
        try:
            told, _ = done.communicate(timeout=LIMIT_S)
        except subprocess.TimeoutExpired:
            os.killpg(done.pid, signal.SIGKILL)  # with the processes that run the tests
            return True
    if done.returncode > 2:  # not tests that failed, which end with 1, and with 2 where xdist stops others
        sys.exit(f"pytest ended with {done.returncode}; nothing can be told:\n{told.decode()[-2000:]}")
    return done.returncode != 0


def main() -> None:
    """Draw mutants, try them, and print the share that was killed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--near", action="store_true", help="do not try what survives by all fast tests")
    given = parser.parse_args()
    files = sorted(file for folder in MUTATED for file in (ROOT / folder).rglob("*.py"))
    drawn = random.Random(given.seed).sample([mutant for file in files for mutant in mutants_of(file)], given.count)
    survived = 0
    with tempfile.TemporaryDirectory(dir=ROOT.parent) as folder:
        copy = Path(folder) / "checkout"
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".venv*", ".git", "docs/_build", ".*_cache"))
        if not given.near and is_killed(copy, ["tests"], given.jobs):
            sys.exit("Tests fail in the copy of the checkout without any mutant; nothing can be told.")
        for number, mutant in enumerate(drawn, 1):
            path = copy / mutant.file
            content = path.read_bytes()
            path.write_bytes(content[: mutant.begin] + mutant.after.encode() + content[mutant.end :])
            killed = is_killed(copy, tests_of(mutant.file), given.jobs)
            killed = killed or (not given.near and is_killed(copy, ["tests"], given.jobs))
            path.write_bytes(content)
            survived += not killed
            what = f"{mutant.file}, line {mutant.line}: `{mutant.before.strip()}` -> `{mutant.after.strip()}`"
            print(f"{number:3} {'killed  ' if killed else 'SURVIVED'} {what}", flush=True)
    print(f"{given.count - survived} of {given.count} killed ({(given.count - survived) / given.count:.0%})")


if __name__ == "__main__":
    main()
