"""What a placement learns from: orders of the past, or the very orders that are run."""

from __future__ import annotations

from collections.abc import Sequence

from attrs import frozen

from rmfs_convert.lines import Sku
from rmfs_core.wording import counted

FORESEES = (
    "The placement knows the orders that it is judged by",
    "--history TABLE or --history-until TIME learns from others",
)


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
        """Return what is said of it, in the output and in the scenario; None where nothing was learned."""
        if self.placement == "random":
            return None
        if self.source is None:
            return f"{FORESEES[0]} ({self.placement}); {FORESEES[1]}."
        again = f", without {counted(self.forgotten, 'order')} that are run" if self.forgotten else ""
        verbs = ("is", "stands") if self.unknown == 1 else ("are", "stand")
        unknown = f" {self.unknown:,} of {counted(self.skus, 'SKU')} {verbs[0]} not in it and {verbs[1]} anywhere."
        told = f"Placement {self.placement} learned from {counted(self.orders, 'order')} of {self.source}{again}."
        return told + (unknown if self.unknown else "")


def merged(run: Sequence[Sku], past: Sequence[Sku]) -> list[Sku]:
    """Return all SKUs with the order lines of the past and the items that the run wants, most lines first."""
    items = {sku.name: sku.items for sku in run}
    found = [Sku(sku.name, sku.lines, items.get(sku.name, 0)) for sku in past]
    known = {sku.name for sku in past}
    return found + [Sku(sku.name, 0, sku.items) for sku in run if sku.name not in known]
