"""Time of loading a large orders file, and of generating the paper's largest instance."""

from __future__ import annotations

from pathlib import Path

from pytest_benchmark.fixture import BenchmarkFixture

from rmfs_commands.instances.generator import generate_instance
from rmfs_core.scenario import InstanceSection
from rmfs_core.world import read_instance


def test_load_100_000_rows(benchmark: BenchmarkFixture, tmp_path: Path) -> None:
    """100,000 order rows; the aim is under 2 s."""
    rows = "".join(f"W{i // 2},{i // 2},SKU{i * 7 % 5000},{i % 3 + 1}\n" for i in range(100_000))
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\n" + rows, encoding="utf-8")
    pods = "".join(f"P{i // 3},SKU{i},\n" for i in range(5000))
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\n" + pods, encoding="utf-8")
    instance = benchmark(read_instance, tmp_path / "orders.csv", tmp_path / "pods.csv")
    assert len(instance.orders) == 50_000


def test_generate_2000_orders(benchmark: BenchmarkFixture) -> None:
    """The paper's 2000-order instance; the aim is under 0.3 s."""
    instance = benchmark(generate_instance, InstanceSection(orders=2000), 1)
    assert len(instance.orders) == 2000
