"""A period: read off the warehouse, reduced; lines that are placed, and parts of orders at stations that count them."""

from itertools import combinations, product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mip_periods import period_of, random_period
from rmfs_commands.testing import small_world
from rmfs_core.warehouse import WarehouseView
from rmfs_rules.mip.period.period import Period, Stock
from rmfs_rules.mip.period.placing import Slots, short_of, stations_of
from rmfs_rules.mip.period.reduction import Reduced
from rmfs_rules.mip.period.solution import Model, Part, Solution, objective_of
from rmfs_rules.mip.printed.constraints import violation
from rmfs_rules.mip.printed.solver import Limits
from rmfs_rules.mip.proof.parts import by_slots, with_joining_lines
from rmfs_rules.mip.proof.proof import Proof

INTEGRATED, AMONG, OVER_TIME = Model


def test_it_is_read_off_the_warehouse():
    """Stations with free capacity, the backlog's open lines by order, and the pods bound for a station."""
    world = small_world({"1": ["b", "a"], "2": ["a"]}, {"p": ["a"], "q": ["b"]}, capacities=(2, 3))
    world.bind(world.pods[1], world.stations[1])
    view = WarehouseView(world)
    period = Period.of(view, Stock.of(view))
    sku = {world.orders[1].lines[0].sku: "a"}
    assert (period.stations, period.capacities) == ((0, 1), (2, 3))
    assert (period.inbound, period.busy, period.orders) == (((), (1,)), (1,), (0, 1))
    assert [sorted(sku.get(i, "b") for i, _ in lines) for lines in period.lines] == [["a", "b"], ["a"]]
    assert period.single_items
    assert period.visits_before == 1


def test_entries_without_items_are_left_out(scarce_periods):
    rng = np.random.default_rng(3)
    for stock in (period.stock for period in scarce_periods[:20]):
        numbers, held = rng.integers(0, 3, len(stock.sku)), [dict[int, int]() for _ in stock.pods]
        for pod, sku, number in zip(stock.pod.tolist(), stock.sku.tolist(), numbers.tolist(), strict=True):
            held[pod] |= {sku: number} if number else {}
        fewer = stock.with_items(numbers)
        assert [fewer.items_on(pod) for pod in stock.pods] == held
        assert [fewer.skus_of(pod).tolist() for pod in stock.pods] == [[*items] for items in held]
        assert [set(np.flatnonzero(row)) for row in fewer.holds] == [set(items) for items in held]


def test_what_no_station_can_take_is_left_out():
    """An order of three items, stations of two slots: integrated drops it, the split models do not."""
    period = period_of([[0, 1, 2], [3]], [(0, 1, 2)], (2, 2))
    assert Reduced(period, INTEGRATED).orders == ()
    assert Reduced(period, AMONG).orders == (0,)  # order 1 wants what no pod has
    assert Reduced(period, OVER_TIME).orders == (0,)
    assert not Reduced(period, INTEGRATED).candidates.any()


def test_every_pod_is_within_one_that_is_kept(periods):
    """Which brings as much and is worth as much; of those that are kept, none is within another."""
    rng = np.random.default_rng(1)
    for period in periods[:100]:
        reduced = Reduced(period, OVER_TIME)
        wanted, value = rng.random(period.stock.n_skus) < 0.7, rng.integers(0, 2, len(period.stock.pods)).astype(float)
        brings = [{i for i in skus if wanted[i]} for skus in map(period.stock.skus_of, period.stock.pods)]
        kept = reduced.classes(wanted, value)

        def within(pod: int, other: int) -> bool:
            return brings[pod] <= brings[other] and value[pod] <= value[other]  # noqa: B023

        for pod, skus in enumerate(brings):
            assert not skus or any(within(pod, one) for one in kept)
        assert not any(within(pod, other) for pod in kept for other in kept if other != pod)


def test_reachable_places(periods):
    """At each station, the most items of any orders that fit together; for split-among-stations, over all stations."""

    def most(reduced: Reduced, room: int) -> int:
        sizes = [kind.size for kind in reduced.types for _ in kind.orders]
        sums = [sum(chosen) for n in range(len(sizes) + 1) for chosen in combinations(sizes, n)]
        return max(items for items in sums if items <= room)

    for period in periods[:100]:
        whole, among = Reduced(period, INTEGRATED), Reduced(period, AMONG)
        assert whole.reachable == tuple(most(whole, room) for room in period.capacities)
        assert among.reachable == period.capacities
        assert among.reachable_sum == most(among, sum(period.capacities))


@given(st.lists(st.integers(0, 3), min_size=1, max_size=3), st.lists(st.integers(0, 7), max_size=5))
def test_one_by_one_is_the_most(capacities, masks):
    """As many lines find a slot as in any assignment, and each stands where its kind is covered."""
    masks = [mask & ((1 << len(capacities)) - 1) for mask in masks]
    most = 0
    for choice in product(range(-1, len(capacities)), repeat=len(masks)):
        allowed = all(at < 0 or mask >> at & 1 for at, mask in zip(choice, masks, strict=True))
        if allowed and all(choice.count(station) <= room for station, room in enumerate(capacities)):
            most = max(most, sum(at >= 0 for at in choice))
    slots = Slots.covered(capacities, masks)
    placed = [mask for mask in masks if slots.add(mask)]
    assert len(placed) == most
    stations = [slots.take(mask, ()) for mask in placed]
    assert all(mask >> station & 1 for mask, station in zip(placed, stations, strict=True))
    assert (np.bincount(stations, minlength=len(capacities)) <= capacities).all()


