"""Kinds of corruption of a recorded trace, each a small function under the name that a test shows.

A corruption is made in what the file holds, header and lines, and is as small as a mistake of a simulation, or of
somebody who changes a trace by hand, can be. `NotThereError` says that a trace has nothing of the kind.
"""

from __future__ import annotations

import copy
import gzip
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from attrs import define

Line = dict[str, Any]
Where = Callable[[Line], bool]
STEPS = ((1, 0), (0, -1), (-1, 0), (0, 1))


class NotThereError(Exception):
    """A trace has nothing that could be corrupted so."""


@define(eq=False)
class Raw:
    """What a trace file holds.

    Parameters
    ----------
    header, events, end
        The first line, those of events, the last one.
    """

    header: Line
    events: list[Line]
    end: Line

    @classmethod
    def read(cls, file: Path) -> Raw:
        """Read a trace file."""
        with gzip.open(file, "rt", encoding="utf-8") as stream:
            header, *events, end = map(json.loads, stream)
        return cls(header, events, end)

    def write(self, file: Path) -> None:
        """Write a trace file."""
        with gzip.open(file, "wt", encoding="utf-8", compresslevel=1) as stream:
            stream.writelines(json.dumps(line) + "\n" for line in (self.header, *self.events, self.end))

    def copy(self) -> Raw:
        """Return one that can be corrupted."""
        return copy.deepcopy(self)

    # What is where

    def places(self, kind: str, where: Where = lambda _: True) -> list[int]:
        """Return the places of the events of a kind."""
        found = [i for i, line in enumerate(self.events) if line["e"] == kind and where(line)]
        if not found:
            raise NotThereError(kind)
        return found

    def place(self, kind: str, where: Where = lambda _: True, at: float = 0.5) -> int:
        """Return the place of one of them: of the first with 0.0, of the last with 1.0, else of one in between."""
        found = self.places(kind, where)
        return found[min(int(at * len(found)), len(found) - 1)]

    def one(self, kind: str, where: Where = lambda _: True, at: float = 0.5) -> Line:
        """Return one of the events of a kind."""
        return self.events[self.place(kind, where, at)]

    def drop(self, kind: str, where: Where = lambda _: True, at: float = 0.5) -> None:
        """Leave out an event."""
        del self.events[self.place(kind, where, at)]

    def twice(self, kind: str, where: Where = lambda _: True) -> None:
        """Tell an event twice."""
        i = self.place(kind, where)
        self.events.insert(i, dict(self.events[i]))

    def move(self, i: int, to: int) -> None:
        """Tell an event at the place, and the time, of another one."""
        line = self.events.pop(i)
        to -= to > i
        line["tick"] = self.events[min(to, len(self.events) - 1)]["tick"]
        self.events.insert(to, line)

    def following(self, i: int, kind: str, where: Where = lambda _: True) -> int:
        """Return the place of the next event of a kind behind a place."""
        return next_of(j for j in self.places(kind, where) if j > i)

    def preceding(self, i: int, kind: str, where: Where = lambda _: True) -> int:
        """Return the place of the last event of a kind ahead of a place."""
        return next_of(j for j in reversed(self.places(kind, where)) if j < i)

    @property
    def scenario(self) -> Line:
        """The scenario in the header."""
        found: Line = self.header["scenario"]
        return found

    # Cells

    @property
    def width(self) -> int:
        """Columns of the grid."""
        return int(self.header["layout"]["width"])

    def cells(self, sign: str) -> list[int]:
        """Return the cells of a kind."""
        text = "".join(self.header["layout"]["kind"])
        return [cell for cell, found in enumerate(text) if found == sign]

    def visited(self) -> set[int]:
        """Return the cells that robots stand in or pass."""
        found = {robot["cell"] for robot in self.header["robots"]}
        for line in self.events:
            if line["e"] == "robot_moved":
                right, down = STEPS[line["heading"]]
                step = right + down * self.width
                found.update(line["origin"] + step * i for i in range(line["distance_m"] + 1))
        return found

    def free_locations(self) -> list[int]:
        """Return the storage locations where nothing ever stands, and nothing is ever set down."""
        taken = {*self.header["blocked"], *(pod["cell"] for pod in self.header["pods"])}
        stored = {line["cell"] for line in self.events if line["e"] == "pod_stored"}
        return [cell for cell in self.cells("2") if cell not in taken | stored | self.visited()]

    def set_sign(self, grid: str, cell: int, sign: str) -> None:
        """Change a cell of the layout."""
        rows = self.header["layout"][grid]
        row, column = divmod(cell, self.width)
        rows[row] = rows[row][:column] + sign + rows[row][column + 1 :]

    def moves(self, cell: int) -> int:
        """Return the headings in which a cell may be left, as bits."""
        row, column = divmod(cell, self.width)
        return int(self.header["layout"]["moves"][row][column], 16)


