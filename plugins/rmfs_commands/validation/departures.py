"""departures.csv and the metrics of the same, worked out anew from a trace."""

from __future__ import annotations

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.tables import Row, arrivals_of, cancelled_in, measured_from
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import OrderCompleted, OrderPacked


def _lateness(trace: Trace) -> dict[tuple[int, str], list[int | None]]:
    """Return by how many ticks the orders of each truck are late, negative if in time; None: not done, and not late."""
    begin, arrivals, cancelled = measured_from(trace), arrivals_of(trace), cancelled_in(trace)
    kind = OrderPacked if trace.scenario.get("packing") else OrderCompleted
    done = {event.order: event.tick for event in trace.events if isinstance(event, kind)}
    end = max(trace.tick, begin)
    found: dict[tuple[int, str], list[int | None]] = {}
    for i, order in enumerate(trace.instance.orders):
        if order.due_tick is None or i in cancelled or arrivals.get(i, -1) < begin:
            continue
        late = done.get(i, end) - order.due_tick
        known = i in done or late > 0
        found.setdefault((order.due_tick, order.route or ""), []).append(late if known else None)
    return found


def departures_of(trace: Trace) -> list[Row]:
    """Return the rows of departures.csv."""
    rows: list[Row] = []
    for number, ((due, route), late) in enumerate(sorted(_lateness(trace).items()), 1):
        known = [ticks for ticks in late if ticks is not None]
        missed = [ticks for ticks in known if ticks > 0]
        counts = {"orders": len(late), "departed": len(known) - len(missed), "missed": len(missed)}
        share = (len(known) - len(missed)) / len(known) if known else None
        mean = round(sum(missed) / len(missed)) / TICKS_PER_S if missed else None
        told: Row = {
            "departure": number,
            "route": route,
            "leaves_s": due / TICKS_PER_S,
            **counts,
            "open": len(late) - len(known),
        }
        rows.append(told | {"departed_share": share, "late_mean_s": mean})
    return rows


def recompute_departures(trace: Trace) -> dict[str, float | None]:
    """Every metric of departures by name."""
    known = [ticks for late in _lateness(trace).values() for ticks in late if ticks is not None]
    share = sum(ticks <= 0 for ticks in known) / len(known) if known else None
    return {"departed_share": share, "missed_percent": None if share is None else 100 - 100 * share}
