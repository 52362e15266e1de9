"""Observer ``acme-first-picks``."""

from __future__ import annotations

from pathlib import Path

from attrs import define, field

from rmfs import Metric, RunInfo, hookimpl
from rmfs.events import Event, ItemPicked, RobotMoved

FILE = "first-picks.csv"


@define
class FirstPicks:
    """Measure when the last station had its first pick, and write each station's first pick to a file.

    Parameters
    ----------
    header
        First line of the file.
    """

    measures = (Metric("acme_all_busy_s", "All stations busy", "s", 1, "When the last station had its first pick."),)

    header: str = "station,first_s"
    first_s: dict[int, float] = field(init=False, factory=dict)
    out: Path | None = field(init=False, default=None)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Forget the run before."""
        self.first_s = {}
        self.out = run.out

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Take down a station's first pick."""
        if isinstance(event, ItemPicked):
            self.first_s.setdefault(event.station, event.time_s)

    @hookimpl
    def run_ended(self) -> None:
        """Write the file."""
        if self.out is not None:
            rows = [f"{station + 1},{first_s}" for station, first_s in sorted(self.first_s.items())]
            (self.out / FILE).write_text("\n".join([self.header, *rows]) + "\n", encoding="utf-8")

    @hookimpl
    def measured(self) -> dict[str, float | None]:
        """One metric that `measures` describes, and one that it does not."""
        return {"acme_all_busy_s": max(self.first_s.values(), default=None), "acme_busy_stations": len(self.first_s)}


class Turns:
    """Count how often robots drive, in every run, and write that to a file."""

    files = ("acme-turns.txt",)
    measures = (Metric("acme_legs", "Legs", "", 0, "How often a robot drove."),)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Start afresh."""
        self.legs = 0
        self.out = run.out

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Count."""
        self.legs += isinstance(event, RobotMoved)

    @hookimpl
    def run_ended(self) -> None:
        """Write the file."""
        if self.out is not None:
            (self.out / self.files[0]).write_text(f"{self.legs}\n", encoding="utf-8")

    @hookimpl
    def measured(self) -> dict[str, float]:
        """How often robots drove."""
        return {"acme_legs": self.legs}
