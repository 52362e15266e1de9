"""From RAWSim-O's files to a scenario: the same warehouse, its orders and its stock."""

from __future__ import annotations

import csv
import tomllib
from collections.abc import Mapping
from pathlib import Path

import pytest

import rmfs_core
from rawsimo_files import keys, xgenc, xinst, xitem, xsett
from rmfs_commands.import_.notes import Imported, Note
from rmfs_commands.import_.rawsimo import import_rawsimo
from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario
from rmfs_core.scenario.reading import shipped_folder
from rmfs_core.world import make_instance, make_layout, parse_map, read_instance

HALL = "..........\n.##.##.##.\n.##.##.##.\n..........\n.##.##.→→O\n.##.##.@@.\n..........\n"
PLACES = {5: (2, 2), 7: (3, 9), 2: (5, 6)}
ROBOTS = ((1, 1), (7, 10))


def given(folder: Path, **texts: str) -> dict[str, Path]:
    """Write files; return them by what they are."""
    found = {}
    for kind, text in texts.items():
        found[kind] = folder / f"{kind}.xml"
        found[kind].write_text(text, encoding="utf-8")
    return found


def written(folder: Path, imported: Imported) -> Path:
    """Write what was imported; return its scenario."""
    for name, text in imported.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / "scenario.toml"


def hall(**more: str) -> dict[str, str]:
    """Return the instance file of a small hall, and others."""
    return {"Instance": xinst(parse_map(HALL, "hall"), PLACES, ROBOTS), **more}


def test_the_warehouse_of_the_comparison_is_the_same(tmp_path: Path) -> None:
    """Its instance file gives the cells, queues, stations, places, robots and orders of the shipped scenario.

    What is on the pods no file of RAWSim-O says: it is drawn when a run begins.
    """
    folder = shipped_folder() / "parity"
    ours = load_scenario("parity/rawsim-o", ["robots.count=16"])
    layout = parse_map((folder / "map.txt").read_text(encoding="utf-8"), "map")
    instance = read_instance(folder / "orders.csv", folder / "pods.csv")
    places = csv.DictReader((folder / "robots.csv").read_text(encoding="utf-8").splitlines())
    robots = [(int(row["row"]), int(row["column"])) for row in places]
    pods = {int(pod.name[1:]): pod.place[:2] for pod in instance.pods if pod.place is not None}
    orders = [(0, {int(instance.skus[sku][1:]): n for sku, n in order.lines}) for order in instance.orders]
    files = given(
        tmp_path,
        Instance=xinst(layout, pods, robots),
        OrderList=xitem(orders),
        SettingConfiguration=xsett("Fixed", {"SimulationDuration": 14_400, "Seed": 1}),
    )
    scenario = load_scenario(written(tmp_path, import_rawsimo(files)))
    assert (tmp_path / "map.txt").read_text(encoding="utf-8") == (folder / "map.txt").read_text(encoding="utf-8")
    assert make_layout(scenario).stations == make_layout(ours).stations
    for section in ("rules", "run"):
        assert getattr(scenario, section) == getattr(ours, section)
    stations, theirs = scenario.stations, ours.stations
    assert (stations.order_capacity, stations.pick_s, stations.handle_s) == (6, theirs.pick_s, theirs.handle_s)
    assert scenario.robots == ours.robots
    assert (tmp_path / "robots.csv").read_text() == (folder / "robots.csv").read_text()
    made = make_instance(scenario)
    assert [(order.name, order.arrival_tick) for order in made.orders] == [
        (order.name, order.arrival_tick) for order in instance.orders
    ]
    named = [[{world.skus[sku]: n for sku, n in order.lines} for order in world.orders] for world in (made, instance)]
    assert named[0] == named[1]
    assert {pod.name: pod.place[:2] for pod in made.pods if pod.place} == {f"p{i}": pods[i] for i in pods}


