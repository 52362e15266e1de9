"""The compiled choice of pods against the plain one."""

from __future__ import annotations

import numpy as np
import pytest

import plain_joint
from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.joint.choosing import Period

SKUS = "abcdefgh"


@pytest.mark.parametrize("seed", range(60))
def test_few_pods(seed: int) -> None:
    """They bring most, then are bound nowhere, have most worth, are nearest; those that others make needless stay."""
    rng = np.random.default_rng(seed)
    items = (lambda: int(rng.integers(1, 4))) if seed % 2 else (lambda: None)
    orders = {
        str(i): {sku: int(rng.integers(1, 3)) for sku in rng.choice([*SKUS], rng.integers(1, 4), False).tolist()}
        for i in range(9)
    }
    pods = {f"p{i}": {sku: items() for sku in rng.choice([*SKUS], 4, False).tolist()} for i in range(12)}
    pods["rest"] = dict.fromkeys(SKUS, 18 if seed % 2 else None)
    world = small_world(orders, pods, capacities=[9, 9, 9])  # type: ignore[arg-type]
    for station in world.stations:
        for pod in rng.choice(12, rng.integers(3), False).tolist():
            world.bind(world.pods[pod], station)
    view = WarehouseView(world)
    period = Period(view, None)
    for number in (0, 3, 9):
        chosen = [(place, int(rng.integers(3))) for place in rng.choice(9, number, False).tolist()]
        for by_worth in (False, True):
            sent = period.pods_for(chosen, by_worth=by_worth)
            worth = plain_joint.wanted_on(view) if by_worth else None
            assert sent == [*plain_joint.pods_for(view, chosen, worth)]
        for trips in (sent, sent[1:]):
            assert period.serve(chosen, trips) == plain_joint.serve(view, chosen, trips)
