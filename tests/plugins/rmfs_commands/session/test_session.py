"""Sessions decide as the simulation does, and go on when their process dies or the floor is not as told."""

import gzip
import itertools
import json
import os
import random
import signal
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

import rmfs_core
from bad_rules import write_rule
from cases import cases
from driven import Log, Told
from hall_trial import BACK, RULES, OwnHall, scenario_of, trouble
from rmfs_commands.cli.main import main
from rmfs_commands.results.files import to_json
from rmfs_commands.session import Hall, StaleBatchError
from rmfs_commands.session.day import run_day
from rmfs_commands.session.facts import FACTS
from rmfs_commands.states import decide, read_recording
from rmfs_commands.validation import check_trace
from rmfs_core.errors import InputError, RmfsError
from rmfs_core.hookspecs import hookimpl
from rmfs_core.scenario import RuleChoice, load_scenario
from rmfs_core.world import make_layout

EXAMPLES = Path(__file__).parents[4] / "scenarios" / "examples"


@pytest.fixture(scope="module")
def small() -> Told:
    run = Told(EXAMPLES / "small.toml", ("instance.orders=8",))
    run.run()
    return run


def sent(hall: Hall, run: Told) -> list[dict[str, Any]]:
    return [hall.take(batch) for batch in run.batches()]


@cases(
    "name overrides",
    ("small.toml", ("rules.pp=sipp", "stations.release=picked")),
    ("replenished.toml", ("instance.orders=60",)),
    ("packing.toml", ("packing.tote='visit'", "packing.packing_from='picked'")),
    ("poisson.toml", ("instance.orders=100",)),
    ("charging.toml", ("instance.orders=150", "robots.count=8", "robots.battery.capacity_wh=60", "layout.chargers=2")),
)
def test_a_session_decides_what_the_run_decides(name: str, overrides: tuple[str, ...]) -> None:
    run = Told(EXAMPLES / name, overrides)
    run.run()
    log = Log()
    hall = Hall(run.scenario, observers=lambda: (log,))
    answers = sent(hall, run)
    assert [answer["dropped"] for answer in answers if answer["dropped"]] == []
    assert log.rows == run.log.rows
    assert len(log.rows) > 100
    numbers = [command["command"] for answer in answers for command in answer["commands"]]
    assert numbers == list(range(1, len(numbers) + 1))


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    return tmp_path / "hall.jsonl"


