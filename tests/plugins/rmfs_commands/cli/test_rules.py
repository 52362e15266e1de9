"""Rules: named on a command line, described, listed and asked outside a run."""

import json
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from calling import exit_code
from cases import cases
from installed import RMFS
from rmfs_commands.cli.choices import option_named, parse_choice, with_parameters
from rmfs_commands.cli.description import RuleDescription, installed_rules
from rmfs_commands.cli.rules import rules
from rmfs_commands.cli.single_rule import load_rule
from rmfs_commands.details.catalogue import CATALOGUE
from rmfs_commands.results.figures import TIMING
from rmfs_core import InputError, entrypoints
from rmfs_core.roles import Role
from rmfs_core.rules.parameters import parameters_of
from rmfs_core.rules.sources import load_entry
from rmfs_core.scenario import RuleChoice

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
    return CliRunner().invoke(rules, arguments)


def as_json() -> dict[str, dict[str, Any]]:
    return {rule["name"]: rule for rule in json.loads(invoke("--json").stdout)}


def test_the_table_shows_every_column(monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_json_has_what_a_third_partys_docstring_says(install: Install) -> None:
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
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=DOCUMENTED)
    result = invoke("mine")
    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout.startswith("mine  decides POA, PPS, observer; from acme 1.0\n\nAssign as I please.\n")
    assert "Another report, 1999." in result.stdout
    assert "  # patience_s = (required)  # a number. How long to wait (s)\n" in result.stdout
    assert '  mode = "slow"  # a text. Fast or slow\n' in result.stdout
    assert "  names = []  # " in result.stdout
    assert "\nParameters\n" not in result.stdout  # they are told once
    shown = invoke("integrated").stdout
    assert "  # max_seconds = (not set)\n    # a number or nothing. " in shown
    assert "None" not in invoke().stdout


@pytest.mark.parametrize("name", ["integrated", "balanced", "common-lines", "sipp"])
def test_details_fit_80_columns_and_end_with_the_parameters_as_toml(name: str) -> None:
    shown = invoke(name).stdout
    lines = shown.splitlines()
    assert max(map(len, lines)) <= 80
    assert not any(line != line.rstrip() or "``" in line or "Literal" in line for line in lines)
    if name == "common-lines":
        assert "    number of open lines of o whose SKU is wanted by an open request at s," in lines
    choice = tomllib.loads(shown.partition("In a scenario\n")[2])
    source = load_entry(entrypoints.offers(entrypoints.RULES)[name], name)
    assert choice.keys() <= parameters_of(source.target).keys()
    assert source.target(**choice) == source.target()


def test_a_rule_that_cannot_be_imported_is_shown_with_its_error(install: Install) -> None:
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


