"""Changes of a kept state: answered as the whole state is, byte for byte, and at the price of what changed."""

import json
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rmfs_commands.serve.service import Service
from rmfs_commands.states.patches import patched

RULES = ("pod-match", "workload", "first-come", "split-over-time", "integrated", "all")
SKUS, WANTED = ("a", "b", "c", "d"), {"lines": {"a": 1}}
HALL: dict[str, Any] = {
    "format": "rmfs-state",
    "version": 2,
    "pods": {str(n): {"contents": {SKUS[n - 1]: 9, "a": 3}} for n in (1, 2, 3, 4)},
    "stations": {"1": {"item_capacity": 3, "inbound": ["1"]}, "2": {"order_capacity": 1}},
    "orders": {"1": {"lines": {"a": 2, "d": 1}}, "2": {"lines": {"b": 1, "c": 1}}, "3": WANTED},
}
one_sku, few = st.sampled_from(SKUS), st.integers(0, 3)
names = st.sampled_from("4567")


def some(**keys: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.fixed_dictionaries({}, optional=keys)


def of(**keys: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    return st.fixed_dictionaries(keys)


parts = st.sampled_from(([], [{"station": "2", "skus": ["a"]}], [{"station": "1", "skus": ["a"], "period": 3}]))
wanted = of(lines=st.dictionaries(one_sku, st.integers(1, 3), max_size=2).map(lambda more: {"a": 1, **more}))
orders = st.tuples(
    wanted,
    some(arrival_s=st.integers(0, 9), due_s=st.just(50), priority=few, waits_for_stock=st.booleans(), parts=parts),
).map(lambda both: both[0] | both[1])
held = st.dictionaries(one_sku, few, max_size=2)
of_order_3 = st.sampled_from(([], [{"order": "3", "sku": "a"}], [{"order": "1", "sku": "d"}]))
inbound = st.sampled_from(([], ["1"], ["2", "1"]))
changes = some(
    orders=st.dictionaries(names, st.none() | orders, min_size=1, max_size=3),
    pods=st.dictionaries(names, of(contents=held), max_size=2),
    stations=some(**{"1": some(requests=of_order_3, inbound=inbound, item_capacity=st.sampled_from((3, 30)))}),
    time_s=st.integers(9, 20),
    backlog=st.none() | st.sampled_from((["2"], ["2", "4"])),
    skus=st.none() | st.just(["d", *SKUS[:3]]),
    sizes=st.none() | st.just({"a": 2}),
)
nulls = st.sampled_from(("motion", "reserved", "empty_pods", "seed", "ask", "chargers_down"))


@pytest.fixture(scope="module")
def kept() -> Service:
    return Service.of(RULES)


def answer(asked: Service, **request: Any) -> tuple[int, bytes]:
    """Return status and content of an answer, without the state's revision."""
    reply = asked.answer(json.dumps(request).encode())
    told = json.loads(reply.content)
    content = reply.content
    for key in ("warehouse", "revision"):
        content = content.replace(f',"{key}":"{told.get(key)}"'.encode(), b"")
    return reply.status, content


FULL = {"orders": dict.fromkeys("456", WANTED)}
ANOTHER, ALL = {"orders": {"4": None, "7": WANTED}}, {"stations": {"1": {"item_capacity": 30}}}
WAITS: dict[str, Any] = {"orders": {"4": WANTED | {"waits_for_stock": True}}}


@example(
    steps=[(FULL, "first-come"), (ANOTHER, "first-come"), (ALL, "first-come")], null="seed"
)  # orders have other ids then
@example(steps=[(WAITS, "first-come"), ({"backlog": ["2", "4"]}, "first-come")], null="motion")
@settings(max_examples=25)
@given(steps=st.lists(st.tuples(changes, st.sampled_from(RULES)), min_size=4, max_size=12), null=nulls)
def test_a_change_is_answered_as_the_whole_state(
    kept: Service, steps: list[tuple[dict[str, Any], str]], null: str
) -> None:
    state = HALL
    reply = kept.answer(json.dumps({"warehouse": "w", "state": state, "rule": "pod-match"}).encode())
    base = json.loads(reply.content)["revision"]
    for change, rule in steps:
        content = json.dumps({"warehouse": "w", "base": base, "change": change, "rule": rule}).encode()
        whole = patched(state, change)
        expected = answer(kept, state=whole, rule=rule)
        assert answer(kept, warehouse="w", base=base, change=change, rule=rule) == expected
        refused = answer(kept, state=whole | {null: None}, rule=rule)
        assert refused == answer(kept, warehouse="w", state=whole | {null: None}, rule=rule)
        assert refused[0] == 422
        if expected[0] == 200:
            base, state = json.loads(kept.answer(content).content)["revision"], whole
