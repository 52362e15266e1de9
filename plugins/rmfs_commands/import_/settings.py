"""RAWSim-O's settings (``.xsett``), SKUs to draw orders from (``.xgenc``), and lists of orders (``.xitem``)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from attrs import define, field, frozen

from rmfs_commands.import_.notes import Notes
from rmfs_commands.import_.xml_reading import Element, document, elements
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import MOST_ORDERS

READ = (
    "Name", "SimulationWarmupTime", "SimulationDuration", "Seed", "InventoryConfiguration", "ItemType", "OrderMode",
    "InitialInventory", "ItemWeightMin", "ItemWeightMax", "BundleSizeMin", "BundleSizeMax", "PositionCountMean",
    "PositionCountStdDev", "PositionCountMin", "PositionCountMax", "OrderPositionCountMean",
    "OrderPositionCountStdDev", "OrderPositionCountMin", "OrderPositionCountMax", "OrderCount",
    "InventoryLevelOrderStopThreshold", "AverageOrdersPerHourAndStation", "DemandInventoryConfiguration",
    "SimpleItemConfiguration", "GeneratorConfigFile", "FixedInventoryConfiguration", "OrderFile",
    "PoissonInventoryConfiguration", "InitialOrderCount", "OverrideConfig", "CommentTag1", "CommentTag2", "CommentTag3",
)  # fmt: skip
"""Keys of a setting that are read, or noted by themselves."""
READ_OF_BUNDLES = (
    "InventoryLevelDrivenBundleGeneration", "InventoryLevelBundleStopThreshold",
    "InventoryLevelBundleRestartThreshold", "AverageBundlesPerHourAndStation", "InitialBundleCount",
    "IgnoreCapacityForBundleGeneration", "BufferBundlesUntilInventoryLoad",
)  # fmt: skip
"""Keys that are read where there are input stations."""
DEFAULT_SIZE = 1.0


@frozen
class Spread:
    """A whole number: a normal one, rounded, drawn again until it is from ``least`` to ``most``."""

    mean: float
    deviation: float
    least: int
    most: int


@frozen
class Setting:
    """A setting.

    Parameters
    ----------
    seed, until_s, warmup_s
        Seed and times of the run.
    mode
        Where orders come from: ``Fill`` (a backlog that is kept full), ``Poisson``, ``Fixed`` (a list).
    backlog
        Orders that ``Fill`` keeps waiting.
    rate_per_h
        Orders per hour and station of ``Poisson``.
    initial_orders
        Orders that ``Poisson`` begins with.
    lines, quantities
        Lines of an order, and items of a line.
    stocked, emptied
        Share of the pods' capacity that is full at the start, and of that stock at which no more orders come.
    weight, bundle
        Weight of an item and size of a bundle where a SKU has none of its own.
    refers_to
        File of SKUs or orders that it names.
    refill
        Shares of the pods' capacity at which ``Fill`` has bundles come, and no more.
    bundles_per_h, initial_bundles
        Bundles an hour and input station of ``Poisson``, and how many it begins with.
    overfill
        Share of the pods' capacity that stock and bundles that wait may need together in ``Poisson``.
    """

    seed: int
    until_s: float
    warmup_s: float
    mode: str
    backlog: int
    rate_per_h: float
    initial_orders: int
    lines: Spread
    quantities: Spread
    stocked: float
    emptied: float
    weight: float
    bundle: int
    refers_to: str | None
    refill: tuple[float, float] = (0.65, 0.85)
    bundles_per_h: float = 45.0
    initial_bundles: int = 30
    overfill: float = 1.1


@frozen
class Sku:
    """A SKU that orders are drawn of: its name, its share of them, an item's weight, and items of a bundle."""

    name: str
    share: float
    weight: float
    bundle: int


@define
class OrderList:
    """Orders and bundles.

    Parameters
    ----------
    weights
        Weight of an item of each SKU.
    bundles
        Time of arrival in seconds, SKU and items of what is to be stored.
    orders
        Time of arrival in seconds, and SKU and items of each line.
    """

    weights: dict[str, float] = field(factory=dict)
    bundles: list[tuple[float, str, int]] = field(factory=list)
    orders: list[tuple[float, list[tuple[str, int]]]] = field(factory=list)


