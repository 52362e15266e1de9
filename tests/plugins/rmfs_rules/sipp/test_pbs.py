"""PP rule `pbs`: who yields, and that its answer is no worse than planning one after another."""

from __future__ import annotations

import numpy as np
import pytest

from crowds import newcomer, paper_roads
from rmfs_commands.testing import check_rule
from rmfs_core import Path
from rmfs_core.traffic import FleetTraffic, Occupancy, Query, Reservations, Roads, occupancy, timed_path
from rmfs_rules.sipp import Pbs, Sipp


def arrivals(roads: Roads, answer: dict[int, Path], queries: list[Query], arrives: dict[int, int]) -> int:
    """Sum of all arrivals with an answer, which is held against a table."""
    table = Reservations(roads.cells)
    total = 0
    for query in queries:
        if query.robot in answer:
            path = timed_path(roads, query, answer[query.robot].legs)
            assert path.end == query.goal
            table.commit(query.robot, occupancy(roads, path))
            total += path.end_tick
        else:
            total += arrives[query.robot]
    return total


def test_the_sum_of_arrivals_is_never_worse_and_sometimes_better() -> None:
    """Robots that set out among thirty on their way, on the paper's layout; no two paths of an answer overlap."""
    roads, rng = paper_roads(), np.random.default_rng(5)
    better = 0
    for _ in range(8):
        queries: list[Query] = []
        table = Reservations(roads.cells)
        reserved: dict[int, Occupancy] = {}
        arrives: dict[int, int] = {}
        for robot in range(30):
            query = newcomer(roads, table, robot, 0, rng)
            path = Sipp().search(roads, table, query)
            if path is None:
                continue
            queries.append(query)
            reserved[robot], arrives[robot] = occupancy(roads, path), path.end_tick
            table.commit(robot, reserved[robot])
        setting_out = queries[-3:]
        for query in setting_out:
            table.release(query.robot)
            del reserved[query.robot], arrives[query.robot]
        for query in setting_out:
            table.hold(query.robot, query.cell, 0)
        asked = [*setting_out, *queries[:-3]]
        traffic = FleetTraffic(roads, table, {}, reserved, arrives)
        costs = [arrivals(roads, Pbs(most_nodes=most).plan_paths(asked, traffic), asked, arrives) for most in (0, 20)]
        assert costs[1] <= costs[0]
        better += costs[1] < costs[0]
    assert better


def test_it_is_a_rule_like_any_other() -> None:
    """No findings in the trial worlds."""
    assert check_rule(Pbs()).findings == ()


def test_wrong_parameters_are_refused() -> None:
    """Fewer nodes than none."""
    with pytest.raises(ValueError, match="most_nodes"):
        Pbs(most_nodes=-1)
