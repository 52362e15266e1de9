"""Items are picked from a pod at the station, one after another, and only those that are wanted."""

from __future__ import annotations

import pytest
from attrs import evolve

from damage import Damage, assert_found, at, change, drop, find, put, repeat, told, twice, without
from rmfs_commands.trace.reader import Trace
from rmfs_core.events import ItemPicked

TEA, JAM, LAST = 13, 14, 15
"""Places of events in `day`."""
TEA_PICKED, JAM_PICKED = (f"SKU {sku} of order A is picked from pod P0 at station 1" for sku in ("tea", "jam"))


def other_sku(trace: Trace) -> Trace:
    """Pick a SKU that the pod has and the order does not want."""
    for place, event in enumerate(trace.events):
        if isinstance(event, ItemPicked):
            held, wanted = trace.instance.pods[event.pod].contents, trace.instance.orders[event.order].lines
            spare = {sku for sku, _ in held} - {sku for sku, _ in wanted}
            if spare:
                return put(trace, place, evolve(event, sku=min(spare)))
    raise AssertionError("every pod holds only what is wanted")


def without_stock(number: int | None) -> Damage:
    """Return the damage that leaves so many items of a SKU on the pod it is picked from; None: not even the SKU."""

    def damage(trace: Trace) -> Trace:
        event = trace.events[find(trace, ItemPicked)]
        assert isinstance(event, ItemPicked)
        pod = trace.instance.pods[event.pod]
        contents = tuple(
            (sku, number if sku == event.sku else held)
            for sku, held in pod.contents
            if sku != event.sku or number is not None
        )
        pods = list(trace.instance.pods)
        pods[event.pod] = evolve(pod, contents=contents)
        return evolve(trace, instance=evolve(trace.instance, pods=tuple(pods)))

    return damage


def pick_of_complete_order(trace: Trace) -> Trace:
    """Tell of the last pick twice, a handling time later."""
    at = find(trace, ItemPicked, number=10**6)
    event = trace.events[at]
    assert isinstance(event, ItemPicked)
    again = evolve(
        event,
        start_tick=event.picker_free_tick,
        tick=event.picker_free_tick + 7000,
        picker_free_tick=event.picker_free_tick + 13_000,
    )
    return evolve(put(trace, at, event, again), tick=again.tick)


def jam_on_pod(number: int) -> Damage:
    """Return the damage that leaves so many items of jam on the pod that the day is served from."""

    def damage(trace: Trace) -> Trace:
        pod, *others = trace.instance.pods
        pods = (evolve(pod, contents=((0, None), (1, number))), *others)
        return evolve(trace, instance=evolve(trace.instance, pods=pods))

    return damage


DAMAGES: list[tuple[str, Damage, str]] = [
    ("a pick dropped", drop(ItemPicked), "completed-early"),
    ("a pick twice", repeat(ItemPicked), "picker-busy"),
    ("a pick too many", pick_of_complete_order, "picked-twice"),
    ("a pick in another visit", change(ItemPicked, lambda t, e: {"visit": e.visit + 1}), "no-visit"),
    ("a pick before the visit", change(ItemPicked, lambda t, e: {"start_tick": 0}), "no-visit"),
    ("a pick too short", change(ItemPicked, lambda t, e: {"start_tick": e.start_tick + 10}), "pick-time"),
    ("a pick handled too fast", change(ItemPicked, lambda t, e: {"picker_free_tick": e.tick}), "handle-time"),
    ("a pick for nobody", other_sku, "not-ordered"),
    ("a pick from a pod without the SKU", without_stock(None), "sku-not-on-pod"),
    ("a pick from an empty pod", without_stock(0), "stock-negative"),
]


@pytest.mark.parametrize(("damage", "kind"), [pytest.param(d, k, id=name) for name, d, k in DAMAGES])
def test_damage_to_a_run_is_found(recorded: Trace, damage: Damage, kind: str) -> None:
    """Whatever is wrong in a run of many orders is among its faults."""
    assert_found(damage(recorded), kind)


@pytest.mark.parametrize(
    ("damage", "faults"),
    [
        (
            without(JAM),
            [
                "completed-early: order A is complete, but 1 of its items are not picked",
                "visit-picks: pod P0 leaves station 1 after 2 picks, but reports 3",
            ],
        ),
        (
            twice(LAST),
            [
                f"picker-busy: {JAM_PICKED} from 41.028 s on, but its picker handles another item until 54.028 s",
                f"picked-twice: {JAM_PICKED}, but all its items have been picked",
                "visit-picks: pod P0 leaves station 1 after 4 picks, but reports 3",
            ],
        ),
        (
            at(JAM, visit=2),
            [
                f"no-visit: {JAM_PICKED} in visit 2, but pod P0 with visit 1 is there",
            ],
        ),
        (
            at(TEA, start_tick=15_000),
            [
                f"no-visit: {TEA_PICKED} from 15.000 s on, before its visit began at 15.028 s",
                f"pick-time: {TEA_PICKED} in 7.028 s; that takes 7.000 s",
                f"handle-time: {TEA_PICKED} and handled in 13.028 s; expected 13.000 s",
            ],
        ),
        (
            at(JAM, tick=35_029),
            [
                f"pick-time: {JAM_PICKED} in 7.001 s; that takes 7.000 s",
            ],
        ),
        (
            at(JAM, picker_free_tick=41_027),
            [
                f"handle-time: {JAM_PICKED} and handled in 12.999 s; expected 13.000 s",
            ],
        ),
        (
            at(JAM, sku=2),
            [
                "not-ordered: SKU rye of order A is picked from pod P0 at station 1, "
                "but the order does not have the SKU",
                "completed-early: order A is complete, but 1 of its items are not picked",
            ],
        ),
        (
            at(JAM, pod=1),
            [
                "no-visit: SKU jam of order A is picked from pod P1 at station 1 in visit 1, "
                "but pod P0 with visit 1 is there",
                "sku-not-on-pod: SKU jam of order A is picked from pod P1 at station 1, which does not hold it",
            ],
        ),
        (
            jam_on_pod(1),
            [
                f"stock-negative: {JAM_PICKED}, which has none left",
            ],
        ),
        (
            jam_on_pod(2),
            [],
        ),
    ],
)
def test_a_damaged_day_is_told(day: Trace, damage: Damage, faults: list[str]) -> None:
    """Each fault of one pick has its sentence; as many items as a pod holds may be picked."""
    assert told(damage(day)) == faults
