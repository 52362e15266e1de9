"""Surfaces of cases: for each surface, arguments and files that begin valid and are made wrong."""

from __future__ import annotations

import gzip
import json
import re
import sys
import tomllib
from collections.abc import Callable, Mapping
from functools import partial
from random import Random
from typing import Any
from xml.sax.saxutils import escape

from attrs import define, frozen

from fuzzing.bases import Bases
from fuzzing.mutations import (
    PATHS,
    as_json,
    as_toml,
    mutate_arguments,
    mutate_bytes,
    mutate_table,
    mutate_text,
    mutate_tree,
    nasty,
    plain_text,
    possible_argument,
    times,
)

Mutation = Callable[[bytes, Random], bytes]
FOLDER, LOOP = b"\0a folder", b"\0a link to itself"
"""Instead of contents: what a file's name is given to instead."""
SCENARIOS = (
    "tiny.toml",
    "tiny.toml",
    "rich.toml",
    "day.toml",
    "day.toml",
    "packed.toml",
    "files.toml",
    "supplied.toml",
    "mapped.toml",
)
TABLES = ("orders.csv", "pods.csv", "places.csv")
SUPPLIES = ("skus.csv", "bundles.csv")
RUN = ("run", "{}", "--quiet", "--out", "out")
WITH_SCENARIO = (
    *(RUN, RUN, RUN),
    *(("scenario", "check", "{}"), ("scenario", "check", "{}"), ("scenario", "check", "{}", "--json")),
    *(("scenario", "show", "{}"), ("scenario", "map", "{}"), ("generate", "{}", "--out", "out")),
)
WITHOUT_ORDERS = {"activation": "activate", "idle": "idle", "repositioning": "move"}
"""Keys of the rules that decide neither what is picked nor what is stored."""
AT_PACKING = {"packing": "packing", "packing-task": "packing_task"}
"""Keys of the rules of packing stations."""
RUN_FILES = ("trace.jsonl.gz", "result.json", "orders.csv", "hours.csv", "stations.csv", "robots.csv")


@frozen
class Case:
    """Arguments of a call of `rmfs`.

    Parameters
    ----------
    surface
        Which surface it is of.
    arguments
        Of `rmfs`.
    files
        Contents by name, in the folder in which it is called.
    """

    surface: str
    arguments: tuple[str, ...]
    files: Mapping[str, bytes]


@define
class Draft:
    """A case in the making."""

    bases: Bases
    random: Random
    arguments: list[str]
    files: dict[str, bytes]

    def need(self, *names: str) -> None:
        """Add files, as they are valid."""
        self.files |= {name: self.bases.files[name] for name in names}

    def scenario(self) -> str:
        """Add a scenario with the files it names; return its name."""
        name = self.random.choice(SCENARIOS)
        self.need(name)
        if name in ("files.toml", "supplied.toml"):
            self.need(*TABLES, *SUPPLIES)
        if name == "mapped.toml":
            self.need("hall.txt")
        return name

    def with_scenario(self, name: str) -> None:
        """Choose a command that reads a scenario."""
        self.arguments = [word.format(name) for word in self.random.choice(WITH_SCENARIO)]

    def change(self, name: str, mutate: Mutation) -> None:
        """Change a file: mostly as its format has it, now and then its bytes, or what it is."""
        for _ in times(self.random):
            chance = self.random.random()
            if self.files.get(name) in (FOLDER, LOOP) or name not in self.files:
                return
            if chance < 0.01:
                self.files[name] = self.random.choice((FOLDER, LOOP))
            elif chance < 0.02:
                del self.files[name]
            else:
                self.files[name] = (mutate_bytes if chance < 0.15 else mutate)(self.files[name], self.random)

    def rule(self, *decides: str) -> dict[str, Any]:
        """Return a rule, as a table of scenario files, with one or two parameters made wrong."""
        fitting = [one for one in self.bases.rules if not decides or {*decides} & {*one["decides"]}]
        chosen = self.random.choice(fitting)
        table: dict[str, Any] = {"rule": chosen["name"]}
        for parameter in self.random.sample(chosen["parameters"], min(len(chosen["parameters"]), 2)):
            if parameter["required"] or self.random.random() < 0.7:
                near = parameter["default"] is not None and self.random.random() < 0.4
                wrong = mutate_tree([parameter["default"]], self.random) if near else [nasty(self.random)]
                table[parameter["name"]] = wrong[0] if isinstance(wrong, list) and wrong else wrong
        return table


