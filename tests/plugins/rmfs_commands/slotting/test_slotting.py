"""`rmfs slot`: the history, placements, the surrogate and its search, changes, and runs of later days."""

import csv
import json
from collections import Counter
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from calling import exit_code, refusal, refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.slotting.changes import Floor, best_changes
from rmfs_commands.slotting.past import Past, read_past
from rmfs_commands.slotting.placing import MADE, Contents, Placer, Stock, driving_s, located
from rmfs_commands.slotting.surrogate import Batches, Shelves
from rmfs_core.scenario import Scenario, load_scenario
from rmfs_core.world import make_layout

PAIRS = (("a", "f"), ("b", "e"), ("c", "d"))
PODS = (("a", "b"), ("c", "a"), ("d", "e"), ("f", "d"))
SCENARIO = """seed = 4
[instance]
orders_file = "orders.csv"
pods_file = "pods.csv"
{instance}
[layout]
block_rows = 4
block_columns = 2
stations_east = 1
[robots]
count = 2
[rules]
poa = "pod-match"
pps = "completes"
{rules}
"""
DAY_S = 86_400


def orders_csv(days: range, *, per_day: int = 6, name: str = "o", column: str = "arrival_s") -> str:
    rows = [f"order,{column},sku,quantity"]
    for day in days:
        for i in range(per_day):
            time: Any = day * DAY_S + 600 * (i + 1)
            time = time if column == "arrival_s" else f"2024-03-{day + 1:02}T00:{10 * i:02}"
            rows += [f"{name}{day}-{i},{time},{sku},1" for sku in PAIRS[i % 3]]
    return "\n".join(rows) + "\n"


def made(folder: Path, orders: str | None = None, pods: str | None = None, instance: str = "", rules: str = "") -> Path:
    stock = "".join(f"P{i},{sku},20\n" for i, pod in enumerate(PODS) for sku in pod)
    (folder / "orders.csv").write_text(orders or orders_csv(range(10)), encoding="utf-8")
    (folder / "pods.csv").write_text(pods or f"pod,sku,quantity\n{stock}", encoding="utf-8")
    file = folder / "day.toml"
    file.write_text(SCENARIO.format(instance=instance, rules=rules), encoding="utf-8")
    return file


def placer_of(file: Path, until: str = str(6 * DAY_S), batch: int = 1) -> tuple[Scenario, Past, Placer]:
    scenario = load_scenario(str(file))
    past = read_past(scenario, None, until, 10)
    return scenario, past, Placer(past, Stock.of(past, scenario), batch, 1)


def totals(contents: Contents) -> Counter[int]:
    found = Counter[int]()
    for sku, items in (one for pod in contents for one in pod):
        found[sku] += items or 0
    return found


def greedy(held: list[list[int]], basket: set[int]) -> int:
    """Pods that a set of SKUs needs, the one with the most of them first: the surrogate in plain Python."""
    visits = 0
    while basket:
        best = max(range(len(held)), key=lambda pod: (len(basket & set(held[pod])), -pod))
        basket, visits = basket - set(held[best]), visits + 1
    return visits


@pytest.mark.parametrize("seed", range(3))
def test_the_surrogate_counts_what_plain_greed_takes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    held = [sorted(rng.choice(12, 4, replace=False).tolist()) for _ in range(9)] + [[sku] for sku in range(12)]
    baskets = [rng.choice(12, rng.integers(1, 5), replace=False).tolist() for _ in range(20)]
    batches = Batches.of(baskets, 3, 12)
    shelves = Shelves.of(held, [[1] * len(pod) for pod in held], 100, 12)
    expected = sum(greedy(held, {sku for one in baskets[i : i + 3] for sku in one}) for i in range(0, 20, 3))
    visits, tally = shelves.visits(batches)
    assert visits == expected / 20
    assert tally.sum() == expected
    for row in shelves.gains(batches, rng.random((50, 6))):
        if row[0]:  # what an exchange is said to save is what it saves
            other = deepcopy(shelves)
            other.exchange(*row[1:].tolist())
            assert round(20 * (visits - other.visits(batches)[0])) == row[0]
    before = Counter(shelves.held.ravel().tolist())
    shelves.search(batches, rng.random((2_000, 6)))
    assert shelves.visits(batches)[0] < visits
    assert Counter(shelves.held.ravel().tolist()) == before
    assert all(len(set(row[row >= 0])) == (row >= 0).sum() for row in shelves.held)


