"""Wall-clock figures of a run; they differ from run to run."""

from __future__ import annotations

from collections.abc import Sequence

from rmfs_commands.instances.tables import Row


def timing(
    wall_s: float, began_s: float, warmup_s: float, end_s: float, orders: Sequence[Row], periods: Sequence[Row]
) -> dict[str, float | None]:
    """Return the figures by name; `rmfs_commands.results.figures.TIMING` has their meanings and units.

    Parameters
    ----------
    wall_s
        Wall-clock seconds of the simulation.
    began_s, warmup_s, end_s
        Simulated time at which the run begins, from which on is counted, and at its end.
    orders, periods
        Rows of the tables.
    """
    completed = [row["completed_s"] for row in orders]
    counted = sum(second is not None and second >= warmup_s for second in completed)
    simulated_s = end_s if None in completed else max(completed, default=0.0)
    first = sum(row["seconds"] for row in periods if row["period"] <= 1)
    later = sum(row["seconds"] for row in periods if row["period"] > 1 and row["time_s"] >= warmup_s)
    since_warmup_s = max(simulated_s - warmup_s, 0)
    return {
        "wall_s": wall_s,
        "simulated_s_per_wall_s": (end_s - began_s) / wall_s if wall_s else None,
        "decision_s_first": first,
        "decision_s_later": later,
        "decision_s_per_order": later / counted if counted else None,
        "decision_percent_of_simulated": 100 * later / since_warmup_s if since_warmup_s else None,
    }
