"""Orders and pods as CSV text, which `rmfs_core.world.read_instance` reads."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

from rmfs_core.clock import TICKS_PER_S, to_seconds
from rmfs_core.world import Instance
from rmfs_core.world.csv_files import ORDER_COLUMNS, POD_COLUMNS


def orders_csv(instance: Instance) -> str:
    """Return the orders as CSV text, a row for each order line."""
    return _csv(
        ORDER_COLUMNS,
        (
            (order.name, _seconds(order.arrival_tick), instance.skus[sku], quantity)
            for order in instance.orders
            for sku, quantity in order.lines
        ),
    )


def pods_csv(instance: Instance) -> str:
    """Return the pods as CSV text, a row for each SKU on a pod; no quantity where it is unlimited."""
    return _csv(
        POD_COLUMNS,
        (
            (pod.name, instance.skus[sku], "" if quantity is None else quantity)
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
