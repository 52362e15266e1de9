"""Running through the library, and the result's files."""

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.details.loading import load_result
from rmfs_core import InputError, Result, RuleError, hookimpl, load_scenario
from rmfs_core.results.catalogue import Metric
from rmfs_core.scenario.model import RunSection

SCENARIO = """
seed = 5
[instance]
orders = 10
skus = 10
pods = 8
skus_per_pod = 3
[layout]
block_rows = 3
block_columns = 2
stations_east = 1
[robots]
count = 3
[rules]
poa = "pod-match"
pps = "demand"
"""

FAILING_RULE = """
import attrs
from rmfs_core import Path, hookimpl

@attrs.define
class Failing:
    @hookimpl
    def plan_path(self, warehouse, robot, goal):
        if any(order.unpicked_items < order.items for order in warehouse.orders):
            raise ValueError("out of ideas")
        return Path(warehouse.travel.fastest_path(robot.cell, robot.heading, goal, robot.pod is not None))
"""

FILES = {
    "result.json",
    "orders.csv",
    "visits.csv",
    "periods.csv",
    "hours.csv",
    "stations.csv",
    "robots.csv",
    "delays.csv",
}


class Interrupting:
    """Observer that acts as if a person pressed Ctrl-C after some events."""

    def __init__(self, after: int) -> None:
        self.left = after
        self.ended: list[tuple[int, str]] = []

    @hookimpl
    def on_event(self) -> None:
        """Interrupt when it is time."""
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        """Take note."""
        self.ended.append((tick, status))


@pytest.fixture
def scenario_file(tmp_path: Path) -> Path:
    """Return a small scenario's file, with a rule beside it that fails after the first pick."""
    (tmp_path / "failing.py").write_text(FAILING_RULE, encoding="utf-8")
    path = tmp_path / "small.toml"
    path.write_text(SCENARIO, encoding="utf-8")
    return path


def same(one: Result, other: Result) -> bool:
    """Whether two results are equal but for wall-clock times."""

    def untimed(result: Result) -> dict[str, Any]:
        content = result.to_dict()
        del content["timing"]
        periods = [{key: value for key, value in row.items() if key != "seconds"} for row in result.periods]
        return content | {"orders": result.orders, "visits": result.visits, "periods": periods}

    return untimed(one) == untimed(other)


def test_a_complete_run(scenario_file: Path) -> None:
    """Every order is complete, tables and metrics agree, and wall-clock figures are apart."""
    result = rmfs_core.run(scenario_file)
    assert (result.status, result.seed, result.error) == ("complete", 5, None)
    assert result.metrics["orders_completed"] == len(result.orders) == 10
    assert result.metrics["picks"] == sum(row["picks"] for row in result.visits)
    assert result.metrics["pod_station_visits"] == len(result.visits)
    assert result.metrics["makespan_s"] == max(row["completed_s"] for row in result.orders)
    assert result.metrics["simulated_s"] == result.metrics["makespan_s"]
    assert result.timing["wall_s"] > 0
    assert result.timing["hook_s"].keys() >= {"assign_orders", "select_pods"}
    assert {"rmfs", "python", "numpy"} <= result.versions.keys()


def test_saved_and_loaded(scenario_file: Path, tmp_path: Path) -> None:
    """A result read back is the result that was saved; the scenario in it is resolved."""
    result = rmfs_core.run(scenario_file, out=tmp_path / "out")
    loaded = load_result(tmp_path / "out")
    assert {path.name for path in (tmp_path / "out").iterdir()} == FILES
    assert loaded.to_dict() == result.to_dict()
    assert (loaded.orders, loaded.visits, loaded.periods) == (result.orders, result.visits, result.periods)
    assert loaded.scenario == result.scenario
    assert json.loads((tmp_path / "out" / "result.json").read_text())["scenario"]["stations"]["item_capacity"] == 15


def test_same_seed_same_result_and_another_seed_another(scenario_file: Path) -> None:
    """Runs of one seed are equal; a scenario object with the file's content gives the same as the file."""
    first = rmfs_core.run(scenario_file, seed=3)
    assert same(first, rmfs_core.run(load_scenario(scenario_file), seed=3))
    assert not same(first, rmfs_core.run(scenario_file, seed=4))


def test_overrides_need_a_file(scenario_file: Path) -> None:
    """Overrides change a file's values, and are refused with a scenario object."""
    assert rmfs_core.run(scenario_file, overrides=["instance.orders=4"]).metrics["orders_total"] == 4
    with pytest.raises(InputError, match="expected a scenario file"):
        rmfs_core.run(load_scenario(scenario_file), overrides=["seed=2"])


def test_a_run_that_ends_before_its_orders_do(scenario_file: Path) -> None:
    """With run.until_s the result is partial: that time is what was simulated, and there is no makespan."""
    scenario = evolve(load_scenario(scenario_file), run=RunSection(until_s=60.0))
    result = rmfs_core.run(scenario)
    assert (result.status, result.interrupted) == ("partial", False)
    assert (result.metrics["makespan_s"], result.metrics["simulated_s"]) == (None, 60.0)
    assert result.metrics["orders_completed"] < 10


def test_no_orders_at_all(scenario_file: Path, tmp_path: Path) -> None:
    """A run without orders is complete at once, and its files can be read back."""
    result = rmfs_core.run(scenario_file, overrides=["instance.orders=0"], out=tmp_path / "out")
    assert result.status == "complete"
    assert result.metrics["turnover_s"] is None
    assert load_result(tmp_path / "out").orders == []


