"""The warehouse that RAWSim-O has run, too: items per hour compared with its own."""

import random
from pathlib import Path
from statistics import mean

import pytest

import rmfs_core
from rmfs_commands.validation import validate_trace
from rmfs_core.scenario.reading import shipped_folder

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
    """All orders that RAWSim-O wrote out are orders here, and none appears again after others."""
    result = rmfs_core.run("parity/rawsim-o", overrides=["run.until_s=1"])
    named = {row.partition(",")[0] for row in (FOLDER / "orders.csv").read_text().splitlines()[1:]}
    assert len(named) == result.metrics["orders_total"] == 6024
    assert "appears again" not in capsys.readouterr().err


def test_sipp_runs_it_too(tmp_path: Path) -> None:
    settings = ("rules.pp=sipp", "robots.count=16", "stations.release=handled", "run.until_s=300")
    result = rmfs_core.run("parity/rawsim-o", overrides=settings, out=tmp_path, record=["trace"])
    assert (result.metrics["picks"] or 0) > 50
    assert validate_trace(tmp_path) == []
