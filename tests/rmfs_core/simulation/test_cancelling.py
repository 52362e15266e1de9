"""Orders that are cancelled: they leave if nothing of them is assigned, and are picked on otherwise."""

from typing import Any

from attrs import evolve

from cases import cases
from rmfs_commands.testing import small_instance
from rmfs_core.events import DecisionMade, OrderArrived, OrderAssigned, OrderCancelled, OrderCompleted, OrderInStock
from rmfs_core.scenario.model import Arrivals, Scenario
from told import Prepare

PODS = {"p": ["a"], "q": ["b"]}
TOLD = (OrderArrived, OrderInStock, OrderAssigned, OrderCancelled, OrderCompleted)


def told(run: Any) -> list[tuple[float, str, int]]:
    """Return what happened to orders: when, what, and to which."""
    return [(event.time_s, type(event).__name__[5:], event.order) for event in run.events if isinstance(event, TOLD)]


def test_what_is_begun_is_picked_on(tiny_run: Prepare) -> None:
    """The station has room for one item; the second order waits until it is cancelled, and nobody picks for it."""
    instance = small_instance({"1": ["a"], "2": ["b"]}, PODS, cancelled_s={"1": 5, "2": 5})
    run = tiny_run(instance, capacity=1).done()
    first, second = run.warehouse.orders
    done = run.of(OrderCompleted)[0].time_s
    happened = [(0, "Arrived", 0), (0, "Arrived", 1), (0, "Assigned", 0), (5, "Cancelled", 1), (done, "Completed", 0)]
    assert told(run) == happened
    assert (first.cancelled, second.cancelled, second.complete, second.open_lines) == (False, True, True, ())
    assert (run.simulation.status, run.simulation.now) == ("complete", 1000 * done)
    assert run.warehouse.open_demand.tolist() == [0, 0]
    assert run.warehouse.ordered.tolist() == [1, 1]


@cases(
    "cancelled_s expected",
    (0, [(0, "Arrived", 0), (0, "Cancelled", 0)]),  # before any rule is asked
    (9.5, [(0, "Arrived", 0), (9.5, "Cancelled", 0)]),
)
def test_the_last_order_may_leave(tiny_run: Prepare, cancelled_s: float, expected: list[Any]) -> None:
    def closed(scenario: Scenario) -> Scenario:
        return evolve(scenario, stations=evolve(scenario.stations, open=(("01:00", "02:00"),)))

    run = tiny_run(small_instance({"1": ["a"]}, PODS, cancelled_s={"1": cancelled_s}), change=closed).done()
    assert told(run) == expected
    assert (run.simulation.status, run.simulation.now) == ("complete", 1000 * cancelled_s)
    assert not run.of(DecisionMade)


def test_what_an_order_leaves_is_there_for_those_that_wait_for_stock(tiny_run: Prepare) -> None:
    """Two items for orders of two, two and one item: the oldest order keeps them when another is cancelled."""

    def closed(scenario: Scenario) -> Scenario:
        return evolve(scenario, stations=evolve(scenario.stations, open=(("00:10", "24:00"),)))

    orders = {"1": {"a": 2}, "2": {"a": 2}, "3": {"a": 1}, "4": {"a": 1}}
    instance = small_instance(orders, {"p": {"a": 2}}, cancelled_s={"1": 10, "2": 30, "3": 20})
    run = tiny_run(instance, change=closed).done()
    assert told(run)[4:7] == [(10, "Cancelled", 0), (10, "InStock", 1), (20, "Cancelled", 2)]
    assert told(run)[7:10] == [(30, "Cancelled", 1), (30, "InStock", 3), (600, "Assigned", 3)]
    assert run.warehouse.claims.unclaimed == {0: 1}
    assert run.simulation.status == "complete"


def test_a_cancellation_that_comes_too_late_changes_nothing(tiny_run: Prepare) -> None:
    plain, late = (
        tiny_run(small_instance({"1": ["a"], "2": ["b"]}, PODS, cancelled_s=given)).done()
        for given in ({}, {"1": 7, "2": 3600})
    )
    assert [evolve(e, wall_s=0.0) if isinstance(e, DecisionMade) else e for e in plain.events] == [
        evolve(e, wall_s=0.0) if isinstance(e, DecisionMade) else e for e in late.events
    ]


def test_no_order_is_cancelled_of_those_that_are_refilled(tiny_run: Prepare) -> None:
    def refill(scenario: Scenario) -> Scenario:
        return evolve(scenario, instance=evolve(scenario.instance, arrivals=Arrivals("refill", backlog=1)))

    instance = small_instance({"1": ["a"], "2": ["b"]}, PODS, cancelled_s={"2": 1})
    assert not tiny_run(instance, capacity=1, change=refill).done().of(OrderCancelled)
