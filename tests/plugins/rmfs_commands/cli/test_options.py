import os
import subprocess
import sys
from pathlib import Path

import click
import pytest
from click.shell_completion import ShellComplete

from cases import cases
from rmfs_commands.cli.main import main, rmfs
from rmfs_commands.cli.options import NumberRange, WholeNumberRange
from rmfs_commands.experiments import shipped_experiments
from rmfs_core import entrypoints
from rmfs_core.scenario import shipped_scenarios


@cases(
    "kind value problem",
    (NumberRange(min=0, min_open=True), "3x", "expected a number > 0, found 3x"),
    (NumberRange(min=0, min_open=True), "nan", "expected a number > 0, found nan"),
    (NumberRange(min=0, min_open=True), "0", "expected a number > 0, found 0"),
    (NumberRange(50, 100, min_open=True, max_open=True), "100", "expected a number > 50 and < 100, found 100"),
    (NumberRange(max=1.5), "2", "expected a number <= 1.5, found 2"),
    (NumberRange(), "x", "expected a number, found x"),
    (WholeNumberRange(2, 1000), "1.5", "expected a whole number from 2 to 1,000, found 1.5"),
    (WholeNumberRange(2, 1000), "1001", "expected a whole number from 2 to 1,000, found 1001"),
)
def test_a_number_that_is_wrong_is_refused_with_what_is_right(kind, value, problem) -> None:
    with pytest.raises(click.BadParameter) as refused:
        kind.convert(value, None, None)
    assert refused.value.message == problem


def test_numbers_at_closed_limits_are_right() -> None:
    assert WholeNumberRange(2, 1000).convert("1000", None, None) == 1000
    assert NumberRange(max=1.5).convert("1.5", None, None) == 1.5


RULE = "from pathlib import Path\nPath('loaded').touch()\nclass Mine:\n    pass\n"
EXPERIMENT = """
base = "examples/small"
seeds = [1]
baseline = "mine"
[[rule_sets]]
name = "mine"
rules.pr = "./mine.py:Mine"
"""
LOADING = (
    ("run", "examples/small", "--set", "rules.pr=./mine.py:Mine"),
    ("scenario", "check", "examples/small", "--set", "rules.pr=./mine.py:Mine"),
    ("generate", "examples/small", "--set", "rules.pr=./mine.py:Mine", "--out", "out"),
    ("rules", "./mine.py:Mine"),
    ("compare", "experiment.toml"),
    ("bench", "./mine.py:Mine"),
    ("plan", "map.txt", "--pp", "./mine.py:Mine", "--agents", "1"),
)
"""Commands that load rules, asked for one from a file."""


@pytest.mark.parametrize("arguments", LOADING, ids=lambda arguments: arguments[0])
@pytest.mark.parametrize("by", ["option", "environment"])
def test_no_code_is_loaded_from_files_where_that_is_refused(by, arguments, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(RULE, encoding="utf-8")
    (tmp_path / "experiment.toml").write_text(EXPERIMENT, encoding="utf-8")
    (tmp_path / "map.txt").write_text("....\n....\n", encoding="utf-8")
    if by == "environment":
        monkeypatch.setenv("RMFS_NO_INLINE_RULES", "1")
    with pytest.raises(SystemExit) as stop:
        main([*arguments, *(["--no-inline-rules"] if by == "option" else [])])
    printed = capsys.readouterr()
    assert stop.value.code == 2
    assert "which --no-inline-rules refuses" in printed.out + printed.err
    assert "Loading code" not in printed.err
    assert not (tmp_path / "loaded").exists()


RULES = sorted(entrypoints.offers(entrypoints.RULES))


def completed(*words: str) -> list[str]:
    *before, incomplete = words
    return [
        item.value for item in ShellComplete(rmfs, {}, "rmfs", "_RMFS_COMPLETE").get_completions(before, incomplete)
    ]


def test_words_are_completed() -> None:
    assert completed("r") == ["replay", "report", "reproduce", "rules", "run"]
    assert completed("scenario", "") == ["check", "list", "map", "schema", "show"]
    assert completed("run", "x", "--set", "rules.poa", "=", "pod-m") == ["pod-match"]
    assert completed("run", "--set", "rules.poa", "=") == RULES
    assert completed("run", "--set", "rules.poa", "=", "pod-m") == ["pod-match"]
    assert completed("compare", "paper-p") == [name for name in shipped_experiments() if name.startswith("paper-p")]
    assert completed("run", "x", "--record", "") == ["decisions", "trace"]


@pytest.mark.parametrize("command", [("run",), ("generate",), ("scenario", "check"), ("scenario", "map")])
def test_scenarios(command: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
    assert completed(*before, "") == RULES
    assert completed(*before, "nearest-") == ["nearest-pod", "nearest-pod-with-room", "nearest-robot"]


def test_keys_and_values_of_overrides() -> None:
    assert completed("run", "x", "--set", "rob") == [
        "robots.count=",
        "robots.file=",
        "robots.acceleration_m_per_s2=",
        "robots.top_speed_m_per_s=",
        "robots.full_turn_s=",
        "robots.lift_s=",
        "robots.available=",
        "robots.battery=",
        "robots.failures=",
        "robots.maintenance=",
    ]
    assert completed("run", "x", "--set", "rules.poa=pod-m") == ["rules.poa=pod-match"]
    assert completed("run", "x", "--set", "rules.poa.rule=pod-m") == ["rules.poa.rule=pod-match"]
    assert completed("run", "--set", "rules.pr=") == [f"rules.pr={name}" for name in RULES]
    for other in ("instance.orders=", "rules.filters=", "rules.observers="):  # the last two hold lists
        assert completed("run", "--set", other) == []


def test_it_is_quick() -> None:
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
