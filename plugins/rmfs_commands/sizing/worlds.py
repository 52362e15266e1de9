"""The scenario with other numbers of stations and robots, or packers and boxes, and what needs no run."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from functools import cached_property
from statistics import fmean

from attrs import evolve

from rmfs_commands.bounds import BOUNDED, find_bounds
from rmfs_commands.sizing.searching import BOXES, ROBOTS, Things
from rmfs_commands.sizing.target import Target
from rmfs_commands.states.beginning import read
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario
from rmfs_core.scenario.model import PackingSection
from rmfs_core.scenario.service import speeds_of
from rmfs_core.simulation.setup import open_warehouse
from rmfs_core.wording import listed
from rmfs_core.world import Instance, make_instance, make_layout

Changes = dict[str, int]
Range = tuple[int, int]

TIMES = 2, 4
"""The most stations and robots that are tried, as multiples of the scenario's, where nothing else is asked for."""
MOST_STATIONS = 200
"""Each has a row of its own."""
MOST_BOXES = 100_000


class Worlds:
    """A scenario's warehouse in other sizes, with the same orders.

    Parameters
    ----------
    scenario
        The scenario that varies in size.
    seeds
        Whose orders are looked at.
    """

    things: Things = ROBOTS

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
    def start(self) -> tuple[int, int]:
        """The scenario's own size, with which the search begins."""
        return self.n_stations, self.scenario.robots.count

    def ranges(self, stations: Range | None, robots: Range | None) -> tuple[range, Range]:
        """Return the numbers of stations to try, and the fewest and most robots; InputError where they do not fit."""
        fixed = self.n_stations
        if self.on_a_map and stations not in (None, (fixed, fixed)):
            what = "map" if self.scenario.instance.state_file is None else "state"
            raise InputError(
                "--stations", f"the {what} of the scenario has {fixed}; expected a scenario without a {what}"
            )
        if self.scenario.instance.state_file is not None and (told := read(self.scenario)[0].robots) is not None:
            problem = f"the state tells of {len(told)} robots, all that there can be; expected one without `robots`"
            raise InputError("instance.state_file", problem)
        least, most = (fixed, fixed) if self.on_a_map else stations or (1, TIMES[0] * fixed)
        few, many = robots or (1, min(TIMES[1] * self.scenario.robots.count, self.places))
        if many > self.places:
            raise InputError("--robots", f"found {many:,}; the layout has {self.places:,} storage locations")
        return _numbers("--stations", least, most), (few, many)

    @property
    def places(self) -> int:
        """Storage locations: there can be no more robots."""
        return len(make_layout(self.scenario).storage_locations)

    @property
    def on_a_map(self) -> bool:
        """Whether a map, another generator than that of blocks, or a state says how many stations there are."""
        layout, drawn = self.scenario.layout, self.scenario.instance.state_file is not None
        return drawn or layout.map_file is not None or layout.generator not in (None, "blocks")

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
        """Return the stations on the east and on the west side, each its part as in the scenario, if they fit."""
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

        That can be said of arrivals at one rate forever, which is what `poisson` without a profile is.
        """
        section, orders = self.scenario.stations, self.orders_per_hour
        fastest = max([1.0, *(one for speed in section.speed.values() for one in speeds_of(speed)[1])])
        work = (
            (orders * self.items_per_order, "items", section.handle_s),
            (orders * self.lines_per_order, "lines", section.line_s or 0.0),  # more where a line takes several visits
            (orders, "orders", section.order_s or 0.0),  # more where an order is split
        )
        if (busy := sum(number * each_s for number, _, each_s in work) / fastest / (3600 * stations)) < 1:
            return None
        shown = [
            f"{number:,.0f} {what} per hour at {each_s / fastest:.3g} s each" for number, what, each_s in work if each_s
        ]
        return f"{listed(shown)} keep each picker busy for {100 * busy:,.0f} % of the time"

    @property
    def orders_per_hour(self) -> float:
        """The rate at which orders arrive forever; 0 where they do not."""
        arrivals = self.scenario.instance.arrivals
        if self.scenario.instance.orders_file is not None or arrivals.profile is not None:
            return 0.0
        return arrivals.orders_per_hour or 0.0

    @property
    def items_per_order(self) -> float:
        """Items of an order, a mean; 0 without orders."""
        return fmean([order.items for instance in self.instances for order in instance.orders] or [0])

    @property
    def lines_per_order(self) -> float:
        """Lines of an order, a mean; 0 without orders."""
        return fmean([len(order.lines) for instance in self.instances for order in instance.orders] or [0])

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

    def least(self, first: int, second: int, target: Target) -> float | None:
        """Return what no rules can beat in a size, mean over the seeds; None where no bound is known."""
        scenario, found = self.of_size(first, second), list[float]()
        for seed, instance in zip(self._seeds, self.instances, strict=True):
            metrics = (target.metric,) if target.metric in BOUNDED else ()
            bounds = find_bounds(scenario.with_seed(seed), instance, make_layout(scenario), metrics) if metrics else ()
            found += [bound.value for bound in bounds if bound.value is not None]
        return fmean(found) if found else None


class PackingWorlds(Worlds):
    """A scenario's warehouse with other numbers of packers and boxes at each of its packing stations."""

    things = BOXES

    @cached_property
    def section(self) -> PackingSection:
        """The scenario's packing stations; InputError where there are none."""
        if self.scenario.packing is None:
            place = "--packers, --boxes"
            raise InputError(place, "the scenario has no packing stations; expected one with a section `packing`")
        return self.scenario.packing

    @property
    def start(self) -> tuple[int, int]:
        """The scenario's own size, with which the search begins."""
        return self.section.packers, self.section.boxes

    def ranges(self, packers: Range | None, boxes: Range | None) -> tuple[range, Range]:
        """Return the numbers of packers to try, and the fewest and most boxes."""
        (of_packers, of_boxes), here = TIMES, self.start
        few, many = boxes or (1, of_boxes * here[1])
        if many > MOST_BOXES:
            raise InputError("--boxes", f"found {many:,}; expected {MOST_BOXES:,} at most")
        return _numbers("--packers", *(packers or (1, of_packers * here[0]))), (few, many)

    def changes(self, packers: int, boxes: int) -> Changes:
        """Return the scenario keys that make it this size."""
        return {"packing.packers": packers, "packing.boxes": boxes}

    def of_size(self, packers: int, boxes: int) -> Scenario:
        """Return the scenario of a size."""
        return evolve(self.scenario, packing=evolve(self.section, packers=packers, boxes=boxes))

    def overload(self, packers: int) -> str | None:
        """Say so when orders arrive faster, in the long run, than packers can pack."""
        number = self.section.stations or len(make_layout(self.scenario).packing) or 1
        each_s = self.section.pack_s + self.section.pack_item_s * self.items_per_order
        if (busy := self.orders_per_hour * each_s / (3600 * number * packers)) < 1:
            return None
        each = f"{self.orders_per_hour:,.10g} orders per hour at {each_s:.0f} s each"
        return f"{each} keep each packer busy for {100 * busy:,.0f} % of the time"


def _numbers(option: str, least: int, most: int) -> range:
    """Return numbers that each have a row of their own; InputError where they are too many."""
    if most > MOST_STATIONS:
        raise InputError(option, f"found {most:,}; expected {MOST_STATIONS} at most")
    return range(least, most + 1)
