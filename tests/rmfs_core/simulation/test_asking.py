"""Ends of runs: rules and observers that raise or take too long, and impossible decisions."""

import os
import re
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba.core.compiler_lock import global_compiler_lock

import rmfs_core
from bad_rules import HOOKS, prepare_bad, what_ends
from cases import cases
from rmfs_commands.testing import small_instance, small_world
from rmfs_core import hookimpl
from rmfs_core.decisions import Leg, OrderAssignment, PodMove, PodTrip, RobotMove
from rmfs_core.decisions import Path as Way
from rmfs_core.errors import RuleError
from rmfs_core.events import Event, ItemPicked, OrderAssigned
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.scenario.model import RunSection
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import Asker, ImpossibleError, Observers
from rmfs_core.simulation.limits import OverdueError, within
from rmfs_core.warehouse import Warehouse
from rmfs_traffic import ReservedError
from rmfs_traffic.paths import ends_of
from saying import said
from scripted import run_of, scripted
from told import Prepare, ToldRun

WHATEVER = [
    *((role, "raise RuntimeError('no idea')", "raised RuntimeError: no idea (") for role in HOOKS),
    *((role, "return None", "returned None; expected ") for role in HOOKS if role != "pr"),
    *((role, "return 'pod'", "returned str 'pod'; expected ") for role in HOOKS if role != "pr"),
    ("pr", "return None", "named cell None; expected a whole number"),
    ("pr", "return 'pod'", "named cell 'pod'; expected a whole number"),
    ("poa", "raise SystemExit(0)", "raised SystemExit: 0 ("),
    ("poa", "import asyncio; raise asyncio.CancelledError('no')", "raised CancelledError: no ("),
]


@pytest.mark.parametrize(
    "body",
    [
        "return warehouse.fits(None, warehouse.stations[0])",
        "from rmfs.helpers import send_pods; return send_pods(warehouse, 9, lambda station, pods: pods[0])",
    ],
)
def test_an_error_within_the_kernel_or_a_helper_names_the_line_of_the_rule(tiny_run, tmp_path, body) -> None:
    assert re.search(r"\(.*bad\.py, line 11\)", what_ends(prepare_bad(tiny_run, tmp_path, "pps", body), "pps"))


@pytest.mark.parametrize("role", HOOKS)
def test_a_rule_that_takes_too_long_is_named_when_a_limit_is_set(tiny_run: Prepare, tmp_path: Path, role: str) -> None:
    slow = RunSection(decision_limit_s=0.3)
    run = prepare_bad(tiny_run, tmp_path, role, "time.sleep(0.35); return []", run=slow)
    with pytest.raises(
        RuleError, match=rf"{HOOKS[role]}, at \d+\.\d+ s: took \S+ s; the scenario allows run\.decision_l"
    ):
        run.simulation.run()


@cases(
    "iterates message",
    ("1 / 0", "returned a Monster, which raised ZeroDivisionError"),
    ("iter([1])", "returned a sequence with int 1 in it; expected PodTrip only"),
)
def test_an_answer_that_is_a_monster(tiny_run: Prepare, tmp_path: Path, iterates: str, message: str) -> None:
    made = f"type('Monster', (list,), {{'__iter__': lambda self: {iterates}, '__repr__': lambda self: exit()}})()"
    assert message in what_ends(prepare_bad(tiny_run, tmp_path, "pps", f"return {made}"), "pps")


@cases(
    "named message",
    ("object()", "named pod <object object>; expected a whole number"),
    ("type('Mute', (), {'__repr__': lambda self: 1 / 0})()", "named pod a Mute; expected a whole number"),
    ("type('Index', (), {'__index__': lambda self: 1 / 0})()", "an answer that raised ZeroDivisionError: division by"),
    ("type('Index', (), {'__index__': lambda self: exit(3)})()", "gave an answer that raised SystemExit: 3 ("),
)
def test_a_name_that_is_a_monster(tiny_run: Prepare, tmp_path: Path, named: str, message: str) -> None:
    body = f"from rmfs import PodTrip; return [PodTrip({named}, 0)]"
    assert message in what_ends(prepare_bad(tiny_run, tmp_path, "pps", body), "pps")


