"""The search for the fewest robots, for one number of stations after the other.

It takes for granted that more robots do no harm, nor more stations. That is not always so: robots stand in each other's
way. So it looks once more beside what it finds, and says what it did not try.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from attrs import frozen

Passes = Callable[[int, int], bool]
"""Whether so many stations with so many robots are enough."""


@frozen
class Found:
    """What came of a number of stations.

    Parameters
    ----------
    stations
        How many.
    robots
        The fewest robots found to be enough, None where none are.
    reason
        Why there are none.
    """

    stations: int
    robots: int | None
    reason: str | None = None


def fewest(passes: Callable[[int], bool], least: int, most: int, start: int, step: int = 1) -> int | None:
    """Return the fewest of ``least`` to ``most`` that pass, None where none is found.

    From ``start`` on the steps double until there is one that passes and one below that fails; then halves. What has
    one below that fails may have another below that passes: the one after is tried, too, and the search goes on from
    there if it does.
    """
    good, bad = None, least - 1
    tried = min(max(start, least), most)
    if passes(tried):
        good = tried
        while good > least:
            tried = max(good - step, least)
            if not passes(tried):
                bad = tried
                break
            good, step = tried, 2 * step
    else:
        bad = tried
        while bad < most and good is None:
            tried = min(bad + step, most)
            if passes(tried):
                good = tried
            else:
                bad, step = tried, 2 * step
        if good is None:
            return None
    while good - bad > 1:
        middle = (good + bad) // 2
        if passes(middle):
            good = middle
        else:
            bad = middle
    if good - 2 >= least and passes(good - 2):
        return fewest(passes, least, good - 2, good - 2)
    return good


def search(
    passes: Passes, stations: Sequence[int], robots: tuple[int, int], start: tuple[int, int]
) -> tuple[Found, ...]:
    """Return what comes of each number of stations, ascending.

    Of the numbers of stations that one nearest to the start comes first, then those below it, each from the robots that
    the one before needs; when none are enough for one, those below it are not tried. Then those above: of them only
    what saves a robot is sought.

    Parameters
    ----------
    passes
        Whether stations and robots are enough.
    stations
        Numbers of stations, at least one, ascending.
    robots
        The fewest and the most robots.
    start
        Stations and robots to begin with.
    """
    least, most = robots
    wide = max(start[1] // 2, 1)
    first = min(stations, key=lambda number: (abs(number - start[0]), number))

    found: dict[int, int | None] = {first: fewest(partial(passes, first), least, most, start[1], wide)}
    reasons = {} if found[first] else {first: not_enough(most)}
    before = first
    for number in reversed([one for one in stations if one < first]):
        needed = found[before]
        if needed is None:
            found[number], reasons[number] = None, f"not tried: {before} stations are too few already"
            continue
        found[number] = fewest(partial(passes, number), least, most, needed)
        if found[number] is None:
            reasons[number] = not_enough(most)
        before = number
    best = found[first]
    for number in (one for one in stations if one > first):
        at = partial(passes, number)
        if best is None:
            best = found[number] = fewest(at, least, most, start[1], wide)
            if best is None:
                reasons[number] = not_enough(most)
            continue
        found[number] = fewest(at, least, best - 1, best - 1) if best > least else None
        if found[number] is None:
            reasons[number] = "saves no robot"
        best = found[number] or best
    return tuple(Found(number, found[number], reasons.get(number)) for number in stations)


def not_enough(most: int) -> str:
    """Say that none are enough."""
    return f"no number of robots up to {most} is enough"


def frontier(found: Sequence[Found]) -> tuple[Found, ...]:
    """Return what needs fewer robots than everything with fewer stations."""
    kept: list[Found] = []
    for one in sorted(found, key=lambda one: one.stations):
        if one.robots is not None and (not kept or one.robots < (kept[-1].robots or 0)):
            kept.append(one)
    return tuple(kept)
