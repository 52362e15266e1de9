"""The page: everything in one file, and no more than it may be."""

from __future__ import annotations

import base64
import json
import re
import zlib

import pytest

from rmfs_commands.replay.page import LIVE, RECORDED, VIEW, packed, page, script
from rmfs_commands.replay.reading import Replay
from rmfs_commands.replay.telling import told
from rmfs_core.results.files import to_json


def test_a_run_is_packed_whole(replay: Replay) -> None:
    """A browser that inflates the text reads what the run is told as."""
    unpacked = json.loads(zlib.decompress(base64.b64decode(packed(told(replay)))))
    assert unpacked == json.loads(to_json(told(replay)))


def test_the_page_needs_nothing_else(replay: Replay) -> None:
    """It names no address and no other file, and forbids itself to ask for any."""
    text = page([replay, replay])
    assert text.count('<script type="text/plain" class="run">') == 2
    assert not re.search(
        r"""(?:src|href)=(?!"data:,")|https?://|@import|url\(|\bfetch\(|^import """, text, re.MULTILINE
    )
    assert "default-src 'none'" in text
    assert "<title>day and day</title>" in text
    assert not re.search(r"\$(title|style|runs|script)", text)


@pytest.mark.parametrize(("entry", "others"), [(RECORDED, {LIVE, "live.mjs"}), (LIVE, {RECORDED})])
def test_all_modules_are_in_the_script_after_what_they_import(entry: str, others: set[str]) -> None:
    """Each once, and no two of them define the same name, as they share one scope there."""
    whole = script(entry)
    names = re.findall(r"^(?:async )?(?:const|let|class|function) (\w+)", whole, re.MULTILINE)
    assert len(names) == len(set(names))
    for module in VIEW.glob("*.mjs"):
        comment = module.read_text(encoding="utf-8").splitlines()[0]
        assert whole.count(comment) == (module.name not in others), module.name
    assert whole.index("class World") < whole.index("function viewsOf") < whole.index("class Page")
    assert not re.search(r"^(import|export) ", whole, re.MULTILINE)


def test_a_name_that_looks_like_html_is_no_html(replay: Replay) -> None:
    """A folder may be called anything."""
    import attrs

    assert "<title>&lt;b&gt;</title>" in page([attrs.evolve(replay, name="<b>")])
