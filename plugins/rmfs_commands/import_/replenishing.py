"""Bundles that arrive while RAWSim-O runs, as rmfs takes them: levels of stock, or a file of bundles."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from attrs import field, frozen

from rmfs_commands.import_.notes import Notes
from rmfs_commands.import_.settings import Setting, Sku
from rmfs_commands.import_.warehouses import Storing, commonest
from rmfs_commands.import_.xml_reading import Element
from rmfs_commands.results.files import to_csv
from rmfs_core.errors import InputError
from rmfs_core.randomness import stream

Bundle = tuple[float, str, int]
"""Arrival in seconds, SKU and items."""
Contents = Sequence[Mapping[str, int | None]]

ROA = {"Random": "random", "SamePod": "same-pod"}
RPS = {
    "Random": "random",
    "Correlative": "correlated",
    "Turnover": "turnover-pod",
    "ClosestLocation": "nearest-pod-with-room",
    "Emptiest": "emptiest-pod",
    "LeastDemand": "least-demand",
}
"""Rules by RAWSim-O's names of its own, which its configurations of controllers have."""
MOST_DRAWN = 500_000
"""Bundles that are drawn at most."""
_SCALES = (1, 10, 100, 1000)
_MOST_BUNDLES_OF_A_STATION = 10_000


@frozen
class Supply:
    """Bundles that refill the pods.

    Parameters
    ----------
    weights
        Weight of an item of each SKU.
    bundle
        Items of the largest bundle.
    bundles
        Bundles by arrival; empty where levels of stock order them.
    levels
        Reorder point and order-up-to level of each SKU, in items; empty where bundles are listed.
    """

    weights: Mapping[str, float]
    bundle: int
    bundles: Sequence[Bundle] = ()
    levels: Mapping[str, tuple[int, int]] = field(factory=dict)

    def files(self) -> dict[str, str]:
        """Return the texts of ``skus.csv``, and of ``bundles.csv`` where bundles are listed."""
        sizes, _ = self._sizes()
        rows: list[dict[str, object]] = [{"sku": sku, "size": size} for sku, size in sizes.items()]
        if self.bundles:
            listed = [
                {"bundle": f"b{i}", "arrival_s": round(time, 3), "sku": sku, "items": items}
                for i, (time, sku, items) in enumerate(self.bundles, 1)
            ]
            bundles = to_csv(("bundle", "arrival_s", "sku", "items"), listed)
            return {"skus.csv": to_csv(("sku", "size"), rows), "bundles.csv": bundles}
        for row, sku in zip(rows, sizes, strict=True):
            row["reorder_point"], row["order_up_to"] = self.levels[sku]
        return {"skus.csv": to_csv(("sku", "size", "reorder_point", "order_up_to"), rows)}

    def instance_keys(self, capacity: Sequence[float], contents: Contents, notes: Notes) -> dict[str, object]:
        """Return the keys of the section ``instance``: sizes of SKUs, space on pods, and where bundles come from."""
        sizes, scale = self._sizes()
        usual = commonest(capacity)
        notes.add("pods that hold more or less than most", sum(one != usual for one in capacity), "as most")
        held = max(sum((items or 0) * sizes[sku] for sku, items in pod.items()) for pod in contents)
        process: dict[str, object] = {"process": "file", "file": "bundles.csv"}
        if not self.bundles:
            process = {"process": "reorder-point", "bundle_items": self.bundle}
        room = max(math.floor(usual * scale + 1e-6), held, *sizes.values())
        room = max(room, *(sizes[sku] * items for _, sku, items in self.bundles), 0)  # sizes are rounded up
        return {"skus_file": "skus.csv", "pod_capacity": room, "replenishment": process}

    def station_keys(self, storing: Sequence[Storing], notes: Notes) -> dict[str, object]:
        """Return the keys of the section ``stations`` for input stations."""
        store_s = commonest(station.store_s for station in storing)
        others = sum(station.store_s != store_s for station in storing)
        notes.add("input stations that store slower or quicker than most", others, "as most")
        largest = self.bundle * max(self.weights.values())
        least = min(station.capacity for station in storing)
        number = least / largest if largest else _MOST_BUNDLES_OF_A_STATION
        return {"bundle_capacity": int(min(max(number, 1), _MOST_BUNDLES_OF_A_STATION)), "store_s": store_s}

    def _sizes(self) -> tuple[dict[str, int], int]:
        """Return the size of each SKU's items in whole numbers, and how many of them make one of weight."""
        scale = next(
            (n for n in _SCALES if all(abs(w * n - round(w * n)) < 1e-6 for w in self.weights.values())), _SCALES[-1]
        )
        return {sku: max(math.ceil(weight * scale - 1e-6), 1) for sku, weight in self.weights.items()}, scale


