"""A state that replaces the session's own: read, checked, and made what a floor begins in."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from attrs import frozen

from rmfs_commands.session.facts import check_finite, own_of
from rmfs_commands.states.beginning import Begun, begin
from rmfs_commands.states.state_json import state_from_dict
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario
from rmfs_core.warehouse import Warehouse
from rmfs_core.wording import shown_short
from rmfs_core.world import Instance, Layout

PLACE = "batch.state"
KINDS = ("robot", "pod", "station", "order", "cell")
"""Kinds of what can be in doubt."""


@frozen
class Replacement:
    """A state in place of facts.

    Parameters
    ----------
    after
        Number of the batch before.
    begun
        State in which a floor begins.
    doubtful
        Kind and name of each thing in doubt, and why.
    failed, closed, by_floor, opened
        Robots that have failed, stations that are closed, those of them that the floor closed, and those that it
        opened outside of their hours, by name.
    own
        Fields of the caller, which begin with x-.
    """

    after: int
    begun: Begun
    doubtful: Sequence[tuple[tuple[str, str], str]]
    failed: Sequence[str]
    closed: Sequence[str]
    by_floor: Sequence[str]
    opened: Sequence[str]
    own: Mapping[str, Any]

    @property
    def tick(self) -> int:
        """When the state was so."""
        return self.begun.opening.warehouse.now


def replacement_of(data: Mapping[str, Any], scenario: Scenario, instance: Instance, layout: Layout) -> Replacement:
    """Return a replacement from JSON's objects: ``{"after": seq, "state": {...}}``.

    What is under way begins anew: a state's ``run`` is left out. What is in ``session.quarantine`` stays in doubt.

    Raises
    ------
    InputError
        Where the state cannot be, with the place.
    """
    after = data.get("after")
    if type(after) is not int or after < 0:
        raise InputError("batch.after", f"found {shown_short(after)}; expected a whole number from 0")
    if scenario.packing is not None:
        problem = "a hall with packing stations takes no state, for what packers do cannot begin anew; expected facts"
        raise InputError(PLACE, problem)
    own = own_of("batch", data)
    if unknown := [name for name in data if name not in ("after", "state", *own)]:
        raise InputError(f"batch.{unknown[0][:40]}", "is not a field of it; expected `after` and `state`")
    if not isinstance(data["state"], Mapping):
        raise InputError(PLACE, f"found {shown_short(data['state'])}; expected a state, a JSON object")
    for key, value in data["state"].items():
        check_finite(f"{PLACE}.{key[:40]}", value)
    given = {key: value for key, value in data["state"].items() if key not in ("session", "run", "ask", "random")}
    session = data["state"].get("session", {})
    doubtful = [*_doubtful(session)]
    lost, by_floor, reopened = (_listed(session, key) for key in ("failed", "closed", "opened"))
    told = {(kind, name): one for (kind, name), one in doubtful}
    given = _trusted(given, told)
    robots, stations = _objects(given, "robots"), _objects(given, "stations")
    out = [name for name, one in robots.items() if one.get("in_service") is False]
    failed = [name for name in out if ("robot", name) not in told or name in lost]
    closed = [name for name, one in stations.items() if False in (one.get("in_service"), one.get("staffed"))]
    opened = [name for name in stations if name in reopened]
    for section, entries in (("robots", robots), ("stations", stations)):
        for name, one in entries.items():
            left = ("in_service",) if "in_hand" in one else ("in_service", "picker_free_s")  # a pick begins anew
            told_of = {key: value for key, value in one.items() if key not in left}
            given[section] = {**given[section], name: told_of}
    named = given.get("skus", [])
    if isinstance(named, list) and all(isinstance(sku, str) for sku in named):
        given["skus"] = [*named, *(sku for sku in instance.skus if sku not in set(named))]
    state = state_from_dict(given, PLACE)
    begun = begin(scenario, instance, layout, state, PLACE)
    _claim_slots(begun.opening.warehouse)
    whys = [(key, one["why"]) for key, one in told.items()]
    return Replacement(after, begun, whys, failed, closed, by_floor, opened, own)


def _claim_slots(warehouse: Warehouse) -> None:
    """Let pods in line and on their way have slots; robots that are still to lift theirs claim them again."""
    first = [pod.bound_for[0] for pod in warehouse.pods if pod.location is None and pod.bound_for]
    for station in warehouse.stations:
        for _ in range(station.queue_length + 1 - station.queue_room):
            warehouse.give_up_slot(station)
        for _ in range(first.count(station.id)):
            warehouse.claim_slot(station)


def _objects(given: Mapping[str, Any], section: str) -> dict[str, Mapping[str, Any]]:
    """Return the objects of a section by name; what is none is told of when the state is read."""
    found = given.get(section)
    if not isinstance(found, Mapping):
        return {}
    return {name: one for name, one in found.items() if isinstance(one, Mapping)}


def _listed(session: Mapping[str, Any], key: str) -> list[Any]:
    """Return the names that a state's ``session`` lists."""
    found = session.get(key, [])
    if not isinstance(found, list):
        raise InputError(f"{PLACE}.session.{key}", f"found {shown_short(found)}; expected a list of names")
    return found


def _doubtful(session: Any) -> Iterator[tuple[tuple[str, str], Mapping[str, Any]]]:
    """Yield kind and name of what a state says to be in doubt, with its entry."""
    listed = session.get("quarantine", []) if isinstance(session, Mapping) else None
    for i, one in enumerate(listed if isinstance(listed, list) else [None]):
        kind = next((kind for kind in KINDS if isinstance(one, Mapping) and isinstance(one.get(kind), str)), None)
        if kind is None or not isinstance(one.get("why"), str):
            raise InputError(f"{PLACE}.session.quarantine.{i}", "expected an entry as the session's own state has it")
        yield (kind, one[kind]), one


def _trusted(given: dict[str, Any], doubtful: Mapping[tuple[str, str], Mapping[str, Any]]) -> dict[str, Any]:
    """Return a state with what pods in doubt hold, and without cells that are blocked."""
    pods = _objects(given, "pods")
    for (kind, name), one in doubtful.items():
        if kind == "pod" and name in pods and isinstance(one.get("contents"), Mapping):
            contents = pods[name].get("contents")
            there = contents if isinstance(contents, Mapping) else {}
            both = {sku: _sum(items, there.get(sku)) for sku, items in one["contents"].items()}
            given["pods"] = {**given["pods"], name: {**pods[name], "contents": {**there, **both}}}
    blocked = {name for kind, name in doubtful if kind == "cell"}
    if blocked and isinstance(given.get("reserved"), list):
        given["reserved"] = [cell for cell in given["reserved"] if str(cell) not in blocked]
    return given


def _sum(held: Any, came: Any) -> Any:
    """Return the number of items of a pod in doubt, with those that came since; what is no number is told of later."""
    return held + came if type(held) is int and type(came) is int else held
