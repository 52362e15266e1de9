"""Run a warehouse for a week and watch the memory: 20,000 orders in 7 days, under both planners that see traffic.

``python tools/soak.py [--orders N] [--rate R]``. What a run keeps of its orders, visits and decisions for its results
is all that may grow. Printed is the resident memory at the end of each simulated day; exit code 1 when a run does not
complete, or grows from its second to its last whole day by more than `MOST_KB_PER_ORDER` for each order that it
completed in between.
"""

from __future__ import annotations

import argparse
import gc
import multiprocessing
import sys
import time
from pathlib import Path
from typing import Any

from rmfs_core import hookimpl
from rmfs_core.results.running import run

MOST_KB_PER_ORDER = 3.0
"""Growth that is allowed: rows of the results and what they are made of."""
DAY_S = 86_400
SETTLED = 2
"""Days after which tables and caches have their size."""


class Watch:
    """Observer that notes memory, time and completed orders at the end of each simulated day.

    Attributes
    ----------
    days
        Resident memory in MB and orders completed, by day.
    """

    def __init__(self) -> None:
        self.days: list[tuple[float, int]] = []
        self._completed = 0

    @hookimpl
    def on_event(self, event: Any) -> None:
        """Look at the clock, and count."""
        if event.time_s >= DAY_S * (len(self.days) + 1):
            self.note()
        self._completed += type(event).__name__ == "OrderCompleted"

    def note(self) -> None:
        """Note what there is now."""
        gc.collect()
        self.days.append((resident_mb(), self._completed))
        print(f"  day {len(self.days)}: {self.days[-1][0]:.0f} MB, {self._completed:,} orders", flush=True)


def resident_mb() -> float:
    """Return the resident memory of this process."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4096 / 1e6


def soak(planner: str, orders: int, per_hour: float) -> None:
    """Run one planner; exit with 1 when it does not complete, or grows too much."""
    watch, started = Watch(), time.process_time()
    overrides = [
        f"instance.orders={orders}",
        f"instance.arrivals.orders_per_hour={per_hour}",
        f"rules.pp={planner}",
    ]
    result = run("paper-poisson", overrides=overrides, observers=[watch])
    cpu_s = time.process_time() - started
    days = result.metrics["makespan_s"] / DAY_S
    print(f"  {result.status} after {days:.1f} days, {days * DAY_S / cpu_s:,.0f} simulated s per CPU s", flush=True)
    print(f"  {resident_mb():.0f} MB with the results", flush=True)
    if len(watch.days) <= SETTLED:
        print("  too short to tell growth", flush=True)
        sys.exit(result.status != "complete")
    (before, first), (after, last) = watch.days[SETTLED - 1], watch.days[-1]
    growth_kb = 1000 * (after - before) / max(last - first, 1)
    print(f"  {growth_kb:.2f} kB an order since day {SETTLED}; at most {MOST_KB_PER_ORDER} are allowed", flush=True)
    sys.exit(result.status != "complete" or growth_kb > MOST_KB_PER_ORDER)


def main() -> int:
    """Run all planners, each in a process of its own."""
    parser = argparse.ArgumentParser(description="Does a week complete, and does the memory stay flat?")
    parser.add_argument("--orders", type=int, default=20_000)
    parser.add_argument("--rate", type=float, default=119.0, help="orders an hour")
    given = parser.parse_args()
    failed = 0
    for planner in ("sipp", "whca-n"):
        print(f"{planner}, {given.orders:,} orders, {given.rate:g} an hour", flush=True)
        process = multiprocessing.get_context("spawn").Process(target=soak, args=(planner, given.orders, given.rate))
        process.start()
        process.join()
        failed += process.exitcode != 0
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
