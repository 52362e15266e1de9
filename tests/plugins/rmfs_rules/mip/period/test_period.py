"""A period as plain data."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.mip.period.period import Period, Stock


def test_it_is_read_off_the_warehouse() -> None:
    """Stations with free capacity, the backlog's open lines by order, and the pods bound for a station."""
    world = small_world({"1": ["b", "a"], "2": ["a"]}, {"p": ["a"], "q": ["b"]}, capacities=(2, 3))
    world.bind(world.pods[1], world.stations[1])
    view = WarehouseView(world)
    period = Period.of(view, Stock.of(view.pods, view.n_skus))
    sku = {world.orders[1].lines[0].sku: "a"}
    assert (period.stations, period.capacities) == ((0, 1), (2, 3))
    assert period.inbound == ((), (1,))
    assert period.busy == (1,)
    assert period.orders == (0, 1)
    assert [sorted(sku.get(i, "b") for i, _ in lines) for lines in period.lines] == [["a", "b"], ["a"]]
    assert period.single_items
    assert period.visits_before == 1


def test_lines_of_one_order(periods: list[Period]) -> None:
    """They are those of the table of all."""
    for period in periods[:50]:
        assert tuple(map(period.lines_of, range(len(period.orders)))) == period.lines


def test_new_visits_are_counted_in(periods: list[Period]) -> None:
    """With a new visit, a station covers what it did and what is on the pod; the period itself stays as it was."""
    for period in periods[:50]:
        before = period.covered.copy()
        covered = period.covered_with([(0, 0)])
        assert (covered[0] == (before[0] | (period.stock.holds[0] > 0))).all()
        assert (covered[1:] == before[1:]).all()
        assert (period.covered == before).all()
        assert (period.covered_with(()) == before).all()


def test_without_a_preference_idle_pods_go_first(periods: list[Period]) -> None:
    """A pod that is bound for a station is worth less than one that is not, and a pod once sent is bound for one."""
    for period in periods[:50]:
        assert period.preferred.once_sent == 0.0
        assert set(np.flatnonzero(period.preferred.pods == 0)) == set(period.busy)


def test_free_items_follow_the_warehouse(scarce_periods):
    """What ran out or came back is read anew, and the rest is as it was."""
    rng = np.random.default_rng(3)
    for period in scarce_periods[:20]:
        entries = [(pod, sku) for pod in range(len(period.stock.pods)) for sku in range(period.stock.n_skus)]
        stock = period.stock
        for _ in range(4):
            numbers = rng.integers(0, 3, len(entries))
            held: list[dict[int, int]] = [{} for _ in period.stock.pods]
            for (pod, sku), number in zip(entries, numbers.tolist(), strict=True):
                held[pod][sku] = number
            stock, anew = stock.with_items(*np.array(entries).T, numbers), Stock.counted(held, stock.n_skus)
            assert stock.contents == anew.contents
            assert (stock.holds == anew.holds).all()
            for name in ("pod", "sku", "number"):
                assert (getattr(stock.items, name) == getattr(anew.items, name)).all()