def test_lines_of_an_order_and_preferred_stations():
    """Where one line of an order finds no slot, the others give theirs back.

    Lines of a kind are interchangeable, so any station where some stand may be named; then they are used up.
    """
    slots = Slots.covered([1, 1], [1, 3])
    assert not slots.add_all([1, 1])
    assert slots.free == [1, 1]
    assert slots.add_all([3, 1])
    assert slots.free == [0, 0]
    slots = Slots.covered([1, 1], [3])
    assert slots.add(3)
    assert slots.add(3)
    assert [slots.take(3, [1]), slots.take(3, [1])] == [1, 0]
    with pytest.raises(ValueError, match="no line of this kind"):
        slots.take(3, [1])


def test_what_is_short(scarce_periods):
    rng = np.random.default_rng(2)
    named = 0
    for period in scarce_periods * 3:
        pairs = list(product(range(len(period.stock.pods)), range(len(period.stations))))
        visits = tuple(pair for pair in pairs if rng.random() < 0.5)
        lines = [(order, sku) for order, held in enumerate(period.lines) for sku, _ in held if rng.random() < 0.4]
        parts = tuple(Part(order, int(rng.integers(len(period.stations))), (sku,)) for order, sku in lines)
        at, short = stations_of(period, visits), set()
        for group in product((False, True), repeat=len(period.stations)):
            for sku in range(period.stock.n_skus):
                there = [part for part in parts if sku in part.skus and group[part.station]]
                wanted = sum(dict(period.lines_of(part.order))[sku] for part in there)
                pods = [pod for pod, stations in at.items() if any(group[s] for s in stations)]
                if wanted > sum(period.stock.items_on(pod).get(sku, 0) for pod in pods):
                    short.add(sku)
        assert short_of(period, visits, parts) == min(short, default=None)
        named += bool(short)
    assert 30 < named < 150


def test_unlimited_stock_is_never_short():
    assert short_of(random_period(0), (), (Part(0, 0, (0,)),)) is None


def test_items_move_between_pods():
    """One item on a pod at two stations of one slot, one on a pod at the first alone: the first has to move.

    A third finds none, and nothing changes; of an order all lines find slots, or none.
    """
    shared = period_of([[0], [0], [0]], [{0: 1}, {0: 1}], (1, 1), [(0, 1), (0,)])
    slots = Slots.from_stock(shared, ())
    assert not slots.add_all([0, 0, 0])
    assert slots.free == [1, 1]
    assert slots.add(0)
    assert slots.add_all([0])
    assert slots.free == [0, 0]
    assert not slots.add(0)
    assert not slots.add_all([0])
    assert {slots.take(0, ()), slots.take(0, ())} == {0, 1}
    with pytest.raises(ValueError, match="no line of this kind"):
        slots.take(0, ())


A, B, C, D = range(4)


def counting_orders(orders: Any, pods: Any, slots: Any = (1,), there: Any = (), **changes: Any) -> Period:
    """Return a period whose stations count orders.

    With W_u = 2, a slot that stays free costs twice the items of the largest order (`Period.factors`).
    """
    return period_of(orders, pods, slots, there, **{"counting_orders": frozenset(range(len(slots)))} | changes)


def placed(period: Period, model: Model, splits: int | None = None, weight: float = 2) -> Proof:
    proof = Proof(Reduced(period, model), weight, Limits(), splits)
    by_slots(proof)
    assert proof.best is not None
    assert violation(period, proof.best, model, weight, splits) is None
    return proof


def known(proof: Proof) -> tuple[float, float]:
    return proof.bound, proof.incumbent.objective


APART = ([[A, B]], [[A], [B]], (1, 1), ((0,), (1,)))
"""The lines of an order are at two stations with a slot each; together they cost a visit and leave a slot free."""


def test_what_is_there_fills_the_places_and_then_a_visit() -> None:
    for model in Model:
        proof = placed(counting_orders([[A, B], [A], [B]], [[A, B]], (2,), there=((0,),)), model)
        assert known(proof) == (1, 1)
        assert proof.incumbent.visits == ((0, 0),)
        assert [part.order for part in proof.incumbent.parts] == [0, 1]
    for model in Model:
        proof = placed(counting_orders([[A], [B]], [[A], [C], [B]], (2,), there=((0,),)), model)
        assert known(proof) == (2, 2)
        assert proof.incumbent.visits == ((0, 0), (2, 0))
    for model in Model:
        for busy in ((), (1,)):
            proof = placed(counting_orders([[A], [B], [C]], [[A], [B, C]], (2,), busy=busy), model)
            assert known(proof) == (1, 1)
            assert proof.incumbent.visits == ((1, 0),)
        proof = placed(counting_orders([[A], [B]], [[A, B], [A]], busy=(0,)), model)
        assert proof.incumbent.visits == ((1, 0),)


