"""What metrics are called, and how they are shown."""

from __future__ import annotations

import re
from types import SimpleNamespace

import pytest

from rmfs_core.errors import InputError
from rmfs_core.results.catalogue import METRICS, TIMING, Metric, described_by, show

EVERY = [*(metric for group in METRICS.values() for metric in group), *TIMING]


@pytest.mark.parametrize(
    ("metric", "value", "text"),
    [
        (Metric("walked_m", digits=1), 12345.678, "12,345.7"),
        (Metric("walked_m"), 0.005, "0.01"),
        (Metric("walks", digits=0), 12345, "12,345"),
        (Metric("walks", digits=2), 7, "7"),  # a whole number is shown whole
        (Metric("walks"), None, "-"),
        (Metric("picker_utilisation", unit="%", digits=1), 0.4567, "45.7"),  # a share, shown in percent
        (Metric("picker_utilisation"), None, "-"),
    ],
)
def test_values_are_shown_for_people(metric: Metric, value: float | None, text: str) -> None:
    """Rounded, thousands separated, a dash for nothing."""
    assert show(metric, value) == text


def test_every_metric_is_described_once() -> None:
    """Names are keys of result.json; each has a sentence."""
    names = [metric.name for metric in EVERY]
    assert len(names) == len(set(names))
    for metric in EVERY:
        assert re.fullmatch(r"[a-z][a-z0-9_]*", metric.name)
        assert metric.meaning.endswith("."), metric.name


def test_a_metric_of_a_third_party_is_called_by_its_name_where_it_has_no_label() -> None:
    """Everything but the name may be left out."""
    assert Metric("queries").label == "queries"
    assert Metric("queries", "Path queries").label == "Path queries"
    with pytest.raises(ValueError, match="'digits' must be >= 0"):
        Metric("queries", digits=-1)


def test_observers_describe_what_they_measure() -> None:
    """By name, of all observers; most measure nothing."""
    walks, runs = Metric("walks"), Metric("runs")
    found = described_by([object(), SimpleNamespace(measures=(walks,)), SimpleNamespace(measures=[runs])])
    assert found == {"walks": walks, "runs": runs}


@pytest.mark.parametrize("measures", ["walks", ("walks",), {"walks": 1}, Metric("walks")])
def test_a_wrong_description_is_refused(measures: object) -> None:
    """The class is named, with what was found and what would be right."""

    class Walks:
        def __init__(self) -> None:
            self.measures = measures

    with pytest.raises(InputError) as caught:
        described_by([Walks()])
    assert str(caught.value) == (
        f"class Walks: expected `measures` to be a tuple of rmfs_core.results.catalogue.Metric, found {measures!r:.80}"
    )
