"""Each shipped rule, with all its parameters, against a literal version of its definition on random worlds.

Nothing else is to be said of what is in `rmfs_rules.common_lines`, `rmfs_rules.demand`, `rmfs_rules.first_come`,
`rmfs_rules.fixed`, `rmfs_rules.free_flow`, `rmfs_rules.near_best_pod`, `rmfs_rules.nearest`, `rmfs_rules.nearest_pod`,
`rmfs_rules.nearest_robot` and `rmfs_rules.waves`.
"""

import inspect
import random
from collections.abc import Iterator
from importlib.metadata import entry_points
from itertools import permutations
from typing import Any

import attrs
import pytest
from attrs import frozen

from cases import cases
from oracles import joint, orders, packing, places, pod_index, pods, robots
from oracles.switch import next_case, switched
from oracles.worlds import Run
from rmfs_core.rules.hooks import OBSERVER_HOOKS, marked_methods
from rmfs_core.rules.sources import RuleSources
from rmfs_rules.switch import Case

ELSEWHERE = {
    "remote": "tests/plugins/rmfs_commands/remote: another program decides",
    "learned": "tests/plugins/rmfs_commands/gym: the network by hand, and the choices by plain searches",
    "integrated": "tests/plugins/rmfs_rules/mip: a model of its own, solved without what the rule knows",
    "split-among-stations": "tests/plugins/rmfs_rules/mip",
    "split-over-time": "tests/plugins/rmfs_rules/mip",
    "sipp": "tests/plugins/rmfs_rules/test_paths.py: a plain search",
    "pbs": "tests/plugins/rmfs_rules/test_paths.py",
    "whca-n": "tests/plugins/rmfs_rules/test_paths.py: a plain search",
}
"""Rules that are compared in other tests, and where."""

LANE: dict[str, Any] = {"max_wait_s": (0.0, 100.0, 600.0, 2000.0), "fast_lane": range(4)}
PAIRS: dict[str, Any] = LANE | {"tie_break": ("oldest", "due", "random"), "late_first": (False, True)}
WEIGHTS: dict[str, Any] = {
    "value": ("picks", "age", "lateness"),
    "backlog_weight": (0.0, 0.2, 2.0),
    "completion_boost": (0.0, 1.0, 3.0),
    "time_cost_per_s": (0.0, 0.03, 1 / 3),
}
BORDERS = ((0.1, 0.3, 1.0), (0.5, 1.0), (1.0,), (0.2, 0.4, 0.6, 0.8, 1.0))
MAX_WAIT_S: dict[str, Any] = {"max_wait_s": LANE["max_wait_s"]}

WORTH: dict[str, Any] = {
    "weight_speed": (0.0, 1.0, 2.0),
    "weight_demand": (0.0, 1.0, 0.5),
    "retry_s": (60.0, 120.0, 400.0),
}
CACHE: dict[str, Any] = WORTH | {
    "share": (0.0, 0.25, 0.5, 1.0),
    "threshold": (0.0, 0.3, 0.5, 0.9),
    "free_places": range(21),
}
UTILITY: dict[str, Any] = WORTH | {"corridor": range(1, 5), "buffer": (0.0, 0.05, 0.5, 1.0)}
JOINT: dict[str, Any] = MAX_WAIT_S | {"unused_capacity_weight": (0.1, 0.5, 2.0, 5.0)}
POD_INDEX: dict[str, Any] = {
    "visit_s": (47.0, 300.0),
    "cost_s": (0.0, 310.0, 1000.0),
    "finish": (0.0, 0.85, 1.0),
    "stay": (0.0, 0.83, 1.37),
    "elsewhere": (0.0, 0.71, 1.0),
    "most_pods": range(1, 4),
    "urge_s": (0.0, 170.0, 2000.0),
    "full": (1.0, 5.0, 31.0),
    "base_s": (1.0, 10.0, 100.0),
    "handle_s": (5.0, 13.0),
    "near": (0.0, 0.21, 1.0),
    "again": (0.0, 0.31, 1.0),
    "packing_capacity": range(1, 4),
    "packing_work_s": (0.0, 2.0, 5.0, 11.0),
    "priority_factor": (1.0, 1.7, 3.0),
    "due_factor": (1.0, 3.1),
    "due_s": (100.0, 1800.0),
    "max_wait_s": (0.0, 100.0, 600.0),
}


