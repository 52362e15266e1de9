"""The data a run starts from, whatever it was made from."""

from __future__ import annotations

from attrs import field, frozen


@frozen
class OrderData:
    """A pick order. Its times are in ticks of 1 ms (`rmfs_core.to_ticks` of seconds), and named wherever one is made.

    Parameters
    ----------
    name
        Its name for people.
    arrival_tick
        When it joins the backlog (ticks of 1 ms).
    lines
        (SKU id, quantity) of each order line; a SKU occurs once.
    due_tick
        Due time (ticks of 1 ms), which may be before the arrival; None: no due time.
    priority
        Priority, higher first.
    cancelled_tick
        When it leaves if nothing of it is assigned then, not before it arrives; None: never.
    route
        Name of the trucks that it goes with; None: it goes with any, or with none.
    """

    name: str
    arrival_tick: int = field(kw_only=True)
    lines: tuple[tuple[int, int], ...]
    due_tick: int | None = field(default=None, kw_only=True)
    priority: int = field(default=0, kw_only=True)
    cancelled_tick: int | None = field(default=None, kw_only=True)
    route: str | None = field(default=None, kw_only=True)

    @property
    def items(self) -> int:
        """Number of items (units) of the order."""
        return sum(quantity for _, quantity in self.lines)


@frozen
class PodData:
    """A pod with contents.

    Parameters
    ----------
    name
        Its name for people.
    contents
        (SKU id, number of items or None for unlimited) of each SKU on the pod; a SKU occurs once.
    place
        Row and column, counted from 1, of where it stands at time 0, and what messages call this; None: anywhere.
    """

    name: str
    contents: tuple[tuple[int, int | None], ...]
    place: tuple[int, int, str] | None = field(default=None, eq=lambda place: place and place[:2])


@frozen
class BundleData:
    """A bundle of a file: its name, when it arrives (ticks of 1 ms), its SKU id and number of items."""

    name: str
    arrival_tick: int = field(kw_only=True)
    sku: int
    items: int


@frozen
class Instance:
    """The start of a run.

    Parameters
    ----------
    skus
        Names by id.
    orders
        By id, in order of arrival.
    pods
        Pods that have contents, by id.
    sizes
        Space that an item takes on a pod, by SKU id; empty: 1 each.
    bundles
        Bundles of the file, in order of arrival.
    levels
        Reorder point s and order-up-to level S in items, by SKU id; empty: nothing is reordered.
    restocked
        Whether bundles may arrive.
    """

    skus: tuple[str, ...]
    orders: tuple[OrderData, ...]
    pods: tuple[PodData, ...]
    sizes: tuple[int, ...] = ()
    bundles: tuple[BundleData, ...] = ()
    levels: tuple[tuple[int, int], ...] = ()
    restocked: bool = False

    @property
    def dated(self) -> bool:
        """Whether any order has a due time or a priority."""
        return any(order.due_tick is not None or order.priority for order in self.orders)

    @property
    def unlimited_stock(self) -> bool:
        """Whether every pod has enough of every SKU it holds (the paper's assumption)."""
        return not self.restocked and all(number is None for pod in self.pods for _, number in pod.contents)
