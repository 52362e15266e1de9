"""Corruptions of work: pods lifted and set down, lines and visits, picks, orders, decisions."""

from itertools import pairwise

from corruptions.driving import MOVED
from corruptions.raw import (
    Line,
    NotThereError,
    Raw,
    Where,
    changed,
    doubled,
    dropped,
    kind,
    missaid,
    next_of,
    others,
    shifted,
    swapped,
    too_early,
    too_late,
)

# Pods lifted and set down

LIFTED, STORED, TASK, TRIP = "pod_lifted", "pod_stored", "task_assigned", "trip_decided"
missaid("a lift", LIFTED)
shifted(LIFTED, 1, cell="a lift elsewhere", start_tick="a lift a tick faster")
others(LIFTED, pod="a lift of another pod", robot="a lift by another robot")
missaid("a storing", STORED)
shifted(STORED, 1, cell="a pod stored elsewhere")
shifted(STORED, -500, start_tick="a storing that starts early")
others(STORED, pod="another pod stored")
changed("a storing later", STORED, lambda line: {"start_tick": line["start_tick"] + 1, "tick": line["tick"] + 1})
missaid("a task", TASK)
dropped("the first task dropped", TASK, at=0.0)
others(TASK, robot="a task for another robot", pod="a task for another pod")
missaid("a trip", TRIP)
others(TRIP, station="a trip to another station", pod="a trip of another pod")
too_early("a task before its trip", TASK, TRIP, "pod")
too_late("a task after the lift", TASK, LIFTED, "pod")
too_late("a trip after the lift", TRIP, LIFTED, "pod")


@kind
def a_task_never_carried_out(raw: Raw) -> None:
    last = raw.place(STORED, at=1.0)
    robot = raw.events[last]["robot"]
    lifted = {line["pod"] for line in raw.events if line["e"] == LIFTED}
    pod = next_of([i for i in range(len(raw.header["pods"])) if i not in lifted])
    raw.events.insert(last + 1, {"e": TASK, "tick": raw.events[last]["tick"], "robot": robot, "pod": pod})


@kind
def a_trip_and_a_task_never_carried_out(raw: Raw) -> None:
    a_task_never_carried_out(raw)
    lifted = {line["pod"] for line in raw.events if line["e"] == LIFTED}
    i = raw.place(TASK, lambda line: line["pod"] not in lifted)
    task = raw.events[i]
    raw.events.insert(i, {"e": TRIP, "tick": task["tick"], "pod": task["pod"], "station": 0})


@kind
def a_fetch_that_never_happened(raw: Raw) -> None:
    i = raw.place(TASK, at=1.0)
    robot = raw.events[i]["robot"]
    raw.events[i + 1 :] = [
        line for line in raw.events[i + 1 :] if line.get("robot") != robot or line["e"] not in (MOVED, LIFTED)
    ]


# Robots without a task, and pods that are carried elsewhere

SENT, RESTED, ELSEWHERE = "robot_sent", "robot_rested", "pod_move_decided"
dropped("a robot that rests without being sent", SENT)
changed("a rest in the next cell", RESTED, lambda line: {"cell": line["cell"] + 1})


@kind
def a_robot_sent_to_rest_on_the_floor(raw: Raw) -> None:
    raw.one(SENT)["cell"] = raw.cells("1")[0]


@kind
def a_robot_sent_to_rest_where_another_stands(raw: Raw) -> None:
    i = raw.place(SENT)
    cells = {robot: place["cell"] for robot, place in enumerate(raw.header["robots"])}
    cells |= {line["robot"]: line["to"] for line in raw.events[:i] if line["e"] == MOVED}
    del cells[raw.events[i]["robot"]]
    raw.events[i]["cell"] = next_of([cell for cell in cells.values() if cell in raw.cells("2")])


@kind
def a_trip_of_a_pod_that_is_carried_elsewhere(raw: Raw) -> None:
    i = raw.place(ELSEWHERE)
    decided = raw.events[i]
    raw.events.insert(i, {"e": TRIP, "tick": decided["tick"], "pod": decided["pod"], "station": 0})


