"""Halls as the HTTP service sees them: a process for each, made and ended while the service runs."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rmfs_commands.results.files import to_json, write_text
from rmfs_commands.serve.halls import POSTED, named
from rmfs_commands.serve.process import EndedError, RuleProcess
from rmfs_commands.serve.service import Reply, line_of, problem
from rmfs_commands.session.facts import check_finite
from rmfs_commands.states.state_json import parse_json
from rmfs_core.errors import InputError

MOST_HALLS = 16
"""Halls at a time; each has a process of its own."""


class HallProcesses:
    """Halls by name.

    Parameters
    ----------
    halls
        ``NAME=SCENARIO`` each. Those that were made over HTTP before are found in the folder of journals.
    journal
        Folder with the journals.
    dead_s, allow_inline
        As for `rmfs_commands.session.Hall`; halls made over HTTP never load rules from files.
    limit_s
        Seconds that a request may wait for its turn, and that an answer may take.
    """

    def __init__(
        self, halls: Sequence[str], journal: str, dead_s: float | None, allow_inline: bool = True, limit_s: float = 30.0
    ) -> None:
        self._folder, self._dead_s, self.limit_s = Path(journal), dead_s, limit_s
        self._processes: dict[str, RuleProcess] = {}
        self._news: dict[str, asyncio.Event] = {}
        for text in halls:
            name, _ = named(text)
            if name in self._processes:
                raise InputError(f"--hall {text}", "found this hall twice; expected each once")
            self._processes[name] = RuleProcess.of_hall(text, journal, dead_s, allow_inline, limit_s)
        for file in sorted(self._folder.glob(f"*{POSTED}")):
            if (name := file.name.removesuffix(POSTED)) in self._processes:
                raise InputError(f"--hall {name}", f"is a hall that was made over HTTP: {file}; expected another name")
            self._processes[name] = self._posted(name, file)

    def _posted(self, name: str, file: Path) -> RuleProcess:
        return RuleProcess.of_hall(f"{name}={file}", str(self._folder), self._dead_s, False, self.limit_s)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the halls."""
        return tuple(self._processes)

    def restarts(self, hall: str) -> int:
        """Return how often a hall's process had to be replaced."""
        return self._processes[hall].restarts if hall in self._processes else 0

    @property
    def there(self) -> bool:
        """Whether all halls have their process now."""
        return all(process.pid is not None for process in self._processes.values())

    async def start(self) -> None:
        """Start all processes, and wait until they have taken their journals again.

        Raises
        ------
        InputError
            When one of the halls cannot be had.
        """
        await asyncio.gather(*(process.start() for process in self._processes.values()))

    async def stop(self) -> None:
        """End all processes."""
        await asyncio.gather(*(process.stop() for process in self._processes.values()))

    def news(self, hall: str) -> asyncio.Event:
        """Return what is set when a hall has taken its next batch."""
        return self._news.setdefault(hall, asyncio.Event()) if hall in self._processes else asyncio.Event()

    async def ask(self, hall: str, request: bytes | Mapping[str, Any]) -> Reply:
        """Return a hall's reply to a request, as `rmfs_commands.serve.halls.Halls.answer` gives it.

        Raises
        ------
        NoAnswerError
            When there is none.
        """
        if (process := self._processes.get(hall)) is None:
            return problem(404, f'there is no hall "{hall[:60]}"')
        reply = await process.ask(request if isinstance(request, bytes) else line_of(request))
        if isinstance(request, bytes) and reply.status == 200 and hall in self._news:
            self._news.pop(hall).set()
        return reply

    async def replace(self, after: int, hall: str, content: bytes) -> Reply:
        """Put a state into the place of a hall's own, if the last batch that it has taken is this one."""
        state = content.strip()
        if not (state.startswith(b"{") and state.endswith(b"}")):
            return problem(422, "expected a state, a JSON object")
        return await self.ask(hall, b'{"after":%d,"state":%b}' % (after, state))

    async def make(self, hall: str, content: bytes) -> Reply:
        """Make a hall of the tables of a scenario, ``{"scenario": {...}}``."""
        try:
            scenario = _scenario_in(content, hall)
        except InputError as error:
            return problem(422, str(error), error.place)
        file = self._folder / f"{hall}{POSTED}"
        if hall in self._processes:
            same = file.exists() and file.read_text(encoding="utf-8") == to_json(scenario)
            if same and not await self._seq(hall):
                return Reply(201, line_of({"session": hall, "seq": 0}))
            return problem(409, f'there is a hall "{hall}" already')
        if len(self._processes) >= MOST_HALLS:
            return problem(503, f"there are {MOST_HALLS} halls already; expected one ended first")
        self._folder.mkdir(parents=True, exist_ok=True)
        write_text(file, to_json(scenario))
        process = self._processes[hall] = self._posted(hall, file)
        try:
            await process.start()
        except BaseException as error:
            del self._processes[hall]
            file.unlink()
            await process.stop()
            if isinstance(error, InputError):
                return problem(422, str(error), error.place)
            raise
        return Reply(201, line_of({"session": hall, "seq": await self._seq(hall)}))  # of a journal that was there

    async def _seq(self, hall: str) -> int:
        reply = await self.ask(hall, {"get": "seq"})
        if reply.status != 200:
            raise EndedError("somebody else ends it")
        return int(json.loads(reply.content)["seq"])

    async def end(self, hall: str, seq: int | None) -> Reply:
        """End a hall, if the last batch that it has taken is this one; its journal is kept under another name."""
        reply = await self.ask(hall, {"get": "seq"})
        if reply.status != 200:
            return reply
        last = json.loads(reply.content)["seq"]
        if seq not in (None, last):
            return problem(409, f"If-Match: found {seq}; expected {last}, the last batch", seq=last)
        if (process := self._processes.pop(hall, None)) is None:
            raise EndedError("somebody else ends it")
        (self._folder / f"{hall}{POSTED}").unlink(missing_ok=True)
        journal = self._folder / f"{hall}.jsonl"
        number = next(n for n in range(1, 1_000_000) if not (self._folder / f"{hall}.{n}.jsonl").exists())
        if journal.exists():
            journal.rename(self._folder / f"{hall}.{number}.jsonl")
        if hall in self._news:
            self._news.pop(hall).set()
        await process.stop()  # not before: a hall that is made meanwhile has files of the same names
        return Reply(200, line_of({"seq": last}))


def _scenario_in(content: bytes, hall: str) -> Mapping[str, Any]:
    named(f"{hall}=x")
    given = parse_json(content, "request")
    if not isinstance(given, dict) or not isinstance(given.get("scenario"), dict) or len(given) > 1:
        raise InputError("request", "expected an object with `scenario`, the tables of a scenario, and nothing else")
    check_finite("request.scenario", given["scenario"])
    return given["scenario"]  # type: ignore[no-any-return]
