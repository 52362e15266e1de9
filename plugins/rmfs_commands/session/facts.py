"""Batches as JSON has them: which facts there are, and what each one tells."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

from attrs import frozen

from rmfs_commands.states.beginning import MOST_S
from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.wording import nearest, shown_short

MOST_EVENTS = 10_000
"""Events in a batch."""
OWN = "x-"
"""Beginning of the names of a caller's own fields, which come back with the answer."""
MOST_DEEP = 100
"""Levels of nesting of such a field, so that whatever has it in its answer can be read."""
MOST = 1_000_000_000
"""Items, ids and priorities."""


class Kind(NamedTuple):
    """A kind of value: in words, whether something is one, and its JSON Schema."""

    expected: str
    holds: Callable[[Any], bool]
    schema: Mapping[str, Any]


def _whole(least: int, most: int = MOST) -> Kind:
    expected = f"a whole number from {least:,} to {most:,}"
    schema = {"type": "integer", "minimum": least, "maximum": most}
    return Kind(expected, lambda given: type(given) is int and least <= given <= most, schema)


def _number(expected: str, most: float) -> Kind:
    schema = {"type": "number", "minimum": 0, "maximum": most}
    return Kind(expected, lambda given: type(given) in (int, float) and 0 <= given <= most, schema)


def _items(least: int) -> Kind:
    number = _whole(least)
    return Kind(
        f"an object of SKUs with whole numbers of items from {least}",
        lambda given: isinstance(given, Mapping) and all(map(number.holds, given.values())),
        {"type": "object", "additionalProperties": number.schema},
    )


TEXT = Kind(
    "a text of 1 to 200 characters",
    lambda given: isinstance(given, str) and 0 < len(given) <= 200,
    {"type": "string", "minLength": 1, "maxLength": 200},
)
TIME = _number(f"seconds since the hall's time 0, not more than {MOST_S:,}", MOST_S)
DUE = _number("seconds from 0 to 1e10", 1e10)
HEADING = _whole(0, 3)._replace(expected="0 (east), 1 (north), 2 (west) or 3 (south)")
SHARE = _number("a share from 0 to 1", 1)
LINES = _items(1)._replace(holds=lambda given: bool(given) and _items(1).holds(given))
CONTENTS = _items(0)

FACTS: Mapping[str, tuple[Mapping[str, Kind], Mapping[str, Kind]]] = {
    "order_arrived": ({"order": TEXT, "lines": LINES}, {"due_s": DUE, "priority": _whole(0)}),
    "order_cancelled": ({"order": TEXT}, {}),
    "robot_at": ({"robot": TEXT, "cell": _whole(0)}, {"heading": HEADING, "charge": SHARE}),
    "robot_charged": ({"robot": TEXT}, {}),
    "pod_lifted": ({"pod": TEXT}, {}),
    "pod_queued": ({"pod": TEXT, "station": TEXT}, {}),
    "pod_at_station": ({"pod": TEXT, "station": TEXT}, {}),
    "picked": ({"pod": TEXT, "order": TEXT, "sku": TEXT}, {}),
    "handled": ({"station": TEXT}, {}),
    "pod_stored": ({"pod": TEXT, "cell": _whole(0)}, {}),
    "bundle_arrived": ({"bundle": TEXT, "sku": TEXT, "items": _whole(1)}, {}),
    "bundle_stored": ({"pod": TEXT, "bundle": TEXT}, {}),
    "short": ({"pod": TEXT, "sku": TEXT, "counted": _whole(0)}, {}),
    "stock": ({"pod": TEXT, "contents": CONTENTS}, {}),
    "pod_locked": ({"pod": TEXT}, {}),
    "pod_unlocked": ({"pod": TEXT}, {}),
    "order_back": ({"order": TEXT}, {}),
    "cell_blocked": ({"cell": _whole(0)}, {}),
    "cell_free": ({"cell": _whole(0)}, {}),
    "command_refused": ({"command": _whole(1), "why": TEXT}, {}),
    "part_arrived": ({"tote": _whole(1)}, {}),
    "part_packed": ({"tote": _whole(1)}, {}),
    "order_packed": ({"order": TEXT}, {}),
    "robot_failed": ({"robot": TEXT}, {}),
    "robot_back": ({"robot": TEXT}, {}),
    "station_opened": ({"station": TEXT}, {}),
    "station_closed": ({"station": TEXT}, {}),
}
"""By kind, the fields that a fact has to have and those that it may have."""