@cases("name capacity", *((name, capacity) for name in MADE for capacity in ("", "pod_capacity = 50")))
def test_placements_keep_items_numbers_of_skus_and_space(tmp_path: Path, name: str, capacity: str) -> None:
    pods = "pod,sku,quantity\nP0,a,30\nP0,b,7\nP1,c,1\nP2,d,40\nP2,a,5\nP2,c,3\nP3,e,9\nP3,f,\n"
    _, past, placer = placer_of(made(tmp_path, pods=pods, instance=capacity))
    now, found = placer.now(), placer.made(name)
    assert found is not None
    better = placer.improved(found, 500)
    for one in (found, better):
        assert totals(one.contents) == totals(now.contents)
        assert all(len(pod) <= len(given) for pod, given in zip(one.contents, now.contents, strict=True))
        assert all(len({sku for sku, _ in pod}) == len(pod) for pod in one.contents)
        assert not capacity or max(sum(items or 0 for _, items in pod) for pod in one.contents) <= 50
        unlimited = [past.instance.skus[sku] for pod in one.contents for sku, items in pod if items is None]
        assert set(unlimited) == {"f"}
    assert better.held_back <= found.held_back


def test_pairs_come_together_and_no_space_is_no_placement(tmp_path: Path) -> None:
    _, _, placer = placer_of(made(tmp_path))
    made_now, together = placer.now(), placer.made("clusters")
    assert together is not None
    assert (made_now.held_back, together.held_back) == (2.0, 1.0)
    assert placer.improved(made_now, 3_000).held_back < 2.0
    stock = Stock(rooms=(2, 2), items=(6, 6, 2, 3), sizes=(1, 1, 2, 1), space=10)
    fitted = stock.fitted([[(0, 6), (1, 6)], [(2, 2), (3, 3)]])
    assert fitted is not None
    assert totals(fitted) == {0: 6, 1: 6, 2: 2, 3: 3}
    assert max(sum(stock.load(*one) for one in pod) for pod in fitted) <= 10
    assert stock.fitted([[(0, 6), (1, 6)], [(2, 2), (3, 5)]]) is None


def test_changes_pay_by_their_driving_and_pods_move_only_where_they_stay(tmp_path: Path) -> None:
    stock = "".join(
        f"P{i},{sku},20,{row},{column}\n"
        for i, (pod, (row, column)) in enumerate(zip(PODS, ((2, 6), (2, 7), (2, 8), (2, 9)), strict=True))
        for sku in pod
    )
    scenario, past, placer = placer_of(made(tmp_path, pods=f"pod,sku,quantity,row,column\n{stock}"))
    layout = make_layout(scenario)
    seconds = driving_s(scenario, layout)
    moved, changes, cells = best_changes(placer, Floor(layout, seconds, 60.0, 10.0, stays=False), 3, 1)
    assert changes
    assert all(one.sku and one.cost_s == 2 * 60 + 10 * one.items for one in changes)
    assert sum(one.saved_s for one in changes) / 60 / 6 == pytest.approx(placer.now().seen - moved.seen)
    assert totals(moved.contents) == totals(placer.now().contents)
    _, staying, after = best_changes(placer, Floor(layout, seconds, 60.0, 1e6, stays=True), 1, 1)
    assert staying[0].sku is None
    assert sorted(after) == sorted(cells)
    assert after != cells
    visits = placer.visits(placer.now())
    way = dict(zip(layout.storage_locations, seconds.tolist(), strict=True))
    placed = located(past.instance.pods, visits, layout, seconds)
    assert sorted(placed) == sorted(cells)
    by_visits = sorted(range(4), key=lambda pod: -visits[pod])
    assert [way[placed[pod]] for pod in by_visits] == sorted(way[cell] for cell in cells)


