"""Scenarios: sections and what does not go together, `--set`, names of rules, and what is written."""

import copy
import json
import pickle
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cases import cases
from rmfs_commands.cli.toml_scenario import to_toml
from rmfs_commands.instances.overrides import DATA_FILES, given_in
from rmfs_core.errors import InputError
from rmfs_core.motion import Motion
from rmfs_core.scenario import load_scenario, scenario_from_dict, scenario_to_dict, shipped_scenarios
from rmfs_core.scenario.model import (
    Arrivals,
    InstanceSection,
    LayoutSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    RunSection,
    Scenario,
    StationsSection,
)
from rmfs_core.scenario.service import Spread
from rmfs_core.scenario.structuring import section_class
from saying import said

ONE, OTHER = RuleChoice("one"), RuleChoice("other")


def test_the_defaults_are_the_papers() -> None:
    """Section 4.1 and Appendix D of the paper: instance, grid, robots and stations."""
    scenario = Scenario(rules=RulesSection(poa=RuleChoice("one"), pps=RuleChoice("other")))
    instance, layout, robots, stations = scenario.instance, scenario.layout, scenario.robots, scenario.stations
    assert (instance.orders, instance.skus, instance.pods, instance.skus_per_pod) == (250, 100, 100, 3)
    assert layout.block_rows * layout.block_columns * 2 * layout.block_length == 504
    assert int(layout.pod_fill * 504) == 428
    assert (layout.stations_east + layout.stations_west, robots.count) == (4, 8)
    assert (stations.item_capacity, stations.queue_length, stations.pick_s, stations.handle_s) == (15, None, 7.0, 13.0)
    assert instance.items_per_sku is None
    for name in ("acceleration_m_per_s2", "top_speed_m_per_s", "full_turn_s", "lift_s"):
        assert getattr(robots, name) == getattr(Motion(), name)


@cases(
    "setting problem",
    ("instance.orders=1000000000", "expected a whole number from 0 to 2,000,000, found 1000000000"),
    ("instance.pods=10000000000", "expected a whole number from 1 to 100,000"),
    ("robots.count=10000000000", "expected a whole number from 1 to 100,000"),
    ("layout.block_rows=100000", "expected at most 1,000,000 cells in all, found blocks and halls of about"),
    ("instance.lines=[" + "0," * 999 + "1]", "`lines` with weights from 0 to 1e9, not all 0 up to"),
    ("stations.queue_length=1000000000", "expected a whole number from 1 to 10,000"),
    ("layout.hall_width=1000000000000000000", "expected a whole number from 1 to 100,000"),
    ("instance.max_lines=10000000000000000000", "expected a whole number from 1 to 2,000,000"),
    ("instance.demand={exponent=1, groups=10000000000000000000}", "expected a whole number from 1 to 2,000,000"),
)
def test_what_no_memory_has_room_for_is_refused_at_once(setting: str, problem: str) -> None:
    started = time.perf_counter()
    with pytest.raises(InputError, match=problem):
        load_scenario("examples/small", [setting])
    assert time.perf_counter() - started < 2


def test_scenarios_of_no_use_are_refused() -> None:
    few = ["instance.skus=100000", "instance.skus_per_pod=100000"]
    assert load_scenario("examples/small", few).instance.skus == 100_000
    with pytest.raises(InputError, match="expected at most 8 GB of memory, found about 10 GB of"):
        load_scenario("examples/small", [*few, "instance.pods=400"])
    long = ["instance.skus=1000", f"instance.lines=[{'0,' * 999}1]"]
    assert load_scenario("examples/small", [*long, "instance.orders=20000"]).instance.orders == 20_000
    with pytest.raises(InputError, match="expected at most 8 GB of memory, found about 605 GB of"):
        load_scenario("examples/small", [*long, "instance.orders=2000000"])
    with pytest.raises(InputError, match="as `profile`, not all 0"):
        load_scenario("examples/poisson", [f"instance.arrivals.profile=[{'0,' * 23}1e308]"])
    slow = "instance.arrivals.orders_per_hour=0.001"
    assert load_scenario("examples/poisson", [slow, "instance.orders=1000"]).instance.orders == 1000
    with pytest.raises(InputError, match="expected orders that arrive within 1,000,000 hours, found about 1,001,000"):
        load_scenario("examples/poisson", [slow, "instance.orders=1001"])


