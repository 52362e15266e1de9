"""Loading the compiled searches before a run."""

from __future__ import annotations

from rmfs_rules.mip import Integrated
from rmfs_rules.mip.compiled import warm_up
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.steps import proof_of


def test_what_is_loaded_is_what_periods_need(periods, splitting_period):
    """After loading, no period has anything left to compile: its arguments have the types that were loaded."""
    warm_up.load()
    loaded = [search.signatures for search in warm_up.searches()]
    assert all(loaded)
    for period in (*periods[:20], *(splitting_period(seed, 7, 3, 9) for seed in range(3))):
        for model in Model:
            proof_of(period, model, 2, Limits(), None).run()
            proof_of(period, model, 2, Limits(), 1).run()
    assert [search.signatures for search in warm_up.searches()] == loaded


def test_a_rule_loads_them(monkeypatch):
    """Once, and not for the printed form, which has no searches."""
    calls = []
    monkeypatch.setattr(warm_up, "load", lambda: calls.append("loaded"))
    monkeypatch.setattr(warm_up, "searches", lambda: (_Search([]),))
    Integrated(formulation="paper").prepare(None)
    assert calls == []
    Integrated().prepare(None)
    assert calls == ["loaded"]
    monkeypatch.setattr(warm_up, "searches", lambda: (_Search(["a signature"]),))
    Integrated().prepare(None)
    assert calls == ["loaded"]


class _Search:
    """A compiled function, as far as a rule looks at it."""

    def __init__(self, signatures: list[str]) -> None:
        self.signatures = signatures
