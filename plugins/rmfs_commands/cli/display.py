"""Code shared by the displays of runs and experiments: plain lines, and a panel on a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from rmfs_commands.cli.screen import say


def duration(seconds: float) -> str:
    """Hours, minutes and seconds: ``1:02:03``."""
    whole = round(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"


class Display:
    """Where something shows what it does.

    Parameters
    ----------
    name
        Name of the run or experiment.
    console
        Where it goes.
    """

    def __init__(self, name: str, console: Console) -> None:
        self.name = name
        self.console = console

    def line(self, text: str) -> None:
        """Write a line."""
        say(self.console, text)

    def close(self) -> None:
        """Give the terminal back: nothing to do after lines."""


class PanelDisplay(Display):
    """A panel on a terminal that changes in place, and goes away when it is closed."""

    def __init__(self, name: str, console: Console) -> None:
        super().__init__(name, console)
        self._live: Live | None = None

    def open(self, refreshes_per_s: float | None = None) -> None:
        """Open the panel; without a rate it changes when `refresh` is called."""
        rate = 4.0 if refreshes_per_s is None else refreshes_per_s
        self._live = Live(
            console=self.console,
            get_renderable=self.picture,
            auto_refresh=refreshes_per_s is not None,
            refresh_per_second=rate,
            transient=True,
        )
        self._live.start()

    def refresh(self) -> None:
        """Show how things are now."""
        if self._live is not None:
            self._live.refresh()

    def close(self) -> None:
        """Give the terminal back, whatever happened."""
        if self._live is not None:
            self._live.stop()
            self._live = None

    def picture(self) -> RenderableType:
        """Return what the panel shows now."""
        raise NotImplementedError

    def panel(self, subtitle: str, *parts: RenderableType) -> Panel:
        """Return a panel of some parts, with the display's name as its title."""
        spaced = [piece for part in parts for piece in (Text(), part)]
        body = Group(*spaced[1:])
        title = Text.assemble((f" {self.name} ", "bold"), (subtitle, "dim"))
        # A terminal echoes Ctrl-C as two characters behind the last line; if they wrapped, a line would be left over.
        width = self.console.width - 3
        return Panel(body, title=title, title_align="left", border_style="cyan", padding=(0, 1), width=width)


def progress_bar(what: str, done: int, total: int) -> Table:
    """Return a bar: how many of how many are done."""
    grid = Table.grid(padding=(0, 2), expand=True)
    grid.add_column()
    grid.add_column(ratio=1)
    grid.add_column(justify="right")
    share = done / total if total else 1.0
    grid.add_row(what, ProgressBar(total=max(total, 1), completed=done), f"{done:,} of {total:,} ({share:.0%})")
    return grid


def figures(pairs: Sequence[tuple[str, str | Text]], per_row: int) -> Table:
    """Return pairs of a name and a figure, some in a row."""
    grid = Table.grid(padding=(0, 2), expand=True)
    for _ in range(per_row):
        grid.add_column(style="dim", no_wrap=True)
        grid.add_column(ratio=1, no_wrap=True)
    for i in range(0, len(pairs), per_row):
        grid.add_row(*(cell for pair in pairs[i : i + per_row] for cell in pair))
    return grid
