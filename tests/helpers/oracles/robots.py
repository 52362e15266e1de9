"""Literal versions of the rules for robots and for stations that are active."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from heapq import heappop, heappush
from itertools import permutations
from typing import Any

from oracles.worlds import Moment
from rmfs_core import Leg, Path, RobotMove, TaskAssignment
from rmfs_core.warehouse import Pod, Robot, Station


def empty_ticks(now: Moment, robot: Robot, cell: int) -> int:
    return now.world.travel.ticks(robot.cell, robot.heading, cell, False)


def nearest_robot(now: Moment, told: Any) -> list[TaskAssignment]:
    """The pod that waits longest gets the robot that reaches it first."""
    idle, tasks = [*now.world.idle], []
    for pod in now.world.waiting.values():
        if idle:
            robot = min(idle, key=lambda robot, pod=pod: (empty_ticks(now, robot, pod.cell), robot.id))
            idle.remove(robot)
            tasks.append(TaskAssignment(robot.id, pod.id))
    return tasks


def drawn(now: Moment, told: Any, *, max_wait_s: float | None = None) -> list[TaskAssignment]:
    """Robots and pods in an order by lot."""
    robots, pods = now.world.idle, [*now.world.waiting.values()]
    lots = now.rng.permutation(len(robots)).tolist(), now.rng.permutation(len(pods)).tolist()
    return [TaskAssignment(robots[robot].id, pods[pod].id) for robot, pod in zip(*lots, strict=False)]


def assignment(now: Moment, told: list[TaskAssignment], *, defer_s: float | None = None) -> list[TaskAssignment]:
    """Of all ways to pair robots and pods one with the lowest sum of drives: the one that was told, if it is."""
    idle = now.world.idle
    storing = [r for r in now.world.robots if r.pod is not None and not now.world.pods[r.pod].bound_for]
    robots = [*idle, *(storing if defer_s is not None else ())]
    pods = [*now.world.waiting.values()][: len(robots)]
    ways: list[tuple[float, list[TaskAssignment]]] = []
    for chosen in permutations(robots, len(pods)):
        pairs = [*zip(chosen, pods, strict=True)]
        never = any(robot in storing and pod is pods[0] for robot, pod in pairs) * 1e15
        cost = never + sum(empty_ticks(now, r, pod.cell) + 1000 * (defer_s or 0.0) * (r in storing) for r, pod in pairs)
        tasks = [TaskAssignment(robot.id, pod.id) for robot, pod in pairs if robot in idle]
        ways.append((cost, sorted(tasks, key=lambda task: task.robot)))
    least = min(cost for cost, _ in ways)
    best = [tasks for cost, tasks in ways if cost == least]
    return told if sorted(told, key=lambda task: task.robot) in best else best[0]


def balanced(now: Moment, told: Any, *, reallocation_s: float = 30.0, help_others: bool = True) -> list[TaskAssignment]:
    """Robots are shared out over the active stations, and fetch for their own station first."""
    station_of: dict[int, int] = now.memory.setdefault("station_of", {})
    active = {station.id for station in now.stations if station.open_requests}
    due = now.now_s - now.memory.get("shared_at_s", -math.inf) >= reallocation_s
    if active and due and active != now.memory.get("active"):
        share_out(now, station_of, active)
        now.memory |= {"shared_at_s": now.now_s, "active": active}

    def first_waiting(stations: Iterable[int]) -> dict[int, Pod]:
        waiting = [pod for pod in now.world.waiting.values() if pod.id not in {task.pod for task in tasks}]
        return {pod.bound_for[0]: pod for pod in reversed(waiting) if pod.bound_for[0] in stations}

    tasks: list[TaskAssignment] = []
    for robot in now.world.idle:
        own = first_waiting([station_of.get(robot.id, -1)])
        tasks += [TaskAssignment(robot.id, pod.id) for pod in own.values()]
    manned = set(station_of.values())
    others = [s.id for s in now.world.stations if help_others or s.id not in manned]
    for robot in [robot for robot in now.world.idle if robot.id not in {task.robot for task in tasks}]:
        if pods := first_waiting(others):
            nearest = min(pods, key=lambda at, r=robot: (empty_ticks(now, r, now.world.stations[at].cell), at))
            tasks.append(TaskAssignment(robot.id, pods[nearest].id))
    return tasks


def share_out(now: Moment, station_of: dict[int, int], active: set[int]) -> None:
    """Share robots out: those that have to move do, the shortest drive first."""
    layout = now.world.travel.layout

    def from_middle(at: int) -> float:
        row, column = divmod(now.stations[at].cell, layout.width)
        return math.hypot(row - (layout.height - 1) / 2, column - (layout.width - 1) / 2)

    each, more = divmod(len(now.world.robots), len(active))
    farthest = sorted(active, key=lambda at: (-round(from_middle(at), 9), at))
    share = {at: each + (rank < more) for rank, at in enumerate(farthest)}
    while True:
        number = Counter(station_of.values())
        moves = [
            (empty_ticks(now, robot, now.stations[at].cell), robot.id, at)
            for robot in now.world.robots
            for at in active
            if number[at] < share[at]
            and ((own := station_of.get(robot.id)) is None or own not in active or number[own] > share[own])
        ]
        if not moves:
            return
        _, robot_id, at = min(moves)
        station_of[robot_id] = at


# Robots without a task


def stay(now: Moment, told: Any) -> list[RobotMove]:
    return []


def resting_place(now: Moment, moves: list[RobotMove]) -> list[int]:
    """Locations without a pod that a robot may be sent to."""
    return [cell for cell in free_cells(now, moves) if cell in now.world.free_locations]


def free_cells(now: Moment, moves: list[RobotMove]) -> list[int]:
    taken = {move.cell for move in moves}
    return [cell for cell in now.warehouse.free_rest_cells if cell not in taken]


def rest(cost: Callable[[Moment, Robot, int], int]) -> Callable[..., list[RobotMove]]:

    def decide(now: Moment, told: Any) -> list[RobotMove]:
        moves: list[RobotMove] = []
        for robot in now.world.idle:
            cells = resting_place(now, moves)
            if robot.cell not in now.world.free_locations and cells:
                best = min(cells, key=lambda cell, robot=robot: (cost(now, robot, cell), cell))
                moves.append(RobotMove(robot.id, best))
        return moves

    return decide


def from_middle(now: Moment, robot: Robot, cell: int) -> int:
    """Cells along rows and columns from the middle of the grid."""
    layout = now.world.travel.layout
    (row, column), middle = divmod(cell, layout.width), (layout.height // 2, layout.width // 2)
    return abs(row - middle[0]) + abs(column - middle[1])


def charge_when_low(now: Moment, told: Any, *, low: float = 0.3, full: float = 0.8) -> list[RobotMove]:
    """Those with the least charge go to the chargers, and those that are full make way."""
    chargers, moves = now.world.travel.layout.chargers, list[RobotMove]()
    resting = [robot for robot in now.world.robots if robot.resting and robot.charge is not None]
    wanting = [r for r in resting if ((r.charge or 0) < low or r.low) and r.cell not in chargers]
    for robot in sorted(wanting, key=lambda robot: (robot.charge or 0, robot.id)):
        if free := [cell for cell in free_cells(now, moves) if cell in chargers]:
            goal = min(free, key=lambda cell, robot=robot: (empty_ticks(now, robot, cell), cell))
            moves.append(RobotMove(robot.id, goal, full))
    left = len(wanting) - len(moves)
    for robot in [r for r in resting if r.cell in chargers and (r.charge or 0) >= full][:left]:
        free = [cell for cell in free_cells(now, moves) if cell not in chargers]
        if free:
            places = [cell for cell in free if cell in now.world.free_locations] or free
            goal = min(places, key=lambda cell, robot=robot: (empty_ticks(now, robot, cell), cell))
            moves.append(RobotMove(robot.id, goal))
    return moves


# Stations


def activate_all(now: Moment, told: Any) -> list[int]:
    return [station.id for station in now.stations]


def staffed(now: Moment) -> list[Station]:
    """Those that their timetables have open, the largest first."""
    return sorted([s for s in now.stations if s.staffed], key=lambda station: (-station.capacity, station.id))


def constant_ratio(now: Moment, told: Any, *, ratio: float = 0.5) -> list[int]:
    """A share of those that are staffed."""
    return [station.id for station in staffed(now)][: max(1, math.floor(ratio * len(staffed(now))))]


def backlog_threshold(
    now: Moment, told: Any, *, open_above: int = 50, timeout_s: float = 600.0, least: int = 1
) -> list[int]:
    """One more while many orders wait, one fewer while there is little to do."""
    working = [station for station in staffed(now) if station.active]
    resting = [station for station in staffed(now) if not station.active]
    active = {station.id for station in now.stations if station.active}
    if len(working) < least:
        return sorted(active | {station.id for station in resting[: least - len(working)]})
    if now.now_s - now.memory.get("changed_s", -math.inf) < timeout_s:
        return sorted(active)
    many = len(now.world.backlog) > open_above
    few = sum(s.load for s in working) < 0.7 * sum(s.capacity for s in working)
    if many and not few and resting:
        active.add(resting[0].id)
    elif few and not many and len(working) > least:
        active.remove(working[-1].id)
    if active != {station.id for station in now.stations if station.active}:
        now.memory["changed_s"] = now.now_s
    return sorted(active)


# Paths


def fastest(now: Moment, told: Path) -> Path:
    """Return the rule's answer, if it is a path to the goal that is as fast as the fastest one."""
    travel, robot, goal = now.world.travel, now.robot, now.goal
    motion, width, loaded = travel.motion, travel.layout.width, robot.pod is not None

    def runs(cell: int) -> Iterator[tuple[int, int, int]]:
        """Where straight runs from a cell may end, in which heading, and how many metres away."""
        for way, step in enumerate((1, -width, -1, width)):
            to = cell + step
            while travel.heading(cell, to) == way and travel.run_problem(robot.cell, cell, to, goal, loaded) is None:
                yield to, way, (to - cell) // step
                to += step

    def ticks_of(cell: int, heading: int) -> dict[tuple[int, int], int]:
        """How long it takes to each end of a run, and heading there."""
        return {(to, way): motion.turn_ticks(heading, way) + motion.run_ticks(metres) for to, way, metres in runs(cell)}

    start = robot.cell, robot.heading
    ticks, heap = {start: 0}, [(0, *start)]
    while heap:
        at, *stop = heappop(heap)
        if ticks[tuple(stop)] == at:
            for end, more in ticks_of(*stop).items():
                if at + more < ticks.get(end, at + more + 1):
                    ticks[end] = at + more
                    heappush(heap, (at + more, *end))
    least = min(ticks.get((goal, way), math.inf) for way in range(4))
    stop, total = start, 0
    for leg in told.legs:
        found = [(end, more) for end, more in ticks_of(*stop).items() if end[0] == leg.to]
        if found:  # else it stays where it is
            stop, total = found[0][0], total + found[0][1] + leg.wait_ticks
    return told if (stop[0], total) == (goal, least) else Path((Leg(-1),))
