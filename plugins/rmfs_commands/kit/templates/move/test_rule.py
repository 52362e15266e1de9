"""Tests of the rule."""

from rmfs.testing import check_rule, small_world
from rmfs.warehouse import WarehouseView

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule()))


def test_a_wanted_pod_comes_nearer() -> None:
    """To the station; a pod that nobody wants stays."""
    view = WarehouseView(small_world({"1": ["a"]}, {"P": ["a"], "Q": ["b"]}))
    (move,) = TheRule().move_pods(view, 2)
    assert move.pod == view.pods[0].id
    table = view.travel.times_to(view.stations[0].cell, True)
    assert table[move.cell].min() < table[view.pods[0].cell].min()
