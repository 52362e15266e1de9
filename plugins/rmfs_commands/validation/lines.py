"""The lines at stations and the visits of pods."""

from __future__ import annotations

from rmfs_commands.validation.case import Case, Handlers
from rmfs_commands.validation.state import PodState, State, Visit
from rmfs_core.events import QueueJoined, RobotMoved, TripDecided, VisitEnded, VisitStarted


class LineCheck:
    """Pods come to a station because a trip was decided, wait in line, and are served in the order of arrival."""

    def __init__(self, case: Case, state: State, *, collisions: bool) -> None:
        self.case = case
        self.state = state
        self.collisions = collisions
        self.visits = 0
        self.handlers: Handlers = {
            TripDecided: self.trip,
            RobotMoved: self.moved,
            QueueJoined: self.joined,
            VisitStarted: self.started,
            VisitEnded: self.ended,
        }

    def trip(self, event: TripDecided) -> None:
        """Note where a pod is bound for."""
        pod = self.state.pods[event.pod]
        if any(station == event.station for station, _ in pod.bound):
            self.case.add(
                "bound-twice",
                event.tick,
                f"{self.case.pod(event.pod)} is sent to {self.case.station(event.station)}, "
                "where it is or is bound for already",
            )
        pod.bound.append((event.station, event.tick))

    def moved(self, event: RobotMoved) -> None:
        """Check that a robot keeps behind its position in line, wherever it entered the queue."""
        case, i = self.case, self.case.lane[event.to]
        if i < 0 or event.pod is None or not self.collisions:
            return
        line, cells = self.state.stations[i].line, case.layout.stations[i]
        ahead = line.index(event.robot) if event.robot in line else len(line)
        place = (cells.station, *cells.queue).index(event.to)
        if place < ahead:
            drives = f"{case.robot(event.robot)} drives to {case.where(event.to)} in the queue of {case.station(i)}"
            case.add("queue-passed", event.tick, f"{drives}, position {place} there; robots ahead in line: {ahead}")

    def joined(self, event: QueueJoined) -> None:
        """Check that a robot stands in the queue, and that the queue has a free cell."""
        case, robot, line = self.case, self.state.robots[event.robot], self.state.stations[event.station].line
        joins = f"{case.robot(event.robot)} with {case.pod(event.pod)} joins the line of {case.station(event.station)}"
        if case.lane[robot.cell] != event.station:
            case.add("robot-elsewhere", event.tick, f"{joins}, but stands at {case.where(robot.cell)}")
        if robot.pod != event.pod:
            case.add("pod-mismatch", event.tick, f"{joins}, but carries {case.load(robot.pod)}")
        if event.robot in line:
            case.add("queue-order", event.tick, f"{joins}, but is in it already")
        else:
            line.append(event.robot)
        if len(line) > case.queue_length + 1:
            case.add(
                "queue-too-long",
                event.tick,
                f"{joins}, which is {len(line)} long then; the station and its queue hold {case.queue_length + 1}",
            )
        self._bound(event, joins)
        robot.lane, robot.joined_tick = None, event.tick

    def started(self, event: VisitStarted) -> None:
        """Check that the pod stands at the station, is first in line and bound for it."""
        case, robot, station = self.case, self.state.robots[event.robot], self.state.stations[event.station]
        visits = f"{case.robot(event.robot)} with {case.pod(event.pod)} starts a visit at {case.station(event.station)}"
        self.visits += 1
        if event.visit != self.visits:
            case.add("visit-number", event.tick, f"{visits} with the number {event.visit}; expected {self.visits}")
            self.visits = event.visit
        if robot.cell != case.layout.stations[event.station].station:
            case.add("robot-elsewhere", event.tick, f"{visits}, but stands at {case.where(robot.cell)}")
        if robot.pod != event.pod:
            case.add("pod-mismatch", event.tick, f"{visits}, but carries {case.load(robot.pod)}")
        if station.visit is not None:
            case.add("station-busy", event.tick, f"{visits}, where {case.pod(station.visit.pod)} still is")
        if not station.line or station.line[0] != event.robot:
            first = f"{case.robot(station.line[0])} is first" if station.line else "nobody is"
            case.add("queue-order", event.tick, f"{visits}, but {first} in its line")
        self._bound(event, visits)
        late = robot.joined_tick == event.tick and robot.rested_in == event.station
        if late and not any(self._comes(other, event.station) for other in range(len(self.state.robots))):
            case.add("joined-late", event.tick, f"{visits}, in whose queue it waited; it joined the line just now")
        robot.rested_in = None
        station.visit = Visit(event.visit, event.robot, event.pod, event.tick)
        robot.free_tick = max(robot.free_tick, event.tick)

    def ended(self, event: VisitEnded) -> None:
        """Check that the visit was under way, and note where the pod goes."""
        case, pod, station = self.case, self.state.pods[event.pod], self.state.stations[event.station]
        leaves = f"{case.pod(event.pod)} leaves {case.station(event.station)}"
        visit = station.visit
        if visit is None or (visit.number, visit.pod) != (event.visit, event.pod):
            there = "no pod is" if visit is None else f"{case.pod(visit.pod)} with visit {visit.number} is"
            case.add("visit-end", event.tick, f"{leaves} after visit {event.visit}, but {there} there")
        if visit is not None:
            self._stayed(event, visit, leaves)
            if visit.robot in station.line:
                station.line.remove(visit.robot)
        station.visit = None
        pod.bound = [entry for entry in pod.bound if entry[0] != event.station]
        pod.next_station, pod.to_storage = event.next_station, event.next_station is None
        if event.next_station is not None and not any(entry[0] == event.next_station for entry in pod.bound):
            going = case.station(event.next_station)
            case.add("not-bound", event.tick, f"{leaves} for {going}, which it is not bound for")
        for sku, number in pod.stock.items():
            if number is None and station.open[sku] > 0:
                case.add("left-early", event.tick, f"{leaves}, where {case.sku(sku)} is still wanted")

    def at_end(self) -> None:
        """Check that no robot has left a station during a visit that is not over."""
        case = self.case
        for cells, station in zip(case.layout.stations, self.state.stations, strict=True):
            visit = station.visit
            if visit is not None and self.state.robots[visit.robot].cell != cells.station:
                left = f"{case.robot(visit.robot)} left {case.where(cells.station)}"
                case.add("moved-in-visit", case.trace.tick, f"{left} during visit {visit.number}, which has no end")

    def _stayed(self, event: VisitEnded, visit: Visit, leaves: str) -> None:
        """Check what happened during a visit."""
        robot = self.state.robots[visit.robot]
        if event.picks != visit.picks:
            self.case.add("visit-picks", event.tick, f"{leaves} after {visit.picks} picks, but reports {event.picks}")
        if robot.cell != self.case.layout.stations[event.station].station or robot.free_tick > visit.start_tick:
            self.case.add(
                "moved-in-visit", event.tick, f"{leaves}, but {self.case.robot(visit.robot)} moved during the visit"
            )
        robot.free_tick = event.tick

    def _comes(self, i: int, station: int) -> bool:
        """Whether a robot is on its way to a line: it may have had a position ahead, and have lost it just now."""
        robot = self.state.robots[i]
        coming = robot.pod is not None and any(at == station for at, _ in self.state.pods[robot.pod].bound)
        return coming and i not in self.state.stations[station].line

    def _bound(self, event: QueueJoined | VisitStarted, doing: str) -> None:
        """Check that a station is the next one of a pod's stations."""
        case, pod = self.case, self.state.pods[event.pod]
        if event.station not in _first(pod):
            bound = " or ".join(case.station(station) for station in _first(pod)) or "no station"
            case.add("not-bound", event.tick, f"{doing}, but {case.pod(event.pod)} is bound for {bound} first")
            pod.bound.insert(0, (event.station, event.tick))
        if pod.to_storage or pod.next_station not in (None, event.station):
            going = "to storage" if pod.next_station is None else f"on to {case.station(pod.next_station)}"
            case.add("next-station", event.tick, f"{doing}, but {case.pod(event.pod)} was to go {going}")
            pod.to_storage = False
        if isinstance(event, VisitStarted):
            pod.next_station = None


def _first(pod: PodState) -> list[int]:
    """Stations whose trips were decided first; ties are open."""
    return [station for station, tick in pod.bound if tick == pod.bound[0][1]]
