"""What is found without a search for the optimum: flows and their bounds, greedy solutions, visits for few splits."""

import csv
from itertools import combinations, product

import numpy as np
import pytest
from attrs import evolve
from hypothesis import given, settings
from hypothesis import strategies as st

import rmfs_core
from cases import cases
from rmfs_rules.mip.period.effort import Effort
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.placing import Places
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.serving import PlacesFromStock
from rmfs_rules.mip.period.solution import Model, Part, Solution, Visits, items_of, objective_of
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.feasible import fill, fill_with_orders
from rmfs_rules.mip.proof.flow import Network, fewest_visits, greedy_visits
from rmfs_rules.mip.proof.greedy import station_by_station
from rmfs_rules.mip.proof.proof import Proof
from rmfs_rules.mip.proof.splitting import visits_for_few_splits
from rmfs_rules.mip.proof.steps import by_greedy, by_nothing
from rmfs_rules.mip.proof.stocked import fill_from_stock, lines_from_stock, one_line_orders

INTEGRATED, AMONG, OVER_TIME = Model


def pairs_of(period: Period) -> list[tuple[int, int]]:
    return list(product(range(len(period.stock.pods)), range(len(period.stations))))


def wrong(period: Period, visits: Visits, parts: tuple[Part, ...], model: Model, weight: float = 2) -> str | None:
    before = {(pod, station) for station, pods in enumerate(period.inbound) for pod in pods}
    sent = tuple(sorted(before | set(visits)))
    value = objective_of(period, parts, len(sent), weight)
    return violation(period, Solution(parts, sent, value, 0.0, "search"), model, weight)


@pytest.mark.parametrize("model", Model)
def test_what_is_filled_satisfies_the_constraints(periods, scarce_periods, model):
    """With any new visits; where orders are split, on periods with single items."""
    rng = np.random.default_rng(1)
    filled = [0, 0]
    for period in (*periods, *scarce_periods):
        if period.single_items or (model is INTEGRATED and period.stock.items is not None):
            scarce = period.stock.items is not None
            visits = tuple(v for v in pairs_of(period) if rng.random() < 0.4 and v[0] not in period.inbound[v[1]])
            reduced = Reduced(period, model)
            parts = fill_from_stock(reduced, visits) if scarce else fill(reduced, period.covered_with(visits))
            assert wrong(period, visits, parts, model) is None
            filled[scarce] += items_of(period, parts) > 0
    assert filled[0] > 100
    assert filled[1] > 20


def test_orders_of_one_line_are_a_solution_of_all_models(scarce_periods):
    rng = np.random.default_rng(2)
    found = 0
    for period in scarce_periods:
        visits = tuple(v for v in pairs_of(period) if rng.random() < 0.4 and v[0] not in period.inbound[v[1]])
        reduced = Reduced(period, INTEGRATED)
        lines = one_line_orders(reduced)
        assert all(len(period.lines_of(int(period.line_order[line]))) == 1 for line in lines)
        parts = lines_from_stock(reduced, visits, lines)
        assert [wrong(period, visits, parts, model) for model in Model] == [None] * 3
        found += bool(parts)
    assert found > 10


@pytest.mark.parametrize("weight", [0.5, 2])
def test_whole_orders_are_a_solution_of_all_models(periods, weight):
    """Never empty while some order fits some station and pays; integrated, so also of the two that split.

    At a single station that has all, they are the fullest choice of orders.
    """
    for period in periods:
        reduced = Reduced(period, INTEGRATED)
        if not reduced.candidates.any():
            continue
        visits, _ = station_by_station(reduced, weight, Effort())
        parts = fill_with_orders(reduced, period.covered_with(visits))
        assert parts or weight < 1
        assert [wrong(period, visits, parts, model, weight) for model in Model] == [None] * 3
        if len(period.stations) == 1:
            fullest = fill_with_orders(reduced, np.ones_like(period.covered))
            assert items_of(period, fullest) == reduced.reachable[0]


def check_bound(period: Period, network: Network, most: int) -> None:
    """Hold greedy visits against the target, and the bound (up to ``most``) against all sets of visits below it."""
    visits, filled = greedy_visits(network, period.preferred)
    assert filled.flow() == network.target
    least = fewest_visits(network)
    assert least <= len(visits)
    for chosen in combinations(pairs_of(period), least - 1) if 0 < least <= most else ():
        tried = network
        for pod, station in chosen:
            tried = tried.adding(pod, station)
        assert tried.flow() < network.target


def test_flow_and_its_bound(periods):
    """The minimum cut equals a flow by augmenting paths; no set of visits smaller than the bound fills the target."""
    for period in periods:
        reduced = Reduced(period, OVER_TIME)
        if period.single_items and reduced.candidates.any():
            network = Network.of(reduced)
            places = Places(network.capacities)
            units = np.repeat(network.mask, network.demand.astype(int)).tolist()
            assert network.flow() == sum(places.add(mask) for mask in units)
            check_bound(period, network, 2)


