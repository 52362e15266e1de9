"""Cells of layouts and what is next to them, layouts of scenarios, and what makes one unfit for use."""

import re
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from attrs import evolve

from cases import cases
from rmfs_commands.layouts import parse_map
from rmfs_commands.layouts.drawing import DRAWN
from rmfs_core import run
from rmfs_core.errors import InputError
from rmfs_core.scenario import LayoutSection, RuleChoice, RulesSection, Scenario, load_scenario
from rmfs_core.scenario.structuring import structure
from rmfs_core.scenario.writing import plain
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, Layout, StationCells, check_layout, make_layout
from rmfs_core.world.grid import where
from rmfs_core.world.layout_making import queue_length
from saying import said

Install = Callable[..., None]

TWO_STATIONS = parse_map("#..#\nqqO.\n....\n.Oqq\n#...", "two stations")
"""Four columns, five rows; a queue of two cells west of the first station and one east of the second."""


def test_cells_headings_and_distances() -> None:
    assert (TWO_STATIONS.width, TWO_STATIONS.height) == (4, 5)
    assert TWO_STATIONS.storage_locations == (0, 3, 16)
    assert TWO_STATIONS.stations == (StationCells(6, (5, 4)), StationCells(13, (14, 15)))
    assert [TWO_STATIONS.may_step(6, heading) for heading in range(4)] == [True, True, False, True]
    assert [TWO_STATIONS.may_step(5, heading) for heading in range(4)] == [True, False, False, False]
    assert [TWO_STATIONS.distance(0, cell) for cell in (0, 3, 4, 7, 19)] == [0, 3, 1, 4, 7]
    assert (TWO_STATIONS.distance(19, 0), TWO_STATIONS.where(0)) == (7, "row 1, column 1")
    assert TWO_STATIONS.where(7) == where(7, 4) == "row 2, column 4"


@cases(
    "cell neighbours", (0, [1, None, None, 4]), (3, [None, None, 2, 7]), (9, [10, 5, 8, 13]), (16, [17, 12, None, None])
)
def test_neighbours_end_at_the_edge(cell: int, neighbours: list[int | None]) -> None:
    assert [TWO_STATIONS.neighbour(cell, heading) for heading in (EAST, NORTH, WEST, SOUTH)] == neighbours
    assert TWO_STATIONS.beside(cell) == [(heading, one) for heading, one in enumerate(neighbours) if one is not None]


def test_lanes_and_their_entries() -> None:
    lane = TWO_STATIONS.lane
    assert np.flatnonzero(lane == 0).tolist() == [4, 5, 6]
    assert np.flatnonzero(lane == 1).tolist() == [13, 14, 15]
    assert (lane == -1).sum() == 14
    with pytest.raises(ValueError, match="read-only"):
        lane[0] = 1
    cells = TWO_STATIONS.stations[0]
    assert [cells.slot(place) for place in range(5)] == [6, 5, 4, 4, 4]
    cells = StationCells(9, (8, 7, 6, 5), clear=1)
    assert [cells.slot(place) for place in range(5)] == [9, 7, 6, 5, 5]
    assert (cells.places, StationCells(9, (8, 7)).places) == (3, 2)


def test_the_nearest_of_some_floor_cells_to_a_goal() -> None:
    layout = parse_map("#...>..#\n...qO...\n........", "row")
    assert layout.nearest({2, 6}, [0, 7]) == (6, 7)
    assert layout.nearest({2, 6}, [0]) == (2, 0)
    assert layout.nearest({5}, [0]) == (5, 0)  # around the station
    assert layout.nearest({5, 11, 16}, [0]) == (16, 0)  # a queue cell is none


def test_notebooks_show_layouts_to_scale() -> None:
    layout = parse_map("#..#\nqqO.\n....\n.Oqq\n#..@", "two stations")
    (shown,) = ElementTree.fromstring(str(layout._repr_html_())).iter("svg")
    assert shown.get("viewBox") == "0 0 4 5"
    lengths = {
        path.get("fill"): sum(map(int, re.findall(r"h(\d+)v1h-\1z", str(path.get("d"))))) for path in shown.iter("path")
    }
    assert lengths == {DRAWN[kind][0]: int((layout.kind == kind).sum()) for kind in DRAWN}
    assert [path.get("d") for path in shown.iter("path")][-1] == "M2 1h1v1h-1zM1 3h1v1h-1z"
    assert "3 storage locations, " in re.sub("<[^>]*>", "", str(layout._repr_html_()))
    side = 501
    none = np.zeros(side * side, np.int8)
    assert Layout(side, side, none, none, ())._repr_html_() is None


CUT_OFF = "map: found cells that cannot be reached over the floor from row 1, column 2:"


