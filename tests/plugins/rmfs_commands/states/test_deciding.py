"""Rules asked in states that no run has recorded, and their answers with names.

States with a layout or none, with bundles, with orders that wait for stock, and with packing stations.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bad_rules import write_rule
from cases import cases
from rmfs_commands.states import Decider, Outcome, decide, state_from_dict
from rmfs_commands.states.answers import answer_to_dict
from rmfs_commands.states.decider import MOST_LOADED
from rmfs_commands.states.deciding import outcome_of
from rmfs_commands.states.rebuilding import open_state
from rmfs_commands.states.written import read_answer
from rmfs_commands.testing import small_world
from rmfs_core import InputError, RuleError
from rmfs_core.decisions import JointDecision, OrderAssignment, PodTrip, TaskAssignment
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice
from rmfs_core.warehouse import Warehouse, WarehouseView


def test_a_joint_rule_in_a_state_that_other_rules_left(by_hand: dict[str, Any], tmp_path: Path) -> None:
    """A request that no pod is on its way for yet is not the joint rule's fault, but no excuse for its own orders."""
    by_hand["stations"]["north"]["requests"] = [{"order": "B", "sku": "jam"}] * 2
    answer = decide(state_from_dict(by_hand), RuleChoice("integrated"))
    assert answer.decision["trips"] == [{"pod": "P1", "station": "north"}]
    assert answer.outcome == Outcome(orders=1, items=2, visits=1, unused=0, uncovered=2)
    careless = write_rule(tmp_path, "poa_pps", "return JointDecision([OrderAssignment(warehouse.backlog[0].id, 0)])")
    with pytest.raises(RuleError, match=r"Bad.* assigned order A .* to station north .*, but no pod there"):
        decide(state_from_dict(by_hand), RuleChoice(careless), folder=str(tmp_path))


def test_requests_that_a_joint_rule_leaves_are_repaired(at_work: dict[str, Any]) -> None:
    """Where there is a layout, for `demand` asks for driving times; the pod waits for a robot as the rule's do."""
    at_work["stations"]["north"] |= {"requests": [{"order": "B", "sku": "jam"}] * 2, "inbound": ["P1"]}
    del at_work["orders"]["A"]["parts"]
    for repair, trips in (({}, ["P2"]), ({"repair": "nearest-pod"}, ["P2"]), ({"repair": "none"}, [])):
        answer = decide(state_from_dict(at_work | {"ask": repair}), RuleChoice("integrated"))
        assert [trip["pod"] for trip in answer.decision["trips"]] == trips
        assert answer.outcome == Outcome(orders=1, items=2, visits=len(trips), unused=0, uncovered=2 - 2 * len(trips))
        assert answer.to_dict().get("repair") == (
            {"rule": repair.get("repair", "demand"), "trips": 1} if trips else None
        )
    for requests in (at_work["stations"]["north"]["requests"], []):  # also where nothing is to be repaired
        at_work["stations"]["north"]["requests"] = requests
        with pytest.raises(InputError, match=r"^state, ask.repair: rule \"first-come\" .* expected a rule for PPS"):
            decide(state_from_dict(at_work | {"ask": {"repair": "first-come"}}), RuleChoice("integrated"))


def test_facts_of_a_state(at_work: dict[str, Any]) -> None:
    """P1 stands at the station with what order A wants, r2 fetches P2; then nothing is left to pick from P1."""
    at_work["robots"]["r2"]["task"] = "P2"
    facts = ["promises", "next", "arrivals", "leaving"]
    told = decide(state_from_dict(at_work | {"ask": {"tell": facts}}), RuleChoice("first-come")).to_dict()
    tea = {"station": "north", "order": "A", "sku": "tea"}
    assert told["promises"] == [tea | {"items": 1, "pod": "P1"}]
    assert told["next"] == [tea | {"pod": "P1"}]
    here, coming = told["arrivals"]
    assert here == {"pod": "P1", "station": "north", "expected_s": 60.5}
    assert (coming["pod"], coming["expected_s"] > 60.5, told["leaving"]) == ("P2", True, [])
    assert read_answer(told).arrivals[1].expected_s == coming["expected_s"]
    at_work["stations"]["north"]["requests"] = []
    told = decide(state_from_dict(at_work | {"ask": {"tell": facts}}), RuleChoice("first-come")).to_dict()
    assert (told["promises"], told["next"], told["leaving"]) == ([], [], ["P1"])
    with pytest.raises(InputError, match=r"ask.tell: expected promises, next, arrivals or leaving, each once, found"):
        state_from_dict(at_work | {"ask": {"tell": ["lines"]}})


