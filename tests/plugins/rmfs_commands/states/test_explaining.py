"""Output of `rmfs explain` on decisions, and on one order or pod; `rmfs decide`."""

import io
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

import rmfs_core
from calling import exit_code, refused
from cases import cases
from installed import RMFS
from rmfs_commands.cli.main import main
from rmfs_commands.states import Answer, Outcome, Recorded, read_recording
from rmfs_commands.states.explain_tables import print_comparison, print_decision, print_story
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.states.stories import Episode, order_story, pod_story, reduced
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice, load_scenario

Content = dict[str, Any]
JAM = {"order": "B", "station": "north", "skus": ["jam"]}
P2 = {"pod": "P2", "station": "north"}


def decision(
    decides: str, decided: Any, content: Content | None = None, *, number: int = 1, report: Any = None, **ask: Any
) -> Recorded:
    asked = {**(content or {"time_s": 60.0}), "ask": {"decides": decides, "period": number, **ask}}
    return Recorded(number, Role.labelled(decides), "acme", asked, decided, report, f"line {number}")


def printed(show: Callable[..., None], *arguments: Any, width: int = 100) -> str:
    stream = io.StringIO()
    show(Console(file=stream, width=width), *arguments)
    return "\n".join(" ".join(line.split()) for line in stream.getvalue().splitlines())


def explained(recorded: Recorded, *, limit: int = 20, **parameters: Any) -> str:
    return printed(print_decision, recorded, RuleChoice("acme", parameters), recorded.state(), limit)


EPISODES = (
    Episode(4, (1, 3), (0.0, 1_200.0), Role.POA, "acme", "it waited"),
    Episode(7, (4, 4), (1_500.0, 1_500.0), Role.PPS, "acme", "pod P2 sent"),
)


def test_stories() -> None:
    out = printed(print_story, "order B", EPISODES)
    assert "What was decided for order B" in out
    assert "0 s - 1,200 s 1 - 3 4 acme (POA) it waited" in out
    assert "1,500 s 4 7 acme (PPS) pod P2 sent" in out
    assert "By whom, and what" in printed(print_story, "order B", EPISODES, width=70)
    out = printed(print_story, "pod P3", [])
    assert "Nothing: no decision concerned it." in out
    assert "Period" not in out


def test_assignments_are_shown_with_stations_and_backlog(at_work: Content) -> None:
    """P1 is in the line and has the tea; the parts at the station keep two of its four places."""
    at_work["orders"]["C"] = {"lines": {"jam": 9}, "arrival_s": 40, "waits_for_stock": True}
    now = at_work | {"version": 2, "time_s": 90.0}
    out = explained(decision("POA", {"assignments": [JAM]}, now), max_wait_s=60.0)
    assert "Decision 1: POA by acme, period 1, at 90.000 s" in out
    assert "Parameters: max_wait_s = 60.0." in out
    assert "north 2 of 4 items 1 0 3 P1*, P2" in out
    assert "* in the line at the station" in out
    assert "Backlog: 1 order with 2 open items; 1 more waits for stock; decided for: 1." in out
    assert "B 60 s 2 x jam north: jam" in out
    assert "--limit" not in out


def test_few_orders_of_a_long_backlog_are_shown(by_hand: Content) -> None:
    by_hand["orders"]["C"], by_hand["stations"]["north"] = {"lines": {"tea": 1}}, {"order_capacity": 3}
    given = {"assignments": [JAM | {"order": "C", "skus": ["tea"]}]}
    out = explained(decision("POA", given, by_hand | {"time_s": 0.0}), limit=1)
    assert "north 3 of 3 orders 0 0 13 -" in out
    assert "C 0 s tea north: tea" in out
    assert "\nA 0 s" not in out
    assert "... and 2 more orders; --limit shows more." in out
    out = explained(decision("POA", given, by_hand | {"time_s": 0.0, "backlog": ["B", "C"]}))
    assert "Backlog: 2 orders with 3 open items (the prefilters left out 1 more); decided for: 1." in out


