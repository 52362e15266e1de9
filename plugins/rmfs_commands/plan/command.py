"""``rmfs plan``: path planning by itself, on a map with robots and nothing else."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rmfs_commands.cli import completion
from rmfs_commands.cli.notes import notes_console
from rmfs_commands.cli.options import OutPath, WholeNumberRange, json_option, no_inline_option
from rmfs_commands.cli.screen import new_table, output_console, print_json
from rmfs_core.wording import counted

if TYPE_CHECKING:
    import numpy as np
    from rich.console import Console

    from rmfs_commands.plan import Collision, Plan, Trip
    from rmfs_commands.plan.planners import HookPlanner
    from rmfs_traffic import Roads

SHOWN = 12
"""Robots that the table lists, those with the longest delay first."""
PLAN_FILE, PATHS_FILE = "plan.json", "paths.csv"


@click.command(short_help="Plan the paths of robots on a map, without orders.")
@click.argument("map_file", metavar="MAP")
@click.option("--agents", type=WholeNumberRange(min=1), default=10, show_default=True, help="Number of robots.")
@click.option("--seed", type=WholeNumberRange(min=0), default=1, show_default=True, help="Seed of the random trips.")
@click.option(
    "--pp",
    default="sipp",
    show_default=True,
    metavar="RULE",
    shell_complete=completion.rules,
    help="Planner: sipp, whca-n, free-flow, ...",
)
@click.option("--set", "values", multiple=True, metavar="KEY=VALUE", help="Set a parameter of the planner. Repeatable.")
@click.option("--scen", metavar="FILE", help="Take the trips from a MovingAI scenario, the first ones in it.")
@click.option(
    "--effort",
    type=WholeNumberRange(min=0),
    default=10,
    show_default=True,
    help="Queries for each robot, on average, to shorten paths of groups; 0: one order of robots.",
)
@click.option("--out", type=OutPath(), metavar="DIR", help=f"Folder to write {PLAN_FILE} and {PATHS_FILE} to.")
@click.option(
    "--html", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE", help="Write a page that shows the plan."
)
@no_inline_option
@json_option
def plan(
    map_file: str,
    agents: int,
    seed: int,
    pp: str,
    values: tuple[str, ...],
    scen: str | None,
    effort: int,
    out: Path | None,
    html: Path | None,
    no_inline_rules: bool,
    as_json: bool,
) -> None:
    """Plan the paths of robots on MAP, a MovingAI map or a text map.

    Each robot has one trip: random ones, or those of a scenario. First paths are searched for all robots together, then
    made shorter: for each robot alone, for groups of robots (--effort), and for each alone again. Where no first paths
    are found, paths are planned one robot after another. The paths are checked for collisions. Exit code 1 when a robot
    finds no path, or when robots collide under a rule that keeps them apart; under free-flow, which keeps none apart,
    collisions are counted only.
    """

    from rmfs_commands.cli.choices import option_named, with_parameters
    from rmfs_commands.cli.compiling import compiling_announced
    from rmfs_commands.cli.file_writing import writable_folder
    from rmfs_commands.cli.pages import check_target
    from rmfs_commands.instances.overrides import rule_name_from
    from rmfs_commands.plan import collisions, find_planner, random_trips, read_map, read_trips, roads_of_map
    from rmfs_commands.results.files import removed_if_empty
    from rmfs_core.errors import RunError
    from rmfs_core.randomness import rule_stream, stream
    from rmfs_core.roles import Role
    from rmfs_core.scenario import RuleChoice

    check_target(html)
    roads = roads_of_map(read_map(map_file))
    with option_named("--pp", f"--pp {pp}", values):
        choice = with_parameters(RuleChoice(rule_name_from(pp, ".", ".")), values)
        draws, allowed = rule_stream(seed, Role.PP, pp), not no_inline_rules
        planner = find_planner(choice.rule, choice.parameters, draws, allow_inline=allowed)
    with compiling_announced(notes_console()):
        trips = random_trips(roads, agents, seed, map_file) if scen is None else read_trips(scen, roads.layout, agents)
        _check_reach(roads, trips, scen or map_file)
        if out is not None:
            click.get_current_context().with_resource(removed_if_empty(out))
        folder = None if out is None else writable_folder(out, (PLAN_FILE, PATHS_FILE), force=True)
        started = time.perf_counter()
        plans = _plan(roads, planner, trips, effort, stream(seed, "joint"))
        wall_s = time.perf_counter() - started
    hits = collisions(roads, [one.path for one in plans])
    title = f"{Path(map_file).name}, {counted(len(plans), 'robot')}, {pp}"
    about = {"map": map_file, "scen": scen, "seed": seed, "pp": pp, "parameters": dict(choice.parameters)}
    about["effort"] = effort
    if as_json:
        rows = [_row(roads, robot, one) for robot, one in enumerate(plans, 1)]
        print_json({**_document(roads, plans, hits, about), "trips": rows})
    else:
        _print(output_console(), title, roads, plans, hits, wall_s)
    if folder is not None:
        _write(folder, roads, plans, hits, about)
    if html is not None:
        from rmfs_commands.plan.page import plan_page
        from rmfs_commands.results.files import write_text

        rows = [row for robot, one in enumerate(plans, 1) for row in _legs(roads, robot, one)]
        ends = [(one.trip.start, one.trip.goal) for one in plans]
        write_text(html, plan_page(title, _said(plans, hits), roads.layout, ends, rows))
    stuck = [str(number) for number, one in enumerate(plans, 1) if not one.arrived]
    if stuck:
        more = f" and {len(stuck) - SHOWN} more" if len(stuck) > SHOWN else ""
        raise RunError(
            f"{pp} found no path to the goal for {len(stuck)} of {len(plans)} robots: {', '.join(stuck[:SHOWN])}{more}."
        )
    if hits and planner.exclusive:
        raise RunError(f"{pp} let robots collide, first {_describe(roads, hits[0])}.")


def _plan(
    roads: Roads, planner: HookPlanner, trips: Sequence[Trip], effort: int, rng: np.random.Generator
) -> tuple[Plan, ...]:
    from rmfs_commands.plan import plan_in_orders, plan_jointly, plan_trips

    if not planner.exclusive or effort == 0:
        return plan_trips(roads, planner, trips, planner.exclusive)
    plan = plan_jointly if planner.complete else plan_in_orders
    return plan(roads, planner, trips, effort, rng)


def _check_reach(roads: Roads, trips: Sequence[Any], place: str) -> None:
    """Refuse trips that no robot could make even if it were alone, and such that share a start or a goal."""
    from rmfs_core.clock import UNREACHABLE
    from rmfs_core.errors import InputError
    from rmfs_core.world import NORTH

    seen: dict[tuple[str, int], int] = {}
    for number, trip in enumerate(trips, 1):
        start, goal = roads.layout.where(trip.start), roads.layout.where(trip.goal)
        if roads.travel.ticks(trip.start, NORTH, trip.goal, False) >= UNREACHABLE:
            raise InputError(place, f"robot {number} has no path from {start} to {goal}")
        for end, cell, where in (("start", trip.start, start), ("goal", trip.goal, goal)):
            if (end, cell) in seen:
                raise InputError(place, f"robots {seen[end, cell]} and {number} have the same {end}, {where}")
            seen[end, cell] = number


def _said(plans: Sequence[Plan], hits: Sequence[Collision]) -> str:
    costs = _costs(plans, hits)
    return f"{costs['arrived']} of {costs['robots']} robots arrive; collisions: {len(hits)}."


def _describe(roads: Roads, hit: Collision) -> str:
    return f"robots {hit.first + 1} and {hit.second + 1} at {_short(roads, hit.cell)} after {hit.since_s:.3f} s"


def _costs(plans: Sequence[Plan], hits: Sequence[Collision]) -> dict[str, Any]:
    """Sums over the robots that arrive, in seconds; a robot's cost is the time at which it is at its goal for good."""
    arrived = [one for one in plans if one.arrived]
    makespan_s = max(one.path.end_tick for one in plans) / 1000
    return {
        "robots": len(plans),
        "arrived": len(arrived),
        "makespan_s": makespan_s if len(arrived) == len(plans) else None,  # a plan with robots left has none
        "sum_of_costs_s": sum(one.path.end_tick for one in arrived) / 1000,
        "sum_without_traffic_s": sum(one.fastest_ticks for one in arrived) / 1000,
        "longest_delay_s": max((one.delay_ticks for one in arrived), default=0) / 1000,
        "queries": sum(one.queries for one in plans),
        "collisions": len(hits),
    }


