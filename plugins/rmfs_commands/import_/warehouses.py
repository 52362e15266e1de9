"""Warehouses of RAWSim-O: instance files (``.xinst``), and layouts that it generates instances from (``.xlayo``)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

from attrs import define, field, frozen

from rmfs_commands.import_.notes import Notes
from rmfs_commands.import_.waypoints import Drawn, StationPoints, Waypoint, draw, nearest
from rmfs_commands.import_.xml_reading import Element, document, elements
from rmfs_commands.layouts import block_map, parse_map
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import MOST_CELLS, MOST_PODS, LayoutSection
from rmfs_core.wording import counted
from rmfs_core.world import CellKind, check_layout

T = TypeVar("T")


@frozen
class Moving:
    """How a robot moves: as RAWSim-O has it, in metres and seconds."""

    acceleration: float
    deceleration: float
    speed: float
    full_turn_s: float
    lift_s: float


@frozen
class Picking:
    """A picking station: how many orders it takes at a time, and how long an item holds picker and pod."""

    orders: int
    handle_s: float
    pick_s: float


@frozen
class Storing:
    """A replenishment station: weight of the bundles that it takes at a time, and how long storing one takes."""

    capacity: float
    store_s: float


@define
class Warehouse:
    """A warehouse, before orders and contents.

    Parameters
    ----------
    name
        Its name in the file.
    layout
        Keys of the scenario's section ``layout``.
    queue_length
        Key of the section ``stations``; None: the map says it.
    text_map
        The map, if there is one.
    pods
        Names of pods.
    places
        Row and column of each pod, from 1; empty when they stand at random.
    pod_capacity
        Weight that each pod holds.
    robots
        Number of robots.
    robot_places
        Row and column of each robot, from 1; empty when they stand at random.
    moving
        How robots move.
    picking
        The picking stations in the order of the layout.
    storing
        The replenishment stations.
    read
        How many of what was read.
    """

    name: str
    moving: Moving
    picking: Sequence[Picking]
    pods: Sequence[str]
    pod_capacity: Sequence[float]
    robots: int
    layout: dict[str, object] = field(factory=dict)
    queue_length: int | None = None
    text_map: str | None = None
    places: Sequence[tuple[int, int]] = ()
    robot_places: Sequence[tuple[int, int]] = ()
    storing: Sequence[Storing] = ()
    read: dict[str, int] = field(factory=dict)


def read_instance_file(path: Path, notes: Notes) -> Warehouse:
    """Read an ``.xinst``: waypoints become a text map; pods and robots stand where the file has them.

    Raises
    ------
    InputError
        When the file is wrong, has more than one tier, or its waypoints are no grid of 1 m.
    """
    found: dict[str, list[Element]] = {}
    points: dict[int, Waypoint] = {}
    elevators: set[int] = set()
    at_inputs: dict[int, int] = {}
    at_stations: dict[int, int] = {}
    name = path.stem
    for element in elements(path, 2):
        section = element.above[-1]
        if section != "Waypoints" or element.name != "Waypoint":
            found.setdefault(section, []).append(element)
            if len(found[section]) > MOST_CELLS:
                raise InputError(element.place, f"found more than {MOST_CELLS:,} {section}; expected fewer")
            continue
        number = element.whole("ID")
        if number in points:
            raise InputError(element.place, f"found waypoint {number} again; expected another ID")
        points[number] = _waypoint(element)
        if element.whole("Elevator", -1, -1) >= 0:
            elevators.add(number)
        for kind, at in (("InputStation", at_inputs), ("OutputStation", at_stations)):
            if (station := element.whole(kind, -1, -1)) >= 0:
                at[station] = number
        if len(points) > MOST_CELLS:
            raise InputError(element.place, f"found more than {MOST_CELLS:,} waypoints; expected at most that many")
    tiers = _of("Tier", found)
    if len(tiers) != 1:
        raise InputError(tiers[1].place if tiers else str(path), f"found {len(tiers)} tiers; expected one")
    _check_numbers(_of("InputStation", found))
    _check_numbers(_of("OutputStation", found))
    stations = [_station(element, at_stations) for element in _of("OutputStation", found)]
    if not stations:
        raise InputError(str(path), "found no output station; expected at least one")
    size = tiers[0].number("Length", least=0, most=1e6), tiers[0].number("Width", least=0, most=1e6)
    inputs = [_station(element, at_inputs, replenishing=True) for element in _of("InputStation", found)]
    drawn, storing = _drawn(points, stations, inputs, elevators, size, str(path), notes)
    notes.add("elevators", len(_of("Elevator", found)), "walls")
    notes.add("semaphores of queues", len(_of("Semaphore", found)), "left out; rmfs reserves cells")
    bots, pods = _of("Bot", found), _of("Pod", found)
    _check_numbers(pods)
    if not bots:
        raise InputError(str(path), "found no bot; expected at least one")
    if len(pods) > MOST_PODS or len(bots) > MOST_PODS:
        raise InputError(str(path), f"found {len(pods):,} pods and {len(bots):,} bots; expected {MOST_PODS:,} at most")
    read = {"waypoints": len(points), "storage locations": len(drawn.layout.storage_locations)}
    read |= {"picking stations": len(stations)} | ({"replenishment stations": len(inputs)} if storing else {})
    read |= {"robots": len(bots), "pods": len(pods)}
    picking = {
        element.whole("ID"): _picking(element, element.whole("Capacity", least=1))
        for element in _of("OutputStation", found)
    }
    return Warehouse(
        name=name,
        text_map=drawn.text,
        layout={"map_file": "map.txt"},
        moving=_same([_moving(bot) for bot in bots], "bots", notes),
        picking=[picking[station.number] for station in drawn.stations],
        storing=[_storing(element) for element in _of("InputStation", found)] if storing else (),
        pods=[f"p{pod.whole('ID')}" for pod in pods],
        pod_capacity=[pod.number("Capacity", 1e9, least=0) for pod in pods],
        places=_placed(pods, drawn, frozenset({CellKind.STORAGE}), "pods that stand at no storage location", notes),
        robots=len(bots),
        robot_places=_placed(bots, drawn, frozenset(CellKind) - {CellKind.WALL}, "bots that stand on no cell", notes),
        read=read,
    )


def _drawn(
    points: Mapping[int, Waypoint],
    stations: Sequence[StationPoints],
    inputs: Sequence[StationPoints],
    elevators: set[int],
    size: tuple[float, float],
    place: str,
    notes: Notes,
) -> tuple[Drawn, bool]:
    """Draw the map; return also whether it has the input stations; if no map can have them, they are walls."""
    told = Notes()
    lost = ""
    if inputs:
        try:
            drawn = draw(points, [*stations, *inputs], elevators, size, place, told)
        except InputError as error:
            told, lost = Notes(), error.problem
    if lost or not inputs:
        walls = {number for station in inputs for number in (station.waypoint, *station.queue)}
        drawn = draw(points, stations, elevators | walls, size, place, told)
        told.add("input stations (replenishment)", len(inputs), f"walls; stock is not filled up: {lost}")
    notes.taken += told.taken
    return drawn, bool(inputs) and not lost


def read_layout_file(path: Path, notes: Notes) -> Warehouse:
    """Read an ``.xlayo``: rmfs draws a block layout of the same sizes; pods and robots stand at random.

    Raises
    ------
    InputError
        When the file is wrong, has more than one tier, or stations in the north or south.
    """
    root = document(path)
    if (tiers := root.whole("TierCount", 1)) != 1:
        raise InputError((root.part("TierCount") or root).place, f"found {tiers} tiers; expected one")
    for side in ("North", "South"):
        key = f"NPickStation{side}"
        if number := root.whole(key, 0):
            found = f"found {counted(number, 'picking station')} in the {side.lower()}"
            raise InputError((root.part(key) or root).place, f"{found}; expected them in the east and the west")
    rows, columns = (root.whole(f"Nr{way}Aisles", n, 1, 10_000) + 1 for way, n in (("Horizontal", 8), ("Vertical", 6)))
    length = root.whole("HorizontalLengthBlock", 4, 1, 10_000)
    east, west = (root.whole(f"NPickStation{side}", n, 0, 10_000) for side, n in (("East", 4), ("West", 0)))
    lanes = root.whole("DistanceEntryExitStation", 3, 1, 1000)
    share = root.number("PodAmount", 0.85, least=1e-6, most=1)
    locations = 2 * rows * columns * length
    pods = int(share * locations)
    if pods > MOST_PODS:
        raise InputError(str(path), f"found {pods:,} pods; expected at most {MOST_PODS:,}")
    sides = ("West", "East", "South", "North")
    inputs = {side: root.whole(f"NReplenishmentStation{side}", 4 * (side == "West"), 0, 10_000) for side in sides}
    left = inputs["South"] + inputs["North"]
    notes.add("input stations in the north and south (replenishment)", left, "left out")
    notes.add("elevators", sum(root.whole(f"NElevators{side}", 0) for side in sides))
    halls = 0 if (root.value("AisleLayoutType") or "Tim") == "HighwayHallway" else (east > 0) + (west > 0)
    notes.add("halls whose lanes lead across (AisleLayoutType Tim)", halls, "lanes that lead along the hall")
    notes.add("queues of other than 3 lanes (DistanceEntryExitStation)", (east + west) * (lanes != 3), "3 lanes")
    one_way = root.truth("AislesTwoDirectional", False) or not root.truth("SingleLane", True)
    notes.add("aisles that are driven both ways, or have two lanes", rows + columns - 2 if one_way else 0, "one-way")
    clockwise = not root.truth("CounterClockwiseRingwayDirection", True)
    notes.add("ring that is driven clockwise", int(clockwise), "counter-clockwise")
    bots = root.whole("BotCount", 32, 1, MOST_PODS)
    layout: dict[str, Any] = {
        "block_rows": rows,
        "block_columns": columns,
        "block_length": length,
        "hall_width": root.whole("WidthHall", 6, 0, 10_000) + 1,  # the ring is a lane of its own there
        "stations_east": east,
        "stations_west": west,
        "pod_fill": share,
    }
    queue_length = lanes * root.whole("WidthBuffer", 4, 1, 1000)
    refill = {f"replenishment_{side.lower()}": inputs[side] for side in ("East", "West") if inputs[side]}
    if refill and (lost := _fault({**layout, **refill}, queue_length, str(path))) is not None:
        instead = f"left out; stock is not filled up: {lost.problem}"
        notes.add("input stations in the east and west (replenishment)", sum(refill.values()), instead)
        refill = {}
    layout |= refill
    if (fault := _fault(layout, queue_length, str(path))) is not None:
        raise fault
    stored = Storing(
        root.number("IStationCapacity", 1000, least=0), root.number("ItemBundleTransferTime", 10, least=0, most=3600)
    )
    read = {"storage locations": locations, "picking stations": east + west}
    read |= {"replenishment stations": sum(refill.values())} if refill else {}
    return Warehouse(
        name=root.value("NameLayout") or path.stem,
        layout=layout,
        queue_length=queue_length,
        moving=_same([_moving(root)], "bots", notes),
        picking=[_picking(root, root.whole("OStationCapacity", 12, 1), 10, 3)] * (east + west),
        pods=[f"p{i}" for i in range(pods)],
        pod_capacity=[root.number("PodCapacity", 500, least=0)] * pods,
        robots=bots,
        storing=[stored] * sum(refill.values()),
        read=read | {"robots": bots, "pods": pods},
    )


def _fault(layout: Mapping[str, Any], queue_length: int, place: str) -> InputError | None:
    """Return what is wrong with a block layout."""
    try:
        check_layout(parse_map(block_map(LayoutSection(**layout), queue_length, place), place), place)
    except InputError as error:
        return error
    except ValueError as error:
        return InputError(place, str(error))
    return None


def _of(name: str, found: dict[str, list[Element]]) -> list[Element]:
    return [element for element in found.get(f"{name}s", ()) if element.name == name]


def _check_numbers(things: Iterable[Element]) -> None:
    """Refuse two of a kind with one ID."""
    seen: set[int] = set()
    for thing in things:
        if (number := thing.whole("ID")) in seen:
            raise InputError(thing.place, f"found {thing.name} {number} again; expected another ID")
        seen.add(number)


def _waypoint(element: Element) -> Waypoint:
    paths = element.part("Paths")
    ways = tuple(_number(way.text, way) for way in paths.inside) if paths is not None else ()
    x, y = element.number("X", least=-1e6, most=1e6), element.number("Y", least=-1e6, most=1e6)
    return Waypoint(x, y, ways, element.truth("PodStorageLocation", False), element.place)


def _number(text: str, element: Element) -> int:
    if (text := text.strip()).isdecimal() and len(text) < 10:
        return int(text)
    raise InputError(element.place, f"expected the number of a waypoint, found {text[:40]!r}")


def _queue(station: Element) -> tuple[int, ...]:
    """Return the waypoints of a station's queue: ``<Queues>12/11</Queues>``, in older files ``<Queue>11</Queue>``."""
    queue = station.part("Queues") or station.part("Queue")
    return () if queue is None else tuple(_number(entry.text.rpartition("/")[2], entry) for entry in queue.inside)


