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
from rmfs_commands.cli.main import main

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
DAY: dict[str, Any] = {
    **TINY,
    "instance": {
        **TINY["instance"],
        "items_per_sku": 1,
        "pod_capacity": 30,
        "replenishment": {
            "process": "reorder-point",
            "reorder_point": 2,
            "order_up_to": 9,
            "unit": "items",
            "lead_s": 60,
            "bundle_items": 3,
        },
    },
    "layout": {**TINY["layout"], "replenishment_east": 0, "replenishment_west": 1, "chargers": 1},
    "robots": {
        "count": 3,
        "available": [["00:00", "06:00"], ["22:00", "02:00", 2]],
        "battery": {
            "capacity_wh": 40,
            "empty_w": 100,
            "loaded_w": 300,
            "lifting_w": 500,
            "idle_w": 20,
            "charging_w": 20000,
            "detour": 2,
        },
    },
    "stations": {
        "queue_length": 4,
        "open": {"1": [["22:00", "00:10"], ["00:12", "14:00"]]},
        "also_replenish": False,
        "bundle_capacity": 3,
        "store_s": 5,
    },
    "rules": {
        **TINY["rules"],
        "roa": "same-pod",
        "rps": {"rule": "spread-sku"},
        "activate": {"rule": "backlog-threshold", "open_above": 1},
        "idle": {"rule": "charge-when-low", "low": 0.5, "full": 0.8},
        "move": {"rule": "cache"},
        "filters": [{"rule": "waves", "every_s": 60, "orders": 2}],
    },
}
"""Scenarios with arrivals and departures: bundles, shifts, robots that charge, rest and move pods, waves."""
PACKED: dict[str, Any] = {
    **TINY,
    "packing": {
        "stations": 1,
        "boxes": 2,
        "packers": 1,
        "sorters": 0,
        "conveyor_s": 20,
        "tote": "visit",
        "tote_s": 3,
        "put_s": 4,
        "pack_s": 200,
        "pack_item_s": 5,
        "packing_from": "packed",
        "open": {"1": [["00:00", "12:00"], ["13:00", "24:00"]]},
    },
    "rules": {"poa_pps": "pod-index", "pp": "free-flow", "packing": "nearest", "packing_task": {"rule": "pack-first"}},
}
SUPPLIED: dict[str, Any] = {
    **FILES,
    "instance": {
        **FILES["instance"],
        "skus_file": "skus.csv",
        "pod_capacity": 300,
        "replenishment": {"process": "file", "file": "bundles.csv"},
    },
    "stations": {"queue_length": 4, "also_replenish": True},
    "rules": {**TINY["rules"], "roa_rps": {"rule": "pod-first", "pod": "same-sku"}},
}
SKUS = b"sku,size,reorder_point,order_up_to\n1,2,1,4\n2,,,\n3,1,0,2\n"
BUNDLES = b"bundle,arrival_s,sku,items\nB-1,0,1,3\nB-2,60.5,2,4\nB-3,60.5,9,1\n"
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

_WAYS = {0: (1, 4), 1: (0, 5), 2: (3,), 3: (7,), 4: (0, 5), 5: (1, 4, 6), 6: (2, 5, 7), 7: (6,)}
_WAYPOINTS = "".join(
    f'<Waypoint ID="{i}" X="{i % 4}.5" Y="{i // 4}.5" OutputStation="{0 if i == 3 else -1}" InputStation="-1" '
    f'PodStorageLocation="{str(i < 2).lower()}"><Paths>{"".join(f"<Waypoint>{to}</Waypoint>" for to in ways)}</Paths>'
    "</Waypoint>\n"
    for i, ways in _WAYS.items()
)
FOREIGN = {
    "hall.xinst": f"""<?xml version="1.0"?>
<Instance Name="hall">
<Bots><Bot ID="0" MaxAcceleration="1" MaxVelocity="1.5" TurnSpeed="2.5" X="0.5" Y="1.5" Tier="0" /></Bots>
<Pods><Pod ID="0" X="1.5" Y="0.5" Tier="0" Capacity="100" /></Pods>
<OutputStations><OutputStation ID="0" X="3.5" Y="0.5" Capacity="6" ItemTransferTime="13" ItemPickTime="7">
<Queues><Queues>3/3</Queues><Queues>3/2</Queues></Queues></OutputStation></OutputStations>
<Tiers><Tier ID="0" Length="4" Width="2" /></Tiers>
<Waypoints>{_WAYPOINTS}</Waypoints>
</Instance>
""",
    "block.xlayo": """<LayoutConfiguration><TierCount>1</TierCount><BotCount>2</BotCount><PodAmount>0.5</PodAmount>
<PodCapacity>500</PodCapacity><NrHorizontalAisles>4</NrHorizontalAisles><NrVerticalAisles>2</NrVerticalAisles>
<WidthBuffer>2</WidthBuffer><NPickStationEast>1</NPickStationEast>
<NReplenishmentStationWest>1</NReplenishmentStationWest></LayoutConfiguration>
""",
    "fill.xsett": """<SettingConfiguration><SimulationDuration>600</SimulationDuration><Seed>0</Seed>
<InventoryConfiguration><ItemType>SimpleItem</ItemType><OrderMode>Fill</OrderMode><InitialInventory>0.5</InitialInventory>
<PositionCountMean>1</PositionCountMean><PositionCountMax>3</PositionCountMax><DemandInventoryConfiguration>
<OrderCount>3</OrderCount></DemandInventoryConfiguration></InventoryConfiguration></SettingConfiguration>
""",
    "rate.xsett": """<SettingConfiguration><SimulationDuration>900</SimulationDuration><Seed>1</Seed>
<InventoryConfiguration><OrderMode>Poisson</OrderMode><InitialInventory>0.1</InitialInventory>
<BufferBundlesUntilInventoryLoad>0.9</BufferBundlesUntilInventoryLoad><PoissonInventoryConfiguration>
<PoissonMode>Simple</PoissonMode><InitialOrderCount>2</InitialOrderCount><InitialBundleCount>3</InitialBundleCount>
<AverageOrdersPerHourAndStation>40</AverageOrdersPerHourAndStation>
<AverageBundlesPerHourAndStation>20</AverageBundlesPerHourAndStation></PoissonInventoryConfiguration>
</InventoryConfiguration></SettingConfiguration>
""",
    "few.xgenc": """<SimpleItemGeneratorConfiguration><DefaultWeight>1</DefaultWeight><ItemDescriptions>
<E><Key>0</Key><Value>10.5</Value></E><E><Key>1</Key><Value>2</Value></E></ItemDescriptions><ItemWeights>
<E><Key>0</Key><Value>3.5</Value></E></ItemWeights></SimpleItemGeneratorConfiguration>
""",
    "list.xitem": """<OrderList><ItemDescriptions><ItemDescription ID="0" Weight="5" /></ItemDescriptions>
<ItemBundles><ItemBundle TimeStamp="12.5" ItemDescription="0" Size="8" /></ItemBundles><Orders>
<Order TimeStamp="3.25"><Positions><Position ItemDescriptionID="0" Count="2" /></Positions></Order>
<Order TimeStamp="9"><Positions><Position ItemDescriptionID="1" Count="1" /></Positions></Order></Orders></OrderList>
""",
    "kiva.map": "3,8\n4\n2\n5000\n........\nr.eeee.r\n..@@@@..\n",
    "sort.grid": "Grid size (x, y)\n2,1\nid,type,station,x,y,weight_to_NORTH,weight_to_WEST,weight_to_SOUTH,"
    "weight_to_EAST,weight_for_WAIT\n0,Induct,i,0,0,inf,inf,inf,1,1\n1,Eject,e,1,0,inf,1,inf,inf,1\n",
    "league.json": '{"mapFile": "m.map", "agentFile": "a.agents", "taskFile": "a.tasks", "teamSize": 2}',
    "a.agents": "2\n0\n12\n",
    "a.tasks": "3\n40,1\n41\n2,40\n",
}
"""Files that `rmfs import` reads."""


