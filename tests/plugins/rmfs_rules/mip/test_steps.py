"""The steps of the proof: flows, bounds, greedy solutions, patterns; and the compiled searches, against all choices."""

import csv
from collections.abc import Sequence
from itertools import combinations, product

import numpy as np
import pytest
from attrs import evolve
from hypothesis import given, settings
from hypothesis import strategies as st

import rmfs_core
from cases import cases
from mip_periods import brute_force, period_of, random_period, scarce_period, splitting_period
from rmfs_rules.mip import Integrated
from rmfs_rules.mip.compiled import warm_up
from rmfs_rules.mip.compiled.arrays import Arrays, arrays_of
from rmfs_rules.mip.compiled.exchanging import completed, exchanged
from rmfs_rules.mip.compiled.pod_sets import best_sets, next_set, sets_of
from rmfs_rules.mip.compiled.spreading import next_that_fills
from rmfs_rules.mip.period.effort import Effort
from rmfs_rules.mip.period.period import Period
from rmfs_rules.mip.period.placing import Slots
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Part, Solution, Visits, items_of, objective_of
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof import pricing, steps
from rmfs_rules.mip.proof.aggregated import Builder
from rmfs_rules.mip.proof.feasible import fill, fill_with_orders
from rmfs_rules.mip.proof.fewest import FewestVisits
from rmfs_rules.mip.proof.flow import Network, fewest_visits, greedy_visits
from rmfs_rules.mip.proof.greedy import station_by_station
from rmfs_rules.mip.proof.pricing import Pricing
from rmfs_rules.mip.proof.proof import Proof
from rmfs_rules.mip.proof.splitting import visits_for_few_splits
from rmfs_rules.mip.proof.steps import by_greedy, by_nothing, proof_of
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
        if period.single_items or (model is INTEGRATED and period.stock.number is not None):
            scarce = period.stock.number is not None
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
            units = np.repeat(network.mask, network.demand.astype(int)).tolist()
            slots = Slots.covered(network.capacities, units)
            assert network.flow() == sum(slots.add(mask) for mask in units)
            check_bound(period, network, 2)


def test_flow_from_stock_and_its_bound(scarce_periods):
    """The same where SKUs are scarce: pods give no more than they have, and share it among their stations."""
    scarce = 0
    for period in scarce_periods:
        reduced = Reduced(period, OVER_TIME)
        if period.single_items and len(reduced.scarce):
            scarce += 1
            network, slots = Network.of(reduced), Slots.from_stock(period, ())
            assert network.flow() == sum(map(slots.add, period.line_sku[reduced.candidates].tolist()))
            flows, _ = network.flows_with_one_more()
            for pod, station in pairs_of(period):
                assert flows[station, pod] == network.adding(pod, station).flow()
            check_bound(period, network, 3)
    assert scarce > 15


@cases(
    "period sent orders",
    # a pod that completes three orders beats two that have more lines of orders which they leave open
    (period_of([[0], [1], [2], [3, 4], [3, 5]], [[3, 6], [0, 1, 2], [4, 5]]), [1], [0, 1, 2]),
    # the pod that completes most alone is given up for two that complete more together
    (period_of([[0], [1], [2, 3], [2, 4], [5, 6]], [[0, 1], [2, 5], [3, 4, 6]], (6,)), [1, 2], [2, 3, 4]),
    # orders that a pod at the station serves need no visit
    (period_of([[0], [1], [2]], [[0, 1, 2], [0]], there=((0,),)), [], [0, 1, 2]),
    ids=["completes most", "exchanged", "there"],
)
def test_pods_for_a_station(period, sent, orders):
    visits, parts = station_by_station(Reduced(period, INTEGRATED), 2, Effort())
    assert sorted(visits) == [(pod, 0) for pod in sent]
    assert sorted(part.order for part in parts) == orders


def test_stations_share_the_lines():
    """Split over time, each line counts for itself, at one station: the order of two lines is served by two."""
    period = period_of([[0], [0], [1], [1, 2], [2]], [[0, 1], [1, 2]], slots=(3, 3))
    proof = Proof(Reduced(period, OVER_TIME), 2, Limits(), bound=0)
    by_nothing(proof)
    by_greedy(proof)
    assert proof.incumbent.visits == ((0, 0), (1, 1))
    assert proof.incumbent.objective == 2


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 10**6), model=st.sampled_from(list(Model)), splits=st.sampled_from([None, 0, 2]))
def test_greedy_solutions_satisfy_the_constraints(seed, model, splits):
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
    return Reduced(period_of([[0, 1], [2, 3], [0, 4], [2, 5]], pods, slots=(2, 2)), OVER_TIME)


