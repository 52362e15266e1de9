"""Scenario files: what is read, and the one sentence that says what is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from rmfs_core.errors import InputError
from rmfs_core.scenario import RuleChoice, load_scenario, located, scenario_from_dict, shipped_scenarios

RULES = '[rules]\npoa = "pod-match"\npps = "demand"\n'

BAD_FILES = [
    # a misspelt key, with the nearest one
    ("[robots]\ncuont = 3\n" + RULES, ", line 2, robots.cuont: unknown key (did you mean `count`?)"),
    # a misspelt section
    ("[robot]\ncount = 3\n" + RULES, ", line 1, robot: unknown key (did you mean `robots`?)"),
    # a key that resembles none: all are listed
    (
        "[instance.arrivals]\nx = 1\n" + RULES,
        ", line 2, instance.arrivals.x: unknown key; "
        "expected one of `backlog`, `orders_per_hour`, `process`, `profile`",
    ),
    # a text is no number
    (
        '[stations]\nitem_capacity = "8"\n' + RULES,
        ', line 2, stations.item_capacity: expected a whole number, found "8"',
    ),
    # nor is a truth value
    ("seed = true\n" + RULES, ", line 1, seed: expected a whole number, found true"),
    # nor is a fraction whole
    ("[robots]\ncount = 2.0\n" + RULES, ", line 2, robots.count: expected a whole number, found 2.0"),
    # times are finite
    ("[run]\nuntil_s = inf\n" + RULES, ", line 2, run.until_s: expected a finite number, found inf"),
    # out of range
    ("[instance]\nskus = 0\n" + RULES, ", line 2, instance.skus: expected a whole number from 1 to 2,000,000, found 0"),
    ("[layout]\npod_fill = 1.5\n" + RULES, ", line 2, layout.pod_fill: expected a number in (0, 1], found 1.5"),
    (
        "[robots]\nfull_turn_s = 1e30\n" + RULES,
        ", line 2, robots.full_turn_s: expected a number from 0.001 to 3600, found 1e+30",
    ),
    (
        "[robots]\ntop_speed_m_per_s = 1e-30\n" + RULES,
        ", line 2, robots.top_speed_m_per_s: expected a number from 0.001 to 1000, found 1e-30",
    ),
    ("[robots]\nlift_s = -1\n" + RULES, ", line 2, robots.lift_s: expected a number from 0 to 3600, found -1.0"),
    # within a list
    (
        '[stations]\nitem_capacity = [3, "x"]\n' + RULES,
        ', line 2, stations.item_capacity[1]: expected a whole number, found "x"',
    ),
    (
        "[stations]\nitem_capacity = []\n" + RULES,
        ", line 2, stations.item_capacity: expected a whole number from 1 to 1,000,000,000, or a list of them, "
        "one per station, found []",
    ),
    # one of a few words
    (
        '[instance]\narrivals = { process = "poison" }\n' + RULES,
        ', line 2, instance.arrivals.process: found "poison" (did you mean `poisson`?)',
    ),
    # values that do not go together
    (
        '[instance]\narrivals = { process = "poisson" }\n' + RULES,
        ', line 2, instance.arrivals: expected `orders_per_hour` with process "poisson", and only there',
    ),
    (
        '[instance]\narrivals = { process = "refill" }\n' + RULES,
        ', line 2, instance.arrivals: expected `backlog` with process "refill", and only there',
    ),
    (
        "[instance]\narrivals = { backlog = 9 }\n" + RULES,
        ', line 2, instance.arrivals: expected `backlog` with process "refill", and only there',
    ),
    (
        '[instance]\ndue = { allowance_s = 9 }\narrivals = { process = "refill", backlog = 9 }\n' + RULES,
        ', line 1, instance: expected no `due` with arrivals of process "refill", whose times nobody knows beforehand',
    ),
    (
        '[instance]\norders_file = "o"\npods_file = "p"\narrivals = { process = "day" }\n' + RULES,
        ", line 4, instance.arrivals: has no meaning beside `instance.orders_file`; leave one of them out",
    ),
    (
        '[stations]\nrelease = "handle"\n' + RULES,
        ', line 2, stations.release: found "handle" (did you mean `handled`?)',
    ),
    (
        '[instance]\norders_file = "o.csv"\n' + RULES,
        ", line 1, instance: expected `orders_file` and `pods_file` together, or neither",
    ),
    (
        "[instance]\nskus = 2\nskus_per_pod = 3\n" + RULES,
        ", line 1, instance: expected skus_per_pod <= skus, found 3 > 2",
    ),
    ("[stations]\nhandle_s = 2\n" + RULES, ", line 1, stations: expected handle_s >= pick_s, found 2.0 < 7.0"),
    ('[rules]\npoa = "pod-match"\n', ", line 1, rules: expected `poa` and `pps`, or `poa_pps`, found `poa` alone"),
    (RULES + 'poa_pps = "demand"\n', ", line 1, rules: expected either `poa_pps` or `poa` and `pps`, found both"),
    # a table where none belongs, and the other way round
    ("robots = 3\n" + RULES, ", line 1, robots: expected a table, found 3"),
    ('[rules]\nfilters = "x"\n', ', line 2, rules.filters: expected a list, found "x"'),
    ("[[robots]]\ncount = 3\n" + RULES, ", line 1, robots: expected a table, found [{ count = 3 }]"),
    ("[instance]\norders_file = 3\n" + RULES, ", line 2, instance.orders_file: expected a text in quotes, found 3"),
    (
        "[instance]\npods_at_stations = 3\n" + RULES,
        ", line 2, instance.pods_at_stations: expected a table, found 3",
    ),
    # rules
    (
        '[rules]\npoa = "pod-mach"\npps = "demand"\n',
        ', line 2, rules.poa: there is no rule "pod-mach" (did you mean `pod-match`?)',
    ),
    (
        '[rules]\npoa = { rle = "pod-match" }\npps = "demand"\n',
        ", line 2, rules.poa: expected a key `rule` with the name of a rule beside the parameters, found none",
    ),
    (
        "[rules]\npoa = 3\n",
        ', line 2, rules.poa: expected the name of a rule or a table { rule = "...", parameter = ... }, found 3',
    ),
    (
        '[rules]\npoa = "./mine:Rule"\npps = "demand"\n',
        ', line 2, rules.poa: expected "./file.py:Class" for a rule beside the scenario, found "./mine:Rule"',
    ),
    (
        '[rules]\npoa = "./mine.py"\npps = "demand"\n',
        ', line 2, rules.poa: expected "./file.py:Class" for a rule beside the scenario, found "./mine.py"',
    ),
    # a whole section missing
    ("seed = 1\n", ", rules: this part is missing"),
    # one value where a list belongs
    ("[instance]\nlines = 3\n" + RULES, ", line 2, instance.lines: expected a list, found 3"),
    # more than 64 bits can count, or a float can hold
    (
        "[instance]\nitems_per_sku = 10000000000000000000\n" + RULES,
        ", line 2, instance.items_per_sku: expected a whole number from 1 to 1,000,000,000, found 10000000000000000000",
    ),
    (
        "[instance]\ndue = { allowance_s = 1, spread_s = 1e308 }\n" + RULES,
        ", line 2, instance.due.spread_s: expected a number from 0 to 1e+07, found 1e+308",
    ),
    (
        "[run]\nuntil_s = 1" + "0" * 400 + "\n" + RULES,
        f", line 2, run.until_s: expected a number, found 1{'0' * 56}...",
    ),
    # no TOML at all
    ("seed = " + "9" * 5000, ": this is no valid TOML: found a number of more than 4,300 digits"),
    ("seed = " + "[" * 2000, ": this is no valid TOML: found more than 50 lists or tables in one another"),
    ("seed = 1\nrobots = \n", ", line 2, column 10: this is no valid TOML: Invalid value; texts need quotes"),
    ("seed = 1\nseed = 2\n", ", line 2, column 9: this is no valid TOML: Cannot overwrite a value"),
    # two mistakes: the first in the file, whatever the order of the keys in the documentation
    (
        "[stations]\npick_s = 0\n[robots]\ncuont = 3\n",
        ", line 2, stations.pick_s: expected a number from 0.001 to 3600, found 0.0",
    ),
    ("[robots]\ncuont = 3\n[stations]\npick_s = 0\n", ", line 2, robots.cuont: unknown key (did you mean `count`?)"),
    # a text that looks like keys: no line rather than a wrong one
    ('seed = """\n[robots]\n"""\n' + RULES, ', seed: expected a whole number, found "[robots]\\n"'),
]


@pytest.mark.parametrize(("text", "message"), BAD_FILES)
def test_a_mistake_is_one_sentence(text: str, message: str, tmp_path: Path) -> None:
    """A wrong file is refused with file, line, key, what was found and what would be right."""
    file = tmp_path / "wrong.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_scenario(file)
    assert str(caught.value) == f"{file}{message.replace('{folder}', str(tmp_path))}"


def test_every_value_is_read(tmp_path: Path) -> None:
    """Values arrive in their sections with the types that the classes say."""
    file = tmp_path / "good.toml"
    file.write_text(
        "seed = 7\n"
        '[instance]\nitems_per_sku = 4\npods_at_stations = { 1 = ["2", "1"] }\n'
        "[stations]\nitem_capacity = [3, 4]\npick_s = 5\n"
        '[rules]\npoa = { rule = "pod-match", weight = 2 }\npps = "demand"\n',
        encoding="utf-8",
    )
    scenario = load_scenario(file)
    assert scenario.seed == 7
    assert scenario.instance.items_per_sku == 4
    assert scenario.instance.pods_at_stations == {"1": ("2", "1")}
    assert scenario.stations.item_capacity == (3, 4)
    assert isinstance(scenario.stations.pick_s, float)
    assert scenario.rules.poa == RuleChoice("pod-match", {"weight": 2})
    assert scenario.rules.pr == RuleChoice("nearest")
    assert scenario.folder == str(tmp_path)


def test_windows_files_are_read(tmp_path: Path) -> None:
    """A byte order mark and line ends of Windows make no difference."""
    file = tmp_path / "windows.toml"
    file.write_bytes(b"\xef\xbb\xbf" + ("seed = 3\n" + RULES).replace("\n", "\r\n").encode())
    assert load_scenario(file).seed == 3


def test_a_file_in_another_encoding_is_refused(tmp_path: Path) -> None:
    """A file that is no UTF-8 is refused with the byte that says so."""
    file = tmp_path / "latin.toml"
    file.write_bytes(b"# gr\xfc\xdfe\n")
    with pytest.raises(InputError, match=r"latin\.toml: expected UTF-8 text, found the byte 0xfc$"):
        load_scenario(file)


def test_an_inline_rule_beside_the_scenario_is_accepted(tmp_path: Path) -> None:
    """A rule from a file is looked up in the scenario's own folder, and not imported by reading."""
    (tmp_path / "mine.py").write_text("raise SystemExit", encoding="utf-8")
    file = tmp_path / "mine.toml"
    file.write_text('[rules]\npoa = "./mine.py:Mine"\npps = "demand"\n', encoding="utf-8")
    assert load_scenario(file).rules.poa == RuleChoice("./mine.py:Mine")


