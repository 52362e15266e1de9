"""`rmfs scenario`: check, show, schema and list."""

import json
import tomllib
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

import rmfs_core
from calling import exit_code
from cases import cases
from installed import RMFS
from rmfs_commands.cli.checking import check_scenario, load_checked
from rmfs_commands.cli.main import main
from rmfs_commands.cli.schema import scenario_schema
from rmfs_commands.cli.toml_scenario import to_toml
from rmfs_commands.layouts import parse_map
from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario, scenario_to_dict, shipped_scenarios
from rmfs_core.world import make_layout


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = exit_code(*arguments)
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_pass(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "scenario", "check", name)
    assert code == 0
    assert all(": ignored `" in line for line in err.splitlines())
    assert out.startswith(f"{name} is valid: ")


def test_check_says_that_it_loads_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine.py").write_text(RULE, encoding="utf-8")
    file = tmp_path / "mine.toml"
    file.write_text('[rules]\npoa = "./mine.py:Mine"\npps = "demand"\n', encoding="utf-8")
    code, _, err = run(capsys, "scenario", "check", str(file))
    assert (code, err) == (0, f"Loaded code from {tmp_path / 'mine.py'}.\n")


def test_the_resolved_scenario_and_the_schema(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code, out, _ = run(capsys, "scenario", "show", "examples/small", "--set", "robots.count=3", "--seed", "9")
    assert (code, tomllib.loads(out)["seed"]) == (0, 9)
    (tmp_path / "again.toml").write_text(out, encoding="utf-8")
    assert load_scenario(tmp_path / "again.toml") == load_scenario("examples/small", ["robots.count=3"], 9)
    rmfs_core.run("examples/small", overrides=["robots.count=3", "instance.orders=5"], seed=9, out=tmp_path / "out")
    ran = [run(capsys, "scenario", "show", str(one)) for one in (tmp_path / "out", tmp_path / "out" / "result.json")]
    assert {code for code, _, _ in ran} == {0}
    for _, out, _ in ran:
        (tmp_path / "ran.toml").write_text(out, encoding="utf-8")
        assert load_scenario(tmp_path / "ran.toml") == load_scenario(tmp_path / "again.toml", ["instance.orders=5"])
    code, _, error = run(capsys, "scenario", "show", str(tmp_path / "out"), "--seed", "3")
    assert (code, error.endswith("expected neither with the folder of a run\n")) == (2, True)
    (tmp_path / "examples" / "small").mkdir(parents=True)  # a folder without a result hides no scenario of that name
    monkeypatch.chdir(tmp_path)
    assert run(capsys, "scenario", "show", "examples/small")[0] == 0
    code, out, _ = run(capsys, "scenario", "schema")
    assert code == 0
    assert json.loads(out)["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    code, _, error = run(capsys, "scenario", "show", "small")
    assert code == 2
    assert error.endswith("no shipped scenario of that name (did you mean `examples/small`?)\n")


def test_check_and_list_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "scenario", "check", "examples/small", "--json")
    assert (code, err) == (0, "")
    assert json.loads(out)["valid"]
    assert json.loads(out)["sizes"]["orders"] == 50
    code, out, err = run(capsys, "scenario", "check", "examples/small", "--json", "--set", "robots.count=0")
    assert (code, err) == (2, "")
    problem = "expected a whole number from 1 to 100,000, found 0"
    assert json.loads(out)["problems"] == [{"place": "--set robots.count=0", "problem": problem}]
    _, out, _ = run(capsys, "scenario", "list", "--json")
    assert [(one["name"], Path(one["file"])) for one in json.loads(out)] == list(shipped_scenarios().items())


@pytest.mark.parametrize("name", ["examples/small", "examples/text-map", "examples/example-appendix", "paper-250"])
def test_a_map_reads_back_as_the_same_layout(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = run(capsys, "scenario", "map", name)
    assert (code, err) == (0, "")
    layout, again = make_layout(load_scenario(name)), parse_map(out, "map")
    assert (again.width, again.height, again.stations) == (layout.width, layout.height, layout.stations)
    assert (again.kind == layout.kind).all()
    assert (again.moves == layout.moves).all()


@pytest.mark.parametrize("width", [60, 80, 140])
def test_the_list_fits_the_screen(capsys, monkeypatch, width) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    code, out, _ = run(capsys, "scenario", "list")
    assert code == 0
    assert max(map(len, out.splitlines())) <= width
    first_words = [line.split()[0] for line in out.splitlines() if not line.startswith(" ")]
    assert first_words == list(shipped_scenarios())


RULE = """
from attrs import define
from rmfs_core import hookimpl
@define
class Mine:
    size: int = 1
    needs = ("item capacity",)
    @hookimpl
    def assign_orders(self, warehouse): return []
"""

WRONG = """\
sed = 3
[instance]
orders = 50
pods = 600
[layout]
stations_east = 2
[stations]
item_capacity = [20, 20, 20]
handle_s = 2.0
pick_s = 7.0
[robots]
count = "many"
cuont = 7
lift_s = -1
[rules]
poa = { rule = "pod-mach" }
pr = { rule = "nearest", x = 1, y = 2 }
ta = "demand"
filters = ["most-covered", { rule = "most-covred" }]
"""


def problems(path: Path | str, *overrides: str, allow_inline: bool = True) -> list[str]:
    checked = check_scenario(str(path), overrides, None, allow_inline=allow_inline)
    return [f"{one['place']}: {one['problem']}" for one in checked.problems]


def test_everything_that_is_wrong_is_named_with_its_place(tmp_path: Path) -> None:
    file = tmp_path / "wrong.toml"
    file.write_text(WRONG, encoding="utf-8")
    assert problems(file, "rules.pps=demnd", "robots", "stations.foo=") == [
        "--set robots: expected key=value, such as instance.orders=50",
        "--set stations.foo=: unknown key `foo`; expected one of `also_replenish`, `bundle_capacity`, `handle_s`, "
        "`item_capacity`, `line_s`, `open`, `order_capacity`, `order_s`, `outages`, `oversize`, `pick_s`, "
        "`queue_length`, `release`, `speed`, `store_s`",
        f"{file}, line 1, sed: unknown key (did you mean `seed`?)",
        f"{file}, line 7, stations: expected handle_s >= pick_s, found 2.0 < 7.0",
        f'{file}, line 12, robots.count: expected a whole number, found "many"',
        f"{file}, line 13, robots.cuont: unknown key (did you mean `count`?)",
        f"{file}, line 14, robots.lift_s: expected a number from 0 to 3600, found -1.0",
        f'{file}, line 16, rules.poa: there is no rule "pod-mach" (did you mean `pod-match`?)',
        '--set rules.pps=demnd: there is no rule "demnd" (did you mean `demand`?)',
        f'{file}, line 19, rules.filters[1]: there is no rule "most-covred" (did you mean `most-covered`?)',
        f'{file}, line 17, rules.pr.x: rule "nearest" ({RMFS}) has no parameter `x`; it has no parameters',
        f'{file}, line 17, rules.pr.y: rule "nearest" ({RMFS}) has no parameter `y`; it has no parameters',
        f'{file}, line 18, rules.ta: rule "demand" ({RMFS}) decides PPS; expected a rule for TA',
        f'{file}, line 19, rules.filters[0].n: rule "most-covered" ({RMFS}) needs the parameter `n`, which is missing',
        f"{file}, line 4, instance.pods: found 600 pods, but the layout has 504 storage locations",
        f"{file}, line 8, stations.item_capacity: found 3 capacities, but the layout has 2 picking stations",
    ]


def test_short_skus_and_large_orders_are_named_together(tmp_path: Path) -> None:
    orders = [(1, "a", 2), (1, "b", 3), (2, "c", 9), *((number, f"s{number}", 8) for number in range(3, 10))]
    rows = "".join(f"{number},0,{sku},{quantity}\n" for number, sku, quantity in orders)
    (tmp_path / "orders.csv").write_text(f"order,arrival_s,sku,quantity\n{rows}", encoding="utf-8")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\np,a,1\np,b,\n", encoding="utf-8")
    file = tmp_path / "short.toml"
    file.write_text(
        '[instance]\norders_file = "orders.csv"\npods_file = "pods.csv"\n'
        'pods_at_stations = { 1 = ["q"], 9 = ["p"] }\n[stations]\nitem_capacity = 7\noversize = "refuse"\n'
        '[rules]\npoa = "pod-match"\npps = "demand"\n',
        encoding="utf-8",
    )
    assert problems(file) == [
        f"{tmp_path}/orders.csv, line 2: from order 1 on, the orders want more than all pods hold: "
        "SKU a (2 wanted, 1 there), SKU c (on no pod), SKU s3 (on no pod), SKU s4 (on no pod), SKU s5 (on no pod) "
        "and 4 more; expected more items on pods, or `instance.replenishment`"
        " (`rmfs convert orders --in-stock` leaves out what stock cannot serve)",
        f"{tmp_path}/orders.csv, line 4: order 2 has 9 items, order 3 has 8 items, order 4 has 8 items, "
        "order 5 has 8 items, order 6 has 8 items and 3 more, more than any station takes at a time (7); "
        'expected a larger `stations.item_capacity` or `stations.oversize` = "alone"',
        f"{file}, line 4, instance.pods_at_stations.1: there is no pod q with contents",
        f"{file}, line 4, instance.pods_at_stations.9: no station 9; expected 1 to 4",
    ]


def test_what_only_follows_is_not_reported(tmp_path: Path) -> None:
    file = tmp_path / "one.toml"
    file.write_text(
        '[instance]\nskus = "x"\nskus_per_pod = 500\n[layout]\nstations_east = "x"\n[stations]\n'
        'item_capacity = [15, 15]\n[rules]\npoa = "pod-match"\n',
        encoding="utf-8",
    )
    assert problems(file) == [
        f'{file}, line 2, instance.skus: expected a whole number, found "x"',
        f'{file}, line 5, layout.stations_east: expected a whole number, found "x"',
        f"{file}, line 8, rules: expected `poa` and `pps`, or `poa_pps`, found `poa` alone",
    ]


@cases(
    "overrides start",
    (["instance.arrivals.process=poisson", "instance.arrivals.orders_per_hour=-4"], "expected a number from 0.001"),
    (["instance.due.allowance_s=x"], 'expected a number, found "x"'),
    (["rules.poa_pps.urge_s=500"], "expected a key `rule`"),
)
def test_one_cause_is_one_mistake(overrides: list[str], start: str) -> None:
    (found,) = problems("examples/small", *overrides)
    assert found.startswith(f"--set {overrides[-1]}")
    assert f": {start}" in found


def test_rules_are_a_part_that_may_be_missing_or_anything(tmp_path: Path) -> None:
    file = tmp_path / "rules.toml"
    file.write_text("[robots]\ncount = 0\n", encoding="utf-8")
    count = f"{file}, line 2, robots.count: expected a whole number from 1 to 100,000, found 0"
    assert problems(file) == [count, f"{file}, rules: this part is missing"]
    assert problems(file, "rules=3") == [count, "--set rules=3: expected a table, found 3"]
    both = ["rules.poa=pod-match", "rules.pps=demand", "rules.poa_pps=integrated"]
    assert problems(file, *both)[1:] == [
        "--set rules.poa_pps=integrated, rules: expected either `poa_pps` or `poa` and `pps`, found both"
    ]
    filters = ["rules.poa=pod-match", "rules.pps=demand", "rules.filters=3", "rules.observers=[3]"]
    assert problems(file, *filters)[1:] == [
        "--set rules.filters=3: expected a list, found 3",
        "--set rules.observers=[3], rules.observers[0]: expected the name of a rule or a table "
        '{ rule = "...", parameter = ... }, found 3',
    ]


def test_bundles_that_no_rule_decides_on_are_a_mistake_beside_others(tmp_path: Path) -> None:
    file = tmp_path / "bundles.toml"
    rules = '[rules]\npoa = "pod-matsch"\npps = "demand"\n'
    bundles = '[instance.replenishment]\nprocess = "poisson"\nbundles_per_hour = 9\nbundle_items = 2\n'
    file.write_text(f"{rules}{bundles}", encoding="utf-8")
    assert problems(file) == [
        f'{file}: expected `rules.roa` and `rules.rps`, or `rules.roa_rps`, with the replenishment process "poisson"',
        f'{file}, line 2, rules.poa: there is no rule "pod-matsch" (did you mean `pod-match`?)',
    ]


def test_needs_and_parameters_of_rules_from_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(RULE, encoding="utf-8")
    chosen = ["rules.poa.rule=./mine.py:Mine", "rules.poa.size=big", "stations.order_capacity=3"]
    size, needs = problems("paper-250", *chosen[:2]), problems("paper-250", *chosen[:1], *chosen[2:])
    assert size == ['--set rules.poa.size=big: expected a whole number, found "big"']
    assert len(needs) == 1
    assert needs[0].startswith("--set rules.poa.rule=./mine.py:Mine, rules.poa: rule ")
    assert "needs stations that count items" in needs[0]
    checked = check_scenario("paper-250", chosen[:1], None, allow_inline=True)
    assert (checked.problems, checked.inline_files) == ([], [f"{tmp_path}/mine.py"])
    assert checked.sizes["orders"] == 250
    assert "--no-inline-rules refuses" in problems("paper-250", *chosen[:1], allow_inline=False)[0]


def test_a_file_that_a_parameter_names_and_that_is_not_there(tmp_path: Path) -> None:
    rule = RULE.replace("    size: int = 1", "    size: Path").replace(
        "from attrs", "from pathlib import Path\nfrom attrs", 1
    )
    (tmp_path / "mine.py").write_text(rule, encoding="utf-8")
    scenario = '[rules]\npps = "demand"\npoa = { rule = "./mine.py:Mine", size = "w.txt" }\n'
    file = tmp_path / "s.toml"
    file.write_text(scenario, encoding="utf-8")
    assert problems(file) == [f"{file}, line 3, rules.poa.size: there is no file {tmp_path}/w.txt"]


def test_what_cannot_be_checked(tmp_path: Path) -> None:
    found = problems("paper-250-integrated", "stations.item_capacity=3", "stations.oversize=refuse", "robots.count=0")
    assert found[0] == "--set robots.count=0: expected a whole number from 1 to 100,000, found 0"
    assert len(found) == 2
    assert "more than any station takes at a time (3); expected" in found[1]
    with pytest.raises(InputError, match="there is no such file"):
        check_scenario(str(tmp_path / "none.toml"), (), None, allow_inline=True)
    found = check_scenario("paper-250", [f"rules.observers=[{2000 * '0,'}]"], None, allow_inline=False).problems
    assert len(found) == 51
    assert found[-1]["problem"] == "is checked no farther after 50 mistakes"


def test_every_mistake_in_csv_files_is_named(tmp_path: Path) -> None:
    (tmp_path / "o.csv").write_text(
        "order,arrival_s,sku,quantity\n1,0,a,1\n1,5,b,1\n2,soon,a,1\n3,0,,1\n4,0,a\n5,0,a,0\n", encoding="utf-8"
    )
    (tmp_path / "p.csv").write_text("pod,sku,quantity\np,a,lots\n", encoding="utf-8")
    files = [f"instance.orders_file={tmp_path}/o.csv", f"instance.pods_file={tmp_path}/p.csv"]
    at = f"{tmp_path}/o.csv, line"
    assert problems("paper-250", *files) == [
        f"{at} 3, arrival_s: expected 0 as in the first row of order 1, found 5",
        f'{at} 4, arrival_s: expected a number of seconds >= 0, found "soon"',
        f"{at} 5, sku: expected a name, found nothing",
        f"{at} 6: expected 4 fields as in the header, found 3",
        f'{at} 7, quantity: expected a whole number >= 1, found "0"',
        f"{tmp_path}/p.csv, line 2, quantity: expected a whole number >= 0, or nothing for an unlimited number, "
        'found "lots"',
    ]
    rows = [f"1,0,a,x{number}\n" for number in range(30)]
    (tmp_path / "o.csv").write_text("order,arrival_s,sku,quantity\n" + "".join(rows), encoding="utf-8")
    *named, more = problems("paper-250", *files)
    assert len(named) == 20
    assert more.endswith(": and 11 more mistakes in its files")
    (tmp_path / "o.csv").write_text("order\n1\n", encoding="utf-8")
    assert [one.partition(":")[0] for one in problems("paper-250", *files)] == [
        f"{tmp_path}/o.csv, line 1",
        f"{tmp_path}/p.csv, line 2, quantity",
    ]


def test_mistakes_that_are_alike_are_one_line_with_their_number(tmp_path: Path) -> None:
    rows = "".join(f"{number},0,a,1,{'north' if number < 3 else 'nord'}\n" for number in range(30))
    (tmp_path / "o.csv").write_text(f"order,arrival_s,sku,quantity,route\n{rows}", encoding="utf-8")
    (tmp_path / "p.csv").write_text("pod,sku,quantity\np,a,99\n", encoding="utf-8")
    files = [f"instance.orders_file={tmp_path}/o.csv", f"instance.pods_file={tmp_path}/p.csv"]
    route = 'instance.departures={column="route", times={north=["14:00"]}}'
    assert problems("paper-250", *files, route) == [
        f"{tmp_path}/o.csv, line 5, route: found nord, which `instance.departures.times` has not "
        "(did you mean `north`?); so in 26 more lines"
    ]


def test_all_wrong_overrides_are_said_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    wrong = ("robots.cuont=3", "seed", "rules.poa=demnd")
    with pytest.raises(InputError) as last:
        load_checked("paper-250", wrong)
    assert [*capsys.readouterr().err.splitlines(), f"Error: {last.value}"] == [
        "Error: --set seed: expected key=value, such as instance.orders=50",
        "Error: --set robots.cuont=3: unknown key (did you mean `count`?)",
        'Error: --set rules.poa=demnd: there is no rule "demnd" (did you mean `demand`?)',
    ]
    assert load_checked("paper-250", ("robots.count=3",)).robots.count == 3


def test_what_may_be_a_slip_is_noted(tmp_path: Path) -> None:
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,mug,1\n", encoding="utf-8")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\n1,mug,5\n", encoding="utf-8")
    (tmp_path / "skus.csv").write_text("sku,size\nmug,1\nmugg,3\n", encoding="utf-8")
    (tmp_path / "bundles.csv").write_text("bundle,arrival_s,sku,items\nA,0,fork,1\n", encoding="utf-8")
    given = [f"instance.{what}_file={tmp_path}/{what}.csv" for what in ("orders", "pods", "skus")]
    given += [f'instance.replenishment={{process="file", file="{tmp_path}/bundles.csv"}}']
    given += ['robots.available=[["06:00", "22:00", 0]]']
    checked = check_scenario("examples/replenished", given, None, allow_inline=False)
    assert (checked.problems, checked.notes) == (
        [],
        [
            f"Note: {tmp_path}/skus.csv has SKUs that no pod, order or bundle has: mugg.",
            "Note: bundles bring SKUs that no pod has and no order wants: fork.",
            "Note: `robots.available` has no robot on duty at any time.",
        ],
    )


def test_reorder_levels_that_are_raised_or_never_reached_are_noted(tmp_path: Path) -> None:
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\n1,0,mug,1\n2,9,mug,8\n2,9,tea,3\n")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\n1,mug,5\n")
    (tmp_path / "skus.csv").write_text("sku,size,reorder_point\nmug,2,\ntea,1,2\n")
    given = [f"instance.{what}_file={tmp_path}/{what}.csv" for what in ("orders", "pods", "skus")]
    given += ["instance.replenishment={process='reorder-point', reorder_point=4, order_up_to=13}"]
    given += ["rules.wait_for_stock=false"]
    assert check_scenario("examples/replenished", given, None, allow_inline=False).notes[1:3] == [
        "Note: the reorder point is raised of SKU mug from 4 to 7, as an order line wants 8 items of it.",
        "Note: `order_up_to` is more than all pods together have space for: SKU mug (13, and space for 12).",
    ]
    given[3] = "instance.replenishment={process='reorder-point', reorder_point=4, order_up_to=10}"
    assert check_scenario("examples/replenished", given, None, allow_inline=False).notes[2] == (
        "Note: stock up to `order_up_to` of all SKUs needs space for 30, and all pods together have 24; bundles may "
        "wait for space."
    )


