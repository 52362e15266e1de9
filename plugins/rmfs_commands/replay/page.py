"""The page of a replay: one HTML file with everything in it, which needs neither network nor other files.

Two regular expressions put its modules together: a bundler would need node wherever rmfs is installed, or a bundle in
the repository next to its sources; the tests hold each module to the forms that the expressions know.
"""

from __future__ import annotations

import base64
import hashlib
import re
import zlib
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from rmfs_commands.cli.not_simulated import NOT_SIMULATED
from rmfs_commands.replay.reading import Replay
from rmfs_commands.replay.telling import told
from rmfs_commands.results.files import json_ready, to_json

VIEW = Path(__file__).parent / "view"
RECORDED, LIVE = "main.mjs", "watch.mjs"
"""Modules that begin: of a page that has its runs, and of one that asks for its run."""
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
    return _page(title, [packed(told(replay)) for replay in replays], RECORDED)


def live_page(name: str) -> str:
    """Return the page of a run that goes on: it asks where it comes from for the run, and for what is new."""
    return _page(name, [], LIVE, connect="connect-src 'self'; ")


def _page(title: str, runs: Sequence[str], entry: str, connect: str = "") -> str:
    style, code = (VIEW / "style.css").read_text(encoding="utf-8"), script(entry)
    return Template((VIEW / "page.html").read_text(encoding="utf-8")).substitute(
        title=escape(title),
        not_simulated=escape(NOT_SIMULATED),
        policy=f"default-src 'none'; {connect}script-src {_source(code)}; style-src {_source(style)}; img-src data:; "
        "base-uri 'none'; form-action 'none'",
        style=style,
        runs="\n".join(f'<script type="text/plain" class="run">{run}</script>' for run in runs),
        script=code,
    )


def _source(text: str) -> str:
    """Return what a Content Security Policy calls an inline script or style: only this text is run or applied."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


def packed(values: Mapping[str, Any], level: int = 9) -> str:
    """Return what is told of a run as base64 of its compressed JSON: text that a browser unpacks, and no HTML."""
    text = to_json(json_ready(values))
    return base64.b64encode(zlib.compress(text.encode("utf-8"), level)).decode("ascii")


def script(entry: str = RECORDED) -> str:
    """Return the page's modules as one: each after its imports, without its imports and exports.

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
