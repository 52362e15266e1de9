"""Order tables as warehouses have them, drawn: customers who come back to what they bought, and quantities.

No table of a real company is in it, and no name: SKUs and orders are numbers. What is drawn follows what such tables
have in common: few SKUs with most lines, baskets of a customer that are alike, and more items of a line where the
customer is a shop.
"""

from __future__ import annotations

import numpy as np

from rmfs_commands.instances.generator import draw_arrivals
from rmfs_core.errors import InputError
from rmfs_core.randomness import stream
from rmfs_core.scenario.model import InstanceSection
from rmfs_core.world import Instance, OrderData, PodData

_TASTE = 40
"""SKUs that a customer comes back to."""
_LONGEST = 30


def order_table(
    section: InstanceSection, seed: int, customers: int = 100, basket: float = 3.0, quantity: float = 1.5
) -> Instance:
    """Draw an order table, and pods slotted by what is asked for.

    Each customer has `_TASTE` SKUs, drawn by Zipf's law; customers differ in how often they order (log-normal). An
    order has 1 + Poisson lines, four in five of them of the customer's SKUs, and each line 1 + geometric items. Pods
    are dealt SKUs in the order of demand, so that each has some of the most wanted; those with most demand are on more
    than one.

    Parameters
    ----------
    section
        Sizes, and when orders arrive.
    seed
        The scenario's seed.
    customers
        Their number.
    basket, quantity
        Lines per order and items per line, means, at least 1.

    Raises
    ------
    InputError
        When the stock of a SKU is too little, or a parameter too small.
    """
    if customers < 1 or not (1 <= basket <= _LONGEST and 1 <= quantity <= 1000) or not section.items_per_sku:
        needs = f"`customers` >= 1, `basket` from 1 to {_LONGEST}, `quantity` from 1 to 1000, and `items_per_sku`"
        raise InputError("instance.parameters", f"expected {needs}")
    rng = stream(seed, "order table")
    weights = 1 / (np.arange(section.skus) + 5.0)
    weights /= weights.sum()
    tastes = [rng.choice(section.skus, min(_TASTE, section.skus), p=weights) for _ in range(customers)]
    habit = rng.lognormal(0, 1, customers)
    entries = section.pods * section.skus_per_pod
    if entries < section.skus:
        raise InputError("instance", f"found {section.skus} SKUs, and pods for {entries}; expected more `pods`")
    copies = 1 + rng.multinomial(entries - section.skus, weights)
    dealt = np.repeat(np.arange(section.skus), copies)
    held = [sorted({*dealt[pod :: section.pods].tolist()}) for pod in range(section.pods)]
    left = np.bincount(np.concatenate(held), minlength=section.skus) * section.items_per_sku
    arrivals = draw_arrivals(section, section.orders, stream(seed, "arrivals"))
    orders = []
    for number, tick in enumerate(arrivals, start=1):
        taste = tastes[rng.choice(customers, p=habit / habit.sum())]
        wanted: dict[int, int] = {}
        for _ in range(min(1 + rng.poisson(basket - 1), _LONGEST)):
            sku = int(rng.choice(taste) if rng.random() < 0.8 else rng.choice(section.skus, p=weights))
            wanted.setdefault(sku, int(min(rng.geometric(1 / quantity), 4 * quantity)))
        for sku, items in wanted.items():
            left[sku] -= items
            if left[sku] < 0:
                raise InputError("instance.items_per_sku", f"the pods have too few items of SKU {sku + 1}")
        orders.append(OrderData(str(number), arrival_tick=tick, lines=tuple(wanted.items())))
    contents = [tuple((sku, section.items_per_sku) for sku in skus) for skus in held]
    pods = tuple(PodData(str(i), each) for i, each in enumerate(contents, start=1))
    return Instance(tuple(str(i + 1) for i in range(section.skus)), tuple(orders), pods)