def test_an_interrupted_run_keeps_what_was_measured(scenario_file: Path, tmp_path: Path) -> None:
    """Ctrl-C gives a partial result, saved and with its trace; observers are told of the end once."""
    observer = Interrupting(after=60)
    result = rmfs_core.run(scenario_file, observers=[observer], out=tmp_path / "out", record=["trace"])
    assert (result.status, result.interrupted) == ("partial", True)
    assert observer.ended == [(round(result.metrics["simulated_s"] * 1000), "partial")]
    assert load_result(tmp_path / "out").status == "partial"
    assert (tmp_path / "out" / "trace.jsonl.gz").exists()


def test_a_failed_run_keeps_what_was_measured(
    scenario_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The error carries the result of what was done until then, and the same is saved."""
    monkeypatch.chdir(scenario_file.parent)
    with pytest.raises(RuleError, match="out of ideas") as caught:
        rmfs_core.run(scenario_file, overrides=["rules.pp=./failing.py:Failing"], out=tmp_path / "out")
    result = caught.value.result
    assert result is not None
    assert result.status == "failed"
    assert result.metrics["picks"] > 0
    saved = load_result(tmp_path / "out")
    assert saved.to_dict() == result.to_dict()
    assert saved.error == str(caught.value)


def test_a_rule_from_the_current_folder_can_be_found_again(
    scenario_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A shipped scenario runs with it, and the saved result leads from everywhere to the same file and digest."""
    monkeypatch.chdir(scenario_file.parent)
    failing = f"{scenario_file.parent}/failing.py"
    with pytest.raises(RuleError, match="out of ideas"):
        rmfs_core.run("examples/small", overrides=["rules.pp=./failing.py:Failing"], out=tmp_path / "out")
    saved = load_result(tmp_path / "out")
    assert saved.scenario.rules.pp.rule == f"{failing}:Failing"
    assert saved.versions[failing].startswith("sha256:")
    monkeypatch.chdir(tmp_path / "out")
    with pytest.raises(RuleError, match="out of ideas") as caught:
        rmfs_core.run(saved.scenario)
    assert caught.value.result is not None
    assert caught.value.result.versions == saved.versions
    with pytest.raises(InputError, match="--no-inline-rules refuses"):
        rmfs_core.run(saved.scenario, allow_inline_rules=False)


def test_files_beside_the_scenario_are_told_apart_by_their_digest(
    scenario_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The versions of a run include the content of each file that a rule came from."""
    monkeypatch.chdir(scenario_file.parent)
    with pytest.raises(RuleError) as caught:
        rmfs_core.run(scenario_file, overrides=["rules.pp=./failing.py:Failing"])
    assert caught.value.result is not None
    assert caught.value.result.versions["failing.py"].startswith("sha256:")


def test_files_of_an_earlier_run_are_replaced(scenario_file: Path, tmp_path: Path) -> None:
    """A folder describes one run: without a new trace, the old one goes. Other files stay."""
    out = tmp_path / "out"
    rmfs_core.run(scenario_file, out=out, record=["trace"])
    (out / "notes.txt").write_text("mine")
    rmfs_core.run(scenario_file, out=out, seed=9)
    assert {path.name for path in out.iterdir()} == FILES | {"notes.txt"}
    assert load_result(out).seed == 9


def test_a_trace_needs_a_folder(scenario_file: Path) -> None:
    """Asking for a trace without saying where is an input error."""
    with pytest.raises(InputError, match="folder"):
        rmfs_core.run(scenario_file, record=["trace"])


def test_a_file_where_the_folder_should_be(scenario_file: Path) -> None:
    """It is found before anything is simulated."""
    with pytest.raises(InputError, match="expected a folder"):
        rmfs_core.run(scenario_file, out=scenario_file)


def shown_in_a_notebook(result: Result) -> list[str]:
    """Return the texts of what a notebook shows, in their order."""
    return [text.strip() for text in ElementTree.fromstring(result._repr_html_()).itertext()]


def test_a_notebook_shows_status_and_metrics() -> None:
    """With units and headings, as in the summary of a run; an observer's by its own heading, or not at all."""

    class Counting:
        measures = (Metric("legs", "Legs", "m", 1, group="Drives"), Metric("hidden", group=None))

        @hookimpl
        def measured(self) -> dict[str, float]:
            return {"legs": 2.25, "hidden": 7.0}

    result = rmfs_core.run("examples/small", observers=[Counting()])
    shown = shown_in_a_notebook(result)
    assert shown[:2] == ["complete", ", seed 1"]
    assert shown[2:5] == ["Orders", "Orders completed", "50"]
    at = shown.index("Picker utilisation")
    assert shown[at + 1 : at + 3] == ["78.8", "%"]
    assert shown[shown.index("Drives") :] == ["Drives", "Legs", "2.2", "m"]
    assert "hidden" not in shown


def test_a_notebook_takes_no_text_of_a_file_for_html(tmp_path: Path) -> None:
    """Whoever wrote the result: names, values and the error are texts."""
    rmfs_core.run("examples/small", out=tmp_path)
    file = tmp_path / "result.json"
    told = json.loads(file.read_text(encoding="utf-8"))
    evil = "<script>alert(1)</script>"
    told |= {"status": evil, "error": evil, "seed": evil}
    told["metrics"] |= {evil: 1, "picks": evil, "makespan_s": None}
    file.write_text(json.dumps(told), encoding="utf-8")
    shown = load_result(tmp_path)._repr_html_()
    assert "<script" not in shown
    assert shown.count("&lt;script&gt;alert(1)&lt;/script&gt;") == 5
    ElementTree.fromstring(shown)
