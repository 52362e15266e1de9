"""Runs against the paper's statements (Xie, Thieme, Krenzler, Li, arXiv:1902.03092), and against RAWSim-O."""

import random
from itertools import product
from pathlib import Path
from statistics import mean

import pytest

import rmfs_core
from rmfs_core.scenario.reading import shipped_folder

IMPLIED_MAKESPAN_S = 3571
"""Computing time per order x 250 orders / share of simulated time (the paper's tables): the makespan they imply."""


def test_example_2_sequential() -> None:
    result = rmfs_core.run("examples/example-2-sequential")
    assert result.status == "complete"
    assert {row["order"]: row["stations"] for row in result.orders} == {"1": "2", "2": "1", "3": "1", "4": "2"}
    assert result.metrics["pod_station_visits"] == 6
    assert result.metrics["pile_on"] == 2.0
    first = [(row["pod"], row["station"]) for row in result.visits[:2]]
    assert first == [("1", "1"), ("2", "2")]
    rest = sorted((row["pod"], row["station"]) for row in result.visits[2:])
    assert rest == [("3", "1"), ("3", "2"), ("4", "1"), ("4", "2")]


@pytest.mark.slow
def test_makespan_of_the_250_order_instances() -> None:
    makespans = {}
    for skus, pods, alpha in product((20, 100), (50, 100), (2, 3)):
        overrides = [f"instance.skus={skus}", f"instance.pods={pods}", f"instance.skus_per_pod={alpha}"]
        result = rmfs_core.run("paper-250", overrides=overrides)
        assert result.status == "complete"
        makespans[skus, pods, alpha] = result.metrics["makespan_s"]
    assert mean(makespans.values()) == pytest.approx(IMPLIED_MAKESPAN_S, rel=0.25), makespans


FOLDER = shipped_folder() / "parity"
RAWSIM_O = [
    ("8 robots, picked", ("stations.release=picked",), 744, 0.03),
    ("16 robots, picked", ("stations.release=picked", "robots.count=16"), 1092, 0.01),
    ("8 robots, handled", ("stations.release=handled",), 702, 0.06),
]


def started_elsewhere(seed: int, file: Path) -> str:
    """Let the robots change their start places; return the setting with the file of them."""
    head, *rows = (FOLDER / "robots.csv").read_text().splitlines()
    places = [row.split(",", 1)[1] for row in rows]
    random.Random(seed).shuffle(places)
    file.write_text("\n".join([head, *(f"{i},{place}" for i, place in enumerate(places, 1))]) + "\n")
    return f"robots.file={file}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "items", "within"), [row[1:] for row in RAWSIM_O], ids=[row[0] for row in RAWSIM_O]
)
def test_items_per_hour_are_those_of_rawsim_o(settings, items, within, tmp_path) -> None:
    starts = [started_elsewhere(seed, tmp_path / f"{seed}.csv") for seed in range(3)]
    results = [rmfs_core.run("parity/rawsim-o", overrides=[*settings, start]) for start in starts]
    assert mean(result.metrics["picks_per_hour"] or 0 for result in results) == pytest.approx(items, rel=within)


def test_every_order_has_a_name_of_its_own(capsys: pytest.CaptureFixture[str]) -> None:
    result = rmfs_core.run("parity/rawsim-o", overrides=["run.until_s=1"])
    named = {row.partition(",")[0] for row in (FOLDER / "orders.csv").read_text().splitlines()[1:]}
    assert len(named) == result.metrics["orders_total"] == 6024
    assert "appears again" not in capsys.readouterr().err
