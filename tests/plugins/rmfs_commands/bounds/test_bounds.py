"""Lower bounds on pod visits and on the way of robots, and `rmfs bound`."""

import json
import random
from collections import Counter
from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pytest
from attrs import evolve
from highspy import Highs, HighsStatus

from calling import exit_code, refused
from cases import cases
from rmfs_commands.bounds import BOUNDED, bounds_of, find_bounds
from rmfs_commands.bounds.cover import cheapest_cover
from rmfs_commands.bounds.ways import find_ways
from rmfs_commands.cli.main import main
from rmfs_commands.details.slots import Servers, shortest_remaining_first
from rmfs_commands.layouts import parse_map
from rmfs_commands.testing import small_instance, small_layout
from rmfs_core import Scenario, run
from rmfs_core.clock import UNREACHABLE
from rmfs_core.motion import Motion
from rmfs_core.scenario import scenario_from_dict
from rmfs_core.scenario.model import (
    Arrivals,
    InstanceSection,
    PackingSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    RunSection,
    StationsSection,
)
from rmfs_core.world import Instance, Layout
from rmfs_core.world.travel import travel_on

LANE = parse_map("#.....qO\n#..@@...", "lane")
"""Two storage locations, 7 and 8 m from the station: 6.167 s, and 8.167 s and a turn, with a pod. 9 m back."""

ONE_ROBOT = Scenario(
    rules=RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand")),
    robots=RobotsSection(count=1),
    stations=StationsSection(release="picked"),
)
TWO_ORDERS = small_instance({"1": ["a"], "2": {"b": 2}}, {"p": ["a"], "q": ["b"]})


def values(scenario: Scenario, instance: Instance) -> dict[str, float | None]:
    found = {bound.metric: bound.value for bound in find_bounds(scenario, instance, LANE)}
    assert tuple(found) == BOUNDED[: 9 if scenario.packing else 8]
    return found