@frozen
class Oracle:
    """Literal versions of what a rule decides."""

    rule: str  # its name
    literals: dict[str, Any]  # by hook. A hook is asked after those before it; all share what they remember
    parameters: dict[str, Any]  # what is tried of each of its parameters
    run: dict[str, Any]  # what kind of run
    every: int = 1  # of so many runs one is tried

    @property
    def kind(self) -> Any:
        return RuleSources(".").find(self.rule, "rule").target

    def drawn(self, lots: random.Random) -> dict[str, Any]:
        required = {one.name for one in attrs.fields(self.kind) if one.default is attrs.NOTHING}
        given = [name for name in self.parameters if name in required or lots.random() < 0.6]
        return {name: lots.choice(self.parameters[name]) for name in given}

    def hold(self, run: Run, parameters: dict[str, Any]) -> None:
        """Compare the decisions of one rule at two moments of a run."""
        rule, memory, world = self.kind(**parameters), {}, run.begin()
        for phase in range(2):
            run.go_on(world, phase)
            for hook, literal in self.literals.items():
                asked = run.moment(world, phase, {})
                if not asked.answers(hook):
                    continue
                method = getattr(rule, marked_methods(self.kind)[hook])
                answer = method(**{name: getattr(asked, name) for name in inspect.signature(method).parameters})
                if isinstance(answer, (list, tuple)):
                    answer = [getattr(one, "name", one) for one in answer]  # orders of two worlds, by their names
                assert answer == literal(run.moment(run.world(phase), phase, memory), answer, **parameters)


def rules_for(hook: str, rules: dict[str, tuple[Any, dict[str, Any]]], **run: Any) -> list[Oracle]:
    return [Oracle(name, {hook: literal}, parameters, run) for name, (literal, parameters) in rules.items()]


def switches(hook: str, rules: dict[str, Any]) -> Oracle:
    """Return the oracle of a switch between rules with a literal version each."""
    first, other = rules
    cases = (
        (Case(first),),
        (Case(first, before_s=1000.0), Case(other)),
        (Case(other, before_s=1200.0), Case(first)),
        (Case(other, backlog_below=3), Case(first)),
        (Case(first, before_s=1200.0, backlog_below=2), Case(first, backlog_below=5), Case(other)),
    )
    literals = {hook: switched(rules), "wake_at": next_case}
    return Oracle("switch", literals, {"cases": cases}, {"filtered": hook == "assign_orders"})


