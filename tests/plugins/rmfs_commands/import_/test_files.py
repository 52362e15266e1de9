"""`rmfs import`: formats of files, how XML is read, what RAWSim-O has, and what then runs."""

import json
import shlex
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st

from calling import refusal, refused
from cases import cases
from rawsimo_files import keys, xgenc, xinst, xitem, xsett
from rmfs_commands.cli.main import main
from rmfs_commands.import_ import stock, xml_reading
from rmfs_commands.import_.kinds import kind_of, sorted_out
from rmfs_commands.import_.notes import Note, Notes
from rmfs_commands.import_.replenishing import Deliveries, Supply, chosen_rules, levels, storable
from rmfs_commands.import_.settings import OrderList, Setting, Sku, Spread, read_order_list, read_setting, read_skus
from rmfs_commands.import_.stock import drawn_contents, drawn_orders, stock_of, stored_bundles
from rmfs_commands.import_.warehouses import Storing
from rmfs_commands.import_.xml_reading import document, elements
from rmfs_commands.layouts import parse_map
from rmfs_core.errors import InputError


def file(folder: Path, text: str | bytes) -> Path:
    path = folder / "orders.xitem"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@cases(
    "value problem",
    ("x", "expected a number from 0 to 10 as `N` of A, found 'x'"),
    ("11", "found '11'"),
    ("NaN", "found 'NaN'"),
    ("", "found nothing"),
)
def test_wrong_numbers_are_told_with_their_line(tmp_path: Path, value: str, problem: str) -> None:
    root = document(file(tmp_path, f"<A>\n<N>{value}</N></A>"))
    said = refusal(lambda: root.number("N", least=0, most=10))
    assert said.startswith(f"{tmp_path}/orders.xitem, line 2: ")
    assert problem in said


@pytest.mark.parametrize("value", ["1.0", "-1", "1" * 30, "yes"])
def test_whole_numbers_and_truth_values_are_strict(tmp_path: Path, value: str) -> None:
    root = document(file(tmp_path, f"<A><N>{value}</N></A>"))
    with pytest.raises(InputError, match="expected a whole number"):
        root.whole("N")
    with pytest.raises(InputError, match="expected true or false"):
        root.truth("N", False)


BOMB = '<!DOCTYPE a [<!ENTITY x "ha"><!ENTITY y "&x;&x;&x;">]><a>&y;</a>'


@cases(
    "text problem",
    ("<a><b></a>", "line 1: this is no valid XML: mismatched tag"),
    ("", "line 1: this is no valid XML: no element found"),
    ("no XML", "line 1: this is no valid XML: syntax error"),
    ('<?xml version="1.0" encoding="klingon"?><a/>', "this is no valid XML: unknown encoding"),
    (BOMB, "found a document type (DOCTYPE); expected none"),
    ('<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', "found a document type (DOCTYPE); expected none"),
    ("<a>" * 40, "found more than 30 elements in one another; expected fewer"),
)
def test_what_is_no_such_file_is_refused(tmp_path: Path, text: str, problem: str) -> None:
    assert problem in refusal(lambda: document(file(tmp_path, text)))


def test_there_are_limits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    many = "<a><b>" + "<c/>" * 200 + "</b></a>"
    monkeypatch.setattr(xml_reading, "MOST_IN_ONE", 100)
    with pytest.raises(InputError, match="found more than 100 elements and signs in one element"):
        list(elements(file(tmp_path, many), 1))
    assert len(list(elements(file(tmp_path, "<a>" + "<b/>" * 200 + "</a>"), 1))) == 200
    monkeypatch.setattr(xml_reading, "MOST_AT_ONCE", 100)
    with pytest.raises(InputError, match="found more than 100 bytes without an element"):
        document(file(tmp_path, "<a>" + " " * 200_000 + "</a>"))
    monkeypatch.setattr(xml_reading, "MOST_AT_ONCE", 10**9)
    monkeypatch.setattr(xml_reading, "MOST_BYTES", 1000)
    with pytest.raises(InputError, match="found more than 1,000 bytes"):
        document(file(tmp_path, "<a>" + " " * 200_000 + "</a>"))


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    assert refusal(lambda: document(tmp_path / "none")) == f"{tmp_path}/none: cannot be read: No such file or directory"


