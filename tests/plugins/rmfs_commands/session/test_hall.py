"""Sessions decide as the simulation does, whatever happens to their process."""

import itertools
import os
import signal
from pathlib import Path
from typing import Any

import pytest
from attrs import evolve

from cases import cases
from driven import Log, Told
from rmfs_commands.cli.main import main
from rmfs_commands.instances.tables import ORDER_COLUMNS, VISIT_COLUMNS
from rmfs_commands.results.files import to_csv, to_json
from rmfs_commands.session import Hall, StaleBatchError
from rmfs_commands.session.day import run_day
from rmfs_commands.validation import check_trace
from rmfs_core.errors import InputError, RmfsError
from rmfs_core.hookspecs import hookimpl
from rmfs_core.info import RunInfo
from rmfs_core.results.result import tables
from rmfs_core.scenario import load_scenario

EXAMPLES = Path(__file__).parents[4] / "scenarios" / "examples"


@pytest.fixture(scope="module")
def small() -> Told:
    run = Told(EXAMPLES / "small.toml", ("instance.orders=8",))
    run.run()
    return run


class Rows(tables().Tables):  # type: ignore[misc]
    """Rows of orders.csv and visits.csv of a session, which knows no order before it arrives."""

    def __init__(self, run: Told) -> None:
        super().__init__()
        self._given = run.info.instance

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        super().run_started(evolve(run, instance=self._given))


def tables_of(rows: Rows) -> dict[str, str]:
    given = {"orders.csv": (ORDER_COLUMNS, rows.orders), "visits.csv": (VISIT_COLUMNS, rows.visits)}
    return {name: to_csv([*(found[0] if found else columns)], found) for name, (columns, found) in given.items()}


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
    log, rows = Log(), Rows(run)
    hall = Hall(run.scenario, observers=lambda: (log, rows))
    answers = sent(hall, run)
    assert [answer["dropped"] for answer in answers if answer["dropped"]] == []
    assert log.rows == run.log.rows
    assert len(log.rows) > 100
    assert tables_of(rows) == tables_of(run.tables)
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
def test_a_session_has_the_tables_of_the_run_byte_for_byte(
    name: str, overrides: tuple[str, ...], tmp_path: Path, journal: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And so has the run that its journal is made into, while it is still open."""
    monkeypatch.setattr("os.fsync", lambda _: None)
    settings = [text for override in overrides for text in ("--set", override)]
    main(["run", str(EXAMPLES / name), "--out", str(tmp_path), "--quiet", *settings])
    run = Told(EXAMPLES / name, overrides)
    run.run()
    rows = Rows(run)
    hall = Hall(run.scenario, journal, observers=lambda: (rows,))
    sent(hall, run)
    assert tables_of(rows) == {name: (tmp_path / name).read_text() for name in ("orders.csv", "visits.csv")}
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
    rows = Rows(run)
    hall = Hall(run.scenario, journal, observers=lambda: (rows,))
    assert len(batches) * 4 // 5 < hall.seq < len(batches)
    for batch in batches[hall.seq :]:
        hall.take(batch)
    hall.close()
    assert tables_of(rows) == tables_of(run.tables)


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


BAD = """
from attrs import define
from rmfs_core import hookimpl
from rmfs_core.decisions import OrderAssignment

@define
class Bad:
    @hookimpl
    def assign_orders(self, warehouse):
        if any(order.name == "bad" for order in warehouse.backlog):
            raise ValueError("no")
        first = warehouse.backlog[0]
        return [OrderAssignment(first.id, 0, [line.sku for line in first.lines])]
"""


@cases("kept", True, False)
def test_a_rule_that_fails_changes_nothing(small: Told, journal: Path, kept: bool) -> None:
    (journal.parent / "bad.py").write_text(BAD)
    rules = evolve(small.scenario.rules, poa=evolve(small.scenario.rules.poa, rule=f"{journal.parent}/bad.py:Bad"))
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
