"""The small worlds that every rule is tried in: each has what some rule has stumbled over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from attrs import evolve, frozen

from rmfs_commands.testing.worlds import Wanted, small_instance, small_layout
from rmfs_core.scenario.model import (
    BatterySection,
    InstanceSection,
    LayoutSection,
    PackingSection,
    Replenishment,
    RobotsSection,
    RuleChoice,
    RulesSection,
    RunSection,
    Scenario,
    StationsSection,
)
from rmfs_core.timetable import Span
from rmfs_core.world import BundleData, Instance, Layout

LONGEST_S = 4 * 3600.0
"""Simulated seconds after which an order that is not complete counts as starved; each world needs a few minutes."""

PLAIN_RULES = RulesSection(
    poa=RuleChoice("first-come"),
    pps=RuleChoice("nearest-pod"),
    pr=RuleChoice("nearest"),
    ta=RuleChoice("nearest-robot"),
    pp=RuleChoice("free-flow"),
    roa=RuleChoice("first-bundle"),
    rps=RuleChoice("emptiest-pod"),
)
"""Rules for the decisions that the rule under test does not take: simple, quick, without randomness. In some worlds
rules for robots without a task come in."""


FINITE = ", finite stock"
"""At the end of the name of a world that has finite stock, and is otherwise like the one named before."""


@frozen(eq=False)
class TrialWorld:
    """A warehouse with its orders, and the scenario around it.

    Parameters
    ----------
    name
        Its name in findings.
    purpose
        Its purpose: the case that a rule may have missed.
    scenario
        Robots, stations and limits, with `PLAIN_RULES`, and in some worlds rules for robots without a task.
    instance, layout
        Orders, pods and grid.
    """

    name: str
    purpose: str
    scenario: Scenario
    instance: Instance
    layout: Layout

    def renamed(self) -> TrialWorld:
        """Return the same world with longer names of SKUs, orders and pods: they sort as before, and hash otherwise.

        Where a rule goes through a set of names, it goes through it in another order, as in another Python process.
        """
        given = self.instance
        instance = evolve(
            given,
            skus=tuple(f"1{sku}" for sku in given.skus),
            orders=tuple(evolve(order, name=f"1{order.name}") for order in given.orders),
            pods=tuple(evolve(pod, name=f"1{pod.name}") for pod in given.pods),
        )
        return evolve(self, instance=instance)

    def running_out(self) -> TrialWorld:
        """Return the same world with finite stock: what is ordered, dealt out to the pods, at least one item each."""
        given = self.instance
        items = {(pod.name, sku): 0 for pod in given.pods for sku, _ in pod.contents}
        for sku in range(len(given.skus)):
            having = [key for key in items if key[1] == sku]
            ordered = sum(quantity for order in given.orders for wanted, quantity in order.lines if wanted == sku)
            for number, key in enumerate(having):
                items[key] = max((ordered + number) // len(having), 1)
        pods = tuple(
            evolve(pod, contents=tuple((sku, items[pod.name, sku]) for sku, _ in pod.contents)) for pod in given.pods
        )
        return evolve(self, name=f"{self.name}{FINITE}", instance=evolve(given, pods=pods))


BATTERY = BatterySection(capacity_wh=40, idle_w=400, charging_w=5000)
"""Standing makes robots too low for a task within minutes, and the only charger has them back in half a minute."""

PACKING = PackingSection(stations=2, boxes=1, packers=1, conveyor_s=20.0)
"""Hardly any order can be split, and packers are no quicker than pickers."""

ORDERS = {"1": "ab", "2": "c", "3": "ade", "4": "b", "5": "bcdf", "6": "ef", "7": "a", "8": "cf", "9": "bde", "10": "d"}
PODS = {"A": "ab", "B": "bc", "C": "cd", "D": "de", "E": "ef", "F": "fa"}


def trial_worlds() -> tuple[TrialWorld, ...]:
    """Return the worlds, new ones at each call: first those named one by one, then those with finite stock instead."""
    plain = small_instance(ORDERS, PODS)
    one_pod_each = small_instance(
        {str(i): "abcdefgh"[i:] + "abcdefgh"[:i] for i in range(8)}, {s: s for s in "abcdefgh"}
    )
    worlds = (
        _world("one station", "the plainest case", plain, capacities=(8,)),
        _world("several stations", "stations of different size, one too small for most orders", plain, (4, 6, 5), 5),
        _world("finite stock", "exactly what is ordered is there, some of it on several pods", _finite(), (7, 7)),
        _world("full queues", "six robots for a queue of one pod", one_pod_each, (32,), 6, queue_length=1),
        _world("a single robot", "decisions that wait for a robot", plain, (5, 5), 1),
        _world("no order", "nothing to decide: no candidate at all", small_instance({}, PODS), (8, 8)),
        _world("later orders", "an empty backlog, and orders long after all is quiet", _later(), (5, 5)),
        _world("an order as large as the largest station", "it fits only when that is empty", _large(), (4, 9, 5)),
        _world("an order larger than the largest station", "it has a station alone", _large(), (4, 6, 5)),
        _world("a line longer than the largest station", "splitting does not help", _long_line(), (4, 6)),
        _world("lines of 10 to 40 items on finite stock", "several pods for one line", _many_items(), (45, 60)),
        _world("order capacity", "stations that count orders, whatever their size", plain, (2, 1), counts_orders=True),
        _world(
            "a station that closes",
            "what was assigned before is finished, nothing more",
            _later(),
            (5, 5),
            opening={"1": (("00:00", "00:02"),)},
        ),
        _world("batteries", "robots that have to charge", _later(), (5, 5), battery=BATTERY, idle="charge-when-low"),
        _world("moved pods", "pods that are away without a visit", _later(), (5, 5), 5, move="utility", pod_fill=0.95),
        _world("packing stations with a box each", "a box for each station", plain, (4, 6), 5, packing=PACKING),
        _reordered(),
        _delivered(),
    )
    more = (
        _world(
            "due times and priorities",
            "`due_s` in the past, near, far and None, and orders that are late at the end",
            _dated(),
            (5, 5),
        ),
        _world(
            "stations that take turns",
            "they close in the middle of orders, for a time none is open, and one opens later",
            _large(),
            (4, 9, 5),
            opening={"1": (("00:00", "00:01"), ("00:05", "24:00")), "2": (("00:01", "00:03"), ("00:06", "24:00"))}
            | {"3": (("00:04", "24:00"),)},
        ),
        _world("long lines", "lines of 10 to 40 items that one pod serves", _without_end(_many_items()), (45, 60)),
        _world("cancellations", "orders that leave the backlog, some as soon as they are there", _cancelled(), (5, 5)),
        _world("a horizon", "the run ends with orders open, after a warm-up", _later(), (5, 5), until_s=125),
    )
    return (*worlds, *(world.running_out() for world in worlds if world.instance.unlimited_stock), *more)


def _finite() -> Instance:
    """Exactly what is ordered is there, some of it on several pods, and an order wants more than any one pod has."""
    orders: Wanted = {"1": {"a": 3, "b": 1}, "2": {"b": 2}, "3": {"c": 1, "d": 2}, "4": {"a": 1, "d": 1}, "5": {"c": 2}}
    pods: Wanted = {
        "A": {"a": 2, "c": 1},
        "B": {"a": 2, "b": 1},
        "C": {"b": 2, "d": 1},
        "D": {"c": 2},
        "E": {"d": 2},
    }
    return small_instance(orders, pods)


def _later() -> Instance:
    """Nothing is there at the start; orders come one by one, two at once, and one long after all is quiet again."""
    arrivals = {"1": 60, "2": 60, "3": 75.5, "4": 80, "5": 110, "6": 111, "7": 112, "8": 130, "9": 200, "10": 3000}
    return small_instance(ORDERS, PODS, arrivals_s=arrivals)


def _dated() -> Instance:
    """Orders with due times of all kinds, with priorities, and without either."""
    given = _later()
    due = (1, None, 90_000, 3_000_000, 110_001, None, 112_000, 600_000, 201_000, None)
    orders = (
        evolve(order, due_tick=tick, priority=number % 3)
        for number, (order, tick) in enumerate(zip(given.orders, due, strict=True))
    )
    return evolve(given, orders=tuple(orders))


def _cancelled() -> Instance:
    """Half of the orders are cancelled: when they arrive, soon after that, or when they are picked."""
    given = _later()
    ticks = (60_000, None, 75_501, 90_000, None, None, 112_000, 3_600_000, None, 3_000_000)
    orders = (evolve(order, cancelled_tick=tick) for order, tick in zip(given.orders, ticks, strict=True))
    return evolve(given, orders=tuple(orders))


def _without_end(given: Instance) -> Instance:
    """Return an instance whose pods have enough of what they hold."""
    pods = (evolve(pod, contents=tuple((sku, None) for sku, _ in pod.contents)) for pod in given.pods)
    return evolve(given, pods=tuple(pods))


def _large() -> Instance:
    """One order fits a single station only, and only when that is empty; smaller ones come before and after it."""
    orders: Wanted = {"1": {"a": 1}, "2": {"b": 2, "c": 1}, "3": {"a": 4, "d": 3, "f": 2}, "4": {"e": 1}, "5": {"c": 1}}
    return small_instance(orders, PODS, arrivals_s={"4": 90, "5": 120})


def _long_line() -> Instance:
    """One order fits a single station only when that is empty, however it is split; another has two such lines."""
    orders: Wanted = {"1": {"a": 1, "b": 9}, "2": {"c": 2}, "3": {"d": 8, "e": 7}, "4": {"f": 3, "a": 2}, "5": {"c": 1}}
    return small_instance(orders, PODS, arrivals_s={"3": 20, "4": 90, "5": 120})


def _many_items() -> Instance:
    """Lines of 10 to 40 items, most of which only several pods bring together; few fit at a station at a time.

    Some of the pods that are sent for one line bring enough of another SKU for another line, too.
    """
    orders: Wanted = {
        "1": {"a": 40, "c": 20},
        "2": {"b": 30},
        "3": {"d": 30, "c": 15},
        "4": {"a": 25, "f": 11},
        "5": {"e": 40, "b": 10},
        "6": {"f": 20},
    }
    kinds: list[dict[str, int]] = [{"a": 12, "b": 10}] * 3 + [{"a": 10, "c": 10}] * 4
    kinds += [{"d": 10, "f": 10}, {"e": 10, "b": 5}] * 4
    pods: Wanted = dict(zip("ABCDEFGHIJKLMNO", kinds, strict=True))
    return small_instance(orders, pods, arrivals_s={"4": 30, "5": 30, "6": 60})


def _reordered() -> TrialWorld:
    """Each SKU is ordered when its last items are left; picking stations store, too, and pods have hardly any space."""
    orders: Wanted = {str(i): {"abcdef"[i % 6]: 2, "abcdef"[(i + 1) % 6]: 1} for i in range(2, 10)}
    pods: Wanted = {name: dict.fromkeys(skus, 2) for name, skus in PODS.items()}
    instance = small_instance(orders, pods, arrivals_s={str(i): 40.0 * i for i in range(2, 10)})
    levels = ((2, 5),) * len(instance.skus)
    process = Replenishment("reorder-point", reorder_point=2, order_up_to=5, lead_s=60, bundle_items=2)
    return _world(
        "replenishment at picking stations",
        "stock that runs out and is ordered, on pods with hardly any space",
        evolve(instance, levels=levels, restocked=True),
        capacities=(4, 6),
        replenishment=process,
        pod_capacity=6,
    )


def _delivered() -> TrialWorld:
    """Bundles come at their times to two stations of their own, of what no pod holds, too.

    However they are spread, each fits on some pod: space for 28 items, 23 items in all, 2 in a bundle.
    """
    orders: Wanted = {"1": {"a": 3, "g": 1}, "2": {"b": 2}, "3": {"h": 3}, "4": {"a": 2, "c": 2}, "5": {"g": 2, "h": 1}}
    pods: Wanted = {"A": {"a": 3, "b": 1}, "B": {"c": 4}, "C": {"d": 1, "e": 3}, "D": {"f": 1}}
    instance = small_instance(orders, pods, arrivals_s={"5": 300})
    bundles = (
        ("1", 0, "g", 1),
        ("2", 0, "h", 2),
        ("3", 0, "g", 2),
        ("4", 50, "h", 2),
        ("5", 50, "a", 2),
        ("6", 90, "b", 1),
    )
    coming = tuple(
        BundleData(name, arrival_tick=1000 * time, sku=instance.skus.index(sku), items=n)
        for name, time, sku, n in bundles
    )
    return _world(
        "replenishment stations",
        "SKUs that no pod has at first, and visits without picks",
        evolve(instance, bundles=coming, restocked=True),
        capacities=(7,),
        replenishment=Replenishment("file", file="bundles.csv"),
        pod_capacity=7,
        replenishment_stations=2,
        bundle_capacity=2,
    )


def _world(
    name: str,
    purpose: str,
    instance: Instance,
    capacities: Sequence[int],
    robots: int = 3,
    *,
    queue_length: int = 3,
    counts_orders: bool = False,
    opening: Mapping[str, tuple[Span, ...]] | None = None,
    replenishment: Replenishment | None = None,
    pod_capacity: int | None = None,
    replenishment_stations: int = 0,
    bundle_capacity: int | None = None,
    battery: BatterySection | None = None,
    idle: str | None = None,
    move: str | None = None,
    pod_fill: float = 0.6,
    until_s: float | None = None,
    packing: PackingSection | None = None,
) -> TrialWorld:
    capacity = tuple(capacities)
    resting, moving = (RuleChoice(name) if name else None for name in (idle, move))
    scenario = Scenario(
        rules=evolve(PLAIN_RULES, idle=resting, move=moving),
        instance=InstanceSection(replenishment=replenishment, pod_capacity=pod_capacity),
        layout=LayoutSection(pod_fill=pod_fill),
        robots=RobotsSection(count=robots, battery=battery),
        stations=StationsSection(
            item_capacity=capacity,
            order_capacity=capacity if counts_orders else None,
            queue_length=queue_length,
            open=opening,
            also_replenish=True if replenishment and not replenishment_stations else None,
            bundle_capacity=bundle_capacity,
        ),
        packing=packing,
        run=RunSection(until_s or LONGEST_S, until_s and until_s / 4, 2 * LONGEST_S),
    )
    layout = small_layout(
        len(capacity), queue_length=queue_length, replenishment=replenishment_stations, chargers=1 if battery else 0
    )
    return TrialWorld(name, purpose, scenario, instance, layout)
