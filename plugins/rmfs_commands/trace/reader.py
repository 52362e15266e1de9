"""Reading a trace back: the format is described in `rmfs_commands.trace.writer`."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from attrs import frozen

from rmfs_commands.trace.json_lines import read_json_lines
from rmfs_commands.trace.writer import EVENTS, FILE, FORMAT, NOT_TRACED, VERSION, header
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.errors import InputError
from rmfs_core.events import Event
from rmfs_core.motion import Motion
from rmfs_core.roles import Role
from rmfs_core.wording import one_line, shown_short
from rmfs_core.world import BundleData, Instance, Layout, OrderData, PodData, StationCells, check_size

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo

TICK_S = 1 / TICKS_PER_S
STATUSES = ("complete", "horizon", "partial", "failed")
MOST = 10**15
"""The largest whole number of an event: ticks of 31,000 years, and sums of them still fit into 64 bits."""


@frozen(eq=False)
class Trace:
    """A whole trace.

    Parameters
    ----------
    scenario
        The resolved scenario as tables.
    layout, motion, instance
        Inputs of the run.
    pods
        For each pod: ``cell``, ``robot`` (the id, or None), ``bound_for``.
    robots
        For each robot: ``cell``, ``heading``.
    stations
        For each station: ``name``, ``capacity``, ``counts_orders``, ``bundle_capacity`` where bundles are stored.
    blocked
        Storage locations that hold an empty pod.
    events
        In the order in which they happened; ``wall_s`` of decisions is 0.
    tick, status
        When the run ended, and how.
    versions
        Of the code that drew layout, orders and locations; empty where the header does not say.
    map_text
        Text of the scenario's map file; None where there is none.
    state
        State that the run begins in: ``file``, ``sha256``, ``tick``, ``lines``, ``content``; None: it begins at time 0.
    apart
        Whether its PP rule keeps robots apart.
    floor
        Of a real day: counts of facts, and when the floor first corrected what was known; None: a simulated run.
    """

    scenario: Mapping[str, Any]
    layout: Layout
    motion: Motion
    instance: Instance
    pods: tuple[Mapping[str, Any], ...]
    robots: tuple[Mapping[str, Any], ...]
    stations: tuple[Mapping[str, Any], ...]
    blocked: tuple[int, ...]
    events: tuple[Event, ...]
    tick: int
    status: str
    versions: Mapping[str, str] = attrs.field(factory=dict)
    map_text: str | None = None
    state: Mapping[str, Any] | None = None
    apart: bool = True
    floor: Mapping[str, Any] | None = None

    @property
    def began(self) -> int:
        """Tick at which the run begins: that of its state, or 0."""
        return 0 if self.state is None else int(self.state["tick"])


class TraceStream:
    """A trace file whose events are read one at a time, so that a large one needs little memory.

    Parameters
    ----------
    path
        The file. Its header is read at once.

    Attributes
    ----------
    start
        Inputs of the run: a trace without events, whose ``tick`` and ``status`` are yet to be read.
    tick, status
        When the run ended, and how; known once the events have been gone through.

    Raises
    ------
    InputError
        With the file and the line when it is no trace, is damaged or was cut off; in the header at once, in an event
        when that is read.
    """

    def __init__(self, path: str | Path) -> None:
        self._lines = read_json_lines(path)
        place, first = next(self._lines, (str(path), {}))
        if first.get("format") != FORMAT:
            raise InputError(place, f"this is no trace; expected a header with the format {FORMAT!r}")
        if first.get("version") != VERSION or isinstance(first["version"], bool):
            raise InputError(place, f"found a trace of version {first.get('version')!r}; expected version {VERSION}")
        if first.get("tick_s", TICK_S) != TICK_S:
            raise InputError(place, f"found ticks of {first['tick_s']!r} s; expected {TICK_S} s")
        self._place = place
        self.start = _trace(str(path), first)
        self.tick, self.status = 0, ""

    def __iter__(self) -> Iterator[Event]:
        """Go through the events, in the order in which they happened; once."""
        for place, line in self._lines:
            if line.get("e") == "end":
                self.tick, self.status = _end(place, line)
                extra = next(self._lines, None)
                if extra is not None:
                    raise InputError(extra[0], "found a line after the event 'end'; expected none")
                return
            self._place = place
            yield _event(place, line)
        raise InputError(self._place, "the trace was cut off here; expected a last line with the event 'end'")


def read_trace(path: str | Path) -> Trace:
    """Read a whole trace file.

    Raises
    ------
    InputError
        With the file and the line when it is no trace, is damaged or was cut off.
    """
    stream = TraceStream(path)
    events = tuple(stream)
    return attrs.evolve(stream.start, events=events, tick=stream.tick, status=stream.status)


def trace_of(run: RunInfo) -> Trace:
    """Return the trace of a run that begins: what it starts from, and no events yet."""
    return _trace("the run", header(run))


def trace_file(path: str | Path) -> Path:
    """Return the trace file of a run's folder, or the file that is given; raise `InputError` where there is none."""
    file = Path(path)
    if not os.path.isdir(file):  # noqa: PTH112 (False for a name that is too long, too)
        return file
    if not (file / FILE).exists():
        raise InputError(str(file), f"has no {FILE}; `rmfs run --trace` records one")
    return file / FILE