def toml_file(data: bytes, random: Random) -> bytes:
    """Change a TOML file: a value of it, or its text."""
    try:
        tree = tomllib.loads(data.decode("utf-8"))
    except (ValueError, RecursionError):
        return mutate_text(data, random)
    return mutate_text(data, random) if random.random() < 0.2 else as_toml(mutate_tree(tree, random))


def json_file(data: bytes, random: Random) -> bytes:
    """Change a JSON file: a value of it, or its text."""
    try:
        tree = json.loads(data)
    except (ValueError, RecursionError):
        return mutate_text(data, random)
    return mutate_text(data, random) if random.random() < 0.05 else as_json(mutate_tree(tree, random))


def json_lines(data: bytes, random: Random) -> bytes:
    """Change a line of a file of JSON objects, or which lines there are."""
    lines = data.splitlines() or [b"{}"]
    at = 0 if random.random() < 0.3 else random.randrange(len(lines))
    match random.choice(("change", "change", "change", "change", "delete", "double", "swap", "cut")):
        case "change":
            lines[at] = json_file(lines[at], random).replace(b"\n", b" ")
        case "delete":
            del lines[at]
        case "double":
            lines.insert(random.randint(0, len(lines)), lines[at])
        case "swap":
            other = random.randrange(len(lines))
            lines[at], lines[other] = lines[other], lines[at]
        case _:
            del lines[at:]
    return b"\n".join([*lines, b""])


def of_scenario(draft: Draft) -> None:
    """A scenario file; now and then another rule with wrong parameters in it."""
    name = draft.scenario()
    if draft.random.random() < 0.4:
        tree = tomllib.loads(draft.files[name].decode("utf-8"))
        roles = "POA", "PPS", "POA+PPS", "PR", "TA", "PP", "filter", "ROA", "RPS", "ROA+RPS", *WITHOUT_ORDERS
        role = draft.random.choice((*roles, *AT_PACKING) if name == "packed.toml" else roles)
        key = {"filter": "filters", **WITHOUT_ORDERS, **AT_PACKING}.get(role, role.lower().replace("+", "_"))
        if key == "poa_pps":
            tree["rules"] = {role: rule for role, rule in tree["rules"].items() if role not in ("poa", "pps")}
        if key == "roa_rps":
            tree["rules"] = {role: rule for role, rule in tree["rules"].items() if role not in ("roa", "rps")}
        tree["rules"][key] = [draft.rule(role)] if role == "filter" else draft.rule(role)
        draft.files[name] = as_toml(tree)
    else:
        draft.change(name, toml_file)
    draft.with_scenario(name)


def of_set(draft: Draft) -> None:
    """Values after ``--set``."""
    name = draft.scenario()
    draft.with_scenario(name)
    for _ in times(draft.random):
        key, value = draft.random.choice(draft.bases.keys)
        near = draft.random.random() < 0.3
        wrong = mutate_tree([value], draft.random) if near else [nasty(draft.random)]
        shown = plain_text(wrong[0] if isinstance(wrong, list) and wrong else wrong)
        draft.arguments += ["--set", possible_argument(f"{key}={shown}")]


def of_orders(draft: Draft) -> None:
    """orders.csv, pods.csv and places.csv of a scenario; skus.csv and bundles.csv of one that is supplied."""
    name = draft.random.choice(("files.toml", "supplied.toml"))
    draft.need(name, *TABLES, *SUPPLIES)
    changed = ("orders.csv", *TABLES) if name == "files.toml" else (*SUPPLIES, *SUPPLIES, "pods.csv", "orders.csv")
    draft.change(draft.random.choice(changed), mutate_table)
    draft.with_scenario(name)


