"""Bounds by hand, and runs of shipped rules that never beat them."""

from __future__ import annotations

import random
from typing import Any

import pytest
from attrs import evolve

from rmfs_commands.bounds import BOUNDED, bounds_of, find_bounds
from rmfs_commands.testing import small_instance
from rmfs_core import Scenario, run
from rmfs_core.scenario import scenario_from_dict
from rmfs_core.scenario.model import (
    Arrivals,
    InstanceSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    RunSection,
    StationsSection,
)
from rmfs_core.world import Instance, parse_map

LANE = parse_map("#.....qO\n#..@@...", "lane")
"""Two storage locations, 7 and 8 m from the station: 6.167 and 8.167 s with a pod. 9 m back."""

ONE_ROBOT = Scenario(
    rules=RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand")),
    robots=RobotsSection(count=1),
    stations=StationsSection(release="picked"),
)
TWO_ORDERS = small_instance({"1": ["a"], "2": {"b": 2}}, {"p": ["a"], "q": ["b"]})


def values(scenario: Scenario, instance: Instance) -> dict[str, float | None]:
    """Return the bounds by metric."""
    found = {bound.metric: bound.value for bound in find_bounds(scenario, instance, LANE)}
    assert tuple(found) == BOUNDED
    return found


def test_by_hand() -> None:
    """One pod for each of two orders; the robot stores the first to fetch the second: 7 + 8 + 9 m.

    A pod is at the station after lift and drive, 2.2 + 6.167 s. Its pick ends 7 s later, the last of three, 26 s after.
    """
    found = values(ONE_ROBOT, TWO_ORDERS)
    assert found == pytest.approx(
        {
            "pod_station_visits": 2,
            "psv_per_order": 1.0,
            "distance_m": 24,
            "loaded_distance_m": 24,
            "distance_per_order_m": 12.0,
            "turnover_s": (15.367 + 41.367) / 2,
            "turnover_p95_s": 15.367,  # between the two, hence not below the smaller one
            "makespan_s": 41.367,
        }
    )


def test_a_percentile_leaves_out_one_in_twenty() -> None:
    """Of 21 orders of an item one may take as long as it likes: the 20th is complete 19 times 13 s after the first.

    Of orders that arrive so far apart that the pickers are never behind, each takes its pick of 7 s.
    """
    lone = {str(i): ["a"] for i in range(1, 22)}
    assert values(ONE_ROBOT, small_instance(lone, {"p": ["a"]}))["turnover_p95_s"] == pytest.approx(17.367 + 19 * 13)
    apart = small_instance(lone, {"p": ["a"]}, arrivals_s={str(i): 100 * i for i in range(1, 22)})
    assert values(ONE_ROBOT, apart)["turnover_p95_s"] == 7.0


def test_more_robots_bring_no_pod_back() -> None:
    """With two robots both pods may be at the station, or on their way, when the run ends."""
    assert values(evolve(ONE_ROBOT, robots=RobotsSection(count=2)), TWO_ORDERS)["distance_m"] == 15


def test_the_last_arrival_counts() -> None:
    """An order of two items that arrives at 100 s, when a pod may be at the station: 13 + 7 s more."""
    late = small_instance({"1": ["a"], "2": {"b": 2}}, {"p": ["a"], "q": ["b"]}, arrivals_s={"2": 100})
    found = values(ONE_ROBOT, late)
    assert found["makespan_s"] == 120.0
    assert found["turnover_s"] == pytest.approx((15.367 + 20) / 2)


def test_robots_can_be_the_bottleneck() -> None:
    """One robot, two stations: it holds one pod at a time, for 7 s an item, though two pickers would take 6.5 s."""
    two_stations = parse_map("#.....qO\n#..@@...\n@.@@@..@\n@......qO\n@.@@@....", "two stations")
    lone = small_instance({"1": {"a": 40}}, {"p": ["a"]})
    found = {bound.metric: bound.value for bound in find_bounds(ONE_ROBOT, lone, two_stations)}
    with_two = evolve(ONE_ROBOT, robots=RobotsSection(count=2))
    faster = {bound.metric: bound.value for bound in find_bounds(with_two, lone, two_stations)}
    assert found["makespan_s"] - 40 * 7 == pytest.approx(8.5, abs=2)
    assert faster["makespan_s"] < 20 * 13 + 12


