"""Which orders trucks took with them: rows of departures.csv, and metrics of the same."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any

from rmfs_commands.details.spans import Number, ratio
from rmfs_core.clock import to_seconds
from rmfs_core.world import OrderData

COLUMNS = ("departure", "route", "leaves_s", "orders", "departed", "missed", "open", "departed_share", "late_mean_s")
"""``open``: orders that are not done at the end of the run, before their truck leaves. ``late_mean_s``: of orders that
missed their truck, how long after it they were done, or the run ended, a mean."""

DueOrders = Iterable[tuple[OrderData, int, int | None]]
"""Orders that count, each with its due tick and the tick at which it was done, None where it was not."""


def rows(orders: DueOrders, end: int) -> list[dict[str, Any]]:
    """Return a row for each truck that an order goes with, in the order in which they leave; ``end`` of the run."""
    counts: dict[tuple[int, str], Counter[str]] = {}
    for order, due, done in orders:
        of = counts.setdefault((due, order.route or ""), Counter())
        of["orders"] += 1
        if (outcome := outcome_of(due, done, end)) == "missed":
            of["late"] += (end if done is None else done) - due
        of[outcome] += 1
    return [
        {
            "departure": number,
            "route": route,
            "leaves_s": to_seconds(due),
            **{name: of[name] for name in ("orders", "departed", "missed", "open")},
            "departed_share": ratio(of["departed"], of["departed"] + of["missed"]),
            "late_mean_s": None if not of["missed"] else to_seconds(round(of["late"] / of["missed"])),
        }
        for number, ((due, route), of) in enumerate(sorted(counts.items()), 1)
    ]


def outcome_of(due: int, done: int | None, end: int) -> str:
    """Say whether an order departed, missed its truck, or is open when the run ends before that leaves."""
    if done is None:
        return "missed" if due < end else "open"
    return "departed" if done <= due else "missed"


def values(orders: DueOrders, end: int) -> dict[str, Number]:
    """Return the metrics by name."""
    of = Counter(outcome_of(due, done, end) for _, due, done in orders)
    known = of["departed"] + of["missed"]
    return {"departed_share": ratio(of["departed"], known), "missed_percent": ratio(100 * of["missed"], known)}
