"""What installed distributions offer through entry points: rules, commands, recorders, observers of every run."""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points

from rmfs_core.errors import InputError
from rmfs_core.wording import listed, one_line

RULES = "rmfs"
COMMANDS = "rmfs.commands"
RECORDERS = "rmfs.recorders"
OBSERVERS = "rmfs.observers"


def origin(entry: EntryPoint) -> tuple[str, str]:
    """Return name and version of the distribution that offers an entry point."""
    return (entry.dist.name, entry.dist.version) if entry.dist is not None else ("unknown distribution", "?")


def describe(kind: str, name: str, distribution: str, version: str) -> str:
    """Name what a distribution offers for a message: ``rule "demand" (rmfs 0.1.0)``."""
    return f'{kind} "{name}" ({distribution} {version})'


def offers(group: str) -> dict[str, tuple[EntryPoint, ...]]:
    """Return a group's entry points by name, ascending; more than one where distributions clash."""
    found: dict[str, list[EntryPoint]] = {}
    for entry in sorted(entry_points(group=group), key=lambda entry: entry.name):
        found.setdefault(entry.name, []).append(entry)
    # Who offers an entry point is read from files: only where it matters.
    return {name: tuple(sorted(same, key=origin) if len(same) > 1 else same) for name, same in found.items()}


def load(entries: tuple[EntryPoint, ...], place: str, kind: str) -> object:
    """Import what the entry point of a name leads to.

    Parameters
    ----------
    entries
        All of that name in its group; more than one is an error.
    place
        What a message calls the place that asks for it.
    kind
        What it is for people: ``"rule"``, ``"command"``, ``"recorder"``.

    Raises
    ------
    InputError
        When several distributions offer it, or it cannot be imported, whatever its module raises.
    """
    entry = entries[0]
    if len(entries) > 1:
        clash = f"more than one installed distribution: {listed(' '.join(origin(entry)) for entry in entries)}"
        raise InputError(place, f'{kind} "{entry.name}" is offered by {clash}; uninstall all but one')
    try:
        target: object = entry.load()
    except (Exception, SystemExit) as error:
        name = describe(kind, entry.name, *origin(entry))
        raise InputError(place, f"{name} cannot be imported from {entry.value}: {one_line(error)}") from error
    return target
