"""`rmfs plan`: the formats of path finding, and trips planned together, by planner and priority, without collisions."""

import csv
import json
import math
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from attrs import define, field
from hypothesis import assume, given
from hypothesis import strategies as st

from bad_rules import write_rule
from calling import exit_code, refusal, refused
from cases import cases
from reserving import EVEN, hold_until
from rmfs_commands.cli.main import main
from rmfs_commands.cli.map_drawing import draw_map
from rmfs_commands.layouts import parse_map
from rmfs_commands.plan import (
    Trip,
    collisions,
    find_planner,
    movingai,
    plan_in_orders,
    plan_jointly,
    plan_trips,
    random_trips,
    read_map,
    read_trips,
    roads_of_map,
)
from rmfs_commands.plan.joint import GROUP, Search
from rmfs_commands.plan.lacam import first_paths
from rmfs_commands.plan.movingai import open_layout
from rmfs_commands.plan.planning import PATIENCE_TICKS, RETRY_TICKS, Plan
from rmfs_commands.testing import small_layout
from rmfs_core.clock import UNREACHABLE
from rmfs_core.decisions import Leg
from rmfs_core.errors import InputError, RunError
from rmfs_core.motion import Motion
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, CellKind
from rmfs_core.world.travel import travel_on
from rmfs_rules.sipp import Sipp
from rmfs_traffic import Query, Reservations, ReservedError, Roads, TimedPath, occupancy, roads_on, timed_path

ROOM = "type octile\nheight 4\nwidth 8\nmap\n........\n.@@..@@.\n........\nTT....OO\n"
SCEN = "version 1\n0\troom.map\t8\t4\t0\t0\t7\t2\t9\n0\troom.map\t8\t4\t7\t2\t0\t2\t9\n"


@pytest.fixture
def room(tmp_path: Path) -> Path:
    (tmp_path / "room.map").write_text(ROOM, encoding="utf-8")
    return tmp_path / "room.map"