@frozen
class Bases:
    """Bases that cases start from.

    Parameters
    ----------
    files
        Contents by name; ``run/...``, ``day/...`` and ``packed/...`` are those of recorded runs. What `rmfs` compresses
        is not compressed here.
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
    texts |= {"day.toml": DAY, "packed.toml": PACKED, "supplied.toml": SUPPLIED}
    for name, tree in texts.items():
        (folder / name).write_bytes(as_toml(tree))
    (folder / "lines.csv").write_bytes(LINES)
    (folder / "skus.csv").write_bytes(SKUS)
    (folder / "bundles.csv").write_bytes(BUNDLES)
    (folder / "m.map").write_bytes(MOVINGAI)
    (folder / "m.scen").write_bytes(SCEN)
    for name, text in FOREIGN.items():
        (folder / name).write_text(text, encoding="utf-8")
    _call("import", "hall.xinst", "list.xitem", "--out", "hall")
    _call("import", "league.json", "--out", "league")
    _call("generate", "rich.toml", "--out", "made")
    for name in ("orders.csv", "pods.csv"):
        (folder / name).write_bytes((folder / "made" / name).read_bytes())
    hall = _call("scenario", "map", "tiny.toml")
    (folder / "hall.txt").write_text(hall, encoding="utf-8")
    _place(folder, hall.splitlines())
    (folder / "yard.txt").write_text(_call("scenario", "map", "day.toml"), encoding="utf-8")
    _call("run", "tiny.toml", "--out", "run", "--quiet", "--trace", "--record-decisions")
    _call("run", "day.toml", "--out", "day", "--quiet", "--trace", "--record-decisions")
    _call("run", "packed.toml", "--out", "packed", "--quiet", "--trace", "--record-decisions")
    for name in ("day", "packed"):  # in whose states runs begin
        state = ("--set", "run.until_s=60", "--save-state", f"{name}-at-60.json")
        _call("run", f"{name}.toml", "--out", "earlier", "--quiet", *state)
    _call(
        "run",
        "packed.toml",
        "--from",
        "packed-at-60.json",
        "--out",
        "begun",
        "--quiet",
        "--trace",
        "--record-decisions",
    )
    _call("validate", "begun")
    for run in ("packed", "day", "run"):  # a state of each kind, where both have one that of the second
        with gzip.open(folder / run / "decisions.jsonl.gz") as lines:
            asked = {json.loads(line).get("decides"): number for number, line in enumerate(lines)}
        for decides, number in asked.items():
            if decides is not None:
                _call("explain", run, "--decision", str(number), "--state", f"{decides.lower()}.json", "--json")
    _call("validate", "run")
    _call("validate", "day")
    _call("validate", "packed")
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
    recorded = [file for run in ("run", "day", "packed", "begun") for file in (folder / run).iterdir()]
    kept = [*folder.glob("*.*"), *recorded]
    files = {file.relative_to(folder).as_posix(): file.read_bytes() for file in sorted(kept)}
    unpacked = {name: gzip.decompress(data) if name.endswith(".gz") else data for name, data in files.items()}
    keys = [*_keys(RICH), *_keys(DAY), *(one for one in _keys(PACKED) if "packing" in one[0])]
    return Bases(unpacked, tuple(json.loads(_call("rules", "--json"))), tuple(keys))


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
