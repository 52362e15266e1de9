"""Greedy pairs of order and station, with the parameters that POA rules share; the oracles have them at random."""

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cases import cases
from rmfs_commands.testing import check_rule, small_world
from rmfs_core.decisions import OrderAssignment
from rmfs_core.warehouse import Station, Warehouse, WarehouseView
from rmfs_rules.common_lines import CommonLines
from rmfs_rules.due import EarliestDue, LeastSlack
from rmfs_rules.first_come import FirstCome
from rmfs_rules.helpers import assign_best_pairs, lines_at, sum_per_order
from rmfs_rules.near_best_pod import NearBestPod
from rmfs_rules.pod_match import PodMatch
from rmfs_rules.workload import Workload
from standing import put_at_station

PAIRS = (PodMatch, CommonLines, FirstCome, Workload, NearBestPod)
OF_PAIRS = pytest.mark.parametrize("rule", PAIRS)
"""Rules with all of these parameters."""
OF_ORDERS = pytest.mark.parametrize("rule", [*PAIRS, EarliestDue, LeastSlack])
"""Rules with a fast lane."""
FOUR = {"1": ["a"], "2": ["a"], "3": ["a"], "4": ["a"]}


def decide(world: Warehouse, rule: Any, seed: int = 0) -> list[tuple[str, int]]:
    arguments = (WarehouseView(world), np.random.default_rng(seed))[
        : 1 if isinstance(rule, (EarliestDue, LeastSlack)) else 2
    ]
    return [(world.orders[one.order].name, one.station) for one in rule.assign_orders(*arguments)]


@OF_PAIRS
def test_of_orders_that_are_alike_one_goes_first(rule: type[Any]) -> None:
    world = small_world(FOUR, {"p": ["a"]}, capacities=[2], due_s={"3": 50, "2": 90})
    assert [name for name, _ in decide(world, rule())] == ["1", "2"]
    assert [name for name, _ in decide(world, rule(tie_break="due"))] == ["3", "2"]
    first = Counter(decide(world, rule(tie_break="random"), seed)[0][0] for seed in range(400))
    assert set(first) == set(FOUR)
    assert all(55 <= number <= 145 for number in first.values())


@OF_ORDERS
def test_a_place_is_kept_for_what_the_pod_at_the_station_completes(rule: type[Any]) -> None:
    """The pod there has `a`; of two free places one is left for such an order, and nothing else takes it."""
    orders = {"x": ["a"], "1": ["b"], "2": ["b"], "3": ["a", "b"], "4": ["a"]}
    pods = {"p": ["a"], "q": ["b"]}
    world = small_world(orders, pods, capacities=[3])
    put_at_station(world, 0, 0)
    world.assign(world.orders[0], world.stations[0], [0])
    assert {name for name, _ in decide(world, rule(fast_lane=1))} in ({"1", "4"}, {"4"})  # 4 may come before 1
    del orders["4"]
    world = small_world(orders, pods, capacities=[3])
    put_at_station(world, 0, 0)
    world.assign(world.orders[0], world.stations[0], [0])
    assert [name for name, _ in decide(world, rule(fast_lane=1))] == ["1"]


@OF_PAIRS
@cases("wrong problem", ({"tie_break": "newest"}, "'tie_break' must be in"), ({"fast_lane": -1}, "must be >= 0"))
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, Any], problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        rule(**wrong)


ORDERS = {"1": {"a": 2, "b": 1}, "2": ["c"], "3": {"a": 1, "b": 1, "c": 4}}


def view(**changes: object) -> WarehouseView:
    """Return a world of three orders of 3, 1 and 6 items; two stations for 6 and 4 items unless said otherwise."""
    settings: dict[str, object] = {"capacities": (6, 4), **changes}
    return WarehouseView(small_world(ORDERS, {"p": ["a", "b", "c"]}, **settings))  # type: ignore[arg-type]


def test_values_of_lines_are_summed_by_order() -> None:
    world = view()
    quantities = world.backlog_lines.quantity
    assert sum_per_order(world, quantities).tolist() == [3, 1, 6]
    assert sum_per_order(world, np.ones_like(quantities)).tolist() == [2, 1, 3]
    assert [quantities[lines_at(world, i)].tolist() for i in range(3)] == [[2, 1], [1], [1, 1, 4]]
    assert check_rule(PodMatch(tie_break="random", late_first=True, fast_lane=2)).findings == ()


def scores(**by_station: list[int]) -> Callable[[Station], np.ndarray]:
    return lambda station: np.array(by_station[f"s{station.id}"])


def chosen(found: list[OrderAssignment]) -> list[tuple[int, int]]:
    return [(one.order, one.station) for one in found]


@cases(
    "s0 s1 expected",
    ([0, 0, 9], [0, 0, 0], [(2, 0), (0, 1), (1, 1)]),  # the best pair first; then nothing else fits station 0
    ([1, 5, 0], [1, 1, 0], [(1, 0), (0, 1)]),  # of the tie of order 0 the station with the lower load
    ([0, 0, 0], [0, 0, 0], [(0, 0), (1, 1)]),  # all alike: the oldest order, the lowest id
    ([0, 0, 0], [0, 9, 0], [(1, 1), (0, 0)]),  # order 2 fits nowhere then
)
def test_the_best_pair_that_fits_goes_first(s0: list[int], s1: list[int], expected: list[tuple[int, int]]) -> None:
    """Scores decide, then age, load, id; an order of six items fits the empty station 0 only."""
    assert chosen(assign_best_pairs(view(), scores(s0=s0, s1=s1))) == expected


def test_scores_are_asked_for_again_where_they_changed() -> None:
    asked: list[int] = []

    def score(station: Station) -> np.ndarray:
        asked.append(station.id)
        return np.array([0, 0, 0]) if asked.count(0) < 2 else np.array([0, 7, 0])

    told: list[tuple[int, int]] = []

    def assigned(station: Station, position: int) -> list[int]:
        told.append((station.id, position))
        return [0] if len(told) == 1 else []

    assert chosen(assign_best_pairs(view(), score, assigned)) == [(0, 0), (1, 0)]
    assert asked == [0, 1, 0]
    assert told == [(0, 0), (0, 1)]


def test_nothing_to_assign() -> None:
    """Neither without orders nor without capacity is any score asked for."""

    def unasked(station: Station) -> np.ndarray:
        raise AssertionError("nothing fits")

    assert assign_best_pairs(WarehouseView(small_world({}, {"p": ["a"]})), unasked) == []
    full = small_world({"1": ["a"], "2": ["b"]}, {"p": ["a", "b"]}, capacities=(1,))
    full.assign(full.orders[0], full.stations[0], [0])
    assert assign_best_pairs(WarehouseView(full), unasked) == []
