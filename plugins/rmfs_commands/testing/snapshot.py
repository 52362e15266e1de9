"""A copy of all that a rule can see of the warehouse: two copies show whether anything was changed in between."""

from __future__ import annotations

from collections.abc import Iterator
from operator import attrgetter
from typing import TYPE_CHECKING

from attrs import frozen

from rmfs_core.warehouse import Bundle, Order, Pod, Request, Robot, Station, WarehouseView

if TYPE_CHECKING:
    from rmfs_traffic import Traffic

_HELD_BESIDE = ("label", "contents", "backlog_lines", "capacities", "free_items", "lines", "stock")
"""Made of other values, or noted below as a copy, because they follow later changes."""


def _public(kind: type) -> tuple[str, ...]:
    """Return the names of the values (not the methods) that a class shows."""
    shown = (name for name in dir(kind) if not name.startswith("_") and name not in _HELD_BESIDE)
    return tuple(name for name in shown if not callable(getattr(kind, name)))


_NAMES: dict[type, tuple[str, ...]] = {
    kind: _public(kind) for kind in (WarehouseView, Order, Pod, Station, Robot, Request, Bundle)
}
_READ = {kind: attrgetter(*names) for kind, names in _NAMES.items()}


@frozen(eq=False)
class Snapshot:
    """The values that everything in a view showed at one moment.

    Parameters
    ----------
    values
        The view, an order, a pod ... -> its public values, in the order of their names.
    stock
        For each pod its contents, and how many of its items are not promised.
    reservations
        The table of who has reserved which cell when, for a PP rule that reserves.
    """

    values: dict[object, tuple[object, ...]]
    stock: dict[Pod, tuple[tuple[int, int, int], ...]]
    reservations: tuple[bytes, ...]

    @classmethod
    def of(cls, warehouse: WarehouseView, traffic: Traffic | None = None) -> Snapshot:
        """Note down what a view, and the traffic that a PP rule is asked with, show now."""
        return cls(
            {part: _READ[type(part)](part) for part in _parts(warehouse)},
            {pod: tuple((sku, n, pod.free_items(sku)) for sku, n in pod.contents.items()) for pod in warehouse.pods},
            () if traffic is None else tuple(array.tobytes() for array in traffic.table.arrays),
        )

    def first_change(self, later: Snapshot) -> str | None:
        """Name the first value that is another one later, or None where all are the same."""
        for part, values in later.values.items():
            before = self.values.get(part)
            if before != values:
                return f"{_first_name(part, before, values)} of {_label(part)}"
        for pod, held in later.stock.items():
            if self.stock.get(pod) != held:
                return f"contents of pod {pod.label}"
        return "the reservations" if self.reservations != later.reservations else None


def _parts(warehouse: WarehouseView) -> Iterator[WarehouseView | Order | Pod | Station | Robot | Request | Bundle]:
    yield warehouse
    yield from warehouse.orders
    yield from warehouse.pods
    yield from warehouse.robots
    yield from warehouse.bundles
    for station in dict.fromkeys((*warehouse.stations, *warehouse.replenishment_stations)):
        yield station
        yield from station.open_requests
        yield from station.bundles


def _first_name(part: object, before: tuple[object, ...] | None, after: tuple[object, ...]) -> str:
    if before is None:
        return "existence"
    return next(name for name, a, b in zip(_NAMES[type(part)], before, after, strict=True) if a != b)


def _label(part: object) -> str:
    if isinstance(part, WarehouseView):
        return "the warehouse"
    return repr(part) if isinstance(part, Request) else f"{type(part).__name__.lower()} {getattr(part, 'label', part)}"
