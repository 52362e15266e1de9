"""Due times of orders that go with trucks."""

import re
from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
from calling import exit_code
from cases import cases
from rmfs_commands.details.loading import load_result
from rmfs_commands.instances.departures import trucks_of
from rmfs_commands.trace.reader import read_trace
from rmfs_commands.validation.checking import validate_trace
from rmfs_commands.validation.validator import faults_of
from rmfs_core import InputError
from rmfs_core.scenario import load_scenario
from rmfs_core.scenario.model import Departures
from rmfs_core.world import make_instance

HOUR = 3_600_000
ORDERS = """order,arrival,sku,quantity,carrier
A,2024-03-01T08:00,X,1,north
A,2024-03-01T08:00,Y,1,north
B,2024-03-01T09:45,X,1,south
C,2024-03-01T09:50,X,1,south
D,2024-03-01T23:00,X,1,north
E,2024-03-01T09:00,X,1,
"""
ROUTES = '[instance.departures]\ntimes = { north = ["12:00", "09:00"], south = ["10:00", 9000] }\ncolumn = "carrier"\n'
LIST = "[instance.departures]\ntimes = [{}]\n"
FILES = '[instance]\norders_file = "orders.csv"\npods_file = "pods.csv"\nstart = "2024-03-01T08:00"\n'
RULES = '[rules]\npoa = { rule = "pod-match", tie_break = "due" }\npps = "demand"\npp = "free-flow"\n'


def write(folder: Path, departures: str = ROUTES, orders: str = ORDERS) -> Path:
    (folder / "orders.csv").write_text(orders, encoding="utf-8")
    (folder / "pods.csv").write_text("pod,sku,quantity\n1,X,\n2,Y,\n", encoding="utf-8")
    (folder / "day.toml").write_text(FILES + departures + RULES, encoding="utf-8")
    return folder / "day.toml"


SIX = {"A": 2, "B": 2, "C": 2, "D": 25.5, "E": 2}


@cases(
    "departures expected",
    (ROUTES, {"A": 1, "B": 2, "C": 2, "D": 25, "E": None}),  # E has no route, and is never due
    (ROUTES + "cutoff_s = 600", {"A": 1, "B": 2, "C": 2, "D": 25, "E": None}),  # C arrives at the very cut-off
    (ROUTES + "cutoff_s = 601", {"A": 1, "B": 2, "C": 2.5, "D": 25, "E": None}),  # 9000 s is half past ten, once
    (ROUTES + "cutoff_s = 3600.001", {"A": 4, "B": 26, "C": 26, "D": 25, "E": None}),  # trucks of the next day
    (LIST.format('"10:00", 91800'), SIX),  # without routes every order goes with the next truck
)
def test_an_order_goes_with_the_first_truck_of_its_route(tmp_path, departures, expected) -> None:
    orders = make_instance(load_scenario(write(tmp_path, departures + "\n"))).orders
    due = {order.name: None if order.due_tick is None else order.due_tick / HOUR for order in orders}
    assert due == expected
    for order in make_instance(load_scenario(write(tmp_path), ["instance.scale.by=3"])).orders:  # drawn anew
        assert order.due_tick is None or 0 <= order.due_tick - order.arrival_tick <= 24 * HOUR


def test_a_truck_at_the_very_arrival_takes_the_order_and_nothing_leaves_before_it() -> None:
    trucks = trucks_of(Departures(times=("00:30", 50.0, 0)), zero=HOUR)[None]
    assert [trucks.first(tick) for tick in (0, 1, 50_000, 50_001)] == [0, 50_000, 50_000, int(23.5 * HOUR)]


