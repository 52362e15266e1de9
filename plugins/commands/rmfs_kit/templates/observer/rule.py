"""Observer ``the-rule``."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from attrs import define, field

from rmfs_core import hookimpl
from rmfs_core.events import ItemPicked

if TYPE_CHECKING:
    from rmfs_core.events import Event
    from rmfs_core.info import RunInfo


@define
class TheRule:
    """Count the picks of each station, and print them when the run is over."""

    picks: Counter[str] = field(init=False, factory=Counter)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Forget the run before, and write down the stations: one without picks counts, too."""
        self.picks = Counter({station.name: 0 for station in run.warehouse.stations})

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Count a pick. (Stations are called 1, 2, ...; their ids are 0, 1, ...)"""
        if isinstance(event, ItemPicked):
            self.picks[str(event.station + 1)] += 1

    @hookimpl
    def run_ended(self) -> None:
        """Print the counts."""
        print("Picks by station:", ", ".join(f"{name}: {picks}" for name, picks in self.picks.items()))
