"""Fit what rmfs generates orders from to a table of order lines: lengths of orders, demand of SKUs, hours of the day.

    python tools/fit_orders.py orders.csv [--longest 60] [--start 00:00]

Reads a file as `rmfs convert orders` writes it, or any CSV with columns `order`, `sku` and perhaps `arrival_s`, and
prints the keys of `[instance]`. They are a few numbers: no order, SKU or time of the table is among them.

- `lines`: how many of 1,000 orders have 1, 2, ... lines; those longer than `--longest` count as that long.
- `demand.exponent` and `shift`: the most likely ones of a grid (shifts to 500) for how often the SKUs are ordered, by
  rank (multinomial).
- `demand.groups`: one for ten SKUs. `together`: the one with which generated orders are as alike as those of the table.
  Half of the orders say which SKU goes with each one more often than chance would have it; alike is how much more often
  than chance the other half has both.
- `arrivals.profile`: how many of 1,000 orders arrive in each hour of the day, where there are times.
"""

from __future__ import annotations

import argparse
import csv
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rmfs_commands.instances.generator import generate_instance, sku_demand
from rmfs_core.scenario.model import InstanceSection, SkuDemand

GROUP = 10
"""SKUs of a group."""
MOST_ORDERS = 4_000
"""Orders that are compared with generated ones."""
SHIFTS = (0.0, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0, 15.0, 20.0, 30.0, 50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 500.0)


def main() -> None:
    """Print the keys."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", type=Path)
    parser.add_argument("--longest", type=int, default=60)
    parser.add_argument("--start", default="00:00", help="Time of the day at 0 s")
    given = parser.parse_args()
    orders, arrivals = read_orders(given.table)
    hours, minutes = map(int, given.start.split(":"))
    cut = sum(len(order) > given.longest for order in orders)
    lines = per_mille(np.bincount([min(len(order), given.longest) for order in orders])[1:])
    counts = np.bincount([sku for order in orders for sku in order])
    demand = fit_demand(counts)
    print(f"# {len(orders)} orders, {counts.sum()} lines, {len(counts)} SKUs; the tenth of SKUs that is wanted most")
    print(f"# has {np.sort(counts)[::-1][: len(counts) // 10].sum() / counts.sum():.0%} of the lines, and here")
    print(f"# {sku_demand(len(counts), demand)[: len(counts) // 10].sum():.0%}.")
    if cut:
        print(f"# {cut} orders are longer than {given.longest} lines (--longest), and count as that long.")
    if demand.shift == SHIFTS[-1]:
        print(f"# The shift is the largest that is tried, {SHIFTS[-1]:g}: a larger one may fit better.")
    together = fit_together(orders, len(counts), lines, demand)
    print(f"lines = {lines}")
    print(f"demand = {{ exponent = {demand.exponent}, shift = {demand.shift}, ", end="")
    print(f"groups = {-(-len(counts) // GROUP)}, together = {together} }}")
    if arrivals:
        of_day = (np.array(arrivals) / 3600 + hours + minutes / 60) % 24
        print(f"arrivals = {{ process = 'day', profile = {per_mille(np.bincount(of_day.astype(int), minlength=24))} }}")


def read_orders(file: Path) -> tuple[list[list[int]], list[float]]:
    """Return the SKUs (numbers) of each order, each once, and when orders arrive, in seconds; none without times."""
    skus: dict[str, int] = {}
    orders: dict[str, dict[int, None]] = defaultdict(dict)
    arrivals: dict[str, float] = {}
    with file.open(newline="", encoding="utf-8") as table:
        for row in csv.DictReader(line for line in table if not line.startswith("#")):
            orders[row["order"]][skus.setdefault(row["sku"], len(skus))] = None
            if row.get("arrival_s"):
                arrivals.setdefault(row["order"], float(row["arrival_s"]))
    return [list(order) for order in orders.values()], list(arrivals.values())


def per_mille(counts: NDArray[np.int64]) -> list[int]:
    """Return counts as shares of 1,000, rounded such that they add up to it."""
    until = np.round(1000 * counts.cumsum() / counts.sum()).astype(int)
    return np.diff(until, prepend=0).tolist()  # type: ignore[no-any-return]


def fit_demand(counts: NDArray[np.int64]) -> SkuDemand:
    """Return the demand that makes counts of SKUs, the most wanted first, most likely."""
    by_rank = np.sort(counts)[::-1]
    choices = [SkuDemand(round(0.05 * n, 2), shift) for n in range(41) for shift in SHIFTS]
    return max(choices, key=lambda demand: float((by_rank * np.log(sku_demand(len(counts), demand))).sum()))


def fit_together(orders: Sequence[Sequence[int]], skus: int, lines: Sequence[int], demand: SkuDemand) -> float:
    """Return the share of lines from the group of another one with which generated orders are as alike as these."""
    some = [orders[i] for i in np.linspace(0, len(orders) - 1, min(len(orders), MOST_ORDERS)).astype(int)]
    wanted = alike(some, skus)
    print(f"# With an SKU comes the one that goes with it in {wanted:.1%} of orders more than chance would have it.")

    def off(together: float) -> float:
        made = SkuDemand(demand.exponent, demand.shift, -(-skus // GROUP), together)
        section = InstanceSection(
            orders=len(some), skus=skus, pods=skus, skus_per_pod=1, lines=tuple(lines), demand=made
        )
        generated = [[sku for sku, _ in order.lines] for order in generate_instance(section, 1).orders]
        return abs(alike(generated, skus) - wanted)

    return min((round(0.1 * n, 2) for n in range(10)), key=off)


def alike(orders: Sequence[Sequence[int]], skus: int) -> float:
    """Return how much more often than chance orders have the SKU that goes with one of theirs, as a share."""
    table = np.zeros((len(orders), skus), np.float32)
    for number, order in enumerate(orders):
        table[number, order] = 1
    seen, others = table[::2], table[1::2]
    excess = seen.T @ seen - np.outer(seen.sum(axis=0), seen.mean(axis=0))
    np.fill_diagonal(excess, -np.inf)
    mate = excess.argmax(axis=1)
    both, alone = (others * others[:, mate]).sum(), others.sum(axis=0)
    return float((both - alone @ others.mean(axis=0)[mate]) / alone.sum())


if __name__ == "__main__":
    main()
