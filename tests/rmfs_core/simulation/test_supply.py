"""Where bundles come from."""

from __future__ import annotations

from itertools import islice

import pytest
from attrs import evolve

from replenished import scenario_of
from rmfs_core.simulation.supply import Supply
from rmfs_core.warehouse.parts import OrderLine
from rmfs_core.world import BundleData, Instance, OrderData, PodData

REORDER = {"process": "reorder-point", "reorder_point": 2, "order_up_to": 7}
INSTANCE = Instance(
    ("a", "b", "c"),
    (OrderData("1", 0, ((0, 3), (1, 1))),),
    (PodData("p", ((0, 3), (1, None))), PodData("q", ((0, 1), (2, 2)))),
    levels=((2, 7), (2, 7), (2, 7)),
    restocked=True,
)


def test_what_has_run_low_is_ordered_up_to_the_level_once() -> None:
    """Four items of a: ordered with the second pick; c is low from the start; b never runs out."""
    supply = Supply(scenario_of(REORDER), INSTANCE)
    assert [supply.order(sku) for sku in range(3)] == [[], [], [5]]
    supply.picked(0)
    assert supply.order(0) == []
    supply.picked(0)
    assert supply.order(0) == [5]
    assert supply.order(0) == []


def test_what_an_order_waits_for_is_ordered() -> None:
    """Four items of a, and an order waits for nine: as many are ordered as leave seven when it is picked."""
    supply, wanted = Supply(scenario_of(REORDER), INSTANCE), [OrderLine(0, 9)]
    supply.waits(wanted)
    assert supply.order(0) == [12]
    supply.waits_no_more(wanted)
    for _ in range(9):
        supply.picked(0)
    assert supply.order(0) == []


@pytest.mark.parametrize(
    ("instance", "largest"),
    [
        ({"replenishment": REORDER | {"bundle_items": 2}}, [2, 2, 1]),
        ({"replenishment": REORDER, "pod_capacity": 4}, [4, 1]),
    ],
)
def test_large_orders_come_in_several_bundles(instance: dict[str, object], largest: list[int]) -> None:
    """Of the most items that a bundle may have, or that a pod has room for."""
    supply = Supply(scenario_of(REORDER, instance=instance), INSTANCE)
    assert supply.order(2) == largest


def test_chance_brings_what_is_wanted() -> None:
    """Three of four bundles are of a, as its items are of those ordered; none of c; about ten an hour."""
    given = {"process": "poisson", "bundles_per_hour": 10.0, "bundle_items": 4}
    drawn = list(islice(Supply(scenario_of(given), INSTANCE).coming(), 400))
    skus = [bundle.sku for bundle in drawn]
    assert 260 < skus.count(0) < 340
    assert skus.count(2) == 0
    assert {bundle.items for bundle in drawn} == {4}
    assert 36 < drawn[-1].arrival_tick / 3_600_000 < 44
    assert drawn == list(islice(Supply(scenario_of(given), INSTANCE).coming(), 400))


def test_a_file_brings_what_it_says() -> None:
    """In order of arrival, and no more."""
    bundles = (BundleData("x", 5, 0, 1), BundleData("y", 9, 1, 2))
    supply = Supply(scenario_of({"process": "file", "file": "b"}), evolve(INSTANCE, bundles=bundles, levels=()))
    assert tuple(supply.coming()) == bundles
    assert supply.order(2) == []
