"""Scenario files: what is read, and the one sentence that says what is wrong."""

from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cases import cases
from rmfs_commands.instances.toml_lines import line_of
from rmfs_core.errors import InputError
from rmfs_core.scenario import RuleChoice, load_scenario, located, scenario_from_dict
from rmfs_core.scenario.checks import DURATION, MAYBE_NO_TIME, MOVING, POSITIVE, SHARE, Check, at_least, within
from rmfs_core.scenario.model import InstanceSection, RulesSection, Scenario, StationsSection
from rmfs_core.scenario.tomltext import shown, toml_text
from saying import said

RULES_TEXT = '[rules]\npoa = "pod-match"\npps = "demand"\n'
WHOLE, NUMBER = "expected a whole number", "expected a number"
RULE_OR_TABLE = 'expected the name of a rule or a table { rule = "...", parameter = ... }'
WRONG_VALUES = [
    # a text is no number, nor is a truth value, nor is a fraction whole, nor is a number endless
    ("stations.item_capacity", '"8"', f'{WHOLE}, found "8"'),
    *(("seed", wrong, f"{WHOLE}, found {wrong}") for wrong in ("true", "{}", "2026-01-31", f'"{"x" * 58}"')),
    ("stations.also_replenish", "1", "expected true or false, found 1"),
    ("instance.orders_file", "1", "expected a text in quotes, found 1"),
    ("robots.full_turn_s", '"x"', f'{NUMBER}, found "x"'),
    ("instance.pods_at_stations", "[]", "expected a table, found []"),
    ("rules.filters", "{ a = 1 }", "expected a list, found { a = 1 }"),
    ("robots.count", "2.0", f"{WHOLE}, found 2.0"),
    ("run.until_s", "inf", "expected a finite number, found inf"),
    # out of range, and more than 64 bits can count, or a float can hold
    ("instance.skus", "0", f"{WHOLE} from 1 to 2,000,000, found 0"),
    ("layout.pod_fill", "1.5", f"{NUMBER} in (0, 1], found 1.5"),
    ("robots.full_turn_s", "1e30", f"{NUMBER} from 0.001 to 3600, found 1e+30"),
    ("robots.top_speed_m_per_s", "1e-30", f"{NUMBER} from 0.001 to 1000, found 1e-30"),
    ("robots.lift_s", "-1", f"{NUMBER} from 0 to 3600, found -1.0"),
    ("instance.items_per_sku", "1" + "0" * 19, f"{WHOLE} from 1 to 1,000,000,000, found 1{'0' * 19}"),
    ("run.until_s", "1" + "0" * 400, f"{NUMBER}, found 1{'0' * 56}..."),
    *(
        (
            "stations.item_capacity",
            many,
            f"{WHOLE} from 1 to 1,000,000,000, or a list of them, one per station, found {many}",
        )
        for many in ("[]", "[1, 0]")
    ),
    ("run.until_s", "0", f"{NUMBER} > 0 up to 1e10, found 0.0"),
    # a few words
    ("stations.release", '"handle"', 'found "handle" (did you mean `handled`?)'),
    (
        "instance.arrivals",
        '{ process = "poisson" }',
        'expected `orders_per_hour` with process "poisson", and only there',
    ),
    ("instance.arrivals", '{ process = "refill" }', 'expected `backlog` with process "refill", and only there'),
    ("instance.arrivals", "{ backlog = 9 }", 'expected `backlog` with process "refill", and only there'),
    # a table where none belongs, and the other way round
    ("robots", "3", "expected a table, found 3"),
    ("instance.lines", "3", "expected a list, found 3"),
    ("instance.departures.times", '"14:00"', 'expected a list, or a table of lists, found "14:00"'),
    ("stations.open", "3", 'expected a list such as [["06:00", "22:00"]], or a table of lists, found 3'),
    ("robots.available", "3", 'expected a list such as [["06:00", "22:00"]], found 3'),
    # rules
    ("rules.poa", '"pod-mach"', 'there is no rule "pod-mach" (did you mean `pod-match`?)'),
    (
        "rules.poa",
        '{ rle = "x" }',
        "expected a key `rule` with the name of a rule in addition to the parameters, found none",
    ),
    ("rules.poa", "3", f"{RULE_OR_TABLE}, found 3"),
    *(
        ("rules.poa", f'"{half}"', f'expected "./file.py:Class" for a rule next to the scenario, found "{half}"')
        for half in ("./mine", "mine.py", "./mine.py:1", "./mine.pyc:A")
    ),
    ("rules.poa", '"./mine.py:A"', "there is no file `./mine.py` in the scenario's folder ({folder})"),
]