@pytest.mark.parametrize("key", ["filters", "observers"])
def test_more_rules_than_anybody_wants_are_refused(key: str) -> None:
    rule = '"most-covered",'
    assert len(getattr(load_scenario("examples/small", [f"rules.{key}=[{50 * rule}]"]).rules, key)) == 50
    with pytest.raises(InputError, match="expected at most 50 `filters` and as many `observers`, found 51"):
        load_scenario("examples/small", [f"rules.{key}=[{51 * rule}]"])


KEY_VALUE = ": expected key=value, such as instance.orders=50"
WRONG = [
    (["seed"], KEY_VALUE),
    (["=3"], KEY_VALUE),
    (["instance..orders=3"], KEY_VALUE),
    (["robots.cuont=3"], ": unknown key (did you mean `count`?)"),
    (["robots.count=many"], ': expected a whole number, found "many"'),
    (["robots={count=0}"], ", robots.count: expected a whole number from 1 to 100,000, found 0"),
    (["robots.battery.detour=0.99"], ": expected a number from 1 to 100, found 0.99"),
    (["seed.x=2"], ": `seed` has no keys of its own, it is 1"),
    (
        ['stations.open=[["06:00", "22:00"]]', "stations.open.3=[]"],
        ': `stations.open` has no keys of its own, it is [["06:00", "22:00"]]; expected a table, as { 3 = [] }',
    ),
    (["robots.count=2", "robots.count=0"], ": expected a whole number from 1 to 100,000, found 0"),
    (["robots.cuont="], ": unknown key `cuont` (did you mean `count`?)"),
    (["rules.pps="], ", rules: expected `poa` and `pps`, or `poa_pps`, found `poa` alone"),
    # a rule for orders takes the place of the joint one; then one for pods is wanted too
    (
        ["rules.poa_pps=integrated", "rules.poa=pod-match"],
        ", rules: expected either `poa_pps` or `poa` and `pps`, found both",
    ),
    # something that only looks like a table
    (
        ["rules.poa={rule=pod-match}"],
        ": this is no valid TOML value: Invalid value (at line 1, column 15); texts in it need quotes",
    ),
    # a line break does not smuggle a second key in
    (["seed=1\nx=2"], ': expected a whole number, found "1\\nx=2"'),
]


@pytest.mark.parametrize(("overrides", "problem"), WRONG)
def test_a_wrong_override_is_one_sentence(overrides: list[str], problem: str) -> None:
    assert said(InputError, load_scenario, "paper-250", overrides) == f"--set {overrides[-1]}{problem}"


def test_overrides() -> None:
    values = ("instance.orders=50", "stations.item_capacity=[1, 2, 3, 4]", "instance.start=2026-03-02T06:00:00")
    scenario = load_scenario("paper-250", [*values, "rules.poa=first-come", 'rules.pps="nearest-pod"'])
    assert (scenario.instance.start, scenario.instance.orders) == ("2026-03-02T06:00:00", 50)
    assert scenario.stations.item_capacity == (1, 2, 3, 4)
    assert (scenario.rules.poa, scenario.rules.pps) == (RuleChoice("first-come"), RuleChoice("nearest-pod"))
    scenario = load_scenario("paper-250", ["rules.poa.x=1", "rules.pps.y=2", "rules.pps.rule=nearest-pod"])
    assert scenario.rules.poa == RuleChoice("pod-match", {"x": 1})
    assert scenario.rules.pps == RuleChoice("nearest-pod", {"y": 2})
    scenario = load_scenario("paper-250", ["rules.poa=", "rules.pps=", "rules.poa_pps=demand", "run.until_s="])
    assert (scenario.rules.poa, scenario.rules.poa_pps) == (None, RuleChoice("demand"))
    assert load_scenario("examples/poisson", ["instance.arrivals="]).instance.arrivals.process == "start"


