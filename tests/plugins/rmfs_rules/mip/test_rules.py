"""The three rules in the kernel: parameters, refusals, decisions of small worlds, and whole runs."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rmfs_core
from cases import cases
from rmfs_commands.testing import small_world
from rmfs_commands.validation import validate_trace
from rmfs_core import JointDecision, OrderAssignment
from rmfs_core.errors import InputError
from rmfs_core.results.result import Result
from rmfs_core.simulation.applying import apply_assignments
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.mip import Integrated, SplitAmongStations, SplitOverTime
from rmfs_rules.mip.period.solution import Model

RULES = (Integrated, SplitAmongStations, SplitOverTime)
NAMES = [str(model) for model in Model]
SPLIT = NAMES[1:]
SMALL = [f"instance.{key}" for key in ("orders=20", "pods=30")]
SMALL += [f"layout.{key}" for key in ("block_rows=5", "block_columns=3", "stations_east=2")]
SCARCE = [*SMALL, "instance.orders=30", "instance.skus=15", "instance.skus_per_pod=2", "rules.pp=free-flow"]


def decide(rule, world) -> JointDecision:
    return rule.assign_orders_and_pods(WarehouseView(world), np.random.default_rng(0))


def apply(world, decision: JointDecision, period: int, room: int | None = None) -> JointDecision:
    return apply_assignments(
        world, decision, joint=True, shown=None, period=period, packing_capacity=room, keep=lambda event: None
    )


def run(rule: str, overrides: list[str], folder: Path | None = None) -> Result:
    """Run a small scenario; hold its trace, if there is a folder for it, against everything that must be true."""
    record = [] if folder is None else ["trace"]
    result = rmfs_core.run(f"paper-250-{rule}", overrides=overrides, out=folder, record=record)
    assert folder is None or validate_trace(folder) == []
    return result


def test_a_solver_that_is_not_installed_is_said_before_the_run(monkeypatch):
    """Also by the aggregated form, which often needs no solver."""
    monkeypatch.setattr("mip.gurobi.has_gurobi", False)
    with pytest.raises(InputError, match='solver = "gurobi" needs an installed Gurobi'):
        run("integrated", [*SMALL, "rules.poa_pps.solver=gurobi"])


@pytest.mark.parametrize("rule", RULES)
def test_nothing_to_do(rule):
    for orders in ({"1": ["nowhere"]}, {}):
        decision = decide(rule(), small_world(orders, {"p": ["a"]}))
        assert (decision.assignments, decision.trips) == ((), ())
        assert decision.report.status == "optimal"
        assert decision.report.objective == decision.report.bound == 2 * 15


@pytest.mark.parametrize("rule", RULES)
def test_a_pod_that_is_there_costs_nothing(rule):
    """A pod bound for the station is no new trip; the oldest order that it serves is taken first."""
    world = small_world({"1": ["b"], "2": ["a"], "3": ["a"]}, {"p": ["a"], "q": ["b"]}, capacities=(1,))
    world.bind(world.pods[0], world.stations[0])
    decision = decide(rule(), world)
    assert decision.assignments == (OrderAssignment(1, 0, (world.orders[1].lines[0].sku,)),)
    assert decision.trips == ()


def test_more_split_orders_open_than_there_is_room_for():
    """A decision that splits no further order may leave a state that others have caused."""
    world = small_world({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]}, capacities=(1, 5))
    world.assign(world.orders[0], world.stations[0], [world.orders[0].lines[0].sku], 1)
    world.bind(world.pods[0], world.stations[0])
    assert world.split_orders_open == 1
    assert len(apply(world, decide(SplitOverTime(packing_capacity=0), world), 2, 0).assignments) == 2


def test_lines_join_the_place_of_their_order():
    """Over time, what the pods at the station have of an order goes there too: it takes no further slot."""
    world = small_world({"1": "abc", "2": "ab"}, {"p": "ab", "q": "c"}, capacities=[2], counts_orders=True)
    world.bind(world.pods[0], world.stations[0])
    world.assign(world.orders[0], world.stations[0], [0])
    decision = decide(SplitOverTime(), world)
    assert sorted((one.order, one.skus) for one in decision.assignments) == [(0, (1,)), (1, (0, 1))]
    assert decision.trips == ()


@pytest.mark.parametrize("rule", RULES)
def test_a_line_too_large_for_the_stations_is_not_split(rule):
    """Five items of one SKU for three slots: the order gets an empty station, from two pods."""
    world = small_world({"1": {"a": 5}}, {"p": {"a": 4}, "q": {"a": 1}}, capacities=[3, 3])
    decision = decide(rule(), world)
    assert [(one.order, one.station, one.skus) for one in decision.assignments] == [(0, 0, (0,))]
    assert {trip.pod for trip in decision.trips} == {0, 1}


@given(
    held=st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 3), min_size=1), min_size=1, max_size=4),
    wanted=st.lists(st.dictionaries(st.sampled_from("abc"), st.integers(1, 2), min_size=1), min_size=1, max_size=6),
    bound=st.lists(st.tuples(st.integers(0, 3), st.integers(0, 1)), max_size=4, unique=True),
    rule=st.sampled_from([Integrated(), SplitAmongStations(), SplitOverTime(), SplitOverTime(formulation="paper")]),
)
@settings(deadline=None, max_examples=60)
def test_what_a_model_decides_can_be_carried_out(held, wanted, bound, rule):
    """Period after period, with pods bound for several stations: the kernel finds promises for every decision."""
    orders, pods = ({str(i): skus for i, skus in enumerate(table)} for table in (wanted, held))
    world = small_world(orders, pods, capacities=[4, 3], robots=4)
    for pod, station in bound:
        if pod < len(held):
            world.bind(world.pods[pod], world.stations[station])
    for period in (1, 2, 3):
        decision = decide(rule, world)
        assert decision.report is None or decision.report.status == "optimal"  # None: an order alone
        apply(world, decision, period)
        for station in world.stations:
            for request in station.open_requests[::2]:
                world.fulfil(request, request.pod)


@pytest.mark.parametrize("rule", NAMES)
@cases(
    "setting",
    *(f"formulation={name}" for name in ("aggregated", "paper")),
    *(f"preferred_pods={name}" for name in ("bound", "any", "random")),
    *(f"tie_break={name}" for name in ("oldest", "demand")),
)
def test_runs_end_complete_and_repeat(rule, setting):
    """A whole run completes every order, each period at its optimum; a second one measures the same."""
    first, second = (run(rule, [*SMALL, f"rules.poa_pps.{setting}"]) for _ in range(2))
    assert first.status == "complete"
    assert first.metrics == second.metrics
    assert first.metrics["solves_stopped_early"] == 0


@pytest.mark.parametrize("rule", NAMES)
@cases(
    "overrides",
    ["instance.items_per_sku=2", "rules.pp=whca-n"],
    ["instance.items_per_sku=5", "rules.pp=whca-n"],
    pytest.param(["instance.items_per_sku=2", "rules.poa_pps.formulation=paper"], marks=pytest.mark.slow),
    ["stations.order_capacity=3"],
    ["stations.order_capacity=3", "instance.items_per_sku=5"],
    *([f"stations.item_capacity={items}", "rules.poa_pps.max_wait_s=100"] for items in (1, 3)),
    ids=" ".join,
)
def test_other_warehouses_end_complete(rule, overrides, tmp_path):
    """Each period at its optimum, and a valid trace: finite stock, slots for orders, stations too small for orders.

    Orders larger than a station, with slots for one item each than both together, get one of their own.
    """
    result = run(rule, [*SCARCE, *overrides], tmp_path)
    assert result.status == "complete"
    assert result.metrics["solves_stopped_early"] == 0


def test_orders_too_large_are_refused_where_the_scenario_says_so(tmp_path):
    """Of the three rules, `integrated` alone cannot do without."""
    refusing = [*SCARCE, "stations.item_capacity=3", "stations.oversize=refuse"]
    with pytest.raises(InputError, match=r"items, more than any station takes at a time \(3\)"):
        run("integrated", refusing)
    assert run("split-over-time", refusing, tmp_path).status == "complete"


@pytest.mark.parametrize("rule", SPLIT)
@pytest.mark.parametrize("room", [0, 2])
def test_packing_capacity_holds_in_a_run(rule, room):
    result = run(rule, [*SMALL, f"rules.poa_pps.packing_capacity={room}"])
    assert result.status == "complete"
    assert result.metrics["split_orders_open_max"] <= room


def test_a_limit_is_reported():
    limited = run("integrated", [*SMALL, "instance.skus=60", "rules.poa_pps.max_seconds=1e-6"])
    assert limited.metrics["solves_stopped_early"] > 0


@pytest.mark.parametrize("rule", NAMES)
def test_a_run_without_effort(rule, tmp_path):
    """Every period has a decision at once; it says that its effort ended it, with a bound, and repeats."""
    first, second = (run(rule, [*SMALL, "rules.poa_pps.effort=0"], tmp_path) for _ in range(2))
    assert first.status == "complete"
    assert first.metrics == second.metrics
    early = [row for row in first.periods if row["status"] == "effort"]
    assert len(early) == first.metrics["solves_stopped_early"]
    assert all(row["bound"] < row["objective"] for row in early)
    assert early or rule == "split-over-time"


@pytest.mark.parametrize("rule", NAMES)
def test_the_example_with_finite_stock(rule, tmp_path):
    overrides = [f"rules.poa_pps={rule}", "rules.poa=", "rules.pps="]
    result = rmfs_core.run("examples/from-csv", overrides=overrides, out=tmp_path, record=["trace"])
    assert result.status == "complete"
    assert validate_trace(tmp_path) == []


@cases(
    "example visits",
    ("example-1-integrated", 4),  # Section 1.2: each station takes one order and needs both pods
    ("example-1-split-among-stations", 2),  # one station gets the blue items, the other the orange ones
    ("example-2-integrated", 4),  # Section 2.4: sequential rules need 6
    ("example-appendix", 2),  # Appendix A: either pod comes once
)
@pytest.mark.parametrize("formulation", ["aggregated", "paper"])
def test_visits_of_the_examples(example, visits, formulation):
    """Either formulation needs as many pod-station visits as the text says."""
    result = rmfs_core.run(f"examples/{example}", overrides=[f"rules.poa_pps.formulation={formulation}"])
    assert result.status == "complete"
    assert result.metrics["pod_station_visits"] == visits


def test_example_2_integrated():
    """Section 2.4: orders 1 and 2 and pod 3 go to station 1, orders 3 and 4 and pod 4 to station 2; pile-on 3."""
    result = rmfs_core.run("examples/example-2-integrated")
    assert {row["order"]: row["stations"] for row in result.orders} == {"1": "1", "2": "1", "3": "2", "4": "2"}
    sent = sorted((row["pod"], row["station"]) for row in result.visits)
    assert sent == [("1", "1"), ("2", "2"), ("3", "1"), ("4", "2")]
    assert result.metrics["pile_on"] == 3.0
