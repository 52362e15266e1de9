"""What metrics are called, and how they are shown."""

from __future__ import annotations

import re
from types import SimpleNamespace

import pytest

from rmfs_core.errors import InputError
from rmfs_core.results.catalogue import TIMING, Metric, by_heading, described_by, show


@pytest.mark.parametrize(
    ("metric", "value", "text"),
    [
        (Metric("walked_m", digits=1), 12345.678, "12,345.7"),
        (Metric("walked_m"), 0.005, "0.01"),
        (Metric("walks", digits=0), 12345, "12,345"),
        (Metric("walks", digits=2), 7, "7"),  # a whole number is shown whole
        (Metric("walks"), None, "-"),
        (Metric("busy", unit="%", digits=1, scale=100), 0.4567, "45.7"),  # a share, shown in percent
        (Metric("busy", scale=100), None, "-"),
    ],
)
def test_values_are_shown_for_people(metric: Metric, value: float | None, text: str) -> None:
    """Rounded, thousands separated, a dash for nothing."""
    assert show(metric, value) == text


def test_every_figure_is_described_once() -> None:
    """Names are keys of result.json; each has a sentence."""
    names = [metric.name for metric in TIMING]
    assert len(names) == len(set(names))
    for metric in TIMING:
        assert re.fullmatch(r"[a-z][a-z0-9_]*", metric.name)
        assert metric.meaning.endswith("."), metric.name


def test_a_metric_of_a_third_party_is_called_by_its_name_where_it_has_no_label() -> None:
    """Everything but the name may be left out."""
    assert Metric("queries").label == "queries"
    assert Metric("queries", "Path queries").label == "Path queries"


def test_observers_describe_what_they_measure() -> None:
    """By name, of all observers; most measure nothing."""
    walks, runs = Metric("walks"), Metric("runs")
    found = described_by([object(), SimpleNamespace(measures=(walks,)), SimpleNamespace(measures=[runs])])
    assert found == {"walks": walks, "runs": runs}


def test_the_first_description_counts() -> None:
    """Who is asked first has told first, and has the name."""
    walks = Metric("walks", "Walks")
    assert described_by([SimpleNamespace(measures=(walks,)), SimpleNamespace(measures=(Metric("walks"),))]) == {
        "walks": walks
    }


def test_metrics_stand_under_their_headings() -> None:
    """Headings as they were measured, under each as described; what has none is left out, what nobody knows is bare."""
    walks, runs = Metric("walks", group="Ways"), Metric("runs", group="Ways")
    hidden, absent = Metric("hidden", group=None), Metric("absent", group="Nowhere")
    described = {metric.name: metric for metric in (walks, runs, hidden, absent)}
    found = by_heading(["bare", "runs", "hidden", "walks"], described)
    assert found == {"Observers": [Metric("bare")], "Ways": [walks, runs]}
    assert list(found) == ["Observers", "Ways"]


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


@pytest.mark.parametrize(
    "wrong", [{"label": 5}, {"unit": None}, {"label": "two\nlines"}, {"digits": -1}, {"digits": 10**9}, {"digits": "2"}]
)
def test_a_metric_is_shown_on_a_line(wrong: dict[str, object]) -> None:
    """What a table could not show is refused when it is made."""
    with pytest.raises(ValueError, match="expected texts of one line and 0 to 15 digits, found Metric"):
        Metric("legs", **wrong)  # type: ignore[arg-type]


def test_measures_that_cannot_be_read_are_one_sentence() -> None:
    """With the class that has them."""

    class Watching:
        @property
        def measures(self) -> tuple[Metric, ...]:
            raise LookupError("none")

    expected = r"class Watching: expected `measures` to be .*, found LookupError\('none'\)"
    with pytest.raises(InputError, match=expected):
        described_by([Watching()])