def test_later_orders_are_days_of_their_own(tmp_path: Path) -> None:
    text = "order,arrival,sku,quantity,due,cancelled\n" + "".join(
        f"{name},{time}+02:00,a,1,{due}+02:00,\n"
        for name, time, due in (
            ("x", "2024-03-01T23:30", "2024-03-02T01:00"),
            ("y", "2024-03-02T00:30", "2024-03-02T02:00"),
            ("z", "2024-03-04T08:00", "2024-03-03T08:00"),
        )
    )
    file = made(tmp_path, text, instance='start = "2024-03-01T06:00+02:00"')
    past = read_past(load_scenario(str(file)), None, "2024-03-01T22:00Z", 10)
    assert [day.name for day in past.later] == ["2024-03-02", "2024-03-04"]
    assert past.later[0].start == "2024-03-02T00:00:00+02:00"
    ((first,), (second,)) = (day.orders for day in past.later)
    assert (first.arrival_tick, first.due_tick) == (1_800_000, 7_200_000)
    assert (second.arrival_tick, second.due_tick) == (28_800_000, 0)
    assert (len(past.baskets), past.days, past.strange) == (1, 1, 0)
    local = read_past(load_scenario(str(file)), None, "2024-03-02T00:00", 10)  # by the clock of time 0
    assert len(local.baskets) == 1
    assert local.later[0].orders == past.later[0].orders


DATED = orders_csv(range(3), column="arrival")


@cases(
    "orders history until said",
    (None, None, "0", "all orders of {}/orders.csv (60) are later than 0; expected a time with orders on both"),
    (None, None, "9000000", "are earlier than 9000000"),
    (None, None, "2024-03-05", "expected seconds from time 0, since the orders have no dates"),
    (DATED, None, "soon", "expected a time in ISO 8601, such as 2024-03-01T06:30"),
    (DATED, None, "2024-03-02T00:00Z", "expected an offset from UTC in all times or"),
    (None, orders_csv(range(1)), None, "past.csv: 6 orders of it are run as well (o0-0, o0-1, o0-2"),
    (None, "order,arrival_s,sku,quantity\n", None, "past.csv: has no order; expected earlier orders of the same SKUs"),
    (None, "", None, "expected a header with the columns order,arrival_s,sku,quantity, found none"),
    (None, "order,arrival_s,sku,quantity\n1,0,zzz,1\n", None, "none of its 1 order has a SKU that stands on a pod"),
    (
        DATED,
        orders_csv(range(1, 2), name="p", column="arrival"),
        None,
        "past.csv: its last order arrives 24.8 hours after",
    ),
    (
        DATED,
        "order,arrival,sku,quantity\np,2024-02-01T00:00Z,a,1\n",
        None,
        "its times have an offset from UTC and those",
    ),
)
def test_what_is_no_history_is_refused(
    tmp_path: Path, orders: str | None, history: str | None, until: str | None, said: str
) -> None:
    file, past = made(tmp_path, orders), tmp_path / "past.csv"
    past.write_text(history or "", encoding="utf-8")
    scenario = load_scenario(str(file))
    found = refusal(lambda: read_past(scenario, None if history is None else past, until, 10))
    assert said.format(tmp_path) in found


@cases(
    "given key",
    ('instance.state_file = "now.json"', "instance.state_file"),
    (
        'instance.replenishment={ process = "file", file = "b.csv" };rules.roa=same-sku;rules.rps=emptiest-pod',
        "instance.replenishment.file",
    ),
    ("instance.departures.times = [7200.0]", "instance.departures.times"),
    ("run.until_s = 86400", "run.until_s"),
    ("run.warmup_s = 3600", "run.warmup_s"),
)
def test_what_counts_from_time_0_is_refused(tmp_path: Path, given: str, key: str) -> None:
    file = made(tmp_path)
    scenario = load_scenario(str(file), given.split(";"))
    said = refusal(lambda: read_past(scenario, None, str(6 * DAY_S), 10))
    assert f"{key}: counts from time 0, but each later day is run alone" in said


def test_rules_are_checked_before_placements_are_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    call = ["slot", str(made(tmp_path)), "--history-until", str(6 * DAY_S), "--rules", "nosuch"]
    said = refused(capsys, main, [*call, "--out", str(tmp_path / "out")])
    assert '--rules nosuch, rules.poa_pps: there is no rule "nosuch"' in said
    assert "Placing" not in said


