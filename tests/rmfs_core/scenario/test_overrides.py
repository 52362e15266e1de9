"""`--set`: values from the command line."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import attrs
import pytest

from rmfs_core.errors import InputError
from rmfs_core.scenario import RuleChoice, Scenario, load_scenario
from rmfs_core.scenario.overrides import DATA_FILES
from rmfs_core.scenario.structuring import section_class

WRONG = [
    # no equals sign
    (["seed"], "--set seed: expected key=value, such as instance.orders=50"),
    # no key
    (["=3"], "--set =3: expected key=value, such as instance.orders=50"),
    # an empty part of a key
    (["instance..orders=3"], "--set instance..orders=3: expected key=value, such as instance.orders=50"),
    # a misspelt key
    (["robots.cuont=3"], "--set robots.cuont=3: unknown key (did you mean `count`?)"),
    # a wrong type, a value out of range
    (["robots.count=many"], '--set robots.count=many: expected a whole number, found "many"'),
    (["robots.count=0"], "--set robots.count=0: expected a whole number from 1 to 100,000, found 0"),
    # a whole table, wrong inside
    (["robots={count=0}"], "--set robots={count=0}, robots.count: expected a whole number from 1 to 100,000, found 0"),
    # a key below a value
    (["seed.x=2"], "--set seed.x=2: `seed` has no keys of its own, it is 1"),
    # an unknown rule
    (["rules.poa=pod-mach"], '--set rules.poa=pod-mach: there is no rule "pod-mach" (did you mean `pod-match`?)'),
    # the wrong one of two is the last
    (["robots.count=2", "robots.count=0"], "--set robots.count=0: expected a whole number from 1 to 100,000, found 0"),
    # taking out a key that no scenario has
    (["robots.cuont="], "--set robots.cuont=: unknown key `cuont` (did you mean `count`?)"),
    # values that do not go together
    (["rules.pps="], "--set rules.pps=, rules: expected `poa` and `pps`, or `poa_pps`, found `poa` alone"),
    # a rule for orders takes the place of the joint one; then one for pods is wanted too
    (
        ["rules.poa_pps=integrated", "rules.poa=pod-match"],
        "--set rules.poa=pod-match, rules: expected either `poa_pps` or `poa` and `pps`, found both",
    ),
    # something that only looks like a table
    (
        ["rules.poa={rule=pod-match}"],
        "--set rules.poa={rule=pod-match}: this is no valid TOML value: "
        "Invalid value (at line 1, column 15); texts in it need quotes",
    ),
    # a line break does not smuggle a second key in
    (["seed=1\nx=2"], '--set seed=1\nx=2: expected a whole number, found "1\\nx=2"'),
]


@pytest.mark.parametrize(("overrides", "message"), WRONG)
def test_a_wrong_override_is_one_sentence(overrides: list[str], message: str) -> None:
    """A mistake in an override is named like one in a file, with the override as its place."""
    with pytest.raises(InputError) as caught:
        load_scenario("paper-250", overrides)
    assert str(caught.value) == message


def test_values_are_toml_or_plain_text() -> None:
    """Numbers, lists and texts with or without quotes are understood."""
    scenario = load_scenario(
        "paper-250",
        [
            "instance.orders=50",
            "stations.item_capacity=[1, 2, 3, 4]",
            "rules.poa=first-come",
            'rules.pps="nearest-pod"',
            "instance.start=2026-03-02T06:00:00",
        ],
    )
    assert scenario.instance.start == "2026-03-02T06:00:00"
    assert scenario.instance.orders == 50
    assert scenario.stations.item_capacity == (1, 2, 3, 4)
    assert scenario.rules.poa == RuleChoice("first-come")
    assert scenario.rules.pps == RuleChoice("nearest-pod")


def test_a_parameter_is_added_to_a_rule_given_by_name() -> None:
    """`rules.poa.x=1` keeps the rule of `poa = "pod-match"`; `rules.poa.rule=...` keeps parameters."""
    scenario = load_scenario("paper-250", ["rules.poa.x=1", "rules.pps.y=2", "rules.pps.rule=nearest-pod"])
    assert scenario.rules.poa == RuleChoice("pod-match", {"x": 1})
    assert scenario.rules.pps == RuleChoice("nearest-pod", {"y": 2})


def test_one_kind_of_rules_takes_the_place_of_the_other() -> None:
    """A joint rule needs nothing taken out, nor do the two rules that take its place; parameters choose nothing."""
    joint = load_scenario("paper-250", ["rules.poa_pps=integrated"]).rules
    assert (joint.poa, joint.pps, joint.poa_pps) == (None, None, RuleChoice("integrated"))
    named = ["rules.poa.rule=first-come", "rules.pps=demand"]
    two = load_scenario("paper-250-integrated", named).rules
    assert (two.poa, two.pps, two.poa_pps) == (RuleChoice("first-come"), RuleChoice("demand"), None)
    assert load_scenario("paper-250-integrated", ["rules.poa=", "rules.poa_pps.gap=0.1"]).rules.poa_pps is not None
    with pytest.raises(InputError) as caught:
        load_scenario("paper-250-integrated", ["rules.poa=pod-match"])
    assert str(caught.value) == (
        "--set rules.poa=pod-match, rules: expected `poa` and `pps`, or `poa_pps`, found `poa` alone"
    )


@pytest.mark.parametrize("nothing", ["", "None", "null"])
def test_nothing_takes_a_key_out(nothing: str) -> None:
    """TOML has no word for it; the words of Python and JSON are understood, and are texts in quotes."""
    scenario = load_scenario(
        "paper-250", [f"robots.count={nothing}", f"rules.poa.x={nothing}", f'rules.poa.y="{nothing}"']
    )
    assert scenario.robots.count == 8
    assert scenario.rules.poa == RuleChoice("pod-match", {"y": nothing})


def test_an_empty_value_takes_a_key_out() -> None:
    """Two rules make room for a joint one; a key that is not there may be taken out as well."""
    scenario = load_scenario("paper-250", ["rules.poa=", "rules.pps=", "rules.poa_pps=demand", "run.until_s="])
    assert scenario.rules.poa is None
    assert scenario.rules.poa_pps == RuleChoice("demand")
    assert load_scenario("paper-250", ["robots.count="]).robots.count == 8
    assert load_scenario("examples/poisson", ["instance.arrivals="]).instance.arrivals.process == "start"


RULE = "from attrs import define\n\n\n@define\nclass X:\n    pass\n"


def test_rules_from_files_are_looked_up_where_the_command_is_called(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A shipped scenario gets them by their absolute path, one in the current folder as its own text names them."""
    (tmp_path / "rules").mkdir()
    (tmp_path / "rules" / "my.py").write_text(RULE, encoding="utf-8")
    (tmp_path / "other").mkdir()
    (tmp_path / "own.toml").write_text('[rules]\npoa = "pod-match"\npps = "demand"\n', encoding="utf-8")
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