def read_setting(path: Path, notes: Notes, *, refilled: bool = False) -> Setting:
    """Read an ``.xsett``; what stands in none of the keys that are read is noted.

    Keys of bundles are read where stock is refilled.
    """
    root = document(path)
    inventory = root.part("InventoryConfiguration") or Element("InventoryConfiguration", root.file, root.line, ())
    empty = Element("", root.file, root.line, ())
    demand, fixed, simple, poisson = (
        inventory.part(f"{name}Configuration") or empty
        for name in ("DemandInventory", "FixedInventory", "SimpleItem", "PoissonInventory")
    )
    mode = inventory.value("OrderMode") or "Fill"
    if mode not in ("Fill", "Poisson", "Fixed"):
        raise inventory.wrong("OrderMode", "Fill, Poisson or Fixed", mode)
    kind = inventory.value("ItemType") or "SimpleItem"
    if kind != "SimpleItem" and mode != "Fixed":
        expected = "SimpleItem, or orders of a list (`OrderMode` Fixed)"
        raise inventory.wrong("ItemType", expected, kind)
    keys = [inner for element in _all(root) for inner in element.inside]
    overrides = [key for key in keys if key.name == "OverrideConfig"]
    notes.add("values of the setting that override those of the layout (OverrideConfig)", _switched_on(overrides))
    if poisson is not empty and mode == "Poisson" and (poisson.value("PoissonMode") or "TimeDependent") != "Simple":
        notes.add("rates of orders by time of day or season", 1, "AverageOrdersPerHourAndStation all the time")
    dated = [key for key in keys if key.name.startswith("DueTime") or key.name.startswith("OrderTimestampDueDate")]
    notes.add("settings of due times", len(dated), "left out; orders have none")
    read = {*READ, *(READ_OF_BUNDLES if refilled else ())}
    others = [key for key in keys if key.name not in read and key not in dated and "OverrideConfig" not in key.above]
    notes.add("other settings", len(others))
    return Setting(
        seed=root.whole("Seed", 0),
        until_s=root.number("SimulationDuration", 172_800, least=1e-3, most=1e10),
        warmup_s=root.number("SimulationWarmupTime", 0, least=0, most=1e10),
        mode=mode,
        backlog=demand.whole("OrderCount", 200, 1, MOST_ORDERS),
        rate_per_h=poisson.number("AverageOrdersPerHourAndStation", 160, least=0.001, most=1e6),
        initial_orders=poisson.whole("InitialOrderCount", 30, 0, MOST_ORDERS),
        lines=_spread(inventory, "OrderPositionCount", (1, 1, 1, 4)),
        quantities=_spread(inventory, "PositionCount", (1, 0.3, 1, 3)),
        stocked=inventory.number("InitialInventory", 0.7, least=0, most=1),
        emptied=demand.number("InventoryLevelOrderStopThreshold", 0.1, least=0, most=1),
        weight=(inventory.number("ItemWeightMin", 5, least=0) + inventory.number("ItemWeightMax", 5, least=0)) / 2,
        bundle=(inventory.whole("BundleSizeMin", 6, 1) + inventory.whole("BundleSizeMax", 6, 1) + 1) // 2,
        refers_to=fixed.value("OrderFile") if mode == "Fixed" else simple.value("GeneratorConfigFile"),
        refill=_refill(demand, notes if refilled and mode == "Fill" else Notes()),
        bundles_per_h=poisson.number("AverageBundlesPerHourAndStation", 45, least=0.001, most=1e6),
        initial_bundles=poisson.whole("InitialBundleCount", 30, 0, 100_000),
        overfill=_overfill(inventory),
    )


def _refill(demand: Element, notes: Notes) -> tuple[float, float]:
    low = demand.number("InventoryLevelBundleRestartThreshold", 0.65, least=0, most=1)
    high = demand.number("InventoryLevelBundleStopThreshold", 0.85, least=0, most=1)
    if low > high:
        expected = f"a number of at least {low:g}, as `InventoryLevelBundleRestartThreshold` says,"
        raise demand.wrong("InventoryLevelBundleStopThreshold", expected, f"{high:g}")
    if not demand.truth("InventoryLevelDrivenBundleGeneration", default=True):
        notes.add("bundles that come until pods are full", 1, f"stock of {low:g} to {high:g} of the pods' capacity")
    return low, high


