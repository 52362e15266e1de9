"""The picture of a hall before a run."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

import rmfs
from calling import exit_code
from rmfs_commands.cli.hall import wanted_of_pods
from rmfs_commands.cli.not_simulated import NOT_SIMULATED_PAGE
from rmfs_commands.layouts import parse_map
from rmfs_commands.layouts.hall import HallPod, hall_legend, hall_svg
from rmfs_core.world import Instance, OrderData, PodData

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
    assert exit_code("scenario", "map", "examples/small", "--out", "x.html") == 2
    assert capsys.readouterr().err == "Error: --out: is for a page; expected --html, too\n"