def of_map(draft: Draft) -> None:
    """Text maps."""
    draft.need("mapped.toml", "hall.txt", "yard.txt")
    if draft.random.random() < 0.5:  # the one with a charger and a replenishment station
        draft.files["hall.txt"] = draft.files.pop("yard.txt")
    if draft.random.random() < 0.3:
        draft.files["hall.txt"] = draft.files["hall.txt"].replace(b" ", b"P", 1)
    draft.change("hall.txt", mutate_text)
    if draft.random.random() < 0.3:
        draft.arguments = ["plan", "hall.txt", "--agents", "2", "--pp", "free-flow", "--out", "out"]
        if draft.random.random() < 0.3:
            draft.arguments += ["--effort", "2"]
    else:
        draft.with_scenario("mapped.toml")
        if "--quiet" in draft.arguments and draft.random.random() < 0.5:
            draft.arguments += ["--set", "packing.conveyor_speed_m_per_s=0.5"]


def of_movingai(draft: Draft) -> None:
    """Maps and scenarios in MovingAI's formats."""
    draft.need("m.map", "m.scen")
    pp = draft.random.choice(("free-flow", "free-flow", "sipp"))
    draft.arguments = ["plan", "m.map", "--agents", "2", "--pp", pp, "--out", "out"]
    if draft.random.random() < 0.5:
        draft.arguments += ["--scen", "m.scen"]
        draft.change("m.scen", partial(mutate_table, separator="\t"))
    else:
        draft.change("m.map", mutate_text)


def of_state(draft: Draft) -> None:
    """States that rules are asked in."""
    asked = draft.random.choice(("poa", "pps", "pr", "ta", "roa", "rps", *WITHOUT_ORDERS, *AT_PACKING))
    draft.need(f"{asked}.json")
    draft.change(f"{asked}.json", json_file)
    decides = asked if asked in WITHOUT_ORDERS | AT_PACKING else asked.upper()
    rule = draft.rule(*{"POA": ("POA", "POA+PPS"), "ROA": ("ROA", "ROA+RPS")}.get(decides, (decides,)))
    draft.arguments = ["decide", f"{asked}.json", "--rule", rule.pop("rule")]
    if draft.random.random() < 0.1:
        roles = "POA", "PPS", "POA+PPS", "PR", "TA", "ROA", "RPS", "ROA+RPS", *WITHOUT_ORDERS, *AT_PACKING
        draft.arguments += ["--decides", draft.random.choice(roles)]
    if draft.random.random() < 0.3:
        for key, value in rule.items():
            draft.arguments += ["--set", possible_argument(f"{key}={plain_text(value)}")]
    if draft.random.random() < 0.1:
        draft.arguments += ["--seed", plain_text(nasty(draft.random)).replace("\0", "")]
    draft.arguments = [possible_argument(word) for word in draft.arguments]


def of_begun(draft: Draft) -> None:
    """States that runs begin in."""
    name = draft.random.choice(("day", "packed"))
    draft.need(f"{name}.toml")
    draft.need(f"{name}-at-60.json")
    draft.change(f"{name}-at-60.json", json_file)
    draft.arguments = ["run", f"{name}.toml", "--from", f"{name}-at-60.json", "--quiet", "--trace"]


def _run_folder(draft: Draft, names: tuple[str, ...]) -> None:
    """Add a recorded run as folder `run`, and change a file of it."""
    run = draft.random.choice(("run", "day", "packed", "begun"))
    if names == RUN_FILES:
        names += {"run": (), "day": ("bundles.csv", "stock.csv")}.get(run, ("packing.csv",))
    draft.files |= {f"run/{name}": draft.bases.files[f"{run}/{name}"] for name in names}
    chosen = names[0] if draft.random.random() < 0.7 else draft.random.choice(names)
    mutations: dict[str, Mutation] = {"csv": mutate_table, "json": json_file, "gz": json_lines}
    draft.change(f"run/{chosen}", mutations[chosen.rpartition(".")[2]])
    for name in [name for name in draft.files if name.endswith(".gz")]:
        if draft.files[name] not in (FOLDER, LOOP):
            packed = gzip.compress(draft.files[name], 1, mtime=0)
            torn = draft.random.random() < 0.05
            draft.files[name] = mutate_bytes(packed, draft.random) if torn else packed


