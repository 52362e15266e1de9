"""What decisions meant for one order or pod."""

from __future__ import annotations

from typing import Any

from rmfs_commands.states import Recorded
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.states.stories import free_capacity, open_lines, order_story, pod_story
from rmfs_core.roles import Role

Content = dict[str, Any]


def decision(number: int, decides: str, content: Content, decided: Any, **ask: Any) -> Recorded:
    """Return a recorded decision made by hand; period and time are its number."""
    content = {**content, "ask": {"decides": decides, "period": number, **ask}, "time_s": float(number)}
    return Recorded(number, Role.labelled(decides), "rule", content, decided, None, f"line {number}")


def content(capacity: int, **changes: Any) -> Content:
    """Return a state with one station and two orders of two items each."""
    orders = {name: {"lines": {"milk": 1, "tea": 1}, "parts": []} for name in "AB"}
    pods = {"P": {"contents": {"milk": None, "tea": None}}}
    station = {"item_capacity": capacity, "requests": []}
    return {"orders": orders, "pods": pods, "stations": {"s": station}, "layout": {"map": ["....", "...."]}, **changes}


def test_why_an_order_waited() -> None:
    """Left out by the prefilters, no room, others preferred, part of it, all of it: one entry each, in order."""
    part = {
        "orders": {"A": {"lines": {"milk": 1, "tea": 1}, "parts": [{"station": "s", "skus": ["tea"], "period": 5}]}}
    }
    other = {"assignments": [{"order": "B", "station": "s", "skus": ["milk", "tea"]}]}
    decisions = [
        decision(1, "POA", content(4, backlog=["B"]), other),
        decision(2, "POA", content(1), other),
        decision(3, "POA", content(0), other),
        decision(4, "POA", content(2), other),
        decision(
            5, "POA+PPS", content(2), {"assignments": [{"order": "A", "station": "s", "skus": ["tea"]}], "trips": []}
        ),
        decision(6, "POA", content(2, **part), {"assignments": [{"order": "A", "station": "s", "skus": ["milk"]}]}),
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
    full = {"item_capacity": 1, "requests": []}
    closed = {"item_capacity": 4, "requests": [], "staffed": False}
    decisions = [
        decision(number, "POA", content(1, stations=stations), {"assignments": []})
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


def test_figures_are_those_of_the_warehouse(record: Any) -> None:
    """Free capacity and open lines, read off the JSON, are what the warehouse made from it has."""
    joint = ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time")
    by_orders, small = ("stations.order_capacity=2",), ("stations.item_capacity=3",)
    for settings in ((), by_orders, small, joint, (*joint, *by_orders)):
        for recorded in record(*settings):
            opened = open_state(recorded.state())
            for station in opened.view.stations:
                assert free_capacity(recorded.content, station.name) == station.free_capacity
            for order in opened.view.orders:
                lines = {opened.instance.skus[line.sku]: line.quantity for line in order.open_lines}
                assert open_lines(recorded.content, order.name) == lines
