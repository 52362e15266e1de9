"""Words that may not stand in pages, help texts, errors, notes, displays, reports, docstrings and comments."""

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import click
import pytest

from cases import cases
from rmfs_commands.cli.main import rmfs

ROOT = Path(__file__).resolve().parent.parent
ONE = "order|item|visit|hour|second|minute|day|run|robot|station|pod|line|step|call|trip|seed|row"
RATES = "visits|orders|items|picks|metres|requests|SKUs|tasks|trips|cells|turn-over|throughput"
MANY = f"(?:{ONE.replace('|', 's|')}s|boxes|packers|faults|events|periods|places|files|decisions|locations)"
WORDS = {
    r"\bfor who\b|(?:^|[.:;] )Who [a-z]+s\b": "the noun: callers, readers, authors",
    r"\bin turns\b": "alternately, or nothing: a method of measuring is for developers",
    r"\b(?i:h)(?:o|e)ld(?:s|ing)? (?:[\w`]+ ){0,5}against\b": "compare, check",
    r"\bbeneath\b": "under",
    r"\bbeside\b": "next to, in addition to, with",
    r"\bbut for\b": "except, apart from",
    r"\bwhoever\b": "the noun: callers, readers, authors",
    r"\bfor ever\b": "forever",
    r"\bbrings? nothing\b": "does not help",
    r"\bworth while\b": "worthwhile, or what it gains",
    r"\b(?:two|three|four|seven|eight|nine) (?:thirds|quarters|fifths|tenths|in ten)\b|\bhalf of the way\b": "%",
    rf"\b(?i:{RATES}) an? (?:{ONE})\b(?! (?:that|can|has|counts))": "per",
    rf"(?<![\w.,-])1 {MANY}\b": "the singular",
    r"(?:^|[.] )(?:Read|Written|Shown|Left out) are\b": "subject, verb, object",
    r"\broom (?:for|at|to|in)\b|\b(?:ha[sd]|have|with|no|more|most|makes?) room\b": "capacity, space, queue cell",
    r"\b(?:free|all|no|many) places?\b|\bplaces? (?:in|at|for)\b": "slot, position, storage location, cell, index",
    r"\btak(?:es?|ing) the places? of\b|\bin their places?\b": "replace, instead",
    r"\bexpected what\b|\bis there twice\b": "the noun; found ... twice",
}
"""Patterns that may not stand in a text, and what to write instead."""
ANY = re.compile("|".join(WORDS), re.MULTILINE)

TEMPLATES = [file for ending in ("j2", "html") for file in sorted((ROOT / "plugins").rglob(f"*.{ending}"))]
SCRIPTS = sorted((ROOT / "plugins").rglob("*.mjs"))
MADE = {"_build", "_generated"}
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")]
PAGES += [page for page in sorted((ROOT / "docs").rglob("*.md")) if not MADE & {*page.parts}]
CODE = [file for part in ("rmfs_core", "plugins") for file in sorted((ROOT / part).rglob("*.py"))]


def prose(page: str) -> str:
    """Return a page without its code."""
    return re.sub(r"```.*?```|`[^`\n]*`", "``", page, flags=re.DOTALL)


@cache
def parsed(file: Path) -> ast.Module:
    """Return the syntax tree of a file."""
    return ast.parse(file.read_text(encoding="utf-8"))


def docstrings(tree: ast.AST) -> Iterator[ast.Constant]:
    """Yield the texts that stand alone in code: docstrings of modules, classes, functions and names."""
    for node in ast.walk(tree):
        match node:
            case ast.Expr(value=ast.Constant(value=str()) as text):
                yield text


def explanations(file: Path) -> Iterator[tuple[int, str]]:
    """Yield docstrings and comments, with their lines."""
    yield from ((text.lineno, str(text.value)) for text in docstrings(parsed(file)))
    for line, code in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
        if comment := re.search(r"(?:^|\s)#.*", code):
            yield line, comment[0]


def sentences(file: Path) -> Iterator[tuple[int, str]]:
    """Yield the texts of code that people may read: all but docstrings and comments, with their lines."""
    tree = parsed(file)
    left_out = {id(text) for text in docstrings(tree)}
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=str(text), lineno=line) if id(node) not in left_out:
                yield line, text


def helps(command: click.Command, called: str) -> Iterator[tuple[str, str]]:
    """Yield the help of a command and of those below it."""
    yield called, command.help or ""
    if isinstance(command, click.Group):
        context = click.Context(command, info_name=called)
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            assert below is not None
            yield from helps(below, f"{called} {name}")


def found(text: str) -> list[str]:
    if not ANY.search(text):
        return []
    return [
        f"{hit[0].strip()!r}, better: {better}"
        for word, better in WORDS.items()
        for hit in re.finditer(word, text, re.MULTILINE)
    ]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_pages_use_plain_words(page: Path) -> None:
    assert found(prose(page.read_text(encoding="utf-8"))) == []


def test_help_errors_and_reports_use_plain_words() -> None:
    hits = [
        f"{file.relative_to(ROOT)}:{line}: {hit}"
        for file in CODE
        for line, text in sentences(file)
        for hit in found(text)
    ]
    hits += [f"{file.name}: {hit}" for file in TEMPLATES for hit in found(file.read_text(encoding="utf-8"))]
    texts = {file.name: re.findall(r'"[^"\n]*"|`[^`]*`', file.read_text(encoding="utf-8")) for file in SCRIPTS}
    hits += [f"{name}: {hit}" for name in texts for text in texts[name] for hit in found(text)]
    hits += [f"{called} --help: {hit}" for called, text in helps(rmfs, "rmfs") for hit in found(text)]
    assert hits == []


def test_docstrings_and_comments_use_plain_words() -> None:
    assert [
        f"{file.relative_to(ROOT)}:{line}: {hit}"
        for file in CODE
        for line, text in explanations(file)
        for hit in found(text)
    ] == []


def test_docstrings_begin_with_a_noun_or_a_verb() -> None:
    """A docstring that begins with "What" says neither what is returned nor what is done; nor does a parameter's."""
    folders = ("rmfs_core", "plugins", "tests", "tools", "docs")
    files = [file for part in folders for file in sorted((ROOT / part).rglob("*.py")) if not MADE & {*file.parts}]
    riddles = [
        f"{file.relative_to(ROOT)}:{text.lineno}"
        for file in files
        if "What " in file.read_text(encoding="utf-8")
        for text in docstrings(parsed(file))
        if re.match(r"\s*What (?!.*\?$)", str(text.value)) or re.search(r"\n +\w[\w, ]*\n +What ", str(text.value))
    ]
    assert riddles == []


@cases(
    "text words",
    ("9.3 visits an order", ["'visits an order'"]),
    ("1 orders are not complete", ["'1 orders'"]),
    ("11 orders in 1 hour; 0.1 orders per hour", []),
    ("Who adds a rule tests it, beside others", ["'Who adds'", "'beside'"]),
    ("It holds all of these rules against each other.", ["'holds all of these rules against'"]),
)
def test_words_are_found(text: str, words: list[str]) -> None:
    assert [hit.partition(",")[0] for hit in found(text)] == words