def test_a_list_of_orders_runs_at_once(tmp_path: Path) -> None:
    """Bundles are on pods at the start; of a SKU that orders want more of there is no end."""
    items = xitem([(0, {1: 2, 2: 1}), (30.5, {3: 1})], bundles=[(1, 5), (2, 1)], skus=(1, 2, 3))
    imported = import_rawsimo(given(tmp_path, **hall(OrderList=items)))
    result = rmfs_core.run(written(tmp_path, imported))
    assert (result.status, result.metrics["orders_completed"]) == ("complete", 2)
    assert Note("bundles that arrive during the run", 2, "on pods at the start") in imported.notes.taken
    assert Note("SKUs of which orders want more than bundles bring", 1, "never run out") in imported.notes.taken
    assert imported.files["orders.csv"].endswith("o1,0,s2,1\no2,30.5,s3,1\n")
    assert imported.files["pods.csv"].splitlines()[1:] == ["p5,s1,5,2,2", "p7,s2,1,3,9", "p2,s3,,5,6"]


def test_a_list_that_is_given_goes_before_the_setting(tmp_path: Path) -> None:
    """Its orders arrive at their times, although the setting would keep a backlog full."""
    files = hall(OrderList=xitem([(30.5, {3: 1})]), SettingConfiguration=xsett("Fill", {"SimulationDuration": 900}))
    scenario = load_scenario(written(tmp_path, import_rawsimo(given(tmp_path, **files))))
    assert (scenario.instance.arrivals.process, scenario.run.until_s) == ("start", 900)
    assert [order.arrival_tick for order in make_instance(scenario).orders] == [30_500]


def test_orders_are_drawn_where_the_setting_has_them_drawn(tmp_path: Path) -> None:
    """By the shares of SKUs; a backlog is kept full, as in RAWSim-O; the same files give the same bytes."""
    setting = xsett(InitialInventory=0.5, DemandInventoryConfiguration={"OrderCount": 4})
    files = given(
        tmp_path,
        **hall(SettingConfiguration=setting, SimpleItemGeneratorConfiguration=xgenc({0: 1, 1: 3, 2: 0})),
    )
    imported = import_rawsimo(files)
    assert imported == import_rawsimo(files)
    result = rmfs_core.run(written(tmp_path, imported), overrides=["run.until_s=300"])
    assert (result.metrics["picks"] or 0) > 3
    scenario = load_scenario(tmp_path / "scenario.toml")
    assert (scenario.seed, scenario.instance.arrivals.backlog, scenario.run.until_s) == (3, 4, 3600)
    wanted = [row["sku"] for row in csv.DictReader(imported.files["orders.csv"].splitlines())]
    assert set(wanted) == {"s0", "s1"}
    assert wanted.count("s1") > 2 * wanted.count("s0")


def test_poisson_arrivals_are_times_in_the_file(tmp_path: Path) -> None:
    """They come at the rate of the setting, for each station, until the run ends."""
    setting = xsett("Poisson", PoissonInventoryConfiguration={"AverageOrdersPerHourAndStation": 60})
    skus = xgenc(dict.fromkeys(range(20), 1.0), weights=dict.fromkeys(range(20), 1.0))
    imported = import_rawsimo(
        given(tmp_path, **hall(SettingConfiguration=setting, SimpleItemGeneratorConfiguration=skus))
    )
    arrivals = {
        row["order"]: float(row["arrival_s"]) for row in csv.DictReader(imported.files["orders.csv"].splitlines())
    }
    assert 65 < len(arrivals) < 120
    assert list(arrivals.values()).count(0) == 30  # RAWSim-O begins with that many
    assert list(arrivals.values()) == sorted(arrivals.values())
    assert max(arrivals.values()) < 3600
    assert "arrivals" not in tomllib.loads(imported.files["scenario.toml"])["instance"]


AROUND = "......@@\n.##.##@@\n......@@\n.##→→O@@\n......@@\n"
INPUTS = [(15, (7, 6), (23, 22, 21))]


def refilled(**more: str) -> dict[str, str]:
    """Return the instance file of a hall with an input station, and others."""
    return {"Instance": xinst(parse_map(AROUND, "hall"), {0: (2, 2), 1: (2, 6)}, [(1, 1)], inputs=INPUTS), **more}


