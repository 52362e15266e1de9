"""Same scenario, same seed, same versions: the same bytes."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import rmfs_core

RUN = """
import sys, rmfs_core
rmfs_core.run("examples/small", overrides=["instance.orders=30"], out=sys.argv[1], record=["trace"])
"""


def without_wall_clock(file: Path) -> bytes:
    """Bytes of an output file but for the wall-clock figures: `timing` in result.json, `seconds` in periods.csv."""
    data = file.read_bytes()
    if file.name == "result.json":
        content = json.loads(data)
        assert content.pop("timing")
        return json.dumps(content).encode()
    if file.name == "periods.csv":
        rows = data.decode().splitlines()
        assert rows[0].endswith(",seconds")
        return "\n".join(row.rpartition(",")[0] for row in rows).encode()
    return data


def test_two_fresh_processes_write_the_same_bytes(tmp_path: Path) -> None:
    folders = [tmp_path / "one", tmp_path / "two"]
    for hash_seed, folder in zip(("1", "4242"), folders, strict=True):
        environment = os.environ | {"PYTHONHASHSEED": hash_seed}
        subprocess.run([sys.executable, "-c", RUN, str(folder)], check=True, env=environment)
    names = sorted(file.name for file in folders[0].iterdir())
    tables = ("orders", "visits", "periods", "hours", "stations", "robots", "delays")
    assert names == sorted(("result.json", "trace.jsonl.gz", *(f"{table}.csv" for table in tables)))
    assert names == sorted(file.name for file in folders[1].iterdir())
    for name in names:
        assert without_wall_clock(folders[0] / name) == without_wall_clock(folders[1] / name), name


@pytest.mark.parametrize("poa", ["first-come", "common-lines"])
def test_rule_sets_see_the_same_orders_and_pods(poa: str) -> None:
    base = rmfs_core.run("examples/small")
    other = rmfs_core.run("examples/small", overrides=[f"rules.poa={poa}"])
    assert [(row["order"], row["items"]) for row in base.orders] == [
        (row["order"], row["items"]) for row in other.orders
    ]
    assert base.metrics != other.metrics
