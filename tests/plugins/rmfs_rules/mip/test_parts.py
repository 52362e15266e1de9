"""Where stations count orders: periods of a few lines, worked out by hand.

With W_u = 2, a place that stays free costs twice the items of the largest order (`Period.factors`).
"""

from collections.abc import Mapping, Sequence
from typing import Any

import pytest

from cases import cases
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Part, Solution, objective_of
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.parts import PartsBuilder, builder_of, by_places, with_joining_lines
from rmfs_rules.mip.proof.proof import Proof

A, B, C, D = range(4)
INTEGRATED, AMONG, OVER_TIME = Model


def period_of(
    orders: Sequence[Sequence[int]],
    pods: Sequence[Sequence[int] | Mapping[int, int]],
    places: Sequence[int] = (1,),
    there: Sequence[Sequence[int]] = ((), ()),
    **changes: Any,
) -> Period:
    """Return a period whose stations count orders.

    From the SKUs of each order, those of each pod or its numbers of items, the free places of each station and the pods
    there, and what else is so.
    """
    counted = [pod for pod in pods if isinstance(pod, Mapping)]
    unlimited = Stock(tuple(range(len(pods))), tuple(tuple(pod) for pod in pods), 4)
    settings: dict[str, Any] = {
        "counting_orders": frozenset(range(len(places))),
        "busy": tuple(sorted({pod for at in there for pod in at})),
        **changes,
    }
    return Period(
        Stock.counted(counted, 4) if counted else unlimited,
        tuple(range(len(places))),
        tuple(places),
        tuple(tuple(at) for at in there[: len(places)]),
        tuple(range(len(orders))),
        [order for order, skus in enumerate(orders) for _ in skus],
        [sku for skus in orders for sku in skus],
        [1 for skus in orders for _ in skus],
        **settings,
    )


def placed(period: Period, model: Model, splits: int | None = None, weight: float = 2) -> Proof:
    proof = Proof(Reduced(period, model), weight, Limits(), splits)
    by_places(proof)
    assert proof.best is not None
    assert violation(period, proof.best, model, weight, splits) is None
    return proof


def known(proof: Proof) -> tuple[float, float]:
    return proof.bound, proof.incumbent.objective


@cases(
    "model counting apart",
    (INTEGRATED, {0, 1}, False),  # an order is one part
    (AMONG, {0, 1}, True),
    (OVER_TIME, {1}, True),
    (AMONG, set(), False),
)
def test_parts_are_told_apart_where_they_take_places(model: Model, counting: set[int], apart: bool) -> None:
    period = period_of([[A, B]], [[A], [B]], (1, 1), counting_orders=frozenset(counting))
    assert isinstance(builder_of(Reduced(period, model), 2, None), PartsBuilder) == apart


APART = ([[A, B]], [[A], [B]], (1, 1), ((0,), (1,)))
"""The lines of an order are at two stations with a place each; together they cost a visit and leave a place free."""


def test_what_is_there_fills_the_places_and_then_a_visit() -> None:
    for model in Model:
        proof = placed(period_of([[A, B], [A], [B]], [[A, B]], (2,), there=((0,),)), model)
        assert known(proof) == (1, 1)
        assert proof.incumbent.visits == ((0, 0),)
        assert [part.order for part in proof.incumbent.parts] == [0, 1]
    for model in Model:
        proof = placed(period_of([[A], [B]], [[A], [C], [B]], (2,), there=((0,),)), model)
        assert known(proof) == (2, 2)
        assert proof.incumbent.visits == ((0, 0), (2, 0))
    for model in Model:
        for busy in ((), (1,)):
            proof = placed(period_of([[A], [B], [C]], [[A], [B, C]], (2,), busy=busy), model)
            assert known(proof) == (1, 1)
            assert proof.incumbent.visits == ((1, 0),)
        proof = placed(period_of([[A], [B]], [[A, B], [A]], busy=(0,)), model)
        assert proof.incumbent.visits == ((1, 0),)


def test_places_that_cannot_be_filled() -> None:
    period = period_of([[A, B]], [[A, B]], (3,), there=((0,),))
    for model in Model:
        assert known(placed(period, model)) == (1 + 2 * 2 * 2, 1 + 2 * 2 * 2)
    for model in Model:
        assert known(placed(period_of([[A]], [[A]], (1, 1), ((0,), ())), model)) == (1 + 2, 1 + 2)
    period = period_of([[A, B, C]], [[A], [B], [C]])
    for model in (INTEGRATED, AMONG):
        assert known(placed(period, model)) == (1, 3)
    assert known(placed(period, OVER_TIME)) == (1, 1)


