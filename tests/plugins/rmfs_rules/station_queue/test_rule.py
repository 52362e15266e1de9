"""POA rule station-queue."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.testing import check_rule, small_world
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import Warehouse, WarehouseView
from rmfs_rules.station_queue import StationQueue

PutAtStation = Callable[[Warehouse, int, int], None]


def decide(world: Warehouse, rule: StationQueue) -> list[tuple[str, int]]:
    """Return (order's name, station) of each assignment."""
    return [(world.orders[one.order].name, one.station) for one in rule.assign_orders(WarehouseView(world))]


def assign(world: Warehouse, found: list[tuple[str, int]]) -> None:
    """Carry out a decision."""
    for name, station in found:
        order = next(order for order in world.orders if order.name == name)
        world.assign(order, world.stations[station], [line.sku for line in order.open_lines])


def test_orders_queue_where_their_items_are_and_stay_there() -> None:
    """Pod p, bound for station 1, has `a` and `b`: orders with them queue there, though station 0 has places free."""
    orders = {"x": {"a": 2}, "1": ["a", "b"], "2": ["a"], "3": ["c"]}
    world = small_world(orders, {"p": ["a", "b"], "q": ["c"]}, capacities=[2, 2])
    world.bind(world.pods[0], world.stations[1])
    assign(world, [("x", 1)])
    rule = StationQueue(fast_lane=0)
    assert decide(world, rule) == [("3", 0)]
    assert rule.queue_of == {1: 1, 2: 1, 3: 0}
    assign(world, [("3", 0)])
    assert decide(world, rule) == []  # station 0 has a place free, but nobody queues for it


def test_queues_have_an_end() -> None:
    """With one place each, the oldest orders queue first, in turns; the others wait in the backlog."""
    world = small_world({str(i): ["a"] for i in range(5)}, {"p": ["a"]}, capacities=[1, 1])
    rule = StationQueue(queue_length=1)
    assert decide(world, rule) == [("0", 0), ("1", 1)]
    assert rule.queue_of == {0: 0, 1: 1}
    assign(world, [("0", 0), ("1", 1)])
    assert decide(world, rule) == []
    assert rule.queue_of == {2: 0, 3: 1}


def test_a_full_queue_takes_no_order_of_a_station_that_has_one_in_part() -> None:
    """Order 1 has a place at the station, which counts orders, and its rest fills the queue."""
    world = small_world({"1": ["a", "b"], "2": ["b"]}, {"p": ["a", "b"]}, capacities=[5], counts_orders=True)
    world.assign(world.orders[0], world.stations[0], [0])
    rule = StationQueue(queue_length=1, fast_lane=0)
    assert decide(world, rule) == [("1", 0)]
    assert decide(world, rule) == [("1", 0)]
    assert rule.queue_of == {0: 0}


def test_orders_that_queue_may_be_left_out_by_a_filter() -> None:
    """The younger order queues and is hidden; it goes to its station as soon as it is shown again."""
    world, rule = small_world({"1": {"a": 2}, "2": ["b"]}, {"p": ["a", "b"]}, capacities=[2]), StationQueue()
    view = WarehouseView(world)
    rule.assign_orders(view.showing([]))
    assign(world, decide(world, rule))
    assert rule.queue_of == {0: 0, 1: 0}
    assert rule.assign_orders(view.showing([])) == []


def test_what_is_urgent_then_what_the_pod_at_the_station_completes_goes_first(put_at_station: PutAtStation) -> None:
    """At 400 s order `due` has 600 s left; `now` is on the pod at the station, `soon` on one that comes."""
    orders = {"old": ["z"], "soon": ["b"], "now": ["a"], "due": ["z"], "later": ["z"]}
    pods = {"p": ["a"], "q": ["b"], "r": ["z"]}
    world = small_world(orders, pods, capacities=[5], due_s={"due": 1000, "later": 1001})
    put_at_station(world, 0, 0)
    world.bind(world.pods[1], world.stations[0])
    world.now = 400_000
    assert [name for name, _ in decide(world, StationQueue(fast_lane=0))] == ["due", "now", "soon", "old", "later"]
    assert decide(world, StationQueue(fast_lane=0, urgent_s=0))[0] == ("now", 0)


def test_another_run_begins_with_empty_queues() -> None:
    """And orders that are done leave theirs."""
    rule = StationQueue(queue_length=2)
    for _ in range(2):
        world = small_world({str(i): ["a"] for i in range(3)}, {"p": ["a"]}, capacities=[1])
        assert decide(world, rule) == [("0", 0)]
        assert rule.queue_of == {0: 0, 1: 0}


def test_an_order_queues_only_where_it_fits() -> None:
    """Three items are too many for station 0, and nine for both: that order goes to whichever is empty."""
    world = small_world({"1": {"a": 3}, "2": {"a": 3}, "3": {"a": 9}}, {"p": ["a"]}, capacities=[2, 4])
    rule = StationQueue()
    assert decide(world, rule) == [("1", 1), ("3", 0)]
    assert rule.queue_of == {0: 1, 1: 1}


def test_a_place_is_kept_for_what_the_pod_completes(put_at_station: PutAtStation) -> None:
    """As with other rules: of two places the second is not for `b`."""
    world = small_world({"x": ["a"], "1": ["b"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}, capacities=[3])
    put_at_station(world, 0, 0)
    assign(world, [("x", 0)])
    assert Counter(decide(world, StationQueue())) == {("1", 0): 1}


@pytest.mark.parametrize("wrong", [{"queue_length": 0}, {"urgent_s": -1}, {"fast_lane": -1}])
def test_wrong_parameters_are_refused(wrong: dict[str, Any]) -> None:
    """Before the run."""
    with pytest.raises(ValueError, match="must be >="):
        StationQueue(**wrong)


def test_short_queues_conform() -> None:
    """No order is left in one."""
    assert check_rule(StationQueue(queue_length=1)).findings == ()


class Doubter:
    """Observer that has each decision made once more, by a rule that keeps its queues and nothing else."""

    def __init__(self, **parameters: Any) -> None:
        self.rule, self.orders = StationQueue(**parameters), 0

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        if question.decides is Role.POA:
            view = question.warehouse.showing(question.warehouse.backlog)  # as filters do: nothing is kept
            assert list(answer) == list(self.rule.assign_orders(view))
            self.orders += len(answer)


@pytest.mark.parametrize(
    "overrides",
    [
        [],
        ["instance.items_per_sku=3", "stations.order_capacity=4"],
        ["instance.due={allowance_s=500,spread_s=400}", "rules.poa.urgent_s=100"],
        ["stations.item_capacity=4", "rules.poa.queue_length=3"],  # some orders are larger than any station
        ["instance.arrivals.process=refill", "instance.arrivals.backlog=30", "rules.poa.fast_lane=0"],
        ['stations.open={"1"=[["08:00","18:00"]],"2"=[["00:00","00:05"],["00:08","00:00"]]}'],
    ],
    ids=", ".join,
)
def test_every_decision_of_a_run(overrides: list[str]) -> None:
    """What is kept from call to call changes no decision."""
    given = dict(one.removeprefix("rules.poa.").split("=") for one in overrides if one.startswith("rules.poa."))
    doubter = Doubter(**{name: int(value) for name, value in given.items()})
    always = ["rules.poa.rule=station-queue", "instance.orders=120", "rules.pp=free-flow", "run.until_s=900"]
    rmfs_core.run("paper-250", overrides=[*always, *overrides], observers=[doubter])
    assert doubter.orders > 15
