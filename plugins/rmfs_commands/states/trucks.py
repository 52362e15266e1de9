"""Which truck an order went with, or missed: told from what a run left next to its recorded decisions."""

from __future__ import annotations

import csv
from typing import Any

from rmfs_commands.details.loading import load_result
from rmfs_commands.details.observer import PACKING
from rmfs_commands.states.recorded import Recording
from rmfs_core.results import RESULT_FILE


def truck_of(recording: Recording, order: str) -> dict[str, Any] | None:
    """Return when the truck of an order leaves, its route, when the order was done, and all of it in words.

    None where no trucks leave, the order goes with none, was cancelled, or the run's result is not there.
    """
    folder, scenario = recording.file.parent, recording.scenario
    if scenario.instance.departures is None or not (folder / RESULT_FILE).exists():
        return None
    result = load_result(folder)
    row = next((row for row in result.orders if row["order"] == order), {})
    leaves_s = row.get("due_s")
    if leaves_s is None or row.get("cancelled_s") is not None:
        return None
    done_s, verb, end_s = row["completed_s"], "picked", result.metrics["simulated_s"]
    if result.status == "horizon":
        end_s = scenario.run.until_s
    if scenario.packing is not None:
        with (folder / PACKING).open(encoding="utf-8", newline="") as stream:
            packed = {one["order"]: one["packed_s"] for one in csv.DictReader(stream)}
        done_s, verb = float(packed[order]) if packed.get(order) else None, "packed"
    route = row.get("route") or None
    leaves = "leaves" if leaves_s > end_s else "left"
    truck = f"the truck{f' of route {route}' if route else ''} that {leaves} at {leaves_s:,.0f} s"
    if done_s is None:
        left = f"it is not {verb} at {end_s:,.0f} s, when the run ends."
        words = f"It may still go with {truck}: {left}" if leaves == "leaves" else f"It missed {truck}: {left}"
    elif done_s > leaves_s:
        words = f"It missed {truck}: it was {verb} at {done_s:,.0f} s, {done_s - leaves_s:,.0f} s late."
    else:
        words = f"It was in time for {truck}: it was {verb} at {done_s:,.0f} s."
    return {"route": route, "leaves_s": leaves_s, "done_s": done_s, "words": words}
