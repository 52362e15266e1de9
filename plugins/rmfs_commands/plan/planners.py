"""Planners by name: any PP rule, asked through its hook for one robot at a time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rmfs_commands.cli.single_rule import load_rule, reserving_way
from rmfs_core.decisions import Path
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule
from rmfs_core.scenario import RuleChoice
from rmfs_core.simulation import checks
from rmfs_core.simulation.asking import Asker, instance_of
from rmfs_core.warehouse import Robot, Warehouse, WarehouseView
from rmfs_core.world import Instance
from rmfs_traffic import (
    FleetTraffic,
    Query,
    Reservations,
    ReservedError,
    Roads,
    TimedPath,
    Traffic,
    occupancy,
    timed_path,
)
from rmfs_traffic.complete import CompleteDriving


def find_planner(
    name: str, parameters: Mapping[str, Any], rng: np.random.Generator, *, allow_inline: bool = True
) -> HookPlanner:
    """Return the planner of a name, or of a file in the current folder and its class: ``./my_rule.py:MyRule``.

    Parameters
    ----------
    name
        As for ``rules.pp`` in a scenario.
    parameters
        Values of the rule's parameters.
    rng
        For rules that draw random numbers.
    allow_inline
        Whether code may be loaded from a file.

    Raises
    ------
    InputError
        When there is no such rule, it takes no such parameters, or it plans no paths.
    """
    rule = load_rule(RuleChoice(name, parameters), (Role.PP,), allow_inline=allow_inline, place="--pp")
    return HookPlanner(rule, rng)


class HookPlanner:
    """Asks a PP rule through its hook, in a warehouse with one robot and nothing else.

    Parameters
    ----------
    rule
        The rule.
    rng
        The rule's random generator.

    Attributes
    ----------
    exclusive
        Whether it keeps clear of other robots' reservations.
    complete
        Whether each of its paths ends at the goal.
    """

    def __init__(self, rule: BoundRule, rng: np.random.Generator) -> None:
        self.rule = rule
        way = reserving_way(rule, "--pp", "which asks for paths in a run only")
        self.exclusive = way is not None
        self.complete = way is not None and issubclass(way, CompleteDriving)
        self._at_once = way is not None and way.hook == "plan_paths"
        self._rng = rng

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        """Return the rule's path; None where a rule that reserves finds none."""
        traffic = Traffic(roads, table, query) if self.exclusive else None
        if traffic is None and query.cell == query.goal:
            return timed_path(roads, query, ())
        robot = Robot(0, query.cell, query.heading)
        warehouse = Warehouse(Instance((), (), ()), roads.travel, (), (robot,), ())
        warehouse.advance(query.start_tick)
        asker = Asker(warehouse)
        asked: dict[str, Any] = {"robot": robot, "goal": query.goal, "traffic": traffic}
        if self._at_once:
            asked = {"queries": (query,), "traffic": FleetTraffic(roads, table, {}, {}, {})}
        answer, _ = asker.ask(self.rule, asked | {"warehouse": WarehouseView(warehouse), "rng": self._rng})
        if isinstance(answer, dict) and "queries" in asked:
            answer = answer.get(query.robot)
        if answer is None and traffic is not None:
            return None

        def check() -> TimedPath:
            legs = checks.path(warehouse, robot, query.cell, query.goal, instance_of(answer, Path))
            path = timed_path(roads, query, Path(legs).legs)
            if traffic is not None:
                try:
                    table.check(query.robot, occupancy(roads, path))
                except ReservedError as error:
                    raise checks.hit(roads.layout, query.robot, error) from None
            return path

        return asker.apply(self.rule, check)