def test_pods_are_shown_with_what_they_are_wanted_for(at_work: Content) -> None:
    """SKUs not covered, pods that could go, and those sent with their contents and the time to drive."""
    at_work["stations"]["north"] |= {"requests": [{"order": "B", "sku": "jam"}] * 2, "inbound": ["P1"]}
    del at_work["orders"]["A"]["parts"]
    out = explained(decision("PPS", {"trips": [P2]}, at_work, max_fetches=1))
    assert "north 2 x jam" in out
    assert "1 of 1 free pods could be sent (robots that can start); leaving a station: P1." in out
    (row,) = (line for line in out.splitlines() if line.startswith("P2 north"))
    *_, drive, unit, number, times, sku = row.split()
    assert float(drive) > 0
    assert (unit, number, times, sku) == ("s", "5", "x", "jam")
    assert "Backlog" not in out
    assert "Decided: no pod is sent." in explained(decision("PPS", {"trips": []}, at_work, max_fetches=0))


@cases(
    "decides decided ask words",
    ("PR", {"cell": 13}, {"pod": "P1"}, "Decided: pod P1 is stored at row 2, column 3."),
    ("TA", {"tasks": [{"robot": "r2", "pod": "P2"}]}, {}, "Decided: robot r2 fetches pod P2."),
    ("TA", {"tasks": []}, {}, "Decided: no task."),
    ("activation", {"active": ["north"]}, {}, "Decided: active stations: north."),
    ("activation", {"active": []}, {}, "Decided: active stations: none."),
    ("POA", None, {}, "Decided: nothing valid; the run ended here."),
)
def test_other_decisions_are_a_sentence(at_work: Content, decides: str, decided: Any, ask: Content, words: str) -> None:
    assert words in explained(decision(decides, decided, at_work, **ask))


def test_robots_that_rest_are_shown_with_what_is_in_their_batteries(tmp_path: Path) -> None:
    battery = "robots.battery={capacity_wh=70, idle_w=200, charging_w=8000}"
    charging = ["layout.chargers=1", battery, "rules.idle=charge-when-low"]
    rmfs_core.run(
        load_scenario("examples/small", ["instance.orders=40", "rules.pp=free-flow", *charging]),
        out=tmp_path,
        record=["decisions"],
    )
    recording = read_recording(tmp_path)
    sends = next(one for one in recording if one.decides is Role.IDLE and (one.decision or {})["rests"])
    out = explained(sends)
    (given,) = (sends.decision or {})["rests"]
    rows = [line for line in out.splitlines() if "%" in line and line[0].isdigit()]
    assert rows[0].startswith(f"{given['robot']} row ")
    assert rows[0].endswith(", a charger")
    shares = [float(row.partition("%")[0].split()[-1]) for row in rows[1:]]
    assert shares == sorted(shares)
    assert f"Decided: robot {given['robot']} goes to row " in out
    assert out.endswith(" until its battery is filled to 80%.")
    assert "more robots" in explained(sends, limit=0) or len(rows) == 1


def test_robots_without_batteries_have_no_charge(at_work: Content) -> None:
    out = explained(decision("idle", {"rests": [{"robot": "r2", "cell": 13}]}, at_work))
    assert "Robot At Goes to" in out
    assert "Decided: robot r2 goes to row 2, column 3." in out


@cases(
    "report words",
    ({"status": "optimal", "objective": 12.0, "bound": 12.0}, "Model: optimal, objective 12, bound 12."),
    (
        {"status": "stopped", "objective": 12.5, "bound": None, "stopped_early": True},
        "Model: stopped, objective 12.5, bound -; a limit ended the solve before its proof.",
    ),
)
def test_a_solve_reports_objective_and_bound(by_hand: Content, report: Content, words: str) -> None:
    joint = {"assignments": [], "trips": []}
    recorded = decision("POA+PPS", joint, by_hand | {"time_s": 0.0}, report={"stopped_early": False, **report})
    assert explained(recorded).endswith(words)


BOTH = {"assignments": [JAM], "trips": [P2]}