def _print(
    console: Console, title: str, roads: Roads, plans: Sequence[Plan], hits: Sequence[Collision], wall_s: float
) -> None:
    table = new_table(title)
    for column in ("Robot", "From", "To"):
        table.add_column(column)
    for column in ("Arrives s", "Delay s", "Stops", "Queries"):
        table.add_column(column, justify="right")
    order = sorted(range(len(plans)), key=lambda i: (plans[i].arrived, -plans[i].delay_ticks, i))
    for i in order[:SHOWN]:
        one = plans[i]
        arrives = f"{one.path.end_tick / 1000:.3f}" if one.arrived else "never"
        delay = f"{one.delay_ticks / 1000:.3f}" if one.arrived else ""
        cells = (_short(roads, one.trip.start), _short(roads, one.trip.goal))
        table.add_row(str(i + 1), *cells, arrives, delay, str(len(one.path.legs)), str(one.queries))
    console.print(table)
    if len(plans) > SHOWN:
        console.print(f"The {SHOWN} robots with the longest delay of {len(plans)}.", highlight=False)
    costs = _costs(plans, hits)
    asked = "query" if costs["queries"] == 1 else "queries"
    makespan = "-" if costs["makespan_s"] is None else f"{costs['makespan_s']:.3f} s"
    console.print(
        f"Arrived {costs['arrived']} of {costs['robots']}; makespan {makespan}; sum of costs "
        f"{costs['sum_of_costs_s']:.3f} s, {costs['sum_without_traffic_s']:.3f} s without traffic; "
        f"{costs['queries']} {asked} in {wall_s:.3f} s; collisions: {len(hits)}",
        highlight=False,
        soft_wrap=True,
    )
    if hits:
        console.print(f"First collision: {_describe(roads, hits[0])}", highlight=False, soft_wrap=True)


