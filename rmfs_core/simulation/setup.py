"""From a scenario to the warehouse at time 0."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from attrs import frozen

from rmfs_core.errors import InputError
from rmfs_core.motion import Motion
from rmfs_core.randomness import stream
from rmfs_core.rules import BoundRule
from rmfs_core.scenario.model import RobotsSection, Scenario
from rmfs_core.warehouse import Robot, Station, Warehouse
from rmfs_core.world import NORTH, CellKind, Instance, Layout
from rmfs_core.world.csv_files import Place, read_robots
from rmfs_core.world.instance_making import oversize_orders
from rmfs_core.world.travel import travel_on


@frozen(eq=False)
class Opening:
    """The warehouse at time 0, and the pods that stand at stations then: (station id, pod id), first in line first."""

    warehouse: Warehouse
    at_stations: tuple[tuple[int, int], ...]


def unmet_needs(rule: BoundRule, place: str, scenario: Scenario, instance: Instance) -> Iterator[InputError]:
    """Yield what a rule, selected at ``place``, needs and the scenario does not have."""
    for lacking in rule.traits.lacks(scenario, instance):
        yield InputError(place, f"{rule.describe()} needs {lacking}")
    if rule.traits.whole_orders:
        yield from oversize_orders(instance, scenario)


def motion_of(robots: RobotsSection) -> Motion:
    """Return the kinematics that a scenario asks for."""
    return Motion(
        acceleration_m_per_s2=robots.acceleration_m_per_s2,
        top_speed_m_per_s=robots.top_speed_m_per_s,
        full_turn_s=robots.full_turn_s,
        lift_s=robots.lift_s,
    )


def open_warehouse(scenario: Scenario, instance: Instance, layout: Layout) -> Opening:
    """Place pods and robots.

    Where no file says otherwise, pods stand at random storage locations (stream ``pod places``), and robots start under
    such (stream ``robot places``), but for those that hold the pods which are at a station already. Besides the pods
    with contents there are empty ones until ``layout.pod_fill`` is reached, which only stand in the way.

    Raises
    ------
    InputError
        When there are more pods or robots than places, or a station gets more pods than its queue holds.
    """
    locations = layout.storage_locations
    n_pods = len(instance.pods)
    if n_pods > len(locations):
        raise InputError("instance.pods", f"found {n_pods} pods, but the layout has {len(locations)} storage locations")
    if scenario.robots.count > len(locations):
        raise InputError(
            "robots.count",
            f"found {scenario.robots.count} robots; the layout has {len(locations)} storage locations to park them",
        )
    standing = max(int(scenario.layout.pod_fill * len(locations)), n_pods)
    given = [pod.place for pod in instance.pods if pod.place is not None]
    places = _cells(given, layout, {CellKind.STORAGE}, "a storage location")
    drawn = [locations[i] for i in stream(scenario.seed, "pod places").permutation(len(locations))]
    places = list(dict.fromkeys([*places, *drawn]))
    at_stations = _pods_at_stations(scenario, instance, layout)
    stations = _stations(scenario, layout)
    robot_places = [locations[i] for i in stream(scenario.seed, "robot places").permutation(len(locations))]
    if (name := scenario.robots.file) is not None:
        given = read_robots(Path(scenario.folder) / name)
        robot_places = _cells(given, layout, {*CellKind} - {CellKind.WALL}, "a cell of the layout, no wall,")
        if len(robot_places) < scenario.robots.count:
            raise InputError("robots.count", f"found {scenario.robots.count}; {name} places {len(robot_places)}")
    robots = [Robot(i, robot_places[i], NORTH) for i in range(scenario.robots.count)]
    travel = travel_on(layout, motion_of(scenario.robots))
    travel.load_searches()
    warehouse = Warehouse(instance, travel, stations, robots, places[:n_pods], places[n_pods:standing])
    return Opening(warehouse, at_stations)


def _cells(places: Iterable[Place], layout: Layout, kinds: set[CellKind], expected: str) -> list[int]:
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
    n = len(layout.stations)
    capacities = capacity if isinstance(capacity, tuple) else (capacity,) * n
    if len(capacities) != n:
        name = "order_capacity" if counts_orders else "item_capacity"
        raise InputError(
            f"stations.{name}", f"found {len(capacities)} capacities, but the layout has {n} picking stations"
        )
    return [Station(i, layout.stations[i], capacities[i], counts_orders, section.queue_length) for i in range(n)]


def _pods_at_stations(scenario: Scenario, instance: Instance, layout: Layout) -> tuple[tuple[int, int], ...]:
    pods = {pod.name: i for i, pod in enumerate(instance.pods)}
    placed: list[tuple[int, int]] = []
    for station, names in scenario.instance.pods_at_stations.items():
        place = f"instance.pods_at_stations.{station}"
        if not station.isdecimal() or not 1 <= int(station) <= len(layout.stations):
            raise InputError(place, f"no station {station}; expected 1 to {len(layout.stations)}")
        if len(names) > scenario.stations.queue_length + 1:
            raise InputError(
                place, f"found {len(names)} pods; the station and its queue hold {scenario.stations.queue_length + 1}"
            )
        placed += [(int(station) - 1, pods[name]) for name in names]
    if len(placed) > scenario.robots.count:
        raise InputError(
            "instance.pods_at_stations",
            f"found {len(placed)} pods at stations, but robots.count = {scenario.robots.count}; each needs a robot",
        )
    return tuple(placed)
