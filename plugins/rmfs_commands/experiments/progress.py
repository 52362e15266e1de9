"""The display of an experiment: live on a terminal, plain lines elsewhere."""

from __future__ import annotations

import threading
import time

from attrs import define, field
from rich.console import Console, RenderableType
from rich.table import Table
from rich.text import Text

from rmfs_commands.cli.display import Display, PanelDisplay, duration, figures, progress_bar
from rmfs_commands.experiments.experiment import Job
from rmfs_commands.experiments.rows import Row
from rmfs_commands.experiments.watching import Watcher
from rmfs_core.wording import counted

REFRESHES_PER_S = 4
MOST_LISTED = 8
"""Runs under way that the live display lists, the oldest first."""
BOUNDING = "{}: bounds of {:,} instances and seeds"


@define
class ExperimentCounts:
    """State of an experiment so far, for both displays.

    Parameters
    ----------
    total, stored
        Runs in all, and those of them that were stored before.
    slots
        Runs at a time.
    clock
        Seconds; only differences count.
    """

    total: int = 0
    stored: int = 0
    slots: int = 1
    done: int = 0
    failed: int = 0
    repeated: int = 0
    simulated_s: float = 0.0
    started: float = field(factory=time.perf_counter)
    running: dict[str, tuple[Job, float]] = field(factory=dict)

    def begin(self, job: Job) -> None:
        """Count a run as under way."""
        self.running[job.key] = (job, time.perf_counter())

    def end(self, job: Job, row: Row) -> None:
        """Count a run as done."""
        self.running.pop(job.key, None)
        self.done += 1
        self.failed += row["status"] == "failed"
        self.simulated_s += row.get("simulated_s") or 0.0

    @property
    def finished(self) -> int:
        """Runs that need not be run any more."""
        return self.stored + self.done

    @property
    def under_way(self) -> int:
        """Runs under way: where one has ended, the next may be begun before that is known."""
        return min(len(self.running), self.slots)

    @property
    def used_s(self) -> float:
        """Wall-clock seconds since the start."""
        return time.perf_counter() - self.started

    @property
    def speed(self) -> str:
        """Simulated seconds per second, over all workers."""
        return f"{self.simulated_s / self.used_s:,.0f}" if self.simulated_s else "-"

    @property
    def left(self) -> str:
        """Wall-clock time that the rest will take if it goes on like this."""
        return duration(self.used_s * (self.total - self.finished) / self.done) if self.done else "-"


class ExperimentLines(Display, Watcher):
    """Writes a line at the start, one for every tenth of the runs, one for each run that fails, and one at the end.

    Parameters
    ----------
    name
        Name of the experiment.
    console
        Where the lines go.
    """

    def __init__(self, name: str, console: Console) -> None:
        super().__init__(name, console)
        self.counts = ExperimentCounts()
        self._lock = threading.Lock()

    def started(self, total: int, stored: int, slots: int) -> None:
        """Write the first line."""
        self.counts = ExperimentCounts(total, stored, slots)
        before = f", {stored:,} of them stored already" if stored else ""
        self.line(f"{self.name}: {counted(total, 'run')}{before}, {slots} at a time")

    def run_started(self, job: Job) -> None:
        """Count."""
        with self._lock:
            self.counts.begin(job)

    def run_dropped(self, job: Job, problem: str) -> None:
        """Write a line."""
        self.line(f"Computed again: {job}: {problem}")

    def run_repeated(self, job: Job, problem: str) -> None:
        """Write a line."""
        with self._lock:
            self.line(f"Repeated: {job}: {problem}")

    def run_finished(self, job: Job, row: Row) -> None:
        """Write a line if the run failed, or another tenth is done."""
        with self._lock:
            counts = self.counts
            before = 10 * counts.finished // counts.total
            counts.end(job, row)
            if row["status"] == "failed":
                self.line(f"Failed: {job}: {row['error']}")
            tenths = 10 * counts.finished // counts.total
            if tenths > before and tenths < 10:
                self.line(f"{10 * tenths:3d} %  {self._state()}, {counts.left} left")

    def bounding(self, instances: int) -> None:
        """Write a line."""
        self.line(BOUNDING.format(self.name, instances))

    def ended(self) -> None:
        """Write the last line."""
        self.line(f"{self._state()} in {duration(self.counts.used_s)}")

    def _state(self) -> str:
        counts = self.counts
        failed = f", {counts.failed:,} failed" if counts.failed else ""
        return (
            f"{counts.finished:,} of {counts.total:,} runs done{failed}, {counts.under_way} running, "
            f"{counts.speed} simulated s per s"
        )