def test_places_that_cannot_be_filled() -> None:
    period = counting_orders([[A, B]], [[A, B]], (3,), there=((0,),))
    for model in Model:
        assert known(placed(period, model)) == (1 + 2 * 2 * 2, 1 + 2 * 2 * 2)
    for model in Model:
        assert known(placed(counting_orders([[A]], [[A]], (1, 1), ((0,), ())), model)) == (1 + 2, 1 + 2)
    period = counting_orders([[A, B, C]], [[A], [B], [C]])
    for model in (INTEGRATED, AMONG):
        assert known(placed(period, model)) == (1, 3)
    assert known(placed(period, OVER_TIME)) == (1, 1)


def test_over_time_an_order_goes_line_by_line_where_items_are_counted() -> None:
    proof = placed(counting_orders([[A, B]], [[A, B]], (1, 1), ((), (0,)), counting_orders=frozenset({0})), OVER_TIME)
    assert proof.incumbent.objective == 2
    assert {(part.station, len(part.skus)) for part in proof.incumbent.parts} == {(0, 1), (1, 1)}


def test_visits_that_cost_more_than_the_place_are_not_made() -> None:
    """With W_u = 0.4, a slot is worth 0.4 with orders of one item, 1.2 with three: one visit, not three."""
    for model in (INTEGRATED, AMONG):
        proof = placed(counting_orders([[A, B, C], [D]], [[A], [B], [C], [D]], (2,)), model, weight=0.4)
        assert proof.incumbent.objective == pytest.approx(1 + 1.2)
        assert proof.incumbent.visits == ((3, 0),)
    period = counting_orders([[A]], [[A]])
    for model in Model:
        proof = placed(period, model, weight=0.4)
        assert known(proof) == (0, 0.4)
        assert proof.incumbent.visits == ()


def test_an_order_is_shared_out_among_stations_that_have_its_lines() -> None:
    """Where no order may be split, it goes to one of them as a whole."""
    for model in (AMONG, OVER_TIME):
        proof = placed(counting_orders(*APART), model)
        assert known(proof) == (2, 2)
        assert len(proof.incumbent.parts) == 2
        proof = placed(counting_orders(*APART), model, splits=0)
        assert proof.incumbent.objective == 3 + 4
        assert len(proof.incumbent.parts) == 1


def test_places_are_filled_from_what_pods_have_left() -> None:
    """One item of A for two orders: the second gets another pod, while there is one."""
    for model in Model:
        proof = placed(counting_orders([[A], [A]], [{A: 1}, {A: 1}], (2,), there=((0,),)), model)
        assert proof.incumbent.objective == 2
        assert proof.incumbent.visits == ((0, 0), (1, 0))
        proof = placed(counting_orders([[A], [A]], [{A: 1}], (2,), there=((0,),)), model)
        assert proof.incumbent.objective == 1 + 2


def joined(period: Period, *parts: Part, model: Model = OVER_TIME) -> dict[tuple[int, int], tuple[int, ...]]:
    visits = tuple((pod, station) for station, pods in enumerate(period.inbound) for pod in pods)
    value = objective_of(period, parts, len(visits), 2)
    solution = with_joining_lines(period, Solution(parts, visits, value, value, "bounds"), model)
    assert (solution.objective, solution.visits) == (value, visits)
    return {(part.order, part.station): part.skus for part in solution.parts}


def test_lines_join_where_their_order_has_a_place() -> None:
    period = counting_orders([[A, B, C, D]], [[A, B, D]], (1, 1), ((0,), (0,)))
    assert joined(period, Part(0, 0, (A,))) == {(0, 0): (A, B, D)}
    assert joined(period, Part(0, 0, (A,)), Part(0, 1, (D,))) == {(0, 0): (A, B), (0, 1): (D,)}
    period = counting_orders([[A], [A, B]], [[A, B]], (1,), ((0,),), begun=(False, True), joined=frozenset({(1, 0)}))
    assert joined(period) == {(1, 0): (A, B)}
    period = counting_orders([[A, B]], [[A, B]])
    solution = with_joining_lines(period, Solution((Part(0, 0, (A,)),), ((0, 0),), 1, 1, "bounds"), OVER_TIME)
    assert solution.parts == (Part(0, 0, (A, B)),)
    period = counting_orders([[B], [A, B]], [{A: 1, B: 1}], (2,), ((0,),))
    assert joined(period, Part(0, 0, (B,)), Part(1, 0, (A,))) == {(0, 0): (B,), (1, 0): (A,)}
    items = counting_orders([[A, B]], [[A, B]], (1, 1), ((0,), (0,)), counting_orders=frozenset({1}))
    assert joined(items, Part(0, 0, (A,))) == {(0, 0): (A,)}
    for model in (INTEGRATED, AMONG):
        assert joined(counting_orders([[A, B]], [[A, B]], (1,), ((0,),)), Part(0, 0, (A,)), model=model) == {
            (0, 0): (A,)
        }
