"""Proofs of optima, also with little effort, and choices among equal ones; optima against trying everything."""

import subprocess
import sys
from itertools import combinations, product
from threading import Thread

import numpy as np
import pytest
from attrs import evolve

from cases import cases
from mip_periods import (
    brute_force,
    brute_force_from_stock,
    holding,
    period_of,
    putwall_period,
    random_period,
    scarce_period,
    splitting_period,
)
from rmfs_rules.mip.period.effort import EFFORT, EFFORT_HARD, EFFORT_LARGE, Effort
from rmfs_rules.mip.period.period import Period, Preference
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Part, Solution, Visits, newly_split
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.models import solve_printed
from rmfs_rules.mip.printed.solver import Limits, check_installed, new_model, optimise
from rmfs_rules.mip.proof.parts import with_joining_lines
from rmfs_rules.mip.proof.proof import Proof
from rmfs_rules.mip.proof.steps import by_nothing, by_solver, proof_of
from rmfs_rules.mip.proof.ties import break_ties, order_gains, pod_gains

WHOLE = Part(0, 0, (0, 1))
BOTH_PODS = ((0, 0), (1, 0))


@pytest.fixture
def reduced() -> Reduced:
    """Return two stations of two slots, and an order of two SKUs, each on a pod of its own."""
    return Reduced(period_of([[0, 1]], [[0], [1]], (2, 2)), Model.SPLIT_AMONG_STATIONS)


def test_the_better_solution_is_kept(reduced: Reduced) -> None:
    """Nothing assigned costs 8, the order 2 + 4; visits of no use are left out, and a pod that is there is none."""
    proof = Proof(reduced, 2, Limits())
    proof.offer((), (), "bounds")
    assert proof.incumbent.objective == 8
    proof.offer((*BOTH_PODS, (0, 1)), (WHOLE,), "search")
    proof.offer((), (), "bounds")
    assert (proof.incumbent.objective, proof.incumbent.how) == (6, "search")
    assert proof.incumbent.visits == BOTH_PODS
    reduced.period.inbound = ((0,), ())
    proof = Proof(reduced, 2, Limits())
    proof.offer(BOTH_PODS, (WHOLE,), "search")
    assert (proof.incumbent.objective, proof.incumbent.visits) == (6, BOTH_PODS)


def test_no_more_orders_are_split_than_allowed(reduced: Reduced) -> None:
    split = Part(0, 0, (0,)), Part(0, 1, (1,))
    for splits in (0, 1):
        proof = Proof(reduced, 2, Limits(), splits)
        proof.offer((), (), "bounds")
        proof.offer(((0, 0), (1, 1)), split, "search")
        assert proof.incumbent.objective == (6 if splits else 8)


@pytest.mark.parametrize(("weight", "bound", "proven"), [(2, 5.0, False), (2, 5.1, True), (1.5, 4.9, False)])
def test_bound_and_solution_meet(reduced: Reduced, weight: float, bound: float, proven: bool) -> None:
    """With a whole W_u, a bound above the next whole number proves as much as one that is reached."""
    proof = Proof(reduced, weight, Limits(), bound=bound)
    assert not proof.proven
    proof.offer(BOTH_PODS, (WHOLE,), "search")
    assert proof.proven == proven


def test_steps_end_with_the_proof(reduced: Reduced) -> None:
    """No step is taken after the one that proves the best solution."""
    taken = []

    def offer(proof: Proof) -> None:
        taken.append("offer")
        proof.offer(BOTH_PODS, (WHOLE,), "search")

    def bound(proof: Proof) -> None:
        taken.append("bound")
        proof.bound = 6.0

    solution = Proof(reduced, 2, Limits(), steps=(offer, bound, offer)).run()
    assert taken == ["offer", "bound"]
    assert solution.bound == solution.objective == 6


def seniority(period: Period, parts: tuple[Part, ...]) -> float:
    gains, lines = order_gains(period), period.lines
    return float(sum(gains[part.order] * dict(lines[part.order])[sku] for part in parts for sku in part.skus))


def demand_covered(period: Period, visits: Visits) -> float:
    gains = pod_gains(period)
    return float(sum(gains[pod] for pod, station in visits if pod not in period.inbound[station]))