def test_other_rules_are_held_against_the_decision() -> None:
    """Visits plus two for each unused place, as W_u of the paper; a dash where requests are not covered."""
    recorded = decision("POA+PPS", BOTH, report={"status": "optimal", "objective": 7.0, "bound": 6.5})
    nothing = {"assignments": [], "trips": []}
    others = [
        ("one", Answer("one", "d", "1", Role.POA_PPS, BOTH, None, Outcome(1, 2, 0, 3, 2))),
        ("two", Answer("two", "d", "1", Role.POA_PPS, nothing, None, Outcome(0, 0, 0, 1_000, 0))),
    ]
    out = printed(print_comparison, recorded, Outcome(1, 2, 1, 3, 0), others)
    assert "acme (decided) 1 2 1 3 7 0 7 / 6.5" in out
    assert "one 1 2 0 3 - 2 -" in out
    assert "two 0 0 0 1000 2000 0 -" in out
    assert "Not covered: open requests" in out
    assert "there is no sum (-)" in out
    assert "asked once" not in out
    assert "Objective and bound are the rule's own" in out
    assert "acme (decided) orders B to north; pods P2 to north" in out
    assert "two orders none; pods none" in out


def test_notes_are_for_tables_that_need_them() -> None:
    recorded = decision("POA", {"assignments": [JAM]})
    other = Answer("one", "d", "1", Role.POA, {"assignments": []}, None, Outcome(0, 0, 0, 4, 0))
    out = printed(print_comparison, recorded, Outcome(1, 2, 0, 2, 0), [("one", other)])
    assert "Not covered:" not in out
    assert "Objective and bound" not in out
    tasks = decision("TA", {"tasks": [{"robot": "r1", "pod": "P1"}]})
    alone = printed(print_comparison, tasks, None, [])
    assert "Unused" not in alone
    assert "acme (decided) robot r1 fetches pod P1" in alone
    assert "acme (decided):\nrobot r1 fetches pod P1" in printed(print_comparison, tasks, None, [], width=40)


def made(number: int, decides: str, content: Content, decided: Any, **ask: Any) -> Recorded:
    return decision(decides, decided, content | {"time_s": float(number)}, number=number, **ask)


def content(room: int, **changes: Any) -> Content:
    """Return a state with a station for four items, of which so many fit now, and two orders of two items each.

    They arrived after the order at the station.
    """
    orders: dict[str, Any] = {name: {"arrival_s": 0.5, "lines": {"milk": 1, "tea": 1}, "parts": []} for name in "AB"}
    if room < 4:
        orders["F"] = {"lines": {"jam": 4 - room}, "parts": [{"station": "s", "skus": ["jam"], "period": 1}]}
    station = {"item_capacity": 4, "requests": [{"order": "F", "sku": "jam"}] * (4 - room)}
    pods = {"P": {"contents": {"milk": None, "tea": None}}}
    state = {"orders": orders, "pods": pods, "stations": {"s": station}, "layout": {"map": ["....", "...."]}}
    return state | changes


def test_why_an_order_waited() -> None:
    begun, closed = content(2), {"item_capacity": 4, "requests": [], "staffed": False}
    begun["orders"]["A"]["parts"] = [{"station": "s", "skus": ["tea"], "period": 5}]
    other = {"assignments": [{"order": "B", "station": "s", "skus": ["milk", "tea"]}]}
    half = [{"order": "A", "station": "s", "skus": ["tea"]}]
    decisions = [
        made(1, "POA", content(4, backlog=["B"]), other),
        made(2, "POA", content(1), other),
        made(3, "POA", content(0), other),
        made(4, "POA", content(2), other),
        made(5, "POA", content(2), {"assignments": []}),
        made(6, "POA", content(2), {"assignments": []}),
        made(7, "POA", content(1, stations={"s": closed}), {"assignments": []}),
        made(8, "POA", content(1, stations={"s": content(1)["stations"]["s"], "t": closed}), {"assignments": []}),
        made(9, "POA", content(2), None),
        made(10, "POA+PPS", content(2), {"assignments": half, "trips": []}),
        made(11, "POA", begun, {"assignments": [{"order": "A", "station": "s", "skus": ["milk"]}]}),
    ]
    story = [*order_story(decisions, "A")]
    assert [(episode.periods, episode.what) for episode in story] == [
        ((1, 1), "the prefilters left it out"),
        ((2, 2), "no station could take its 2 open items, only some of them"),
        ((3, 3), "no station could take its 2 open items"),
        ((4, 4), "it fitted a station, but the rule preferred others"),
        ((5, 6), "it fitted a station, but the rule assigned nothing"),
        ((7, 7), "all stations were closed"),
        ((8, 8), "no open station could take its 2 open items, only some of them"),
        ((9, 9), "the rule decided nothing valid, which ended the run"),
        ((10, 10), "assigned to station s: SKU tea; 1 of its lines stays in the backlog"),
        ((11, 11), "assigned to station s: SKU milk"),
    ]
    assert (story[4].number, story[4].times_s) == (5, (5.0, 6.0))


