"""Orders that a placement learns from: orders of the past, or the very orders that are run."""

from __future__ import annotations

from collections.abc import Sequence

from attrs import frozen

from rmfs_commands.convert.lines import Sku
from rmfs_core.wording import counted


@frozen
class Learned:
    """Where a placement comes from.

    Parameters
    ----------
    placement
        Its name.
    source
        Table or time of the history; None: the orders that are run.
    orders
        Orders of the history.
    forgotten
        Orders of it that are run as well, and were left out.
    skus, unknown
        SKUs that stand on pods, and how many of them the history does not have.
    """

    placement: str
    source: str | None
    orders: int = 0
    forgotten: int = 0
    skus: int = 0
    unknown: int = 0

    def sentence(self) -> str | None:
        """Return a sentence for the output and the scenario; None where nothing was learned."""
        if self.placement == "random":
            return None
        if self.source is None:
            return (
                f"The placement ({self.placement}) knows the orders that it is judged by; "
                "--history TABLE or --history-until TIME learns from others."
            )
        again = f" (and not from {self.forgotten:,} that are also run)" if self.forgotten else ""
        unknown = f" SKUs without history: {self.unknown:,} of {self.skus:,}, placed anywhere." if self.unknown else ""
        return (
            f"Placement {self.placement} learned from {counted(self.orders, 'order')} of {self.source}{again}.{unknown}"
        )


def merged(run: Sequence[Sku], past: Sequence[Sku]) -> list[Sku]:
    """Return all SKUs with the order lines of the past and the items that the run wants, most lines first."""
    items = {sku.name: sku.items for sku in run}
    found = [Sku(sku.name, sku.lines, items.get(sku.name, 0)) for sku in past]
    known = {sku.name for sku in past}
    return found + [Sku(sku.name, 0, sku.items) for sku in run if sku.name not in known]
