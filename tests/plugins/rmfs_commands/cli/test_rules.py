"""`rmfs rules`."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from installed import RMFS
from rmfs_commands.cli.main import main
from rmfs_commands.cli.rules import rules
from rmfs_core import entrypoints
from rmfs_core.errors import InputError
from rmfs_core.rules.parameters import parameters_of
from rmfs_core.rules.sources import load_entry

Install = Callable[..., None]

DOCUMENTED = '''
@define
class Mine:
    """Assign as I please.

    Parameters
    ----------
    patience_s
        How long to wait (s).
    mode, unused
        Fast or slow.

    References
    ----------
    A. Uthor: A paper. https://doi.org/10.1000/xyz.

    Another report, 1999.
    """

    patience_s: float
    mode: str = "slow"
    names: list[str] = field(factory=list)

    @hookimpl
    def assign_orders(self, warehouse):
        return []

    @hookimpl
    def select_pods(self, warehouse):
        return []

    @hookimpl
    def on_event(self, event):
        pass
'''


def invoke(*arguments: str) -> Result:
    """Call the command."""
    return CliRunner().invoke(rules, arguments)


def as_json() -> dict[str, dict[str, Any]]:
    """Return what the command prints for machines, by name of the rule."""
    return {rule["name"]: rule for rule in json.loads(invoke("--json").stdout)}


def test_the_table_shows_every_column(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where it is wide enough: rule, decision, distribution, parameters with defaults and units, summary, reference."""
    monkeypatch.setenv("COLUMNS", "200")
    result = invoke()
    assert (result.exit_code, result.stderr) == (0, "")
    for text in (
        "balanced",
        "TA",
        RMFS,
        "reallocation_s = 30.0 s",
        "help_others = true",
        "Share the robots out over the active stations, as evenly as possible.",
        "10.23773/2018_8",
        "arXiv:1902.03092",
    ):
        assert text in result.stdout


def test_every_shipped_rule_has_summary_reference_and_documented_parameters() -> None:
    """Nothing in the table is empty for the rules of this distribution."""
    shipped = [rule for rule in as_json().values() if rule["distribution"] == "rmfs"]
    assert len(shipped) >= 11
    for rule in shipped:
        assert rule["error"] is None
        assert rule["decides"]
        assert rule["summary"].endswith(".")
        assert "https://doi.org/" in rule["reference"] or "https://arxiv.org/" in rule["reference"]
        assert all(parameter["doc"] for parameter in rule["parameters"])


