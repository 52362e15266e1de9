"""Rules that keep accounts of the backlog, where orders join it late because they had to wait for stock.

They decide as new ones do, which have kept nothing.
"""

from __future__ import annotations

import inspect
from copy import deepcopy
from typing import Any

import pytest

import rmfs_core
from rmfs_commands.states.answers import answer_to_dict
from rmfs_core import hookimpl
from rmfs_core.events import Event, OrderInStock
from rmfs_core.info import Question
from rmfs_core.roles import Role
from rmfs_core.rules.hooks import marked_methods
from rmfs_core.rules.sources import RuleSources

SHORT = ("instance.replenishment.lead_s=600", "instance.orders=120", "robots.count=3", "rules.pp=free-flow")
BUSY = ("instance.arrivals.orders_per_hour=600", "stations.item_capacity=6")
POA = (
    "common-lines",
    "earliest-due",
    "first-come",
    "near-best-pod",
    "pod-match",
    "random",
    "station-queue",
    "workload",
)
PPS = ("completes", "demand", "lexicographic", "nearest-pod", "work-amount")
RPS = ("correlated", "turnover-pod")
JOINT = ("alternating", "integrated", "lns", "pod-index", "split-among-stations", "split-over-time", "two-stage")
SLOW = {"integrated", "split-among-stations", "split-over-time"}


class Doubter:
    """Observer that has each decision made once more, by a new rule; by one that sees filtered orders, if that is told.

    A rule keeps nothing of orders that a filter has left; what else it remembers, it does.
    """

    def __init__(self, role: Role, name: str, *, filtered: bool = False, **parameters: Any) -> None:
        self.role, self.filtered, self.parameters = role, filtered, parameters
        kind: Any = RuleSources(".").find(name, "rule").target
        self.kind = kind
        self.other: Any = self.kind(**parameters)
        self.late = self.decided = 0

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Count orders that had to wait."""
        self.late += isinstance(event, OrderInStock)

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Decide, before anything changes, with the same random numbers."""
        view = question.warehouse
        if question.decides is not self.role:
            return
        assert list(view.backlog) == sorted(view.backlog, key=lambda order: (order.arrival_tick, order.id))
        rule = self.other if self.filtered else self.kind(**self.parameters)
        given = {**question.arguments, "rng": deepcopy(question.rng)}
        given["warehouse"] = view.showing(view.backlog) if self.filtered else view
        method = getattr(rule, marked_methods(self.kind)[self.role.hook])
        self.answer = method(**{name: given[name] for name in inspect.signature(method).parameters})

    @hookimpl
    def rule_answered(self, question: Question, answer: Any) -> None:
        """Compare."""
        if question.decides is self.role:
            skus = [str(sku) for sku in range(question.warehouse.n_skus)]
            told, other = (answer_to_dict(question.warehouse, skus, self.role, one) for one in (answer, self.answer))
            assert told == other
            self.decided += any((told or {}).values())


def doubt(role: Role, name: str, *overrides: str, filtered: bool = False, **parameters: Any) -> None:
    """Doubt every decision of a run in which orders join the backlog late."""
    doubter = Doubter(role, name, filtered=filtered, **parameters)
    chosen = [
        f"rules.{role.key}={name}",
        *(f"rules.{role.key}.{key}={str(value).lower()}" for key, value in parameters.items()),
    ]
    chosen = ["rules.poa=", "rules.pps=", *chosen] if role is Role.POA_PPS else chosen
    rmfs_core.run("examples/replenished", overrides=[*SHORT, *BUSY, *chosen, *overrides], observers=[doubter])
    assert doubter.late > 10
    assert doubter.decided > 30


@pytest.mark.parametrize("name", POA)
def test_poa(name: str) -> None:
    """Each rule that assigns whole orders; queues of stations are remembered."""
    doubt(Role.POA, name, filtered=name == "station-queue")


@pytest.mark.parametrize("name", ["common-lines", "pod-match"])
def test_poa_by_lot_and_by_due_time(name: str) -> None:
    """Ties and late orders, too."""
    due = "instance.due={allowance_s=900, spread_s=300, priority_share=0.3}"
    doubt(Role.POA, name, due, tie_break="random")
    doubt(Role.POA, name, due, tie_break="due", late_first=True, fast_lane=2)
    doubt(Role.POA, name, due, filtered=True, tie_break="random")


@pytest.mark.parametrize("name", PPS)
def test_pps(name: str) -> None:
    """Each rule that selects pods by the backlog."""
    doubt(Role.PPS, name)


@pytest.mark.parametrize("name", RPS)
def test_rps(name: str) -> None:
    """Rules that count what was ordered until now count orders once, those that wait as well."""
    doubt(Role.RPS, name)


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in JOINT])
def test_joint(name: str) -> None:
    """Each rule that does both."""
    parameters: dict[str, Any] = {"iterations": 2} if name == "lns" else {}
    doubt(Role.POA_PPS, name, **parameters)
