"""From a scenario to the warehouse at time 0."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from attrs import frozen

from rmfs_core.entrypoints import format_module, process
from rmfs_core.errors import InputError
from rmfs_core.motion import Motion
from rmfs_core.randomness import stream
from rmfs_core.rules import BoundRule
from rmfs_core.scenario.model import RobotsSection, Scenario
from rmfs_core.simulation.services import Services
from rmfs_core.timetable import Timetable
from rmfs_core.warehouse import UNLIMITED, Robot, Station, Warehouse
from rmfs_core.world import NORTH, CellKind, Instance, Layout
from rmfs_core.world.instance_making import reader
from rmfs_core.world.layout_making import queue_length
from rmfs_core.world.travel import travel_on


@frozen(eq=False)
class Opening:
    """The warehouse at time 0, the pods that stand at stations then: (station id, pod id), first in line first,
    timetables: by id that of each station that has one, under None that of the robots; and how long services take."""

    warehouse: Warehouse
    at_stations: tuple[tuple[int, int], ...]
    hours: Mapping[int | None, Timetable]
    services: Services


def begin(scenario: Scenario, instance: Instance, layout: Layout, content: object = None) -> Any:
    """Return what a run begins in: the state that ``instance.state_file`` names, or that of ``content``; else None."""
    if scenario.instance.state_file is None:
        return None
    return process("state", "instance.state_file")(scenario, instance, layout, content)


def unmet_needs(rule: BoundRule, place: str, scenario: Scenario, instance: Instance) -> Iterator[InputError]:
    """Yield what a rule, selected at ``place``, needs and the scenario does not have."""
    for lacking in rule.traits.lacks(scenario, instance):
        yield InputError(place, f"{rule.describe()} needs {lacking}")
    if rule.traits.whole_orders:
        yield from format_module("problems").oversize_orders(instance, scenario)


def motion_of(robots: RobotsSection) -> Motion:
    """Return the kinematics that a scenario asks for."""
    return Motion(
        acceleration_m_per_s2=robots.acceleration_m_per_s2,
        top_speed_m_per_s=robots.top_speed_m_per_s,
        full_turn_s=robots.full_turn_s,
        lift_s=float(robots.lift_s),
    )


def open_warehouse(scenario: Scenario, instance: Instance, layout: Layout) -> Opening:
    """Place pods and robots.

    Where no file says otherwise, pods stand at random storage locations (stream ``pod places``), and robots start under
    such (stream ``robot places``), except for those that hold the pods which are at a station already. Besides the pods
    with contents there are empty ones until ``layout.pod_fill`` is reached, which only stand in the way.

    Raises
    ------
    InputError
        When there are more pods or robots than storage locations, or a station gets more pods than its queue holds.
    """
    locations = layout.storage_locations
    n_pods = len(instance.pods)
    if n_pods > len(locations):
        raise InputError("instance.pods", f"found {n_pods} pods, but the layout has {len(locations)} storage locations")
    if scenario.robots.count > len(locations):
        found = f"found {scenario.robots.count} robots"
        raise InputError("robots.count", f"{found}; the layout has {len(locations)} storage locations to park them")
    standing = max(int(scenario.layout.pod_fill * len(locations)), n_pods)
    given = [pod.place for pod in instance.pods if pod.place is not None]
    places = _cells(given, layout, {CellKind.STORAGE}, "a storage location")
    drawn = [locations[i] for i in stream(scenario.seed, "pod places").permutation(len(locations))]
    places = list(dict.fromkeys([*places, *drawn]))
    at_stations = _pods_at_stations(scenario, instance, layout)
    stations = _stations(scenario, layout)
    robot_places = [locations[i] for i in stream(scenario.seed, "robot places").permutation(len(locations))]
    if (name := scenario.robots.file) is not None:
        given = reader().read_robots(Path(scenario.folder) / name)
        robot_places = _cells(given, layout, {*CellKind} - {CellKind.WALL}, "a cell of the layout, no wall,")
        if len(robot_places) < scenario.robots.count:
            raise InputError("robots.count", f"found {scenario.robots.count}; {name} places {len(robot_places)}")
    robots = [Robot(i, robot_places[i], NORTH) for i in range(scenario.robots.count)]
    travel = travel_on(layout, motion_of(scenario.robots))
    travel.load_searches()
    room = scenario.instance.pod_capacity or UNLIMITED
    section, stored = scenario.robots.battery, places[:n_pods]
    battery = None if section is None else process("battery", "robots.battery")(scenario, travel)
    waits = scenario.rules.wait_for_stock is not False
    empty = places[n_pods:standing]
    parts = instance, travel, stations, robots, stored, empty, room, battery
    packing = () if scenario.packing is None else process("packing", "packing").stations(scenario, layout)
    warehouse = Warehouse(*parts, wait_for_stock=waits, packing=packing)
    if instance.restocked and not warehouse.storing:
        expected = "expected `I` in the map, `layout.replenishment_east` or `_west`, or `stations.also_replenish`"
        raise InputError("instance.replenishment", f"found no replenishment station; {expected}")
    picking = len(warehouse.picking)
    zero, lift_s = reader().Calendar(scenario.instance.start).time_of_day(), scenario.robots.lift_s
    services = Services(scenario.stations, scenario.seed, picking, zero, lift_s)
    hours = process("hours", "stations.open").timetables(scenario, picking)
    return Opening(warehouse, at_stations, hours, services)


def _cells(places: Iterable[tuple[int, int, str]], layout: Layout, kinds: set[CellKind], expected: str) -> list[int]:
    """Return the cells that lines of a file name."""
    found: dict[int, None] = {}
    for row, column, line in places:
        cell = (row - 1) * layout.width + column - 1
        if row > layout.height or column > layout.width or layout.kind[cell] not in kinds or cell in found:
            raise InputError(line, f"found row {row}, column {column}; expected {expected} that no line before names")
        found[cell] = None
    return list(found)


def _stations(scenario: Scenario, layout: Layout) -> list[Station]:
    section = scenario.stations
    counts_orders = section.order_capacity is not None
    capacity = section.order_capacity if section.order_capacity is not None else section.item_capacity
    n, bundles = len(layout.stations) - layout.replenishing, section.bundle_capacity or 10
    capacities = capacity if isinstance(capacity, tuple) else (capacity,) * n
    if len(capacities) != n:
        name = "order_capacity" if counts_orders else "item_capacity"
        raise InputError(
            f"stations.{name}", f"found {len(capacities)} capacities, but the layout has {n} picking stations"
        )
    length = queue_length(scenario, layout)
    kinds = [(capacity, None, bundles if section.also_replenish else 0, True) for capacity in capacities]
    kinds += [(0, None, bundles, False)] * layout.replenishing
    return [
        Station(i, cells, kind[0], counts_orders, length, *kind[1:])
        for i, (cells, kind) in enumerate(zip(layout.stations, kinds, strict=True))
    ]


def _pods_at_stations(scenario: Scenario, instance: Instance, layout: Layout) -> tuple[tuple[int, int], ...]:
    pods = {pod.name: i for i, pod in enumerate(instance.pods)}
    placed: list[tuple[int, int]] = []
    for station, names in scenario.instance.pods_at_stations.items():
        place = f"instance.pods_at_stations.{station}"
        if not station.isdecimal() or not 1 <= int(station) <= len(layout.stations):
            raise InputError(place, f"no station {station}; expected 1 to {len(layout.stations)}")
        if len(names) > (room := queue_length(scenario, layout) + 1):
            raise InputError(place, f"found {len(names)} pods; the station and its queue hold {room}")
        placed += [(int(station) - 1, pods[name]) for name in names]
    if len(placed) > scenario.robots.count:
        found = f"found {len(placed)} pods at stations, but robots.count = {scenario.robots.count}"
        raise InputError("instance.pods_at_stations", f"{found}; each needs a robot")
    return tuple(placed)
