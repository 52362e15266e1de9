"""Corruptions of work: pods lifted and set down, lines and visits, picks, orders, decisions."""

from corruptions.driving import MOVED
from corruptions.raw import Line, NotThereError, Raw, Where, changed, doubled, dropped, kind, next_of

# Pods lifted and set down

LIFTED, STORED, TASK, TRIP = "pod_lifted", "pod_stored", "task_assigned", "trip_decided"
dropped("a lift dropped", LIFTED)
dropped("the last lift dropped", LIFTED, at=1.0)
changed("a lift elsewhere", LIFTED, lambda line: {"cell": line["cell"] + 1})
changed("a lift of another pod", LIFTED, lambda line: {"pod": line["pod"] ^ 1})
changed("a lift by another robot", LIFTED, lambda line: {"robot": line["robot"] ^ 1})
changed("a lift a tick faster", LIFTED, lambda line: {"start_tick": line["start_tick"] + 1})
dropped("a pod's storing dropped", STORED)
dropped("the last storing dropped", STORED, at=1.0)
changed("a pod stored elsewhere", STORED, lambda line: {"cell": line["cell"] + 1})
changed("another pod stored", STORED, lambda line: {"pod": line["pod"] ^ 1})
changed("a storing that starts early", STORED, lambda line: {"start_tick": line["start_tick"] - 500})
changed("a storing later", STORED, lambda line: {"start_tick": line["start_tick"] + 1, "tick": line["tick"] + 1})
dropped("a task dropped", TASK)
dropped("the first task dropped", TASK, at=0.0)
doubled("a task twice", TASK)
changed("a task for another robot", TASK, lambda line: {"robot": line["robot"] ^ 1})
changed("a task for another pod", TASK, lambda line: {"pod": line["pod"] ^ 1})
dropped("a trip dropped", TRIP)
dropped("the last trip dropped", TRIP, at=1.0)
doubled("a trip twice", TRIP)
changed("a trip to another station", TRIP, lambda line: {"station": line["station"] ^ 1})
changed("a trip of another pod", TRIP, lambda line: {"pod": line["pod"] ^ 1})


@kind
def a_task_before_its_trip(raw: Raw) -> None:
    i = raw.place(TASK)
    raw.move(i, raw.preceding(i, TRIP, lambda line: line["pod"] == raw.events[i]["pod"]))


@kind
def a_task_after_the_lift(raw: Raw) -> None:
    i = raw.place(TASK)
    raw.move(i, raw.following(i, LIFTED, lambda line: line["pod"] == raw.events[i]["pod"]) + 1)


@kind
def a_trip_after_the_lift(raw: Raw) -> None:
    i = raw.place(TRIP)
    raw.move(i, raw.following(i, LIFTED, lambda line: line["pod"] == raw.events[i]["pod"]) + 1)


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
    raw.one(ELSEWHERE)["cell"] = next_of(raw.free_locations())


# Lines and visits

JOINED, STARTED, ENDED = "queue_joined", "visit_started", "visit_ended"
dropped("a joining dropped", JOINED)
dropped("the last joining dropped", JOINED, at=1.0)
doubled("a joining twice", JOINED)
changed("a joining of another line", JOINED, lambda line: {"station": line["station"] ^ 1})
changed("a joining by another robot", JOINED, lambda line: {"robot": line["robot"] ^ 1})
changed("a joining a tick early", JOINED, lambda line: {"tick": line["tick"] - 1})
dropped("a visit's start dropped", STARTED)
dropped("a visit's end dropped", ENDED)
doubled("a visit twice", STARTED)
changed("a visit by number", STARTED, lambda line: {"visit": line["visit"] + 1})
changed("a visit of another pod", STARTED, lambda line: {"pod": line["pod"] ^ 1})
changed("a visit at another station", STARTED, lambda line: {"station": line["station"] ^ 1})
changed("a visit a tick late", STARTED, lambda line: {"tick": line["tick"] + 1})
changed("a visit's end by number", ENDED, lambda line: {"visit": line["visit"] - 1})
changed("a visit's picks", ENDED, lambda line: {"picks": line["picks"] + 1})
changed("a visit that leads on", ENDED, lambda line: {"next_station": line["station"] ^ 1},
        lambda line: line["next_station"] is None)  # fmt: skip
changed("a visit that leads nowhere", ENDED, lambda line: {"next_station": None},
        lambda line: line["next_station"] is not None)  # fmt: skip


