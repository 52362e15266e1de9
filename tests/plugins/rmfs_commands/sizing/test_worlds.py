"""Other sizes of a scenario, and what needs no run."""

from __future__ import annotations

import pytest
from attrs import evolve

from rmfs_commands.bounds import bounds_of
from rmfs_commands.sizing.target import Target
from rmfs_commands.sizing.worlds import Worlds
from rmfs_core import Scenario, load_scenario, run
from rmfs_core.scenario.model import Arrivals, StationsSection


def sides(worlds: Worlds, stations: int) -> tuple[int, int]:
    """Return the stations on the east and on the west side."""
    layout = worlds.of_size(stations, 1).layout
    return layout.stations_east, layout.stations_west


def test_sides_keep_their_shares_while_there_is_room(poisson: Scenario) -> None:
    """The hall has room for two stations a side; what is beyond goes to the other one."""
    assert [sides(Worlds(poisson, [1]), n) for n in (1, 2, 3, 4)] == [(1, 0), (2, 0), (2, 1), (2, 2)]
    both = evolve(poisson, layout=evolve(poisson.layout, stations_east=1, stations_west=1))
    assert [sides(Worlds(both, [1]), n) for n in (1, 2, 3, 4)] == [(0, 1), (1, 1), (2, 1), (2, 2)]


def test_changes_are_the_keys_of_the_size(poisson: Scenario) -> None:
    """What an experiment sets is what the scenario of that size has."""
    worlds = Worlds(poisson, [1])
    assert worlds.changes(3, 7) == {"layout.stations_east": 2, "layout.stations_west": 1, "robots.count": 7}
    assert worlds.of_size(3, 7).robots.count == 7


def test_a_map_has_its_stations() -> None:
    """Only the robots vary."""
    worlds = Worlds(load_scenario("examples/text-map"), [1])
    assert worlds.changes(9, 5) == {"robots.count": 5}
    assert worlds.of_size(9, 5).layout.map_file is not None


def test_without_room_it_says_so(poisson: Scenario) -> None:
    """Stations beyond both sides, robots beyond the places, capacities of other stations: the kernel's sentence."""
    worlds, target = Worlds(poisson, [1]), Target("turnover_p95_s", 1e6)
    assert "at most 2 fit" in str(worlds.obstacle(5, 2, target))
    assert "81 robots; the layout has 80 storage locations" in str(worlds.obstacle(2, 81, target))
    listed = Worlds(evolve(poisson, stations=StationsSection(item_capacity=(15, 10))), [1])
    assert listed.obstacle(2, 2, target) is None
    assert "found 2 capacities, but the layout has 3" in str(listed.obstacle(3, 2, Target("late_percent", 2)))


def test_what_no_rules_can_keep_needs_no_run(poisson: Scenario) -> None:
    """The bound of the seed that is easiest; just above it, nobody knows without a run."""
    worlds = Worlds(poisson, [1, 2, 3])
    bounds = [
        bound.value
        for seed in (1, 2, 3)
        for bound in bounds_of(worlds.of_size(2, 2).with_seed(seed))
        if bound.metric == "turnover_p95_s" and bound.value is not None
    ]
    easiest = min(bounds)
    reason = worlds.obstacle(2, 2, Target("turnover_p95_s", easiest - 0.1))
    assert reason == f"whatever the rules, it is {easiest:,.1f} s or more"
    assert worlds.obstacle(2, 2, Target("turnover_p95_s", easiest + 0.1)) is None
    assert easiest < run(worlds.of_size(2, 2)).metrics["turnover_p95_s"]


def test_pickers_that_cannot_keep_up(poisson: Scenario) -> None:
    """Items an hour times 13 s is more than an hour has, for so many pickers."""
    arrivals = Arrivals(process="poisson", orders_per_hour=250)
    worlds = Worlds(evolve(poisson, instance=evolve(poisson.instance, arrivals=arrivals)), [1, 2])
    orders = [order for instance in worlds.instances for order in instance.orders]
    items_per_hour = 250 * sum(order.items for order in orders) / len(orders)
    percent = items_per_hour * 13 / 36
    assert 100 < percent < 200
    expected = f"{items_per_hour:.0f} items an hour of 13 s keep each picker busy for {percent:.0f} % of the time"
    assert worlds.overload(1) == expected
    assert worlds.overload(2) is None


@pytest.mark.parametrize("process", ["start", "day"])
def test_a_load_that_ends_overloads_nobody(process: str, poisson: Scenario) -> None:
    """The backlog is worked off some time: only runs tell when."""
    ending = evolve(poisson, instance=evolve(poisson.instance, arrivals=Arrivals(process=process)))
    worlds = Worlds(ending, [1])
    assert worlds.overload(1) is None
    assert worlds.at_once == (process == "start")