def test_a_wait_for_stock() -> None:
    orders = content(4)["orders"]
    waits = {"orders": orders | {"A": orders["A"] | {"arrival_s": 0.5, "waits_for_stock": True}}}
    there = {"orders": orders | {"A": orders["A"] | {"arrival_s": 0.5, "waits_for_stock": False}}}
    assigned = {"assignments": [{"order": "A", "station": "s", "skus": ["milk", "tea"]}]}
    decisions = [
        made(1, "POA", content(4, **waits), {"assignments": []}),
        made(2, "TA", content(4, **waits), {"tasks": []}),
        made(3, "TA", content(4, **there), {"tasks": []}),
        made(4, "POA", content(4, **there), assigned),
    ]
    first, last = order_story(decisions, "A")
    assert (first.what, first.times_s) == ("waited for stock from 0 s to 3 s", (1.0, 2.0))
    assert last.what == "assigned to station s: SKUs milk, tea"
    (still,) = order_story(decisions[:2], "A")
    assert still.what == "waits for stock since 0 s"


def test_an_order_that_no_rule_was_asked_about_at_first() -> None:
    """As between waves, or while stations are closed; not where a rule was asked at once, nor of an order begun."""
    decisions = [made(3, "TA", content(4), {"tasks": []}), made(4, "POA", content(0), {"assignments": []})]
    first, waited = order_story(decisions, "A")
    assert first.what == "it arrived at 0 s; in this run no rule was asked to assign it before 4 s"
    assert waited.what == "no station could take its 2 open items"
    assert len(order_story([made(1, "POA", content(0), {"assignments": []}), *decisions], "A")) == 1
    begun = content(0)
    begun["orders"]["A"]["parts"] = [{"station": "s", "skus": ["tea"], "period": 0}]
    assert len(order_story([made(4, "POA", begun, {"assignments": []})], "A")) == 1


def test_reasons_that_return_are_one_row() -> None:
    """In turn, from the first to the last decision for any of them."""
    other = {"assignments": [{"order": "B", "station": "s", "skus": ["milk", "tea"]}]}
    nothing: Content = {"assignments": []}
    decided = [(0, nothing), (2, other), (2, nothing), (2, other), (2, nothing), (0, other)]
    decisions = [made(number, "POA", content(*one[:1]), one[1]) for number, one in enumerate(decided, 1)]
    full, both = order_story(decisions[:5], "A")
    assert (full.what, both.periods) == ("no station could take its 2 open items", (2, 5))
    reasons = "it fitted a station, but the rule preferred others; it fitted a station, but the rule assigned nothing"
    assert both.what == f"in turn: {reasons}"
    (all_of_it,) = order_story(decisions, "A")
    assert (all_of_it.number, all_of_it.times_s) == (1, (1.0, 6.0))


def test_no_rule_was_asked_again_for_long() -> None:
    decisions = [made(number, "POA", content(0), {"assignments": []}) for number in (1, 2, 500, 1100)]
    waited, gap, again = order_story(decisions, "A")
    assert (waited.times_s, again.times_s) == ((1.0, 500.0), (1100.0, 1100.0))
    assert gap.what == "between 500 s and 1,100 s no rule was asked to assign it"
    tasks = [made(number, "TA", content(0), {"tasks": []}) for number in (1100, 1700)]
    assert order_story([*decisions, *tasks], "A")[-1].what.startswith("between 1,100 s and 1,700 s no rule was asked")
    (never,) = order_story(tasks, "A")
    assert never.what == "it arrived at 0 s; in this run no rule was asked to assign it before 1,700 s"


