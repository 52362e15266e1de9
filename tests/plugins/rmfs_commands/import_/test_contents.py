"""Settings, stock, orders and bundles as RAWSim-O has them."""

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st

from calling import refusal
from cases import cases
from rawsimo_files import keys, xgenc, xitem, xsett
from rmfs_commands.import_ import stock
from rmfs_commands.import_.notes import Note, Notes
from rmfs_commands.import_.replenishing import Deliveries, Supply, chosen_rules, levels, storable
from rmfs_commands.import_.settings import OrderList, Setting, Sku, Spread, read_order_list, read_setting, read_skus
from rmfs_commands.import_.stock import drawn_contents, drawn_orders, stock_of, stored_bundles
from rmfs_commands.import_.warehouses import Storing
from rmfs_commands.import_.xml_reading import document
from rmfs_core.errors import InputError

SETTING = Setting(1, 3600, 0, "Fill", 5, 60, 0, Spread(1, 1, 1, 4), Spread(1, 0.3, 1, 3), 0.5, 0.1, 5, 6, None)
SKUS = [Sku("s0", 1, 2.0, 5), Sku("s1", 4, 1.0, 10), Sku("s2", 0, 1.0, 5)]


def test_pods_are_filled_to_their_share() -> None:
    contents = drawn_contents(SETTING, SKUS, [100.0] * 20, "x")
    assert contents == drawn_contents(SETTING, SKUS, [100.0] * 20, "x")
    loads = [sum((n or 0) * {"s0": 2, "s1": 1}[sku] for sku, n in pod.items()) for pod in contents]
    assert set(loads) == {50}
    assert contents != drawn_contents(evolve(SETTING, seed=2), SKUS, [100.0] * 20, "x")


