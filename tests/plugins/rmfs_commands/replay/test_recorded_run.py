"""A run at any time: recorded and read, as columns, with positions and charges; and while it goes on."""

import base64
import csv
import gzip
import json
import shutil
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
import zlib
from collections import Counter
from collections.abc import Callable
from itertools import accumulate
from pathlib import Path
from typing import Any

import attrs
import pytest
from attrs import define, field

import rmfs_core
from calling import exit_code
from cases import cases
from chromium import Chromium
from rmfs_commands.replay.charges import WHOLE, Line
from rmfs_commands.replay.columns import KINDS, Columns, ColumnsBuilder
from rmfs_commands.replay.live import RUNNING, Watch
from rmfs_commands.replay.positions import ways
from rmfs_commands.replay.reading import Replay, read_replay
from rmfs_commands.replay.recorded import recorded_decisions
from rmfs_commands.replay.telling import told
from rmfs_commands.replay.warehouse import WarehouseAt
from rmfs_commands.states.recorded import read_recording
from rmfs_commands.trace import read_trace
from rmfs_commands.validation.collisions import reached_s
from rmfs_core import InputError, hookimpl
from rmfs_core.clock import TICKS_PER_S, to_ticks
from rmfs_core.events import Event, PodLifted, PodStored, RobotMoved
from rmfs_core.info import RunInfo
from rmfs_core.roles import Role
from rmfs_core.scenario import load_scenario