class ContradictionError(Exception):
    """A fact that cannot be so; the text says why, and ``concerns`` what is not known to be right from now on."""

    def __init__(self, problem: str, *concerns: tuple[str, str]) -> None:
        super().__init__(problem)
        self.concerns = concerns


@frozen
class Fact:
    """One fact of the floor: its id, kind, and fields by name; ``own`` are those of the caller, which begin with x-."""

    id: str
    kind: str
    fields: Mapping[str, Any]
    own: Mapping[str, Any]


@frozen
class Batch:
    """Facts that are taken together, or not at all.

    Parameters
    ----------
    after
        Number of the batch before.
    tick
        When they were so.
    facts
        In the order in which they happened.
    own
        Fields of the caller, which begin with x-.
    """

    after: int
    tick: int
    facts: Sequence[Fact]
    own: Mapping[str, Any]


def batch_of(data: Any) -> Batch:
    """Return a batch from JSON's objects.

    Raises
    ------
    InputError
        Where it has another shape, with the place.
    """
    if not isinstance(data, Mapping):
        raise InputError("batch", f"expected a JSON object, found {shown_short(data)}")
    needed: dict[str, Kind] = {"after": _whole(0), "time_s": TIME, "events": _EVENTS}
    _check("batch", data, needed, {})
    facts = []
    for i, given in enumerate(data["events"]):
        place = f"batch, events.{i}"
        if not isinstance(given, Mapping) or not isinstance(kind := given.get("kind"), str):
            raise InputError(place, f"expected an object with `id`, `kind` and fields, found {shown_short(given)}")
        if kind not in FACTS:
            raise InputError(f"{place}.kind", f'no kind of fact is "{kind[:40]}"{nearest(kind, FACTS)}')
        has, may = FACTS[kind]
        _check(place, given, {"id": TEXT, "kind": TEXT, **has}, may)
        fields = {name: value for name, value in given.items() if name in has or name in may}
        facts.append(Fact(given["id"], kind, fields, own_of(place, given)))
    return Batch(data["after"], to_ticks(float(data["time_s"])), facts, own_of("batch", data))


def own_of(place: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the caller's own fields of a batch or fact, which are to come back as they are."""
    own = {name: value for name, value in given.items() if name.startswith(OWN)}
    for name, value in own.items():
        check_finite(f"{place}.{name[:40]}", value)
        level = [value]
        for _ in range(MOST_DEEP):
            level = [inner for one in level for inner in _within(one)]
        if level:
            raise InputError(f"{place}.{name[:40]}", f"is nested too deeply; expected {MOST_DEEP} levels at most")
    return own


def _within(value: Any) -> Iterable[Any]:
    return value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ()


def check_finite(place: str, value: Any) -> None:
    """Raise an `InputError` where a value of JSON has a number that is not finite, which the journal cannot keep."""
    try:
        json.dumps(value, allow_nan=False)
    except ValueError:
        raise InputError(place, "has a number that is not finite; expected JSON") from None


_EVENTS = Kind(
    f"a list of at most {MOST_EVENTS:,} events",
    lambda given: isinstance(given, list) and len(given) <= MOST_EVENTS,
    {"type": "array", "maxItems": MOST_EVENTS},
)


def _check(place: str, given: Mapping[str, Any], needed: Mapping[str, Kind], optional: Mapping[str, Kind]) -> None:
    for name, (expected, holds, _) in (*needed.items(), *optional.items()):
        if name in needed and name not in given:
            raise InputError(f"{place}.{name}", f"is missing; expected {expected}")
        if name in given and not holds(given[name]):
            raise InputError(f"{place}.{name}", f"found {shown_short(given[name])}; expected {expected}")
    known = {**needed, **optional}
    unknown = (name for name in given if name not in known and not name.startswith(OWN))
    for name in islice(unknown, 1):
        raise InputError(f"{place}.{name[:40]}", f"is not a field of it{nearest(name, known)}")
