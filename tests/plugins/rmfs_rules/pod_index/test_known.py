"""What is remembered of a run makes no decision another one."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np
import pytest
from attrs import evolve
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rmfs_core import run
from rmfs_rules.pod_index import PodIndex
from rmfs_rules.pod_index.deciding import Deciding
from rmfs_rules.pod_index.known import Known
from rmfs_rules.pod_index.period import WANTED, Period

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


def whatever(examples: int) -> Callable[[Any], Any]:
    """Worlds of each kind, drawn."""

    def tried(test: Any) -> Any:
        drawn = given(
            seed=st.integers(1, 10_000),
            rate=st.sampled_from([60, 400, 100_000]),
            urge_s=st.sampled_from([0, 30, 300]),
            most_pods=st.integers(1, 3),
        )(test)
        kept = settings(
            max_examples=examples, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
        )
        return pytest.mark.parametrize("world", WORLDS)(kept(drawn))

    return tried


@whatever(4)
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


def told_of(period: Period) -> dict[str, list[Any]]:
    """What an account says, without what is left over from earlier periods."""
    lines, pods = period.lines[period.lines["untaken"]], period.pods
    orders = np.unique(lines["order"])
    return {
        "lines": lines.tolist(),
        "orders": period.orders[["arrival", "begin", "end", "open_items", "due_s", "left"]][orders].tolist(),
        "skus": period.skus[["head", "tail", "number", "arrivals"]].tolist(),
        "wanted": period.wanted[: period.numbers[WANTED]].tolist(),
        "free items": [period.entries["free"].tolist(), period.holders.tolist()],
        "ages": period.ages.tolist(),
        "pods": [pods[["last", "free"]].tolist(), pods["cell"][pods["free"]].tolist(), pods["movable"].tolist()],
        "available": period.available.tolist(),
    }


@whatever(2)
def test_what_is_kept_is_what_is_there(
    world: str, seed: int, rate: int, urge_s: int, most_pods: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After each decision the account is one that is made anew, and so is the decision."""
    decision, decided = Deciding.decision, []

    def compared(kept: Deciding) -> Any:
        made = decision(kept)
        known = Known(evolve(kept.rule), kept.warehouse)
        known.hear(kept.warehouse)
        again = decision(Deciding(known, kept.warehouse))
        assert made == again
        assert told_of(kept.known.account.period) == told_of(known.account.period)
        decided.append(made)
        return made

    parameters = (f"rules.poa_pps.urge_s={urge_s}", f"rules.poa_pps.most_pods={most_pods}")
    with monkeypatch.context() as patch:
        patch.setattr(Deciding, "decision", compared)
        overrides = [*RULES, *parameters, f"instance.arrivals.orders_per_hour={rate}", *WORLDS[world]]
        run("examples/poisson", seed=seed, overrides=overrides)
    assert decided
