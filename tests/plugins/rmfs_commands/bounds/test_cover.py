"""The cheapest cover, against every choice of pods there is."""

from __future__ import annotations

import random
from collections import Counter
from itertools import product

import pytest
from highspy import Highs, HighsStatus

from rmfs_commands.bounds.cover import cheapest_cover
from rmfs_commands.testing import small_instance
from rmfs_core.world import Instance


def cheapest_of_all(instance: Instance, costs: list[int]) -> int:
    """Try every choice of pods."""
    wanted = Counter[int]()
    for order in instance.orders:
        wanted.update(dict(order.lines))
    found = []
    for chosen in product((False, True), repeat=len(costs)):
        left = wanted.copy()
        for taken, pod in zip(chosen, instance.pods, strict=True):
            for sku, number in pod.contents if taken else ():
                left[sku] -= wanted[sku] if number is None else number
        if max(left.values(), default=0) <= 0:
            found.append(sum(cost for cost, taken in zip(costs, chosen, strict=True) if taken))
    return min(found)


def random_instance(rng: random.Random, *, finite: bool) -> Instance:
    """Return up to 8 pods that hold what a few orders want, finite stock mostly in several places."""
    skus = "abcdef"[: rng.randint(1, 6)]
    orders = {str(i): {sku: rng.randint(1, 3) for sku in rng.sample(skus, rng.randint(1, len(skus)))} for i in range(4)}
    pods: dict[str, dict[str, int | None]] = {str(i): {} for i in range(rng.randint(1, 8))}
    for sku in skus:
        left = sum(order.get(sku, 0) for order in orders.values())
        holders = rng.sample(sorted(pods), rng.randint(1, min(4, len(pods))))
        for pod in holders:
            pods[pod][sku] = rng.randint(1, max(left, 1)) if finite else None
        if finite:
            pods[holders[0]][sku] = max(left, 1) if rng.random() < 0.3 else pods[holders[0]][sku]
            short = left - sum(pod.get(sku) or 0 for pod in pods.values())
            pods[holders[-1]][sku] = (pods[holders[-1]][sku] or 0) + max(short, 0)
    return small_instance(orders, pods)  # type: ignore[arg-type]


@pytest.mark.parametrize("finite", [False, True])
def test_it_is_the_cheapest_of_all_choices(finite: bool) -> None:
    """Each pod at a cost of 1, and at costs of its own, some of them 0."""
    rng = random.Random(f"covers, {finite}")
    for _ in range(60):
        instance = random_instance(rng, finite=finite)
        for costs in ([1] * len(instance.pods), [rng.randint(0, 20) for _ in instance.pods]):
            found = cheapest_cover(instance, costs)
            assert (found.cost, found.how) == (cheapest_of_all(instance, costs), "optimal")


def test_stock_counts() -> None:
    """Five items of which no pod has more than two need three pods; were the stock unlimited, one would do."""
    orders = {"1": {"a": 3}, "2": {"a": 2}}
    assert cheapest_cover(small_instance(orders, {p: {"a": 2} for p in "pqrs"}), [1] * 4).cost == 3
    assert cheapest_cover(small_instance(orders, {p: ["a"] for p in "pqrs"}), [1] * 4).cost == 1


def test_what_nobody_wants_costs_nothing() -> None:
    """Neither without orders, nor for SKUs that are in no order."""
    assert cheapest_cover(small_instance({}, {"p": ["a"]}), [1]).cost == 0
    assert cheapest_cover(small_instance({"1": ["b"]}, {"p": ["a"], "q": ["b"]}), [5, 3]).cost == 3


def test_a_limit_leaves_a_bound() -> None:
    """Where the limit of nodes comes first, that is said; what was proven is no more than what a cover costs."""
    rng = random.Random("a hard cover")
    skus = [f"s{i}" for i in range(70)]
    pods = {f"p{i}": rng.sample(skus, 6) for i in range(70)} | {"rest": skus[:35], "rest 2": skus[35:]}
    instance, costs = small_instance({"1": skus}, pods), [1] * 70 + [20, 20]
    none, one, many = (cheapest_cover(instance, costs, most_nodes=nodes) for nodes in (0, 1, 10_000))
    assert (none.how, many.how) == ("as far as proven in the limit of nodes", "optimal")
    assert 0 <= none.cost <= one.cost <= many.cost
    assert one.cost > 0.8 * many.cost


@pytest.mark.parametrize("finite", [False, True])
def test_above_a_size_parts_of_pods_may_be_taken(finite: bool) -> None:
    """A bound that costs less to find: never above the cheapest cover, and mostly there."""
    rng = random.Random(f"relaxed, {finite}")
    reached = 0
    for _ in range(60):
        instance = random_instance(rng, finite=finite)
        costs = [rng.randint(0, 20) for _ in instance.pods]
        found, least = cheapest_cover(instance, costs, most_pairs=0), cheapest_of_all(instance, costs)
        assert found.how == "linear relaxation"
        assert found.cost <= least
        reached += found.cost == least
    assert reached > 30


def test_half_pods_are_dearer_than_none() -> None:
    """Three SKUs, a pod for every two of them: half of each pod holds all, at 1.5 pods, hence 2."""
    instance = small_instance({"1": ["a", "b", "c"]}, {"p": ["a", "b"], "q": ["b", "c"], "r": ["a", "c"]})
    assert cheapest_cover(instance, [1] * 3, most_pairs=0).cost == 2
    assert cheapest_cover(instance, [100] * 3, most_pairs=0).cost == 150


def test_other_solvers_of_the_process_keep_their_threads() -> None:
    """HiGHS has one pool of threads in a process, and refuses to solve with another number of them."""

    def solved_by(threads: int) -> bool:
        solver = Highs()
        solver.setOptionValue("output_flag", False)
        solver.setOptionValue("threads", threads)
        x = solver.addVariable(lb=1)
        return solver.minimize(x) == HighsStatus.kOk and solver.getObjectiveValue() == 1

    Highs.resetGlobalScheduler(True)
    instance = small_instance({"1": ["a", "b"]}, {"p": ["a"], "q": ["b"]})
    assert solved_by(2)
    assert not solved_by(1)
    assert cheapest_cover(instance, [1, 1]).cost == 2
    assert solved_by(2)
    Highs.resetGlobalScheduler(True)
