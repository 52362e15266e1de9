"""Tables worked out anew from a trace: of a day of one order, written by hand, and of runs of many kinds."""

from __future__ import annotations

from pathlib import Path

import pytest
from attrs import evolve

import rmfs_core
from rmfs_commands.trace import Trace
from rmfs_commands.validation import validate_trace
from rmfs_commands.validation.tables import hours_of, robots_of, stations_of, waiting_ticks


def test_the_day_by_hours(day: Trace) -> None:
    """One order, three picks, one visit, and 14 m to drive."""
    assert [*hours_of(day)] == [
        {"hour": 0, "start_s": 0, "orders_in": 1, "orders_out": 1, "picks": 3, "visits": 1, "distance_m": 14}
        | {"backlog": 0}
    ]


def test_the_day_by_stations(day: Trace) -> None:
    """39 s are busy with three items of 13 s, but for the 6 s that the last one takes after the pick."""
    (row,) = stations_of(day)
    assert (row["picks"], row["visits"], row["busy_s"], row["queue_max"]) == (3, 1, 39.0, 1)
    assert row["starved_s"] == 0.0
    whole = float(row["busy_s"] or 0) + float(row["waiting_s"] or 0) + float(row["idle_s"] or 0)
    assert whole == pytest.approx(day.tick / 1000)


def test_the_day_by_robots(day: Trace) -> None:
    """The robot never waits, and its times add up to the day."""
    (row,) = robots_of(day)
    assert (row["robot"], row["distance_m"], row["station_s"], row["waiting_s"]) == ("1", 14, 33.0, 0.0)
    assert sum(float(value or 0) for column, value in row.items() if column.endswith("_s")) == day.tick / 1000
    assert not waiting_ticks(day).total()


def test_a_warm_up_is_left_out(day: Trace) -> None:
    """All of it, where the day is over before anything is measured."""
    late = evolve(day, scenario={**day.scenario, "run": {"warmup_s": 1000}})
    assert {value for row in robots_of(late) for column, value in row.items() if column != "robot"} == {0}
    (row,) = stations_of(late)
    assert (row["picks"], row["busy_s"], row["idle_s"], row["queue_mean"]) == (0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "overrides",
    [
        ("rules.pp=whca-n",),
        ("run.until_s=200", "run.warmup_s=60"),
        ("instance.pods_at_stations={1 = ['3', '5'], 2 = ['4']}",),
        ("rules.poa_pps=split-over-time",),
    ],
)
def test_runs_leave_what_their_traces_amount_to(tmp_path: Path, overrides: tuple[str, ...]) -> None:
    """With robots in each other's way, orders left, pods at stations from the start, and pods that go on."""
    rmfs_core.run("examples/small", overrides=["instance.orders=20", *overrides], out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []
