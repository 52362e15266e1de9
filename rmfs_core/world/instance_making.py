"""From a scenario to its instance, generated or read, and whether it can be run in that scenario."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from attrs import evolve

from rmfs_core.errors import InputError
from rmfs_core.scenario.model import InstanceSection, Scenario
from rmfs_core.scenario.reading import located
from rmfs_core.wording import did_you_mean, first_few
from rmfs_core.world.csv_files import Calendar, Wrong, line_of, read_instance, read_profile, refuse
from rmfs_core.world.generator import generate_instance
from rmfs_core.world.instance import Instance


def make_instance(scenario: Scenario) -> Instance:
    """Generate the instance of a scenario, or read it from the scenario's CSV files.

    Raises
    ------
    InputError
        When a file is wrong, or the instance cannot be run in this scenario: an order that no station or no stock can
        serve, an unknown pod at a station.
    """
    with located(scenario):
        instance = unchecked_instance(scenario)
        for problem in instance_problems(instance, scenario):
            raise problem
    return instance


def unchecked_instance(scenario: Scenario, wrong: Wrong = refuse) -> Instance:
    """Generate or read the instance, as `make_instance` does, without asking whether it can be run.

    ``wrong`` is called with each mistake in its files, as `read_instance` does.
    """
    section, folder = scenario.instance, Path(scenario.folder)
    Calendar(section.start).zero(0)  # whether or not it is used, what is wrong with it is said
    if section.orders_file is None or section.pods_file is None:
        if isinstance(profile := section.arrivals.profile, str):
            section = evolve(section, arrivals=evolve(section.arrivals, profile=read_profile(folder / profile)))
        return generate_instance(section, scenario.seed)
    orders, pods = folder / section.orders_file, folder / section.pods_file
    for key, file in (("orders_file", orders), ("pods_file", pods)):
        if not file.exists():
            raise InputError(f"instance.{key}", f"there is no file {file}")
    return read_instance(orders, pods, section.start, wrong)


def instance_problems(instance: Instance, scenario: Scenario) -> Iterator[InputError]:
    """Yield what keeps an instance from being run: short SKUs, orders that are too large, pods at stations."""
    yield from _short_skus(instance, scenario)
    if scenario.rules.poa_pps is None:  # a joint rule may split an order that is larger than any station
        yield from oversize_orders(instance, scenario)
    yield from _pods_at_stations(instance, scenario.instance)


def _place(scenario: Scenario, order: str, sku: str | None = None) -> str:
    """Return where an order, or its line of a SKU, comes from."""
    if scenario.instance.orders_file is None:
        return "instance.orders"
    file = Path(scenario.folder) / scenario.instance.orders_file
    return f"{file}, line {line_of(file, order, sku)}"


def _short_skus(instance: Instance, scenario: Scenario) -> Iterator[InputError]:
    stock: dict[int, int | None] = {}
    for pod in instance.pods:
        for sku, items in pod.contents:
            held = stock.get(sku, 0)
            stock[sku] = None if items is None or held is None else held + items
    wanted: Counter[int] = Counter()
    short: dict[int, str] = {}
    for order in instance.orders:
        for sku, quantity in order.lines:
            wanted[sku] += quantity
            held = stock.get(sku, 0)
            if held is not None and wanted[sku] > held:
                short.setdefault(sku, order.name)
    if short:
        sku, order_name = next(iter(short.items()))
        name = instance.skus[sku]
        problem = f"order {order_name} wants SKU {name}, which is on no pod"
        if len(short) > 1 or stock.get(sku):
            named = first_few([_shortage(instance.skus[one], wanted[one], stock.get(one)) for one in short])
            problem = f"from order {order_name} on, the orders want more than all pods hold: {named}"
        yield InputError(_place(scenario, order_name, name), problem)


def _shortage(sku: str, wanted: int, held: int | None) -> str:
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
