"""Rules of packing stations, those of `rmfs_rules.packing` and others; and rules that split orders without a box."""

from typing import Any

import numpy as np
import pytest
from attrs import evolve

from rmfs_commands.testing import small_world
from rmfs_core import run
from rmfs_core.roles import Role
from rmfs_core.scenario import load_scenario
from rmfs_core.scenario.model import PackingSection, RuleChoice
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.helpers.packing import packing_work_s, room_to_split
from rmfs_rules.mip import SplitOverTime
from rmfs_rules.pod_index import PodIndex


def busy_packers(orders: dict[str, list[str]], boxes: tuple[int, ...] = (9,)) -> WarehouseView:
    """Return a world in which the first order is begun with one line, and bound for the first packing station."""
    world = small_world(orders, {"p": ["a"], "q": ["b"], "r": ["c"]}, capacities=(9, 9), boxes=boxes)
    world.assign(world.orders[0], world.stations[0], [0])
    world.bind_packing(world.orders[0], world.packing[0])
    return WarehouseView(world)


@pytest.mark.parametrize(
    ("first", "boxes", "work_s"),
    [
        (["a", "b", "c"], (9,), (30 + 5 * 3 + 3 + 4 * 3) / 4),  # split: packed and put
        (["a"], (9,), (30 + 5) / 4),
        (["a", "b", "c"], (9, 9), (30 + 5 * 3 + 3 + 4 * 3) / 8),  # packers at another station count
    ],
)
def test_work_of_packers(first: list[str], boxes: tuple[int, ...], work_s: float) -> None:
    """Four packers at a station; above its limit a rule splits no further order, at its limit it does."""
    warehouse = busy_packers({"0": first, "1": ["a", "b"]}, boxes)
    assert packing_work_s(warehouse) == work_s
    assert room_to_split(warehouse, 5, work_s) == 5 - (len(first) > 1)
    assert room_to_split(warehouse, 5, work_s - 0.1) == 0


@pytest.mark.parametrize(("kind", "rng"), [(PodIndex, ()), (SplitOverTime, (np.random.default_rng(1),))])
@pytest.mark.parametrize(("most_s", "taken"), [(0.0, {0, 1, 2}), (20.0, {0, 1, 2}), (10.0, {0, 2})])
def test_no_order_is_split_while_packers_have_enough_to_do(
    kind: Any, rng: tuple[Any, ...], most_s: float, taken: set[int]
) -> None:
    """They have 12.75 s each. The second order lacks a SKU: it can only be begun; the first is, the third is whole."""
    warehouse = busy_packers({"0": ["a", "b"], "1": ["a", "b", "d"], "2": ["a"]})
    decision = kind(packing_work_s=most_s).assign_orders_and_pods(warehouse, *rng)
    assert {given.order for given in decision.assignments} == taken


@pytest.mark.parametrize("rule", ["pod-index", "split-among-stations", "split-over-time"])
def test_busy_packers_keep_no_order_from_being_assigned(rule: str) -> None:
    """Orders of more items than any station takes go alone when packers have too much to do for any split."""
    rules = f'rules.poa_pps={{rule = "{rule}", packing_work_s = 1.0}}'
    small = ["instance.orders=30", "rules.pp=free-flow", "stations.item_capacity=4", "packing.boxes=2"]
    result = run("examples/packing", overrides=[rules, *small])
    assert (result.status, result.metrics["orders_packed"]) == ("complete", 30)


@pytest.mark.parametrize("rule", ["pod-index", "split-among-stations", "split-over-time"])
def test_few_boxes_are_enough_and_never_too_many(rule: str) -> None:
    scenario = load_scenario("examples/packing", [f"rules.poa_pps={rule}", "instance.orders=30", "rules.pp=free-flow"])
    few = evolve(scenario, packing=PackingSection(boxes=2, packers=1))
    result = run(few)
    assert (result.status, result.metrics["orders_packed"]) == ("complete", 30)
    assert 0 < result.metrics["boxes_max"] <= 2


@pytest.mark.parametrize("rule", ["split-among-stations", "split-over-time"])
def test_boxes_that_count_until_the_last_pick_are_the_packing_capacity_of_the_paper(rule: str) -> None:
    """Constraint (18): the same picks, periods and visits as with `packing_capacity`, as long as boxes are scarce."""
    few = [f"rules.poa_pps={rule}", "rules.pp=free-flow", "instance.orders=30", "stations.item_capacity=20"]
    boxes = load_scenario("examples/packing", [*few, "packing.packing_from=picked", "packing.boxes=1"])
    rules = evolve(boxes.rules, poa_pps=RuleChoice(rule, {"packing_capacity": 2}))
    counted, limited = run(boxes).metrics, run(evolve(boxes, packing=None, rules=rules)).metrics
    same = ("pod_station_visits", "turnover_s", "split_orders_open_max", "periods")
    assert {name: counted[name] for name in same} == {name: limited[name] for name in same}


@pytest.mark.slow
def test_ten_boxes_until_the_last_pick_save_what_the_reproduction_prints() -> None:
    """The experiment `paper-packing`, seed 1: a packing capacity of 10 in the paper's warehouse."""
    base = ["rules.poa=", "rules.pps=", "rules.ta=nearest-robot", "rules.pp=free-flow", "seed=1"]

    def visits(rule: str, *more: str) -> float | None:
        return run("paper-250", overrides=[*base, f"rules.poa_pps={rule}", *more]).metrics["psv_per_order"]

    limited = visits("{rule='split-among-stations', packing_capacity=10}")
    few = "split-among-stations", "packing.boxes=10"
    assert limited == visits(*few, "packing.packing_from=picked") == 0.752
    assert (visits(*few) or 0) > 0.9


@pytest.mark.parametrize("task", ["first-come", "pack-first", "due-first", "shortest"])
@pytest.mark.parametrize("bound", ["least-reserved", "nearest"])
def test_all_go_together(task: str, bound: str) -> None:
    changes = ["rules.pp=free-flow", f"rules.packing={bound}", f"rules.packing_task={task}", "instance.orders=20"]
    scenario = load_scenario("examples/packing", changes)
    assert scenario.rules.packing == RuleChoice(bound)
    result = run(scenario)
    assert result.status == "complete"
    assert min(result.hook_calls[role.hook] for role in (Role.PACKING, Role.PACKING_TASK)) > 0
