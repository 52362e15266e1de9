"""The simulation's story on instances small enough to work out by hand: time 0, step by step, cancelled orders."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from bad_rules import write_rule
from cases import cases
from installed import RMFS
from rmfs_commands.testing import small_instance, small_layout
from rmfs_core import events
from rmfs_core.errors import InputError, StandstillError
from rmfs_core.scenario import RuleChoice, Scenario, model
from rmfs_core.simulation.setup import motion_of, open_warehouse
from rmfs_core.warehouse import Warehouse
from rmfs_core.world import Instance
from saying import said
from told import Prepare

ONE_ORDER = small_instance({"1": ["a"]}, {"p": ["a"]})
Change = Callable[[Scenario], Scenario]


def stations(**keys: Any) -> Change:
    return lambda scenario: evolve(scenario, stations=evolve(scenario.stations, **keys))


def refill(backlog: int) -> Change:
    arrivals = model.Arrivals("refill", backlog=backlog)
    return lambda scenario: evolve(scenario, instance=evolve(scenario.instance, arrivals=arrivals))


def test_places_may_be_given_back_when_items_are_handled(tiny_run: Prepare) -> None:
    instance = small_instance({"1": ["a"], "2": ["b"]}, {"p": ["a"], "q": ["b"]})
    run = tiny_run(instance, capacity=1, change=stations(release="handled")).done()
    first, second = run.of(events.ItemPicked)
    assert [event.tick for event in run.of(events.OrderCompleted)] == [first.picker_free_tick, second.picker_free_tick]
    assert run.of(events.VisitEnded)[0].tick == first.tick == first.picker_free_tick - 6000
    assert run.of(events.OrderAssigned)[1].tick == first.picker_free_tick
    assert (run.simulation.now, run.simulation.status) == (second.picker_free_tick, "complete")
    instance = small_instance({"1": ["a", "b"], "2": ["a"]}, {"p": ["a", "b"]})
    run = tiny_run(instance, capacity=2, change=stations(release="handled")).done()
    assert run.of(events.OrderAssigned)[1].tick == run.of(events.ItemPicked)[1].picker_free_tick


def test_orders_arrive_as_there_is_room_in_the_backlog(tiny_run: Prepare) -> None:
    orders = {str(i): ["a"] for i in range(1, 6)}
    run = tiny_run(small_instance(orders, {"p": ["a"]}), capacity=1, change=refill(2)).done()
    arrived, assigned = run.of(events.OrderArrived), run.of(events.OrderAssigned)
    assert [event.order for event in arrived] == [0, 1, 2, 3, 4]
    assert [event.tick for event in arrived] == [0, 0, *(event.tick for event in assigned[:3])]
    assert [order.arrival_tick for order in run.warehouse.orders] == [event.tick for event in arrived]
    assert run.warehouse.orders[4].arrival_s == assigned[2].time_s


def test_the_next_pod_moves_up_while_the_picker_still_handles_the_last_item(tiny_run: Prepare) -> None:
    """A pod that waits in the queue is at the station 2 s after the one before it left, before the picker is free."""
    run = tiny_run(
        small_instance({"1": ["a", "b"]}, {"p": ["a"], "q": ["b"]}), robots=2, at_stations={"1": ("p", "q")}
    ).done()
    first, second = run.of(events.ItemPicked)
    left = run.of(events.VisitEnded)[0].tick
    assert left == first.tick == 7000
    turn_and_step = run.of(events.VisitStarted)[1].tick - left
    assert 2000 <= turn_and_step <= 2000 + 1250
    assert second.start_tick == first.picker_free_tick == 13000


def test_a_pod_more_than_needed_is_no_error(tiny_run: Prepare, tmp_path: Path) -> None:
    wanted = "wanted = {one.sku for one in warehouse.stations[0].uncovered_requests}"
    body = f"{wanted}; return [PodTrip(pod.id, 0) for pod in warehouse.free_pods if wanted & {{*pod.contents}}]"
    pods = {"p": ["a"], "q": ["a"], "r": ["b"]}
    instance = small_instance({"1": ["a"], "2": ["b"]}, pods, arrivals_s={"2": 500})
    run = tiny_run(instance, robots=2, pps=write_rule(tmp_path, "pps", body)).done()
    assert [visit.picks for visit in run.of(events.VisitEnded)] == [1, 0, 1]


@pytest.mark.parametrize("body", ["1 / 0", "raise SystemExit(3)", "raise BaseException"])
def test_a_rule_that_cannot_be_prepared_is_named(tiny_run: Prepare, tmp_path: Path, body: str) -> None:
    (tmp_path / "bad.py").write_text(
        "from attrs import define\nfrom rmfs_core import hookimpl\n@define\nclass Bad:\n    @hookimpl\n"
        f"    def plan_path(self): pass\n    def prepare(self, travel):\n        {body}\n",
        encoding="utf-8",
    )
    with pytest.raises(InputError, match=r"rules\.pp: .*bad\.py inline\), prepare: (ZeroDivision|SystemExit|BaseEx)"):
        tiny_run(ONE_ORDER, pp="./bad.py:Bad")


@cases(
    "line problem",
    ('stations.open = { 9 = [["06:00", "14:00"]] }', "stations.open.9: no station 9; expected 1 to 4"),
    ("robots.count = 600", "robots.count: found 600 robots; the layout has 504 storage locations to park them"),
    ("instance.pods = 600", "instance.pods: found 600 pods, but the layout has 504 storage locations"),
    ("robots.battery.capacity_wh = 1", "robots.battery: expected a charger"),
    ("layout.block_columns = 1", "instance.pods: found 100 pods, but the layout has 72 storage locations"),
    ('rules.idle = "stay"\nlayout.chargers = 1\nrobots.battery.capacity_wh = 900', 'rules.idle: rule "stay" '),
)
def test_what_is_found_when_a_warehouse_is_opened_names_file_and_line(tmp_path: Path, line: str, problem: str) -> None:
    file = tmp_path / "day.toml"
    file.write_text(f'# of a day\n{line}\nrules.poa = "pod-match"\nrules.pps = "demand"\n', encoding="utf-8")
    with pytest.raises(InputError) as caught:
        rmfs_core.run(file)
    at = "" if problem.startswith("instance.pods:") and "layout" in line else ", line 2"
    assert str(caught.value).startswith(f"{file}{at}, {problem}")


@pytest.mark.parametrize("length", [3, 4])
def test_a_battery_with_the_energy_that_its_refusal_names_is_enough(length: int) -> None:
    given = [f"layout.block_length={length}", "layout.chargers=1", "rules.idle=charge-when-low", "instance.orders=0"]
    with pytest.raises(InputError, match=r"expected more than ") as caught:
        rmfs_core.run("examples/small", overrides=[*given, "robots.battery.capacity_wh=1"])
    named = str(caught.value).split("more than ")[1].split(" Wh")[0]
    rmfs_core.run("examples/small", overrides=[*given, f"robots.battery.capacity_wh={named}"])


RULES = model.RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand"))
PODS = small_instance({"1": ["a"]}, {"p": ["a"], "q": ["a"], "r": ["a"]})


def scenario(seed: int = 1, **sections: Any) -> Scenario:
    """Return a scenario for two stations with queues of three, three robots, and half of the locations filled."""
    given = {
        "layout": model.LayoutSection(pod_fill=0.5),
        "robots": model.RobotsSection(count=3),
        "stations": model.StationsSection(queue_length=3),
    }
    return Scenario(rules=RULES, seed=seed, **(given | sections))


def refusal(given: Scenario, instance: Instance = PODS) -> str:
    return said(InputError, open_warehouse, given, instance, small_layout(2))


def at(**stations: str) -> model.InstanceSection:
    return model.InstanceSection(pods_at_stations={station: tuple(pods) for station, pods in stations.items()})


def test_pods_and_robots_get_places_of_their_own() -> None:
    layout = small_layout(2)
    locations = layout.storage_locations
    world = open_warehouse(scenario(), PODS, layout).warehouse
    places = [*world.homes, *world.blocked]
    assert len(places) == len(set(places)) == len(locations) // 2
    assert set(places) | set(world.free_locations) == set(locations)
    assert not set(places) & set(world.free_locations)
    robots = [robot.cell for robot in world.robots]
    assert len(set(robots)) == 3
    assert set(robots) <= set(locations)
    assert robots != list(world.homes)  # where they stand has nothing to do with where the first pods do
    assert [pod.location for pod in world.pods] == list(world.homes)


def placed(*places: tuple[int, int]) -> Instance:
    """Return the instance with pods that a file gives places, rows and columns from 1."""
    pods = zip(PODS.pods, places, strict=True)
    return evolve(PODS, pods=tuple(evolve(pod, place=(*at, f"line {at}")) for pod, at in pods))


def test_pods_and_robots_stand_where_files_say(tmp_path: Path) -> None:
    layout = small_layout(2)
    cells = layout.storage_locations[3:6]
    at = [(cell // layout.width + 1, cell % layout.width + 1) for cell in cells]
    (tmp_path / "robots.csv").write_text("robot,row,column\n" + "".join(f"{i},2,{i}\n" for i in range(1, 6)))
    given = evolve(scenario(robots=model.RobotsSection(count=3, file="robots.csv")), folder=str(tmp_path))
    world = open_warehouse(given, placed(*at), layout).warehouse
    assert world.homes == cells
    assert len({*world.homes, *world.blocked}) == len(layout.storage_locations) // 2
    assert [robot.cell for robot in world.robots] == [layout.width, layout.width + 1, layout.width + 2]


def test_places_that_nothing_can_stand_in_are_refused(tmp_path: Path) -> None:
    layout = small_layout(2)
    first = layout.storage_locations[0]
    good, floor = (first // layout.width + 1, first % layout.width + 1), (1, 1)
    expected = "; expected a storage location that no line before names"
    assert refusal(scenario(), placed(good, floor, good)) == f"line (1, 1): found row 1, column 1{expected}"
    assert refusal(scenario(), placed(good, good, floor)).endswith(expected)
    assert refusal(scenario(), placed((1, layout.width + good[1]), good, floor)).endswith(expected)
    file = tmp_path / "robots.csv"
    file.write_text("robot,row,column\n1,2,1\n2,2,1\n")
    given = evolve(scenario(robots=model.RobotsSection(count=2, file="robots.csv")), folder=str(tmp_path))
    assert refusal(given) == (
        f"{file}, line 3: found row 2, column 1; expected a cell of the layout, no wall, that no line before names"
    )
    file.write_text("robot,row,column\n1,2,1\n")
    assert refusal(given) == "robots.count: found 2; robots.csv places 1"


def test_where_pods_stand_at_the_start() -> None:
    world = open_warehouse(scenario(layout=model.LayoutSection(pod_fill=0.01)), PODS, small_layout(2)).warehouse
    assert (len(world.homes), world.blocked) == (3, ())
    layout = small_layout(2)

    def opened(given: Scenario) -> Warehouse:
        return open_warehouse(given, PODS, layout).warehouse

    one = opened(scenario())
    other = opened(scenario(robots=model.RobotsSection(count=5), layout=model.LayoutSection(pod_fill=0.9)))
    assert one.homes == other.homes
    assert [robot.cell for robot in one.robots] == [robot.cell for robot in other.robots][:3]
    again = opened(scenario(seed=2))
    assert again.homes != one.homes
    assert [robot.cell for robot in again.robots] != [robot.cell for robot in one.robots]


def test_robots_move_as_the_scenario_says() -> None:
    section = model.RobotsSection(acceleration_m_per_s2=0.5, top_speed_m_per_s=2.0, full_turn_s=4.0, lift_s=3.0)
    motion = motion_of(section)
    assert (motion.acceleration_m_per_s2, motion.top_speed_m_per_s) == (0.5, 2.0)
    assert (motion.turn_ticks(0, 2), motion.lift_ticks) == (2000, 3000)
    opened = open_warehouse(scenario(robots=section), small_instance({}, {}), small_layout())
    assert opened.warehouse.travel.motion == motion


@cases(
    "stations expected",
    (model.StationsSection(queue_length=3, item_capacity=7), [(7, False), (7, False)]),
    (model.StationsSection(queue_length=3, item_capacity=(7, 2)), [(7, False), (2, False)]),
    (model.StationsSection(queue_length=3, item_capacity=7, order_capacity=4), [(4, True), (4, True)]),
    (model.StationsSection(queue_length=3, order_capacity=(4, 5)), [(4, True), (5, True)]),
)
def test_stations_count_items_or_orders(stations: model.StationsSection, expected: list[tuple[int, bool]]) -> None:
    world = open_warehouse(scenario(stations=stations), PODS, small_layout(2)).warehouse
    assert [(station.capacity, station.counts_orders) for station in world.stations] == expected
    assert [station.queue_length for station in world.stations] == [3, 3]


@cases(
    "sections message",
    ({"stations": model.StationsSection(item_capacity=(1, 2, 3))}, "stations.item_capacity: found 3 capacities, "),
    ({"stations": model.StationsSection(order_capacity=(1,))}, "stations.order_capacity: found 1 capacities, but "),
    ({"instance": at(**{"3": "p"})}, "instance.pods_at_stations.3: no station 3; expected 1 to 2"),
    ({"instance": at(west="p")}, "instance.pods_at_stations.west: no station west; expected 1 to 2"),
    (
        {"instance": at(**{"2": "pqr"}), "stations": model.StationsSection(queue_length=1)},
        "instance.pods_at_stations.2: found 3 pods; the station and its queue hold 2",
    ),
    (
        {"instance": at(**{"1": "p", "2": "q"}), "robots": model.RobotsSection(count=1)},
        "instance.pods_at_stations: found 2 pods at stations, but robots.count = 1; each needs a robot",
    ),
)
def test_what_has_no_place_is_refused(sections: dict[str, Any], message: str) -> None:
    assert refusal(scenario(**sections)).startswith(message)


def test_pods_at_stations_are_told_first_in_line_first() -> None:
    at = model.InstanceSection(pods_at_stations={"2": ("r", "p"), "1": ("q",)})
    opening = open_warehouse(scenario(instance=at), PODS, small_layout(2))
    assert opening.at_stations == ((1, 2), (1, 0), (0, 1))
    assert all(pod.location is not None for pod in opening.warehouse.pods)


COUNTS_ITEMS = """
from attrs import define
from rmfs_core import OrderAssignment, hookimpl
@define
class CountsItems:
    @hookimpl
    def assign_orders(self, warehouse):
        fitting = [order for order in warehouse.backlog if order.items <= warehouse.stations[0].free_capacity]
        return [OrderAssignment(order.id, 0) for order in fitting[:1]]