def _station(element: Element, waypoints: dict[int, int], *, replenishing: bool = False) -> StationPoints:
    number = element.whole("ID")
    return StationPoints(number, waypoints.get(number, -1), _queue(element), element.place, replenishing)


def _storing(element: Element) -> Storing:
    capacity = element.number("Capacity", 1000, least=0)
    return Storing(capacity, element.number("ItemBundleTransferTime", 10, least=0, most=3600))


def _moving(element: Element) -> Moving:
    return Moving(
        acceleration=element.number("MaxAcceleration", 1.0, least=0.001, most=1000),
        deceleration=element.number("MaxDeceleration", 1.0, least=0.001, most=1000),
        speed=element.number("MaxVelocity", 1.5, least=0.001, most=1000),
        full_turn_s=element.number("TurnSpeed", 2.5, least=0.001, most=3600),
        lift_s=element.number("PodTransferTime", 2.2, least=0, most=3600),
    )


def _picking(element: Element, orders: int, handle: float | None = None, pick: float = 0.0) -> Picking:
    """Return how a station works; where it has no time for picking, an item holds the pod as long as the picker."""
    handle_s = element.number("ItemTransferTime", handle, least=0.001, most=3600)
    pick_s = element.number("ItemPickTime", pick, least=0, most=3600) or handle_s
    return Picking(orders, max(handle_s, pick_s), pick_s)


