"""How a run ends, and how robots drive."""

from corruptions.raw import (
    STEPS,
    Line,
    NotThereError,
    Raw,
    add,
    changed,
    dropped,
    kind,
    made,
    missaid,
    others,
    shifted,
    some,
)

# How it ends

made("another status", lambda raw: raw.end.update(status="partial" if raw.end["status"] == "complete" else "complete"))
made("a failed run", lambda raw: raw.end.update(status="failed"))
made("an end that is too late", lambda raw: add(raw.end, tick=10_000))
made("an end that is a tick late", lambda raw: add(raw.end, tick=1))
made("an end that is a tick early", lambda raw: add(raw.end, tick=-1))
made("the last event missing", lambda raw: raw.events.pop())


@kind
def a_trace_cut_off(raw: Raw) -> None:
    del raw.events[-len(raw.events) // 10 :]


@kind
def a_trace_cut_off_with_its_end(raw: Raw) -> None:
    a_trace_cut_off(raw)
    raw.end.update(tick=raw.events[-1]["tick"], status="partial")


@kind
def a_cut_in_the_middle(raw: Raw) -> None:
    middle = len(raw.events) // 2
    del raw.events[middle : middle + 20]


@kind
def everything_later_by_a_tick(raw: Raw) -> None:
    after = raw.events[len(raw.events) // 2]["tick"]
    for line in (*raw.events, raw.end):
        for name in ("tick", "start_tick", "picker_free_tick"):
            if line.get(name, 0) > after:
                line[name] += 1


# Runs of robots


def far(line: Line) -> bool:
    return bool(line["distance_m"] > 3)


def apart(line: Line) -> bool:
    return bool(line["wait_ticks"])


MOVED = "robot_moved"
missaid("a run", MOVED)
dropped("the first run dropped", MOVED, at=0.0)
others(MOVED, robot="a run of another robot")
shifted(MOVED, 1, origin="a run from elsewhere", to="a run to the next cell", distance_m="a run of a metre more")
shifted(MOVED, 1, tick="a run a tick slower")
shifted(MOVED, 1, apart, wait_ticks="a wait a tick longer")
shifted(MOVED, -1, tick="a run a tick faster", start_tick="a run that starts a tick early")
shifted(MOVED, -1, turn_ticks="a turn a tick faster")
shifted(MOVED, -1, at=1.0, to="the last run to elsewhere")
changed("a run backwards", MOVED, lambda line: {"heading": (line["heading"] + 2) % 4})
changed("a wait instead of a turn", MOVED, lambda line: {"wait_ticks": line["turn_ticks"], "turn_ticks": 0},
        lambda line: line["turn_ticks"] and not line["wait_ticks"])  # fmt: skip
changed("a wait that is none", MOVED,
        lambda line: {"wait_ticks": 0, "start_tick": line["start_tick"] + line["wait_ticks"]}, apart)  # fmt: skip
changed("a run without its pod", MOVED, lambda line: {"pod": None}, lambda line: line["pod"] is not None)
changed("a run with a pod", MOVED, lambda line: {"pod": 0}, lambda line: line["pod"] is None)


def cut_off(raw: Raw) -> Line:
    line = raw.one(MOVED, at=1.0)
    if line["tick"] != raw.end["tick"]:
        raise NotThereError
    return line


made("a run that was cut off dropped", lambda raw: raw.events.remove(cut_off(raw)))


@kind
def a_run_that_was_cut_off_farther_on(raw: Raw) -> None:
    line = cut_off(raw)
    add(line, to=raw.step(line["heading"]), distance_m=1)


@kind
def a_run_that_was_cut_off_too_early(raw: Raw) -> None:
    line = cut_off(raw)
    line["wait_ticks"] = line["tick"] - line["start_tick"] - line["turn_ticks"] - 900


@kind
def a_run_in_two(raw: Raw) -> None:
    i = raw.place(MOVED, far)
    line = raw.events[i]
    half = line["origin"] + 2 * raw.step(line["heading"])
    tick = line["tick"] - 1500
    raw.events.insert(i, {**line, "to": half, "distance_m": 2, "tick": tick})
    line.update(origin=half, distance_m=line["distance_m"] - 2, start_tick=tick, wait_ticks=0, turn_ticks=0)
    raw.events.sort(key=lambda each: each["tick"])


@kind
def two_runs_in_one(raw: Raw) -> None:
    for i in raw.places(MOVED):
        line = raw.events[i]
        j = raw.following(i, MOVED, raw.alike(i, "robot"))
        if raw.events[j]["heading"] != line["heading"]:
            raw.events[j].update(origin=line["origin"], start_tick=line["start_tick"])
            del raw.events[i]
            return
    raise NotThereError


@kind
def a_detour(raw: Raw) -> None:
    for i in raw.places(MOVED, lambda line: line["wait_ticks"] > 12_000):
        line = raw.events[i]
        for heading in range(len(STEPS)):
            if raw.moves(line["origin"]) >> heading & 1:
                beside = line["origin"] + raw.step(heading)
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
    line = raw.one(MOVED, at=1.0)
    some(raw.moves(line["to"]) >> line["heading"] & 1)
    to = line["to"] + raw.step(line["heading"])
    end = {"tick": raw.end["tick"], "start_tick": line["tick"], "origin": line["to"], "to": to, "distance_m": 1}
    raw.events.append({**line, **end, "wait_ticks": raw.end["tick"] - line["tick"] - 2000, "turn_ticks": 0})


@kind
def robots_that_change_names(raw: Raw) -> None:
    for line in raw.events:
        if line.get("robot", 2) < 2:
            line["robot"] ^= 1


@kind
def robots_that_change_names_and_places(raw: Raw) -> None:
    robots_that_change_names(raw)
    robots = raw.header["robots"]
    robots[0], robots[1] = robots[1], robots[0]
    for pod in raw.header["pods"]:
        if pod["robot"] in (0, 1):
            pod["robot"] ^= 1
