"""Days drawn from a file's orders: by `rmfs scale`, and by the key `instance.scale` with the seed of a run."""

from pathlib import Path

import numpy as np
import pytest
from attrs import evolve
from hypothesis import given
from hypothesis import strategies as st

import rmfs_core
from calling import exit_code
from cases import cases
from rmfs_commands.instances.days import HOUR, draw_day, read_peaks
from rmfs_core.errors import InputError
from rmfs_core.timetable import DAY
from rmfs_core.world import OrderData, make_instance

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
        OrderData(
            str(i), arrival_tick=tick, lines=((i, 1),), due_tick=tick + i, priority=i, cancelled_tick=tick + 2 * i
        )
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
    assert (
        exit_code(*["scale", "orders.csv", "--by", "3", "--peak", "01:00-02:00=0", "--seed", "4", "--out", "more.csv"])
        == 0
    )
    comment, header, *rows = (folder / "more.csv").read_text().splitlines()
    command = "rmfs scale orders.csv --by 3 --peak 01:00-02:00=0 --seed 4"
    assert comment.endswith(f"drawn by `{command}`; times count from midnight.")
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


@cases(
    "options said",
    ("--by 0", "expected a number from 0.001 to 1,000, found 0"),
    ("--peak 17-20=2", "expected two times of the day and a factor up to 1,000, such as"),
    ("--peak 17:00-17:00=2", "found '17:00-17:00=2'"),
    ("--start noon", '--start: expected a time in ISO 8601, such as 2024-03-01T06:30, found "noon"'),
)
def test_what_makes_no_sense_is_refused(
    folder: Path, capsys: pytest.CaptureFixture[str], options: str, said: str
) -> None:
    assert exit_code("scale", "orders.csv", "--out", "new.csv", *options.split()) == 2
    assert said in capsys.readouterr().err
    assert not (folder / "new.csv").exists()


def test_each_seed_draws_a_day_of_its_own(folder: Path) -> None:
    scenario = rmfs_core.load_scenario(folder / "day.toml", ["instance.scale.by=2"])
    days = [make_instance(scenario.with_seed(seed)).orders for seed in (1, 2, 1)]
    assert days[0] == days[2] != days[1]
    plain = make_instance(rmfs_core.load_scenario(folder / "day.toml", ["instance.scale="]))
    assert [order.name for order in plain.orders] == list("ABCD")
    result = rmfs_core.run("day.toml", overrides=["instance.scale.by=2"])
    assert result.status == "complete"


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
