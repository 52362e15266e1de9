"""Fields of a rule's class that a scenario can set."""

import pytest
from attrs import define, fields, validators

from rmfs_rules.helpers.parameters import parameter


@define
class Mine:
    """A rule with two parameters."""

    share: float = parameter(0.5, [validators.gt(0), validators.le(1)], "How much of it")
    window_s: float = parameter(20.0, None, "How long", "s", infinite=True)


def test_default_check_meaning_and_unit() -> None:
    assert (Mine().share, Mine(1).window_s) == (0.5, 20.0)
    for share in (0, 2):
        with pytest.raises(ValueError, match="'share' must be"):
            Mine(share)
    told = [dict(field.metadata) for field in fields(Mine)]
    assert told == [{"doc": "How much of it"}, {"unit": "s", "doc": "How long", "infinite": True}]
