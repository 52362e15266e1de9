"""Rules that choose where pods are stored, and which are moved; test_oracles.py has them on random worlds."""

from typing import Any

import pytest

from cases import cases
from rmfs_commands.testing import check_rule, small_instance, small_layout, small_world
from rmfs_core.motion import Motion
from rmfs_core.warehouse import Station, Warehouse, WarehouseView
from rmfs_core.world.travel import travel_on
from rmfs_rules.classes import Cache, Utility
from rmfs_rules.classes.locations import Locations


def test_places_with_empty_pods_are_none() -> None:
    layout = small_layout(1)
    locations = layout.storage_locations
    station = Station(0, layout.stations[0], 9, False, 3)
    instance = small_instance({}, {"p": ["a"]})
    world = Warehouse(instance, travel_on(layout, Motion()), [station], [], locations[:1], blocked=locations[1:5])
    assert not {*Locations.of(WarehouseView(world)).cells.tolist()} & {*locations[1:5]}


@cases(
    "rule wrong",
    (Cache, {"share": 1.5}),
    (Cache, {"threshold": -1}),
    (Utility, {"corridor": 0}),
    (Utility, {"buffer": -0.1}),
    (Utility, {"weight_speed": -1}),
)
def test_wrong_parameters_are_refused(rule: type[Any], wrong: dict[str, float]) -> None:
    (name,) = wrong
    with pytest.raises(ValueError, match=f"'{name}' must be"):
        rule(**wrong)


def test_a_large_cache_conforms() -> None:
    assert check_rule(Cache(share=1.0, threshold=0.1)).findings == ()


@pytest.mark.parametrize("rule", [Utility(retry_s=60), Cache(retry_s=60)])
def test_it_looks_again_after_a_pause(rule: Utility | Cache) -> None:
    warehouse = small_world({}, {str(i): ["a"] for i in range(len(small_layout().storage_locations))})
    view = WarehouseView(warehouse)
    assert rule.wake_at(view) is None
    assert rule.move_pods(view, 2) == []
    assert rule.wake_at(view) == 60
    warehouse.advance(60_000)
    assert rule.wake_at(view) is None
    assert WarehouseView(small_world({}, {"p": ["a"]})) is not view
    assert rule.wake_at(WarehouseView(small_world({}, {"p": ["a"]}))) is None, "another run"
