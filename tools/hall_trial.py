"""Run a hall of one's own behind a session, as an integrator would: noise, a lost robot, cancellations, a miscount.

``python tools/hall_trial.py [--orders N] [--open N] [--events N] [--seed S]``. The floor is no simulation of rmfs: it
drives, lifts and picks by itself, in times that vary, does what the session's commands say or refuses it, and reports
facts. ``--open`` keeps so many orders open, until there were so many events. Printed are events per second of CPU, the
99th percentile of the CPU time for a batch, and the memory as it grows; exit code 1 when an order in stock is left.
"""

from __future__ import annotations

import argparse
import heapq
import itertools
import random
import resource
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from rmfs_commands.session import Hall
from rmfs_core.scenario import Scenario
from rmfs_core.scenario.reading import scenario_from_dict

RULES: Mapping[str, Mapping[str, Any]] = {
    "sequential": {"poa": "pod-match", "pps": "demand"},
    "joint": {"poa_pps": "pod-index"},
}
Take = Callable[[dict[str, Any]], Mapping[str, Any]]
LIFT_S, PICK_S, HANDLE_S, DRIVE_S = 4.0, 6.0, 5.0, 1.0
"""Mean times of the floor; for driving, per cell."""


BACK = {
    **dict.fromkeys(("fetch", "lift", "go_on", "move_robot"), ("robot_back", "robot")),
    "store": ("cell_free", "cell"),
    "pick_next": ("pod_unlocked", "pod"),
    "assign": ("order_back", "order"),
}
"""By what is refused, the fact that later lets the session use again what was concerned."""


