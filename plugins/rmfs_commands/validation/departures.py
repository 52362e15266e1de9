"""departures.csv and the metrics of the same, worked out anew from a trace."""

from __future__ import annotations

from rmfs_commands.processes.events import OrderPacked
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation.tables import Row, due_in, measured_from
from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.events import OrderCompleted

_Late = tuple[bool, int]
"""Whether an order misses its truck, and when it was done, or the run ended, in ticks after that left."""


def _lateness(trace: Trace) -> dict[tuple[int, str], list[_Late | None]]:
    """Return how late the orders of each truck are; None where it leaves after the run has to end, or did end with
    orders not done."""
    kind = OrderPacked if trace.scenario.get("packing") else OrderCompleted
    done = {event.order: event.tick for event in trace.events if isinstance(event, kind)}
    end, until_s = max(trace.tick, measured_from(trace)), trace.scenario.get("run", {}).get("until_s")
    going = {i: (due, trace.instance.orders[i].route or "") for i, due in due_in(trace, done).items()}
    over = [] if until_s is None else [to_ticks(until_s)]
    if going.keys() - done.keys():
        over.append(end)
    found: dict[tuple[int, str], list[_Late | None]] = {}
    for i, (due, route) in going.items():
        late = done.get(i, end) - due
        known = not any(tick < due for tick in over)
        found.setdefault((due, route), []).append((late > 0 or i not in done, late) if known else None)
    return found


def departures_of(trace: Trace) -> list[Row]:
    """Return the rows of departures.csv."""
    rows: list[Row] = []
    for number, ((due, route), late) in enumerate(sorted(_lateness(trace).items()), 1):
        known = [one for one in late if one is not None]
        missed = [ticks for misses, ticks in known if misses]
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
    known = [one[0] for late in _lateness(trace).values() for one in late if one is not None]
    share = known.count(False) / len(known) if known else None
    return {"departed_share": share, "missed_percent": None if share is None else 100 - 100 * share}
