"""Files of RAWSim-O as tests need them: instance files written from layouts, settings, SKUs, lists of orders."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from xml.sax.saxutils import quoteattr

from rmfs_core.world import EAST, NORTH, SOUTH, WEST, CellKind, Layout

HEADINGS = (EAST, NORTH, WEST, SOUTH)
Cell = tuple[int, int]
"""Row and column, from 1."""


def xinst(
    layout: Layout,
    pods: Mapping[int, Cell] | None = None,
    robots: Sequence[Cell] = (),
    *,
    name: str = "made",
    inputs: Iterable[tuple[int, Sequence[int], Sequence[int]]] = (),
    robot: str = "",
    station: str = 'Capacity="6" ItemTransferTime="13" ItemPickTime="7"',
    tiers: int = 1,
    pitch: float = 1.0,
) -> str:
    """Return the instance file of a layout, whose cells that are no walls become waypoints, numbered as they are.

    Pods are numbered. ``inputs`` are input stations in cells that are walls of the layout: the station, its queue from
    there on, which floor next to its far end leads to, and the lane that leads away to the floor. ``robot`` and
    ``station`` are attributes of every bot and output station; ``pitch`` is in metres between waypoints.
    """

    def at(cell: int) -> str:
        return f'X="{(cell % layout.width + 0.5) * pitch:.10g}" Y="{(cell // layout.width + 0.5) * pitch:.10g}"'

    def placed(place: Cell) -> str:
        return at((place[0] - 1) * layout.width + place[1] - 1)

    ways: dict[int, list[int]] = {}
    for cell, kind in enumerate(layout.kind):
        if kind != CellKind.WALL:
            beside = [layout.neighbour(cell, heading) for heading in HEADINGS if layout.may_step(cell, heading)]
            ways[cell] = [other for other in beside if other is not None]
    of_input: dict[int, int] = {}
    for number, (cell, queue, lane) in enumerate(inputs):
        of_input[cell] = number
        chain = [*reversed(queue), cell, *lane]
        for here, there in pairwise(chain):
            ways[here] = [there]
        entry = chain[0]
        for _, beside in layout.beside(entry):
            if layout.kind[beside] == CellKind.FLOOR:
                ways[beside].append(entry)
    stations = {cells.station: number for number, cells in enumerate(layout.stations)}
    moving = robot or 'PodTransferTime="2.2" MaxAcceleration="1" MaxDeceleration="1" MaxVelocity="1.5" TurnSpeed="2.5"'
    bots = [f'<Bot ID="{i}" {moving} {placed(place)} Tier="0" />' for i, place in enumerate(robots)]
    stood = [f'<Pod ID="{i}" {placed(place)} Tier="0" Capacity="500" />' for i, place in (pods or {}).items()]
    written = []
    for number, cells in enumerate(layout.stations):
        queue = "".join(f"<Queues>{cells.station}/{cell}</Queues>" for cell in (cells.station, *cells.queue))
        about = f'ID="{number}" {at(cells.station)} Tier="0" {station}'
        written.append(f"<OutputStation {about}><Queues>{queue}</Queues></OutputStation>")
    entered = [
        f'<InputStation ID="{of_input[cell]}" {at(cell)} Tier="0" Capacity="400" ItemBundleTransferTime="10"><Queues>'
        + "".join(f"<Queues>{cell}/{other}</Queues>" for other in (cell, *queue))
        + "</Queues></InputStation>"
        for cell, queue, _ in inputs
    ]
    waypoints = []
    for cell, to in ways.items():
        kinds = (
            f'OutputStation="{stations.get(cell, -1)}" InputStation="{of_input.get(cell, -1)}" Elevator="-1" Pod="-1"'
        )
        storage = str(bool(layout.kind[cell] == CellKind.STORAGE)).lower()
        paths = "".join(f"<Waypoint>{other}</Waypoint>" for other in to)
        waypoints.append(
            f'<Waypoint ID="{cell}" {at(cell)} Tier="0" {kinds} PodStorageLocation="{storage}" IsQueueWaypoint="false">'
            f"<Paths>{paths}</Paths></Waypoint>"
        )
    size = f'Length="{layout.width * pitch:g}" Width="{layout.height * pitch:g}"'
    floors = "".join(f'<Tier ID="{tier}" {size} />' for tier in range(tiers))
    sections = {
        "Bots": "\n".join(bots),
        "Pods": "\n".join(stood),
        "Elevators": "",
        "InputStations": "\n".join(entered),
        "OutputStations": "\n".join(written),
        "Tiers": floors,
        "Waypoints": "\n".join(waypoints),
        "Semaphores": "",
    }
    inner = "\n".join(f"<{section}>{text}</{section}>" for section, text in sections.items())
    return f'<?xml version="1.0" encoding="utf-8"?>\n<Instance Name={quoteattr(name)}>\n{inner}\n</Instance>\n'


def keys(root: str, values: Mapping[str, object]) -> str:
    """Return a file of elements with a value each; a table is an element with elements in it."""

    def element(name: str, value: object) -> str:
        inner = "".join(element(key, v) for key, v in value.items()) if isinstance(value, Mapping) else str(value)
        return f"<{name}>{inner}</{name}>\n"

    return '<?xml version="1.0" encoding="utf-8"?>\n' + element(root, values)


def xsett(mode: str = "Fill", run: Mapping[str, object] | None = None, **inventory: object) -> str:
    given: dict[str, object] = {"ItemType": "SimpleItem", "OrderMode": mode, **inventory}
    values = {"SimulationDuration": 3600, "Seed": 3, **(run or {}), "InventoryConfiguration": given}
    return keys("SettingConfiguration", values)


def xgenc(shares: Mapping[int, float], *, weights: Mapping[int, float] | None = None, bundle: int = 4) -> str:
    def pairs(values: Mapping[int, float]) -> str:
        return "".join(
            f"<SkvpOfInt32Double><Key>{k}</Key><Value>{v}</Value></SkvpOfInt32Double>" for k, v in values.items()
        )

    return keys(
        "SimpleItemGeneratorConfiguration",
        {
            "DefaultWeight": 1,
            "ItemDescriptions": pairs(dict.fromkeys(shares, -276.5)),
            "ItemDescriptionWeights": pairs(weights or dict.fromkeys(shares, 2.0)),
            "ItemDescriptionBundleSizes": pairs(dict.fromkeys(shares, bundle)),
            "ItemWeights": pairs(shares),
        },
    )


def xitem(
    orders: Iterable[tuple[float, Mapping[int, int]]], bundles: Iterable[tuple[int, int]] = (), skus: Iterable[int] = ()
) -> str:
    """Return a list of orders: times and items of SKUs; and of bundles: SKU and items."""
    listed = "".join(
        f'<Order TimeStamp="{time}"><Positions>'
        + "".join(f'<Position ItemDescriptionID="{sku}" Count="{items}" />' for sku, items in lines.items())
        + "</Positions></Order>\n"
        for time, lines in orders
    )
    described = "".join(f'<ItemDescription ID="{sku}" Type="Letter" Weight="5" Color="Blue" />' for sku in skus)
    arriving = "".join(f'<ItemBundle TimeStamp="1.5" ItemDescription="{sku}" Size="{n}" />' for sku, n in bundles)
    return (
        f'<?xml version="1.0" encoding="utf-8"?>\n<OrderList Type="Letter">\n<ItemDescriptions>{described}'
        f"</ItemDescriptions>\n<ItemBundles>{arriving}</ItemBundles>\n<Orders>{listed}</Orders>\n</OrderList>\n"
    )
