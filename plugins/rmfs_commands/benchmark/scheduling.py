"""Whole schedules for instances whose orders are all there at the start: from a cover of pods, then by annealing."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from attrs import frozen

from rmfs_commands.benchmark.annealing import STOP, Ints, Work, anneal
from rmfs_commands.benchmark.plans import Plan
from rmfs_commands.benchmark.sets import Frozen
from rmfs_commands.bounds.cover import cheapest_cover
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.simulation.setup import open_warehouse
from rmfs_core.world import Instance, make_instance, make_layout

MANY = 1 << 40
STEPS = 1_000_000
"""Changes that annealing tries in the first round; in the next one twice as many, then three times."""
HOT_S, COLD_S = 3.0, 0.02
MOST_NODES = 20_000
"""Nodes of branch and bound for the pods of the first schedule."""
WEIGHTS = {"pod_station_visits": (1.0, 1e4, 0.0), "turnover_s": (1.0, 0.1, 0.0), "makespan_s": (0.02, 0.02, 1.0)}
"""Costs of a schedule for each objective: seconds of mean turn-over, visits, seconds of makespan."""
WEIGHTS["distance_m"] = WEIGHTS["pod_station_visits"]


@frozen(eq=False)
class Problem:
    """A static instance, as schedules are made for it.

    Parameters
    ----------
    instance
        Orders and pods.
    work
        The same for `anneal`.
    metres
        From each pod to each station. Shape (pods, stations).
    """

    instance: Instance
    work: Work
    metres: Ints

    @classmethod
    def of(cls, one: Frozen, objective: str) -> Problem:
        """Return the problem of an instance.

        Raises
        ------
        InputError
            When it has no such schedules.
        """
        scenario, instance = one.scenario, make_instance(one.scenario)
        lines = [(order, *line) for order, data in enumerate(instance.orders) for line in data.lines]
        if not one.static or objective not in WEIGHTS or any(quantity != 1 for *_, quantity in lines):
            expected = "all orders there at the start, one item a line, and no packing"
            raise InputError(one.name, f"there are no schedules of it for {objective}; expected {expected}")
        warehouse = open_warehouse(scenario, instance, make_layout(scenario)).warehouse
        travel, picking = warehouse.travel, warehouse.picking
        cells = [pod.cell for pod in warehouse.pods]
        width = travel.layout.width
        rows, columns = np.divmod(np.array(cells), width)
        to = [np.asarray(travel.times_to(station.cell, True))[cells].min(axis=1) for station in picking]
        metres = [abs(rows - s.cell // width) + abs(columns - s.cell % width) for s in picking]
        stock = np.zeros((len(instance.pods), len(instance.skus)), np.int64)
        for pod, data in enumerate(instance.pods):
            for sku, items in data.contents:
                stock[pod, sku] = MANY if items is None else items
        work = Work(
            order=np.array([order for order, *_ in lines]),
            sku=np.array([sku for _, sku, _ in lines]),
            orders=len(instance.orders),
            stations=len(picking),
            robots=scenario.robots.count,
            capacity=picking[0].capacity,
            stock=stock,
            first=np.array([travel.times_from(r.cell, r.heading, False)[cells] for r in warehouse.robots])
            / TICKS_PER_S,
            carry=np.array(to).T / TICKS_PER_S,
            store=15.0,
            swap=4.0,
            pick=float(scenario.stations.pick_s),
            handle=float(scenario.stations.handle_s),
            weights=np.array(WEIGHTS[objective]),
        )
        return cls(instance, work, np.array(metres).T)

    def first(self, objective: str) -> tuple[Ints, Ints]:
        """Return a schedule with few visits, or short ways: the lines of each station in sequence, and their pods."""
        near, work = objective == "distance_m", self.work
        costs = [int(way) for way in self.metres.min(axis=1) + 1] if near else [1] * len(work.stock)
        cover = cheapest_cover(self.instance, costs, MOST_NODES)
        left, pod_of = work.stock.copy(), np.full(len(work.sku), -1)
        by_pod: dict[int, list[int]] = defaultdict(list)
        for pod in cover.pods:
            for line, sku in enumerate(work.sku.tolist()):
                if pod_of[line] < 0 and left[pod, sku] > 0:
                    left[pod, sku] -= 1
                    pod_of[line] = pod
                    by_pod[pod].append(line)
        stations: list[list[int]] = [[] for _ in range(work.stations)]
        for pod, of_pod in sorted(by_pod.items(), key=lambda entry: -len(entry[1])):
            least = min(range(work.stations), key=lambda at: (self.metres[pod, at] if near else 0, len(stations[at])))
            stations[least] += of_pod
        sequence: list[int] = []
        for at, of_station in enumerate(stations):
            sequence += [STOP] * (at > 0) + of_station
        return np.array(sequence), pod_of

    def improved(
        self, schedule: tuple[Ints, Ints], seed: int, pace: float, steps: int = STEPS, hot: float = HOT_S
    ) -> tuple[Ints, Ints]:
        """Return a schedule that annealing leads to.

        Parameters
        ----------
        schedule
            Where it begins.
        pace
            How long driving takes in the evaluator, as a multiple of what it takes alone.
        seed, steps, hot
            As `anneal` has them.
        """
        work = self.work._replace(
            carry=self.work.carry * pace, first=self.work.first * pace, store=self.work.store * pace
        )
        sequence, pod_of, _ = anneal(*schedule, work, steps, hot, COLD_S, seed)
        return sequence, pod_of

    def plan(self, schedule: tuple[Ints, Ints]) -> Plan:
        """Return a schedule as visits."""
        sequence, pod_of = schedule
        stations: list[list[tuple[int, list[tuple[int, int]]]]] = [[]]
        for line in sequence.tolist():
            if line == STOP:
                stations.append([])
                continue
            visits, pod = stations[-1], int(pod_of[line])
            if not visits or visits[-1][0] != pod:
                visits.append((pod, []))
            visits[-1][1].append((int(self.work.order[line]), int(self.work.sku[line])))
        return tuple(tuple((pod, tuple(lines)) for pod, lines in visits) for visits in stations)
