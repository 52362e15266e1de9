"""Which pods are wanted enough, against sums worked out by hand."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rmfs_rules.pod_index.period import NONE, NOW, URGENT, new_account
from rmfs_rules.pod_index.urging import find_front, find_urgent, needed, next_urgent


def test_the_ages_of_the_lines_that_a_pod_has_items_for_add_up() -> None:
    """Pod 0 has lines of 30 and 40 ticks, pod 1 the second alone, pod 2 none."""
    account, now = new_account(np.zeros(0, np.int64), np.zeros(0, np.int64), 3, 1, np.zeros((1, 1), np.int64)), 100
    period = account.period
    period.ages["lines_of"], period.ages["arrivals_of"], period.numbers[NOW] = (2, 1, 0), (130, 60, 0), now
    period.pods["free"] = True

    def soonest(need: int, passed: int = 0) -> int:
        tick = next_urgent(*account.parts, now + passed, need)
        return tick if tick == NONE else tick - now - passed

    def urgent(need: int) -> list[int]:
        find_urgent(period, need)
        return period.urgent[: period.numbers[URGENT]].tolist()

    assert soonest(70) == 30
    assert soonest(71) == 1
    assert soonest(100) == 15
    assert soonest(100, 10) == 5
    assert soonest(100, 15) == 45
    assert urgent(40) == [0, 1]
    assert period.pods["urge"].tolist() == [70, 40, 0]
    assert urgent(NONE) == [0, 1]
    period.pods["free"][1] = False
    assert find_urgent(period, 40)
    assert urgent(40) == [0]
    assert not find_urgent(period, 41)
    period.ages["lines_of"] = period.ages["arrivals_of"] = 0
    assert soonest(100) == NONE


@given(data=st.data())
def test_whatever_the_need_the_next_pod_is_of_the_front(data: st.DataObject) -> None:
    """Of all pods, none is sooner: those of the front say when the next one is wanted enough, or that one is by now."""
    ages = data.draw(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 90)), min_size=1, max_size=8))
    account = new_account(np.zeros(0, np.int64), np.zeros(0, np.int64), len(ages), 1, np.zeros((1, 1), np.int64))
    period, now = account.period, 20
    period.ages["lines_of"], period.ages["arrivals_of"] = np.array(ages).T
    period.ages["arrivals_of"][period.ages["lines_of"] == 0] = 0
    front = period.front[: find_front(period, now)].tolist()
    later, need = data.draw(st.integers(now, 100)), data.draw(st.integers(1, 1000))
    found = min([-(-(need + arrivals) // lines) for lines, arrivals in front], default=NONE)
    urgent = any(lines and lines * later - arrivals >= need for lines, arrivals in ages)
    assert urgent == (NONE < found <= later)
    assert urgent or found == next_urgent(*account.parts, later, need)


def test_the_fuller_a_station_the_more_it_takes() -> None:
    """Sixteen times as much where all places are taken, or more than all."""
    assert [needed(load, 30, 500, 16.0) for load in (0, 2, 30, 31)] == [500, 1000, 8000, 8000]
