"""The fewest robots and stations for a target: from the question to the answer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from attrs import frozen

from rmfs_commands.cli.serving import SERVING
from rmfs_commands.experiments import Watcher
from rmfs_commands.experiments.resolving import resolve
from rmfs_commands.experiments.workers import Workers
from rmfs_commands.sizing.judging import FIRST_LOOK, Verdict
from rmfs_commands.sizing.searching import Found, frontier, search
from rmfs_commands.sizing.target import Target
from rmfs_commands.sizing.trials import Candidate, Trials
from rmfs_commands.sizing.worlds import Worlds
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario

TIMES = 2, 4
"""The most stations and robots that are tried, as multiples of the scenario's, where nothing else is asked for."""

MOST_STATIONS = 200
"""Each has a row of its own."""

Range = tuple[int, int]


@frozen
class OtherRules:
    """What `SERVING` rules do in a size in which the scenario's rules fail.

    Parameters
    ----------
    judged
        The size, judged with these rules.
    least
        What no rules can beat there, mean over the first seeds; None where no bound is known.
    """

    judged: Candidate
    least: float | None


@frozen
class Answer:
    """What was found.

    Parameters
    ----------
    scenario
        Its name.
    target
        What was asked for.
    stations
        What came of each number of stations, ascending.
    frontier
        The sizes that are enough and have fewer robots than every one with fewer stations.
    candidates
        All that was judged, by stations and robots.
    at_once
        Whether all orders arrive at the same time.
    other_rules
        What other rules do in a size that fails; None where none fails, or the scenario has these rules.
    """

    scenario: str
    target: Target
    stations: tuple[Found, ...]
    frontier: tuple[Candidate, ...]
    candidates: tuple[Candidate, ...]
    at_once: bool
    other_rules: OtherRules | None = None

    @property
    def failed(self) -> int:
        """Runs that an error ended."""
        return sum(one.failed for one in self.candidates)

    @property
    def undecided(self) -> tuple[Candidate, ...]:
        """What would be better than the frontier, or on it, if more seeds decided for it."""
        return tuple(
            one
            for one in self.candidates
            if one.verdict is Verdict.UNDECIDED
            and not any(best.stations <= one.stations and best.robots <= one.robots for best in self.frontier)
        )

    def cheapest(self, robot_cost: float, station_cost: float) -> tuple[Candidate, float] | None:
        """Return what costs least of the frontier, with its cost; of equals what has fewest stations."""
        costs = [(one, robot_cost * one.robots + station_cost * one.stations) for one in self.frontier]
        return min(costs, key=lambda priced: priced[1]) if costs else None


def size(
    scenario: Scenario,
    name: str,
    target: Target,
    *,
    store: str | Path,
    workers: Workers,
    stations: Range | None = None,
    robots: Range | None = None,
    watcher: Watcher | None = None,
    tell: Callable[[Candidate], None] = lambda _: None,
    allow_inline_rules: bool = True,
) -> Answer:
    """Search for the fewest robots and stations that keep a target.

    Parameters
    ----------
    scenario
        The load, the rules, and the size to begin with.
    name
        What messages call it.
    target
        What is asked for.
    store
        Folder of finished runs; what is there is not run again.
    workers
        Who runs them.
    stations, robots
        The fewest and the most; None: 1 to `TIMES` as many as the scenario has.
    watcher, allow_inline_rules
        As `rmfs_commands.experiments.run_experiment` has them.
    tell
        Is told of every size as soon as it is judged.

    Raises
    ------
    InputError
        When the layout has no room for a range, or the metric is unknown, not measured, or better when larger.
    RunError
        When a run ends without any result. (One that a rule's misbehaviour ends makes its size fail.)
    """
    worlds = Worlds(scenario, target.seeds[:FIRST_LOOK])
    target.check(worlds.instances)
    fixed = worlds.n_stations
    if worlds.on_a_map and stations not in (None, (fixed, fixed)):
        raise InputError("--stations", f"the map of the scenario has {fixed}; expected a scenario without a map")
    least, most = (fixed, fixed) if worlds.on_a_map else stations or (1, TIMES[0] * fixed)
    if most > MOST_STATIONS:
        raise InputError("--stations", f"found {most:,}; expected {MOST_STATIONS} at most")
    few, many = robots or (1, min(TIMES[1] * scenario.robots.count, worlds.places))
    if many > worlds.places:
        raise InputError("--robots", f"found {many:,}; the layout has {worlds.places:,} places to park them")
    impossible: dict[int, str] = {}
    for number in range(least, most + 1):
        why = worlds.overload(number) or worlds.obstacle(number, many, target)
        if why is not None:
            impossible[number] = why
    possible = [number for number in range(least, most + 1) if number not in impossible]
    found = [Found(number, None, why) for number, why in impossible.items()]
    judged: dict[tuple[int, int], Candidate] = {}
    if possible:
        trials = Trials(worlds, name, target, Path(store), workers, watcher or Watcher(), tell, allow_inline_rules)
        found += search(trials.passes, possible, (few, many), (fixed, scenario.robots.count))
        judged = trials.judged
    found.sort(key=lambda one: one.stations)
    best = tuple(judged[one.stations, one.robots] for one in frontier(found) if one.robots is not None)
    every = tuple(judged[key] for key in sorted(judged))
    own = fixed, scenario.robots.count
    failing = [one for one in every if one.verdict is Verdict.FAILS and one.seeds and not one.failed]
    failing = [one for one in failing if (one.stations, one.robots) == own] if best else failing
    other = None
    served = resolve(scenario, SERVING, scenario.folder, name)
    if failing and served.rules != scenario.rules:
        of_size = max((one.stations, one.robots) for one in failing)
        worlds = Worlds(served, target.seeds[:FIRST_LOOK])
        trials = Trials(worlds, name, target, Path(store), workers, watcher or Watcher(), tell, allow_inline_rules)
        trials.passes(*of_size)
        other = OtherRules(trials.judged[of_size], worlds.least(*of_size, target))
    return Answer(name, target, tuple(found), best, every, worlds.at_once, other)
