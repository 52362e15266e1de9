"""Robots, stations and chargers out of service: metrics, columns of hours.csv, and a sentence for the summary."""

from __future__ import annotations

from collections import Counter
from typing import Any

from rmfs_commands.details.spans import Count, Handlers, Number, ratio
from rmfs_commands.processes.events import ChargerDown, ChargerUp, RobotDown, RobotUp, StationDown, StationUp
from rmfs_core.info import RunInfo
from rmfs_core.wording import counted


def robots_may_fail(robots: Any) -> bool:
    """Whether robots of a section, or of a table of it, may be out of service."""
    get = robots.get if isinstance(robots, dict) else lambda key: getattr(robots, key)
    return bool(get("failures") or get("maintenance"))


def chargers_may_fail(robots: Any) -> bool:
    """Whether chargers may be out of service, by the section of robots, or a table of it."""
    get = robots.get if isinstance(robots, dict) else lambda key: getattr(robots, key)
    battery = get("battery") or {}
    return bool(battery.get("charger_outages") if isinstance(battery, dict) else battery.charger_outages)


class Outages:
    """Follows what is out of service.

    Parameters
    ----------
    run
        The run.
    begin
        The time from which on is counted.
    """

    def __init__(self, run: RunInfo, begin: int) -> None:
        self._view, self._begin = run.warehouse, begin
        self._on = {
            "robots": robots_may_fail(run.scenario.robots),
            "stations": run.scenario.stations.outages is not None,
            "chargers": chargers_may_fail(run.scenario.robots),
        }
        view = run.warehouse
        self._numbers = {
            "robots": len(view.robots),
            "stations": len(view.stations),
            "chargers": len(run.layout.chargers),
        }
        self._down = {kind: Count() for kind in self._on}
        self._failures: Counter[str] = Counter()
        self._held = 0
        self._of_robot: Counter[int] = Counter()
        self.handlers: Handlers = {
            RobotDown: self._robot_down,
            RobotUp: lambda event: self._down["robots"].add(event.tick, -1),
            StationDown: self._station_down,
            StationUp: lambda event: self._down["stations"].add(event.tick, -1),
            ChargerDown: self._charger_down,
            ChargerUp: lambda event: self._down["chargers"].add(event.tick, -1),
        }

    def _robot_down(self, event: RobotDown) -> None:
        self._down["robots"].add(event.tick, 1)
        if event.tick >= self._begin and not event.planned:
            self._failures["robots"] += 1
            self._of_robot[event.robot] += 1

    def _station_down(self, event: StationDown) -> None:
        self._down["stations"].add(event.tick, 1)
        if event.tick >= self._begin:
            self._failures["stations"] += 1
            waiting = self._view.station(event.station).open_requests
            self._held += len({request.order.id for request in waiting})

    def _charger_down(self, event: ChargerDown) -> None:
        self._down["chargers"].add(event.tick, 1)
        self._failures["chargers"] += event.tick >= self._begin

    def hourly(self) -> dict[str, Count]:
        """Return how many are out of service, by column of hours.csv."""
        return {f"{kind}_down": self._down[kind] for kind, on in self._on.items() if on}

    def _percent(self, kind: str, end: int) -> float | None:
        return ratio(100 * self._down[kind].mean(self._begin, end), self._numbers[kind]) if end > self._begin else None

    def values(self, end: int) -> dict[str, Number]:
        """Return the metrics; none of what never fails."""
        found: dict[str, Number] = {}
        if self._on["robots"]:
            found |= {"robot_failures": self._failures["robots"], "robots_down_percent": self._percent("robots", end)}
        if self._on["stations"]:
            found |= {"station_failures": self._failures["stations"], "orders_held": self._held}
            found["stations_down_percent"] = self._percent("stations", end)
        if self._on["chargers"]:
            found["charger_failures"] = self._failures["chargers"]
            found["chargers_down_percent"] = self._percent("chargers", end)
        return found

    def says(self, end: int) -> str | None:
        """Return what was out of service in a sentence; None where nothing ever is."""
        said = []
        if self._on["robots"]:
            told = f"robots failed {counted(self._failures['robots'], 'time')}"
            if self._of_robot:
                robot, times = min(self._of_robot.items(), key=lambda one: (-one[1], one[0]))
                told += f" (robot {self._view.robots[robot].name}: {counted(times, 'time')})"
            said.append(f"{told}; {self._percent('robots', end) or 0:.1f} % of their time out of service")
        if self._on["stations"]:
            told = f"stations failed {counted(self._failures['stations'], 'time')}"
            held = f"{counted(self._held, 'order')} waited for {'it' if self._failures['stations'] == 1 else 'them'}"
            said.append(f"{told}, {held}; {self._percent('stations', end) or 0:.1f} % of their time out of service")
        if self._on["chargers"]:
            told = f"chargers failed {counted(self._failures['chargers'], 'time')}"
            said.append(f"{told}; {self._percent('chargers', end) or 0:.1f} % of their time out of service")
        return "".join(f"{one[0].upper()}{one[1:]}. " for one in said).strip() or None