def test_a_broken_robot_and_a_pod_on_the_floor(at_work: dict[str, Any]) -> None:
    """The pod of a robot out of service, bound nowhere: its requests are uncovered, and another pod is sent."""
    at_work["version"] = 2
    at_work["stations"]["north"] |= {"inbound": [], "line": []}
    at_work["pods"]["P3"] = {"contents": {"tea": 2}, "cell": 16}
    at_work["robots"]["r1"] = {"cell": 35, "task": "P1", "in_service": False}
    answer = decide(state_from_dict(at_work), RuleChoice("demand"))
    assert answer.decision == {"trips": [{"pod": "P3", "station": "north"}]}
    ask = {"decides": "TA"}
    del at_work["pods"]["P3"]
    at_work["stations"]["north"]["inbound"] = ["P2"]
    answer = decide(state_from_dict(at_work | {"ask": ask}), RuleChoice("nearest-robot"))
    assert answer.decision == {"tasks": [{"robot": "r2", "pod": "P2"}]}


@cases("rule straight", ("free-flow", True), ("sipp", False), ("whca-n", False))
def test_a_path_among_robots_that_stand(at_work: dict[str, Any], rule: str, straight: bool) -> None:
    at_work["robots"] |= {"r2": {"cell": 0, "heading": 0}, "r3": {"cell": 3}}
    ask = {"decides": "PP", "robot": "r2", "goal": 7}
    decision = decide(state_from_dict(at_work | {"ask": ask}), RuleChoice(rule)).decision
    assert (decision["legs"] == [{"cell": 7, "wait_s": 0.0}]) == straight
    assert decision["legs"][-1]["cell"] == 7
    assert [leg.cell for leg in read_answer(decision).legs] == [leg["cell"] for leg in decision["legs"]]


@cases(
    "legs problem",
    ("[(3, 0)]", r"returned a path with tuple \(3, 0\) in it; expected Leg only"),
    ("5", "returned a path with int 5 in it; expected Leg only"),
    ("[Leg('x')]", "named cell 'x'; expected a whole number"),
    ("[Leg(3, 0.5)]", "named wait_ticks 0.5; expected a whole number"),
)
def test_what_is_no_path_is_told(at_work: dict[str, Any], tmp_path: Path, legs: str, problem: str) -> None:
    route = RuleChoice(write_rule(tmp_path, "pp", f"return Path({legs})"))
    state = state_from_dict(at_work | {"ask": {"decides": "PP", "robot": "r2", "goal": 7}})
    with pytest.raises(RuleError, match=rf'^rule "./bad.py:Bad" .*{problem}'):
        decide(state, route, folder=str(tmp_path))


@cases(
    "change rule problem",
    ({"robot": None}, "free-flow", "ask.robot: is missing; expected the robot that needs a path"),
    ({"robot": "r9"}, "free-flow", 'ask.robot: names robot "r9", which the state does not list'),
    ({"goal": 9999}, "free-flow", "ask.goal: found 9999; expected a cell of the layout where the robot can go"),
    ({}, "pbs", '^state: rule "pbs" .* plans the paths of all robots at once; expected a PP rule that'),
    ({}, "sipp", "robots.r3.cell: found cell 0, where robot r2 stands; expected one robot in a cell"),
)
def test_paths_that_cannot_be_asked_for(at_work: dict[str, Any], change, rule, problem) -> None:
    at_work["robots"]["r3"] = {"cell": 0}
    ask = {key: to for key, to in ({"decides": "PP", "robot": "r2", "goal": 7} | change).items() if to is not None}
    with pytest.raises(InputError, match=problem):
        decide(state_from_dict(at_work | {"ask": ask}), RuleChoice(rule))


