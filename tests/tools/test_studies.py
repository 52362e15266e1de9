"""The studies that take long: what they count and say, on tiny cases."""

import os
import re
import runpy
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mutants
from fuzzing.bases import Bases, make_bases
from fuzzing.surfaces import SURFACES, make_case
from random_worlds import (
    World,
    assigning_rules,
    failure,
    failures,
    joint_rules,
    main,
    random_world,
    with_boxes,
    with_failures,
)
from rmfs_commands.processes.events import RobotDown, StationDown
from rmfs_core import hookimpl
from rmfs_core.events import Event
from rmfs_core.info import Question
from rmfs_core.rules import RuleSet
from rmfs_core.simulation.engine import Simulation
from rmfs_core.world.instance_making import instance_problems

TOOLS = Path(__file__).resolve().parents[2] / "tools"
FUZZ = TOOLS / "fuzz.py"
PLANTED = """
import os, sys
from pathlib import Path

import fuzz
import fuzzing.working
from fuzzing.surfaces import Case

fuzzing.working.MOST_CPU_S = 0
HALF, QUIET = "Error: a.toml: found", "Error: a.toml: found x; expected y"

def divide(): 1 / 0
def hang():
    while True: pass
def vanish(): os._exit(0)
def swell(): bytearray(3 << 30)
def exotic(): sys.exit(7)
def mute(): sys.exit(2)
def rambling(): print(HALF, "x", sep="\\n", file=sys.stderr); sys.exit(2)
def halved(): Path("orders.csv").write_text("a"); print(QUIET, file=sys.stderr); sys.exit(2)
def fine(): print(QUIET, file=sys.stderr); sys.exit(2)

PLANTED = [divide, fine, hang, vanish, swell, exotic, mute, rambling, halved, fine]

def call(arguments):
    PLANTED[int(arguments[0])]()

found = fuzz.scan(range(len(PLANTED)), lambda number: Case("planted", (str(number),), {}), call)
fuzz.report(found, seed=5, wall_s=1.0)
"""


def called(tool: Path | str, *arguments: str, cwd: Path | None = None, **more: Any) -> Any:
    """Call a tool as a program."""
    command = [sys.executable, *([str(tool)] if isinstance(tool, Path) else ["-c", tool]), *arguments]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, **more)


@pytest.fixture(scope="module")
def bases() -> Bases:
    return make_bases(compiled=False)


def test_a_case_is_the_same_for_the_same_seed_and_number(bases: Bases) -> None:
    cases = [make_case(bases, 1, number) for number in range(300)]
    assert make_case(bases, 1, 7) == cases[7]
    assert sum(make_case(bases, 2, number) == case for number, case in enumerate(cases)) < 10
    assert {case.surface for case in cases} == {make.__name__.removeprefix("of_") for _, make in SURFACES}


def test_what_breaks_is_found() -> None:
    done = called(PLANTED, cwd=TOOLS)
    first, *told = done.stdout.splitlines()
    assert first == "10 cases in 1 s; exit codes 1: 2, 2: 5, 7: 1, None: 2; 8 kinds of violations"
    kinds = dict(zip(told[::2], told[1::2], strict=True))
    assert set(kinds) == {
        "1 x traceback: ZeroDivisionError in code of others",
        "1 x hang: too much CPU time, in code of others",
        "1 x ended by os._exit, in code of others",
        "1 x traceback: MemoryError in code of others",
        "1 x exit code 7",
        "1 x no sentence: planted, exit code 2",
        "1 x more than a line: Error: a.toml: ...",
        "1 x exit code 2, but written: 8, orders.csv",
    }
    assert kinds["1 x exit code 7"] == "    python tools/fuzz.py --seed 5 --case 5"
    assert done.stderr == ""


