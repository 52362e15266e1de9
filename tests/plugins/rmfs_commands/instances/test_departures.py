"""Due times of orders that go with trucks."""

from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
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
SCENARIO = """
[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"
start = "2024-03-01T08:00"
{departures}
[layout]
block_rows = 3
block_columns = 2
stations_east = 1
[robots]
count = 2
[rules]
poa = "pod-match"
pps = "demand"
"""
ROUTES = '[instance.departures]\ntimes = { north = ["12:00", "09:00"], south = ["10:00", 9000] }\ncolumn = "carrier"\n'


def write(folder: Path, departures: str = ROUTES, orders: str = ORDERS) -> Path:
    (folder / "orders.csv").write_text(orders, encoding="utf-8")
    (folder / "pods.csv").write_text("pod,sku,quantity\n1,X,9\n2,Y,9\n", encoding="utf-8")
    (folder / "day.toml").write_text(SCENARIO.format(departures=departures), encoding="utf-8")
    return folder / "day.toml"


def due(file: Path, *overrides: str) -> dict[str, float | None]:
    """Hours from time 0 at which each order is due."""
    orders = make_instance(load_scenario(file, overrides)).orders
    return {order.name: None if order.due_tick is None else order.due_tick / HOUR for order in orders}


@cases(
    "cutoff_s expected",
    (0, {"A": 1, "B": 2, "C": 2, "D": 25, "E": None}),  # E has no route, and is never due
    (600, {"A": 1, "B": 2, "C": 2, "D": 25, "E": None}),  # C arrives at the very cut-off
    (601, {"A": 1, "B": 2, "C": 2.5, "D": 25, "E": None}),  # and then it does not: 9000 s is half past ten, once
    (3600.001, {"A": 4, "B": 26, "C": 26, "D": 25, "E": None}),  # the truck of the next day
)
def test_an_order_goes_with_the_first_truck_of_its_route(
    tmp_path: Path, cutoff_s: float, expected: dict[str, float | None]
) -> None:
    assert due(write(tmp_path), f"instance.departures.cutoff_s={cutoff_s}") == expected


def test_without_routes_every_order_goes_with_the_next_truck(tmp_path: Path) -> None:
    file = write(tmp_path, '[instance.departures]\ntimes = ["09:55", 100000]\n')
    assert due(file) == {"A": 115 / 60, "B": 115 / 60, "C": 115 / 60, "D": 25 + 55 / 60, "E": 115 / 60}


def test_a_truck_at_the_very_arrival_takes_the_order_and_nothing_leaves_before_it() -> None:
    trucks = trucks_of(Departures(times=("00:30", 50.0, 0)), zero=HOUR)[None]
    assert [trucks.first(tick) for tick in (0, 1, 50_000, 50_001)] == [0, 50_000, 50_000, int(23.5 * HOUR)]


def test_orders_that_a_scale_moves_go_with_trucks_of_their_new_times(tmp_path: Path) -> None:
    rows = "".join(f"{i},{60 * i},X,1,north\n" for i in range(40))
    times = '[instance.departures]\ntimes = { north = [300, 1200, 90000] }\ncolumn = "carrier"\n'
    file = write(tmp_path, times, "order,arrival_s,sku,quantity,carrier\n" + rows)
    orders = make_instance(load_scenario(file, ["instance.scale.by=0.2"])).orders
    assert {order.route for order in orders} == {"north"}
    for order in orders:
        assert order.due_tick == min(t for t in (300_000, 1_200_000, 90_000_000) if t >= order.arrival_tick)


def test_results_and_checks_know_due_times_of_trucks(tmp_path: Path) -> None:
    every = ["rules.poa={rule='pod-match',tie_break='due'}", "rules.pp=free-flow"]
    result = rmfs_core.run(write(tmp_path), overrides=every, out=tmp_path / "out", record=["trace"])
    assert validate_trace(tmp_path / "out") == []
    trace = read_trace(tmp_path / "out" / "trace.jsonl.gz")
    first, *others = trace.instance.orders
    wrong = evolve(trace.instance, orders=(evolve(first, due_tick=2 * HOUR), *others))  # an hour after its truck
    assert "the orders are others than the scenario makes" in faults_of(evolve(trace, instance=wrong))[0].sentence
    assert load_result(tmp_path / "out").orders == result.orders
    rows = {row["order"]: (row["due_s"], row["route"]) for row in result.orders}
    assert rows["B"] == (7200.0, "south")
    assert rows["E"] == (None, "")
    assert list(result.orders[0])[-2:] == ["lateness_s", "route"]


SECONDS = "[instance.departures]\ntimes = [{}]\n"
NEEDS = 'expected times of the day such as "14:00", or seconds from 0 to ten years, found '
LATER = "order D arrives at 54,000 s, and no truck leaves after that; expected a later one, or times of the day"


@cases(
    "departures problem",
    (SECONDS.format(-1), NEEDS + "-1.0"),
    (SECONDS.format("1e30"), NEEDS + "1e+30"),
    (SECONDS.format('"24:01"'), NEEDS + "'24:01'"),
    (SECONDS.format(""), 'found no time; expected at least one, such as "14:00"'),
    (SECONDS.format("30000"), LATER),
    (SECONDS.format("0") + "cutoff_s = -5\n", "expected a number from 0 to 1e+07, found -5.0"),
    ("[instance.departures]\ntimes = {}\n", "found no route; expected at least one"),
    (ROUTES.replace("column", "#"), "found routes, but no order has one; expected `column`"),
    (ROUTES.replace("carrier", "carier"), "without `carier`"),
    (ROUTES.replace("carrier", "sku"), "found `sku`, which says something else; expected a column of routes"),
    (
        ROUTES.replace("south =", "sauth ="),
        "found south, which `instance.departures.times` has not (did you mean `sauth`",
    ),
    (
        SECONDS.format('"09:00"') + 'column = "carrier"\n',
        'expected a table of routes with `column` "carrier", found a list',
    ),
)
def test_wrong_departures_are_refused_in_a_sentence(tmp_path: Path, departures: str, problem: str) -> None:
    with pytest.raises(InputError) as error:
        make_instance(load_scenario(write(tmp_path, departures)))
    assert problem in error.value.problem
    assert str(tmp_path) in error.value.place


@cases(
    "overrides problem",
    (["instance.due.allowance_s=9"], "found a due time of order 1 besides; expected the one or the other"),
    (['instance.arrivals={process="refill",backlog=3}'], 'expected none with arrivals of process "refill"'),
    (['instance.departures.column="x"'], "expected it beside `instance.orders_file`, where that column is"),
)
def test_what_does_not_go_with_generated_orders(overrides: list[str], problem: str) -> None:
    with pytest.raises(InputError, match=r"instance\.departures") as error:
        make_instance(load_scenario("examples/small", ['instance.departures.times=["10:00"]', *overrides]))
    assert problem in error.value.problem