Corruption = Callable[[Raw], None]
KINDS: dict[str, Corruption] = {}


def kind(corruption: Corruption) -> Corruption:
    """Register a corruption under its name."""
    KINDS[corruption.__name__.replace("_", " ")] = corruption
    return corruption


def next_of(found: Iterator[Any] | list[Any]) -> Any:
    """Return the first of them; there may be none."""
    for one in found:
        return one
    raise NotThereError


def changed(name: str, event: str, by: Callable[[Line], Line], where: Where = lambda _: True, at: float = 0.5) -> None:
    """Register the corruption that changes fields of one event."""

    def corruption(raw: Raw) -> None:
        line = raw.one(event, where, at)
        line.update(by(line))

    KINDS[name] = corruption


def dropped(name: str, event: str, where: Where = lambda _: True, at: float = 0.5) -> None:
    """Register the corruption that leaves out one event."""
    KINDS[name] = lambda raw: raw.drop(event, where, at)


def doubled(name: str, event: str, where: Where = lambda _: True) -> None:
    """Register the corruption that tells one event twice."""
    KINDS[name] = lambda raw: raw.twice(event, where)


def scenario_says(name: str, section: str, key: str, by: Callable[[Any], Any], given: bool = True) -> None:
    """Register the corruption that changes a key of the scenario in the header."""

    def corruption(raw: Raw) -> None:
        table = raw.scenario[section] if section else raw.scenario
        if given and key not in table:
            raise NotThereError(key)
        table[key] = by(table.get(key))

    KINDS[name] = corruption


# The header: the layout


@kind
def a_one_way_cell_opened(raw: Raw) -> None:
    """A cell may be left in one more direction, towards a neighbour that is floor."""
    floor = set(raw.cells("1"))
    for cell in sorted(floor):
        for heading, (right, down) in enumerate(STEPS):
            column = cell % raw.width + right
            inside = 0 <= column < raw.width and cell + right + down * raw.width in floor
            if inside and not raw.moves(cell) >> heading & 1:
                raw.set_sign("moves", cell, f"{raw.moves(cell) | 1 << heading:x}")
                return
    raise NotThereError


@kind
def a_cell_closed_where_nobody_drives(raw: Raw) -> None:
    """A cell may be left in one direction less."""
    cell = next_of([cell for cell in raw.cells("1") if raw.moves(cell) and cell not in raw.visited()])
    raw.set_sign("moves", cell, f"{raw.moves(cell) & (raw.moves(cell) - 1):x}")


@kind
def floor_in_place_of_storage(raw: Raw) -> None:
    """A storage location where nothing stands is floor."""
    raw.set_sign("kind", next_of(raw.free_locations()), "1")


@kind
def floor_in_place_of_storage_with_an_empty_pod(raw: Raw) -> None:
    """A blocked storage location is floor, and its pod is gone."""
    raw.set_sign("kind", next_of(raw.header["blocked"]), "1")
    del raw.header["blocked"][0]


