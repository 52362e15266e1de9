"""What ``rmfs explain`` prints of decisions made by hand."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

import rmfs_core
from rmfs_commands.states import Answer, Outcome, Recorded, read_recording
from rmfs_commands.states.explain_tables import (
    overview,
    print_comparison,
    print_decision,
    print_others,
    print_overview,
    print_story,
)
from rmfs_commands.states.stories import Episode
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice, load_scenario

Content = dict[str, Any]
JAM = {"order": "B", "station": "north", "skus": ["jam"]}
P2 = {"pod": "P2", "station": "north"}


def decision(
    decides: str, decided: Any, content: Content | None = None, *, number: int = 1, report: Any = None, **ask: Any
) -> Recorded:
    """Return a recorded decision of the rule ``acme``; its period is its number."""
    asked = {**(content or {"time_s": 60.0}), "ask": {"decides": decides, "period": number, **ask}}
    return Recorded(number, Role.labelled(decides), "acme", asked, decided, report, f"line {number}")


def printed(show: Callable[..., None], *arguments: Any, width: int = 100) -> str:
    """Return what a function prints, blanks drawn together."""
    stream = io.StringIO()
    show(Console(file=stream, width=width), *arguments)
    return "\n".join(" ".join(line.split()) for line in stream.getvalue().splitlines())


def explained(recorded: Recorded, *, limit: int = 20, **parameters: Any) -> str:
    """Return what is printed of one decision."""
    return printed(print_decision, recorded, RuleChoice("acme", parameters), recorded.state(), limit)


def test_decisions_are_counted_by_rule() -> None:
    """In the order in which they first decided; periods are those that were reached."""
    recording = [decision(what, {}, number=n) for n, what in ((1, "POA"), (1, "PPS"), (2, "POA"))]
    assert overview(recording) == {  # type: ignore[arg-type]
        "periods": 2,
        "decisions": 3,
        "by_rule": [
            {"decides": "POA", "rule": "acme", "decisions": 2},
            {"decides": "PPS", "rule": "acme", "decisions": 1},
        ],
    }
    out = printed(print_overview, recording)
    assert "POA acme 2\nPPS acme 1" in out
    assert "Periods 1 to 2, decisions 1 to 3: see --period" in out


EPISODES = (
    Episode(4, (1, 3), (0.0, 1_200.0), Role.POA, "acme", "it waited"),
    Episode(7, (4, 4), (1_500.0, 1_500.0), Role.PPS, "acme", "pod P2 sent"),
)


def test_a_story_has_a_row_for_each_thing_that_happened() -> None:
    """What went on for some time has its first and last period and time."""
    out = printed(print_story, "order B", EPISODES)
    assert "What was decided for order B" in out
    assert "0 s - 1,200 s 1 - 3 4 acme (POA) it waited" in out
    assert "1,500 s 4 7 acme (PPS) pod P2 sent" in out
    assert "By whom, and what" in printed(print_story, "order B", EPISODES, width=70)


def test_a_story_of_nothing() -> None:
    """It says so, and no table is empty."""
    out = printed(print_story, "pod P3", [])
    assert "Nothing: no decision concerned it." in out
    assert "Period" not in out


def test_assignments_are_shown_with_stations_and_backlog(at_work: Content) -> None:
    """P1 is in the line and has the tea; the parts at the station keep two of its four places."""
    out = explained(decision("POA", {"assignments": [JAM]}, at_work | {"time_s": 90.0}), max_wait_s=60.0)
    assert "Decision 1: POA by acme, period 1, at 90.000 s" in out
    assert "Parameters: max_wait_s = 60.0." in out
    assert "north 2 of 4 items 1 0 3 P1*, P2" in out
    assert "* in the line at the station" in out
    assert "Backlog: 1 order with 2 open items; decided for: 1." in out
    assert "B 60 s 2 x jam north: jam" in out
    assert "--limit" not in out


def test_stations_that_count_orders_say_so(by_hand: Content) -> None:
    """Nothing inbound is a dash."""
    by_hand["stations"]["north"] = {"order_capacity": 3}
    out = explained(decision("POA", {"assignments": []}, by_hand | {"time_s": 0.0}))
    assert "north 3 of 3 orders 0 0 13 -" in out


def test_few_orders_of_a_long_backlog_are_shown(by_hand: Content) -> None:
    """Those decided for first, whatever their age; the rest is counted."""
    by_hand["orders"]["C"] = {"lines": {"tea": 1}}
    given = {"assignments": [JAM | {"order": "C", "skus": ["tea"]}]}
    out = explained(decision("POA", given, by_hand | {"time_s": 0.0}), limit=1)
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


@pytest.mark.parametrize(
    ("decides", "decided", "ask", "words"),
    [
        ("PR", {"cell": 13}, {"pod": "P1"}, "Decided: pod P1 is stored at row 2, column 3."),
        ("TA", {"tasks": [{"robot": "r2", "pod": "P2"}]}, {}, "Decided: robot r2 fetches pod P2."),
        ("TA", {"tasks": []}, {}, "Decided: no task."),
        ("activation", {"active": ["north"]}, {}, "Decided: active stations: north."),
        ("activation", {"active": []}, {}, "Decided: active stations: none."),
        ("POA", None, {}, "Decided: nothing valid; the run ended here."),
    ],
)
def test_other_decisions_are_a_sentence(at_work: Content, decides: str, decided: Any, ask: Content, words: str) -> None:
    """Also one that ended the run."""
    assert words in explained(decision(decides, decided, at_work, **ask))


def test_robots_that_rest_are_shown_with_what_is_in_their_batteries(tmp_path: Path) -> None:
    """Those that are sent come first, then those with the least charge; where there are no batteries, no column is."""
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
    """The column is not there."""
    out = explained(decision("idle", {"rests": [{"robot": "r2", "cell": 13}]}, at_work))
    assert "Robot At Goes to" in out
    assert "Decided: robot r2 goes to row 2, column 3." in out


@pytest.mark.parametrize(
    ("report", "words"),
    [
        ({"status": "optimal", "objective": 12.0, "bound": 12.0}, "Model: optimal, objective 12, bound 12."),
        (
            {"status": "stopped", "objective": 12.5, "bound": None, "stopped_early": True},
            "Model: stopped, objective 12.5, bound -; a limit ended the solve before its proof.",
        ),
    ],
)
def test_a_solve_reports_objective_and_bound(by_hand: Content, report: Content, words: str) -> None:
    """A dash for a figure that it does not have."""
    joint = {"assignments": [], "trips": []}
    recorded = decision("POA+PPS", joint, by_hand | {"time_s": 0.0}, report={"stopped_early": False, **report})
    assert explained(recorded).endswith(words)


def test_pods_selected_later_in_the_period() -> None:
    """Station by station; nothing is printed where none were."""
    trips = [{"pod": pod, "station": station} for pod, station in (("3", "2"), ("1", "1"), ("2", "2"))]
    later = decision("PPS", {"trips": trips}, number=6)
    out = printed(print_others, [later, decision("PPS", {"trips": []}, number=8)])
    assert "Pods selected in this period" in out
    assert "6 60.000 s acme 1 to 1; 3, 2 to 2" in out
    assert "8 60.000 s acme none" in out
    assert printed(print_others, []) == ""


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


def test_that_rules_were_asked_once_is_said_where_it_matters() -> None:
    """One that decides on an order at a time leaves places that it would fill when asked again."""
    recorded = decision("POA", {"assignments": [JAM]})
    for orders, unused, said in ((2, 1, True), (2, 0, False), (1, 1, False)):
        outcome = Outcome(orders=1, items=1, visits=0, unused=unused, uncovered=0)
        other = Answer("one", "d", "1", Role.POA, {"assignments": [JAM]}, None, outcome)
        out = printed(print_comparison, recorded, Outcome(orders, 3, 0, 0, 0), [("one", other)])
        assert ("Each rule was asked once." in out) is said


def test_notes_are_for_tables_that_need_them() -> None:
    """Without uncovered requests and reports, there is nothing to explain; without outcomes, no figures."""
    recorded = decision("POA", {"assignments": [JAM]})
    other = Answer("one", "d", "1", Role.POA, {"assignments": []}, None, Outcome(0, 0, 0, 4, 0))
    out = printed(print_comparison, recorded, Outcome(1, 2, 0, 2, 0), [("one", other)])
    assert "Not covered:" not in out
    assert "Objective and bound" not in out
    tasks = {"tasks": [{"robot": "r1", "pod": "P1"}]}
    alone = printed(print_comparison, decision("TA", tasks), None, [])
    assert "Unused" not in alone
    assert "acme (decided) robot r1 fetches pod P1" in alone


def test_where_names_leave_no_room_decisions_stand_below_them() -> None:
    """On a narrow screen, as sentences of their own."""
    out = printed(print_comparison, decision("TA", {"tasks": []}), None, [], width=40)
    assert "acme (decided):\nno task" in out
