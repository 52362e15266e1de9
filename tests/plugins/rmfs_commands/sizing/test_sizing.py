"""The whole search against brute force, in runs."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from rmfs_commands.sizing.judging import Estimate, Verdict, estimate
from rmfs_commands.sizing.searching import Found
from rmfs_commands.sizing.sizing import Answer, size
from rmfs_commands.sizing.target import Target
from rmfs_commands.sizing.trials import Candidate
from rmfs_commands.sizing.worlds import Worlds
from rmfs_core import Scenario, load_scenario, run
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import Arrivals

SEEDS = (1, 2, 3)


def test_the_answer_is_that_of_the_whole_grid(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """Every size run with every seed: the same sizes pass, and the fewest of them are the same."""
    backlog = evolve(poisson, instance=evolve(poisson.instance, arrivals=Arrivals(), orders=10))
    worlds = Worlds(backlog, SEEDS)
    values = {
        sizes: [run(worlds.of_size(*sizes), seed=seed).metrics["turnover_p95_s"] for seed in SEEDS]
        for sizes in product((1, 2), range(1, 4))
    }
    found: list[list[tuple[int, int]]] = []
    for most in (290.0, 230.0, 170.0):
        target = Target("turnover_p95_s", most, confidence=0.8, seeds=SEEDS)
        answer = size(backlog, "hall", target, store=tmp_path, workers=here, stations=(1, 2), robots=(1, 3))
        assert answer.at_once
        best: list[tuple[int, int]] = []
        for (stations, robots), of_seeds in values.items():
            enough = estimate(of_seeds, 0.8, 1).verdict(most) is Verdict.PASSES
            if enough and all(robots < fewer for _, fewer in best):
                best.append((stations, robots))
        found.append([(one.stations, one.robots) for one in answer.frontier])
        assert found[-1] == best
    assert found == [[(1, 2)], [(2, 3)], []]
    assert len({job.key for job in here.jobs}) == len(here.jobs)


def test_stations_that_cannot_keep_up_are_left_out(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """By the load, and by the room that there is; nothing is run for them."""
    target = Target("turnover_p95_s", 3600, seeds=SEEDS)
    arrivals = Arrivals(process="poisson", orders_per_hour=250)
    busy = evolve(poisson, instance=evolve(poisson.instance, arrivals=arrivals))
    answer = size(busy, "hall", target, store=tmp_path, workers=here, stations=(1, 6), robots=(4, 4))
    reasons = {found.stations: found.reason for found in answer.stations}
    assert "busy" in str(reasons[1])
    assert "at most 2 fit" in str(reasons[5])
    assert (reasons[2], reasons[3]) == (None, "saves no robot")
    assert {(one.stations, one.robots) for one in answer.candidates} == {(2, 4)}
    assert [(one.stations, one.robots) for one in answer.frontier] == [(2, 4)]


def test_a_map_keeps_its_stations(here: Any, tmp_path: Path) -> None:
    """Only the robots are sought; another number of stations is refused."""
    scenario = load_scenario("examples/text-map", ["instance.orders=8", "rules.pp=free-flow"])
    target = Target("turnover_p95_s", 5000, seeds=(1, 2))
    with pytest.raises(InputError, match="--stations: the map of the scenario has"):
        size(scenario, "map", target, store=tmp_path, workers=here, stations=(1, 9))
    answer = size(scenario, "map", target, store=tmp_path, workers=here, robots=(2, 2))
    assert [one.robots for one in answer.frontier] == [2]


def test_there_is_no_room_for_so_many_robots(poisson: Scenario, here: Any, tmp_path: Path) -> None:
    """The sentence has both numbers."""
    target = Target("turnover_p95_s", 300)
    with pytest.raises(InputError, match="--robots: found 500; the layout has 80 places to park them"):
        size(poisson, "hall", target, store=tmp_path, workers=here, robots=(1, 500))


def answer_of(*frontier: tuple[int, int], undecided: tuple[tuple[int, int], ...] = ()) -> Answer:
    """Return an answer without runs."""
    best = tuple(Candidate(*one, Verdict.PASSES, 4, Estimate(1, 1, 1)) for one in frontier)
    open_ones = tuple(Candidate(*one, Verdict.UNDECIDED, 16, Estimate(1, 1, 1)) for one in undecided)
    found = tuple(Found(*one) for one in frontier)
    return Answer("hall", Target("turnover_s", 1), found, best, (*best, *open_ones), at_once=False)


def test_what_is_cheapest_depends_on_the_costs() -> None:
    """Dear robots ask for more stations; of equals the one with fewer stations; of nothing there is none."""
    answer = answer_of((2, 9), (3, 7), (4, 6))
    sizes = {costs: answer.cheapest(*costs) for costs in ((10, 1), (1, 10), (1, 2))}
    found = {costs: priced and ((priced[0].stations, priced[0].robots), priced[1]) for costs, priced in sizes.items()}
    assert found == {(10, 1): ((4, 6), 64), (1, 10): ((2, 9), 29), (1, 2): ((2, 9), 13)}
    assert answer_of().cheapest(1, 1) is None


def test_undecided_sizes_count_where_they_would_be_better() -> None:
    """One that has no fewer stations and no fewer robots than one that is enough would bring nothing."""
    answer = answer_of((2, 9), (3, 7), undecided=((2, 8), (3, 8), (4, 7), (4, 6)))
    assert [(one.stations, one.robots) for one in answer.undecided] == [(2, 8), (4, 6)]
