"""Tiny warehouses with a picking station in the east (id 0) and a replenishment station in the west (id 1)."""

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from attrs import evolve

from rmfs_commands.layouts import block_map, parse_map
from rmfs_commands.testing import small_instance
from rmfs_core.motion import Motion
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario, scenario_from_dict
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.simulation.engine import Simulation
from rmfs_core.warehouse import Robot, Station, Warehouse
from rmfs_core.warehouse.parts import UNLIMITED
from rmfs_core.world import NORTH, Instance, Layout, check_layout
from rmfs_core.world.travel import travel_on
from told import ToldRun

RULES = {"poa": "pod-match", "pps": "demand", "roa": "first-bundle", "rps": "emptiest-pod", "pp": "free-flow"}
Wanted = Mapping[str, Sequence[str] | Mapping[str, int]]


@cache
def two_sided_layout() -> Layout:
    """Return three rows of blocks between the two stations, whose queues have three cells."""
    section = LayoutSection(block_rows=3, block_columns=2, hall_width=1, stations_east=1, replenishment_west=1)
    layout = parse_map(block_map(section, 3), "two-sided layout")
    check_layout(layout, "two-sided layout")
    return layout


def replenished_world(
    orders: Wanted,
    pods: Wanted,
    *,
    pod_capacity: int = UNLIMITED,
    bundle_capacity: int = 2,
    sizes: Sequence[int] = (),
    wait_for_stock: bool = False,
) -> Warehouse:
    """Return a warehouse at time 0 with all orders in the backlog, unless they wait for stock, and no bundles yet."""
    layout = two_sided_layout()
    locations = layout.storage_locations
    instance = evolve(small_instance(orders, pods), sizes=tuple(sizes), restocked=True)
    stations = [
        Station(0, layout.stations[0], 15, False, 3),
        Station(1, layout.stations[1], 0, False, 3, bundle_capacity=bundle_capacity, picks=False),
    ]
    robots = [Robot(i, locations[-1 - i], NORTH) for i in range(2)]
    places, travel = locations[: len(instance.pods)], travel_on(layout, Motion())
    warehouse = Warehouse(
        instance, travel, stations, robots, places, pod_capacity=pod_capacity, wait_for_stock=wait_for_stock
    )
    for order in warehouse.orders:
        warehouse.order_arrives(order)
    return warehouse


def scenario_of(supply: Mapping[str, object], *, robots: int = 2, **sections: Mapping[str, object]) -> Scenario:
    """Return a scenario with a replenishment process; further sections are merged with what is here."""
    tables: dict[str, dict[str, object]] = {
        "rules": dict(RULES),
        "instance": {"replenishment": supply},
        "layout": {"pod_fill": 0.05, "block_rows": 3, "block_columns": 2, "hall_width": 1, "stations_east": 1},
        "stations": {"queue_length": 3},
        "robots": {"count": robots},
    }
    tables["layout"]["replenishment_west"] = 1
    for name, section in sections.items():
        tables[name] = tables.get(name, {}) | dict(section)
    return scenario_from_dict(tables)


def prepared(scenario: Scenario, instance: Instance, out: Path | None = None, *observers: object) -> ToldRun:
    rules = RuleSet.load(scenario.rules, ".")
    for observer in observers:
        rules.register_observer(observer)
    run = ToldRun(Simulation(scenario, evolve(instance, restocked=True), two_sided_layout(), rules, out))
    rules.register_observer(run)
    return run
