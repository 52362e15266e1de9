"""What the page of a replay is told."""

from __future__ import annotations

import json
from pathlib import Path

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
