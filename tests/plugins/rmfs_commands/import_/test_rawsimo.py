"""RAWSim-O's instances and layouts as scenarios: the same warehouse, on a text map."""

import csv
import tomllib
from collections.abc import Mapping
from pathlib import Path

import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st

import rmfs_core
from calling import refusal
from cases import cases
from rawsimo_files import keys, xgenc, xinst, xitem, xsett
from rmfs_commands.import_.notes import Imported, Note, Notes
from rmfs_commands.import_.rawsimo import import_rawsimo
from rmfs_commands.import_.warehouses import Moving, Picking, Storing, commonest, read_instance_file, read_layout_file
from rmfs_commands.import_.waypoints import Drawn, StationPoints, Waypoint, draw
from rmfs_commands.layouts import block_map, parse_map
from rmfs_core.errors import InputError
from rmfs_core.scenario import load_scenario
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.scenario.reading import shipped_folder
from rmfs_core.world import CellKind, Layout, make_instance, make_layout, read_instance

AROUND = "......@@\n.##.##@@\n......@@\n.##→→O@@\n......@@\n"
HALL = "..........\n.##.##.##.\n.##.##.##.\n..........\n.##.##.→→O\n.##.##.@@.\n..........\n"
PLACES = {5: (2, 2), 7: (3, 9), 2: (5, 6)}
ROBOTS = ((1, 1), (7, 10))


def written_files(folder: Path, **texts: str) -> dict[str, Path]:
    found = {}
    for kind, text in texts.items():
        found[kind] = folder / f"{kind}.xml"
        found[kind].write_text(text, encoding="utf-8")
    return found


def written(folder: Path, imported: Imported) -> Path:
    for name, text in imported.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / "scenario.toml"


def hall(**more: str) -> dict[str, str]:
    return {"Instance": xinst(parse_map(HALL, "hall"), PLACES, ROBOTS), **more}