def test_results_and_checks_know_due_times_of_trucks(tmp_path: Path) -> None:
    result = rmfs_core.run(write(tmp_path), out=tmp_path / "out", record=["trace"])
    assert validate_trace(tmp_path / "out") == []
    trace = read_trace(tmp_path / "out" / "trace.jsonl.gz")
    first, *others = trace.instance.orders
    wrong = evolve(trace.instance, orders=(evolve(first, due_tick=2 * HOUR), *others))  # an hour after its truck
    assert "the orders are others than the scenario makes" in faults_of(evolve(trace, instance=wrong))[0].sentence
    assert load_result(tmp_path / "out").orders == result.orders
    rows = {row["order"]: (row["due_s"], row["route"]) for row in result.orders}
    assert (rows["B"], rows["E"]) == ((7200.0, "south"), (None, ""))


NEEDS = 'expected times of the day such as "14:00", or seconds from 0 to ten years, found '


@cases(
    "departures problem",
    (LIST.format(-1), NEEDS + "-1.0"),
    (LIST.format('"24:01"'), NEEDS + "'24:01'"),
    (LIST.format(""), 'found no time; expected at least one, such as "14:00"'),
    (LIST.format("30000"), "order D arrives at 54,000 s, and no truck leaves after that; expected a later one"),
    (LIST.format("0") + "cutoff_s = -5\n", "expected a number from 0 to 1e+07, found -5.0"),
    ("[instance.departures]\ntimes = {}\n", "found no route; expected at least one"),
    (ROUTES.replace("column", "#"), "found routes, but no order has one; expected `column`"),
    (ROUTES.replace("column", "#") + "[instance.scale]\nby = 2\n", "found routes, but no order has one; expected `col"),
    (ROUTES.replace("carrier", "carier"), "without `carier`"),
    (ROUTES.replace("carrier", "sku"), "found `sku`, which has another meaning; expected a column of routes"),
    (ROUTES.replace("south =", "sauth ="), "found south, which `instance.departures.times` has not (did you mean"),
    (LIST.format('"09:00"') + 'column = "carrier"\n', "expected a table of routes with `column`"),
)
def test_wrong_departures_are_refused_in_a_sentence(tmp_path: Path, departures: str, problem: str) -> None:
    with pytest.raises(InputError) as error:
        make_instance(load_scenario(write(tmp_path, departures)))
    assert problem in error.value.problem
    assert str(tmp_path) in error.value.place


def test_a_day_that_is_drawn_may_have_no_order_with_a_route(tmp_path: Path) -> None:
    scenario = load_scenario(write(tmp_path, orders=ORDERS.replace("north", "").replace("south", "")))
    with pytest.raises(InputError, match="no order has one; expected some in `carrier`"):
        make_instance(scenario)
    orders = make_instance(load_scenario(write(tmp_path), ["instance.scale.by=0.5", "seed=2"])).orders
    assert [(order.name, order.due_tick) for order in orders] == [("E", None)]


@cases(
    "override problem",
    ("instance.due.allowance_s=9", "found a due time of order 1, too; expected one of them"),
    ('instance.arrivals={process="refill",backlog=3}', 'expected none with arrivals of process "refill"'),
    ('instance.departures.column="x"', "expected it with `instance.orders_file`, where that column is"),
)
def test_what_does_not_go_with_generated_orders(override: str, problem: str) -> None:
    with pytest.raises(InputError, match=re.escape(problem)):
        make_instance(load_scenario("examples/small", ['instance.departures.times=["10:00"]', override]))


@cases(
    "departures overrides", (ROUTES, ()), (LIST.format('"09:00"'), ()), (ROUTES, ("instance.scale.by=0.5", "seed=2"))
)
def test_a_scenario_that_is_written_keeps_its_trucks(
    tmp_path: Path, departures: str, overrides: tuple[str, ...]
) -> None:
    day = write(tmp_path, departures)
    chosen = [text for one in overrides for text in ("--set", one)]
    assert exit_code("generate", str(day), *chosen, "--out", str(tmp_path / "new")) == 0
    before, after = load_scenario(day, list(overrides)), load_scenario(tmp_path / "new" / "scenario.toml")
    assert make_instance(after) == make_instance(before)
    assert after.instance.departures == (None if overrides else before.instance.departures)
