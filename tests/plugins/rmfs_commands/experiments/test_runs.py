"""One run of an experiment: the hash that names it, the code that counts, its folder and its row."""

import json
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from calling import refusal
from cases import cases
from rmfs_commands.experiments import Experiment, Job
from rmfs_commands.experiments.bounds import PACKAGES
from rmfs_commands.experiments.keys import digest_of, rules_of, run_key
from rmfs_commands.experiments.outcome import Outcome, simulate
from rmfs_commands.experiments.sources import changed_since, sources_of, sources_of_world
from rmfs_commands.experiments.store import RunStore
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
    (folder / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,a,1\n", encoding="utf-8")
    (folder / "pods.csv").write_text("pod,sku,quantity\np,a,\n", encoding="utf-8")
    (folder / "map.txt").write_text(MAP, encoding="utf-8")
    (folder / "files.toml").write_text(
        '[instance]\norders_file = "orders.csv"\npods_file = "pods.csv"\n[layout]\nmap_file = "map.txt"\n'
        '[stations]\nqueue_length = 3\n[rules]\npoa = "pod-match"\npps = "demand"\n'
        'pr = { rule = "./bad.py:Reading", weights = "map.txt" }\n'
        'ta = { rule = "balanced", reallocation_s = 5.0, help_others = true }\n',
        encoding="utf-8",
    )
    return load_scenario(folder / "files.toml")


def key_of(scenario: Scenario, seed: int = 1) -> str:
    rules = RuleSet.load(scenario.rules, scenario.folder)
    return run_key(scenario, versions_of(rules, scenario), sources_of(rules, scenario))(seed)


def test_seed_values_versions_and_code_count(scenario: Scenario) -> None:
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


@pytest.mark.parametrize("rule", ["./own.py:Own", '{ rule = "learned", weights = "own.npz" }'])
def test_the_contents_of_files_count_in_the_digest_of_rules(
    scenario: Scenario, rule: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(scenario.folder)
    digests = set()
    for content in ("1", "2"):
        for name in ("own.py", "own.npz"):
            Path(name).write_text(content, encoding="utf-8")
        digests.add(digest_of(rules_of(load_scenario("files.toml", [f"rules.poa={rule}"]))))
    assert len(digests) == 2


@pytest.mark.parametrize("name", ["orders.csv", "pods.csv", "map.txt", "bad.py"])
def test_the_contents_of_files_count(scenario: Scenario, name: str) -> None:
    before = key_of(scenario)
    file = Path(scenario.folder) / name
    file.write_text(file.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert key_of(scenario) != before


@cases(
    "part given",
    ("rules", "w.txt"),
    *((part, given) for part in ("instance", "layout") for given in ("w.txt", ["w.txt", 1], {"deep": ["w.txt"]})),
)
def test_the_files_of_parameters_count(folder: Path, part: str, given: Any) -> None:
    """Also in lists and tables, and with their names: a text that is the name of a file may be just a label."""
    tiny, other = load_scenario(folder / "tiny.toml"), folder / "other.txt"
    keys = []
    named_otherwise = json.loads(json.dumps(given).replace("w", "other"))
    for number, used in (("1", given), ("2", given), ("1", given), ("1", named_otherwise)):
        (folder / "w.txt").write_text(number, encoding="utf-8")
        other.write_text(number, encoding="utf-8")
        if part == "rules":
            chosen = {"pr": RuleChoice("./bad.py:Reading", {"weights": used})}
        else:
            chosen = {"parameters": {"history": used, "name": "none such", "level": 3}}
        keys.append(key_of(evolve(tiny, **{part: evolve(getattr(tiny, part), **chosen)})))
    assert (keys[0], len({*keys})) == (keys[2], 3)


def test_place_and_order_do_not_count(scenario: Scenario, tmp_path: Path) -> None:
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
    scenario = load_scenario(folder / "tiny.toml", [f"rules.pr={folder}/bad.py:Raising"])
    rules = RuleSet.load(scenario.rules, scenario.folder)
    with pytest.raises(RuleError) as caught:
        run(scenario)
    assert caught.value.result.versions == versions_of(rules, scenario)


@cases(
    "name problem",
    ("/dev/zero", "found /dev/zero, a device; expected a file, which each run can read anew"),
    ("a\0b", "a\0b: embedded null byte"),
    ("none.txt", "none.txt: No such file or directory"),
)
def test_what_no_run_can_read_has_no_key(scenario: Scenario, name: str, problem: str) -> None:
    named = evolve(scenario, layout=evolve(scenario.layout, map_file=name))
    with pytest.raises(InputError) as caught:
        run_key(named, VERSIONS, SOURCES)
    assert caught.value.place == "layout.map_file"
    assert caught.value.problem.endswith(problem)


RULE = """
import {imported}
from attrs import define
from rmfs_core import hookimpl
@define
class Mine:
    @hookimpl
    def choose_storage_location(self, warehouse):
        return min(warehouse.free_storage_locations)
"""


def sources(scenario: Scenario) -> dict[str, str]:
    return sources_of(RuleSet.load(scenario.rules, scenario.folder), scenario)


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder on the import path: a distribution with a rule, in a package that imports two others."""
    path = tmp_path / "path"
    (path / "thing-1.0.dist-info").mkdir(parents=True)
    (path / "thing-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: thing\nVersion: 1.0\n")
    (path / "thing-1.0.dist-info" / "entry_points.txt").write_text(
        "[rmfs.rules]\nthing = spaces.thing_rules.rule:Mine\n"
    )
    for folder in ("spaces/thing_rules/deep", "thing_tools", "thing_other"):
        (path / folder).mkdir(parents=True)
    (path / "spaces" / "thing_rules" / "__init__.py").write_text("import json, thing_tools as tools\n")
    (path / "spaces" / "thing_rules" / "rule.py").write_text(RULE.format(imported="attrs"))
    (path / "spaces" / "thing_rules" / "deep" / "table.csv").write_text("1\n")
    (path / "thing_tools" / "__init__.py").write_text("def f():\n    from thing_single import one\n")
    (path / "thing_single.py").write_text("one = 1\n")
    (path / "thing_other" / "__init__.py").write_text("two = 2\n")
    monkeypatch.syspath_prepend(path)
    yield path
    for name in [name for name in sys.modules if name.startswith(("thing_", "spaces"))]:
        del sys.modules[name]


def test_what_the_selected_rules_import_counts(path: Path, folder: Path) -> None:
    found = sources(load_scenario(folder / "tiny.toml", ["rules.pr=thing"]))
    assert {"rmfs_core", "rmfs_rules.helpers", "rmfs_commands.details", "rmfs_commands.instances"} <= found.keys()
    assert {"rmfs_rules.pod_match", "rmfs_rules.demand"} <= found.keys()
    assert {"spaces.thing_rules", "thing_tools", "thing_single"} <= found.keys()
    others = {"thing_other", "attrs", "json", "numpy", "rmfs_rules.sipp", "rmfs_commands.testing"}
    assert found.keys().isdisjoint(others)
    assert all(digest.startswith("sha256:") for digest in found.values())


@cases(
    "file package",
    ("spaces/thing_rules/rule.py", "spaces.thing_rules"),
    ("spaces/thing_rules/deep/table.csv", "spaces.thing_rules"),
    ("spaces/thing_rules/deep/new.py", "spaces.thing_rules"),
    ("thing_tools/__init__.py", "thing_tools"),
    ("thing_single.py", "thing_single"),
    ("thing_other/__init__.py", None),
    ("spaces/thing_rules/__pycache__/rule.cpython-311.pyc", None),
    ("spaces/thing_rules/.rule.py.swp", None),
)
def test_a_changed_file_changes_its_package_alone(path: Path, folder: Path, file: str, package: str | None) -> None:
    scenario = load_scenario(folder / "tiny.toml", ["rules.pr=thing"])
    before = sources(scenario)
    (path / file).parent.mkdir(exist_ok=True)
    with (path / file).open("a", encoding="utf-8") as stream:
        stream.write("\n")
    after = sources(scenario)
    assert {name for name in after if after[name] != before[name]} == ({package} if package else set())
    assert after.keys() == before.keys()


def test_a_rule_that_another_asks_counts(path: Path, folder: Path) -> None:
    cases = '[{ rule = "thing", before_s = 9 }, { rule = "nearest" }]'
    found = sources(load_scenario(folder / "tiny.toml", ["rules.pr=switch", f"rules.pr.cases={cases}"]))
    asked = {"rmfs_rules.switch", "rmfs_rules.nearest", "spaces.thing_rules", "thing_tools", "thing_single"}
    assert asked <= found.keys()


def test_the_selected_generator_counts_alone(install: Callable[..., None], folder: Path) -> None:
    before = sources(load_scenario(folder / "tiny.toml"))
    modules = {"acme_days": "import acme_tools\ndef days(): ...\n", "acme_tools": "x = 1\n"}
    install("acme", {"acme-days": "acme_days:days"}, "rmfs.instances", **modules)
    assert sources(load_scenario(folder / "tiny.toml")) == before
    chosen = load_scenario(folder / "tiny.toml", ["instance.generator=acme-days"])
    assert sources(chosen).keys() - before.keys() == {"acme_days", "acme_tools"}
    assert before.keys() <= sources(chosen).keys()  # ours has the tables of results besides
    read = sources_of_world(load_scenario("examples/from-csv")).keys()
    assert (
        sources_of_world(chosen).keys() == {*read, "acme_days", "acme_tools"} >= {"rmfs_commands.layouts", "rmfs_core"}
    )
    assert "rmfs_commands.details" in sources_of_world(chosen, PACKAGES)  # the bounds of hours ask when stations work


def test_packages_of_a_collection_count_each_for_itself(folder: Path) -> None:
    def found_with(line: str) -> set[str]:
        code = RULE.format(imported="attrs").replace("import attrs", line)
        (folder / "mine.py").write_text(code, encoding="utf-8")
        return {*sources(load_scenario(folder / "tiny.toml", [f"rules.pr={folder}/mine.py:Mine"]))}

    assert "rmfs_rules.due" not in found_with("import attrs")
    for line in ("from rmfs_rules import due", "from rmfs_rules.due import LeastSlack", "import rmfs_rules.due as due"):
        assert "rmfs_rules.due" in found_with(line)
    assert {"rmfs.layouts", "rmfs_commands.layouts"} <= found_with("from rmfs import hookimpl, layouts")


def test_a_process_has_the_code_it_has_imported(path: Path) -> None:
    assert changed_since({"thing_single": "sha256:0"}) == ["thing_single"]
    (path / "thing_tools" / "__init__.py").write_text("three = 3\n")
    scenario = load_scenario("examples/small")
    assert changed_since(sources_of(RuleSet.load(scenario.rules, scenario.folder), scenario)) == []


Write = Callable[..., Experiment]


@pytest.fixture
def job(experiment: Write) -> Job:
    return experiment().jobs()[0]


@pytest.fixture
def runs(tmp_path: Path) -> RunStore:
    return RunStore(tmp_path / "new" / "runs")


def test_a_whole_run_is_stored_once_and_read_back_as_its_row(job: Job, runs: RunStore) -> None:
    """Half a run does not count; one that another process stored meanwhile stays."""
    half = runs.folder / f".{job.key}.0123456789ab.part"
    half.mkdir()
    (half / "result.json").write_text("{", encoding="utf-8")
    assert job not in runs
    outcome = simulate(job)
    runs.save(job, outcome)
    assert job in runs
    row = runs.row(job)
    assert (row["rule_set"], row["seed"], row["status"], row["key"]) == ("pod-match", 1, "complete", job.key)
    assert (row["run_s"], row["picks"]) == (outcome.run_s, outcome.result.metrics["picks"])
    assert json.loads((runs.place(job) / "run.json").read_text(encoding="utf-8"))["run"] == str(job)
    assert runs.save(job, evolve(outcome, run_s=99.0)) == row == runs.row(job)
    RunStore(runs.folder)
    assert [*runs.folder.rglob("*.part"), *runs.folder.glob("*/*")] == [runs.place(job)]


def test_runs_of_earlier_versions_take_their_places(experiment: Write, runs: RunStore) -> None:
    """They were beside each other; one that is stored anew already stays as it is."""
    one, other = experiment().jobs()[:2]
    rows = [runs.save(job, simulate(job)) for job in (one, other)]
    runs.place(one).rename(runs.folder / one.key)
    shutil.copytree(runs.place(other), runs.folder / other.key)
    (runs.folder / "bounds").mkdir()
    again = RunStore(runs.folder)
    assert [again.row(job) for job in (one, other)] == rows
    assert {path.name for path in runs.folder.iterdir()} == {"bounds", one.key[:2], other.key[:2]}


def test_what_is_not_stored_leaves_nothing(job: Job, runs: RunStore, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="a run without a result has nothing to be stored"):
        runs.save(job, Outcome(None, "it died", "WorkerDiedError"))
    outcome = simulate(job)
    for error in (OSError("no space left"), KeyboardInterrupt()):

        def fail(path: Path, content: bytes, error: BaseException = error) -> None:
            raise error

        monkeypatch.setattr(Path, "write_bytes", fail)
        with pytest.raises((InputError, KeyboardInterrupt), match=r"runs: cannot be written: no space left|^$"):
            runs.save(job, outcome)
        assert list(runs.folder.iterdir()) == []


def test_a_run_that_another_process_stores_meanwhile_stays(job, runs, monkeypatch) -> None:
    """Whether it is there when the files are written, instead of one with something wrong, or first at the rename."""
    outcome, rename, write = simulate(job), Path.rename, Path.write_bytes
    other = evolve(outcome, run_s=99.0)

    def meanwhile(path: Path, *given: Any) -> Any:
        monkeypatch.undo()
        shutil.rmtree(runs.place(job), ignore_errors=True)
        runs.save(job, other)
        return {"rename": rename, "write_bytes": write}[moment](path, *given)

    for moment in ("rename", "write_bytes", "write_bytes"):
        monkeypatch.setattr(Path, moment, meanwhile)
        assert runs.save(job, outcome) == runs.row(job)
        assert runs.row(job)["run_s"] == 99
        assert [*runs.folder.rglob("*.part"), *runs.folder.glob("*/*")] == [runs.place(job)]
        changed(runs.place(job), "run.json", "{}")
    monkeypatch.setattr(shutil, "rmtree", lambda *_, **__: None)  # killed before the wrong one is deleted
    runs.save(job, outcome)
    monkeypatch.undo()
    assert len([*runs.folder.glob(".*")]) == 1
    RunStore(runs.folder)
    assert [*runs.folder.glob("**/*")] == [runs.place(job).parent, runs.place(job), *runs.place(job).iterdir()]


def changed(folder: Path, name: str, text: str | None) -> None:
    """Change a file of a stored run, or delete it: ``/`` tells what is replaced from what takes its place."""
    file = folder / name
    if text is None:
        file.unlink()
    elif "/" in text:
        before, after = text.split("/")
        content = file.read_text(encoding="utf-8")
        assert before in content
        file.write_text(content.replace(before, after, 1), encoding="utf-8")
    else:
        file.write_text(text, encoding="utf-8")


@cases(
    "name text problem",
    ("result.json", "{", ""),
    ("result.json", "[]", ""),
    ("result.json", '"picks": /"picks": 1', ": result.json was changed"),
    ("result.json", '"key": "/"key": "0', ": it is the run 0{key}"),
    ("result.json", '"run.json": "sha256:/"run.json": "sha256:0', ": run.json was changed"),
    ("run.json", "{}", ": run.json was changed"),
    ("run.json", '"run_s": /"run_s": 1', ": run.json was changed"),
    ("run.json", None, ""),
    ("orders.csv", ",/,1", ": orders.csv was changed"),
    ("visits.csv", None, ""),
)
def test_a_run_that_was_changed_is_noticed(job: Job, runs: RunStore, name: str, text: str | None, problem: str) -> None:
    outcome = simulate(job)
    runs.save(job, outcome)
    changed(runs.place(job), name, text)
    sentence = f"{runs.place(job)}: is not as it was stored{problem.format(key=job.key)}"
    assert (runs.problem(job), refusal(lambda: runs.row(job))) == (sentence, sentence)
    runs.save(job, outcome)
    assert runs.problem(job) is None
    assert [*runs.folder.rglob("*.part"), *runs.folder.glob("*/*")] == [runs.place(job)]


def test_other_versions_or_code_at_a_worker_are_no_result(job: Job) -> None:
    for other, error in (
        ({"versions": {**job.versions, "rmfs": "0.0.9"}}, f"rmfs {job.versions['rmfs']}, expected 0.0.9"),
        (
            {"sources": {**job.sources, "rmfs_rules.demand": "sha256:0"}},
            "other code of rmfs_rules.demand; expected that which the experiment began with",
        ),
    ):
        outcome = simulate(evolve(job, **other))
        assert (outcome.result, outcome.error) == (None, f"the worker has {error}")


def test_no_error_gets_through(job: Job, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rmfs_commands.experiments.outcome.run", lambda scenario: 1 / 0)
    outcome = simulate(job)
    assert (outcome.result, outcome.error_kind) == (None, "ZeroDivisionError")
    assert outcome.error == "ZeroDivisionError: division by zero"