def _short(roads: Roads, cell: int) -> str:
    return f"{cell % roads.layout.width},{cell // roads.layout.width}"


def _document(
    roads: Roads, plans: Sequence[Plan], hits: Sequence[Collision], about: Mapping[str, Any]
) -> dict[str, Any]:
    """Return all but the trips, as plain values; cells and robots have the names that the table has."""
    found = [
        {"cell": _short(roads, hit.cell), "first": hit.first + 1, "second": hit.second + 1}
        | {"since_s": hit.since_s, "until_s": hit.until_s}
        for hit in hits
    ]
    return {**about, "costs": _costs(plans, hits), "collisions": found}


def _row(roads: Roads, robot: int, one: Plan) -> dict[str, Any]:
    """Return one robot of the table, as plain values."""
    return {
        "robot": robot,
        "from": _short(roads, one.trip.start),
        "to": _short(roads, one.trip.goal),
        "arrives_s": one.path.end_tick / 1000 if one.arrived else None,
        "delay_s": one.delay_ticks / 1000 if one.arrived else None,
        "stops": len(one.path.legs),
        "queries": one.queries,
    }


def _write(
    folder: Path, roads: Roads, plans: Sequence[Plan], hits: Sequence[Collision], about: Mapping[str, Any]
) -> None:
    """Write both files, or none."""
    from rmfs_commands.results.files import json_ready, staged, to_csv, to_json, write_text

    rows = [row for robot, one in enumerate(plans, 1) for row in _legs(roads, robot, one)]
    columns = ("robot", "leg", "start_s", "wait_s", "turn_s", "run_s", "from_x", "from_y", "to_x", "to_y", "end_s")
    with staged(folder) as path:
        write_text(path / PLAN_FILE, to_json(json_ready(_document(roads, plans, hits, about)), indent=2) + "\n")
        write_text(path / PATHS_FILE, to_csv(columns, rows))


def _legs(roads: Roads, robot: int, one: Plan) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    width = roads.layout.width
    cell, heading, tick = one.path.cell, one.path.heading, one.path.start_tick
    for number, leg in enumerate(one.path.legs, 1):
        towards = roads.travel.heading(cell, leg.to)
        turn = 0 if towards is None else int(roads.travel.turns[(towards - heading) % 4])
        run = int(roads.travel.runs[roads.layout.distance(cell, leg.to)])
        end = tick + leg.wait_ticks + turn + run
        places = {"from_x": cell % width, "from_y": cell // width, "to_x": leg.to % width, "to_y": leg.to // width}
        times = {"start_s": tick, "wait_s": leg.wait_ticks, "turn_s": turn, "run_s": run, "end_s": end}
        rows.append({"robot": robot, "leg": number, **places, **{key: t / 1000 for key, t in times.items()}})
        cell, heading, tick = leg.to, heading if towards is None else towards, end
    return rows
