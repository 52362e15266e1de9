"""Joint rules alternating, two-stage, lns and pod-index; test_oracles.py has what they decide."""

from collections.abc import Callable
from functools import cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

import numpy as np
import pytest
from attrs import evolve

import rmfs_rules.pod_index
from cases import cases
from rmfs_commands.testing import check_rule, small_instance, small_world
from rmfs_core import JointDecision, run
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.joint import Alternating, LargeNeighborhoodSearch, TwoStage
from rmfs_rules.mip import Integrated
from rmfs_rules.pod_index import PodIndex
from standing import put_at_station


@cases(
    "rule",
    Alternating(rounds=1, max_wait_s=60, unused_capacity_weight=0.5),
    TwoStage(first_share=0.2, max_wait_s=60),
    TwoStage(first_orders="oldest"),
    LargeNeighborhoodSearch(max_wait_s=60, share=1.0, iterations=5, unused_capacity_weight=0.5),
    PodIndex(packing_capacity=1),
    PodIndex(urge_s=0, most_pods=1, elsewhere=0),
)
def test_it_conforms(rule: object) -> None:
    check_rule(rule)


@cases(
    "rule wrong",
    (Alternating, {"rounds": 0}),
    (Alternating, {"unused_capacity_weight": 0}),
    (Alternating, {"max_wait_s": -1}),
    (TwoStage, {"first_share": 0}),
    (TwoStage, {"first_share": 1.5}),
    (TwoStage, {"first_orders": "best"}),
    (LargeNeighborhoodSearch, {"iterations": -1}),
    (LargeNeighborhoodSearch, {"share": 0}),
    (LargeNeighborhoodSearch, {"share": 1.1}),
    (LargeNeighborhoodSearch, {"unused_capacity_weight": 0}),
)
def test_bad_parameters(rule: type[Any], wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        rule(**wrong)


def random_world(seed: int) -> Warehouse:
    """Return a small world in the middle of a run: pods bound for stations, some orders assigned, stock often scarce.

    Every order fits a station, and all pods together have what all orders want.
    """
    rng = np.random.default_rng(seed)
    skus, n_pods = "abcdef", int(rng.integers(2, 7))
    most, finite = (3 if seed % 3 == 0 else 1), seed % 2 == 0
    orders = {
        str(i): {str(sku): int(rng.integers(1, most + 1)) for sku in rng.choice([*skus], rng.integers(1, 4), False)}
        for i in range(int(rng.integers(1, 9)))
    }
    pods: dict[str, dict[str, int | None]] = {f"p{i}": {} for i in range(n_pods)}
    for sku in skus:
        holders = rng.choice(n_pods, rng.integers(1, min(n_pods, 3) + 1), False)
        wanted = sum(order.get(sku, 0) for order in orders.values())
        for number, pod in enumerate(holders.tolist()):
            pods[f"p{pod}"][sku] = (wanted + number) // len(holders) + 1 if finite else None
    capacities = rng.integers(9, 12, rng.integers(1, 4)) if most > 1 else rng.integers(3, 7, rng.integers(1, 4))
    held = {name: contents for name, contents in pods.items() if contents}
    world = small_world(orders, held, capacities=capacities.tolist(), counts_orders=seed % 5 == 0)
    for station in world.stations:
        for pod in rng.choice(len(held), rng.integers(0, min(len(held), 2) + 1), False).tolist():
            world.bind(world.pods[pod], station)
    return world


def apply(world: Warehouse, decision: JointDecision) -> None:
    """Carry a decision out; fail where the kernel would refuse it."""
    for trip in decision.trips:
        assert trip.station not in world.pods[trip.pod].bound_for
        world.bind(world.pods[trip.pod], world.stations[trip.station])
    for pair in decision.assignments:
        order, station = world.orders[pair.order], world.stations[pair.station]
        assert world.size_at(order, station) <= station.free_capacity
        world.assign(order, station, [line.sku for line in order.open_lines])
    for trip in decision.trips:
        wanted = {request.sku for request in world.stations[trip.station].open_requests}
        assert wanted & world.pods[trip.pod].contents.keys()
    assert not [request for station in world.stations for request in station.uncovered_requests]


def missed(decide: Callable[[WarehouseView, int], JointDecision]) -> list[float]:
    """Decide random periods, (view, seed); return by how much each misses the optimum.

    The objective that a decision reports is worked out anew: visits, and two for every free slot.
    """
    missed = []
    for seed in range(60):
        world = random_world(seed)
        visits = sum(len(station.inbound_pods) for station in world.stations)
        decision = decide(WarehouseView(world), seed)
        largest = max(order.items for order in world.orders) if world.stations[0].counts_orders else 1
        apply(world, decision)
        free = sum(station.free_capacity for station in world.stations)
        objective = visits + len(decision.trips) + 2 * largest * free
        assert decision.report is None or decision.report.objective == objective
        missed.append(objective - optimum(seed))
    return missed


@cache
def optimum(seed: int) -> float:
    """Return the least objective of a random period, by the model as it is printed."""
    rule = Integrated(formulation="paper")
    report = rule.assign_orders_and_pods(WarehouseView(random_world(seed)), np.random.default_rng()).report
    assert report.objective is not None
    return report.objective


def test_more_rounds_cost_no_more() -> None:
    """On random periods; some are improved, and most are decided as well as the model does."""
    one, more = (
        missed(lambda view, seed, rounds=rounds: Alternating(rounds=rounds).assign_orders_and_pods(view))
        for rounds in (1, 10)
    )
    assert all(later <= earlier for earlier, later in zip(one, more, strict=True))
    assert sum(more) < sum(one)
    assert min(more) == 0
    assert sum(more) / len(more) < 1


def test_two_stages_are_never_below_the_optimum() -> None:
    """On random periods, where the kernel would take each decision; with the whole capacity it is close."""
    whole, half = (
        missed(lambda view, seed, share=share: TwoStage(first_share=share).assign_orders_and_pods(view))
        for share in (1.0, 0.5)
    )
    assert min(whole) == min(half) == 0
    assert sum(whole) / len(whole) < 2


def test_it_costs_less_with_the_iterations_and_is_never_below_the_optimum() -> None:
    """On random periods, where the kernel would take each decision; with none it is that of alternating."""

    def after(iterations: int) -> list[float]:
        rule = LargeNeighborhoodSearch(iterations=iterations)
        return missed(lambda view, seed: rule.assign_orders_and_pods(view, np.random.default_rng(seed)))

    results = [after(iterations) for iterations in (0, 5, 50)]
    assert results[0] == missed(lambda view, seed: Alternating().assign_orders_and_pods(view))
    for fewer, more in pairwise(results):
        assert all(later <= earlier for earlier, later in zip(fewer, more, strict=True))
        assert sum(more) < sum(fewer)
    assert min(results[-1]) == 0
    assert results[-1].count(0) >= 54


def decide(
    world: Warehouse, **parameters: float
) -> tuple[list[tuple[str, int, tuple[int, ...]]], list[tuple[str, int]]]:
    decision = PodIndex(**parameters).assign_orders_and_pods(WarehouseView(world))  # type: ignore[arg-type]
    return (
        [(world.orders[one.order].name, one.station, tuple(one.skus or ())) for one in decision.assignments],
        [(world.pods[one.pod].name, one.station) for one in decision.trips],
    )


def test_nothing_is_compiled_once_a_run_has_begun() -> None:
    """Prepared functions are those that decisions call, also with whole numbers for seconds and shares."""
    modules = [
        import_module(f"rmfs_rules.pod_index.{found.name}") for found in iter_modules(rmfs_rules.pod_index.__path__)
    ]
    searches = [called for module in modules for called in vars(module).values() if hasattr(called, "signatures")]
    PodIndex().prepare(small_world({"1": ["a"]}, {"p": ["a"]}).travel)
    before = [len(search.signatures) for search in searches]
    whole = [f"rules.poa_pps.{name}={value}" for name, value in {"visit_s": 300, "finish": 1, "due_factor": 1}.items()]
    run("examples/small", overrides=["rules.poa_pps=pod-index", *whole])
    assert any(before)
    assert [len(search.signatures) for search in searches] == before


def test_the_pod_that_finishes_orders_goes_first() -> None:
    """Each pod would bring two lines; those of q are whole orders, those of p are halves."""
    orders = {"1": ["a", "x"], "2": ["b", "y"], "3": ["c"], "4": ["d"]}
    world = small_world(orders, {"p": ["a", "b"], "q": ["c", "d"], "r": ["x", "y"]}, capacities=[2])
    c, d = world.orders[2].lines[0].sku, world.orders[3].lines[0].sku
    assert decide(world, most_pods=1) == ([("3", 0, (c,)), ("4", 0, (d,))], [("q", 0)])


def test_a_line_that_would_need_a_visit_of_its_own_goes_first() -> None:
    """Of two pods at a station one has three lines, the other one: that would have to come again for it alone."""
    world = small_world({"1": ["a"], "2": ["a"], "3": ["a"], "4": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[1])
    put_at_station(world, 0, 0)
    put_at_station(world, 1, 0)
    assert [[name for name, *_ in decide(world, again=share)[0]] for share in (0, 0.3)] == [["1"], ["4"]]


def waiting(capacities: list[int]) -> Warehouse:
    """Two orders, the second of which comes a second later, and a pod for each."""
    wanted: tuple[Any, Any] = {"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}
    plain, instance = small_world(*wanted, capacities=capacities), small_instance(*wanted)
    orders = (instance.orders[0], evolve(instance.orders[1], arrival_tick=1000))
    world = Warehouse(evolve(instance, orders=orders), plain.travel, plain.stations, plain.robots, plain.homes)
    for order in world.orders:
        world.order_arrives(order)
    world.now = 1000
    return world


def test_pods_wait_until_it_pays() -> None:
    """While a station has one item to pick, a pod for one line that came at 1 s is not sent; at 191 s it is."""

    def trips(now_s: float) -> list[tuple[str, int]]:
        world = waiting([2])
        put_at_station(world, 0, 0)
        world.assign(world.orders[0], world.stations[0], [0])
        world.now = round(1000 * now_s)
        assert PodIndex(urge_s=100, full=3).wake_at(WarehouseView(world)) == (191.0 if now_s < 191 else None)
        return decide(world, urge_s=100.0, base_s=10.0, full=3.0)[1]

    assert trips(1.5) == []
    assert trips(190.999) == []
    assert trips(191.0) == [("q", 0)]


def test_a_pod_is_sent_when_it_is_urgent_and_not_when_something_happens(tmp_path: Path) -> None:
    """A whole run: the second order comes at 10 s; a pick that takes 1,000 s is all that happens around 200 s."""
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,a,1\n2,10,b,1\n", encoding="utf-8")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,a,9\nq,b,9\n", encoding="utf-8")
    files = [f"instance.{kind}_file={tmp_path / kind}.csv" for kind in ("orders", "pods")]
    slow = ["stations.pick_s=1000", "stations.handle_s=1000", "rules.pp=free-flow", "rules.poa_pps=pod-index"]
    slow.append("rules.poa_pps.urge_s=200")
    _, second = run("examples/from-csv", overrides=[*files, *slow]).orders
    assert second["turnover_backlog_s"] == 190.0


def test_lines_that_several_pods_bring() -> None:
    world = small_world({"1": {"a": 4}}, {"p": {"a": 1}, "q": {"a": 2}, "r": {"a": 2}}, capacities=[5])
    taken, trips = decide(world)
    assert taken == [("1", 0, (0,))]
    assert sorted(trips) == [("q", 0), ("r", 0)]
    orders = {"1": {"a": 40, "c": 20}, "2": {"b": 30}}
    pods = {name: {"a": 12, "b": 10} if name in "pqr" else {"a": 10, "c": 10} for name in "pqrstuv"}
    taken, trips = decide(small_world(orders, pods, capacities=[60]), most_pods=1)
    assert taken == [("1", 0, (0,))]
    assert [name for name, _ in trips[:3]] == ["p", "q", "r"]
    assert len(trips) == 4
    pods = {"p": {"a": 2}, "q": {"b": 1, "z": 9}, "r": {"a": 3, "b": 4}}
    world = small_world({"1": {"a": 5, "b": 5}}, pods, capacities=[4])
    assert decide(world) == ([("1", 0, ())], [("r", 0), ("p", 0), ("q", 0)])
    put_at_station(world, 2, 0)
    assert decide(world) == ([("1", 0, ())], [("p", 0), ("q", 0)])
    assert decide(small_world({"1": {"a": 5, "b": 6}}, pods, capacities=[4])) == ([], [])


@pytest.mark.parametrize("parameters", [{}, {"packing_capacity": 1}])
def test_a_line_of_more_items_than_a_station_takes_goes_to_an_empty_one(parameters: dict[str, Any]) -> None:
    """Both pods are sent for it; the other line of an order, which fits, goes first."""
    pods = {"p": {"a": 2, "b": 1}, "q": {"a": 2}}
    world = small_world({"1": {"a": 4}}, pods, capacities=[3, 3])
    assert decide(world, **parameters) == ([("1", 0, ())], [("p", 0), ("q", 0)])
    world = small_world({"1": {"a": 4, "b": 1}}, pods, capacities=[3, 3])
    assert decide(world, **parameters) == ([("1", 0, (1,))], [("p", 0)])


@pytest.mark.parametrize("parameters", [{}, {"packing_capacity": 1}])
def test_orders_with_long_lines_are_completed(tmp_path: Path, parameters: dict[str, Any]) -> None:
    """One line of four items at stations that take three, from two pods; then two such lines and a short one."""
    lines = ["1,0,A,4", "2,10,A,5", "2,10,B,7", "2,10,C,1", "3,10,C,2"]
    stock = [f"{pod},{sku},3" for pod in ("p", "q", "r") for sku in "ABC"]
    (tmp_path / "orders.csv").write_text("\n".join(["order,arrival_s,sku,quantity", *lines]), encoding="utf-8")
    (tmp_path / "pods.csv").write_text("\n".join(["pod,sku,quantity", *stock]), encoding="utf-8")
    files = [f"instance.{kind}_file={tmp_path / kind}.csv" for kind in ("orders", "pods")]
    given = [f"rules.poa_pps.{name}={value}" for name, value in parameters.items()]
    rules = ["rules.poa_pps=pod-index", *given, "rules.pp=free-flow", "stations.item_capacity=3"]
    result = run("examples/from-csv", overrides=[*files, *rules])
    assert result.status == "complete"
    assert result.orders[0]["parts"] == result.orders[0]["stations"].count(" ") + 1 == 1


@pytest.mark.parametrize("seed", [1, 2])
def test_fewer_visits_and_a_shorter_turn_over_than_the_sequential_rules(seed: int) -> None:
    """Few visits, on sixty orders of the paper's generator."""
    size = ["instance.orders=60", "instance.skus=30", "instance.pods=40", "rules.pp=free-flow"]
    usual = run("paper-250", seed=seed, overrides=size).metrics
    index = run("paper-250", seed=seed, overrides=[*size, "rules.poa_pps=pod-index"]).metrics
    assert index["psv_per_order"] < 0.5 * usual["psv_per_order"]
    assert index["turnover_s"] < usual["turnover_s"]
