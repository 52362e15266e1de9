"""Pods for the stations that lack one, chosen with and without what is kept of pods."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

import rmfs_core
from rmfs_commands.testing import small_world
from rmfs_core import hookimpl
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.warehouse import Pod, Station, Warehouse, WarehouseView
from rmfs_rules.demand import Demand
from rmfs_rules.helpers import send_pods, ticks_to_station
from rmfs_rules.helpers.pod_sending import KeptPods, KeptSums
from rmfs_rules.nearest_pod import NearestPod
from rmfs_rules.random import Random
from rmfs_rules.scorers import Completes, Lexicographic, WorkAmount


def test_whatever_is_kept_the_same_pods_are_offered() -> None:
    """To both, in a world that goes on: pods are bound, lifted, picked from and set down between two decisions.

    Where they are stored, and which may be moved, is kept, too.
    """
    pods = {"p": {"a": 2, "c": 1}, "q": {"a": 1, "b": 1}, "r": {"b": 3}, "s": {"c": 1}}
    world = small_world({"1": {"a": 2}, "2": {"b": 2}, "3": {"a": 1, "c": 1}}, pods, capacities=[9, 9])
    view, kept = WarehouseView(world), KeptPods()
    plain: list[Any] = []
    offered: list[Any] = []

    def choose(station: Station, given: list[Pod]) -> Pod:
        plain.append((station.id, [(pod.id, ticks_to_station(view, pod, station)) for pod in given]))
        return given[-1]

    def choose_kept(station: Station, given: Any) -> int:
        offered.append((station.id, list(zip(given.tolist(), kept.ticks(view, given, station).tolist(), strict=True))))
        return int(given[-1])

    def decide(max_fetches: int) -> None:
        kept.update(view)
        assert kept.places.tolist() == [-1 if pod.location is None else pod.location for pod in world.pods]
        free = [pod.location is not None and not pod.bound_for and pod.robot is None for pod in world.pods]
        assert kept.movable.tolist() == free
        assert send_pods(view, max_fetches, choose) == kept.send(view, max_fetches, choose_kept)
        assert plain == offered

    robot, pod, (here, there) = world.robots[0], world.pods[0], world.stations
    decide(9)
    for order, station in zip(world.orders, (here, there, there), strict=True):
        world.assign(order, station, [line.sku for line in order.open_lines])
        decide(9)
    decide(1)
    decide(0)
    world.place_at_station(robot, pod, here)
    decide(9)
    for request in here.open_requests:
        world.fulfil(request, pod)
    offered.clear()
    plain.clear()
    decide(0)
    assert [(station, [pod for pod, _ in given]) for station, given in offered] == [(1, [0])]
    decide(9)
    world.leave(robot, pod, here)
    world.reserve(world.homes[0])
    decide(9)
    world.move(robot, world.homes[0], 0)
    world.store(robot, pod)
    decide(9)
    assert len(offered) > 5
    moved = world.pods[3]
    world.waiting[moved.id] = moved
    world.take_task(robot, moved)  # to be carried elsewhere, without a visit
    decide(9)
    assert not kept.movable[moved.id]


def test_where_pods_are_stored_and_which_may_be_moved() -> None:
    """One is bound, lifted, and set down elsewhere."""
    world, kept = small_world({}, {"p": ["a"], "q": ["a"]}), KeptPods()
    robot, pod, station = world.robots[0], world.pods[1], world.stations[0]
    first, second = (pod.cell for pod in world.pods)

    def seen(world: Warehouse) -> list[tuple[int, bool]]:
        kept.update(WarehouseView(world))
        return list(zip(kept.places.tolist(), kept.movable.tolist(), strict=True))

    assert seen(world) == [(first, True), (second, True)]
    world.bind(pod, station)
    assert seen(world) == [(first, True), (second, False)]
    world.take_task(robot, pod)
    world.lift(robot, pod)
    assert seen(world) == [(first, True), (-1, False)]
    world.join_line(robot, station)
    world.leave(robot, pod, station)
    world.reserve(cell := world.free_locations[-1])
    world.move(robot, cell, 0)
    world.store(robot, pod)
    assert seen(world) == [(first, True), (cell, True)]
    assert seen(small_world({}, {"p": ["a"]})) == [(first, True)]


def test_sums_follow_items_and_what_is_wanted() -> None:
    """Of min(items, wanted) by pod; entries may be told twice, and where there are other pods all begins anew."""
    kept, sums = KeptPods(), KeptSums()
    kept.update(WarehouseView(small_world({}, {"p": {"a": 2, "b": 1}, "q": {"b": 4}})))
    entries = np.arange(3)
    assert sums.update(kept, entries, np.array([2, 1, 4]), np.array([1, 3])).tolist() == [2, 3]
    assert sums.update(kept, entries[:0], entries[:0], np.array([5, 0])).tolist() == [2, 0]
    assert sums.update(kept, entries[[0, 2, 0]], np.array([4, 1, 4]), np.array([3, 2])).tolist() == [4, 1]
    kept.update(WarehouseView(small_world({}, {"p": {"a": 2, "b": 1}, "q": {"b": 4}})))
    assert sums.of_free(kept, np.array([1, 3])).tolist() == [2, 3]
    assert sums.of_free(kept, np.array([9, 0])).tolist() == [2, 0]


@pytest.mark.parametrize("given", [{"a": 1}, {}])
def test_sums_take_in_many_new_skus_at_once(given: dict[str, int]) -> None:
    """However few a pod held before, and however many it was given since the last look."""
    skus = "abcdefghijkl"
    world = small_world({"1": [*skus]}, {"p": given, "q": dict.fromkeys("bc", 1)}, bundle_capacity=99)
    view, kept, sums = WarehouseView(world), KeptPods(), KeptSums()
    wanted = np.ones(len(skus), np.int64)
    kept.update(view)
    assert sums.of_free(kept, wanted).tolist() == [len(given), 2]
    for sku in range(1, len(skus)):
        bundle = world.bundle_arrives(sku, 3)
        world.assign_bundle(bundle, world.stations[0])
        world.bind_bundle(bundle, world.pods[0])
        world.store_bundle(bundle, world.pods[0])
        if sku in (9, 11):
            kept.update(view)
            assert sums.of_free(kept, wanted).tolist() == [len(given) + sku, 2]


class Doubter:
    """Observer that has each choice of pods made once more, by a rule that remembers nothing."""

    def __init__(self, rule: Callable[[], Any]) -> None:
        self.rule, self.trips = rule, 0

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Note which lots will be drawn."""
        self.state = None if question.rng is None else question.rng.bit_generator.state

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        if question.decides is Role.PPS:
            given: dict[str, Any] = {"warehouse": question.warehouse, "max_fetches": question.arguments["max_fetches"]}
            rule = self.rule()
            if not isinstance(rule, Demand | NearestPod):
                given["rng"] = np.random.default_rng()
                given["rng"].bit_generator.state = self.state
            assert list(answer) == list(rule.select_pods(**given))
            self.trips += len(answer)
            free = [*question.warehouse.free_pods, *question.warehouse.leaving_pods]
            assert all(pod.free_items(sku) == items for pod in free for sku, items in pod.contents.items())


RULES = (Demand, NearestPod, Random, Completes, partial(Completes, count_backlog=True), WorkAmount, Lexicographic)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: str(rule()))
@pytest.mark.parametrize(
    ("scenario", "overrides"),
    [
        ("paper-250", ["instance.orders=90", "run.until_s=900"]),
        ("paper-250", ["instance.orders=90", "run.until_s=900", "instance.items_per_sku=3"]),
        ("examples/replenished", ["run.until_s=2400"]),
        ("examples/small", ["rules.move=utility", "robots.count=7"]),
    ],
    ids=["unlimited", "finite", "replenished", "moved"],
)
def test_what_is_kept_decides_as_what_is_read_anew(rule: Any, scenario: str, overrides: list[str]) -> None:
    """In whole runs: pods come and go, become empty, and are given SKUs that they never held."""
    doubter = Doubter(rule)
    rmfs_core.run(scenario, overrides=[*overrides, "rules.pp=free-flow"], rules={"pps": rule()}, observers=[doubter])
    assert doubter.trips > 20
