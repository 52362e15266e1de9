"""`rmfs generate`: instances as CSV files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from attrs import evolve

from rmfs_commands.cli.main import main
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import InstanceSection, load_scenario, shipped_scenarios
from rmfs_core.world import block_map, make_instance, make_layout

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
    def assign_orders(self, warehouse):
        return []

    @hookimpl
    def select_pods(self, warehouse):
        return []

    @hookimpl
    def filter_backlog(self, warehouse, orders):
        return orders
'''


@pytest.mark.parametrize("name", shipped_scenarios())
def test_the_written_scenario_has_the_same_instance(name: str, tmp_path: Path) -> None:
    """The scenario in the folder differs in where its orders and pods come from, and in nothing else."""
    main(["generate", name, "--seed", "4", "--out", str(tmp_path / "new" / "folder")])
    before = load_scenario(name, seed=4)
    after = load_scenario(tmp_path / "new" / "folder" / "scenario.toml")
    assert make_instance(after) == make_instance(before)
    assert evolve(after, instance=InstanceSection()) == evolve(before, instance=InstanceSection())
    assert after.instance.pods_at_stations == before.instance.pods_at_stations


def test_files_that_are_there_are_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without --force nothing is replaced, and nothing is written beside it; with it, everything is."""
    (tmp_path / "pods.csv").write_text("mine", encoding="utf-8")
    with pytest.raises(SystemExit) as stop:
        main(["generate", "examples/small", "--out", str(tmp_path)])
    assert stop.value.code == 2
    assert capsys.readouterr().err == (
        f"Error: {tmp_path / 'pods.csv'}: found a file of that name; --force replaces it\n"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["pods.csv"]
    main(["generate", "examples/small", "--out", str(tmp_path), "--force"])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["orders.csv", "pods.csv", "scenario.toml"]
    assert (tmp_path / "pods.csv").read_text(encoding="utf-8") != "mine"


def test_a_file_in_the_way_of_the_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The output folder cannot be a file."""
    (tmp_path / "out").write_text("", encoding="utf-8")
    with pytest.raises(SystemExit) as stop:
        main(["generate", "examples/small", "--out", str(tmp_path / "out")])
    assert stop.value.code == 2
    assert "Traceback" not in capsys.readouterr().err


def test_maps_and_rules_in_files_come_along(tmp_path: Path) -> None:
    """A scenario that names files of its own folder works in the new folder as well."""
    small = load_scenario("examples/small")
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "hall.txt").write_text(block_map(small.layout, 12), encoding="utf-8")
    (tmp_path / "mine.py").write_text(RULE, encoding="utf-8")
    (tmp_path / "mine.toml").write_text(
        '[layout]\nmap_file = "maps/hall.txt"\n[rules]\npoa = "./mine.py:Mine"\npps = "demand"\n', encoding="utf-8"
    )
    main(["generate", str(tmp_path / "mine.toml"), "--out", str(tmp_path / "new"), "--set", "instance.pods=20"])
    scenario = load_scenario(tmp_path / "new" / "scenario.toml")
    assert scenario.layout.map_file == "hall.txt"
    assert make_layout(scenario).storage_locations == make_layout(small).storage_locations
    assert (tmp_path / "new" / "mine.py").read_text(encoding="utf-8") == RULE


def test_rules_from_elsewhere_come_along(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files of rules that the command line names lie in the new folder, each under a name of its own."""
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "mine.py").write_text(f"{RULE}\nNAME = {name!r}\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path / "one")
    chosen = ["rules.poa=./mine.py:Mine", "rules.pps=../two/mine.py:Mine", 'rules.filters=["./mine.py:Mine"]']
    main(["generate", "examples/small", "--out", "../new", *(word for one in chosen for word in ("--set", one))])
    rules = load_scenario(tmp_path / "new" / "scenario.toml").rules
    assert rules.poa is not None
    assert rules.pps is not None
    assert (rules.poa.rule, rules.pps.rule) == ("./mine.py:Mine", "./mine_2.py:Mine")
    assert [choice.rule for choice in rules.filters] == ["./mine.py:Mine"]
    assert "two" in (tmp_path / "new" / "mine_2.py").read_text(encoding="utf-8")


def test_files_that_parameters_name_come_along(install: Callable[..., None], tmp_path: Path) -> None:
    """They are in the new folder under names that the rules find there, also in rules of rules; other texts stay."""
    source = """
from pathlib import Path

@define
class Places:
    file: Path

    @hookimpl
    def choose_storage_location(self, warehouse, pod):
        return 0
"""
    install("acme", {"places": "acme_rules:Places"}, acme_rules=source)
    old, new = tmp_path / "old", tmp_path / "new"
    (old / "plans").mkdir(parents=True)
    (old / "mine.py").write_text(RULE, encoding="utf-8")
    (old / "plans" / "a.csv").write_text("a\n", encoding="utf-8")
    (old / "plans" / "b.csv").write_text("b\n", encoding="utf-8")
    (old / "orders.csv").write_text("no orders\n", encoding="utf-8")
    (tmp_path / "a.csv").write_text("elsewhere\n", encoding="utf-8")
    chosen = (
        '[rules.poa]\nrule = "./mine.py:Mine"\nplan = "plans/../plans/a.csv"\nnote = "orders.csv"\n'
        '[rules.pps]\nrule = "./mine.py:Mine"\nplan = "orders.csv"\n'
        '[rules.pr]\nrule = "switch"\ncases = [{ rule = "places", parameters = { file = "plans/b.csv" } }]\n'
        '[[rules.filters]]\nrule = "./mine.py:Mine"\nplan = "../a.csv"\n'
    )
    (old / "scenario.toml").write_text(chosen, encoding="utf-8")
    main(["generate", str(old / "scenario.toml"), "--set", "instance.orders=3", "--out", str(new)])
    old.rename(tmp_path / "gone")
    scenario = load_scenario(new / "scenario.toml")
    rules = RuleSet.load(scenario.rules, scenario.folder)
    assert rules.poa is not None
    assert rules.pps is not None
    assert (rules.poa.instance.plan, rules.poa.instance.note) == (new / "plans" / "a.csv", "orders.csv")
    assert rules.pps.instance.plan == new / "orders_2.csv"
    assert rules.filters[0].instance.plan == new / "a.csv"  # the other one is in plans/
    read = [one.file.read_text(encoding="utf-8") for one in rules.files]
    assert read == ["a\n", "no orders\n", "b\n", "elsewhere\n"]
