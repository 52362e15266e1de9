"""Running a scenario into a folder."""

from pathlib import Path

import pytest

import rmfs_core
from rmfs_core.cli import main


def test_results_never_replace_the_input(tmp_path: Path) -> None:
    """A scenario with an orders.csv of its own is not run into that folder."""
    main(["generate", "examples/small", "--out", str(tmp_path / "data")])
    before = (tmp_path / "data" / "orders.csv").read_bytes()
    with pytest.raises(rmfs_core.InputError, match=r"results would replace `instance\.orders_file`, orders\.csv"):
        rmfs_core.run(tmp_path / "data" / "scenario.toml", out=tmp_path / "data")
    assert (tmp_path / "data" / "orders.csv").read_bytes() == before


def test_results_never_replace_what_is_no_result(tmp_path: Path) -> None:
    """A folder that holds somebody's orders.csv, but no result, is refused; one with a result is used again."""
    (tmp_path / "orders.csv").write_text("mine", encoding="utf-8")
    with pytest.raises(rmfs_core.InputError, match=r"found a file orders\.csv that no run of rmfs has written"):
        rmfs_core.run("examples/small", out=tmp_path)
    assert (tmp_path / "orders.csv").read_text(encoding="utf-8") == "mine"
    for seed in (1, 2):
        rmfs_core.run("examples/small", seed=seed, out=tmp_path / "new")


def test_a_pod_more_than_needed_is_no_error(tmp_path: Path) -> None:
    """A PPS rule may send two pods for one uncovered request: wasteful, not impossible."""
    (tmp_path / "rule.py").write_text(
        "from attrs import define\nfrom rmfs_core import PodTrip, hookimpl\n\n@define\nclass Two:\n"
        "    @hookimpl\n    def select_pods(self, warehouse, max_fetches):\n"
        "        trips, used = [], set()\n"
        "        for station in warehouse.stations:\n"
        "            wanted = {request.sku for request in station.uncovered_requests}\n"
        "            fits = [pod for pod in warehouse.free_pods if wanted & set(pod.contents) and pod.id not in used]\n"
        "            for pod in fits[:2][: max_fetches - len(trips)]:\n"
        "                used.add(pod.id)\n                trips.append(PodTrip(pod.id, station.id))\n"
        "        return trips\n",
        encoding="utf-8",
    )
    (tmp_path / "s.toml").write_text(
        '[instance]\norders = 30\n[rules]\npoa = "pod-match"\npps = "./rule.py:Two"\n', encoding="utf-8"
    )
    assert rmfs_core.run(tmp_path / "s.toml").metrics["orders_completed"] == 30


def test_how_metrics_are_shown_is_checked_before_the_run() -> None:
    """What an observer says of its metrics has to be `Metric`s."""

    class Watching:
        measures = ("legs",)

        @rmfs_core.hookimpl
        def run_started(self) -> None:
            raise AssertionError

    with pytest.raises(rmfs_core.InputError, match=r"class Watching: expected `measures` to be a tuple of .*Metric"):
        rmfs_core.run("examples/small", observers=[Watching()])