@kind
def a_queue_joined_only_when_the_visit_begins(raw: Raw) -> None:
    for i in raw.places(JOINED):
        j = raw.following(i, STARTED, lambda line, i=i: line["pod"] == raw.events[i]["pod"])  # type: ignore[misc]
        if raw.events[j]["tick"] > raw.events[i]["tick"]:
            raw.move(i, j)
            return
    raise NotThereError


@kind
def a_place_in_line_taken_too_early(raw: Raw) -> None:
    for i in raw.places(JOINED):
        j = raw.following(i, JOINED, lambda line, i=i: line["station"] == raw.events[i]["station"])  # type: ignore[misc]
        raw.move(j, i)
        return


@kind
def a_visit_that_ends_later(raw: Raw) -> None:
    line = raw.one(ENDED, lambda line: line["picks"])
    line["tick"] += 1
    raw.events.sort(key=lambda each: each["tick"])


# Picks

PICKED = "item_picked"
dropped("a pick dropped", PICKED)
doubled("a pick twice", PICKED)
changed("a pick for another order", PICKED, lambda line: {"order": line["order"] ^ 1})
changed("a pick of another SKU", PICKED, lambda line: {"sku": line["sku"] ^ 1})
changed("a pick from another pod", PICKED, lambda line: {"pod": line["pod"] ^ 1})
changed("a pick at another station", PICKED, lambda line: {"station": line["station"] ^ 1})
changed("a pick in another visit", PICKED, lambda line: {"visit": line["visit"] + 1})
changed("a pick that starts a tick early", PICKED, lambda line: {"start_tick": line["start_tick"] - 1})
changed("a pick a tick longer", PICKED, lambda line: {"tick": line["tick"] + 1})
changed("a picker free a tick early", PICKED, lambda line: {"picker_free_tick": line["picker_free_tick"] - 1})


@kind
def picks_in_another_order(raw: Raw) -> None:
    for i in raw.places(PICKED):
        j = next((j for j in raw.places(PICKED) if j > i), i)
        one, other = raw.events[i], raw.events[j]
        if one["visit"] == other["visit"] and (one["order"], one["sku"]) != (other["order"], other["sku"]):
            for name in ("order", "sku"):
                one[name], other[name] = other[name], one[name]
            return
    raise NotThereError


@kind
def a_pick_for_the_order_that_came_later(raw: Raw) -> None:
    for i in raw.places(PICKED):
        for j in raw.places(PICKED):
            one, other = raw.events[i], raw.events[j]
            same = (one["station"], one["sku"]) == (other["station"], other["sku"])
            if j > i and same and one["order"] != other["order"]:
                one["order"], other["order"] = other["order"], one["order"]
                return
    raise NotThereError


# Orders

ARRIVED, ASSIGNED, COMPLETED, DECIDED = "order_arrived", "order_assigned", "order_completed", "decision_made"
dropped("an arrival dropped", ARRIVED)
doubled("an arrival twice", ARRIVED)
changed("an arrival of another order", ARRIVED, lambda line: {"order": line["order"] ^ 1})
changed("an arrival a tick late", ARRIVED, lambda line: {"tick": line["tick"] + 1})
dropped("an assignment dropped", ASSIGNED)
doubled("an assignment twice", ASSIGNED)
changed("an assignment to another station", ASSIGNED, lambda line: {"station": line["station"] ^ 1})
changed("an assignment of another order", ASSIGNED, lambda line: {"order": line["order"] ^ 1})
changed("an assignment of a line less", ASSIGNED, lambda line: {"skus": line["skus"][1:]})
changed("an assignment of an item more", ASSIGNED, lambda line: {"items": line["items"] + 1})
changed("an assignment in the next period", ASSIGNED, lambda line: {"period": line["period"] + 1})
changed("an assignment said to be all", ASSIGNED, lambda line: {"complete": not line["complete"]})
dropped("a completion dropped", COMPLETED)
dropped("the last completion dropped", COMPLETED, at=1.0)
doubled("a completion twice", COMPLETED)
changed("a completion of another order", COMPLETED, lambda line: {"order": line["order"] ^ 1})
changed("a completion a tick late", COMPLETED, lambda line: {"tick": line["tick"] + 1})


@kind
def an_assignment_before_the_arrival(raw: Raw) -> None:
    i = raw.place(ASSIGNED)
    raw.move(i, raw.preceding(i, ARRIVED, lambda line: line["order"] == raw.events[i]["order"]))


