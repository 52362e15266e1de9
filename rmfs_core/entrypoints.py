"""Entry points of installed distributions: rules, commands, recorders, observers, generators."""

from __future__ import annotations

import os
import sys
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from copy import deepcopy
from functools import lru_cache
from importlib.metadata import Distribution, EntryPoint, entry_points
from inspect import signature
from pathlib import Path
from threading import RLock
from typing import Any, TypeVar

from rmfs_core.errors import InputError, refusing
from rmfs_core.wording import listed, nearest, raised, shown_short

T = TypeVar("T")
Entries = tuple[EntryPoint, ...]  # of one name in a group; more than one where distributions clash
_all = lru_cache(maxsize=1)(lambda _stamps: entry_points())  # of all groups: to read those of one takes as long

IMPORTING = RLock()  # a package and a module of it, imported by two threads at once, may see each other half made
RULES = "rmfs.rules"
COMMANDS = "rmfs.commands"
RECORDERS = "rmfs.recorders"
OBSERVERS = "rmfs.observers"
INSTANCES = "rmfs.instances"
LAYOUTS = "rmfs.layouts"
FORMATS = "rmfs.formats"
PROCESSES = "rmfs.processes"
DRIVING = "rmfs.driving"
SECTIONS = {INSTANCES: "instance", LAYOUTS: "layout"}  # of a scenario, whose key `generator` names an entry point


def origin(entry: EntryPoint) -> tuple[str, str]:
    """Return name and version of the distribution that offers an entry point."""
    return ("unknown distribution", "?") if entry.dist is None else _origin(entry.dist)


@lru_cache(maxsize=64)
def _origin(distribution: Distribution) -> tuple[str, str]:  # read from files, each time anew
    return distribution.name, distribution.version


def describe(kind: str, name: str, distribution: str, version: str) -> str:
    """Name what a distribution offers for a message: ``rule "demand" (rmfs 0.1.0)``."""
    return f'{kind} "{name}" ({distribution} {version})'


def offers(group: str) -> dict[str, Entries]:
    """Return a group's entry points by name; several where distributions clash, each as ``DISTRIBUTION:NAME``, too."""
    stamps = []  # change where something is installed; until then the distributions' files are read once
    for place in sys.path:
        with suppress(OSError):
            stamps.append((place, os.stat(place or ".").st_mtime_ns))  # noqa: PTH116 (a text that may be empty)
    return dict(_offers(group, tuple(stamps)))


@lru_cache(maxsize=16)
def _offers(group: str, stamps: tuple[tuple[str, int], ...]) -> dict[str, Entries]:
    found: dict[str, list[EntryPoint]] = {}
    for entry in sorted(_all(stamps).select(group=group), key=lambda entry: entry.name):
        found.setdefault(entry.name, []).append(entry)
    for name, same in list(found.items()):
        if len(same) > 1:  # who offers an entry point is read from files: only where it matters
            same.sort(key=origin)
            found |= {f"{origin(entry)[0]}:{name}": [entry] for entry in same}
    return {name: tuple(same) for name, same in found.items()}


