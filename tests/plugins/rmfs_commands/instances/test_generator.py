"""The paper's instance generator."""

from collections import Counter

import numpy as np
import pytest
from attrs import evolve
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_commands.instances.generator import draw_distinct, generate_instance, order_lengths, sku_demand
from rmfs_core.errors import InputError
from rmfs_core.scenario import Arrivals, InstanceSection
from rmfs_core.scenario.model import Due, SkuDemand
from rmfs_core.world import Instance

PAPER = InstanceSection()


def wanted(instance: Instance) -> list[tuple[str, ...]]:
    return [tuple(instance.skus[sku] for sku, _ in order.lines) for order in instance.orders]


def test_sizes_are_those_of_the_scenario() -> None:
    instance = generate_instance(PAPER, seed=1)
    assert (len(instance.orders), len(instance.skus), len(instance.pods)) == (250, 100, 100)
    assert instance.skus == tuple(str(i) for i in range(1, 101))
    assert [order.name for order in instance.orders] == [str(i) for i in range(1, 251)]
    assert {len(pod.contents) for pod in instance.pods} <= {2, 3}
    assert instance.unlimited_stock
    assert {order.arrival_tick for order in instance.orders} == {0}


@settings(deadline=None)
@given(
    seed=st.integers(0, 10**6),
    skus=st.integers(1, 40),
    pods=st.integers(10, 30),
    skus_per_pod=st.integers(2, 4),
    items_per_sku=st.none() | st.integers(5, 9),
)
def test_pods_can_fill_every_order(
    seed: int, skus: int, pods: int, skus_per_pod: int, items_per_sku: int | None
) -> None:
    section = InstanceSection(
        orders=5, skus=skus, pods=pods, skus_per_pod=min(skus, skus_per_pod), items_per_sku=items_per_sku
    )
    instance = generate_instance(section, seed)
    stock: Counter[int] = Counter()
    for pod in instance.pods:
        assert len({sku for sku, _ in pod.contents}) == len(pod.contents)
        stock.update({sku: 10**9 if items is None else items for sku, items in pod.contents})
    for order in instance.orders:
        assert 1 <= len({sku for sku, _ in order.lines}) == len(order.lines) <= min(skus, 15)
        stock.subtract(dict(order.lines))
    assert min(stock.values()) >= 0
    assert set(stock) == set(range(len(instance.skus)))


def test_a_seed_gives_one_instance() -> None:
    assert generate_instance(PAPER, 1) == generate_instance(PAPER, 1)
    assert wanted(generate_instance(PAPER, 1)) != wanted(generate_instance(PAPER, 2))
    assert generate_instance(PAPER, 1).orders[:50] == generate_instance(evolve(PAPER, orders=50), 1).orders
    section = evolve(PAPER, orders=2000, arrivals=Arrivals("poisson", orders_per_hour=360))
    instance = generate_instance(section, 1)
    ticks = [order.arrival_tick for order in instance.orders]
    assert ticks == sorted(ticks)
    assert ticks[0] > 0
    assert ticks[-1] / 1000 / 2000 == pytest.approx(10, rel=0.1)
    assert wanted(instance) == wanted(generate_instance(evolve(PAPER, orders=2000), 1))


def test_order_lengths_are_truncated_geometric() -> None:
    lengths = order_lengths(20)
    assert lengths.sum() == pytest.approx(1)
    assert lengths[1:] / lengths[:-1] == pytest.approx(np.full(19, 0.6))
    assert lengths @ np.arange(1, 21) == pytest.approx(2.5, abs=0.01)


@pytest.mark.parametrize(("skus", "p"), [(100, 0.05), (20, 0.25), (11, 5 / 11), (10, 0.5), (5, 0.5), (2, 0.5)])
def test_sku_demand_is_geometric(skus: int, p: float) -> None:
    demand = sku_demand(skus)
    assert demand.sum() == pytest.approx(1)
    assert demand[1:] / demand[:-1] == pytest.approx(np.full(skus - 1, 1 - p))


def test_drawn_orders_follow_the_distributions() -> None:
    section = InstanceSection(orders=20_000, skus=20, pods=20)
    orders = wanted(generate_instance(section, 3))
    mean = order_lengths(15) @ np.arange(1, 16)
    assert np.mean([len(skus) for skus in orders]) == pytest.approx(mean, rel=0.02)
    single = Counter(skus[0] for skus in orders if len(skus) == 1)
    shares = np.array([single[str(i)] for i in range(1, 21)]) / single.total()
    assert shares == pytest.approx(sku_demand(20), abs=0.012)


@pytest.mark.parametrize("skus", [6, 40, 3_000])
def test_distinct_draws_are_those_of_numpy(skus: int) -> None:
    ours, theirs, weights = np.random.default_rng(5), np.random.default_rng(5), sku_demand(skus)
    shares = weights.cumsum() / weights.cumsum()[-1]
    for number in [1, 2, 3, 6] * 50:
        expected = theirs.choice(skus, number, replace=False, p=weights)
        assert draw_distinct(number, weights, shares, ours).tolist() == expected.tolist()