def test_an_order_that_left_is_told_of_once() -> None:
    left = content(0)
    left["orders"]["A"]["cancelled"] = True
    decisions = [made(n, "POA", content(0) if n == 1 else left, {"assignments": []}) for n in (1, 2, 3)]
    assert [episode.what for episode in order_story(decisions, "A")] == [
        "no station could take its 2 open items",
        "cancelled before 2 s, with nothing of it assigned",
    ]
    never = [made(n, "TA", content(0) if n < 2000 else left, {"tasks": []}) for n in (1000, 2000, 3000)]
    told = [episode.what.partition(" s")[0] for episode in order_story(never, "A")]
    assert told == ["it arrived at 0", "cancelled before 2,000"]


def test_pods_that_are_bound_for_the_station_already() -> None:
    """Pod P is there for tea when A is assigned; Q, which has milk, is sent with it."""
    after, before = content(4), content(4, pods={"Q": {"contents": {"milk": None}}})
    served = (("A", "tea", "P"), ("A", "milk", "Q"), ("B", "tea", "P"))
    after["stations"]["s"]["requests"] = [{"order": order, "sku": sku, "pod": pod} for order, sku, pod in served]
    given = {"order": "A", "station": "s", "skus": ["milk", "tea"]}
    decided = {"assignments": [given], "trips": [{"pod": "Q", "station": "s"}]}
    decisions = [made(1, "POA+PPS", before, decided), made(2, "TA", after, {"tasks": []})]
    assert [(episode.number, episode.what) for episode in order_story(decisions, "A")][1:] == [
        (1, "pod Q sent to station s: it holds SKU milk"),
        (1, "pod P, bound for station s already, holds SKU tea"),
    ]


def test_where_a_pod_went() -> None:
    wanted = content(4)
    wanted["orders"]["A"]["parts"] = [{"station": "s", "skus": ["milk"], "period": 1}]
    wanted["stations"]["s"]["requests"] = [{"order": "A", "sku": "milk"}]
    decisions = [
        made(1, "PPS", wanted, {"trips": [{"pod": "P", "station": "s"}]}),
        made(2, "TA", wanted, {"tasks": [{"robot": "3", "pod": "P"}]}),
        made(3, "TA", wanted, {"tasks": [{"robot": "4", "pod": "Q"}]}),
        made(4, "PR", wanted, {"cell": 6}, pod="P"),
        made(5, "PR", wanted, {"cell": 7}, pod="Q"),
    ]
    assert [episode.what for episode in pod_story(decisions, "P")] == [
        "sent to station s: it holds SKU milk",
        "robot 3 fetches it",
        "stored at row 2, column 3",
    ]


def test_a_reduced_warehouse_has_the_room_of_the_whole_one(record: Any) -> None:
    joint = ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time")
    by_orders, small = ("stations.order_capacity=2",), ("stations.item_capacity=3",)
    poisson = ("instance.arrivals.process=poisson", "instance.arrivals.orders_per_hour=300")
    for settings in ((), by_orders, small, poisson, joint, (*joint, *by_orders)):
        for recorded in record(*settings):
            whole = open_state(recorded.state())
            for order in [order for order in whole.view.orders[-3:] if order.open_lines]:
                part, alone = reduced(recorded.content, order.name)
                assert alone.name == order.name
                lines = [(part.instance.skus[line.sku], line.quantity) for line in alone.open_lines]
                assert lines == [(whole.instance.skus[line.sku], line.quantity) for line in order.open_lines]
                for station, there in zip(part.view.stations, whole.view.stations, strict=True):
                    assert station.free_capacity == there.free_capacity
                    assert part.view.size_at(alone, station) == whole.view.size_at(order, there)


def test_an_order_that_waits_beside_a_large_one_is_reduced_without_most_of_its_items() -> None:
    """They took ten minutes in a report of 150 orders, one of them of 5,000 items."""
    large = content(4)
    large["orders"]["B"] |= {"lines": {"tea": 5000}, "parts": [{"station": "s", "skus": ["tea"], "period": 1}]}
    large["stations"]["s"]["requests"] = [{"order": "B", "sku": "tea"}] * 4000
    state, _ = reduced(large, "A")
    (station,) = state.view.stations
    assert (station.free_capacity, station.open_items) == (0, 4)