@kind
def a_pod_carried_to_another_location(raw: Raw) -> None:
    raw.one(ELSEWHERE)["cell"] = raw.free_location


# Lines and visits

JOINED, STARTED, ENDED = "queue_joined", "visit_started", "visit_ended"
missaid("a joining", JOINED)
others(JOINED, station="a joining of another line", robot="a joining by another robot")
shifted(JOINED, -1, tick="a joining a tick early")
missaid("a visit's start", STARTED)
missaid("a visit's end", ENDED)
shifted(STARTED, 1, visit="a visit by number", tick="a visit a tick late")
others(STARTED, pod="a visit of another pod", station="a visit at another station")
shifted(ENDED, -1, visit="a visit's end by number")
shifted(ENDED, 1, picks="a visit's picks")
changed("a visit that leads on", ENDED, lambda line: {"next_station": line["station"] ^ 1},
        lambda line: line["next_station"] is None)  # fmt: skip
changed("a visit that leads nowhere", ENDED, lambda line: {"next_station": None},
        lambda line: line["next_station"] is not None)  # fmt: skip


@kind
def a_queue_joined_only_when_the_visit_begins(raw: Raw) -> None:
    for i in raw.places(JOINED):
        j = raw.following(i, STARTED, raw.alike(i, "pod"))
        if raw.events[j]["tick"] > raw.events[i]["tick"]:
            raw.move(i, j)
            return
    raise NotThereError


@kind
def a_place_in_line_taken_too_early(raw: Raw) -> None:
    i = raw.place(JOINED, at=0.0)
    raw.move(raw.following(i, JOINED, raw.alike(i, "station")), i)


@kind
def a_visit_that_ends_later(raw: Raw) -> None:
    line = raw.one(ENDED, lambda line: line["picks"])
    line["tick"] += 1
    raw.events.sort(key=lambda each: each["tick"])


# Picks

PICKED = "item_picked"
missaid("a pick", PICKED)
others(PICKED, order="a pick for another order", sku="a pick of another SKU", pod="a pick from another pod")
others(PICKED, station="a pick at another station")
shifted(PICKED, 1, visit="a pick in another visit", tick="a pick a tick longer")
shifted(PICKED, -1, start_tick="a pick that starts a tick early", picker_free_tick="a picker free a tick early")
swapped("a pick for the order that came later", PICKED, ("station", "sku"), "order")


@kind
def picks_in_another_order(raw: Raw) -> None:
    for i, j in pairwise(raw.places(PICKED)):
        one, other = raw.events[i], raw.events[j]
        if one["visit"] == other["visit"] and (one["order"], one["sku"]) != (other["order"], other["sku"]):
            for name in ("order", "sku"):
                one[name], other[name] = other[name], one[name]
            return
    raise NotThereError


# Orders

ARRIVED, ASSIGNED, COMPLETED, DECIDED = "order_arrived", "order_assigned", "order_completed", "decision_made"
missaid("an arrival", ARRIVED)
others(ARRIVED, order="an arrival of another order")
shifted(ARRIVED, 1, tick="an arrival a tick late")
missaid("an assignment", ASSIGNED)
others(ASSIGNED, station="an assignment to another station", order="an assignment of another order")
others(ASSIGNED, at=1.0, station="the last assignment to another station")
shifted(ASSIGNED, 1, items="an assignment of an item more", period="an assignment in the next period")
changed("an assignment of a line less", ASSIGNED, lambda line: {"skus": line["skus"][1:]})
changed("an assignment said to be all", ASSIGNED, lambda line: {"complete": not line["complete"]})
too_early("an assignment before the arrival", ASSIGNED, ARRIVED, "order")
swapped("assignments that change places", ASSIGNED, ("tick",), "station")
missaid("a completion", COMPLETED)
others(COMPLETED, order="a completion of another order")
shifted(COMPLETED, 1, tick="a completion a tick late")


@kind
def an_arrival_at_the_start(raw: Raw) -> None:
    raw.move(raw.place(ARRIVED, lambda line: line["tick"] > 0), raw.place(ARRIVED, at=0.0))