def of_recording(draft: Draft) -> None:
    """Decision records that are explained."""
    _run_folder(draft, ("decisions.jsonl.gz", "result.json", "orders.csv"))
    draft.arguments = ["explain", "run"]
    options = (("--period", "1"), ("--decision", "2"), ("--order", "1"), ("--pod", "1"), ("--json",))
    draft.arguments += draft.random.choice(options)
    if draft.random.random() < 0.3:
        draft.arguments += ["--state", "out.json"]
    if draft.random.random() < 0.3:
        rule = draft.random.choice((draft.rule("POA", "PPS", "POA+PPS", "ROA", "RPS"), {"rule": "first-come"}))
        draft.arguments += ["--against", possible_argument(plain_text(rule))]


def of_trace(draft: Draft) -> None:
    """Traces that are validated or shown, with the results beside them."""
    _run_folder(draft, RUN_FILES)
    draft.arguments = ["validate", "run", *draft.random.choice(((), (), ("--json",), ("--collisions",)))]
    if draft.random.random() < 0.3:
        draft.arguments = [
            "replay",
            "run",
            *draft.random.choice(((), ("--frames", "2"), ("--video", "x.gif", "--speed", "900"))),
        ]


def of_experiment(draft: Draft) -> None:
    """Experiment files."""
    draft.need("tiny.toml", "trial.toml")
    draft.change("trial.toml", toml_file)
    draft.arguments = ["compare", "trial.toml", "--out", "out", "--quiet", "--jobs", "1"]


def of_bench(draft: Draft) -> None:
    """Rules that are measured."""
    rule = plain_text(draft.rule()) if draft.random.random() < 0.7 else plain_text(nasty(draft.random))
    draft.arguments = ["bench", possible_argument(rule), "--world", "small", "--seed", "1"]
    draft.arguments += ["--set", "instance.orders=4", "--set", "instance.pods=20"]
    if draft.random.random() < 0.5:
        key, _ = draft.random.choice(draft.bases.keys)
        draft.arguments += ["--set", possible_argument(f"{key}={plain_text(nasty(draft.random))}")]


CELLS = (
    *("1.000", "1.234,00", "1 000", "1'000", "2,5", "-3", "(2)", "1e9", "999999999999", "0", "\u0663", "1000001"),
    *("20240229", "240229", "45351,25", "1709251200", "1709251200000", "9999-12-31", "1900-01-01", "2034-12-01T06:00"),
    *("2024-03-31T02:30", "2024-10-27T02:30", "2024-03-01T06:30+02:00", "2024-03-01T06:30Z", "01.03.2024 06:30"),
    *("06:30", '"', '"a', 'a"b', "\r", "caf\u00e9", "cafe\u0301", "\0", "\t", ",", "nr", "A", "", " "),
    *("\u2028", "x" * 140_000),
)  # fmt: skip
"""Cells as exports of other programs have them."""

OF_CONVERT = (
    ("--pods", "3", "--history", "lines.csv"),
    ("--time", "when", "--pods", "3", "--history-until", "2024-03-01T07:00"),
    ("--orders", "lines.csv", "--order-key", "nr"),
    *(("--time", "when"), ("--time", "when", "--due", "due"), ("--quantity", "pieces"), ("--priority", "urgent")),
    *(("--pods", "3"), ("--pods", "3", "--skus-per-pod", "2", "--placement", "co-purchase"), ("--items", "5")),
    *(("--start", "2024-03-01T00:00"), ("--from", "2024-03-01T07:00"), ("--until", "2024-03-01T07:30Z")),
    *(("--time-format", "%Y-%m-%dT%H:%M"), ("--time-format", "unix"), ("--time-format", "%d %d"), ("--start", "0")),
    *(("--zone", "Europe/Berlin"), ("--decimal", ","), ("--thousands", "."), ("--decimal", ".", "--thousands", ",")),
    *(("--encoding", "utf-16"), ("--encoding", "cp1252"), ("--encoding", "shift_jis"), ("--separator", "tab")),
    *(("--leave-out-sku", "A"), ("--most-quantity", "2"), ("--whole-orders",), ("--force",)),
    ("--time-of-day", "due"),
)