@contextmanager
def fitting(file: Path, done: str) -> Iterator[None]:
    """Say in a sentence that a trace that nothing has recorded cannot be ``done`` ("checked", "shown")."""
    try:
        yield
    except (TypeError, KeyError, IndexError, AttributeError, ValueError, ArithmeticError) as error:
        problem = f"the events contradict each other, so that it cannot be {done}; expected a trace by rmfs"
        raise InputError(str(file), f"{problem} ({one_line(error)})") from error


class KnownIds:
    """Which ids there are in a trace.

    Parameters
    ----------
    trace
        Its header is enough.
    """

    def __init__(self, trace: Trace) -> None:
        counts = {
            "robot": len(trace.robots),
            "pod": len(trace.pods),
            "station": len(trace.stations),
            "next_station": len(trace.stations),
            "order": len(trace.instance.orders),
            "sku": len(trace.instance.skus),
            "skus": len(trace.instance.skus),
            "heading": 4,
            "packing": packing_stations(trace),
            **dict.fromkeys(("origin", "to", "cell"), len(trace.layout.kind)),
        }
        self._of_kind = {
            kind: [(one.name, counts[one.name]) for one in attrs.fields(kind) if one.name in counts]
            for kind in EVENTS.values()
        }

    def unknown(self, event: Event) -> str | None:
        """Return the first id in an event that is none, and of what: ``"pod 2"``."""
        for name, count in self._of_kind[type(event)]:
            value = getattr(event, name)
            for i in value if isinstance(value, tuple) else (value,):
                if i is not None and not 0 <= i < count:
                    return f"{name} {i}"
        return None


def packing_stations(trace: Trace) -> int:
    """Return how many packing stations a run has."""
    section = trace.scenario.get("packing")
    return 0 if section is None else int(section.get("stations") or len(trace.layout.packing) or 1)