def test_pods_that_hold_nothing_stay_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bundles that fit nowhere are not there; pods without end, or for which it would take hours, are refused."""
    assert drawn_contents(SETTING, SKUS, [4.0, 3.0], "x") == [{}, {}]
    with pytest.raises(InputError, match="found pods that hold bundles without end"):
        drawn_contents(SETTING, [Sku("s", 1, 0.0, 5)], [100.0], "x")
    monkeypatch.setattr(stock, "MOST_BUNDLES", 10_000)
    with pytest.raises(InputError, match=r"^x: found room for more than 10,000 bundles on pods"):
        drawn_contents(SETTING, [Sku("s", 1, 1e-9, 1)], [100.0], "x")


@given(
    seed=st.integers(0, 5),
    stock=st.lists(st.integers(0, 30), min_size=1, max_size=6),
    lines=st.tuples(st.integers(1, 3), st.integers(3, 5)),
    end=st.sampled_from([0.0, 0.1, 0.5]),
)
def test_orders_never_want_more_than_there_is(seed: int, stock: list[int], lines: tuple[int, int], end: float) -> None:
    setting = evolve(SETTING, seed=seed, lines=Spread(2, 1, *lines), emptied=end)
    skus = [Sku(f"s{i}", 1, 1, 1) for i in range(len(stock))]
    contents: Any = [{f"s{i}": number} for i, number in enumerate(stock)]
    orders = drawn_orders(setting, skus, stock_of(contents), 1, 10.0, Notes())
    wanted = [0] * len(stock)
    for _, order in orders:
        assert 1 <= len(order) <= lines[1]
        assert len({sku for sku, _ in order}) == len(order)
        for sku, items in order:
            wanted[int(sku[1:])] += items
    assert all(want <= there for want, there in zip(wanted, stock, strict=True))
    assert sum(stock) - sum(wanted) <= end * sum(stock) or not sum(stock)


def test_there_are_as_many_orders_as_stations_can_pick() -> None:
    notes = Notes()
    plenty = {"s0": 10_000, "s1": 10_000}
    orders = drawn_orders(SETTING, SKUS, plenty, 2, 0.1, notes)
    items = sum(n for _, lines in orders for _, n in lines)
    assert 375 <= items < 400
    assert notes.taken == []
    few = drawn_orders(SETTING, SKUS, {"s0": 10}, 2, 0.1, notes)
    assert notes.taken == [
        Note("orders drawn until the stock of pods ends", len(few), "no more come; stock is not filled up")
    ]


def test_stock_that_is_refilled() -> None:
    setting = evolve(SETTING, emptied=1.0)
    assert drawn_orders(setting, SKUS, {"s0": 10_000}, 2, 0.1, Notes()) == []
    assert (
        drawn_orders(setting, SKUS, None, 2, 0.1, Notes()) == drawn_orders(SETTING, SKUS, None, 2, 0.1, Notes()) != []
    )
    notes = Notes()
    bundles = [(0.0, "s0", 3), (9.0, "s1", 9), (1.0, "s0", 100), (2.0, "s2", 2)]
    found = OrderList({"s0": 10.0}, bundles, [(0, [("s0", 4), ("s3", 1), ("s2", 2)])])
    assert stored_bundles(found, [50.0, 50.0], notes) == ([{"s0": None, "s3": None}, {"s1": 9, "s2": 2}], [])
    assert [note.number for note in notes.taken] == [3, 1, 2]


def test_bundles_that_come_later_are_listed_by_arrival() -> None:
    notes = Notes()
    bundles = [(9.0, "s1", 9), (0.0, "s0", 3), (1.0, "s0", 100)]
    found = OrderList({"s0": 10.0}, bundles, [(0, [("s0", 3), ("s3", 1), ("s1", 10)])])
    contents, coming = stored_bundles(found, [50.0, 50.0], notes, later=True)
    assert contents == [{"s3": None}, {"s1": None}]
    assert coming == [(0.0, "s0", 3), (9.0, "s1", 9)]
    assert notes.taken == [
        Note("bundles that no pod has room for", 1, "left out"),
        Note("SKUs of which orders want more than bundles bring", 2, "never run out"),
    ]


def test_poisson_loads_above_capacity_are_said() -> None:
    notes = Notes()
    setting = evolve(SETTING, mode="Poisson", until_s=36_000)
    orders = drawn_orders(setting, SKUS, None, 2, 1 / 60, notes)
    (note,) = notes.taken
    assert note.what == "items ordered per hour, more than the 60 that output stations can handle"
    assert note.instead == "kept; more and more orders wait"
    items = sum(n for _, lines in orders for _, n in lines)
    assert note.number == pytest.approx(120 * items / len(orders), abs=1)
    assert 1000 < len(orders) < 1400
    notes = Notes()
    drawn_orders(setting, SKUS, None, 2, 1.0, notes)
    assert notes.taken == []


def test_orders_want_what_deliveries_have_brought() -> None:
    notes = Notes()
    setting = evolve(SETTING, mode="Poisson", until_s=36_000, bundles_per_h=6, initial_bundles=1, initial_orders=1)
    deliveries = Deliveries(setting, SKUS, 1, 1e9, {})
    orders = drawn_orders(setting, SKUS, {}, 1, 10.0, notes, deliveries)
    assert 30 < len(deliveries.bundles) < 90
    left: dict[str, int] = {}
    coming = list(deliveries.bundles)
    for time, lines in orders:
        while coming and coming[0][0] <= time:
            _, sku, items = coming.pop(0)
            left[sku] = left.get(sku, 0) + items
        for sku, items in lines:
            left[sku] -= items
            assert left[sku] >= 0
    assert orders[0][0] == deliveries.bundles[0][0] == 0
    assert [note.what for note in notes.taken] == ["orders for which stock has nothing left when they arrive"]


POISSON = Setting(
    1, 36_000, 0, "Poisson", 5, 60, 0, Spread(1, 1, 1, 4), Spread(1, 0.3, 1, 3), 0.5, 0.1, 5, 6, None, (0.4, 0.6), 60, 3
)


def test_levels_keep_stock_between_the_shares_of_the_setting() -> None:
    """Half of the capacity on average, as much of each SKU as bundles bring, one bundle of its own at a time."""
    notes = Notes()
    supply = levels(POISSON, SKUS, 1000.0, {"s0": 1000, "s1": 1000}, notes)
    assert supply.levels == {"s0": (47, 52), "s1": (395, 405)}
    assert (supply.bundle, supply.weights) == (10, {"s0": 2.0, "s1": 1.0})
    usual = {"s0": 2 * 50, "s1": 400}
    assert sum(usual.values()) == 500
    assert notes.taken == [Note("levels of all stock at which bundles come", 1, "levels of each SKU (skus.csv)")]


def test_what_is_not_ordered_or_refilled() -> None:
    supply = levels(POISSON, SKUS, 1000.0, {"s0": 20}, Notes())
    assert supply.levels == {"s0": (19, 24), "s1": (0, 10)}
    notes = Notes()
    assert levels(POISSON, SKUS, 19.0, {}, notes) is None
    assert notes.taken == [Note("SKUs whose bundles have no room on pods all at once", 2, "stock is not filled up")]


def test_bundles_and_pods_that_fit() -> None:
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
    supply = Supply({"s0": 1 / 3}, 3, bundles=[(0.0, "s0", 3)])
    assert supply.instance_keys([1.0], [{}], Notes())["pod_capacity"] == 3 * 334


def test_deliveries_come_at_their_rate_until_pods_are_full() -> None:
    deliveries = Deliveries(POISSON, SKUS, 2, 1e9, {})
    assert len(list(deliveries.arrived(0.0))) == 3
    found = Counter(sku for sku, _ in deliveries.arrived(36_000.0))
    assert 1080 < found["s0"] + found["s1"] < 1320
    assert found["s1"] > 3 * found["s0"]
    full = Deliveries(evolve(POISSON, overfill=1.0), [Sku("s0", 1, 2.0, 5)], 2, 35.0, {"s0": 3})
    assert list(full.arrived(3600.0)) == [("s0", 5), ("s0", 5)]
    full.ordered({"s0": 3})
    assert list(full.arrived(7200.0)) == [("s0", 5)]
    assert full.supply().bundles == tuple(full.bundles)


@cases(
    "weights sizes capacity",
    ({"a": 2.0, "b": 5.0}, ["2", "5"], 50),
    ({"a": 0.25, "b": 1.0}, ["25", "100"], 5000),
    ({"a": 1 / 3, "b": 0.0}, ["334", "1"], 50_000),
)
def test_sizes_are_whole_numbers(weights: dict[str, float], sizes: list[str], capacity: int) -> None:
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


def file(folder: Path, text: str) -> Path:
    path = folder / "x.xml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_setting_has_the_defaults_of_rawsimo(tmp_path: Path) -> None:
    found = read_setting(file(tmp_path, keys("SettingConfiguration", {})), Notes())
    assert (found.seed, found.until_s, found.warmup_s, found.mode, found.backlog) == (0, 172_800, 0, "Fill", 200)
    assert (found.lines, found.quantities) == (Spread(1, 1, 1, 4), Spread(1, 0.3, 1, 3))
    assert (found.stocked, found.emptied, found.weight, found.bundle, found.refers_to) == (0.7, 0.1, 5, 6, None)


def test_what_has_no_counterpart_is_counted(tmp_path: Path) -> None:
    notes = Notes()
    text = xsett(
        "Poisson",
        {"OverrideConfig": {"OverridePodCapacity": "true", "OverridePodCapacityValue": 4}, "LogLevel": 1},
        DueTimeOffsetMean=3600,
        PoissonInventoryConfiguration={"PoissonMode": "TimeDependent"},
    )
    read_setting(file(tmp_path, text), notes)
    assert [(note.what.split(" (")[0], note.number) for note in notes.taken] == [
        ("values of the setting that override those of the layout", 1),
        ("rates of orders by time of day or season", 1),
        ("settings of due times", 1),
        ("other settings", 2),
    ]


@cases(
    "text message",
    (xsett("Magic"), "expected Fill, Poisson or Fixed as `OrderMode` of InventoryConfiguration, found 'Magic'"),
    (xsett(ItemType="Letter"), "expected SimpleItem, or orders of a list (`OrderMode` Fixed) as `ItemType`"),
    (xsett(run={"Seed": -1}), "expected a whole number from 0 to 1,000,000,000 as `Seed`"),
    (xsett(PositionCountMin=5), "expected a whole number of at least 5, as `PositionCountMin` says, as"),
)
def test_wrong_settings_are_refused(tmp_path: Path, text: str, message: str) -> None:
    assert message in refusal(lambda: read_setting(file(tmp_path, text.replace('"Seed": 3', "")), Notes()))


def test_skus_and_lists_are_read(tmp_path: Path) -> None:
    found = read_skus(file(tmp_path, xgenc({2: 0.5, 1: 7}, weights={1: 3.0}, bundle=9)), 5, 6, Notes())
    assert found == [Sku("s1", 7, 3.0, 9), Sku("s2", 0.5, 5, 9)]
    bare = '<C><DefaultWeight>2.5</DefaultWeight><ItemDescriptions><E Key="4" Value="1"/></ItemDescriptions>'
    bare += "<ItemCoWeights><E/><E/></ItemCoWeights></C>"
    notes = Notes()
    assert read_skus(file(tmp_path, bare), 5, 6, notes) == [Sku("s4", 2.5, 5, 6)]
    assert notes.taken == [Note("SKUs that are bought together (ItemCoWeights)", 2, "drawn apart")]
    with pytest.raises(InputError, match="found no SKU that orders want; expected"):
        read_skus(file(tmp_path, xgenc({1: 0})), 5, 6, Notes())
    notes = Notes()
    text = xitem([(1.5, {3: 2, 4: 1}), (2, {}), (0.5, {3: 1})], [(3, 7)], [3, 4])
    assert read_order_list(file(tmp_path, text), notes) == OrderList(
        {"s3": 5.0, "s4": 5.0}, [(1.5, "s3", 7)], [(1.5, [("s3", 2), ("s4", 1)]), (0.5, [("s3", 1)])]
    )
    assert notes.taken == [Note("orders without positions", 1, "left out")]


@cases(
    "text message",
    (xitem([]), "found no order; expected some"),
    (xitem([(-1, {1: 1})]), "expected a number from 0 to 3e+08 as `TimeStamp` of Order, found '-1'"),
    (xitem([(0, {1: -1})]), "expected a whole number from 0 to 1,000,000,000 as `Count` of Position, found '-1'"),
    (xitem([(0, {1: 1})], [(1, 0)]), "as `Size` of ItemBundle, found '0'"),
)
def test_wrong_lists_are_refused(tmp_path: Path, text: str, message: str) -> None:
    assert message in refusal(lambda: read_order_list(file(tmp_path, text), Notes()))
