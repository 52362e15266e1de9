"""The search of `pbs`: nodes, and which of two robots goes first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from attrs import frozen

from rmfs_core.decisions import Path
from rmfs_rules.sipp.rule import Sipp
from rmfs_traffic import (
    FleetTraffic,
    Occupancy,
    Query,
    Reservations,
    ReservedError,
    TimedPath,
    occupancy,
)

ANYONE = -1
"""The reservations of all robots that go before another: their paths may still cross."""


@frozen(eq=False)
class Way:
    """How a robot gets to its goal.

    Parameters
    ----------
    path
        Its new path; None where it keeps the one that it has.
    occupied
        Cells that it occupies, the leg under way included.
    arrives
        Tick at which it is there.
    """

    path: TimedPath | None
    occupied: Occupancy
    arrives: int


@frozen(eq=False)
class Node:
    """A way for each robot, and who goes before whom."""

    ways: dict[int, Way]
    before: frozenset[tuple[int, int]]

    @property
    def cost(self) -> int:
        """Sum of all arrivals."""
        return sum(way.arrives for way in self.ways.values())

    def ahead(self, robot: int) -> set[int]:
        """Return all that go before a robot."""
        return _reached(robot, {(later, first) for first, later in self.before})

    def behind(self, robot: int) -> list[int]:
        """Return a robot and all that come after it, nobody before one that goes before it."""
        found = _reached(robot, self.before) | {robot}
        return sorted(found, key=lambda one: (len(self.ahead(one) & found), one))


class Search:
    """One round of planning.

    Parameters
    ----------
    sipp
        Finds each path.
    queries, traffic
        Arguments of the rule's hook.
    """

    def __init__(self, sipp: Sipp, queries: Sequence[Query], traffic: FleetTraffic) -> None:
        self.sipp, self.roads, self.traffic = sipp, traffic.roads, traffic
        self.queries = {query.robot: query for query in queries}
        self.setting_out = [query for query in queries if query.robot not in traffic.arrives]

    def best(self, most: int) -> dict[int, Path]:
        """Return the new paths of the best node, after so many nodes at most."""
        kept = {
            robot: Way(None, self.traffic.reserved[robot], arrives) for robot, arrives in self.traffic.arrives.items()
        }
        first = self._one_after_another(self.traffic.table.copy())
        best = Node({**kept, **first}, frozenset())
        if kept and most and len(first) == len(self.setting_out):
            self.fixed = self.traffic.table.copy()
            for robot in self.queries:
                self.fixed.release(robot)
                if robot in self.traffic.under_way:
                    self.fixed.add(robot, self.traffic.under_way[robot])
            alone = self._one_after_another(self.fixed.copy())
            sooner = sum(way.arrives for way in alone.values()) < sum(way.arrives for way in first.values())
            if sooner and len(alone) == len(first):  # who goes before others may bar the way of one of them
                in_order = frozenset(pairwise(query.robot for query in self.setting_out))
                best = self._search(Node({**kept, **alone}, in_order), best, most)
        return {robot: way.path.path for robot, way in best.ways.items() if way.path is not None}

    def _one_after_another(self, table: Reservations) -> dict[int, Way]:
        """Plan for robots that set out, in the order given, in a table of one's own."""
        ways = {}
        for query in self.setting_out:
            way = self._way(query, table)
            if way is not None:
                table.commit(query.robot, way.occupied)
                ways[query.robot] = way
        return ways

    def _way(self, query: Query, table: Reservations) -> Way | None:
        path = self.sipp.search(self.roads, table, query)
        if path is None:
            return None
        new, under_way = occupancy(self.roads, path), self.traffic.under_way.get(query.robot)
        if under_way is not None:
            pairs = ((under_way.cells, new.cells), (under_way.since, new.since), (under_way.until, new.until))
            new = Occupancy(*(np.concatenate(pair) for pair in pairs))
        return Way(path, new, path.end_tick)

    def _search(self, root: Node, best: Node, most: int) -> Node:
        stack = [root]
        while stack and most:
            node = stack.pop()
            if node.cost >= best.cost:
                continue
            most -= 1
            crossing = self._first_crossing(node)
            if crossing is None:
                best = node
                continue
            children = [child for child in self._children(node, *crossing) if child.cost < best.cost]
            stack += sorted(children, key=lambda child: -child.cost)
        return best

    def _first_crossing(self, node: Node) -> tuple[int, int] | None:
        table = self.fixed.copy()
        for robot, way in node.ways.items():
            try:
                table.commit(robot, way.occupied)
            except ReservedError as error:
                return error.owner, robot
        return None

    def _children(self, node: Node, one: int, other: int) -> Iterator[Node]:
        for first, later in ((one, other), (other, one)):
            if first not in node.ways or later in node.ahead(first):
                continue
            child = self._again(Node(dict(node.ways), node.before | {(first, later)}), later)
            if child is not None:
                yield child

    def _again(self, node: Node, robot: int) -> Node | None:
        """Plan for a robot again, and for all behind it that cross somebody ahead; None where one finds no path."""
        for one in node.behind(robot):
            table = self.fixed.copy()
            for other in sorted(node.ahead(one)):
                table.release(other)
                table.add(ANYONE, node.ways[other].occupied)
            if one == robot or not table.is_free(one, node.ways[one].occupied):
                way = self._way(self.queries[one], table)
                if way is None:
                    return None
                node.ways[one] = way
        return node


def _reached(robot: int, steps: Iterable[tuple[int, int]]) -> set[int]:
    steps = set(steps)
    found: set[int] = set()
    waiting = [robot]
    while waiting:
        one = waiting.pop()
        new = {later for first, later in steps if first == one} - found
        found |= new
        waiting += sorted(new)
    return found