def test_pods_that_complete_orders_are_found():
    """Without any split, each station gets the pod that has a whole order."""
    visits = visits_for_few_splits(four_orders(((0, 2), (0, 1), (2, 4), (2, 3))), 2, 0, Effort())
    assert sorted(visits) in ([(1, 0), (3, 1)], [(1, 1), (3, 0)])


@pytest.mark.parametrize(("splits", "found"), [(1, False), (2, False), (3, False), (4, True)])
def test_splits_fill_what_whole_orders_do_not(splits, found):
    """Pods that have one item of each order fill four slots with four splits, and no less."""
    assert (visits_for_few_splits(four_orders(((0, 2), (0, 2))), 2, splits, Effort()) is not None) == found


def test_without_effort_no_visits_are_looked_for():
    """The search takes its steps from the period's effort, and notes that there were too few."""
    effort = Effort(1.0)
    assert visits_for_few_splits(four_orders(((0, 1), (2, 3))), 2, 0, effort) is None
    assert effort.short


@pytest.mark.parametrize("seed", [1401, 1402])
def test_the_first_period_of_the_paper_with_packing_capacity(seed, tmp_path):
    """Four visits fill 60 slots with ten splits, which is proven; split-among-stations needs five."""
    rule = 'rules.poa_pps={rule="split-over-time", packing_capacity=10}'
    rmfs_core.run("paper-250", overrides=[f"seed={seed}", "rules.pp=free-flow", "run.until_s=1", rule], out=tmp_path)
    with (tmp_path / "periods.csv").open() as file:
        period = next(csv.DictReader(file))
    assert (period["status"], period["objective"], period["bound"]) == ("optimal", "4.0", "4.0")


LIMITS = Limits()
WHOLE = (INTEGRATED, AMONG)
ENDLESS = 10**9


def printed_optimum(period: Period, model: Model) -> float:
    return solve_printed(period, model, 2, LIMITS).objective


@pytest.mark.parametrize("model", Model)
def test_nothing_is_better_than_the_optimum(periods, model):
    """Asked for a solution that costs less, the aggregated model has none; asked for one that costs as much, it has."""
    for period in periods[::20]:
        reduced = Reduced(period, model)
        if not reduced.candidates.any():
            continue
        optimum = printed_optimum(period, model)
        for most in (optimum - 1, optimum):
            builder = Builder(reduced, 2)
            aggregated = builder.build()
            builder.limit_objective(float("-inf"), most)
            assert (aggregated.program.solve(LIMITS).values is not None) == (most == optimum)


def searched(reduced: Reduced, most_work: int = ENDLESS, splits: int | None = None) -> tuple[float, object]:
    """Return the value of the search by itself, without any bound to start from, and what it finds."""
    value, found = FewestVisits(reduced, 2, most_work, splits).run(0, 2 * reduced.reachable_sum)
    return reduced.least(2) + value, found


def few_decisions(periods: list[Period], model: Model) -> list[Reduced]:
    """Return those that are small enough to try everything, and have something to decide."""
    few = [Reduced(p, model) for p in periods if (len(p.stations) + 1) ** len(p.line_sku) <= 3000]
    few = [reduced for reduced in few if reduced.candidates.any()]
    assert len(few) > 50
    return few


@pytest.mark.parametrize("model", WHOLE)
def test_it_finds_the_optimum_by_itself(all_periods, model):
    for reduced in few_decisions(all_periods, model):
        assert searched(reduced)[0] == brute_force(reduced.period, model, 2)


@pytest.mark.parametrize("splits", [0, 1])
def test_it_finds_the_optimum_with_few_splits(small_periods, splits):
    mattered = 0
    for period in small_periods:
        reduced, capacity = Reduced(period, AMONG), splits + period.split_open
        value, found = searched(reduced, splits=splits)
        assert value == brute_force(period, AMONG, 2, splits)
        mattered += value > searched(reduced)[0]
        if found is not None:
            proof = proof_of(period, AMONG, 2, LIMITS, capacity)
            proof.offer((), (), "bounds")
            proof.offer(*found, "search")
            assert proof.incumbent.objective == value
            assert violation(period, proof.incumbent, AMONG, 2, capacity) is None
    assert mattered > 5


def test_giving_up_proves_nothing_false(all_periods):
    """With few steps, what it returns is still a lower bound, and it says so by returning no solution."""
    gave_up = 0
    for reduced in few_decisions(all_periods, AMONG):
        optimum = brute_force(reduced.period, AMONG, 2)
        for most_work in (0, 5, 15, 40):
            value, found = searched(reduced, most_work)
            assert value <= optimum
            gave_up += found is None and value < optimum
    assert gave_up > 20


