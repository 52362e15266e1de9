"""First paths for all robots together, by LaCAM: a search over configurations, in steps of one cell.

A configuration has a cell for each robot. In a step each robot stays or moves to a neighbouring cell; the moves of a
step can be made one after another, each into a cell that is empty then: no two robots change places, and no robots
move round in a ring. Robots that move one after another so can drive so, whatever their kinematics.

LaCAM looks for a sequence of configurations depth first. It makes the next configuration of one by PIBT: robots choose
their moves in the order of a priority that grows until they are at their goals, and push robots that have not chosen
yet out of their ways. Of those that push or follow one another, the first few move in a step and the others later: each
sets out when the one ahead has left its cell, so a long column takes many times a step. In a corridor, where two robots
have to change places, one is led backwards until the other can pass. If that goes round in circles, the search forces
moves on more and more robots of a configuration: it is complete.

Sources: K. Okumura, LaCAM: search-based algorithm for quick multi-agent pathfinding, AAAI 2023,
https://doi.org/10.1609/aaai.v37i10.26377; K. Okumura, M. Machida, X. Defago, Y. Tamura, Priority inheritance with
backtracking for iterative multi-agent path finding, Artificial Intelligence 310, 2022,
https://doi.org/10.1016/j.artint.2022.103752; K. Okumura, Improving LaCAM for scalable eventually optimal multi-agent
pathfinding, IJCAI 2023, https://doi.org/10.24963/ijcai.2023/28 (how robots change places).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from itertools import pairwise
from operator import eq
from random import Random

import numpy as np
from attrs import define, field

from rmfs_commands.plan.movingai import Trip
from rmfs_core.clock import UNREACHABLE
from rmfs_core.decisions import Leg
from rmfs_core.world import NORTH
from rmfs_traffic import FOREVER, Query, Roads, TimedPath, timed_path

FAR = 1 << 30
"""Steps to a goal from where there is no way to it."""
BEHIND = 3
"""How many robots follow one in a step, each into the cell that the one ahead leaves."""
Cells = tuple[int, ...]
Moves = tuple[tuple[int, int], ...]
_Options = tuple[int, Iterator[int], tuple[int, int] | None]
"""Of a robot in a step: the cells that it may choose, the best first, and whom it leads if it gets which one."""


@define(eq=False)
class _Node:
    """A configuration, and moves that are to be forced on its robots: (robot, cell) pairs, the fewest first."""

    cells: Cells
    parent: _Node | None
    priorities: list[float]
    order: list[int]
    forced: deque[Moves] = field(factory=lambda: deque([()]))


def first_paths(roads: Roads, trips: Sequence[Trip], most: int, rng: np.random.Generator) -> list[TimedPath]:
    """Return paths that keep clear of each other and bring robots to their goals; all face north and start at 0.

    Parameters
    ----------
    roads
        The layout.
    trips
        One for each robot.
    most
        How many configurations the search makes at most, besides one for each cell of the longest way.
    rng
        Decides between moves that are alike.

    Returns
    -------
    list[TimedPath]
        One for each robot. Where the trips have no solution, or none was found with so many configurations, those that
        bring the most robots to their goals, and others elsewhere; a robot without a way to its goal ends at its start.
    """
    lacam = _Lacam(roads, trips, Random(int(rng.integers(1 << 32))))
    longest = max(min(steps[cell], roads.cells) for steps, cell in zip(lacam.steps, lacam.starts, strict=True))
    return _driven(roads, trips, _without_detours(lacam.solve(most + longest)))


class _Lacam:
    """The search."""

    def __init__(self, roads: Roads, trips: Sequence[Trip], draws: Random) -> None:
        self.starts, self.draws = tuple(trip.start for trip in trips), draws
        ways = [roads.travel.ticks(trip.start, NORTH, trip.goal, False) < UNREACHABLE for trip in trips]
        self.goals = tuple(trip.goal if there else trip.start for trip, there in zip(trips, ways, strict=True))
        moves, offsets = roads.layout.moves.tolist(), roads.travel.offsets.tolist()
        self.next_to = [[cell + offsets[h] for h in range(4) if moves[cell] >> h & 1] for cell in range(roads.cells)]
        into: list[list[int]] = [[] for _ in self.next_to]
        for cell, others in enumerate(self.next_to):
            for other in others:
                into[other].append(cell)
        passable = [roads.travel.passable(goal, False).tolist() for goal in self.goals]
        self.steps = [_steps_to(goal, into, may) for goal, may in zip(self.goals, passable, strict=True)]
        self.stays = [not may[goal] for goal, may in zip(self.goals, passable, strict=True)]

    def solve(self, most: int) -> list[Cells]:
        """Return configurations from the starts to the goals, or else to where the most robots are at theirs."""
        stack = [self._node(self.starts, None)]
        nodes = {self.starts: stack[0]}
        for _ in range(most):
            while stack and not stack[-1].forced:
                stack.pop()
            if not stack or stack[-1].cells == self.goals:
                break
            cells = _Step(self, stack[-1]).made(self._next_forced(stack[-1]))
            if cells is not None:
                if cells not in nodes:
                    nodes[cells] = self._node(cells, stack[-1])
                stack.append(nodes[cells])
        node = nodes.get(self.goals) or max(nodes.values(), key=lambda one: sum(map(eq, one.cells, self.goals)))
        found = [node.cells]
        while node.parent is not None:
            node = node.parent
            found.append(node.cells)
        return found[::-1]

    def _next_forced(self, node: _Node) -> Moves:
        """Return the next moves to be forced, and note those that force one robot more."""
        forced = node.forced.popleft()
        if len(forced) < len(node.order):
            robot = node.order[len(forced)]
            node.forced += [(*forced, (robot, cell)) for cell in self.wishes(robot, node.cells[robot])]
        return forced

    def wishes(self, robot: int, cell: int) -> list[int]:
        """Return where a robot may move to, its own cell included: the one with the fewest steps to its goal first."""
        steps = self.steps[robot]
        if self.stays[robot] and steps[cell] == 0:
            return [cell]
        options = [cell, *(other for other in self.next_to[cell] if steps[other] < FAR)]
        self.draws.shuffle(options)
        return sorted(options, key=steps.__getitem__)

    def _node(self, cells: Cells, parent: _Node | None) -> _Node:
        """Return a node whose robots have priority by how long ago they were at their goals, or how far they start."""
        if parent is None:
            priorities = [self.steps[robot][cell] / FAR for robot, cell in enumerate(cells)]
        else:
            went = zip(parent.priorities, cells, self.goals, strict=True)
            priorities = [old % 1 if cell == goal else old + 1 for old, cell, goal in went]
        return _Node(cells, parent, priorities, sorted(range(len(cells)), key=lambda robot: -priorities[robot]))


def _steps_to(goal: int, into: Sequence[Sequence[int]], passable: Sequence[bool]) -> list[int]:
    """Return how many steps each cell that robots may cross is from a goal, `FAR` for any other."""
    steps = [FAR] * len(into)
    steps[goal] = 0
    waiting = deque([goal])
    while waiting:
        cell = waiting.popleft()
        for other in into[cell]:
            if passable[other] and steps[other] == FAR:
                steps[other] = steps[cell] + 1
                waiting.append(other)
    return steps


class _Step:
    """Where the robots of a configuration move in one step: PIBT."""

    def __init__(self, lacam: _Lacam, node: _Node) -> None:
        self.lacam, self.now, self.order = lacam, node.cells, node.order
        self.at = {cell: robot for robot, cell in enumerate(node.cells)}
        self.to: dict[int, int] = {}
        self.taken: set[int] = set()

    def made(self, forced: Moves) -> Cells | None:
        """Return the next configuration; None if none was found with the moves forced."""
        for robot, cell in forced:
            if not self._may(robot, cell):
                return None
            self._choose(robot, cell)
        for robot in self.order:
            if robot not in self.to and not self._moves(robot):
                return None
        return tuple(self.to[robot] for robot in range(len(self.now)))

    def _choose(self, robot: int, cell: int) -> None:
        self.to[robot] = cell
        self.taken.add(cell)

    def _may(self, robot: int, cell: int) -> bool:
        """Whether nobody else moves to a cell, and the robot would follow few others, none of which follows it."""
        return cell not in self.taken and self._behind(robot, cell) <= BEHIND

    def _behind(self, robot: int, cell: int) -> int:
        """Return how many robots, of those that have chosen, a robot would follow to a cell; `FAR` in a ring."""
        behind, ahead = 0, None if cell == self.now[robot] else self.at.get(cell)
        while ahead in self.to and ahead != robot:
            behind, ahead = behind + 1, self.at.get(self.to[ahead])
        return FAR if ahead == robot else behind

    def _moves(self, first: int) -> bool:
        """Choose a move for a robot, and for all that it pushes; False if it can neither move nor stay."""
        pushing = [self._options(first)]
        while pushing:
            robot, options, _ = pushing[-1]
            cell = next((cell for cell in options if self._may(robot, cell)), None)
            if cell is None:
                self._choose(robot, self.now[robot])
                pushing.pop()
                continue
            self._choose(robot, cell)
            pushed = self.at.get(cell, robot)
            if pushed in self.to:
                self._settle(pushing, BEHIND + 1 - self._behind(robot, cell))
                return True
            pushing.append(self._options(pushed))
        return False

    def _settle(self, pushing: Sequence[_Options], number: int) -> None:
        """Let so many of the last of some robots move that push one another, and whom they lead; the others stay.

        All move where the first has to, for a forced move leads into its cell.
        """
        staying = [] if self.now[pushing[0][0]] in self.taken else pushing[:-number]
        for robot, _, led in reversed(pushing[len(staying) :]):
            if led is not None and self.to[robot] == led[0]:
                other, cell = led[1], self.now[robot]
                if other not in self.to and self._may(other, cell):
                    self._choose(other, cell)
        self.taken.difference_update([self.to[robot] for robot, *_ in staying])
        for robot, *_ in staying:
            self._choose(robot, self.now[robot])

    def _options(self, robot: int) -> _Options:
        """Return the options of a robot, the cell that it wants first.

        Where it has to change places with another one, it backs out, and the other follows.
        """
        wishes = self.lacam.wishes(robot, self.now[robot])
        other = self._to_swap(robot, wishes[0])
        if other is None:
            return robot, iter(wishes), None
        wishes.reverse()
        return robot, iter(wishes), (wishes[0], other)

    # Changing places

    def _to_swap(self, robot: int, cell: int) -> int | None:
        """Return which neighbour has to change places with a robot that wants to move to a cell, if they can."""
        now = self.now[robot]
        if cell == now or not self._can_swap(cell, now):
            return None
        ahead = self.at.get(cell)
        if ahead is not None and ahead not in self.to and self._must_swap(robot, ahead, now, cell):
            return ahead
        behind = [self.at[near] for near in self.lacam.next_to[now] if near in self.at and near != cell]
        return next((other for other in behind if self._must_swap(other, robot, now, cell)), None)

    def _must_swap(self, pushing: int, pushed: int, back: int, front: int) -> bool:
        """Whether a robot that pushes another one along a corridor comes to no junction before it is in its way."""
        steps, others = self.lacam.steps[pushing], self.lacam.steps[pushed]
        while steps[front] < steps[back]:
            onward = self._onward(back, front)
            if len(onward) > 1:
                return False
            if not onward:
                break
            back, front = front, onward[0]
        return others[back] < others[front] and (steps[back] == 0 or steps[front] < steps[back])

    def _can_swap(self, back: int, front: int) -> bool:
        """Whether a robot that backs out of a corridor comes to a junction, where another can pass it."""
        first = back
        for _ in self.lacam.next_to:
            onward = self._onward(back, front)
            if len(onward) != 1 or onward[0] == first:
                return len(onward) > 1
            back, front = front, onward[0]
        return False

    def _onward(self, back: int, front: int) -> list[int]:
        """Return where a corridor leads, dead ends where robots are at their goals left out."""
        next_to, goals, at = self.lacam.next_to, self.lacam.goals, self.at
        return [
            cell
            for cell in next_to[front]
            if cell != back and not (len(next_to[cell]) == 1 and cell in at and goals[at[cell]] == cell)
        ]


def _without_detours(configurations: Sequence[Cells]) -> list[list[int]]:
    """Return the configurations with robots that stay where they would come back to before anybody else comes."""
    rows, changed = [list(cells) for cells in configurations], True
    while changed:
        changed = False
        last: dict[int, tuple[int, int]] = {}
        for step, row in enumerate(rows):
            for robot, cell in enumerate(row):
                who, since = last.get(cell, (robot, step))
                if who == robot and since < step - 1 and rows[since][robot] == cell:
                    changed = True
                    for between in rows[since + 1 : step]:
                        between[robot] = cell
                last[cell] = robot, step
    return rows


# As robots drive


def _driven(roads: Roads, trips: Sequence[Trip], configurations: Sequence[Sequence[int]]) -> list[TimedPath]:
    """Return the paths of robots that come to each cell in the order of the configurations, each as soon as it can."""
    routes: list[deque[int]] = [deque() for _ in trips]
    visitors: dict[int, deque[int]] = {}
    for before, after in pairwise(configurations):
        for robot, cell in enumerate(after):
            if cell != before[robot]:
                routes[robot].append(cell)
                visitors.setdefault(cell, deque()).append(robot)
    left = {trip.start: FOREVER for trip in trips}
    drivers = [_Driver(roads, trip.start, left) for trip in trips]
    while any(routes):
        for robot, route in enumerate(routes):
            cells = [drivers[robot].cell]
            while route and visitors[route[0]][0] == robot and left.get(route[0], 0) < FOREVER:
                visitors[route[0]].popleft()
                cells.append(route.popleft())
            drivers[robot].drive(cells)
    queries = [Query(robot, trip.start, NORTH, 0, trip.goal) for robot, trip in enumerate(trips)]
    return [timed_path(roads, query, tuple(driver.legs)) for query, driver in zip(queries, drivers, strict=True)]


class _Driver:
    """A robot that drives where others have left; ``left`` has the tick of each cell, `FOREVER` where a robot is."""

    def __init__(self, roads: Roads, cell: int, left: dict[int, int]) -> None:
        self.travel, self.passing = roads.travel, roads.passing
        self.cell, self.heading, self.tick, self.left = cell, NORTH, 0, left
        self.legs: list[Leg] = []

    def drive(self, cells: Sequence[int]) -> None:
        """Drive from cell to cell, in runs that set out as soon as their next cell is free."""
        while len(cells) > 1:
            heading = self.travel.heading(cells[0], cells[1])
            assert heading is not None
            ready = self.tick + int(self.travel.turns[(heading - self.heading) % 4])
            departs = max(ready, self.left.get(cells[1], 0))
            straight = [self.travel.heading(*move) == heading for move in pairwise(cells)]
            length = 1
            while length < len(straight) and straight[length] and self._is_free(cells[1 : length + 2], departs):
                length += 1
            for i in range(length):
                self.left[cells[i]] = departs + int(self.passing.leave[length, i])
            cells = cells[length:]
            self.cell, self.heading, self.tick = cells[0], heading, departs + int(self.travel.runs[length])
            self.legs.append(Leg(self.cell, departs - ready))
        self.left[self.cell] = FOREVER

    def _is_free(self, cells: Sequence[int], departs: int) -> bool:
        """Whether the cells of a run have been left when it enters them."""
        enter = self.passing.enter[len(cells)].tolist()
        return all(departs + enter[i] >= self.left.get(cell, 0) for i, cell in enumerate(cells, 1))
