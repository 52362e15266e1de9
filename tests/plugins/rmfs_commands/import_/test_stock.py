"""What is on pods and what is ordered, where RAWSim-O draws it."""

from __future__ import annotations

from typing import Any

import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.import_ import stock
from rmfs_commands.import_.notes import Note, Notes
from rmfs_commands.import_.replenishing import Deliveries
from rmfs_commands.import_.settings import OrderList, Setting, Sku, Spread
from rmfs_commands.import_.stock import drawn_contents, drawn_orders, stock_of, stored_bundles
from rmfs_core.errors import InputError

SETTING = Setting(1, 3600, 0, "Fill", 5, 60, 0, Spread(1, 1, 1, 4), Spread(1, 0.3, 1, 3), 0.5, 0.1, 5, 6, None)
SKUS = [Sku("s0", 1, 2.0, 5), Sku("s1", 4, 1.0, 10), Sku("s2", 0, 1.0, 5)]


def test_pods_are_filled_to_their_share() -> None:
    """With whole bundles, evenly, of SKUs that are ordered; the same seed gives the same."""
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
    """Of any SKU; they have as many lines as the setting allows, and end when so much of the stock is left."""
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
    """In the time of the run, and a full backlog more; whether the stock ends them is said."""
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


def test_stock_that_is_refilled_ends_no_orders() -> None:
    """However little of it may be used up."""
    setting = evolve(SETTING, emptied=1.0)
    assert drawn_orders(setting, SKUS, {"s0": 10_000}, 2, 0.1, Notes()) == []
    assert (
        drawn_orders(setting, SKUS, None, 2, 0.1, Notes()) == drawn_orders(SETTING, SKUS, None, 2, 0.1, Notes()) != []
    )


def test_bundles_are_stored_on_the_emptiest_pods() -> None:
    """As long as they have room; SKUs that orders want more of have no end, wherever they are."""
    notes = Notes()
    bundles = [(0.0, "s0", 3), (9.0, "s1", 9), (1.0, "s0", 100), (2.0, "s2", 2)]
    found = OrderList({"s0": 10.0}, bundles, [(0, [("s0", 4), ("s3", 1), ("s2", 2)])])
    assert stored_bundles(found, [50.0, 50.0], notes) == ([{"s0": None, "s3": None}, {"s1": 9, "s2": 2}], [])
    assert [note.number for note in notes.taken] == [3, 1, 2]


def test_bundles_that_come_later_are_listed_by_arrival() -> None:
    """Pods begin empty, but for SKUs that orders want more of; a bundle too large for any pod does not come."""
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
    """Two stations of 60 orders an hour, of more than 1.5 items each on average, handle 60 items in all."""
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
    """From then on, and never more; orders that come when nothing is there are counted."""
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