def test_a_pod_at_the_station_need_not_come() -> None:
    """It is picked from at once, and drives nowhere; the other one is 8 m away, or 7, and is fetched by this robot."""
    there = evolve(ONE_ROBOT, instance=InstanceSection(pods_at_stations={"1": ("p",)}))
    found = values(there, TWO_ORDERS)
    assert found["turnover_s"] == (7 + 33) / 2
    assert found["pod_station_visits"] == 2
    assert found["distance_m"] in (7 + 9, 8 + 9)


def test_what_is_before_the_warm_up_counts_for_nothing() -> None:
    """Visits and metres may be before it. Turn-over is that of orders that arrive after it; the makespan is of all."""
    warm = evolve(ONE_ROBOT, run=RunSection(warmup_s=50))
    found = values(warm, small_instance({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, arrivals_s={"2": 100}))
    assert {metric for metric, value in found.items() if value is None} == {*BOUNDED[:5]}
    assert (found["turnover_s"], found["makespan_s"]) == (7.0, 107.0)
    later = {"1": 60, "2": 60}
    found = values(warm, small_instance({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, arrivals_s=later))
    assert found["pod_station_visits"] == 2
    assert values(warm, TWO_ORDERS)["turnover_s"] is None


def test_where_stock_is_replenished_pods_may_come_to_hold_anything() -> None:
    """Orders may want what is on no pod yet; whatever the rules, one visit may do, and its pod may be there at once."""
    stored = evolve(ONE_ROBOT, stations=evolve(ONE_ROBOT.stations, also_replenish=True))
    found = values(stored, evolve(small_instance({"1": ["a"], "2": {"b": 2}}, {"p": ["c"]}), restocked=True))
    assert {metric for metric, value in found.items() if value is None} == {*BOUNDED[:5]}
    assert (found["turnover_s"], found["makespan_s"]) == ((7 + 33) / 2, 33.0)


def test_pods_may_be_moved_before_an_order_comes() -> None:
    """Nothing is lost of visits and metres unless what is before the warm-up does not count."""
    moving = evolve(ONE_ROBOT, rules=evolve(ONE_ROBOT.rules, move=RuleChoice("utility")))
    late = small_instance({"1": ["a"]}, {"p": ["a"], "q": ["b"]}, arrivals_s={"1": 100})
    found, before = values(moving, late), values(ONE_ROBOT, late)
    assert (found["distance_m"], found["makespan_s"]) == (before["distance_m"], 107.0)
    warm = values(evolve(moving, run=RunSection(warmup_s=50)), late)
    assert {metric for metric, value in warm.items() if value is None} == {*BOUNDED[:5]}


def test_orders_end_when_their_items_are_handled() -> None:
    """Where that is when places are given back: what is left to handle after a pick, 6 s, is not taken off."""
    handled = evolve(ONE_ROBOT, stations=evolve(ONE_ROBOT.stations, release="handled"))
    picked, later = values(ONE_ROBOT, TWO_ORDERS), values(handled, TWO_ORDERS)
    for metric in ("turnover_s", "turnover_p95_s", "makespan_s"):
        assert later[metric] == pytest.approx((picked[metric] or 0) + 6)


def test_a_refilled_backlog_bounds_no_turn_over() -> None:
    """Orders may come when they are assigned; all else holds, as if all were there at the start."""
    arrivals = Arrivals("refill", backlog=1)
    refilled = evolve(ONE_ROBOT, instance=evolve(ONE_ROBOT.instance, arrivals=arrivals))
    found, before = values(refilled, TWO_ORDERS), values(ONE_ROBOT, TWO_ORDERS)
    assert (found["turnover_s"], found["turnover_p95_s"]) == (None, None)
    assert found["makespan_s"] == before["makespan_s"]


def test_without_orders() -> None:
    """Nothing need be done, and there is nothing to divide by."""
    found = values(ONE_ROBOT, small_instance({}, {"p": ["a"]}))
    nothing = {"psv_per_order": None, "distance_per_order_m": None, "turnover_s": None, "turnover_p95_s": None}
    assert found == dict.fromkeys(BOUNDED, 0) | nothing


RULES: dict[str, dict[str, str]] = {
    "demand": {"poa": "pod-match", "pps": "demand"},
    "completes": {"poa": "common-lines", "pps": "completes"},
    "nearest-pod": {"poa": "first-come", "pps": "nearest-pod"},
    "random": {"poa": "near-best-pod", "pps": "random"},
    "pod-index": {"poa_pps": "pod-index"},
    "integrated": {"poa_pps": "integrated"},
    "split-among-stations": {"poa_pps": "split-among-stations"},
    "split-over-time": {"poa_pps": "split-over-time"},
}


def random_world(rng: random.Random, rules: dict[str, str]) -> Scenario:
    """Return a tiny scenario: finite stock, arrivals, pods at stations, quick robots, warm-up, each now and then."""
    stations, handle_s, skus = rng.randint(1, 2), rng.choice((3.0, 13.0)), rng.randint(3, 8)
    instance: dict[str, Any] = {"orders": rng.randint(1, 12), "skus": skus, "pods": 8, "max_lines": rng.randint(1, 4)}
    instance |= {"skus_per_pod": rng.randint(1, 3)}
    if rng.random() < 0.4:
        instance |= {"items_per_sku": 20}
    if rng.random() < 0.4:
        instance["arrivals"] = {"process": "poisson", "orders_per_hour": rng.choice((60, 300, 1500))}
    elif rng.random() < 0.2:
        instance["arrivals"] = {"process": "refill", "backlog": rng.randint(1, 6)}
    if rng.random() < 0.3:
        instance["pods_at_stations"] = {"1": ["1"], str(stations): ["1", "2"] if stations == 1 else ["2"]}
    robots = {"count": rng.randint(2, 5)}
    quick = {"lift_s": 0.0, "full_turn_s": 0.1, "top_speed_m_per_s": 5.0, "acceleration_m_per_s2": 20.0}
    return scenario_from_dict(
        {
            "seed": rng.randint(0, 99_999),
            "instance": instance,
            "layout": {"block_rows": 5, "block_columns": 2, "stations_east": stations, "hall_width": 2},
            "robots": robots | quick if rng.random() < 0.3 else robots,
            "stations": {
                "queue_length": 2,
                "handle_s": handle_s,
                "pick_s": rng.choice((handle_s, 1.0)),
                "release": rng.choice(("picked", "handled")),
            },
            "rules": {**rules, "pp": "free-flow"},
            "run": {"warmup_s": 60.0} if rng.random() < 0.2 else {},
        },
        ".",
        "a random world",
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", RULES)
def test_no_run_beats_a_bound(name: str) -> None:
    """Random tiny worlds under eight sets of shipped rules: no figure is below its bound; some are not far above."""
    rng = random.Random(f"worlds of {name}")
    nearest = dict.fromkeys(BOUNDED, 99.0)
    for _ in range(6):
        scenario = random_world(rng, RULES[name])
        bounds = {bound.metric: bound.value for bound in bounds_of(scenario)}
        figures = run(scenario).metrics
        for metric, least in bounds.items():
            figure = figures[metric]
            if least is not None and figure is not None:
                assert figure >= least, (metric, scenario)
                nearest[metric] = min(nearest[metric], figure / least) if least else nearest[metric]
    assert nearest["makespan_s"] < 2
    assert nearest["pod_station_visits"] < 3