def test_json_has_what_a_third_partys_docstring_says(install: Install) -> None:
    """Decisions from the hooks, units and docs from the numpydoc sections, required parameters marked."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=DOCUMENTED)
    mine = as_json()["mine"]
    assert (mine["distribution"], mine["version"]) == ("acme", "1.0")
    assert mine["decides"] == ["POA", "PPS", "observer"]
    assert mine["summary"] == "Assign as I please."
    assert mine["reference"] == "A. Uthor: A paper. https://doi.org/10.1000/xyz.\n\nAnother report, 1999."
    assert [tuple(parameter.values()) for parameter in mine["parameters"]] == [
        ("patience_s", "a number", True, None, "s", "How long to wait (s)."),
        ("mode", "a text", False, "slow", "", "Fast or slow."),
        ("names", "a list, each a text", False, [], "", ""),
    ]


def test_the_details_of_one_rule(install: Install) -> None:
    """The whole docstring, and the parameters as a scenario writes them."""
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=DOCUMENTED)
    result = invoke("mine")
    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.startswith("mine  decides POA, PPS, observer; from acme 1.0\n\nAssign as I please.\n")
    assert "Another report, 1999." in result.stdout
    assert "  # patience_s = (required)  # a number. How long to wait (s)\n" in result.stdout
    assert '  mode = "slow"  # a text. Fast or slow\n' in result.stdout
    assert "\nParameters\n" not in result.stdout  # they are told once


@pytest.mark.parametrize("name", ["integrated", "balanced", "common-lines", "sipp"])
def test_parameters_are_shown_as_toml_has_them(name: str) -> None:
    """What stands below "In a scenario" can be copied into one."""
    choice = tomllib.loads(invoke(name).stdout.partition("In a scenario\n")[2])
    source = load_entry(entrypoints.offers(entrypoints.RULES)[name], name)
    assert choice.keys() <= parameters_of(source.target).keys()
    assert source.target(**choice) == source.target()


@pytest.mark.parametrize("name", ["integrated", "balanced", "common-lines", "sipp"])
def test_details_fit_80_columns(name: str) -> None:
    """Prose is filled anew, formulas stay as they are, and types are in words."""
    lines = invoke(name).stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert not any(line != line.rstrip() or "``" in line or "Literal" in line for line in lines)
    if name == "common-lines":
        assert "    number of open lines of o whose SKU is wanted by an open request at s," in lines


def test_a_rule_that_cannot_be_imported_is_shown_with_its_error(install: Install) -> None:
    """The command goes on, exits with 0, and says so on stderr."""
    install("acme", {"broken": "acme_rules:Broken"}, acme_rules="import acme_nowhere\n")
    result = invoke()
    problem = (
        'rule "broken" (acme 1.0) cannot be imported from acme_rules:Broken: '
        "ModuleNotFoundError: No module named 'acme_nowhere'"
    )
    assert result.exit_code == 0
    assert result.stderr == f"Rule broken (acme 1.0) cannot be used: {problem}\n"
    assert "broken" in result.stdout
    assert "pod-match" in result.stdout
    assert as_json()["broken"]["error"] == problem


def test_rules_that_clash_are_both_shown(install: Install) -> None:
    """Each under the name that selects it."""
    for name in ("acme", "bolt"):
        install(name, {"mine": f"{name}_rules:Mine"}, **{f"{name}_rules": DOCUMENTED})
    result = invoke("--json")
    clash = [rule for rule in json.loads(result.stdout) if rule["name"].endswith("mine")]
    assert [(rule["name"], rule["error"]) for rule in clash] == [("acme:mine", None), ("bolt:mine", None)]


def test_an_unknown_name_is_a_wrong_input(capsys: pytest.CaptureFixture[str]) -> None:
    """Exit code 2, and the nearest name."""
    with pytest.raises(SystemExit) as stop:
        main(["rules", "balancd"])
    assert stop.value.code == 2
    assert capsys.readouterr().err == (
        'Error: rmfs rules: unknown rule "balancd" (did you mean `balanced`?); `rmfs rules` lists all\n'
    )


def test_nothing_set_is_said_in_words(install: Install) -> None:
    """A default is printed as TOML has it; where it is none, that the key is not set."""
    shown = invoke("integrated").stdout
    assert "  # max_seconds = (not set)\n    # a number or nothing. " in shown
    assert "None" not in invoke().stdout
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=DOCUMENTED)
    assert "  names = []  # " in invoke("mine").stdout


@pytest.mark.parametrize("width", [80, 140])
def test_long_names_are_whole(install: Install, monkeypatch: pytest.MonkeyPatch, width: int) -> None:
    """A rule's and its parameters' names are not broken; no line is wider than the screen."""
    monkeypatch.setenv("COLUMNS", str(width))
    name = "a-rule-with-a-long-name-of-somebody"
    install("acme", {name: "acme_rules:Mine"}, acme_rules=DOCUMENTED)
    lines = invoke().stdout.splitlines()
    assert max(map(len, lines)) <= width
    assert any(name in line for line in lines)
    assert any("split-among-stations" in line for line in lines)
    assert width == 140 or any(line.strip() == "unused_capacity_weight = 2.0" for line in lines)


def test_a_rule_in_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is shown as an installed one is, and a class that is not there is refused."""
    monkeypatch.chdir(tmp_path)
    head = "from attrs import define, field\nfrom rmfs_core import hookimpl\n\n"
    (tmp_path / "mine.py").write_text(f"{head}{DOCUMENTED}", encoding="utf-8")
    shown = invoke("./mine.py:Mine")
    assert shown.exit_code == 0
    for text in ("decides POA, PPS, observer; from mine.py inline", "Assign as I please.", "# patience_s = (required)"):
        assert text in shown.output
    with pytest.raises(InputError, match=r"mine.py has no class `Min` \(did you mean `Mine`\?\)"):
        CliRunner().invoke(rules, ["./mine.py:Min"], catch_exceptions=False)