@pytest.mark.parametrize("nothing", ["", "None", "null"])
def test_nothing_takes_a_key_out(nothing: str) -> None:
    scenario = load_scenario(
        "paper-250", [f"robots.count={nothing}", f"rules.poa.x={nothing}", f'rules.poa.y="{nothing}"']
    )
    assert scenario.robots.count == 8
    assert scenario.rules.poa == RuleChoice("pod-match", {"y": nothing})


RULE_FILE = "from attrs import define\n\n\n@define\nclass X:\n    pass\n"
OWN = '[rules]\npoa = "pod-match"\npps = "demand"\n'


def test_files_of_rules_are_looked_up_where_the_command_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "rules").mkdir()
    (tmp_path / "rules" / "my.py").write_text(RULE_FILE, encoding="utf-8")
    (tmp_path / "other").mkdir()
    (tmp_path / "own.toml").write_text(OWN, encoding="utf-8")
    monkeypatch.chdir(tmp_path / "other")
    named, absolute = "../rules/my.py:X", f"{tmp_path}/rules/my.py:X"
    overrides = [
        f"rules.poa={named}",
        f"rules.pps.rule={absolute}",
        f'rules.filters=[{{rule="{named}", file="{named}"}}]',
        f"rules.ta.rule={named}",
    ]
    shipped = load_scenario("paper-250", overrides).rules
    assert (shipped.poa, shipped.pps, shipped.ta) == (RuleChoice(absolute),) * 3
    assert shipped.filters == (RuleChoice(absolute, {"file": named}),)  # a parameter is what the rule makes of it
    own = load_scenario("../own.toml", overrides).rules
    assert own.poa == own.pps == RuleChoice("./rules/my.py:X")
    whole = load_scenario("../own.toml", [f'rules={{poa="{named}", pps="demand"}}']).rules
    assert whole.poa == RuleChoice("./rules/my.py:X")
    (tmp_path / "own.toml").write_text(OWN.replace("pod-match", "./rules/my.py:X"), encoding="utf-8")
    assert load_scenario("../own.toml").rules.poa == RuleChoice("./rules/my.py:X")
    assert (
        said(InputError, load_scenario, "paper-250", ["rules.pps=./my.py:X"])
        == f"--set rules.pps=./my.py:X: there is no file `{tmp_path}/other/my.py`"
    )


def test_files_of_data_are_looked_up_where_the_command_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    files = {"orders_file": "o.csv", "pods_file": "../p.csv"}
    scenario = load_scenario(
        "paper-250", [*(f"instance.{key}={file}" for key, file in files.items()), "layout.map_file=my/map.txt"]
    )
    daily = load_scenario("grocery-day", ["instance.arrivals.profile=hours.csv"]).instance.arrivals
    assert daily.profile == str(tmp_path / "hours.csv")
    assert scenario.instance.orders_file == str(tmp_path / "o.csv")
    assert scenario.instance.pods_file == str(tmp_path.parent / "p.csv")
    assert scenario.layout.map_file == str(tmp_path / "my" / "map.txt")
    (tmp_path / "there.csv").touch()  # texts of generators may be labels as well
    texts = 'layout.parameters={files=["there.csv", "none.csv"]}'
    made = load_scenario("paper-250", ["instance.parameters.file=there.csv", "instance.parameters.way=none", texts])
    assert made.instance.parameters == {"file": str(tmp_path / "there.csv"), "way": "none"}
    assert made.layout.parameters == {"files": [str(tmp_path / "there.csv"), "none.csv"]}
    (tmp_path / "below").mkdir()
    own = tmp_path / "below" / "own.toml"
    own.write_text(f'{OWN}[instance]\norders_file = "o.csv"\npods_file = "p.csv"\n', encoding="utf-8")
    assert load_scenario(own).instance.orders_file == "o.csv"
    assert load_scenario(own, ["instance.orders_file=below/new.csv"]).instance.orders_file == "new.csv"
    whole = load_scenario(own, ['instance={orders_file="o.csv", pods_file="below/p.csv"}']).instance
    assert (whole.orders_file, whole.pods_file) == (str(tmp_path / "o.csv"), "p.csv")