@pytest.mark.parametrize("packing_capacity", [None, 1])
@pytest.mark.parametrize("model", Model)
def test_first_objective_is_kept_and_second_not_worse(periods, model, packing_capacity):
    """Each tie-break is an optimum of (1), and no other tie-break's solution is better at its own objective.

    Where stations count orders, only the former is promised.
    """
    for period in (*periods[::3], *map(putwall_period, range(20))):
        found = {}
        for tie_break in ("solver", "oldest", "demand", *["finish"] * (model is Model.SPLIT_OVER_TIME)):
            proof = proof_of(period, model, 2, Limits(), packing_capacity)
            first = proof.run()
            found[tie_break] = break_ties(proof, tie_break)
            assert found[tie_break].objective == first.objective
            assert violation(period, found[tie_break], model, 2, packing_capacity) is None
        for other in found.values() if not period.counting_orders else ():
            assert seniority(period, found["oldest"].parts) >= seniority(period, other.parts)
            assert demand_covered(period, found["demand"].visits) >= demand_covered(period, other.visits)
            if model is Model.SPLIT_OVER_TIME:
                assert finished(period, found["finish"].parts) >= finished(period, other.parts) - 1e-6


def finished(period: Period, parts: tuple[Part, ...]) -> float:
    taken: dict[int, int] = {}
    for part in parts:
        taken[part.order] = taken.get(part.order, 0) + len(part.skus)
    return sum(1 / (len(period.lines[order]) - j) for order, m in taken.items() for j in range(m))


def optima(period: Period, objective: float) -> list[tuple[Part, ...]]:
    """Return what may be assigned in the optima of split-over-time, by trying everything; items of one SKU alone."""
    pods, stations = range(len(period.stock.pods)), range(len(period.stations))
    pairs = [(p, s) for s in stations for p in pods if p not in period.inbound[s]]
    kinds = [(order, sku) for order, lines in enumerate(period.lines) for sku, _ in lines]
    found = []
    for number in range(len(pairs) + 1):
        for visits in combinations(pairs, number):
            there = period.covered_with(visits)
            for where in product((-1, *stations), repeat=len(kinds)):
                free = list(period.capacities)
                for (_, sku), station in zip(kinds, where, strict=True):
                    if station >= 0:
                        free[station] -= 1 if there[station, sku] else 99
                cost = period.visits_before + number + 2 * sum(free)
                if min(free) >= 0 and cost == objective:
                    placed = zip(kinds, where, strict=True)
                    found.append(tuple(Part(order, s, (sku,)) for (order, sku), s in placed if s >= 0))
    return found


@pytest.mark.parametrize("stations", [1, 2])
@pytest.mark.parametrize("seed", range(12))
def test_finish_is_the_best_of_all_optima(stations, seed):
    """Tried out: with and without a pod at the station, orders of one to three lines."""
    rng = np.random.default_rng(seed)
    lines = [(o, i, 1) for o in range(3) for i in rng.choice(4, rng.integers(1, 4 - (o > 0)), replace=False).tolist()]
    contents = tuple(tuple(sorted(rng.choice(4, 2, replace=False).tolist())) for _ in range(3))
    at = tuple((int(rng.integers(3)),) if rng.random() < 0.6 else () for _ in range(stations))
    rooms = tuple(rng.integers(1, 4, stations).tolist())
    columns = zip(*sorted(lines), strict=True)
    period = Period(holding(contents, 4), tuple(range(stations)), rooms, at, (0, 1, 2), *map(list, columns))
    proof = proof_of(period, Model.SPLIT_OVER_TIME, 2, Limits())
    objective = proof.run().objective
    found = break_ties(proof, "finish")
    assert found.objective == objective
    assert violation(period, found, Model.SPLIT_OVER_TIME, 2) is None
    best = max(finished(period, parts) for parts in optima(period, objective))
    assert finished(period, found.parts) == pytest.approx(best)


PREFERENCES = {
    "any": lambda period, _: Preference(np.ones(len(period.stock.pods))),
    "bound": lambda period, _: Preference(1 - period.idle, once_sent=1.0),
    "random": lambda period, rng: Preference(rng.random(len(period.stock.pods))),
}


@pytest.mark.parametrize("weight", [2, 1.5, 0.5002])
@pytest.mark.parametrize("packing_capacity", [None, 1])
@pytest.mark.parametrize("model", Model)
def test_preferred_pods_cost_nothing(periods, model, packing_capacity, weight):
    rng = np.random.default_rng(1)
    for period in periods[::7]:
        optimum = proof_of(period, model, weight, Limits(), packing_capacity).run().objective
        for preference in PREFERENCES.values():
            preferring = evolve(period, preference=preference(period, rng))
            solution = proof_of(preferring, model, weight, Limits(), packing_capacity).run()
            assert solution.objective == pytest.approx(optimum, abs=1e-9)
            assert violation(preferring, solution, model, weight, packing_capacity) is None