@cases(
    "text message",
    ("..#\n.qO\n..@\n@@.", f"{CUT_OFF} row 4, column 3"),
    (  # four of a kind: three are named
        "..#@\n.qO.\n@@@@\n....",
        f"{CUT_OFF} row 4, column 1; row 4, column 2; row 4, column 3 and 1 more",
    ),
    (
        "#...>.\n.qO..@\n......",  # a pocket that is entered by a one-way cell and never left
        "map: found cells that have no way over the floor to row 1, column 2: row 1, column 5; row 1, column 6",
    ),
    (
        ".#.\n###\n.qO\n...",
        "map: found cells that have no floor next to them, so no pod gets in or out: row 2, column 2",
    ),
    ("#.\n..", "map: the layout has no picking station; expected at least one (`O` in a map)"),
    (".qO\n...", "map: the layout has no storage location; expected some (`#` in a map)"),
    ("###\n#qO", "map: the layout has no floor; expected aisles (`.` in a map)"),
    ("#@@@\n.@qO\n.<┘<", "map, row 2, column 3: no aisle leads into the end of this queue"),
    ("..#\n.qO", "map, row 2, column 3: no floor next to the station to leave it"),
)
def test_a_map_that_cannot_be_driven_on_is_refused_with_its_cells(text: str, message: str) -> None:
    assert said(InputError, check_layout, parse_map(text, "map"), "map") == message


def test_a_lane_may_lead_away_from_a_station_only() -> None:
    check_layout(parse_map("#....\n.qO>.\n.....\n@@@@@", "map"), "map")


MAP = "..#..\n.qqO.\n.....\n"
SCENARIO = '[layout]\nmap_file = "map.txt"\n[stations]\nqueue_length = 2\n[rules]\npoa = "pod-match"\npps = "demand"\n'


def scenario_with_map(folder: Path, text: str) -> Path:
    (folder / "map.txt").write_text(text, encoding="utf-8")
    (folder / "s.toml").write_text(SCENARIO, encoding="utf-8")
    return folder / "s.toml"


def test_map_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    file = scenario_with_map(tmp_path, MAP)
    layout = make_layout(load_scenario(file))
    assert (layout.width, layout.storage_locations, layout.stations[0].queue) == (5, (2,), (7, 6))
    assert make_layout(load_scenario(file, ["seed=2"])) is layout  # with which tables of driving times are kept
    assert make_layout(load_scenario(file, ["stations.queue_length=1"])) is not layout
    scenario_with_map(tmp_path, MAP.replace("..#", ".##"))
    assert make_layout(load_scenario(file)).storage_locations == (1, 2)
    assert make_layout(load_scenario(scenario_with_map(tmp_path, f"\ufeff{MAP}"))).width == 5
    file = scenario_with_map(tmp_path, MAP)
    (tmp_path / "map.txt").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"map\.txt: cannot read the map: .*utf-8"):
        make_layout(load_scenario(file))
    (tmp_path / "map.txt").unlink()
    with pytest.raises(InputError, match=r"map\.txt cannot be read: No such file"):
        make_layout(load_scenario(file))


def test_a_map_says_how_long_its_queues_are(tmp_path: Path) -> None:
    file = scenario_with_map(tmp_path, MAP)
    mapped = load_scenario(file, ["stations.queue_length="])
    assert queue_length(mapped, make_layout(mapped)) == 2
    given = load_scenario(file, ["stations.queue_length=1"])
    assert queue_length(given, make_layout(given)) == 1
    (tmp_path / "map.txt").write_text("..#" + "." * 14 + "\n." + "q" * 14 + "O.\n" + "." * 17 + "\n", encoding="utf-8")
    assert queue_length(mapped, make_layout(mapped)) == 12
    drawn = load_scenario("examples/small")
    assert (drawn.stations.queue_length, queue_length(drawn, make_layout(drawn))) == (None, 12)
    file = scenario_with_map(tmp_path, MAP)
    assert said(InputError, make_layout, load_scenario(file, ["stations.queue_length=3"])) == (
        f"stations.queue_length: found 3, but the queue of station 1 in {tmp_path}/map.txt has 2 cells; "
        "expected at most that many"
    )


@cases(
    "name problem",
    ("a\0b", r"^layout\.map_file: .* cannot be read: embedded null byte$"),
    ("/dev/zero", r"^/dev/zero: found a map of [\d,]+ x 1 cells; expected at most 5,000"),  # goes on for ever
)
def test_a_map_file_that_is_none_is_named(tmp_path: Path, name: str, problem: str) -> None:
    scenario = load_scenario(scenario_with_map(tmp_path, MAP))
    with pytest.raises(InputError, match=problem):
        make_layout(evolve(scenario, layout=evolve(scenario.layout, map_file=name)))