@pytest.mark.slow
@cases(
    "name overrides",
    ("small.toml", ()),
    ("from-csv.toml", ()),
    ("replenished.toml", ()),
    ("packing.toml", ()),
    ("charging.toml", ("instance.orders=400",)),  # all 1,200 take four times as long
)
def test_the_day_of_a_journal_has_the_tables_of_the_run_byte_for_byte(
    name: str, overrides: tuple[str, ...], tmp_path: Path, journal: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also while the session is still open."""
    monkeypatch.setattr("os.fsync", lambda _: None)
    settings = [text for override in overrides for text in ("--set", override)]
    main(["run", str(EXAMPLES / name), "--out", str(tmp_path), "--quiet", *settings])
    run = Told(EXAMPLES / name, overrides)
    run.run()
    hall = Hall(run.scenario, journal)
    sent(hall, run)
    day = ["--out", str(tmp_path / "day"), "--quiet", "--trace", "--record-decisions"]
    main(["run", str(EXAMPLES / name), *settings, "--journal", str(journal), *day])
    hall.close()
    for table in ("orders.csv", "visits.csv", "stations.csv", "delays.csv", "hours.csv"):
        assert (tmp_path / "day" / table).read_text() == (tmp_path / table).read_text(), table
    report = check_trace(tmp_path / "day")
    assert (report.faults, report.metrics_checked) == ([], True)
    main(["replay", str(tmp_path / "day")])
    main(["explain", str(tmp_path / "day"), "--decision", "9"])


@cases(
    "line problem",
    (b"x", "line 3: found no JSON"),
    (b"[1]", "line 3: expected a batch and its answer"),
    (b'{"batch":{"after":1},"answer":{}}', "line 3: batch.time_s: is missing"),
    (b'{"batch":{"after":5,"time_s":9,"events":[]},"answer":{}}', "line 3: expected a batch after 1"),
    (b'{"batch":{"after":1,"time_s":0,"events":[]},"answer":{}}', "line 3: expected a batch after 1, and not earlier"),
    (b'{"batch":{"after":1,"time_s":9,"events":[]},"answer":{}}', "line 3: is not answered as it was"),
)
def test_a_damaged_journal_makes_no_day(small: Told, line: bytes, problem: str, journal: Path, tmp_path: Path) -> None:
    hall = Hall(small.scenario, journal)
    hall.take({"after": 0, "time_s": 5, "events": []})
    hall.close()
    with journal.open("ab") as lines:
        lines.write(line + b"\n")
    with pytest.raises(InputError, match=problem):
        run_day(small.scenario, journal, tmp_path / "day")
    with pytest.raises(InputError, match=problem):
        Hall(small.scenario, journal)
    assert not (tmp_path / "day").exists()


def test_a_day_is_of_the_batches_that_were_there_when_it_began(small: Told, journal: Path, tmp_path: Path) -> None:
    hall, batches = Hall(small.scenario, journal), [*small.batches()]
    for batch in batches[: (half := len(batches) // 2)]:
        hall.take(batch)

    class Later:
        @hookimpl
        def run_started(self) -> None:
            for batch in batches[half:]:
                hall.take(batch)

    day = run_day(small.scenario, journal, tmp_path / "day", ("trace",), (Later(),))
    hall.close()
    assert (hall.seq, day.metrics["simulated_s"]) == (len(batches), batches[half - 1]["time_s"])
    assert check_trace(tmp_path / "day").floor["batches"] == half


@pytest.mark.slow
def test_nothing_is_lost_in_twenty_kills(journal: Path) -> None:
    run, kills = Told(EXAMPLES / "from-csv.toml"), 20
    run.run()
    batches = [*run.batches()]
    for kill in range(kills):
        ours, its = os.pipe()
        if not (child := os.fork()):
            hall = Hall(run.scenario, journal)
            for batch in batches[hall.seq :]:
                hall.take(batch)
                os.write(its, b".")
            os._exit(0)
        os.close(its)
        for _ in range(len(batches) // kills - kill % 3):
            os.read(ours, 1)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        os.close(ours)
    log = Log()
    hall = Hall(run.scenario, journal, observers=lambda: (log,))
    assert len(batches) * 4 // 5 < hall.seq < len(batches)
    for batch in batches[hall.seq :]:
        hall.take(batch)
    hall.close()
    assert log.rows == run.log.rows


def test_a_session_starts_again_where_it_was(small: Told, journal: Path) -> None:
    whole = Hall(small.scenario)
    answers = sent(whole, small)
    batches = [*small.batches()]
    hall, again = Hall(small.scenario, journal), []
    for i, batch in enumerate(batches):
        again.append(hall.take(batch))
        if i % (len(batches) // 20) == 0:
            hall.close()
            with journal.open("ab") as lines:
                lines.write(b'{"batch":{"after":')  # killed while it wrote: nobody had that answer
            hall = Hall(small.scenario, journal)
            assert hall.take(batch) == again[-1]
    assert again == answers
    assert to_json(hall.state) == to_json(whole.state)
    assert hall.since(len(batches) - 2) == answers[-2:]
    hall.close()


def test_a_journal_has_one_writer_and_one_scenario(small: Told, journal: Path) -> None:
    hall = Hall(small.scenario, journal)
    with pytest.raises(InputError, match="in use by another session"):
        Hall(small.scenario, journal)
    hall.close()
    with pytest.raises(InputError, match=r"journal of another session: .*seed.* differ"):
        Hall(small.scenario.with_seed(2), journal)


ARRIVES = {"kind": "order_arrived", "order": "A", "lines": {"1": 1}}


def batch_of(**event: Any) -> dict[str, Any]:
    return {"after": 1, "time_s": 9, "events": [{"id": "a", **event}]}


@cases(
    "batch problem",
    ([], "expected a JSON object"),
    ({"after": 0, "time_s": 0}, "events: is missing"),
    ({"after": 3, "time_s": 1, "events": []}, "found 3; expected 1"),
    ({"after": 1, "time_s": 4, "events": []}, "no time before 5"),
    ({"after": 1, "time_s": float("nan"), "events": []}, "found nan; expected seconds"),
    ({"after": 1, "time_s": 1.8e9, "events": []}, "found 1800000000.0; expected seconds since the hall's time 0"),
    (batch_of(due_s=2e10, **ARRIVES), "due_s: found 20000000000.0; expected seconds from 0 to 1e10"),
    (batch_of(kind="short"), "events.0.pod: is missing"),
    (batch_of(kind="pod_liftet"), "did you mean `pod_lifted`"),
    (batch_of(kind="handled", station=1), "events.0.station: found 1"),
    (batch_of(**{"kind": "handled", "station": "1", "x-weight": [float("inf")]}), "events.0.x-weight: has a number"),
    (batch_of(**{"kind": "handled", "station": "1", "x-a": json.loads("[" * 101 + "]" * 101)}), "x-a: is nested too"),
    (batch_of(kind="handled", station="1", pod="1"), "is not a field"),
)
def test_a_batch_is_taken_whole_or_not_at_all(small: Told, batch: Any, problem: str) -> None:
    hall = Hall(small.scenario)
    hall.take({"after": 0, "time_s": 5, "events": [{"id": "1", "kind": "robot_at", "robot": "1", "cell": 0}]})
    before = to_json(hall.state)
    with pytest.raises(InputError, match=problem) as caught:
        hall.take(batch)
    assert to_json(hall.state) == before
    assert isinstance(caught.value, StaleBatchError) == ("found 3" in problem)


def test_a_fact_counts_once(small: Told) -> None:
    hall = Hall(small.scenario)
    first, *_ = small.batches()
    answer = hall.take(first)
    assert hall.take(first) == answer  # the answer was lost, and is asked for again
    again = hall.take(first | {"after": 1})  # the same ids in another batch
    assert (again["commands"], again["dropped"], again["seq"]) == ([], [], 2)
    with pytest.raises(StaleBatchError, match="found 0; expected 2"):
        hall.take(first)


@cases("change", {"after": True}, {"time_s": True}, {"after": 1.0})
def test_a_batch_with_true_for_1_is_not_the_last_one_again(small: Told, change: dict[str, Any]) -> None:
    hall = Hall(small.scenario)
    hall.take({"after": 0, "time_s": 1, "events": []})
    answer = hall.take(last := {"after": 1, "time_s": 1, "events": []})
    with pytest.raises(InputError, match=f"found {next(iter(change.values()))}; expected"):
        hall.take(last | change)
    assert hall.take(last) == answer


BAD = """
        if any(order.name == "bad" for order in warehouse.backlog):
            raise ValueError("no")
        return [OrderAssignment(warehouse.backlog[0].id, 0, [line.sku for line in warehouse.backlog[0].lines])]
"""


@cases("kept", True, False)
def test_a_rule_that_fails_changes_nothing(small: Told, journal: Path, kept: bool) -> None:
    write_rule(journal.parent, "poa", BAD)
    rules = evolve(small.scenario.rules, poa=RuleChoice(f"{journal.parent}/bad.py:Bad"))
    hall = Hall(evolve(small.scenario, rules=rules), journal if kept else None)
    sku = small.info.instance.skus[0]

    def arrives(order: str, after: int) -> dict[str, Any]:
        event = {"id": order, "kind": "order_arrived", "order": order, "lines": {sku: 1}}
        return {"after": after, "time_s": after, "events": [event]}

    assert hall.take(arrives("good", 0))["commands"][0]["kind"] == "assign"
    before = to_json(hall.state)
    with pytest.raises(RmfsError, match="raised ValueError: no"):
        hall.take(arrives("bad", 1))
    assert to_json(hall.state) == before
    assert hall.take(arrives("better", 1))["commands"][0]["order"] == "better"
    hall.close()


def test_what_cannot_be_is_dropped_and_the_hall_goes_on(small: Told) -> None:
    batches = [*small.batches()]
    hall = Hall(small.scenario)
    answers = [hall.take(batch) for batch in itertools.islice(batches, 1)]
    fetch = next(one for one in answers[0]["commands"] if one["kind"] == "fetch")
    wrong = {"id": "w", "kind": "pod_lifted", "pod": fetch["pod"], "x-fact": [1]}
    answer = hall.take({"after": 1, "time_s": batches[0]["time_s"], "events": [wrong], "x-batch": {"a": None}})
    told = f'pod "{fetch["pod"]}" is not to be lifted now; expected robot_at first.'
    assert answer["dropped"] == [{"id": "w", "place": "events.0", "problem": told, "x-fact": [1]}]
    assert answer["x-batch"] == {"a": None}
    quarantine = {kind: name for one in hall.state["session"]["quarantine"] for kind, name in one.items()}
    assert (quarantine["pod"], quarantine["robot"]) == (fetch["pod"], fetch["robot"])
    assert hall.state["robots"][fetch["robot"]]["in_service"] is False
    later = []
    for batch in batches[1:]:
        later += hall.take(batch | {"after": hall.seq, "time_s": batch["time_s"]})["commands"]
    assert not [one for one in later if one["kind"] == "fetch" and one["robot"] == fetch["robot"]]  # no further task
    assert [one for one in later if one["kind"] == "store" and one["robot"] == fetch["robot"]]  # what it had is done
    back = {"id": "b", "kind": "robot_back", "robot": fetch["robot"]}
    hall.take({"after": hall.seq, "time_s": 1e6, "events": [back]})
    assert "robot" not in {kind for one in hall.state["session"]["quarantine"] for kind in one}


@cases("text key", ("stations.release=picked", "stations.release"), ("run.until_s=5", "run.until_s"))
def test_what_sessions_do_not_do_is_refused(text: str, key: str) -> None:
    with pytest.raises(InputError, match=f"{key}.*: .*expected a scenario without it"):
        Hall(load_scenario(EXAMPLES / "packing.toml", (text,)))


class FoundError(Exception):
    """Ends a floor's day."""


def until(session: Hall, kind: str, orders: int = 12, items: int = 1) -> Mapping[str, Any]:
    """Run a floor until a kind of command is given, and return that."""

    def take(batch: dict[str, Any]) -> Mapping[str, Any]:
        answer = session.take(batch)
        if found := [one for one in answer["commands"] if one["kind"] == kind]:
            raise FoundError(found[0])
        return answer

    hall = OwnHall(take, session.state)
    skus = sorted({sku for held in hall.stock.values() for sku in held})
    arrive = [hall.order(f"o{i}", {skus[i]: items, skus[-i - 1]: items}) for i in range(orders)]
    hall.at(1, lambda: iter(arrive))
    with pytest.raises(FoundError) as found:
        hall.run()
    command: Mapping[str, Any] = found.value.args[0]
    return command


def tell(session: Hall, *events: Mapping[str, Any], seconds: float = 0.0) -> dict[str, Any]:
    seq, now = session.seq, session.state["time_s"]
    told = [{"id": f"{seq}.{i}", **event} for i, event in enumerate(events)]
    return session.take({"after": seq, "time_s": now + seconds, "events": told})


def quarantined(session: Hall, kind: str) -> set[str]:
    return {one[kind] for one in session.state["session"]["quarantine"] if kind in one}


@cases("name seed at", ("sequential", 1, 131), ("joint", 2, 57), ("replenished", 1, 94))
def test_a_floor_goes_on_from_a_state_put_into_the_place_of_the_own(
    name: str, seed: int, at: int, tmp_path: Path
) -> None:
    scenario = scenario_of(RULES[name]) if name in RULES else load_scenario(f"examples/{name}")
    session = Hall(scenario, tmp_path / "hall.jsonl")
    hall, rng = OwnHall(session.take, session.state, seed), random.Random(seed)
    skus = sorted({sku for held in hall.stock.values() for sku in held})
    hall.at(1, lambda: iter([hall.order(f"{i}", dict.fromkeys(rng.sample(skus, 2), 1)) for i in range(20)]))
    hall.run(lambda: hall.seq >= at)
    free = next(
        cell for cell in hall.homes if cell not in {told.get("cell") for told in session.state["pods"].values()}
    )
    tell(session, {"kind": "cell_blocked", "cell": free}, {"kind": "station_closed", "station": "2"})
    hall.seq = session.seq
    before = json.loads(to_json(session.state))
    hall.take_over(before)
    after = session.state
    same = before.keys() - {"stations", "session", "version"}
    assert {key: after[key] for key in same} == {key: before[key] for key in same}
    old, new = ([told["requests"] for told in state["stations"].values()] for state in (before, after))
    assert (new, after["stations"]["2"]["staffed"]) == (old, False)
    assert after["session"]["quarantine"] == [{"cell": f"{free}", "why": "it was blocked"}]
    tell(session, {"kind": "station_opened", "station": "2"})
    hall.seq = session.seq
    hall.run()
    assert (hall.left, hall.dropped, session.state["session"]["awaited"]) == ([], [], [])
    session.close()
    again = Hall(scenario, tmp_path / "hall.jsonl")
    assert to_json(again.state) == to_json(session.state)
    again.close()
    with pytest.raises(InputError, match="the state was replaced"):
        run_day(scenario, tmp_path / "hall.jsonl", tmp_path / "day")


def test_robots_at_rest_and_at_chargers_are_so_in_a_state_that_is_put_back() -> None:
    session = Hall(load_scenario("examples/charging", ("robots.count=2",)))
    low = {"kind": "robot_at", "robot": "1", "cell": session.state["robots"]["1"]["cell"], "charge": 0.2}
    arrives = {"kind": "order_arrived", "order": "A", "lines": {"1": 1}}
    sent = next(one for one in tell(session, low, arrives)["commands"] if one["kind"] == "move_robot")
    there = {"kind": "robot_at", "robot": sent["robot"], "cell": sent["cell"]}
    for awaits, fact in (("robot_at", there), ("robot_charged", {"kind": "robot_charged", "robot": "1"}), (None, None)):
        before = json.loads(to_json(session.state))
        answer = session.take({"after": session.seq, "state": before})
        after = json.loads(to_json(session.state))
        assert ([one["kind"] for one in answer["commands"]], after["robots"]) == ([], before["robots"])
        assert [one["awaits"] for one in after["session"]["awaited"] if one["robot"] == "1"] == [awaits][: bool(awaits)]
        assert fact is None or tell(session, fact, seconds=5)["dropped"] == []


def test_a_robot_is_charged_when_the_floor_says_so_and_no_battery_is_less_than_empty() -> None:
    session = Hall(load_scenario("examples/charging", ("robots.count=1",)))
    at = {"kind": "robot_at", "robot": "1", "charge": 0}
    arrives = {"kind": "order_arrived", "order": "A", "lines": {"1": 1}}
    rest = tell(session, at | {"cell": 0}, arrives)["commands"][-1]
    tell(session, at | {"cell": rest["cell"]}, seconds=60)
    fetch = tell(session, {"kind": "robot_charged", "robot": "1"}, seconds=60)["commands"][-1]  # faster than expected
    assert (rest["kind"], fetch["kind"]) == ("move_robot", "fetch")
    assert session.state["robots"]["1"]["charge"] == rest["charge"]
    there = at | {"cell": session.state["pods"][fetch["pod"]]["cell"]}
    tell(session, there, {"kind": "pod_lifted", "pod": fetch["pod"]}, seconds=60)
    assert session.state["robots"]["1"]["charge"] == 0


def test_what_is_in_doubt_stays_so_in_a_state_that_is_put_back(session: Hall) -> None:
    fetch = until(session, "fetch")
    tell(session, {"kind": "pod_locked", "pod": "7"}, {"kind": "robot_failed", "robot": fetch["robot"]})
    tell(session, {"kind": "order_arrived", "order": "o1", "lines": {"1": 1}})
    tell(session, {"kind": "robot_charged", "robot": fetch["robot"]})  # one that has failed is in doubt, too
    before = json.loads(to_json(session.state))
    cells = {told.get("cell") for told in before["pods"].values()} | {*before["empty_pods"]}
    free = next(one for one in make_layout(scenario_of(RULES["sequential"])).storage_locations if one not in cells)
    before["session"]["quarantine"].append({"cell": str(free), "why": "a store was refused"})
    session.take({"after": session.seq, "state": before})
    after = session.state
    assert after["session"]["quarantine"] == before["session"]["quarantine"]
    assert (after["session"]["failed"], after["pods"]) == ([fetch["robot"]], before["pods"])
    held = next(one["contents"] for one in after["session"]["quarantine"] if one.get("pod") == "7")
    came = dict.fromkeys(held, 2)  # bundles that were stored meanwhile
    before["pods"]["7"]["contents"] = came
    session.take({"after": session.seq, "state": before})
    assert session.state["session"]["quarantine"][0]["contents"] == {sku: items + 2 for sku, items in held.items()}
    tell(session, {"kind": "pod_unlocked", "pod": "7"})
    assert sum(session.state["pods"]["7"]["contents"].values()) > 0


@cases(
    "change problem",
    ({"after": 0}, "found 0; expected 1"),
    ({"after": "1"}, "found '1'; expected a whole number"),
    ({"events": []}, "batch.events: is not a field"),
    ({"state": []}, r"batch.state: found \[\]"),
    ({"time_s": 2}, "expected no time before 5"),
    ({"pods": 3}, "batch.state, pods"),
    ({"robots": {"1": {"cell": 5, "task": "none"}}}, "batch.state, robots.1.task"),
    ({"skus": [[]]}, "batch.state, skus"),
    ({"session": {"quarantine": [3]}}, "session.quarantine.0: expected an entry"),
    ({"session": {"closed": 1}}, "session.closed: found 1"),
    ({"run": {"unread": [float("nan")]}}, "batch.state.run: has a number that is not finite"),
    ({"stations": {}}, "batch.state, stations"),
    ({"orders": {"A": {"lines": {"nothing": 1}}}}, "names SKU"),
)
def test_a_state_that_cannot_be_changes_nothing(session: Hall, change: dict[str, Any], problem: str) -> None:
    session.take({"after": 0, "time_s": 5, "events": []})
    before = to_json(session.state)
    batch = {"after": 1, "state": json.loads(before)}
    target: Any = batch if change.keys() & {"after", "events", "state"} else batch["state"]
    target |= change
    with pytest.raises(InputError, match=problem):
        session.take(batch)
    assert (to_json(session.state), session.seq) == (before, 1)


def test_the_first_correction_of_a_day_may_be_at_time_0(tmp_path: Path) -> None:
    scenario = scenario_of(RULES["sequential"])
    session = Hall(scenario, tmp_path / "hall.jsonl")
    tell(session, {"kind": "pod_locked", "pod": "7"})
    assign = tell(session, {"kind": "order_arrived", "order": "A", "lines": {"1": 1}}, seconds=5)["commands"][0]
    tell(session, {"kind": "command_refused", "command": assign["command"], "why": "no"})
    session.close()
    run_day(scenario, tmp_path / "hall.jsonl", tmp_path / "day", ("trace",))
    assert (assign["kind"], check_trace(tmp_path / "day").floor["corrected_s"]) == ("assign", 0)


OPENS = ('stations.open=[["00:00", "00:06"], ["00:09", "23:00"]]',)


def test_a_station_that_the_floor_closed_stays_so_when_its_timetable_opens_it(journal: Path, tmp_path: Path) -> None:
    session = Hall(scenario := load_scenario(EXAMPLES / "small.toml", OPENS), journal)
    closed, opened = ({"kind": f"station_{what}", "station": "1"} for what in ("closed", "opened"))
    for seconds, facts in ((0, [ARRIVES]), (100, [closed]), (500, []), (100, []), (100, [opened])):
        tell(session, *facts, seconds=seconds)
    assert session.state["stations"]["1"]["changes_s"] == 23 * 3600
    session.close()
    run_day(scenario, journal, tmp_path / "day", ("trace",))
    with gzip.open(tmp_path / "day" / "trace.jsonl.gz") as lines:
        traced = [*map(json.loads, lines)][1:]
    told = [(one["e"], one["tick"] // 1000) for one in traced if one["e"].startswith("station_") and not one["station"]]
    assert told == [("station_closed", 100), ("station_opened", 800)]


@pytest.mark.parametrize("put_back", [False, True])
def test_a_station_that_the_floor_opened_outside_its_hours_stays_open_until_these_close_it(put_back: bool) -> None:
    opens = 'stations.open={1=[["00:00", "00:05"], ["00:20", "00:30"]], 2=[["00:00", "00:10"]]}'
    session = Hall(load_scenario(EXAMPLES / "small.toml", (opens,)))
    tell(session, seconds=400)
    tell(session, {"kind": "station_opened", "station": "1"})
    if put_back:
        session.take({"after": session.seq, "state": json.loads(to_json(session.state))})
    states = [(tell(session, seconds=seconds), session.state["stations"]["1"])[1] for seconds in (300, 600, 600)]
    assert [one.get("staffed", True) for one in states] == [True, True, False]
    assert [one.get("changes_s") for one in states] == [None, 1800, 86400]
    assert session.state["session"]["opened"] == []
    tell(session, {"kind": "station_opened", "station": "1"})
    assert session.state["session"]["opened"] == ["1"]


def test_a_station_that_the_floor_closed_stays_so_in_a_state_that_is_put_back() -> None:
    session = Hall(load_scenario(EXAMPLES / "small.toml", OPENS))
    tell(session, seconds=400)
    tell(session, {"kind": "station_closed", "station": "1"})
    session.take({"after": session.seq, "state": json.loads(to_json(session.state))})
    tell(session, seconds=200)
    assert [one.get("staffed", True) for one in session.state["stations"].values()] == [False, True]
    tell(session, {"kind": "station_opened", "station": "1"})
    assert (session.state["stations"]["1"].get("staffed", True), session.state["session"]["closed"]) == (True, [])


def test_a_run_goes_on_from_a_state_with_a_robot_that_drives_in_a_queue(tmp_path: Path) -> None:
    session = Hall(scenario := load_scenario(EXAMPLES / "small.toml", ("rules.pp=free-flow",)))
    fetch = tell(session, ARRIVES)["commands"][1]
    queue = make_layout(scenario).stations[0].queue
    at = [session.state["pods"][fetch["pod"]]["cell"], queue[len(queue) // 2]]
    there, on_its_way = ({"kind": "robot_at", "robot": fetch["robot"], "cell": cell} for cell in at)
    tell(session, there, {"kind": "pod_lifted", "pod": fetch["pod"]}, on_its_way, seconds=30)
    (tmp_path / "state.json").write_text(to_json(session.state))
    overrides = ["rules.pp=free-flow", f"instance.state_file={tmp_path / 'state.json'}"]
    rmfs_core.run("examples/small", overrides=overrides, out=tmp_path / "run", record=["trace"])
    assert check_trace(tmp_path / "run").faults == []


def test_a_day_has_robots_whose_task_or_rest_was_taken_back(journal: Path, tmp_path: Path) -> None:
    scenario = load_scenario(EXAMPLES / "small.toml", ("rules.idle=rest-nearest", "robots.count=2"))
    session = Hall(scenario, journal)
    _, fetch, rests = tell(session, ARRIVES)["commands"]
    robot, there = {"robot": fetch["robot"]}, session.state["pods"]["1"]["cell"]
    tell(session, {"kind": "robot_at", "robot": rests["robot"], "cell": rests["cell"]}, seconds=5)
    refused = {"kind": "command_refused", "why": "no", "command": fetch["command"]}
    tell(session, refused, {"kind": "robot_at", **robot, "cell": there}, seconds=5)  # the other robot fetches the pod
    sent = tell(session, {"kind": "robot_back", **robot}, seconds=60)["commands"]
    assert [one["kind"] for one in sent] == ["move_robot"]
    tell(session, {"kind": "robot_at", **robot, "cell": 61}, seconds=9)  # on its way
    again, refused["command"] = ARRIVES | {"order": "B", "lines": {"5": 1, "9": 1, "14": 1}}, sent[0]["command"]
    sent = tell(session, refused, again, {"kind": "robot_back", **robot}, seconds=9)
    assert ("fetch", fetch["robot"]) in [(one["kind"], one.get("robot")) for one in sent["commands"]]
    tell(session, {"kind": "robot_at", **robot, "cell": 60}, seconds=9)
    session.close()
    run_day(scenario, journal, tmp_path / "day", ("trace",))
    assert check_trace(tmp_path / "day").faults == []


def test_a_day_has_a_replenishment_station_that_the_floor_closed(journal: Path, tmp_path: Path) -> None:
    session = Hall(scenario := load_scenario("examples/replenished"), journal)
    for what in ("closed", "opened"):
        tell(session, {"kind": f"station_{what}", "station": "3"}, seconds=100)
        assert session.state["stations"]["3"].get("staffed", True) is (what == "opened")
    session.close()
    run_day(scenario, journal, tmp_path / "day", ("trace",))
    assert check_trace(tmp_path / "day").faults == []


def test_a_day_has_orders_that_had_to_wait_again_and_parts_that_were_refused(journal: Path, tmp_path: Path) -> None:
    session = Hall(scenario := scenario_of({"poa_pps": "split-over-time"}, pods=20, robots=4, blocks=3), journal)
    closed, opened = ([{"kind": f"station_{what}", "station": one} for one in "12"] for what in ("closed", "opened"))
    tell(session, *closed, {"kind": "order_arrived", "order": "A", "lines": {"1": 1}})
    held = [pod for pod, told in session.state["pods"].items() if "1" in told["contents"]]
    for counted in (0, 40):  # the order waits, and is in stock
        tell(session, *({"kind": "short", "pod": pod, "sku": "1", "counted": counted} for pod in held), seconds=10)
    never = {"kind": "order_arrived", "order": "C", "lines": {"1": 100_000}}  # it waits for stock to the end
    tell(session, *opened, never)
    lines = {f"{sku}": 1 for sku in range(2, 9)}
    commands = tell(session, {"kind": "order_arrived", "order": "B", "lines": lines}, seconds=100)["commands"]
    parts = [one for one in commands if one["kind"] == "assign" and one["order"] == "B"]
    assert len(parts) > 1
    tell(session, {"kind": "command_refused", "command": parts[0]["command"], "why": "no"})
    tell(session, {"kind": "order_back", "order": "B"}, seconds=100)
    session.close()
    day = run_day(scenario, journal, tmp_path / "day", ("trace",))
    assert (day.metrics["backlog_end"], check_trace(tmp_path / "day").faults) == (1, [])


def test_a_day_has_a_move_that_was_refused(journal: Path, tmp_path: Path) -> None:
    rules = {"poa": "pod-match", "pps": "demand", "move": "utility"}
    session = Hall(scenario := scenario_of(rules), journal)
    move = until(session, "move_pod")
    robot, pod = {"robot": move["robot"]}, {"pod": move["pod"]}
    tell(session, {"kind": "robot_at", **robot, "cell": session.state["pods"][move["pod"]]["cell"]})
    refused = {"kind": "command_refused", "command": move["command"], "why": "no"}
    store = tell(session, {"kind": "pod_lifted", **pod}, refused, seconds=9)["commands"][-1]
    there = {"kind": "robot_at", **robot, "cell": store["cell"]}, {"kind": "pod_stored", **pod, "cell": store["cell"]}
    assert tell(session, *there, seconds=9)["dropped"] == []
    session.close()
    run_day(scenario, journal, tmp_path / "day", ("trace",))
    assert check_trace(tmp_path / "day").faults == []


def test_a_hall_with_packing_stations_takes_no_state() -> None:
    session = Hall(load_scenario("examples/packing"))
    tell(session)
    before = to_json(session.state)
    with pytest.raises(InputError, match="a hall with packing stations takes no state"):
        session.take({"after": session.seq, "state": json.loads(before)})
    assert to_json(session.state) == before


@pytest.fixture
def session() -> Hall:
    return Hall(scenario_of(RULES["sequential"]), dead_s=60)


@cases("name seed", ("sequential", 1), ("sequential", 4), ("joint", 1), ("packing", 2), ("replenished", 1))
def test_every_order_in_stock_is_done(name: str, seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.fsync", lambda _: None)  # there is no power cut here
    if name in RULES:
        scenario = scenario_of(RULES[name])
    else:
        scenario = load_scenario(f"examples/{name}", ("instance.items_per_sku=40",) if name == "packing" else ())
    session = Hall(scenario, tmp_path / "hall.jsonl", dead_s=300)
    hall = trouble(session.take, session.state, 40, seed, 0.1)
    assert hall.left == []
    assert hall.lost
    assert {*hall.refused} >= {"fetch", "lift", "store", "pick_next", "assign"}
    assert name != "packing" or len(hall.packed) >= 36
    others = [one["problem"] for one in hall.dropped if "order" not in one["problem"]]
    assert [one for one in others if "taken back" not in one] == []
    assert all("cell" in item or "robot" in item for item in session.state["session"]["quarantine"])
    session.close()
    again = Hall(scenario, tmp_path / "hall.jsonl", dead_s=300)
    assert to_json(again.state) == to_json(session.state)
    again.close()
    day = run_day(scenario, tmp_path / "hall.jsonl", tmp_path / "day", ("trace", "decisions"))
    assert (day.status, day.metrics["orders_completed"] >= 36) == ("complete", True)
    report = check_trace(tmp_path / "day")
    assert (report.faults, report.floor["corrected_s"] > 0) == ([], True)
    recording = read_recording(tmp_path / "day")
    asked = [one for one in recording if one.decides.label in ("PPS", "PR") and one.decision is not None][9::9]
    assert [decide(one.state(), recording.choice_of(one)).decision for one in asked] == [one.decision for one in asked]


def test_an_item_that_took_long_to_pick_is_handled_before_the_next_is_picked(session: Hall) -> None:
    pick = until(session, "pick_next", 2, items=2)
    picked = {"kind": "picked", **{name: pick[name] for name in ("pod", "order", "sku")}}
    assert tell(session, picked, seconds=30)["commands"] == []
    assert "is not handled yet" in tell(session, picked, seconds=5)["dropped"][0]["problem"]
    handled, unlocked = {"kind": "handled", "station": pick["station"]}, {"kind": "pod_unlocked", "pod": pick["pod"]}
    again = [one for one in tell(session, unlocked, handled)["commands"] if one["kind"] == "pick_next"]
    assert again == [pick | {"command": again[0]["command"]}]


def test_a_pod_stands_where_it_was_to_be_stored_wherever_its_robot_was_last_told_to_be(session: Hall) -> None:
    store = until(session, "store")
    there, late = ({"kind": "robot_at", "robot": store["robot"], "cell": cell} for cell in (store["cell"], 0))
    stored = {"kind": "pod_stored", "pod": store["pod"], "cell": store["cell"]}
    assert "is to be set down in cell" in tell(session, there, late, stored | {"cell": 0})["dropped"][0]["problem"]
    assert tell(session, stored)["dropped"] == []
    state = session.state
    assert state["pods"][store["pod"]]["cell"] == state["robots"][store["robot"]]["cell"] == store["cell"]


def test_a_pod_is_lifted_where_it_stood_after_a_wrong_position_of_its_robot(journal: Path, tmp_path: Path) -> None:
    session = Hall(scenario := scenario_of(RULES["sequential"]), journal)
    lift = until(session, "lift")
    stood = session.state["pods"][lift["pod"]]["cell"]
    tell(session, {"kind": "robot_at", "robot": lift["robot"], "cell": 0}, seconds=1)
    assert tell(session, {"kind": "pod_lifted", "pod": lift["pod"]}, seconds=1)["dropped"] == []
    assert session.state["robots"][lift["robot"]]["cell"] == stood
    session.close()
    run_day(scenario, journal, tmp_path / "day", ("trace",))
    assert check_trace(tmp_path / "day").faults == []


def test_a_robot_that_stores_a_pod_in_a_state_that_was_put_back_may_fail(session: Hall) -> None:
    store = until(session, "store")
    session.take({"after": session.seq, "state": json.loads(to_json(session.state))})
    failed = {"kind": "robot_failed", "robot": store["robot"]}
    stored = {"kind": "pod_stored", "pod": store["pod"], "cell": store["cell"]}
    assert tell(session, failed, stored)["dropped"] == []
    assert session.state["pods"][store["pod"]]["cell"] == store["cell"]


def test_a_bundle_whose_pod_was_turned_back_is_stored_later_and_a_count_may_exceed_the_capacity() -> None:
    session = Hall(load_scenario("examples/replenished"))
    bundle = {"kind": "bundle_arrived", "bundle": "b", "sku": "1", "items": 3}
    fetch = next(one for one in tell(session, bundle)["commands"] if one["kind"] == "fetch")
    pod, robot = {"pod": fetch["pod"]}, {"robot": fetch["robot"]}
    cell = session.state["pods"][fetch["pod"]]["cell"]
    tell(session, {"kind": "robot_at", **robot, "cell": cell}, {"kind": "pod_lifted", **pod})
    facts = {"kind": "robot_failed", **robot}, {"kind": "pod_stored", **pod, "cell": cell}, bundle
    answer = tell(session, *facts)
    again = [one for one in answer["commands"] if one["kind"] == "fetch"]
    assert [(one["pod"], one["station"]) for one in again] == [(fetch["pod"], fetch["station"])]
    assert [one["problem"] for one in answer["dropped"]] == ['bundle "b" has arrived before, and is not stored yet.']
    held = dict.fromkeys(session.state["pods"][fetch["pod"]]["contents"], 10)
    tell(session, {"kind": "stock", **pod, "contents": held}, {"kind": "pod_locked", **pod})
    session.take({"after": session.seq, "state": json.loads(to_json(session.state))})
    tell(session, {"kind": "pod_unlocked", **pod})
    state = session.state
    with pytest.raises(InputError, match='skus: names SKU "", of which the scenario has no size'):
        session.take({"after": session.seq, "state": json.loads(to_json(state)) | {"skus": [""]}})
    assert ([one["pod"] for one in state["bundles"]], state["pods"][fetch["pod"]]["capacity"]) == ([fetch["pod"]], 33)


@cases("kind concerns", *((kind, what) for kind, (_, what) in BACK.items() if kind not in ("go_on", "move_robot")))
def test_what_is_refused_is_taken_back(session: Hall, kind: str, concerns: str) -> None:
    command = until(session, kind, 2 if kind in ("fetch", "lift") else 12)
    answer = tell(session, {"kind": "command_refused", "command": command["command"], "why": "no"})
    assert answer["dropped"] == []
    name = str(command[concerns])
    assert quarantined(session, concerns) == {name}
    again = [one for one in answer["commands"] if one["kind"] == kind and str(one[concerns]) == name]
    assert again == []
    if kind in ("fetch", "lift"):  # another robot does it
        assert command["pod"] in [one["pod"] for one in answer["commands"] if one["kind"] == "fetch"]
    if kind == "store":
        assert answer["commands"][0] == command | {key: answer["commands"][0][key] for key in ("command", "cell")}
    if kind == "assign":
        assert session.state["orders"][name]["parts"] == []
    if kind == "pick_next":
        assert session.state["pods"][name]["contents"] == dict.fromkeys(session.state["pods"][name]["contents"], 0)
    refused_again = tell(session, {"kind": "command_refused", "command": command["command"], "why": "no"})
    assert "was not given" in refused_again["dropped"][0]["problem"]
    fact, _ = BACK[kind]
    tell(session, {"kind": fact, concerns: command[concerns]})
    assert quarantined(session, concerns) == set()


def test_the_requests_of_a_late_pod_are_uncovered_until_it_is_heard_of(session: Hall) -> None:
    fetch = until(session, "fetch", 1)
    wanted = session.state["stations"][fetch["station"]]["requests"]
    assert fetch["pod"] in [one.get("pod") for one in wanted]
    now = session.state["time_s"]
    answer = tell(session, seconds=100)
    awaited = {"awaits": "robot_at", "robot": fetch["robot"], "pod": fetch["pod"], "since_s": now}
    assert awaited in answer["overdue"]
    wanted = session.state["stations"][fetch["station"]]["requests"]
    assert fetch["pod"] not in [one.get("pod") for one in wanted]
    assert fetch["pod"] not in [one["pod"] for one in answer["commands"] if one["kind"] == "fetch"]
    assert [one for one in answer["commands"] if one["kind"] == "fetch"]  # others bring the items
    assert fetch["pod"] in quarantined(session, "pod")
    answer = tell(session, {"kind": "robot_at", "robot": fetch["robot"], "cell": 0})
    assert fetch["robot"] not in [one["robot"] for one in answer["overdue"]]
    assert fetch["pod"] not in quarantined(session, "pod")


def test_a_tote_that_does_not_come_is_overdue() -> None:
    session = Hall(load_scenario("examples/packing", ("instance.items_per_sku=40",)), dead_s=60)
    tote = until(session, "send_part")["tote"]
    assert {"awaits": "part_arrived", "tote": tote} in [
        {name: one[name] for name in one if name != "since_s"} for one in tell(session, seconds=61)["overdue"]
    ]


@cases(
    "fact problem concerns",
    ({"kind": "pod_stored", "pod": "1", "cell": 3}, "is no robot's task", ("pod", "1")),
    ({"kind": "robot_at", "robot": "2", "cell": 10**8}, "cannot stand in cell", ("robot", "2")),
    ({"kind": "order_arrived", "order": "o1", "lines": {"1": 1}}, "has arrived before", ("order", "o1")),
    ({"kind": "stock", "pod": "1", "contents": {"1": 1, "2": 1, "3": 1, "4": 1}}, "was never given", ("pod", "1")),
    ({"kind": "cell_blocked", "cell": 0}, "is no free storage location", None),
    ({"kind": "command_refused", "command": 99, "why": "x"}, "was not given", None),
    ({"kind": "order_back", "order": "o9"}, "there is no order", None),
)
def test_what_contradicts_the_state_is_dropped(
    session: Hall, fact: dict[str, Any], problem: str, concerns: Any
) -> None:
    until(session, "assign", 3)
    dropped = tell(session, fact)["dropped"]
    assert [problem in one["problem"] for one in dropped] == [True]
    assert (concerns is None) == (session.state["session"]["quarantine"] == [])
    if concerns is not None:
        assert quarantined(session, concerns[0]) == {concerns[1]}


def test_a_locked_pod_serves_nothing_and_its_orders_wait(session: Hall) -> None:
    before = session.state["pods"]
    sku = next(iter(before["1"]["contents"]))
    holders = [pod for pod, told in before.items() if sku in told["contents"]]
    tell(session, *({"kind": "pod_locked", "pod": pod} for pod in holders))
    answer = tell(session, {"kind": "order_arrived", "order": "A", "lines": {sku: 1}})
    assert answer["commands"] == []
    counted = {"kind": "stock", "pod": "1", "contents": {sku: 0}}
    assert tell(session, counted)["commands"] == []
    assert quarantined(session, "pod") == {*holders} - {"1"}
    found = tell(session, counted | {"contents": {sku: 2}})["commands"]
    assert {("assign", "A"), ("fetch", "1")} <= {(one["kind"], one.get("pod", one.get("order"))) for one in found}
    tell(session, *({"kind": "pod_unlocked", "pod": pod} for pod in holders[::-1]))
    assert session.state["pods"] == before | {"1": session.state["pods"]["1"]}
    short = {"kind": "short", "pod": "1", "sku": sku, "counted": 0}
    answer = tell(session, short)
    if others := {*holders} - {"1"}:
        assert {one["pod"] for one in answer["commands"] if one["kind"] == "fetch"} <= others


def test_an_order_that_is_waiting_leaves_the_backlog_when_its_items_are_gone() -> None:
    session = Hall(scenario_of(RULES["sequential"]))
    stations = [*session.state["stations"]]
    tell(session, *({"kind": "station_closed", "station": one} for one in stations))
    sku = next(iter(session.state["skus"]))
    tell(session, {"kind": "order_arrived", "order": "A", "lines": {sku: 1}})
    holders = [pod for pod, told in session.state["pods"].items() if sku in told["contents"]]
    tell(session, *({"kind": "short", "pod": pod, "sku": sku, "counted": 0} for pod in holders))
    assert tell(session, *({"kind": "station_opened", "station": one} for one in stations))["commands"] == []
    answer = tell(session, {"kind": "short", "pod": holders[0], "sku": sku, "counted": 5})
    assert answer["commands"][0]["kind"] == "assign"


def test_stock_that_is_unlimited_is_not_counted_and_may_be_locked() -> None:
    session = Hall(scenario_of(RULES["joint"], unlimited=True))
    sku = next(iter(session.state["pods"]["1"]["contents"]))
    answer = tell(session, {"kind": "short", "pod": "1", "sku": sku, "counted": 0})
    assert "is unlimited" in answer["dropped"][0]["problem"]
    before = to_json(session.state["pods"])
    tell(session, {"kind": "pod_locked", "pod": "1"})
    answer = tell(session, *({"kind": "order_arrived", "order": f"{i}", "lines": {sku: 1}} for i in range(3)))
    assert "1" not in [one["pod"] for one in answer["commands"] if one["kind"] == "fetch"]
    tell(session, {"kind": "pod_unlocked", "pod": "1"})
    assert to_json(session.state["pods"]) == before


def test_a_session_does_not_grow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rmfs_commands.session.hall.MOST_DONE", 5)
    session = Hall(scenario_of({**RULES["sequential"], "poa": "pod-match"}))
    hall = trouble(session.take, session.state, 40, refuses=0.1)
    assert hall.left == []
    assert len(session.state["orders"]) == 6  # the first one stays
    assert to_json(session.state) == to_json(session.state)
    assert tell(session, {"kind": "order_arrived", "order": "new", "lines": {"1": 1}})["commands"][0]["order"] == "new"
    assert [one["seq"] for one in session.since(session.seq - 2)] == [session.seq - 1, session.seq]


def nonsense(rng: random.Random, state: Mapping[str, Any], number: int) -> dict[str, Any]:
    """Return a fact of the right shape that is true by chance at best."""
    kind, pod = rng.choice([*FACTS]), rng.choice([*state["pods"]])
    held, sku, order = rng.choice([*state["pods"][pod]["contents"]]), rng.choice(state["skus"]), "none"
    values = {
        **{"pod": pod, "sku": held, "order": rng.choice([*state["orders"], order]), "bundle": "b", "why": "?"},
        **{"robot": rng.choice([*state["robots"]]), "station": rng.choice([*state["stations"]])},
        **{"cell": rng.randrange(600), "lines": {sku: 1}, "contents": {held: rng.randrange(5)}, "items": 3},
        **{"counted": rng.randrange(3), "command": rng.randrange(1, 99), "tote": rng.randrange(1, 9)},
    }
    return {"id": f"x{number}", "kind": kind} | {name: values[name] for name in FACTS[kind][0]}


@cases("name", "joint", "packing", "replenished")
def test_no_fact_ends_a_session(name: str) -> None:
    """Each batch is answered and the state can be told, though nobody knows what is right after that."""
    scenario = scenario_of(RULES[name], unlimited=True) if name in RULES else load_scenario(f"examples/{name}")
    session, rng = Hall(scenario, dead_s=200), random.Random(1)
    state = session.state
    skus = sorted(sku for told in state["pods"].values() for sku in told["contents"])
    for number in range(200):
        arrives = {"kind": "order_arrived", "order": f"{number}", "lines": {rng.choice(skus): 1}}
        robot, pod = rng.choice([*state["robots"]]), rng.choice([*state["waiting"], "1"])
        moves = [{"kind": "robot_at", "robot": robot, "cell": rng.randrange(99)}, {"kind": "pod_lifted", "pod": pod}]
        right = [
            {"kind": one["awaits"]} | one for one in state["session"]["awaited"][:2] if one["awaits"] != "robot_at"
        ]
        known = [
            {key: one[key] for key in FACTS[one["kind"]][0] if key in one} | {"kind": one["kind"]} for one in right
        ]
        whole = [one for one in known if FACTS[one["kind"]][0].keys() <= one.keys()]
        answer = tell(session, arrives, *moves, *whole, nonsense(rng, state, number), seconds=5)
        assert answer["seq"] == number + 1
        state = session.state
    assert len(state["session"]["quarantine"]) > 5


REFILL = "instance.arrivals.process=refill", "instance.arrivals.backlog=1", "instance.items_per_sku=40"


def test_an_order_whose_turn_has_not_come_can_be_cancelled_or_set_aside() -> None:
    session = Hall(load_scenario("examples/small", REFILL))
    stations = ("1", "2")
    a, b, c, d = ({"kind": "order_arrived", "order": name, "lines": {"1": 1}} for name in "ABCD")
    tell(session, *({"kind": "station_closed", "station": one} for one in stations), a, b, c, d)
    assert [*session.state["orders"]] == ["A"]
    assert tell(session, {"kind": "order_cancelled", "order": "C"})["dropped"] == []
    assert tell(session, b)["dropped"] != []
    answer = tell(session, *({"kind": "station_opened", "station": one} for one in stations))
    assert [one["order"] for one in answer["commands"] if one["kind"] == "assign"] == ["A", "D"]
    answer = tell(session, {"kind": "order_back", "order": "B"})
    assert [one["order"] for one in answer["commands"] if one["kind"] == "assign"] == ["B"]
    assert tell(session, c)["commands"][0]["order"] == "C"


@cases("seconds", 0.0, 1e8)
def test_orders_whose_turn_has_not_come_are_left_out_of_a_state_and_named(seconds: float) -> None:
    session = Hall(load_scenario("examples/small", REFILL))
    a, b, c, d = ({"kind": "order_arrived", "order": name, "lines": {"1": 1}} for name in "ABCD")
    tell(session, *({"kind": "station_closed", "station": one} for one in ("1", "2")), a, b, c, d, c, seconds=seconds)
    answer = session.take({"after": 1, "state": json.loads(to_json(session.state))})
    assert (answer["left_out"], [*session.state["orders"]]) == (["B", "C", "D"], ["A"])
    assert tell(session, b, c, d)["dropped"] == []
    opened = tell(session, *({"kind": "station_opened", "station": one} for one in ("1", "2")))["commands"]
    assert [one["order"] for one in opened if one["kind"] == "assign"] == ["A", "B", "C", "D"]
