"""Classes of what is sorted."""

from __future__ import annotations

import numpy as np
import pytest
from attrs import define

from rmfs_rules.helpers.classes import by_share, class_borders, turn


@define
class Cut:
    """A rule with classes."""

    borders: tuple[float, ...] = class_borders("pods")


def test_shares_are_cut_in_the_given_order() -> None:
    """Of five the best two, the next one and the last two."""
    assert by_share(np.array([3, 0, 4, 1, 2]), (0.4, 0.6, 1.0)).tolist() == [0, 2, 2, 0, 1]
    assert by_share(np.arange(3), (0.01, 1.0)).tolist() == [1, 1, 1]


def test_ones_own_class_is_looked_at_first_then_those_to_both_sides() -> None:
    """The better one or the worse one before the other."""
    away = np.array([-2, -1, 0, 1, 2])
    assert turn(away, better_first=True).argsort().tolist() == [2, 1, 3, 0, 4]
    assert turn(away, better_first=False).argsort().tolist() == [2, 3, 1, 4, 0]


@pytest.mark.parametrize(
    "borders",
    [(), (0.5,), (0.3, 0.3, 1.0), (0.5, 0.2, 1.0), (0.0, 1.0)],
    ids=["none", "short", "equal", "falling", "0"],
)
def test_borders_have_to_rise_to_1(borders: tuple[float, ...]) -> None:
    """Each class has a share."""
    with pytest.raises(ValueError, match="expected shares above 0 that rise to 1"):
        Cut(borders)