def test_a_backlog_is_filled_from_stock_that_is_filled_up(tmp_path: Path) -> None:
    """Each SKU is ordered in bundles of its own; more is picked than was ever on the pods at the start."""
    setting = xsett(InitialInventory=0.1, DemandInventoryConfiguration={"OrderCount": 4})
    files = refilled(SettingConfiguration=setting, SimpleItemGeneratorConfiguration=xgenc({0: 1, 1: 3}, bundle=6))
    imported = import_rawsimo(given(tmp_path, **files))
    assert imported.read["replenishment stations"] == 1
    assert [row[-2:] for row in imported.files["map.txt"].splitlines()[:3]] == ["→↓", "@I", "<<"]
    scenario = load_scenario(written(tmp_path, imported))
    assert scenario.instance.replenishment is not None
    assert scenario.instance.replenishment.process == "reorder-point"
    assert (scenario.instance.pod_capacity, scenario.instance.replenishment.bundle_items) == (500, 6)
    rows = list(csv.DictReader(imported.files["skus.csv"].splitlines()))
    assert {int(row["order_up_to"]) - int(row["reorder_point"]) for row in rows} == {6}
    assert {row["size"] for row in rows} == {"2"}
    result = rmfs_core.run(scenario)
    start = sum(int(row["quantity"]) for row in csv.DictReader(imported.files["pods.csv"].splitlines()))
    assert (result.metrics["picks"] or 0) > start
    assert (result.metrics["bundles_stored"] or 0) > 10


def test_bundles_of_a_rate_are_times_in_a_file(tmp_path: Path) -> None:
    """Orders want what there is by then, so that the run is valid and completes them."""
    rates = {"AverageOrdersPerHourAndStation": 30, "AverageBundlesPerHourAndStation": 20, "InitialBundleCount": 2}
    setting = xsett("Poisson", InitialInventory=0.02, PoissonInventoryConfiguration=rates)
    files = refilled(SettingConfiguration=setting, SimpleItemGeneratorConfiguration=xgenc({0: 1, 1: 3}))
    imported = import_rawsimo(given(tmp_path, **files))
    bundles = list(csv.DictReader(imported.files["bundles.csv"].splitlines()))
    assert 10 < len(bundles) < 35
    assert [row["arrival_s"] for row in bundles[:2]] == ["0.0", "0.0"]
    scenario = load_scenario(written(tmp_path, imported), ["run.until_s=7200"])
    result = rmfs_core.run(scenario)
    assert result.status == "complete"


def test_bundles_of_a_list_come_at_their_times(tmp_path: Path) -> None:
    """Where there is an input station; pods are empty until then. Controllers name the rules."""
    control = (
        '<ControlConfiguration xmlns:xsi="x"><ItemStorageConfig xsi:type="LeastDemandItemStorageConfiguration" />'
        '<ReplenishmentBatchingConfig xsi:type="SamePodReplenishmentBatchingConfiguration" /></ControlConfiguration>'
    )
    items = xitem([(0, {1: 2, 2: 1})], bundles=[(1, 5), (2, 1)], skus=(1, 2))
    imported = import_rawsimo(given(tmp_path, **refilled(OrderList=items, ControlConfiguration=control)))
    assert imported.files["bundles.csv"].splitlines()[1:] == ["b1,1.5,s1,5", "b2,1.5,s2,1"]
    scenario = load_scenario(written(tmp_path, imported))
    assert scenario.rules.roa is not None
    assert scenario.rules.rps is not None
    assert (scenario.rules.roa.rule, scenario.rules.rps.rule) == ("same-pod", "least-demand")
    assert rmfs_core.run(scenario).status == "complete"
    what = "configuration of controllers (.xconf), but for replenishment"
    assert Note(what, 1, "pod-match, demand, nearest, balanced and whca-n") in imported.notes.taken


