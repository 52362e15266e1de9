"""Valid inputs, made wrong: trees of values (TOML, JSON), tables, texts, bytes and arguments."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from copy import deepcopy
from random import Random
from typing import Any

Tree = Any
"""Tables, lists and single values, as TOML and JSON have them."""

DEPTHS = (300, 450, 2000)


class Literal(str):
    """Values written as they are: numbers that Python does not print, dates."""

    __slots__ = ()


class Deep(str):
    """A list or a table of which each holds another, some hundred-fold: its kind and how often."""

    __slots__ = ()


NUMBERS: tuple[Any, ...] = (
    *(0, -1, 1, 2, 3, 2**31, 2**63, 2**64, 1_000_000_001, 10**18, 10**19, -(10**19)),
    *(0.5, -0.5, -0.0, 1e-320, 1e308, -1e308, math.nan, math.inf, -math.inf),
    *(Literal("9" * 400), Literal("-" + "9" * 5000), Literal("1e999"), Literal("9" * 5000), Literal("1e-999")),
)
TEXTS = (
    *("", " ", "x", "0", "a" * 300, "\0", "a\nb", "\x1b[31m", "\ud800", "Zoë", "東京", "9" * 400, "9" * 5000, "1e400"),
    *(
        "[/]",
        "[bold]",
        "$\\frac{1$",
        "=cmd|' /C calc'!A0",
        "{0}",
        "%s",
        "%",
        "~",
        "a/b",
        "..",
        ".",
        "None",
        "nan",
        "-1",
    ),
    *("24:00", "00:00", "25:00", "6:00"),
    *("2024-03-01T06:30", "0001-01-01T00:00:00+14:00", "9999-12-31T23:59:59", "²", "१", "\u2028", "\ufeff", "'", '"'),
)
SHAPES: tuple[Any, ...] = (
    *(None, True, False, [], {}, [[]], {"": ""}, [1, 2, 3], ["x"], {"rule": "demand"}, {"x": 1}, [0] * 1000),
    *(Deep(f"{kind} {depth}") for kind in ("list", "table") for depth in DEPTHS),
    *(Literal("1979-05-27T07:32:00Z"), Literal("07:32:00")),
)
PATHS = ("", ".", "a" * 300, "a/b/c", "x\udcff", "\udcff/x", "/dev/null", "/dev/full", "/dev/null/x", "~", "-", "--")
"""Names of files and folders; all of them lie in the current folder, or cannot be."""


OPERATIONS = ("replace", "replace", "alike", "alike", "alike", "nudge", "delete", "copy", "swap", "wrap", "double")


def nasty(random: Random) -> Any:
    """Return a value that is likely to be wrong."""
    return random.choice(random.choice((NUMBERS, NUMBERS, TEXTS, SHAPES)))


def mutate_tree(tree: Tree, random: Random) -> Tree:
    """Return a tree with one thing in it changed."""
    tree = deepcopy(tree)
    parent, key = _somewhere(tree, random)
    if parent is None:
        return nasty(random)
    value = parent[key]
    match random.choice(OPERATIONS):
        case "nudge" if isinstance(value, int | float):
            parent[key] = nudged(value, random)
        case "alike":
            parent[key] = alike(value, random)
        case "delete":
            del parent[key]
        case "copy" | "swap" as how:
            other, place = _somewhere(tree, random)
            if other is not None:
                held = deepcopy(parent[key])
                parent[key] = deepcopy(other[place])
                if how == "swap" and place in (other if isinstance(other, dict) else range(len(other))):
                    other[place] = held
        case "wrap":
            parent[key] = random.choice(([value], {"x": value}, [value, value]))
        case "double" if isinstance(parent, list):
            parent.insert(random.randint(0, len(parent)), deepcopy(value))
        case "double":
            parent[random.choice(TEXTS)] = parent.pop(key)
        case _:
            parent[key] = nasty(random)
    return tree


def alike(value: Any, random: Random) -> Any:
    """Return a value of the same type that is likely to be out of range."""
    match value:
        case bool():
            return not value
        case int() | float():
            return random.choice([one for one in NUMBERS if isinstance(one, type(value))])
        case str():
            return random.choice(TEXTS)
        case list() if value:
            return random.choice((value[1:], value[:-1], value * 2, value[::-1], [*value, nasty(random)]))
        case dict() if value:
            keys = random.sample([*value], len(value))
            return {key: value[key] for key in keys[random.randint(0, 1) :]}
    return nasty(random)


def nudged(value: float, random: Random) -> Any:
    """Return a number near another, or of another type."""
    return random.choice((value + 1, value - 1, value * 3, -value, float(value), str(value), value + 0.5, value == 1))


def _somewhere(tree: Tree, random: Random) -> tuple[Any, Any]:
    """Return container and key of something in a tree, what is near the root as likely as what is far."""
    parent, key = None, None
    while isinstance(tree, dict | list) and tree and (parent is None or random.random() < 0.85):
        parent, key = tree, random.choice([*tree] if isinstance(tree, dict) else range(len(tree)))
        tree = tree[key]
    return parent, key


def as_json(tree: Tree) -> bytes:
    """Return a tree as JSON."""
    return _written(tree, "null", ": ", json.dumps).encode("utf-8")


def as_toml(tree: Tree) -> bytes:
    """Return a tree as TOML, a line for each key of the top and of the tables in it."""

    def number(value: object) -> str:
        return repr(value)

    if not isinstance(tree, dict):
        return _written(tree, '""', " = ", number).encode("utf-8")
    top = [
        f"{json.dumps(key)} = {_written(entry, '[]', ' = ', number)}" for key, entry in tree.items() if _is_value(entry)
    ]
    for key, table in tree.items():
        if not _is_value(table):
            top.append(f"[{json.dumps(key)}]")
            top += [f"{json.dumps(name)} = {_written(entry, '[]', ' = ', number)}" for name, entry in table.items()]
    return "\n".join([*top, ""]).encode("utf-8")


def _is_value(entry: Tree) -> bool:
    return not isinstance(entry, dict)


def _written(tree: Tree, nothing: str, between: str, number: Callable[[Any], str]) -> str:
    def inner(value: Tree) -> str:
        return _written(value, nothing, between, number)

    if isinstance(tree, Literal):
        text = str(tree)
    elif isinstance(tree, Deep):
        kind, depth = tree.split()
        opening, closing = ("[", "]") if kind == "list" else (f'{{"a"{between}', "}")
        text = f"{opening * int(depth)}0{closing * int(depth)}"
    elif isinstance(tree, str):
        text = json.dumps(tree, ensure_ascii=not tree.isprintable())
    elif isinstance(tree, dict):
        text = f"{{{', '.join(f'{json.dumps(key)}{between}{inner(value)}' for key, value in tree.items())}}}"
    elif isinstance(tree, list | tuple):
        text = f"[{', '.join(map(inner, tree))}]"
    else:
        text = nothing if tree is None else json.dumps(tree) if isinstance(tree, bool) else number(tree)
    return text


def plain_text(value: Any) -> str:
    """Return a value as somebody would type it."""
    return value if type(value) is str else _written(value, "None", " = ", repr)


def mutate_table(table: bytes, random: Random, separator: str = ",") -> bytes:
    """Return a CSV file with one thing in it changed."""
    rows = [line.split(separator) for line in table.decode("utf-8", "surrogateescape").splitlines()] or [[""]]
    at = 0 if random.random() < 0.15 else random.randrange(len(rows))
    cell = random.randrange(len(rows[at]) or 1)
    match random.choice(("cell", "cell", "cell", "cell", "delete", "double", "swap", "shorten", "lengthen", "column")):
        case "cell":
            rows[at][cell : cell + 1] = [plain_text(nasty(random))]
        case "delete":
            del rows[at]
        case "double":
            rows.insert(random.randint(0, len(rows)), [*rows[at]])
        case "swap":
            other = random.randrange(len(rows))
            rows[at], rows[other] = rows[other], rows[at]
        case "shorten":
            del rows[at][cell:]
        case "lengthen":
            rows[at].insert(cell, plain_text(nasty(random)))
        case _:
            for row in rows:
                del row[cell : cell + 1]
    return "\n".join([*(separator.join(row) for row in rows), ""]).encode("utf-8", "surrogatepass")


def mutate_text(text: bytes, random: Random) -> bytes:
    """Return a text with something in a line, or a line, changed."""
    lines = text.decode("utf-8", "surrogateescape").splitlines() or [""]
    at = random.randrange(len(lines))
    line = lines[at]
    place = random.randrange(len(line) or 1)
    match random.choice(("sign", "sign", "word", "word", "delete", "double", "swap", "shorten", "line")):
        case "sign":
            sign = random.choice(".@TGWSOICq#<>^v┐→↓⇒⇐⇑⇓╗ x\0é0[]=")
            lines[at] = f"{line[:place]}{sign}{line[place + 1 :]}"
        case "word":
            words = line.split(" ")
            words[random.randrange(len(words))] = plain_text(random.choice(NUMBERS))
            lines[at] = " ".join(words)
        case "delete":
            del lines[at]
        case "double":
            lines.insert(random.randint(0, len(lines)), line)
        case "swap":
            other = random.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        case "shorten":
            lines[at] = line[:place]
        case _:
            lines[at] = plain_text(nasty(random))
    return "\n".join([*lines, ""]).encode("utf-8", "surrogatepass")


def mutate_bytes(data: bytes, random: Random) -> bytes:
    """Return bytes that no format has, or fewer."""
    place = random.randrange(len(data) + 1)
    before, after = data[:place], data[place:]
    return random.choice(
        (
            b"\xef\xbb\xbf" + data,
            data.replace(b"\n", b"\r\n"),
            data.replace(b"\n", b"\r"),
            before + b"\0" + after,
            before + b"\xff" + after,
            before,
            before,
            b"",
            b"\n" * 3,
            data + data,
            before + bytes([random.randrange(256)]) + after[1:],
            before + bytes([random.randrange(256)]) + after[1:],
            data.decode("utf-8", "replace").encode("utf-16"),
        )
    )


def mutate_arguments(arguments: list[str], random: Random) -> list[str]:
    """Return arguments one of which is another, gone, twice, or new."""
    changed = [*arguments]
    at = random.randrange(len(changed) or 1)
    match random.choice(("replace", "replace", "replace", "path", "path", "delete", "double", "swap", "insert")):
        case "delete":
            del changed[at : at + 1]
        case "double":
            changed[at:at] = changed[at : at + 1]
        case "swap":
            other = random.randrange(len(changed) or 1)
            changed[at : at + 1], changed[other : other + 1] = changed[other : other + 1], changed[at : at + 1]
        case "path":
            changed[at : at + 1] = [random.choice(PATHS)]
        case "insert":
            changed.insert(at, random.choice(("--json", "--seed", "--help", "--x", "--set", "--out", "-q", "--limit")))
        case _:
            changed[at : at + 1] = [plain_text(nasty(random))]
    return [possible_argument(argument) for argument in changed]


def possible_argument(text: str) -> str:
    """Return a text without what no argument of a program can have: the sign of code 0, halves of surrogate pairs."""
    return (
        text.replace("\0", "")
        .encode("utf-8", "surrogateescape" if "\udcff" in text else "replace")
        .decode("utf-8", "surrogateescape")
    )


def times(random: Random, most: int = 3) -> Iterator[int]:
    """Yield once for each mutation of a case: one mostly."""
    yield from range(1 + sum(random.random() < 0.35 for _ in range(most - 1)))
