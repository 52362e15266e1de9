"""How many orders of a run waited for stock, for people."""

from __future__ import annotations

from attrs import define, field

from rmfs_core import hookimpl
from rmfs_core.events import OrderInStock
from rmfs_core.wording import counted


@define(eq=False)
class StockWaits:
    """Counts the orders that waited until the pods held enough for them; orders that still wait do not count."""

    hears = (OrderInStock,)
    orders: int = field(default=0, init=False)

    @hookimpl
    def on_event(self, event: OrderInStock) -> None:  # noqa: ARG002 - only how many there are counts
        """Count one."""
        self.orders += 1

    @property
    def sentence(self) -> str:
        """Say how many there were; nothing where there was none."""
        return f"{counted(self.orders, 'order')} waited for stock (stock_s in delays.csv)." if self.orders else ""