@kind
def an_arrival_at_the_start(raw: Raw) -> None:
    raw.move(raw.place(ARRIVED, lambda line: line["tick"] > 0), raw.place(ARRIVED, at=0.0))


@kind
def an_arrival_after_the_next_decision(raw: Raw) -> None:
    i = raw.place(ARRIVED, lambda line: line["tick"] > 0)
    raw.move(i, raw.following(i, DECIDED) + 1)


@kind
def assignments_that_change_places(raw: Raw) -> None:
    for i in raw.places(ASSIGNED):
        for j in raw.places(ASSIGNED):
            one, other = raw.events[i], raw.events[j]
            if one["tick"] == other["tick"] and one["station"] != other["station"]:
                one["station"], other["station"] = other["station"], one["station"]
                return
    raise NotThereError


# Decisions


def empty(line: Line) -> bool:
    return not (line["assignments"] or line["trips"])


def on(what: str) -> Where:
    return lambda line: line["decides"] == what


dropped("a decision dropped", DECIDED)
dropped("the last decision dropped", DECIDED, at=1.0)
dropped("a decision on pods dropped", DECIDED, on("PPS"))
dropped("a decision on orders dropped", DECIDED, lambda line: line["decides"] != "PPS")
dropped("an empty decision dropped", DECIDED, empty)
doubled("a decision twice", DECIDED)
doubled("a decision on pods twice", DECIDED, on("PPS"))
changed("a decision in the next period", DECIDED, lambda line: {"period": line["period"] + 1})
changed("a decision of another rule", DECIDED, lambda _: {"rule": "somebody"})
changed("a decision on something else", DECIDED, lambda _: {"decides": "PR"})
changed("a decision that saw one order more", DECIDED, lambda line: {"backlog": line["backlog"] + 1})
changed("a decision that saw one order less", DECIDED, lambda line: {"backlog": line["backlog"] - 1},
        lambda line: line["backlog"] > 0)  # fmt: skip
changed("a decision of one assignment more", DECIDED, lambda line: {"assignments": line["assignments"] + 1})
changed("a decision of one trip more", DECIDED, lambda line: {"trips": line["trips"] + 1})
changed("a decision of another status", DECIDED, lambda line: {"status": f"nearly {line['status']}"})
changed("a decision that was stopped early", DECIDED, lambda line: {"stopped_early": not line["stopped_early"]})
changed("a bound above the objective", DECIDED, lambda line: {"bound": line["objective"] + 1},
        lambda line: line["objective"] is not None)  # fmt: skip
changed("a lower bound", DECIDED, lambda line: {"bound": line["bound"] - 1}, lambda line: line["bound"] is not None)
changed("another objective", DECIDED, lambda line: {"objective": (line["objective"] or 0) + 1})
changed("a decision a tick late", DECIDED, lambda line: {"tick": line["tick"] + 1})


@kind
def a_decision_before_what_it_decides(raw: Raw) -> None:
    i = raw.place(DECIDED, lambda line: not empty(line))
    raw.move(i, raw.preceding(i, ASSIGNED if raw.events[i]["assignments"] else TRIP))


# Names of what does not exist

for _event, _name in ((MOVED, "robot"), (LIFTED, "pod"), (TRIP, "station"), (ASSIGNED, "order"), (PICKED, "sku")):
    changed(f"a {_name} that does not exist, in {_event}", _event, lambda _, name=_name: {name: 10_000})


# Cancellations

CANCELLED = "order_cancelled"
dropped("a cancellation dropped", CANCELLED)
doubled("a cancellation twice", CANCELLED)
changed("a cancellation of another order", CANCELLED, lambda line: {"order": line["order"] ^ 1})
changed("a cancellation a tick late", CANCELLED, lambda line: {"tick": line["tick"] + 1})


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
    dropped(f"{_name} dropped", _event)
    doubled(f"{_name} twice", _event)
    changed(f"{_name} a second late", _event, lambda line: {"tick": line["tick"] + 1000})
changed("another number of robots on duty", "robots_on_duty", lambda line: {"number": line["number"] - 1})
changed("the last assignment to another station", ASSIGNED, lambda line: {"station": line["station"] ^ 1}, at=1.0)


@kind
def a_task_for_a_robot_off_duty(raw: Raw) -> None:
    raw.place("robots_on_duty")
    last = raw.place(STORED, lambda line: line["robot"] > 0, at=1.0)
    stored = raw.events[last]
    raw.events.insert(last + 1, {"e": TASK, "tick": stored["tick"], "robot": stored["robot"], "pod": 0})