def pods_alike(stations: int, **changes) -> Period:
    """Return a period with an order and a slot a station, and three pods that have the one SKU that all want."""
    return period_of([[0]] * stations, [[0]] * 3, (1,) * stations, **changes)


@pytest.mark.parametrize("model", Model)
@pytest.mark.parametrize("preferred", range(3))
def test_of_pods_alike_the_preferred_one_is_sent(model, preferred):
    """Three pods would serve the order; the preferred one does."""
    period = pods_alike(1, preference=Preference(np.eye(3)[preferred]))
    assert proof_of(period, model, 2, Limits(), None).run().visits == ((preferred, 0),)


@pytest.mark.parametrize("model", Model)
@cases("preferred sent", ("idle", {0, 1}), ("bound", {2}), ("any", {0}), ("random", {1}), ids=lambda value: value)
def test_what_is_preferred_once_a_pod_is_sent(model, preferred, sent):
    """The third pod is bound for a station; a pod that is sent to the first station is bound at the second one."""
    period = pods_alike(2, busy=(2,))
    if preferred != "idle":
        period = evolve(period, preference=PREFERENCES[preferred](period, np.random.default_rng(1)))
    assert {pod for pod, _ in proof_of(period, model, 2, Limits(), None).run().visits} == sent


INTEGRATED, AMONG, OVER_TIME = Model


@pytest.fixture
def period() -> Period:
    """Two stations; order 10 wants SKUs 0 and 1, order 11 SKU 2; pod 0 is at the first station."""
    return evolve(period_of([[0, 1], [2]], [[0, 1], [2]], (2, 1), ((0,), ())), orders=(10, 11))


def solution(parts, visits=((0, 0), (0, 1), (1, 0), (1, 1)), unused=None, bound=0.0) -> Solution:
    taken = sum(len(skus) for _, _, skus in parts)
    objective = len(visits) + 2 * ((3 - taken) if unused is None else unused)
    return Solution(tuple(Part(*part) for part in parts), visits, objective, bound, "solver")


GOOD = [(0, 0, (0, 1)), (1, 1, (2,))]


@pytest.mark.parametrize("model", Model)
def test_a_right_solution_passes(period, model):
    """Both orders, each as a whole at one station, with all pods at all stations."""
    assert violation(period, solution(GOOD), model, 2) is None


WRONG = [
    ("(1) objective", INTEGRATED, solution(GOOD, unused=1)),
    ("(1) objective", INTEGRATED, solution(GOOD, bound=99.0)),
    ("(2) whole orders", INTEGRATED, solution([(0, 0, (0,))])),
    ("(3) one station", INTEGRATED, solution([(0, 0, (0,)), (0, 1, (1,))])),
    ("(4) item capacity", INTEGRATED, solution([(0, 1, (0, 1))])),
    ("(5) pods", INTEGRATED, solution(GOOD, visits=((0, 0), (0, 1)))),
    ("(6) pods", INTEGRATED, solution([(1, 1, (2,))], visits=((1, 1),))),
    ("(8) lines: SKU id 3 is no open line", OVER_TIME, solution([(0, 0, (3,))])),
    ("(8) lines: SKU id 0 of order id 10 is twice", OVER_TIME, solution([(0, 0, (0, 0))])),
    ("(9) pods", INTEGRATED, solution(GOOD, visits=((0, 0), (0, 0), (1, 1)))),
    ("(11) whole orders", AMONG, solution([(0, 0, (0,))])),
    ("(11) lines", AMONG, solution([(0, 0, (0, 1)), (0, 1, (0,))])),
    ("(11.1) lines", OVER_TIME, solution([(0, 0, (0, 1)), (0, 1, (0,))])),
    ("(13) order at a station without a line", AMONG, solution([(0, 0, ())])),
]


@pytest.mark.parametrize(("named", "model", "wrong"), WRONG, ids=[f"{w[0]}, {w[1]}" for w in WRONG])
def test_the_violated_constraint_is_named(period, named, model, wrong):
    assert violation(period, wrong, model, 2).startswith(named)


