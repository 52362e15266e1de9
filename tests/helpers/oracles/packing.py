"""Where orders are packed, and what packers do next."""

from collections.abc import Callable
from typing import Any

from oracles.worlds import Moment
from rmfs_core.warehouse import Order, PackingStation


def least_reserved(asked: Moment, _: object) -> list[int]:
    """The fewest boxes reserved, then the fewest orders bound; the other way round for an order that is not split."""
    return sent(asked, lambda order, station: 0.0)


def nearest(asked: Moment, _: object) -> list[int]:
    """The shortest time of all its parts on conveyors."""
    return sent(asked, lambda order, station: sum(station.conveyor_s[part.station] for part in order.parts))


def sent(asked: Moment, cost: Callable[[Order, PackingStation], float]) -> list[int]:
    """Bind one order after another."""
    chosen = []
    for order in asked.orders:
        ranked: list[Any] = []
        for station in asked.world.packing:
            boxes, orders = station.section.boxes - station.free_boxes, len(station.orders)
            if order.split and not station.free_boxes:
                continue
            rank = [boxes, orders] if order.split else [orders, boxes]
            ranked.append((cost(order, station), *rank, station.id))
        chosen.append(min(ranked)[-1])
        asked.world.bind_packing(order, asked.world.packing[chosen[-1]])
    return chosen


def first_come(_asked: Moment, _: object, **_parameters: Any) -> int:
    """The first, as tasks are in the order in which they began to wait."""
    return 0


def pack_first(asked: Moment, _: object) -> int:
    """The first to pack, or else the first."""
    return next((i for i, task in enumerate(asked.tasks) if task.kind == "pack"), 0)


def due_first(asked: Moment, _: object) -> int:
    """By due time, those without one last; then by priority; then as they wait."""

    def key(i: int) -> tuple[bool, float, int, int]:
        order = asked.tasks[i].order
        return order.due_s is None, order.due_s or 0.0, -order.priority, i

    return min(range(len(asked.tasks)), key=key)


def shortest(asked: Moment, _: object) -> int:
    """By duration; then as they wait."""
    return sorted(range(len(asked.tasks)), key=lambda i: (asked.tasks[i].duration_s, i))[0]
