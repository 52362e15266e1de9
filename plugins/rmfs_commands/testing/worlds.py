"""Tiny warehouses for tests of rules."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

from rmfs_commands.layouts import block_map, parse_map
from rmfs_core.motion import Motion
from rmfs_core.scenario.model import LayoutSection, PackingSection
from rmfs_core.warehouse import UNLIMITED, PackingStation, Robot, Station, Warehouse
from rmfs_core.world import NORTH, Instance, Layout, OrderData, PodData, check_layout
from rmfs_core.world.travel import travel_on

Wanted = Mapping[str, Sequence[str] | Mapping[str, int]]


def small_instance(
    orders: Wanted,
    pods: Wanted,
    *,
    arrivals_s: Mapping[str, float] | None = None,
    due_s: Mapping[str, float] | None = None,
    cancelled_s: Mapping[str, float] | None = None,
) -> Instance:
    """Write down an instance.

    Parameters
    ----------
    orders
        Order name to its SKUs (quantity 1 each), or to SKU and quantity.
    pods
        Pod name to its SKUs (unlimited stock), or to SKU and number of items.
    arrivals_s
        Order name to its arrival in seconds; 0 where left out.
    due_s
        Order name to its due time in seconds; none where left out.
    cancelled_s
        Order name to when it is cancelled, in seconds; never where left out.
    """
    names = dict.fromkeys(sku for contents in (*pods.values(), *orders.values()) for sku in contents)
    ids = {name: i for i, name in enumerate(names)}
    due, cancelled = (
        {name: round(seconds * 1000) for name, seconds in (given or {}).items()} for given in (due_s, cancelled_s)
    )
    arrivals = arrivals_s or {}
    return Instance(
        skus=tuple(names),
        orders=tuple(
            OrderData(
                name,
                arrival_tick=round(arrivals.get(name, 0.0) * 1000),
                lines=tuple((ids[s], n) for s, n in _numbers(wanted, 1)),
                due_tick=due.get(name),
                cancelled_tick=cancelled.get(name),
            )
            for name, wanted in orders.items()
        ),
        pods=tuple(PodData(name, tuple((ids[s], n) for s, n in _numbers(held, None))) for name, held in pods.items()),
    )


def _numbers(skus: Sequence[str] | Mapping[str, int], default: int | None) -> Iterable[tuple[str, int]]:
    if isinstance(skus, Mapping):
        return skus.items()
    return ((sku, default) for sku in skus)  # type: ignore[misc]


@lru_cache(maxsize=16)
def small_layout(
    stations: int = 1, block_columns: int = 2, queue_length: int = 3, replenishment: int = 0, chargers: int = 0
) -> Layout:
    """Return a block layout that is just large enough for so many stations, and for replenishment, on its east side.

    Chargers are instead of storage locations.
    """
    section = LayoutSection(
        block_rows=2 * (stations + replenishment) + 1,
        block_columns=block_columns,
        hall_width=1,
        stations_east=stations,
        stations_west=0,
        replenishment_east=replenishment or None,
        chargers=chargers or None,
    )
    layout = parse_map(block_map(section, queue_length), "small layout")
    check_layout(layout, "small layout")
    return layout


def small_world(
    orders: Wanted,
    pods: Wanted,
    *,
    capacities: Sequence[int] = (15,),
    counts_orders: bool = False,
    robots: int = 2,
    layout: Layout | None = None,
    due_s: Mapping[str, float] | None = None,
    bundle_capacity: int = 0,
    pod_capacity: int | None = None,
    boxes: Sequence[int] = (),
) -> Warehouse:
    """Return a warehouse at time 0 with all orders in the backlog, whatever the pods hold.

    Pods stand in the first storage locations in reading order, robots under the last ones.

    Parameters
    ----------
    orders, pods
        As for `small_instance`.
    capacities
        Item capacity (or order capacity) of each station.
    counts_orders
        Whether stations count orders instead of items.
    robots
        Number of robots.
    layout
        The grid; left out, `small_layout` with the stations needed.
    due_s
        As for `small_instance`.
    bundle_capacity
        Bundles that each station can have at a time; left out, nothing is stored there. Bundles come by
        ``bundle_arrives(sku, items)`` and ``assign_bundle(bundle, station)`` of the warehouse.
    pod_capacity
        Items that a pod can hold; left out, any number.
    boxes
        Boxes of each packing station; left out, there are none. An order is bound for one, a split one with a box, by
        ``bind_packing(order, station)`` of the warehouse, once a part of it is assigned.
    """
    instance = small_instance(orders, pods, due_s=due_s)
    layout = layout or small_layout(len(capacities))
    locations = layout.storage_locations
    stations = [
        Station(
            i,
            layout.stations[i],
            capacity,
            counts_orders,
            layout.stations[i].places,
            bundle_capacity=bundle_capacity,
        )
        for i, capacity in enumerate(capacities)
    ]
    warehouse = Warehouse(
        instance,
        travel_on(layout, Motion()),
        stations,
        [Robot(i, locations[-1 - i], NORTH) for i in range(robots)],
        locations[: len(instance.pods)],
        pod_capacity=pod_capacity or UNLIMITED,
        wait_for_stock=False,
        packing=[
            PackingStation(i, PackingSection(boxes=number), conveyor_s=(60.0,) * len(stations))
            for i, number in enumerate(boxes)
        ],
    )
    for order in warehouse.orders:
        warehouse.order_arrives(order)
    return warehouse
