"""Damage to a trace in one place: an event changed, left out, told twice or too early."""

from collections.abc import Callable
from typing import Any, TypeVar

from attrs import evolve

from rmfs_commands.trace.reader import Trace
from rmfs_commands.validation import KINDS, faults_of
from rmfs_core.events import Event

Kind = TypeVar("Kind", bound=Event)
Damage = Callable[[Trace], Trace]


def find(trace: Trace, kind: type[Kind], number: int = 3, where: Callable[[Kind], bool] = lambda _: True) -> int:
    """Return the place of the event with this number among those of a kind."""
    places = [i for i, event in enumerate(trace.events) if isinstance(event, kind) and where(event)]
    return places[min(number, len(places) - 1)]


def put(trace: Trace, at: int, *events: Event, instead_of: int = 1) -> Trace:
    return evolve(trace, events=(*trace.events[:at], *events, *trace.events[at + instead_of :]))


def change(kind: type[Kind], by: Callable[[Trace, Any], dict[str, Any]], **where: Any) -> Damage:
    def damage(trace: Trace) -> Trace:
        at = find(trace, kind, **where)
        return put(trace, at, evolve(trace.events[at], **by(trace, trace.events[at])))

    return damage


def drop(kind: type[Kind], **where: Any) -> Damage:
    return lambda trace: put(trace, find(trace, kind, **where))


def at(place: int, **fields: Any) -> Damage:
    """Return the damage that changes fields of the event at a place."""
    return lambda trace: put(trace, place, evolve(trace.events[place], **fields))


def without(place: int) -> Damage:
    return lambda trace: put(trace, place)


def twice(place: int) -> Damage:
    return lambda trace: put(trace, place, trace.events[place], trace.events[place])


def told_before(place: int, before: int) -> Damage:
    """Return the damage that tells the event at a place before an earlier one, at the time of that."""

    def damage(trace: Trace) -> Trace:
        moved = evolve(trace.events[place], tick=trace.events[before].tick)
        return put(put(trace, place), before, moved, instead_of=0)

    return damage


def assert_found(damaged: Trace, kind: str) -> None:
    """Fail unless a kind is among the faults of a trace, and each fault has a known kind and a sentence."""
    faults = faults_of(damaged)
    assert kind in {fault.kind for fault in faults}
    assert all(fault.kind in KINDS and len(fault.sentence) > 20 for fault in faults)
    assert [fault.tick for fault in faults] == sorted(fault.tick for fault in faults)


def told(trace: Trace) -> list[str]:
    return [f"{fault.kind}: {fault.sentence}" for fault in faults_of(trace)]
