"""All checks over one trace, the start of a run, folders of runs, and `rmfs validate`."""

import gzip
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from shutil import copytree
from typing import Any

import pytest
from attrs import evolve

import rmfs_commands.validation
import rmfs_core
from calling import exit_code, refusal
from cases import cases
from corruptions import Raw
from damage import Damage, at, told
from rmfs_commands.cli.description import installed_rules
from rmfs_commands.testing import validate_trace
from rmfs_commands.trace import read_trace
from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation import KINDS, Fault, check_trace, faults_of
from rmfs_commands.validation.case import Case, avoids_collisions
from rmfs_commands.validation.header import check_readable
from rmfs_commands.validation.opening import check_opening, made_alike
from rmfs_core.errors import InputError
from rmfs_core.motion import Motion
from rmfs_core.world import WEST, OrderData, PodData, StationCells

HALL = "........\n" * 5
ASSIGNED, TRIP, LIFT, JOIN, LEAVE = 1, 3, 7, 10, 17
"""Places of events in `day`."""


def kinds(script: Any, collisions: bool | None = None) -> list[str]:
    return [fault.kind for fault in faults_of(script.trace(), collisions=collisions)]


def test_good_runs_have_no_fault(recorded: Trace, recorded_result: Mapping[str, Any], day: Trace) -> None:
    assert faults_of(recorded, recorded_result) == []
    assert faults_of(day) == []
    wrong = {"metrics": {}, "status": "complete", "scenario": day.scenario}
    assert "metric" in {fault.kind for fault in faults_of(day, wrong)}
    assert "metric" not in {fault.kind for fault in faults_of(at(TRIP, pod=2)(day), wrong)}


@cases(
    "damage sentence",
    (at(TRIP, pod=2), "TripDecided names pod 2, which does not exist"),
    (at(ASSIGNED, skus=(0, 7)), "OrderAssigned names skus 7, which does not exist"),
    (at(LEAVE, next_station=3), "VisitEnded names next_station 3, which does not exist"),
    (at(LIFT, cell=-1), "PodLifted names cell -1, which does not exist"),
)
def test_an_unknown_id_is_named(day: Trace, damage: Damage, sentence: str) -> None:
    """The first fault of its event is the only one: an event that names what is not there is not followed."""
    assert [fault.sentence for fault in faults_of(damage(day)) if fault.kind == "unknown-id"] == [sentence]


def test_times_and_the_end(day: Trace) -> None:
    (fault,) = faults_of(at(JOIN, tick=13_027)(day))
    assert (fault.kind, fault.tick) == ("time-order", 13_027)
    assert fault.sentence == "QueueJoined at 13.027 s stands below an event of 13.028 s"
    (fault,) = faults_of(evolve(day, tick=61_097))
    assert fault.sentence == "the last event is later than the end of the run at 61.097 s"
    (fault,) = faults_of(evolve(day, tick=day.tick + 1))
    assert (fault.kind, fault.tick) == ("end", day.tick + 1)
    assert fault.sentence == "the run ends at 61.099 s, complete, but nothing has happened since 61.098 s"
    late = evolve(day, scenario={**day.scenario, "run": {"until_s": 60}}, status="failed")
    assert [fault.sentence for fault in faults_of(late)] == ["the run ends at 61.098 s; run.until_s is 60"]


def test_a_rule_that_ignores_other_robots_is_not_held_to_it(new_script: Any) -> None:
    script = new_script(HALL, robots=[(0, 0), (0, 5)])
    script.drive(0, 0, 7)
    script.rest(1, 30)
    script.drive(1, 4, 5)
    assert faults_of(script.trace("free-flow")) == []
    assert [fault.kind for fault in faults_of(script.trace("free-flow"), collisions=True)] == ["collision"]
    assert kinds(script, collisions=False) == []


COMMON = ("instance.orders=15", "instance.skus=12", "instance.pods=12", "layout.block_columns=2")


def shipped(decides: str) -> list[str]:
    found = installed_rules()
    decide = [rule for rule in found if rule.distribution == "rmfs" and decides in rule.decides and not rule.error]
    return [rule.name for rule in decide if rule.name != "remote"]  # another program decides