def test_the_warehouse_of_the_comparison_is_the_same(tmp_path: Path) -> None:
    folder = shipped_folder() / "parity"
    ours = load_scenario("parity/rawsim-o", ["robots.count=16"])
    layout = parse_map((folder / "map.txt").read_text(encoding="utf-8"), "map")
    instance = read_instance(folder / "orders.csv", folder / "pods.csv")
    places = csv.DictReader((folder / "robots.csv").read_text(encoding="utf-8").splitlines())
    robots = [(int(row["row"]), int(row["column"])) for row in places]
    pods = {int(pod.name[1:]): pod.place[:2] for pod in instance.pods if pod.place is not None}
    orders = [(0, {int(instance.skus[sku][1:]): n for sku, n in order.lines}) for order in instance.orders]
    files = written_files(
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
    named = [
        [(order.name, order.arrival_tick, {world.skus[sku]: n for sku, n in order.lines}) for order in world.orders]
        for world in (made, instance)
    ]
    assert named[0] == named[1]
    assert {pod.name: pod.place[:2] for pod in made.pods if pod.place} == {f"p{i}": pods[i] for i in pods}


def test_lists_of_orders(tmp_path: Path) -> None:
    items = xitem([(0, {1: 2, 2: 1}), (30.5, {3: 1})], bundles=[(1, 5), (2, 1)], skus=(1, 2, 3))
    imported = import_rawsimo(written_files(tmp_path, **hall(OrderList=items)))
    result = rmfs_core.run(written(tmp_path, imported))
    assert (result.status, result.metrics["orders_completed"]) == ("complete", 2)
    assert Note("bundles that arrive during the run", 2, "on pods at the start") in imported.notes.taken
    assert Note("SKUs of which orders want more than bundles bring", 1, "never run out") in imported.notes.taken
    assert imported.files["orders.csv"].endswith("o1,0,s2,1\no2,30.5,s3,1\n")
    assert imported.files["pods.csv"].splitlines()[1:] == ["p5,s1,5,2,2", "p7,s2,1,3,9", "p2,s3,,5,6"]
    files = hall(OrderList=xitem([(30.5, {3: 1})]), SettingConfiguration=xsett("Fill", {"SimulationDuration": 900}))
    scenario = load_scenario(written(tmp_path, import_rawsimo(written_files(tmp_path, **files))))
    assert (scenario.instance.arrivals.process, scenario.run.until_s) == ("start", 900)
    assert [order.arrival_tick for order in make_instance(scenario).orders] == [30_500]


def test_orders_are_drawn_where_the_setting_has_them_drawn(tmp_path: Path) -> None:
    setting = xsett(InitialInventory=0.5, DemandInventoryConfiguration={"OrderCount": 4})
    files = written_files(
        tmp_path, **hall(SettingConfiguration=setting, SimpleItemGeneratorConfiguration=xgenc({0: 1, 1: 3, 2: 0}))
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
    setting = xsett("Poisson", PoissonInventoryConfiguration={"AverageOrdersPerHourAndStation": 60})
    skus = xgenc(dict.fromkeys(range(20), 1.0), weights=dict.fromkeys(range(20), 1.0))
    imported = import_rawsimo(
        written_files(tmp_path, **hall(SettingConfiguration=setting, SimpleItemGeneratorConfiguration=skus))
    )
    arrivals = {
        row["order"]: float(row["arrival_s"]) for row in csv.DictReader(imported.files["orders.csv"].splitlines())
    }
    assert 65 < len(arrivals) < 120
    assert list(arrivals.values()).count(0) == 30  # RAWSim-O begins with that many
    assert list(arrivals.values()) == sorted(arrivals.values())
    assert max(arrivals.values()) < 3600
    assert "arrivals" not in tomllib.loads(imported.files["scenario.toml"])["instance"]


INPUTS = [(15, (7, 6), (23, 22, 21))]


def refilled(**more: str) -> dict[str, str]:
    return {"Instance": xinst(parse_map(AROUND, "hall"), {0: (2, 2), 1: (2, 6)}, [(1, 1)], inputs=INPUTS), **more}


def test_a_backlog_is_filled_from_stock_that_is_filled_up(tmp_path: Path) -> None:
    setting = xsett(InitialInventory=0.1, DemandInventoryConfiguration={"OrderCount": 4})
    files = refilled(SettingConfiguration=setting, SimpleItemGeneratorConfiguration=xgenc({0: 1, 1: 3}, bundle=6))
    imported = import_rawsimo(written_files(tmp_path, **files))
    assert imported.read["replenishment stations"] == 1
    assert [row[-2:] for row in imported.files["map.txt"].splitlines()[:3]] == ["→↓", "@I", "<<"]
    scenario = load_scenario(written(tmp_path, imported))
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
    imported = import_rawsimo(written_files(tmp_path, **files))
    bundles = list(csv.DictReader(imported.files["bundles.csv"].splitlines()))
    assert 10 < len(bundles) < 35
    assert [row["arrival_s"] for row in bundles[:2]] == ["0.0", "0.0"]
    assert "orders for which stock has nothing left when they arrive" in [note.what for note in imported.notes.taken]
    scenario = load_scenario(written(tmp_path, imported), ["run.until_s=7200"])
    assert rmfs_core.run(scenario).status == "complete"


def test_bundles_of_a_list_come_at_their_times(tmp_path: Path) -> None:
    control = (
        '<ControlConfiguration xmlns:xsi="x"><ItemStorageConfig xsi:type="LeastDemandItemStorageConfiguration" />'
        '<ReplenishmentBatchingConfig xsi:type="SamePodReplenishmentBatchingConfiguration" /></ControlConfiguration>'
    )
    items = xitem([(0, {1: 2, 2: 1})], bundles=[(1, 5), (2, 1)], skus=(1, 2))
    imported = import_rawsimo(written_files(tmp_path, **refilled(OrderList=items, ControlConfiguration=control)))
    assert imported.files["bundles.csv"].splitlines()[1:] == ["b1,1.5,s1,5", "b2,1.5,s2,1"]
    scenario = load_scenario(written(tmp_path, imported))
    assert (scenario.rules.roa.rule, scenario.rules.rps.rule) == ("same-pod", "least-demand")
    assert rmfs_core.run(scenario).status == "complete"
    what = "configuration of controllers (.xconf), except for replenishment"
    assert Note(what, 1, "pod-match, demand, nearest, balanced and whca-n") in imported.notes.taken


def test_settings_and_what_they_name(tmp_path: Path) -> None:
    imported = import_rawsimo(written_files(tmp_path, **hall()))
    assert sorted(imported.files) == ["map.txt", "robots.csv", "scenario.toml"]
    assert imported.notes.taken[-1] == Note("pods whose contents no file says", 3, "random contents and locations")
    scenario = load_scenario(written(tmp_path, imported), ["instance.orders=3", "instance.skus=4"])
    assert rmfs_core.run(scenario).status == "complete"
    (tmp_path / "Resources").mkdir()
    (tmp_path / "Resources" / "few.xgenc").write_text(xgenc({4: 1}), encoding="utf-8")
    setting = xsett(SimpleItemConfiguration={"GeneratorConfigFile": "..\\somewhere\\few.xgenc"})
    imported = import_rawsimo(written_files(tmp_path, **hall(SettingConfiguration=setting)))
    assert ",s4," in imported.files["pods.csv"]


def test_a_layout_is_a_block_layout(tmp_path: Path) -> None:
    layout = keys(
        "LayoutConfiguration",
        {
            "NameLayout": "small",
            **{"NrHorizontalAisles": 4, "NrVerticalAisles": 2, "HorizontalLengthBlock": 4, "WidthHall": 2},
            **{"WidthBuffer": 2, "NPickStationEast": 2, "NReplenishmentStationWest": 0, "BotCount": 3},
        },
    )
    imported = import_rawsimo(written_files(tmp_path, LayoutConfiguration=layout, OrderList=xitem([(0, {1: 1})])))
    scenario = load_scenario(written(tmp_path, imported))
    section = scenario.layout
    assert (section.block_rows, section.block_columns, section.block_length, section.hall_width) == (5, 3, 4, 3)
    assert (scenario.stations.queue_length, scenario.stations.order_capacity, scenario.robots.count) == (6, 12, 3)
    assert (imported.read["storage locations"], imported.read["pods"]) == (120, 102)
    assert len(make_layout(scenario).storage_locations) == 120
    assert rmfs_core.run(scenario).status == "complete"


@cases(
    "texts place problem",
    (
        {"Instance": xinst(parse_map(HALL, "hall"), {}, [(1, 1)] * 21)},
        "Instance.xml",
        "found 21 bots; expected at most one a storage location, 20",
    ),
    ({"SettingConfiguration": xsett()}, "SettingConfiguration.xml", "found no warehouse; expected an .xinst or .xlayo"),
    (hall(LayoutConfiguration=keys("LayoutConfiguration", {})), "LayoutConfiguration.xml", "expected one warehouse"),
    (
        hall(SettingConfiguration=xsett(SimpleItemConfiguration={"GeneratorConfigFile": "none.xgenc"})),
        "SettingConfiguration.xml",
        "names none.xgenc, which is not next to it nor in a folder `Resources`; expected it there",
    ),
    (
        hall(SettingConfiguration=xsett(SimpleItemConfiguration={"GeneratorConfigFile": "a" * 5000})),
        "SettingConfiguration.xml",
        f"names {'a' * 80}, which is not next to it nor in a folder `Resources`; expected it there",
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
)
def test_what_is_missing_is_said(tmp_path: Path, texts: Mapping[str, str], place: str, problem: str) -> None:
    said = refusal(lambda: import_rawsimo(written_files(tmp_path, **texts)))
    assert said.startswith(f"{tmp_path / place}: ")
    assert problem in said


NARROW = ".......\n.##.##.\n.......\n.##→→→O\n.......\n"
LAYOUT = parse_map(NARROW, "hall")
ALONE = xinst(LAYOUT, {}, [(1, 1)])


def file(folder: Path, text: str) -> Path:
    path = folder / "x.xinst"
    path.write_text(text, encoding="utf-8")
    return path


def test_warehouses_are_read_whole(tmp_path: Path) -> None:
    notes = Notes()
    found = read_instance_file(file(tmp_path, xinst(LAYOUT, {3: (2, 2), 4: (4, 3)}, [(1, 7)], name="hall")), notes)
    assert found.text_map == NARROW
    assert (found.pods, found.places, found.pod_capacity) == (["p3", "p4"], [(2, 2), (4, 3)], [500, 500])
    assert (found.robots, found.robot_places) == (1, [(1, 7)])
    assert (found.moving, found.picking) == (Moving(1.0, 1.0, 1.5, 2.5, 2.2), [Picking(6, 13.0, 7.0)])
    assert found.read == {"waypoints": 35, "storage locations": 6, "picking stations": 1, "robots": 1, "pods": 2}
    assert notes.taken == []
    notes = Notes()
    text = xinst(parse_map(AROUND, "hall"), {}, [(1, 1)], inputs=[(15, (7, 6), (23, 22, 21))])
    found = read_instance_file(file(tmp_path, text), notes)
    assert found.text_map == "......→↓\n.##.##@I\n.....┘<<\n.##→→O@@\n......@@\n"
    assert (found.storing, found.read["replenishment stations"]) == ([Storing(400.0, 10.0)], 1)
    assert notes.taken == []
    notes = Notes()
    brakes = 'PodTransferTime="3" MaxAcceleration="0.5" MaxDeceleration="0.4" MaxVelocity="1" TurnSpeed="3"'
    text = xinst(LAYOUT, {}, [(1, 1)], robot=brakes, station='Capacity="12" ItemTransferTime="8"')
    found = read_instance_file(file(tmp_path, text), notes)
    assert (found.moving, found.picking) == (Moving(0.5, 0.4, 1.0, 3.0, 3.0), [Picking(12, 8.0, 8.0)])
    assert notes.taken == [Note("bots that brake otherwise than they start", 1, "as they start")]
    assert commonest([1, 2, 2, 1, 3]) == 1


def test_what_cannot_be_drawn(tmp_path: Path) -> None:
    notes = Notes()
    text = xinst(parse_map(AROUND, "hall"), {}, [(1, 1)], inputs=[(15, (14,), (23, 22, 21))])
    text = text.replace("<Queues>15/14</Queues>", "")
    found = read_instance_file(file(tmp_path, text), notes)
    assert found.storing == ()
    assert found.text_map == AROUND
    reason = "input station 0 has no queue; expected waypoints from which ways lead to it, as its `Queues`"
    assert Note("input stations (replenishment)", 1, f"walls; stock is not filled up: {reason}") in notes.taken
    assert Note("waypoints of lanes that lead nowhere, such as those of replenishment", 3, "walls") in notes.taken
    notes = Notes()
    pods, robots = {0: (2, 2), 1: (2, 2), 2: (3, 7)}, [(1, 1), (1, 1)]
    found = read_instance_file(file(tmp_path, xinst(LAYOUT, pods, robots)), notes)
    assert found.places == [(2, 2), (2, 3), (2, 6)]
    assert found.robot_places == [(1, 1), (1, 2)]
    assert [note.number for note in notes.taken] == [2, 1]
    assert {note.instead for note in notes.taken} == {"the nearest free one"}


@cases(
    "text message",
    (
        xinst(LAYOUT, {0: (2, 2), 1: (2, 3)}, [(1, 1)]).replace('Pod ID="1"', 'Pod ID="0"'),
        "found Pod 0 again; expected",
    ),
    (xinst(LAYOUT, {}, [(1, 1)], tiers=2), "found 2 tiers; expected one"),
    (xinst(LAYOUT, {}, [(1, 1)], pitch=1.05), "found waypoint 1 at x 1.575, y 0.525, the first one at x 0.525"),
    (xinst(LAYOUT, {}, []), "found no bot; expected at least one"),
    (
        ALONE.replace("<OutputStation ", "<Other ").replace("</OutputStation>", "</Other>"),
        "found no output station; expected at least",
    ),
    (ALONE.replace("<Queues>27/", "<Queues>27/x"), "expected the number of a waypoint"),
    (ALONE.replace('Waypoint ID="2"', 'Waypoint ID="1"'), "found waypoint 1 again; expected"),
    (ALONE.replace('Capacity="6"', 'Capacity="0"'), "expected a whole number from 1 to"),
    (xinst(LAYOUT, dict.fromkeys(range(7), (2, 2)), [(1, 1)]), "found no free cell for all pods; expected fewer"),
)
def test_what_cannot_be_read_is_said(tmp_path: Path, text: str, message: str) -> None:
    said = refusal(lambda: read_instance_file(file(tmp_path, text), Notes()))
    assert said.startswith(f"{tmp_path}/x.xinst")
    assert message in said


def test_a_layout_has_the_defaults_of_rawsimo(tmp_path: Path) -> None:
    """Where it leaves keys out; what rmfs draws otherwise is noted."""
    notes = Notes()
    found = read_layout_file(file(tmp_path, keys("LayoutConfiguration", {})), notes)
    assert found.layout == {
        **{"block_rows": 9, "block_columns": 7, "block_length": 4, "hall_width": 7},
        **{"stations_east": 4, "stations_west": 0, "pod_fill": 0.85, "replenishment_west": 4},
    }
    assert found.storing == [Storing(1000.0, 10.0)] * 4
    assert (found.queue_length, found.robots, len(found.pods)) == (12, 32, 428)
    assert found.picking[0] == Picking(12, 10.0, 3.0)
    halls = "halls whose lanes lead across (AisleLayoutType Tim)"
    assert notes.taken == [Note(halls, 1, "lanes that lead along the hall")]


def test_other_layouts_are_noted(tmp_path: Path) -> None:
    notes = Notes()
    values = {"AisleLayoutType": "HighwayHallway", "AislesTwoDirectional": "true", "NReplenishmentStationWest": 4}
    values |= {"NReplenishmentStationNorth": 2, "CounterClockwiseRingwayDirection": "false"}
    values |= {"DistanceEntryExitStation": 5, "NElevatorsEast": 1}
    found = read_layout_file(file(tmp_path, keys("LayoutConfiguration", values)), notes)
    assert found.queue_length == 20
    assert [note.number for note in notes.taken] == [2, 1, 4, 14, 1]
    assert found.layout["replenishment_west"] == 4


def test_input_stations_that_have_no_room_are_left_out(tmp_path: Path) -> None:
    notes = Notes()
    values = {"NrHorizontalAisles": 4, "NPickStationEast": 2, "AisleLayoutType": "HighwayHallway"}
    found = read_layout_file(file(tmp_path, keys("LayoutConfiguration", values)), notes)
    assert (found.storing, "replenishment_west" in found.layout) == ([], False)
    (note,) = notes.taken
    assert (note.what, note.number) == ("input stations in the east and west (replenishment)", 4)
    assert note.instead.startswith("left out; stock is not filled up: found 4 stations next to 5 rows of blocks")


@cases(
    "values message",
    ({"TierCount": 2}, "found 2 tiers; expected one"),
    ({"NPickStationNorth": 1}, "found 1 picking station in the north; expected them in the east and the west"),
    ({"PodAmount": 1.5}, "expected a number from 1e-06 to 1 as `PodAmount` of LayoutConfiguration, found '1.5'"),
    ({"NrHorizontalAisles": 9999, "NrVerticalAisles": 9999}, "expected at most 100,000"),
    ({"NrHorizontalAisles": 4, "PodAmount": 0.01}, "found 4 stations next to 5 rows of blocks; at most 2 fit"),
    ({"NPickStationEast": 0}, "found no picking station; expected at least one on either side"),
    ({"WidthHall": 10_000, "NrHorizontalAisles": 40}, "expected at most 1,000,000 cells in all"),
)
def test_layouts_that_cannot_be_drawn_are_refused(tmp_path: Path, values: dict[str, object], message: str) -> None:
    assert message in refusal(lambda: read_layout_file(file(tmp_path, keys("LayoutConfiguration", values)), Notes()))


TINY = "......\n.##.#.\n......\n.##→→O\n......\n"


def graph(layout: Layout) -> tuple[dict[int, Waypoint], list[StationPoints]]:
    """Return the waypoints of a layout, numbered as its cells are, and its stations."""
    points = {}
    for cell, kind in enumerate(layout.kind):
        if kind != CellKind.WALL:
            beside = (layout.neighbour(cell, heading) for heading in range(4) if layout.may_step(cell, heading))
            ways = tuple(other for other in beside if other is not None)
            x, y = cell % layout.width + 0.5, cell // layout.width + 0.5
            points[cell] = Waypoint(x, y, ways, bool(kind == CellKind.STORAGE), f"x.xinst, line {cell}")
    stations = [
        StationPoints(i, cells.station, (cells.station, *cells.queue), f"x.xinst, line {cells.station}")
        for i, cells in enumerate(layout.stations)
    ]
    return points, stations


def drawn(
    points: Mapping[int, Waypoint], stations: list[StationPoints], left_out: tuple[int, ...] = (), size: float = 0
) -> tuple[Drawn, list[Note]]:
    notes = Notes()
    return draw(points, stations, left_out, (size, size), "x.xinst", notes), notes.taken


@given(
    rows=st.integers(1, 6),
    columns=st.integers(1, 3),
    length=st.integers(1, 4),
    hall=st.integers(1, 4),
    sides=st.tuples(st.integers(0, 2), st.integers(0, 2)),
    queue=st.sampled_from(["plain", "shortcut"]),
    queue_length=st.integers(1, 9),
)
def test_what_was_a_layout_is_the_same_one(rows, columns, length, hall, sides, queue, queue_length) -> None:
    """Every block layout, as waypoints, is drawn so that it reads back as itself; there is nothing to note."""
    fitting = (rows - 1) // 2
    east, west = (min(number, fitting) for number in sides)
    if not east + west:
        rows, east = max(rows, 3), 1
    section = LayoutSection(rows, columns, length, hall, east, west, queue=queue)
    layout = parse_map(block_map(section, queue_length), "layout")
    found, notes = drawn(*graph(layout))
    assert notes == []
    assert found.layout.stations == layout.stations
    assert found.layout.kind.tolist() == layout.kind.tolist()
    assert found.layout.moves.tolist() == layout.moves.tolist()


def test_where_a_grid_begins_and_a_queue_ends() -> None:
    points, stations = graph(parse_map(TINY, "hall"))
    moved = {i: evolve(point, x=point.x - 3.25, y=point.y + 2) for i, point in points.items()}
    found, notes = drawn(moved, stations)
    assert found.text == "@@@@@@\n@@@@@@\n" + TINY
    assert (found.cell(-2.75, 2.5), found.cell(-2.0, 7.4), found.cell(99, -99), notes) == (12, 37, 5, [])
    larger = drawn(points, stations, size=8)[0].text.splitlines()
    assert larger == [f"{row}@@" for row in TINY.splitlines()] + ["@" * 8] * 3
    points, stations = graph(parse_map(TINY, "hall"))
    turned = [evolve(stations[0], queue=tuple(reversed(stations[0].queue)))]
    assert drawn(points, turned)[0].layout.stations == parse_map(TINY, "hall").stations


def test_lanes_and_ways_that_are_left_out() -> None:
    layout = parse_map("......\n.##.#.\n......\n.##→→O\n......\n@@^@@@\n", "hall")
    points, stations = graph(parse_map("......\n.##.#.\n......\n.##→→O\n......\n@.....\n", "hall"))
    lane = {i: point for i, point in points.items() if i < 30 or i in (31, 32)}
    lane[31] = evolve(lane[31], ways=(32,))
    lane[32] = evolve(lane[32], ways=(26,))
    lane = {i: evolve(p, ways=tuple(w for w in p.ways if w in lane and (i > 30 or w < 32))) for i, p in lane.items()}
    found, notes = drawn(lane, stations, left_out=(31,))
    assert found.text.splitlines()[-1] == "@@@@@@"
    assert notes == [Note("waypoints of lanes that lead nowhere, such as those of replenishment", 1, "walls")]
    assert layout.height == found.layout.height
    points, stations = graph(parse_map(TINY, "hall"))
    points[0] = evolve(points[0], ways=(*points[0].ways, 4))
    points[21] = evolve(points[21], ways=(*points[21].ways, 27))
    points[1] = evolve(points[1], ways=tuple(way for way in points[1].ways if way != 7))
    _, notes = drawn(points, stations)
    assert notes == [
        Note("ways that a text map cannot say", 1, "left out"),
        Note("no ways between cells that a text map always joins", 1, "ways"),
        Note("ways between waypoints that are not side by side", 1, "left out"),
    ]


@cases(
    "number change message",
    (3, {"x": 3.6}, "x.xinst, line 3: found waypoint 3 at x 3.6, y 0.5, the first one at x 0.5, y 0.5; expected"),
    (3, {"x": 1.5}, "x.xinst, line 3: found waypoints 1 and 3 at one point; expected one"),
    (3, {"ways": (99,)}, "x.xinst, line 3: found a path to waypoint 99, which does not exist"),
    (3, {"x": 1e6 + 0.5}, "x.xinst: found 1,000,001 x 5 m; expected at most 1,000,000 cells of 1 m x 1 m"),
    (3, {"x": 1e5 + 0.5}, "x.xinst: found a map of 100,001 x 5 cells; expected at most 5,000 in a row or column"),
    (22, {"ways": ()}, "x.xinst, line 23: output station 0 has no queue; expected waypoints from which ways lead"),
    (21, {"ways": ()}, "no aisle leads into the end of this queue"),
    (28, {"ways": ()}, ""),
)
def test_what_is_no_grid_or_no_warehouse_is_refused(number: int, change: dict[str, object], message: str) -> None:
    points, stations = graph(parse_map(TINY, "hall"))
    points[number] = evolve(points[number], **change)
    if number == 21:
        points[20] = evolve(points[20], ways=())
    if not message:
        drawn(points, stations)
        return
    assert message in refusal(lambda: drawn(points, stations))


def test_stations_without_waypoints_are_refused() -> None:
    points, stations = graph(parse_map(TINY, "hall"))
    with pytest.raises(InputError, match="found no waypoint of output station 0; expected one"):
        drawn(points, [evolve(stations[0], waypoint=77)])
    with pytest.raises(InputError, match="the queue has waypoint 78; there is none of that number"):
        drawn(points, [evolve(stations[0], queue=(78,))])
    with pytest.raises(InputError, match="found no waypoint; expected some"):
        drawn({}, stations)
