"""Impossible decisions: each ends the run with one sentence."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bad_rules import prepare_bad, what_ends
from rmfs_commands.testing import small_world
from rmfs_core.decisions import Leg, OrderAssignment, PodMove, PodTrip, RobotMove
from rmfs_core.decisions import Path as Way
from rmfs_core.events import OrderAssigned
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.traffic import ReservedError
from rmfs_core.traffic.paths import ends_of
from rmfs_core.warehouse import Warehouse
from saying import said
from told import Prepare

ORDER, POD, NAMED = "order one (id 0) to station 1 (id 0)", "to station 1 (id 0)", "expected a whole number"
TWICE = "OrderAssignment(0, 0), OrderAssignment"
WRONG = [
    ("poa", "return [3]", "returned a sequence with int 3 in it; expected OrderAssignment only"),
    ("poa", "return [OrderAssignment(9, 0)]", "named order 9, which does not exist; ids are 0 to 2"),
    ("poa", "return [OrderAssignment('1', 0)]", f"named order '1'; {NAMED}"),
    ("poa", "return [OrderAssignment(0, 5)]", "named station 5, which does not exist; ids are 0 to 0"),
    # larger than any station: it takes a whole one
    ("poa", f"return [{TWICE}(1, 0)]", f"assigned order two (id 1) {POD}: it takes 2 items, but only 0 of 2 are free"),
    ("poa", f"return [{TWICE}(0, 0)]", f"assigned {ORDER}, but the order has no open line left"),
    ("poa", "return [OrderAssignment(0, 0, skus=(2,))]", "SKU id 2 of order one (id 0), which is no open line of it"),
    ("poa", "return [OrderAssignment(0, 0, skus=())]", "SKUs () of order one (id 0); expected one or more, each once"),
    ("poa", "return [OrderAssignment(2, 0)]", f"late (id 2) {POD}, but the order was not in the backlog it was shown"),
    ("poa", "return [OrderAssignment(0.0, 0)]", f"named order 0.0; {NAMED}"),
    ("poa", "return [OrderAssignment(True, 0)]", f"named order True; {NAMED}"),
    ("poa", "import numpy as np; return [OrderAssignment(np.True_, 0)]", f"named order np.True_; {NAMED}"),
    ("poa", "return [OrderAssignment(0, 0, skus=5)]", "SKUs 5 of order one (id 0); expected a sequence of ids"),
    ("poa", "return [OrderAssignment(0, 0, skus=(0.0,))]", f"named SKU id 0.0; {NAMED}"),
    ("pps", "return [PodTrip(9, 0)]", "named pod 9, which does not exist; ids are 0 to 2"),
    ("pps", "return [PodTrip(-1, 0)]", "named pod -1, which does not exist; ids are 0 to 2"),
    ("pps", "return [PodTrip(0, 0), PodTrip(0, 0)]", f"pod p (id 0) {POD}, where it already is or is bound for"),
    ("pps", "return [PodTrip(2, 0)]", f"pod r (id 2) {POD}, but it holds no item of any request uncovered there"),
    (
        "pps",
        "return [PodTrip(0, 0), PodTrip(1, 0)] if max_fetches == 1 else []",
        "sent 2 stored pods on their way; at most 1 robots can start",
    ),
    ("poa_pps", "return []", "returned list []; expected JointDecision"),
    (
        "poa_pps",
        "return JointDecision([OrderAssignment(0, 0)], [])",
        f"assigned {ORDER}, but no pod there or bound for it has an item of SKU id 0 left",
    ),
    ("poa_pps", "return JointDecision([], [PodTrip(0, 7)])", "named station 7, which does not exist; ids are 0 to 0"),
    ("poa_pps", f"return JointDecision([{TWICE}(1, 0)], [PodTrip(0, 0)])", "it takes 2 items, but only 0 of 2"),
    ("poa_pps", "return JointDecision([], [PodTrip(2, 0)])", "(id 0), but it holds no item of any request open there"),
    ("poa_pps", "return JointDecision([], [], report='fine')", "returned str 'fine'; expected SolveReport"),
    ("poa_pps", "return JointDecision([], [], SolveReport('optimal', objective='x'))", "objective is 'x'; expected a"),
    ("pr", "return 2.5", f"named cell 2.5; {NAMED}"),
    ("pr", "return -1", "stores pod p (id 0) at cell -1, which is not on the grid"),
    ("pr", "return warehouse.stations[0].cell", "which is no storage location"),
    ("pr", "return warehouse.home(warehouse.pods[1])", "which is taken"),
    ("ta", "return [TaskAssignment(4, 0)]", "named robot 4, which does not exist; ids are 0 to 0"),
    ("ta", "return [TaskAssignment(0, 2)]", "pod r (id 2) to robot 1 (id 0), but the pod does not wait for a robot"),
    ("ta", "return [TaskAssignment(0, 0), TaskAssignment(0, 1)]", "gave pod q (id 1) to robot 1 (id 0), which is busy"),
    ("idle", "return [3]", "returned a sequence with int 3 in it; expected RobotMove only"),
    ("idle", "return [RobotMove(5, 0)]", "named robot 5, which does not exist; ids are 0 to 0"),
    ("idle", "return [RobotMove(0, 0)] if warehouse.resting_robots else []", "to rest in cell 0, no storage location"),
    ("move", "return [3]", "returned a sequence with int 3 in it; expected PodMove only"),
    ("move", "return [PodMove(9, 0)]", "named pod 9, which does not exist; ids are 0 to 2"),
    ("move", "return [PodMove(2, 0), PodMove(2, 0), PodMove(2, 0)]", "moves 3 pods; at most 1 can be moved now"),
    ("move", "return [PodMove(2, warehouse.pods[2].cell)]", "stores pod r (id 2) at row"),
    ("pp", "return Path()", "gave robot 1 (id 0) an empty path to "),
    ("pp", "return Path([Leg(-5)])", "sent robot 1 (id 0) to cell -5, which is not on the grid"),
    ("pp", "return Path([Leg(robot.cell)])", "gave robot 1 (id 0) a leg that waits 0 ticks and goes nowhere"),
    ("pp", "return Path([Leg(robot.cell, 10**14)])", "gave robot 1 (id 0) a leg that waits 100000000000000 ticks"),
    ("pp", "return Path([Leg(robot.cell, 0.5)])", f"named wait_ticks 0.5; {NAMED}"),
    ("pp", "return Path([Leg(None)])", f"named cell None; {NAMED}"),
    ("pp", "return Path([Leg(robot.cell, 60000)])", " for 3660 s (longer than run.standstill_s and than 10 crossings"),
    ("pp", "return Path([3])", "returned a path with int 3 in it; expected Leg only"),
    ("pp", "return Path([Leg(warehouse.stations[0].cell)])", "gave robot 1 (id 0) an impossible path: "),
    ("filters", "return orders + orders[:1] + (warehouse.orders[0],) + tuple('x')", "in it; expected Order only"),
]


@pytest.mark.parametrize(("role", "body", "message"), WRONG)
def test_a_wrong_decision_ends_the_run(tiny_run: Prepare, tmp_path: Path, role: str, body: str, message: str) -> None:
    assert message in what_ends(prepare_bad(tiny_run, tmp_path, role, body), role)


def test_numpy_integers_are_ids_too(tiny_run: Prepare, tmp_path: Path) -> None:
    """A rule that finds its answer with argmax need not convert it."""
    body = "import numpy as np; return [OrderAssignment(np.int64(o.id), np.int64(0)) for o in warehouse.backlog[:1]]"
    run = prepare_bad(tiny_run, tmp_path, "poa", body).done()
    assert run.simulation.status == "complete"
    assert {type(event.order) for event in run.of(OrderAssigned)} == {int}


def impossible(check: Callable[..., object], *arguments: object) -> str:
    return said(ImpossibleError, check, *arguments)


@pytest.fixture
def world() -> Warehouse:
    """Three orders, the last of them unknown yet; pods of a, of b and of a; one station for two orders, one for two."""
    return small_world(
        {"1": ["a"], "2": ["a", "b"], "3": ["b"]},
        {"p": ["a"], "q": ["b"], "r": ["a"]},
        capacities=[2, 2],
        counts_orders=True,
    )


def test_where_orders_are_counted_each_takes_one_place(world: Warehouse) -> None:
    one, two, three = world.orders
    here, there = world.stations
    world.assign(two, here, [0])
    world.assign(one, here, [0])
    assert checks.assignment(world, OrderAssignment(1, 0), None) == (two, here, [1])
    assert impossible(checks.assignment, world, OrderAssignment(2, 0), None) == (
        "assigned order 3 (id 2) to station 1 (id 0): it takes 1 orders, but only 0 of 2 are free"
    )
    assert checks.assignment(world, OrderAssignment(2, 1), {2}) == (three, there, [1])


def test_a_pod_in_use_is_not_selected(world: Warehouse) -> None:
    p, q, r = world.pods
    here, there = world.stations
    world.place_at_station(world.robots[0], p, here)
    world.bind(r, here)
    leaving: set[int] = set()
    uncovered = {0: {0}, 1: {0, 1}}
    text = impossible(checks.selected_trip, world, PodTrip(2, 1), leaving, uncovered)
    assert text == f"sent pod {r.label} to station 2 (id 1), but the pod is in use"
    assert checks.selected_trip(world, PodTrip(0, 1), leaving, uncovered) == (p, there)
    assert leaving == {0}
    assert checks.selected_trip(world, PodTrip(1, 1), leaving, uncovered) == (q, there)
    assert impossible(checks.selected_trip, world, PodTrip(1, 0), leaving, uncovered) == (
        "sent pod q (id 1) to station 1 (id 0), but it holds no item of any request uncovered there"
    )


def test_a_path_is_checked_leg_by_leg() -> None:
    world = small_world({"1": ["a"]}, {"p": ["a"]})
    robot, travel = world.robots[0], world.travel
    start, goal = robot.cell, world.pods[0].cell
    fastest = travel.fastest_path(start, robot.heading, goal, loaded=False)
    legs = [Leg(start, 70), *(Leg(np.int64(leg.to)) for leg in fastest)]  # type: ignore[arg-type]
    found = checks.path(world, robot, start, goal, Way(legs))
    assert Way(found) == Way([Leg(start, 70), *fastest])
    assert checks.path(world, robot, goal, goal, Way()).tolist() == []
    assert impossible(checks.path, world, robot, start, goal, Way(legs[::-1])).startswith("gave robot 1 (id 0) an imp")
    most = checks.LONGEST_WAIT_TICKS
    assert checks.path(world, robot, start, goal, Way([Leg(start, most)])).tolist() == [[start, most]]
    assert impossible(checks.path, world, robot, start, goal, Way([Leg(start, -1)])) == (
        f"gave robot 1 (id 0) a leg that waits -1 ticks and goes nowhere; expected 0 to {most}, "
        "and at least 1 for a leg that only waits"
    )


@given(
    steps=st.lists(st.tuples(st.integers(-5, 5), st.integers(-3, 3), st.integers(-1, 2)), max_size=4),
    data=st.data(),
    loaded=st.booleans(),
)
def test_a_path_given_as_an_array_is_checked_alike(steps: list[tuple[int, int, int]], data: Any, loaded: bool) -> None:
    world = small_world({"1": ["a"]}, {"p": ["a"]})
    robot, layout = world.robots[0], world.travel.layout
    start, goal = (data.draw(st.integers(0, len(layout.kind) - 1)) for _ in range(2))
    at = start
    if loaded:
        pod = world.pods[0]
        world.bind(pod, world.stations[0])
        world.take_task(robot, pod)
        world.lift(robot, pod)
    legs = [
        Leg(at := at + (right if i % 2 else layout.width * down), wait) for i, (right, down, wait) in enumerate(steps)
    ]

    def said(path: Way) -> object:
        try:
            return checks.path(world, robot, start, goal, path).tolist()
        except ImpossibleError as problem:
            return str(problem)

    assert said(Way(ends_of(legs))) == said(Way(legs))


def test_a_hit_names_who_was_there_first() -> None:
    layout = small_world({}, {"p": ["a"]}).travel.layout
    error = checks.hit(layout, 4, ReservedError(layout.width + 2, owner=0, since=12_500, until=13_000))
    assert str(error) == ("gave robot 5 a path that hits a reservation: robot 1 has row 2, column 3 from 12.500 s on")


def test_pods_that_nobody_uses_are_moved(world: Warehouse) -> None:
    bound, fetched, free = world.pods[0], world.pods[1], world.free_locations[0]
    assert checks.move(world, PodMove(1, free)) == (fetched, free)
    world.bind(bound, world.stations[0])
    world.waiting[1] = fetched
    world.take_task(world.robots[0], fetched)
    for pod in (bound, fetched):
        assert impossible(checks.move, world, PodMove(pod.id, free)) == f"moves pod {pod.label}, which is in use"


def test_robots_without_a_task_rest_where_nobody_else_does(world: Warehouse) -> None:
    (one, other), free = world.robots, world.free_locations
    assert checks.rest(world, RobotMove(0, free[0])) == (one, free[0], 0.0)
    for cell, why in ((other.cell, "where another"), (one.cell, "where another"), (0, "no storage location")):
        told = impossible(checks.rest, world, RobotMove(0, cell))
        assert f"sent robot 1 (id 0) to rest in cell {cell}, {why}" in told
    world.reserve(free[1])
    world.bind(world.pods[0], world.stations[0])
    for cell in (free[0], world.pods[0].cell):
        world.reserve(cell) if cell in world.free_locations else None
        assert "where another robot or pod is or goes" in impossible(checks.rest, world, RobotMove(0, cell))
    assert "no charger" in impossible(checks.rest, world, RobotMove(0, world.free_locations[3], 0.5))
    assert "is 2.0; expected a share from 0 to 1" in impossible(checks.rest, world, RobotMove(0, free[3], 2.0))
    world.send(one, world.free_locations[3])
    assert impossible(checks.rest, world, RobotMove(0, world.free_locations[0])).endswith("to rest, which is busy")
