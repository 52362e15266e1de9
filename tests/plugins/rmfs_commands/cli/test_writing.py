"""Files that commands write: instances as CSV, layouts as text maps."""

from collections.abc import Callable
from pathlib import Path

import pytest
from attrs import evolve

from calling import exit_code
from rmfs_commands.cli.main import main
from rmfs_commands.layouts import block_map
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import InstanceSection, load_scenario, shipped_scenarios
from rmfs_core.world import make_instance, make_layout

RULE = '''"""Orders and pods as listed in a file, or as they come."""
from pathlib import Path
from attrs import define
from rmfs_core import hookimpl
@define
class Mine:
    """Reads a file, if there is one."""
    plan: Path | None = None
    note: str = ""
    @hookimpl
    def assign_orders(self, warehouse): return []
    @hookimpl
    def select_pods(self, warehouse): return []
    @hookimpl
    def filter_backlog(self, warehouse, orders): return orders
'''


@pytest.mark.parametrize("name", shipped_scenarios())
def test_the_written_scenario_has_the_same_instance(name: str, tmp_path: Path) -> None:
    main(["generate", name, "--seed", "4", "--out", str(tmp_path / "new" / "folder")])
    before = load_scenario(name, seed=4)
    after = load_scenario(tmp_path / "new" / "folder" / "scenario.toml")
    assert make_instance(after) == make_instance(before)
    assert evolve(after, instance=InstanceSection()) == evolve(before, instance=InstanceSection())
    assert after.instance.pods_at_stations == before.instance.pods_at_stations


def test_files_in_the_way(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "pods.csv").write_text("mine", encoding="utf-8")
    assert exit_code("generate", "examples/small", "--out", str(tmp_path)) == 2
    assert capsys.readouterr().err == (
        f"Error: {tmp_path / 'pods.csv'}: found a file of that name; --force replaces it\n"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["pods.csv"]
    main(["generate", "examples/small", "--out", str(tmp_path), "--force"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["orders.csv", "pods.csv", "scenario.toml"]
    assert (tmp_path / "pods.csv").read_text(encoding="utf-8") != "mine"


def test_the_map_rules_in_files_and_files_of_parameters_come_along(
    install: Callable[..., None], tmp_path: Path
) -> None:
    source = """
from pathlib import Path
@define
class Places:
    file: Path
    @hookimpl
    def choose_storage_location(self, warehouse, pod): return 0
"""
    install("acme", {"places": "acme_rules:Places"}, acme_rules=source)
    old, new = tmp_path / "old", tmp_path / "new"
    (old / "plans").mkdir(parents=True)
    (old / "mine.py").write_text(RULE, encoding="utf-8")
    (old / "plans" / "a.csv").write_text("a\n", encoding="utf-8")
    (old / "plans" / "b.csv").write_text("b\n", encoding="utf-8")
    (old / "orders.csv").write_text("no orders\n", encoding="utf-8")
    (tmp_path / "a.csv").write_text("elsewhere\n", encoding="utf-8")
    small = load_scenario("examples/small")
    (old / "plans" / "hall.txt").write_text(block_map(small.layout, 12), encoding="utf-8")
    chosen = (
        '[layout]\nmap_file = "plans/hall.txt"\n'
        '[rules.poa]\nrule = "./mine.py:Mine"\nplan = "plans/../plans/a.csv"\nnote = "orders.csv"\n'
        '[rules.pps]\nrule = "./mine.py:Mine"\nplan = "orders.csv"\n'
        '[rules.pr]\nrule = "switch"\ncases = [{ rule = "places", parameters = { file = "plans/b.csv" } }]\n'
        '[[rules.filters]]\nrule = "./mine.py:Mine"\nplan = "../a.csv"\n'
    )
    (old / "scenario.toml").write_text(chosen, encoding="utf-8")
    main(["generate", str(old / "scenario.toml"), "--set", "instance.orders=3", "--out", str(new)])
    old.rename(tmp_path / "gone")
    scenario = load_scenario(new / "scenario.toml")
    assert scenario.layout.map_file == "hall.txt"
    assert make_layout(scenario).storage_locations == make_layout(small).storage_locations
    rules = RuleSet.load(scenario.rules, scenario.folder)
    assert (rules.poa.instance.plan, rules.poa.instance.note) == (new / "plans" / "a.csv", "orders.csv")
    assert rules.pps.instance.plan == new / "orders_2.csv"
    assert rules.filters[0].instance.plan == new / "a.csv"  # the other one is in plans/
    read = [one.file.read_text(encoding="utf-8") for one in rules.files]
    assert read == ["a\n", "no orders\n", "b\n", "elsewhere\n"]
