"""The search for the fewest robots, for one number of stations after the other; or the fewest boxes, of packers.

It takes for granted that more robots do no harm, nor more stations. That is not always so: robots stand in each other's
way. So it looks once more around what it finds, and says what it did not try.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from attrs import frozen

Passes = Callable[[int, int], bool]
"""Whether so many stations with so many robots are enough."""


@frozen
class Things:
    """The two kinds of things whose fewest are sought, each by its singular and plural."""

    first: tuple[str, str]
    second: tuple[str, str]

    def counted(self, first: int, second: int, between: str = ", ") -> str:
        """Return a size in words."""
        return f"{first} {self.first[first != 1]}{between}{second} {self.second[second != 1]}"


ROBOTS = Things(("station", "stations"), ("robot", "robots"))
BOXES = Things(("packer", "packers"), ("box", "boxes"))
"""Of each packing station."""


@frozen
class Found:
    """Results for a number of stations, or of packers.

    Parameters
    ----------
    first
        How many.
    second
        The fewest robots, or boxes, found to be enough, None where none are.
    reason
        Why there are none.
    """

    first: int
    second: int | None
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
    passes: Passes,
    stations: Sequence[int],
    robots: tuple[int, int],
    start: tuple[int, int],
    things: Things = ROBOTS,
) -> tuple[Found, ...]:
    """Return what comes of each number of stations, ascending; with packers and boxes it is the same.

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
    things
        Their name in messages.
    """
    least, most = robots
    wide = max(start[1] // 2, 1)
    first = min(stations, key=lambda number: (abs(number - start[0]), number))

    found: dict[int, int | None] = {first: fewest(partial(passes, first), least, most, start[1], wide)}
    none = f"no number of {things.second[1]} up to {most} is shown to be enough"
    reasons = {} if found[first] else {first: none}
    before = first
    for number in reversed([one for one in stations if one < first]):
        needed = found[before]
        if needed is None:
            found[number], reasons[number] = None, f"not tried: {before} {things.first[1]} are not shown to be enough"
            continue
        found[number] = fewest(partial(passes, number), least, most, needed)
        if found[number] is None:
            reasons[number] = none
        before = number
    best = found[first]
    for number in (one for one in stations if one > first):
        at = partial(passes, number)
        if best is None:
            best = found[number] = fewest(at, least, most, start[1], wide)
            if best is None:
                reasons[number] = none
            continue
        found[number] = fewest(at, least, best - 1, best - 1) if best > least else None
        if found[number] is None:
            reasons[number] = f"saves no {things.second[0]}"
        best = found[number] or best
    return tuple(Found(number, found[number], reasons.get(number)) for number in stations)


def frontier(found: Sequence[Found]) -> tuple[Found, ...]:
    """Return what needs fewer robots than everything with fewer stations, or fewer boxes with fewer packers."""
    kept: list[Found] = []
    for one in sorted(found, key=lambda one: one.first):
        if one.second is not None and (not kept or one.second < (kept[-1].second or 0)):
            kept.append(one)
    return tuple(kept)
