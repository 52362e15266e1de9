"""Tests of the rule."""

from rmfs import PodTrip
from rmfs.helpers import ticks_to_station
from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_what_an_item_is_worth_decides() -> None:
    """Three pods hold SKU a. Where items count for nothing the nearest is sent, else the one that holds SKU b, too."""
    world = small_world({"O": ["a", "b"]}, {"P": ["a"], "Q": ["a", "b"], "R": ["a"]})
    station = world.stations[0]
    world.assign(world.orders[0], station, [0, 1], 1)
    view = WarehouseView(world)
    nearest = min(view.pods, key=lambda pod: ticks_to_station(view, pod, station))
    assert nearest.name != "Q"
    assert TheRule(seconds_per_item=0).select_pods(view, max_fetches=1) == [PodTrip(nearest.id, station.id)]
    assert TheRule(seconds_per_item=1000).select_pods(view, max_fetches=1) == [PodTrip(1, station.id)]


def test_what_a_pod_serves_counts_no_more_for_the_next() -> None:
    """The first pod has SKUs a and b, so that c alone is left: R goes next, though Q holds a and b, too."""
    world = small_world({"O": ["a", "b", "c"]}, {"P": ["a", "b"], "Q": ["a", "b"], "R": ["c"]})
    station = world.stations[0]
    world.assign(world.orders[0], station, [0, 1, 2], 1)
    first, second = TheRule(seconds_per_item=1000).select_pods(WarehouseView(world), max_fetches=2)
    assert first.pod in (0, 1)
    assert second == PodTrip(2, station.id)