def test_two_orders_by_hand() -> None:
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

    The robot starts at the other location, 1 m away, and turns once on its way to the station.

    Of orders that arrive so far apart that the pickers are never behind, each takes its pick of 7 s.
    """
    lone, fetch_s = {str(i): ["a"] for i in range(1, 22)}, 2.625
    assert values(ONE_ROBOT, small_instance(lone, {"p": ["a"]}))["turnover_p95_s"] == pytest.approx(
        fetch_s + 17.367 + 19 * 13
    )
    apart = small_instance(lone, {"p": ["a"]}, arrivals_s={str(i): 100 * i for i in range(1, 22)})
    assert values(ONE_ROBOT, apart)["turnover_p95_s"] == 7.0


def test_robots_and_the_last_arrival() -> None:
    assert values(evolve(ONE_ROBOT, robots=RobotsSection(count=2)), TWO_ORDERS)["distance_m"] == 15
    late = small_instance({"1": ["a"], "2": {"b": 2}}, {"p": ["a"], "q": ["b"]}, arrivals_s={"2": 100})
    found = values(ONE_ROBOT, late)
    assert found["makespan_s"] == 120.0
    assert found["turnover_s"] == pytest.approx((15.367 + 20) / 2)
    two_stations = parse_map("#.....qO\n#..@@...\n@.@@@..@\n@......qO\n@.@@@....", "two stations")
    lone = small_instance({"1": {"a": 40}}, {"p": ["a"]})
    found = {bound.metric: bound.value for bound in find_bounds(ONE_ROBOT, lone, two_stations)}
    with_two = evolve(ONE_ROBOT, robots=RobotsSection(count=2))
    faster = {bound.metric: bound.value for bound in find_bounds(with_two, lone, two_stations)}
    assert found["makespan_s"] - 40 * 13 == pytest.approx(7, abs=2)  # a way to the other station takes more than 6 s
    assert faster["makespan_s"] < 20 * 13 + 12


def test_a_pod_at_the_station_need_not_come() -> None:
    """It is picked from at once, and drives nowhere; the other one is 8 m away, or 7, and is fetched by this robot."""
    there = evolve(ONE_ROBOT, instance=InstanceSection(pods_at_stations={"1": ("p",)}))
    found = values(there, TWO_ORDERS)
    assert (found["turnover_s"], found["pod_station_visits"]) == ((7 + 33) / 2, 2)
    assert found["distance_m"] in (7 + 9, 8 + 9)


def test_what_is_before_the_warm_up_counts_for_nothing() -> None:
    warm = evolve(ONE_ROBOT, run=RunSection(warmup_s=50))
    found = values(warm, small_instance({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, arrivals_s={"2": 100}))
    assert {metric for metric, value in found.items() if value is None} == {*BOUNDED[:5]}
    assert (found["turnover_s"], found["makespan_s"]) == (7.0, 107.0)
    later = {"1": 60, "2": 60}
    found = values(warm, small_instance({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, arrivals_s=later))
    assert found["pod_station_visits"] == 2
    assert values(warm, TWO_ORDERS)["turnover_s"] is None


def test_where_stock_is_replenished_or_moved_pods_may_come() -> None:
    stored = evolve(ONE_ROBOT, stations=evolve(ONE_ROBOT.stations, also_replenish=True))
    found = values(stored, evolve(small_instance({"1": ["a"], "2": {"b": 2}}, {"p": ["c"]}), restocked=True))
    assert {metric for metric, value in found.items() if value is None} == {*BOUNDED[:5]}
    assert (found["turnover_s"], found["makespan_s"]) == ((7 + 33) / 2, 33.0)
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
    arrivals = Arrivals("refill", backlog=1)
    refilled = evolve(ONE_ROBOT, instance=evolve(ONE_ROBOT.instance, arrivals=arrivals))
    found, before = values(refilled, TWO_ORDERS), values(ONE_ROBOT, TWO_ORDERS)
    assert (found["turnover_s"], found["turnover_p95_s"]) == (None, None)
    assert found["makespan_s"] == before["makespan_s"]
    found = values(ONE_ROBOT, small_instance({}, {"p": ["a"]}))
    nothing = {"psv_per_order": None, "distance_per_order_m": None, "turnover_s": None, "turnover_p95_s": None}
    assert found == dict.fromkeys(BOUNDED[:8], 0) | nothing
    packing = evolve(ONE_ROBOT, packing=PackingSection())
    assert values(packing, small_instance({}, {"p": ["a"]}))["packed_makespan_s"] == 0


@pytest.mark.parametrize(("packers", "work_s"), [(1, 75), (2, 37.5)])
def test_packers_bound_the_makespan_to_packed(packers: int, work_s: float) -> None:
    """By hand: a pod is lifted, driven 7 m, an item handled and conveyed; the orders take 35 and 40 s to pack."""
    packing = PackingSection(packers=packers, conveyor_s=10.0)
    found = values(evolve(ONE_ROBOT, packing=packing), TWO_ORDERS)
    first = 2.2 + 6.167 + 13 + 10
    assert found["packed_makespan_s"] == pytest.approx(max(first + work_s, (found["makespan_s"] or 0) + 10 + 35))


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
    times: dict[str, Any] = {"handle_s": handle_s, "pick_s": rng.choice((handle_s, 1.0))}
    if rng.random() < 0.4:  # they vary
        times = {key: {"mean": mean, "cv": rng.choice((0.5, 1.0))} for key, mean in times.items()}
        times |= {"line_s": 1.5, "order_s": {"times": [1.0, 4.0]}, "speed": {"1": rng.choice((0.8, 1.3))}}
    return scenario_from_dict(
        {
            "seed": rng.randint(0, 99_999),
            "instance": instance,
            "layout": {"block_rows": 5, "block_columns": 2, "stations_east": stations, "hall_width": 2},
            "robots": robots | quick if rng.random() < 0.3 else robots,
            "stations": {**times, "queue_length": 2, "release": rng.choice(("picked", "handled"))},
            "rules": {**rules, "pp": "free-flow"},
            "run": {"warmup_s": 60.0} if rng.random() < 0.2 else {},
        },
        ".",
        "a random world",
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", RULES)
def test_no_run_beats_a_bound(name: str) -> None:
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


def cheapest_of_all(instance: Instance, costs: list[int]) -> int:
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


def test_a_limit_leaves_a_bound() -> None:
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
    instance = small_instance({"1": ["a", "b", "c"]}, {"p": ["a", "b"], "q": ["b", "c"], "r": ["a", "c"]})
    assert cheapest_cover(instance, [1] * 3, most_pairs=0).cost == 2
    assert cheapest_cover(instance, [100] * 3, most_pairs=0).cost == 150


def test_other_solvers_of_the_process_keep_their_threads() -> None:
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


def array(*values: int) -> np.ndarray:
    return np.array(values, dtype=np.int64)


def all_ways(servers: Servers, items: list[int], arrivals: list[int]) -> Iterator[list[int]]:
    """Yield the completions of the orders, ascending, for each order of items and each choice of who serves which."""

    def serve(left: tuple[int, ...], free: tuple[int, ...], done: tuple[int, ...]) -> Iterator[list[int]]:
        if not any(left):
            yield sorted(done)
        for order in range(len(left)):
            for server in range(len(free)) if left[order] else ():
                start = max(free[server], arrivals[order])
                yield from serve(
                    (*left[:order], left[order] - 1, *left[order + 1 :]),
                    (*free[:server], start + servers.spacing, *free[server + 1 :]),
                    (*done[:order], max(done[order], start + servers.lasts), *done[order + 1 :]),
                )

    yield from serve(tuple(items), tuple(int(tick) for tick in servers.opens), (0,) * len(items))


def test_servers_by_hand() -> None:
    two = Servers(array(0, 5), 10, 4)
    assert two.last_done(array(1, 2, 3, 4, 5), 0).tolist() == [4, 9, 14, 19, 24]
    assert two.last_done(array(1, 2, 3), array(12, 12, 12)).tolist() == [16, 16, 26]
    assert two.last_done(array(2), array(3)).tolist() == [9]
    assert shortest_remaining_first(array(0, 1, 2), array(5, 2, 1)).tolist() == [3, 4, 8]
    assert shortest_remaining_first(array(10, 0), array(1, 2)).tolist() == [2, 11]
    assert Servers(array(0, 0), 10, 4).completions(array(4, 1, 2), array(0, 0, 0)).tolist() == [4, 14, 34]
    three = Servers(array(0, 0, 0), 10, 4)
    assert three.completions(array(1, 7), array(100, 1000)).tolist() == [104, 1024]


def test_no_way_to_serve_is_faster() -> None:
    rng = random.Random("ways to serve")
    reached = 0
    for _ in range(60):
        spacing = rng.randint(1, 12)
        servers = Servers(
            np.sort(array(*(rng.choice((0, 0, 7, 15)) for _ in range(2)))), spacing, rng.randint(1, spacing + 6)
        )
        items = [rng.randint(1, 2) for _ in range(rng.randint(1, 3))]
        arrivals = [rng.choice((0, 0, 5, 20, 40)) for _ in items]
        bound = servers.completions(array(*items), array(*arrivals))
        ways = np.array(list(all_ways(servers, items, arrivals)))
        assert (ways.min(axis=0) >= bound).all()
        together = servers.last_done(array(sum(items)), min(arrivals))[0]
        assert ways[:, -1].min() >= together
        reached += bool((ways.min(axis=0) == bound).all())
    assert reached > 30


def test_drives_by_hand_and_none_shorter() -> None:
    ways = find_ways(travel_on(LANE, Motion()), LANE.storage_locations[:1])
    north, south = LANE.storage_locations
    assert ways.metres[0, [north, south]].tolist() == [7, 8]
    assert ways.ticks[0, [north, south]].tolist() == [6167, 6167 + 625 + 2000]
    assert ways.fetch_ticks[[north, south]].tolist() == [0, 2000]
    assert ways.back_m == 9
    layout = small_layout(2)
    travel = travel_on(layout, Motion())
    ways = find_ways(travel, [0])
    for station, cells in enumerate(layout.stations):
        driven = travel.times_to(cells.station, True).min(axis=1)
        assert (ways.ticks[station] <= driven).all()
        assert (driven[list(layout.storage_locations)] < UNREACHABLE).all()
    assert all(ways.metres[0, cell] <= metres for cell, metres in distances_driven(layout))
    assert np.median([ways.metres[0, cell] / metres for cell, metres in distances_driven(layout)]) > 0.75


def distances_driven(layout: Layout) -> list[tuple[int, int]]:
    travel, station = travel_on(layout, Motion()), layout.stations[0].station
    found = []
    for cell in layout.storage_locations:
        at, metres = cell, 0
        for leg in travel.fastest_path(cell, 1, station, loaded=True):
            metres += layout.distance(at, leg.to)
            at = leg.to
        found.append((cell, metres))
    return found


bound_command = partial(exit_code, "bound")


def test_tables_and_json(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    assert bound_command("examples/small", "--set", "instance.orders=5") == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.split()[:3] == ["Pod-station", "visits", "2"] and "set cover, optimal" in line for line in lines)
    assert any(line.split()[:5] == ["Turn-over", "time,", "p95", "48.61", "s"] for line in lines)
    assert any(line.split()[:4] == ["Makespan", "61.61", "s", "pickers"] for line in lines)

    def bounds(*arguments: str) -> dict[str, float]:
        assert bound_command("examples/small", "--set", "instance.orders=20", "--json", *arguments) == 0
        return {one["metric"]: one["value"] for one in json.loads(capsys.readouterr().out)["bounds"]}

    assert bounds() == bounds("--set", "rules.poa_pps=split-over-time") != bounds("--seed", "2")
    assert bound_command("examples/small", "--set", "instance.orders=5", "--set", "run.warmup_s=60") == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "Visits per order - none: what happens before run.warmup_s does not count" in out


@cases(
    "arguments sentence",
    (("examples/small", "--set", "instance.pods=1000"), "1000 pods, but the layout has"),
    (("examples/from-csv", "--set", 'instance.pods_at_stations={"1"=["none"]}'), "there is no pod none"),
)
def test_wrong_input_is_one_sentence(arguments, sentence, capsys) -> None:
    assert sentence in refused(capsys, main, ["bound", *arguments])