@pytest.mark.parametrize(("key", "value", "problem"), WRONG_VALUES)
def test_a_wrong_value_is_refused_with_its_line_and_key(key: str, value: str, problem: str, tmp_path: Path) -> None:
    file = tmp_path / "wrong.toml"
    rest = 'rules.pps = "demand"\n' if key.startswith("rules.") else RULES_TEXT
    file.write_text(f"# values\n{key} = {value}\n{rest}", encoding="utf-8")
    assert (
        said(InputError, load_scenario, file) == f"{file}, line 2, {key}: {problem.replace('{folder}', str(tmp_path))}"
    )


ARRIVALS_KEYS = "`backlog`, `orders_per_hour`, `process`, `profile`"
ALONE = "expected `poa` and `pps`, or `poa_pps`, found"
BAD_FILES = [
    # a misspelt key, with the nearest one; a misspelt section; a key that resembles none: all are listed
    ("[robots]\ncuont = 3", ", line 2, robots.cuont: unknown key (did you mean `count`?)"),
    ("[robot]\ncount = 3", ", line 1, robot: unknown key (did you mean `robots`?)"),
    ("[instance.arrivals]\nx = 1", f", line 2, instance.arrivals.x: unknown key; expected one of {ARRIVALS_KEYS}"),
    (f"[run]\nwarmup = {'[' * 48}{']' * 48}", ", line 2, run.warmup: unknown key (did you mean `warmup_s`?)"),
    # within a list, and within a table
    ('[stations]\nitem_capacity = [3, "x"]', ', line 2, stations.item_capacity[1]: expected a whole number, found "x"'),
    (
        '[instance]\npods_at_stations = { 1 = ["a", 2] }',
        ", line 2, instance.pods_at_stations.1[1]: expected a text in quotes, found 2",
    ),
    (RULES_TEXT + "pr.rule = 3", ", line 4, rules.pr.rule: expected a text in quotes, found 3"),
    (RULES_TEXT + 'filters = ["a", ""]', f', line 4, rules.filters[1]: {RULE_OR_TABLE}, found ""'),
    ("[[robots]]\ncount = 3", ", line 1, robots: expected a table, found [{ count = 3 }]"),
    (
        '[instance]\narrivals = { process = "poison" }',
        ', line 2, instance.arrivals.process: found "poison" (did you mean `poisson`?)',
    ),
    (
        "[instance]\ndue = { allowance_s = 1, spread_s = 1e308 }",
        ", line 2, instance.due.spread_s: expected a number from 0 to 1e+07, found 1e+308",
    ),
    # values that do not go together
    (
        '[instance]\ndue = { allowance_s = 9 }\narrivals = { process = "refill", backlog = 9 }',
        ', line 1, instance: expected no `due` with arrivals of process "refill", whose times nobody knows beforehand',
    ),
    (
        '[instance]\norders_file = "o"\npods_file = "p"\narrivals = { process = "day" }',
        ", line 4, instance.arrivals: has no effect with `instance.orders_file`; leave one of them out",
    ),
    (
        '[instance]\norders_file = "o.csv"',
        ", line 1, instance: expected `orders_file` and `pods_file` together, or neither",
    ),
    ("[instance]\nskus = 2\nskus_per_pod = 3", ", line 1, instance: expected skus_per_pod <= skus, found 3 > 2"),
    ("[stations]\nhandle_s = 2", ", line 1, stations: expected handle_s >= pick_s, found 2.0 < 7.0"),
    ('[rules]\npoa = "pod-match"\n', f", line 1, rules: {ALONE} `poa` alone"),
    ('[rules]\npps = "demand"\n', f", line 1, rules: {ALONE} `pps` alone"),
    ("[rules]\n", ", line 1, rules: expected `poa` and `pps`, or `poa_pps`"),
    (RULES_TEXT + 'poa_pps = "demand"\n', ", line 1, rules: expected either `poa_pps` or `poa` and `pps`, found both"),
    # a whole section missing
    ("seed = 1  # no [rules]\n", ", rules: this part is missing"),
    # no TOML at all
    ("seed = " + "9" * 5000, ": this is no valid TOML: found a number of more than 4,300 digits"),
    *(
        (f"x = {deep}", ": this is no valid TOML: found more than 50 lists or tables in one another")
        for deep in (f"{'[' * 60}{']' * 60}", f"{'{a = ' * 60}1{'}' * 60}", f"{'[' * 2000}{']' * 2000}")
    ),
    ("seed = 1\nrobots = ", ", line 2, column 10: this is no valid TOML: Invalid value; texts need quotes"),
    (
        "{}",
        ": this is no valid TOML: found JSON; `rmfs scenario show DIR` prints the scenario of the run in DIR, and "
        "`rmfs run SCENARIO --journal FILE` runs the day of a hall again",
    ),
    ("seed = 1\nseed = 2", ", line 2, column 9: this is no valid TOML: Cannot overwrite a value"),
    # two mistakes: the first in the file, whatever the order of the keys in the documentation
    (
        "[stations]\npick_s = 0\n[robots]\ncuont = 3",
        ", line 2, stations.pick_s: expected a number from 0.001 to 3600, found 0.0",
    ),
    ("[robots]\ncuont = 3\n[stations]\npick_s = 0", ", line 2, robots.cuont: unknown key (did you mean `count`?)"),
    # a text that looks like keys: no line rather than a wrong one
    ('seed = """\n[robots]\n"""', ', seed: expected a whole number, found "[robots]\\n"'),
]


