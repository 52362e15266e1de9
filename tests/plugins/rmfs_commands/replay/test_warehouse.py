"""The warehouse of a recorded run at any time."""

from __future__ import annotations

import csv
from collections import Counter
from pathlib import Path

from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.replay.warehouse import WarehouseAt
from rmfs_commands.trace import read_trace
from rmfs_core.events import PodStored


def test_the_start(replay: Replay) -> None:
    """Everything is where the header says, and all orders are there at once."""
    world = WarehouseAt(replay)
    assert world.pod_cell == {i: pod["cell"] for i, pod in enumerate(replay.start.pods)}
    assert (world.backlog, world.done, world.picks) == (0, 0, 0)
    world.go(0)
    assert world.backlog + sum(len(open_) for open_ in world.open) == 20
    most = max(range(len(replay.start.pods)), key=world.open_items)
    wanted = [sku for order in replay.start.instance.orders for sku, items in order.lines for _ in range(items)]
    assert world.open_items(most) == sum(wanted.count(sku) for sku, _ in replay.start.instance.pods[most].contents) > 0


def test_the_end(day: Path, replay: Replay) -> None:
    """What was counted on the way is what the result says, and pods stand where they were stored last."""
    world = WarehouseAt(replay)
    world.go(replay.tick)
    assert world.done == replay.metrics["orders_completed"]
    assert world.picks == replay.metrics["picks"]
    assert world.backlog == 0
    assert not any(world.open)
    assert not any(map(world.open_items, range(len(replay.start.pods))))
    stored = {e.pod: e.cell for e in read_trace(day / "trace.jsonl.gz").events if isinstance(e, PodStored)}
    assert all(world.pod_cell[pod] == cell for pod, cell in stored.items() if pod in world.pod_cell)
    assert world.pod_cell.keys().isdisjoint(world.robot_pod.values())


def test_pickers_work_as_long_as_the_table_says(day: Path, replay: Replay) -> None:
    """Seen once a second, a picker is busy for the seconds of stations.csv."""
    world = WarehouseAt(replay)
    seen = [0] * len(replay.start.stations)
    for tick in range(0, replay.tick, 1000):
        world.go(tick)
        for station in range(len(seen)):
            seen[station] += world.is_picking(station)
    with (day / "stations.csv").open(encoding="utf-8", newline="") as file:
        busy = [float(row["busy_s"]) for row in csv.DictReader(file)]
    assert all(abs(a - b) <= 0.05 * b + 2 for a, b in zip(seen, busy, strict=True))


def test_bundles_closed_stations_and_moved_pods(restocked: Path) -> None:
    """Seen at each event: bundles at stations until they are stored, then items on pods; the second station closed."""
    replay = read_replay(restocked)
    world, ticks = WarehouseAt(replay), Counter[str]()
    for tick in sorted({event.tick for event in read_trace(restocked / "trace.jsonl.gz").events}):
        world.go(tick)
        ticks["bundles"] += bool(world.bundles[2])
        ticks["bound"] += any(world.bundles[2].values())
        ticks["stored"] += world.is_picking(2)
        ticks["moving"] += bool(world.moving)
        assert world.closed == ({1} if tick < 600_000 else set())
        assert world.moving <= world.busy
    assert min(ticks.values()) > 0
    assert not any(world.bundles)
