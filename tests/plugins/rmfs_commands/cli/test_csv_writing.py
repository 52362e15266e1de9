"""Instances written as CSV read back equal."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_commands.cli.csv_writing import orders_csv, pods_csv
from rmfs_commands.instances.generator import generate_instance
from rmfs_core.scenario import Arrivals, InstanceSection
from rmfs_core.world import Instance, read_instance


def read_back(instance: Instance, folder: Path) -> Instance:
    """Write an instance and read it again."""
    (folder / "orders.csv").write_text(orders_csv(instance), encoding="utf-8")
    (folder / "pods.csv").write_text(pods_csv(instance), encoding="utf-8")
    return read_instance(folder / "orders.csv", folder / "pods.csv")


@settings(deadline=None)
@given(
    section=st.builds(
        InstanceSection,
        orders=st.integers(0, 20),
        skus=st.integers(3, 60),
        pods=st.integers(5, 20),
        items_per_sku=st.none() | st.just(50),
        arrivals=st.sampled_from([Arrivals(), Arrivals("poisson", 77.7)]),
    ),
    seed=st.integers(0, 1000),
)
def test_generated_instances_read_back(
    tmp_path_factory: pytest.TempPathFactory, section: InstanceSection, seed: int
) -> None:
    """A generated instance survives its CSV files, ids and all."""
    instance = generate_instance(section, seed)
    assert read_back(instance, tmp_path_factory.mktemp("csv")) == instance


def test_unlimited_stock_is_an_empty_field() -> None:
    """A pod's unlimited SKU has no quantity; arrival times have no more digits than they need."""
    instance = generate_instance(InstanceSection(orders=1, skus=1, pods=1, skus_per_pod=1), 1)
    assert orders_csv(instance) == "order,arrival_s,sku,quantity\n1,0,1,1\n"
    assert pods_csv(instance) == "pod,sku,quantity\n1,1,\n"
