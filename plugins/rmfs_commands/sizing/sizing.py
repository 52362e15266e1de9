"""The fewest robots and stations, or packers and boxes, for a target: from the question to the answer."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from pathlib import Path
from statistics import fmean

from attrs import frozen

from rmfs_commands.cli.serving import SERVING
from rmfs_commands.experiments import Watcher
from rmfs_commands.experiments.resolving import resolve
from rmfs_commands.experiments.workers import Workers
from rmfs_commands.sizing.judging import FIRST_LOOK, Verdict
from rmfs_commands.sizing.searching import ROBOTS, Found, Things, frontier, search
from rmfs_commands.sizing.target import Target
from rmfs_commands.sizing.trials import Candidate, Trials
from rmfs_commands.sizing.worlds import PackingWorlds, Range, Worlds
from rmfs_core.scenario import Scenario


def costs_of(candidates: Iterable[Candidate]) -> dict[tuple[int, int], float]:
    """Return what an order costs in each size that is enough, mean over the seeds that all of these ran."""
    priced = [one for one in candidates if one.verdict is Verdict.PASSES and one.costs]
    seeds = min((len(one.costs) for one in priced), default=0)
    return {(one.first, one.second): fmean(one.costs[:seeds]) for one in priced}


def _beside(first: int, second: int) -> tuple[tuple[int, int], ...]:
    """Return the sizes with one more or less of either."""
    return ((first, second - 1), (first, second + 1), (first - 1, second), (first + 1, second))


def seek_cheapest(trials: Trials, firsts: Sequence[int], seconds: Range) -> None:
    """Judge sizes next to the one in which an order costs least, until none of them in the ranges is cheaper.

    The fewest robots are not always the cheapest: with more of them fewer orders are late, and people go home earlier.
    """
    while costs := costs_of(trials.judged.values()):
        first, second = min(costs, key=lambda size: (costs[size], size))
        inside = [one for one in _beside(first, second) if one[0] in firsts and seconds[0] <= one[1] <= seconds[1]]
        if not (untried := [one for one in inside if one not in trials.judged]):
            return
        for one in untried:
            trials.passes(*one)


@frozen
class OtherRules:
    """Results of `SERVING` rules in a size in which the scenario's rules fail.

    Parameters
    ----------
    judged
        The size, judged with these rules.
    least
        Bound that no rules can beat there, mean over the first seeds; None where no bound is known.
    """

    judged: Candidate
    least: float | None


@frozen
class Answer:
    """Findings.

    Parameters
    ----------
    scenario
        Its name.
    target
        The target asked for.
    found
        Findings for each number of stations, or packers, ascending.
    frontier
        The sizes that are enough and have fewer robots, or boxes, than every one with fewer stations, or packers.
    candidates
        All that was judged, by size.
    at_once
        Whether all orders arrive at the same time.
    things
        Names of the things that are sized.
    other_rules
        Verdict on other rules in a size that fails; None where none fails, or the scenario has these rules.
    """

    scenario: str
    target: Target
    found: tuple[Found, ...]
    frontier: tuple[Candidate, ...]
    candidates: tuple[Candidate, ...]
    at_once: bool
    things: Things = ROBOTS
    other_rules: OtherRules | None = None

    @property
    def failed(self) -> int:
        """Runs that an error ended, also those with other rules."""
        others = 0 if self.other_rules is None else self.other_rules.judged.failed
        return others + sum(one.failed for one in self.candidates)

    @property
    def undecided(self) -> tuple[Candidate, ...]:
        """Sizes that would be better than the frontier, or on it, if more seeds decided for them."""
        return tuple(
            one
            for one in self.candidates
            if one.verdict is Verdict.UNDECIDED
            and not any(best.first <= one.first and best.second <= one.second for best in self.frontier)
        )

    def cheapest(self, of_second: float, of_first: float) -> tuple[Candidate, float] | None:
        """Return what costs least of the frontier, with its cost; of equals what has fewest stations, or packers."""
        costs = [(one, of_second * one.second + of_first * one.first) for one in self.frontier]
        return min(costs, key=lambda priced: priced[1]) if costs else None

    @cached_property
    def costs(self) -> dict[tuple[int, int], float]:
        """The cost of an order in each size that is enough; empty where the scenario names no costs."""
        return costs_of(self.candidates)

    @property
    def least_per_order(self) -> tuple[Candidate, float] | None:
        """The size, of all that were tried and are enough, in which an order costs least, with that cost."""
        priced = [(one, self.costs[size]) for one in self.candidates if (size := (one.first, one.second)) in self.costs]
        return min(priced, key=lambda of: of[1], default=None)

    @property
    def unknown_beside_least(self) -> dict[tuple[int, int], str]:
        """Sizes with one more or less than the one in which an order costs least that may be cheaper, and why."""
        if (least := self.least_per_order) is None:
            return {}
        here, verdicts = least[0], {(one.first, one.second): one.verdict for one in self.candidates}
        unknown = {}
        for first, second in _beside(here.first, here.second):
            overloaded = first != here.first and any(one.first == first for one in self.found)  # else it were judged
            verdict = verdicts.get((first, second))
            if verdict is Verdict.UNDECIDED:
                unknown[first, second] = "undecided"
            elif verdict is None and min(first, second) > 0 and not overloaded:
                unknown[first, second] = "not tried"
        return unknown


def size(
    scenario: Scenario,
    name: str,
    target: Target,
    *,
    store: str | Path,
    workers: Workers,
    stations: Range | None = None,
    robots: Range | None = None,
    packers: Range | None = None,
    boxes: Range | None = None,
    watcher: Watcher | None = None,
    tell: Callable[[Candidate], None] = lambda _: None,
    allow_inline_rules: bool = True,
) -> Answer:
    """Search for the fewest robots and stations, or packers and boxes, that keep a target.

    Parameters
    ----------
    scenario
        The load, the rules, and the size to begin with.
    name
        Its name in messages.
    target
        The target asked for.
    store
        Folder of finished runs; what is there is not run again.
    workers
        Who runs them.
    stations, robots
        The fewest and the most; None: 1 to `TIMES` as many as the scenario has.
    packers, boxes
        Likewise, of each packing station; with one of them stations and robots are as in the scenario.
    watcher, allow_inline_rules
        As `rmfs_commands.experiments.run_experiment` has them.
    tell
        Is told of every size as soon as it is judged.

    Raises
    ------
    InputError
        When a range does not fit the layout, or the metric is unknown, not measured, or better when larger.
    RunError
        When a run ends without any result. (One that a rule's misbehaviour ends makes its size fail.)
    """
    kind, ranges = (Worlds, (stations, robots)) if packers is boxes is None else (PackingWorlds, (packers, boxes))
    worlds = kind(scenario, target.seeds[:FIRST_LOOK])
    numbers, (few, many) = worlds.ranges(*ranges)
    of_each = zip((worlds.things.first, worlds.things.second), (len(numbers) > 1, few < many), strict=True)
    target.check(worlds.instances, [plural for (_, plural), several in of_each if several])
    impossible: dict[int, str] = {}
    for number in numbers:
        why = worlds.overload(number) or worlds.obstacle(number, many, target)
        if why is not None:
            impossible[number] = why
    possible = [number for number in numbers if number not in impossible]
    found = [Found(number, None, why) for number, why in impossible.items()]
    judged: dict[tuple[int, int], Candidate] = {}
    if possible:
        trials = Trials(worlds, name, target, Path(store), workers, watcher or Watcher(), tell, allow_inline_rules)
        found += search(trials.passes, possible, (few, many), worlds.start, worlds.things)
        seek_cheapest(trials, possible, (few, many))
        judged = trials.judged
    found.sort(key=lambda one: one.first)
    best = tuple(judged[one.first, one.second] for one in frontier(found) if one.second is not None)
    every = tuple(judged[key] for key in sorted(judged))
    failing = [one for one in every if one.verdict is Verdict.FAILS and one.seeds and not one.failed]
    failing = [one for one in failing if (one.first, one.second) == worlds.start] if best else failing
    other = None
    served = resolve(scenario, SERVING, scenario.folder, name)
    if failing and served.rules != scenario.rules:
        of_size = max((one.first, one.second) for one in failing)
        worlds = kind(served, target.seeds[:FIRST_LOOK])
        trials = Trials(worlds, name, target, Path(store), workers, watcher or Watcher(), tell, allow_inline_rules)
        trials.passes(*of_size)
        other = OtherRules(trials.judged[of_size], worlds.least(*of_size, target))
    return Answer(name, target, tuple(found), best, every, worlds.at_once, worlds.things, other)
