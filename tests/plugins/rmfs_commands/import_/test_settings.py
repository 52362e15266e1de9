"""Settings, SKUs and lists of orders as RAWSim-O has them."""

from __future__ import annotations

from pathlib import Path

import pytest

from rawsimo_files import keys, xgenc, xitem, xsett
from rmfs_commands.import_.notes import Note, Notes
from rmfs_commands.import_.settings import OrderList, Sku, Spread, read_order_list, read_setting, read_skus
from rmfs_core.errors import InputError


def file(folder: Path, text: str) -> Path:
    """Write a file."""
    path = folder / "x.xml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_setting_has_the_defaults_of_rawsimo(tmp_path: Path) -> None:
    """Where it leaves keys out."""
    found = read_setting(file(tmp_path, keys("SettingConfiguration", {})), Notes())
    assert (found.seed, found.until_s, found.warmup_s, found.mode, found.backlog) == (0, 172_800, 0, "Fill", 200)
    assert (found.lines, found.quantities) == (Spread(1, 1, 1, 4), Spread(1, 0.3, 1, 3))
    assert (found.stocked, found.emptied, found.weight, found.bundle, found.refers_to) == (0.7, 0.1, 5, 6, None)


def test_what_has_no_counterpart_is_counted(tmp_path: Path) -> None:
    """Due times, values that override a layout, rates by time, and all that is not read."""
    notes = Notes()
    text = xsett(
        "Poisson",
        {
            "OverrideConfig": {"OverridePodCapacity": "true", "OverridePodCapacityValue": 4},
            "LogLevel": 1,
        },
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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (xsett("Magic"), "expected Fill, Poisson or Fixed as `OrderMode` of InventoryConfiguration, found 'Magic'"),
        (xsett(ItemType="Letter"), "expected SimpleItem, or orders of a list (`OrderMode` Fixed) as `ItemType`"),
        (xsett(run={"Seed": -1}), "expected a whole number from 0 to 1,000,000,000 as `Seed`"),
        (
            xsett(PositionCountMin=5),
            "expected a whole number of at least 5, as `PositionCountMin` says, as",
        ),
    ],
)
def test_wrong_settings_are_refused(tmp_path: Path, text: str, message: str) -> None:
    """With what would be right."""
    with pytest.raises(InputError) as caught:
        read_setting(file(tmp_path, text.replace('"Seed": 3', "")), Notes())
    assert message in str(caught.value)


def test_skus_have_weights_and_bundles(tmp_path: Path) -> None:
    """Their own, or those of the setting; how often they are ordered is 1 where nothing else is said."""
    found = read_skus(file(tmp_path, xgenc({2: 0.5, 1: 7}, weights={1: 3.0}, bundle=9)), 5, 6, Notes())
    assert found == [Sku("s1", 7, 3.0, 9), Sku("s2", 0.5, 5, 9)]
    bare = '<C><DefaultWeight>2.5</DefaultWeight><ItemDescriptions><E Key="4" Value="1"/></ItemDescriptions>'
    bare += "<ItemCoWeights><E/><E/></ItemCoWeights></C>"
    notes = Notes()
    assert read_skus(file(tmp_path, bare), 5, 6, notes) == [Sku("s4", 2.5, 5, 6)]
    assert notes.taken == [Note("SKUs that are bought together (ItemCoWeights)", 2, "drawn apart")]
    with pytest.raises(InputError, match="found no SKU that orders want; expected"):
        read_skus(file(tmp_path, xgenc({1: 0})), 5, 6, Notes())


def test_a_list_has_orders_and_bundles(tmp_path: Path) -> None:
    """In the order of the file; an order without positions is none."""
    notes = Notes()
    text = xitem([(1.5, {3: 2, 4: 1}), (2, {}), (0.5, {3: 1})], [(3, 7)], [3, 4])
    assert read_order_list(file(tmp_path, text), notes) == OrderList(
        {"s3": 5.0, "s4": 5.0}, [(1.5, "s3", 7)], [(1.5, [("s3", 2), ("s4", 1)]), (0.5, [("s3", 1)])]
    )
    assert notes.taken == [Note("orders without positions", 1, "left out")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (xitem([]), "found no order; expected some"),
        (xitem([(-1, {1: 1})]), "expected a number from 0 to 3e+08 as `TimeStamp` of Order, found '-1'"),
        (xitem([(0, {1: -1})]), "expected a whole number from 0 to 1,000,000,000 as `Count` of Position, found '-1'"),
        (xitem([(0, {1: 1})], [(1, 0)]), "as `Size` of ItemBundle, found '0'"),
    ],
)
def test_wrong_lists_are_refused(tmp_path: Path, text: str, message: str) -> None:
    """With the line."""
    with pytest.raises(InputError) as caught:
        read_order_list(file(tmp_path, text), Notes())
    assert message in str(caught.value)
