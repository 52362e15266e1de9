"""Orders and pods as CSV text, which `rmfs_core.world.read_instance` reads."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

from rmfs_commands.instances.csv_files import DUE_COLUMNS, ORDER_COLUMNS, PLACE_COLUMNS, POD_COLUMNS
from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.world import Instance, OrderData


def orders_csv(instance: Instance) -> str:
    """Return the orders as CSV text, a row for each order line; with due times and priorities if there are any."""
    dated = instance.dated
    return _csv(
        (*ORDER_COLUMNS, *(DUE_COLUMNS if dated else ())),
        (
            (order.name, _seconds(order.arrival_tick), instance.skus[sku], quantity, *(_due(order) if dated else ()))
            for order in instance.orders
            for sku, quantity in order.lines
        ),
    )


def _due(order: OrderData) -> tuple[str, int]:
    return "" if order.due_tick is None else _seconds(order.due_tick), order.priority


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
