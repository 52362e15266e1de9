"""What is remembered of a run makes no decision another one."""

from __future__ import annotations

from typing import Any

import pytest

from rmfs_core import run
from rmfs_pod_index.known import Known

RULES = ("rules.poa=", "rules.pps=", "rules.poa_pps=pod-index", "rules.pp=free-flow")


@pytest.mark.parametrize(
    "settings",
    [
        (),
        ("instance.items_per_sku=20",),
        ("instance.items_per_sku=20", "stations.order_capacity=3"),
        ("instance.due.allowance_s=900", "instance.arrivals.orders_per_hour=120"),
    ],
    ids=["never run out", "finite stock", "order capacity", "due times"],
)
def test_what_is_skipped_would_have_decided_nothing(settings: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """Asked in full each time, the rule decides as it does with the calls left out that can bring nothing."""
    asked, skipped = Known.nothing_to_do, []

    def noted(known: Known, *arguments: Any) -> bool:
        skipped.append(asked(known, *arguments))
        return skipped[-1]

    monkeypatch.setattr(Known, "nothing_to_do", noted)
    quick = run("examples/poisson", overrides=[*RULES, *settings])
    monkeypatch.setattr(Known, "nothing_to_do", lambda *_: False)
    full = run("examples/poisson", overrides=[*RULES, *settings])
    assert any(skipped)
    assert (quick.orders, quick.visits) == (full.orders, full.visits)
