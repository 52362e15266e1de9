"""How many orders waited for stock is said at the end of a run."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from rmfs_commands.cli.main import main
from rmfs_commands.cli.waiting import StockWaits
from rmfs_core.events import OrderInStock


def test_orders_are_counted() -> None:
    """Nothing is said where none waited."""
    waits = StockWaits()
    assert waits.sentence == ""
    waits.on_event(OrderInStock(tick=5, order=2))
    assert waits.sentence == "1 order waited for stock (stock_s in delays.csv)."
    waits.on_event(OrderInStock(tick=5, order=3))
    assert waits.sentence == "2 orders waited for stock (stock_s in delays.csv)."


def test_a_run_says_how_many(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As many as have waited by delays.csv; a run in which stock never runs out says nothing."""
    scarce = ("--set", "instance.replenishment.reorder_point=1", "--set", "instance.replenishment.order_up_to=6")
    main(["run", "examples/replenished", *scarce, "--out", str(tmp_path)])
    with (tmp_path / "delays.csv").open(encoding="utf-8", newline="") as file:
        waited = sum(float(row["stock_s"] or 0) > 0 for row in csv.DictReader(file))
    assert waited > 1
    assert f"\n{waited} orders waited for stock (stock_s in delays.csv).\n" in capsys.readouterr().out
    main(["run", "examples/small", "--out", str(tmp_path / "small")])
    assert "waited for stock" not in capsys.readouterr().out
