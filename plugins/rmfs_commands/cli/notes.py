"""Notes of commands on the standard error stream, as long as somebody reads it."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import IO, TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from rich.console import Console


class _Heedless:
    """A text stream whose writer does not care whether what it writes arrives."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Write; from the first time on that this fails, to nowhere."""
        with suppress(OSError):
            self._stream.write(text)
            self._stream.flush()  # here, so that nothing is left for the end, where nobody could catch it
            return len(text)
        with suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())
        return len(text)

    def flush(self) -> None:
        """Do nothing: everything is written."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def notes_console(*, quiet: bool = False) -> Console:
    """Return where a command reports its progress. A caller who closes that stream misses it; the command goes on."""
    from rich.console import Console

    from rmfs_commands.cli.visible import VisibleSigns

    file = None if sys.stderr is None else cast(IO[str], _Heedless(sys.stderr))
    console = Console(stderr=True, quiet=quiet, file=file)
    console.push_render_hook(VisibleSigns())
    return console
