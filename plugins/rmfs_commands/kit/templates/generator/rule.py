"""Generator ``the-rule`` of orders, SKUs and pods."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rmfs import stream, to_ticks
from rmfs.world import Instance, OrderData, PodData

if TYPE_CHECKING:
    from rmfs import InstanceSection


def the_rule(section: InstanceSection, seed: int, *, pace_s: float = 60.0) -> Instance:
    """Make orders of one line that come at a pace; each pod holds some SKUs without end.

    Parameters
    ----------
    section
        The section ``instance`` of the scenario: ``orders``, ``skus``, ``pods`` and ``skus_per_pod`` say how many.
    seed
        The same seed makes the same instance: numbers are drawn from `stream`, under a purpose of its own.
    pace_s
        Time from one order to the next (s); ``instance.parameters`` of a scenario sets it.
    """
    rng = stream(seed, "the-rule")
    pods = [rng.choice(section.skus, section.skus_per_pod, replace=False).tolist() for _ in range(section.pods)]
    stocked = sorted({sku for pod in pods for sku in pod})  # a SKU that is on no pod cannot be ordered
    wanted = rng.choice(stocked, section.orders).tolist()
    return Instance(
        skus=tuple(str(sku + 1) for sku in range(section.skus)),
        orders=tuple(
            OrderData(str(i + 1), arrival_tick=to_ticks(pace_s * i), lines=((sku, 1),)) for i, sku in enumerate(wanted)
        ),
        pods=tuple(PodData(str(i + 1), tuple((sku, None) for sku in pod)) for i, pod in enumerate(pods)),
    )