@pytest.fixture
def decide(tmp_path: Path, by_hand: Any, capsys: Any) -> Callable[..., tuple[int, str, str]]:

    def run(*arguments: str, **changes: Any) -> tuple[int, str, str]:
        (tmp_path / "state.json").write_text(json.dumps(by_hand | changes))
        code = exit_code("decide", str(tmp_path / "state.json"), *arguments)
        out, err = capsys.readouterr()
        return code, out, err

    return run


def test_a_decision_as_json(decide: Any) -> None:
    code, out, err = decide("--rule", "split-over-time", "--set", "max_seconds=5")
    assert (code, err) == (0, "")
    written = json.loads(out)
    assert list(written) == [
        *("rule", "distribution", "version", "decides", "assignments", "trips", "report", "outcome")
    ]
    assert written["trips"] == [{"pod": "P1", "station": "north"}, {"pod": "P2", "station": "north"}]
    assert written["outcome"] == {"orders": 2, "items": 4, "visits": 2, "unused": 0, "uncovered": 0}
    assert decide("--rule", "first-come", "--seed", "7") == decide("--rule", "first-come")


def test_due_times(decide: Any) -> None:
    orders = {"A": {"lines": {"milk": 1}, "due_s": 90, "priority": 2}, "B": {"lines": {"jam": 2}, "priority": 1}}
    code, out, _ = decide("--rule", "first-come", version=2, time_s=100.5, orders=orders)
    assert code == 0
    assert json.loads(out)["due"] == {"A": {"due_s": 90.0, "priority": 2, "slack_s": -10.5}}


IN_HAND = {"1": {"item_capacity": 3, "requests": [], "in_hand": {"order": "1", "sku": "a"}}}


@cases(
    "arguments changes problem",
    ("--rule first-come", {"version": 3}, "state.json, version: expected version 1 or 2"),
    ("--rule first-come", {"orders": {"A": {"lines": {"jam": 1}, "due_s": 90}}}, "found `due_s` or `priority` in a st"),
    ("--rule first-come", {"orders": {"A": {"lines": {"jam": 1}, "priority": 1}}}, "found `due_s` or `priority` in a"),
    ("--rule first-come", {"stations": IN_HAND}, "found `in_hand` in a state of version 1; expected version 2 with it"),
    ("--rule first-come", {"order": {}}, "state.json, order: unknown key (did you mean `orders`?)"),
    ("--rule firstcome", {}, 'there is no rule "firstcome" (did you mean `first-come`'),
    ("--rule integrated --set gap=-1", {}, "gap"),
    ("--rule fixed", {}, "decides PR, but the state has no layout"),
    ("--rule ./mine.py:Mine --no-inline-rules", {}, "--no-inline-rules refuses"),
    ("", {}, "Missing option '--rule'"),
)
def test_wrong_input(decide: Any, arguments: str, changes: dict[str, Any], problem: str) -> None:
    code, out, err = decide(*arguments.split(), **changes)
    assert (code, out) == (2, "")
    assert problem in err


def test_standard_input(by_hand: Any, capsys: Any, monkeypatch: Any) -> None:
    def given(content: Any) -> None:
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(json.dumps(content).encode())))

    asked = ["decide", "-", "--rule", "first-come"]
    given(by_hand)
    main(asked)
    assert json.loads(capsys.readouterr().out)["rule"] == "first-come"
    given(by_hand | {"version": 3})
    assert refused(capsys, main, asked).startswith("Error: standard input, version: expected version 1 or 2")
    monkeypatch.setattr("sys.stdin", None)
    assert refused(capsys, main, asked).startswith("Error: standard input, line 1: this is no valid JSON")


def test_what_can_be_asked(capsys: pytest.CaptureFixture[str]) -> None:
    main(["decide", "--schema"])
    assert json.loads(capsys.readouterr().out)["title"] == "rmfs decision state"


JOINT = ("rules.poa=", "rules.pps=", "rules.poa_pps=split-over-time")


@pytest.fixture
def sequential(record: Any) -> str:
    return str(record().file.parent)


@pytest.fixture
def joint(record: Any) -> str:
    return str(record(*JOINT).file.parent)


