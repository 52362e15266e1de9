"""Layouts of scenarios, and what makes one unfit for use."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from attrs import evolve

from rmfs_core import run
from rmfs_core.errors import InputError
from rmfs_core.scenario import LayoutSection, RuleChoice, RulesSection, Scenario, load_scenario
from rmfs_core.world import check_layout, make_layout, parse_map
from rmfs_core.world.layout_making import queue_length


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "..#\n.qO\n..@\n@@.",
            "map: found cells that cannot be reached over the floor from row 1, column 2: row 4, column 3",
        ),
        (
            ".#.\n###\n.qO\n...",
            "map: found cells that have no floor beside them, so no pod gets in or out: row 2, column 2",
        ),
        ("#.\n..", "map: the layout has no picking station"),
        (".qO\n...", "map: the layout has no storage location"),
        ("#@@@\n.@qO\n.<┘<", "map, row 2, column 3: no aisle leads into the end of this queue"),
        ("..#\n.qO", "map, row 2, column 3: no floor beside the station to leave it"),
    ],
)
def test_what_cannot_be_reached_is_named(text: str, message: str) -> None:
    """A map that can be read but not driven on is refused with the cells."""
    layout = parse_map(text, "map")
    with pytest.raises(InputError) as caught:
        check_layout(layout, "map")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        # a pocket that is entered by a one-way cell and never left
        (
            "#...>.\n.qO..@\n......",
            "map: found cells that have no way over the floor to row 1, column 2: row 1, column 5; row 1, column 6",
        ),
        # four of a kind: three are named
        (
            "..#@\n.qO.\n@@@@\n....",
            "map: found cells that cannot be reached over the floor from row 1, column 2: row 4, column 1; "
            "row 4, column 2; row 4, column 3 and 1 more",
        ),
        # all is storage
        ("###\n#qO", "map: the layout has no floor; expected aisles (`.` in a map)"),
    ],
)
def test_robots_get_from_everywhere_to_everywhere(text: str, message: str) -> None:
    """Whatever floor there is is reached and left; at most three cells are named that are not."""
    layout = parse_map(text, "map")
    with pytest.raises(InputError) as caught:
        check_layout(layout, "map")
    assert str(caught.value) == message


def test_a_lane_may_lead_away_from_a_station_only() -> None:
    """It is reached from the station, and leads back to the aisles."""
    check_layout(parse_map("#....\n.qO>.\n.....\n@@@@@", "map"), "map")


MAP = "..#..\n.qqO.\n.....\n"
SCENARIO = '[layout]\nmap_file = "map.txt"\n[stations]\nqueue_length = 2\n[rules]\npoa = "pod-match"\npps = "demand"\n'


def scenario_with_map(folder: Path, text: str) -> Path:
    """Write a scenario with a text map."""
    (folder / "map.txt").write_text(text, encoding="utf-8")
    (folder / "s.toml").write_text(SCENARIO, encoding="utf-8")
    return folder / "s.toml"


def test_a_map_is_read_from_the_scenarios_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wherever the command is called; an edited map is another layout."""
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    file = scenario_with_map(tmp_path, MAP)
    layout = make_layout(load_scenario(file))
    assert (layout.width, layout.storage_locations, layout.stations[0].queue) == (5, (2,), (7, 6))
    scenario_with_map(tmp_path, MAP.replace("..#", ".##"))
    assert make_layout(load_scenario(file)).storage_locations == (1, 2)


def test_a_byte_order_mark_is_no_cell(tmp_path: Path) -> None:
    """Editors on Windows begin files with it."""
    assert make_layout(load_scenario(scenario_with_map(tmp_path, f"\ufeff{MAP}"))).width == 5


def test_the_same_layout_is_the_same_object(tmp_path: Path) -> None:
    """Its tables of driving times are kept with it, so that the next run need not compute them again."""
    file = scenario_with_map(tmp_path, MAP)
    assert make_layout(load_scenario(file)) is make_layout(load_scenario(file, ["seed=2"]))
    drawn = load_scenario("examples/small")
    assert make_layout(drawn) is make_layout(drawn.with_seed(99))
    assert make_layout(drawn) is not make_layout(load_scenario("examples/small", ["stations.queue_length=2"]))


