"""The small valid inputs that every case begins with, made by `rmfs` itself."""

from __future__ import annotations

import contextlib
import gzip
import io
import json
import os
import tempfile
from collections.abc import Mapping
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from attrs import frozen

from fuzzing.mutations import as_toml
from rmfs_core.cli import main

TINY: dict[str, Any] = {
    "seed": 1,
    "instance": {"orders": 4, "skus": 6, "pods": 4, "skus_per_pod": 3, "max_lines": 3},
    "layout": {"block_rows": 3, "block_columns": 2, "stations_east": 1},
    "robots": {"count": 2},
    "stations": {"queue_length": 4},
    "rules": {"poa": "pod-match", "pps": "demand", "pp": "free-flow"},
    "run": {"until_s": 900},
}
RICH: dict[str, Any] = {
    **TINY,
    "instance": {
        **TINY["instance"],
        "lines": [3, 2, 1],
        "items_per_sku": 50,
        "start": "2024-03-01T00:00",
        "demand": {"exponent": 1.0, "shift": 2.0, "groups": 2, "together": 0.5},
        "due": {"allowance_s": 600, "spread_s": 60, "priority_share": 0.2, "priority_allowance_s": 300},
        "arrivals": {"process": "poisson", "orders_per_hour": 360, "profile": [1] * 24},
        "pods_at_stations": {},
    },
    "stations": {
        "item_capacity": [5],
        "oversize": "alone",
        "queue_length": 4,
        "pick_s": 7,
        "handle_s": 13,
        "release": "handled",
    },
    "rules": {
        "poa": {"rule": "common-lines", "max_wait_s": 60},
        "pps": {"rule": "completes"},
        "pr": "nearest",
        "ta": {"rule": "balanced"},
        "pp": {"rule": "free-flow"},
        "filters": [{"rule": "most-covered", "n": 5}],
        "observers": [],
    },
    "run": {"until_s": 900, "warmup_s": 60, "standstill_s": 900},
}
FILES: dict[str, Any] = {
    **TINY,
    "instance": {
        "orders_file": "orders.csv",
        "pods_file": "pods.csv",
        "arrivals": {"process": "refill", "backlog": 2},
    },
    "robots": {"count": 2, "file": "places.csv"},
}
MAPPED = {**TINY, "layout": {"map_file": "hall.txt"}}
EXPERIMENT: dict[str, Any] = {
    "description": "Tiny",
    "base": "tiny.toml",
    "seeds": [1, 2],
    "baseline": "pod-match",
    "metrics": ["pile_on", "makespan_s"],
    "by": ["instance.orders"],
    "axes": {"instance.orders": [2, 4]},
    "rule_sets": [
        {"name": "pod-match", "rules": {"poa": "pod-match"}},
        {"name": "first-come", "rules": {"poa": {"rule": "first-come"}}},
    ],
}
COMPILED = (
    *(("pp=sipp",), ("pp=whca-n",), ("poa_pps=pod-index",), ("poa_pps=split-over-time",)),
    *(("poa_pps=split-among-stations",), ("poa_pps=integrated",)),
)
LINES = b"""nr;article;when;pieces;due;urgent
1;A;2024-03-01T06:30;2;2024-03-01T08:00;0
1;B;2024-03-01T06:30;1;2024-03-01T08:00;0
2;A;2024-03-01T07:10;1;;1
3;C;2024-03-01T07:20;4;2024-03-01T09:00;
"""
MOVINGAI = b"type octile\nheight 6\nwidth 8\nmap\n" + b"........\n" * 2 + b"...@@...\n" * 2 + b"........\n" * 2
SCEN = b"version 1\n" + b"".join(b"0\tm.map\t8\t6\t%d\t0\t%d\t5\t6.0\n" % (n, 7 - n) for n in range(4))


@frozen
class Bases:
    """What cases start from.

    Parameters
    ----------
    files
        Contents by name; ``run/...`` are those of a recorded run. What `rmfs` compresses is not compressed here.
    rules
        Every installed rule as ``rmfs rules --json`` has it.
    keys
        Keys of scenarios, dotted, and their values.
    """

    files: Mapping[str, bytes]
    rules: tuple[dict[str, Any], ...]
    keys: tuple[tuple[str, Any], ...]


