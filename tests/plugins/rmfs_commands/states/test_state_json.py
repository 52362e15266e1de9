"""States as JSON: their format, their names, and the patches between them."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from cases import cases
from rmfs_commands.results.files import to_json
from rmfs_commands.states import read_state, state_from_dict, state_json, state_schema, state_to_dict
from rmfs_commands.states.names import Names
from rmfs_commands.states.patches import difference, patched
from rmfs_commands.states.state import (
    LayoutState,
    MotionState,
    RandomState,
    StationState,
)
from rmfs_core import InputError
from rmfs_core.motion import Motion
from rmfs_core.scenario.model import LayoutSection


def test_defaults_and_limits() -> None:
    assert MotionState().motion() == Motion()
    assert MotionState(top_speed_m_per_s=2.0).motion() == Motion(top_speed_m_per_s=2.0)
    assert RandomState(str((1 << 128) - 1), "0").has_uint32 == 0
    assert LayoutState(blocks=LayoutSection()).map is None
    assert StationState(order_capacity=1).item_capacity is None


def test_the_schema_takes_states_and_nothing_else(by_hand: dict[str, object], at_work: dict[str, object]) -> None:
    schema = state_schema()
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema)
    for good in (by_hand, at_work):
        assert validator.is_valid(good)
    for changed in (
        {"version": 3},
        {"pods": 5},
        {"weather": "fine"},
        {"stations": {"north": {"item_capacity": 0}}},
        {"ask": {"decides": "lunch"}},
        {"robots": {"r1": {"heading": 4}}},
    ):
        assert not validator.is_valid({**by_hand, **changed}), changed


def test_what_is_written_reads_back(by_hand: dict[str, Any], at_work: dict[str, Any]) -> None:
    asked = {"decides": "POA", "max_fetches": 0}
    drawn = {"random": {"state": str(2**128 - 1), "increment": "7"}, "backlog": [], "reserved": [12], "seed": 9}
    for content in (by_hand, at_work, at_work | drawn | {"ask": asked, "waiting": ["P2"], "empty_pods": [14]}):
        state = state_from_dict(content)
        written = json.loads(to_json(state_to_dict(state)))
        assert (state_from_dict(written), written["version"]) == (state, content["version"])
        assert state_to_dict(state_from_dict(written)) == written
        jsonschema.validate(written, state_schema())


def test_every_key_of_the_schema_says_what_it_means() -> None:
    def undocumented(part: dict[str, Any], path: str) -> list[str]:
        found = []
        for key, value in part.get("properties", {}).items():
            inner = value.get("additionalProperties") or value.get("items") or value
            found += [] if value.get("description") else [f"{path}.{key}"]
            found += undocumented(inner if isinstance(inner, dict) else {}, f"{path}.{key}")
        return found

    assert undocumented(state_schema(), "state") == []


def test_files_of_states(by_hand, write, tmp_path, monkeypatch) -> None:
    state = read_state(write(by_hand))
    assert state.orders["A"].lines == {"milk": 1, "tea": 1}
    assert (state.layout, state.robots, state.time_s, state.seed) == (None, None, None, 1)
    with pytest.raises(InputError, match="cannot be read"):
        read_state(tmp_path / "nowhere.json")
    monkeypatch.setattr(state_json, "MOST_BYTES", 1000)
    with pytest.raises(InputError, match=r"^/dev/zero: found more than 1,000 bytes; expected at most that many"):
        read_state("/dev/zero")


@cases(
    "path value place problem",
    (("format",), "rmfs-trace", "format", "expected 'rmfs-state', found 'rmfs-trace'"),
    (("version",), 3, "version", "expected version 1 or 2 of 'rmfs-state', found 3"),
    (("version",), True, "version", "expected version 1 or 2 of 'rmfs-state', found True"),
    (("orders", "A", "lines"), {}, "orders.A.lines", "expected one line or more"),
    (("orders", "A", "lines", "milk"), 0, "orders.A.lines", "quantities from 1 to 1,000,000,000"),
    (("orders", "A", "lines", "milk"), "2", "orders.A.lines.milk", "expected a whole number"),
    (("orders", "A", "line"), {"milk": 1}, "orders.A.line", "unknown key (did you mean `lines`?)"),
    (("pods", "P1", "contents", "milk"), -1, "pods.P1.contents", "numbers of items from 0 to"),
    (("pods", "P1", "cell"), -1, "pods.P1.cell", "a whole number from 0 to"),
    (("stations", "north"), {}, "stations.north", "either `item_capacity` or `order_capacity`"),
    (("stations", "north", "item_capacity"), 0, "stations.north.item_capacity", "a whole number from 1 to"),
    (("stations", "north", "requests"), [{"order": "A"}], "stations.north.requests[0].sku", "is missing"),
    (("stations", "north", "line"), "P1", "stations.north.line", "expected a list"),
    (("ask",), {"decides": "path"}, "ask.decides", "idle, repositioning, packing, packing-task or PP"),
    (("layout",), {"map": [".."], "blocks": {}}, "layout", "expected either `map` or `blocks`"),
    (("stations", "north", "order_capacity"), 2, "stations.north", "either `item_capacity` or `order_capacity`"),
    (("random",), {"state": str(1 << 128), "increment": "1"}, "random", "numbers below 2^128"),
    (("layout",), {}, "layout", "expected either `map` or `blocks`"),
    (("layout",), {"blocks": {"map_file": "x"}}, "layout", "expected no `map_file`"),
    (("robots",), {"r": {"heading": 4}}, "robots.r.heading", "expected 0, 1, 2 or 3"),
    (("orders", "A", "lines", "milk"), 10**30, "orders.A.lines", "quantities from 1 to"),
    (("orders", "A", "arrival_s"), float("nan"), "orders.A.arrival_s", "expected a finite number"),
    (("time_s",), 10**400, "time_s", "expected a number"),
    (("time_s",), 1e308, "time_s", "expected a"),
    (("random",), {"state": "-1", "increment": "1"}, "random", "decimal digits"),
    (("random",), {"state": "os.system", "increment": "1"}, "random", "decimal digits"),
    (("random",), {"state": "1", "increment": "1", "has_uint32": 2}, "random.has_uint32", "expected 0 or 1"),
    (("random",), {"state": "1", "increment": "1", "uinteger": 1 << 32}, "random.uinteger", "4,294,967,295"),
    (("orders", "A", "lines", "milk"), None, "orders.A.lines.milk", "expected a whole number, found null"),
)
def test_what_is_wrong_is_named(by_hand, path, value, place, problem) -> None:
    """The first mistake is an error with the path of its key, what was found and what would be right."""
    content = json.loads(json.dumps(by_hand))
    table = content
    for key in path[:-1]:
        table = table[key]
    table[path[-1]] = value
    with pytest.raises(InputError) as caught:
        state_from_dict(content, "s.json")
    assert caught.value.place == f"s.json, {place}"
    assert problem in caught.value.problem


def test_ids_and_numbers(by_hand: dict[str, Any]) -> None:
    assert state_from_dict({**by_hand, "seed": 10**19}).seed == 10**19
    found = names_of(by_hand)
    assert (found.pods, found.stations) == ({"P1": 0, "P2": 1}, {"north": 0})
    assert found.skus == {"milk": 0, "tea": 1, "jam": 2}
    assert names_of(by_hand | {"skus": ["jam", "tea", "milk", "rye"]}).skus == {"jam": 0, "tea": 1, "milk": 2, "rye": 3}
    orders = {"A": by_hand["orders"]["A"] | {"arrival_s": 9}, "B": by_hand["orders"]["B"], "C": {"lines": {"tea": 1}}}
    assert names_of(by_hand | {"orders": orders}).orders == {"B": 0, "C": 1, "A": 2}


@pytest.mark.parametrize("missing", ["format", "version", "pods", "stations", "orders"])
def test_what_must_be_there(by_hand: dict[str, Any], missing: str) -> None:
    del by_hand[missing]
    with pytest.raises(InputError, match=f"state, {missing}"):
        state_from_dict(by_hand)


@cases(
    "text problem",
    ("{", "line 1: this is no valid JSON"),
    ("[]", "expected a JSON object"),
    ('{"format": "rmfs-state", "format": "rmfs-state"}', "names 'format' twice"),
    ("[" * 100_000, "is nested too deeply to be a state"),
    ('"\ud800"', "expected UTF-8"),
)
def test_files_that_are_no_states(tmp_path: Path, text: str, problem: str) -> None:
    file = tmp_path / "state.json"
    file.write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(InputError, match=problem):
        read_state(file)


def names_of(content: dict[str, Any]) -> Names:
    return Names(state_from_dict(content, "state.json"), "state.json")


def test_names_that_are_not_listed_are_refused(by_hand: dict[str, Any]) -> None:
    found = names_of(by_hand)
    assert (found.pod("P2"), found.station("north"), found.order("B"), found.sku("jam")) == (1, 0, 1, 2)
    with pytest.raises(InputError) as caught:
        found.sku("mlk", "orders", "A", "lines", "mlk")
    assert "state.json" in str(caught.value)
    assert 'names SKU "mlk", which the state does not list (did you mean `milk`?)' in str(caught.value)
    for find, kind in ((found.pod, "pod"), (found.station, "station"), (found.order, "order")):
        with pytest.raises(InputError, match=f'names {kind} "nobody", which the state does not list'):
            find("nobody", "waiting", 0)


values = st.recursive(
    st.booleans() | st.integers() | st.text(max_size=3) | st.lists(st.integers(), max_size=3),
    lambda inner: st.dictionaries(st.text("abc", max_size=2), inner, max_size=4),
    max_leaves=8,
)
objects = st.dictionaries(st.text("abc", max_size=2), values, max_size=4)


@given(objects, objects)
def test_the_difference_leads_from_one_to_the_other(before: dict[str, Any], after: dict[str, Any]) -> None:
    copy = repr(before)
    assert patched(before, difference(before, after)) == after
    assert repr(before) == copy


@cases(
    "before patch after",
    # from RFC 7396, Appendix A
    ({"a": "b"}, {"a": "c"}, {"a": "c"}),
    ({"a": "b"}, {"b": "c"}, {"a": "b", "b": "c"}),
    ({"a": "b"}, {"a": None}, {}),
    ({"a": ["b"]}, {"a": "c"}, {"a": "c"}),
    ({"a": {"b": "c"}}, {"a": {"b": "d", "c": None}}, {"a": {"b": "d"}}),
    ({"e": None}, {"a": 1}, {"e": None, "a": 1}),
    ({}, {"a": {"bb": {"ccc": None}}}, {"a": {"bb": {}}}),
)
def test_the_standards_examples(before: dict[str, Any], patch: dict[str, Any], after: dict[str, Any]) -> None:
    assert patched(before, patch) == after


def test_nothing_changed_is_an_empty_patch() -> None:
    assert difference({"a": {"b": None}, "c": [1]}, {"a": {"b": None}, "c": [1]}) == {}
