"""JSON to states and back. Nothing that is read is executed."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rmfs_commands.states.state import FORMAT, VERSIONS, State
from rmfs_core.errors import InputError
from rmfs_core.scenario.source import Source
from rmfs_core.scenario.structuring import KeyProblem, structure_as
from rmfs_core.scenario.writing import plain
from rmfs_core.wording import listed

TABLES = ("pods", "stations", "orders", "robots")
"""Keys of a state with a table of what it lists, by name."""

MOST_BYTES = 200_000_000
"""Bytes that are read of a file; a device may have no end."""


def read_state(path: str | Path) -> State:
    """Read a state from a JSON file.

    Raises
    ------
    InputError
        With the file and the path of the key, for the first thing that is wrong.
    """
    return state_from_dict(read_json(Path(path)), str(path))


def state_from_dict(data: object, name: str = "state") -> State:
    """Return the state that JSON's objects, lists and values describe.

    Parameters
    ----------
    data
        As `json.loads` returns it.
    name
        Name of the source in messages.

    Raises
    ------
    InputError
        For the first thing that is wrong in it. Whether names lead anywhere is seen when the state is used.
    """
    if not isinstance(data, Mapping):
        raise InputError(name, f"expected a JSON object with the format {FORMAT!r}, found {type(data).__name__}")
    check_format(data, FORMAT, VERSIONS, name)
    try:
        return structure_as(State, {key: value for key, value in data.items() if key != "session"})
    except KeyProblem as problem:
        raise InputError(Source(name).place_of(problem.path), problem.problem) from None


def state_after(data: Mapping[str, Any], before: Mapping[str, Any], state: State, name: str = "state") -> State:
    """Return the state that JSON's objects, lists and values describe, of which only what changed is read.

    Parameters
    ----------
    data
        As for `state_from_dict`; what did not change is the same object as in ``before``, as `patched` has it.
    before, state
        An earlier one, and the state that it describes.
    name
        Name of the source in messages.

    Raises
    ------
    InputError
        As `state_from_dict`.
    """
    changed = {
        key: value
        for key, value in data.items()
        if key in ("format", "version") or key not in before or value is not before[key]
    }
    for key in TABLES:
        told, earlier = data.get(key), before.get(key)
        if isinstance(told, Mapping) and isinstance(earlier, Mapping):
            changed[key] = {
                one: value for one, value in told.items() if one not in earlier or value is not earlier[one]
            }
    read = state_from_dict(changed, name)
    values = {key: getattr(read if key in changed else state, key) for key in data}
    for key in TABLES:
        if (fresh := values.get(key)) is not None and before.get(key) is not None:
            kept = getattr(state, key)
            values[key] = {one: fresh[one] if one in fresh else kept[one] for one in data[key]}
    try:
        return State(**values)
    except ValueError as problem:
        raise InputError(name, str(problem)) from None


def state_to_dict(state: State) -> dict[str, Any]:
    """Return a state as JSON's objects, lists and values; `state_from_dict` reads it back as an equal state."""
    tables: dict[str, Any] = plain(state)
    return {"format": state.format, "version": state.version, **tables}


def check_format(data: Mapping[str, Any], expected: str, versions: Sequence[int], name: str) -> None:
    """Raise `InputError` unless a file says that it has a format, in a version that is known here."""
    if data.get("format") != expected:
        found = f"found {data['format']!r}" if "format" in data else "found no key `format`"
        raise InputError(Source(name).place_of(("format",)), f"expected {expected!r}, {found}")
    if data.get("version") not in versions or isinstance(data.get("version"), bool):
        found = f"found {data['version']!r}" if "version" in data else "found no key `version`"
        known = f"version {listed(map(str, versions), 'or')} of {expected!r}"
        raise InputError(Source(name).place_of(("version",)), f"expected {known}, {found}")


def read_json(path: Path) -> Any:
    """Read a JSON file in which no object has a key twice.

    Raises
    ------
    InputError
        When it cannot be read, is no JSON, or has a key twice.
    """
    try:
        with path.open("rb") as stream:
            return parse_json(stream.read(MOST_BYTES + 1), str(path))
    except OSError as error:
        raise InputError(str(path), f"cannot be read: {error.strerror or error}") from error


def parse_json(content: bytes, name: str) -> Any:
    """Return what JSON text says in which no object has a key twice.

    Parameters
    ----------
    content
        The text in UTF-8.
    name
        Name of its source in messages.

    Raises
    ------
    InputError
        When it is too long, no JSON, or has a key twice.
    """
    if len(content) > MOST_BYTES:
        raise InputError(name, f"found more than {MOST_BYTES:,} bytes; expected at most that many")
    try:
        return json.loads(content.decode("utf-8-sig"), object_pairs_hook=_object)
    except UnicodeDecodeError as error:
        raise InputError(name, f"expected UTF-8 text: {error}") from error
    except json.JSONDecodeError as error:
        raise InputError(f"{name}, line {error.lineno}", f"this is no valid JSON: {error.msg}") from error
    except RecursionError as error:
        raise InputError(name, "is nested too deeply to be a state") from error
    except ValueError as error:
        raise InputError(name, f"this is no state: {error}") from error


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in pairs:
        if name in found:
            raise ValueError(f"an object names {name!r} twice; expected each name once")
        found[name] = value
    return found