def test_no_orders_are_noted_before_and_after_a_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "orders.csv").write_text("order,arrival_s,sku,quantity\n", encoding="utf-8")
    (tmp_path / "pods.csv").write_text("pod,sku,quantity\n1,mug,5\n", encoding="utf-8")
    files = [f"instance.{what}_file={tmp_path}/{what}.csv" for what in ("orders", "pods")]
    assert check_scenario("examples/small", files, None, allow_inline=False).notes == ["Note: there are no orders."]
    main(["run", "examples/small", *(f"--set={file}" for file in files), "--out", str(tmp_path / "out")])
    assert "There were no orders" in capsys.readouterr().out


TEN_ARRIVE = "instance.arrivals={process='poisson', orders_per_hour=10}"
AT_NIGHT = ["instance.start=2026-01-05T08:00:00", TEN_ARRIVE, 'stations.open=[["22:00","06:00"]]']
MORNING = 'stations.open=[["06:00", "10:00"]]'


@cases(
    "overrides note",
    (['instance.departures={times=["00:00"], cutoff_s=60}'], "Note: 9 orders go with a truck of a later day than"),
    (["costs={packer_per_h=1}"], "Note: `costs.packer_per_h` is paid to nobody: there are no packing stations."),
    (AT_NIGHT, "Note: all 9 orders arrive while no station is open (`stations.open`)."),
    ([*AT_NIGHT, 'instance.departures={times=["18:00"], cutoff_s=60}'], "Note: the trucks of 9 orders leave before a "),
    (["costs={late_h=1}"], "Note: `costs.late_order` and `costs.late_h` count nothing: no order has a due time."),
    (
        [MORNING, 'robots.available=[["12:00", "16:00"]]'],
        "Note: no robot is on duty while a station is open (`robots.available`, `stations.open`)",
    ),
    (
        ["run.until_s=60", "run.warmup_s=60"],
        "Note: the run ends (`run.until_s` = 60) no later than its warm-up (`run.warmup_s` = 60)",
    ),
)
def test_hours_departures_and_costs_that_may_be_slips_are_noted(overrides: list[str], note: str) -> None:
    found = check_scenario("examples/small", ["instance.orders=9", *overrides], None, allow_inline=False)
    assert not found.problems
    assert any(one.startswith(note) for one in found.notes)


