"""Halls that run in sessions, asked by lines of JSON."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rmfs_commands.serve.service import Reply, replied
from rmfs_commands.session import Hall
from rmfs_commands.states.state_json import read_json
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario, load_scenario
from rmfs_core.scenario.reading import Given
from rmfs_core.scenario.source import Source
from rmfs_core.scenario.structuring import KeyProblem
from rmfs_core.wording import listed, nearest, shown_short

GET = ("state", "answers", "seq", "counts")
POSTED = ".hall.json"
"""End of the names of files with halls that were made over HTTP."""


class Halls:
    """Sessions by name, one request at a time.

    Parameters
    ----------
    halls
        The sessions.
    """

    def __init__(self, halls: Mapping[str, Hall]) -> None:
        self._halls = halls

    @classmethod
    def of(
        cls,
        halls: Sequence[str],
        journal: str | None = None,
        dead_s: float | None = None,
        allow_inline: bool = True,
        replayed: Callable[[], None] = lambda: None,
    ) -> Halls:
        """Open halls as they are named on a command line: ``NAME=SCENARIO``; their journals are in a folder.

        Raises
        ------
        InputError
            For the first that cannot be had.
        """
        made: dict[str, Hall] = {}
        for text in halls:
            name, file = named(text)
            if name in made:
                raise InputError(f"--hall {text}", "found this hall twice; expected each once")
            path = None if journal is None else Path(journal) / f"{name}.jsonl"
            if path is not None:
                try:
                    path.parent.mkdir(parents=True, exist_ok=True)
                except OSError as error:
                    problem = "found a file" if path.parent.is_file() else f"cannot be made: {error.strerror or error}"
                    raise InputError(f"--journal {journal}", f"{problem}; expected a folder") from error
            scenario = posted(file) if file.endswith(POSTED) else load_scenario(file, [], None)
            made[name] = Hall(scenario, path, dead_s, allow_inline=allow_inline, replayed=replayed)
        return cls(made)

    def answer(self, content: bytes) -> Reply:
        """Answer a request, whatever it is: a batch of facts, or ``get`` (``state``, ``answers`` with ``after``)."""
        return replied(content, self._answer)

    def _answer(self, data: Any) -> Mapping[str, Any]:
        if not isinstance(data, dict):
            raise InputError("request", f"expected a JSON object, found {shown_short(data)}")
        hall = self._hall(data.pop("hall", None))
        if "get" not in data:
            return hall.take(data)
        if data["get"] not in GET:
            raise InputError("request.get", f"found {shown_short(data['get'])}; expected {listed(GET, 'or')}")
        if data["get"] == "state":
            return hall.state
        if data["get"] == "counts":
            return hall.counts
        if data["get"] == "seq":
            return {"seq": hall.seq}
        after = data.get("after", 0)
        if type(after) is not int or not 0 <= after <= hall.seq:
            raise InputError("request.after", f"found {shown_short(after)}; expected 0 to {hall.seq}")
        return {"seq": hall.seq, "answers": hall.since(after)}

    def _hall(self, name: Any) -> Hall:
        if name is None and len(self._halls) == 1:
            return next(iter(self._halls.values()))
        if name is None:
            raise InputError("request.hall", f"is missing; expected {listed(self._halls, 'or')}")
        if not isinstance(name, str) or name not in self._halls:
            raise InputError("request.hall", f"no hall is {shown_short(name)}{nearest(str(name), self._halls)}")
        return self._halls[name]

    @property
    def rules(self) -> tuple[str, ...]:
        """Names of the halls."""
        return tuple(self._halls)


def posted(file: str) -> Scenario:
    """Return the scenario of a hall that was made over HTTP, from the tables that it was made of.

    Raises
    ------
    InputError
        Where it cannot be had; also for whatever names a file.
    """
    tables = read_json(Path(file))
    source = Source("request, scenario")
    for path, text in _texts(tables):
        if "/" in text or "\\" in text:
            raise InputError(source.place_of(path), f"found {shown_short(text)}; expected no file")
    try:
        return Given(tables, Path(file).parent / "no files", source).scenario()
    except KeyProblem as problem:
        raise InputError(source.place_of(problem.path), problem.problem) from None


def _texts(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], str]]:
    """Yield the texts in tables, keys included, each with its path."""
    if isinstance(value, str):
        yield path, value
    elif isinstance(value, Mapping):
        for name, within in value.items():
            yield path, str(name)
            yield from _texts(within, (*path, name))
    elif isinstance(value, Sequence):
        for i, within in enumerate(value):
            yield from _texts(within, (*path, i))


def named(text: str) -> tuple[str, str]:
    """Return name and scenario of a hall as it is named on a command line."""
    name, there, file = text.partition("=")
    if not there or not file or not 0 < len(name) <= 60 or not name.replace("-", "").replace("_", "").isalnum():
        raise InputError(f"--hall {text}", "expected NAME=SCENARIO, with a name of letters, digits, - and _")
    return name, file
