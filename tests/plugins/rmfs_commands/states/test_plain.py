"""The warehouse at one moment as plain data."""

from __future__ import annotations

import pytest
from attrs import evolve

from rmfs_commands.states.plain import Memento, PodMemento, RequestMemento, RobotMemento, StationMemento
from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView


def test_what_is_told() -> None:
    """Ids in place of objects; the picker, hours and what is in hand as far as there is something to tell."""
    world = small_world({"1": {"a": 2}}, {"p": {"a": 3}}, capacities=[4])
    station = world.stations[0]
    world.assign(world.orders[0], station, [0])
    world.place_at_station(world.robots[0], world.pods[0], station)
    before = StationMemento.of(station, world.now)
    assert before.requests == (RequestMemento(0, 0, 0, 0), RequestMemento(1, 0, 0, 0))
    assert (before.inbound, before.line) == ((0,), (0,))
    assert before.in_hand is before.picker_free is before.changes is None
    world.fulfil(station.open_requests[0], world.pods[0], handled=False)
    world.occupy_picker(station, 2500)
    world.staff(station, False, 9000)
    after = StationMemento.of(station, world.now)
    assert (after.in_hand, after.picker_free, after.staffed, after.changes) == ((0, 0), 2500, False, 9000)
    assert StationMemento.of(station, 2500).picker_free is None
    pod = PodMemento.of(world.pods[0], world.homes[0])
    assert (pod.data.contents, pod.cell, pod.home, pod.bound_for) == (((0, 2),), None, world.homes[0], (0,))
    assert RobotMemento.of(world.robots[0]).task == 0


def test_a_memento_has_no_time_before_the_start_and_no_fifth_heading() -> None:
    """What is wrong by itself is refused when it is made."""
    memento = Memento.of(WarehouseView(small_world({}, {"p": ["a"]})), ("a",))
    with pytest.raises(ValueError, match="'now' must be >= 0: -1"):
        evolve(memento, now=-1)
    with pytest.raises(ValueError, match="'heading' must be in range"):
        evolve(memento.robots[0], heading=4)
