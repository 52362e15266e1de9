"""A trace under examination: quick access to what its header says, names for people, and the faults found so far."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from rmfs_commands.instances.calendar import Calendar
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.fault import KINDS, Fault
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.events import Event, RobotMoved
from rmfs_core.scenario.model import PackingSection, RobotsSection, StationsSection
from rmfs_core.scenario.service import MAY_SPREAD
from rmfs_core.scenario.structuring import KeyProblem, structure_as
from rmfs_core.simulation.services import Services
from rmfs_core.world import CellKind
from rmfs_core.world.grid import RESTING

Handlers = Mapping[type[Event], Callable[[Any], None]]
"""Functions that a check calls at each kind of event."""

NOBODY_WAITS = "free-flow"
"""PP rule by which no robot waits for another."""


def name_of(choice: object) -> object:
    """Return a rule's name where a scenario may give it alone, or in a table with parameters."""
    return choice.get("rule") if isinstance(choice, Mapping) else choice


def nobody_waits(trace: Trace) -> bool:
    """Whether no robot waits for another by the PP rule of a trace's scenario."""
    return bool(name_of(trace.scenario.get("rules", {}).get("pp")) == NOBODY_WAITS)


def avoids_collisions(trace: Trace) -> bool:
    """Whether the PP rule keeps robots apart, as the header says; traces of rmfs 0.2 do not say it of free-flow."""
    return not nobody_waits(trace) and trace.apart


class Case:
    """A trace, and its faults.

    Parameters
    ----------
    trace
        The trace.

    Raises
    ------
    InputError
        When the header lacks what a validation needs.
    """

    def __init__(self, trace: Trace) -> None:
        self.trace = trace
        self.layout = trace.layout
        self.motion = trace.motion
        self.avoids_collisions = avoids_collisions(trace)
        self.faults: list[Fault] = []
        self.kind = trace.layout.kind.tolist()
        self.moves = trace.layout.moves.tolist()
        self.lane = trace.layout.lane.tolist()
        self.run_ticks = cache(trace.motion.run_ticks)
        self.turn_ticks = cache(trace.motion.turn_ticks)
        section = "stations"
        try:
            stations, robots = trace.scenario["stations"], trace.scenario.get("robots", {})
            times = {key: stations[key] for key in ("pick_s", "handle_s")}
            times |= {key: stations[key] for key in ("line_s", "order_s", "speed", "store_s") if key in stations}
            picking = len(trace.layout.stations) - trace.layout.replenishing
            seed = int(trace.scenario.get("seed", 1))
            zero = Calendar(trace.scenario.get("instance", {}).get("start")).time_of_day()
            own, section = structure_as(StationsSection, times), "packing"
            given = trace.scenario.get("packing") or {}
            packs = {key: given[key] for key in MAY_SPREAD["packing"] if key in given}
            self.packing = structure_as(PackingSection, packs)
            section, varies = "robots", isinstance(robots.get("lift_s"), Mapping)
            lift_s = structure_as(RobotsSection, {"lift_s": robots["lift_s"]}).lift_s if varies else trace.motion.lift_s
            self.services = Services(own, seed, picking, zero, lift_s)
            self.keeps_places = stations.get("release", "picked") == "handled"
            shortest = min((own.places for own in trace.layout.stations), default=12)
            self.queue_length = int(stations.get("queue_length", min(12, shortest)))
        except KeyError as error:
            raise InputError("header of the trace", f"the scenario lacks {error} among its stations") from error
        except KeyProblem as problem:
            raise InputError(
                f"header of the trace, {section}.{'.'.join(map(str, problem.path))}", problem.problem
            ) from None

    def add(self, kind: str, tick: int, sentence: str) -> None:
        """Note a fault."""
        assert kind in KINDS
        self.faults.append(Fault(kind, tick, sentence))

    def is_cut_off(self, event: RobotMoved) -> bool:
        """Whether the end of the run has cut a leg off: the robot was then still driving."""
        ended, distance = self.trace.status != "complete", self.layout.distance(event.origin, event.to)
        taken = event.tick - event.start_tick - event.wait_ticks - event.turn_ticks
        return ended and event.tick == self.trace.tick and distance > 0 and taken != self.run_ticks(distance)

    def is_storage(self, cell: int) -> bool:
        """Whether a cell is a storage location."""
        return bool(self.kind[cell] == CellKind.STORAGE)

    def is_rest(self, cell: int) -> bool:
        """Whether robots may rest in a cell: a storage location, a charger, or a maintenance cell."""
        return bool(self.kind[cell] in RESTING)

    def heading(self, cell: int, to: int) -> int | None:
        """Heading of a straight run from one cell to another; None when there is none."""
        width = self.layout.width
        right, down = to % width - cell % width, to // width - cell // width
        if (right == 0) == (down == 0):
            return None
        if down == 0:
            return 0 if right > 0 else 2
        return 3 if down > 0 else 1

    def step(self, heading: int) -> int:
        """Difference in cell index of one cell in a heading."""
        return (1, -self.layout.width, -1, self.layout.width)[heading]

    # Names

    def where(self, cell: int) -> str:
        """Cell for people."""
        return self.layout.where(cell)

    def robot(self, robot: int) -> str:
        """Robot for people."""
        return f"robot {robot + 1}"

    def pod(self, pod: int | None) -> str:
        """Pod for people; None is an empty one."""
        return "an empty pod" if pod is None else f"pod {self.trace.instance.pods[pod].name}"

    def load(self, pod: int | None) -> str:
        """The pod that a robot carries, for people."""
        return "no pod" if pod is None else self.pod(pod)

    def station(self, station: int) -> str:
        """Station for people."""
        return f"station {self.trace.stations[station]['name']}"

    def order(self, order: int) -> str:
        """Order for people."""
        return f"order {self.trace.instance.orders[order].name}"

    def sku(self, sku: int) -> str:
        """SKU for people."""
        return f"SKU {self.trace.instance.skus[sku]}"


def seconds(ticks: int | float) -> str:
    """Time for people."""
    return f"{ticks / TICKS_PER_S:.3f} s"
