"""Filter ``the-rule``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from attrs import define, field, validators
from rmfs import hookimpl

if TYPE_CHECKING:
    from rmfs.warehouse import Order


@define
class TheRule:
    """Show the assigning rule the oldest orders only.

    It decides faster among fewer orders, and none waits forever.

    Parameters
    ----------
    n
        How many orders to keep.
    """

    n: int = field(default=50, validator=validators.ge(1))

    @hookimpl
    def filter_backlog(self, orders: Sequence[Order]) -> Sequence[Order]:
        """Keep the oldest orders; they come oldest first."""
        return orders[: self.n]
