"""Layouts: blocks and text maps, and the picture of a hall before a run."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from attrs import evolve

import rmfs
from calling import exit_code, refusal, refused
from cases import cases
from rmfs_commands.cli.hall import wanted_of_pods
from rmfs_commands.cli.main import main
from rmfs_commands.cli.map_drawing import draw_map
from rmfs_commands.cli.not_simulated import NOT_SIMULATED_PAGE
from rmfs_commands.layouts import block_map, parse_map
from rmfs_commands.layouts.hall import HallPod, hall_legend, hall_svg
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import LayoutSection
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, CellKind, Instance, OrderData, PodData, check_layout
from rmfs_core.world.grid import LONGEST_SIDE


def test_layouts_of_known_sizes() -> None:
    layout = parse_map(block_map(LayoutSection(), 12), "map")
    check_layout(layout, "map")
    assert len(layout.storage_locations) == 504
    assert [len(cells.queue) for cells in layout.stations] == [12] * 4
    assert all(cells.station % layout.width == layout.width - 1 for cells in layout.stations)
    section = LayoutSection(block_rows=3, block_columns=1, block_length=2, hall_width=1, stations_east=1, queue="plain")
    assert block_map(section, 6) == ("v<<<@@\nv##^@@\nv##^@@\n┌>>└→↓\nv##^↓←\nv##^→↓\nv<<┘<O\nv##^@@\nv##^@@\n>>>^@@\n")
    section = LayoutSection(block_rows=3, block_columns=1, block_length=2, hall_width=1, queue="shortcut")
    east = block_map(evolve(section, stations_east=1), 6)
    assert east == "v<<<@@\nv##^@@\nv##^@@\n┌>>└→↓\nv##^↓╗\nv##└→↓\nv<<┘<O\nv##^@@\nv##^@@\n>>>^@@\n"
    west = block_map(evolve(section, block_rows=4, stations_east=0, stations_west=1), 6)
    assert "↓←┐<<┘\n╔↓v##^\n↓←┐##^\nO>┌>>^\n" in west


@pytest.mark.parametrize("form", ["plain", "shortcut"])
@pytest.mark.parametrize("rows", [3, 4, 5, 6, 9])
@pytest.mark.parametrize("hall", [1, 2, 3, 5])
@pytest.mark.parametrize("queue", [1, 2, 3, 12])
def test_every_block_layout_is_fit_for_use(rows: int, hall: int, queue: int, form: str) -> None:
    fitting = (rows - 1) // 2
    section = LayoutSection(
        block_rows=rows, block_columns=3, hall_width=hall, stations_east=fitting, stations_west=fitting, queue=form
    )
    text = block_map(section, queue)
    layout = parse_map(text, "map")
    check_layout(layout, "map")
    assert (draw_map(layout), len(layout.stations)) == (text, 2 * fitting)
    assert all(len(cells.queue) >= queue for cells in layout.stations)
    assert (layout.kind == CellKind.STORAGE).sum() == rows * 3 * 8


def test_too_many_stations_or_long_queues_are_refused() -> None:
    with pytest.raises(
        InputError, match=r"layout\.stations_east: found 3 stations next to 5 rows of blocks; at most 2 fit"
    ):
        block_map(LayoutSection(block_rows=5, stations_east=3), 12)
    with pytest.raises(InputError, match="found no picking station"):
        block_map(LayoutSection(stations_east=0), 12)
    with pytest.raises(InputError, match=r"stations\.queue_length: found queues of 100,000 cells next to 100 rows of"):
        block_map(LayoutSection(block_rows=100), 100_000)


def test_aisles_and_replenishment_stations() -> None:
    west = block_map(LayoutSection(block_rows=5, stations_east=1, replenishment_west=2), 3)
    assert [row.strip("@")[0] for row in west.splitlines() if "I" in row] == ["I", "I"]
    east = "".join(block_map(LayoutSection(block_rows=7, stations_east=2, replenishment_east=1), 3).split())
    assert [sign for sign in east if sign in "IO"] == ["O", "O", "I"]
    with pytest.raises(InputError, match=r"layout.replenishment_east: found 4 stations next to 7 rows"):
        block_map(LayoutSection(block_rows=7, stations_east=2, replenishment_east=2), 3)
    layout = parse_map("v<<<\nv##^\n>>>^\n.qO.\n....", "ring")
    assert layout.may_step(1, WEST)
    assert not layout.may_step(1, EAST)
    assert not layout.may_step(0, EAST)
    assert layout.may_step(1, SOUTH)  # into storage
    assert layout.may_step(5, NORTH)
    layout = parse_map("#...\n..qI\n....\n..qO\n....", "map")
    assert [cells.station for cells in layout.stations] == [15, 7]
    assert (layout.replenishing, layout.lane[7], draw_map(layout).count("I")) == (1, 1, 1)
    assert parse_map(draw_map(layout), "drawn").stations == layout.stations


@cases(
    "text message",
    ("", "map: the map is empty; expected rows of characters such as `#` and `.`"),
    ("#.\n.x", "map, row 2, column 2: unknown sign 'x'; expected one of # O I q"),
    ("#..\n..O", "map, row 2, column 3: the station has no queue; expected at least one queue cell (`q`)"),
    ("#.qq\n.qqO", "the queue branches to row 1, column 4 and row 2, column 3; give the direction"),
    ("#..q\n.qO.\n....", "map, row 1, column 4: the queue cell leads to no station"),
    ("@#..\n.╔→O\n.@.@", "map, row 2, column 2: the queue cell leads to row 2, column 3 and row 3, column 2; expected"),
    ("#...\n.→╚O", "map, row 2, column 3: the queue cell leads to row 2, column 4 and row 1, column 3; expected two"),
    (".→╚O", "map, row 1, column 3: the queue cell leads to row 1, column 4 and beyond the map; expected two cells"),
    ("#....\n.→╔→O\n..↓..\n..→→O", "map, row 2, column 3: the queue cell leads to row 2, column 4 and row 3, col"),
    ("#.....\n.╔→↓..\n.↓╔←..\n.→→→→O", "map, row 2, column 2: the queue cell leads to row 2, column 3 and row 3, c"),
    ("#....\n.→⇒→O", "map, row 2, column 3: found a queue cell where nobody waits (⇒ ⇐ ⇑ ⇓) out of place; expected"),
    ("#..\n.⇒O", "map, row 2, column 3: found a queue cell where nobody waits (⇒ ⇐ ⇑ ⇓) out of place; expected"),
    ("#╔→↓\n.→→→O", "map, row 2, column 4: the queue branches to row 1, column 4 and row 2, column 3; give"),
)
def test_wrong_maps_are_refused_with_the_cell(text: str, message: str) -> None:
    assert message in refusal(lambda: parse_map(text, "map"))


FOLDED = """
#.......
..→→→→↓.
..↓←←╗←.
.└→→→↓..
.....O..
........
"""


def test_a_queue_may_have_a_shortcut_and_a_second_entrance() -> None:
    layout = parse_map(FOLDED, "folded")
    check_layout(layout, "folded")
    (cells,) = layout.stations
    assert [cell % 8 for cell in cells.queue] == [5, 4, 3, 2, 2, 3, 4, 5, 6, 6, 5, 4, 3, 2]
    shortcut, entrance = cells.queue[7], cells.queue[3]
    assert [h for h in range(4) if layout.may_step(shortcut, h)] == [WEST, SOUTH]
    assert layout.neighbour(shortcut, SOUTH) == cells.queue[0]
    assert layout.may_step(entrance - 1, EAST)
    assert layout.may_step(entrance - 1, NORTH)
    assert not layout.may_step(cells.queue[4] - 1, EAST)  # a cell that leads everywhere is no entrance
    assert draw_map(layout) == draw_map(parse_map(draw_map(layout), "drawn"))
    assert "╗" in draw_map(layout)


@pytest.mark.parametrize(
    "text",
    [
        ".......\n.##.#..\n.......\n.##.qqO\n.##.@@.\n.......",  # the cell south of the station
        ".......\n.#.v.#.\n....<..\n.#.^.#.\n...qqO.\n.......",  # among one-way cells that lead to it
        "........\n.##.##..\n.##.@.#.\n......#.\n.##.qqO.\n...└....",  # a dead end, and one beside storage locations
    ],
)
def test_a_drawn_map_is_read_back_with_the_same_ways(text: str) -> None:
    layout = parse_map(text, "given")
    drawn = parse_map(draw_map(layout), "drawn")
    assert (drawn.moves.tolist(), drawn.kind.tolist()) == (layout.moves.tolist(), layout.kind.tolist())


def test_cells_before_a_station_may_be_kept_clear() -> None:
    layout = parse_map("#......\n.→→⇒⇒O.\n.......", "clear")
    check_layout(layout, "clear")
    (cells,) = layout.stations
    assert (cells.queue, cells.clear, cells.places) == ((11, 10, 9, 8), 2, 2)
    assert [layout.may_step(cell, EAST) for cell in cells.queue] == [True] * 4
    assert draw_map(layout).splitlines()[1].strip("┌│") == "→→⇒⇒O"


@cases("width height", (3000, 3000), (3_000_000, 1), (1, 3_000_000), (LONGEST_SIDE + 1, 2), (1, LONGEST_SIDE + 1))
def test_a_map_that_no_memory_has_room_for_is_refused(width: int, height: int) -> None:
    expected = "expected at most 5,000 in a row or column and 4,000,000 in all"
    assert (
        refusal(lambda: parse_map("#\n" * (height - 1) + "#" * width, "hall.txt"))
        == f"hall.txt: found a map of {width:,} x {height:,} cells; {expected}"
    )


def test_the_longest_row_that_may_be_is_read() -> None:
    assert parse_map("." * LONGEST_SIDE, "hall.txt").width == LONGEST_SIDE


MAP = "<<<<<\nv##..\nv.#P@\nvCqqO"


def shapes(svg: str) -> list[tuple[str, dict[str, str]]]:
    """Return class and attributes of what is drawn, once it is seen that the text is XML."""
    return [(one.get("class", ""), dict(one.attrib)) for one in ElementTree.fromstring(svg)]


def test_what_is_drawn_is_where_it_is() -> None:
    layout = parse_map(MAP, "map")
    drawn = shapes(hall_svg(layout, [HallPod(6, 3, "pod <1>"), HallPod(7)], [6], over='<g class="heat"/>'))
    at = {kind: (found.get("x"), found.get("y")) for kind, found in drawn}
    assert at["level-3"] == ("1.12", "1.12")
    assert at["empty"] == ("2.12", "1.12")
    assert at["pick"] == ("4", "3")
    assert at["pack"] == ("3", "2")
    areas = dict(drawn)
    assert areas["charge"]["d"] == "M1 3h1v1h-1z"
    assert areas["wall"]["d"] == "M3 2h2v1h-2z"  # packing stations stand on it
    assert [kind for kind, _ in drawn].index("heat") < [kind for kind, _ in drawn].index("level-3")
    arrows = re.findall(r"M(\d+)[\d.]* (\d+)", areas["arrow"]["d"])
    assert {("1", "0"), ("4", "0"), ("0", "1"), ("2", "3"), ("3", "3")} <= {*arrows}  # one-way floor, and the queue


def test_the_legend_has_what_is_there() -> None:
    layout = parse_map(MAP, "map")
    legend = hall_legend(layout, {0: "pods, <no> items"}, robots=1)
    for text in ("1 picking station<", "1 packing station<", "1 charger<", "one-way aisles", "walls", "1 robot at"):
        assert text in legend
    assert "pods, &lt;no&gt; items" in legend
    assert "replenishment" not in legend
    assert "empty pods" not in legend
    assert "one-way" not in hall_legend(parse_map("##..\n..qO", "map"))


def test_demand_is_shared_among_the_pods_of_a_sku() -> None:
    pods = [PodData("A", ((0, 5), (1, 5))), PodData("B", ((0, None),)), PodData("C", ((2, 1),))]
    orders = [OrderData("1", ((0, 3), (1, 1)), arrival_tick=0), OrderData("2", ((0, 1),), arrival_tick=0)]
    assert wanted_of_pods(Instance(("x", "y", "z"), tuple(orders), tuple(pods))) == [3, 2, 0]


@pytest.mark.parametrize("name", ["examples/packing", "examples/charging", "examples/text-map"])
def test_a_page_needs_nothing_else(name, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert exit_code("scenario", "map", name, "--html") == 0
    file = f"{name.partition('/')[2]}-map.html"
    assert capsys.readouterr().out == f"Open {file} in a browser.\n"
    page = Path(file).read_text(encoding="utf-8")
    assert not re.search(r"(src|href|url)\s*[=(]", page)
    picture = rmfs.hall(name)
    assert picture.figure in page
    assert picture.figure in picture._repr_html_()
    loaded = rmfs.load_scenario(name)
    assert picture.figure.count('class="robot" cx') == loaded.robots.count + 1  # and one in the legend
    assert NOT_SIMULATED_PAGE in page
    told = Path(__file__).parents[4] / "docs" / "explanation" / "what-is-not-simulated.md"
    assert told.read_text(encoding="utf-8").startswith(f"# {NOT_SIMULATED_PAGE}\n")


def test_a_picture_as_text_has_no_file(capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(capsys, main, ["scenario", "map", "examples/small", "--out", "x.html"])
    assert said == "Error: --out: is for a page; expected --html, too\n"
