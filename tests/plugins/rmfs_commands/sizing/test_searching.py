"""The search against brute force."""

from __future__ import annotations

import random

import pytest

from rmfs_commands.sizing.searching import Found, fewest, frontier, search


@pytest.mark.parametrize("step", [1, 4, 20])
def test_the_fewest_are_found_from_wherever_it_starts(step: int) -> None:
    """Every threshold within 3 to 30, and beyond; the steps double, so that few are tried."""
    for threshold in range(2, 33):
        for start in (1, 3, 8, 17, 30, 40):
            tried: list[int] = []

            def passes(n: int, tried: list[int] = tried, threshold: int = threshold) -> bool:
                tried.append(n)
                return n >= threshold

            expected = None if threshold > 30 else max(threshold, 3)
            assert fewest(passes, 3, 30, start, step) == expected
            assert {*tried} <= {*range(3, 31)}
            assert len(set(tried)) <= 12


def test_a_single_number_that_fails_hides_nothing() -> None:
    """12 fails though 10 is enough: the search looks there, too, and goes on."""
    assert fewest(lambda n: n >= 10 and n != 12, 1, 40, 16, 3) == 10
    assert fewest(lambda n: n in (5, 7, 9) or n > 10, 1, 40, 16, 4) == 5


@pytest.mark.parametrize("seed", range(40))
def test_the_frontier_is_that_of_the_whole_grid(seed: int) -> None:
    """Random needs, never more of one with more stations: as if everything had been tried, but with less."""
    rng = random.Random(seed)
    stations = sorted(rng.sample(range(1, 12), rng.randint(1, 9)))
    needs = dict(zip(stations, sorted((rng.randint(1, 40) for _ in stations), reverse=True), strict=True))
    tried: set[tuple[int, int]] = set()

    def passes(number: int, robots: int) -> bool:
        tried.add((number, robots))
        return robots >= needs[number]

    least, most = rng.randint(1, 5), rng.randint(20, 32)
    found = search(passes, stations, (least, most), (rng.randint(1, 12), rng.randint(1, 32)))
    best: list[tuple[int, int]] = []
    for number in stations:
        robots = next((n for n in range(least, most + 1) if n >= needs[number]), None)
        if robots is not None and all(robots < other for _, other in best):
            best.append((number, robots))
    assert [(one.stations, one.robots) for one in frontier(found)] == best
    assert [one.stations for one in found] == stations
    assert all((one.robots is None) == (one.reason is not None) for one in found)
    assert len(tried) < 0.4 * len(stations) * (most - least + 1) + 10


def test_what_is_left_out_has_its_reason() -> None:
    """Fewer stations than are too few already are not tried, and more that save nothing are named."""
    needs = {1: 99, 2: 99, 3: 12, 4: 8, 5: 8}
    found = search(lambda number, robots: robots >= needs[number], [1, 2, 3, 4, 5], (1, 16), (4, 8))
    assert found == (
        Found(1, None, "not tried: 2 stations are too few already"),
        Found(2, None, "no number of robots up to 16 is enough"),
        Found(3, 12),
        Found(4, 8),
        Found(5, None, "saves no robot"),
    )
    assert frontier(found) == (found[2], found[3])


def test_more_stations_that_need_more_robots_are_dominated() -> None:
    """What more robots with more stations would be, nobody asks for."""
    assert frontier([Found(2, 5), Found(1, 4), Found(3, 3)]) == (Found(1, 4), Found(3, 3))