class OwnHall:
    """A floor that does what it is told.

    Parameters
    ----------
    take
        Takes a batch; returns the session's answer.
    state
        The session's state before the first batch: names, cells and contents.
    seed
        Of all times.
    refuses
        Share of the commands that are refused.
    """

    def __init__(self, take: Take, state: Mapping[str, Any], seed: int = 1, refuses: float = 0.0) -> None:
        self.refuses, self.refused = refuses, Counter[str]()
        self._take, self._rng = take, random.Random(seed)
        self.width = len(state["layout"]["map"][0])
        self.cells = {robot: told["cell"] for robot, told in state["robots"].items()}
        self.pod_cells = {pod: told["cell"] for pod, told in state["pods"].items() if "cell" in told}
        self.stock = {pod: Counter(told["contents"]) for pod, told in state["pods"].items()}
        self.station_cells = dict(zip(state["stations"], _station_cells(state["layout"]["map"]), strict=True))
        self.homes = sorted(told["home"] for told in state["pods"].values())
        self.goals: dict[str, int] = {}  # by pod, the cell that is kept for it
        self.wanted: dict[str, Counter[str]] = {}
        self.cancelled: set[str] = set()
        self.tasks: dict[str, tuple[str, str]] = {}  # robot: pod and station
        self.on: dict[str, str] = {}  # pod: robot that carries it
        self.lines: dict[str, list[str]] = defaultdict(list)  # pods at a station, the first in front of the picker
        self.lost: set[str] = set()
        self.packed: set[str] = set()
        self._bundles: dict[str, dict[str, int]] = {}
        self.seq, self.now, self.events = 0, 0.0, 0
        self.dropped: list[Any] = []
        self.cpu: list[float] = []
        self._due: list[tuple[float, int, Callable[[], Iterator[dict[str, Any]]]]] = []
        self._count, self._ids = itertools.count(), itertools.count()

    def take_over(self, state: Mapping[str, Any]) -> None:
        """Put a state into the session's place, and go on from there: with what robots do, and pickers have in hand."""
        answer = self._take({"after": self.seq, "state": dict(state)})
        self._due.clear()
        self.seq = answer["seq"]
        commanded = {one["robot"] for one in answer["commands"] if "robot" in one}
        self.on = {told["task"]: robot for robot, told in state["robots"].items() if "task" in told}
        self.on = {pod: robot for pod, robot in self.on.items() if "cell" not in state["pods"][pod]}
        self.lines = defaultdict(list, {name: [*told["line"]] for name, told in state["stations"].items()})
        bound = {pod: name for name, told in state["stations"].items() for pod in told["inbound"]}
        self.tasks = {}
        for robot, told in state["robots"].items():
            pod = told.get("task")
            if pod is None or pod not in bound:
                continue
            self.tasks[robot] = pod, state["pods"][pod].get("bound_for", [bound[pod]])[0]
            if any(pod in line for line in self.lines.values()) or robot in commanded or robot in self.lost:
                continue
            if pod in self.on:
                self._to(robot, *self.tasks[robot])
            elif told["cell"] != state["pods"][pod]["cell"]:
                self._drive(robot, state["pods"][pod]["cell"], lambda: iter(()))
        for station, line in self.lines.items():
            if line:
                self.at(3, partial(self._moves_up, station, line[0]))
            if "in_hand" in state["stations"][station]:
                self.at(HANDLE_S, lambda station=station: iter([{"kind": "handled", "station": station}]))  # type: ignore[misc]
        self._follow(answer)

    # Time

    def at(self, seconds: float, does: Callable[[], Iterator[dict[str, Any]]]) -> None:
        """Let something happen so many seconds from now, in any time from half of that to twice."""
        noise = self._rng.uniform(0.5, 2.0)
        heapq.heappush(self._due, (self.now + seconds * noise, next(self._count), does))

    def run(self, until: Callable[[], bool] = lambda: False) -> None:
        """Go on until nothing is left to happen."""
        while self._due and not until():
            self.now, _, does = heapq.heappop(self._due)
            self.now = round(self.now, 3)
            if events := list(does()):
                self.send(events)

    def send(self, events: list[dict[str, Any]]) -> None:
        """Report facts, and begin what is commanded."""
        told = [{"id": f"{next(self._ids)}", **event} for event in events]
        started = time.process_time()
        answer = self._take({"after": self.seq, "time_s": self.now, "events": told})
        self.cpu.append(time.process_time() - started)
        self.seq, self.events = answer["seq"], self.events + len(told)
        self.dropped += answer["dropped"]
        self._follow(answer)

    def _follow(self, answer: Mapping[str, Any]) -> None:
        refusing = set[str]()  # robots, which do nothing further then
        for command in answer["commands"]:
            if command.get("robot") in refusing:
                continue
            if command["kind"] in BACK and self._rng.random() < self.refuses:
                self.at(1, partial(self._refuse, command))
                refusing.add(command.get("robot", ""))
            elif command.get("robot") not in self.lost and (does := getattr(self, f"_{command['kind']}", None)):
                does(command)
        if (again := answer["ask_again_s"]) is not None and again > self.now:
            heapq.heappush(self._due, (again, next(self._count), lambda: iter(())))

    def _refuse(self, command: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
        kind, what = BACK[command["kind"]]
        self.refused[command["kind"]] += 1
        if command.get("robot") not in self.lost:
            self.at(60, lambda: iter([{"kind": kind, what: command[what]}]))
        yield {"kind": "command_refused", "command": command["command"], "why": "not now"}

    # What robots do

    def _metres(self, origin: int, cell: int) -> int:
        return abs(origin // self.width - cell // self.width) + abs(origin % self.width - cell % self.width)

    def _drive(self, robot: str, cell: int, then: Callable[[], Iterator[dict[str, Any]]]) -> None:
        def arrives() -> Iterator[dict[str, Any]]:
            if robot not in self.lost:
                self.cells[robot] = cell
                yield {"kind": "robot_at", "robot": robot, "cell": cell}
                yield from then()

        self.at(2 + DRIVE_S * self._metres(self.cells[robot], cell), arrives)

    def _fetch(self, command: Mapping[str, Any]) -> None:
        robot, pod = command["robot"], command["pod"]
        self.tasks[robot] = pod, command["station"]
        if self.cells[robot] != self.pod_cells[pod]:
            self._drive(robot, self.pod_cells[pod], lambda: iter(()))

    def _lift(self, command: Mapping[str, Any]) -> None:
        robot, pod = command["robot"], command["pod"]

        def lifted() -> Iterator[dict[str, Any]]:
            if robot not in self.lost:
                self.on[pod] = robot
                yield {"kind": "pod_lifted", "pod": pod}
                self._to(robot, pod, self.tasks[robot][1])

        self.at(LIFT_S, lifted)

    def _to(self, robot: str, pod: str, station: str) -> None:
        def queued() -> Iterator[dict[str, Any]]:
            self.lines[station].append(pod)
            yield {"kind": "pod_queued", "pod": pod, "station": station}
            if self.lines[station][0] == pod:
                yield {"kind": "pod_at_station", "pod": pod, "station": station}

        self._drive(robot, self.station_cells[station], queued)

    def _leave(self, pod: str) -> None:
        for station, line in self.lines.items():
            if pod in line:
                first = line[0] == pod
                line.remove(pod)
                if first and line:
                    self.at(3, partial(self._moves_up, station, line[0]))

    def _moves_up(self, station: str, pod: str) -> Iterator[dict[str, Any]]:
        if self.lines[station][:1] == [pod] and self.on[pod] not in self.lost:
            yield {"kind": "pod_at_station", "pod": pod, "station": station}

    def _go_on(self, command: Mapping[str, Any]) -> None:
        self._leave(command["pod"])
        self._to(command["robot"], command["pod"], command["station"])

    def _store(self, command: Mapping[str, Any]) -> None:
        robot, pod, cell = command["robot"], command["pod"], command["cell"]
        self._leave(pod)
        self.goals[pod] = cell

        def stored() -> Iterator[dict[str, Any]]:
            if robot not in self.lost:
                self.pod_cells[pod] = cell
                del self.on[pod], self.goals[pod]
                yield {"kind": "pod_stored", "pod": pod, "cell": cell}

        def there() -> Iterator[dict[str, Any]]:
            self.at(LIFT_S, stored)
            yield from ()

        self._drive(robot, cell, there)

    def _move_robot(self, command: Mapping[str, Any]) -> None:
        def there() -> Iterator[dict[str, Any]]:
            if command["charge"]:
                yield {"kind": "robot_charged", "robot": command["robot"]}

        self._drive(command["robot"], command["cell"], there)

    # What pickers do

    def _pick_next(self, command: Mapping[str, Any]) -> None:
        pod, sku, order, station = (command[name] for name in ("pod", "sku", "order", "station"))

        def picked() -> Iterator[dict[str, Any]]:
            if self.stock[pod][sku] <= 0:
                yield {"kind": "short", "pod": pod, "sku": sku, "counted": 0}
                return
            self.stock[pod][sku] -= 1
            self.wanted[order][sku] -= 1
            yield {"kind": "picked", "pod": pod, "order": order, "sku": sku}
            self.at(HANDLE_S, lambda: iter([{"kind": "handled", "station": station}]))

        self.at(PICK_S, picked)

    def _store_bundle(self, command: Mapping[str, Any]) -> None:
        pod, bundle = command["pod"], command["bundle"]

        def stored() -> Iterator[dict[str, Any]]:
            self.stock[pod].update(self._bundles.pop(bundle))
            yield {"kind": "bundle_stored", "pod": pod, "bundle": bundle}

        self.at(PICK_S, stored)

    # What is brought, and what is packed

    def _reorder(self, command: Mapping[str, Any]) -> None:
        bundle, told = f"bundle {next(self._ids)}", {name: command[name] for name in ("sku", "items")}
        self._bundles[bundle] = {told["sku"]: told["items"]}
        self.at(300, lambda: iter([{"kind": "bundle_arrived", "bundle": bundle, **told}]))

    def _send_part(self, command: Mapping[str, Any]) -> None:
        self.at(30, lambda: iter([{"kind": "part_arrived", "tote": command["tote"]}]))

    def _put_next(self, command: Mapping[str, Any]) -> None:
        self.at(8, lambda: iter([{"kind": "part_packed", "tote": command["tote"]}]))

    def _pack_next(self, command: Mapping[str, Any]) -> None:
        def packed() -> Iterator[dict[str, Any]]:
            self.packed.add(command["order"])
            yield {"kind": "order_packed", "order": command["order"]}

        self.at(20, packed)

    # What goes wrong

    def order(self, name: str, lines: Mapping[str, int]) -> dict[str, Any]:
        """Return an order that arrives."""
        self.wanted[name] = Counter(lines)
        return {"kind": "order_arrived", "order": name, "lines": dict(lines)}

    def arrive(self, name: str, lines: Mapping[str, int]) -> Iterator[dict[str, Any]]:
        """Let an order arrive."""
        yield self.order(name, lines)

    def cancel(self, order: str) -> Iterator[dict[str, Any]]:
        """Cancel an order; it is picked on if it is begun."""
        self.cancelled.add(order)
        yield {"kind": "order_cancelled", "order": order}

    def lose(self, minutes: float) -> Iterator[dict[str, Any]]:
        """Lose the first robot that carries a pod; somebody brings the pod back, and nobody the robot."""
        carrying = [pod for pod, robot in self.on.items() if not any(pod in line for line in self.lines.values())]
        if not carrying:
            self.at(5, lambda: self.lose(minutes))
            return
        pod = carrying[0]
        robot = self.on[pod]
        self.lost.add(robot)
        self.at(60 * minutes, lambda: self._brought(pod))
        yield {"kind": "robot_failed", "robot": robot}

    def _brought(self, pod: str) -> Iterator[dict[str, Any]]:
        taken = {cell for other, cell in self.pod_cells.items() if other not in self.on} | {*self.goals.values()}
        cell = next(cell for cell in self.homes if cell not in taken)
        del self.on[pod]
        self.pod_cells[pod] = cell
        yield {"kind": "pod_stored", "pod": pod, "cell": cell}

    @property
    def left(self) -> list[str]:
        """Orders of which items were not picked, and that nobody has cancelled."""
        return [name for name, items in self.wanted.items() if +items and name not in self.cancelled]


def _station_cells(drawn: list[str]) -> Iterator[int]:
    """Yield the cells of the stations on a map, first to last."""
    for row, line in enumerate(drawn):
        for column, sign in enumerate(line):
            if sign in "OIX":
                yield row * len(line) + column


def scenario_of(
    rules: Mapping[str, Any], pods: int = 60, robots: int = 6, blocks: int = 4, *, unlimited: bool = False
) -> Scenario:
    """Return a hall with finite stock, unless it is to be unlimited."""
    instance = {"skus": pods, "pods": pods, "skus_per_pod": 3} | ({} if unlimited else {"items_per_sku": 40})
    layout = {"block_rows": 6, "block_columns": blocks, "stations_east": 2}
    tables = {"seed": 1, "instance": instance, "layout": layout, "robots": {"count": robots}, "rules": rules}
    return scenario_from_dict(tables)


def trouble(take: Take, state: Mapping[str, Any], orders: int, seed: int = 1, refuses: float = 0.02) -> OwnHall:
    """Run a hall to its end in which a robot is lost, orders are cancelled, and pods hold less than they should."""
    hall, rng = OwnHall(take, state, seed, refuses), random.Random(seed)
    there = Counter(sku for held in hall.stock.values() for sku in held.elements())
    for pod in sorted(hall.stock)[: len(hall.stock) // 4]:  # miscounts, none of which makes a SKU scarce
        for sku in hall.stock[pod]:
            hall.stock[pod][sku] = min(hall.stock[pod][sku], 1)
    for number in range(orders):
        lines = Counter(rng.choices(sorted(there), k=rng.randint(1, 3)))
        name = f"order {number}"
        hall.at(20.0 * number, partial(hall.arrive, name, lines))
        if number % 10 == 3:
            hall.at(20.0 * number + 30, partial(hall.cancel, name))
    hall.at(300, lambda: hall.lose(10))
    hall.run()
    return hall


def main() -> int:
    """Run the trial with sequential and joint rules, or measure a hall with many open orders."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orders", type=int, default=300)
    parser.add_argument("--open", type=int, default=0, help="orders that are open all the time; 0: no measurement")
    parser.add_argument("--events", type=int, default=20_000)
    parser.add_argument("--journal", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    if given.open:
        return measure(given.open, given.events, given.journal)
    failed = 0
    for name, rules in RULES.items():
        session = Hall(scenario_of(rules), given.journal)
        hall = trouble(session.take, session.state, given.orders, given.seed)
        done = f"{hall.events:,} events, {len(hall.dropped)} dropped, {len(hall.left)} orders left"
        print(f"{name}: {done}, {hall.events / sum(hall.cpu):,.0f} events per second of CPU")
        failed |= bool(hall.left)
        session.close()
    return failed


def measure(there: int, events: int, journal: Path | None) -> int:
    """Print what a session with many open orders and 64 robots costs."""
    session = Hall(scenario_of(RULES["sequential"], 900, 64, 20), journal)
    hall, rng = OwnHall(session.take, session.state), random.Random(1)
    skus, numbers = sorted({sku for held in hall.stock.values() for sku in held}), itertools.count()

    def arrive(number: int) -> Iterator[dict[str, Any]]:
        return (hall.order(f"{next(numbers)}", Counter(rng.choices(skus, k=2))) for _ in range(number))

    def refill() -> Iterator[dict[str, Any]]:
        hall.at(10, refill)
        for name in [name for name, items in hall.wanted.items() if not +items]:
            del hall.wanted[name]
        return arrive(there - len(hall.wanted))

    hall.at(0.001, refill)
    hall.run(lambda: bool(hall.events))
    first = hall.events
    for share in range(1, 11):
        began = hall.events
        hall.cpu.clear()
        most = first + events * share // 10
        hall.run(lambda most=most: hall.events >= most)  # type: ignore[misc]
        cpu = sorted(hall.cpu)
        p99, rate = cpu[len(cpu) * 99 // 100], (hall.events - began) / sum(cpu)
        print(f"{hall.events:8,} events, {rate:6,.0f} per second of CPU, p99 {1000 * p99:.1f} ms, {memory_mb():.0f} MB")
    print(f"{len(hall.dropped)} dropped")
    return 0


def memory_mb() -> float:
    """Return the memory that this process has."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize() / 1e6


if __name__ == "__main__":
    sys.exit(main())