@pytest.mark.parametrize("name", ["paper-250", "paper-250.toml", "examples/small", Path("examples/small.toml")])
def test_shipped_scenarios_are_found_by_name(name: str | Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A shipped scenario's name works from any folder."""
    monkeypatch.chdir(tmp_path)
    assert load_scenario(name).rules.poa == RuleChoice("pod-match")


def test_a_misspelt_file_names_the_nearest_scenario() -> None:
    """A file that is not there is compared with the shipped names."""
    with pytest.raises(InputError) as caught:
        load_scenario("paper-25")
    assert str(caught.value) == (
        "paper-25: there is no such file, and no shipped scenario of that name "
        "(did you mean `paper-250` or `paper-2000`?)"
    )


def test_a_folder_is_no_scenario(tmp_path: Path) -> None:
    """A folder is refused as such."""
    with pytest.raises(InputError, match=r": expected a scenario file, found a folder$"):
        load_scenario(tmp_path)


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_load(name: str) -> None:
    """Every shipped scenario is right."""
    load_scenario(name)


def test_the_seed_can_be_replaced() -> None:
    """The seed argument wins over the file and over overrides."""
    assert load_scenario("paper-250", ["seed=3"], seed=5).seed == 5


def test_tables_are_read_without_a_file() -> None:
    """Nested tables make a scenario, and their mistakes are named alike."""
    rules = {"poa": "pod-match", "pps": "demand"}
    assert scenario_from_dict({"rules": rules, "seed": 4}).seed == 4
    with pytest.raises(InputError) as caught:
        scenario_from_dict({"rules": rules, "seed": -4}, name="result.json")
    assert str(caught.value) == "result.json, seed: expected a whole number >= 0, found -4"


def test_later_errors_get_the_line_of_their_key(tmp_path: Path) -> None:
    """An error about a key that is found after reading names file and line too; one about another place stays."""
    file = tmp_path / "late.toml"
    file.write_text(RULES + "[instance]\npods_at_stations = { 1 = ['9'] }\n", encoding="utf-8")
    scenario = load_scenario(file, ["robots.count=3"])
    for place, expected in [
        ("instance.pods_at_stations.1", f"{file}, line 5, instance.pods_at_stations.1"),
        ("robots.count", "--set robots.count=3"),
        ("orders.csv, line 3", "orders.csv, line 3"),
    ]:
        with pytest.raises(InputError) as caught, located(scenario):
            raise InputError(place, "wrong")
        assert str(caught.value) == f"{expected}: wrong"


def test_what_is_located_stays_so(tmp_path: Path) -> None:
    """Also where one part of the code calls another that locates its errors, and the file is called like a section."""
    file = tmp_path / "run.toml"
    file.write_text("[instance]\norders = 7\n" + RULES, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        scenario = load_scenario("run.toml")
    with pytest.raises(InputError) as caught, located(scenario), located(scenario):
        raise InputError("instance.orders", "wrong")
    assert str(caught.value) == "run.toml, line 2, instance.orders: wrong"


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ('[instance]\norders = 7\norders_file = "o.csv"\npods_file = "p.csv"\n', "instance.orders"),
        ('[layout]\nstations_east = 2\nmap_file = "map.txt"\n', "layout.stations_east"),
    ],
)
def test_keys_that_a_file_replaces_are_refused(tmp_path: Path, text: str, key: str) -> None:
    """A key without a meaning beside a file that is named is an error, not ignored in silence."""
    file = tmp_path / "s.toml"
    file.write_text(text + RULES, encoding="utf-8")
    with pytest.raises(InputError, match=rf"line 2, {key}: has no meaning beside `\w+\.\w+_file`; leave one of them"):
        load_scenario(file)


def test_a_name_too_long_for_a_file_is_a_file_that_is_not_there() -> None:
    """Of a scenario and of a rule."""
    name = "a" * 300
    with pytest.raises(InputError, match="there is no such file"):
        load_scenario(f"{name}.toml")
    with pytest.raises(InputError, match=r"there is no file `.*aaa"):
        load_scenario("examples/small", [f"rules.poa=./{name}.py:Mine"])
