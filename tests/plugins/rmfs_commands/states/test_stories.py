"""What decisions meant for one order or pod."""

from __future__ import annotations

from typing import Any

from rmfs_commands.states import Recorded
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.states.stories import order_story, pod_story, reduced
from rmfs_core.roles import Role

Content = dict[str, Any]


def decision(number: int, decides: str, content: Content, decided: Any, **ask: Any) -> Recorded:
    """Return a recorded decision made by hand; period and time are its number."""
    content = {**content, "ask": {"decides": decides, "period": number, **ask}, "time_s": float(number)}
    return Recorded(number, Role.labelled(decides), "rule", content, decided, None, f"line {number}")


def content(room: int, **changes: Any) -> Content:
    """Return a state with a station for four items, of which so many fit now, and two orders of two items each."""
    orders: dict[str, Any] = {name: {"lines": {"milk": 1, "tea": 1}, "parts": []} for name in "AB"}
    pods = {"P": {"contents": {"milk": None, "tea": None}}}
    state = {"orders": orders, "pods": pods, "stations": {"s": station(orders, room)}}
    return state | {"layout": {"map": ["....", "...."]}} | changes


def station(orders: dict[str, Any], room: int) -> Content:
    """Return a station for four items, of which so many fit now; the others are for an order that it adds."""
    if room < 4:
        orders["F"] = {"lines": {"jam": 4 - room}, "parts": [{"station": "s", "skus": ["jam"], "period": 1}]}
    return {"item_capacity": 4, "requests": [{"order": "F", "sku": "jam"}] * (4 - room)}


def test_why_an_order_waited() -> None:
    """Left out by the prefilters, no room, others preferred, part of it, all of it: one entry each, in order."""
    begun = content(2)
    begun["orders"]["A"]["parts"] = [{"station": "s", "skus": ["tea"], "period": 5}]
    other = {"assignments": [{"order": "B", "station": "s", "skus": ["milk", "tea"]}]}
    decisions = [
        decision(1, "POA", content(4, backlog=["B"]), other),
        decision(2, "POA", content(1), other),
        decision(3, "POA", content(0), other),
        decision(4, "POA", content(2), other),
        decision(
            5, "POA+PPS", content(2), {"assignments": [{"order": "A", "station": "s", "skus": ["tea"]}], "trips": []}
        ),
        decision(6, "POA", begun, {"assignments": [{"order": "A", "station": "s", "skus": ["milk"]}]}),
    ]
    assert [(episode.periods, episode.what) for episode in order_story(decisions, "A")] == [
        ((1, 1), "the prefilters left it out"),
        ((2, 2), "no station had room for its 2 open items, only for some of them"),
        ((3, 3), "no station had room for its 2 open items"),
        ((4, 4), "it fitted a station, but the rule preferred others"),
        ((5, 5), "assigned to station s: SKU tea; 1 of its lines stays in the backlog"),
        ((6, 6), "assigned to station s: SKU milk"),
    ]


def test_a_wait_is_told_once() -> None:
    """Decisions one after another in which it waited for the same reason are one entry, from the first to the last."""
    decisions = [decision(number, "POA", content(4), {"assignments": []}) for number in (1, 2, 3)]
    (episode,) = order_story(decisions, "A")
    assert (episode.number, episode.periods, episode.times_s) == (1, (1, 3), (1.0, 3.0))
    assert episode.what == "it fitted a station, but the rule assigned nothing"


def test_a_wait_for_stock() -> None:
    """From its arrival to the first decision, of any kind, that has it in the backlog; one that goes on, too."""
    orders = content(4)["orders"]
    waits = {"orders": orders | {"A": orders["A"] | {"arrival_s": 0.5, "waits_for_stock": True}}}
    there = {"orders": orders | {"A": orders["A"] | {"arrival_s": 0.5, "waits_for_stock": False}}}
    assigned = {"assignments": [{"order": "A", "station": "s", "skus": ["milk", "tea"]}]}
    decisions = [
        decision(1, "POA", content(4, **waits), {"assignments": []}),
        decision(2, "TA", content(4, **waits), {"tasks": []}),
        decision(3, "TA", content(4, **there), {"tasks": []}),
        decision(4, "POA", content(4, **there), assigned),
    ]
    first, last = order_story(decisions, "A")
    assert (first.what, first.times_s) == ("waited for stock from 0 s to 3 s", (1.0, 2.0))
    assert last.what == "assigned to station s: SKUs milk, tea"
    (still,) = order_story(decisions[:2], "A")
    assert still.what == "waits for stock since 0 s"


