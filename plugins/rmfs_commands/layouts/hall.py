"""A picture of a hall from above, as SVG for pages and notebooks: cells, ways, stations, pods and robots."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from html import escape

from attrs import frozen

from rmfs_core.wording import counted
from rmfs_core.world import CellKind, Layout
from rmfs_core.world.grid import RESTING

LEVELS = 5
"""Shades of pods, from 0 for pods without wanted items."""

HALL_STYLE = """
.hall { --wall: #c9ced5; --way: #ffffff; --place: #e9ecf0; --lane: #d6e6f2; --arrow: #6b7684; --pick: #b3402f;
  --store: #7a5c00; --pack: #5b3fa0; --charge: #007a58;
  --repair: #a2611b; --robot: #111417; --empty: #b9c0c8; --text: #ffffff;
  --level-0: #d3d8de; --level-1: #a9cfe8; --level-2: #6aaedb; --level-3: #2a83bd; --level-4: #0b4f7d; }
@media screen and (prefers-color-scheme: dark) {
  .hall { --wall: #3a424b; --way: #1b2127; --place: #2a323a; --lane: #1f3546; --arrow: #8b97a4; --pick: #ff8a75;
    --store: #dcbf4a; --pack: #b9a2f5; --charge: #3ecf9f;
    --repair: #d99a4e; --robot: #f2f4f6; --empty: #5a646f; --text: #10151a;
    --level-0: #4a535d; --level-1: #2c5a7d; --level-2: #327fb3; --level-3: #58acdf; --level-4: #b4defa; }
}
.hall .wall { fill: var(--wall); } .hall .way { fill: var(--way); } .hall .place { fill: var(--place); }
.hall .lane { fill: var(--lane); } .hall .pick { fill: var(--pick); } .hall .store { fill: var(--store); }
.hall .pack { fill: var(--pack); } .hall .charge { fill: var(--charge); }
.hall .repair { fill: var(--repair); }
.hall .empty { fill: none; stroke: var(--empty); stroke-width: .1; }
.hall .arrow { fill: none; stroke: var(--arrow); stroke-width: .09; stroke-linecap: round; stroke-linejoin: round; }
.hall .robot { fill: none; stroke: var(--robot); stroke-width: .13; }
.hall .level-0 { fill: var(--level-0); } .hall .level-1 { fill: var(--level-1); }
.hall .level-2 { fill: var(--level-2); } .hall .level-3 { fill: var(--level-3); }
.hall .level-4 { fill: var(--level-4); }
.hall text { fill: var(--text); font: 600 .62px system-ui, sans-serif; text-anchor: middle; }
.hall .scroll { overflow-x: auto; }
.hall ul { list-style: none; margin: .6rem 0 0; padding: 0; display: flex; flex-wrap: wrap; gap: .25rem 1.1rem; }
.hall li { display: flex; align-items: center; gap: .4rem; } .hall li svg { width: 1.1em; height: 1.1em; flex: none; }
"""
"""Styles that a page needs once for all pictures; it follows the light or dark of the browser."""

_CHEVRONS = ("M.38 .3L.62 .5L.38 .7", "M.3 .62L.5 .38L.7 .62", "M.62 .3L.38 .5L.62 .7", "M.3 .38L.5 .62L.7 .38")
_SIDES = ("M.76 .4L.88 .5L.76 .6", "M.4 .24L.5 .12L.6 .24", "M.24 .4L.12 .5L.24 .6", "M.4 .76L.5 .88L.6 .76")
"""An arrow in the middle of a cell, and one at its side, for each heading: east, north, west, south."""


@frozen
class HallPod:
    """A pod in the picture.

    Parameters
    ----------
    cell
        Where it stands.
    level
        Its shade, from 0 up to, not including, `LEVELS`; None: an empty pod.
    title
        Text shown while the pointer is over it.
    """

    cell: int
    level: int | None = None
    title: str = ""


def hall_svg(
    layout: Layout,
    pods: Iterable[HallPod] = (),
    robots: Collection[int] = (),
    *,
    names: Mapping[int, str] | None = None,
    over: str = "",
) -> str:
    """Return a hall as an ``<svg>`` element of one unit a cell, north at the top; `HALL_STYLE` has its colours.

    It belongs in an element of the class ``hall``. Nothing in it has an id, so a page may have several.

    Parameters
    ----------
    layout
        The grid.
    pods
        Pods to be drawn.
    robots
        Cells in which robots stand.
    names
        Labels of stations, by their cells; None: their numbers.
    over
        SVG to be drawn over the floor and under pods, stations and robots: a heat map.
    """
    drawn = [f'<path class="{shape}" d="{d}"/>' for shape, d in _areas(layout).items() if d]
    drawn.append(over)
    drawn += [_pod(layout, pod) for pod in pods]
    if ways := "".join(_arrows(layout, cell) for cell in range(layout.width * layout.height)):
        drawn.append(f'<path class="arrow" d="{ways}"/>')
    drawn += [_station(layout, cell, shape, (names or {}).get(cell, name)) for cell, shape, name in _stations(layout)]
    drawn += [f'<circle class="robot" cx="{_x(layout, cell)}.5" cy="{_y(layout, cell)}.5" r=".42"/>' for cell in robots]
    named = f'role="img" aria-label="Hall of {layout.width} x {layout.height} cells, north at the top"'
    size = f'viewBox="0 0 {layout.width} {layout.height}"'
    style = f"width:100%;min-width:{7 * layout.width}px;max-width:{26 * layout.width}px;display:block"
    return f'<svg {size} style="{style}" {named}>{"".join(drawn)}</svg>'


def hall_legend(
    layout: Layout, levels: Mapping[int, str] | None = None, *, empty: bool = False, robots: int = 0
) -> str:
    """Return the legend as a ``<ul>`` element.

    Parameters
    ----------
    layout
        The grid.
    levels
        Meaning of each shade of pods, where there are any.
    empty
        Whether there are empty pods.
    robots
        How many robots are drawn.
    """
    square = '<rect class="{}" width="1" height="1"/>'
    pod = (
        '<rect class="place" width="1" height="1"/><rect class="{}" x=".12" y=".12" width=".76" height=".76" rx=".1"/>'
    )
    picking = len(layout.stations) - layout.replenishing
    waiting = sum(own.places for own in layout.stations)
    rows = [
        (counted(picking, "picking station"), picking, square.format("pick")),
        (counted(layout.replenishing, "replenishment station"), layout.replenishing, square.format("store")),
        (counted(len(layout.packing), "packing station"), len(layout.packing), square.format("pack")),
        (f"queues for {waiting:,} pods", waiting, square.format("lane") + _sign(0)),
        ("one-way aisles", _one_way(layout), square.format("way") + _sign(0)),
        ("walls", bool((layout.kind == CellKind.WALL).any()), square.format("wall")),
        (counted(len(layout.chargers), "charger"), len(layout.chargers), square.format("charge")),
        (counted(len(layout.maintenance), "maintenance cell"), len(layout.maintenance), square.format("repair")),
        (f"{len(layout.storage_locations):,} storage locations; robots may rest there", 1, square.format("place")),
        *((text, 1, pod.format(f"level-{level}")) for level, text in (levels or {}).items()),
        ("empty pods", empty, pod.format("empty")),
        (f"{counted(robots, 'robot')} at the start", robots, '<circle class="robot" cx=".5" cy=".5" r=".42"/>'),
    ]
    sign_of = '<svg viewBox="0 0 1 1" aria-hidden="true">{}</svg>'
    items = (f"<li>{sign_of.format(sign)}{escape(text)}</li>" for text, there, sign in rows if there)
    return f"<ul>{''.join(items)}</ul>"


def _sign(heading: int) -> str:
    return f'<path class="arrow" d="{_CHEVRONS[heading]}"/>'


def _x(layout: Layout, cell: int) -> int:
    return cell % layout.width


def _y(layout: Layout, cell: int) -> int:
    return cell // layout.width


def _areas(layout: Layout) -> dict[str, str]:
    """Return a path of all cells of each kind that covers the floor, each row's in as few pieces as there are."""
    shapes = {CellKind.WALL: "wall", CellKind.STORAGE: "place", CellKind.QUEUE: "lane", CellKind.CHARGER: "charge"}
    shapes[CellKind.MAINTENANCE] = "repair"
    areas = {"way": f"M0 0h{layout.width}v{layout.height}H0z"} | dict.fromkeys(shapes.values(), "")
    kinds = layout.kind.tolist()
    for row in range(layout.height):
        column = 0
        while column < layout.width:
            kind, begin = kinds[row * layout.width + column], column
            while column < layout.width and kinds[row * layout.width + column] == kind:
                column += 1
            if kind in shapes:
                areas[shapes[kind]] += f"M{begin} {row}h{column - begin}v1h-{column - begin}z"
    return areas


def _ways(layout: Layout, cell: int) -> list[int]:
    """Return the headings in which robots leave floor or a queue cell, apart from storage locations and chargers."""
    queue = layout.kind[cell] == CellKind.QUEUE
    if not queue and layout.kind[cell] != CellKind.FLOOR:
        return []
    beside = [(heading, other) for heading, other in layout.beside(cell) if layout.kind[other] not in RESTING]
    open_ = [heading for heading, _ in beside if layout.may_step(cell, heading)]
    if queue:
        return open_
    both = [heading for heading, other in beside if layout.kind[other] == CellKind.FLOOR]
    return open_ if any(not layout.may_step(cell, heading) for heading in both) else []


def _one_way(layout: Layout) -> bool:
    floor = [cell for cell, kind in enumerate(layout.kind.tolist()) if kind == CellKind.FLOOR]
    return any(_ways(layout, cell) for cell in floor)


def _arrows(layout: Layout, cell: int) -> str:
    """Return the arrows of a cell as part of a path; floor that may be left in every direction has none."""
    ways = _ways(layout, cell)
    signs = _CHEVRONS if len(ways) == 1 else _SIDES
    return "".join(_moved(signs[heading], layout, cell) for heading in ways)


def _moved(path: str, layout: Layout, cell: int) -> str:
    """Return a path of points, each a sign and two numbers, moved into a cell."""
    points = path.replace("M", "|M").replace("L", "|L").split("|")[1:]
    moved = ((point[0], [float(number) for number in point[1:].split()]) for point in points)
    return "".join(f"{sign}{_x(layout, cell) + x:g} {_y(layout, cell) + y:g}" for sign, (x, y) in moved)


def _stations(layout: Layout) -> Iterable[tuple[int, str, str]]:
    """Yield cell, shape and number of each station."""
    picking = len(layout.stations) - layout.replenishing
    for number, own in enumerate(layout.stations):
        yield own.station, "pick" if number < picking else "store", str(number + 1)
    for number, cell in enumerate(layout.packing, 1):
        yield cell, "pack", str(number)


def _station(layout: Layout, cell: int, shape: str, name: str) -> str:
    column, row = _x(layout, cell), _y(layout, cell)
    square = f'<rect class="{shape}" x="{column}" y="{row}" width="1" height="1"/>'
    return f'{square}<text x="{column}.5" y="{row}.72">{escape(name)}</text>'


def _pod(layout: Layout, pod: HallPod) -> str:
    shape = "empty" if pod.level is None else f"level-{pod.level}"
    title = f"<title>{escape(pod.title)}</title>" if pod.title else ""
    place = f'x="{_x(layout, pod.cell)}.12" y="{_y(layout, pod.cell)}.12"'
    return f'<rect class="{shape}" {place} width=".76" height=".76" rx=".1">{title}</rect>'
