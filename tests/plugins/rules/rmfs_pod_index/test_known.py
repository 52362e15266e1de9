"""What is remembered of a run makes no decision another one."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

import pytest
from attrs import evolve
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rmfs_core import run
from rmfs_pod_index import PodIndex

RULES = ("rules.poa=", "rules.pps=", "rules.poa_pps=pod-index", "rules.pp=free-flow", "instance.orders=25")

WORLDS = {
    "never run out": (),
    "finite stock": ("instance.items_per_sku=20",),
    "order capacity": ("instance.items_per_sku=20", "stations.order_capacity=3"),
    "due times": ("instance.due.allowance_s=900",),
    "few places": ("stations.item_capacity=3",),
    "filtered": ("instance.items_per_sku=20", 'rules.filters=[{rule="most-covered",n=4}]'),
    "packing stations": ("rules.poa_pps.packing_capacity=3",),
}


def forgetful(hook: Callable[..., Any]) -> Callable[..., Any]:
    """A hook that is called on a rule of its own each time, which has no memory and scores everything anew."""

    @wraps(hook)
    def called(rule: PodIndex, *arguments: Any) -> Any:
        return hook(evolve(rule), *arguments)

    return called


@pytest.mark.parametrize("world", WORLDS)
@settings(max_examples=4, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    seed=st.integers(1, 10_000),
    rate=st.sampled_from([60, 400, 100_000]),
    urge_s=st.sampled_from([0, 30, 300]),
    most_pods=st.integers(1, 3),
)
def test_memory_makes_no_difference(
    world: str, seed: int, rate: int, urge_s: int, most_pods: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is left out, kept, or brought up to date: a rule that scores everything anew decides the same."""
    parameters = (f"rules.poa_pps.urge_s={urge_s}", f"rules.poa_pps.most_pods={most_pods}")
    overrides = [*RULES, *parameters, f"instance.arrivals.orders_per_hour={rate}", *WORLDS[world]]
    quick = run("examples/poisson", seed=seed, overrides=overrides)
    with monkeypatch.context() as patch:
        for name in ("assign_orders_and_pods", "wake_at"):
            patch.setattr(PodIndex, name, forgetful(getattr(PodIndex, name)))
        full = run("examples/poisson", seed=seed, overrides=overrides)
    assert (quick.orders, quick.visits) == (full.orders, full.visits)