def test_a_part_that_is_done_gives_its_capacity_back(by_hand: dict[str, Any]) -> None:
    """Parts at one station without a period are of several; those of one period are one part, and done together."""
    by_hand["stations"]["north"]["requests"] = [{"order": "A", "sku": "tea"}]
    for period, load in (({}, 1), ({"period": 1}, 2)):
        parts = [{"station": "north", "skus": [sku]} | period for sku in ("milk", "tea")]
        by_hand["orders"]["A"]["parts"] = parts
        opened = open_state(state_from_dict(by_hand))
        assert opened.view.stations[0].load == load
        assert [part.period for part in opened.view.orders[0].parts] == [1, 2][: 3 - load]
    by_hand["orders"]["A"]["parts"] = [{"station": "north", "skus": ["milk"]}, parts[1]]
    assert [part.period for part in open_state(state_from_dict(by_hand)).view.orders[0].parts] == [2, 1]


def test_no_more_pods_are_moved_than_robots_can(at_work: dict[str, Any]) -> None:
    ask = {"decides": "repositioning", "max_moves": 60}
    with pytest.raises(InputError, match=r"ask.max_moves: found 60; expected at most \d, the number of idle robots"):
        decide(state_from_dict(at_work | {"ask": ask}), RuleChoice("cache"))
    state = state_from_dict(at_work | {"ask": ask | {"max_moves": 0}})
    assert decide(state, RuleChoice("cache")).decision == {"moves": []}


def test_places_to_store(at_work: dict[str, Any]) -> None:
    at_work["stations"]["north"] = {"item_capacity": 4}
    state = at_work | {"ask": {"decides": "PR", "pod": "P1"}}
    assert decide(state_from_dict(state), RuleChoice("fixed")).decision == {"cell": 12}
    with pytest.raises(InputError, match=r"ask.pod: is missing"):
        decide(state_from_dict(at_work), RuleChoice("fixed"))
    with pytest.raises(InputError, match=r'ask.pod: pod "P2" is stored'):
        decide(state_from_dict(at_work | {"ask": {"pod": "P2"}}), RuleChoice("fixed"))


def test_times_of_stations_are_told_in_version_2(by_hand: dict[str, Any]) -> None:
    for changed in ({"staffed": False}, {"picker_free_s": 3.0}, {"changes_s": 60.0}):
        first = by_hand | {"time_s": 100.0, "stations": {"north": {"item_capacity": 4} | changed}}
        with pytest.raises(InputError, match=r"found opening hours, or a busy picker, in a state of version 1"):
            state_from_dict(first)


def test_what_a_rule_needs_is_checked(by_hand: dict[str, Any], tmp_path: Path) -> None:
    needs = write_rule(tmp_path, "poa", "return []\n    needs = ('unlimited stock', 'item capacity')")
    by_hand["pods"]["P1"]["contents"]["milk"] = 5
    with pytest.raises(InputError, match=r"Bad.* needs pods whose SKUs never run out"):
        decide(state_from_dict(by_hand), RuleChoice(needs), folder=str(tmp_path))
    by_hand["pods"]["P1"]["contents"]["milk"], by_hand["stations"]["north"] = None, {"order_capacity": 1}
    with pytest.raises(InputError, match=r"Bad.* needs stations that count items"):
        decide(state_from_dict(by_hand), RuleChoice(needs), folder=str(tmp_path))


OTHER = '^state, ask.decides: found {}; rule "{}" .* decides {}; expected that, or a rule for {}'