@pytest.mark.parametrize("stations", [6, 7, 8])
def test_many_stations(stations):
    """Up to seven stations fit the packed vectors; with more, the search stays out and the optimum is found as well."""
    rng = np.random.default_rng(stations)
    orders = [rng.choice(8, 2, replace=False).tolist() for _ in range(9)]
    there = [[int(pod)] for pod in rng.integers(0, 6, stations)]
    pods = [(sku, (sku + 3) % 8) for sku in range(6)]
    period = period_of(orders, pods, (2, *[1] * (stations - 1)), there)
    reduced = Reduced(period, AMONG)
    assert FewestVisits(reduced, 2, ENDLESS).possible == (stations <= 7)
    optimum = printed_optimum(period, AMONG)
    assert proof_of(period, AMONG, 2, LIMITS).run().objective == optimum
    assert stations > 7 or searched(reduced)[0] == optimum


@pytest.mark.parametrize("seed", [13, 19, 27])
def test_pods_are_exchanged_until_no_fewer_do(seed):
    """Seven visits are found of up to 31, and the orders are served as the model says."""
    rng = np.random.default_rng(seed)
    contents = [rng.choice(150, 6, replace=False).tolist() for _ in range(80)]
    orders = [sorted(rng.choice(150, rng.integers(1, 5), replace=False).tolist()) for _ in range(80)]
    period = period_of(orders, contents, (12, 12, 12), n_skus=150)
    found = FewestVisits(Reduced(period, AMONG), 2, 0).quickly(1, 32)
    proof = proof_of(period, AMONG, 2, LIMITS)
    proof.offer(*found, "greedy")
    assert violation(period, proof.incumbent, AMONG, 2) is None
    assert len(found[0]) == 7


def by_patterns(period: Period, model: Model = INTEGRATED, limits: Limits = LIMITS) -> Solution:
    """Prove a period without what would prove small ones before the patterns are needed."""
    left_out = (steps.by_bounds, steps.by_fewest_visits, steps.by_greedy)
    chosen = [step for step in steps.STEPS if step not in left_out]
    return proof_of(period, model, 2, limits, steps=chosen).run()


@pytest.mark.parametrize("quick_work", [pricing.QUICK_WORK, -1], ids=["all-sets", "better-sets"])
@pytest.mark.parametrize("model", [INTEGRATED, OVER_TIME])
def test_patterns_prove_the_optimum(equal_stations, monkeypatch, model, quick_work):
    """Whatever they prove is true, and what they choose satisfies the printed constraints: 120 periods."""
    monkeypatch.setattr(pricing, "QUICK_WORK", quick_work)
    proven = 0
    for number, period in enumerate(equal_stations):
        found = by_patterns(period, model)
        assert found.objective == found.bound == printed_optimum(period, model), number
        assert violation(period, found, model, 2) is None, number
        proven += found.how == "patterns"
    assert proven > 10


@cases(
    "module name value",
    (pricing, "MOST_WORK", 0),
    (pricing, "MOST_WORK", 20),
    *((steps, "CLOSE_SETS", n) for n in ((1,), (1, 2), (2, 8))),
    ids=lambda value: str(getattr(value, "__name__", value)),
)
def test_so_they_do_in_other_ways(equal_stations, monkeypatch, module, name, value):
    """Where a single station's model has to price, and however few sets of pods a solution is put together from."""
    monkeypatch.setattr(module, name, value)
    for period in equal_stations[: 40 if module is pricing else 60]:
        found = by_patterns(period)
        assert found.objective == found.bound == printed_optimum(period, INTEGRATED)


def test_a_time_limit_ends_patterns_in_order(equal_stations):
    """With no time at all there is a solution all the same, marked as stopped unless it happens to be proven."""
    for period in equal_stations[:40]:
        found = by_patterns(period, limits=Limits(max_seconds=1e-9))
        optimum = printed_optimum(period, INTEGRATED)
        assert found.bound <= optimum <= found.objective
        assert found.stopped_early or found.objective == optimum


def worth_of(pricing: Pricing, chosen: tuple[int, ...], values: np.ndarray) -> float:
    """Return the best sum of values over the orders that a set of pods serves, by trying all numbers of each type."""
    at_hand = {sku for pod in chosen for sku in pricing.brings[pod]}
    sums = {0: 0.0}
    for t, missing in enumerate(pricing.missing):
        if at_hand.issuperset(missing):
            for used, worth in list(sums.items()):
                for n in range(1, int(pricing.counts[t]) + 1):
                    place = used + n * int(pricing.sizes[t])
                    if place <= pricing.room:
                        sums[place] = max(sums.get(place, -1.0), worth + n * float(values[t]))
    return max(sums.values())