def test_skus_on_pods() -> None:
    instance = generate_instance(InstanceSection(orders=0, skus=12, pods=16, skus_per_pod=3), 1)
    assert Counter(sku for pod in instance.pods for sku, _ in pod.contents) == dict.fromkeys(range(12), 4)
    section = InstanceSection(orders=0, skus=3, pods=40, skus_per_pod=2, items_per_sku=5)
    pods = generate_instance(section, 1).pods
    assert {contents for pod in pods for contents in [tuple(items for _, items in pod.contents)]} == {(5, 5), (10,)}
    assert sum(items or 0 for pod in pods for _, items in pod.contents) == 40 * 2 * 5
    instance = generate_instance(InstanceSection(orders=10, skus=100, pods=4, skus_per_pod=2), 1)
    assert len(instance.skus) == 8
    assert set(instance.skus) <= {str(i) for i in range(1, 101)}


def test_too_little_stock_is_an_error() -> None:
    section = InstanceSection(orders=50, skus=5, pods=5, skus_per_pod=1, items_per_sku=2)
    with pytest.raises(InputError) as caught:
        generate_instance(section, 1)
    message = str(caught.value)
    assert message.startswith("instance: after ")
    assert message.endswith(
        "of 50 orders the 5 pods of 1 SKUs each have items of 0 of 5 SKUs left, too few to draw an order that they can "
        "fill; expected more `pods` or `skus_per_pod` or `items_per_sku`, or fewer `orders` or `skus`"
    )


PROFILE = (0.0,) * 6 + (1.0, 3.0) + (0.0,) * 16


def test_arrivals_follow_the_hours() -> None:
    day = evolve(PAPER, arrivals=Arrivals("day", profile=PROFILE))
    hours = np.array([order.arrival_tick for order in generate_instance(day, seed=1).orders]) / 3_600_000
    assert (hours.min() >= 6, hours.max() < 8) == (True, True)
    assert np.mean(hours < 7) == pytest.approx(0.25, abs=0.07)
    assert (np.diff(hours) >= 0).all()
    assert wanted(generate_instance(day, seed=1)) == wanted(generate_instance(PAPER, seed=1))
    day = evolve(PAPER, arrivals=Arrivals("day", profile=PROFILE), start="2024-03-01T07:30")
    hours = np.array([order.arrival_tick for order in generate_instance(day, seed=1).orders]) / 3_600_000
    assert set(np.floor(hours * 2).tolist()) == {0, 45, 46, 47}  # half hours after 7:30; 6:00 is 22.5 hours later
    assert np.mean(hours < 0.5) == pytest.approx(3 / 8, abs=0.08)
    section = evolve(PAPER, orders=4800, max_lines=1, arrivals=Arrivals("poisson", 100.0, PROFILE))
    hours = np.array([order.arrival_tick for order in generate_instance(section, seed=1).orders]) / 3_600_000
    assert set(np.floor(hours % 24).tolist()) == {6, 7}
    assert np.mean(hours < 24) == pytest.approx(0.5, abs=0.05)


def test_due_times() -> None:
    """A third has priority 1 and a minute; the others have ten minutes, two more or less."""
    due = Due(allowance_s=600, spread_s=120, priority_share=1 / 3, priority_allowance_s=60)
    orders = generate_instance(evolve(PAPER, due=due, arrivals=Arrivals("day")), seed=1).orders
    left = {0: [], 1: []}
    for order in orders:
        assert order.due_tick is not None
        left[order.priority].append((order.due_tick - order.arrival_tick) / 1000)
    assert len(left[1]) == pytest.approx(250 / 3, abs=25)
    assert set(left[1]) == {60.0}
    assert (480 <= min(left[0]) < 500, 700 < max(left[0]) <= 720) == (True, True)


def test_demand_and_lengths() -> None:
    lengths = Counter(len(lines) for lines in wanted(generate_instance(evolve(PAPER, lines=(1.0, 0.0, 3.0)), seed=1)))
    assert lengths.keys() == {1, 3}
    assert lengths[3] / 250 == pytest.approx(0.75, abs=0.08)
    small = evolve(PAPER, skus=2, skus_per_pod=1, lines=(1.0, 0.0, 3.0))
    assert {len(lines) for lines in wanted(generate_instance(small, seed=1))} == {1}
    assert sku_demand(3, SkuDemand(1.0, shift=1.0)) == pytest.approx([6 / 13, 4 / 13, 3 / 13])
    section = evolve(PAPER, lines=(0.0, 1.0), demand=SkuDemand(0.0, groups=50, together=1.0))
    pairs = Counter(frozenset(lines) for lines in wanted(generate_instance(section, seed=1)))
    alone = Counter(frozenset(lines) for lines in wanted(generate_instance(evolve(PAPER, lines=(0.0, 1.0)), seed=1)))
    assert sum(n for n in pairs.values() if n > 1) > 0.3 * 250
    assert pairs.most_common(1)[0][1] > 1
    assert len(pairs) < len(alone)