OCTILE = "type octile\nheight 1\nwidth 2\nmap\n..\n"
TEXTS = {
    "a.xinst": keys("Instance", {}),
    "a.xsett": "\ufeff" + keys("SettingConfiguration", {}),
    "a.map": OCTILE,
    "b.map": OCTILE.replace("..\n", ".E\n"),
    "k.map": "1,2\n0\n0\n0\n..\n",
    "s.grid": "Grid size (x, y)\n1,1\n",
    "a.scen": "version 1\n",
    "a.json": '\ufeff {"mapFile": "a.map"}',
    "a.txt": "hello\n",
    "a.html": "<html></html>",
    "broken.xinst": '<?xml version="1.0"?>\n<Instance Name="A & B"></Instance>',
    "empty": "",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in TEXTS.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@cases(
    "name found",
    ("a.txt", "found none of these"),
    ("a.html", "found an XML file of html"),
    ("broken.xinst", "broken.xinst, line 2: this is no valid XML: not well-formed"),
    ("empty", "found none of these"),
    ("none", "cannot be read: No such file or directory"),
    (".", "cannot be read: Is a directory"),
)
def test_other_files_are_refused(folder: Path, name: str, found: str) -> None:
    assert found in refusal(lambda: kind_of(folder / name))


@cases(
    "names asked chosen",
    (["a.xsett", "a.xinst"], None, "rawsim-o"),
    (["k.map"], None, "rhcr"),
    (["s.grid"], "rhcr", "rhcr"),
    (["a.json"], None, "lorr"),
    (["a.map"], None, "movingai"),
    (["b.map"], None, "lorr"),
    (["a.map"], "lorr", "lorr"),
    (["b.map"], "movingai", "movingai"),
    (["a.map", "a.scen"], None, "movingai"),
)
def test_files_of_one_instance_have_one_format(folder: Path, names: list[str], asked: str | None, chosen: str) -> None:
    assert sorted_out([folder / name for name in names], asked)[0] == chosen


@cases(
    "names asked message",
    (["a.map", "b.map"], None, "a.map, too, which is of the same kind; expected one of them"),
    (["a.map", "a.xinst"], None, "a.map and a.xinst: found files of different formats, or one missing; expected"),
    (["a.scen"], None, "a.scen: found files of different formats, or one missing"),
    (["k.map"], "lorr", "--format: found files that the League of Robot Runners does not have together; they look"),
    (["a.map", "a.xinst"], "rhcr", "--format: found files that RHCR does not have together"),
)
def test_files_that_do_not_belong_together_are_refused(folder, names, asked, message) -> None:
    assert message in refusal(lambda: sorted_out([folder / name for name in names], asked))


HALL = ".......\n.##.##.\n.......\n.##→→→O\n.......\n"
ENDPOINTS = "type octile\nheight 3\nwidth 6\nmap\n......\n.E@@S.\n......\n"
KIVA = "3,6\n2\n2\n5000\n......\nr.ee.r\n......\n"
PROBLEM = {"mapFile": "a.map", "agentFile": "a.agents", "taskFile": "a.tasks", "teamSize": 2}
INSTANCES = {
    "hall.xinst": xinst(parse_map(HALL, "hall"), {0: (2, 2), 1: (4, 3)}, [(1, 1)]),
    "few.xsett": xsett(run={"SimulationDuration": 200}, InitialInventory=0.2),
    "few.xgenc": xgenc({0: 1, 1: 2}),
    "kiva.map": KIVA,
    "a.map": ENDPOINTS,
    "a.agents": "2\n0\n12\n",
    "a.tasks": "2\n7,10\n10,7\n",
    "a.json": json.dumps(PROBLEM),
    "m.map": ENDPOINTS.replace("E", "."),
    "m.scen": "version 1\n0\tm.map\t6\t3\t0\t0\t5\t2\t8\n1\tm.map\t6\t3\t5\t0\t0\t2\t8\n",
}


@pytest.fixture
def instances(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in INSTANCES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@cases(
    "files kind wrote",
    (
        ["hall.xinst", "few.xsett", "few.xgenc"],
        "RAWSim-O",
        ["import.json", "map.txt", "orders.csv", "pods.csv", "robots.csv", "scenario.toml"],
    ),
    (["kiva.map"], "RHCR", ["import.json", "map.txt", "trips.scen"]),
    (["a.json"], "League of Robot Runners", ["import.json", "map.txt", "trips.scen"]),
    (["m.map", "m.scen"], "MovingAI", ["import.json", "map.txt", "trips.scen"]),
)
def test_the_command_that_is_shown_runs(instances, capsys, files, kind, wrote) -> None:
    main(["import", *files, "--out", "made"])
    said = capsys.readouterr().out
    assert said.startswith(f"Read from {kind}: ")
    assert sorted(file.name for file in (instances / "made").iterdir()) == wrote
    assert f"Wrote {', '.join(wrote)} to made." in said
    arguments = said.splitlines()[-1].removeprefix("Run it with: rmfs ").split()
    main([*arguments, *(["--quiet", "--out", "run"] if arguments[0] == "run" else ["--pp", "free-flow"])])
    assert ("Arrived 2 of 2" in capsys.readouterr().out) == (arguments[0] == "plan")
    assert (instances / "run" / "result.json").exists() == (arguments[0] == "run")


def test_the_command_that_is_shown_can_be_pasted(instances: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["import", "m.map", "--out", "my {} map"])
    words = shlex.split(capsys.readouterr().out.splitlines()[-1].removeprefix("Run it with: rmfs "))
    assert words == ["plan", "my {} map/map.txt", "--agents", "8"]
    main([*words, "--pp", "free-flow"])
    assert "8 robots, free-flow" in capsys.readouterr().out


def test_the_report_is_json_too(instances: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["import", "kiva.map", "--out", "made", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told.pop("folder") == "made"
    assert told == json.loads((instances / "made" / "import.json").read_text(encoding="utf-8"))
    assert (told["format"], told["read"]["trips"]) == ("RHCR", 2)
    assert told["without_counterpart"][0] == {"what": "endpoints (e)", "number": 2, "instead": "storage locations"}
    written = {file.name: file.read_bytes() for file in (instances / "made").iterdir()}
    assert "found a file of that name; --force replaces it" in refused(
        capsys, main, ["import", "kiva.map", "--out", "made"]
    )
    main(["import", "kiva.map", "--out", "made", "--force"])
    assert {file.name: file.read_bytes() for file in (instances / "made").iterdir()} == written


SETTING = Setting(1, 3600, 0, "Fill", 5, 60, 0, Spread(1, 1, 1, 4), Spread(1, 0.3, 1, 3), 0.5, 0.1, 5, 6, None)
SKUS = [Sku("s0", 1, 2.0, 5), Sku("s1", 4, 1.0, 10), Sku("s2", 0, 1.0, 5)]


def test_pods_that_hold_nothing_stay_empty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bundles that fit nowhere are not there; pods without end, or for which it would take hours, are refused."""
    assert drawn_contents(SETTING, SKUS, [4.0, 3.0], "x") == [{}, {}]
    with pytest.raises(InputError, match="found pods of unlimited capacity"):
        drawn_contents(SETTING, [Sku("s", 1, 0.0, 5)], [100.0], "x")
    monkeypatch.setattr(stock, "MOST_BUNDLES", 10_000)
    with pytest.raises(InputError, match=r"^x: found pods that can hold over 10,000 bundles"):
        drawn_contents(SETTING, [Sku("s", 1, 1e-9, 1)], [100.0], "x")


@given(
    seed=st.integers(0, 5),
    stock=st.lists(st.integers(0, 30), min_size=1, max_size=6),
    lines=st.tuples(st.integers(1, 3), st.integers(3, 5)),
    end=st.sampled_from([0.0, 0.1, 0.5]),
)
def test_orders_never_want_more_than_there_is(seed: int, stock: list[int], lines: tuple[int, int], end: float) -> None:
    setting = evolve(SETTING, seed=seed, lines=Spread(2, 1, *lines), emptied=end)
    skus = [Sku(f"s{i}", 1, 1, 1) for i in range(len(stock))]
    contents: Any = [{f"s{i}": number} for i, number in enumerate(stock)]
    orders = drawn_orders(setting, skus, stock_of(contents), 1, 10.0, Notes())
    wanted = [0] * len(stock)
    for _, order in orders:
        assert 1 <= len(order) <= lines[1]
        assert len({sku for sku, _ in order}) == len(order)
        for sku, items in order:
            wanted[int(sku[1:])] += items
    assert all(want <= there for want, there in zip(wanted, stock, strict=True))
    assert sum(stock) - sum(wanted) <= end * sum(stock) or not sum(stock)


def test_there_are_as_many_orders_as_stations_can_pick() -> None:
    notes = Notes()
    plenty = {"s0": 10_000, "s1": 10_000}
    orders = drawn_orders(SETTING, SKUS, plenty, 2, 0.1, notes)
    assert 375 <= sum(n for _, lines in orders for _, n in lines) < 400
    assert notes.taken == []
    few = drawn_orders(SETTING, SKUS, {"s0": 10}, 2, 0.1, notes)
    assert notes.taken == [
        Note("orders drawn until the stock of pods ends", len(few), "no more come; stock is not filled up")
    ]


def test_stock_that_is_refilled() -> None:
    setting = evolve(SETTING, emptied=1.0)
    assert drawn_orders(setting, SKUS, {"s0": 10_000}, 2, 0.1, Notes()) == []
    assert (
        drawn_orders(setting, SKUS, None, 2, 0.1, Notes()) == drawn_orders(SETTING, SKUS, None, 2, 0.1, Notes()) != []
    )
    notes = Notes()
    bundles = [(0.0, "s0", 3), (9.0, "s1", 9), (1.0, "s0", 100), (2.0, "s2", 2)]
    found = OrderList({"s0": 10.0}, bundles, [(0, [("s0", 4), ("s3", 1), ("s2", 2)])])
    assert stored_bundles(found, [50.0, 50.0], notes) == ([{"s0": None, "s3": None}, {"s1": 9, "s2": 2}], [])
    assert [(note.what, note.number) for note in notes.taken] == [
        ("bundles that arrive during the run", 3),
        ("bundles that fit on no pod", 1),
        ("SKUs of which orders want more than bundles bring", 2),
    ]


def test_poisson_loads_above_capacity_are_said() -> None:
    notes = Notes()
    setting = evolve(SETTING, mode="Poisson", until_s=36_000)
    orders = drawn_orders(setting, SKUS, None, 2, 1 / 60, notes)
    (note,) = notes.taken
    assert note.what == "items ordered per hour, more than the 60 that output stations can handle"
    assert note.instead == "kept; more and more orders wait"
    items = sum(n for _, lines in orders for _, n in lines)
    assert note.number == pytest.approx(120 * items / len(orders), abs=1)
    assert 1000 < len(orders) < 1400
    notes = Notes()
    drawn_orders(setting, SKUS, None, 2, 1.0, notes)
    assert notes.taken == []


POISSON = Setting(
    1, 36_000, 0, "Poisson", 5, 60, 0, Spread(1, 1, 1, 4), Spread(1, 0.3, 1, 3), 0.5, 0.1, 5, 6, None, (0.4, 0.6), 60, 3
)


def test_levels_keep_stock_between_the_shares_of_the_setting() -> None:
    """Half of the capacity on average, as much of each SKU as bundles bring, one bundle of its own at a time."""
    notes = Notes()
    supply = levels(POISSON, SKUS, 1000.0, {"s0": 1000, "s1": 1000}, notes)
    assert supply.levels == {"s0": (47, 52), "s1": (395, 405)}
    assert (supply.bundle, supply.weights) == (10, {"s0": 2.0, "s1": 1.0})
    usual = {"s0": 2 * 50, "s1": 400}
    assert sum(usual.values()) == 500
    assert notes.taken == [Note("levels of all stock at which bundles come", 1, "levels of each SKU (skus.csv)")]


def test_what_is_not_ordered_or_refilled() -> None:
    supply = levels(POISSON, SKUS, 1000.0, {"s0": 20}, Notes())
    assert supply.levels == {"s0": (19, 24), "s1": (0, 10)}
    notes = Notes()
    assert levels(POISSON, SKUS, 19.0, {}, notes) is None
    assert notes.taken == [Note("SKUs whose bundles do not all fit on pods at once", 2, "stock is not filled up")]


def test_bundles_and_pods_that_fit() -> None:
    notes = Notes()
    assert storable(SKUS, [10.0, 10.0, 5.0], "few.xgenc", notes) == SKUS
    assert not notes.taken
    heavy = [*SKUS, Sku("s3", 1, 30.0, 40)]
    assert storable(heavy, [10.0, 10.0, 5000.0], "few.xgenc", notes) == SKUS
    assert notes.taken == [Note("SKUs of which a bundle is heavier than what a pod holds", 1, "left out")]
    told = "few.xgenc: found no SKU that is ordered and whose bundle a pod of capacity 9 can"
    assert refusal(lambda: storable(heavy, [9.0], "few.xgenc", notes)).startswith(told)
    supply = Supply({"s0": 1 / 3}, 3, bundles=[(0.0, "s0", 3)])
    assert supply.instance_keys([1.0], [{}], Notes())["pod_capacity"] == 3 * 334


def test_deliveries_come_at_their_rate_until_pods_are_full() -> None:
    deliveries = Deliveries(POISSON, SKUS, 2, 1e9, {})
    assert len(list(deliveries.arrived(0.0))) == 3
    found = Counter(sku for sku, _ in deliveries.arrived(36_000.0))
    assert 1080 < found["s0"] + found["s1"] < 1320
    assert found["s1"] > 3 * found["s0"]
    full = Deliveries(evolve(POISSON, overfill=1.0), [Sku("s0", 1, 2.0, 5)], 2, 35.0, {"s0": 3})
    assert list(full.arrived(3600.0)) == [("s0", 5), ("s0", 5)]
    full.ordered({"s0": 3})
    assert list(full.arrived(7200.0)) == [("s0", 5)]
    assert full.supply().bundles == tuple(full.bundles)


def test_stations_and_pods_are_as_most_of_them() -> None:
    """A station takes bundles as long as their weight fits; what differs is counted."""
    notes = Notes()
    supply = Supply({"a": 5.0}, 6, levels={"a": (3, 9)})
    storing = [Storing(1000, 10), Storing(400, 10), Storing(1000, 12)]
    assert supply.station_keys(storing, notes) == {"bundle_capacity": 13, "store_s": 10}
    keys = supply.instance_keys([50.0, 50.0, 40.0], [{"a": 11}, {}, {}], notes)
    assert keys["pod_capacity"] == 55  # what one holds at the start
    assert keys["replenishment"] == {"process": "reorder-point", "bundle_items": 6}
    assert [note.number for note in notes.taken] == [1, 1]


def test_rules_have_the_names_of_controllers(tmp_path: Path) -> None:
    text = '<ControlConfiguration xmlns:xsi="x"><ItemStorageConfig xsi:type="ReactiveItemStorageConfiguration" />'
    text += '<ReplenishmentBatchingConfig xsi:type="RandomReplenishmentBatchingConfiguration" /></ControlConfiguration>'
    notes = Notes()
    assert chosen_rules(document(file(tmp_path, text)), notes) == {"roa": "random", "rps": "emptiest-pod"}
    assert notes.taken == [Note("ItemStorage Reactive", 1, "emptiest-pod")]
    assert chosen_rules(None, notes) == {"roa": "first-bundle", "rps": "emptiest-pod"}


def test_a_setting_has_the_defaults_of_rawsimo(tmp_path: Path) -> None:
    found = read_setting(file(tmp_path, keys("SettingConfiguration", {})), Notes())
    assert (found.seed, found.until_s, found.warmup_s, found.mode, found.backlog) == (0, 172_800, 0, "Fill", 200)
    assert (found.lines, found.quantities) == (Spread(1, 1, 1, 4), Spread(1, 0.3, 1, 3))
    assert (found.stocked, found.emptied, found.weight, found.bundle, found.refers_to) == (0.7, 0.1, 5, 6, None)


def test_what_has_no_counterpart_is_counted(tmp_path: Path) -> None:
    notes = Notes()
    text = xsett(
        "Poisson",
        {"OverrideConfig": {"OverridePodCapacity": "true", "OverridePodCapacityValue": 4}, "LogLevel": 1},
        DueTimeOffsetMean=3600,
        PoissonInventoryConfiguration={"PoissonMode": "TimeDependent"},
    )
    read_setting(file(tmp_path, text), notes)
    assert [(note.what.split(" (")[0], note.number) for note in notes.taken] == [
        ("values of the setting that override those of the layout", 1),
        ("rates of orders by time of day or season", 1),
        ("settings of due times", 1),
        ("other settings", 2),
    ]


@cases(
    "text message",
    (xsett("Magic"), "expected Fill, Poisson or Fixed as `OrderMode` of InventoryConfiguration, found 'Magic'"),
    (xsett(ItemType="Letter"), "expected SimpleItem, or orders of a list (`OrderMode` Fixed) as `ItemType`"),
    (xsett(run={"Seed": -1}), "expected a whole number from 0 to 1,000,000,000 as `Seed`"),
    (xsett(PositionCountMin=5), "expected a whole number of at least 5, as `PositionCountMin` says, as"),
)
def test_wrong_settings_are_refused(tmp_path: Path, text: str, message: str) -> None:
    assert message in refusal(lambda: read_setting(file(tmp_path, text.replace('"Seed": 3', "")), Notes()))


def test_skus_and_lists_are_read(tmp_path: Path) -> None:
    found = read_skus(file(tmp_path, xgenc({2: 0.5, 1: 7}, weights={1: 3.0}, bundle=9)), 5, 6, Notes())
    assert found == [Sku("s1", 7, 3.0, 9), Sku("s2", 0.5, 5, 9)]
    bare = '<C><DefaultWeight>2.5</DefaultWeight><ItemDescriptions><E Key="4" Value="1"/></ItemDescriptions>'
    bare += "<ItemCoWeights><E/><E/></ItemCoWeights></C>"
    notes = Notes()
    assert read_skus(file(tmp_path, bare), 5, 6, notes) == [Sku("s4", 2.5, 5, 6)]
    assert notes.taken == [Note("SKUs that are bought together (ItemCoWeights)", 2, "drawn apart")]
    with pytest.raises(InputError, match="found no SKU that orders want; expected"):
        read_skus(file(tmp_path, xgenc({1: 0})), 5, 6, Notes())
    notes = Notes()
    text = xitem([(1.5, {3: 2, 4: 1}), (2, {}), (0.5, {3: 1})], [(3, 7)], [3, 4])
    assert read_order_list(file(tmp_path, text), notes) == OrderList(
        {"s3": 5.0, "s4": 5.0}, [(1.5, "s3", 7)], [(1.5, [("s3", 2), ("s4", 1)]), (0.5, [("s3", 1)])]
    )
    assert notes.taken == [Note("orders without positions", 1, "left out")]


@cases(
    "text message",
    (xitem([]), "found no order; expected some"),
    (xitem([(-1, {1: 1})]), "expected a number from 0 to 3e+08 as `TimeStamp` of Order, found '-1'"),
    (xitem([(0, {1: -1})]), "expected a whole number from 0 to 1,000,000,000 as `Count` of Position, found '-1'"),
    (xitem([(0, {1: 1})], [(1, 0)]), "as `Size` of ItemBundle, found '0'"),
)
def test_wrong_lists_are_refused(tmp_path: Path, text: str, message: str) -> None:
    assert message in refusal(lambda: read_order_list(file(tmp_path, text), Notes()))
