"""Observer ``the-rule``."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from attrs import define, field
from rmfs import Metric, hookimpl
from rmfs.events import ItemPicked

if TYPE_CHECKING:
    from rmfs import RunInfo
    from rmfs.events import Event


@define
class TheRule:
    """Measure what share of the picks the busiest station has, and write the picks of each station to a file.

    The file is ``the_rule.csv`` next to the results, where a run keeps some.
    """

    # How tables show what it measures: name, label, unit, digits, meaning.
    measures = (
        Metric("busiest_station_percent", "Picks at the busiest station", "%", 1, "Its share of all items picked."),
    )

    picks: Counter[str] = field(init=False, factory=Counter)
    out: Path | None = field(init=False, default=None)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Forget the run before, and write down the stations: one without picks counts, too."""
        self.out = run.out
        self.picks = Counter({station.name: 0 for station in run.warehouse.stations})

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Count a pick. (Stations are called 1, 2, ...; their ids are 0, 1, ...)"""
        if isinstance(event, ItemPicked):
            self.picks[str(event.station + 1)] += 1

    @hookimpl
    def run_ended(self) -> None:
        """Write the counts."""
        if self.out is not None:
            lines = ["station,picks", *(f"{name},{picks}" for name, picks in self.picks.items())]
            (self.out / "the_rule.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")

    @hookimpl
    def measured(self) -> dict[str, float | None]:
        """Hand over the metric: it stands with the others in result.json. A share of nothing is None."""
        total = self.picks.total()
        return {"busiest_station_percent": 100 * max(self.picks.values()) / total if total else None}
