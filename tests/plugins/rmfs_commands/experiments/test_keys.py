"""The hash that names a run: what counts, and what does not."""

import shutil
from pathlib import Path

import pytest
from attrs import evolve

from rmfs_commands.experiments.keys import run_key
from rmfs_commands.experiments.sources import sources_of
from rmfs_core import RuleError, run
from rmfs_core.errors import InputError
from rmfs_core.results.running import versions_of
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import RuleChoice, Scenario, load_scenario

VERSIONS = {"rmfs": "0.1.0", "other": "2"}
SOURCES = {"rmfs_core": "sha256:1", "mine": "sha256:2"}
MAP = "........\n.##.##..\n.##.##..\n........\n.##.##.qqqO\n.##.##.@@@.\n...........\n"


@pytest.fixture
def scenario(folder: Path) -> Scenario:
    """Return a scenario that names files of every kind."""
    (folder / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,a,1\n", encoding="utf-8")
    (folder / "pods.csv").write_text("pod,sku,quantity\np,a,\n", encoding="utf-8")
    (folder / "map.txt").write_text(MAP, encoding="utf-8")
    (folder / "files.toml").write_text(
        '[instance]\norders_file = "orders.csv"\npods_file = "pods.csv"\n[layout]\nmap_file = "map.txt"\n'
        '[stations]\nqueue_length = 3\n[rules]\npoa = "pod-match"\npps = "demand"\npr = "./bad.py:Raising"\n'
        'ta = { rule = "balanced", reallocation_s = 5.0, help_others = true }\n',
        encoding="utf-8",
    )
    return load_scenario(folder / "files.toml")


def key_of(scenario: Scenario, seed: int = 1) -> str:
    """Return the key of a run of a scenario with the rules that are installed."""
    rules = RuleSet.load(scenario.rules, scenario.folder)
    return run_key(scenario, versions_of(rules, scenario), sources_of(rules, scenario))(seed)


def test_seed_values_versions_and_code_count(scenario: Scenario) -> None:
    """Another seed, value, rule, parameter, version or code is another run."""
    keys = [
        run_key(scenario, VERSIONS, SOURCES)(1),
        run_key(scenario, VERSIONS, SOURCES)(2),
        run_key(scenario, VERSIONS, {**SOURCES, "mine": "sha256:3"})(1),
        run_key(scenario, {**VERSIONS, "rmfs": "0.1.1"}, SOURCES)(1),
        run_key(scenario, {**VERSIONS, "other": "3"}, SOURCES)(1),
        run_key(evolve(scenario, robots=evolve(scenario.robots, count=3)), VERSIONS, SOURCES)(1),
        run_key(load_scenario(f"{scenario.folder}/files.toml", ["rules.poa=first-come"]), VERSIONS, SOURCES)(1),
        run_key(load_scenario(f"{scenario.folder}/files.toml", ["rules.ta.help_others=false"]), VERSIONS, SOURCES)(1),
    ]
    assert len(set(keys)) == len(keys)


def test_the_hours_of_a_profile_count(tmp_path: Path) -> None:
    """A file that a key within a section of a section names is one, too."""
    file = tmp_path / "hours.csv"
    keys = set()
    for weight in (1, 2):
        file.write_text(f"hour,weight\n9,{weight}\n", encoding="utf-8")
        keys.add(run_key(load_scenario("grocery-day", [f"instance.arrivals.profile={file}"]), VERSIONS, SOURCES)(1))
    assert len(keys) == 2


@pytest.mark.parametrize("name", ["orders.csv", "pods.csv", "map.txt", "bad.py"])
def test_the_contents_of_files_count(scenario: Scenario, name: str) -> None:
    """A change in a file of orders, pods, layout or rules that the scenario names makes another run."""
    before = key_of(scenario)
    file = Path(scenario.folder) / name
    file.write_text(file.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert key_of(scenario) != before


def test_the_files_of_parameters_count(folder: Path) -> None:
    """A policy that was trained anew is another run; the same in another folder is the same."""
    reading = RuleChoice("./bad.py:Reading", {"weights": "w.txt"})
    keys = []
    for number in ("1", "2", "1"):
        (folder / "w.txt").write_text(number, encoding="utf-8")
        tiny = load_scenario(folder / "tiny.toml")
        keys.append(key_of(evolve(tiny, rules=evolve(tiny.rules, pr=reading))))
    elsewhere = folder / "elsewhere"
    shutil.copytree(folder, elsewhere, ignore=shutil.ignore_patterns("elsewhere"))
    keys.append(key_of(evolve(load_scenario(elsewhere / "tiny.toml"), rules=evolve(tiny.rules, pr=reading))))
    assert keys[0] != keys[1]
    assert keys[0] == keys[2] == keys[3]


def test_place_and_order_do_not_count(scenario: Scenario, tmp_path: Path) -> None:
    """The same files in another folder, keys in another order, and a default written out are the same run."""
    before = key_of(scenario)
    elsewhere = tmp_path / "elsewhere"
    shutil.copytree(scenario.folder, elsewhere, ignore=shutil.ignore_patterns("elsewhere"))
    text = (elsewhere / "files.toml").read_text(encoding="utf-8")
    rules, _, rest = text.partition("[rules]\n")
    swapped = "\n".join(reversed(rest.strip().splitlines()))
    swapped = swapped.replace("reallocation_s = 5.0, help_others = true", "help_others = true, reallocation_s = 5.0")
    (elsewhere / "other.toml").write_text(
        f"seed = 9\n[rules]\n{swapped}\n{rules}[robots]\ncount = 8\n", encoding="utf-8"
    )
    moved = load_scenario(elsewhere / "other.toml")
    assert moved.folder != scenario.folder
    assert key_of(moved) == before


def test_the_versions_are_those_of_the_result(folder: Path) -> None:
    """A run's result.json has the versions that went into its key."""
    scenario = load_scenario(folder / "tiny.toml", [f"rules.pr={folder}/bad.py:Raising"])
    rules = RuleSet.load(scenario.rules, scenario.folder)
    with pytest.raises(RuleError) as caught:
        run(scenario)
    assert caught.value.result is not None
    assert caught.value.result.versions == versions_of(rules, scenario)


def test_a_missing_file_is_named(scenario: Scenario) -> None:
    """A file that cannot be read is an error with the key that names it."""
    (Path(scenario.folder) / "orders.csv").unlink()
    with pytest.raises(InputError, match=r"instance.orders_file: cannot read .*orders.csv"):
        run_key(scenario, VERSIONS, SOURCES)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("/dev/zero", "found /dev/zero, a device; expected a file, which each run can read anew"),
        ("a\0b", "a\0b: embedded null byte"),
        ("none.txt", "none.txt: No such file or directory"),
    ],
)
def test_what_no_run_can_read_has_no_key(scenario: Scenario, name: str, problem: str) -> None:
    """With the key of the scenario that names it."""
    named = evolve(scenario, layout=evolve(scenario.layout, map_file=name))
    with pytest.raises(InputError) as caught:
        run_key(named, VERSIONS, SOURCES)
    assert caught.value.place == "layout.map_file"
    assert caught.value.problem.endswith(problem)
