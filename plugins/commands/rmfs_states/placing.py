"""Where a state's pods and robots are, and where they are bound for."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rmfs_core.warehouse import Pod, Robot, Warehouse
from rmfs_states.names import Names
from rmfs_states.state import RobotState, State

NOWHERE = -1
"""Home of a pod of which the state does not tell it."""


def place_pods_and_robots(warehouse: Warehouse, names: Names, state: State) -> None:
    """Put pods and robots where a state says they are. Station lines, trips and waiting pods follow from that."""
    _bind(warehouse, names, state)
    lines = _lines(warehouse, names, state)
    fetching = _tasks(warehouse, names, state)
    _place_robots(warehouse, names, state)
    _place_pods(warehouse, names, state, {pod.id for line in lines for pod in line})
    for station, line, given in zip(warehouse.stations, lines, state.stations.values(), strict=True):
        for place, pod in enumerate(line):
            robot = fetching.get(pod.id) or _make_up_robot(warehouse, pod)
            if state.robots is None or state.layout is None or robot.id >= len(state.robots):
                robot._cell = station.cells.slot(place)
            station._line.append(robot)
        room = given.queue_room
        station._claims = len(line) if room is None else station.queue_length + 1 - room
    for robot in warehouse.robots:
        if robot._task is not None and warehouse.pods[robot._task].location is None:
            robot._pod = robot._task
    _let_wait(warehouse, names, state)


def _bind(warehouse: Warehouse, names: Names, state: State) -> None:
    """Bind pods for stations: which pods, and in which order at the station, is `inbound`; each pod's own order is
    `bound_for`.
    """
    for station, (name, given) in zip(warehouse.stations, state.stations.items(), strict=True):
        inbound = given.line if given.inbound is None else given.inbound
        for i, pod_name in enumerate(inbound):
            pod = warehouse.pods[names.pod(pod_name, "stations", name, "inbound", i)]
            if pod.id in station._inbound:
                names.wrong(("stations", name, "inbound", i), f'names pod "{pod_name}" twice; expected each once')
            station._inbound[pod.id] = pod
            pod._itinerary.append(station.id)
        for i, pod_name in enumerate(given.line):
            if pod_name not in inbound:
                names.wrong(("stations", name, "line", i), f'names pod "{pod_name}", which `inbound` does not')
    for pod, (name, given_pod) in zip(warehouse.pods, state.pods.items(), strict=True):
        if given_pod.bound_for is None:
            continue
        bound = [names.station(station, "pods", name, "bound_for") for station in given_pod.bound_for]
        if sorted(bound) != sorted(pod._itinerary):
            names.wrong(("pods", name, "bound_for"), "expected the stations that have the pod in `inbound`, each once")
        pod._itinerary = bound


def _lines(warehouse: Warehouse, names: Names, state: State) -> list[list[Pod]]:
    lines = [
        [warehouse.pods[names.pod(pod, "stations", name, "line")] for pod in given.line]
        for name, given in state.stations.items()
    ]
    seen: set[int] = set()
    for (name, _), line in zip(state.stations.items(), lines, strict=True):
        for pod in line:
            if pod.id in seen:
                names.wrong(("stations", name, "line"), f'names pod "{pod.name}", which stands in a line already')
            seen.add(pod.id)
    return lines


def _tasks(warehouse: Warehouse, names: Names, state: State) -> dict[int, Robot]:
    """Give robots their tasks; return who has which pod."""
    found: dict[int, Robot] = {}
    for robot, (name, given) in zip(warehouse.robots, (state.robots or {}).items(), strict=True):
        if given.task is None:
            continue
        pod = warehouse.pods[names.pod(given.task, "robots", name, "task")]
        if pod.id in found:
            names.wrong(("robots", name, "task"), f'names pod "{pod.name}", which is another robot\'s task')
        robot._task, pod._carrier = pod.id, robot
        found[pod.id] = robot
    return found


def _make_up_robot(warehouse: Warehouse, pod: Pod) -> Robot:
    """Return a robot for a pod in a line: some robot carries it, whether the state lists robots or not."""
    robot = Robot(len(warehouse.robots), 0, 1)
    robot._task, pod._carrier = pod.id, robot
    warehouse.robots = (*warehouse.robots, robot)
    return robot


def _place_robots(warehouse: Warehouse, names: Names, state: State) -> None:
    layout = warehouse.travel.layout
    robots: Mapping[str, RobotState] = state.robots or {}
    for robot, (name, given) in zip(warehouse.robots, robots.items(), strict=True):
        if state.layout is None:
            if given.cell is not None:
                names.wrong(("robots", name, "cell"), "found a cell, but the state has no layout")
        elif given.cell is None or given.cell >= layout.width * layout.height:
            cells = layout.width * layout.height
            names.wrong(("robots", name, "cell"), f"expected a cell of the layout, 0 to {cells - 1}")
        else:
            robot._cell, robot._heading = given.cell, given.heading


def _place_pods(warehouse: Warehouse, names: Names, state: State, in_line: Collection[int]) -> None:
    layout = warehouse.travel.layout
    taken = dict.fromkeys((*state.empty_pods, *state.reserved), "another pod")
    homes = list(warehouse.homes)
    for pod, (name, given) in zip(warehouse.pods, state.pods.items(), strict=True):
        path = ("pods", name, "cell")
        if state.layout is None:
            if given.cell is not None:
                names.wrong(path, "found a cell, but the state has no layout")
            if pod.id in in_line:
                pod._location = None
            continue
        homes[pod.id] = next((cell for cell in (given.home, given.cell) if cell is not None), NOWHERE)
        pod._location = given.cell
        if given.cell is None:
            if pod.id not in in_line and pod._carrier is None:
                names.wrong(path, "is missing; expected the pod's cell, or that it is in a line or a robot's task")
            continue
        if pod.id in in_line:
            names.wrong(path, "found a storage location for a pod that stands in a station's line")
        if given.cell not in layout.storage_locations:
            first = layout.storage_locations[0]
            problem = (
                f"found {given.cell}, which is no storage location of the layout; the first is {first} "
                f"({layout.where(first)})"
            )
            names.wrong(path, problem)
        if given.cell in taken:
            names.wrong(path, f"found {given.cell}, where there is {taken[given.cell]} already")
        taken[given.cell] = f'pod "{name}"'
        pod._cell = given.cell
    warehouse.homes = tuple(homes)
    warehouse.blocked = tuple(sorted(state.empty_pods))
    if state.layout is not None:
        warehouse.free_locations = [cell for cell in layout.storage_locations if cell not in taken]


def _let_wait(warehouse: Warehouse, names: Names, state: State) -> None:
    """Let pods that are stored and bound for a station wait for a robot."""
    waiting = [pod for pod in warehouse.pods if pod.bound_for and pod.location is not None and pod.robot is None]
    if state.waiting is not None:
        named = [warehouse.pods[names.pod(pod, "waiting", i)] for i, pod in enumerate(state.waiting)]
        if sorted(pod.id for pod in named) != [pod.id for pod in waiting]:
            expected = ", ".join(pod.name for pod in waiting) or "none"
            names.wrong(("waiting",), f"expected the stored pods that are inbound and no robot's task: {expected}")
        waiting = named
    warehouse.waiting = {pod.id: pod for pod in waiting}
