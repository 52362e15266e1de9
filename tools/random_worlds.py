"""Run every rule that assigns orders in small random worlds that are hard to finish: each run must complete.

``python tools/random_worlds.py [--seed S] [--worlds N] [--boxes] [--failures] [--rules NAME ...]``. Stock is finite,
enough for all orders and scarce on each pod; lines have up to 40 items, in some worlds more than any station takes;
stations have item or order capacity; rules that split orders have packing capacities of 0 to 3, or none, or with
``--boxes`` packing stations with 1 to 3 boxes in all. With ``--failures`` robots and stations fail, times vary, and
robots are in each other's way (`sipp` in worlds of even seeds, `whca-n` in those of odd ones). Some worlds have too
little stock: these must be refused before the run. Each failure is printed with the command that repeats it; exit code
1 when there was any.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np
from attrs import evolve, frozen

from rmfs_commands.testing import small_layout
from rmfs_core.entrypoints import RULES, offers, origin
from rmfs_core.errors import RmfsError
from rmfs_core.roles import Role
from rmfs_core.rules import RuleSet
from rmfs_core.rules.hooks import roles_of
from rmfs_core.scenario.model import (
    FailuresSection,
    LayoutSection,
    PackingSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    RunSection,
    Scenario,
    StationsSection,
)
from rmfs_core.scenario.service import ServiceTime, Spread
from rmfs_core.simulation.engine import Simulation
from rmfs_core.world import Instance, Layout, OrderData, PodData
from rmfs_core.world.instance_making import instance_problems

LONGEST_S = 10 * 86_400.0
"""Simulated seconds after which a run counts as one that does not complete; the longest worlds need a few hours."""
NOT_ALONE = (
    "remote",
    "switch",
)
"""Rules that only ask others."""
WITH_PACKING = ("pod-index", "split-among-stations", "split-over-time")
WITH_EFFORT = ("integrated", "split-among-stations", "split-over-time")


@frozen(eq=False)
class World:
    """A warehouse with its orders, and the scenario around it, whose rules the tried one joins.

    Parameters
    ----------
    scenario
        Robots, stations and rules.
    instance, layout
        Orders, pods and grid.
    packing_capacity
        That of the rules that split orders; None: none.
    short
        Whether the pods hold too little for all orders.
    packing_work_s
        That of the rules that split orders, where there are packing stations.
    """

    scenario: Scenario
    instance: Instance
    layout: Layout
    packing_capacity: int | None
    short: bool
    packing_work_s: float = 0.0

    def with_rule(self, name: str) -> Scenario:
        """Return the scenario with a rule that assigns orders."""
        parameters: dict[str, Any] = {}
        if name in WITH_PACKING and not (name == "pod-index" and self.packing_capacity == 0):  # it takes 1 and more
            parameters["packing_capacity"] = self.packing_capacity
        if name in WITH_PACKING and self.scenario.packing is not None:
            parameters["packing_work_s"] = self.packing_work_s
        if name in WITH_EFFORT:
            parameters["effort"] = 1_000_000
        choice, rules = RuleChoice(name, parameters), self.scenario.rules
        if name in joint_rules():
            return evolve(self.scenario, rules=evolve(rules, poa=None, pps=None, poa_pps=choice))
        return evolve(self.scenario, rules=evolve(rules, poa=choice))


def assigning_rules() -> tuple[str, ...]:
    """Return the shipped rules that assign orders, alone or jointly with pods, by name."""
    return (*_shipped(Role.POA), *joint_rules())


def joint_rules() -> tuple[str, ...]:
    """Return the shipped rules that assign orders and select pods together."""
    return _shipped(Role.POA_PPS)


@cache
def _shipped(role: Role) -> tuple[str, ...]:
    of_rmfs = {name: entries[0] for name, entries in offers(RULES).items() if origin(entries[0])[0] == "rmfs"}
    return tuple(n for n, entry in of_rmfs.items() if n not in NOT_ALONE and role in roles_of(entry.load()))


def random_world(seed: int) -> World:
    """Return a world, the same for the same seed."""
    rng = np.random.default_rng(seed)
    skus, short = int(rng.integers(1, 8)), bool(rng.random() < 0.1)
    longest = int(rng.choice([1, 4, 10, 40]))
    orders = _orders(rng, skus, longest)
    counts_orders = bool(rng.random() < 0.25)
    stations = int(rng.integers(1, 4))
    capacities = tuple(rng.integers(1, 5 if counts_orders else int(rng.choice([4, 15])), stations).tolist())
    scenario = Scenario(
        seed=seed,
        rules=RulesSection(
            poa=RuleChoice("first-come"),
            pps=RuleChoice(str(rng.choice(["nearest-pod", "demand", "completes", "work-amount"]))),
            ta=RuleChoice(str(rng.choice(["balanced", "nearest-robot", "assignment"]))),
            pp=RuleChoice("free-flow"),
        ),
        layout=LayoutSection(pod_fill=0.5),
        robots=RobotsSection(count=int(rng.integers(1, 7))),
        stations=StationsSection(
            item_capacity=15 if counts_orders else capacities,
            order_capacity=capacities if counts_orders else None,
            queue_length=3,
            release=str(rng.choice(["picked", "handled"])),
        ),
        run=RunSection(until_s=LONGEST_S),
    )
    pods, orders = _pods(rng, orders, skus, short), _cancelled(orders, scenario.seed)
    packing = (None, None, 0, 1, 2, 3)[int(rng.integers(6))]
    names = tuple(str(sku + 1) for sku in range(skus))
    return World(scenario, Instance(names, orders, pods), small_layout(stations), packing, short)


def with_boxes(world: World) -> World:
    """Return a world with one to three boxes at packing stations, the same for the same world, instead of a capacity.

    Packers are few and slow, so that boxes are taken for long; in two worlds of three their work limits splitting.
    """
    rng = np.random.default_rng(world.scenario.seed)
    stations, boxes = ((1, 1), (1, 2), (2, 1), (1, 3), (3, 1))[int(rng.integers(5))]
    section = PackingSection(
        stations=stations,
        boxes=boxes,
        packers=int(rng.integers(1, 3)),
        sorters=int(rng.integers(0, 2)),
        conveyor_s=float(rng.choice([0.0, 60.0, 600.0])),
        tote=str(rng.choice(["part", "visit"])),
        pack_s=float(rng.choice([0.0, 30.0, 900.0])),
        packing_from=str(rng.choice(["packed", "packed", "picked"])),
        open=(("00:00", "00:30"), ("01:00", "24:00")) if rng.random() < 0.3 else None,
    )
    tasks, bound = str(rng.choice(_shipped(Role.PACKING_TASK))), str(rng.choice(_shipped(Role.PACKING)))
    rules = evolve(world.scenario.rules, packing=RuleChoice(bound), packing_task=RuleChoice(tasks))
    scenario, work_s = evolve(world.scenario, packing=section, rules=rules), float(rng.choice([0.0, 1.0, 400.0]))
    return evolve(world, scenario=scenario, packing_capacity=None, packing_work_s=work_s)


def with_failures(world: World) -> World:
    """Return a world in which robots and stations fail, often or for long, and times vary, the same for the same world.

    Paths are planned among other robots, by `sipp` for even seeds and by `whca-n` for odd ones.
    """
    scenario, rng = world.scenario, np.random.default_rng([world.scenario.seed, 2])

    def fails() -> FailuresSection | None:
        hours, seconds = float(rng.choice([0.01, 0.1, 1.0])), float(rng.choice([1.0, 60.0, 3600.0]))
        return FailuresSection(hours, seconds) if rng.random() < 0.75 else None

    hours = {"1": (("00:05", "00:20"), ("02:00", "03:00"))} if rng.random() < 0.3 else None
    robots = evolve(scenario.robots, failures=fails(), maintenance=hours, lift_s=ServiceTime(Spread(2.2, 0.5)))
    handle_s = ServiceTime(Spread(15.0, float(rng.choice([0.5, 1.0, 2.0])), str(rng.choice(["lognormal", "gamma"]))))
    stations = evolve(scenario.stations, outages=fails(), handle_s=handle_s)
    rules = evolve(scenario.rules, pp=RuleChoice("whca-n" if scenario.seed % 2 else "sipp"))
    return evolve(world, scenario=evolve(scenario, robots=robots, stations=stations, rules=rules))


def _orders(rng: np.random.Generator, skus: int, longest: int) -> tuple[OrderData, ...]:
    """Return orders of few lines of few items, and some lines of up to ``longest`` items; half of them come later."""
    until_ticks = int(rng.choice([0, 300_000, 3_000_000]))
    arrivals = np.sort(rng.integers(0, until_ticks + 1, int(rng.integers(1, 13))) * rng.integers(0, 2))
    orders = []
    for number, tick in enumerate(arrivals.tolist()):
        chosen = rng.permutation(skus)[: int(rng.integers(1, 6))].tolist()
        long = rng.random(len(chosen)) < 0.3
        most = np.where(long, longest, min(longest, 3))
        due = tick + int(rng.integers(1, 2_000_000)) if rng.random() < 0.3 else None
        lines = tuple(sorted((sku, int(rng.integers(1, n + 1))) for sku, n in zip(chosen, most.tolist(), strict=True)))
        orders.append(OrderData(str(number + 1), arrival_tick=tick, lines=lines, due_tick=due))
    return tuple(orders)


def _cancelled(orders: tuple[OrderData, ...], seed: int) -> tuple[OrderData, ...]:
    """Let some orders of every third world be cancelled, the same ones for the same world."""
    rng = np.random.default_rng([seed, 1])
    if rng.random() < 2 / 3:
        return orders
    after = np.where(rng.random(len(orders)) < 0.5, rng.choice([0, 1_000, 60_000, 600_000], len(orders)), -1)
    ticks = [
        None if ticks < 0 else order.arrival_tick + ticks for order, ticks in zip(orders, after.tolist(), strict=True)
    ]
    return tuple(evolve(order, cancelled_tick=tick) for order, tick in zip(orders, ticks, strict=True))


def _pods(rng: np.random.Generator, orders: Sequence[OrderData], skus: int, short: bool) -> tuple[PodData, ...]:
    """Return pods that together hold what is ordered, and a little more; or one item of some SKU too few."""
    wanted = np.zeros(skus, np.int64)
    for order in orders:
        for sku, quantity in order.lines:
            wanted[sku] += quantity
    stock = wanted + rng.integers(0, int(rng.choice([1, 3])), skus)
    if short:
        sku = int(rng.choice(np.flatnonzero(wanted)))
        stock[sku] = wanted[sku] - 1
    held = np.zeros((int(rng.integers(1, 9)), skus), np.int64)
    for sku, items in enumerate(stock.tolist()):
        some = rng.permutation(len(held))[: int(rng.integers(1, len(held) + 1))]
        held[some, sku] = rng.multinomial(items, rng.dirichlet(np.ones(len(some))))
    contents = [tuple((sku, n) for sku, n in enumerate(row) if n) for row in held.tolist()]
    return tuple(PodData(str(number + 1), row) for number, row in enumerate(contents))


def failure(world: World, rule: str) -> str | None:
    """Run a rule in a world; return what went wrong, or None."""
    scenario = world.with_rule(rule)
    problems = [str(problem) for problem in instance_problems(world.instance, scenario)]
    if world.short or problems:
        if len(problems) == world.short:
            return None
        return f"expected {int(world.short)} reasons to refuse it before the run, found {problems}"
    simulation = Simulation(scenario, world.instance, world.layout, RuleSet.load(scenario.rules, "."))
    try:
        simulation.run()
    except Exception as error:
        return f"{'' if isinstance(error, RmfsError) else type(error).__name__ + ': '}{error}"
    left = [order.name for order in simulation.warehouse.orders if order.unpicked_items]
    if simulation.status != "complete" and not left:
        return f"not all orders are packed after {simulation.view.now_s:.0f} s"
    return f"orders {', '.join(left)} are not complete after {simulation.view.now_s:.0f} s" if left else None


def failures(
    seeds: Sequence[int], rules: Sequence[str], *, boxes: bool = False, failing: bool = False
) -> Iterator[tuple[int, str, str]]:
    """Yield seed, rule and problem of each run that fails.

    With ``boxes`` worlds have packing stations; with ``failing`` robots and stations fail.
    """
    for seed in seeds:
        world = with_boxes(random_world(seed)) if boxes else random_world(seed)
        world = with_failures(world) if failing else world
        for rule in rules:
            if (problem := failure(world, rule)) is not None:
                yield seed, rule, problem


def main() -> int:
    """Run the worlds that were asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1, help="seed of the first world")
    parser.add_argument("--worlds", type=int, default=100, help="how many worlds, of consecutive seeds")
    parser.add_argument("--rules", nargs="+", default=assigning_rules(), metavar="NAME", help="left out: all")
    parser.add_argument("--boxes", action="store_true", help="with packing stations")
    parser.add_argument("--failures", action="store_true", help="with failures, outages and times that vary")
    given = parser.parse_args()
    began, number = time.perf_counter(), 0
    seeds = range(given.seed, given.seed + given.worlds)
    for seed, rule, problem in failures(seeds, given.rules, boxes=given.boxes, failing=given.failures):
        number += 1
        more = (" --boxes" if given.boxes else "") + (" --failures" if given.failures else "")
        print(f"{problem}\n  python tools/random_worlds.py --seed {seed} --worlds 1 --rules {rule}{more}", flush=True)
    runs = f"{given.worlds:,} worlds under {len(given.rules)} rules in {time.perf_counter() - began:.0f} s"
    print(f"{runs}: {number} failed" if number else f"{runs}: all completed or were refused")
    return int(number > 0)


if __name__ == "__main__":
    sys.exit(main())
