"""The page of `rmfs replay`: what it is told, what is in it, also in a notebook."""

import base64
import hashlib
import json
import re
import zlib
from functools import partial
from html.parser import HTMLParser
from pathlib import Path

import attrs
import pytest
from PIL import Image, ImageSequence

import rmfs_commands.replay
import rmfs_core
from calling import exit_code
from cases import cases
from rmfs_commands.details.loading import load_result
from rmfs_commands.replay import notebook
from rmfs_commands.replay.page import LIVE, RECORDED, VIEW, live_page, packed, page, script
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.replay.telling import metrics_of, rules_of, summaries, told
from rmfs_commands.results.files import to_json


def test_the_page_is_packed_whole_and_needs_nothing_else(replay: Replay) -> None:
    unpacked = json.loads(zlib.decompress(base64.b64decode(packed(told(replay)))))
    assert unpacked == json.loads(to_json(told(replay)))
    text = page([replay, replay])
    assert text.count('<script type="text/plain" class="run">') == 2
    assert not re.search(
        r"""(?:src|href)=(?!"data:,")|https?://|@import ["u]|url\(|\bfetch\(|^import """, text, re.MULTILINE
    )
    assert "<title>day and day</title>" in text
    assert not re.search(r"\$(title|policy|style|runs|script)\b", text)