def test_what_an_override_replaces() -> None:
    files = ["instance.orders_file=o.csv", "instance.pods_file=p.csv"]
    refilled = load_scenario("parity/rawsim-o", files).instance
    assert (refilled.orders_file, refilled.arrivals.backlog) == (str(Path("o.csv").resolve()), 200)
    assert load_scenario("examples/poisson", files).instance.arrivals.process == "start"
    mapped = load_scenario("paper-250", ["layout.map_file=hall.txt"])
    assert (mapped.layout.map_file, mapped.layout.pod_fill) == (str(Path("hall.txt").resolve()), 0.85)
    assert (mapped.stations.queue_length, mapped.stations.pick_s) == (None, 7.0)
    assert load_scenario("paper-250", ["layout.map_file="]).stations.queue_length == 12
    given = ["stations.queue_length=3", "layout.map_file=hall.txt"]
    assert load_scenario("paper-250", given).stations.queue_length == 3
    problem = r"^--set layout.block_rows=3: has no effect with `layout.map_file`; leave one of them out$"
    for order in (1, -1):
        with pytest.raises(InputError, match=problem):
            load_scenario("paper-250", ["layout.block_rows=3", "layout.map_file=hall.txt"][::order])
    joint = load_scenario("paper-250", ["rules.poa_pps=integrated"]).rules
    assert (joint.poa, joint.pps, joint.poa_pps) == (None, None, RuleChoice("integrated"))
    named = ["rules.poa.rule=first-come", "rules.pps=demand"]
    two = load_scenario("paper-250-integrated", named).rules
    assert (two.poa, two.pps, two.poa_pps) == (RuleChoice("first-come"), RuleChoice("demand"), None)
    assert load_scenario("paper-250-integrated", ["rules.poa=", "rules.poa_pps.gap=0.1"]).rules.poa_pps is not None
    assert said(InputError, load_scenario, "paper-250-integrated", ["rules.poa=pod-match"]) == (
        "--set rules.poa=pod-match, rules: expected `poa` and `pps`, or `poa_pps`, found `poa` alone"
    )


