"""A replay in a notebook."""

from __future__ import annotations

from html import escape
from pathlib import Path

from attrs import field, frozen

from rmfs_commands.replay.page import page
from rmfs_commands.replay.reading import read_replay

MOST_BYTES = 8_000_000
"""The largest page that is put into a notebook, which keeps it."""


@frozen(eq=False)
class Page:
    """The page of a replay; a notebook shows it in a frame, with all that can be done in it.

    Parameters
    ----------
    name
        Of the run, or of both.
    html
        The page, as `rmfs replay` writes it.
    height_px
        How high the frame is.
    """

    name: str
    html: str = field(repr=False)
    height_px: int

    def _repr_html_(self) -> str:
        """Return the page in a frame of its own, cut off from the notebook's; a sentence for one that is too large."""
        size = len(self.html.encode())
        if size > MOST_BYTES:
            advice = (
                f"a notebook is given at most {MOST_BYTES / 1e6:g} MB. <code>rmfs replay</code> writes it as a file"
            )
            return f"<p>The replay of {escape(self.name)} has {size / 1e6:.1f} MB; {advice}.</p>"
        named = f'title="Replay of {escape(self.name)}" style="width:100%;height:{self.height_px}px;border:0"'
        return f'<iframe {named} sandbox="allow-scripts allow-forms" srcdoc="{escape(self.html)}"></iframe>'


def replay(folder: str | Path, other: str | Path | None = None, *, height_px: int = 640) -> Page:
    """Return the replay of a recorded run, or of two side by side, for a notebook to show.

    Parameters
    ----------
    folder, other
        Folder that ``run(..., out=folder, record=["trace"])`` or `rmfs run --trace` wrote.
    height_px
        How high it is shown; it is as wide as the notebook.

    Raises
    ------
    InputError
        When there is no trace, or one that is damaged, cut off, or of another run than what is next to it.
    """
    runs = [read_replay(one) for one in (folder, other) if one is not None]
    return Page(" and ".join(run.name for run in runs), page(runs), int(height_px))