@cases(
    "name asked decides problem",
    ("pod-match", "idle", None, OTHER.format("idle", "pod-match", "POA", "idle")),
    ("integrated", "POA", None, OTHER.format("POA", "integrated", r"POA\+PPS", "POA")),
    ("first-come", "PPS", None, OTHER.format("PPS", "first-come", "POA and packing-task", "PPS")),
    ("most-covered", None, None, "decides filter; expected a rule for POA"),
    ("first-come", None, Role.PPS, "decides POA and packing-task; expected a rule for PPS"),
    ("first-comes", None, None, "did you mean `first-come`"),
    ("free-flow", None, Role.FILTER, r"decides: expected POA, PPS, .*, ROA\+RPS, activation, .* or PP, found 'filter'"),
)
def test_rules_that_cannot_answer(by_hand: dict[str, Any], name, asked, decides, problem) -> None:
    state = state_from_dict(by_hand | {"ask": {"decides": asked} if asked else {}})
    with pytest.raises(InputError, match=problem):
        decide(state, RuleChoice(name), decides=decides)


def test_a_decision_of_another_state(by_hand: dict[str, Any]) -> None:
    decision = {"assignments": [{"order": "C", "station": "north", "skus": ["milk"]}]}
    with pytest.raises(InputError, match="does not belong to the state"):
        outcome_of(state_from_dict(by_hand), Role.POA, decision)


COUNTING = """
from attrs import define, field
from rmfs_core import OrderAssignment, hookimpl

print("loaded")

@define
class Once:
    "POA and PPS: an order the first time it is asked, and nothing afterwards."
    seen: list = field(factory=list)
    def __attrs_post_init__(self): self.calls = 0
    calls: int = field(init=False)
    @hookimpl(specname="assign_orders")
    def something_else(self, warehouse):
        self.calls += 1
        self.seen.append(warehouse.now_s)
        return [OrderAssignment(0, 0)] if self.calls == len(self.seen) == 1 else []
    @hookimpl
    def select_pods(self, warehouse): return []
"""


@pytest.fixture
def once(tmp_path: Path) -> str:
    (tmp_path / "once.py").write_text(COUNTING, encoding="utf-8")
    return "./once.py:Once"


def test_it_remembers_nothing(once: str, tmp_path: Path, by_hand: dict[str, Any], capsys: Any) -> None:
    decider = Decider(RuleChoice(once), folder=str(tmp_path))
    asked = state_from_dict(by_hand | {"ask": {"decides": "POA"}})
    answers = [decider.decide(asked) for _ in range(3)]
    assert [len(answer.decision["assignments"]) for answer in answers] == [1, 1, 1]
    assert decider.decide(state_from_dict(by_hand | {"ask": {"decides": "PPS"}})).decision == {"trips": []}
    with pytest.raises(InputError, match="decides POA and PPS; say which of them is asked"):
        decider.decide(state_from_dict(by_hand))
    assert capsys.readouterr().out == "loaded\n"


