"""Bundles that arrive while RAWSim-O runs: levels of stock, listed bundles, rules."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from attrs import evolve

from rmfs_commands.import_.notes import Note, Notes
from rmfs_commands.import_.replenishing import Deliveries, Supply, chosen_rules, levels, storable
from rmfs_commands.import_.settings import Setting, Sku, Spread
from rmfs_commands.import_.warehouses import Storing
from rmfs_commands.import_.xml_reading import document
from rmfs_core.errors import InputError

SETTING = Setting(
    1, 36_000, 0, "Poisson", 5, 60, 0, Spread(1, 1, 1, 4), Spread(1, 0.3, 1, 3), 0.5, 0.1, 5, 6, None, (0.4, 0.6), 60, 3
)
SKUS = [Sku("s0", 1, 2.0, 5), Sku("s1", 4, 1.0, 10), Sku("s2", 0, 1.0, 5)]


def test_levels_keep_stock_between_the_shares_of_the_setting() -> None:
    """Half of the capacity on average, as much of each SKU as bundles bring, one bundle of its own at a time."""
    notes = Notes()
    supply = levels(SETTING, SKUS, 1000.0, {"s0": 1000, "s1": 1000}, notes)
    assert supply is not None
    assert supply.levels == {"s0": (47, 52), "s1": (395, 405)}
    assert (supply.bundle, supply.weights) == (10, {"s0": 2.0, "s1": 1.0})
    usual = {"s0": 2 * 50, "s1": 400}
    assert sum(usual.values()) == 500
    assert notes.taken == [Note("levels of all stock at which bundles come", 1, "levels of each SKU (skus.csv)")]


def test_nothing_is_ordered_of_what_is_there_at_the_start() -> None:
    """Stock below the level lowers it; a SKU that is on no pod is ordered at once."""
    supply = levels(SETTING, SKUS, 1000.0, {"s0": 20}, Notes())
    assert supply is not None
    assert supply.levels == {"s0": (19, 24), "s1": (0, 10)}


def test_pods_too_small_for_every_sku_are_not_refilled() -> None:
    """A bundle of each has to fit; that it does not is said."""
    notes = Notes()
    assert levels(SETTING, SKUS, 19.0, {}, notes) is None
    assert notes.taken == [
        Note("SKUs whose bundles have no room on pods all at once", 2, "stock is not filled up"),
    ]


def test_skus_whose_bundles_no_pod_holds_are_left_out() -> None:
    """They would be ordered and never come; some that is ordered has to be left."""
    notes = Notes()
    assert storable(SKUS, [10.0, 10.0, 5.0], "few.xgenc", notes) == SKUS
    assert not notes.taken
    heavy = [*SKUS, Sku("s3", 1, 30.0, 40)]
    assert storable(heavy, [10.0, 10.0, 5000.0], "few.xgenc", notes) == SKUS
    assert notes.taken == [Note("SKUs of which a bundle is heavier than what a pod holds", 1, "left out")]
    with pytest.raises(
        InputError, match=r"^few.xgenc: found no SKU that is ordered and whose bundle a pod of capacity 9 can"
    ):
        storable(heavy, [9.0], "few.xgenc", notes)


def test_a_pod_holds_every_bundle_though_sizes_are_rounded() -> None:
    """Three items of a third of the weight that a pod holds."""
    supply = Supply({"s0": 1 / 3}, 3, bundles=[(0.0, "s0", 3)])
    assert supply.instance_keys([1.0], [{}], Notes())["pod_capacity"] == 3 * 334


def test_deliveries_come_at_their_rate_until_pods_are_full() -> None:
    """As often of a SKU as it is ordered; what orders take makes room."""
    deliveries = Deliveries(SETTING, SKUS, 2, 1e9, {})
    assert len(list(deliveries.arrived(0.0))) == 3
    found = Counter(sku for sku, _ in deliveries.arrived(36_000.0))
    assert 1080 < found["s0"] + found["s1"] < 1320
    assert found["s1"] > 3 * found["s0"]
    full = Deliveries(evolve(SETTING, overfill=1.0), [Sku("s0", 1, 2.0, 5)], 2, 35.0, {"s0": 3})
    assert list(full.arrived(3600.0)) == [("s0", 5), ("s0", 5)]
    full.ordered({"s0": 3})
    assert list(full.arrived(7200.0)) == [("s0", 5)]
    assert full.supply().bundles == tuple(full.bundles)


@pytest.mark.parametrize(
    ("weights", "sizes", "capacity"),
    [
        ({"a": 2.0, "b": 5.0}, ["2", "5"], 50),
        ({"a": 0.25, "b": 1.0}, ["25", "100"], 5000),
        ({"a": 1 / 3, "b": 0.0}, ["334", "1"], 50_000),
    ],
)
def test_sizes_are_whole_numbers(weights: dict[str, float], sizes: list[str], capacity: int) -> None:
    """Of a unit fine enough for all weights, in which pods hold as much as before."""
    supply = Supply(weights, 4, bundles=[(0.5, "a", 4)])
    files = supply.files()
    assert [row.split(",")[1] for row in files["skus.csv"].splitlines()[1:]] == sizes
    assert files["bundles.csv"] == "bundle,arrival_s,sku,items\nb1,0.5,a,4\n"
    found = supply.instance_keys([50.0], [{}], Notes())
    assert found["pod_capacity"] == capacity
    assert found["replenishment"] == {"process": "file", "file": "bundles.csv"}


def test_stations_and_pods_are_as_most_of_them() -> None:
    """A station takes bundles as long as their weight fits; what differs is counted."""
    notes = Notes()
    supply = Supply({"a": 5.0}, 6, levels={"a": (3, 9)})
    storing = [Storing(1000, 10), Storing(400, 10), Storing(1000, 12)]
    assert supply.station_keys(storing, notes) == {"bundle_capacity": 13, "store_s": 10}
    keys = supply.instance_keys([50.0, 50.0, 40.0], [{"a": 11}, {}, {}], notes)
    assert keys["pod_capacity"] == 55  # what one holds at the start
    assert keys["replenishment"] == {"process": "reorder-point", "bundle_items": 6}
    assert [note.number for note in notes.taken] == [1, 1]


def test_rules_have_the_names_of_controllers(tmp_path: Path) -> None:
    """Those that rmfs has; others are said, and the rule that stands in."""
    file = tmp_path / "x.xconf"
    file.write_text(
        '<ControlConfiguration xmlns:xsi="x"><ItemStorageConfig xsi:type="ReactiveItemStorageConfiguration" />'
        '<ReplenishmentBatchingConfig xsi:type="RandomReplenishmentBatchingConfiguration" /></ControlConfiguration>',
        encoding="utf-8",
    )
    notes = Notes()
    assert chosen_rules(document(file), notes) == {"roa": "random", "rps": "emptiest-pod"}
    assert notes.taken == [Note("ItemStorage Reactive", 1, "emptiest-pod")]
    assert chosen_rules(None, notes) == {"roa": "first-bundle", "rps": "emptiest-pod"}