"""


@cases(
    "orders left large",
    (1, "1 order is not complete (1 in the backlog;", "1 in the backlog has more than 1 item and fits"),
    (2, "2 orders are not complete (2 in the backlog;", "2 in the backlog have more than 1 item and fit"),
)
def test_a_standstill_says_what_is_left(tiny_run: Prepare, tmp_path: Path, orders: int, left: str, large: str) -> None:
    (tmp_path / "own.py").write_text(COUNTS_ITEMS, encoding="utf-8")
    instance = small_instance({str(i): ["a", "b"] for i in range(orders)}, {"p": ["a", "b"]})
    run = tiny_run(instance, capacity=1, poa="./own.py:CountsItems")
    assert said(StandstillError, run.simulation.run) == (
        f"The run stands still at 0.000 s: {left} 0 open requests that no inbound pod can serve; 0 pods waiting for a "
        'robot), and no rule decides anything (asked last: rule "./own.py:CountsItems" (own.py inline), rule "demand" '
        f'({RMFS}), rule "nearest-robot" ({RMFS})); {large} an empty station alone, as `fits` says.'
    )


@cases(
    "stations robots until_s sentence",
    ((("06:00", "10:00"),), None, 3600.0, "no station is open before 21600.000 s."),
    (None, (("12:00", "16:00"),), 3600.0, "no robot is on duty before 43200.000 s."),
    ((("00:00", "00:01"),), (("00:01", "24:00"),), 61.0, "no robot is on duty while a station is open at any time."),
    (None, None, 1.0, "1 of 1 order arrived, with 0 items picked."),
)
def test_why_no_order_is_complete_is_said(tiny_run, stations, robots, until_s, sentence) -> None:
    def change(scenario: Scenario) -> Scenario:
        return evolve(
            scenario,
            stations=evolve(scenario.stations, open=stations),
            robots=evolve(scenario.robots, available=robots),
            run=model.RunSection(until_s=until_s),
        )

    simulation = tiny_run(ONE_ORDER, change=change).simulation
    simulation.run()
    assert [*simulation.notes()] == [f"No order is complete at {until_s:.3f} s: {sentence}"]


TWO_PODS = {"p": ["a"], "q": ["b"]}
TOLD = (events.OrderArrived, events.OrderInStock, events.OrderAssigned, events.OrderCancelled, events.OrderCompleted)


def told(run: Any) -> list[tuple[float, str, int]]:
    """Return what happened to orders: when, what, and to which."""
    return [(event.time_s, type(event).__name__[5:], event.order) for event in run.events if isinstance(event, TOLD)]


def test_what_is_begun_is_picked_on(tiny_run: Prepare) -> None:
    """The station has room for one item; the second order waits until it is cancelled, and nobody picks for it."""
    instance = small_instance({"1": ["a"], "2": ["b"]}, TWO_PODS, cancelled_s={"1": 5, "2": 5})
    run = tiny_run(instance, capacity=1).done()
    first, second = run.warehouse.orders
    done = run.of(events.OrderCompleted)[0].time_s
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
    closed = stations(open=(("01:00", "02:00"),))
    run = tiny_run(small_instance({"1": ["a"]}, TWO_PODS, cancelled_s={"1": cancelled_s}), change=closed).done()
    assert told(run) == expected
    assert (run.simulation.status, run.simulation.now) == ("complete", 1000 * cancelled_s)
    assert not run.of(events.DecisionMade)


def test_what_an_order_leaves_is_there_for_those_that_wait_for_stock(tiny_run: Prepare) -> None:
    """Two items for orders of two, two and one item: the oldest order keeps them when another is cancelled."""
    closed = stations(open=(("00:10", "24:00"),))
    orders = {"1": {"a": 2}, "2": {"a": 2}, "3": {"a": 1}, "4": {"a": 1}}
    instance = small_instance(orders, {"p": {"a": 2}}, cancelled_s={"1": 10, "2": 30, "3": 20})
    run = tiny_run(instance, change=closed).done()
    assert told(run)[4:7] == [(10, "Cancelled", 0), (10, "InStock", 1), (20, "Cancelled", 2)]
    assert told(run)[7:10] == [(30, "Cancelled", 1), (30, "InStock", 3), (600, "Assigned", 3)]
    assert run.warehouse.claims.unclaimed == {0: 1}
    assert run.simulation.status == "complete"


def test_a_cancellation_that_comes_too_late_changes_nothing(tiny_run: Prepare) -> None:
    def happened(cancelled_s: dict[str, int]) -> list[Any]:
        run = tiny_run(small_instance({"1": ["a"], "2": ["b"]}, TWO_PODS, cancelled_s=cancelled_s)).done()
        return [evolve(one, wall_s=0.0) if isinstance(one, events.DecisionMade) else one for one in run.events]

    assert happened({}) == happened({"1": 7, "2": 3600})


def test_no_order_is_cancelled_of_those_that_are_refilled(tiny_run: Prepare) -> None:
    instance = small_instance({"1": ["a"], "2": ["b"]}, TWO_PODS, cancelled_s={"2": 1})
    assert not tiny_run(instance, capacity=1, change=refill(1)).done().of(events.OrderCancelled)