ORACLES: list[Oracle] = [
    *rules_for(
        "assign_orders",
        {
            "pod-match": (orders.pod_match, PAIRS | {"spread": (0.0, 0.5, 2.0)}),
            "common-lines": (orders.common_lines, PAIRS),
            "first-come": (orders.first_come, PAIRS),
            "workload": (orders.workload, PAIRS | {"prefer": ("fewest", "most")}),
            "near-best-pod": (orders.near_best_pod, PAIRS),
            "earliest-due": (orders.earliest_due, LANE),
            "least-slack": (orders.least_slack, LANE | {"item_s": (0.0, 13.0, 100.0)}),
            "random": (orders.drawn, MAX_WAIT_S),
            "station-queue": (
                orders.station_queue,
                {"queue_length": range(1, 5), "urgent_s": (0.0, 300.0, 600.0), "fast_lane": range(3)},
            ),
        },
        filtered=True,
    ),
    Oracle(
        "most-covered",
        {"filter_backlog": orders.most_covered},
        {"n": range(1, 6), "lines": ("all", "open")},
        {"filtered": True},
    ),
    Oracle(
        "waves",
        {"filter_backlog": orders.waves, "wake_at": orders.next_wave},
        {"every_s": (200.0, 400.0, 999.0), "orders": range(1, 4)},
        {"filtered": True},
    ),
    *rules_for(
        "select_pods",
        {
            "demand": (pods.most_wanted, {}),
            "nearest-pod": (pods.nearest_pod, {}),
            "random": (pods.drawn, MAX_WAIT_S),
            "completes": (pods.completes_most, {"count_backlog": (False, True)}),
            "work-amount": (pods.work_amount, WEIGHTS),
            "lexicographic": (
                pods.lexicographic,
                WEIGHTS
                | {
                    "scores": [*permutations(("completes", "picks", "work", "demand", "nearest", "random"), 3)],
                    "count_backlog": (False, True),
                },
            ),
        },
    ),
    *rules_for(
        "assign_bundles",
        {
            "first-bundle": (pods.first_bundle, {}),
            "same-pod": (pods.same_pod, {}),
            "random": (pods.drawn_stations, MAX_WAIT_S),
        },
        stocked=True,
    ),
    *rules_for(
        "select_replenishment_pods",
        {name: (pods.stores(cost), {}) for name, cost in pods.COSTS.items()}
        | {
            "turnover-pod": (pods.stores(pods.class_apart), {"borders": BORDERS}),
            "random": (pods.drawn_pods, MAX_WAIT_S),
        },
        stocked=True,
    ),
    *rules_for("assign_bundles_and_pods", {"pod-first": (pods.pod_first, {"pod": (*pods.COSTS,)})}, stocked=True),
    *rules_for(
        "choose_storage_location",
        {
            "nearest": (places.nearest, {}),
            "fixed": (places.fixed, {}),
            "random": (places.drawn, MAX_WAIT_S),
            "station-based": (places.station_based, {}),
            "turnover-classes": (places.turnover_classes, {"borders": BORDERS}),
            "cache": (places.cache, CACHE),
            "utility": (places.utility, UTILITY),
        },
        crowded=True,
    ),
    *(
        Oracle(name, {"move_pods": places.paused(moves), "wake_at": places.pause_ends}, parameters, {"crowded": True})
        for name, moves, parameters in (
            ("cache", places.cache_moves, CACHE),
            ("utility", places.utility_moves, UTILITY),
        )
    ),
    *rules_for(
        "assign_tasks",
        {
            "nearest-robot": (robots.nearest_robot, {}),
            "random": (robots.drawn, MAX_WAIT_S),
            "assignment": (robots.assignment, {"defer_s": (0.0, 3.0, 30.0)}),
            "balanced": (robots.balanced, {"reallocation_s": (0.0, 100.0, 500.0), "help_others": (False, True)}),
        },
        crowded=True,
    ),
    *rules_for(
        "idle_robots",
        {
            "stay": (robots.stay, {}),
            "rest-nearest": (robots.rest(robots.empty_ticks), {}),
            "rest-middle": (robots.rest(robots.from_middle), {}),
        },
        crowded=True,
    ),
    *rules_for(
        "idle_robots",
        {"charge-when-low": (robots.charge_when_low, {"low": (0.0, 0.2, 0.3), "full": (0.5, 0.8, 1.0)})},
        crowded=True,
        batteries=True,
    ),
    *rules_for(
        "activate_stations",
        {
            "all": (robots.activate_all, {}),
            "constant-ratio": (robots.constant_ratio, {"ratio": (0.1, 0.34, 0.5, 0.67, 1.0)}),
            "backlog-threshold": (
                robots.backlog_threshold,
                {"open_above": range(5), "timeout_s": (0.0, 100.0, 600.0), "least": range(1, 4)},
            ),
        },
    ),
    *rules_for(
        "assign_packing",
        {"least-reserved": (packing.least_reserved, {}), "nearest": (packing.nearest, {})},
        packing=True,
    ),
    *rules_for(
        "choose_packing_task",
        {
            "first-come": (packing.first_come, PAIRS),
            "pack-first": (packing.pack_first, {}),
            "due-first": (packing.due_first, {}),
            "shortest": (packing.shortest, {}),
        },
        packing=True,
    ),
    *rules_for(
        "assign_orders_and_pods",
        {
            "alternating": (joint.alternating, JOINT | {"rounds": range(1, 5)}),
            "two-stage": (
                joint.two_stage,
                MAX_WAIT_S | {"first_share": (0.2, 0.5, 0.75, 1.0), "first_orders": ("cheapest", "oldest")},
            ),
            "lns": (joint.lns, JOINT | {"iterations": range(6), "share": (0.3, 0.7, 1.0)}),
        },
        filtered=True,
    ),
    Oracle(
        "pod-index",
        {"assign_orders_and_pods": pod_index.pod_index, "wake_at": pod_index.wake_at},
        POD_INDEX,
        {"filtered": True, "single": True},
    ),
    Oracle(
        "pod-index",
        {"assign_orders_and_pods": pod_index.pod_index, "wake_at": pod_index.wake_at},
        POD_INDEX,
        {"filtered": True, "single": True, "packing": True},
    ),
    switches("assign_orders", {"pod-match": orders.pod_match, "first-come": orders.first_come}),
    switches("select_pods", {"demand": pods.most_wanted, "random": pods.drawn}),
    switches("choose_storage_location", {"nearest": places.nearest, "station-based": places.station_based}),
    switches("assign_tasks", {"nearest-robot": robots.nearest_robot, "random": robots.drawn}),
    Oracle("free-flow", {"plan_path": robots.fastest}, {}, {"crowded": True}, every=10),
]