@kind
def storage_in_place_of_floor(raw: Raw) -> None:
    """Floor where nobody drives is a storage location."""
    raw.set_sign("kind", next_of([cell for cell in raw.cells("1") if cell not in raw.visited()]), "2")


@kind
def a_wall_in_place_of_storage(raw: Raw) -> None:
    """A storage location where nothing stands is a wall."""
    raw.set_sign("kind", next_of(raw.free_locations()), "0")


@kind
def a_queue_cell_less(raw: Raw) -> None:
    """A station's queue ends one cell earlier."""
    queue = raw.header["layout"]["stations"][0]["queue"]
    if len(queue) < 2:
        raise NotThereError
    queue.pop()


@kind
def a_queue_the_other_way_round(raw: Raw) -> None:
    """The cell next to the station is the entry."""
    queue = raw.header["layout"]["stations"][-1]["queue"]
    if len(queue) < 2:
        raise NotThereError
    queue.reverse()


# The header: what stands where


@kind
def an_empty_pod_elsewhere(raw: Raw) -> None:
    """A blocked location is another one where nothing ever stands."""
    if not raw.header["blocked"]:
        raise NotThereError
    raw.header["blocked"][0] = next_of(raw.free_locations())


@kind
def an_empty_pod_less(raw: Raw) -> None:
    """A blocked location is free."""
    if not raw.header["blocked"]:
        raise NotThereError
    raw.header["blocked"].pop()


@kind
def an_empty_pod_more(raw: Raw) -> None:
    """A free location is blocked."""
    raw.header["blocked"].append(next_of(raw.free_locations()))


@kind
def an_extra_parked_robot(raw: Raw) -> None:
    """A robot that does nothing stands at a free location."""
    raw.header["robots"].append({"cell": next_of(raw.free_locations()), "heading": 1})


@kind
def a_robot_starts_elsewhere(raw: Raw) -> None:
    """The first robot stands somewhere else at the start."""
    raw.header["robots"][0]["cell"] = next_of(raw.free_locations())


@kind
def a_robot_starts_with_another_heading(raw: Raw) -> None:
    """The last robot faces west at the start."""
    raw.header["robots"][-1]["heading"] = (raw.header["robots"][-1]["heading"] + 1) % 4


@kind
def a_pod_that_is_never_fetched_stands_elsewhere(raw: Raw) -> None:
    """A pod that stays where it is stands at another location."""
    fetched = {line["pod"] for line in raw.events if line["e"] == "task_assigned"}
    pods = [pod for i, pod in enumerate(raw.header["pods"]) if i not in fetched and pod["robot"] is None]
    next_of(pods)["cell"] = next_of(raw.free_locations())


@kind
def a_pod_bound_for_a_station_from_the_start(raw: Raw) -> None:
    """A pod that stays where it is counts as on its way."""
    fetched = {line["pod"] for line in raw.events if line["e"] == "task_assigned"}
    next_of([pod for i, pod in enumerate(raw.header["pods"]) if i not in fetched and not pod["bound_for"]])[
        "bound_for"
    ] = [0]


@kind
def a_pod_more(raw: Raw) -> None:
    """A pod with contents stands at a free location."""
    cell = next_of(raw.free_locations())
    pod = {"name": "extra", "contents": [[0, None]], "cell": cell, "robot": None, "bound_for": []}
    raw.header["pods"].append(pod)


# The header: orders, pods, stations


@kind
def an_order_twice_by_name(raw: Raw) -> None:
    """Two orders have one name."""
    raw.header["orders"][1]["name"] = raw.header["orders"][0]["name"]


@kind
def an_order_with_another_name(raw: Raw) -> None:
    """An order has a name that nobody gave it."""
    raw.header["orders"][1]["name"] = "another"


@kind
def a_pod_twice_by_name(raw: Raw) -> None:
    """Two pods have one name."""
    raw.header["pods"][1]["name"] = raw.header["pods"][0]["name"]


