"""What the shell completes, asked as click's shell scripts ask."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from rmfs_commands.cli.main import rmfs
from rmfs_commands.experiments import shipped_experiments
from rmfs_core import entrypoints
from rmfs_core.scenario import shipped_scenarios

RULES = sorted(entrypoints.offers(entrypoints.RULES))


def completed(*words: str) -> list[str]:
    """Return what the last word can be completed to."""
    *before, incomplete = words
    return [
        item.value for item in ShellComplete(rmfs, {}, "rmfs", "_RMFS_COMPLETE").get_completions(before, incomplete)
    ]


def test_commands() -> None:
    """The commands of the group, and those below one."""
    assert completed("r") == ["replay", "reproduce", "rules", "run"]
    assert completed("scenario", "") == ["check", "list", "map", "schema", "show"]


@pytest.mark.parametrize("command", [("run",), ("generate",), ("scenario", "check"), ("scenario", "map")])
def test_scenarios(command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The shipped ones, files of the current folder, and folders on the way to one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").mkdir()
    for name in ("paper.toml", "mine/own.toml", "other.txt"):
        (tmp_path / name).write_text("", encoding="utf-8")
    assert completed(*command, "pa") == [*(name for name in shipped_scenarios() if name.startswith("pa")), "paper.toml"]
    assert completed(*command, "m") == ["multi-day", "mine/"]
    assert completed(*command, "mine/") == ["mine/own.toml"]
    assert "other.txt" not in completed(*command, "")


@pytest.mark.parametrize("before", [("rules",), ("decide", "s.json", "--rule"), ("bench",), ("plan", "m", "--pp")])
def test_rules(before: tuple[str, ...]) -> None:
    """Wherever a command takes the name of a rule."""
    assert completed(*before, "") == RULES
    assert completed(*before, "nearest-") == ["nearest-pod", "nearest-pod-with-room", "nearest-robot"]


def test_keys_and_values_of_overrides() -> None:
    """Keys of a scenario; after a key of the rules, the rules."""
    assert completed("run", "x", "--set", "rob") == [
        "robots.count=",
        "robots.file=",
        "robots.acceleration_m_per_s2=",
        "robots.top_speed_m_per_s=",
        "robots.full_turn_s=",
        "robots.lift_s=",
        "robots.available=",
        "robots.battery=",
    ]
    assert completed("run", "x", "--set", "rules.poa=pod-m") == ["rules.poa=pod-match"]
    assert completed("run", "x", "--set", "rules.poa.rule=pod-m") == ["rules.poa.rule=pod-match"]
    assert completed("run", "--set", "rules.pr=") == [f"rules.pr={name}" for name in RULES]
    for other in ("instance.orders=", "rules.filters=", "rules.observers="):  # the last two hold lists
        assert completed("run", "--set", other) == []


def test_bash_splits_at_the_equals_sign() -> None:
    """Its words are `rules.poa`, `=` and `pod-m`, and only the last one is replaced."""
    assert completed("run", "x", "--set", "rules.poa", "=", "pod-m") == ["pod-match"]
    assert completed("run", "--set", "rules.poa", "=") == RULES
    assert completed("run", "--set", "rules.poa", "=", "pod-m") == ["pod-match"]


def test_experiments_and_recorders() -> None:
    """Names of shipped experiments, and of what `rmfs run` can record."""
    assert completed("compare", "paper-p") == [name for name in shipped_experiments() if name.startswith("paper-p")]
    assert completed("run", "x", "--record", "") == ["decisions", "trace"]


def test_it_is_quick() -> None:
    """Completing imports no rule, no solver, no compiler and nothing that draws."""
    heavy = ("numpy", "numba", "rich", "simpy", "mip", "matplotlib", "scipy")
    code = (
        "import sys\nfrom rmfs_commands.cli.main import main\ntry:\n    main()\nexcept SystemExit:\n    pass\n"
        f"print([name for name in {heavy!r} if name in sys.modules], file=sys.stderr)\n"
    )
    asked = {"_RMFS_COMPLETE": "bash_complete", "COMP_WORDS": "rmfs run --set rules.pp", "COMP_CWORD": "3"}
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.argv = ['rmfs']\n{code}"],
        env={**os.environ, **asked},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "rules.pps=" in done.stdout
    assert done.stderr == "[]\n"
