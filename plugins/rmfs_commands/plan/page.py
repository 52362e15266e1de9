"""A plan as a page: the map, the paths, and the robots that move along them, ten times as fast as they would."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rmfs_commands.cli.hall import hall_page
from rmfs_commands.layouts.hall import hall_legend, hall_svg
from rmfs_core.world import Layout

FASTER = 10
GOLDEN_ANGLE = 137.508
"""Degrees between the hues of two robots: neighbours in the table are far apart in colour."""

Row = Mapping[str, object]


def plan_page(title: str, told: str, layout: Layout, ends: Sequence[tuple[int, int]], legs: Sequence[Row]) -> str:
    """Return the page, which needs no network.

    Parameters
    ----------
    title
        Of the plan.
    told
        Its outcome, in a sentence.
    layout
        The map.
    ends
        Start and goal of each robot, as cells.
    legs
        Rows of paths.csv.
    """
    own: list[list[dict[str, float]]] = [[] for _ in ends]
    for row in legs:
        own[int(str(row["robot"])) - 1].append({name: float(str(value)) for name, value in row.items()})
    last_s = max([leg["end_s"] for path in own for leg in path], default=0.0) or 1.0
    drawn = "".join(_robot(layout, i, *ends[i], path, last_s) for i, path in enumerate(own))
    figure = f'<div class="scroll">{hall_svg(layout, over=drawn)}</div>{hall_legend(layout)}'
    shown = f"Circles are robots, {FASTER} times as fast as they drive; squares are their goals."
    return hall_page(title, [told, shown], figure, [])


def _robot(
    layout: Layout, number: int, start: int, goal: int, path: Sequence[Mapping[str, float]], last_s: float
) -> str:
    """Return a robot's path, its goal, and the robot, which begins anew when the last robot is where it goes."""
    colour = f"hsl({number * GOLDEN_ANGLE % 360:.0f} 70% 48%)"
    x, y = start % layout.width + 0.5, start // layout.width + 0.5
    points, stops = [(x, y)], [(0.0, x, y)]
    for leg in path:
        begin = leg["start_s"] + leg["wait_s"] + leg["turn_s"]
        stops.append((begin, leg["from_x"] + 0.5, leg["from_y"] + 0.5))
        stops.append((leg["end_s"], leg["to_x"] + 0.5, leg["to_y"] + 0.5))
        points.append((leg["to_x"] + 0.5, leg["to_y"] + 0.5))
    stops.append((last_s, *stops[-1][1:]))
    line = " ".join(f"{px:g},{py:g}" for px, py in points)
    times = ";".join(f"{min(second / last_s, 1):.5f}" for second, _, _ in stops)
    moves = "".join(
        f'<animate attributeName="{name}" dur="{last_s / FASTER:.3f}s" repeatCount="indefinite" keyTimes="{times}" '
        f'values="{";".join(f"{stop[axis]:g}" for stop in stops)}"/>'
        for axis, name in ((1, "cx"), (2, "cy"))
    )
    gx, gy = goal % layout.width + 0.15, goal // layout.width + 0.15
    return (
        f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width=".14" opacity=".55"/>'
        f'<rect x="{gx:g}" y="{gy:g}" width=".7" height=".7" fill="none" stroke="{colour}" stroke-width=".14"/>'
        f'<circle cx="{x:g}" cy="{y:g}" r=".36" fill="{colour}"><title>robot {number + 1}</title>{moves}</circle>'
    )