class ExperimentPanel(PanelDisplay, Watcher):
    """Shows an experiment on a terminal while it goes on; runs that fail stay to be read above the display.

    Parameters
    ----------
    name
        Name of the experiment.
    console
        The terminal.
    """

    def __init__(self, name: str, console: Console) -> None:
        super().__init__(name, console)
        self.counts = ExperimentCounts()
        self._lock = threading.Lock()

    def started(self, total: int, stored: int, slots: int) -> None:
        """Open the display."""
        self.counts = ExperimentCounts(total, stored, slots)
        self.open(REFRESHES_PER_S)

    def run_started(self, job: Job) -> None:
        """Count."""
        with self._lock:
            self.counts.begin(job)

    def run_dropped(self, job: Job, problem: str) -> None:
        """Write a line; the display is not open yet."""
        self._above("Computed again", f"{job}: {problem}", "yellow")

    def run_repeated(self, job: Job, problem: str) -> None:
        """Write a line above the display."""
        with self._lock:
            self.counts.repeated += 1
        self._above("Repeated", f"{job}: {problem}", "yellow")

    def run_finished(self, job: Job, row: Row) -> None:
        """Count; write a line above the display if the run failed."""
        with self._lock:
            self.counts.end(job, row)
        if row["status"] == "failed":
            self._above("Failed", f"{job}: {row['error']}", "red")

    def bounding(self, instances: int) -> None:
        """Write a line; the display is closed."""
        self.line(BOUNDING.format(self.name, instances))

    def ended(self) -> None:
        """Remove the display; the tables replace it."""
        self.close()

    def _above(self, word: str, text: str, style: str) -> None:
        self.console.print(Text.assemble((f"{word}: ", style), text), soft_wrap=True)

    def picture(self) -> RenderableType:
        """Return what the display shows now."""
        with self._lock:
            bar = progress_bar("Runs", self.counts.finished, self.counts.total)
            return self.panel("", bar, self._figures(), self._runs())

    def _figures(self) -> RenderableType:
        counts = self.counts
        pairs: list[tuple[str, str | Text]] = [
            ("Running", f"{counts.under_way} of {counts.slots} at a time"),
            ("Simulated s per s", counts.speed),
            ("Stored before", f"{counts.stored:,}"),
            ("Time used", duration(counts.used_s)),
            ("Failed", Text(f"{counts.failed:,}", "bold red" if counts.failed else "")),
            ("Ends in about", counts.left),
        ]
        if counts.repeated:
            pairs.append(("Repeated", Text(f"{counts.repeated:,}", "yellow")))
        return figures(pairs, per_row=2)

    def _runs(self) -> RenderableType:
        table = Table(box=None, expand=True, padding=(0, 1, 0, 0), header_style="dim")
        for name, ratio in (("Instance", 2), ("Rule set", 1)):
            table.add_column(name, ratio=ratio, no_wrap=True)
        for name in ("Seed", "For"):
            table.add_column(name, justify="right", no_wrap=True)
        now = time.perf_counter()
        running = list(self.counts.running.values())
        for job, since in running[:MOST_LISTED]:
            table.add_row(job.instance, job.rule_set, str(job.seed), duration(now - since))
        if len(running) > MOST_LISTED:
            table.add_row(f"and {len(running) - MOST_LISTED} more", style="dim")
        return table


ExperimentDisplay = ExperimentPanel | ExperimentLines


def experiment_display(console: Console, name: str) -> ExperimentDisplay:
    """Return the display that suits where the output goes."""
    return ExperimentPanel(name, console) if console.is_terminal else ExperimentLines(name, console)
