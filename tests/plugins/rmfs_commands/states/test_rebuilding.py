"""The warehouse that a state describes: as plain data, and back; and states as JSON."""

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
from rmfs_commands.states.patches import difference, patched
from rmfs_commands.states.rebuilding import LacksError, OpenState, open_state
from rmfs_core import InputError


def opened_from(content: dict[str, Any]) -> OpenState:
    return open_state(state_from_dict(content))


def test_without_a_layout_places_cannot_be_asked_for(by_hand: dict[str, Any]) -> None:
    view = opened_from(by_hand).view
    for ask in (
        lambda: view.travel,
        lambda: view.free_storage_locations,
        lambda: view.blocked_locations,
        lambda: view.home(view.pods[0]),
    ):
        with pytest.raises(LacksError, match=r"driving times|storage locations"):
            ask()


GONE = object()


def changed(content: dict[str, Any], path: str, value: object) -> dict[str, Any]:
    """Return a copy of a state with the value at a path changed, or taken out."""
    copy = table = json.loads(json.dumps(content))
    *within, last = path.split(".")
    for key in within:
        table = table[key]
    table[last] = value
    if value is GONE:
        del table[last]
    return copy


TEA, MILK, JAM = ({"order": order, "sku": sku} for order, sku in (("A", "tea"), ("A", "milk"), ("B", "jam")))


@cases(
    "path value place problem",
    ("stations", {}, "stations", "found none"),
    ("skus", ["milk", "milk"], "skus", "a name twice"),
    ("skus", ["milk", "jam"], "orders.A.lines.tea", 'names SKU "tea", which the state does not list'),
    ("time_s", 3, "time_s", "an order arrives at 30"),
    ("backlog", ["C"], "backlog[0]", 'names order "C"'),
    ("backlog", ["A"], "backlog[0]", "has no open line left"),
    ("waiting", ["P3"], "waiting[0]", 'names pod "P3", which the state does not list'),
    ("waiting", [], "waiting", "expected the stored pods that are inbound and no robot's task: P2"),
    ("empty_pods", [13], "pods.P2.cell", "found 13, where there is another pod already"),
    ("pods.P2.cell", 0, "pods.P2.cell", "no storage location"),
    ("pods.P2.cell", GONE, "pods.P2.cell", "is missing"),
    ("pods.P1.cell", 12, "pods.P1.cell", "stands in a station's line"),
    ("pods.P1.bound_for", [], "pods.P1.bound_for", "expected the stations that have the pod"),
    ("pods.P1.bound_for", ["south"], "pods.P1.bound_for", 'names station "south"'),
    ("robots.r2.task", "P1", "robots.r2.task", "another robot's task"),
    ("robots.r2.task", "P3", "robots.r2.task", 'names pod "P3"'),
    ("robots.r2.cell", 999, "robots.r2.cell", "expected a cell of the layout, 0 to 76"),
    ("robots.r2.cell", GONE, "robots.r2.cell", "expected a cell of the layout"),
    ("robots.r2.cell", 62, "robots.r2.cell", "expected a cell of the layout, 0 to 76, no wall"),
    ("reserved", [14, 14], "reserved", "found 14; expected a storage location that is not named before"),
    ("chargers_down", [3], "chargers_down", "found 3; expected a charger of the layout that is not named before"),
    ("pods.P1.home", 0, "pods.P1.home", "found 0; expected a storage location"),
    ("pods.P1.capacity", 2, "pods.P1.capacity", "found 2; expected at least 4, what the pod holds"),
    ("stations.north.queue_room", 99, "stations.north.queue_room", "found 99; expected 0 to 3, what the line leaves"),
    ("stations.north.in_hand", TEA, "stations.north.in_hand", "names no item picked here"),
    ("stations.north.inbound", ["P2"], "stations.north.line[0]", "which `inbound` does not"),
    ("stations.north.inbound", ["P1", "P1"], "stations.north.inbound[1]", "twice"),
    ("stations.north.line", ["P1", "P1"], "stations.north.line", "stands in a line already"),
    ("stations.north.queue_length", 4, "stations.north.queue_length", "the layout has 3"),
    ("stations.north.requests", [TEA] * 2, "stations.north.requests[1]", "requests more"),
    (
        "stations.north.requests",
        [TEA | {"pod": "P2"}],
        "stations.north.requests[0].pod",
        "not inbound here with an item",
    ),
    ("stations.north.requests", [TEA | {"id": 1}, MILK | {"id": 1}], "stations.north.requests", "the id 1 after 1"),
    ("stations.north.requests", [TEA, JAM, JAM], "stations.north.item_capacity", "found 3; expected at least 4"),
    ("orders.A.parts", [{"station": "north", "skus": ["jam"]}], "orders.A.parts[0].skus", "no line of the order"),
    ("stations.south", {"item_capacity": 1}, "stations", "found 2; expected 1, as the layout has them"),
    ("layout", {"map": ["#"]}, "layout", "no picking station"),
    ("layout", {"map": ["?"]}, "layout.map, row 1, column 1", "unknown sign"),
    ("layout", GONE, "robots.r1.cell", "found a cell, but the state has no layout"),
)
def test_contradictions(at_work: dict[str, Any], path: str, value: object, place: str, problem: str) -> None:
    at_work["version"], at_work["stations"]["north"]["item_capacity"] = 2, 3
    with pytest.raises(InputError) as caught:
        opened_from(changed(at_work, path, value))
    assert caught.value.place == f"state, {place}"
    assert problem in caught.value.problem


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