@kind
def a_sku_twice_by_name(raw: Raw) -> None:
    """Two SKUs have one name."""
    raw.header["skus"][1] = raw.header["skus"][0]


@kind
def an_order_that_came_later(raw: Raw) -> None:
    """An order arrived a second later, in the header alone."""
    raw.header["orders"][-1]["arrival"] += 1000


@kind
def an_order_that_came_a_tick_earlier(raw: Raw) -> None:
    """An order arrived a tick earlier, in the header and in its event."""
    number = next_of([i for i, order in enumerate(raw.header["orders"]) if order["arrival"] > 0])
    raw.header["orders"][number]["arrival"] -= 1
    raw.one("order_arrived", lambda line: line["order"] == number)["tick"] -= 1


@kind
def an_order_due_later(raw: Raw) -> None:
    """An order has another due time."""
    next_of([order for order in raw.header["orders"] if "due" in order])["due"] += 1000


@kind
def an_order_more_urgent(raw: Raw) -> None:
    """An order has another priority."""
    order = raw.header["orders"][0]
    order["priority"] = order.get("priority", 0) + 1


@kind
def an_order_of_one_more_item(raw: Raw) -> None:
    """A line wants one item more."""
    raw.header["orders"][len(raw.header["orders"]) // 2]["lines"][0][1] += 1


@kind
def an_order_more(raw: Raw) -> None:
    """An order that never arrives."""
    raw.header["orders"].append({"name": "extra", "arrival": 10**9, "lines": [[0, 1]]})


@kind
def a_sku_more_on_a_pod(raw: Raw) -> None:
    """A pod holds what it did not hold."""
    for pod in raw.header["pods"]:
        for sku in range(len(raw.header["skus"])):
            if all(held != sku for held, _ in pod["contents"]):
                pod["contents"].append([sku, 3])
                return
    raise NotThereError


@kind
def other_stock(raw: Raw) -> None:
    """A pod holds many items where it held some, or so many as nobody can count."""
    contents = next_of([pod for pod in raw.header["pods"] if pod["contents"]])["contents"]
    contents[0][1] = 1000 if contents[0][1] is None else contents[0][1] + 1000


@kind
def a_larger_station(raw: Raw) -> None:
    """A station takes one more, in its own line of the header alone."""
    raw.header["stations"][0]["capacity"] += 1


@kind
def larger_stations(raw: Raw) -> None:
    """Each station takes one more, in the scenario, too."""
    table = raw.scenario["stations"]
    name = "order_capacity" if "order_capacity" in table else "item_capacity"
    table[name] = [one + 1 for one in table[name]] if isinstance(table[name], list) else table[name] + 1
    for station in raw.header["stations"]:
        station["capacity"] += 1


@kind
def stations_that_count_otherwise(raw: Raw) -> None:
    """Stations count orders in place of items, or the other way round."""
    for station in raw.header["stations"]:
        station["counts_orders"] = not station["counts_orders"]


@kind
def a_station_with_another_name(raw: Raw) -> None:
    """A station is called otherwise."""
    raw.header["stations"][0]["name"] = "north"


@kind
def another_version(raw: Raw) -> None:
    """The run was recorded by another version, so that nothing can be made anew."""
    raw.header["versions"] = dict.fromkeys(raw.header["versions"], "0.1")


@kind
def a_version_left_out(raw: Raw) -> None:
    """Nobody says which version recorded the run, and something stands elsewhere."""
    del raw.header["versions"]
    an_empty_pod_elsewhere(raw)


@kind
def another_map(raw: Raw) -> None:
    """The text of the map has another sign."""
    if "map" not in raw.header:
        raise NotThereError
    raw.header["map"] = raw.header["map"].replace(".", ">", 1)


@kind
def another_tick_length(raw: Raw) -> None:
    """A tick is two milliseconds."""
    raw.header["tick_s"] = 0.002


@kind
def faster_robots(raw: Raw) -> None:
    """Robots are faster, in the kinematics alone."""
    raw.header["motion"]["top_speed_m_per_s"] += 0.5


@kind
def faster_robots_in_the_scenario_too(raw: Raw) -> None:
    """Robots are faster, and the scenario says so."""
    raw.header["motion"]["top_speed_m_per_s"] += 0.5
    raw.scenario["robots"]["top_speed_m_per_s"] += 0.5


@kind
def slower_lifts(raw: Raw) -> None:
    """Lifting takes longer, and the scenario says so."""
    raw.header["motion"]["lift_s"] += 1.0
    raw.scenario["robots"]["lift_s"] += 1.0


# The header: the scenario

scenario_says("another seed", "", "seed", lambda value: value + 1)
scenario_says("robots count", "robots", "count", lambda value: value + 1)
scenario_says("a shorter pick", "stations", "pick_s", lambda value: value - 1)
scenario_says("a longer handling", "stations", "handle_s", lambda value: value + 1)
scenario_says("a longer queue", "stations", "queue_length", lambda value: value + 1)
scenario_says("a shorter queue", "stations", "queue_length", lambda value: value - 1)
scenario_says("other PP rule", "rules", "pp", lambda value: "sipp" if value == "free-flow" else "free-flow")
scenario_says("other PR rule", "rules", "pr", lambda value: "fixed" if value == "random" else "random")
scenario_says("other POA rule", "rules", "poa", lambda _: "random")
scenario_says("other PPS rule", "rules", "pps", lambda _: "random")
scenario_says("other joint rule", "rules", "poa_pps", lambda _: "split-among-stations")
scenario_says("a warm-up", "run", "warmup_s", lambda value: (value or 0) + 100, given=False)
scenario_says("another limit", "run", "until_s", lambda value: (value or 10**6) + 100, given=False)
scenario_says("fewer empty pods", "layout", "pod_fill", lambda value: value / 2)
scenario_says("a filter", "rules", "filters", lambda _: ["oldest"], given=False)

# How it ends


@kind
def another_status(raw: Raw) -> None:
    """A partial run was complete, or the other way round."""
    raw.end["status"] = "partial" if raw.end["status"] == "complete" else "complete"


@kind
def a_failed_run(raw: Raw) -> None:
    """The run has failed."""
    raw.end["status"] = "failed"


@kind
def an_end_that_is_too_late(raw: Raw) -> None:
    """The run went on for ten seconds."""
    raw.end["tick"] += 10_000


@kind
def an_end_that_is_a_tick_late(raw: Raw) -> None:
    """The run went on for a tick."""
    raw.end["tick"] += 1


@kind
def an_end_that_is_a_tick_early(raw: Raw) -> None:
    """The run ended a tick earlier."""
    raw.end["tick"] -= 1


@kind
def a_trace_cut_off(raw: Raw) -> None:
    """What happened in the last tenth is missing."""
    del raw.events[-len(raw.events) // 10 :]


@kind
def a_trace_cut_off_with_its_end(raw: Raw) -> None:
    """The run ends, not complete, when nine tenths have happened."""
    del raw.events[-len(raw.events) // 10 :]
    raw.end.update(tick=raw.events[-1]["tick"], status="partial")


@kind
def the_last_event_missing(raw: Raw) -> None:
    """The event above the end is missing."""
    raw.events.pop()


@kind
def a_cut_in_the_middle(raw: Raw) -> None:
    """Twenty events are missing."""
    middle = len(raw.events) // 2
    del raw.events[middle : middle + 20]


@kind
def everything_later_by_a_tick(raw: Raw) -> None:
    """From the middle on, all times are a tick later."""
    after = raw.events[len(raw.events) // 2]["tick"]
    for line in (*raw.events, raw.end):
        for name in ("tick", "start_tick", "picker_free_tick"):
            if line.get(name, 0) > after:
                line[name] += 1


# Runs of robots


def far(line: Line) -> bool:
    """Whether a run is long."""
    return bool(line["distance_m"] > 3)


def apart(line: Line) -> bool:
    """Whether a robot waits before its run."""
    return bool(line["wait_ticks"])


MOVED = "robot_moved"
dropped("a run dropped", MOVED)
dropped("the first run dropped", MOVED, at=0.0)
dropped("the last run dropped", MOVED, at=1.0)
doubled("a run twice", MOVED)
changed("a run of another robot", MOVED, lambda line: {"robot": line["robot"] ^ 1})
changed("a run from elsewhere", MOVED, lambda line: {"origin": line["origin"] + 1})
changed("a run to the next cell", MOVED, lambda line: {"to": line["to"] + 1})
changed("the last run to elsewhere", MOVED, lambda line: {"to": line["to"] - 1}, at=1.0)
changed("a run backwards", MOVED, lambda line: {"heading": (line["heading"] + 2) % 4})
changed("a run of a metre more", MOVED, lambda line: {"distance_m": line["distance_m"] + 1})
changed("a run a tick faster", MOVED, lambda line: {"tick": line["tick"] - 1})
changed("a run a tick slower", MOVED, lambda line: {"tick": line["tick"] + 1})
changed("a run that starts a tick early", MOVED, lambda line: {"start_tick": line["start_tick"] - 1})
changed("a turn a tick faster", MOVED, lambda line: {"turn_ticks": line["turn_ticks"] - 1})
changed("a wait in place of a turn", MOVED, lambda line: {"wait_ticks": line["turn_ticks"], "turn_ticks": 0},
        lambda line: line["turn_ticks"] and not line["wait_ticks"])  # fmt: skip
changed("a wait that is none", MOVED,
        lambda line: {"wait_ticks": 0, "start_tick": line["start_tick"] + line["wait_ticks"]}, apart)  # fmt: skip
changed("a wait a tick longer", MOVED, lambda line: {"wait_ticks": line["wait_ticks"] + 1}, apart)
changed("a run without its pod", MOVED, lambda line: {"pod": None}, lambda line: line["pod"] is not None)
changed("a run with a pod", MOVED, lambda line: {"pod": 0}, lambda line: line["pod"] is None)


def cut_off(raw: Raw) -> Line:
    """Return the last run, which the end of the run cut off."""
    line = raw.one(MOVED, at=1.0)
    if line["tick"] != raw.end["tick"]:
        raise NotThereError
    return line


@kind
def a_run_that_was_cut_off_dropped(raw: Raw) -> None:
    """Nobody tells what a robot was doing when the run was over."""
    raw.events.remove(cut_off(raw))


@kind
def a_run_that_was_cut_off_farther_on(raw: Raw) -> None:
    """The robot has come a cell farther."""
    line = cut_off(raw)
    right, down = STEPS[line["heading"]]
    line.update(to=line["to"] + right + down * raw.width, distance_m=line["distance_m"] + 1)


@kind
def a_run_that_was_cut_off_too_early(raw: Raw) -> None:
    """The robot has not begun its run that long ago."""
    line = cut_off(raw)
    line["wait_ticks"] += line["tick"] - line["start_tick"] - line["wait_ticks"] - line["turn_ticks"] - 900


@kind
def a_run_in_two(raw: Raw) -> None:
    """A long run is two, without a stop between them."""
    i = raw.place(MOVED, far)
    line = raw.events[i]
    right, down = STEPS[line["heading"]]
    half = line["origin"] + 2 * (right + down * raw.width)
    tick = line["tick"] - 1500
    raw.events.insert(i, {**line, "to": half, "distance_m": 2, "tick": tick})
    line.update(origin=half, distance_m=line["distance_m"] - 2, start_tick=tick, wait_ticks=0, turn_ticks=0)
    raw.events.sort(key=lambda each: each["tick"])


@kind
def two_runs_in_one(raw: Raw) -> None:
    """A run with a turn in it is told as one, from its start to its end."""
    for i in raw.places(MOVED):
        line = raw.events[i]
        j = raw.following(i, MOVED, lambda other, robot=line["robot"]: other["robot"] == robot)  # type: ignore[misc]
        if raw.events[j]["heading"] != line["heading"]:
            raw.events[j].update(origin=line["origin"], start_tick=line["start_tick"])
            del raw.events[i]
            return
    raise NotThereError


@kind
def a_detour(raw: Raw) -> None:
    """A robot that waits drives to the next cell and back in that time."""
    for i in raw.places(MOVED, lambda line: line["wait_ticks"] > 12_000):
        line = raw.events[i]
        for heading, (right, down) in enumerate(STEPS):
            if raw.moves(line["origin"]) >> heading & 1:
                beside = line["origin"] + right + down * raw.width
                start, turn = line["start_tick"], {"wait_ticks": 0, "turn_ticks": 1000, "distance_m": 1}
                out = {"start_tick": start, "to": beside, "heading": heading, "tick": start + 3000}
                back = {"start_tick": start + 3000, "origin": beside, "to": line["origin"], "heading": heading ^ 2}
                raw.events[i:i] = [{**line, **turn, **out}, {**line, **turn, **back, "tick": start + 6000}]
                line.update(start_tick=start + 6000, wait_ticks=line["wait_ticks"] - 6000)
                raw.events.sort(key=lambda each: each["tick"])
                return
    raise NotThereError


@kind
def a_robot_that_drives_on(raw: Raw) -> None:
    """A robot that has ended its last run drives a metre on, at the end of the run."""
    line = raw.one(MOVED, at=1.0)
    for heading, (right, down) in enumerate(STEPS):
        if raw.moves(line["to"]) >> heading & 1 and heading == line["heading"]:
            to = line["to"] + right + down * raw.width
            end = {"tick": raw.end["tick"], "start_tick": line["tick"], "origin": line["to"], "to": to, "distance_m": 1}
            raw.events.append({**line, **end, "wait_ticks": raw.end["tick"] - line["tick"] - 2000, "turn_ticks": 0})
            return
    raise NotThereError


@kind
def robots_that_change_names(raw: Raw) -> None:
    """The first two robots are each other all along, but for where they start."""
    for line in raw.events:
        if line.get("robot", 2) < 2:
            line["robot"] ^= 1


@kind
def robots_that_change_names_and_places(raw: Raw) -> None:
    """The first two robots are each other all along."""
    robots_that_change_names(raw)
    robots = raw.header["robots"]
    robots[0], robots[1] = robots[1], robots[0]
    for pod in raw.header["pods"]:
        if pod["robot"] in (0, 1):
            pod["robot"] ^= 1


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
    """A robot is told to fetch a pod before anybody has decided where it shall go."""
    i = raw.place(TASK)
    raw.move(i, raw.preceding(i, TRIP, lambda line: line["pod"] == raw.events[i]["pod"]))


@kind
def a_task_after_the_lift(raw: Raw) -> None:
    """A robot is told to fetch a pod when it has it."""
    i = raw.place(TASK)
    raw.move(i, raw.following(i, LIFTED, lambda line: line["pod"] == raw.events[i]["pod"]) + 1)


@kind
def a_trip_after_the_lift(raw: Raw) -> None:
    """A pod's trip is decided when the pod is on its way."""
    i = raw.place(TRIP)
    raw.move(i, raw.following(i, LIFTED, lambda line: line["pod"] == raw.events[i]["pod"]) + 1)


@kind
def a_task_never_carried_out(raw: Raw) -> None:
    """A robot with nothing to do gets a task that nothing comes of."""
    last = raw.place(STORED, at=1.0)
    robot = raw.events[last]["robot"]
    lifted = {line["pod"] for line in raw.events if line["e"] == LIFTED}
    pod = next_of([i for i in range(len(raw.header["pods"])) if i not in lifted])
    raw.events.insert(last + 1, {"e": TASK, "tick": raw.events[last]["tick"], "robot": robot, "pod": pod})


@kind
def a_trip_and_a_task_never_carried_out(raw: Raw) -> None:
    """A pod gets a trip and a robot that never comes."""
    a_task_never_carried_out(raw)
    lifted = {line["pod"] for line in raw.events if line["e"] == LIFTED}
    i = raw.place(TASK, lambda line: line["pod"] not in lifted)
    task = raw.events[i]
    raw.events.insert(i, {"e": TRIP, "tick": task["tick"], "pod": task["pod"], "station": 0})


@kind
def a_fetch_that_never_happened(raw: Raw) -> None:
    """Of what came of the last task, nothing is told."""
    i = raw.place(TASK, at=1.0)
    robot = raw.events[i]["robot"]
    raw.events[i + 1 :] = [
        line for line in raw.events[i + 1 :] if line.get("robot") != robot or line["e"] not in (MOVED, LIFTED)
    ]


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
    """A robot that has waited in line joins it when it is served."""
    for i in raw.places(JOINED):
        j = raw.following(i, STARTED, lambda line, i=i: line["pod"] == raw.events[i]["pod"])  # type: ignore[misc]
        if raw.events[j]["tick"] > raw.events[i]["tick"]:
            raw.move(i, j)
            return
    raise NotThereError


@kind
def a_place_in_line_taken_too_early(raw: Raw) -> None:
    """Of two that join a line after each other, the second one has joined first."""
    for i in raw.places(JOINED):
        j = raw.following(i, JOINED, lambda line, i=i: line["station"] == raw.events[i]["station"])  # type: ignore[misc]
        raw.move(j, i)
        return


@kind
def a_visit_that_ends_later(raw: Raw) -> None:
    """A visit ends a tick after its last pick."""
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
    """Two items that are picked after each other in a visit are picked the other way round."""
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
    """One SKU of two orders at a station is picked for them the other way round."""
    for i in raw.places(PICKED):
        for j in raw.places(PICKED):
            one, other = raw.events[i], raw.events[j]
            same = (one["station"], one["sku"]) == (other["station"], other["sku"])
            if j > i and same and one["order"] != other["order"]:
                one["order"], other["order"] = other["order"], one["order"]
                return
    raise NotThereError


# Orders

ARRIVED, ASSIGNED, COMPLETED = "order_arrived", "order_assigned", "order_completed"
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
    """An order is assigned before it is there."""
    i = raw.place(ASSIGNED)
    raw.move(i, raw.preceding(i, ARRIVED, lambda line: line["order"] == raw.events[i]["order"]))


@kind
def assignments_that_change_places(raw: Raw) -> None:
    """Of two orders assigned at once each goes to the other's station."""
    for i in raw.places(ASSIGNED):
        for j in raw.places(ASSIGNED):
            one, other = raw.events[i], raw.events[j]
            if one["tick"] == other["tick"] and one["station"] != other["station"]:
                one["station"], other["station"] = other["station"], one["station"]
                return
    raise NotThereError


# Decisions

DECIDED = "decision_made"


def empty(line: Line) -> bool:
    """Whether a decision has nothing in it."""
    return not (line["assignments"] or line["trips"])


def on(what: str) -> Where:
    """Return what says whether a decision is on this."""
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
    """A decision is told before its assignments and trips."""
    i = raw.place(DECIDED, lambda line: not empty(line))
    raw.move(i, raw.preceding(i, ASSIGNED if raw.events[i]["assignments"] else TRIP))


# Names of what does not exist

for _event, _name in ((MOVED, "robot"), (LIFTED, "pod"), (TRIP, "station"), (ASSIGNED, "order"), (PICKED, "sku")):
    changed(f"a {_name} that does not exist, in {_event}", _event, lambda _, name=_name: {name: 10_000})
