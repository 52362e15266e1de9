"""States as JSON: what is written reads back, and what is wrong is named."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rmfs_commands.states import State, read_state, state_from_dict, state_json, state_schema, state_to_dict
from rmfs_commands.states.state import (
    AskState,
    LayoutState,
    OrderState,
    PartState,
    PodState,
    RandomState,
    RequestState,
    RobotState,
    StationState,
)
from rmfs_core import InputError
from rmfs_core.results.files import to_json

names = st.text(min_size=1, max_size=4)
cells = st.integers(0, 2000)
numbers = st.integers(1, 20)
named = st.lists(names, max_size=3).map(tuple)


def maybe(values: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """A value, or None: left out."""
    return st.none() | values


pods = st.builds(
    PodState,
    contents=st.dictionaries(names, maybe(st.integers(0, 9)), max_size=3),
    cell=maybe(cells),
    home=maybe(cells),
    bound_for=maybe(named),
)
requests = st.builds(RequestState, order=names, sku=names, pod=maybe(names), id=maybe(st.integers(0, 99)))
stations = st.builds(
    StationState,
    item_capacity=numbers,
    queue_length=maybe(numbers),
    requests=st.lists(requests, max_size=3).map(tuple),
    inbound=maybe(named),
    line=named,
    queue_room=maybe(st.integers(0, 13)),
)
orders = st.builds(
    OrderState,
    lines=st.dictionaries(names, numbers, min_size=1, max_size=3),
    arrival_s=st.floats(0, 1e6),
    parts=maybe(st.lists(st.builds(PartState, station=names, skus=named, period=numbers), max_size=2).map(tuple)),
)
robots = st.builds(RobotState, cell=maybe(cells), heading=st.integers(0, 3), task=maybe(names))
states = st.builds(
    State,
    pods=st.dictionaries(names, pods, max_size=3),
    stations=st.dictionaries(names, stations, max_size=3),
    orders=st.dictionaries(names, orders, max_size=3),
    time_s=maybe(st.floats(0, 1e6)),
    skus=maybe(named),
    layout=maybe(st.builds(LayoutState, map=st.lists(st.text("#.>O", max_size=4), max_size=3).map(tuple))),
    robots=maybe(st.dictionaries(names, robots, max_size=3)),
    waiting=maybe(named),
    empty_pods=st.lists(cells, max_size=3).map(tuple),
    reserved=st.lists(cells, max_size=3).map(tuple),
    backlog=maybe(named),
    ask=st.builds(AskState, decides=maybe(st.sampled_from(["POA", "PR"])), max_fetches=maybe(st.integers(0, 9))),
    seed=st.integers(0, 9),
    random=maybe(st.builds(RandomState, state=st.integers(0, 2**128 - 1).map(str), increment=st.just("7"))),
)


@given(states)
def test_what_is_written_reads_back(state: State) -> None:
    """State to JSON text to state is the same state, and JSON to state to JSON the same JSON."""
    written = json.loads(to_json(state_to_dict(state)))
    assert state_from_dict(written) == state
    assert state_to_dict(state_from_dict(written)) == written
    jsonschema.validate(written, state_schema())


def test_the_schema_is_one() -> None:
    """The published schema is valid JSON Schema, and every key in it says what it means."""
    schema = state_schema()
    jsonschema.Draft202012Validator.check_schema(schema)

    def undocumented(part: dict[str, Any], path: str) -> list[str]:
        found = []
        for key, value in part.get("properties", {}).items():
            inner = value.get("additionalProperties") or value.get("items") or value
            found += [] if value.get("description") else [f"{path}.{key}"]
            found += undocumented(inner if isinstance(inner, dict) else {}, f"{path}.{key}")
        return found

    assert undocumented(schema, "state") == []


def test_a_file_by_hand(by_hand: dict[str, Any], write: Callable[[Any], Path]) -> None:
    """Pods, stations and orders are enough; everything else has a default."""
    jsonschema.validate(by_hand, state_schema())
    state = read_state(write(by_hand))
    assert state.orders["A"].lines == {"milk": 1, "tea": 1}
    assert (state.layout, state.robots, state.time_s, state.seed) == (None, None, None, 1)


@pytest.mark.parametrize(
    ("path", "value", "place", "problem"),
    [
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
        (("ask",), {"decides": "PP"}, "ask.decides", "PR, TA, ROA, RPS, ROA+RPS, activation, idle or repositioning"),
        (("layout",), {}, "layout", "expected either `map` or `blocks`"),
        (("layout",), {"blocks": {"map_file": "x"}}, "layout", "expected no `map_file`"),
        (("robots",), {"r": {"heading": 4}}, "robots.r.heading", "expected 0, 1, 2 or 3"),
        (("orders", "A", "lines", "milk"), 10**30, "orders.A.lines", "quantities from 1 to"),
        (("orders", "A", "arrival_s"), float("nan"), "orders.A.arrival_s", "expected a finite number"),
        (("random",), {"state": "-1", "increment": "1"}, "random", "decimal digits"),
        (("random",), {"state": "os.system", "increment": "1"}, "random", "decimal digits"),
        (("random",), {"state": "1", "increment": "1", "has_uint32": 2}, "random.has_uint32", "expected 0 or 1"),
        (("random",), {"state": "1", "increment": "1", "uinteger": 1 << 32}, "random.uinteger", "4,294,967,295"),
        (("orders", "A", "lines", "milk"), None, "orders.A.lines.milk", "expected a whole number, found null"),
    ],
)
def test_what_is_wrong_is_named(
    by_hand: dict[str, Any], path: tuple[str, ...], value: Any, place: str, problem: str
) -> None:
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


@pytest.mark.parametrize("time_s", [10**400, 1e308, float("inf")])
def test_numbers_out_of_all_bounds(by_hand: dict[str, Any], time_s: float) -> None:
    """Numbers that no float can hold, or no clock, are refused as well."""
    with pytest.raises(InputError, match=r"time_s: expected a (finite )?number"):
        state_from_dict({**by_hand, "time_s": time_s})


def test_a_seed_is_any_that_a_scenario_may_have(by_hand: dict[str, Any]) -> None:
    """It is no number of things."""
    assert state_from_dict({**by_hand, "seed": 10**19}).seed == 10**19


@pytest.mark.parametrize("missing", ["format", "version", "pods", "stations", "orders"])
def test_what_must_be_there(by_hand: dict[str, Any], missing: str) -> None:
    """A state says its format and version, and has pods, stations and orders."""
    del by_hand[missing]
    with pytest.raises(InputError, match=f"state, {missing}"):
        state_from_dict(by_hand)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("{", "line 1: this is no valid JSON"),
        ("[]", "expected a JSON object"),
        ('{"format": "rmfs-state", "format": "rmfs-state"}', "names 'format' twice"),
        ("[" * 100_000, "is nested too deeply to be a state"),
        ('"\ud800"', "expected UTF-8"),
    ],
)
def test_files_that_are_no_states(tmp_path: Path, text: str, problem: str) -> None:
    """What is no JSON, or not one object with each key once, is refused with the file's name."""
    file = tmp_path / "state.json"
    file.write_bytes(text.encode("utf-8", "surrogatepass"))
    with pytest.raises(InputError, match=problem):
        read_state(file)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    """A missing file is one sentence."""
    with pytest.raises(InputError, match="cannot be read"):
        read_state(tmp_path / "nowhere.json")


def test_a_file_without_end_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A device is read as far as a file may go, and no farther."""
    monkeypatch.setattr(state_json, "MOST_BYTES", 1000)
    with pytest.raises(InputError, match=r"^/dev/zero: found more than 1,000 bytes; expected at most that many"):
        read_state("/dev/zero")
