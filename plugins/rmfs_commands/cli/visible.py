"""Names as they are, whatever signs they have: none of them reaches a terminal as a command."""

from __future__ import annotations

from collections.abc import Iterator

from attrs import frozen
from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook
from rich.segment import Segment

from rmfs_core.wording import visible


class VisibleSigns(RenderHook):
    """Writes the signs that would steer the terminal as Python does; what rich itself sends there stays."""

    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        """Wrap what is to be printed."""
        return [_Visible(renderable) for renderable in renderables]


@frozen
class _Visible:
    renderable: ConsoleRenderable

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Segment]:
        for segment in console.render(self.renderable, options):
            plain = segment.control or segment.text.isprintable()
            yield segment if plain else Segment(visible(segment.text), segment.style)