def test_the_trace_alone(day: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(day / "trace.jsonl.gz", tmp_path / "other.jsonl.gz")
    found = read_replay(tmp_path / "other.jsonl.gz")
    assert found.metrics == {}
    assert found.name == tmp_path.name
    shutil.copytree(day, tmp_path, dirs_exist_ok=True)
    other_header(tmp_path)
    assert exit_code("replay", str(tmp_path)) == 2
    assert "contradict each other, so that it cannot be shown" in capsys.readouterr().err
    assert not (tmp_path / "replay.html").exists()


def cut_through(folder: Path) -> None:
    file = folder / "trace.jsonl.gz"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def other_result(folder: Path) -> None:
    content = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    content["scenario"]["rules"]["pps"] = "completes"
    (folder / "result.json").write_text(json.dumps(content), encoding="utf-8")


def changed(folder: Path, by: Callable[[list[str]], list[str]], name: str = "trace.jsonl.gz") -> None:
    lines = gzip.decompress((folder / name).read_bytes()).decode().splitlines(keepends=True)
    (folder / name).write_bytes(gzip.compress("".join(by(lines)).encode()))


def other_header(folder: Path) -> None:
    (folder / "result.json").unlink()

    def other(lines: list[str]) -> list[str]:
        header = json.loads(lines[0])
        header["scenario"]["rules"] = ["nearest"]
        return [f"{json.dumps(header)}\n", *lines[1:]]

    changed(folder, other)


@cases(
    "damage sentence",
    (lambda folder: (folder / "trace.jsonl.gz").unlink(), r"has no trace.jsonl.gz; `rmfs run --trace` records one"),
    (
        lambda folder: changed(folder, lambda lines: lines[:-5]),
        "the trace was cut off here; expected a last line with the event 'end'",
    ),
    (cut_through, r"trace.jsonl.gz, line \d+: the file was cut off here"),
    (other_result, r"another run than trace.jsonl.gz: its rules.pps is 'completes', that of the trace 'demand'"),
    (
        lambda folder: (folder / "result.json").write_text("[]", encoding="utf-8"),
        "expected a result that rmfs has written, with the key `metrics`",
    ),
)
def test_what_is_no_recorded_run(day: Path, tmp_path: Path, damage: Callable[[Path], object], sentence: str) -> None:
    shutil.copytree(day, tmp_path, dirs_exist_ok=True)
    damage(tmp_path)
    with pytest.raises(InputError, match=sentence):
        read_replay(tmp_path)


TIMES = {"start_tick": -1, "picker_free_tick": 1}


def field_of(columns: Columns, name: str, field: str, i: int, tick: int) -> Any:
    """Return what a column says of an event at a tick."""
    own, texts = columns.events[name], list(columns.texts)
    if field in ("tick", "wall_s"):
        return tick if field == "tick" else 0.0
    if field == "skus":
        begin = sum(own["skus_n"][:i])
        return tuple(own["skus"][begin : begin + own["skus_n"][i]])
    value = own[field][i]
    if field in TIMES:
        return tick + TIMES[field] * value
    if field in ("decides", "rule", "status"):
        return Role.labelled(texts[value]) if field == "decides" else texts[value]
    if field in ("complete", "stopped_early"):
        return bool(value)
    return None if field == "next_station" and value < 0 else value


def events_of(columns: Columns) -> list[Event]:
    """Return the events of columns, but for those of robots that moved."""
    kinds = list(KINDS.items())
    ticks = {name: list(accumulate(columns.events[name]["tick"])) for _, name in kinds}
    taken = Counter[str]()
    found = []
    for code in columns.order:
        kind, name = kinds[code]
        i = taken[name]
        taken[name] += 1
        told = [field_of(columns, name, field.name, i, ticks[name][i]) for field in attrs.fields(kind)]
        found.append(kind(*told))
    return found


def test_no_event_is_lost(day: Path, replay: Replay) -> None:
    told = read_trace(day / "trace.jsonl.gz").events
    assert events_of(replay.columns) == [event for event in told if not isinstance(event, RobotMoved)]


def test_no_leg_is_lost(day: Path, replay: Replay) -> None:
    trace = read_trace(day / "trace.jsonl.gz")
    steps = (1, -trace.layout.width, -1, trace.layout.width)
    for robot, legs in enumerate(replay.columns.legs):
        tick, cell, found = 0, legs.cell, []
        for gap, wait, turn, run, towards, metres, jump in zip(
            legs.gap, legs.wait, legs.turn, legs.run, legs.towards, legs.metres, legs.jump, strict=True
        ):
            start, origin = tick + gap, cell + jump
            tick, cell = start + wait + turn + run, origin + steps[towards] * metres
            found.append((tick, start, origin, cell, towards, wait, turn, metres))
        assert found == [
            (e.tick, e.start_tick, e.origin, e.to, e.heading, e.wait_ticks, e.turn_ticks, e.distance_m)
            for e in trace.events
            if isinstance(e, RobotMoved) and e.robot == robot
        ]


@cases(
    "event named",
    (PodLifted(5, 0, robot=99, pod=0, cell=0), "PodLifted names robot 99"),
    (PodLifted(5, 0, robot=0, pod=-1, cell=0), "PodLifted names pod -1"),
    (RobotMoved(5, 0, 0, 10**6, 3, 0, 0, 0, 1, None), "RobotMoved names origin 1000000"),
)
def test_what_is_not_there_is_refused(replay: Replay, event: Event, named: str) -> None:
    with pytest.raises(InputError, match=named):
        ColumnsBuilder(replay.start).add(event)


@define
class Seen:
    """Observer that notes what rules see of the charge of each robot, after the events of each time."""

    run: RunInfo | None = None
    charges: dict[int, list[float | None]] = field(factory=dict)

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        self.run = run

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.charges[event.tick] = [robot.charge for robot in self.run.warehouse.robots]  # the last of a time counts


@pytest.fixture(scope="module")
def seen(charged: Path, batteries: tuple[str, ...]) -> tuple[Replay, Seen]:
    rmfs_core.run(load_scenario("examples/small", batteries), observers=[(seen := Seen())])
    return read_replay(charged), seen


def test_charges_are_what_rules_see(seen: tuple[Replay, Seen]) -> None:
    replay, observed = seen
    lines = replay.columns.charges.lines(replay.tick)
    compared, lowest = 0, 1.0
    for tick, charges in observed.charges.items():
        for line, charge in zip(lines, charges, strict=True):
            if tick in line.ticks:  # else it may be on its way, and what that takes is counted when it is there
                assert line.at(tick) == pytest.approx(charge, abs=1.5 / WHOLE)
                compared, lowest = compared + 1, min(lowest, charge)
    assert compared > 200
    assert lowest < 0.8
    assert any(b - a > 0.1 * WHOLE for line in lines for a, b in zip(line.charges, line.charges[1:], strict=False))


def test_the_page_is_told_them(seen: tuple[Replay, Seen], replay: Replay) -> None:
    charged, _ = seen
    found = told(charged)["charges"]
    lines = charged.columns.charges.lines(charged.tick)
    assert found["n"] == [len(line.ticks) for line in lines]
    assert sum(found["tick"][: found["n"][0]]) == charged.tick
    assert len(found["charge"]) == sum(found["n"])
    assert told(replay)["charges"] == {"n": [], "tick": [], "charge": []}  # there are no batteries


def test_a_line_is_straight_between_points() -> None:
    line = Line()
    line.ticks.extend([100, 200])
    line.charges.extend([5000, 6000])
    assert [line.at(tick) for tick in (0, 50, 100, 150, 300)] == [1, 0.75, 0.5, 0.55, 0.6]


def test_every_cell_is_reached_when_the_validator_says(day: Path, replay: Replay) -> None:
    trace = read_trace(day / "trace.jsonl.gz")
    found = ways(replay)
    width = trace.layout.width
    legs = [event for event in trace.events if isinstance(event, RobotMoved) and event.distance_m]
    assert len(legs) > 100
    for event in legs:
        begin = event.start_tick + event.wait_ticks + event.turn_ticks
        across, down = ((1, 0), (0, -1), (-1, 0), (0, 1))[event.heading]
        for metres in range(event.distance_m + 1):
            tick = begin + reached_s(trace.motion, event.distance_m, metres) * TICKS_PER_S
            place = found[event.robot].at(round(tick))
            assert place.column == pytest.approx(event.origin % width + across * metres, abs=2e-3)
            assert place.row == pytest.approx(event.origin // width + down * metres, abs=2e-3)
        rests = found[event.robot].at(event.tick)
        assert (rests.column, rests.row) == (event.to % width, event.to // width)
        assert rests.heading == event.heading


def test_a_robot_turns_the_shorter_way(replay: Replay) -> None:
    turned = 0
    for legs, way in zip(replay.columns.legs, ways(replay), strict=True):
        tick, heading = 0, legs.heading
        for i in range(len(legs.gap)):
            start = tick + legs.gap[i] + legs.wait[i]
            quarters = (legs.towards[i] - heading) % 4
            if quarters in (1, 3):
                place = way.at(start + legs.turn[i] // 2)
                half = 0.5 if quarters == 1 else -0.5
                assert place.heading == pytest.approx(heading + half, abs=0.01)
                assert place.moving
                turned += 1
            tick, heading = start + legs.turn[i] + legs.run[i], legs.towards[i]
    assert turned > 10


def test_where_robots_are(replay: Replay, short: Path) -> None:
    for legs, way, robot in zip(replay.columns.legs, ways(replay), replay.start.robots, strict=True):
        place = way.at(0)
        assert place.row * replay.start.layout.width + place.column == robot["cell"] == legs.cell
        assert not place.moving or legs.turn[0] or legs.run[0]
    found = read_replay(short)
    cut = [i for i, legs in enumerate(found.columns.legs) if legs.whole and legs.whole[-1] > legs.metres[-1]]
    assert cut
    for robot in cut:
        legs, way = found.columns.legs[robot], ways(found)[robot]
        end, last = way.at(found.tick), way.at(found.tick - legs.run[-1])
        driven = abs(end.column - last.column) + abs(end.row - last.row)
        assert legs.metres[-1] <= driven < legs.metres[-1] + 1
    world = WarehouseAt(replay)
    assert world.pod_cell == {i: pod["cell"] for i, pod in enumerate(replay.start.pods)}
    assert (world.backlog, world.done, world.picks) == (0, 0, 0)
    world.go(0)
    assert world.backlog + sum(len(open_) for open_ in world.open) == 20
    most = max(range(len(replay.start.pods)), key=world.open_items)
    wanted = [sku for order in replay.start.instance.orders for sku, items in order.lines for _ in range(items)]
    assert world.open_items(most) == sum(wanted.count(sku) for sku, _ in replay.start.instance.pods[most].contents) > 0


def test_the_end(day: Path, replay: Replay) -> None:
    world = WarehouseAt(replay)
    world.go(replay.tick)
    assert world.done == replay.metrics["orders_completed"]
    assert (world.picks, world.backlog) == (replay.metrics["picks"], 0)
    assert not any(world.open)
    assert not any(map(world.open_items, range(len(replay.start.pods))))
    stored = {e.pod: e.cell for e in read_trace(day / "trace.jsonl.gz").events if isinstance(e, PodStored)}
    assert all(world.pod_cell[pod] == cell for pod, cell in stored.items() if pod in world.pod_cell)
    assert world.pod_cell.keys().isdisjoint(world.robot_pod.values())


def test_pickers_work_as_long_as_the_table_says(day: Path, replay: Replay) -> None:
    world = WarehouseAt(replay)
    seen = [0] * len(replay.start.stations)
    for tick in range(0, replay.tick, 1000):
        world.go(tick)
        for station in range(len(seen)):
            seen[station] += world.is_picking(station)
    with (day / "stations.csv").open(encoding="utf-8", newline="") as file:
        busy = [float(row["busy_s"]) for row in csv.DictReader(file)]
    assert all(abs(a - b) <= 0.05 * b + 2 for a, b in zip(seen, busy, strict=True))


def test_bundles_closed_stations_and_moved_pods(restocked: Path) -> None:
    replay = read_replay(restocked)
    world, ticks = WarehouseAt(replay), Counter[str]()
    for tick in sorted({event.tick for event in read_trace(restocked / "trace.jsonl.gz").events}):
        world.go(tick)
        ticks["bundles"] += bool(world.bundles[2])
        ticks["bound"] += any(world.bundles[2].values())
        ticks["stored"] += world.is_picking(2)
        ticks["moving"] += bool(world.moving)
        assert world.closed == ({1} if tick < 600_000 else set())
        assert world.moving <= world.busy
    assert min(ticks.values()) > 0
    assert not any(world.bundles)


def test_each_decision_has_what_was_decided(day: Path, replay: Replay, short: Path) -> None:
    columns = replay.decisions
    recorded = list(read_recording(day))
    assert list(accumulate(columns["tick"])) == [to_ticks(one.time_s) for one in recorded]
    assert [columns["texts"][text] for text in columns["rule"]] == [one.rule for one in recorded]
    assert [columns["texts"][text] for text in columns["decides"]] == [one.decides.label for one in recorded]
    trips = [(t["pod"], t["station"]) for one in recorded for t in (one.decision or {}).get("trips", ())]
    pods, stations = replay.start.instance.pods, replay.start.stations
    assert trips == [
        (pods[one].name, stations[other]["name"])
        for what, one, other in zip(columns["what"], columns["one"], columns["other"], strict=True)
        if what == 1
    ]
    assert (columns["backlog"][0], columns["backlog"][-1]) == (20, 0)
    assert read_replay(short).decisions is None  # none was recorded


def test_bundles_rests_and_moves(restocked: Path) -> None:
    replay = read_replay(restocked)
    columns, names = replay.decisions, replay.columns.bundles()
    parts = list(zip(columns["what"], columns["one"], columns["other"], strict=True))
    pods = {pod.name: i for i, pod in enumerate(replay.start.instance.pods)}
    recorded = [one.decision or {} for one in read_recording(restocked)]
    bundles = [(names.index(b["bundle"]), int(b["station"]) - 1) for one in recorded for b in one.get("bundles", ())]
    stores = [(names.index(b["bundle"]), pods[b["pod"]]) for one in recorded for b in one.get("stores", ())]
    rests = [(int(r["robot"]) - 1, r["cell"]) for one in recorded for r in one.get("rests", ())]
    moves = [(pods[m["pod"]], m["cell"]) for one in recorded for m in one.get("moves", ())]
    for what, expected in ((3, bundles), (4, stores), (5, rests), (6, moves)):
        assert [(one, other) for code, one, other in parts if code == what] == expected != []
    labels = [columns["texts"][text] for text in columns["decides"]]
    waiting = [n for label, n in zip(labels, columns["backlog"], strict=True) if label == "ROA"]
    assert min(waiting) >= 1


def test_decisions_of_another_run(day: Path, tmp_path: Path, replay: Replay) -> None:
    shutil.copytree(day, tmp_path, dirs_exist_ok=True)

    def other(lines: list[str]) -> list[str]:
        decided = json.loads(lines[1])
        decided["decision"]["assignments"][0]["order"] = "none of these"
        return [lines[0], f"{json.dumps(decided)}\n", *lines[2:]]

    changed(tmp_path, other, "decisions.jsonl.gz")
    with pytest.raises(InputError, match="line 2: is no decision of the run that the trace tells of"):
        recorded_decisions(tmp_path, replay.start)


HEED = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
"""Whoever runs the tests in the background ignores Ctrl-C, and so would what they start."""


def asked(address: str, after: int = -1) -> dict[str, Any] | None:
    with urllib.request.urlopen(address.replace("?", f"run?after={after}&"), timeout=10) as answer:
        text = answer.read()
    found: dict[str, Any] | None = json.loads(zlib.decompress(base64.b64decode(text))) if text else None
    return found


class Asking:
    def __init__(self, watch: Watch) -> None:
        self.watch = watch
        self.found: list[tuple[int, dict[str, Any] | None]] = []
        self.events = 0

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.events += 1
        if self.events % 200 == 1:
            self.found.append((event.tick, asked(self.watch.address)))


def test_a_browser_is_told_of_the_run_so_far(tmp_path: Path) -> None:
    watch = Watch("day")
    asking = Asking(watch)
    few = ["instance.orders=20"]
    rmfs_core.run("examples/small", overrides=few, out=tmp_path, record=["trace"], observers=[asking, watch])
    told_in_time = [(tick, run) for tick, run in asking.found if run is not None]
    assert told_in_time
    assert all(run["status"] == RUNNING and run["tick"] <= tick for tick, run in told_in_time)
    last = asked(watch.address)
    whole = json.loads(json.dumps(told(read_replay(tmp_path))))
    assert {**last, **{key: whole[key] for key in ("name", "metrics", "says")}} == whole
    assert asked(watch.address, after=last["tick"] + 1) == last  # a page that has missed the end is told it, too
    watch.close()
    with pytest.raises(urllib.error.URLError):
        asked(watch.address)
    watch.close()


def refusal(address: str, **headers: str) -> tuple[int, str]:
    with pytest.raises(urllib.error.HTTPError) as refused:
        urllib.request.urlopen(urllib.request.Request(address, headers=headers), timeout=10)
    with refused.value as answer:
        return answer.code, answer.read().decode("utf-8")


HELD = """
import time
from pathlib import Path

import attrs
from rmfs_core import hookimpl


@attrs.define
class Held:
    'Observer that holds the run after a minute, until the file `seen` is beside it.'

    @hookimpl
    def on_event(self, event):
        while event.tick > 60_000 and not Path(__file__).with_name("seen").exists():
            time.sleep(0.05)
"""


@pytest.mark.slow
def test_the_command_shows_the_run_in_a_browser_until_ctrl_c(tmp_path: Path) -> None:
    (tmp_path / "held.py").write_text(HELD)
    program = f"{HEED}; from rmfs_commands.cli.main import main; main()"
    held = ("--set", f'rules.observers=["{tmp_path / "held.py"}:Held"]', "--out", str(tmp_path / "out"))
    command = [sys.executable, "-c", program, "run", "paper-250", "--watch", "--quiet", *held]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process, Chromium() as browser:
        try:
            address = next(line.split()[-1] for line in process.stderr if line.startswith("Watch the run at"))
            assert "?token=" in address
            browser.open(address)
            first = browser.evaluate("replay.end")
            assert browser.evaluate("replay.running")
            (tmp_path / "seen").touch()
            begin = time.monotonic()
            while browser.evaluate("replay.running"):
                assert time.monotonic() - begin < 120
                time.sleep(0.2)
            assert browser.evaluate("replay.end") > first
            assert browser.evaluate("replay.clock.tick") > 0
            assert browser.evaluate("replay.views[0].run.status") == "complete"
            assert browser.problems == []
            assert any("until you press Ctrl-C" in line for line in process.stderr)
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=20) == 0
        finally:
            process.kill()
    assert (tmp_path / "out" / "result.json").is_file()


def test_only_this_machine_s_pages_with_the_token_are_answered() -> None:
    watch, other = Watch("day"), Watch("day")
    rmfs_core.run("examples/small", overrides=["instance.orders=1"], observers=[watch])
    assert len(watch.token) > 30
    assert watch.token != other.token
    for host in ({}, {"Host": "localhost:8000"}):  # as through a tunnel
        request = urllib.request.Request(watch.address, headers=host)
        with urllib.request.urlopen(request, timeout=10) as answer:
            assert (answer.status, answer.headers["Content-Type"]) == (200, "text/html; charset=utf-8")
            assert watch.token not in answer.read().decode("utf-8")
    assert asked(watch.address)
    assert asked(watch.address, after=0)
    assert asked(watch.address, after=int("9" * 4000))  # is no time: the whole run
    page, _, _ = watch.address.partition("?")
    without = (403, "Open the address that rmfs run --watch printed, with its token.")
    queries = ("", "?token=", f"?token={other.token}", f"?token={watch.token[:-1]}", "?token=%C3%A9", "?after=0")
    for path in ("", "run", "etc"):
        for query in queries:
            assert refusal(f"{page}{path}{query}") == without, (path, query)
    for host in ("example.org", "localhost.example.org:80"):
        assert refusal(watch.address, Host=host) == (403, "This page is for the machine that it runs on.")
    assert refusal(watch.address.replace("?", "etc?")) == (404, "There is / and /run.")
    watch.close()