def make_bases(*, compiled: bool = True) -> Bases:
    """Return the bases; in passing, what commands import is imported, and what rules compile is compiled if wanted."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            return _made(Path(folder), compiled)
        finally:
            os.chdir(before)


def _made(folder: Path, compiled: bool) -> Bases:
    texts = {"tiny.toml": TINY, "rich.toml": RICH, "files.toml": FILES, "mapped.toml": MAPPED, "trial.toml": EXPERIMENT}
    for name, tree in texts.items():
        (folder / name).write_bytes(as_toml(tree))
    (folder / "lines.csv").write_bytes(LINES)
    (folder / "m.map").write_bytes(MOVINGAI)
    (folder / "m.scen").write_bytes(SCEN)
    _call("generate", "rich.toml", "--out", "made")
    for name in ("orders.csv", "pods.csv"):
        (folder / name).write_bytes((folder / "made" / name).read_bytes())
    hall = _call("scenario", "map", "tiny.toml")
    (folder / "hall.txt").write_text(hall, encoding="utf-8")
    _place(folder, hall.splitlines())
    _call("run", "tiny.toml", "--out", "run", "--quiet", "--trace", "--record-decisions")
    for number in range(1, 6):  # one state of each kind
        told = json.loads(_call("explain", "run", "--decision", str(number), "--state", "state.json", "--json"))
        (folder / "state.json").rename(folder / f"{told['decides'].lower()}.json")
    _call("validate", "run")
    _call("decide", "poa.json", "--rule", "pod-match")
    _call("plan", "m.map", "--agents", "2", "--pp", "free-flow")
    _call(
        "convert", "orders", "lines.csv", "--separator", ";", "--order", "nr", "--sku", "article", "--out", "converted"
    )
    _call("scenario", "check", "files.toml")
    for rules in COMPILED if compiled else ():  # once, here: it takes long
        choices = [word for rule in rules for word in ("--set", f"rules.{rule}")]
        compiling = get_context("fork").Process(target=_call, args=("run", "tiny.toml", "--quiet", *choices))
        compiling.start()  # apart: threads that solvers leave do not survive a copy of the process
        compiling.join()
    kept = [*folder.glob("*.*"), *(folder / "run").iterdir()]
    files = {file.relative_to(folder).as_posix(): file.read_bytes() for file in sorted(kept)}
    unpacked = {name: gzip.decompress(data) if name.endswith(".gz") else data for name, data in files.items()}
    return Bases(unpacked, tuple(json.loads(_call("rules", "--json"))), tuple(_keys(RICH)))


def _place(folder: Path, rows: list[str]) -> None:
    """Say in the files of pods and of robots where they stand: in the first storage locations, in their order."""
    cells = [f"{i},{j}" for i, row in enumerate(rows, 1) for j, sign in enumerate(row, 1) if sign == "#"]
    header, *pods = (folder / "pods.csv").read_text(encoding="utf-8").splitlines()
    names = list(dict.fromkeys(row.partition(",")[0] for row in pods))
    placed = [f"{row},{cells[names.index(row.partition(',')[0])]}" for row in pods]
    (folder / "pods.csv").write_text("\n".join([f"{header},row,column", *placed, ""]), encoding="utf-8")
    (folder / "places.csv").write_text(f"robot,row,column\n1,{cells[0]}\n2,{cells[1]}\n", encoding="utf-8")


def _keys(tree: Mapping[str, Any], above: str = "") -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = []
    for key, value in tree.items():
        found.append((above + key, value))
        if isinstance(value, dict):
            found += _keys(value, f"{above}{key}.")
    return found


def _call(*arguments: str) -> str:
    with contextlib.redirect_stdout(io.StringIO()) as output:
        try:
            main([*arguments])
        except SystemExit as end:
            raise RuntimeError(f"rmfs {' '.join(arguments)} ended with {end.code}") from end
    return output.getvalue()