def test_a_wait_for_stations_to_open() -> None:
    """All stations closed, or those with room: it is said."""
    state = content(1)
    full, closed = state["stations"]["s"], {"item_capacity": 4, "requests": [], "staffed": False}
    decisions = [
        decision(number, "POA", state | {"stations": stations}, {"assignments": []})
        for number, stations in enumerate([{"s": closed}, {"s": full, "t": closed}, {"s": full}], start=1)
    ]
    assert [episode.what for episode in order_story(decisions, "A")] == [
        "all stations were closed",
        "no open station had room for its 2 open items, only for some of them",
        "no station had room for its 2 open items, only for some of them",
    ]


def test_an_order_split_among_stations() -> None:
    """What stays in the backlog is what no station was given."""
    state = content(4)
    state["orders"]["A"]["lines"]["jam"] = 2
    assigned = [{"order": "A", "station": station, "skus": [sku]} for station, sku in (("s", "milk"), ("t", "tea"))]
    assert [
        episode.what for episode in order_story([decision(1, "POA+PPS", state, {"assignments": assigned})], "A")
    ] == [
        "assigned to station s: SKU milk",
        "assigned to station t: SKU tea; 1 of its lines stays in the backlog",
    ]


def test_pods_for_an_order() -> None:
    """A pod that holds what the order has uncovered at the station is part of its story; another is not."""
    waiting = content(2)
    waiting["orders"]["A"]["parts"] = [{"station": "s", "skus": ["milk", "tea"], "period": 1}]
    waiting["stations"]["s"]["requests"] = [{"order": "A", "sku": "tea"}, {"order": "A", "sku": "milk", "pod": "Q"}]
    waiting["pods"]["Q"] = {"contents": {"milk": None}}
    decisions = [
        decision(1, "PPS", waiting, {"trips": [{"pod": "Q", "station": "s"}]}),
        decision(2, "PPS", waiting, {"trips": [{"pod": "P", "station": "s"}]}),
    ]
    assert [e.what for e in order_story(decisions, "A")] == ["pod P sent to station s: it holds SKU tea"]
    assert list(order_story(decisions, "C")) == []


def test_a_rule_that_failed() -> None:
    """A decision that was nothing valid is told, too."""
    (episode,) = order_story([decision(1, "POA", content(4), None)], "A")
    assert episode.what == "the rule decided nothing valid, which ended the run"


def test_where_a_pod_went() -> None:
    """Sent, fetched, stored: in this order, with what it was sent for and where it is stored."""
    wanted = content(4)
    wanted["orders"]["A"]["parts"] = [{"station": "s", "skus": ["milk"], "period": 1}]
    wanted["stations"]["s"]["requests"] = [{"order": "A", "sku": "milk"}]
    decisions = [
        decision(1, "PPS", wanted, {"trips": [{"pod": "P", "station": "s"}]}),
        decision(2, "TA", wanted, {"tasks": [{"robot": "3", "pod": "P"}]}),
        decision(3, "TA", wanted, {"tasks": [{"robot": "4", "pod": "Q"}]}),
        decision(4, "PR", wanted, {"cell": 6}, pod="P"),
        decision(5, "PR", wanted, {"cell": 7}, pod="Q"),
    ]
    assert [episode.what for episode in pod_story(decisions, "P")] == [
        "sent to station s: it holds SKU milk",
        "robot 3 fetches it",
        "stored at row 2, column 3",
    ]


def test_a_reduced_warehouse_has_the_room_of_the_whole_one(record: Any) -> None:
    """Free capacity, and open lines and size of an order, are those of the warehouse made from all of the state."""
    joint = ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time")
    by_orders, small = ("stations.order_capacity=2",), ("stations.item_capacity=3",)
    for settings in ((), by_orders, small, joint, (*joint, *by_orders)):
        for recorded in record(*settings):
            whole = open_state(recorded.state())
            for order in whole.view.orders[-3:]:
                part = reduced(recorded.content, order.name)
                alone = part.view.orders[0]
                lines = [(part.instance.skus[line.sku], line.quantity) for line in alone.open_lines]
                assert lines == [(whole.instance.skus[line.sku], line.quantity) for line in order.open_lines]
                for station, there in zip(part.view.stations, whole.view.stations, strict=True):
                    assert station.free_capacity == there.free_capacity
                    assert part.view.size_at(alone, station) == whole.view.size_at(order, there)