def _same(found: Sequence[Moving], what: str, notes: Notes) -> Moving:
    """Return how most of them move."""
    usual = commonest(found)
    notes.add(f"{what} that move otherwise than most", sum(one != usual for one in found), "as most")
    if usual.acceleration != usual.deceleration:
        notes.add(f"{what} that brake otherwise than they start", len(found), "as they start")
    return usual


def commonest(found: Iterable[T]) -> T:
    """Return what there is most of, the first of equals."""
    return Counter(found).most_common(1)[0][0]


def _placed(
    things: Sequence[Element], drawn: Drawn, kinds: frozenset[CellKind], what: str, notes: Notes
) -> list[tuple[int, int]]:
    """Return row and column of each, from 1: where it stands, or else the nearest cell that is free."""
    layout = drawn.layout
    points = [[thing.number(axis, least=-1e6, most=1e6) for axis in "XY"] for thing in things]
    own: list[int | None] = []
    taken: set[int] = set()
    for x, y in points:
        cell = drawn.cell(x, y)
        fits = cell not in taken and layout.kind[cell] in kinds
        own.append(cell if fits else None)
        taken |= {cell} if fits else set()
    places = []
    for thing, (x, y), stands in zip(things, points, own, strict=True):
        at = nearest(layout, drawn.cell(x, y), kinds, taken) if stands is None else stands
        if at is None:
            raise InputError(thing.place, f"found no free cell for all {what.partition(' ')[0]}; expected fewer")
        taken.add(at)
        places.append((at // layout.width + 1, at % layout.width + 1))
    notes.add(f"{what} of their own", own.count(None), "the nearest free one")
    return places