@cases("seeds", range(200), pytest.param(range(200, 2000), marks=pytest.mark.slow), ids=["some", "many"])
@pytest.mark.parametrize("oracle", ORACLES, ids=lambda oracle: f"{oracle.rule}-{next(iter(oracle.literals))}")
def test_a_rule_decides_as_its_definition_says(oracle: Oracle, seeds: range) -> None:
    """In runs of all sizes; a rule that is slow to check by hand in fewer of them."""
    for seed in seeds[:: oracle.every]:
        parameters = oracle.drawn(random.Random(f"{seed} drawn"))
        try:
            oracle.hold(Run(seed, seed % 5, **oracle.run), parameters)
        except Exception as error:
            error.add_note(f"{oracle.rule}: Run({seed}, {seed % 5}, **{oracle.run}), parameters {parameters}")
            raise


def test_lns_looks_at_few_of_many_orders(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rmfs_rules.joint.lns.MOST_ORDERS", 3)
    monkeypatch.setattr(joint, "MOST_ORDERS", 3)
    (oracle,) = (oracle for oracle in ORACLES if oracle.rule == "lns")
    for seed in range(60):
        oracle.hold(Run(seed, 3, filtered=True), {"iterations": 4})


def shipped() -> Iterator[tuple[str, set[str], set[str]]]:
    for point in entry_points(group="rmfs.rules"):
        if point.dist is not None and point.dist.name == "rmfs" and point.name not in ELSEWHERE:
            kind = point.load()
            parameters = {one.name for one in attrs.fields(kind) if one.init and one.name[0] != "_"}
            yield point.name, marked_methods(kind).keys() - OBSERVER_HOOKS, parameters


@pytest.mark.parametrize(("name", "hooks", "parameters"), [pytest.param(*rule, id=rule[0]) for rule in shipped()])
def test_every_rule_has_a_literal_version(name: str, hooks: set[str], parameters: set[str]) -> None:
    """Of all that it decides, with all its parameters; or it is named in `ELSEWHERE`."""
    found = [oracle for oracle in ORACLES if oracle.rule == name]
    assert {hook for oracle in found for hook in oracle.literals} == hooks
    assert all(oracle.parameters.keys() == parameters for oracle in found)