def chosen(group: str, name: str | None, default: str) -> Entries:
    """Return the entry points of a name that a scenario gives; where it gives none, ours of the default name alone.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    known = offers(group)
    if name is not None and name not in known:
        raise InputError(f"{SECTIONS[group]}.generator", f'there is no generator "{name}"{nearest(name, known)}')
    return known[name] if name is not None else preferred(group, default)


def preferred(group: str, name: str, distribution: str = "rmfs") -> Entries:
    """Return the entry points of a name: those of the given distribution, else ours, else all of them."""
    known = offers(group)
    return known.get(f"{distribution}:{name}") or known.get(f"rmfs:{name}") or known[name]


def format_module(name: str) -> Any:
    """Return the module that reads or makes some files, by its name in the entry-point group ``rmfs.formats``.

    ``csv`` is described by `rmfs_core.world.instance_making.reader`; ``tables`` has ``Tables``, an observer with each
    table's rows, and ``TABLE_FILES``, their files and columns; ``results`` writes and shows a `Result`, ``recorders``
    makes recorders and the observers of every run, ``problems`` says what keeps an instance from being run, ``drawing``
    shows a layout, ``reaching`` checks that all of it can be reached, ``toml`` reads TOML and finds the line of a key,
    ``states`` writes states, ``overrides`` reads ``--set``, ``endings`` says how a run ended, ``files`` writes texts.
    """
    return load(chosen(FORMATS, None, name), f"format {name}", "format")


def process(name: str, place: str) -> Any:
    """Return what a scenario asks for at ``place``, by its name in the entry-point group ``rmfs.processes``.

    Some are classes made with the run, a `Simulation`. ``packing`` has the packing stations (``stations``) and is told
    of decisions, picks and visits: ``assigned``, ``released``, ``visit_ended``. ``supply`` lets bundles arrive:
    ``follow``, ``item_picked``, ``order_waits``, ``waits_no_more``. ``hours`` has ``timetables``, and opens and closes
    stations: ``follow``, ``keep``. ``outages`` takes robots, stations and chargers out of service: ``follow``,
    ``check``, ``update``, ``repaired``, ``charge``. ``battery`` is a function of scenario and travel times; it returns
    what makes a robot's battery, given a clock: ``charging``, ``share``, ``low``, ``lift``, ``drive``, ``stand``,
    ``ticks_to``. ``state`` lets a run begin in a state. States, halls and reports ask for more: subclass ours.
    """
    return load(chosen(PROCESSES, None, name), place, "process")


def load(entries: Entries, place: str, kind: str) -> object:
    """Import what the entry point of a name leads to.

    Parameters
    ----------
    entries
        All of that name in its group; more than one is an error.
    place
        Name of the key or option that asks for it, in messages.
    kind
        Its name for people: ``"rule"``, ``"command"``, ``"recorder"``.

    Raises
    ------
    InputError
        When several distributions offer it, or it cannot be imported, whatever its module raises.
    """
    entry = entries[0]
    if len(entries) > 1:
        clash = listed(" ".join(origin(entry)) for entry in entries)
        ways = listed((f"`{origin(entry)[0]}:{entry.name}`" for entry in entries), "or")
        raise InputError(place, f'{kind} "{entry.name}" is offered by {clash}; expected one of them: {ways}')
    name = describe(kind, entry.name, *origin(entry))
    with IMPORTING, refusing(place, f"{name} cannot be imported from {entry.value}:"):
        return entry.load()


def hints_of(annotations: Mapping[str, Any], module: str) -> dict[str, Any]:
    """Return the types that annotations in a module stand for; one that cannot be resolved is left out."""
    known = {"Path": Path, **getattr(sys.modules.get(module), "__dict__", {})}  # may be there for type checkers alone
    found: dict[str, Any] = {}
    for name, hint in annotations.items():
        with suppress(Exception):
            found |= typing.get_type_hints(type(name, (), {"__annotations__": {name: hint}}), known)
    return found


def kinds_of(kind: Any) -> tuple[Any, ...]:
    """Return the types of a union; of another type itself."""
    return typing.get_args(kind) if typing.get_origin(kind) in (typing.Union, types.UnionType) else (kind,)


def generated(
    entries: Entries, kind: type[T], malformed: Callable[[T], Iterable[str]], folder: str = ".", **handed: Any
) -> T:
    """Return what a generator makes of what it is handed, in this order, and of parameters by name, files of a folder.

    Raises
    ------
    InputError
        When it cannot be called so, raises, or returns what is not of that kind, or ``malformed``.
    """
    section, parameters = SECTIONS[entries[0].group], deepcopy(dict(handed["section"].parameters))
    place, described = f"{section}.generator", describe("generator", entries[0].name, *origin(entries[0]))
    generate: Any = load(entries, place, "generator")
    names: list[str] = []
    try:
        with suppress(ValueError):  # of a function whose parameters nobody knows
            names += (takes := signature(generate)).parameters
            takes.bind(*handed.values(), **parameters)
            typed = {name: one.annotation for name, one in takes.parameters.items() if name in parameters}
            for name, hint in hints_of(typed, getattr(generate, "__module__", entries[0].module)).items():
                parameters[name] = _with_paths(parameters[name], hint, folder)
    except TypeError as error:
        expected = f"besides {listed(handed)} it takes {listed(f'`{name}`' for name in names[len(handed) :])}"
        why = str(error).replace(" keyword-only", "")  # as Python 3.11 says it
        problem = f"{described} cannot be called: {why}; {expected}"
        raise InputError(f"{section}.parameters" if parameters else place, problem) from None
    with refusing(place, f"{described} raised", lambda error: raised(error, generate), InputError):
        made: T = generate(*handed.values(), **parameters)
    if not isinstance(made, kind):
        raise InputError(place, f"{described} returned {shown_short(made)}; expected {kind.__name__}")
    for problem in malformed(made):
        raise InputError(place, f"{described} returned a wrong {kind.__name__}: {problem}")
    return made


def _with_paths(value: Any, kind: Any, folder: str) -> Any:
    """Return a parameter; where its type has `Path`, in a union or a list, too, its texts are names of files."""
    kinds = kinds_of(kind)
    if isinstance(value, list | tuple):
        inner = next((inside[0] for one in kinds if (inside := typing.get_args(one))), None)
        return type(value)(_with_paths(entry, inner, folder) for entry in value)
    return Path(folder, value) if isinstance(value, str) and value and Path in kinds else value