def test_flow_from_stock_and_its_bound(scarce_periods):
    """The same where SKUs are scarce: pods give no more than they have, and share it among their stations."""
    scarce = 0
    for period in scarce_periods:
        reduced = Reduced(period, OVER_TIME)
        if period.single_items and len(reduced.scarce):
            scarce += 1
            network, places = Network.of(reduced), PlacesFromStock(period, ())
            assert network.flow() == sum(map(places.add, period.line_sku[reduced.candidates].tolist()))
            flows, _ = network.flows_with_one_more()
            for pod, station in pairs_of(period):
                assert flows[station, pod] == network.adding(pod, station).flow()
            check_bound(period, network, 3)
    assert scarce > 15


def period_of(lines, contents, rooms=(3,), inbound=None):
    table = [(order, sku, 1) for order, skus in enumerate(lines) for sku in skus]
    stock = Stock(tuple(range(len(contents))), tuple(map(tuple, contents)), 9)
    at = ((),) * len(rooms) if inbound is None else inbound
    return Period(stock, tuple(range(len(rooms))), rooms, at, tuple(range(len(lines))), *zip(*table, strict=True))


@cases(
    "period sent orders",
    # a pod that completes three orders beats two that have more lines of orders which they leave open
    (period_of([[0], [1], [2], [3, 4], [3, 5]], [[3, 6], [0, 1, 2], [4, 5]]), [1], [0, 1, 2]),
    # the pod that completes most alone is given up for two that complete more together
    (period_of([[0], [1], [2, 3], [2, 4], [5, 6]], [[0, 1], [2, 5], [3, 4, 6]], (6,)), [1, 2], [2, 3, 4]),
    # orders that a pod at the station serves need no visit
    (period_of([[0], [1], [2]], [[0, 1, 2], [0]], inbound=((0,),)), [], [0, 1, 2]),
    ids=["completes most", "exchanged", "there"],
)
def test_pods_for_a_station(period, sent, orders):
    visits, parts = station_by_station(Reduced(period, INTEGRATED), 2, Effort())
    assert sorted(visits) == [(pod, 0) for pod in sent]
    assert sorted(part.order for part in parts) == orders


def test_stations_share_the_lines():
    """Split over time, each line counts for itself, at one station: the order of two lines is served by two."""
    period = period_of([[0], [0], [1], [1, 2], [2]], [[0, 1], [1, 2]], rooms=(3, 3))
    proof = Proof(Reduced(period, OVER_TIME), 2, Limits(), bound=0)
    by_nothing(proof)
    by_greedy(proof)
    assert proof.incumbent.visits == ((0, 0), (1, 1))
    assert proof.incumbent.objective == 2


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), model=st.sampled_from(list(Model)), splits=st.sampled_from([None, 0, 2]))
def test_greedy_solutions_satisfy_the_constraints(random_period, scarce_period, seed, model, splits):
    """Finite and unlimited stock, begun orders, a packing capacity, several items."""
    for period in (random_period(seed), scarce_period(seed), evolve(random_period(seed), begun=())):
        limit = None if model is INTEGRATED else splits
        proof = Proof(Reduced(period, model), 2, Limits(), limit, bound=period.visits_before)
        by_nothing(proof)
        by_greedy(proof)
        capacity = None if limit is None else period.split_open + limit
        assert violation(period, proof.incumbent, model, 2, capacity) is None


def four_orders(pods: tuple[tuple[int, ...], ...]) -> Reduced:
    """Return a period of four orders of two items, and two empty stations with room for two items each."""
    return Reduced(period_of([[0, 1], [2, 3], [0, 4], [2, 5]], pods, rooms=(2, 2)), OVER_TIME)


def test_pods_that_complete_orders_are_found():
    """Without any split, each station gets the pod that has a whole order."""
    visits = visits_for_few_splits(four_orders(((0, 2), (0, 1), (2, 4), (2, 3))), 2, 0, Effort())
    assert sorted(visits) in ([(1, 0), (3, 1)], [(1, 1), (3, 0)])


@pytest.mark.parametrize(("splits", "found"), [(1, False), (2, False), (3, False), (4, True)])
def test_splits_fill_what_whole_orders_do_not(splits, found):
    """Pods that have one item of each order fill four places with four splits, and no less."""
    assert (visits_for_few_splits(four_orders(((0, 2), (0, 2))), 2, splits, Effort()) is not None) == found


def test_without_effort_no_visits_are_looked_for():
    """The search takes its steps from the period's effort, and notes that there were too few."""
    effort = Effort(1.0)
    assert visits_for_few_splits(four_orders(((0, 1), (2, 3))), 2, 0, effort) is None
    assert effort.short


@pytest.mark.parametrize("seed", [1401, 1402])
def test_the_first_period_of_the_paper_with_packing_capacity(seed, tmp_path):
    """Four visits fill 60 places with ten splits, which is proven; split-among-stations needs five."""
    rule = 'rules.poa_pps={rule="split-over-time", packing_capacity=10}'
    rmfs_core.run("paper-250", overrides=[f"seed={seed}", "rules.pp=free-flow", "run.until_s=1", rule], out=tmp_path)
    with (tmp_path / "periods.csv").open() as file:
        period = next(csv.DictReader(file))
    assert (period["status"], period["objective"], period["bound"]) == ("optimal", "4.0", "4.0")
