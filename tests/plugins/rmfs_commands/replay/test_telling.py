"""What the page of a replay is told."""

from __future__ import annotations

import json
import re
from pathlib import Path

from rmfs_commands.replay.page import VIEW
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.replay.telling import metrics_of, rules_of, summaries, told


def test_what_the_page_is_told(replay: Replay) -> None:
    """Names, layout, rules with what they do, and the metrics of the result."""
    found = told(replay)
    assert found["name"] == "day"
    assert found["status"] == "complete"
    assert found["tick"] == replay.tick > 0
    assert len(found["layout"]["kind"]) == found["layout"]["width"] * found["layout"]["height"]
    assert len(found["orders"]["name"]) == 20
    assert ["Visits per order", f"{replay.metrics['psv_per_order']:.2f}"] in found["metrics"]
    assert found["about"]["nearest"] == "Store a pod in the nearest free storage location."
    assert sum(found["legs"]["n"]) == len(found["legs"]["gap"])
    assert "due" not in found["orders"]
    json.dumps(found, allow_nan=False)


def declared(name: str) -> dict[str, str]:
    """Return the keys of a type of the page's JavaScript with their types."""
    text = re.sub(r"//[^\n]*|/\*.*?\*/", "", (VIEW / "types.d.ts").read_text(encoding="utf-8"), flags=re.DOTALL)
    body = re.search(rf"^export type {name} = \{{\n(.*?)^\}};", text, re.DOTALL | re.MULTILINE)
    assert body
    return dict(re.findall(r"^  (\w+): (.*?);$", body[1], re.DOTALL | re.MULTILINE))


def test_the_types_of_the_page_are_what_it_is_told(day: Path) -> None:
    """Every key and column is declared, and no other: what the JavaScript is checked against is true."""
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


def test_metrics_are_as_the_summary_has_them() -> None:
    """Rounded, with their units; what a run has no figure of is left out."""
    values = {"turnover_s": 1234.56, "picker_utilisation": 0.512, "orders_per_hour": None}
    assert metrics_of(values) == [["Turn-over time", "1,234.6 s"], ["Picker utilisation", "51.2 %"]]


def test_rules_with_parameters_have_their_names() -> None:
    """A scenario gives a rule alone, or in a table with parameters; a joint rule decides two things."""
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
    assert summaries({"./my.py:Mine", "nearest"}) == {"nearest": "Store a pod in the nearest free storage location."}


def test_stations_tell_how_many_bundles_they_take(restocked: Path, replay: Replay) -> None:
    """Those that store none take 0."""
    assert told(read_replay(restocked))["stations"]["bundle_capacity"] == [0, 0, 10]
    assert told(replay)["stations"]["bundle_capacity"] == [0] * len(replay.start.stations)
