"""The scenario with other numbers of stations and robots, and what can be said of it without a run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import cached_property
from statistics import fmean

from attrs import evolve

from rmfs_commands.bounds import BOUNDED, find_bounds
from rmfs_commands.sizing.target import Target
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario
from rmfs_core.simulation.setup import open_warehouse
from rmfs_core.world import Instance, make_instance, make_layout

Changes = dict[str, int]


class Worlds:
    """A scenario's warehouse in other sizes, with the same orders.

    Parameters
    ----------
    scenario
        What varies in size.
    seeds
        Whose orders are looked at.
    """

    def __init__(self, scenario: Scenario, seeds: Sequence[int]) -> None:
        self.scenario = scenario
        self._seeds = seeds
        self._east: dict[int, int] = {}
        self._no_room_for: float = math.inf

    @cached_property
    def instances(self) -> list[Instance]:
        """Orders and pods of each seed; from files they are the same, unless days are drawn from them."""
        if self.scenario.instance.orders_file is not None and self.scenario.instance.scale is None:
            return [make_instance(self.scenario)] * len(self._seeds)
        return [make_instance(self.scenario.with_seed(seed)) for seed in self._seeds]

    @cached_property
    def n_stations(self) -> int:
        """Picking stations that the scenario itself has."""
        layout = make_layout(self.scenario)
        return len(layout.stations) - layout.replenishing

    @property
    def places(self) -> int:
        """Storage locations: there can be no more robots."""
        return len(make_layout(self.scenario).storage_locations)

    @property
    def on_a_map(self) -> bool:
        """Whether a map, or another generator than that of blocks, says how many stations there are."""
        layout = self.scenario.layout
        return layout.map_file is not None or layout.generator not in (None, "blocks")

    @property
    def at_once(self) -> bool:
        """Whether all orders arrive at the same time."""
        return all(len({order.arrival_tick for order in instance.orders}) <= 1 for instance in self.instances)

    def changes(self, stations: int, robots: int) -> Changes:
        """Return the scenario keys that make it this size."""
        if self.on_a_map:
            return {"robots.count": robots}
        east, west = self._sides(stations)
        return {"layout.stations_east": east, "layout.stations_west": west, "robots.count": robots}

    def of_size(self, stations: int, robots: int) -> Scenario:
        """Return the scenario of a size."""
        sized = evolve(self.scenario, robots=evolve(self.scenario.robots, count=robots))
        if self.on_a_map:
            return sized
        east, west = self._sides(stations)
        return evolve(sized, layout=evolve(sized.layout, stations_east=east, stations_west=west))

    def _sides(self, stations: int) -> tuple[int, int]:
        """Return the stations on the east and on the west side, each its part as in the scenario, if there is room."""
        if stations not in self._east:
            layout = self.scenario.layout
            wanted = round(stations * layout.stations_east / (layout.stations_east + layout.stations_west))
            self._east[stations] = wanted  # whatever is wrong with it is said when it is tried
            sides = sorted(range(stations + 1), key=lambda east: (abs(east - wanted), east))
            for east in sides if stations < self._no_room_for else ():
                with suppress(InputError):
                    shared = evolve(layout, stations_east=east, stations_west=stations - east)
                    make_layout(evolve(self.scenario, layout=shared))
                    self._east[stations] = east
                    break
            else:
                self._no_room_for = min(self._no_room_for, stations)
        return self._east[stations], stations - self._east[stations]

    def overload(self, stations: int) -> str | None:
        """Say so when orders arrive faster, in the long run, than pickers can handle: no run is long enough to tell.

        That can be said of arrivals at one rate for ever, which is what `poisson` without a profile is.
        """
        arrivals, handle_s = self.scenario.instance.arrivals, self.scenario.stations.handle_s
        files = self.scenario.instance.orders_file is not None
        if files or arrivals.orders_per_hour is None or arrivals.profile is not None:
            return None
        orders = [order for instance in self.instances for order in instance.orders]
        if not orders:
            return None
        items_per_hour = arrivals.orders_per_hour * fmean(order.items for order in orders)
        busy = items_per_hour * handle_s / (3600 * stations)
        if busy < 1:
            return None
        percent = f"{100 * busy:.0f} %"
        return f"{items_per_hour:.0f} items an hour of {handle_s:g} s keep each picker busy for {percent} of the time"

    def obstacle(self, stations: int, robots: int, target: Target) -> str | None:
        """Say why a size needs no run: it is refused, or no rules can keep the target with any of the seeds."""
        scenario = self.of_size(stations, robots)
        least: list[float] = []
        try:
            layout = make_layout(scenario)
            for seed, instance in zip(self._seeds, self.instances, strict=True):
                of_seed = scenario.with_seed(seed)
                if target.metric not in BOUNDED:
                    open_warehouse(of_seed, instance, layout)
                    return None
                bound = next(iter(find_bounds(of_seed, instance, layout, (target.metric,))), None)
                if bound is None or bound.value is None or bound.value <= target.most:
                    return None
                least.append(bound.value)
        except InputError as error:
            return str(error)
        return f"whatever the rules, it is {target.with_unit(min(least))} or more" if least else None
