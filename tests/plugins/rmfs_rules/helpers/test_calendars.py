"""Numbers that wait for their time."""

from __future__ import annotations

import numpy as np

from rmfs_rules.helpers.calendars import Calendar


def test_few_and_many_come_out_when_their_time_is_over() -> None:
    """Each number once, at the first call after its time, whether it was added with few others or with many."""
    rng = np.random.default_rng(1)
    times, calendar = rng.integers(0, 100, 700).tolist(), Calendar()
    for begin, end in ((0, 5), (5, 600), (600, 700)):
        calendar.add([(float(times[number]), number) for number in range(begin, end)])
    out: set[int] = set()
    for now in (0, 10, 50, 50.5, 200):
        found = calendar.before(now).tolist()
        assert set(found) == {number for number, time in enumerate(times) if time < now} - out
        out.update(found)
    assert len(out) == 700