def explain(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = exit_code("explain", *arguments)
    out, err = capsys.readouterr()
    return code, "\n".join(" ".join(line.split()) for line in out.splitlines()), " ".join(err.split())


def test_what_was_decided(sequential: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = explain(capsys, sequential)
    assert code == 0
    for words in ("POA pod-match", "PPS demand", "PR nearest", "TA nearest-robot", "Periods 1 to"):
        assert words in out
    code, out, _ = explain(capsys, sequential, "--period", "1", "--limit", "3")
    assert code == 0
    assert "Decision 1: POA by pod-match, period 1, at 0.000 s" in out
    assert "1 6 of 6 items 0 0 13 -" in out
    assert "Backlog: 14 orders" in out
    assert "more orders; --limit shows more" in out
    assert "Pods selected in this period" in out


def test_other_rules_than_those_recorded(joint: str, capsys: pytest.CaptureFixture[str], sequential: str) -> None:
    against = ("--against", "integrated", "--against", "first-come", "--against", "pod-match + demand")
    code, out, _ = explain(capsys, joint, "--period", "1", *against)
    assert code == 0
    assert "Model: optimal, objective" in out
    lines = out.splitlines()
    *_, objective, _, bound = figures_of("split-over-time (decided)", lines)
    assert objective == bound
    assert sum(line.startswith("integrated") for line in lines) == 2
    assert sum(line.startswith("pod-match + demand") for line in lines) == 2
    assert figures_of("first-come", lines)[4] == "-"  # no pods are sent, so nothing is covered
    for period in (2, 3, 4):
        code, out, err = explain(capsys, sequential, "--period", str(period), "--against", "split-over-time")
        assert (code, err) == (0, "")
        assert "\nsplit-over-time " in out


def figures_of(rule: str, lines: list[str]) -> list[str]:
    """Return the figures of a rule, which stand below its name where names are too long for 80 columns."""
    return lines[lines.index(rule) + 1].split()


def test_a_state_goes_round(joint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "state.json"
    code, out, _ = explain(capsys, joint, "--period", "2", "--state", str(file))
    assert code == 0
    assert f"State written to {file}" in out
    main(["decide", str(file), "--rule", "split-over-time"])
    again = json.loads(capsys.readouterr().out)
    recorded = next(r for r in read_recording(joint) if r.period == 2)
    assert recorded.decision == {key: again[key] for key in ("assignments", "trips")}


def test_stories_of_orders_and_pods(sequential: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = explain(capsys, sequential, "--order", "14")
    assert code == 0
    assert "What was decided for order 14" in out
    assert "assigned to station" in out
    sent = next(line for line in out.splitlines() if " sent to station " in line and "pod " in line)
    code, out, _ = explain(capsys, sequential, "--pod", sent.split("pod ")[1].split()[0])
    assert code == 0
    assert "fetches it" in out
    code, _, err = explain(capsys, "a" * 300)
    assert (code, err) == (2, f"Error: {'a' * 300}: cannot be read: File name too long")


@cases(
    "arguments problem",
    ("--period 9999", "there is none; the run has periods 1 to"),
    ("--decision 9999", "there is none; the run has decisions 1 to"),
    ("--order 15", "the run has no order of that name"),
    ("--order x", "no order of that name; expected one such as 1, 2, 3, 4, 5 and 9 more"),
    ("--pod 300", "did you mean `30`"),
    ("--pod 3 --order 3", "exclude each other"),
    ("--against demand", "need --period or --decision"),
    ("--order 3 --state x.json", "need --period or --decision"),
    ("--period 1 --against demand", f'demand: rule "demand" ({RMFS}) decides PPS; expected a rule for POA or POA+PPS'),
    ("--period 1 --against first-come+demand+nearest", "--against first-come+demand+nearest: found 3 rules"),
    ("--period 1 --against ./a.py:A --no-inline-rules", "--no-inline-rules refuses"),
)
def test_what_cannot_be_explained_is_refused(sequential, capsys, arguments, problem) -> None:
    assert problem in " ".join(refused(capsys, main, ["explain", sequential, *arguments.split()]).split())


@cases(
    "change",
    lambda first: first | {"decision": {"assignments": [{"order": "1"}]}},
    lambda first: first | {"change": first["change"] | {"seed": -1}},
    lambda first: first | {"change": first["change"] | {"time_s": 1e308}},
)
def test_a_recording_that_was_changed(change: Any, damaged: Any, tmp_path: Path, capsys: Any) -> None:
    folder = damaged(lambda lines: [lines[0], change(lines[1]), *lines[2:]])
    code, out, err = explain(capsys, str(folder), "--decision", "1", "--state", str(tmp_path / "state.json"))
    assert (code, out) == (2, "")
    assert err.startswith(f"Error: {folder}/decisions.jsonl.gz")
    assert "raised" not in err
    assert not (tmp_path / "state.json").exists()


def test_json(sequential: str, joint: str, capsys: pytest.CaptureFixture[str]) -> None:
    counted = plain(capsys, sequential)
    assert sum(row["decisions"] for row in counted["by_rule"]) == counted["decisions"]
    decision = plain(capsys, joint, "--period", "1", "--against", "integrated")
    assert (decision["number"], decision["decides"], decision["rule"]) == (1, "POA+PPS", "split-over-time")
    assert decision["outcome"]["orders"] > 0
    assert [(one["rule"], one["report"]["status"]) for one in decision["against"]] == [("integrated", "optimal")]
    assert all(one["decides"] == "PPS" for one in plain(capsys, sequential, "--period", "1")["then"])
    story = plain(capsys, sequential, "--order", "14")
    assert story["order"] == "14"
    assert any("assigned to station" in episode["what"] for episode in story["episodes"])


def plain(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    main(["explain", *arguments, "--json"])
    return json.loads(capsys.readouterr().out)


def test_due_times_and_nothing_are_shown(record: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    due = ("instance.due.allowance_s=600", "instance.due.priority_share=0.5", "instance.due.priority_allowance_s=60")
    code, out, _ = explain(capsys, str(record(*due).file.parent), "--decision", "1")
    assert code == 0
    assert "Order Waits Due in Priority Open lines (SKUs)" in out
    assert "0 s 60 s 1" in out
    assert "0 s 600 s 0" in out
    early = ["run", "examples/poisson", "--set", "run.until_s=0.001", "--out", str(tmp_path / "run")]
    main([*early, "--quiet", "--record-decisions"])
    for option in ("period", "decision"):
        code, _, problem = explain(capsys, str(tmp_path / "run"), f"--{option}", "1")
        assert (code, problem) == (2, f"Error: --{option} 1: there is none; the run has no {option}")


def test_a_run_explains_what_was_decided_for_bundles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rmfs_core.run("examples/replenished", overrides=["instance.orders=40"], out=tmp_path, record=["decisions"])
    chosen = next(recorded for recorded in read_recording(tmp_path) if recorded.decides.label == "RPS")
    (store,) = chosen.decision["stores"]
    against = ("--against", "spread-sku", "--against", "random")
    main(["explain", str(tmp_path), "--decision", str(chosen.number), *against])
    shown = capsys.readouterr().out
    assert f"RPS by emptiest-pod, period {chosen.period}" in shown
    assert "Without" in shown
    assert f"bundles {store['bundle']} to pod {store['pod']}" in shown
    told = [episode.what for episode in pod_story(read_recording(tmp_path), store["pod"])]
    assert any(what.startswith(f"chosen for bundle {store['bundle']}: ") for what in told)


PACKING = (
    *("rules.poa=", "rules.pps=", "rules.poa_pps=pod-index", "instance.start='2024-03-01T06:30:15'"),
    "packing={stations=2, boxes=2, packers=1, sorters=1, open={2=[['06:00', '05:00']]}}",
)


def test_the_story_of_an_order_goes_on_to_its_packing(record: Any) -> None:
    recording = record(*PACKING)
    bound = {
        one["order"] for made in recording if made.decides is Role.PACKING for one in (made.decision or {})["packing"]
    }
    told = {order: " ".join(episode.what for episode in order_story(recording, order)) for order in sorted(bound)[:8]}
    assert all("bound for packing station " in story for story in told.values())
    assert any("and no box was free to split it" in story for story in told.values())
    assert any(
        re.search(r"(pack order|put tote \d+, into the box of order) \d+ at packing", one) for one in told.values()
    )