def test_packing_capacity(period):
    """A split order needs a slot (18), also when a line stays in the backlog; not if it was split already."""
    split = solution([(0, 0, (0,)), (0, 1, (1,))])
    assert violation(period, split, AMONG, 2, 1) is None
    assert violation(period, split, AMONG, 2, 0).startswith("(18) packing capacity")
    left = solution([(0, 0, (0,))])
    assert violation(period, left, OVER_TIME, 2, 0).startswith("(18) packing capacity")
    period.split_open = 1
    assert violation(period, left, OVER_TIME, 2, 1).startswith("(18) packing capacity")
    period.begun = (True, False)
    assert violation(period, left, OVER_TIME, 2, 1) is None


def test_too_few_items_are_named():
    """Two orders want SKU 0 at different stations, and the pod that goes to both has one item of it."""
    sent = solution([(0, 0, (0,)), (1, 1, (0,))], visits=((0, 0), (0, 1)))
    for items, said in (
        (1, "stock: the pods at the stations and sent to them have too few free items of SKU id 0"),
        (2, None),
    ):
        period = period_of([[0], [0]], [{0: items}], (2, 1), [(0,), ()])
        for model in Model:
            assert violation(period, sent, model, 2) == said


def test_a_limit_before_any_solution():
    """Then nothing is assigned, and the bound that is known lies below the objective."""
    for seed in range(10):
        period = random_period(seed)
        solution = solve_printed(period, INTEGRATED, 2, Limits(max_seconds=1e-9))
        assert violation(period, solution, INTEGRATED, 2) is None
        assert solution.bound <= solution.objective


DEADLOCK = """
import gc
import mip
from pycparser import c_parser

import rmfs_core

gc.disable()  # the collector runs where this test lets it, and nowhere else
model = mip.Model(solver_name=mip.HIGHS)
model.cycle = model
before = gc.get_threshold()
del model
parse = c_parser.CParser.parse

def parse_and_collect(self, *arguments, **more):
    gc.collect()
    return parse(self, *arguments, **more)

c_parser.CParser.parse = parse_and_collect
small = ["instance.orders=12", "instance.skus=8", "instance.pods=8", "rules.pp=free-flow"]
rule = "rules.poa_pps={rule='integrated', formulation='paper'}"
status = rmfs_core.run("paper-250-integrated", overrides=[*small, rule]).status
print(status, gc.isenabled(), gc.get_threshold() == before)
"""


