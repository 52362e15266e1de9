"""A run that stops wherever the caller has to choose."""

from __future__ import annotations

import pytest
from greenlet import getcurrent, greenlet

import rmfs_core
from rmfs_commands.gym.episode import Episode
from rmfs_core import Scenario, load_scenario
from rmfs_core.events import TaskAssigned
from rmfs_core.roles import Role

PLACE = ["instance.orders=10", "rules.pp=free-flow"]


@pytest.fixture
def scenario() -> Scenario:
    """Ten orders."""
    return load_scenario("examples/small", PLACE)


def to_its_end(episode: Episode) -> int:
    """Choose the first slot until the run is over; return how many choices there were."""
    number, choice = 0, episode.go_on()
    while choice is not None:
        number, choice = number + 1, episode.go_on(min(choice.options))
    return number


def test_it_stops_at_each_choice_and_goes_on(scenario: Scenario) -> None:
    """One choice for each task that a robot is given."""
    episode = Episode(scenario, Role.TA, 50)
    assert not episode.complete
    choices = to_its_end(episode)
    assert choices == sum(isinstance(event, TaskAssigned) for event in episode.heard().events)
    assert episode.complete


def test_its_result_is_one_of_a_run(scenario: Scenario) -> None:
    """All that `run` returns is there; the scenario in it says that the caller decided."""
    episode = Episode(scenario, Role.PPS, 50)
    to_its_end(episode)
    result, by_run = episode.result(), rmfs_core.run(scenario)
    assert result.status == "complete"
    assert result.metrics.keys() == by_run.metrics.keys()
    assert result.timing.keys() == by_run.timing.keys()
    assert result.timing["profile_s"].keys() == by_run.timing["profile_s"].keys()
    assert result.versions == {**by_run.versions, "Caller": "object of rmfs_commands.gym.episode"}
    assert result.hook_calls.keys() == by_run.hook_calls.keys()
    assert {row["order"] for row in result.orders} == {row["order"] for row in by_run.orders}
    assert result.scenario.rules.pps is not None
    assert result.scenario.rules.pps.rule == "Caller"
    assert result.periods[1]["rule"] == "Caller"


def test_what_is_heard_is_heard_once(scenario: Scenario) -> None:
    """Steps follow one another without a gap, and know how many orders are open."""
    episode = Episode(scenario, Role.PPS, 50)
    choice = episode.go_on()
    first = episode.heard()
    assert (first.since_tick, first.orders_open) == (0, 10)
    assert first.events
    assert episode.heard().events == ()
    while choice is not None:
        before = episode.simulation.now
        choice = episode.go_on(min(choice.options))
        step = episode.heard()
        assert step.since_tick == before
        assert all(before <= event.tick <= step.warehouse.now_tick for event in step.events)
    assert step.orders_open == 0


@pytest.mark.parametrize("steps", [0, 1, 5])
def test_closing_ends_it_wherever_it_is(scenario: Scenario, steps: int) -> None:
    """Before the first choice or at any: nothing more happens, and it can be closed again."""
    episode = Episode(scenario, Role.POA, 50)
    slot = None
    for _ in range(steps):
        choice = episode.go_on(slot)
        assert choice is not None
        slot = min(choice.options)
    episode.heard()
    episode.close()
    episode.close()
    assert episode.heard().events == ()
    assert not episode.complete


def test_who_lets_it_go_on_is_asked(scenario: Scenario) -> None:
    """An episode may be begun in one greenlet and go on in another, as servers of greenlets do."""
    episode = Episode(scenario, Role.TA, 50)
    choice = episode.go_on()
    assert choice is not None
    elsewhere = greenlet(episode.go_on, getcurrent())
    choice = elsewhere.switch(min(choice.options))
    assert choice is not None
    assert episode.go_on(min(choice.options)) is not None