class Inline(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.tag = ""
        self.found: dict[str, list[str]] = {"script": [], "style": []}
        self.attributes: set[str] = set()
        self.policy: dict[str, list[str]] = {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        values = dict(attributes)
        self.attributes |= values.keys()
        self.tag = tag if values.get("type") != "text/plain" else ""
        if values.get("http-equiv") == "Content-Security-Policy":
            rules = (rule.split() for rule in str(values["content"]).split(";"))
            self.policy = {name: sources for name, *sources in rules}

    def handle_data(self, data: str) -> None:
        if self.tag in self.found:
            self.found[self.tag].append(data)

    def handle_endtag(self, _tag: str) -> None:
        self.tag = ""


def test_the_page_keeps_names_and_scripts_apart(replay: Replay) -> None:
    common = {"default-src": ["'none'"], "img-src": ["data:"], "base-uri": ["'none'"], "form-action": ["'none'"]}
    for text, more in ((page([replay]), {}), (live_page("day"), {"connect-src": ["'self'"]})):
        inline = Inline(text)
        hashes = {}
        for name, (content,) in inline.found.items():
            digest = hashlib.sha256(content.encode("utf-8")).digest()
            hashes[f"{name}-src"] = [f"'sha256-{base64.b64encode(digest).decode('ascii')}'"]
        assert inline.policy == {**common, **more, **hashes}
        assert not [name for name in inline.attributes if name == "style" or name.startswith("on")]
    import attrs

    assert "<title>&lt;b&gt;</title>" in page([attrs.evolve(replay, name="<b>")])


def code_of(text: str) -> str:
    return re.sub(r"/\*.*?\*/|(?<![:\"'])//[^\n]*", "", text, flags=re.DOTALL)


def names_of(text: str) -> list[str]:
    defined = re.findall(
        r"^(?:export )?(?:async )?(?:const|let|var|class|function\*?) (\w+|\$|\[[^]]*\]|\{[^}]*\})", text, re.MULTILINE
    )
    return [name for one in defined for name in re.findall(r"\w+|\$", one)]


@pytest.mark.parametrize("file", sorted(VIEW.glob("*.mjs")), ids=lambda file: file.name)
def test_modules_have_the_forms_that_the_script_is_made_from(file: Path) -> None:
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


class Frame(HTMLParser):
    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        assert tag == "iframe"
        self.found = dict(attributes)


def frame_of(shown: rmfs_commands.replay.Page) -> dict[str, str | None]:
    parser = Frame()
    parser.feed(shown._repr_html_())
    parser.close()
    return parser.found


def test_the_page_is_shown_in_a_frame(day: Path, replay: Replay) -> None:
    shown = rmfs_commands.replay.replay(day, height_px=400)
    frame = frame_of(shown)
    assert frame["srcdoc"] == page([replay])
    assert frame["title"] == "Replay of day"
    assert "height:400px" in str(frame["style"])
    assert "allow-same-origin" not in frame["sandbox"]
    assert repr(shown) == "Page(name='day', height_px=400)"


def test_pages_of_two_runs_or_too_large_ones(day: Path, short: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert frame_of(rmfs_commands.replay.replay(day, short))["title"] == "Replay of day and short"
    monkeypatch.setattr(notebook, "MOST_BYTES", 1000)
    shown = attrs.evolve(rmfs_commands.replay.replay(day), name="<b>")._repr_html_()
    assert shown.startswith("<p>The replay of &lt;b&gt; has 0.1 MB; ")
    assert "<code>rmfs replay</code> writes it as a file" in shown


called = partial(exit_code, "replay")


def test_pages_are_written_where_asked(day, capsys, short, tmp_path) -> None:
    assert called(str(day)) == 0
    page = day / "replay.html"
    assert capsys.readouterr().out == f"Open {page} in a browser.\n"
    assert page.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    page.unlink()
    assert called(str(day), str(short), "--out", str(tmp_path / "both.html"), "--quiet") == 0
    assert capsys.readouterr().out == ""
    assert "<title>day and short</title>" in (tmp_path / "both.html").read_text(encoding="utf-8")


def test_pictures_from_a_time_to_another(day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert called(str(day), "--frames", "2", "--from", "60", "--to", "120", "--out", str(tmp_path)) == 0
    assert capsys.readouterr().out == f"2 pictures in {tmp_path}.\n"
    assert sorted(file.name for file in tmp_path.iterdir()) == ["frame-001.png", "frame-002.png"]


def test_a_video(day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "x.gif"
    assert called(str(day), "--video", str(file), "--from", "60", "--to", "70", "--speed", "5") == 0
    assert capsys.readouterr().out == f"A video in {file}.\n"
    with Image.open(file) as found:
        assert sum(frame.info["duration"] for frame in ImageSequence.Iterator(found)) == 2100


@cases(
    "arguments sentence",
    (("nowhere",), "nowhere: cannot be read"),
    (("DAY", "nowhere"), "nowhere: cannot be read"),
    (("DAY", "--video", "x.webm"), "found the ending '.webm'; expected .gif or .mp4"),
    (("DAY", "--video", "x.gif", "--frames", "3"), "--video: found with --frames; expected one of them"),
    (("DAY", "--video", "x.gif", "--out", "y"), "--out: found with --video x.gif"),
    (("DAY", "--speed", "3"), "--speed: found without --video"),
    (("DAY", "--to", "3"), "--to: found without --frames or --video"),
    (("DAY", "--video", "x.gif", "--speed", "1e-9"), "pictures; expected at most 2,000, by a higher speed or a"),
    (("DAY", "--frames", "3", "--from", "99999"), "--from 99999: the run ends at "),
    (("DAY", "--frames", "3", "--from", "9", "--to", "8"), "--to 8: expected a time from 9 s on"),
    (("DAY", "--out", "DAY"), "cannot be written: a folder has that name"),
)
def test_what_cannot_be_done(day, capsys, arguments, sentence) -> None:
    assert called(*(str(day) if argument == "DAY" else argument for argument in arguments)) == 2
    said = capsys.readouterr().err
    assert sentence in said
    assert len(said.splitlines()) == 1


NEAREST = "Store a pod in the nearest free storage location; send an order to the nearest packing station."


def test_what_the_page_is_told(replay: Replay, day: Path) -> None:
    found = told(replay)
    assert found["name"] == "day"
    assert found["status"] == "complete"
    assert found["tick"] == replay.tick > 0
    assert len(found["layout"]["kind"]) == found["layout"]["width"] * found["layout"]["height"]
    assert len(found["orders"]["name"]) == 20
    assert ["Visits per order", f"{replay.metrics['psv_per_order']:.2f}"] in found["metrics"]
    assert found["says"] == load_result(day).summary["bottleneck"]["says"] != []
    assert found["about"]["nearest"] == NEAREST
    assert sum(found["legs"]["n"]) == len(found["legs"]["gap"])
    assert "due" not in found["orders"]
    json.dumps(found, allow_nan=False)


def declared(name: str) -> dict[str, str]:
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", (VIEW / "types.d.ts").read_text(encoding="utf-8"), flags=re.DOTALL)
    body = re.search(rf"^export type {name} = \{{\n(.*?)^\}};", text, re.DOTALL | re.MULTILINE)
    assert body
    return dict(re.findall(r"^  (\w+): (.*?);$", body[1], re.DOTALL | re.MULTILINE))


def test_the_types_of_the_page_are_what_it_is_told(day: Path) -> None:
    found = told(read_replay(day))
    events = {name: {"tick", *re.findall(r'"(\w+)"', columns)} for name, columns in declared("ToldEvents").items()}
    assert {name: set(columns) for name, columns in found["events"].items()} == events
    run = declared("ToldRun")
    assert found.keys() == run.keys()
    for key, kind in run.items():
        if kind.startswith("{"):
            names = re.findall(r"(\w+)(\??):", kind)
            assert (
                {name for name, optional in names if not optional} <= found[key].keys() <= {name for name, _ in names}
            )
    decisions = {*re.findall(r'"(\w+)"', run["decisions"]), "texts"}
    assert found["decisions"].keys() == decisions


def test_packing_stations_are_told(tmp_path: Path) -> None:
    few = ["instance.orders=6", "rules.pp=free-flow"]
    rmfs_core.run("examples/packing", overrides=few, out=tmp_path, record=["trace"])
    found = told(read_replay(tmp_path))
    assert found["packing"] == {"stations": 2, "boxes": 10, "packers": 1, "sorters": 0, "until_picked": False}
    assert len(found["events"]["order_packed"]["order"]) == 6
    assert [label for label, _ in found["metrics"]][:2] == ["Turn-over time", "Time to packed"]


def test_metrics_are_as_the_summary_has_them() -> None:
    values = {"turnover_s": 1234.56, "picker_utilisation": 0.512, "orders_per_hour": None}
    assert metrics_of(values) == [["Turn-over time", "1,234.6 s"], ["Picker utilisation", "51.2 %"]]


def test_rules_with_parameters_have_their_names() -> None:
    rules = {"poa_pps": {"rule": "lns", "iterations": 3}, "pr": "nearest", "poa": None, "filters": []}
    assert rules_of({"rules": rules}) == {"POA+PPS": "lns", "PR": "nearest"}
    more = {"roa": "first-bundle", "rps": {"rule": "random"}, "idle": "stay", "move": "cache", "activate": "all"}
    assert rules_of({"rules": more}) == {
        "ROA": "first-bundle",
        "RPS": "random",
        "activation": "all",
        "idle": "stay",
        "repositioning": "cache",
    }
    assert summaries({"./my.py:Mine", "nearest"}) == {"nearest": NEAREST}


def test_stations_tell_how_many_bundles_they_take(restocked: Path, replay: Replay) -> None:
    assert told(read_replay(restocked))["stations"]["bundle_capacity"] == [0, 0, 10]
    assert told(replay)["stations"]["bundle_capacity"] == [0] * len(replay.start.stations)