def storable(skus: Sequence[Sku], capacity: Sequence[float], place: str, notes: Notes) -> list[Sku]:
    """Return the SKUs whose bundles a pod of the usual capacity can hold; of others there would never be any.

    Raises
    ------
    InputError
        When there is none that is ordered.
    """
    most = commonest(capacity)
    found = [sku for sku in skus if sku.bundle * sku.weight <= most]
    if not any(sku.share for sku in found):
        found_none = f"found no SKU that is ordered and whose bundle a pod of capacity {most:g} can hold"
        raise InputError(place, f"{found_none}; expected lighter items, smaller bundles or larger pods")
    notes.add("SKUs of which a bundle is heavier than what a pod holds", len(skus) - len(found))
    return found


def levels(
    setting: Setting, skus: Sequence[Sku], capacity: float, stock: Mapping[str, int], notes: Notes
) -> Supply | None:
    """Return levels that keep stock half-way between the shares of the pods' capacity that a setting names.

    RAWSim-O has bundles come when all stock together falls to one share, until it reaches the other. Here each SKU is
    ordered by itself, a bundle of its own size at a time, and there is as much of each as bundles would bring, or as is
    there at the start where that is less.

    Returns
    -------
    Supply or None
        None where such levels of all SKUs do not fit on the pods.
    """
    wanted = [sku for sku in skus if sku.share]
    weight = sum(sku.share * sku.bundle * sku.weight for sku in wanted)
    middle = sum(setting.refill) / 2
    found: dict[str, tuple[int, int]] = {}
    space = 0.0
    for sku in wanted:
        usual = middle * capacity * sku.share * sku.bundle / weight if weight else 0.0
        point = max(min(math.floor(usual - sku.bundle / 2), stock.get(sku.name, 0) - 1), 0)
        found[sku.name] = point, point + sku.bundle
        space += found[sku.name][1] * sku.weight
    if not weight or space > capacity:
        notes.add("SKUs whose bundles do not all fit on pods at once", len(wanted), "stock is not filled up")
        return None
    notes.add("levels of all stock at which bundles come", 1, "levels of each SKU (skus.csv)")
    return Supply({sku.name: sku.weight for sku in wanted}, max(sku.bundle for sku in wanted), levels=found)


class Deliveries:
    """Bundles of a Poisson process, drawn as time goes on.

    Parameters
    ----------
    setting
        Rate, bundles at the start, and how full pods may be with all that has come.
    skus
        SKUs of the bundles, as often as they are ordered.
    stations
        Number of input stations.
    capacity
        Weight that all pods hold.
    stock
        Items on pods at the start.

    Attributes
    ----------
    bundles
        Those drawn so far.
    """

    def __init__(
        self, setting: Setting, skus: Sequence[Sku], stations: int, capacity: float, stock: Mapping[str, int]
    ) -> None:
        self.bundles: list[Bundle] = []
        self._skus = [sku for sku in skus if sku.share]
        self._weights = {sku.name: sku.weight for sku in skus}
        shares = [sku.share for sku in self._skus]
        self._chances = [share / sum(shares) for share in shares]
        self._rng = stream(setting.seed, "imported bundles")
        self._gap_s = 3600 / (setting.bundles_per_h * stations)
        self._initial = setting.initial_bundles
        self._most = setting.overfill * capacity
        self._left = MOST_DRAWN
        self._load = sum(self._weights[sku] * items for sku, items in stock.items())
        self._next_s = 0.0 if self._initial else self._gap()

    def arrived(self, now_s: float) -> Iterable[tuple[str, int]]:
        """Yield SKU and items of the bundles that have come since the last call; others do not come."""
        while self._next_s <= now_s and self._left:
            self._left -= 1
            sku = self._skus[int(self._rng.choice(len(self._skus), p=self._chances))]
            if self._load + sku.bundle * sku.weight <= self._most:
                self._load += sku.bundle * sku.weight
                self.bundles.append((self._next_s, sku.name, sku.bundle))
                yield sku.name, sku.bundle
            self._initial -= 1
            if self._initial <= 0:
                self._next_s += self._gap()

    def ordered(self, lines: Mapping[str, int]) -> None:
        """Take note that the items of an order leave the pods."""
        self._load -= sum(self._weights[sku] * items for sku, items in lines.items())

    def supply(self) -> Supply:
        """Return the bundles drawn so far, and the weights of all SKUs."""
        return Supply(self._weights, max(sku.bundle for sku in self._skus), bundles=tuple(self.bundles))

    def _gap(self) -> float:
        return float(self._rng.exponential(self._gap_s))


def chosen_rules(configuration: Element | None, notes: Notes) -> dict[str, str]:
    """Return the rules that have the names of those in a configuration of controllers."""
    chosen = {"roa": "first-bundle", "rps": "emptiest-pod"}
    for role, key, known in (("roa", "ReplenishmentBatching", ROA), ("rps", "ItemStorage", RPS)):
        inner = None if configuration is None else configuration.part(f"{key}Config")
        if inner is None:
            continue
        kind = (inner.attributes.get("xsi:type") or "").removesuffix(f"{key}Configuration")
        if kind in known:
            chosen[role] = known[kind]
        else:
            notes.add(f"{key} {kind[:40] or 'without a type'}", 1, chosen[role])
    return chosen
