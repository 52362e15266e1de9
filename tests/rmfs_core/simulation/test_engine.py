"""The simulation's story, step by step, on instances small enough to work out by hand."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.testing import small_instance
from rmfs_core.errors import InputError
from rmfs_core.events import (
    ItemPicked,
    OrderArrived,
    OrderAssigned,
    OrderCompleted,
    PodLifted,
    PodStored,
    RobotMoved,
    VisitEnded,
    VisitStarted,
)
from rmfs_core.scenario.model import Arrivals, RunSection, Scenario

Prepare = Callable[..., "TinyRun"]  # type: ignore[name-defined]  # noqa: F821


def test_one_item_takes_fetching_lifting_carrying_and_handling(tiny_run: Prepare) -> None:
    """One robot, pod, item: the run is the empty drive, 2.2 s of lifting, the loaded drive and 13 s of handling."""
    run = tiny_run(small_instance({"1": ["a"]}, {"p": ["a"]}))
    warehouse = run.warehouse
    travel, robot, pod = warehouse.travel, warehouse.robots[0], warehouse.pods[0]
    station = warehouse.stations[0].cell
    fetch = travel.ticks(robot.cell, robot.heading, pod.cell, loaded=False)
    run.simulation.run()
    heading = next(e.heading for e in reversed(run.recorder.of(RobotMoved)) if e.pod is None) if fetch else 1
    carry = travel.ticks(pod.robot is not None and warehouse.homes[0], heading, station, loaded=True)
    assert run.simulation.now == fetch + 2200 + carry + 13000
    assert run.simulation.status == "complete"


def release_when(at: str) -> Callable[[Scenario], Scenario]:
    """Return what makes a scenario one in which places are given back when items are picked, or handled."""
    return lambda scenario: evolve(scenario, stations=evolve(scenario.stations, release=at))


@pytest.mark.parametrize(("release", "later"), [("picked", 0), ("handled", 6000)])
def test_the_picker_needs_thirteen_seconds_an_item(tiny_run: Prepare, release: str, later: int) -> None:
    """Three items from one pod: picks begin 13 s apart, each done after 7 s; the pod leaves with the last one."""
    instance = small_instance({"1": ["a", "b", "c"]}, {"p": ["a", "b", "c"]})
    run = tiny_run(instance, change=release_when(release))
    run.simulation.run()
    picks = run.recorder.of(ItemPicked)
    starts = [pick.start_tick for pick in picks]
    assert [b - a for a, b in pairwise(starts)] == [13000, 13000]
    assert [pick.tick - pick.start_tick for pick in picks] == [7000] * 3
    assert run.recorder.of(VisitEnded)[0].picks == 3
    assert run.recorder.of(VisitEnded)[0].tick == picks[-1].tick
    assert run.recorder.of(OrderCompleted)[0].tick == picks[-1].tick + later


def test_places_may_be_given_back_when_items_are_handled(tiny_run: Prepare) -> None:
    """An order is complete after 13 s in place of 7, and the next one is assigned only then; the pod leaves after 7."""
    instance = small_instance({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]})
    run = tiny_run(instance, capacity=1, change=release_when("handled"))
    run.simulation.run()
    first, second = run.recorder.of(ItemPicked)
    assert [event.tick for event in run.recorder.of(OrderCompleted)] == [
        first.picker_free_tick,
        second.picker_free_tick,
    ]
    assert run.recorder.of(VisitEnded)[0].tick == first.tick == first.picker_free_tick - 6000
    assert run.recorder.of(OrderAssigned)[1].tick == first.picker_free_tick
    assert run.simulation.now == second.picker_free_tick
    assert run.simulation.status == "complete"


def test_with_two_items_only_the_last_one_counts(tiny_run: Prepare) -> None:
    """The part of an order keeps its places until the last of its items is handled."""
    instance = small_instance({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]})
    run = tiny_run(instance, capacity=2, change=release_when("handled"))
    run.simulation.run()
    assert run.recorder.of(OrderAssigned)[1].tick == run.recorder.of(ItemPicked)[1].picker_free_tick


def test_orders_arrive_as_there_is_room_in_the_backlog(tiny_run: Prepare) -> None:
    """Two wait at all times: the third comes when the first is assigned, and so on; their turn-over begins then."""

    def refill(scenario: Scenario) -> Scenario:
        return evolve(scenario, instance=evolve(scenario.instance, arrivals=Arrivals("refill", backlog=2)))

    orders = {str(i): ["a"] for i in range(1, 6)}
    run = tiny_run(small_instance(orders, {"p": ["a"]}), capacity=1, change=refill)
    run.simulation.run()
    arrived, assigned = run.recorder.of(OrderArrived), run.recorder.of(OrderAssigned)
    assert [event.order for event in arrived] == [0, 1, 2, 3, 4]
    assert [event.tick for event in arrived] == [0, 0, *(event.tick for event in assigned[:3])]
    assert [order.arrival_tick for order in run.warehouse.orders] == [event.tick for event in arrived]
    assert run.warehouse.orders[4].arrival_s == assigned[2].time_s


def test_the_next_pod_moves_up_while_the_picker_still_handles_the_last_item(tiny_run: Prepare) -> None:
    """A pod that waits in the queue is at the station 2 s after the one before it left, before the picker is free."""
    run = tiny_run(
        small_instance({"1": ["a", "b"]}, {"p": ["a"], "q": ["b"]}),
        robots=2,
        at_stations={"1": ("p", "q")},
    )
    run.simulation.run()
    first, second = run.recorder.of(ItemPicked)
    left = run.recorder.of(VisitEnded)[0].tick
    assert left == first.tick == 7000
    turn_and_step = run.recorder.of(VisitStarted)[1].tick - left
    assert 2000 <= turn_and_step <= 2000 + 1250
    assert second.start_tick == first.picker_free_tick == 13000


def test_a_pod_goes_on_to_the_next_station_it_is_bound_for(tiny_run: Prepare) -> None:
    """One robot carries a pod from station to station; each is a visit, and it is stored only once."""
    run = tiny_run(
        small_instance({"1": ["a", "b"], "2": ["a", "c"]}, {"p": ["a"], "q": ["b"], "r": ["c"]}),
        robots=3,
        capacity=(2, 2),
    )
    run.simulation.run()
    visits = [(visit.pod, visit.station) for visit in run.recorder.of(VisitStarted)]
    assert sorted(visits) == [(0, 0), (0, 1), (1, 0), (2, 1)]
    onward = [event for event in run.recorder.of(VisitEnded) if event.next_station is not None]
    assert [event.pod for event in onward] == [0]
    lifted = [event.pod for event in run.recorder.of(PodLifted)]
    assert sorted(lifted) == [0, 1, 2]


def test_a_pod_is_put_back_and_the_robot_fetches_the_next(tiny_run: Prepare) -> None:
    """With one robot two pods take turns: the first is stored before the second is lifted."""
    run = tiny_run(small_instance({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]}), capacity=1)
    run.simulation.run()
    stored, lifted = run.recorder.of(PodStored), run.recorder.of(PodLifted)
    assert len(stored) == 1
    assert len(lifted) == 2
    assert stored[0].tick <= lifted[1].start_tick


def test_orders_that_arrive_later_are_picked_later(tiny_run: Prepare) -> None:
    """An order that arrives at 500 s is unknown before, and completed after."""
    instance = small_instance({"1": ["a"], "2": ["a"]}, {"p": ["a"]}, arrivals_s={"2": 500})
    run = tiny_run(instance)
    run.simulation.run()
    assert [event.tick for event in run.recorder.of(OrderArrived)] == [0, 500_000]
    assert [event.tick for event in run.recorder.of(OrderAssigned)] == [0, 500_000]
    assert [event.order for event in run.recorder.of(OrderCompleted)] == [0, 1]


def test_a_run_without_orders_is_over_at_once(tiny_run: Prepare) -> None:
    """Nothing to pick: complete at time 0."""
    run = tiny_run(small_instance({}, {"p": ["a"]}))
    run.simulation.run()
    assert (run.simulation.status, run.simulation.now) == ("complete", 0)


def test_until_ends_the_run_at_its_time(tiny_run: Prepare) -> None:
    """run.until_s ends the run exactly then, with orders left."""
    run = tiny_run(small_instance({"1": ["a"]}, {"p": ["a"]}), run=RunSection(until_s=5))
    run.simulation.run()
    assert run.simulation.now == 5000
    assert not run.recorder.of(OrderCompleted)


def test_pods_wait_for_room_in_the_queue(tiny_run: Prepare) -> None:
    """With one queue cell at most two pods are on their way to or at the station at any time; all are served."""
    skus = list("abcdef")
    run = tiny_run(
        small_instance({str(i): [sku] for i, sku in enumerate(skus)}, {sku: [sku] for sku in skus}),
        robots=6,
        queue_length=1,
    )
    run.simulation.run()
    under_way = 0
    for event in run.recorder.events:
        under_way += isinstance(event, PodLifted) - isinstance(event, VisitEnded)
        assert under_way <= 2
    assert len(run.recorder.of(OrderCompleted)) == 6


def test_full_queues_do_not_block_each_other(tiny_run: Prepare) -> None:
    """Pods at two full stations, each bound for the other, are stored and fetched again: nothing stands still."""
    run = tiny_run(
        small_instance(
            {"1": ["a", "b", "c", "d"], "2": ["a", "b", "c", "d"]},
            {"p": ["a"], "q": ["b"], "r": ["c"], "s": ["d"]},
        ),
        robots=6,
        capacity=(4, 4),
        queue_length=1,
        at_stations={"1": ("p", "q"), "2": ("r", "s")},
    )
    run.simulation.run()
    assert len(run.recorder.of(OrderCompleted)) == 2
    assert len(run.recorder.of(ItemPicked)) == 8


@pytest.mark.parametrize("body", ["1 / 0", "raise SystemExit(3)"])
def test_a_rule_that_cannot_be_prepared_is_named(tiny_run: Prepare, tmp_path: Path, body: str) -> None:
    """Before the run: one sentence, whatever it raises."""
    (tmp_path / "bad.py").write_text(
        "from attrs import define\nfrom rmfs_core import hookimpl\n@define\nclass Bad:\n    @hookimpl\n"
        f"    def plan_path(self): pass\n    def prepare(self, roads):\n        {body}\n",
        encoding="utf-8",
    )
    with pytest.raises(
        InputError, match=r"rules\.pp: rule .*bad\.py inline\), prepare: (ZeroDivisionError|SystemExit)"
    ):
        tiny_run(small_instance({"1": ["a"]}, {"p": ["a"]}), pp="./bad.py:Bad")


def test_a_station_takes_an_order_larger_than_it_is(tiny_run: Prepare) -> None:
    """When it is empty; the order is picked like any other."""
    run = tiny_run(small_instance({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]}), capacity=1)
    run.simulation.run()
    assert [event.order for event in run.recorder.of(OrderCompleted)] == [0, 1]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ('stations.open = { 9 = [["06:00", "14:00"]] }', "stations.open.9: no station 9; expected 1 to 4"),
        ("stations.item_capacity = [3, 4]", "stations.item_capacity: found 2 capacities, but the layout has 4"),
        ("robots.count = 600", "robots.count: found 600 robots; the layout has 504 storage locations to park them"),
        ("instance.pods = 600", "instance.pods: found 600 pods, but the layout has 504 storage locations"),
        ('instance.pods_at_stations = { 7 = ["1"] }', "instance.pods_at_stations.7: no station 7; expected 1 to 4"),
        ("robots.battery.capacity_wh = 1", "robots.battery: expected a charger"),
        ("layout.block_columns = 1", "instance.pods: found 100 pods, but the layout has 72 storage locations"),
        ('rules.idle = "stay"\nlayout.chargers = 1\nrobots.battery.capacity_wh = 900', 'rules.idle: rule "stay" '),
    ],
)
def test_what_is_found_when_a_warehouse_is_opened_names_file_and_line(tmp_path: Path, line: str, problem: str) -> None:
    """As what is found when the scenario is read; a key that the file does not have stands without a line."""
    file = tmp_path / "day.toml"
    file.write_text(f'# of a day\n{line}\nrules.poa = "pod-match"\nrules.pps = "demand"\n', encoding="utf-8")
    with pytest.raises(InputError) as caught:
        rmfs_core.run(file)
    at = "" if problem.startswith("instance.pods:") and "layout" in line else ", line 2"
    assert str(caught.value).startswith(f"{file}{at}, {problem}")
