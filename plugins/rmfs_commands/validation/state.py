"""Where everything is, as far as the events tell. After a fault the newer statement counts, so that it shows once."""

from __future__ import annotations

from collections import Counter

from attrs import Factory, define

from rmfs_commands.trace.reader import Trace


@define
class RobotState:
    """A robot: where it rests, since when it is free, what it carries.

    ``lifted_at`` is the storage location where it lifted its pod, until it has left it; ``lane`` the station whose
    queue it entered without having joined the line yet; ``task`` the pod it was told to fetch; ``rested_in`` the
    station in whose queue it stood still before a run and had not joined the line yet; ``joined_tick`` when it joined
    one last; ``sent`` where it is sent to rest, until it rests.
    """

    cell: int
    heading: int
    free_tick: int = 0
    pod: int | None = None
    task: int | None = None
    lifted_at: int | None = None
    lane: int | None = None
    rested_in: int | None = None
    joined_tick: int = -1
    sent: int | None = None


@define
class PodState:
    """A pod: its storage location or the robot that carries it, items left, where it is bound for and since when.

    ``next_station`` is what the end of its last visit said; ``to_storage`` that it said there is none; ``fetched_by``
    the robot that was told to fetch it, until it is stored.
    """

    location: int | None
    robot: int | None
    stock: dict[int, int | None]
    bound: list[tuple[int, int]]
    next_station: int | None = None
    to_storage: bool = False
    fetched_by: int | None = None


@define
class Visit:
    """A visit under way."""

    number: int
    robot: int
    pod: int
    start_tick: int
    picks: int = 0


@define
class StationState:
    """A station: robots in line, the visit under way, the picker, open requests by SKU, capacity in use.

    ``in_hand`` are the items (order, SKU, tick at which they are handled) whose orders use capacity until then.
    """

    line: list[int] = Factory(list)
    visit: Visit | None = None
    picker_free_tick: int = 0
    open: Counter[int] = Factory(Counter)
    load: int = 0
    in_hand: list[tuple[int, int, int]] = Factory(list)


@define
class OrderState:
    """An order: what is left of it to assign and to pick, and the part that each SKU belongs to.

    A part is what one period assigns to a station: (station, period), with the items left to pick (or to handle) and
    its size. ``waits`` says that it waits for stock. ``in_hand`` are its items that are picked and still to be handled;
    ``last_tick`` is when the last one was picked (or handled), ``begun_tick`` when its first lines were assigned.
    """

    unassigned: dict[int, int]
    unpicked: dict[int, int]
    part_of: dict[int, tuple[int, int]] = Factory(dict)
    left: Counter[tuple[int, int]] = Factory(Counter)
    size: Counter[tuple[int, int]] = Factory(Counter)
    arrived: bool = False
    waits: bool = False
    in_hand: int = 0
    last_tick: int = 0
    completed: bool = False
    cancelled: bool = False
    begun_tick: int | None = None


class State:
    """Everything at the moment of an event.

    Parameters
    ----------
    trace
        Its header says how the run starts.
    """

    def __init__(self, trace: Trace) -> None:
        self.robots = [RobotState(robot["cell"], robot["heading"]) for robot in trace.robots]
        self.pods: list[PodState] = []
        self.stored: dict[int, int | None] = dict.fromkeys(trace.blocked)  # location -> pod, None for an empty one
        for i, (start, data) in enumerate(zip(trace.pods, trace.instance.pods, strict=True)):
            robot = start["robot"]
            location = start["cell"] if robot is None else None
            bound = [(station, 0) for station in start["bound_for"]]
            self.pods.append(PodState(location, robot, dict(data.contents), bound, bound[0][0] if bound else None))
            if location is not None:
                self.stored[location] = i
            else:
                self.robots[robot].pod = self.robots[robot].task = i
        self.stations = [StationState() for _ in trace.stations]
        self.orders = [OrderState(dict(order.lines), dict(order.lines)) for order in trace.instance.orders]
        for cells, station in zip(trace.layout.stations, self.stations, strict=True):
            slots = (cells.station, *cells.queue)
            waiting = [i for i, robot in enumerate(self.robots) if robot.pod is not None and robot.cell in slots]
            station.line = sorted(waiting, key=lambda i: (slots.index(self.robots[i].cell), i))

    def take(self, robot: int, pod: int | None) -> None:
        """Let a robot carry a pod, or none, whichever robot did before."""
        old = self.robots[robot].pod
        if old is not None:
            self.pods[old].robot = None
        if pod is not None:
            before = self.pods[pod]
            if before.robot is not None:
                self.robots[before.robot].pod = None
            if before.location is not None and self.stored.get(before.location) == pod:
                del self.stored[before.location]
            before.robot, before.location = robot, None
        self.robots[robot].pod = pod

    def put(self, pod: int, cell: int) -> None:
        """Let a pod stand in a cell, whichever robot carried it."""
        carrier = self.pods[pod].robot
        if carrier is not None:
            self.robots[carrier].pod = None
        self.pods[pod].robot, self.pods[pod].location = None, cell
        self.stored[cell] = pod