def test_over_time_an_order_goes_line_by_line_where_items_are_counted() -> None:
    proof = placed(period_of([[A, B]], [[A, B]], (1, 1), ((), (0,)), counting_orders=frozenset({0})), OVER_TIME)
    assert proof.incumbent.objective == 2
    assert {(part.station, len(part.skus)) for part in proof.incumbent.parts} == {(0, 1), (1, 1)}


def test_visits_that_cost_more_than_the_place_are_not_made() -> None:
    """With W_u = 0.4, a place is worth 0.4 with orders of one item, 1.2 with three: one visit, not three."""
    for model in (INTEGRATED, AMONG):
        proof = placed(period_of([[A, B, C], [D]], [[A], [B], [C], [D]], (2,)), model, weight=0.4)
        assert proof.incumbent.objective == pytest.approx(1 + 1.2)
        assert proof.incumbent.visits == ((3, 0),)
    period = period_of([[A]], [[A]])
    for model in Model:
        proof = placed(period, model, weight=0.4)
        assert known(proof) == (0, 0.4)
        assert proof.incumbent.visits == ()


def test_an_order_is_shared_out_among_stations_that_have_its_lines() -> None:
    """Where no order may be split, it goes to one of them as a whole."""
    for model in (AMONG, OVER_TIME):
        proof = placed(period_of(*APART), model)
        assert known(proof) == (2, 2)
        assert len(proof.incumbent.parts) == 2
        proof = placed(period_of(*APART), model, splits=0)
        assert proof.incumbent.objective == 3 + 4
        assert len(proof.incumbent.parts) == 1


def test_places_are_filled_from_what_pods_have_left() -> None:
    """One item of A for two orders: the second gets another pod, while there is one."""
    for model in Model:
        proof = placed(period_of([[A], [A]], [{A: 1}, {A: 1}], (2,), there=((0,),)), model)
        assert proof.incumbent.objective == 2
        assert proof.incumbent.visits == ((0, 0), (1, 0))
        proof = placed(period_of([[A], [A]], [{A: 1}], (2,), there=((0,),)), model)
        assert proof.incumbent.objective == 1 + 2


def joined(period: Period, *parts: Part, model: Model = OVER_TIME) -> dict[tuple[int, int], tuple[int, ...]]:
    visits = tuple((pod, station) for station, pods in enumerate(period.inbound) for pod in pods)
    value = objective_of(period, parts, len(visits), 2)
    solution = with_joining_lines(period, Solution(parts, visits, value, value, "bounds"), model)
    assert (solution.objective, solution.visits) == (value, visits)
    return {(part.order, part.station): part.skus for part in solution.parts}


def test_lines_join_where_their_order_has_a_place() -> None:
    period = period_of([[A, B, C, D]], [[A, B, D]], (1, 1), ((0,), (0,)))
    assert joined(period, Part(0, 0, (A,))) == {(0, 0): (A, B, D)}
    assert joined(period, Part(0, 0, (A,)), Part(0, 1, (D,))) == {(0, 0): (A, B), (0, 1): (D,)}
    period = period_of([[A], [A, B]], [[A, B]], (1,), ((0,),), begun=(False, True), joined=frozenset({(1, 0)}))
    assert joined(period) == {(1, 0): (A, B)}
    period = period_of([[A, B]], [[A, B]])
    solution = with_joining_lines(period, Solution((Part(0, 0, (A,)),), ((0, 0),), 1, 1, "bounds"), OVER_TIME)
    assert solution.parts == (Part(0, 0, (A, B)),)
    period = period_of([[B], [A, B]], [{A: 1, B: 1}], (2,), ((0,),))
    assert joined(period, Part(0, 0, (B,)), Part(1, 0, (A,))) == {(0, 0): (B,), (1, 0): (A,)}
    items = period_of([[A, B]], [[A, B]], (1, 1), ((0,), (0,)), counting_orders=frozenset({1}))
    assert joined(items, Part(0, 0, (A,))) == {(0, 0): (A,)}
    for model in (INTEGRATED, AMONG):
        assert joined(period_of([[A, B]], [[A, B]], (1,), ((0,),)), Part(0, 0, (A,)), model=model) == {(0, 0): (A,)}
