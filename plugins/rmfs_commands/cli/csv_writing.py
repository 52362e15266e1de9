"""Orders and pods as CSV text, which `rmfs_core.world.read_instance` reads."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

from rmfs_commands.instances.csv_files import (
    CANCELLED_COLUMNS,
    DUE_COLUMNS,
    ORDER_COLUMNS,
    PLACE_COLUMNS,
    POD_COLUMNS,
)
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.world import Instance, OrderData


def orders_csv(instance: Instance, route: str | None = None) -> str:
    """Return the orders as CSV text, a row for each order line; with due times and the like if there are any.

    ``route`` is the column for their routes; None: these are left out.
    """
    dated, cancelled = instance.dated, any(order.cancelled_tick is not None for order in instance.orders)

    def more(order: OrderData) -> Iterable[object]:
        if dated:
            yield _maybe(order.due_tick)
            yield order.priority
        if cancelled:
            yield _maybe(order.cancelled_tick)
        if route is not None:
            yield order.route or ""

    some = [*(DUE_COLUMNS if dated else ()), *(CANCELLED_COLUMNS if cancelled else ())]
    some += [] if route is None else [route]
    return _csv(
        (*ORDER_COLUMNS, *some),
        (
            (order.name, _seconds(order.arrival_tick), instance.skus[sku], quantity, *more(order))
            for order in instance.orders
            for sku, quantity in order.lines
        ),
    )


def _maybe(tick: int | None) -> str:
    return "" if tick is None else _seconds(tick)


def pods_csv(instance: Instance) -> str:
    """Return the pods as CSV text, a row for each SKU on a pod; no quantity where it is unlimited."""
    placed = any(pod.place is not None for pod in instance.pods)
    return _csv(
        (*POD_COLUMNS, *(PLACE_COLUMNS if placed else ())),
        (
            (pod.name, instance.skus[sku], "" if quantity is None else quantity, *(pod.place or ())[:2])
            for pod in instance.pods
            for sku, quantity in pod.contents
        ),
    )


def _seconds(tick: int) -> str:
    return str(tick // TICKS_PER_S) if tick % TICKS_PER_S == 0 else str(to_seconds(tick))


def _csv(header: tuple[str, ...], rows: Iterable[tuple[object, ...]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()
