"""Requests and answers, whatever they come by."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rmfs_commands.serve.service import SMALL, Service
from rmfs_commands.states import decide, state_from_dict
from rmfs_commands.states.patches import difference
from rmfs_commands.states.state import DECIDING
from rmfs_core.errors import InputError
from rmfs_core.results.files import to_json
from rmfs_core.roles import Role
from rmfs_core.scenario import RuleChoice

Answer = Callable[..., tuple[int, dict[str, Any]]]


@pytest.fixture(scope="module")
def service() -> Service:
    """Return a service with one rule."""
    return Service.of(["first-come"])


def test_a_state_is_a_request(service: Service, state: dict[str, Any], answered: Answer) -> None:
    """A whole state on its own gets the decision that `rmfs decide` prints, and so does one that is wrapped."""
    expected = json.loads(to_json(decide(state_from_dict(state), RuleChoice("first-come")).to_dict()))
    assert answered(service, state) == answered(service, {"state": state}) == (200, expected)


@pytest.mark.parametrize(
    ("request_", "status", "place", "detail"),
    [
        (b"", 400, "request, line 1", "no valid JSON"),
        (b'{"a": 1, "a": 2}', 400, "request", "names 'a' twice"),
        (b"\xff", 400, "request", "UTF-8"),
        (b"[" * 100_000, 400, "request", ""),
        ([], 422, "request", "expected a JSON object, found []"),
        (None, 422, "request", "expected a JSON object, found"),
        ({}, 422, "state, format", "no key `format`"),
        ({"state": {}, "stat": 1}, 422, "request, stat", "did you mean `state`"),
        ({"rule": "first-come"}, 422, "request", "expected either `state` or `change`"),
        ({"change": {}, "warehouse": "w"}, 422, "request", "expected `warehouse` and `base` with `change`"),
        ({"state": {}, "base": "x"}, 422, "request", "found `base` with a whole state"),
        ({"change": [], "warehouse": "w", "base": ""}, 422, "request, change", "expected a table"),
        ({"state": {}, "rule": "first"}, 422, "request, rule", "did you mean `first-come`"),
        ({"change": {}, "warehouse": "w", "base": "x"}, 409, "request, warehouse", 'no state of "w" is kept'),
    ],
)
def test_what_is_wrong_with_a_request(
    service: Service, answered: Answer, request_: Any, status: int, place: str, detail: str
) -> None:
    """The status says whose fault it is, the problem what and where."""
    got, told = answered(service, request_)
    assert (got, told["status"], told["place"]) == (status, status, place)
    assert detail in told["detail"]


def test_a_bad_state_names_the_key(service: Service, state: dict[str, Any], answered: Answer) -> None:
    """Where in the state something is wrong, in a change, too."""
    state["orders"]["A"]["lines"]["milk"] = 0
    status, told = answered(service, state)
    assert (status, told["place"]) == (422, "state, orders.A.lines")
    state["orders"]["A"]["lines"] = {"beer": 1}
    state["stations"]["north"]["inbound"] = ["P9"]
    assert answered(service, state)[1]["place"] == "state, stations.north.inbound[0]"


def test_a_problem_is_a_sentence(service: Service, state: dict[str, Any], answered: Answer) -> None:
    """However long what is wrong is; its end is told, too."""
    status, told = answered(service, state | {"format": "x" * 100_000})
    assert status == 422
    assert len(told["detail"]) < 1_300
    assert told["detail"].startswith("state, format: expected 'rmfs-state', found 'xxx")


def test_several_rules(state: dict[str, Any], answered: Answer) -> None:
    """A request says which rule it asks; they share the states that are kept."""
    service = Service.of(["first-come", '{ rule = "integrated", effort = 5 }'])
    assert answered(service, state)[1]["detail"] == "request, rule: is missing; expected first-come or integrated"
    status, told = answered(service, {"state": state, "rule": "integrated", "warehouse": "w"})
    assert (status, told["decides"], told["warehouse"]) == (200, "POA+PPS", "w")
    change = {"change": {}, "rule": "first-come", "warehouse": "w", "base": told["revision"]}
    assert answered(service, change)[1]["decides"] == "POA"


def test_a_change_is_enough(service: Service, state: dict[str, Any], answered: Answer) -> None:
    """The decision is that of the whole state; a request that comes twice is answered twice; an old base is not."""
    _, first = answered(service, {"warehouse": "w", "state": state})
    change = {"orders": {"A": None, "C": {"lines": {"tea": 1}}}, "time_s": 7}
    request = {"warehouse": "w", "base": first["revision"], "change": change}
    status, second = answered(service, request)
    assert status == 200 and second["revision"] != first["revision"]
    state["orders"] = {"B": state["orders"]["B"], "C": {"lines": {"tea": 1}}}
    _, whole = answered(service, state | {"time_s": 7})
    assert {**second, "warehouse": None, "revision": None} == {**whole, "warehouse": None, "revision": None}
    assert answered(service, request) == (200, second)
    status, told = answered(service, request | {"change": {}})
    assert (status, told["place"]) == (409, "request, base")
    assert f'the last state is "{second["revision"]}"' in told["detail"]


def test_what_gets_no_decision_is_not_kept(service: Service, state: dict[str, Any], answered: Answer) -> None:
    """After a change that was wrong, another one may start from the same state."""
    _, first = answered(service, {"warehouse": "w", "state": state})
    wrong = {"warehouse": "w", "base": first["revision"], "change": {"pods": None}}
    assert answered(service, wrong) == (
        422,
        {
            "title": "Unprocessable Entity",
            "status": 422,
            "detail": "state, pods: this part is missing",
            "place": "state, pods",
        },
    )
    assert answered(service, wrong | {"change": {}})[0] == 200


amounts = st.integers(1, 4)
skus = st.sampled_from(["milk", "tea", "jam"])
orders = st.dictionaries(
    st.sampled_from("ABCDE"),
    st.builds(
        lambda lines, due: {"lines": lines} | ({} if due is None else {"due_s": due}),
        st.dictionaries(skus, amounts, min_size=1),
        st.none() | st.integers(0, 900),
    ),
    max_size=5,
)
pods = st.fixed_dictionaries(
    {name: st.dictionaries(skus, amounts).map(lambda c: {"contents": c}) for name in ("P", "Q")}
)
stations = st.fixed_dictionaries({"north": st.builds(lambda n: {"item_capacity": n}, amounts)})
states = st.builds(
    lambda orders, pods, stations, time_s: {
        "format": "rmfs-state",
        "version": 2,
        "skus": ["milk", "tea", "jam"],
        "orders": orders,
        "pods": pods,
        "stations": stations,
        "time_s": time_s,
    },
    *(orders, pods, stations, st.integers(0, 100)),
)


def new_last(before: Any, after: Any) -> Any:
    """Return an object in which what was there before comes first, as in a state after a change."""
    if not isinstance(before, dict) or not isinstance(after, dict):
        return after
    return {name: new_last(before.get(name), after[name]) for name in {**before, **after} if name in after}


@settings(max_examples=40)
@given(st.lists(states, min_size=2, max_size=4))
def test_changes_lead_to_the_whole_state(found: list[dict[str, Any]]) -> None:
    """Whatever changes, the decision after a change is that of the whole state: same bytes but for the revision."""
    service = Service.of(["first-come"])
    first = service.answer(json.dumps({"warehouse": "w", "state": found[0]}).encode())
    revision, before = json.loads(first.content)["revision"], found[0]
    for after in found[1:]:
        change = {"warehouse": "w", "base": revision, "change": difference(before, after)}
        told = json.loads(service.answer(json.dumps(change).encode()).content)
        revision = told.pop("revision")
        assert told.pop("warehouse") == "w"
        before = new_last(before, after)  # the order in which a state lists things breaks ties
        assert told == json.loads(service.answer(json.dumps(before).encode()).content)


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3),
    max_leaves=8,
)


@settings(max_examples=60)
@given(st.binary(max_size=60) | json_values.map(lambda value: json.dumps(value).encode()))
def test_any_bytes_get_a_status(content: bytes) -> None:
    """No request of any kind is more than a refusal."""
    reply = Service.of(["first-come"]).answer(content)
    assert reply.status in (400, 422)
    assert json.loads(reply.content)["status"] == reply.status


paths = st.sampled_from(
    [
        *(
            ("orders",),
            ("orders", "A"),
            ("orders", "A", "lines"),
            ("pods",),
            ("pods", "P1", "contents"),
            ("pods", "P1"),
        ),
        ("stations", "north"),
        ("stations", "north", "inbound"),
        ("time_s",),
        ("ask",),
        ("layout",),
        ("random",),
        ("seed",),
    ]
)


@settings(max_examples=80)
@given(paths, json_values)
def test_any_value_anywhere_gets_a_status(path: tuple[str, ...], value: Any) -> None:
    """A state with anything in place of a part of it is decided or refused, and the next one is answered."""
    service = Service.of(["first-come"])
    state: dict[str, Any] = json.loads(json.dumps(SMALL)) | {"orders": {"A": {"lines": {"a": 1}}}}
    state["pods"] = {"P1": {"contents": {"a": 1}, "cell": 12}}
    state["stations"] = {"north": {"item_capacity": 3, "inbound": []}}
    del state["robots"], state["waiting"]
    good = json.dumps({"warehouse": "w", "state": state}).encode()
    base = json.loads(service.answer(good).content)["revision"]
    patch: Any = value
    for name in reversed(path):
        patch = {name: patch}
    changed = service.answer(json.dumps({"warehouse": "w", "base": base, "change": patch}).encode())
    assert changed.status in (200, 422), changed
    assert service.answer(good).status == 200


def test_a_rule_at_fault(trouble: str, state: dict[str, Any], answered: Answer) -> None:
    """A rule that raises is told of as in a run; the next request is answered."""
    service = Service.of([trouble])
    status, told = answered(service, state | {"orders": {"raise": {"lines": {"jam": 1}}}})
    assert status == 500
    assert "assign_orders, at 0.000 s: raised ZeroDivisionError: nothing to divide" in told["detail"]
    assert answered(service, state)[0] == 200


def test_half_a_surrogate_comes_back_as_it_came(service: Service, state: dict[str, Any], answered: Answer) -> None:
    """JSON may name what is no character."""
    state["orders"] = {"\ud800": {"lines": {"jam": 1}}}
    assert answered(service, state)[1]["assignments"][0]["order"] == "\ud800"


@pytest.mark.parametrize(
    ("rules", "settings", "problem"),
    [
        (["firstcome"], [], r"^--rule firstcome: there is no rule"),
        (["integrated"], ["gap=-1"], r"^--set gap=-1: "),
        (["first-come", "integrated"], ["effort=1"], r"^--set effort=1: found 2 rules; expected one, or parameters in"),
        (["first-come", "first-come"], [], r"^--rule first-come: found this rule twice"),
        (["./mine.py:Mine"], [], r"--no-inline-rules refuses"),
        (["sipp"], [], r"^--rule sipp: .* decides PP; expected a rule for"),
    ],
)
def test_a_rule_that_cannot_be_had(rules: list[str], settings: list[str], problem: str) -> None:
    """One sentence, with what was typed."""
    with pytest.raises(InputError, match=problem):
        Service.of(rules, settings, allow_inline=False)


@pytest.mark.parametrize(
    ("rule", "role"),
    [
        ("first-come", Role.POA),
        ("nearest-pod", Role.PPS),
        ("pod-index", Role.POA_PPS),
        ("nearest", Role.PR),
        ("assignment", Role.TA),
    ],
)
def test_the_small_state_has_something_to_decide(rule: str, role: Role) -> None:
    """Of each kind: so that warming up does something."""
    given = state_from_dict({**SMALL, "ask": {"decides": role.label, "pod": "3"}})
    (decided, *_) = decide(given, RuleChoice(rule)).decision.values()
    assert role in DECIDING
    assert decided


def test_warming_up_asks_a_rule(
    trouble: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever it does then: a rule that fails is told of when it is asked in earnest."""
    asked: list[Role] = []
    service = Service.of(["random"])
    monkeypatch.setattr("rmfs_commands.states.Decider.decide", lambda _self, state, *_: asked.append(state.ask.role))
    for _ in service.warm_up():
        pass
    assert asked == [*DECIDING]
    monkeypatch.undo()
    for _ in Service.of(["random"]).warm_up():
        pass