def _overfill(inventory: Element) -> float:
    if inventory.truth("IgnoreCapacityForBundleGeneration", default=False):
        return 1e9
    return inventory.number("BufferBundlesUntilInventoryLoad", 1.1, least=0, most=1e9)


def read_skus(path: Path, weight: float, bundle: int, notes: Notes) -> list[Sku]:
    """Read an ``.xgenc``; items have the weight and bundles the size given where it has none."""
    default, together = 1.0, 0
    values: dict[str, dict[int, float]] = {}
    for element in elements(path, 1):
        if element.name == "DefaultWeight":
            default = _number_of(element)
        if element.name == "ItemCoWeights":
            together = len(element.inside)
        if element.name.startswith("Item") and element.name != "ItemCoWeights":
            least = -1e9 if element.name == "ItemDescriptions" else 0  # hues of SKUs
            values[element.name] = {e.whole("Key"): e.number("Value", least=least) for e in element.inside}
    numbers = values.get("ItemDescriptions", {})
    shares, weights, bundles = (
        values.get(name, {}) for name in ("ItemWeights", "ItemDescriptionWeights", "ItemDescriptionBundleSizes")
    )
    notes.add("SKUs that are bought together (ItemCoWeights)", together, "drawn apart")
    skus = [
        Sku(f"s{i}", shares.get(i, default), weights.get(i, weight), max(1, round(bundles.get(i, bundle))))
        for i in sorted(numbers)
    ]
    if not any(sku.share for sku in skus):
        raise InputError(str(path), "found no SKU that orders want; expected `ItemDescriptions` and `ItemWeights`")
    return skus


def read_order_list(path: Path, notes: Notes) -> OrderList:
    """Read an ``.xitem``."""
    found = OrderList()
    empty = 0
    for element in elements(path, 2):
        match element.name:
            case "ItemDescription":
                found.weights[f"s{element.whole('ID')}"] = element.number("Weight", DEFAULT_SIZE, least=0)
            case "ItemBundle":
                sku, items = f"s{element.whole('ItemDescription')}", element.whole("Size", least=1)
                found.bundles.append((element.number("TimeStamp", 0, least=0, most=3e8), sku, items))
            case "Order":
                lines = list(_lines(element))
                empty += not lines
                if lines:
                    found.orders.append((element.number("TimeStamp", 0, least=0, most=3e8), lines))
        if max(len(found.weights), len(found.bundles), len(found.orders)) > MOST_ORDERS:
            raise InputError(element.place, f"found more than {MOST_ORDERS:,} of {element.name}; expected fewer")
    if not found.orders:
        raise InputError(str(path), "found no order; expected some")
    notes.add("orders without positions", empty)
    return found


def _lines(order: Element) -> Iterator[tuple[str, int]]:
    positions = order.part("Positions")
    for position in positions.inside if positions is not None else ():
        if count := position.whole("Count", 1, 0):
            yield f"s{position.whole('ItemDescriptionID')}", count


def _spread(inventory: Element, name: str, default: tuple[float, float, int, int]) -> Spread:
    mean, deviation, low, high = default
    least = inventory.whole(f"{name}Min", low, 0, 10_000)
    spread = Spread(
        inventory.number(f"{name}Mean", mean, least=0, most=10_000),
        inventory.number(f"{name}StdDev", deviation, least=0, most=10_000),
        max(1, least),
        inventory.whole(f"{name}Max", high, 1, 10_000),
    )
    if spread.least > spread.most:
        expected = f"a whole number of at least {spread.least}, as `{name}Min` says,"
        raise inventory.wrong(f"{name}Max", expected, str(spread.most))
    return spread


def _all(element: Element) -> Iterator[Element]:
    yield element
    for inner in element.inside:
        yield from _all(inner)


def _switched_on(overrides: list[Element]) -> int:
    return sum(inner.text.strip() == "true" for element in overrides for inner in element.inside)


def _number_of(element: Element) -> float:
    """Return what an element with nothing but a number says."""
    return Element("", element.file, element.line, (), {element.name: element.text}).number(element.name, least=0)