def test_rules_in_a_scenario_file_stay_relative_to_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the command is called does not matter to them; an override that is not there is refused with its place."""
    (tmp_path / "my.py").write_text(RULE, encoding="utf-8")
    (tmp_path / "own.toml").write_text('[rules]\npoa = "./my.py:X"\npps = "demand"\n', encoding="utf-8")
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    assert load_scenario("../own.toml").rules.poa == RuleChoice("./my.py:X")
    with pytest.raises(InputError) as caught:
        load_scenario("paper-250", ["rules.pps=./my.py:X"])
    assert str(caught.value) == f"--set rules.pps=./my.py:X: there is no file `{tmp_path}/other/my.py`"


def test_files_of_data_are_looked_up_where_the_command_is_called(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A shipped scenario gets them by their absolute path and without what they replace; a file's own stay its own."""
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
    (tmp_path / "below").mkdir()
    own = tmp_path / "below" / "own.toml"
    own.write_text(
        '[instance]\norders_file = "o.csv"\npods_file = "p.csv"\n[rules]\npoa = "pod-match"\npps = "demand"\n',
        encoding="utf-8",
    )
    assert load_scenario(own).instance.orders_file == "o.csv"
    assert load_scenario(own, ["instance.orders_file=below/new.csv"]).instance.orders_file == "new.csv"
    whole = load_scenario(own, ['instance={orders_file="o.csv", pods_file="below/p.csv"}']).instance
    assert (whole.orders_file, whole.pods_file) == (str(tmp_path / "o.csv"), "p.csv")