def test_a_collection_cannot_stop_a_solve() -> None:
    """A model that is ended while cffi parses a type does not wait for cffi's lock; the collector's settings stay."""
    done = subprocess.run([sys.executable, "-c", DEADLOCK], capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout == "complete False True\n"


def test_a_solver_that_is_not_there_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """An environment may do without CBC's libraries; HiGHS is always there."""
    monkeypatch.setattr("rmfs_rules.mip.printed.solver.find_spec", lambda _: None)
    check_installed("highs")
    with pytest.raises(ValueError, match=r'solver = "cbc" needs the package cbcbox'):
        check_installed("cbc")


def test_each_thread_asks_for_its_own_number_of_threads() -> None:
    """HiGHS's pool is of the calling thread: one that had another number before does not stop a solve."""
    found = []

    def solve(threads: int) -> None:
        limits = Limits(threads=threads)
        model = new_model(limits)
        taken = [model.add_var(var_type="B") for _ in range(4)]
        model += taken[0] + taken[1] + taken[2] + taken[3] >= 2
        model.objective = taken[0] + 2 * taken[1] + 3 * taken[2] + 4 * taken[3]
        found.append((threads, optimise(model, limits).objective))

    solve(1)
    other = Thread(target=solve, args=(2,))
    other.start()
    other.join()
    solve(2)
    solve(1)
    assert found == [(1, 3), (2, 3), (2, 3), (1, 3)]


SPLIT = (Model.SPLIT_AMONG_STATIONS, Model.SPLIT_OVER_TIME)
MANY = pytest.param(range(60, 160), marks=pytest.mark.slow, id="many")


def ended(period, model, steps, brute_force=None, splits=None, weight=2):
    """Return what a budget of steps comes to; it satisfies the constraints, and the optimum is in its bounds."""
    capacity = None if splits is None else period.split_open + splits
    solution = proof_of(period, model, weight, Limits(effort=Effort(steps)), capacity).run()
    assert violation(period, solution, model, weight, capacity) is None
    assert (solution.how == "effort") == (solution.bound < solution.objective)
    assert brute_force is None or solution.bound <= brute_force(period, model, weight, splits) <= solution.objective
    return solution


@pytest.mark.parametrize("steps", [0, 3000])
@pytest.mark.parametrize("model", Model)
def test_little_effort_leaves_a_bound_and_a_solution(small_periods, model, steps):
    """The bound is never above the optimum, nor the solution below it; a period without proof says so."""
    some = small_periods[:: 1 if steps == 0 else 3]
    found = [ended(period, model, steps, brute_force).how for period in some]
    assert "effort" in found or steps


SPLITS = [(model, splits, range(380, 700)) for model in SPLIT for splits in range(3)]


@cases(
    "model splits seeds",
    *((model, None, range(30)) for model in Model),
    *(pytest.param(model, None, range(60, 380), marks=pytest.mark.slow) for model in Model),
    *(pytest.param(*case, marks=pytest.mark.slow) for case in SPLITS),
)
def test_little_effort_with_few_items(model, splits, seeds):
    for seed in seeds:
        ended(scarce_period(seed), model, 0, brute_force_from_stock, splits)


@pytest.mark.parametrize("seeds", [pytest.param(range(4), id="some"), MANY])
@pytest.mark.parametrize("splits", [0, 1])
def test_little_effort_with_few_splits(splits, seeds):
    for seed in seeds:
        period = splitting_period(seed, orders=4, stations=2, skus=6)
        for model in SPLIT:
            for weight in (1.5, 2):
                ended(period, model, 0, brute_force, splits, weight)


@pytest.mark.parametrize("weight", [0.5, 1.0, 1.5])
def test_other_weights(small_periods, weight):
    for period in small_periods[::5]:
        for model in Model:
            ended(period, model, 0, brute_force, weight=weight)


def test_effort_that_is_enough_or_the_same(small_periods):
    for period in small_periods[::7]:
        for model in Model:
            limited = Effort.for_period(period, None)
            solution = proof_of(period, model, 2, Limits(effort=limited)).run()
            assert solution == proof_of(period, model, 2, Limits()).run()
            assert solution.bound == solution.objective
            assert not limited.short
    for steps in (0, 500, 5000, 50_000):
        for seed in range(6):
            period = splitting_period(seed, orders=9, stations=3, skus=9)
            for model in Model:
                assert ended(period, model, steps) == ended(evolve(period), model, steps)


def test_large_periods_get_less():
    """By default a period with more pods or SKUs than the paper's gets less effort."""
    period = random_period(1)
    more = period_of([[0]], [[0]] * 101)
    assert Effort.for_period(period, None).left == EFFORT
    assert Effort.for_period(more, None).left == EFFORT_LARGE
    assert Effort.for_period(more, 7).left == 7


@cases("weight capacity effort", (2, None, EFFORT), (1.5, None, EFFORT_HARD), (2, 3, EFFORT_HARD))
def test_periods_without_hope_of_a_proof_get_less(weight, capacity, effort):
    """By default fractional weights, and few splits between stations that are alike, get less effort."""
    period = random_period(1)
    alike = evolve(period, inbound=((),) * len(period.stations), capacities=(6,) * len(period.stations))
    proof = proof_of(alike, Model.SPLIT_AMONG_STATIONS, weight, Limits(), capacity)
    assert Effort.for_period(alike, None, hard=proof.hard).left == effort


LIMITS = Limits()
BY_PROGRAM = (by_nothing, by_solver)
"""The aggregated form by itself, without any step before it."""


def optimum(period: Period, model: Model, capacity: int | None = None, weight: float = 2, steps=None) -> Solution:
    """Return the proven solution of the aggregated form, which satisfies the printed constraints."""
    solution = proof_of(period, model, weight, LIMITS, capacity, steps=steps).run()
    assert solution.bound == pytest.approx(solution.objective)
    assert violation(period, solution, model, weight, capacity) is None
    return solution


@pytest.mark.parametrize("capacity", [None, 0, 1, 2], ids=lambda room: f"packing capacity {room}")
@pytest.mark.parametrize("model", Model)
def test_all_ways_agree(periods, model, capacity):
    """Printed and aggregated form have one objective, that of the brute force where there are few decisions."""
    tried = 0
    for number, period in enumerate(periods if capacity is None else periods[capacity::5]):
        printed = solve_printed(period, model, 2, LIMITS, capacity)
        assert printed.objective == printed.bound == optimum(period, model, capacity).objective, number
        assert violation(period, printed, model, 2, capacity) is None, number
        if capacity is not None or number % 5 == 0:
            assert optimum(period, model, capacity, steps=BY_PROGRAM).objective == printed.objective, number
        if (len(period.stations) + 1) ** len(period.line_sku) <= 3000:
            splits = None if capacity is None or model is Model.INTEGRATED else max(capacity - period.split_open, 0)
            assert printed.objective == brute_force(period, model, 2, splits), number
            tried += 1
    assert tried > 10


@pytest.mark.parametrize("many", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["some", "many"])
@pytest.mark.parametrize(("model", "room"), [*product(Model, [None]), *product(SPLIT, [0, 1, 2])])
@pytest.mark.parametrize("make", [scarce_period, putwall_period])
def test_all_ways_agree_on_other_periods(make, model, room, many):
    """Where pods run out, or stations count orders; with room for so many new splits."""
    scarce = at_once = 0
    first = 60 if many else 40 * (room is not None and make is scarce_period)
    seeds = range(first, first + (100 if room is not None else 320)) if many else range(first, first + 16)
    for seed in seeds:
        period = make(seed)
        capacity = None if room is None else period.split_open + room
        best = brute_force_from_stock(period, model, 2, room)
        printed = solve_printed(period, model, 2, LIMITS, capacity)
        found = optimum(period, model, capacity)
        for solution in (printed, found, optimum(period, model, capacity, steps=BY_PROGRAM)):
            joined = with_joining_lines(period, solution, model)
            assert solution.objective == solution.bound == joined.objective == best, seed
            assert violation(period, solution, model, 2, capacity) is None, seed
            assert violation(period, joined, model, 2, capacity) is None, seed
        scarce += len(Reduced(period, model).scarce) > 0
        at_once += found.how == "bounds"
    assert scarce > len(seeds) / 6
    assert at_once < len(seeds)


@pytest.mark.parametrize("weight", [0.5, 1.0, 1.5, 4.0])
def test_all_ways_agree_on_other_weights(periods, scarce_periods, weight):
    """W_u may be anything: below 1 a free slot may be cheaper than a pod, fractions leave the whole numbers."""
    for model in Model:
        for period in periods[::10]:
            printed = solve_printed(period, model, weight, LIMITS).objective
            assert optimum(period, model, weight=weight).objective == pytest.approx(printed)
        for period in scarce_periods[::8]:
            best = brute_force_from_stock(period, model, weight)
            assert optimum(period, model, weight=weight).objective == pytest.approx(best)


@pytest.mark.parametrize("splits", [0, *(pytest.param(splits, marks=pytest.mark.slow) for splits in (1, 2))])
def test_few_splits(splits):
    """It has the objective of the printed model, with and without begun orders and pods at the stations."""
    among, limited = Model.SPLIT_AMONG_STATIONS, 0
    for seed in range(12):
        period = splitting_period(seed, orders=7, stations=3, skus=9)
        capacity = splits + period.split_open
        solution = optimum(period, among, capacity)
        assert solution.objective == solve_printed(period, among, 2, LIMITS, capacity).objective, seed
        assert len(newly_split(period, solution.parts)) <= splits
        limited += solution.objective > optimum(period, among).objective
    assert limited > 0


@pytest.mark.parametrize("model", Model)
def test_plentiful_stock_is_unlimited_stock(periods, model):
    """Where each pod has as much as the period can take from it, the solution is the same to the last visit."""
    for period in periods[::3]:
        most = sum(period.capacities)
        stock = holding(
            [dict.fromkeys(period.stock.skus_of(pod).tolist(), most) for pod in period.stock.pods], period.stock.n_skus
        )
        plentiful = evolve(period, stock=stock)
        assert not len(Reduced(plentiful, model).scarce)
        assert optimum(plentiful, model) == optimum(period, model)


def test_solvers_agree_and_repeat(periods):
    """HiGHS and CBC find the same objective, and the same solution again."""
    for period in periods[::20]:
        for model in Model:
            found = optimum(period, model)
            assert found == optimum(evolve(period), model)
            assert proof_of(period, model, 2, Limits("cbc")).run().objective == found.objective


def test_a_time_limit_is_told():
    """A solve that a limit ends says so, and its bound lies below its objective."""
    stopped = 0
    for seed in range(2, 300, 3):
        period = random_period(seed)
        solution = proof_of(period, Model.SPLIT_OVER_TIME, 2, Limits(max_seconds=1e-9), 1).run()
        assert violation(period, solution, Model.SPLIT_OVER_TIME, 2, 1) is None
        assert solution.stopped_early == (solution.bound < solution.objective)
        stopped += solution.stopped_early
    assert stopped