@pytest.mark.parametrize(("text", "message"), BAD_FILES)
def test_a_mistake_is_one_sentence(text: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "wrong.toml"
    file.write_text(text if "[rules]" in text else f"{text}\n{RULES_TEXT}", encoding="utf-8")
    assert said(InputError, load_scenario, file) == f"{file}{message}"


def test_every_value_is_read(tmp_path: Path) -> None:
    file = tmp_path / "good.toml"
    file.write_text(
        'seed = 7\n[instance]\nitems_per_sku = 4\npods_at_stations = { 1 = ["2", "1"] }\n'
        "[stations]\nitem_capacity = [3, 4]\npick_s = 5\n"
        '[rules]\npoa = { rule = "pod-match", weight = 2, deep = { a = [1] } }\npps = "demand"\nfilters = ["waves"]\n',
        encoding="utf-8",
    )
    scenario = load_scenario(file)
    stations = StationsSection(item_capacity=(3, 4), pick_s=5.0)
    instance = InstanceSection(items_per_sku=4, pods_at_stations={"1": ("2", "1")})
    poa = RuleChoice("pod-match", {"weight": 2, "deep": {"a": [1]}})
    rules = RulesSection(poa=poa, pps=RuleChoice("demand"), filters=(RuleChoice("waves"),))
    assert scenario == Scenario(seed=7, instance=instance, stations=stations, rules=rules)
    assert (type(scenario.stations.pick_s), scenario.rules.pr) == (float, RuleChoice("nearest"))
    assert scenario.folder == str(tmp_path)


def test_files_of_windows_and_of_another_encoding(tmp_path: Path) -> None:
    file = tmp_path / "windows.toml"
    file.write_bytes(b"\xef\xbb\xbf" + ("seed = 3\n" + RULES_TEXT).replace("\n", "\r\n").encode())
    assert load_scenario(file).seed == 3
    file = tmp_path / "latin.toml"
    file.write_bytes(b"# gr\xfc\xdfe\n")
    with pytest.raises(InputError, match=r"latin\.toml: expected UTF-8 text, found the byte 0xfc$"):
        load_scenario(file)


@pytest.mark.parametrize("name", ["paper-250", "paper-250.toml", "examples/small", Path("examples/small.toml")])
def test_shipped_scenarios_are_found_by_name(name: str | Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert load_scenario(name).rules.poa == RuleChoice("pod-match")


def test_what_is_no_scenario_is_named(tmp_path: Path) -> None:
    assert said(InputError, load_scenario, "paper-25") == (
        "paper-25: there is no such file, and no shipped scenario of that name "
        "(did you mean `paper-250` or `paper-2000`?)"
    )
    with pytest.raises(InputError, match=r": expected a scenario file, found a folder$"):
        load_scenario(tmp_path)
    name = "a" * 300
    with pytest.raises(InputError, match="there is no such file"):
        load_scenario(f"{name}.toml")
    for impossible in (name, "aaa\0"):
        with pytest.raises(InputError, match=r"there is no file `.*aaa"):
            load_scenario("examples/small", [f"rules.poa=./{impossible}.py:Mine"])


def test_tables_are_read_without_a_file() -> None:
    assert load_scenario("paper-250", ["seed=3"], seed=5).seed == 5
    rules = {"rules": {"poa": "pod-match", "pps": "demand"}}
    assert scenario_from_dict(rules | {"seed": 4}).seed == 4
    for wrong, told in (
        ({"seed": -4}, "seed: expected a whole number >= 0, found -4"),
        ({"seed": None}, "seed: expected a whole number, found null"),
        ({"robots": {"full_turn_s": float("nan")}}, "robots.full_turn_s: expected a finite number, found nan"),
        ({"folder": "x"}, "folder: unknown key; expected one of `"),  # no key of the file
    ):
        problem = said(InputError, scenario_from_dict, rules | wrong, name="result.json")
        assert problem.startswith(f"result.json, {told}")


def test_errors_have_the_line_of_their_key(tmp_path: Path) -> None:
    file = tmp_path / "late.toml"
    file.write_text(RULES_TEXT + "[instance]\npods_at_stations = { 1 = ['9'] }\n", encoding="utf-8")
    scenario = load_scenario(file, ["robots.count=3"])
    for place, expected in [
        ("instance.pods_at_stations.1", f"{file}, line 5, instance.pods_at_stations.1"),
        ("robots.count", "--set robots.count=3"),
        ("orders.csv, line 3", "orders.csv, line 3"),
    ]:
        with pytest.raises(InputError) as caught, located(scenario):
            raise InputError(place, "wrong")
        assert str(caught.value) == f"{expected}: wrong"
    file = tmp_path / "run.toml"
    file.write_text("[instance]\norders = 7\n" + RULES_TEXT, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        scenario = load_scenario("run.toml")
    with pytest.raises(InputError) as caught, located(scenario), located(scenario):
        raise InputError("instance.orders", "wrong")
    assert str(caught.value) == "run.toml, line 2, instance.orders: wrong"


DOTTED = """\
# robots.count = 1
seed = 1
robots.count = 2

[instance]  # data
orders = 3
arrivals = { process = "start" }
pods_at_stations."1" = [
  "1",
]

[ rules . poa ]
rule = "x"

[[sets]]
name = "a"
[[sets]]
name = "b"
[sets.rules]
poa = "x"
[[sets]]
[[ others ]]
name = 1
"""


@cases(
    "path line",
    (("seed",), 2),
    (("robots", "count"), 3),  # a dotted key
    (("robots",), 3),  # a table that only a dotted key makes
    (("instance",), 5),
    (("instance", "orders"), 6),
    (("instance", "arrivals", "process"), 7),  # within an inline table: the table's line
    (("instance", "pods_at_stations", "1", 0), 8),  # a quoted key, a list over several lines
    (("rules", "poa", "rule"), 13),  # a header with spaces
    (("rules",), 12),  # a table that only a deeper header makes
    (("instance", "skus"), 5),  # not there: the table it would be in
    (("stations", "pick_s"), None),  # nothing of it there
    (("sets",), 15),
    (("sets", 0, "name"), 16),
    (("sets", 1), 17),
    (("sets", 1, "name"), 18),
    (("sets", 1, "rules", "poa"), 20),  # a table within the last one before it
    (("sets", 2, "name"), 21),  # not there: its table
    (("others", 0, "name"), 23),
)
def test_a_key_is_found(path: tuple[str | int, ...], line: int | None) -> None:
    assert line_of(DOTTED, path) == line


NUMBERS = [at_least(1), at_least(0), within(0.5, 2), POSITIVE, DURATION, MAYBE_NO_TIME, MOVING, SHARE]


def refusal(check: Any, value: object) -> str | None:
    try:
        check(None, None, value)
    except ValueError as error:
        return str(error)
    return None


@given(
    value=st.floats(allow_nan=False, allow_infinity=False) | st.integers(-10, 10_000), check=st.sampled_from(NUMBERS)
)
def test_the_schema_says_the_same(value: float, check: Check) -> None:
    by_schema = jsonschema.Draft202012Validator(dict(check.schema)).is_valid(value)
    assert by_schema == (refusal(check, value) is None)


def test_what_json_and_toml_write_otherwise() -> None:
    assert toml_text("a\x7fb") == '"a\\u007fb"'  # which JSON would leave as it is, and TOML forbids
    nested: list[Any] = []
    for _ in range(990):
        nested = [nested]
    assert shown(nested) == "lists or tables in one another"