def test_rules_that_cannot_be_used_are_named(install: Install, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("acme", "bolt"):
        install(name, {"mine": f"{name}_rules:Mine"}, **{f"{name}_rules": DOCUMENTED})
    result = invoke("--json")
    clash = [rule for rule in json.loads(result.stdout) if rule["name"].endswith("mine")]
    assert [(rule["name"], rule["error"]) for rule in clash] == [("acme:mine", None), ("bolt:mine", None)]
    assert exit_code("rules", "balancd") == 2
    assert capsys.readouterr().err == (
        'Error: rmfs rules: unknown rule "balancd" (did you mean `balanced`?); `rmfs rules` lists all\n'
    )


def test_a_rule_in_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    head = "from attrs import define, field\nfrom rmfs_core import hookimpl\n\n"
    (tmp_path / "mine.py").write_text(f"{head}{DOCUMENTED}", encoding="utf-8")
    shown = invoke("./mine.py:Mine")
    assert shown.exit_code == 0
    for text in ("decides POA, PPS, observer; from mine.py inline", "Assign as I please.", "# patience_s = (required)"):
        assert text in shown.output
    with pytest.raises(InputError, match=r"mine.py has no class `Min` \(did you mean `Mine`\?\)"):
        CliRunner().invoke(rules, ["./mine.py:Min"], catch_exceptions=False)


@cases(
    "default line",
    ("field(factory=lambda: numpy.zeros(3))", "# a = (ndarray)"),
    ("field(factory=object)", "# a = (object)"),
    ("pathlib.Path('tables', 'a.csv')", 'a = "tables/a.csv"'),
    ("'(all)'", 'a = "(all)"'),
    ("field(factory=lambda: 1 / 0)", "rmfs rules: the factory of `a` raised ZeroDivisionError: division by zero"),
)
def test_odd_defaults_of_parameters(default: str, line: str, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    head = "import numpy, pathlib\nfrom attrs import define, field\nfrom rmfs_core import hookimpl\n"
    rule = f"@define\nclass R:\n    a: object = {default}\n    @hookimpl\n    def assign_orders(self): pass\n"
    (tmp_path / "odd.py").write_text(head + rule, encoding="utf-8")
    shown = CliRunner().invoke(rules, ["./odd.py:R"])
    assert line in f"{shown.output}{shown.exception}"


def described(name: str) -> RuleDescription:
    (found,) = [rule for rule in installed_rules() if rule.name == name]
    return found


@cases(
    "source error",
    ("class Mine: pass", "attrs"),
    ("@define\nclass Mine:\n    @hookimpl\n    def asign_orders(self): pass", "did you mean `assign_orders`"),
)
def test_a_rule_that_cannot_be_used_says_why(install: Callable[..., None], source: str, error: str) -> None:
    install("acme", {"mine": "acme_rules:Mine"}, acme_rules=source)
    rule = described("mine")
    assert error in rule.error
    assert (rule.decides, rule.parameters) == ((), ())
    assert described("demand").error is None


def test_choices() -> None:
    assert parse_choice("demand", "x") == RuleChoice("demand")
    table = parse_choice('{ rule = "integrated", gap = 0.1, threads = 2 }', "x")
    assert table == RuleChoice("integrated", {"gap": 0.1, "threads": 2})
    assert with_parameters(table, ["gap=", "threads=1"]) == RuleChoice("integrated", {"threads": 1})
    for wrong, problem in (
        ("{ rule = ", "no valid TOML"),
        ("{ gap = 1 }", "expected a key `rule`"),
        ("", "the name of"),
    ):
        with pytest.raises(InputError, match=problem):
            parse_choice(wrong, "x")
    for wrong, problem in (("a.b=1", "expected a parameter of the rule"), ("gap", "expected parameter=value")):
        with pytest.raises(InputError, match=problem):
            with_parameters(table, [wrong])


@cases(
    "place named",
    ("rule", "--rule mine"),
    ("rule.x", "--set x = 2"),
    ("rule.y", "--rule mine, y"),
    ("rules", "rules"),
    ("state.json", "state.json"),
)
def test_an_error_names_what_was_typed(place: str, named: str) -> None:
    with pytest.raises(InputError) as caught, option_named("rule", "--rule mine", ["x=1", "x = 2"]):
        raise InputError(place, "wrong")
    assert str(caught.value) == f"{named}: wrong"


RANDOM = RuleChoice("random")


def test_the_role_of_a_single_rule() -> None:
    rule = load_rule(RuleChoice("pod-index", {"near": 0.5}), (Role.POA_PPS, Role.POA, Role.PP))
    assert (rule.role, rule.name, rule.instance.near) == (Role.POA_PPS, "pod-index", 0.5)
    assert load_rule(RANDOM, tuple(Role), preferred=Role.PPS).role is Role.PPS
    with pytest.raises(InputError, match=r"^here: rule \"random\" .* which of them is asked \(`--decides`"):
        load_rule(RANDOM, tuple(Role), place="here")
    with pytest.raises(InputError, match=r"decides PP; expected a rule for POA or PPS$"):
        load_rule(RuleChoice("sipp"), (Role.POA, Role.PPS))


def test_metrics_are_listed_with_unit_and_group(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("metrics", "--json") == 0
    listed = {one["name"]: one for one in json.loads(capsys.readouterr().out)}
    known = {metric.name for group in CATALOGUE.values() for metric in group}
    assert known | {metric.name for metric in TIMING} <= listed.keys()
    assert listed["turnover_s"]["unit"] == "s"
    groups = {name: one["group"] for name, one in listed.items()}
    assert "Of other packages" not in groups.values()
    assert groups["packed_s"] == groups["unpacked_end"] == "Packing"
    assert (groups["hook_s.plan_path"], groups["turnover_s"]) == ("Wall clock (under `timing`)", "Orders")
    assert [name for name in groups if "priority" in name] == ["on_time_percent_priority_N"]


def test_metrics_are_found_by_words_of_name_label_or_meaning(capsys, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")
    assert exit_code("metrics", "visit") == 0
    assert "waiting_for_room_per_visit_s " in capsys.readouterr().out
    assert exit_code("metrics", "turn-over", "95th") == 0
    shown = capsys.readouterr().out
    assert "turnover_p95_s" in shown
    assert "turnover_median_s" not in shown
    assert exit_code("metrics", "nothing of it") == 0
    assert capsys.readouterr().out == "No metric has nothing of it in its name or meaning.\n"
