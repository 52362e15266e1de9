"""How long services take: as the scenario says, or drawn for each by what it is for."""

from __future__ import annotations

from collections import Counter

from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.randomness import keyed_stream
from rmfs_core.scenario.model import StationsSection
from rmfs_core.scenario.service import ServiceTime, drawn, speeds_of
from rmfs_core.timetable import Timetable

STORE_S = 10.0


class Services:
    """Ticks of services, told in the order in which each station does them.

    Draws depend on the seed and on what a service is for, never on what was drawn before: the n-th item of a line, the
    n-th visit in which a line is begun, an order at a station, a bundle, the n-th lift of a pod. So all rules meet the
    same.

    Parameters
    ----------
    section
        The times.
    seed
        The seed of the run.
    stations
        Number of picking stations.
    zero, lift_s
        Tick of the day at which the run starts; time of lifting.

    Raises
    ------
    InputError
        When ``section.speed`` names another station.
    """

    def __init__(self, section: StationsSection, seed: int, stations: int, zero: int = 0, lift_s: float = 0) -> None:
        self._section, self._seed, self._lift_s = section, seed, lift_s
        self._fixed = to_ticks(section.pick_s), to_ticks(section.handle_s), to_ticks(section.handle_s)
        spread = any(isinstance(seconds, ServiceTime) for seconds in (section.pick_s, section.handle_s))
        self.vary = bool(spread or section.line_s or section.order_s or section.speed)
        self.speeds: list[tuple[float, ...]] = [(1.0,)] * stations  # of each outside of all shifts, and in each
        self._shifts = [Timetable((), zero)] * stations
        for name, speed in section.speed.items():
            if name not in map(str, range(1, stations + 1)):
                raise InputError(f"stations.speed.{name}", f"no station {name}; expected 1 to {stations}")
            spans, self.speeds[int(name) - 1] = speeds_of(speed)
            self._shifts[int(name) - 1] = Timetable(spans, zero)
        self.begun: Counter[tuple[int | str, ...]] = Counter()  # items of a line, visits to it ...
        self.last: dict[int, tuple[int, int, int]] = {}  # of each station: visit, order, SKU

    def speed(self, station: int, tick: int) -> float:
        """Return how fast the picker of a station is; bundles are stored at speed 1 where nothing is picked."""
        return self.speeds[station][self._shifts[station].at(tick)] if station < len(self.speeds) else 1.0

    def pick(self, station: int, visit: int, order: int, sku: int, tick: int = 0) -> tuple[int, int, int]:
        """Return ticks of the next item of a line, begun at a tick: picking it, handling it (picking included), and
        what may be expected for that before it is over."""
        if not self.vary:
            return self._fixed
        section, before_s, expected_s = self._section, 0.0, float(self._section.handle_s)
        pick_s, handle_s = self.item_s(order, sku, self.count(order, sku))
        if self.last.get(station) != (now := (visit, order, sku)):
            self.last[station] = now
            before_s += self.begin_line_s(order, sku, self.count(order, sku, 0))
            expected_s += section.line_s or 0
        if not self.count(order, station, 0, 0):
            before_s += self.begin_order_s(order, station)
            expected_s += section.order_s or 0
        times = before_s + pick_s, before_s + handle_s, expected_s
        speed = self.speed(station, tick)
        pick, handle, expected = (max(to_ticks(seconds / speed), 1) for seconds in times)
        return pick, handle, expected

    def begin_line_s(self, order: int, sku: int, visits: int = 0) -> float:
        """Return the seconds of beginning a line, after so many visits in which it was begun, at speed 1."""
        return self.draw(self._section.line_s, "lines", order, sku, visits)

    def begin_order_s(self, order: int, station: int) -> float:
        """Return the seconds of beginning an order at a station, at speed 1."""
        return self.draw(self._section.order_s, "orders", order, station)

    def item_s(self, order: int, sku: int, number: int) -> tuple[float, float]:
        """Return the seconds of picking and handling the n-th item of a line, from 0, at speed 1."""
        pick_s, handle_s = (
            self.draw(seconds, "items", order, sku, number)
            for seconds in (self._section.pick_s, self._section.handle_s)
        )
        return pick_s, max(pick_s, handle_s)

    def store(self, station: int, bundle: int, tick: int = 0) -> tuple[int, int]:
        """Return ticks of storing a bundle at a station, begun at a tick, and what may be expected for it."""
        given, speed = self._section.store_s, self.speed(station, tick)
        times = STORE_S if given is None else given, self.draw(given or STORE_S, "bundles", bundle)
        expected, ticks = (max(to_ticks(seconds / speed), 1) for seconds in times)
        return ticks, expected

    def lift(self, pod: int) -> int:
        """Return the ticks of lifting a pod or setting it down, the next time that this happens."""
        if not isinstance(self._lift_s, ServiceTime):
            return to_ticks(self._lift_s)
        return to_ticks(self.draw(self._lift_s, "lifts", pod, self.count(pod)))

    def count(self, *what: int | str) -> int:
        """Count something; return how many there were before."""
        self.begun[what] += 1
        return self.begun[what] - 1

    def draw(self, seconds: float | None, purpose: str, *what: int) -> float:
        """Return the seconds of one service, of a purpose and told by up to three numbers."""
        if not isinstance(seconds, ServiceTime):
            return seconds or 0.0
        return drawn(seconds, keyed_stream(self._seed, f"service {purpose}", *what))
