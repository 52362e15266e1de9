"""Tests of the rule."""

from rmfs.testing import check_rule, small_world

from the_rule import TheRule


def test_it_conforms() -> None:
    """It decides only what is possible, repeatably, and starves no order, in every small world."""
    print(check_rule(TheRule(n=2)))


def test_the_oldest_are_kept() -> None:
    """The first two of three."""
    world = small_world({"first": ["a"], "second": ["a"], "third": ["a"]}, {"P": ["a"]})
    assert [order.name for order in TheRule(n=2).filter_backlog(world.backlog)] == ["first", "second"]
