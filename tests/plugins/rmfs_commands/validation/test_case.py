"""A trace under examination: geometry, names for people, and what its header must say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from attrs import evolve

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.case import Case, avoids_collisions, seconds
from rmfs_core.errors import InputError
from rmfs_core.world import EAST, NORTH, SOUTH, WEST


@pytest.mark.parametrize(
    ("cell", "to", "heading"),
    [(8, 11, EAST), (11, 8, WEST), (26, 2, NORTH), (2, 26, SOUTH), (8, 8, None), (0, 9, None), (7, 8, None)],
)
def test_headings_of_straight_runs(day: Trace, cell: int, to: int, heading: int | None) -> None:
    """On a map of eight columns; the last cell of a row and the first of the next are no neighbours."""
    case = Case(day)
    assert case.heading(cell, to) == heading
    if heading is not None:
        assert (to - cell) % case.step(heading) == 0
        assert (to - cell) // case.step(heading) > 0


def test_names_are_those_that_people_know(day: Trace) -> None:
    """Robots count from 1; pods, stations, orders and SKUs have names; cells are rows and columns."""
    case = Case(day)
    assert case.robot(0) == "robot 1"
    assert (case.pod(1), case.pod(None)) == ("pod P1", "an empty pod")
    assert (case.load(1), case.load(None)) == ("pod P1", "no pod")
    assert (case.station(0), case.order(0), case.sku(1)) == ("station 1", "order A", "SKU jam")
    assert case.where(26) == "row 4, column 3"
    assert seconds(61_098) == "61.098 s"


def test_only_storage_locations_are_storage(day: Trace) -> None:
    """Neither floor nor queue nor station nor wall."""
    case = Case(day)
    assert [cell for cell in range(48) if case.is_storage(cell)] == [26, 27, 29, 30]


def test_times_of_picking_are_ticks(day: Trace) -> None:
    """As the scenario says them, in seconds there."""
    case = Case(day)
    assert (case.pick_ticks, case.handle_ticks, case.queue_length) == (7000, 13_000, 2)


def test_queues_are_as_long_as_the_shortest_one(day: Trace) -> None:
    """Where the scenario leaves it out, and that is less than 12."""
    stations = {name: value for name, value in day.scenario["stations"].items() if name != "queue_length"}
    shortest = min(len(cells.queue) for cells in day.layout.stations)
    assert Case(evolve(day, scenario={**day.scenario, "stations": stations})).queue_length == shortest < 12


@pytest.mark.parametrize("key", ["pick_s", "handle_s"])
def test_a_scenario_without_its_stations_is_refused(day: Trace, key: str) -> None:
    """The key that is missing is named."""
    stations = {name: value for name, value in day.scenario["stations"].items() if name != key}
    with pytest.raises(InputError, match=f"^header of the trace: the scenario lacks '{key}' among its stations$"):
        Case(evolve(day, scenario={**day.scenario, "stations": stations}))


def test_faults_have_known_kinds(day: Trace) -> None:
    """A check that names a kind nobody has described is a mistake of its author."""
    case = Case(day)
    case.add("wall", 5, "robot 1 drives through the wall")
    with pytest.raises(AssertionError):
        case.add("walls", 5, "robot 1 drives through the wall")
    assert [(fault.kind, fault.tick) for fault in case.faults] == [("wall", 5)]


@pytest.mark.parametrize(
    ("rules", "expected"),
    [
        ({"pp": "free-flow"}, False),
        ({"pp": {"rule": "free-flow"}}, False),
        ({"pp": "sipp"}, True),
        ({"pp": {"rule": "whca-n", "window_s": 9}}, True),
        ({}, True),
    ],
)
def test_only_free_flow_ignores_other_robots(day: Trace, rules: Mapping[str, Any], expected: bool) -> None:
    """Written by its name or as a table; whoever plans in another way is held to it."""
    assert avoids_collisions(evolve(day, scenario={**day.scenario, "rules": rules})) is expected
