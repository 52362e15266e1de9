"""Generator ``the-rule`` of orders, SKUs and pods."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rmfs import stream, to_ticks
from rmfs.world import Instance, OrderData, PodData

if TYPE_CHECKING:
    from rmfs import InstanceSection


def the_rule(section: InstanceSection, seed: int) -> Instance:
    """Make orders of one line that come one a minute; each pod holds some SKUs without end.

    The section of the scenario says how many: ``orders``, ``skus``, ``pods``, ``skus_per_pod``. The same seed makes the
    same instance: numbers are drawn from `stream`, under a purpose of its own.
    """
    rng = stream(seed, "the-rule")
    pods = [rng.choice(section.skus, section.skus_per_pod, replace=False).tolist() for _ in range(section.pods)]
    stocked = sorted({sku for pod in pods for sku in pod})  # a SKU that is on no pod cannot be ordered
    wanted = rng.choice(stocked, section.orders).tolist()
    return Instance(
        skus=tuple(str(sku + 1) for sku in range(section.skus)),
        orders=tuple(OrderData(str(i + 1), to_ticks(60.0 * i), ((sku, 1),)) for i, sku in enumerate(wanted)),
        pods=tuple(PodData(str(i + 1), tuple((sku, None) for sku in pod)) for i, pod in enumerate(pods)),
    )
