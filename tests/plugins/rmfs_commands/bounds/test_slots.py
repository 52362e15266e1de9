"""When orders can be complete at the earliest, against every way to serve a few items."""

from __future__ import annotations

import random
from collections.abc import Iterator

import numpy as np

from rmfs_commands.bounds.slots import Servers, shortest_remaining_first


def array(*values: int) -> np.ndarray:
    """Return whole numbers as an array."""
    return np.array(values, dtype=np.int64)


def all_ways(servers: Servers, items: list[int], arrivals: list[int]) -> Iterator[list[int]]:
    """Yield the completions of the orders, ascending, for each order of items and each choice of who serves which."""

    def serve(left: tuple[int, ...], free: tuple[int, ...], done: tuple[int, ...]) -> Iterator[list[int]]:
        if not any(left):
            yield sorted(done)
        for order in range(len(left)):
            for server in range(len(free)) if left[order] else ():
                start = max(free[server], arrivals[order])
                yield from serve(
                    (*left[:order], left[order] - 1, *left[order + 1 :]),
                    (*free[:server], start + servers.spacing, *free[server + 1 :]),
                    (*done[:order], max(done[order], start + servers.lasts), *done[order + 1 :]),
                )

    yield from serve(tuple(items), tuple(int(tick) for tick in servers.opens), (0,) * len(items))


def test_the_last_of_many_items() -> None:
    """Two who start at 0 and 5, an item every 10, picked after 4: starts 0, 5, 10, 15, 20; from 12 on 12, 12, 22."""
    two = Servers(array(0, 5), 10, 4)
    assert two.last_done(array(1, 2, 3, 4, 5), 0).tolist() == [4, 9, 14, 19, 24]
    assert two.last_done(array(1, 2, 3), array(12, 12, 12)).tolist() == [16, 16, 26]
    assert two.last_done(array(2), array(3)).tolist() == [9]


def test_the_shortest_goes_first() -> None:
    """A job of 5 waits for those of 1 and 2 that come while it is served; it was served for 1 until then."""
    assert shortest_remaining_first(array(0, 1, 2), array(5, 2, 1)).tolist() == [3, 4, 8]
    assert shortest_remaining_first(array(10, 0), array(1, 2)).tolist() == [2, 11]


def test_orders_that_arrive_together() -> None:
    """Of 1, 2 and 4 items with two servers: after 1, 3 and 7 items, so after the starts at 0, 10 and 30."""
    assert Servers(array(0, 0), 10, 4).completions(array(4, 1, 2), array(0, 0, 0)).tolist() == [4, 14, 34]


def test_one_at_a_time_is_as_fast_as_its_items() -> None:
    """Orders far apart: each takes as long as its items do, shared among all servers."""
    three = Servers(array(0, 0, 0), 10, 4)
    assert three.completions(array(1, 7), array(100, 1000)).tolist() == [104, 1024]


def test_no_way_to_serve_is_faster() -> None:
    """Of all ways, none has a first, second, ... order complete before it is said to be possible; nor the last item."""
    rng = random.Random("ways to serve")
    reached = 0
    for _ in range(60):
        spacing = rng.randint(1, 12)
        servers = Servers(
            np.sort(array(*(rng.choice((0, 0, 7, 15)) for _ in range(2)))), spacing, rng.randint(1, spacing + 6)
        )
        items = [rng.randint(1, 2) for _ in range(rng.randint(1, 3))]
        arrivals = [rng.choice((0, 0, 5, 20, 40)) for _ in items]
        bound = servers.completions(array(*items), array(*arrivals))
        ways = np.array(list(all_ways(servers, items, arrivals)))
        assert (ways.min(axis=0) >= bound).all()
        together = servers.last_done(array(sum(items)), min(arrivals))[0]
        assert ways[:, -1].min() >= together
        reached += bool((ways.min(axis=0) == bound).all())
    assert reached > 30