def export_cell(data: bytes, random: Random) -> bytes:
    """Put one of `CELLS` into a table, in a row or in all of a column; now and then encoded otherwise."""
    rows = [line.split(";") for line in data.decode("utf-8", "surrogateescape").splitlines()] or [[""]]
    cell, text = random.randrange(len(rows[0]) or 1), random.choice(CELLS)
    for row in rows[1:] if random.random() < 0.3 else [random.choice(rows)]:
        row[cell : cell + 1] = [text]
    encoding = random.choice(("utf-8", "utf-8", "utf-8", "utf-8", "utf-16", "cp1252", "utf-8-sig"))
    return "\n".join([*(";".join(row) for row in rows), ""]).encode(encoding, "ignore")


def of_convert(draft: Draft) -> None:
    """Tables of order lines, and how they are converted."""
    draft.need("lines.csv")
    draft.arguments = ["convert", "orders", "lines.csv", "--out", "out", "--order", "nr", "--sku", "article"]
    if draft.random.random() < 0.2:
        draft.arguments = ["convert", "pods", "lines.csv", "--out", "out", "--pod", "nr", "--sku", "article"]
        draft.arguments += draft.random.choice((["--quantity", "pieces"], [], ["--row", "pieces", "--column", "nr"]))
    draft.arguments += ["--separator", ";"]
    of_pods = draft.arguments[1] == "pods"
    for chosen in () if of_pods else draft.random.sample(OF_CONVERT, draft.random.randint(0, 5)):
        draft.arguments += chosen
    chance = draft.random.random()
    if chance < 0.4:
        draft.change("lines.csv", export_cell)
    elif chance < 0.7:
        draft.change("lines.csv", partial(mutate_table, separator=";"))
    else:
        draft.arguments = mutate_arguments(draft.arguments, draft.random)


def xml_file(data: bytes, random: Random) -> bytes:
    """Change an XML file: a value of it, or its text."""
    text = data.decode("utf-8", "surrogateescape")
    values = [match.span(0) for match in re.finditer(r'(?<==")[^"<>]*(?=")|(?<=>)[^<>\s]+(?=<)', text)]
    if not values or random.random() < 0.2:
        return mutate_text(data, random)
    begin, end = random.choice(values)
    wrong = escape(plain_text(nasty(random)), {'"': ""})
    other = text[slice(*random.choice(values))] if random.random() < 0.4 else wrong
    return (text[:begin] + other + text[end:]).encode("utf-8", "surrogatepass")


def of_import(draft: Draft) -> None:
    """Files of other programs."""
    together = draft.random.choice(
        (
            *(("hall.xinst", "list.xitem"), ("hall.xinst", "fill.xsett", "few.xgenc"), ("block.xlayo", "list.xitem")),
            *(("hall.xinst",), ("kiva.map",), ("sort.grid",), ("m.map", "m.scen"), ("m.map",)),
            *(("league.json", "m.map", "a.agents", "a.tasks"), ("block.xlayo", "fill.xsett", "few.xgenc")),
            ("block.xlayo", "rate.xsett", "few.xgenc"),
        )
    )
    draft.need(*together)
    changed = draft.random.choice(together)
    as_xml = xml_file if changed.rpartition(".")[2].startswith("x") else mutate_text
    draft.change(changed, json_file if changed == "league.json" else as_xml)
    named = together[:1] if together[0] == "league.json" else together
    options = draft.random.choice(((), (), ("--json",), ("--seed", "3"), ("--format", "lorr"), ("--force",)))
    draft.arguments = ["import", *named, "--out", "out", *options]