def ask(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Run `rmfs plan`; return exit code, output and errors, without the notice of a checkout's first search."""
    code = exit_code("plan", *arguments)
    out, err = capsys.readouterr()
    return code, out, "".join(line for line in err.splitlines(True) if not line.startswith("Compiling searches"))


@pytest.mark.parametrize("pp", ["sipp", pytest.param("whca-n", marks=pytest.mark.slow)])
def test_all_robots_of_a_random_plan_arrive(pp, room, tmp_path, capsys) -> None:
    written = []
    for folder in ("one", "two"):
        out = tmp_path / folder
        code, text, error = ask([str(room), "--agents", "4", "--seed", "3", "--pp", pp, "--out", str(out)], capsys)
        assert (code, error) == (0, "")
        assert "Arrived 4 of 4" in text
        written.append([(out / name).read_bytes() for name in ("plan.json", "paths.csv")])
    assert written[0] == written[1]
    document = json.loads(written[0][0])
    assert (document["costs"]["arrived"], document["collisions"]) == (4, [])
    rows = list(csv.DictReader(written[0][1].decode().splitlines()))
    ends = {row["robot"]: float(row["end_s"]) for row in rows}
    assert sum(ends.values()) == pytest.approx(document["costs"]["sum_of_costs_s"])
    assert max(ends.values()) == document["costs"]["makespan_s"]


def test_trips_of_scenarios_and_maps(room: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    scen = room.with_suffix(".scen")
    scen.write_text(SCEN, encoding="utf-8")
    code, text, _ = ask([str(room), "--scen", str(scen), "--agents", "2"], capsys)
    assert code == 0
    assert "7,2" in text
    code, text, _ = ask([str(room), "--agents", "6", "--pp", "free-flow"], capsys)
    assert code == 0
    assert "First collision: robots" in text
    hit = json.loads(ask([str(room), "--agents", "6", "--pp", "free-flow", "--json"], capsys)[1])["collisions"][0]
    named = f"robots {hit['first']} and {hit['second']} at {hit['cell']} after {hit['since_s']:.3f} s"
    assert f"First collision: {named}\n" in text
    assert hit["first"] > 0
    assert "," in hit["cell"]
    (tmp_path / "hall.txt").write_text(draw_map(small_layout(stations=2)), encoding="utf-8")
    code, text, _ = ask([str(tmp_path / "hall.txt"), "--agents", "20"], capsys)
    assert code == 0
    assert "Arrived 20 of 20" in text


def test_who_finds_no_path_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Two robots cannot pass each other in a corridor: both are named, exit code 1; such a plan has no makespan."""
    (tmp_path / "c.map").write_text("type octile\nheight 1\nwidth 4\nmap\n....\n", encoding="utf-8")
    (tmp_path / "c.scen").write_text("version 1\n0 c.map 4 1 0 0 3 0 3\n0 c.map 4 1 3 0 0 0 3\n", encoding="utf-8")
    asked = [str(tmp_path / "c.map"), "--scen", str(tmp_path / "c.scen"), "--agents", "2"]
    code, text, error = ask(asked, capsys)
    assert code == 1
    assert error == "Error: sipp found no path to the goal for 2 of 2 robots: 1, 2.\n"
    assert "Arrived 0 of 2; makespan -; sum of costs" in text
    assert json.loads(ask([*asked, "--json"], capsys)[1])["costs"]["makespan_s"] is None


def test_maps_and_trips_that_cannot_be_planned_are_one_sentence(room, tmp_path, capsys) -> None:
    (tmp_path / "bad.map").write_text("type octile\nheight 1\nwidth 2\nmap\n..\n", encoding="utf-8")
    scen = room.with_suffix(".scen")
    scen.write_text("version 1\n0 room.map 8 4 0 0 1 0 1\n0 room.map 8 4 0 0 2 0 1\n", encoding="utf-8")
    taken = "room.scen: robots 1 and 2 have the same start, row 1, column 1"
    for arguments, problem in (
        ([str(tmp_path / "bad.map")], "bad.map: found starts and goals for 1 robot"),
        ([str(room), "--scen", str(scen), "--agents", "2"], taken),
    ):
        code, _, error = ask(arguments, capsys)
        assert (code, error.count("\n")) == (2, 1)
        assert error.startswith(f"Error: {tmp_path}/{problem}")


@cases(
    "arguments problem",
    (["--pp", "sip"], '--pp sip: there is no rule "sip"'),
    (["--pp", "demand"], "decides PPS; expected a rule for PP"),
    (["--pp", "whca-n", "--set", "window=3"], "--set window=3: rule"),
    (["--pp", "whca-n", "--set", "window_s=-3"], "expected a number > 0"),
    (["--set", "a.b=3"], "--set a.b=3: expected a parameter of the rule"),
    (["--agents", "50"], "found starts and goals for"),
)
def test_wrong_options_are_refused(arguments, problem, room, capsys) -> None:
    assert problem in refused(capsys, main, ["plan", str(room), *arguments])


def test_an_interrupted_search_leaves_no_folder(room, tmp_path, capsys, monkeypatch) -> None:
    def interrupted(*_: object) -> None:
        assert (tmp_path / "out").is_dir()
        raise KeyboardInterrupt

    monkeypatch.setattr("rmfs_commands.plan.plan_jointly", interrupted)
    assert ask([str(room), "--agents", "2", "--out", str(tmp_path / "out")], capsys)[0] == 130
    assert not (tmp_path / "out").exists()


def test_where_the_files_cannot_go_is_said_before_the_search(room, tmp_path, capsys, monkeypatch) -> None:
    monkeypatch.setattr("rmfs_commands.plan.plan_jointly", lambda *_: pytest.fail("the search began"))
    (tmp_path / "taken" / "paths.csv").mkdir(parents=True)
    in_the_way = f"{room}/out: found a file; expected a folder, or a new name"
    for out, problem in (
        (room / "out", in_the_way),
        (tmp_path / "taken", f"{tmp_path}/taken/paths.csv: cannot be written: a folder has that name"),
    ):
        assert ask([str(room), "--agents", "2", "--out", str(out)], capsys) == (2, "", f"Error: {problem}\n")


@cases(
    "reserves problem code",
    ("windows", " a path that hits a reservation: robot ", 1),
    ("window", "has reserves = 'window'; expected 'fleet', 'full paths', 'windows' or None", 2),
)
def test_a_rule_that_heeds_nobody_is_named(reserves, problem, code, room, capsys, monkeypatch) -> None:
    body = "return Path(warehouse.travel.fastest_path(robot.cell, robot.heading, goal, loaded=False))"
    mine = write_rule(room.parent, "pp", f"{body}\n    reserves = {reserves!r}")
    monkeypatch.chdir(room.parent)
    found, _, error = ask([room.name, "--pp", mine], capsys)
    assert (found, error.count("\n")) == (code, 1)
    assert problem in error


def test_json(room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, text, _ = ask([str(room), "--agents", "3", "--pp", "free-flow", "--out", str(tmp_path), "--json"], capsys)
    assert code == 0
    document = json.loads(text)
    trips = document.pop("trips")
    assert document == json.loads((tmp_path / "plan.json").read_text(encoding="utf-8"))
    assert [trip["robot"] for trip in trips] == [1, 2, 3]
    assert sum(trip["arrives_s"] for trip in trips) == pytest.approx(document["costs"]["sum_of_costs_s"])


def test_a_map_is_floor_and_walls(room: Path) -> None:
    room.write_text(ROOM.replace("........\nTT", "...G.S..\nTT"), encoding="utf-8")
    layout = read_map(room)
    assert (layout.width, layout.height, layout.stations) == (8, 4, ())
    assert [int(cell) for cell in np.flatnonzero(layout.kind == CellKind.WALL)] == [9, 10, 13, 14, 24, 25, 30, 31]
    assert set(layout.kind.tolist()) == {CellKind.WALL, CellKind.FLOOR}
    assert (layout.moves[0], layout.moves[7]) == (1 << EAST | 1 << SOUTH, 1 << WEST | 1 << SOUTH)
    assert layout.moves[26] == 1 << EAST | 1 << NORTH
    assert layout.moves[11] == 1 << EAST | 1 << NORTH | 1 << SOUTH
    assert not layout.moves[9]


def test_maps_of_both_kinds(tmp_path: Path) -> None:
    free = np.random.default_rng(1).random((6, 9)) < 0.7
    layout = open_layout(free)
    for cell in range(54):
        for heading, step in ((EAST, 1), (NORTH, -9), (WEST, -1), (SOUTH, 9)):
            if layout.may_step(cell, heading):
                assert layout.may_step(cell + step, (heading + 2) % 4)
                assert free.flat[cell]
                assert free.flat[cell + step]
    given, hall = small_layout(stations=2), tmp_path / "hall.txt"
    hall.write_text(draw_map(given), encoding="utf-8")
    layout = read_map(hall)
    assert (layout.storage_locations, layout.stations) == (given.storage_locations, given.stations)


@cases(
    "text problem",
    ("type octile\nheight x\nwidth 8\nmap\n", ": expected a line `height N`, N from 1 to 5,000, found 'x'"),
    ("type octile\nwidth 8\nmap\n", ": expected a line `height N`, N from 1 to 5,000, found ''"),
    ("type octile\nheight 0\nwidth 8\nmap\n", ": expected a line `height N`, N from 1 to 5,000, found '0'"),
    (f"type octile\nheight {'9' * 5000}\nmap\n", f": expected a line `height N`, N from 1 to 5,000, found '{'9' * 79}"),
    ("type octile\nheight 1\nwidth 9999\nmap\n", ": expected a line `width N`, N from 1 to 5,000, found '9999'"),
    (
        "type octile\nheight 4000\nwidth 4000\nmap\n",
        ": found a map of 4,000 x 4,000 cells; expected at most 5,000 in a row or column and 4,000,000 in all",
    ),
    ("type octile\nheight 1\nwidth 8\n....", ", line 4: expected the line `map` after type, height and width"),
    ("type octile\nheight 2\nwidth 2\nmap\n..\n", ": found 1 row of the map; expected 2, as its height says"),
    ("type octile\nheight 1\nwidth 3\nmap\n..\n", ", line 5: found 2 cells; expected 3, the map's width"),
    ("type octile\nheight 1\nwidth 2\nmap\n.x\n", ", line 5: unknown sign 'x'; expected one of . G S @ O T W"),
    ("", ": the map is empty; expected rows of characters such as `#` and `.`"),
)
def test_wrong_maps_are_refused(text: str, problem: str, room: Path) -> None:
    room.write_text(text, encoding="utf-8")
    assert refusal(lambda: read_map(room)) == f"{room}{problem}"


def test_trips_are_read_in_order(room: Path, tmp_path: Path) -> None:
    layout, scen = read_map(room), tmp_path / "room.scen"
    scen.write_text(SCEN.replace("0\troom.map\t8\t4\t7", "\n0\tmy room.map\t8\t4\t7"), encoding="utf-8")
    assert read_trips(scen, layout) == read_trips(scen, layout, 2) == (Trip(0, 23), Trip(23, 16))
    assert read_trips(scen, layout, 1) == (Trip(0, 23),)
    scen.write_text("version 1.0\n0 room.map 8 4 1 0 2 0 1\n", encoding="utf-8")
    assert read_trips(scen, layout) == (Trip(1, 2),)


@cases(
    "text problem",
    ("", ", line 1: expected the line `version 1`, as in MovingAI's scenarios"),
    ("version 1\n", ": found 0 trips; expected at least 2, one for each robot"),
    ("version 1\n0 room.map 8 4 0\n", ", line 2: found 5 fields; expected bucket, map, width, height, start x"),
    ("version 1\n0 room.map 9 4 0 0 1 0 1\n", ", line 2: found a map of 9 x 4 cells; the map given has 8 x 4"),
    ("version 1\n0 room.map 8 4 0 0 8 0 1\n", ", line 2: found the cell x 8, y 0, which is not on the map"),
    ("version 1\n\n0 room.map 8 4 0 0 1 1 1\n", ", line 3: found the cell x 1, y 1, which is a wall"),
    ("version 1\n0 room.map 8 4 0 0 -1 0 1\n", ", line 2: expected a whole number from 0 to 5,000, found '-1'"),
    ("version 1\n0 room.map 9999 4 0 0 1 0 1\n", ", line 2: expected a whole number from 0 to 5,000, found '9999'"),
)
def test_wrong_scenarios_are_refused(text: str, problem: str, room: Path) -> None:
    scen = room.with_suffix(".scen")
    scen.write_text(text, encoding="utf-8")
    assert refusal(lambda: read_trips(scen, read_map(room), 2)).startswith(f"{scen}{problem}")


def test_files_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, problem in (("none.map", "No such file or directory"), (".", "Is a directory")):
        with pytest.raises(InputError, match=f"cannot be read: {problem}"):
            read_map(tmp_path / name)
    (tmp_path / "latin.map").write_bytes(b"type \xff")
    with pytest.raises(InputError, match="cannot be read: it is no UTF-8 text"):
        read_map(tmp_path / "latin.map")
    monkeypatch.setattr(movingai, "MOST_SIGNS", 1000)
    with pytest.raises(InputError, match=r"^/dev/zero: found more than 1,000 signs; expected at most that many"):
        read_map("/dev/zero")


CORRIDOR = roads_on(travel_on(parse_map("....", "corridor"), EVEN))
HALL = roads_on(travel_on(parse_map("....\n....", "hall"), EVEN))


@define
class Scripted:
    """A planner that answers as told, and notes what it was asked."""

    answer: Callable[[Query], TimedPath | None]
    queries: list[Query] = field(factory=list)

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        self.queries.append(query)
        return self.answer(query)


def straight(roads: Roads, query: Query, to: int) -> TimedPath:
    return timed_path(roads, query, (Leg(to),))


def test_trips_alone_and_in_order() -> None:
    plan, still = plan_trips(HALL, Sipp(), [Trip(0, 3), Trip(4, 4)])
    assert (plan.path.start_tick, plan.path.heading, plan.path.end, plan.path.end_tick) == (0, NORTH, 3, 4000)
    assert (plan.arrived, plan.fastest_ticks, plan.delay_ticks, plan.queries) == (True, 4000, 0, 1)
    assert (still.arrived, still.path.legs, still.fastest_ticks) == (True, (), 0)
    first, second = plan_trips(HALL, Sipp(), [Trip(0, 3), Trip(5, 1)])
    assert first.delay_ticks == 0
    assert second.delay_ticks > 0
    assert second.path.end_tick == second.fastest_ticks + second.delay_ticks
    assert collisions(HALL, [first.path, second.path]) == ()


def test_who_finds_no_path() -> None:
    behind, ahead = plan_trips(CORRIDOR, Sipp(), [Trip(0, 1), Trip(1, 3)])
    assert behind.arrived
    assert ahead.arrived
    assert (behind.queries, ahead.queries) == (2, 1)
    plans = plan_trips(CORRIDOR, Sipp(), [Trip(0, 3), Trip(3, 0)])
    assert [(plan.arrived, plan.path.end) for plan in plans] == [(False, 0), (False, 3)]
    assert all(PATIENCE_TICKS <= plan.path.end_tick <= PATIENCE_TICKS + 2 * RETRY_TICKS for plan in plans)


def test_paths_that_end_early() -> None:
    planner = Scripted(lambda query: straight(CORRIDOR, query, query.cell + 1))
    (plan,) = plan_trips(CORRIDOR, planner, [Trip(0, 3)])
    asked = [(query.cell, query.heading, query.start_tick) for query in planner.queries]
    assert asked == [(0, NORTH, 0), (1, 0, 2000), (2, 0, 3000)]
    assert (plan.arrived, plan.queries, [leg.to for leg in plan.path.legs]) == (True, 3, [1, 2, 3])
    planner = Scripted(
        lambda query: straight(CORRIDOR, query, 3) if query.start_tick else timed_path(CORRIDOR, query, ())
    )
    (plan,) = plan_trips(CORRIDOR, planner, [Trip(0, 3)])
    assert plan.arrived
    assert plan.path.legs[0] == Leg(0, RETRY_TICKS)
    assert plan.path.end_tick == RETRY_TICKS + 4000


@pytest.mark.parametrize(("effort", "arrived"), [(0, [False, False]), (1000, [True, True])])
def test_other_orders_are_tried_while_robots_are_lost(effort: int, arrived: list[bool]) -> None:
    orders: list[bool] = []  # whether the robot from cell 3 was asked first

    def answer(query: Query) -> TimedPath | None:
        if query.start_tick == 0 and query.robot == 0:
            orders.append(query.cell == 3)
        return straight(CORRIDOR, query, query.goal) if orders[-1] else None

    plans = plan_in_orders(CORRIDOR, Scripted(answer), [Trip(0, 1), Trip(3, 2)], effort, np.random.default_rng(1))
    assert [plan.arrived for plan in plans] == arrived
    assert [plan.trip for plan in plans] == [Trip(0, 1), Trip(3, 2)]


ROADS = roads_of_map(parse_map("......\n......", "hall"))


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def test_an_impossible_path_of_a_rule_is_an_error(room: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wild = write_rule(room.parent, "pp", "return Path((Leg(goal),))")
    roads = roads_of_map(read_map(room))
    monkeypatch.chdir(room.parent)
    planner = find_planner(wild, {}, rng())
    with pytest.raises(RunError, match=r"Bad.* gave robot 1 \(id 0\) an impossible path: .* is no straight run"):
        planner.search(roads, Reservations(roads.cells), Query(0, 0, 0, 0, 23))


@pytest.mark.parametrize(("name", "exclusive"), [("sipp", True), ("whca-n", True), ("free-flow", False)])
def test_planners_keep_clear_of_others_or_do_not(name: str, exclusive: bool) -> None:
    planner = find_planner(name, {}, rng())
    table = Reservations(ROADS.cells)
    hold_until(table, 1, 2, 0, 30_000)
    hold_until(table, 1, 8, 0, 30_000)
    query = Query(0, 0, EAST, 500, 5)
    path = planner.search(ROADS, table, query)
    assert planner.exclusive is exclusive
    alone = 500 + ROADS.travel.ticks(0, EAST, 5, False)
    assert (path.end_tick == alone) == (not exclusive)
    assert planner.search(ROADS, Reservations(ROADS.cells), query).end_tick == alone


def test_answers_of_planners() -> None:
    table = Reservations(ROADS.cells)
    table.hold(1, 2, 0)
    table.hold(1, 8, 0)
    assert find_planner("sipp", {}, rng()).search(ROADS, table, Query(0, 0, EAST, 0, 5)) is None
    planner, table, query = find_planner("pbs", {}, rng()), Reservations(ROADS.cells), Query(0, 0, EAST, 0, 5)
    assert planner.complete
    assert planner.search(ROADS, table, query) == find_planner("sipp", {}, rng()).search(ROADS, table, query)
    table.hold(1, 2, 0)
    table.hold(1, 8, 0)
    assert planner.search(ROADS, table, query) is None
    for name in ("free-flow", "sipp", "pbs"):
        path = find_planner(name, {}, rng()).search(ROADS, Reservations(ROADS.cells), Query(0, 3, EAST, 700, 3))
        assert (path.legs, path.end, path.end_tick) == ((), 3, 700)


@define
class Counting:
    asked: int = 0
    sipp: Sipp = field(factory=Sipp)

    def search(self, roads: Roads, table: Reservations, query: Query) -> TimedPath | None:
        self.asked += 1
        return self.sipp.search(roads, table, query)


def shelves(folder: Path, across: int, down: int) -> Roads:
    """Return a hall of shelves, 5 cells by 2, with aisles one cell wide between them and two more at either side."""
    free, shelf = "." * (6 * across + 3), ".." + "@@@@@." * across + "."
    rows = [free, *[shelf, shelf, free] * down]
    text = f"type octile\nheight {len(rows)}\nwidth {len(free)}\nmap\n" + "\n".join(rows)
    (folder / "shelves.map").write_text(text, encoding="utf-8")
    return roads_of_map(read_map(folder / "shelves.map"))


def searched(roads: Roads, trips: tuple[Trip, ...], effort: int = 20) -> tuple[Plan, ...]:
    return plan_jointly(roads, Sipp(), trips, effort, np.random.default_rng(1))


def sum_of_costs(plans: tuple[Plan, ...]) -> int:
    return sum(plan.path.end_tick for plan in plans)


@given(robots=st.integers(2, 4), seed=st.integers(0, 10_000))
def test_all_arrive_wherever_they_can_one_move_after_another(robots: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    roads = roads_of_map(open_layout(rng.random((3, 4)) < 0.7))
    cells = np.flatnonzero(roads.layout.kind == CellKind.FLOOR)
    assume(len(cells) >= robots)
    starts, goals = (tuple(rng.permutation(cells)[:robots].tolist()) for _ in range(2))
    reached, waiting = {starts}, [starts]
    for here in waiting:
        for robot, cell in enumerate(here):
            for heading, to in roads.layout.beside(cell):
                there = (*here[:robot], to, *here[robot + 1 :])
                if roads.layout.may_step(cell, heading) and to not in here and there not in reached:
                    reached.add(there)
                    waiting.append(there)
    plans = searched(roads, tuple(map(Trip, starts, goals)))
    assert all(plan.arrived for plan in plans) == (goals in reached)
    assert collisions(roads, [plan.path for plan in plans]) == ()


def test_first_paths_of_robots_on_a_third_of_all_cells(tmp_path: Path) -> None:
    roads = shelves(tmp_path, across=9, down=10)
    trips = random_trips(roads, 300, 1, "shelves")
    paths = first_paths(roads, trips, 1000, np.random.default_rng(1))
    assert [path.end for path in paths] == [trip.goal for trip in trips]
    assert collisions(roads, paths) == ()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_sum_of_costs_is_below_the_best_of_twenty_orders(seed: int, tmp_path: Path) -> None:
    roads = shelves(tmp_path, across=3, down=6)
    trips = random_trips(roads, 20, seed, "shelves")
    rng = np.random.default_rng(seed)
    orders = [plan_trips(roads, Sipp(), rng.permutation(np.array(trips, dtype=object)).tolist()) for _ in range(20)]
    best = min(sum_of_costs(plans) for plans in orders if all(plan.arrived for plan in plans))
    plans = searched(roads, trips)
    assert all(plan.arrived for plan in plans)
    assert sum(plan.fastest_ticks for plan in plans) <= sum_of_costs(plans) < best


@pytest.mark.parametrize("seed", [1, 2])
def test_all_arrive_where_one_order_loses_most_and_none_would_earlier_alone(seed: int, tmp_path: Path) -> None:
    roads = shelves(tmp_path, across=3, down=6)
    trips = random_trips(roads, 50, seed, "shelves")
    assert sum(plan.arrived for plan in plan_trips(roads, Sipp(), trips)) < 25
    plans = searched(roads, trips)
    assert [plan.path.end for plan in plans] == [trip.goal for trip in trips]
    assert collisions(roads, [plan.path for plan in plans]) == ()
    for robot, plan in enumerate(plans):
        table = Reservations(roads.cells)
        for other, its in enumerate(plans):
            if other != robot:
                table.commit(other, occupancy(roads, its.path))
        found = Sipp().search(roads, table, Query(robot, plan.trip.start, NORTH, 0, plan.trip.goal))
        assert found.end_tick == plan.path.end_tick


def test_effort_is_spent_on_groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Search, "shorten_alone", lambda *_: None)  # which is not limited
    roads = shelves(tmp_path, across=3, down=3)
    planner = Counting()
    plans = plan_jointly(roads, planner, random_trips(roads, 15, 2, "shelves"), 5, np.random.default_rng(1))
    assert 75 <= planner.asked < 75 + GROUP
    assert sum(plan.queries for plan in plans) == planner.asked


def test_where_not_all_can_arrive_all_others_do() -> None:
    corridor = roads_on(travel_on(parse_map("......@...\n@@@@@@@...", "corridor"), EVEN))
    trips = (Trip(0, 1), Trip(2, 5), Trip(5, 2), Trip(7, 9), Trip(9, 7), Trip(8, 3))
    plans = searched(corridor, trips)
    assert [plan.arrived for plan in plans] == [True, False, False, True, True, False]
    assert collisions(corridor, [plan.path for plan in plans]) == ()


STORAGE_HALL = roads_of_map(small_layout(stations=2))
HALVES = roads_of_map(parse_map("..@..\n..@..", "halves"))


@given(robots=st.integers(1, len(STORAGE_HALL.layout.storage_locations) // 2), seed=st.integers(0, 10_000))
def test_trips_join_storage_locations(robots: int, seed: int) -> None:
    trips = random_trips(STORAGE_HALL, robots, seed, "hall")
    places = [place for trip in trips for place in (trip.start, trip.goal)]
    assert (len(trips), len(set(places))) == (robots, 2 * robots)
    assert {int(STORAGE_HALL.layout.kind[place]) for place in places} == {CellKind.STORAGE}
    assert trips == random_trips(STORAGE_HALL, robots, seed, "elsewhere")


def test_floor_is_used_where_storage_locations_are_too_few() -> None:
    robots = len(STORAGE_HALL.layout.storage_locations) // 2 + 1
    trips = random_trips(STORAGE_HALL, robots, 1, "hall")
    kinds = {int(STORAGE_HALL.layout.kind[place]) for trip in trips for place in (trip.start, trip.goal)}
    assert kinds == {CellKind.STORAGE, CellKind.FLOOR}


@given(st.integers(0, 10_000))
def test_a_goal_is_in_reach(seed: int) -> None:
    for trip in random_trips(HALVES, 4, seed, "halves"):
        assert HALVES.travel.ticks(trip.start, 1, trip.goal, False) < UNREACHABLE
        assert (trip.start % 5 < 2) == (trip.goal % 5 < 2)


@pytest.mark.parametrize(("text", "found"), [("..@..\n..@..", 4), (".@.\n", 0)])
def test_a_map_that_is_too_small_is_refused(text: str, found: int) -> None:
    said = refusal(lambda: random_trips(roads_of_map(parse_map(text, "map")), 5, 1, "my.map"))
    assert said == f"my.map: found starts and goals for {found} robots; expected 5"


LONG_EVEN = roads_on(travel_on(ROADS.layout, Motion(acceleration_m_per_s2=1e12, top_speed_m_per_s=1.0)))
"""A robot has the cell it leaves until a second after, when it stands in the next one."""


def drive(cell: int, *legs: Leg, heading: int = EAST, roads: Roads = ROADS) -> TimedPath:
    return timed_path(roads, Query(0, cell, heading, 0, legs[-1].to), legs)


even = partial(drive, roads=LONG_EVEN)


def test_collisions_are_found() -> None:
    first = drive(0, Leg(5))
    assert collisions(ROADS, [first, drive(6, Leg(11))]) == ()
    assert {hit.cell for hit in collisions(ROADS, [first, drive(5, Leg(0), heading=WEST)])} == {2, 3}
    assert [hit.cell for hit in collisions(ROADS, [first, drive(5, Leg(5, 1000))])] == [5]
    assert collisions(ROADS, [drive(1, Leg(5)), drive(0, Leg(4, 500))])
    assert collisions(ROADS, [drive(1, Leg(5)), drive(0, Leg(4, 2100))]) == ()
    (hit,) = collisions(LONG_EVEN, [even(5, Leg(5)), even(0, Leg(5))])
    assert (hit.cell, hit.first, hit.second) == (5, 0, 1)
    assert (hit.since_s, hit.until_s) == (pytest.approx(4), math.inf)
    (hit,) = collisions(LONG_EVEN, [even(0, Leg(5)), even(9, Leg(3, 2500), Leg(9), heading=NORTH)])
    assert (hit.cell, hit.first, hit.second) == (3, 0, 1)
    assert (hit.since_s, hit.until_s) == (pytest.approx(2.5), pytest.approx(4))
    assert collisions(LONG_EVEN, [even(2, Leg(5)), even(0, Leg(3))]) == ()
    late = even(2, Leg(5, 100))
    assert {hit.cell for hit in collisions(LONG_EVEN, [late, even(0, Leg(3))])} == {2, 3}
    hits = collisions(
        LONG_EVEN, [even(0, Leg(5)), even(5, Leg(5)), even(7, Leg(1), heading=NORTH), even(9, Leg(3), heading=NORTH)]
    )
    assert [hit.since_s for hit in hits] == sorted(hit.since_s for hit in hits)
    assert {hit.second for hit in hits if hit.first == 0} == {1, 2, 3}
    south, after = even(0, Leg(2), Leg(8)), even(3, Leg(2, 2000), heading=WEST)
    assert [hit.cell for hit in collisions(LONG_EVEN, [south, after])] == [2]
    assert south.end_heading == SOUTH


@pytest.mark.parametrize("seed", range(6))
def test_they_agree_with_the_reservation_table(seed: int) -> None:
    roads = roads_of_map(small_layout())
    rng = np.random.default_rng(seed)
    cells = roads.layout.storage_locations
    planner = find_planner("free-flow", {}, rng)
    starts = rng.permutation(cells)[:3]
    goals = rng.permutation([cell for cell in cells if cell not in starts])[:3]
    trips = [Trip(int(a), int(b)) for a, b in zip(starts, goals, strict=True)]
    paths = [plan.path for plan in plan_trips(roads, planner, trips, exclusive=False)]
    table, refused = Reservations(roads.cells), False
    for robot, path in enumerate(paths):
        try:
            table.commit(robot, occupancy(roads, path))
        except ReservedError:
            refused = True
    assert bool(collisions(roads, paths)) == refused


def test_a_page_shows_the_plan(tmp_path: Path) -> None:
    (tmp_path / "hall.map").write_text("......\n......\n", encoding="utf-8")
    trips = "version 1\n0\thall.map\t6\t2\t0\t0\t5\t1\t6\n0\thall.map\t6\t2\t5\t0\t0\t1\t6\n"
    (tmp_path / "two.scen").write_text(trips, encoding="utf-8")
    file = tmp_path / "plan.html"
    arguments = ("--agents", "2", "--scen", str(tmp_path / "two.scen"), "--html", str(file))
    assert exit_code("plan", str(tmp_path / "hall.map"), *arguments) == 0
    page = file.read_text(encoding="utf-8")
    assert "2 of 2 robots arrive; collisions: 0." in page
    assert "Not simulated" not in page
    assert page.count("<polyline") == page.count("<title>robot ") == 2
    (across, down, *_) = re.findall(r'<animate attributeName="c[xy]"[^>]* values="([^"]*)"', page)
    assert [text.split(";")[0] for text in (across, down)] == ["0.5", "0.5"]
    assert [text.split(";")[-1] for text in (across, down)] == ["5.5", "1.5"]
