"""Recorders: observers that write a file next to a run's results, switched on by the names of their entry points."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from typing import Any, ClassVar, Protocol

from rmfs_commands.instances.tables import TABLE_FILES
from rmfs_core import entrypoints
from rmfs_core.errors import InputError, refusing
from rmfs_core.results import RESULT_FILE
from rmfs_core.wording import listed, nearest, sentence, shown_short


def files_of_results() -> list[str]:
    """Return the names of the files that every result has."""
    return [RESULT_FILE, *(file for file, _ in TABLE_FILES.values())]


class Recorder(Protocol):
    """An observer that `run` makes when it is asked to record: an entry point of the group ``rmfs.recorders``.

    It is made without arguments and writes one file into ``RunInfo.out``, whole or not at all.
    """

    file: ClassVar[str]
    """Name of the file, a plain one; one that an earlier run has left is deleted where a run does not record it."""

    def __init__(self) -> None: ...


def _is_plain(file: object) -> bool:
    """Whether that is the name of a file in a folder of results, and of none of theirs."""
    plain = isinstance(file, str) and re.fullmatch(r"[A-Za-z0-9][\w.-]{0,99}", file, re.ASCII) is not None
    return plain and str(file).lower() not in files_of_results()


def load_recorder(name: str) -> type[Recorder]:
    """Return the class of an installed recorder; raise `InputError` when there is none of that name, or it is none."""
    place = f"record {name}"
    known = entrypoints.offers(entrypoints.RECORDERS)
    if name not in known:
        raise InputError(place, f'there is no recorder "{name}"{nearest(name, known)}')
    kind = entrypoints.load(known[name], place, "recorder")
    if not isinstance(kind, type) or not _is_plain(getattr(kind, "file", None)):
        described = entrypoints.describe("recorder", name, *entrypoints.origin(known[name][0]))
        expected = "expected a class with the name of its file as `file`, a plain name that no file of results has"
        raise InputError(place, f"{described} is no recorder: {expected}")
    return kind


def make_recorders(names: Iterable[str]) -> list[tuple[Recorder, str]]:
    """Return recorders, and what messages call them; raise `InputError` when two write one file, or one is none."""
    made: dict[str, tuple[Recorder, str]] = {}
    for name in names:
        kind, (entry,) = load_recorder(name), entrypoints.offers(entrypoints.RECORDERS)[name]
        described = entrypoints.describe("recorder", name, *entrypoints.origin(entry))
        made[name] = _make(kind, f"record {name}", described), described
    for name, (recorder, _) in made.items():
        same = [described for other, described in made.values() if other.file == recorder.file]
        if len(same) > 1:
            raise InputError(
                f"record {name}", f"{listed(same)} write the same file, {recorder.file}; expected one of them"
            )
    return list(made.values())


def make_observers(*, quiet: bool = False) -> list[tuple[Any, str]]:
    """Return the observers of every run, entry points of the group ``rmfs.observers``, and what messages call them.

    In the order in which they are told: those of rmfs come first, whatever others do wrong. All are told before any
    other, also where no results are kept. Their attribute ``files`` has the names of what they write into
    ``RunInfo.out``. One that cannot be had is left out, and named on standard error unless ``quiet``.
    """
    made = []
    offers = entrypoints.offers(entrypoints.OBSERVERS).items()
    for name, entries in sorted(
        offers, key=lambda one: (entrypoints.origin(one[1][0])[0] == "rmfs", one[0]), reverse=True
    ):
        place, described = f"observer {name}", entrypoints.describe("observer", name, *entrypoints.origin(entries[0]))
        try:
            if len(entries) == 1:  # where distributions clash, each is there by a name of its own, too
                made.append((_make_observer(entries, place, described), described))
        except InputError as error:
            if not quiet:
                print(sentence(f"Left out: {error}"), file=sys.stderr)
    return made


def _make_observer(entries: entrypoints.Entries, place: str, described: str) -> Any:
    observer = _make(entrypoints.load(entries, place, "observer"), place, described)
    files = getattr(observer, "files", ())
    if not isinstance(files, tuple | list) or not all(map(_is_plain, files)):
        expected = "a tuple of plain names, none that of a file of results"
        raise InputError(place, f"{described}: expected `files` to be {expected}; found {shown_short(files)}")
    return observer


def _make(kind: Any, place: str, described: str) -> Any:
    with refusing(place, f"{described} cannot be made:"):
        return kind()


def files_of(observers: Iterable[Any]) -> list[str]:
    """Return the names of the files that recorders and observers of every run write."""
    return [file for one in observers for file in (*getattr(one, "files", ()), getattr(one, "file", None)) if file]
