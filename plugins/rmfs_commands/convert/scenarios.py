"""A scenario for orders and pods that were made of tables."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil, isfinite, sqrt
from textwrap import fill

from attrs import evolve, field, frozen

from rmfs_commands.cli.loads import Demand, Load, loads_of
from rmfs_commands.cli.serving import serving_lines
from rmfs_core.scenario.model import (
    InstanceSection,
    LayoutSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    Scenario,
    StationsSection,
)
from rmfs_core.scenario.tomltext import toml_text
from rmfs_core.world import make_layout

MOST_PERCENT, MOST_PEAK_PERCENT = 80, 100
"""Load that stations and robots are to have, at most, over all the time and in the peak hour."""
SHIFT_H = 8
"""Hours in which orders are to be picked that are all there at once."""
MOST_STATIONS = 60
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
    """Return a size with room for so many pods, with a station and eight robots for each 100 of them."""
    blocks = ceil(pods / 0.85 / 8)
    rows = max(2 * ceil(sqrt(blocks / 2.5) / 2) + 1, least_rows)
    stations = max(1, min(ceil(pods / 100), (rows - 1) // 2))
    return Size(rows, max(ceil(blocks / rows), 2), stations, 8 * stations)


def size_for(pods: int, demand: Demand, start: str | None = None) -> tuple[Size, list[Load]]:
    """Return a size with room for so many pods, whose stations and robots can do what orders want, and its loads."""
    size = evolve(size_without_orders(pods), stations=1, robots=1)
    pickers, _ = _loads(size, demand, start)
    stations = min(needed := _needed(pickers), MOST_STATIONS)
    size = evolve(size_without_orders(pods, 2 * ceil(stations / 2) + 1), stations=stations, robots=1)
    pickers, robots = _loads(size, demand, start)
    of_load = ceil(stations * robots.wanted_h / pickers.wanted_h) if robots.percent is None else _needed(robots)
    number = min(max(of_load, ROBOTS_PER_STATION * stations), max(size.locations // 2, 1))
    wanted = {"stations": (needed, stations), "robots": (of_load, number)}
    size = evolve(size, robots=number, capped={what: n for what, (n, most) in wanted.items() if n > most})
    return size, _loads(size, demand, start)


def _needed(load: Load) -> int:
    """Return how many are needed, by the load of one."""
    if load.percent is None:
        return ceil(load.wanted_h / SHIFT_H)
    shares = [(load.percent, MOST_PERCENT), (load.peak_percent or 0.0, MOST_PEAK_PERCENT)]
    return max(1, *(ceil(percent / most) for percent, most in shares if isfinite(percent)))


def _loads(size: Size, demand: Demand, start: str | None) -> list[Load]:
    east, west = size.sides
    scenario = Scenario(
        rules=RulesSection(poa=RuleChoice("pod-match"), pps=RuleChoice("demand")),
        instance=InstanceSection(start=start),
        layout=LayoutSection(block_rows=size.rows, block_columns=size.columns, stations_east=east, stations_west=west),
        robots=RobotsSection(count=size.robots),
        stations=StationsSection(),
    )
    return loads_of(scenario, make_layout(scenario), demand)


def scenario_of(pods: int, start: str | None = None, learned: str | None = None, size: Size | None = None) -> str:
    """Return a scenario with a block layout that has room for the pods.

    Parameters
    ----------
    pods
        How many.
    start
        Time 0 in ISO 8601; None: a midnight.
    learned
        What SKUs stand on pods by, for the comment.
    size
        How large it is; None: as large as for pods whose orders nobody knows.
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

[rules]
{serving_lines()}
"""
