"""The paper's instance generator; days drawn from a file's orders, by `rmfs scale` and by `instance.scale`."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from attrs import evolve
from hypothesis import given, settings
from hypothesis import strategies as st

import rmfs_core
from calling import exit_code, refusal, refused
from cases import cases
from rmfs_commands.cli.main import main
from rmfs_commands.instances.days import HOUR, draw_day, read_peaks
from rmfs_commands.instances.generator import draw_distinct, generate_instance, order_lengths, sku_demand
from rmfs_core.errors import InputError
from rmfs_core.scenario import Arrivals, InstanceSection
from rmfs_core.scenario.model import Due, SkuDemand
from rmfs_core.timetable import DAY
from rmfs_core.world import Instance, OrderData, make_instance

PAPER = InstanceSection()


def wanted(instance: Instance) -> list[tuple[str, ...]]:
    return [tuple(instance.skus[sku] for sku, _ in order.lines) for order in instance.orders]


@settings(deadline=None)
@given(
    seed=st.integers(0, 10**6),
    skus=st.integers(1, 40),
    pods=st.integers(10, 30),
    skus_per_pod=st.integers(2, 4),
    items_per_sku=st.none() | st.integers(5, 9),
)
def test_pods_can_fill_every_order(seed, skus, pods, skus_per_pod, items_per_sku) -> None:
    section = InstanceSection(
        orders=5, skus=skus, pods=pods, skus_per_pod=min(skus, skus_per_pod), items_per_sku=items_per_sku
    )
    instance = generate_instance(section, seed)
    stock: Counter[int] = Counter()
    for pod in instance.pods:
        assert len({sku for sku, _ in pod.contents}) == len(pod.contents)
        stock.update({sku: 10**9 if items is None else items for sku, items in pod.contents})
    for order in instance.orders:
        assert 1 <= len({sku for sku, _ in order.lines}) == len(order.lines) <= min(skus, 15)
        stock.subtract(dict(order.lines))
    assert min(stock.values()) >= 0
    assert set(stock) == set(range(len(instance.skus)))


def test_a_seed_gives_one_instance() -> None:
    assert generate_instance(PAPER, 1) == generate_instance(PAPER, 1)
    assert wanted(generate_instance(PAPER, 1)) != wanted(generate_instance(PAPER, 2))
    assert generate_instance(PAPER, 1).orders[:50] == generate_instance(evolve(PAPER, orders=50), 1).orders
    section = evolve(PAPER, orders=2000, arrivals=Arrivals("poisson", orders_per_hour=360))
    instance = generate_instance(section, 1)
    ticks = [order.arrival_tick for order in instance.orders]
    assert ticks == sorted(ticks)
    assert ticks[0] > 0
    assert ticks[-1] / 1000 / 2000 == pytest.approx(10, rel=0.1)
    assert wanted(instance) == wanted(generate_instance(evolve(PAPER, orders=2000), 1))


def test_order_lengths_are_truncated_geometric() -> None:
    lengths = order_lengths(20)
    assert lengths.sum() == pytest.approx(1)
    assert lengths[1:] / lengths[:-1] == pytest.approx(np.full(19, 0.6))
    assert lengths @ np.arange(1, 21) == pytest.approx(2.5, abs=0.01)


@pytest.mark.parametrize(("skus", "p"), [(100, 0.05), (20, 0.25), (11, 5 / 11), (10, 0.5), (5, 0.5), (2, 0.5)])
def test_sku_demand_is_geometric(skus: int, p: float) -> None:
    demand = sku_demand(skus)
    assert demand.sum() == pytest.approx(1)
    assert demand[1:] / demand[:-1] == pytest.approx(np.full(skus - 1, 1 - p))


def test_drawn_orders_follow_the_distributions() -> None:
    section = InstanceSection(orders=20_000, skus=20, pods=20)
    orders = wanted(generate_instance(section, 3))
    mean = order_lengths(15) @ np.arange(1, 16)
    assert np.mean([len(skus) for skus in orders]) == pytest.approx(mean, rel=0.02)
    single = Counter(skus[0] for skus in orders if len(skus) == 1)
    shares = np.array([single[str(i)] for i in range(1, 21)]) / single.total()
    assert shares == pytest.approx(sku_demand(20), abs=0.012)


@pytest.mark.parametrize("skus", [6, 40, 3_000])
def test_distinct_draws_are_those_of_numpy(skus: int) -> None:
    ours, theirs, weights = np.random.default_rng(5), np.random.default_rng(5), sku_demand(skus)
    shares = weights.cumsum() / weights.cumsum()[-1]
    for number in [1, 2, 3, 6] * 50:
        expected = theirs.choice(skus, number, replace=False, p=weights)
        assert draw_distinct(number, weights, shares, ours).tolist() == expected.tolist()


def test_skus_on_pods() -> None:
    instance = generate_instance(InstanceSection(orders=0, skus=12, pods=16, skus_per_pod=3), 1)
    assert Counter(sku for pod in instance.pods for sku, _ in pod.contents) == dict.fromkeys(range(12), 4)
    section = InstanceSection(orders=0, skus=3, pods=40, skus_per_pod=2, items_per_sku=5)
    pods = generate_instance(section, 1).pods
    assert {contents for pod in pods for contents in [tuple(items for _, items in pod.contents)]} == {(5, 5), (10,)}
    assert sum(items or 0 for pod in pods for _, items in pod.contents) == 40 * 2 * 5
    instance = generate_instance(InstanceSection(orders=10, skus=100, pods=4, skus_per_pod=2), 1)
    assert len(instance.skus) == 8
    assert set(instance.skus) <= {str(i) for i in range(1, 101)}


def test_too_little_stock_is_an_error() -> None:
    section = InstanceSection(orders=50, skus=5, pods=5, skus_per_pod=1, items_per_sku=2)
    message = refusal(lambda: generate_instance(section, 1))
    assert message.startswith("instance: after ")
    assert message.endswith(
        "of 50 orders the 5 pods of 1 SKUs each have items of 0 of 5 SKUs left, too few to draw an order that they can "
        "fill; expected more `pods` or `skus_per_pod` or `items_per_sku`, or fewer `orders` or `skus`"
    )


PROFILE = (0.0,) * 6 + (1.0, 3.0) + (0.0,) * 16


def test_arrivals_follow_the_hours() -> None:
    day = evolve(PAPER, arrivals=Arrivals("day", profile=PROFILE))
    hours = np.array([order.arrival_tick for order in generate_instance(day, seed=1).orders]) / 3_600_000
    assert (hours.min() >= 6, hours.max() < 8) == (True, True)
    assert np.mean(hours < 7) == pytest.approx(0.25, abs=0.07)
    assert (np.diff(hours) >= 0).all()
    assert wanted(generate_instance(day, seed=1)) == wanted(generate_instance(PAPER, seed=1))
    day = evolve(PAPER, arrivals=Arrivals("day", profile=PROFILE), start="2024-03-01T07:30")
    hours = np.array([order.arrival_tick for order in generate_instance(day, seed=1).orders]) / 3_600_000
    assert set(np.floor(hours * 2).tolist()) == {0, 45, 46, 47}  # half hours after 7:30; 6:00 is 22.5 hours later
    assert np.mean(hours < 0.5) == pytest.approx(3 / 8, abs=0.08)
    section = evolve(PAPER, orders=4800, max_lines=1, arrivals=Arrivals("poisson", 100.0, PROFILE))
    hours = np.array([order.arrival_tick for order in generate_instance(section, seed=1).orders]) / 3_600_000
    assert set(np.floor(hours % 24).tolist()) == {6, 7}
    assert np.mean(hours < 24) == pytest.approx(0.5, abs=0.05)


def test_due_times() -> None:
    """A third has priority 1 and a minute; the others have ten minutes, two more or less."""
    due = Due(allowance_s=600, spread_s=120, priority_share=1 / 3, priority_allowance_s=60)
    orders = generate_instance(evolve(PAPER, due=due, arrivals=Arrivals("day")), seed=1).orders
    left = {0: [], 1: []}
    for order in orders:
        assert order.due_tick is not None
        left[order.priority].append((order.due_tick - order.arrival_tick) / 1000)
    assert len(left[1]) == pytest.approx(250 / 3, abs=25)
    assert set(left[1]) == {60.0}
    assert (480 <= min(left[0]) < 500, 700 < max(left[0]) <= 720) == (True, True)


def test_demand_and_lengths() -> None:
    lengths = Counter(len(lines) for lines in wanted(generate_instance(evolve(PAPER, lines=(1.0, 0.0, 3.0)), seed=1)))
    assert lengths.keys() == {1, 3}
    assert lengths[3] / 250 == pytest.approx(0.75, abs=0.08)
    small = evolve(PAPER, skus=2, skus_per_pod=1, lines=(1.0, 0.0, 3.0))
    assert {len(lines) for lines in wanted(generate_instance(small, seed=1))} == {1}
    assert sku_demand(3, SkuDemand(1.0, shift=1.0)) == pytest.approx([6 / 13, 4 / 13, 3 / 13])
    section = evolve(PAPER, lines=(0.0, 1.0), demand=SkuDemand(0.0, groups=50, together=1.0))
    pairs = Counter(frozenset(lines) for lines in wanted(generate_instance(section, seed=1)))
    alone = Counter(frozenset(lines) for lines in wanted(generate_instance(evolve(PAPER, lines=(0.0, 1.0)), seed=1)))
    assert sum(n for n in pairs.values() if n > 1) > 0.3 * 250
    assert pairs.most_common(1)[0][1] > 1
    assert len(pairs) < len(alone)


ORDERS = """order,arrival_s,sku,quantity,due_s,priority,cancelled_s
A,600,tea,1,4200,2,
A,600,mug,2,4200,2,
B,4000,tea,1,,0,4900
C,4000,ale,3,,0,
D,61500,nuts,1,61500,0,
"""
PODS = "pod,sku,quantity\nP,tea,\nP,mug,\nQ,ale,\nQ,nuts,\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with a file of orders, one of pods, and a scenario that draws from them."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "orders.csv").write_text(ORDERS)
    (tmp_path / "pods.csv").write_text(PODS)
    rules = '[rules]\npoa = "pod-match"\npps = "demand"\npp = "free-flow"\n'
    hall = "[layout]\nblock_rows = 3\nblock_columns = 1\nstations_east = 1\n[robots]\ncount = 1\n"
    files = '[instance]\norders_file = "orders.csv"\npods_file = "pods.csv"\n[instance.scale]\n'
    (tmp_path / "day.toml").write_text(files + hall + rules)
    return tmp_path


def day(orders: tuple[OrderData, ...], by: float, *peaks: str, seed: int = 1, zero: int = 0) -> tuple[OrderData, ...]:
    return draw_day(orders, by, read_peaks(peaks, "here"), np.random.default_rng(seed), zero, "here")


@given(
    arrivals=st.lists(st.integers(0, 2 * DAY), min_size=1, max_size=30),
    by=st.sampled_from([0.3, 1.0, 4.0]),
    zero=st.sampled_from([0, 6 * HOUR + 5]),
    seed=st.integers(0, 9),
)
def test_whole_orders_come_at_about_their_times(arrivals: list[int], by: float, zero: int, seed: int) -> None:
    orders = tuple(
        OrderData(str(i), ((i, 1),), arrival_tick=tick, due_tick=tick + i, priority=i, cancelled_tick=tick + 2 * i)
        for i, tick in enumerate(sorted(arrivals))
    )
    found = day(orders, by, "06:30-07:10=2", "12:00-13:00=0", seed=seed, zero=zero)
    assert found == day(orders, by, "06:30-07:10=2", "12:00-13:00=0", seed=seed, zero=zero)
    assert [one.arrival_tick for one in found] == sorted(one.arrival_tick for one in found)
    assert len({one.name for one in found}) == len(found)
    for one in found:
        first = orders[one.priority]
        assert one.name.split("/")[0] == first.name
        later = one.arrival_tick - first.arrival_tick
        assert one == evolve(
            first,
            name=one.name,
            arrival_tick=first.arrival_tick + later,
            due_tick=(first.due_tick or 0) + later,
            cancelled_tick=(first.cancelled_tick or 0) + later,
        )
        assert (one.arrival_tick + zero) // HOUR == (first.arrival_tick + zero) // HOUR
        assert (one.arrival_tick + zero) % DAY // HOUR != 12
        before, after = orders[max(one.priority - 1, 0)], orders[min(one.priority + 1, len(orders) - 1)]
        assert before.arrival_tick <= one.arrival_tick <= after.arrival_tick


def test_so_many_orders_come_in_the_mean() -> None:
    """10,000 orders at each of three hours; the standard deviation is the root of what is expected."""
    times = np.repeat([8, 17, 23], 10_000) * HOUR + np.tile(np.arange(10_000), 3) * 300
    orders = tuple(OrderData(str(i), arrival_tick=tick, lines=((0, 1),)) for i, tick in enumerate(times.tolist()))
    found = np.array([one.arrival_tick // HOUR for one in day(orders, 0.8, "17:00-18:00=3", "22:30-02:00=0.5")])
    for hour, expected in ((8, 8_000), (17, 24_000), (23, 4_000)):
        assert abs((found == hour).sum() - expected) < 5 * expected**0.5


def test_a_peak_begins_and_ends_at_its_times_and_orders_at_one_moment_stay_together() -> None:
    hour = 17 * HOUR
    orders = tuple(OrderData(str(i), arrival_tick=hour + i * HOUR // 2, lines=((0, 1),)) for i in range(3))
    found = day(orders, 200, "17:15-17:45=5")
    assert {one.arrival_tick // (HOUR // 4) for one in found if one.name[0] == "1"} == {69, 70}  # 17:15 to 17:45
    ticks = (hour - 9000, hour + 5000, hour + 5000, hour + 5000, hour + 90_000)
    together = tuple(evolve(orders[0], name=str(i), arrival_tick=tick) for i, tick in enumerate(ticks))
    found = day(together, 50)
    assert {one.arrival_tick for one in found if one.name[0] in "123"} == {hour + 5000}
    assert len({one.arrival_tick for one in found if one.name[0] in "04"}) > 20
    assert not day((), 2)


def test_a_file_is_made_that_says_how(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = "scale orders.csv --by 3 --peak 01:00-02:00=0 --seed 4"
    assert exit_code(*command.split(), "--out", "more.csv") == 0
    comment, header, *rows = (folder / "more.csv").read_text().splitlines()
    assert comment.endswith(f"drawn by `rmfs {command}`; times count from midnight.")
    assert header == "order,arrival_s,sku,quantity,due_s,priority"  # cancelled ones come in the peak
    assert {row[0] for row in rows} == {"A", "D"}
    quoted = (folder / "more.csv").rename(folder / "my more.csv")
    assert exit_code("scale", quoted.name, "--start", "2026-01-01 08:00", "--out", "next.csv") == 0
    comment = (folder / "next.csv").read_text().partition("\n")[0]
    assert "`rmfs scale 'my more.csv' --by 1 --start '2026-01-01 08:00' --seed 1`" in comment
    assert exit_code("scale", "a\nb.csv", "--out", "next.csv") == 2
    assert "expected a name that can be printed in a line, found 'a\\nb.csv'" in capsys.readouterr().err
    quoted.rename(folder / "more.csv")
    assert exit_code("scale", "more.csv", "--out", "again.csv") == 0  # a file with a comment, and names of copies
    changed = ["instance.orders_file=more.csv", "instance.scale="]
    names = [order.name for order in make_instance(rmfs_core.load_scenario("day.toml", changed)).orders]
    assert names == list(dict.fromkeys(row.split(",")[0] for row in rows))
    assert exit_code("scale", "orders.csv", "--out", "more.csv") == 2
    assert "--force replaces it" in capsys.readouterr().err


def test_a_drawn_day_keeps_the_routes_of_its_orders(folder: Path) -> None:
    rows = "1,100,a,1,N\n2,200,a,1,\n3,300,a,1,S\n"
    (folder / "routed.csv").write_text(f"order,arrival_s,sku,quantity,tour\n{rows}", encoding="utf-8")
    assert exit_code("scale", "routed.csv", "--by", "3", "--route", "tour", "--out", "more.csv") == 0
    comment, header, *drawn = (folder / "more.csv").read_text().splitlines()
    assert "--by 3 --route tour --seed 1" in comment
    assert header == "order,arrival_s,sku,quantity,tour"
    assert {(row[0], row.split(",")[-1]) for row in drawn} == {("1", "N"), ("2", ""), ("3", "S")}


@cases(
    "options said",
    ("--route sku", "--route: found `sku`, which has another meaning; expected a column of routes"),
    ("--by 0", "expected a number from 0.001 to 1,000, found 0"),
    ("--peak 17-20=2", "expected two times of the day and a factor up to 1,000, such as"),
    ("--peak 17:00-17:00=2", "found '17:00-17:00=2'"),
    ("--start noon", '--start: expected a time in ISO 8601, such as 2024-03-01T06:30, found "noon"'),
)
def test_what_makes_no_sense_is_refused(folder, capsys, options, said) -> None:
    assert said in refused(capsys, main, ["scale", "orders.csv", "--out", "new.csv", *options.split()])
    assert not (folder / "new.csv").exists()


def test_each_seed_draws_a_day_of_its_own(folder: Path) -> None:
    scenario = rmfs_core.load_scenario(folder / "day.toml", ["instance.scale.by=2"])
    days = [make_instance(scenario.with_seed(seed)).orders for seed in (1, 2, 1)]
    assert days[0] == days[2] != days[1]
    plain = make_instance(rmfs_core.load_scenario(folder / "day.toml", ["instance.scale="]))
    assert [order.name for order in plain.orders] == list("ABCD")
    assert rmfs_core.run("day.toml", overrides=["instance.scale.by=2"]).status == "complete"


@cases(
    "changes said",
    (["instance.scale.by=1000000"], "expected a number from 0.001 to 1000"),
    (["instance.scale.peaks=['x']"], "expected two times of the day and a factor"),
    (["instance.pods_file=few.csv", "instance.scale.by=50"], "instance.scale: from order "),
    (["instance.orders_file=", "instance.pods_file="], "expected `orders_file` with `scale`"),
)
def test_a_scenario_that_cannot_draw_is_refused(folder: Path, changes: list[str], said: str) -> None:
    (folder / "few.csv").write_text(PODS.replace("ale,", "ale,3"))
    with pytest.raises(InputError, match=said.replace(".", r"\.")):
        make_instance(rmfs_core.load_scenario("day.toml", changes))