def test_the_command_needs_files_and_one_history(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    call = ["slot", "examples/small", "--out", str(tmp_path / "out")]
    assert "expected --history ORDERS or --history-until TIME, one of them" in refused(capsys, main, call)
    said = refused(capsys, main, ["slot", "examples/small", "--history-until", "9", "--out", str(tmp_path)])
    assert "found a generated instance; expected `orders_file` and `pods_file`" in said


@pytest.mark.slow
def test_a_history_places_skus_for_later_days(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The same bytes twice; SKUs of the history that are on no pod, and others without history, are told."""
    pods = "pod,sku,quantity\nempty,a,0\n"
    pods += "".join(f"P{i},{sku},20\n" for i, pod in enumerate(PODS) for sku in (*pod, "new"))
    file = made(tmp_path, orders_csv(range(10, 13)), pods)
    past = tmp_path / "past.csv"
    past.write_text(orders_csv(range(9)) + "strange,800000,gone,1\n", encoding="utf-8")
    options = ("--history", str(past), "--moves", "2", "--steps", "2000", "-j1", "--rules=own")
    options = (*options, "--placement=clusters")
    assert exit_code("slot", str(file), *options, "--json", "--out", str(tmp_path / "one")) == 0
    found = json.loads(capsys.readouterr().out)
    assert exit_code("slot", str(file), *options, "--out", str(tmp_path / "two")) == 0
    shown = capsys.readouterr().out
    for name in ("pods.csv", "slotted.toml", "answer.json", "report.html", "changes.csv"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes(), name
    assert found["judged_on"] == ["day 11", "day 12", "day 13"]
    assert found["chosen"] != "now"
    visits = {row["placement"]: row["mean"] for row in found["compared"] if row["metric"] == "psv_per_order"}
    assert visits[found["chosen"]] < visits["now"]
    assert "SKUs of the history that stand on no pod: 1, left out." in found["told"]
    assert "that it is earlier than the days is not checked." in " ".join(found["told"])
    assert "SKUs on pods without history: 1 of 7, placed anywhere." in found["told"]
    assert "Run all days with them" in shown
    rows = list(csv.DictReader((tmp_path / "one" / "pods.csv").read_text(encoding="utf-8").splitlines()))
    assert {row["pod"] for row in rows} == {"empty", "P0", "P1", "P2", "P3"}
    assert "Chosen by the last 20 % of the history, where" in shown
    assert sum(int(row["quantity"]) for row in rows) == 12 * 20
    day = ("run", str(file), "--set", f"instance.pods_file={tmp_path / 'one' / 'pods.csv'}", "--quiet")
    assert exit_code(*day, "--out", str(tmp_path / "run")) == 0


@pytest.mark.slow
def test_one_pod_stays_as_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pods = "pod,sku,quantity\n" + "".join(f"P,{sku},90\n" for sku in "abcdef")
    """Nothing is held back of a history of one order."""
    options = ("--history-until", "601", "--days", "1", "--rules", "own", "--moves", "1", "-j", "1")
    options = (*options, "--placement", "random")
    assert exit_code("slot", str(made(tmp_path, pods=pods)), *options, "--out", str(tmp_path / "out")) == 0
    shown = capsys.readouterr().out
    assert "No placement needs fewer visits than the pods as they are" in shown
    assert "Changes that save visits in the history: 0, not 1." in shown
    assert "Chosen by all of the history, too short to hold back a part; now needs 1.000 visits per order" in shown
    assert "Held back" not in shown


@pytest.mark.slow
@cases(
    "departures dues",
    ('{ times = { north = ["12:00"] }, column = "to" }', ["", "", "43200.0"]),
    ('{ times = ["12:00"] }', ["43200.0"] * 3),
)
def test_orders_of_later_days_are_due_when_trucks_leave(tmp_path: Path, departures: str, dues: list[str]) -> None:
    """On one of the days no order has a route."""
    orders = "order,arrival_s,sku,quantity,to\np,600,a,1,north\nq,90000,a,1,\nr,180000,a,1,\ns,180000,a,1,north\n"
    file = made(tmp_path, orders, instance=f"departures = {departures}")
    options = ("--history-until", "700", "--rules", "own", "--placement", "random", "--steps", "0", "-j", "1")
    assert exit_code("slot", str(file), *options, "--out", str(tmp_path / "out")) == 0
    texts = [path.read_text(encoding="utf-8") for path in tmp_path.glob("out/runs/**/orders.csv")]
    found = {row["order"]: row.get("due_s", "") for text in texts for row in csv.DictReader(text.splitlines())}
    assert [found[order] for order in "qrs"] == dues