@pytest.mark.slow
def test_nothing_breaks(tmp_path: Path) -> None:
    done = called(FUZZ, "--seed", "1", "--cases", "1000", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    assert done.stdout.startswith("1000 cases")


CODE = '"""A text."""\nif a < b and not c:\n    d = (e + 1) * f if g is None else True\n'


def test_each_change_is_of_one_expression(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mutants, "ROOT", tmp_path)
    file = tmp_path / "code.py"
    file.write_text(CODE, encoding="utf-8")
    changed = set()
    for mutant in mutants.mutants_of(file):
        content = CODE.encode()
        text = (content[: mutant.begin] + mutant.after.encode() + content[mutant.end :]).decode()
        compile(text, "code.py", "exec")
        changed.add(text.splitlines()[mutant.line - 1].strip())
    assert changed == {
        "if a <= b and not c:",
        "if a < b or not c:",
        "if a < b and c:",
        "d = (e - 1) * f if g is None else True",
        "d = (e + 2) * f if g is None else True",
        "d = (e + 1) * f if g is not None else True",
        "d = (e + 1) * f if not (g is None) else True",
        "d = (e + 1) * f if g is None else False",
    }


def test_the_study_counts(tmp_path: Path) -> None:
    done = called(TOOLS / "coverage_study.py", "--repeats", "40", cwd=tmp_path)
    head, _, *rows = done.stdout.splitlines()
    assert head.count("|") == 7
    assert len(rows) == 6
    several = [row.split("|") for row in rows if "4 instances" in row]
    assert all(float(row[2].strip(" %")) > float(row[-2].strip(" %")) + 5 for row in several)
    assert done.returncode == (1 if done.stderr else 0)
    assert "Traceback" not in done.stderr
    assert "contradictions" not in done.stderr


def test_a_short_day_is_compared() -> None:
    options = ["--hours", "0.05", "--seeds", "1", "--shapes", "bought together", "--rules", "pod-match+demand"]
    done = called(TOOLS / "placement_trial.py", *options)
    assert done.returncode == 0, done.stderr
    first, row = done.stdout.splitlines()
    assert first == "Turn-over time and pod visits against random: popularity, co-purchase, foresight"
    assert row.startswith("pod-match+demand bought together")
    assert len(re.findall(r"[+-]\d+ %", row)) == 6


IDLE = """
from attrs import define
from rmfs_core import hookimpl

@define
class Idle:
    @hookimpl
    def assign_orders(self): return []
"""


def test_all_rules_complete_their_worlds() -> None:
    assert list(failures(range(1, 7), assigning_rules())) == []


SPLITTING = ("pod-index", "split-among-stations", "split-over-time")


@settings(max_examples=10, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(1, 1 << 32), rule=st.sampled_from(SPLITTING))
def test_few_boxes_let_no_run_stand_still(seed: int, rule: str) -> None:
    """One to three of them at packing stations; `docs/explanation/packing.md` says why."""
    assert failure(with_boxes(random_world(seed)), rule) is None


@settings(max_examples=20, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(1, 1 << 32), rule=st.sampled_from(("pod-match", *SPLITTING)))
def test_failures_let_no_run_stand_still(seed: int, rule: str) -> None:
    """Of robots and stations, under `sipp` and `whca-n`; `docs/explanation/traffic.md` says why."""
    assert failure(with_failures(random_world(seed)), rule) is None


class Notes:
    """Observer of what fails, and of how often orders are assigned with all boxes taken."""

    failed = without_box = 0

    @hookimpl
    def on_event(self, event: Event) -> None:
        self.failed += isinstance(event, RobotDown | StationDown)

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        self.without_box += question.decides.assigns and question.warehouse.free_boxes == 0


def noted(world: World, rule: str) -> Notes:
    scenario, notes = world.with_rule(rule), Notes()
    if not world.short and not [*instance_problems(world.instance, scenario)]:
        rules = RuleSet.load(scenario.rules, ".")
        rules.register_observer(notes)
        Simulation(scenario, world.instance, world.layout, rules).run()
    return notes


def test_boxes_are_waited_for_and_robots_and_stations_fail() -> None:
    """Without that, the two tests above would show nothing."""
    boxes = [noted(with_boxes(random_world(seed)), "split-over-time") for seed in range(1, 31)]
    assert sum(one.without_box > 0 for one in boxes) >= 6
    failures = [noted(with_failures(random_world(seed)), "pod-match") for seed in range(1, 21)]
    assert sum(one.failed > 1 for one in failures) >= 10


def test_all_rules_that_assign_orders_are_tried() -> None:
    rules = assigning_rules()
    assert {"first-come", "station-queue", "random"} < {*rules}
    assert set(rules[-len(joint_rules()) :]) == set(joint_rules())
    assert len(rules) == 17
    assert "switch" not in rules


def test_worlds_have_what_rules_stumble_over() -> None:
    found: Counter[str] = Counter()
    for seed in range(1, 101):
        world = random_world(seed)
        stations, orders = world.scenario.stations, world.instance.orders
        lines = [line for order in orders for line in order.lines]
        pods = [dict(pod.contents) for pod in world.instance.pods]
        longest = max(quantity for _, quantity in lines)
        counts_orders = stations.order_capacity is not None
        found["order capacity"] += counts_orders
        found["long line"] += not counts_orders and longest > max(np.atleast_1d(stations.item_capacity))
        found["scarce pods"] += any(quantity > max(pod.get(sku, 0) or 0 for pod in pods) for sku, quantity in lines)
        found["short"] += world.short
        found["several stations"] += len(world.layout.stations) > 1
        found[f"packing capacity {world.packing_capacity}"] += 1
        found[world.scenario.rules.ta.rule] += 1
        found["later orders"] += orders[-1].arrival_tick > 0
    assert len(found) == 14
    assert min(found.values()) >= 5, found


def test_a_world_is_the_same_for_the_same_seed() -> None:
    one, other = random_world(7), random_world(7)
    assert (one.scenario, one.instance, one.layout) == (other.scenario, other.instance, other.layout)
    assert random_world(8).instance != one.instance


def test_too_little_stock_that_is_not_refused_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    short = next(world for world in map(random_world, range(1, 99)) if world.short)
    assert failure(short, "first-come") is None
    monkeypatch.setattr("random_worlds.instance_problems", lambda *_: [])
    assert failure(short, "first-come") == "expected 1 reasons to refuse it before the run, found []"
    monkeypatch.setattr("random_worlds.instance_problems", lambda *_: ["why"])
    enough = next(world for world in map(random_world, range(1, 9)) if not world.short)
    assert failure(enough, "first-come") == "expected 0 reasons to refuse it before the run, found ['why']"


def test_failures_are_printed_with_the_command_that_repeats_them(tmp_path, monkeypatch, capsys) -> None:
    """Exit code 1 when there is one, else 0."""
    (tmp_path / "idle.py").write_text(IDLE)
    first = next(seed for seed in range(1, 9) if not random_world(seed).short)
    idle = f"{tmp_path / 'idle.py'}:Idle"
    for rule, code, last in (("first-come", 0, "all completed or were refused"), (idle, 1, "1 failed")):
        asked = ["--seed", str(first), "--worlds", "1", "--rules", rule]
        monkeypatch.setattr("sys.argv", ["random_worlds.py", *asked])
        assert main() == code
        printed = capsys.readouterr().out
        assert printed.endswith(f"{last}\n")
        assert (f"\n  python tools/random_worlds.py {' '.join(asked)}\n" in printed) == bool(code)
        assert ("The run stands still at 0.000 s" in printed) == bool(code)


LOAD = TOOLS / "load.py"
PRINTED = """
Summary:
  Total:        0.0234 secs
  Slowest:      0.0121 secs
  Requests/sec: 854.7812

Latency distribution:
  10%% in 0.0020 secs
  50%% in 0.0031 secs
  99%% in 0.0119 secs

Status code distribution:
  [200] 20 responses
"""


@pytest.fixture
def with_hey(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "hey").write_text(f"#!/bin/sh\ncat <<'END'\n{PRINTED}\nEND\n", encoding="utf-8")
    (tmp_path / "hey").chmod(0o755)
    return {**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ.get('PATH', '')}"}


def load(environment: dict[str, str], *arguments: str) -> tuple[int, str]:
    done = called(LOAD, *arguments, env=environment)
    return done.returncode, done.stdout + done.stderr


def test_what_hey_prints() -> None:
    measured: Any = runpy.run_path(str(LOAD))["Measured"]
    found = measured.of(PRINTED)
    assert (found.rate, found.median_s, found.p99_s, found.statuses) == (854.7812, 0.0031, 0.0119, {"200": 20})
    assert measured.of(PRINTED + "\nError distribution:\n  [3]\tEOF\n").statuses == {"200": 20, "none": 1}


def test_a_short_run(with_hey: dict[str, str]) -> None:
    code, told = load(with_hey, "--requests", "20")
    assert code == 0, told
    assert "Memory after 2 and 20 requests: service " in told and told.count("\nok: ") == 4
    file = Path(with_hey["PATH"].partition(os.pathsep)[0]) / "hey"
    file.write_text(file.read_text(encoding="utf-8").replace("0.0119", "0.0219"), encoding="utf-8")
    code, told = load(with_hey, "--requests", "20")
    assert code == 1
    assert "NOT SO: 99 % within 20 ms at 200 a second" in told


def test_without_hey(tmp_path: Path) -> None:
    code, told = load({**os.environ, "PATH": str(tmp_path)})
    assert (code, told) == (2, "Error: hey is not installed; expected `apt-get install hey`.\n")


def test_a_short_run_is_watched_under_both_planners(tmp_path: Path) -> None:
    done = called(TOOLS / "soak.py", "--orders", "20", cwd=tmp_path)
    assert done.stderr == ""
    lines = done.stdout.splitlines()
    planned = [f"{pp}, 20 orders, 119 an hour" for pp in ("sipp", "whca-n")]
    assert [line for line in lines if "orders," in line] == planned
    assert sum("complete after 0." in line for line in lines) == 2
    assert lines.count("  too short to tell growth") == 2
    assert done.returncode == 0