@cases(
    "name parameter problem",
    ("first-come", "nonsense", r"^rule.nonsense: .* has no parameter `nonsense`"),
    ("random", "nonsense", r"^rule.nonsense: .* has no parameter `nonsense`"),
    ("pod-index", "finish", r"^rule.finish: expected a number >= 0, found -1"),
)
def test_a_wrong_parameter_is_told_at_once(name: str, parameter: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        Decider(RuleChoice(name, {parameter: -1}))


def test_a_file_that_has_changed(once: str, tmp_path: Path, by_hand: dict[str, Any]) -> None:
    state = state_from_dict(by_hand)
    ask = {"decides": Role.POA, "folder": str(tmp_path)}
    assert decide(state, RuleChoice(once), **ask).decision["assignments"]
    text = (tmp_path / "once.py").read_text(encoding="utf-8")
    (tmp_path / "once.py").write_text(text.replace("[OrderAssignment(0, 0)]", "[]"), encoding="utf-8")
    assert not decide(state, RuleChoice(once), **ask).decision["assignments"]


def test_many_rules_one_after_the_other(by_hand: dict[str, Any]) -> None:
    by_hand["orders"] = {"B": {"lines": {"jam": 1}}}
    state = state_from_dict(by_hand)
    for percent in [*range(1, 2 * MOST_LOADED), *range(1, 2 * MOST_LOADED)]:
        report = decide(state, RuleChoice("integrated", {"unused_capacity_weight": percent / 100})).report
        assert report["objective"] == pytest.approx(4 * percent / 100)  # four places stay free: less than a visit


def test_no_name_is_taken_for_another(by_hand: dict[str, Any], install: Any) -> None:
    source = "\n@define\nclass Lazy:\n    @hookimpl\n    def assign_orders(self, warehouse):\n        return []\n"
    with pytest.raises(InputError, match="there is no rule"):
        decide(state_from_dict(by_hand), RuleChoice("acme-lazy"))
    install("acme", {"acme-lazy": "acme_lazy:Lazy"}, acme_lazy=source)
    assert decide(state_from_dict(by_hand), RuleChoice("acme-lazy")).distribution == "acme"


def test_what_is_no_rule_or_state_is_refused() -> None:
    with pytest.raises(InputError, match=r'^choice: expected a RuleChoice such as .*, found "?.first-come'):
        Decider("first-come")
    with pytest.raises(InputError, match=r"^state: expected a State, such as `read_state` returns, found {}"):
        Decider(RuleChoice("first-come")).decide({})


SKUS = ("milk", "tea", "jam")


@pytest.fixture
def world() -> Warehouse:
    """Return a world of two orders, two pods, two robots and two stations; names are not ids."""
    orders = {"A": ["milk", "tea"], "B": {"jam": 2}}
    return small_world(orders, {"P1": ["milk", "tea"], "P2": ["jam"]}, capacities=(4, 4))


def written(world: Warehouse, decides: Role, answer: object) -> dict[str, Any] | None:
    return answer_to_dict(WarehouseView(world), SKUS, decides, answer)


@cases(
    "decides answer",
    (Role.POA, None),
    (Role.POA, [OrderAssignment(type("Monster", (), {"__index__": lambda _: 1 / 0})(), 0)]),
    (Role.POA, [PodTrip(0, 0)]),
    (Role.POA, [OrderAssignment(9, 0)]),
    (Role.POA, [OrderAssignment(-1, 0)]),
    (Role.POA, [OrderAssignment("A", 0)]),
    (Role.POA, [OrderAssignment(0, 2)]),
    (Role.POA, [OrderAssignment(0, 0, (7,))]),
    (Role.PPS, [PodTrip(2, 0)]),
    (Role.PPS, 3),
    (Role.POA_PPS, [OrderAssignment(0, 0)]),
    (Role.POA_PPS, JointDecision([OrderAssignment(0, 0)], [PodTrip(0, 5)])),
    (Role.POA_PPS, JointDecision(report="optimal")),
    (Role.PR, "12"),
    (Role.PR, True),
    (Role.TA, [TaskAssignment(2, 0)]),
    (Role.TA, [TaskAssignment(0, -1)]),
)
def test_what_names_nothing_is_no_answer(world: Warehouse, decides: Role, answer: object) -> None:
    assert written(world, decides, answer) is None


def test_pods_to_send_need_driving_times_and_robots(by_hand: dict[str, Any], at_work: dict[str, Any]) -> None:
    by_hand["stations"]["north"]["requests"] = [{"order": "B", "sku": "jam"}] * 2
    by_hand["pods"]["P3"] = {"contents": {"jam": None}}
    with pytest.raises(InputError, match=r'rule "nearest-pod" .* asks for driving times, but the state has no layout'):
        decide(state_from_dict(by_hand), RuleChoice("nearest-pod"))
    del at_work["orders"]["A"]["parts"]
    at_work["stations"]["north"] |= {"requests": [{"order": "B", "sku": "jam"}] * 2, "inbound": ["P1"]}
    answer = decide(state_from_dict(at_work), RuleChoice("nearest-pod"))
    assert answer.decision == {"trips": [{"pod": "P2", "station": "north"}]}
    assert answer.outcome == Outcome(orders=0, items=0, visits=1, unused=2, uncovered=0)
    for change, trips in (({"ask": {"max_fetches": 0}}, 0), ({"robots": {"r1": {"cell": 54}}}, 1)):
        assert len(decide(state_from_dict(at_work | change), RuleChoice("nearest-pod")).decision["trips"]) == trips


def with_bundles(**changes: Any) -> dict[str, Any]:
    """Return a state: a station for picking, one for bundles; one bundle waits, the other is at its station."""
    return {
        "format": "rmfs-state",
        "version": 2,
        "time_s": 100,
        "pods": {"P": {"contents": {"a": 3}, "capacity": 10}, "Q": {"contents": {"b": 1}, "capacity": 10}},
        "stations": {"out": {"item_capacity": 5}, "in": {"bundle_capacity": 2}},
        "orders": {},
        "sizes": {"b": 2},
        "bundles": [
            {"name": "late", "sku": "a", "items": 4, "arrival_s": 90},
            {"name": "early", "sku": "b", "items": 4, "arrival_s": 10, "station": "in"},
        ],
    } | changes


@cases(
    "rule decided outcome",
    ("first-bundle", {"bundles": [{"bundle": "late", "station": "in"}]}, (1, 0, 0, 0, 2)),
    ("same-sku", {"stores": [{"bundle": "early", "pod": "Q"}]}, (0, 4, 1, 1, 0)),
    (
        {"rule": "pod-first", "parameters": {"pod": "same-sku"}},
        {
            "bundles": [{"bundle": "late", "station": "in"}],
            "stores": [{"bundle": "early", "pod": "Q"}, {"bundle": "late", "pod": "P"}],
        },
        (1, 8, 2, 0, 0),
    ),
)
def test_each_decision_has_its_answer_and_outcome(rule: Any, decided: dict[str, Any], outcome: tuple[int, ...]) -> None:
    choice = RuleChoice(**rule) if isinstance(rule, dict) else RuleChoice(rule)
    answer = decide(state_from_dict(with_bundles()), choice).to_dict()
    assert {key: answer[key] for key in ("bundles", "stores") if key in answer} == decided
    assert tuple(answer["outcome"].values()) == outcome


def test_pods_have_their_own_capacity_and_number() -> None:
    pods = {"P": {"contents": {"a": 8}, "capacity": 10}, "Q": {"contents": {"b": 1}, "capacity": 3}}
    bundles = [{"name": "x", "sku": "b", "items": 1, "arrival_s": 10, "station": "in"}]
    answer = decide(state_from_dict(with_bundles(pods=pods, bundles=bundles)), RuleChoice("emptiest-pod")).to_dict()
    assert answer["stores"] == [{"bundle": "x", "pod": "P"}]
    for more in ({"ask": {"max_fetches": 0}}, {"robots": {}}):
        assert decide(state_from_dict(with_bundles(**more)), RuleChoice("same-sku")).decision == {"stores": []}


LATE = {"name": "late", "sku": "a", "items": 4}


@cases(
    "changes problem",
    ({"version": 1}, "`bundle_capacity` or `bundles` in a state of version 1"),
    ({"bundles": [LATE, LATE]}, r'bundles\[1\]\.name: found "late" twice'),
    ({"bundles": [LATE | {"station": "on"}]}, r'bundles\[0\]\.station: names station "on"'),
    ({"bundles": [LATE | {"station": "out"}]}, r"bundles\[0\]\.station: expected one that holds more bundles"),
    ({"bundles": [LATE | {"station": "in", "pod": "P"}]}, r"bundles\[0\]\.pod: expected a pod with space"),
    ({"bundles": [LATE | {"arrival_s": 101}]}, r"bundles\[0\]\.arrival_s: found 101.*later than now"),
    ({"bundles": [LATE | {"items": 0}]}, r"bundles\[0\]\.items: expected a whole number from 1"),
    ({"sizes": {"z": 1}}, r'sizes\.z: names SKU "z"'),
    ({"stations": {"in": {"bundle_capacity": 2}}, "bundles": []}, "stations: found none; expected at least one"),
    (
        {"stations": {"in": {"bundle_capacity": 2}, "out": {"item_capacity": 5}}, "bundles": []},
        r"stations\.out: found one that picks orders; expected stations that only store bundles to come last",
    ),
    ({"stations": {"out": {"queue_length": 2}}}, "expected either `item_capacity` or `order_capacity`"),
)
def test_what_cannot_be_is_refused(changes: dict[str, Any], problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        decide(state_from_dict(with_bundles(**changes)), RuleChoice("first-bundle"))


def test_stations_are_of_the_kinds_that_the_layout_has() -> None:
    wrong = {"out": {"item_capacity": 5, "queue_length": 1}, "in": {"item_capacity": 2, "queue_length": 1}}
    layout = {"blocks": {"block_rows": 3, "block_columns": 1, "stations_east": 1, "replenishment_west": 1}}
    given = with_bundles(stations=wrong, pods={}, sizes={}, skus=["a", "b"], layout=layout, bundles=[])
    with pytest.raises(InputError, match=r"stations\.in: found one that picks orders; expected one that stores"):
        decide(state_from_dict(given), RuleChoice("first-bundle"))


NEW = {"format": "rmfs-state", "version": 2}


def asked(**orders: dict[str, Any]) -> dict[str, Any]:
    """Return the answer of a rule that assigns orders, the only place of a station among it."""
    given = NEW | {
        "pods": {"P": {"contents": {"tea": 3}}},
        "stations": {"n": {"order_capacity": 1}},
        "orders": {"old": {"lines": {"milk": 1}}, "new": {"lines": {"tea": 1}}} | orders,
    }
    return decide(state_from_dict(given), RuleChoice("pod-match")).to_dict()


def test_orders_that_stock_cannot_serve_are_not_shown() -> None:
    """The younger order is assigned, and the answer names the one that waits; what a state says of it counts."""
    answer = asked()
    assert [given["order"] for given in answer["assignments"]] == ["new"]
    assert answer["waiting_for_stock"] == ["old"]
    answer = asked(old={"lines": {"milk": 1}, "waits_for_stock": False})
    assert [given["order"] for given in answer["assignments"]] == ["old"]
    assert "waiting_for_stock" not in answer
    answer = asked(new={"lines": {"tea": 1}, "waits_for_stock": True})
    assert (answer["assignments"], answer["waiting_for_stock"]) == ([], ["old", "new"])


def test_the_oldest_orders_take_their_share_of_stock_first() -> None:
    """Two items are left for orders, as one of three is requested; an order that is begun keeps what it wants."""
    stations = {"n": {"item_capacity": 9, "requests": [{"order": "B", "sku": "tea"}]}}
    orders = {
        "A": {"lines": {"tea": 1}, "arrival_s": 30},
        "B": {"lines": {"tea": 1, "jam": 1}, "arrival_s": 20},
        "C": {"lines": {"tea": 2}, "arrival_s": 10},
        "D": {"lines": {"jam": 1}, "arrival_s": 5},
    }
    given = NEW | {"pods": {"P": {"contents": {"tea": 3, "jam": 1}}}, "stations": stations, "orders": orders}
    answer = decide(state_from_dict(given), RuleChoice("first-come")).to_dict()
    assert [one["order"] for one in answer["assignments"]] == ["C", "B"]
    assert answer["waiting_for_stock"] == ["D", "A"]


@cases(
    "changes problem",
    ({"version": 1}, "`waits_for_stock` in a state of version 1; expected version 2"),
    ({"backlog": ["A"]}, r"orders\.A\.waits_for_stock: found true .* waits no more: `backlog` names it"),
    (
        {"stations": {"n": {"order_capacity": 1, "requests": [{"order": "A", "sku": "tea"}]}}},
        r"orders\.A\.waits_for_stock: found true .*: lines of it are assigned",
    ),
)
def test_an_order_that_waits_is_neither_shown_nor_begun(changes: dict[str, Any], problem: str) -> None:
    orders = {"A": {"lines": {"tea": 1, "jam": 1}, "waits_for_stock": True}}
    given = NEW | {"pods": {"P": {"contents": {"tea": 3}}}, "stations": {"n": {"order_capacity": 1}}, "orders": orders}
    with pytest.raises(InputError, match=problem):
        decide(state_from_dict(given | changes), RuleChoice("first-come"))


STATE: dict[str, Any] = {
    "format": "rmfs-state",
    "version": 2,
    "pods": {"P": {"contents": {"a": 9, "b": 9}}},
    "stations": {"1": {"item_capacity": 9}, "2": {"item_capacity": 9}},
    "orders": {
        "1": {"lines": {"a": 1, "b": 1}, "parts": [{"station": "1", "skus": ["a"]}]},
        "2": {
            "lines": {"a": 2, "b": 1},
            "parts": [{"station": "1", "skus": ["a"]}, {"station": "2", "skus": ["b"]}],
            "packing": {"station": "1", "box": 0, "items_in_box": 1},
        },
        "3": {"lines": {"a": 1}, "parts": [{"station": "1", "skus": ["a"]}], "packing": {"station": "1"}},
    },
    "packing": {
        "section": {"boxes": 1, "packers": 1},
        "stations": [
            {
                "tasks": [
                    {"kind": "put", "order": "2", "tote": 1, "items": 2, "duration_s": 11},
                    {"kind": "pack", "order": "3", "tote": 2, "items": 1, "duration_s": 35},
                ]
            },
            {},
        ],
    },
}


def answer_of(
    rule: str, decides: str, change: Callable[[dict[str, Any]], object] = lambda state: None, **ask: Any
) -> Any:
    orders = {name: {**order} for name, order in STATE["orders"].items()}
    stations = [{**station} for station in STATE["packing"]["stations"]]
    state = {**STATE, "orders": orders, "packing": {**STATE["packing"], "stations": stations}}
    state["ask"] = {"decides": decides, **ask}
    change(state)
    return decide(state_from_dict(state), RuleChoice(rule)).decision


def test_a_state_written_by_hand() -> None:
    """Station 1 has no box left; of its tasks one is to pack."""
    assert answer_of("least-reserved", "packing") == {"packing": [{"order": "1", "station": "2"}]}
    assert answer_of("pack-first", "packing-task") == {"task": 1}
    assert answer_of("first-come", "packing-task", station="1") == {"task": 0}
    assert answer_of("first-come", "POA")["assignments"][0]["order"] == "1"


def test_a_rule_that_decides_more_is_asked_that_unless_told_otherwise() -> None:
    state = {**STATE, "ask": {}}
    assert decide(state_from_dict(state), RuleChoice("first-come")).decides is Role.POA


@cases(
    "change told",
    (lambda s: s.pop("packing"), r'orders.2.packing.station: names packing station "1"; the state has 0'),
    (lambda s: s["orders"]["1"].update(packing={"station": "3"}), 'packing station "3"; the state has 2'),
    (lambda s: s["orders"]["2"].update(packing={"station": "1"}), "expected a box for an order that is split"),
    (lambda s: s["orders"]["1"].update(packing={"station": "1", "box": 0}), "found a box that two orders have"),
    (lambda s: s["orders"]["3"].update(parts=[]), "found it for an order of which no part is assigned"),
    (lambda s: s["packing"]["stations"][0].update(orders=["3"]), "whose `packing` names it .* not packed: 2, 3"),
    (lambda s: s["packing"].update(stations=[]), "expected one packing station or more"),
    (
        lambda s: s["packing"]["stations"][1].update(tasks=[{"kind": "pack", "order": "3"}]),
        r'packing.stations\[1\].tasks: names order "3", which is not bound for it',
    ),
    (lambda s: s.update(version=1), "found `packing` in a state of version 1"),
    (lambda s: s["ask"].update(orders=["2"]), 'ask.orders: names order "2", which is bound for a packing station'),
)
def test_a_state_that_contradicts_itself_is_refused(change: Callable[[dict[str, Any]], object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        answer_of("least-reserved", "packing", change)


def test_nothing_to_do_is_said() -> None:
    with pytest.raises(InputError, match=r"ask.station: no packer is free for a task at packing station 2"):
        answer_of("shortest", "packing-task", station="2")
