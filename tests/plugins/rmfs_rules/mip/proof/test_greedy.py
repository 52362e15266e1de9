"""Solutions that are found at once."""

from attrs import evolve
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_rules.mip.period.effort import Effort
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.greedy import station_by_station
from rmfs_rules.mip.proof.proof import Proof
from rmfs_rules.mip.proof.steps import by_greedy, by_nothing


def period_of(lines, contents, rooms=(3,), inbound=None):
    """Return a period: lists of SKUs per order and pod, and the free places."""
    table = [(order, sku, 1) for order, skus in enumerate(lines) for sku in skus]
    stock = Stock(tuple(range(len(contents))), tuple(map(tuple, contents)), 9)
    at = ((),) * len(rooms) if inbound is None else inbound
    return Period(stock, tuple(range(len(rooms))), rooms, at, tuple(range(len(lines))), *zip(*table, strict=True))


def test_one_pod_that_completes_all_goes_first():
    """A pod that completes three orders beats two that have more lines of orders which they leave open."""
    period = period_of([[0], [1], [2], [3, 4], [3, 5]], [[3, 6], [0, 1, 2], [4, 5]])
    visits, parts = station_by_station(Reduced(period, Model.INTEGRATED), 2, Effort())
    assert visits == ((1, 0),)
    assert sorted(part.order for part in parts) == [0, 1, 2]


def test_pods_are_exchanged():
    """The pod that completes most alone is given up for two that complete more together."""
    period = period_of([[0], [1], [2, 3], [2, 4], [5, 6]], [[0, 1], [2, 5], [3, 4, 6]], rooms=(6,))
    visits, parts = station_by_station(Reduced(period, Model.INTEGRATED), 2, Effort())
    assert sorted(visits) == [(1, 0), (2, 0)]
    assert sorted(part.order for part in parts) == [2, 3, 4]


def test_what_is_at_a_station_is_used_first():
    """Orders that a pod at the station serves need no visit."""
    period = period_of([[0], [1], [2]], [[0, 1, 2], [0]], inbound=((0,),))
    assert station_by_station(Reduced(period, Model.INTEGRATED), 2, Effort())[0] == ()


def test_stations_share_the_lines():
    """Split over time, each line counts for itself, at one station: the order of two lines is served by two."""
    period = period_of([[0], [0], [1], [1, 2], [2]], [[0, 1], [1, 2]], rooms=(3, 3))
    proof = Proof(Reduced(period, Model.SPLIT_OVER_TIME), 2, Limits(), bound=0)
    by_nothing(proof)
    by_greedy(proof)
    assert proof.incumbent.visits == ((0, 0), (1, 1))
    assert proof.incumbent.objective == 2


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), model=st.sampled_from(list(Model)), splits=st.sampled_from([None, 0, 2]))
def test_every_solution_satisfies_the_constraints(random_period, scarce_period, seed, model, splits):
    """Greedy solutions are feasible: finite and unlimited stock, begun orders, a packing capacity, several items."""
    for period in (random_period(seed), scarce_period(seed), evolve(random_period(seed), begun=())):
        if model is Model.INTEGRATED:
            splits = None
        proof = Proof(Reduced(period, model), 2, Limits(), splits, bound=period.visits_before)
        by_nothing(proof)
        by_greedy(proof)
        capacity = None if splits is None else period.split_open + splits
        assert violation(period, proof.incumbent, model, 2, capacity) is None