def _is_int(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and abs(value) <= MOST


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


_ROLES = {role.label: role for role in Role}
_CHECKS: dict[str, Callable[[Any], bool]] = {
    "int": _is_int,
    "int | None": lambda value: value is None or _is_int(value),
    "float | None": lambda value: value is None or _is_number(value),
    "bool": lambda value: isinstance(value, bool),
    "str": lambda value: isinstance(value, str),
    "tuple[int, ...]": lambda value: isinstance(value, list) and all(map(_is_int, value)),
    "Role": lambda value: isinstance(value, str) and value in _ROLES,
}
_FIELDS = {
    name: {field.name: str(field.type) for field in attrs.fields(kind) if field.name not in NOT_TRACED}
    for name, kind in EVENTS.items()
}
_NOT_TRACED: dict[str, dict[str, Any]] = {
    name: {field.name: 0.0 for field in attrs.fields(kind) if field.name in NOT_TRACED} for name, kind in EVENTS.items()
}


def _event(place: str, line: dict[str, Any]) -> Event:
    name = line.pop("e", None)
    if not isinstance(name, str) or name not in EVENTS:
        raise InputError(place, f"found the event {shown_short(name)}; expected one of {', '.join(EVENTS)}, end")
    fields = _FIELDS[name]
    if line.keys() != fields.keys():
        raise InputError(place, f"{name} has the fields {', '.join(line)}; expected {', '.join(fields)}")
    for key, kind in fields.items():
        if not _CHECKS[kind](line[key]):
            values = line[key] if isinstance(line[key], list) else [line[key]]
            large = "int" in kind and any(type(one) is int and abs(one) > MOST for one in values)
            expected = f"{kind} up to {MOST:,}" if large else kind
            raise InputError(place, f"{key} of {name} is {shown_short(line[key])}; expected {expected}")
        if isinstance(line[key], list):
            line[key] = tuple(line[key])
        elif kind == "Role":
            line[key] = _ROLES[line[key]]
    return EVENTS[name](**line, **_NOT_TRACED[name])


def _end(place: str, line: Mapping[str, Any]) -> tuple[int, str]:
    tick, status = line.get("tick"), line.get("status")
    if not isinstance(tick, int) or not _is_int(tick) or tick < 0 or status not in STATUSES:
        expected = f"a tick from 0 to {MOST:,} and a status of {', '.join(STATUSES)}"
        raise InputError(place, f"found the end {shown_short(line)}; expected {expected}")
    return tick, str(status)


_BOOLEANS = ("counts_orders", "restocked")
"""Keys of the header, outside the scenario, that are true or false; anywhere else Python would take true for 1."""


def _refuse_booleans(value: object, where: str) -> None:
    """Raise TypeError where a header has ``true`` or ``false`` for a number."""
    if isinstance(value, bool):
        raise TypeError(f"found {str(value).lower()} in {where}; expected a number")
    if isinstance(value, Mapping):
        for key, entry in value.items():
            if key not in _BOOLEANS:
                _refuse_booleans(entry, f"`{key}`")
    elif isinstance(value, list):
        for entry in value:
            _refuse_booleans(entry, where)


def _trace(path: str, first: Mapping[str, Any]) -> Trace:
    try:
        _refuse_booleans({key: value for key, value in first.items() if key not in ("scenario", "state")}, "the header")
        return Trace(
            scenario=first["scenario"],
            layout=_layout(first["layout"], f"{path}, line 1"),
            motion=Motion(**first["motion"]),
            instance=_instance(first),
            pods=tuple({key: pod[key] for key in ("cell", "robot", "bound_for")} for pod in first["pods"]),
            robots=tuple({key: robot[key] for key in ("cell", "heading")} for robot in first["robots"]),
            stations=tuple(first["stations"]),
            blocked=tuple(first["blocked"]),
            events=(),
            tick=0,
            status="",
            versions=dict(first.get("versions", {})),
            map_text=first.get("map"),
            state=_state(first.get("state"), first["scenario"]),
            apart=first.get("reserves", "") is not None,
            floor=_floor(first.get("floor")),
        )
    except KeyError as error:
        raise InputError(f"{path}, line 1", f"the header lacks {error}") from error
    except (TypeError, ValueError) as error:
        raise InputError(f"{path}, line 1", f"the header is not as the format has it: {error}") from error


def _state(told: Any, scenario: Any) -> Mapping[str, Any] | None:
    if told is None:
        return None
    if not (_is_int(told["tick"]) and told["tick"] >= 0 and isinstance(told["content"], dict)):
        raise ValueError(f"found the state {shown_short(told)}; expected a tick from 0, and a content")
    given = scenario.get("instance") if isinstance(scenario, Mapping) else None
    if not (isinstance(given, Mapping) and isinstance(given.get("state_file"), str)):
        raise TypeError("found a state, but no file's name in `instance.state_file` of the scenario; expected both")
    return dict(told)


def _floor(told: Any) -> Mapping[str, Any] | None:
    if told is None:
        return None
    if not ((found := told["corrected_s"]) is None or (_is_number(found) and 0 <= found <= MOST)):
        raise ValueError(f"found {shown_short(found)} in `corrected_s` of the floor; expected seconds from 0, or null")
    if not (isinstance(left := told.get("waiting", []), list) and all(map(_is_int, left))):
        raise ValueError(f"found {shown_short(left)} in `waiting` of the floor; expected ids of orders")
    return dict(told)


def _layout(table: Mapping[str, Any], place: str) -> Layout:
    width, height = table["width"], table["height"]
    check_size(width, height, place)

    def cells(rows: list[str]) -> np.ndarray[Any, np.dtype[np.int8]]:
        if len(rows) != height or any(len(row) != width for row in rows):
            raise ValueError(f"expected {height} rows of {width} cells each")
        return np.array([int(digit, 16) for row in rows for digit in row], dtype=np.int8)

    stations = tuple(
        StationCells(entry["cell"], tuple(entry["queue"]), entry.get("clear", 0)) for entry in table["stations"]
    )
    kind, moves = cells(table["kind"]), cells(table["moves"])
    replenishing, packing = int(table.get("replenishing", 0)), tuple(table.get("packing", ()))
    return Layout(width, height, kind, moves, stations, replenishing, packing)


def _place(given: Sequence[int] | None) -> tuple[int, int, str] | None:
    if given is None:
        return None
    row, column = given
    return row, column, "the header"


def _instance(first: Mapping[str, Any]) -> Instance:
    orders = tuple(
        OrderData(
            order["name"],
            arrival_tick=order["arrival"],
            lines=tuple((sku, quantity) for sku, quantity in order["lines"]),
            due_tick=order.get("due"),
            priority=order.get("priority", 0),
            cancelled_tick=order.get("cancelled"),
            route=order.get("route"),
        )
        for order in first["orders"]
    )
    pods = tuple(
        PodData(pod["name"], tuple((sku, number) for sku, number in pod["contents"]), _place(pod.get("place")))
        for pod in first["pods"]
    )
    return Instance(
        tuple(first["skus"]),
        orders,
        pods,
        tuple(first.get("sizes", ())),
        tuple(
            BundleData(name, arrival_tick=tick, sku=sku, items=items)
            for name, tick, sku, items in first.get("bundles", ())
        ),
        tuple((s, up_to) for s, up_to in first.get("levels", ())),
        bool(first.get("restocked", False)),
    )
