"""Classes of what is sorted."""

import numpy as np
import pytest
from attrs import define

from cases import cases
from rmfs_rules.helpers.classes import by_share, class_borders, turn


@define
class Cut:
    """A rule with classes."""

    borders: tuple[float, ...] = class_borders("pods")


def test_classes_are_cut_and_looked_at_in_turn() -> None:
    assert by_share(np.array([3, 0, 4, 1, 2]), (0.4, 0.6, 1.0)).tolist() == [0, 2, 2, 0, 1]
    assert by_share(np.arange(3), (0.01, 1.0)).tolist() == [1, 1, 1]
    away = np.array([-2, -1, 0, 1, 2])
    assert turn(away, better_first=True).argsort().tolist() == [2, 1, 3, 0, 4]
    assert turn(away, better_first=False).argsort().tolist() == [2, 3, 1, 4, 0]


@cases(
    "borders", (), (0.5,), (0.3, 0.3, 1.0), (0.5, 0.2, 1.0), (0.0, 1.0), ids=["none", "short", "equal", "falling", "0"]
)
def test_borders_have_to_rise_to_1(borders: tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="expected shares above 0 that rise to 1"):
        Cut(borders)