def keys_of_files(section: type, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    for field in attrs.fields(section):
        inner = Spread if "ServiceTime" in str(field.type) else section_class(section, field.name)
        if inner is not None and attrs.has(inner):
            yield from keys_of_files(inner, (*path, field.name))
        elif field.name.endswith("_file") or "CSV" in field.metadata.get("doc", ""):
            yield (*path, field.name)


def test_every_key_that_names_a_file_is_known_as_one() -> None:
    """Else its file is looked up in another place, and a change in it goes unnoticed."""
    assert set(keys_of_files(Scenario)) == set(DATA_FILES)


def test_texts_of_parameters_are_given_where_the_command_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rule = '{ rule = "pod-match", a = "w" }'
    (tmp_path / "own.toml").write_text(OWN.replace('"pod-match"', rule), encoding="utf-8")
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    given = load_scenario("../own.toml", ["rules.poa.b=w", 'rules.pps={rule="demand", c=["w"]}']).rules
    assert (given.poa.parameters, given.pps.parameters) == ({"a": "w", "b": "w"}, {"c": ["w"]})
    assert type(given.poa.parameters["a"]) is str
    assert given.poa.parameters["b"].there == given.pps.parameters["c"][0].there == str(tmp_path / "other")
    monkeypatch.chdir(tmp_path)
    assert type(load_scenario("own.toml", ["rules.poa.b=w"]).rules.poa.parameters["b"]) is str
    text = given.poa.parameters["b"]
    assert given_in({"b": text}, ("rules", "poa"), "/there")["b"].there == text.there  # not given anew
    assert (json.dumps([text]), repr(text)) == ('["w"]', f"'w' in {tmp_path}/other")
    for same in (copy.deepcopy(text), pickle.loads(pickle.dumps(text))):
        assert (same, same.there) == ("w", f"{tmp_path}/other")


TEXTS = st.text(st.characters(codec="utf-8"), max_size=8)
COUNTS = st.integers(1, 10**5)
TIMES = st.floats(0.001, 1e6)
TOML_VALUES = st.recursive(
    st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | TEXTS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS, inner, max_size=3),
    max_leaves=6,
)
PARAMETERS = st.dictionaries(TEXTS.filter(lambda name: name != "rule"), TOML_VALUES, max_size=3)
SOME_RULES = st.builds(RuleChoice, TEXTS.filter(bool), PARAMETERS)
MANY_RULES = st.lists(SOME_RULES, max_size=2).map(tuple)
CAPACITIES = COUNTS | st.lists(COUNTS, min_size=1, max_size=3).map(tuple)
INSTANCES = st.builds(
    InstanceSection,
    orders=st.integers(0, 500),
    skus=st.integers(3, 100),
    items_per_sku=st.none() | COUNTS,
    arrivals=st.just(Arrivals()) | st.builds(Arrivals, st.just("poisson"), TIMES),
    pods_at_stations=st.dictionaries(TEXTS, st.lists(TEXTS, max_size=2).map(tuple), max_size=2),
) | st.builds(InstanceSection, orders_file=TEXTS, pods_file=TEXTS)
TWO_RULES = st.builds(
    RulesSection, poa=SOME_RULES, pps=SOME_RULES, pr=SOME_RULES, filters=MANY_RULES, observers=MANY_RULES
)
SCENARIOS = st.builds(
    Scenario,
    rules=TWO_RULES | st.builds(RulesSection, poa_pps=SOME_RULES),
    seed=st.integers(0, 2**63 - 1),
    instance=INSTANCES,
    layout=st.builds(LayoutSection, block_rows=st.integers(1, 1000), pod_fill=st.floats(0.01, 1))
    | st.builds(LayoutSection, pod_fill=st.floats(0.01, 1), map_file=TEXTS),
    robots=st.builds(RobotsSection, count=COUNTS, top_speed_m_per_s=st.floats(0.001, 1000)),
    stations=st.builds(StationsSection, item_capacity=CAPACITIES, order_capacity=st.none() | CAPACITIES),
    run=st.builds(RunSection, until_s=st.none() | TIMES),
)


@settings(deadline=None)
@given(SCENARIOS, st.booleans())
def test_what_is_written_reads_back_as_an_equal_scenario(scenario: Scenario, comments: bool) -> None:
    assert scenario_from_dict(tomllib.loads(to_toml(scenario, comments=comments))) == scenario
    assert scenario_from_dict(json.loads(json.dumps(scenario_to_dict(scenario)))) == scenario


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_read_back(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario_from_dict(tomllib.loads(to_toml(scenario))) == scenario


def test_every_key_is_written_with_its_meaning_and_unit() -> None:
    text = to_toml(load_scenario("paper-250"))
    assert "# Time of picking a unit: holds the picker, the pod and its robot (s)\npick_s = 7.0\n" in text
    assert "hall_width = 5\n" in text
    assert "until_s" not in text
    tables: dict[str, Any] = scenario_to_dict(load_scenario("paper-250", ["rules.poa.x=1"]))
    assert tables["rules"]["poa"] == {"rule": "pod-match", "x": 1}
    assert tables["rules"]["pps"] == "demand"
