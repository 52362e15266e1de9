"""A replay in a notebook."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import attrs
import pytest

import rmfs_commands.replay
from rmfs_commands.replay import notebook
from rmfs_commands.replay.page import page
from rmfs_commands.replay.reading import Replay
from rmfs_core import InputError


class Frame(HTMLParser):
    """What a browser makes of the HTML: the one frame in it."""

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Keep its attributes."""
        assert tag == "iframe"
        self.found = dict(attributes)


def frame_of(shown: rmfs_commands.replay.Page) -> dict[str, str | None]:
    """Return the attributes of a replay's frame."""
    parser = Frame()
    parser.feed(shown._repr_html_())
    parser.close()
    return parser.found


def test_the_page_is_shown_in_a_frame(day: Path, replay: Replay) -> None:
    """It is the one that `rmfs replay` writes; its scripts have no hold on the notebook."""
    shown = rmfs_commands.replay.replay(day, height_px=400)
    frame = frame_of(shown)
    assert frame["srcdoc"] == page([replay])
    assert frame["title"] == "Replay of day"
    assert "height:400px" in str(frame["style"])
    assert frame["sandbox"] is not None
    assert "allow-same-origin" not in frame["sandbox"]
    assert repr(shown) == "Page(name='day', height_px=400)"


def test_two_runs_are_one_page(day: Path, short: Path) -> None:
    """Side by side, as with the command."""
    assert frame_of(rmfs_commands.replay.replay(day, short))["title"] == "Replay of day and short"


def test_a_page_that_is_too_large_is_a_sentence(day: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A notebook keeps what it shows. A folder may be called anything."""
    monkeypatch.setattr(notebook, "MOST_BYTES", 1000)
    shown = attrs.evolve(rmfs_commands.replay.replay(day), name="<b>")._repr_html_()
    assert shown.startswith("<p>The replay of &lt;b&gt; has 0.1 MB; ")
    assert "<code>rmfs replay</code> writes it as a file" in shown


def test_a_folder_without_a_trace_is_refused(tmp_path: Path) -> None:
    """As by the command."""
    with pytest.raises(InputError, match="trace"):
        rmfs_commands.replay.replay(tmp_path)
