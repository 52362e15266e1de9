"""What a run says when it ends with orders that are not complete."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from installed import RMFS
from rmfs_commands.testing import small_instance
from rmfs_core.errors import StandstillError
from rmfs_core.scenario.model import RunSection, Scenario
from rmfs_core.timetable import Span

Prepare = Callable[..., Any]
COUNTS_ITEMS = """
from attrs import define
from rmfs_core import OrderAssignment, hookimpl


@define
class CountsItems:
    @hookimpl
    def assign_orders(self, warehouse):
        fitting = [order for order in warehouse.backlog if order.items <= warehouse.stations[0].free_capacity]
        return [OrderAssignment(order.id, 0) for order in fitting[:1]]
"""


@pytest.mark.parametrize(
    ("orders", "left", "large"),
    [
        (1, "1 order is not complete (1 in the backlog;", "1 in the backlog has more than 1 item and fits"),
        (2, "2 orders are not complete (2 in the backlog;", "2 in the backlog have more than 1 item and fit"),
    ],
)
def test_a_run_that_stands_still_says_what_is_left(
    tiny_run: Prepare, tmp_path: Path, orders: int, left: str, large: str
) -> None:
    """When no rule decides anything and nothing is under way, the error counts what is left, and what it could take."""
    (tmp_path / "own.py").write_text(COUNTS_ITEMS, encoding="utf-8")
    instance = small_instance({str(i): ["a", "b"] for i in range(orders)}, {"p": ["a", "b"]})
    run = tiny_run(instance, capacity=1, poa="./own.py:CountsItems")
    with pytest.raises(StandstillError) as caught:
        run.simulation.run()
    assert str(caught.value) == (
        f"The run stands still at 0.000 s: {left} 0 open requests that no inbound pod can serve; 0 pods waiting for a "
        'robot), and no rule decides anything (asked last: rule "./own.py:CountsItems" (own.py inline), rule "demand" '
        f'({RMFS}), rule "nearest-robot" ({RMFS})); {large} an empty station alone, as `fits` says.'
    )


@pytest.mark.parametrize(
    ("stations", "robots", "until_s", "sentence"),
    [
        ((("06:00", "10:00"),), None, 3600.0, "no station is open before 21600.000 s."),
        (None, (("12:00", "16:00"),), 3600.0, "no robot is on duty before 43200.000 s."),
        (
            (("00:00", "00:01"),),
            (("00:01", "24:00"),),
            61.0,
            "no robot is on duty while a station is open at any time.",
        ),
        (None, None, 1.0, "1 of 1 order arrived, with 0 items picked."),
    ],
)
def test_why_no_order_is_complete_is_said(
    tiny_run: Prepare, stations: Any, robots: tuple[Span, ...] | None, until_s: float, sentence: str
) -> None:
    """Where hours are the reason, what is missing and from when on it is there."""

    def change(scenario: Scenario) -> Scenario:
        return evolve(
            scenario,
            stations=evolve(scenario.stations, open=stations),
            robots=evolve(scenario.robots, available=robots),
            run=RunSection(until_s=until_s),
        )

    simulation = tiny_run(small_instance({"1": ["a"]}, {"p": ["a"]}), change=change).simulation
    simulation.run()
    assert [*simulation.notes()] == [f"No order is complete at {until_s:.3f} s: {sentence}"]


def test_where_an_order_is_complete_nothing_is_said(tiny_run: Prepare) -> None:
    """Nor where there are none."""
    simulation = tiny_run(small_instance({"1": ["a"]}, {"p": ["a"]})).simulation
    simulation.run()
    assert [*simulation.notes()] == []