@cases(
    "scenario overrides word noted",
    ("paper-250", [], "`max_wait_s` of pod-match", True),
    ("paper-250", ["rules.poa.max_wait_s=600"], "max_wait_s", False),
    ("paper-250", ["stations.order_capacity=6"], "max_wait_s", False),
    ("paper-250-split-over-time", [], "max_wait_s", False),
    ("examples/replenished", [], "order_up_to", False),
    ("examples/replenished", [], "reorder point", False),
    ("examples/small", [MORNING, 'robots.available=[["09:59", "16:00"]]'], "on duty", False),
    ("examples/small", [*AT_NIGHT, "instance.arrivals={process='start'}"], "no station is open", False),
    ("examples/small", [*AT_NIGHT, 'stations.open=[["08:01","06:00"]]'], "no station is open", False),
)
def test_what_is_no_slip_is_not_noted(scenario: str, overrides: list[str], word: str, noted: bool) -> None:
    found = check_scenario(scenario, overrides, None, allow_inline=False)
    assert not found.problems
    assert any(word in one for one in found.notes) == noted


NO_SCENARIOS = [
    {"robots": {"cuont": 1}},  # unknown key
    {"robots": {"count": 0}},  # out of range
    {"robots": {"count": "2"}},  # wrong type
    {"layout": {"pod_fill": 0}},  # exclusive minimum
    {"instance": {"arrivals": {"process": "poison"}}},  # not one of the words
    {"rules": {"poa": {"x": 1}}},  # a rule's table without the rule
    {"stations": {"item_capacity": ["x"]}},  # within a list
]


def test_the_schema_is_a_schema() -> None:
    Draft202012Validator.check_schema(scenario_schema())
    pick_s = scenario_schema()["properties"]["stations"]["properties"]["pick_s"]
    seconds, spread = pick_s["anyOf"]
    assert (seconds["minimum"], seconds["maximum"], spread["properties"]["cv"]["maximum"]) == (0.001, 3600, 10)
    turn = scenario_schema()["properties"]["robots"]["properties"]["full_turn_s"]
    assert turn == {
        "type": "number",
        "description": "Time of a full turn on the spot (s)",
        "minimum": 0.001,
        "maximum": 3600,
        "default": 2.5,
    }


@pytest.mark.parametrize("change", NO_SCENARIOS)
def test_mistakes_are_marked(change: dict[str, object]) -> None:
    rules = {"poa": "pod-match", "pps": "demand"}
    assert not Draft202012Validator(scenario_schema()).is_valid({"rules": rules, **change})


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_follow_the_schema(name: str) -> None:
    validator = Draft202012Validator(scenario_schema())
    validator.validate(tomllib.loads(shipped_scenarios()[name].read_text(encoding="utf-8")))
    validator.validate(scenario_to_dict(load_scenario(name)))


def test_scenarios_as_toml() -> None:
    scenario = load_scenario("examples/small")
    assert max(map(len, to_toml(scenario).splitlines())) <= 100
    assert "#" not in to_toml(scenario, comments=False)