def test_files_of_states(by_hand, tmp_path, monkeypatch) -> None:
    (tmp_path / "state.json").write_text(to_json(by_hand))
    state = read_state(tmp_path / "state.json")
    assert state.orders["A"].lines == {"milk": 1, "tea": 1}
    assert (state.layout, state.robots, state.time_s, state.seed) == (None, None, None, 1)
    with pytest.raises(InputError, match="cannot be read"):
        read_state(tmp_path / "nowhere.json")
    monkeypatch.setattr(state_json, "MOST_BYTES", 1000)
    with pytest.raises(InputError, match=r"^/dev/zero: found more than 1,000 bytes; expected at most that many"):
        read_state("/dev/zero")


@cases(
    "path value place problem",
    ("format", GONE, "format", "no key `format`"),
    ("version", GONE, "version", "expected version 1 or 2"),
    *((key, GONE, key, "this part is missing") for key in ("pods", "stations", "orders")),
    ("format", "rmfs-trace", "format", "expected 'rmfs-state', found 'rmfs-trace'"),
    ("version", 3, "version", "expected version 1 or 2 of 'rmfs-state', found 3"),
    ("version", True, "version", "expected version 1 or 2 of 'rmfs-state', found True"),
    ("orders.A.lines", {}, "orders.A.lines", "expected one line or more"),
    ("orders.A.lines.milk", 0, "orders.A.lines", "quantities from 1 to 1,000,000,000"),
    ("orders.A.lines.milk", 10**30, "orders.A.lines", "quantities from 1 to"),
    ("orders.A.lines.milk", "2", "orders.A.lines.milk", "expected a whole number"),
    ("orders.A.lines.milk", None, "orders.A.lines.milk", "expected a whole number, found null"),
    ("orders.A.line", {"milk": 1}, "orders.A.line", "unknown key (did you mean `lines`?)"),
    ("orders.A.arrival_s", float("nan"), "orders.A.arrival_s", "expected a finite number"),
    ("pods.P1.contents.milk", -1, "pods.P1.contents", "numbers of items from 0 to"),
    ("pods.P1.cell", -1, "pods.P1.cell", "a whole number from 0 to"),
    ("stations.north", {}, "stations.north", "either `item_capacity` or `order_capacity`"),
    ("stations.north.order_capacity", 2, "stations.north", "either `item_capacity` or `order_capacity`"),
    ("stations.north.item_capacity", 0, "stations.north.item_capacity", "a whole number from 1 to"),
    ("stations.north.requests", [{"order": "A"}], "stations.north.requests[0].sku", "is missing"),
    ("stations.north.line", "P1", "stations.north.line", "expected a list"),
    ("ask", {"decides": "path"}, "ask.decides", " or PP, found path"),
    ("layout", {"map": [".."], "blocks": {}}, "layout", "expected either `map` or `blocks`"),
    ("layout", {}, "layout", "expected either `map` or `blocks`"),
    ("layout", {"blocks": {"map_file": "x"}}, "layout", "expected no `map_file`"),
    ("robots", {"r": {"heading": 4}}, "robots.r.heading", "expected 0, 1, 2 or 3"),
    ("time_s", 10**400, "time_s", "expected a number"),
    ("time_s", 1e308, "time_s", "expected a"),
    ("random", {"state": str(1 << 128), "increment": "1"}, "random", "numbers below 2^128"),
    ("random", {"state": "-1", "increment": "1"}, "random", "decimal digits"),
    ("random", {"state": "1", "increment": "1", "has_uint32": 2}, "random.has_uint32", "expected 0 or 1"),
    ("random", {"state": "1", "increment": "1", "uinteger": 1 << 32}, "random.uinteger", "4,294,967,295"),
)
def test_what_is_wrong_is_named(by_hand, path, value, place, problem) -> None:
    with pytest.raises(InputError) as caught:
        state_from_dict(changed(by_hand, path, value), "s.json")
    assert caught.value.place == f"s.json, {place}"
    assert problem in caught.value.problem


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
    assert difference(after, after) == {}
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