@kind
def an_arrival_after_the_next_decision(raw: Raw) -> None:
    i = raw.place(ARRIVED, lambda line: line["tick"] > 0)
    raw.move(i, raw.following(i, DECIDED) + 1)


# Decisions


def empty(line: Line) -> bool:
    return not (line["assignments"] or line["trips"])


def on(what: str) -> Where:
    return lambda line: line["decides"] == what


missaid("a decision", DECIDED)
dropped("a decision on pods dropped", DECIDED, on("PPS"))
dropped("a decision on orders dropped", DECIDED, lambda line: line["decides"] != "PPS")
dropped("an empty decision dropped", DECIDED, empty)
doubled("a decision on pods twice", DECIDED, on("PPS"))
shifted(DECIDED, 1, period="a decision in the next period", backlog="a decision that saw one order more")
shifted(DECIDED, -1, lambda line: line["backlog"] > 0, backlog="a decision that saw one order less")
shifted(DECIDED, 1, assignments="a decision of one assignment more", trips="a decision of one trip more")
shifted(DECIDED, 1, tick="a decision a tick late")
shifted(DECIDED, -1, lambda line: line["bound"] is not None, bound="a lower bound")
changed("a decision of another rule", DECIDED, lambda _: {"rule": "somebody"})
changed("a decision on something else", DECIDED, lambda _: {"decides": "PR"})
changed("a decision of another status", DECIDED, lambda line: {"status": f"nearly {line['status']}"})
changed("a decision that was stopped early", DECIDED, lambda line: {"stopped_early": not line["stopped_early"]})
changed("a bound above the objective", DECIDED, lambda line: {"bound": line["objective"] + 1},
        lambda line: line["objective"] is not None)  # fmt: skip
changed("another objective", DECIDED, lambda line: {"objective": (line["objective"] or 0) + 1})


@kind
def a_decision_before_what_it_decides(raw: Raw) -> None:
    i = raw.place(DECIDED, lambda line: not empty(line))
    raw.move(i, raw.preceding(i, ASSIGNED if raw.events[i]["assignments"] else TRIP))


# Names of what does not exist

for _event, _name in ((MOVED, "robot"), (LIFTED, "pod"), (TRIP, "station"), (ASSIGNED, "order"), (PICKED, "sku")):
    changed(f"a {_name} that does not exist, in {_event}", _event, lambda _, name=_name: {name: 10_000})


# Cancellations

CANCELLED = "order_cancelled"
missaid("a cancellation", CANCELLED)
others(CANCELLED, order="a cancellation of another order")
shifted(CANCELLED, 1, tick="a cancellation a tick late")


@kind
def a_cancellation_of_an_order_that_is_begun(raw: Raw) -> None:
    line = raw.one(CANCELLED)
    tick = raw.header["orders"][line["order"]]["cancelled"]
    raw.header["orders"][line["order"]]["cancelled"] = tick + 1
    line["order"] = raw.one(ASSIGNED, lambda other: other["tick"] < tick)["order"]
    raw.header["orders"][line["order"]]["cancelled"] = tick


@kind
def a_cancellation_that_nobody_asked_for(raw: Raw) -> None:
    del raw.header["orders"][raw.one(CANCELLED)["order"]]["cancelled"]


@kind
def an_assignment_after_the_cancellation(raw: Raw) -> None:
    i = raw.place(CANCELLED)
    later = raw.following(i, ASSIGNED)
    raw.events[later]["order"] = raw.events[i]["order"]


# Hours

for _name, _event in (
    ("an opening", "station_opened"),
    ("a closing", "station_closed"),
    ("a change of robots on duty", "robots_on_duty"),
):
    missaid(_name, _event)
    shifted(_event, 1000, tick=f"{_name} a second late")
shifted("robots_on_duty", -1, number="another number of robots on duty")


@kind
def a_task_for_a_robot_off_duty(raw: Raw) -> None:
    raw.place("robots_on_duty")
    last = raw.place(STORED, lambda line: line["robot"] > 0, at=1.0)
    stored = raw.events[last]
    raw.events.insert(last + 1, {"e": TASK, "tick": stored["tick"], "robot": stored["robot"], "pod": 0})
