"""The header of a trace: what a run starts from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.case import Case
from rmfs_core.errors import InputError
from rmfs_core.wording import counted

PLACE = "header of the trace"


def check_readable(trace: Trace) -> None:
    """Raise `InputError` when the header names what it does not have: nothing can be checked then."""
    cells, skus, stations = len(trace.layout.kind), len(trace.instance.skus), len(trace.layout.stations)
    named = {
        "cell": (cells, [place["cell"] for place in (*trace.robots, *trace.pods)] + list(trace.blocked)),
        "cell of a station": (cells, [c for own in trace.layout.stations for c in (own.station, *own.queue)]),
        "robot": (len(trace.robots), [pod["robot"] for pod in trace.pods if pod["robot"] is not None]),
        "station": (stations, [station for pod in trace.pods for station in pod["bound_for"]]),
        "SKU": (skus, [sku for order in trace.instance.orders for sku, _ in order.lines]),
        "SKU of a pod": (skus, [sku for pod in trace.instance.pods for sku, _ in pod.contents]),
        "heading": (4, [robot["heading"] for robot in trace.robots]),
    }
    for what, (count, ids) in named.items():
        wrong = next((i for i in ids if not isinstance(i, int) or not 0 <= i < count), None)
        if wrong is not None:
            raise InputError(PLACE, f"found {what} {wrong!r}; expected a whole number from 0 to {count - 1}")
    if stations != len(trace.stations):
        raise InputError(PLACE, f"found {counted(len(trace.stations), 'station')}, but the layout has {stations}")
    motion = trace.motion
    if not (motion.acceleration_m_per_s2 > 0 and motion.top_speed_m_per_s > 0):
        raise InputError(PLACE, f"found {motion}; expected an acceleration and a top speed above 0")


def check_header(case: Case) -> None:
    """Add faults: the header against the scenario in it, and where pods and robots are at the start."""
    trace = case.trace
    robots, stations = trace.scenario.get("robots", {}), trace.scenario["stations"]
    for name in ("acceleration_m_per_s2", "top_speed_m_per_s", "full_turn_s", "lift_s"):
        found = getattr(trace.motion, name)
        given = robots.get(name, found)
        if not isinstance(given, Mapping) and given != found:  # of times that vary nothing is said but their mean
            case.add("header", 0, f"{name} of the robots is {found}; the scenario says {given}")
    for i, station in enumerate(trace.stations[: len(trace.stations) - case.layout.replenishing]):
        asked = stations.get("order_capacity" if station["counts_orders"] else "item_capacity")
        capacity = asked[i] if isinstance(asked, list | tuple) and i < len(asked) else asked
        if station["capacity"] != capacity:
            case.add("header", 0, f"the capacity of {case.station(i)} is {station['capacity']}, not {capacity}")
    _bundle_capacities(case)
    _names(case)
    _numbers(case)
    _places(case)
    _queues(case)


def _bundle_capacities(case: Case) -> None:
    """Stations that only store do that, and the others where the scenario says so."""
    trace, asked = case.trace, case.trace.scenario["stations"]
    picking = len(trace.stations) - case.layout.replenishing
    for i, station in enumerate(trace.stations):
        stores = i >= picking or bool(asked.get("also_replenish"))
        found, expected = station.get("bundle_capacity", 0), asked.get("bundle_capacity", 10) if stores else 0
        if found != expected:
            case.add("header", 0, f"{case.station(i)} holds {counted(found, 'bundle')}; the scenario says {expected}")


def _names(case: Case) -> None:
    """Check that everything known by its name has a name of its own."""
    instance = case.trace.instance
    named = {
        "orders": [order.name for order in instance.orders],
        "pods": [pod.name for pod in instance.pods],
        "SKUs": list(instance.skus),
        "stations": [station["name"] for station in case.trace.stations],
    }
    for what, names in named.items():
        for name, number in Counter(names).items():
            if number > 1:
                case.add("header", 0, f"{number} {what} have the name {name}")


def _numbers(case: Case) -> None:
    """There is as much of everything as the scenario says."""
    trace, instance = case.trace, case.trace.instance
    scenario, locations = trace.scenario, len(case.layout.storage_locations)
    asked, fill = scenario.get("instance", {}), scenario.get("layout", {}).get("pod_fill")
    skus = asked.get("skus")
    if skus is not None and len(instance.skus) < skus:
        skus = None  # those on no pod are left out
    expected = {
        "robots": (len(trace.robots), scenario.get("robots", {}).get("count")),
        "orders": (len(instance.orders), None if trace.state is not None else asked.get("orders")),  # it has others
        "SKUs": (len(instance.skus), None if instance.bundles else skus),  # bundles may bring others
        "pods": (len(instance.pods), asked.get("pods")),
        "empty pods": (
            len(trace.blocked),
            None if fill is None else max(int(fill * locations) - len(instance.pods), 0),
        ),
    }
    for what, (found, number) in expected.items():
        if number is not None and found != number:
            case.add("header", 0, f"there are {found} {what}; the scenario says {number}")


def _queues(case: Case) -> None:
    """Every way on from a queue cell leads to one that is nearer to the station, or to the station."""
    for i, own in enumerate(case.layout.stations):
        nearer = {own.station}
        for cell in own.queue:
            ways = [cell + case.step(heading) for heading in range(4) if case.moves[cell] >> heading & 1]
            if not ways or not nearer.issuperset(ways):
                case.add(
                    "header", 0, f"the way on from {case.where(cell)} in the queue of {case.station(i)} leads back"
                )
            nearer.add(cell)


def _places(case: Case) -> None:
    taken: dict[int, int | None] = {}
    standing: list[tuple[int | None, int]] = [(None, cell) for cell in case.trace.blocked]
    standing += [(i, pod["cell"]) for i, pod in enumerate(case.trace.pods) if pod["robot"] is None]
    for pod, cell in standing:
        if not case.is_storage(cell):
            case.add("no-storage-location", 0, f"{case.pod(pod)} stands at {case.where(cell)} from the start")
        elif cell in taken:
            case.add(
                "location-taken", 0, f"{case.pod(pod)} and {case.pod(taken[cell])} both stand at {case.where(cell)}"
            )
        taken[cell] = pod
    carriers: dict[int, int] = {}
    for i, pod_start in enumerate(case.trace.pods):
        robot = pod_start["robot"]
        if robot is None:
            continue
        if robot in carriers:
            case.add("header", 0, f"{case.robot(robot)} carries {case.pod(carriers[robot])} and {case.pod(i)}")
        carriers[robot] = i