LAYOUTS = """
from attrs import evolve
from rmfs_commands.layouts import parse_map
from rmfs_core.world import StationCells

def lane(section, text, queue_length, place):
    return parse_map(text or "####..@@@\\n......qqO\\n####.....", place)

def long(section, text, queue_length, place, *, length, gap=False):
    length.append(2)
    return lane(section, "#" * sum(length) + f"..@@@\\n{'.' * sum(length)}..qqO\\n.{'.' * sum(length)}....", 0, place)

def row_by_row(section, text, queue_length, place):
    return evolve(lane(section, text, queue_length, place), kind=[0, 1])

def outside(section, text, queue_length, place):
    return evolve(lane(section, text, queue_length, place), stations=(StationCells(99, (5, 6)),))

def no_queue(section, text, queue_length, place):
    return evolve(lane(section, text, queue_length, place), stations=(StationCells(17, ()),))

RULES = "none"

def shut(section, text, queue_length, place):
    return parse_map("#@.\\n@qO\\n...", place)
"""
RULES = RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand"))
GENERATORS = {
    name: f"acme_halls:{name}" for name in ("lane", "long", "row_by_row", "outside", "no_queue", "shut", "RULES")
}


def test_a_distribution_makes_layouts(install: Install) -> None:
    install("acme", GENERATORS, group="rmfs.layouts", acme_halls=LAYOUTS)
    scenario = load_scenario("examples/small", ["layout.generator=lane", "robots.count=2", "instance.pods=6"])
    layout = make_layout(scenario)
    assert (layout.width, len(layout.storage_locations), len(layout.stations)) == (9, 8, 1)
    assert make_layout(scenario) is layout
    assert run(scenario).versions["acme"] == "1.0"
    assert make_layout(scenario, "#....\n..qqO\n.....").width == 5


def test_a_generator_of_layouts_takes_parameters(install: Install) -> None:
    """As one of instances does. What it does to them is its own; 1 and true are two parameters."""
    install("acme", GENERATORS, group="rmfs.layouts", acme_halls=LAYOUTS)
    keys = ["layout.generator=long", "layout.parameters={length=[3, 4]}"]
    first, again, other = (
        make_layout(load_scenario("examples/small", [*keys, key]))
        for key in ("seed=1", "seed=2", "layout.parameters.gap=true")
    )
    assert (len(first.storage_locations), first is again, first is other) == (9, True, False)
    assert make_layout(structure(plain(load_scenario("examples/small", keys)))) is first
    for text, same in (("wide", True), ("small.toml", False)):  # a file beside the scenario, which may change
        named = [*keys, f"layout.parameters.gap={text}"]
        made = [make_layout(load_scenario("examples/small", named)) for _ in range(2)]
        assert (made[0] is made[1]) is same
    one = LayoutSection(generator="long", parameters={"a": 1, "b": 2})
    assert one == evolve(one, parameters={"b": 2, "a": 1}) != evolve(one, parameters={"a": True, "b": 2})


RETURNED = 'layout.generator: generator "{}" (acme 1.0) returned a wrong Layout:'
CELLS = "; expected cells from 0 to 26, and a queue of at least one"


@cases(
    "name problem",
    (
        "RULES",
        "layout.generator: generator \"RULES\" (acme 1.0) cannot be called: 'none' is not a callable object; besides "
        "section, text, queue_length and place it takes nothing",
    ),
    ("row_by_row", f"{RETURNED.format('row_by_row')} `kind` [0, 1]; expected an array of int8, shape (27,)"),
    ("outside", f"{RETURNED.format('outside')} station 1 StationCells(station=99, queue=(5, 6), clear=0){CELLS}"),
    ("no_queue", f"{RETURNED.format('no_queue')} station 1 StationCells(station=17, queue=(), clear=0){CELLS}"),
    ("shut", "layout: found cells that have no floor next to them, so no pod gets in or out: row 1, column 1"),
    ("text-map", "layout.map_file: expected the text map that the layout generator `text-map` reads"),
)
def test_a_layout_that_cannot_be_had_is_one_sentence(install: Install, name: str, problem: str) -> None:
    install("acme", GENERATORS, group="rmfs.layouts", acme_halls=LAYOUTS)
    assert said(InputError, make_layout, Scenario(rules=RULES, layout=LayoutSection(generator=name))) == problem


def test_a_name_of_ours_that_others_offer_too_is_ours_where_none_is_given(install: Install) -> None:
    install("acme", {"blocks": "acme_halls:shut"}, group="rmfs.layouts", acme_halls=LAYOUTS)
    assert len(make_layout(Scenario(rules=RULES)).stations) == 4
    with pytest.raises(InputError, match="expected one of them: `acme:blocks` or `rmfs:blocks`"):
        make_layout(Scenario(rules=RULES, layout=LayoutSection(generator="blocks")))