def test_an_error_of_the_kernel_is_not_the_rule_s(tiny_run: Prepare, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(checks, "selected_trip", checks.covered)  # which takes other arguments
    with pytest.raises(TypeError, match="covered"):
        prepare_bad(tiny_run, tmp_path, "pps", "from rmfs import PodTrip; return [PodTrip(0, 0)]").simulation.run()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no os.fork")
@pytest.mark.parametrize("copy", ["return []", "raise ValueError", "raise SystemExit(0)"])
def test_a_copy_that_a_rule_makes_does_not_simulate(copy: str, tmp_path: Path) -> None:
    """It would write results, too: it ends where the rule would have returned."""
    run, rule = run_of(small_world({"1": ["a"]}, {"p": ["a"]}), tmp_path)

    def forking(_: Any) -> int:
        child = os.fork()
        if not child:
            exec(copy.replace("return []", "return_ = []"))
        return child

    rule.answers["plan_path"] = [forking]
    arguments = {"warehouse": run.view, "rng": None, "robot": 1, "goal": 2, "traffic": None}
    child, _ = run.asker.ask(run.rules.pp, arguments)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1


def observed(tiny_run: Prepare, folder: Path, method: str, head: str = "") -> ToldRun:
    source = f"from attrs import define\nfrom rmfs_core import hookimpl\n{head}@define\nclass Bad:\n    @hookimpl\n"
    (folder / "bad.py").write_text(f"{source}    {method}\n", encoding="utf-8")
    return tiny_run(small_instance({"1": ["a"]}, {"p": ["a"]}), observers=["./bad.py:Bad"])


@pytest.mark.parametrize("hook", ["on_event(self, event)", "run_started(self, run)"])
@cases("body problem", ("raise OSError('full')", "OSError: full"), ("Fraction('a')", "ValueError: Invalid literal"))
def test_an_observer_that_raises_is_named(tiny_run, tmp_path, hook, body, problem) -> None:
    """With its own line, also where a library raises."""
    with pytest.raises(RuleError, match=rf'rule "\./bad\.py:Bad" .*{problem}.* \(\S*bad\.py, line 7\)'):
        observed(tiny_run, tmp_path, f"def {hook}: {body}", "from fractions import Fraction\n").done()


def test_observers_hear_and_change_no_answer(tiny_run: Prepare, tmp_path: Path) -> None:
    method = "def rule_answered(self, answer): answer.clear() if isinstance(answer, list) else None"
    assert observed(tiny_run, tmp_path, method).done().simulation.status == "complete"


class Asked:
    def __init__(self) -> None:
        self.heard: list[Any] = []

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        self.heard.append(question)

    @hookimpl
    def rule_answered(self, question: Question, answer: object) -> None:
        self.heard.append((question, answer))


def test_observers_hear_questions_and_answers(tmp_path: Path) -> None:
    world = small_world({"1": ["a"]}, {"p": ["a"]})
    first, _ = run_of(world, tmp_path, filters=(scripted("Waking"),))
    assert not first.observers.hear_questions
    listener = Asked()
    first.rules.register_observer(listener)
    observers = Observers(first.rules, world)
    assert observers.hear_questions
    asker, rule = Asker(world, None, observers), first.rules.pp.instance
    asker.period = 3
    rule.answers["plan_path"] = ["over there", lambda _: 1 / 0]
    arguments = {"warehouse": first.view, "rng": np.random.default_rng(1), "robot": 7, "goal": 5, "traffic": None}
    asker.ask(first.rules.pp, arguments)
    question, (same, answer) = listener.heard
    assert (question is same, answer) == (True, "over there")
    assert (question.decides, question.hook, question.period) == (Role.PP, "plan_path", 3)
    assert question.rule == "./scripted_rules.py:Scripted"
    assert (question.warehouse, question.rng) == (first.view, arguments["rng"])
    assert question.arguments == {"robot": 7, "goal": 5, "traffic": None}
    with pytest.raises(RuleError):
        asker.ask(first.rules.pp, arguments)
    assert len(listener.heard) == 3
    (waking,) = first.rules.filters  # of that they are not told
    asker.ask(waking, {"warehouse": first.view, "rng": None}, waking.wake)
    assert (len(listener.heard), asker.calls["wake_at"]) == (3, 1)


class Hearing:
    """Observer that listens to nothing, to some kinds of events, or to some with a function for each."""

    def __init__(self, hears: Any = None) -> None:
        self.heard: list[Event] = []
        if hears is not None:
            self.hears = hears

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.heard.append(event)


def test_an_observer_hears_what_it_listens_to() -> None:
    told: list[tuple[str, Event]] = []
    calls = [lambda event: told.append(("first", event)), lambda event: told.append(("second", event))]
    every, choosy, several = Hearing(), Hearing((ItemPicked,)), Hearing({ItemPicked: calls})
    overrides = ["run.until_s=200", "rules.pp=free-flow"]
    rmfs_core.run("examples/small", overrides=overrides, observers=[every, choosy, several])
    picked = [event for event in every.heard if isinstance(event, ItemPicked)]
    assert choosy.heard == picked != []
    assert told == [(name, event) for event in picked for name in ("first", "second")]
    assert several.heard == []


needs_alarms = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no signal.setitimer")


def compute() -> None:
    while True:
        pass


def catch() -> None:
    while True:
        try:
            time.sleep(60)
        except Exception:
            continue


def catch_all_once() -> None:
    try:
        time.sleep(60)
    except BaseException:
        compute()


def wait_for_a_lock() -> None:
    lock = threading.Lock()
    with lock:
        lock.acquire()


@needs_alarms
@pytest.mark.parametrize("call", [compute, catch, catch_all_once, wait_for_a_lock])
def test_a_call_that_never_returns_is_ended(call: Callable[[], None]) -> None:
    """Whether it computes, waits, or catches what goes wrong; who else uses the signal has it back."""
    before = signal.getsignal(signal.SIGALRM)
    started = time.monotonic()
    with pytest.raises(OverdueError):
        within(0.05, call, {})
    assert time.monotonic() - started < 20
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0


@needs_alarms
def test_compiling_goes_on() -> None:
    """Else a machine that is slow would begin anew each time."""

    def compiling() -> str:
        with global_compiler_lock:
            time.sleep(0.2)
        return "compiled"

    assert within(0.05, compiling, {}) == "compiled"


def test_outside_the_main_thread_a_call_goes_on() -> None:
    found: list[Any] = []

    def slow() -> str:
        time.sleep(0.1)
        return "done"

    thread = threading.Thread(target=lambda: found.append(within(0.01, slow, {})))
    thread.start()
    thread.join()
    assert found == ["done"]


ORDER, POD, NAMED = "order one (id 0) to station 1 (id 0)", "to station 1 (id 0)", "expected a whole number"
TWICE = "OrderAssignment(0, 0), OrderAssignment"
WAITS = f"expected 0 to {checks.LONGEST_WAIT_TICKS}, and at least 1 for a leg that only waits"
WRONG = [
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
    ("poa", "import numpy as np; return [OrderAssignment(np.True_, 0)]", f"named order {np.True_!r}; {NAMED}"),
    ("poa", "return [OrderAssignment(0, 0, skus=5)]", "SKUs 5 of order one (id 0); expected a sequence of ids"),
    ("poa", "return [OrderAssignment(0, 0, skus=iter([0]))]", "of order one (id 0); expected a sequence of ids"),
    ("poa", "import numpy as np; return [OrderAssignment(0, 0, np.array(0))]", "(id 0); expected a sequence of ids"),
    ("poa", "return [OrderAssignment(0, 0, skus=(0.0,))]", f"named SKU id 0.0; {NAMED}"),
    ("pps", "return {PodTrip(0, 0)}", "returned set {PodTrip(pod=0, station=0)}; expected a sequence of PodTrip"),
    ("pps", "return b''", "returned bytes b''; expected a sequence of PodTrip"),
    ("pps", "return [PodTrip(0, 0), None]", "returned a sequence with None in it; expected PodTrip only"),
    ("pps", "return [PodTrip(9, 0)]", "named pod 9, which does not exist; ids are 0 to 2"),
    ("pps", "return [PodTrip(-1, 0)]", "named pod -1, which does not exist; ids are 0 to 2"),
    ("pps", "return [PodTrip(0, 0), PodTrip(0, 0)]", f"pod p (id 0) {POD}, but it is there or bound for it"),
    ("pps", "return [PodTrip(2, 0)]", f"pod r (id 2) {POD}, but it holds no item of any request uncovered there"),
    (
        "pps",
        "return [PodTrip(0, 0), PodTrip(1, 0)] if max_fetches == 1 else []",
        "sent too many stored pods (2); expected at most 1, the robots that can start",
    ),
    ("poa_pps", "return 'x' * 500", f"returned str '{'x' * 79}; expected JointDecision"),
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
    ("idle", "return [RobotMove(5, 0)]", "named robot 5, which does not exist; ids are 0 to 0"),
    ("idle", "return [RobotMove(0, 0)] if warehouse.resting_robots else []", "to rest in cell 0, no storage location"),
    ("move", "return [3]", "returned a sequence with int 3 in it; expected PodMove only"),
    ("move", "return [PodMove(9, 0)]", "named pod 9, which does not exist; ids are 0 to 2"),
    ("move", "return [PodMove(2, 0), PodMove(2, 0), PodMove(2, 0)]", "moves too many pods (3); expected at most 1 now"),
    ("move", "return [PodMove(2, warehouse.pods[2].cell)]", "stores pod r (id 2) at row"),
    ("pp", "return Path()", "gave robot 1 (id 0) an empty path to "),
    ("pp", "return Path([Leg(-5)])", "sent robot 1 (id 0) to cell -5, which is not on the grid"),
    ("pp", "return Path([Leg(robot.cell)])", f"gave robot 1 (id 0) a leg that waits 0 ticks and goes nowhere; {WAITS}"),
    ("pp", "return Path([Leg(robot.cell, -1)])", f"waits -1 ticks and goes nowhere; {WAITS}"),
    ("pp", "return Path([Leg(robot.cell, 10**14)])", f"waits 100000000000000 ticks and goes nowhere; {WAITS}"),
    ("pp", "return Path([Leg(robot.cell, 0.5)])", f"named wait_ticks 0.5; {NAMED}"),
    ("pp", "return Path([Leg(None)])", f"named cell None; {NAMED}"),
    ("pp", "return Path([Leg(robot.cell, 60000)])", " for 3660 s (longer than run.standstill_s and than 10 crossings"),
    ("pp", "return Path([3])", "returned a path with int 3 in it; expected Leg only"),
    ("pp", "return Path([Leg(warehouse.stations[0].cell)])", "gave robot 1 (id 0) an impossible path: "),
    ("filters", "return orders + orders[:1] + (warehouse.orders[0],) + tuple('x')", "in it; expected Order only"),
]


@pytest.mark.parametrize(("role", "body", "message"), WHATEVER + WRONG)
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
    assert Way(checks.path(world, robot, start, goal, Way(legs))) == Way([Leg(start, 70), *fastest])
    assert checks.path(world, robot, goal, goal, Way()).tolist() == []
    most = checks.LONGEST_WAIT_TICKS
    assert checks.path(world, robot, start, goal, Way([Leg(start, most)])).tolist() == [[start, most]]


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
    for cell, why in ((other.cell, "which a robot"), (one.cell, "which a robot"), (0, "no storage location")):
        told = impossible(checks.rest, world, RobotMove(0, cell))
        assert f"sent robot 1 (id 0) to rest in cell {cell}, {why}" in told
    world.reserve(free[1])
    world.bind(world.pods[0], world.stations[0])
    for cell in (free[0], world.pods[0].cell):
        world.reserve(cell) if cell in world.free_locations else None
        assert "which a robot or pod occupies or is bound for" in impossible(checks.rest, world, RobotMove(0, cell))
    assert "no charger" in impossible(checks.rest, world, RobotMove(0, world.free_locations[3], 0.5))
    assert "is 2.0; expected a share from 0 to 1" in impossible(checks.rest, world, RobotMove(0, free[3], 2.0))
    world.send(one, world.free_locations[3])
    assert impossible(checks.rest, world, RobotMove(0, world.free_locations[0])).endswith("to rest, which is busy")
