"""Compares the placements of `rmfs convert orders` on days that were made up.

A day has one of several shapes. SKUs are placed by ten earlier days of the same shape, and the day itself is run; with
``foresight`` they are placed by that very day. Each is compared with ``random`` on the same day: the mean change of
turn-over time and of pod visits, over the seeds.

    python tools/placement_trial.py --seeds 31 32 33
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from math import exp, log
from pathlib import Path
from statistics import fmean

import numpy as np
from attrs import frozen

import rmfs_core
from rmfs_commands.cli.serving import serving_lines
from rmfs_commands.convert.history import merged
from rmfs_commands.convert.lines import Sku
from rmfs_commands.convert.placement import items_on, place
from rmfs_commands.convert.scenarios import scenario_of

Lines = dict[int, int]
Day = list[tuple[float, Lines]]

PODS, PAST_DAYS = 100, 10
RULES = {"pod-match+demand": 'poa = "pod-match"\npps = "demand"', "pod-index": 'poa_pps = "pod-index"'}
PLACEMENTS = ("random", "popularity", "co-purchase", "foresight")


class Demand:
    """How often each SKU is ordered, and which are bought together."""

    def __init__(self, skus: int, exponent: float, rng: np.random.Generator) -> None:
        share = rng.permutation(np.arange(1, skus + 1.0) ** -exponent)
        self.share = share / share.sum()
        self.groups = np.array_split(rng.permutation(skus), skus // 6)
        of_group = np.array([self.share[group].sum() for group in self.groups])
        self.of_group = of_group / of_group.sum()

    def few(self, rng: np.random.Generator) -> Lines:
        """Draw an order of one to six lines, mostly of one item."""
        skus = rng.choice(len(self.share), min(rng.geometric(0.5), 6), replace=False, p=self.share)
        return {int(sku): 1 if rng.random() < 0.85 else 2 for sku in skus}

    def together(self, rng: np.random.Generator) -> Lines:
        """Draw an order of a group, sometimes with a SKU of another."""
        group = self.groups[rng.choice(len(self.groups), p=self.of_group)]
        skus = [*rng.choice(group, min(1 + rng.poisson(1.5), len(group)), replace=False)]
        if rng.random() < 0.3:
            skus.append(rng.choice(len(self.share), p=self.share))
        return {int(sku): 1 for sku in skus}

    def wholesale(self, rng: np.random.Generator) -> Lines:
        """Draw an order of many lines, a fifth of them of 10 to 40 items."""
        skus = rng.choice(len(self.share), 2 + rng.poisson(3), replace=False, p=self.share)
        return {int(sku): int(rng.integers(1, 9) if rng.random() < 0.8 else rng.integers(10, 41)) for sku in skus}


@frozen
class Shape:
    """Shapes of days: SKUs, how unequal they are, orders, and how much stands on the pods."""

    skus: int
    exponent: float
    orders_per_h: float
    order: Callable[[Demand, np.random.Generator], Lines]
    skus_per_pod: int = 10
    items: int = 10


SHAPES = {
    "popular SKUs": Shape(400, 1.0, 112, Demand.few),
    "bought together": Shape(400, 0.9, 100, Demand.together),
    "wholesale": Shape(200, 0.8, 6.5, Demand.wholesale, skus_per_pod=4, items=20),
    "equal SKUs": Shape(400, 0.3, 112, Demand.few),
    "scarce stock": Shape(400, 1.0, 112, Demand.few, items=1),
}


def made(shape: Shape, demand: Demand, rng: np.random.Generator, hours: float) -> Day:
    """Return the orders of a day, at random times."""
    day: Day = []
    time = rng.exponential(3600 / shape.orders_per_h)
    while time < hours * 3600 or not day:
        day.append((time, shape.order(demand, rng)))
        time += rng.exponential(3600 / shape.orders_per_h)
    return day


def skus_of(day: Day) -> list[Sku]:
    """Return the SKUs of orders, most order lines first."""
    lines = Counter(sku for _, order in day for sku in order)
    items: Counter[int] = Counter()
    for _, order in day:
        items.update(order)
    return [Sku(f"s{sku}", number, items[sku]) for sku, number in sorted(lines.items(), key=lambda one: (-one[1], one))]


def run(shape: Shape, placement: str, rules: str, seed: int, hours: float) -> tuple[float, float]:
    """Return turn-over time and pod visits of a day."""
    demand = Demand(shape.skus, shape.exponent, np.random.default_rng([seed, 1]))
    past = [
        order for day in range(PAST_DAYS) for order in made(shape, demand, np.random.default_rng([seed, 2, day]), hours)
    ]
    today = made(shape, demand, np.random.default_rng([seed, 3]), hours)
    known = today if placement == "foresight" else past
    skus = merged(skus_of(today), skus_of(known))
    name = "co-purchase" if placement == "foresight" else placement
    baskets = [[f"s{sku}" for sku in order] for _, order in known]
    held = place(skus, [shape.skus_per_pod] * PODS, name, np.random.default_rng([seed, 4]), baskets)
    number, _ = items_on(skus, held, shape.items)
    with tempfile.TemporaryDirectory() as folder:
        pods = [f"P{i},{skus[sku].name},{number[sku]}\n" for i, pod in enumerate(held) for sku in pod]
        rows = [
            f"o{i},{time:.3f},s{sku},{items}\n" for i, (time, order) in enumerate(today) for sku, items in order.items()
        ]
        scenario = scenario_of(PODS).replace(serving_lines(), RULES[rules])
        scenario = scenario.replace("item_capacity = 100", "item_capacity = 400")
        (Path(folder) / "pods.csv").write_text("pod,sku,quantity\n" + "".join(pods))
        (Path(folder) / "orders.csv").write_text("order,arrival_s,sku,quantity\n" + "".join(rows))
        (Path(folder) / "scenario.toml").write_text(scenario)
        result = rmfs_core.run(Path(folder) / "scenario.toml")
    assert result.status == "complete"
    return float(result.metrics["turnover_s"] or 0), float(result.metrics["pod_station_visits"] or 0)


def compared(shape: Shape, rules: str, seeds: list[int], hours: float) -> Iterator[str]:
    """Yield, for each placement, how turn-over time and visits change against ``random``: geometric means."""
    base = [run(shape, "random", rules, seed, hours) for seed in seeds]
    for placement in PLACEMENTS[1:]:
        found = [run(shape, placement, rules, seed, hours) for seed in seeds]
        for i in (0, 1):
            mean = exp(fmean(log(one[i] / other[i]) for one, other in zip(found, base, strict=True)))
            yield f"{100 * (mean - 1):+.0f} %"


def main() -> None:
    """Print a table for each set of rules."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", default=[31, 32, 33])
    parser.add_argument("--shapes", nargs="+", choices=SHAPES, default=list(SHAPES))
    parser.add_argument("--rules", nargs="+", choices=RULES, default=list(RULES))
    parser.add_argument("--hours", type=float, default=2.5)
    given = parser.parse_args()
    print("Turn-over time and pod visits against random: " + ", ".join(PLACEMENTS[1:]))
    for rules in given.rules:
        for shape in given.shapes:
            changes = compared(SHAPES[shape], rules, given.seeds, given.hours)
            print(f"{rules:16} {shape:16}", *(f"{change:>7}" for change in changes), flush=True)


if __name__ == "__main__":
    main()