def test_a_warehouse_alone_runs_on_the_papers_instance(tmp_path: Path) -> None:
    """Its pods have random contents then, and stand anywhere."""
    imported = import_rawsimo(given(tmp_path, **hall()))
    assert sorted(imported.files) == ["map.txt", "robots.csv", "scenario.toml"]
    assert imported.notes.taken[-1] == Note("pods whose contents no file says", 3, "random contents at random places")
    scenario = load_scenario(written(tmp_path, imported), ["instance.orders=3", "instance.skus=4"])
    assert rmfs_core.run(scenario).status == "complete"


def test_a_layout_is_a_block_layout(tmp_path: Path) -> None:
    """Its aisles lie between blocks; its hall has the ring beside it; stations have three lanes of a queue."""
    layout = keys(
        "LayoutConfiguration",
        {
            "NameLayout": "small",
            **{"NrHorizontalAisles": 4, "NrVerticalAisles": 2, "HorizontalLengthBlock": 4, "WidthHall": 2},
            **{"WidthBuffer": 2, "NPickStationEast": 2, "NReplenishmentStationWest": 0, "BotCount": 3},
        },
    )
    imported = import_rawsimo(given(tmp_path, LayoutConfiguration=layout, OrderList=xitem([(0, {1: 1})])))
    scenario = load_scenario(written(tmp_path, imported))
    section = scenario.layout
    assert (section.block_rows, section.block_columns, section.block_length, section.hall_width) == (5, 3, 4, 3)
    assert (scenario.stations.queue_length, scenario.stations.order_capacity, scenario.robots.count) == (6, 12, 3)
    assert (imported.read["storage locations"], imported.read["pods"]) == (120, 102)
    assert len(make_layout(scenario).storage_locations) == 120
    assert rmfs_core.run(scenario).status == "complete"


def test_files_that_a_setting_names_are_found_beside_it(tmp_path: Path) -> None:
    """Or in a folder of resources above, under the name that it gives, however it writes folders."""
    (tmp_path / "Resources").mkdir()
    (tmp_path / "Resources" / "few.xgenc").write_text(xgenc({4: 1}), encoding="utf-8")
    setting = xsett(SimpleItemConfiguration={"GeneratorConfigFile": "..\\somewhere\\few.xgenc"})
    imported = import_rawsimo(given(tmp_path, **hall(SettingConfiguration=setting)))
    assert ",s4," in imported.files["pods.csv"]


@pytest.mark.parametrize(
    ("texts", "place", "problem"),
    [
        (
            {"Instance": xinst(parse_map(HALL, "hall"), {}, [(1, 1)] * 21)},
            "Instance.xml",
            "found 21 bots; expected at most one a storage location, 20",
        ),
        (
            {"SettingConfiguration": xsett()},
            "SettingConfiguration.xml",
            "found no warehouse; expected an .xinst or .xlayo",
        ),
        (
            hall(LayoutConfiguration=keys("LayoutConfiguration", {})),
            "LayoutConfiguration.xml",
            "expected one warehouse",
        ),
        (
            hall(SettingConfiguration=xsett(SimpleItemConfiguration={"GeneratorConfigFile": "none.xgenc"})),
            "SettingConfiguration.xml",
            "names none.xgenc, which is not beside it nor in a folder `Resources`; expected it there",
        ),
        (
            hall(SettingConfiguration=xsett(SimpleItemConfiguration={"GeneratorConfigFile": "a" * 5000})),
            "SettingConfiguration.xml",
            f"names {'a' * 80}, which is not beside it nor in a folder `Resources`; expected it there",
        ),
        (
            hall(SettingConfiguration=xsett("Fixed")),
            "SettingConfiguration.xml",
            "names no file of SKUs or orders; expected",
        ),
        (
            hall(SimpleItemGeneratorConfiguration=xgenc({1: 1})),
            "SimpleItemGeneratorConfiguration.xml",
            "expected an .xsett",
        ),
    ],
)
def test_what_is_missing_is_said(tmp_path: Path, texts: Mapping[str, str], place: str, problem: str) -> None:
    """In one sentence, with the file."""
    with pytest.raises(InputError) as caught:
        import_rawsimo(given(tmp_path, **texts))
    assert str(caught.value).startswith(f"{tmp_path / place}: ")
    assert problem in str(caught.value)
