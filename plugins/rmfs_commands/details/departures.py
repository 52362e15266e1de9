"""Which orders trucks took with them: rows of departures.csv, and metrics of the same."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

from rmfs_commands.details.spans import Number, ratio
from rmfs_core.clock import to_seconds
from rmfs_core.world import OrderData

COLUMNS = ("departure", "route", "leaves_s", "orders", "departed", "missed", "open", "departed_share", "late_mean_s")
"""``open``: orders whose truck leaves after all that count, see `last_truck`. ``late_mean_s``: of orders that missed
their truck, how long after it they were done, or the run ended, a mean."""

DueOrders = Sequence[tuple[OrderData, int, int | None]]
"""Orders that count, each with its due tick and the tick at which it was done, None where it was not."""


def last_truck(orders: DueOrders, end: int, until: int | None) -> float:
    """Return the last tick at which a truck leaves that counts.

    Of a truck that leaves after the horizon ``until``, or after the ``end`` of a run with orders left, only the early
    orders are known, so that none of them counts. Without a horizon trucks count that leave after the last order.
    """
    by = math.inf if until is None else until
    return min(by, end) if any(done is None for _, _, done in orders) else by


def rows(orders: DueOrders, end: int, until: int | None = None) -> list[dict[str, Any]]:
    """Return a row for each truck that an order goes with, in the order in which they leave.

    Parameters
    ----------
    orders
        The orders that count.
    end
        Tick at which the run ended.
    until
        Tick of its horizon, ``run.until_s``; None without one.
    """
    by = last_truck(orders, end, until)
    counts: dict[tuple[int, str], Counter[str]] = {}
    for order, due, done in orders:
        of = counts.setdefault((due, order.route or ""), Counter())
        of["orders"] += 1
        if (outcome := outcome_of(due, done, by)) == "missed":
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


def outcome_of(due: int, done: int | None, by: float) -> str:
    """Say whether an order departed, missed its truck, or is open since that leaves after the `last_truck`."""
    if due > by:
        return "open"
    return "departed" if done is not None and done <= due else "missed"


def values(orders: DueOrders, end: int, until: int | None = None) -> dict[str, Number]:
    """Return the metrics by name; parameters as of `rows`."""
    by = last_truck(orders, end, until)
    of = Counter(outcome_of(due, done, by) for _, due, done in orders)
    known = of["departed"] + of["missed"]
    return {"departed_share": ratio(of["departed"], known), "missed_percent": ratio(100 * of["missed"], known)}
