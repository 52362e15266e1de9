"""A scenario for orders and pods that were made of tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from math import ceil, isfinite, sqrt
from textwrap import fill

from attrs import evolve, field, frozen

from rmfs_commands.cli.loads import MINUTE, Demand, Load, loads_of
from rmfs_commands.cli.serving import serving_lines
from rmfs_commands.instances.calendar import Calendar
from rmfs_core.scenario.model import (
    InstanceSection,
    LayoutSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    Scenario,
    StationsSection,
)
from rmfs_core.scenario.tomltext import toml_text, toml_value
from rmfs_core.timetable import DAY
from rmfs_core.world import make_layout

Opens = tuple[str, str]
"""From when until when stations are open: ``"HH:MM"``."""

MOST_PERCENT, MOST_PEAK_PERCENT = 80, 100
"""Load that stations and robots are to have, at most, over all the time and in the peak hour."""
SHIFT_H = 8
"""Hours in which orders are to be picked that are all there at once."""
MOST_STATIONS = 60
QUIET_H, QUIET_SHARE = 5, 0.01
"""Hours of the day on end, with so small a share of the items, that make nights in which stations may be closed."""
ROBOTS_PER_STATION = 4
"""Robots that bring pods to a station without a break, at least, where their load asks for fewer."""


@frozen
class Size:
    """How large a warehouse is.

    Parameters
    ----------
    rows, columns
        Rows and columns of blocks.
    stations, robots
        How many.
    capped
        How many stations or robots the load asks for, where that is more than are guessed.
    """

    rows: int
    columns: int
    stations: int
    robots: int
    capped: Mapping[str, int] = field(factory=dict)

    @property
    def sides(self) -> tuple[int, int]:
        """Stations on the east and on the west side."""
        fitting = (self.rows - 1) // 2
        east = min(self.stations, fitting)
        return east, self.stations - east

    @property
    def locations(self) -> int:
        """Storage locations."""
        return 8 * self.rows * self.columns


def size_without_orders(pods: int, least_rows: int = 3) -> Size:
    """Return a size for so many pods, with a station and eight robots for each 100 of them."""
    blocks = ceil(pods / 0.85 / 8)
    rows = max(2 * ceil(sqrt(blocks / 2.5) / 2) + 1, least_rows)
    stations = max(1, min(ceil(pods / 100), (rows - 1) // 2))
    return Size(rows, max(ceil(blocks / rows), 2), stations, 8 * stations)


def size_for(
    pods: int, demand: Demand, start: str | None = None, opens: Sequence[Opens] = ()
) -> tuple[Size, list[Load]]:
    """Return a size for so many pods, whose stations and robots can do what orders want, and its loads."""
    size = evolve(size_without_orders(pods), stations=1, robots=1)
    pickers, _ = _loads(size, demand, start, opens)
    stations = min(needed := _needed(pickers), MOST_STATIONS)
    size = evolve(size_without_orders(pods, 2 * ceil(stations / 2) + 1), stations=stations, robots=1)
    pickers, robots = _loads(size, demand, start, opens)
    of_load = ceil(stations * robots.wanted_h / pickers.wanted_h) if robots.percent is None else _needed(robots)
    number = min(max(of_load, ROBOTS_PER_STATION * stations), max(size.locations // 2, 1))
    wanted = {"stations": (needed, stations), "robots": (of_load, number)}
    size = evolve(size, robots=number, capped={what: n for what, (n, most) in wanted.items() if n > most})
    return size, _loads(size, demand, start, opens)


def quiet_hours(demand: Demand, start: str | None) -> tuple[int, int] | None:
    """Return begin and end, in hours of the day, of nights in which hardly anything is ordered; None: there are none.

    Orders that all come within a day have no night between them.
    """
    if demand.last - demand.first <= DAY:
        return None
    zero, of_hour = Calendar(start).time_of_day(), Counter[int]()
    for minute, items in demand.items.items():
        of_hour[(minute * MINUTE + zero) % DAY // (60 * MINUTE)] += items
    most, found = QUIET_SHARE * of_hour.total(), None
    for begin in range(24):
        hours = next((h for h in range(24) if sum(of_hour[(begin + i) % 24] for i in range(h + 1)) > most), 24)
        if hours >= QUIET_H and (found is None or hours > found[1]):
            found = begin, hours
    return None if found is None else (found[0], sum(found) % 24)


def _needed(load: Load) -> int:
    """Return how many are needed, by the load of one."""
    if load.percent is None:
        return ceil(load.wanted_h / SHIFT_H)
    shares = [(load.percent, MOST_PERCENT), (load.peak_percent or 0.0, MOST_PEAK_PERCENT)]
    return max(1, *(ceil(percent / most) for percent, most in shares if isfinite(percent)))


def _loads(size: Size, demand: Demand, start: str | None, opens: Sequence[Opens]) -> list[Load]:
    east, west = size.sides
    scenario = Scenario(
        rules=RulesSection(poa=RuleChoice("pod-match"), pps=RuleChoice("demand")),
        instance=InstanceSection(start=start),
        layout=LayoutSection(block_rows=size.rows, block_columns=size.columns, stations_east=east, stations_west=west),
        robots=RobotsSection(count=size.robots),
        stations=StationsSection(open=tuple(opens) or None),
    )
    return loads_of(scenario, make_layout(scenario), demand)


def scenario_of(
    pods: int,
    start: str | None = None,
    learned: str | None = None,
    size: Size | None = None,
    opens: Sequence[Opens] = (),
) -> str:
    """Return a scenario with a block layout that holds the pods.

    Parameters
    ----------
    pods
        How many.
    start
        Time 0 in ISO 8601; None: a midnight.
    learned
        Origin of the placement, for the comment.
    size
        How large it is; None: as large as for pods whose orders nobody knows.
    opens
        When stations are open; all day, where that is empty.
    """
    size = size or size_without_orders(pods)
    east, west = size.sides
    begins = "" if start is None else f'start = "{start}"\n'
    told = "Orders and pods made by `rmfs convert`. The layout, its stations and robots are a guess."
    told += (
        f" {toml_text(learned)[1:-1]}" if learned else ""
    )  # a name of a file may have signs that no comment can have
    comment = fill(
        told, 80, initial_indent="# ", subsequent_indent="# ", break_on_hyphens=False, break_long_words=False
    )
    open_ = f"open = {toml_value([list(span) for span in opens])}\n" if opens else ""
    stations_west = f"stations_west = {west}\n" if west else ""
    return f"""{comment}

seed = 1

[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"
{begins}
[layout]
block_rows = {size.rows}
block_columns = {size.columns}
stations_east = {east}
{stations_west}
[robots]
count = {size.robots}

[stations]
item_capacity = 100
{open_}
[rules]
{serving_lines()}
"""
