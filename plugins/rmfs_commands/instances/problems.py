"""Whether an instance can be run in a scenario, with the lines of the files that it is from.

It is the entry point ``problems`` of the group ``rmfs.formats``.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any

from rmfs_commands.instances.csv_files import MOST_ITEMS_OF_LINE, line_of
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import MOST_ITEMS, MOST_PODS, InstanceSection, Replenishment, Scenario
from rmfs_core.wording import did_you_mean, first_few, shown_short
from rmfs_core.world import Instance, OrderData, PodData


def instance_problems(instance: Instance, scenario: Scenario) -> Iterator[InputError]:
    """Yield what keeps an instance from being run: short SKUs, orders that are too large, pods at stations."""
    given = scenario.instance.replenishment
    if given is None or given.process in ("none", "file"):  # any other brings whatever is wanted
        yield from _short_skus(instance, scenario)
    yield from _too_large_for_pods(instance, scenario.instance.pod_capacity)
    yield from _too_many_bundles(instance, scenario.instance)
    if instance.restocked and scenario.rules.wait_for_stock is not False:
        yield from _too_large_lines(instance, scenario)
    if scenario.rules.poa_pps is None:  # a joint rule may split an order that is larger than any station
        yield from oversize_orders(instance, scenario)
    yield from _pods_at_stations(instance, scenario.instance)


def _place(scenario: Scenario, order: str, sku: str | None = None) -> str:
    """Return where an order, or its line of a SKU, comes from."""
    if scenario.instance.orders_file is None:
        return "instance.orders"
    if scenario.instance.scale is not None:
        return "instance.scale"
    file = Path(scenario.folder) / scenario.instance.orders_file
    return f"{file}, line {line_of(file, order, sku)}"


def _short_skus(instance: Instance, scenario: Scenario) -> Iterator[InputError]:
    stock = defaultdict[int, float](int)  # infinite where a pod has enough
    for pod in instance.pods:
        for sku, items in pod.contents:
            stock[sku] += math.inf if items is None else items
    for bundle in instance.bundles:
        stock[bundle.sku] += bundle.items
    wanted: Counter[int] = Counter()
    short: dict[int, str] = {}
    for order in instance.orders:
        for sku, quantity in order.lines:
            wanted[sku] += quantity
            if wanted[sku] > stock[sku]:
                short.setdefault(sku, order.name)
    if short:
        sku, order_name = next(iter(short.items()))
        name = instance.skus[sku]
        problem = f"order {order_name} wants SKU {name}, which is on no pod"
        if len(short) > 1 or stock[sku]:
            named = first_few([_shortage(instance.skus[one], wanted[one], stock[one]) for one in short])
            all_there = "pods and bundles" if instance.bundles else "pods"
            remedy = "on pods or in bundles" if instance.bundles else "on pods, or `instance.replenishment`"
            problem = f"from order {order_name} on, the orders want more than all {all_there} hold: {named}"
            problem += f"; expected more items {remedy}"
        if scenario.instance.orders_file is not None:
            how = "--in-stock` leaves out what stock cannot serve"
            how = how if scenario.instance.scale is None else "--items` puts more items of each SKU on a pod"
            problem += f" (`rmfs convert orders {how})"
        yield InputError(_place(scenario, order_name, name), problem)


def _too_large_for_pods(instance: Instance, capacity: int | None) -> Iterator[InputError]:
    """Yield problems of sizes: contents of pods and bundles that fit on no pod."""
    if capacity is None:
        return
    sizes = instance.sizes or (1,) * len(instance.skus)
    held = [(sum((items or 0) * sizes[sku] for sku, items in pod.contents), pod) for pod in instance.pods]
    needs = [(used, f"what pod {pod.name} holds") for used, pod in held]
    needs += [(one.items * sizes[one.sku], f"the size of bundle {one.name}") for one in instance.bundles]
    needs.append((max(sizes, default=0), "the size of the largest item"))
    if large := [(used, what) for used, what in needs if used > capacity]:
        least, what = max(large, key=itemgetter(0))
        more = f" (the largest of {len(large)} that are too large)" if len(large) > 1 else ""
        yield InputError("instance.pod_capacity", f"found {capacity}; expected at least {least}, {what}{more}")


def _too_large_lines(instance: Instance, scenario: Scenario) -> Iterator[InputError]:
    """Yield the first line for which an order waits forever: all pods together have no space for its items."""
    capacity, sizes = scenario.instance.pod_capacity, instance.sizes or (1,) * len(instance.skus)
    if capacity is None or any(items is None for pod in instance.pods for _, items in pod.contents):
        return
    for order in instance.orders:
        for sku, quantity in order.lines:
            if quantity > (most := len(instance.pods) * (capacity // sizes[sku])):
                wanted = f"order {order.name} wants {quantity:,} items of SKU {instance.skus[sku]}"
                remedy = "a smaller line, more pods or a larger `instance.pod_capacity`"
                problem = f"{wanted}, and all pods together have space for {most:,}; expected {remedy}"
                yield InputError(_place(scenario, order.name, instance.skus[sku]), problem)
                return


def _too_many_bundles(instance: Instance, section: InstanceSection) -> Iterator[InputError]:
    """Yield what orders more bundles at once than a run can follow."""
    largest, room = (section.replenishment or Replenishment()).bundle_items, section.pod_capacity
    ordered = 0.0
    for (_, up_to), size in zip(instance.levels, instance.sizes or (1,) * len(instance.skus), strict=False):
        ordered += up_to / max(min(largest or up_to, (room or up_to * size) // size), 1)
    if ordered > MOST_PODS:
        expected = f"expected levels of at most {MOST_PODS:,}: fewer items, or larger bundles"
        yield InputError("instance.replenishment", f"found levels of about {ordered:,.0f} bundles in all; {expected}")


def _shortage(sku: str, wanted: int, held: float) -> str:
    return f"SKU {sku} ({f'{wanted} wanted, {held} there' if held else 'on no pod'})"


def oversize_orders(instance: Instance, scenario: Scenario) -> Iterator[InputError]:
    """Yield what is wrong with orders that are larger than any station, where the scenario refuses them."""
    stations, generated = scenario.stations, scenario.instance.orders_file is None
    if stations.order_capacity is not None or stations.oversize != "refuse":
        return  # with order capacity, the number of orders counts, whatever their size
    capacity = stations.item_capacity
    largest = max(capacity) if isinstance(capacity, tuple) else capacity
    large = [order for order in instance.orders if order.items > largest]
    if large:
        smaller = "a smaller `instance.max_lines`, " if generated else ""
        mend = f'; expected {smaller}a larger `stations.item_capacity` or `stations.oversize` = "alone"'
        sizes = first_few([f"order {order.name} has {order.items} items" for order in large])
        problem = f"{sizes}, more than any station takes at a time ({largest}){mend}"
        yield InputError(_place(scenario, large[0].name), problem)


def _pods_at_stations(instance: Instance, section: InstanceSection) -> Iterator[InputError]:
    pods = {pod.name for pod in instance.pods}
    standing_at: dict[str, str] = {}
    for station, names in section.pods_at_stations.items():
        place = f"instance.pods_at_stations.{station}"
        for name in names:
            if name not in pods:
                yield InputError(place, f"there is no pod {name} with contents{did_you_mean(name, pods)}")
            if name in standing_at:
                yield InputError(place, f"pod {name} already stands at station {standing_at[name]}")
            standing_at[name] = station


def malformed(instance: Instance) -> Iterator[str]:
    """Yield what is not as `Instance` has it."""
    for what, kind in (("skus", str), ("orders", OrderData), ("pods", PodData)):
        many = getattr(instance, what)
        if not isinstance(many, tuple) or not all(isinstance(one, kind) for one in many):
            yield f"`{what}` {shown_short(many)}; expected a tuple of {kind.__name__}"
            return
    named = {"SKU": instance.skus, "order": [one.name for one in instance.orders]}
    named["pod"] = [one.name for one in instance.pods]
    for what, names in named.items():
        if strange := [name for name in names if not isinstance(name, str)]:
            yield f"{what} {shown_short(strange[0])}; expected a name, a str"
        elif len(set(names)) < len(names):
            yield f"two or more {what}s {Counter(names).most_common(1)[0][0]}; expected each name once"
    yield from _malformed_orders(instance)
    for pod in instance.pods:
        if not _fit(pod.contents, instance, None):
            expected = f"(SKU id, items or None) as int of each SKU, each once, and at most {MOST_ITEMS:,} items"
            yield f"`contents` {shown_short(pod.contents)} of pod {pod.name}; expected {expected}"


def _malformed_orders(instance: Instance) -> Iterator[str]:
    latest = 0
    for order in instance.orders:
        if not _is_whole(order.arrival_tick, latest):
            expected = f"an int of at least {latest}, as orders are in order of arrival, and at most 2^53"
            yield f"`arrival_tick` {shown_short(order.arrival_tick)} of order {order.name}; expected {expected}"
            return
        latest = order.arrival_tick
        if order.cancelled_tick is not None and not _is_whole(order.cancelled_tick, latest):
            expected = f"None or an int of at least {latest}, when it arrives"
            yield f"`cancelled_tick` {shown_short(order.cancelled_tick)} of order {order.name}; expected {expected}"
        if order.due_tick is not None and not _is_whole(order.due_tick, -LATEST):
            yield f"`due_tick` {shown_short(order.due_tick)} of order {order.name}; expected None or an int"
        if not _is_whole(order.priority, -LATEST):
            yield f"`priority` {shown_short(order.priority)} of order {order.name}; expected an int"
        if not order.lines or not _fit(order.lines, instance, 1):
            most = f"{MOST_ITEMS_OF_LINE:,}"
            expected = f"(SKU id, quantity) as int of at least one SKU, each once, and quantities from 1 to {most}"
            yield f"`lines` {shown_short(order.lines)} of order {order.name}; expected {expected}"


LATEST = 1 << 53
"""No tick is later, as no number of a table can tell it from the next."""


def _is_whole(value: object, least: int, most: int = LATEST) -> bool:
    return isinstance(value, int) and least <= value <= most


def _fit(entries: Any, instance: Instance, least: int | None) -> bool:
    """Whether entries are a SKU id and a number each, no SKU twice; ``least`` None: also no number, for no end."""
    try:
        most = MOST_ITEMS if least is None else MOST_ITEMS_OF_LINE
        sizes = [(sku, least is None and number is None, number) for sku, number in entries]
        ids = [sku for sku, endless, number in sizes if endless or _is_whole(number, least or 0, most)]
        return len(set(ids)) == len(entries) and all(_is_whole(sku, 0) and sku < len(instance.skus) for sku in ids)
    except (TypeError, ValueError):
        return False