def of_arguments(draft: Draft) -> None:
    """Arguments of every command, on files that are right."""
    draft.need("tiny.toml", "day.toml", "poa.json", "m.map", "m.scen", "run/trace.jsonl.gz", "run/decisions.jsonl.gz")
    for name in ("run/trace.jsonl.gz", "run/decisions.jsonl.gz"):
        draft.files[name] = gzip.compress(draft.files[name], 1, mtime=0)
    calls: tuple[tuple[str, ...], ...] = (
        ("run", "tiny.toml", "--seed", "1", "--out", "out"),
        ("run", "tiny.toml", "--out", "out", "--record", "trace", "--json"),
        ("scenario", "check", "tiny.toml", "--seed", "1"),
        ("scenario", "show", "tiny.toml"),
        ("scenario", "map", "tiny.toml"),
        ("scenario", "list", "--json"),
        ("bound", "day.toml", "--json"),
        ("scenario", "schema"),
        ("generate", "tiny.toml", "--out", "out", "--seed", "3"),
        ("validate", "run", "--limit", "3"),
        ("replay", "run", "--out", "x.html"),
        ("replay", "run", "--frames", "2", "--from", "3", "--to", "9", "--out", "out"),
        ("explain", "run", "--period", "1", "--against", "first-come", "--limit", "3", "--state", "out.json"),
        ("explain", "run", "--pod", "1"),
        ("explain", "run", "--order", "1"),
        ("decide", "poa.json", "--rule", "pod-match", "--seed", "1", "--decides", "POA"),
        ("plan", "m.map", "--agents", "2", "--seed", "1", "--pp", "free-flow", "--scen", "m.scen", "--out", "out"),
        ("rules", "demand", "--json"),
        ("new-rule", "my-rule", "--decides", "POA", "--into", "."),
    )
    draft.arguments = [*draft.random.choice(calls)]
    for _ in times(draft.random):
        draft.arguments = mutate_arguments(draft.arguments, draft.random)


def of_new_rule(draft: Draft) -> None:
    """Names of new rules."""
    names = ("my-rule", plain_text(nasty(draft.random)), draft.random.choice(PATHS))
    decided = "POA", "PPS", "POA+PPS", "PR", "TA", "PP", "ROA", "RPS", "ROA+RPS", *WITHOUT_ORDERS, *AT_PACKING
    decides = draft.random.choice((*decided, "filter", "observer", "command", "x", ""))
    draft.arguments = ["new-rule", possible_argument(draft.random.choice(names)), "--decides", decides]
    if draft.random.random() < 0.5:
        draft.arguments += ["--into", draft.random.choice(PATHS)]


def of_reproduction(draft: Draft) -> None:
    """Arguments of what would take hours: always with a mistake."""
    wrong = possible_argument(plain_text(nasty(draft.random)))
    draft.arguments = [
        "reproduce",
        "--only",
        f"x{wrong}",
        "--out",
        draft.random.choice(("out", *PATHS)),
        "--jobs",
        wrong,
    ]


SURFACES: tuple[tuple[int, Callable[[Draft], None]], ...] = (
    (22, of_scenario),
    (14, of_set),
    (8, of_orders),
    (6, of_map),
    (6, of_movingai),
    (12, of_state),
    (6, of_begun),
    (8, of_recording),
    (8, of_trace),
    (3, of_experiment),
    (3, of_bench),
    (6, of_convert),
    (6, of_import),
    (8, of_arguments),
    (2, of_new_rule),
    (1, of_reproduction),
)
"""Every surface, and how often it is taken."""


def make_case(bases: Bases, seed: int, number: int) -> Case:
    """Return a case: the same for the same seed and number."""
    random = Random(f"{seed}:{number}")
    draft = Draft(bases, random, [], {})
    (make,) = random.choices([make for _, make in SURFACES], [weight for weight, _ in SURFACES])
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(50_000)  # a mutation may follow one that puts a thousand lists into one another
    try:
        make(draft)
    finally:
        sys.setrecursionlimit(limit)
    return Case(make.__name__.removeprefix("of_"), tuple(draft.arguments), draft.files)
