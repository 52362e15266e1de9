"""Random worlds that are hard to finish complete under every rule that assigns orders."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from random_worlds import assigning_rules, failure, failures, joint_rules, main, random_world

IDLE = """
from attrs import define
from rmfs_core import hookimpl

@define
class Idle:
    @hookimpl
    def assign_orders(self):
        return []
"""


def test_all_rules_complete_a_few_worlds() -> None:
    """Each rule, each world; those with too little stock are refused."""
    assert list(failures(range(1, 7), assigning_rules())) == []


@pytest.mark.slow
def test_all_rules_complete_many_worlds() -> None:
    """`make long` does 3,000 of them."""
    assert list(failures(range(1, 151), assigning_rules())) == []


def test_all_rules_that_assign_orders_are_tried() -> None:
    """Those that do it alone and those that select pods, too; not the one that only asks others."""
    rules = assigning_rules()
    assert {"first-come", "station-queue", "random"} < {*rules}
    assert set(rules[-len(joint_rules()) :]) == set(joint_rules())
    assert len(rules) == 16
    assert "switch" not in rules


def test_worlds_have_what_rules_stumble_over() -> None:
    """Among a hundred of them each is there often: long lines, order capacity, too little stock, scarce pods."""
    found: Counter[str] = Counter()
    for seed in range(1, 101):
        world = random_world(seed)
        stations, orders = world.scenario.stations, world.instance.orders
        lines, pods = (
            [line for order in orders for line in order.lines],
            [dict(p.contents) for p in world.instance.pods],
        )
        longest = max(quantity for _, quantity in lines)
        counts_orders = stations.order_capacity is not None
        found["order capacity"] += counts_orders
        found["long line"] += not counts_orders and longest > max(np.atleast_1d(stations.item_capacity))
        found["scarce pods"] += any(quantity > max(pod.get(sku, 0) or 0 for pod in pods) for sku, quantity in lines)
        found["short"] += world.short
        found["several stations"] += len(world.layout.stations) > 1
        found[f"packing capacity {world.packing_capacity}"] += 1
        found[world.scenario.rules.ta.rule] += 1
        found["later orders"] += orders[-1].arrival_tick > 0
    assert len(found) == 14
    assert min(found.values()) >= 5, found


def test_a_world_is_the_same_for_the_same_seed() -> None:
    """To the last item."""
    one, other = random_world(7), random_world(7)
    assert (one.scenario, one.instance, one.layout) == (other.scenario, other.instance, other.layout)
    assert random_world(8).instance != one.instance


def test_a_rule_that_does_nothing_is_found(tmp_path: Path) -> None:
    """What the run says of it is the failure."""
    (tmp_path / "idle.py").write_text(IDLE)
    world = next(world for world in map(random_world, range(1, 9)) if not world.short)
    problem = failure(world, f"{tmp_path / 'idle.py'}:Idle")
    assert problem is not None
    assert problem.startswith("The run stands still at 0.000 s")


def test_too_little_stock_that_is_not_refused_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """As is a reason to refuse a world that has enough."""
    short = next(world for world in map(random_world, range(1, 99)) if world.short)
    assert failure(short, "first-come") is None
    monkeypatch.setattr("random_worlds.instance_problems", lambda *_: [])
    assert failure(short, "first-come") == "expected 1 reasons to refuse it before the run, found []"
    monkeypatch.setattr("random_worlds.instance_problems", lambda *_: ["why"])
    enough = next(world for world in map(random_world, range(1, 9)) if not world.short)
    assert failure(enough, "first-come") == "expected 0 reasons to refuse it before the run, found ['why']"


def test_failures_are_printed_with_the_command_that_repeats_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Exit code 1 when there is one, else 0."""
    (tmp_path / "idle.py").write_text(IDLE)
    first = next(seed for seed in range(1, 9) if not random_world(seed).short)
    idle = f"{tmp_path / 'idle.py'}:Idle"
    for rule, code, last in (("first-come", 0, "all completed or were refused"), (idle, 1, "1 failed")):
        asked = ["--seed", str(first), "--worlds", "1", "--rules", rule]
        monkeypatch.setattr("sys.argv", ["random_worlds.py", *asked])
        assert main() == code
        printed = capsys.readouterr().out
        assert printed.endswith(f"{last}\n")
        assert (f"\n  python tools/random_worlds.py {' '.join(asked)}\n" in printed) == bool(code)
