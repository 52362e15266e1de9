"""What the README shows works, and what it lists is all there is."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
from rmfs_core.entrypoints import COMMANDS, offers
from rmfs_core.hookspecs import DecisionHooks, FilterHooks, ObserverHooks
from rmfs_experiments import load_experiment, run_experiment

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")


def block(marker: str) -> str:
    """Return the code block that follows a marker."""
    found = re.search(rf"<!-- {marker} -->\n```\w+\n(.*?)```", README, re.DOTALL)
    assert found is not None
    return found[1]


def test_the_readmes_rule_runs(tmp_path: Path) -> None:
    """The rule and the scenario of the README, saved as it says, complete all orders."""
    (tmp_path / "my_rule.py").write_text(block("rule"), encoding="utf-8")
    (tmp_path / "my-scenario.toml").write_text(block("scenario"), encoding="utf-8")
    result = rmfs_core.run(tmp_path / "my-scenario.toml")
    assert result.status == "complete"
    assert result.metrics["orders_completed"] == 50
    assert len(block("rule").strip().splitlines()) <= 25


def test_the_readmes_experiment_compares_the_readmes_rule(tmp_path: Path) -> None:
    """The experiment of the README, saved as it says beside the rule, runs every rule set on both instances."""
    (tmp_path / "my_rule.py").write_text(block("rule"), encoding="utf-8")
    (tmp_path / "my-experiment.toml").write_text(block("experiment"), encoding="utf-8")
    experiment = load_experiment(tmp_path / "my-experiment.toml")
    assert len(experiment.jobs()) == 30
    result = run_experiment(evolve(experiment, seeds=(1,)), store=tmp_path / "runs")
    assert [row["status"] for row in result.rows] == ["complete"] * 6
    assert result.comparison().instance_sets == ("orders=50", "orders=100", "overall")


def test_the_readmes_map_is_fit_for_use(tmp_path: Path) -> None:
    """The example of a text map is a layout that a scenario can run on."""
    (tmp_path / "map.txt").write_text(block("map"), encoding="utf-8")
    (tmp_path / "s.toml").write_text(
        "[instance]\norders = 5\nskus = 6\npods = 6\n[robots]\ncount = 2\n[stations]\nqueue_length = 3\n"
        '[layout]\nmap_file = "map.txt"\n[rules]\npoa = "pod-match"\npps = "demand"\n',
        encoding="utf-8",
    )
    assert rmfs_core.run(tmp_path / "s.toml").metrics["orders_completed"] == 5


def test_the_readmes_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """The library example prints status and figures."""
    example = re.search(r"From Python:\n\n```python\n(.*?)```", README, re.DOTALL)
    assert example is not None
    exec(example[1], {})
    assert capsys.readouterr().out.startswith("complete ")


def test_the_tables_are_up_to_date() -> None:
    """The README's tables of rules and keys are what tools/update_readme.py writes."""
    check = [sys.executable, str(ROOT / "tools" / "update_readme.py"), "--check"]
    done = subprocess.run(check, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_every_hook_is_listed_and_documented() -> None:
    """Each hook has a row in the README, and a docstring that says when it is called and what its arguments are."""
    for group in (DecisionHooks, FilterHooks, ObserverHooks):
        for name, hook in vars(group).items():
            if name.startswith("_"):
                continue
            assert f"`{name}`" in README
            doc = hook.__doc__ or ""
            arguments = [a for a in hook.__annotations__ if a != "return"]
            assert all(f":param {argument}:" in doc for argument in arguments), name
            assert (":return:" in doc) == (hook.__annotations__["return"] != "None"), name


def test_every_command_is_mentioned() -> None:
    """Each command of the command line occurs in the README."""
    for name in offers(COMMANDS):
        assert f"rmfs {name}" in README
