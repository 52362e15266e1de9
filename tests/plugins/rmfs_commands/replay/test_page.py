"""The page: everything in one file, and no more than it may be."""

from __future__ import annotations

import base64
import hashlib
import json
import re
import zlib
from html.parser import HTMLParser
from pathlib import Path

import pytest

from rmfs_commands.replay.page import LIVE, RECORDED, VIEW, live_page, packed, page, script
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
        r"""(?:src|href)=(?!"data:,")|https?://|@import ["u]|url\(|\bfetch\(|^import """, text, re.MULTILINE
    )
    assert "<title>day and day</title>" in text
    assert not re.search(r"\$(title|policy|style|runs|script)\b", text)


class Inline(HTMLParser):
    """What is inline in a page, and its policy."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tag = ""
        self.found: dict[str, list[str]] = {"script": [], "style": []}
        self.attributes: set[str] = set()
        self.policy: dict[str, list[str]] = {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Keep what can run or be applied: the runs are data."""
        values = dict(attributes)
        self.attributes |= values.keys()
        self.tag = tag if values.get("type") != "text/plain" else ""
        if values.get("http-equiv") == "Content-Security-Policy":
            rules = (rule.split() for rule in str(values["content"]).split(";"))
            self.policy = {name: sources for name, *sources in rules}

    def handle_data(self, data: str) -> None:
        """Keep a text whole."""
        if self.tag in self.found:
            self.found[self.tag].append(data)

    def handle_endtag(self, _tag: str) -> None:
        """Leave an element."""
        self.tag = ""


def test_the_page_allows_its_own_script_and_style_only(replay: Replay) -> None:
    """By their hashes; nothing is loaded, and only the page of a run that goes on may ask where it comes from."""
    common = {"default-src": ["'none'"], "img-src": ["data:"], "base-uri": ["'none'"], "form-action": ["'none'"]}
    for text, more in ((page([replay]), {}), (live_page("day"), {"connect-src": ["'self'"]})):
        inline = Inline(text)
        hashes = {}
        for name, (content,) in inline.found.items():
            digest = hashlib.sha256(content.encode("utf-8")).digest()
            hashes[f"{name}-src"] = [f"'sha256-{base64.b64encode(digest).decode('ascii')}'"]
        assert inline.policy == {**common, **more, **hashes}
        assert not [name for name in inline.attributes if name == "style" or name.startswith("on")]


def code_of(text: str) -> str:
    """Return JavaScript without its comments."""
    return re.sub(r"/\*.*?\*/|(?<![:\"'])//[^\n]*", "", text, flags=re.DOTALL)


def names_of(text: str) -> list[str]:
    """Return the names that JavaScript defines in its outermost scope."""
    defined = re.findall(
        r"^(?:export )?(?:async )?(?:const|let|var|class|function\*?) (\w+|\$|\[[^]]*\]|\{[^}]*\})", text, re.MULTILINE
    )
    return [name for one in defined for name in re.findall(r"\w+|\$", one)]


@pytest.mark.parametrize("file", sorted(VIEW.glob("*.mjs")), ids=lambda file: file.name)
def test_modules_have_the_forms_that_the_script_is_made_from(file: Path) -> None:
    """Imports are one statement each, of names that another module exports by an own word before what it defines."""
    text = file.read_text(encoding="utf-8")
    assert text.startswith("// @ts-check\n// ")
    exports = {
        other.name: re.findall(r"^export (?:async )?(?:const|class|function) (\w+)", code, re.MULTILINE)
        for other in VIEW.glob("*.mjs")
        for code in [code_of(other.read_text(encoding="utf-8"))]
    }
    code = code_of(text)
    statements = re.findall(r'^import \{ (\w+(?:, \w+)*) \} from "\./([\w.-]+)";$', code, re.MULTILINE)
    for names, module in statements:
        assert set(names.split(", ")) <= set(exports[module])
    assert len(re.findall(r"\bimport\b", code)) == len(statements)
    assert len(re.findall(r"\bexport\b", code)) == len(exports[file.name])


@pytest.mark.parametrize(("entry", "others"), [(RECORDED, {LIVE, "live.mjs"}), (LIVE, {RECORDED})])
def test_all_modules_are_in_the_script_after_what_they_import(entry: str, others: set[str]) -> None:
    """Each once, and no two of them define the same name, as they share one scope there."""
    whole = script(entry)
    modules = {file.name: file.read_text(encoding="utf-8") for file in VIEW.glob("*.mjs") if file.name not in others}
    names = names_of(whole)
    assert sorted(names) == sorted(name for text in modules.values() for name in names_of(text))
    assert len(names) == len(set(names))
    heads = {name: text.splitlines()[1] for name, text in modules.items()}
    assert all(whole.count(head) == 1 for head in heads.values())
    for name, text in modules.items():
        for imported in re.findall(r'^import .* from "\./(.*)";$', text, re.MULTILINE):
            assert whole.index(heads[imported]) < whole.index(heads[name]), (imported, name)
    assert whole.count("// @ts-check") == len(modules)
    assert not re.search(r"\b(import|export)\b", code_of(whole))
    assert not re.search(r"<!--|</script|<script", whole)  # these would end the element, or hide its end


def test_a_name_that_looks_like_html_is_no_html(replay: Replay) -> None:
    """A folder may be called anything."""
    import attrs

    assert "<title>&lt;b&gt;</title>" in page([attrs.evolve(replay, name="<b>")])