def rows(roles: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Yield rules for roles, so that every rule is there twice, the second time beside others."""
    names = [shipped(role) for role in roles]
    for turn, number in product(range(2), range(max(map(len, names)))):
        yield tuple(found[(number + turn * place) % len(found)] for place, found in enumerate(names))


SEQUENTIAL = [(*row, pp) for row in rows(("POA", "PPS", "PR", "TA")) for pp in shipped("PP")]
JOINT = list(product(shipped("POA+PPS"), shipped("PP")))
CHOSEN = {"switch": '{rule="switch", cases=[{rule="random", before_s=300}, {rule="random"}]}'}
"""Entry in a scenario for a rule that needs parameters."""


def test_there_are_rules_to_combine() -> None:
    assert len(SEQUENTIAL) >= 36
    assert {name for row in SEQUENTIAL for name in row} >= {*shipped("POA"), *shipped("PPS"), *shipped("PR")}


@pytest.mark.parametrize("named", SEQUENTIAL)
def test_sequential_rules(named: tuple[str, ...], tmp_path: Path) -> None:
    roles = ("poa", "pps", "pr", "ta", "pp")
    rules = (f"rules.{role}={CHOSEN.get(name, name)}" for role, name in zip(roles, named, strict=True))
    rmfs_core.run("examples/small", overrides=(*COMMON, *rules), out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []


@pytest.mark.parametrize(("joint", "pp"), JOINT)
def test_joint_rules(joint: str, pp: str, tmp_path: Path) -> None:
    rules = ("rules.poa=", "rules.pps=", f"rules.poa_pps={joint}", f"rules.pp={pp}")
    rmfs_core.run("examples/small", overrides=(*COMMON, *rules), out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []


@pytest.mark.parametrize("pp", shipped("PP"))
@cases(
    "settings",
    ("stations.order_capacity=2",),
    ("stations.order_capacity=[1, 4]",),
    ("stations.item_capacity=3",),
    ("stations.order_capacity=2", "rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time"),
    ("stations.item_capacity=[15, 20]", "stations.queue_length=1", "robots.count=8"),
    ("instance.items_per_sku=40", "instance.arrivals.process=poisson", "instance.arrivals.orders_per_hour=400"),
    ("run.until_s=200",),
    ("instance.pods_at_stations={1 = ['1', '2'], 2 = ['3']}",),
    ("robots.acceleration_m_per_s2=0.7", "robots.top_speed_m_per_s=2.3", "robots.full_turn_s=3.1"),
    ("stations.pick_s=5", "stations.handle_s=5", "robots.lift_s=0"),
    ("layout.pod_fill=1", "layout.stations_west=1"),
    ("stations.release=handled", "stations.order_capacity=2"),
    ("stations.release=handled", "instance.arrivals={process='refill', backlog=6}", "run.until_s=333"),
)
def test_settings(settings: tuple[str, ...], pp: str, tmp_path: Path) -> None:
    overrides = (*COMMON, f"rules.pp={pp}", *settings)
    rmfs_core.run("examples/small", overrides=overrides, out=tmp_path, record=["trace"])
    assert validate_trace(tmp_path) == []


@pytest.mark.parametrize("name", ["examples/from-csv", "examples/example-2-sequential", "examples/poisson"])
def test_shipped_scenarios(name: str, tmp_path: Path) -> None:
    rmfs_core.run(name, overrides=("rules.pp=free-flow",), out=tmp_path, record=["trace"])
    report = check_trace(tmp_path)
    assert report.faults == []
    assert report.events > 80
    assert report.metrics_checked
    assert not report.collisions_checked


@pytest.fixture
def copied(recorded_folder: Path, tmp_path: Path) -> Path:
    return copytree(recorded_folder, tmp_path / "run")


def test_a_result_is_read_where_there_is_one(copied: Path) -> None:
    for path in (copied, copied / "trace.jsonl.gz", str(copied)):
        report = check_trace(path)
        assert (report.faults, report.metrics_checked, report.collisions_checked) == ([], True, False)
    (copied / "result.json").unlink()
    assert not check_trace(copied).metrics_checked
    assert validate_trace(copied) == []


@cases(
    "content problem",
    ("{", "result.json: cannot be read as JSON: Expecting property name"),
    ("[" * 100_000, "result.json: cannot be read as JSON: maximum recursion depth"),
    ("[1]", "result.json: expected a result that rmfs has written, with the key `metrics`"),
    ('{"metrics": 3}', "result.json: expected a result that rmfs has written, with the key `metrics`"),
)
def test_a_damaged_result_is_refused(copied: Path, content: str, problem: str) -> None:
    """A file that is there must be a result: leaving it out of the comparison would hide the damage."""
    (copied / "result.json").write_text(content, encoding="utf-8")
    assert refusal(lambda: validate_trace(copied)).startswith(f"{copied}/{problem}")


@pytest.mark.parametrize("scenario", [[], {"rules": "[/x]"}])
def test_a_header_that_does_not_fit_together_is_refused(copied: Path, scenario: object) -> None:
    trace = copied / "trace.jsonl.gz"
    header, *lines = gzip.decompress(trace.read_bytes()).decode().splitlines(keepends=True)
    changed = json.dumps({**json.loads(header), "scenario": scenario}) + "\n"
    trace.write_bytes(gzip.compress("".join([changed, *lines]).encode()))
    with pytest.raises(InputError, match="the events contradict each other"):
        check_trace(copied)


def alter_metric(folder: Path) -> None:
    file = folder / "result.json"
    content = json.loads(file.read_text(encoding="utf-8"))
    content["metrics"]["picks"] += 1
    file.write_text(json.dumps(content), encoding="utf-8")


code_of = partial(exit_code, "validate")


def test_a_good_run_and_one_with_a_fault(copied: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert code_of(str(copied)) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith("no faults in ")
    assert first.endswith(" events")
    assert second.startswith(
        "NOT CHECKED: WHETHER ROBOTS COLLIDE. The trace says that its PP rule ignores other robots;"
    )
    assert code_of(str(copied), "--json") == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["faults"], report["collisions_checked"], report["metrics_checked"]) == ([], False, True)
    alter_metric(copied)
    assert code_of(str(copied), "--json") == 1
    (fault,) = json.loads(capsys.readouterr().out)["faults"]
    assert fault["kind"] == "metric"
    assert code_of(str(copied)) == 1
    out = capsys.readouterr().out
    assert "metric" in out
    assert "picks is reported as" in out
    assert "1 fault in " in out


def test_a_trace_of_another_version_alone(copied: Path, capsys: pytest.CaptureFixture[str]) -> None:
    raw = Raw.read(copied / "trace.jsonl.gz")
    raw.header["versions"]["numpy"] = "1.0"
    raw.write(copied / "trace.jsonl.gz")
    (copied / "result.json").unlink()
    assert code_of(str(copied / "trace.jsonl.gz")) == 0
    said = capsys.readouterr().out
    assert "Not checked: whether the run starts from what its scenario makes" in said
    assert "no result.json" in said


def test_many_faults_are_cut_off(copied: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert code_of(str(copied), "--collisions", "--limit", "1") == 1
    told = capsys.readouterr().out
    assert re.search(r"collision|swap", told)
    assert "more; --limit shows more of them." in told
    assert code_of(str(copied), "--no-collisions") == 0
    assert "NOT CHECKED: WHETHER ROBOTS COLLIDE, as --no-collisions asks." in capsys.readouterr().out


def test_what_cannot_be_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert code_of(str(tmp_path)) == 2
    assert capsys.readouterr().err == f"Error: {tmp_path}: has no trace.jsonl.gz; `rmfs run --trace` records one\n"
    assert code_of(str(tmp_path / "nowhere")) == 2
    assert capsys.readouterr().err.startswith(f"Error: {tmp_path}/nowhere: ")


def test_every_kind_of_fault_is_found_and_shown_by_a_test() -> None:
    tests = "".join(file.read_text(encoding="utf-8") for file in Path(__file__).parent.parent.rglob("test_*.py"))
    assert {kind for kind in KINDS if not re.search(rf'"{kind}[":]', tests)} == set()
    folder = Path(rmfs_commands.validation.__file__).parent
    code = "".join(file.read_text(encoding="utf-8") for file in folder.glob("*.py") if file.name != "fault.py")
    assert {kind for kind in KINDS if f'"{kind}"' not in code} == set()
    assert Fault("wall", 61_098, "robot 1 drives through the wall at row 1, column 1").time_s == 61.098


def test_stations_of_the_scenario(day: Trace) -> None:
    stations = {name: value for name, value in day.scenario["stations"].items() if name != "queue_length"}
    shortest = min(len(cells.queue) for cells in day.layout.stations)
    assert Case(evolve(day, scenario={**day.scenario, "stations": stations})).queue_length == shortest < 12
    stations = {**day.scenario["stations"], "item_capacity": [15]}
    assert told(evolve(day, scenario={**day.scenario, "stations": stations})) == []


@pytest.mark.parametrize("key", ["pick_s", "handle_s"])
def test_a_scenario_without_its_stations_is_refused(day: Trace, key: str) -> None:
    stations = {name: value for name, value in day.scenario["stations"].items() if name != key}
    with pytest.raises(InputError, match=f"^header of the trace: the scenario lacks '{key}' among its stations$"):
        Case(evolve(day, scenario={**day.scenario, "stations": stations}))


@cases(
    "rules apart expected",
    ({"pp": {"rule": "free-flow"}}, True, False),
    ({"pp": "./mine.py:Mine"}, False, False),
    ({"pp": {"rule": "whca-n", "window_s": 9}}, True, True),
    ({}, True, True),
)
def test_which_rules_avoid_collisions(day: Trace, rules: Mapping[str, Any], apart: bool, expected: bool) -> None:
    """The header says it, but in old traces of free-flow, which may be written by its name or as a table."""
    assert avoids_collisions(evolve(day, scenario={**day.scenario, "rules": rules}, apart=apart)) is expected


def places(trace: Trace, **parts: dict[str, Any]) -> Trace:
    return evolve(trace, **{name: ({**getattr(trace, name)[0], **part},) for name, part in parts.items()})


@cases(
    "damage sentence",
    (lambda t: places(t, robots={"cell": 48}), "found cell 48; expected a whole number from 0 to 47"),
    (lambda t: places(t, robots={"cell": "a"}), "found cell 'a'; expected a whole number from 0 to 47"),
    (lambda t: places(t, robots={"heading": 4}), "found heading 4; expected a whole number from 0 to 3"),
    (lambda t: evolve(t, blocked=(-1,)), "found cell -1; expected a whole number from 0 to 47"),
    (lambda t: places(t, pods={"robot": 1}), "found robot 1; expected a whole number from 0 to 0"),
    (lambda t: places(t, pods={"bound_for": [1]}), "found station 1; expected a whole number from 0 to 0"),
    (
        lambda t: evolve(t, layout=evolve(t.layout, stations=(StationCells(39, (99,)),))),
        "found cell of a station 99; expected a whole number from 0 to 47",
    ),
    (
        lambda t: evolve(t, instance=evolve(t.instance, orders=(OrderData("A", arrival_tick=0, lines=((3, 1),)),))),
        "found SKU 3; expected a whole number from 0 to 2",
    ),
    (
        lambda t: evolve(t, instance=evolve(t.instance, pods=(PodData("P0", ((5, None),)),))),
        "found SKU of a pod 5; expected a whole number from 0 to 2",
    ),
    (lambda t: evolve(t, stations=()), "found 0 stations, but the layout has 1"),
    (
        lambda t: evolve(t, motion=Motion(top_speed_m_per_s=0)),
        "found Motion(acceleration_m_per_s2=1.0, top_speed_m_per_s=0, full_turn_s=2.5, lift_s=2.2); "
        "expected an acceleration and a top speed above 0",
    ),
)
def test_what_names_nothing_is_refused(day: Trace, damage: Damage, sentence: str) -> None:
    check_readable(day)
    assert refusal(lambda: check_readable(damage(day))) == f"header of the trace: {sentence}"


def slower(trace: Trace) -> Trace:
    return evolve(trace, scenario={**trace.scenario, "robots": {"count": 1, "top_speed_m_per_s": 1.0}})


def queue_back(trace: Trace) -> Trace:
    moves = trace.layout.moves.copy()
    moves[trace.layout.stations[0].queue[0]] |= 1 << WEST
    return evolve(trace, layout=evolve(trace.layout, moves=moves))


def two_loads(trace: Trace) -> Trace:
    pods = tuple({**pod, "robot": 0} for pod in trace.pods)
    return evolve(trace, pods=pods, events=(), status="failed")


@cases(
    "damage fault",
    (slower, "header: top_speed_m_per_s of the robots is 1.5; the scenario says 1.0"),
    (lambda t: places(t, stations={"capacity": 16}), "header: the capacity of station 1 is 16, not 15"),
    (lambda t: evolve(t, blocked=(43,)), "no-storage-location: an empty pod stands at row 6, column 4 from the start"),
    (lambda t: evolve(t, blocked=(26,)), "location-taken: pod P1 and an empty pod both stand at row 4, column 3"),
    (queue_back, "header: the way on from row 5, column 7 in the queue of station 1 leads back"),
    (two_loads, "header: robot 1 carries pod P0 and pod P1"),
)
def test_contradictions_are_told(day: Trace, damage: Damage, fault: str) -> None:
    assert told(damage(day)) == [fault]


@pytest.mark.parametrize(("skus", "faults"), [(2, ["header: there are 3 SKUs; the scenario says 2"]), (9, [])])
def test_skus_on_no_pod_may_be_left_out(day: Trace, skus: int, faults: list[str]) -> None:
    instance = {**day.scenario.get("instance", {}), "skus": skus}
    assert told(evolve(day, scenario={**day.scenario, "instance": instance})) == faults


def faults(trace: Trace) -> list[str]:
    case = Case(trace)
    check_opening(case)
    return [fault.sentence for fault in case.faults]


def says(trace: Trace, section: str, **keys: object) -> Trace:
    return evolve(trace, scenario={**trace.scenario, section: {**trace.scenario[section], **keys}})


def test_starts_are_made_anew(recorded: Trace) -> None:
    assert faults(recorded) == []
    assert made_alike(recorded, None)
    assert not made_alike(evolve(recorded, versions={**recorded.versions, "numpy": "1.0"}), None)
    untold = evolve(recorded, versions={})
    assert not made_alike(untold, None)
    assert made_alike(untold, {"versions": {**recorded.versions, "click": "8"}})


def test_a_map_is_read_from_the_header(tmp_path: Path) -> None:
    few = ("instance.orders=2", "rules.pp=free-flow")
    rmfs_core.run("examples/text-map", overrides=few, out=tmp_path, record=["trace"])
    trace = read_trace(tmp_path / "trace.jsonl.gz")
    assert trace.map_text is not None
    assert faults(trace) == []
    assert faults(evolve(trace, map_text=None)) == []
    assert faults(evolve(trace, map_text=trace.map_text.replace("<", ".", 1))) == [
        "row 3, column 16 is left by 14; the scenario says 15, and 1 more"
    ]
    assert faults(evolve(trace, map_text=f"{trace.map_text}@@@@@@@@@@@@@@@@@@@@")) == [
        "the layout has 20 x 10 cells; the scenario says 20 x 11"
    ]
    assert faults(says(trace, "stations", queue_length=4)) == [
        "nothing can be run as the scenario says: stations.queue_length: found 4, but the queue of station 1 in "
        "text-map-hall.txt has 3 cells; expected at most that many"
    ]


@cases(
    "change sentence",
    (lambda t: evolve(t, scenario={**t.scenario, "seed": 9}), "the orders are others than the scenario makes: "),
    (lambda t: evolve(t, robots=t.robots[:-1]), "the locations of robots are 3; the scenario makes 4"),
    (lambda t: evolve(t, blocked=t.blocked[1:]), "the empty pods are "),
    (
        lambda t: evolve(
            t, layout=evolve(t.layout, stations=(t.layout.stations[0], StationCells(0, t.layout.stations[1].queue)))
        ),
        "stations and queues have other cells than the scenario says",
    ),
    (lambda t: says(t, "robots", count=-1), "nothing can be run as the scenario says: header of the trace"),
)
def test_other_starts_are_told(recorded: Trace, change: Callable[[Trace], Trace], sentence: str) -> None:
    assert [told for told in faults(change(recorded)) if told.startswith(sentence)]