@pytest.mark.parametrize("share", [0.0, 0.5, 0.9])
def test_the_sets_of_pricing_are_all_and_the_best(equal_stations, share):
    """The search finds exactly the sets that are worth enough; asked for three, three of the greatest worth."""
    for period in equal_stations[:40]:
        pricing = Pricing(Reduced(period, INTEGRATED), 2, LIMITS)
        values = (2.0 * pricing.sizes + np.linspace(0, -1, len(pricing.sizes))) if len(pricing.sizes) else np.zeros(0)
        for number in range(min(len(pricing.pods), 3) + 1):
            sets = list(combinations(range(len(pricing.pods)), number))
            worths = {chosen: worth_of(pricing, chosen, values) for chosen in sets}
            least = share * max(worths.values()) + 1e-3
            found = {tuple(sorted(chosen)): worth for worth, chosen in pricing.sets(number, values, least, 1000)}
            assert found == pytest.approx({chosen: worth for chosen, worth in worths.items() if worth >= least})
            best = [worth for worth, _ in pricing.sets(number, values, 0.0, 3)]
            assert sorted(best) == pytest.approx(sorted(worths.values())[-3:])


def value_of(arrays: Arrays, worth: np.ndarray, pods: Sequence[int]) -> float:
    """Return the worth of the orders that pods complete."""
    there = arrays.at_hand > 0
    for pod in pods:
        there[arrays.pod_sku[arrays.pod_start[pod] : arrays.pod_start[pod + 1]]] = True
    lines = [arrays.line_sku[slice(*span)] for span in zip(arrays.order_start, arrays.order_start[1:], strict=False)]
    return sum(max(w, 0.0) for w, skus in zip(worth, lines, strict=True) if there[skus].all())


@given(seed=st.integers(0, 10**6), share=st.floats(0, 1))
@settings(max_examples=200, deadline=None)
def test_every_set_is_found_once(seed, share):
    """The search names exactly the sets that complete enough; half of them with the bound that large periods have."""
    rng = np.random.default_rng(seed)
    arrays, pods = arrays_of(Reduced(random_period(seed), AMONG), sharp=bool(rng.integers(2)))
    n, worth = len(pods), rng.uniform(-0.5, 3, len(arrays.order_start) - 1)
    for number in range(n + 1):
        values = {chosen: value_of(arrays, worth, chosen) for chosen in combinations(range(n), number)}
        least = share * max(values.values()) + 1e-3
        search = sets_of(arrays, number, worth, least)
        found = []
        while next_set(arrays, search, np.zeros(1, np.int64), ENDLESS):
            found.append(tuple(sorted(search.chosen.tolist())))
        assert sorted(found) == sorted(chosen for chosen, value in values.items() if value >= least)


@pytest.mark.parametrize("seed", range(20))
def test_the_search_for_sets_gives_up_when_told(seed):
    """With no steps left there is no further set, and the count of steps says so."""
    arrays, pods = arrays_of(Reduced(random_period(seed), AMONG))
    if pods:
        work, search = np.zeros(1, np.int64), sets_of(arrays, 1, arrays.items.astype(float), 0.0)
        assert sum(1 for _ in iter(lambda: next_set(arrays, search, work, 0), False)) <= 1
        assert work[0] > 0


@pytest.mark.parametrize("seed", range(40))
def test_sets_that_are_found_by_exchanging(seed):
    """Many exchanges find the best of all sets; the seed alone decides; without one, the first pods are returned."""
    period = splitting_period(seed, 9, 2, 9) if seed % 2 else random_period(seed)
    arrays, pods = arrays_of(Reduced(period, AMONG))
    n, items_of = len(pods), arrays.items.astype(float)
    for number in range(n + 1):
        found, items = exchanged(arrays, number, 2000, 1)
        assert len(set(found.tolist())) == number
        assert items == completed(arrays, found, np.zeros(len(arrays.at_hand), np.bool_))
        assert items == value_of(arrays, items_of, found.tolist())
        assert items == max(value_of(arrays, items_of, chosen) for chosen in combinations(range(n), number))
    once, again = (exchanged(arrays, n // 2, 50, 3)[0].tolist() for _ in range(2))
    assert once == again
    assert exchanged(arrays, n // 2, 0, 3)[0].tolist() == list(range(n // 2))


def test_what_is_loaded_is_what_periods_need(periods):
    """After loading, no period has anything left to compile: its arguments have the types that were loaded."""
    warm_up.load()
    searches = sets_of, next_that_fills, best_sets, exchanged
    loaded = [search.signatures for search in searches]
    assert all(loaded)
    for period in (*periods[:20], *(splitting_period(seed, 7, 3, 9) for seed in range(3))):
        for model in Model:
            proof_of(period, model, 2, Limits(), None).run()
            proof_of(period, model, 2, Limits(), 1).run()
    assert [search.signatures for search in searches] == loaded


def test_a_rule_loads_them(monkeypatch):
    """Not for the printed form, which has no searches."""
    calls = []
    monkeypatch.setattr(warm_up, "load", lambda: calls.append("loaded"))
    Integrated(formulation="paper").prepare(None)
    assert calls == []
    Integrated().prepare(None)
    assert calls == ["loaded"]