def test_a_map_says_how_long_its_queues_are(tmp_path: Path) -> None:
    """Where the scenario does not: as long as the shortest; 12 where they are longer, or the layout is drawn."""
    file = scenario_with_map(tmp_path, MAP)
    mapped = load_scenario(file, ["stations.queue_length="])
    assert queue_length(mapped, make_layout(mapped)) == 2
    given = load_scenario(file, ["stations.queue_length=1"])
    assert queue_length(given, make_layout(given)) == 1
    (tmp_path / "map.txt").write_text("..#" + "." * 14 + "\n." + "q" * 14 + "O.\n" + "." * 17 + "\n", encoding="utf-8")
    assert queue_length(mapped, make_layout(mapped)) == 12
    drawn = load_scenario("examples/small")
    assert (drawn.stations.queue_length, queue_length(drawn, make_layout(drawn))) == (None, 12)


def test_a_queue_that_is_too_short_for_the_scenario_is_refused(tmp_path: Path) -> None:
    """The key is named, with the station and how many cells its queue has."""
    file = scenario_with_map(tmp_path, MAP)
    with pytest.raises(InputError) as caught:
        make_layout(load_scenario(file, ["stations.queue_length=3"]))
    assert str(caught.value) == (
        f"stations.queue_length: found 3, but the queue of station 1 in {tmp_path}/map.txt has 2 cells; "
        "expected at most that many"
    )


def test_a_map_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    """A file that is not there, and one that is no text."""
    file = scenario_with_map(tmp_path, MAP)
    (tmp_path / "map.txt").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"map\.txt: cannot read the map: .*utf-8"):
        make_layout(load_scenario(file))
    (tmp_path / "map.txt").unlink()
    with pytest.raises(InputError, match=r"map\.txt cannot be read: No such file"):
        make_layout(load_scenario(file))


def test_a_map_under_a_name_that_no_file_can_have_is_named(tmp_path: Path) -> None:
    """With the key, as one that is not there."""
    scenario = load_scenario(scenario_with_map(tmp_path, MAP))
    named = evolve(scenario, layout=evolve(scenario.layout, map_file="a\0b"))
    with pytest.raises(InputError, match=r"^layout\.map_file: .* cannot be read: embedded null byte$"):
        make_layout(named)


def test_a_map_without_end_is_read_in_part(tmp_path: Path) -> None:
    """A device that goes on for ever is refused for its size."""
    scenario = load_scenario(scenario_with_map(tmp_path, MAP))
    with pytest.raises(InputError, match=r"^/dev/zero: found a map of [\d,]+ x 1 cells; expected at most 5,000"):
        make_layout(evolve(scenario, layout=evolve(scenario.layout, map_file="/dev/zero")))


LAYOUTS = """
from rmfs_commands.layouts import parse_map

def lane(section, text, queue_length, place):
    return parse_map(text or "####..@@@\\n......qqO\\n####.....", place)

def nothing(section, text, queue_length, place):
    return None

def fails(section, text, queue_length, place):
    raise KeyError(section.block_rows)

def shut(section, text, queue_length, place):
    return parse_map("#@.\\n@qO\\n...", place)
"""
RULES = RulesSection(poa=RuleChoice("first-come"), pps=RuleChoice("demand"))
GENERATORS = {name: f"acme_halls:{name}" for name in ("lane", "nothing", "fails", "shut")}


def test_a_distribution_makes_layouts(install: Callable[..., None]) -> None:
    """Named by a scenario; what it is of stands among the versions; what the map file says is handed to it."""
    install("acme", GENERATORS, group="rmfs.layouts", acme_halls=LAYOUTS)
    scenario = load_scenario("examples/small", ["layout.generator=lane", "robots.count=2", "instance.pods=6"])
    layout = make_layout(scenario)
    assert (layout.width, len(layout.storage_locations), len(layout.stations)) == (9, 8, 1)
    assert make_layout(scenario) is layout
    assert run(scenario).versions["acme"] == "1.0"
    assert make_layout(scenario, "#....\n..qqO\n.....").width == 5


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("line", 'layout.generator: there is no generator "line" (did you mean `lane`?)'),
        ("nothing", 'layout.generator: layout generator "nothing" (acme 1.0) returned None; expected a Layout'),
        ("fails", 'layout.generator: layout generator "fails" (acme 1.0) raised KeyError: 9'),
        (
            "shut",
            "layout: found cells that have no floor beside them, so no pod gets in or out: row 1, column 1",
        ),
        ("text-map", "layout.map_file: expected the text map that the layout generator `text-map` reads"),
    ],
)
def test_a_layout_that_cannot_be_had_is_one_sentence(install: Callable[..., None], name: str, problem: str) -> None:
    install("acme", GENERATORS, group="rmfs.layouts", acme_halls=LAYOUTS)
    with pytest.raises(InputError) as caught:
        make_layout(Scenario(rules=RULES, layout=LayoutSection(generator=name)))
    assert str(caught.value) == problem
