"""Decisions by kept scores; those of whole runs are held to a rule without memory in ``test_pair_scores``."""

from __future__ import annotations

import numpy as np

from rmfs_commands.testing import small_world
from rmfs_core.warehouse import Station, WarehouseView
from rmfs_rules.helpers.pair_scores import PairScores


def test_who_takes_is_told_until_nothing_more_fits() -> None:
    """Each assignment but the one that fills the last free place is told before the next is chosen."""
    world = small_world({"0": ["a"], "1": ["a"], "2": ["b"]}, {"p": ["a", "b"]}, capacities=[1, 1])
    view, scores = WarehouseView(world), PairScores()
    told: list[tuple[int, int]] = []

    def take(station: Station, place: int) -> None:
        told.append((station.id, scores.order_at(place)))
        scores.change(1, 1, 5)  # now station 1 has what the youngest order wants

    scores.update(view, np.zeros((2, 2), np.int64))
    assert [(one.station, one.order) for one in scores.assign(view, take)] == [(0, 0), (1, 2)]
    assert told == [(0, 0)]


def test_ties_go_to_the_station_that_is_preferred() -> None:
    """Of the stations with an order's highest score the lowest by ``prefer`` takes it."""
    world = small_world({"0": {"a": 1}}, {"p": ["a"]}, capacities=[4, 4])
    view, scores = WarehouseView(world), PairScores()
    assert scores.decides(view)
    assert [one.station for one in scores.assign(view)] == [0]
    assert [one.station for one in scores.assign(view, prefer=lambda _, station: -station.id)] == [1]
