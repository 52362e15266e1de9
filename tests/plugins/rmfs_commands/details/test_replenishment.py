"""Bundles and stock of a small run, held against its events."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import pytest
from attrs import define

import rmfs_core
from replenished import scenario_of
from rmfs_commands.trace import Trace, read_trace
from rmfs_core.events import BundleArrived, BundleStored, ItemPicked, OrderInStock, PodStored, TaskAssigned, VisitEnded

SUPPLY = {"process": "reorder-point", "reorder_point": 1, "order_up_to": 6, "lead_s": 200.0}
INSTANCE = {"orders": 40, "skus": 4, "pods": 4, "skus_per_pod": 1, "items_per_sku": 4, "replenishment": SUPPLY}


@define
class Run:
    """A run with its files."""

    folder: Path
    metrics: dict[str, Any]
    trace: Trace

    def of(self, kind: type) -> list[Any]:
        """Events of one class."""
        return [event for event in self.trace.events if isinstance(event, kind)]

    def rows(self, name: str) -> list[dict[str, str]]:
        """Rows of a table."""
        return list(csv.DictReader((self.folder / name).read_text(encoding="utf-8").splitlines()))


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Return a run of 40 orders with one robot, in which SKUs run out."""
    folder = tmp_path_factory.mktemp("run")
    result = rmfs_core.run(scenario_of(SUPPLY, robots=1, instance=INSTANCE), out=folder, record=["trace"])
    return Run(folder, dict(result.metrics), read_trace(folder / "trace.jsonl.gz"))


def test_bundles(run: Run) -> None:
    """A row for each, with what became of it."""
    rows, arrived = run.rows("bundles.csv"), run.of(BundleArrived)
    assert [(row["bundle"], float(row["arrival_s"]), int(row["items"])) for row in rows] == [
        (event.name, event.time_s, event.items) for event in arrived
    ]
    stored = {event.bundle: event for event in run.of(BundleStored)}
    assert len(stored) > 3
    for i, row in enumerate(rows):
        event = stored.get(i)
        told = (row["stored_s"], row["station"], row["visit"])
        assert told == (("", "", "") if event is None else (str(event.time_s), "2", str(event.visit)))
    done = [event.tick - arrived[i].tick for i, event in stored.items()]
    assert run.metrics["bundles_stored"] == len(stored)
    assert run.metrics["items_stored"] == sum(event.items for event in stored.values())
    assert run.metrics["bundle_turnover_s"] == pytest.approx(sum(done) / len(done) / 1000)
    assert run.metrics["replenishment_visits"] == len({event.visit for event in stored.values()})


def test_stock(run: Run) -> None:
    """What is there at the end of each hour is what was there, what was stored, and what was picked."""
    items, left = 16, dict.fromkeys(range(4), 4)
    held, outs = [(0, items)], 0
    rows = run.rows("stock.csv")
    for event in run.trace.events:
        if isinstance(event, BundleStored | ItemPicked):
            change = event.items if isinstance(event, BundleStored) else -1
            left[event.sku] += change
            items += change
            outs += left[event.sku] == 0
            held.append((event.tick, items))
    for row in rows:
        end = (int(row["hour"]) + 1) * 3_600_000
        assert int(row["items_in_stock"]) == next(number for tick, number in reversed(held) if tick < end)
    assert sum(int(row["items_picked"]) for row in rows) == len(run.of(ItemPicked))
    assert int(rows[-1]["skus_in_stock"]) == sum(number > 0 for number in left.values())
    assert run.metrics["stock_outs"] == outs > 0
    ticks = [*(tick for tick, _ in held[1:]), run.trace.tick]
    area = sum((end - tick) * number for (tick, number), end in zip(held, ticks, strict=True))
    assert run.metrics["items_in_stock_mean"] == pytest.approx(area / run.trace.tick)


def test_share_of_robots_that_replenish(run: Run) -> None:
    """Ways to visits in which a bundle was stored and nothing picked, and ways back from them; there is one robot."""
    visits = {event.visit for event in run.of(BundleStored)}
    total, since, storing = 0, 0, False
    for event in run.trace.events:
        if isinstance(event, TaskAssigned):
            since = event.tick
        elif isinstance(event, VisitEnded):
            storing = event.visit in visits and not event.picks
            total, since = total + storing * (event.tick - since), event.tick
        elif isinstance(event, PodStored):
            total += storing * (event.tick - since)
    assert total > 0
    assert run.metrics["replenishment_robot_percent"] == pytest.approx(100 * total / run.trace.tick)


def test_time_that_orders_wait_for_stock(run: Run) -> None:
    """From the arrival to the event; what follows in delays.csv adds up to the turn-over time with it."""
    served = {event.order: event.tick for event in run.of(OrderInStock)}
    assert len(served) > 3
    waits = [
        served.get(i, order.arrival_tick) - order.arrival_tick for i, order in enumerate(run.trace.instance.orders)
    ]
    rows = run.rows("delays.csv")
    assert [float(row["stock_s"]) for row in rows] == [tick / 1000 for tick in waits]
    for row in rows:
        parts = [float(value) for column, value in row.items() if column not in ("order", "turnover_s")]
        assert sum(parts) == pytest.approx(float(row["turnover_s"]))
    assert run.metrics["turnover_stock_s"] == pytest.approx(sum(waits) / len(waits) / 1000)


def test_nothing_of_waiting_where_no_order_waits(tmp_path: Path) -> None:
    """With the key that switches it off."""
    over = ["rules.wait_for_stock=false", "instance.orders=5", "rules.pp=free-flow"]
    result = rmfs_core.run("examples/replenished", overrides=over, out=tmp_path)
    assert "turnover_stock_s" not in result.metrics
    assert (tmp_path / "delays.csv").read_text(encoding="utf-8").startswith("order,turnover_s,backlog_s,")


def test_visits_to_replenishment_stations_are_counted_apart(run: Run) -> None:
    """Pod-station visits are those to picking stations, in every table."""
    picking = [event for event in run.of(VisitEnded) if event.station == 0]
    assert run.metrics["pod_station_visits"] == len(picking) == sum(int(row["visits"]) for row in run.rows("hours.csv"))
    assert [int(row["visits"]) for row in run.rows("stations.csv")] == [len(picking)]
    assert len(run.rows("visits.csv")) > len(picking)


def test_runs_without_replenishment_have_none_of_it(tmp_path: Path) -> None:
    """Neither files nor metrics."""
    result = rmfs_core.run("examples/small", overrides=["instance.orders=3"], out=tmp_path)
    assert not {"bundles_stored", "stock_outs"} & result.metrics.keys()
    assert not (tmp_path / "bundles.csv").exists()
