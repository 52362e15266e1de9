"""The page of a replay: one HTML file with everything in it, which needs neither network nor other files."""

from __future__ import annotations

import base64
import re
import zlib
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template

from rmfs_core.results.files import json_ready, to_json
from rmfs_replay.reading import Replay
from rmfs_replay.telling import told

VIEW = Path(__file__).parent / "view"
ENTRY = "main.mjs"
_IMPORT = re.compile(r'^import \{[^}]*\} from "\./([\w.-]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export (?=const|function|class|async)", re.MULTILINE)


def page(replays: Sequence[Replay]) -> str:
    """Return the page.

    Parameters
    ----------
    replays
        One run, or two that are shown side by side.
    """
    title = " and ".join(replay.name for replay in replays)
    return Template((VIEW / "page.html").read_text(encoding="utf-8")).substitute(
        title=escape(title),
        style=(VIEW / "style.css").read_text(encoding="utf-8").strip(),
        runs="\n".join(f'<script type="text/plain" class="run">{packed(replay)}</script>' for replay in replays),
        script=script(),
    )


def packed(replay: Replay) -> str:
    """Return a run as base64 of its compressed JSON: text that a browser unpacks by itself, and no HTML."""
    text = to_json(json_ready(told(replay)))
    return base64.b64encode(zlib.compress(text.encode("utf-8"), 9)).decode("ascii")


def script(entry: str = ENTRY) -> str:
    """Return the page's modules as one: each after those that it imports, without its imports and exports.

    A page that is opened from a file may import nothing, so the modules share one scope; no two may define a name.
    """
    done: dict[str, str] = {}
    _add(entry, done)
    return "\n".join(done.values()).replace("</script", "<\\/script").strip()


def _add(name: str, done: dict[str, str]) -> None:
    text = (VIEW / name).read_text(encoding="utf-8")
    for imported in _IMPORT.findall(text):
        if imported not in done:
            _add(imported, done)
    done[name] = _EXPORT.sub("", _IMPORT.sub("", text)).strip() + "\n"
