"""From a scenario to its instance, generated or read, and whether it can be run in that scenario."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path

from rmfs_core.errors import InputError
from rmfs_core.scenario.checks import close_to
from rmfs_core.scenario.model import InstanceSection, Scenario, StationsSection
from rmfs_core.scenario.reading import located
from rmfs_core.world.csv_files import line_of, read_instance
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
        return _made(scenario)


def _made(scenario: Scenario) -> Instance:
    section = scenario.instance
    if section.orders_file is None or section.pods_file is None:
        instance = generate_instance(section, scenario.seed)
    else:
        folder = Path(scenario.folder)
        instance = read_instance(folder / section.orders_file, folder / section.pods_file)
    check_instance(instance, scenario)
    return instance


Place = Callable[..., str]
"""Where an order, or its line of a SKU, comes from."""


def check_instance(instance: Instance, scenario: Scenario) -> None:
    """Raise InputError for the first order that could never be picked, or a pod at a station that does not exist."""
    section = scenario.instance
    place = partial(_place, scenario)
    _check_stock(instance, place)
    if scenario.rules.poa_pps is None:  # a joint rule may split an order that is larger than any station
        _check_sizes(instance, scenario.stations, place, generated=section.orders_file is None)
    _check_pods_at_stations(instance, section)


def _place(scenario: Scenario, order: str, sku: str | None = None) -> str:
    if scenario.instance.orders_file is None:
        return "instance.orders"
    file = Path(scenario.folder) / scenario.instance.orders_file
    return f"{file}, line {line_of(file, order, sku)}"


def _check_stock(instance: Instance, place: Place) -> None:
    stock: dict[int, int | None] = {}
    for pod in instance.pods:
        for sku, items in pod.contents:
            held = stock.get(sku, 0)
            stock[sku] = None if items is None or held is None else held + items
    wanted: Counter[int] = Counter()
    for order in instance.orders:
        for sku, quantity in order.lines:
            wanted[sku] += quantity
            name = instance.skus[sku]
            held = stock.get(sku, 0)
            if held == 0:
                raise InputError(place(order.name, name), f"order {order.name} wants SKU {name}, which is on no pod")
            if held is not None and wanted[sku] > held:
                raise InputError(
                    place(order.name, name),
                    f"the orders up to {order.name} want {wanted[sku]} items of SKU {name}, "
                    f"but all pods together hold {held}",
                )


def _check_sizes(instance: Instance, stations: StationsSection, place: Place, *, generated: bool) -> None:
    if stations.order_capacity is not None:
        return  # then the number of orders counts, whatever their size
    capacity = stations.item_capacity
    largest = max(capacity) if isinstance(capacity, tuple) else capacity
    for order in instance.orders:
        if order.items > largest:
            mend = "; expected a smaller `instance.max_lines` or a larger `stations.item_capacity`" if generated else ""
            raise InputError(
                place(order.name),
                f"order {order.name} has {order.items} items, more than any station takes at a time ({largest}){mend}",
            )


def _check_pods_at_stations(instance: Instance, section: InstanceSection) -> None:
    pods = {pod.name for pod in instance.pods}
    standing_at: dict[str, str] = {}
    for station, names in section.pods_at_stations.items():
        place = f"instance.pods_at_stations.{station}"
        for name in names:
            if name not in pods:
                raise InputError(place, f"there is no pod {name} with contents{close_to(name, pods)}")
            if name in standing_at:
                raise InputError(place, f"pod {name} already stands at station {standing_at[name]}")
            standing_at[name] = station