def test_what_a_file_of_data_replaces_is_refused_beside_it() -> None:
    """Where both are set on the command line, the one that would be ignored is named."""
    with pytest.raises(InputError) as caught:
        load_scenario("paper-250", ["layout.map_file=map.txt", "layout.block_rows=3"])
    assert str(caught.value) == (
        "--set layout.block_rows=3: has no meaning beside `layout.map_file`; leave one of them out"
    )


def test_sections_that_the_file_lacks_are_made() -> None:
    """An override may set a key of a section that the file does not have."""
    assert load_scenario("examples/small", ["run.until_s=100"]).run.until_s == 100.0


def test_a_file_of_orders_leaves_a_refilled_backlog_alone() -> None:
    """It says how many orders wait, not what they are; other arrivals are those of generated orders."""
    files = ["instance.orders_file=o.csv", "instance.pods_file=p.csv"]
    refilled = load_scenario("parity/rawsim-o", files).instance
    assert (refilled.orders_file, refilled.arrivals.backlog) == (str(Path("o.csv").resolve()), 200)
    assert load_scenario("examples/poisson", files).instance.arrivals.process == "start"


def test_a_map_takes_the_place_of_a_block_layout() -> None:
    """With its keys, and the length of its queues, unless it is given beside the map."""
    mapped = load_scenario("paper-250", ["layout.map_file=hall.txt"])
    assert (mapped.layout.map_file, mapped.layout.pod_fill) == (str(Path("hall.txt").resolve()), 0.85)
    assert (mapped.stations.queue_length, mapped.stations.pick_s) == (None, 7.0)
    assert load_scenario("paper-250", ["layout.map_file="]).stations.queue_length == 12
    given = ["stations.queue_length=3", "layout.map_file=hall.txt"]
    assert load_scenario("paper-250", given).stations.queue_length == 3
    with pytest.raises(InputError, match=r"^--set layout.block_rows=3: has no meaning beside `layout.map_file`"):
        load_scenario("paper-250", ["layout.block_rows=3", "layout.map_file=hall.txt"])


def keys_of_files(section: type, path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield the paths of the keys that say of themselves that they name a file."""
    for field in attrs.fields(section):
        inner = section_class(section, field.name)
        if inner is not None and attrs.has(inner):
            yield from keys_of_files(inner, (*path, field.name))
        elif field.name.endswith("_file") or "CSV" in field.metadata.get("doc", ""):
            yield (*path, field.name)


def test_every_key_that_names_a_file_is_known_as_one() -> None:
    """Else its file is looked up in another place, and a change in it goes unnoticed."""
    assert set(keys_of_files(Scenario)) == set(DATA_FILES)


def test_texts_of_parameters_are_given_where_the_command_is_called(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only the rule knows whether they name files; those of the scenario's file, and one called beside it, stay."""
    (tmp_path / "own.toml").write_text(
        '[rules]\npoa = { rule = "pod-match", a = "w" }\npps = "demand"\n', encoding="utf-8"
    )
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path / "other")
    given = load_scenario("../own.toml", ["rules.poa.b=w", 'rules.pps={rule="demand", c=["w"]}']).rules
    assert given.poa is not None
    assert given.pps is not None
    assert (given.poa.parameters, given.pps.parameters) == ({"a": "w", "b": "w"}, {"c": ["w"]})
    assert type(given.poa.parameters["a"]) is str
    assert given.poa.parameters["b"].there == given.pps.parameters["c"][0].there == str(tmp_path / "other")
    monkeypatch.chdir(tmp_path)
    beside = load_scenario("own.toml", ["rules.poa.b=w"]).rules.poa
    assert beside is not None
    assert type(beside.parameters["b"]) is str
