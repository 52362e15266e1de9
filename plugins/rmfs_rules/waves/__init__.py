"""Filter ``waves``: orders are released in waves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define, validators

from rmfs_core import hookimpl
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_rules.helpers.parameters import AT_LEAST_1, parameter

if TYPE_CHECKING:
    from rmfs_core.warehouse import Order, WarehouseView


@define
class Waves:
    """Hold orders back and release them in waves, by the clock or by number.

    At 0, ``every_s``, 2 ``every_s``, ... everything that has arrived is released. In between, with ``orders`` = n, n
    orders are as soon as n have arrived since. What is held back is assigned to no station, though one is free: the
    rules that assign orders choose among more of them at once, and orders wait for it.

    References
    ----------
    R. de Koster, T. Le-Duc, K. J. Roodbergen: Design and control of warehouse order picking: a literature review.
    European Journal of Operational Research 182(2), 481-501, 2007. https://doi.org/10.1016/j.ejor.2006.07.009
    """

    every_s: float = parameter(1800.0, [validators.ge(1), validators.le(1e9)], "Time between waves", "s")
    orders: int | None = parameter(
        None,
        validators.optional(AT_LEAST_1),
        "Orders that are released before their time, as soon as there are so many; left out: never",
    )

    @hookimpl
    def filter_backlog(self, warehouse: WarehouseView, orders: Sequence[Order]) -> Sequence[Order]:
        """Keep the orders that are released."""
        held = self._held(warehouse)
        return [order for order in orders if order.id not in held]

    @hookimpl
    def wake_at(self, warehouse: WarehouseView) -> float | None:
        """Return the time of the next wave, if an order waits for it."""
        if not self._held(warehouse):
            return None
        every = to_ticks(self.every_s)
        return to_seconds((warehouse.now_tick // every + 1) * every)

    def _held(self, warehouse: WarehouseView) -> set[int]:
        """Return the ids of the orders that are held back: the youngest ones."""
        every = to_ticks(self.every_s)
        last_wave = warehouse.now_tick // every * every
        held = []
        for order in reversed(warehouse.orders):
            if order.arrival_tick <= last_wave:
                break
            held.append(order.id)
        return set(held[: len(held) % self.orders] if self.orders is not None else held)
