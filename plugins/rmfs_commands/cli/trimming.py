"""Lines without the blanks that rich fills them up with: they break where a narrower window wraps them."""

from __future__ import annotations

from collections.abc import Iterator

from attrs import frozen
from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook
from rich.segment import Segment


class WithoutTrailingBlanks(RenderHook):
    """Takes the blanks from the end of each line that a console prints."""

    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        """Wrap what is to be printed."""
        return [_Trimmed(renderable) for renderable in renderables]


@frozen
class _Trimmed:
    renderable: ConsoleRenderable

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Segment]:
        segments = list(console.render(self.renderable, options))
        lines = list(Segment.split_lines(segments))
        ended = bool(segments) and segments[-1].text.endswith("\n")
        for number, line in enumerate(lines, 1):
            while line and not line[-1].text.strip():
                line.pop()
            if line:
                *before, last = line
                yield from before
                yield Segment(last.text.rstrip(), last.style, last.control)
            if ended or number < len(lines):
                yield Segment.line()
