"""The start of a run, made again from the scenario in the header: layout, orders, and where everything stands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib.metadata import version
from typing import Any

import numpy as np
from attrs import evolve

from rmfs_commands.instances.departures import departing
from rmfs_commands.trace.reader import Trace
from rmfs_commands.trace.writer import MADE_BY
from rmfs_commands.validation.begun import opened
from rmfs_commands.validation.case import Case
from rmfs_core.errors import InputError
from rmfs_core.randomness import stream
from rmfs_core.scenario import Scenario, scenario_from_dict
from rmfs_core.world import NORTH, Instance, Layout, make_instance, make_layout

PLACE = "header of the trace"


def made_alike(trace: Trace, result: Mapping[str, Any] | None) -> bool:
    """Whether what is installed draws layouts, orders and locations like the code that recorded a trace.

    Which versions did is said by the header; where it says nothing, by the result next to the trace.
    """
    recorded = trace.versions or ({} if result is None else result.get("versions", {}))
    return all(recorded.get(name) == version(name) for name in MADE_BY)


def check_opening(case: Case) -> None:
    """Add faults: the header against what its scenario makes, as far as that needs no files next to the scenario."""
    trace = case.trace
    try:
        scenario = scenario_from_dict(trace.scenario, name=PLACE)
        layout = _layout(scenario, trace)
        given, supply = scenario.instance, scenario.instance.replenishment
        files = given.orders_file, given.skus_file, supply and supply.file
        drawn = files == (None,) * 3 and not isinstance(given.arrivals.profile, str)
        instance = make_instance(scenario) if drawn and trace.floor is None else None
        if instance is not None and trace.state is not None:
            instance = opened(trace, instance).instance
        undated = tuple(evolve(order, due_tick=None) for order in trace.instance.orders)
        due = departing(evolve(trace.instance, orders=undated), scenario)  # also of orders that are not made anew
    except InputError as error:
        case.add("header", 0, f"nothing can be run as the scenario says: {error}")
        return
    if layout is not None:
        _compare_layouts(case, layout)
    if instance is not None:
        _compare_instances(case, instance)
    elif given.departures is not None:
        _compare(case, "the orders", trace.instance.orders, due.orders)
    if trace.state is None:
        _compare_places(case, scenario)


def _layout(scenario: Scenario, trace: Trace) -> Layout | None:
    if scenario.layout.map_file is not None and trace.map_text is None:
        return None
    return make_layout(scenario, trace.map_text)


def _compare_layouts(case: Case, layout: Layout) -> None:
    found = case.layout
    if (found.width, found.height) != (layout.width, layout.height):
        size, asked = f"{found.width} x {found.height}", f"{layout.width} x {layout.height}"
        case.add("header", 0, f"the layout has {size} cells; the scenario says {asked}")
        return
    for name, cells, asked_for in (("of kind", found.kind, layout.kind), ("left by", found.moves, layout.moves)):
        different = np.flatnonzero(cells != asked_for)
        if len(different):
            cell = int(different[0])
            told = f"{case.where(cell)} is {name} {int(cells[cell])}; the scenario says {int(asked_for[cell])}"
            case.add("header", 0, f"{told}{_more(len(different))}")
    if (found.stations, found.replenishing) != (layout.stations, layout.replenishing):
        case.add("header", 0, "stations and queues have other cells than the scenario says")
    for i, own in enumerate(found.stations):
        if own.places < case.queue_length:
            held = f"the queue of {case.station(i)} has {own.places} cells"
            case.add("header", 0, f"{held}; stations.queue_length is {case.queue_length}")


def _compare_instances(case: Case, instance: Instance) -> None:
    found = case.trace.instance
    for name in ("skus", "orders", "pods", "levels"):
        _compare(case, f"the {name}", getattr(found, name), getattr(instance, name))


def _compare_places(case: Case, scenario: Scenario) -> None:
    """Pods, empty ones and robots stand at random; pods that are at stations from the start, and their robots, there.

    Each pod and each robot has its location in a stream of the scenario's seed, whether or not it stands there.
    """
    trace, locations = case.trace, case.layout.storage_locations
    pods, robots = (
        [locations[i] for i in stream(scenario.seed, purpose).permutation(len(locations))]
        for purpose in ("pod places", "robot places")
    )
    number = len(trace.instance.pods)
    standing = max(int(scenario.layout.pod_fill * len(locations)), number)
    placed_pods = [pod.place for pod in trace.instance.pods if pod.place is not None]
    if placed_pods:
        given = [(row - 1) * case.layout.width + column - 1 for row, column, _ in placed_pods]
        pods = given + [cell for cell in pods if cell not in set(given)]
    if scenario.robots.file is not None:  # which is not here
        robots = [robot["cell"] for robot in trace.robots]
    expected_robots = [{"cell": cell, "heading": NORTH} for cell in robots[: scenario.robots.count]]
    expected_pods: list[Mapping[str, Any]] = [{"cell": cell, "robot": None, "bound_for": []} for cell in pods[:number]]
    ids = {pod.name: i for i, pod in enumerate(trace.instance.pods)}
    placed = (
        (int(station) - 1, place, name)
        for station, names in scenario.instance.pods_at_stations.items()
        for place, name in enumerate(names)
    )
    for robot, (station, place, name) in enumerate(placed):
        cells = case.layout.stations[station] if station < len(case.layout.stations) else None
        if cells is not None and name in ids and robot < len(expected_robots):
            cell = cells.slot(place)
            expected_robots[robot]["cell"] = cell
            expected_pods[ids[name]] = {"cell": cell, "robot": robot, "bound_for": [station]}
    _compare(case, "the locations of pods", map(_listed, trace.pods), expected_pods)
    _compare(case, "the locations of robots", trace.robots, expected_robots)
    names = [station["name"] for station in trace.stations]
    _compare(case, "the names of stations", names, [str(i) for i in range(1, len(names) + 1)])
    _compare(case, "the empty pods", trace.blocked, sorted(pods[number:standing]))


def _listed(pod: Mapping[str, Any]) -> Mapping[str, Any]:
    return {**pod, "bound_for": list(pod["bound_for"])}


def _compare(case: Case, what: str, found: Iterable[Any], expected: Iterable[Any]) -> None:
    one, other = list(found), list(expected)
    if len(one) != len(other):
        case.add("header", 0, f"{what} are {len(one)}; the scenario makes {len(other)}")
        return
    different = [i for i, (a, b) in enumerate(zip(one, other, strict=True)) if a != b]
    if different:
        i = different[0]
        told = f"{what} are others than the scenario makes: {one[i]} instead of {other[i]}"
        case.add("header", 0, f"{told}{_more(len(different))}")


def _more(number: int) -> str:
    return f", and {number - 1} more" if number > 1 else ""
