"""Planners by name: any PP rule, asked through its hook `plan_path`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pluggy
from attrs import frozen

from rmfs_core.clock import to_seconds
from rmfs_core.decisions import Path
from rmfs_core.errors import InputError, RuleError
from rmfs_core.hookspecs import DecisionHooks
from rmfs_core.rules.parameters import build
from rmfs_core.rules.sources import RuleSources
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.simulation.driving import reserves_of
from rmfs_core.traffic import Planner, Query, Reservations, ReservedError, Roads, TimedPath, occupancy, timed_path
from rmfs_core.traffic.asking import Traffic
from rmfs_core.warehouse import Robot, Warehouse, WarehouseView
from rmfs_core.world import Instance


@frozen
class Choice:
    """A planner, whether it is one that keeps clear of other robots' reservations, and the rule's class."""

    planner: Planner
    exclusive: bool
    rule: type


def find_planner(name: str, parameters: Mapping[str, Any], rng: np.random.Generator, folder: str = ".") -> Choice:
    """Return the planner of a name, or of a file and class: ``./my_rule.py:MyRule``.

    Parameters
    ----------
    name
        As for ``rules.pp`` in a scenario.
    parameters
        Values of the rule's parameters.
    rng
        For rules that draw random numbers.
    folder
        Where files are looked for.

    Raises
    ------
    InputError
        When there is no such rule, it takes no such parameters, or it plans no paths.
    """
    source = RuleSources(folder).find(name, "--pp")
    if not isinstance(source.target, type) or not hasattr(source.target, "__attrs_attrs__"):
        raise InputError("--pp", f"{source.describe()} is no attrs class")
    rule = build(source.target, parameters, "--set", source.describe())
    if hasattr(rule, "plan_path"):
        reserves = reserves_of(source.target, "--pp", source.describe())
        return Choice(HookPlanner(rule, source.describe(), rng), reserves is not None, source.target)
    raise InputError("--pp", f"{source.describe()} plans no paths; expected a rule for PP, such as sipp or free-flow")


class HookPlanner:
    """Asks a PP rule through its hook, in a warehouse with one robot and nothing else.

    Parameters
    ----------
    rule
        The rule.
    name
        What to call it in errors.
    rng
        The rule's random generator.
    """

    def __init__(self, rule: object, name: str, rng: np.random.Generator) -> None:
        self._hooks = pluggy.PluginManager("rmfs")
        self._hooks.add_hookspecs(DecisionHooks)
        self._hooks.register(rule)
        self._reserves = getattr(rule, "reserves", None)
        self._name = name
        self._rng = rng

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        """Return the rule's path; None where a rule that reserves finds none."""
        traffic = None if self._reserves is None else Traffic(roads, table, query)
        if traffic is None and query.cell == query.goal:
            return timed_path(roads, query, ())
        robot = Robot(0, query.cell, query.heading)
        warehouse = Warehouse(Instance((), (), ()), roads.travel, (), (robot,), ())
        warehouse.now = query.start_tick
        view = WarehouseView(warehouse)
        answer = self._hooks.hook.plan_path(
            warehouse=view, robot=robot, goal=query.goal, traffic=traffic, rng=self._rng
        )
        if answer is None and traffic is not None:
            return None
        if not isinstance(answer, Path):
            raise RuleError(f"{self._name} returned {type(answer).__name__} from plan_path; expected a Path.")
        try:
            checks.path(warehouse, robot, query.cell, query.goal, answer.legs)
        except ImpossibleError as error:
            raise RuleError(f"{self._name} {error}.") from error
        path = timed_path(roads, query, answer.legs)
        if traffic is not None:
            self._check_free(roads, table, query, path)
        return path

    def _check_free(self, roads: Roads, table: Reservations, query: Query, path: TimedPath) -> None:
        try:
            table.check(query.robot, occupancy(roads, path))
        except ReservedError as error:
            where, since_s = roads.layout.where(error.cell), to_seconds(error.since)
            raise RuleError(
                f"{self._name} gave robot {query.robot + 1} a path that hits a reservation: "
                f"robot {error.owner + 1} has {where} from {since_s:.3f} s on."
            ) from None
