"""The rules' process as the HTTP service sees it: asked one request at a time, replaced when it takes too long.

A search that is compiled or a solver may hold Python's lock as long as it runs: in a thread it could neither be ended
nor would anything else be answered meanwhile.
"""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from rmfs_commands.serve.service import Reply
from rmfs_commands.serve.worker import COMPILING, FAILED, HEAD, WARMING, message
from rmfs_core.errors import InputError, RmfsError

START_S = 30.0
"""Seconds that loading the rules, and each first decision, may take at least; compiling does not count."""


class NoAnswerError(RmfsError):
    """A request gets no answer, for no fault of its own; ``status`` is that of HTTP."""

    status = 503


class BusyError(NoAnswerError):
    """A request's turn did not come in time."""


class LateError(NoAnswerError):
    """A decision took too long."""

    status = 504


class EndedError(NoAnswerError):
    """The rules' process has ended, or cannot be started again."""


class RuleProcess:
    """A process with rules in it.

    Parameters
    ----------
    rules, settings, decides, allow_inline
        As for `rmfs_commands.serve.service.Service.of`; ``decides`` by its label.
    limit_s
        Seconds that a request may wait for its turn, and that a decision may take.
    start_s
        Seconds that loading the rules, and each first decision, may take at least.

    Attributes
    ----------
    restarts
        How often the process had to be replaced.
    names
        The rules' names.
    """

    def __init__(
        self,
        rules: Sequence[str],
        settings: Sequence[str] = (),
        decides: str | None = None,
        allow_inline: bool = True,
        limit_s: float = 30.0,
        start_s: float = START_S,
    ) -> None:
        self._tell({"rules": rules, "settings": settings, "decides": decides, "allow_inline": allow_inline})
        self.limit_s, self.start_s = limit_s, start_s
        self.restarts = 0
        self.names: tuple[str, ...] = ()
        self._turn = asyncio.Lock()
        self._process: asyncio.subprocess.Process | None = None
        self._replacing: asyncio.Task[None] | None = None
        self._watching: asyncio.Task[None] | None = None
        self._stopped = False

    @classmethod
    def of_hall(
        cls, hall: str, journal: str, dead_s: float | None, allow_inline: bool = True, limit_s: float = 30.0
    ) -> RuleProcess:
        """Return a process with a hall in it, given as for `rmfs_commands.serve.halls.Halls.of`."""
        process = cls((), limit_s=limit_s)
        process._tell({"halls": [hall], "journal": journal, "dead_s": dead_s, "allow_inline": allow_inline})
        return process

    def _tell(self, settings: dict[str, Any]) -> None:
        # -P: a file in the current folder that is called like a module is not taken for it
        self._command = (sys.executable, "-P", "-m", "rmfs_commands.serve.worker", json.dumps(settings))

    @property
    def pid(self) -> int | None:
        """Number of the process; None while it is being started, or when it has ended."""
        return self._process.pid if self._process is not None and self._process.returncode is None else None

    async def start(self) -> None:
        """Start the process and wait until the rules are loaded.

        Raises
        ------
        InputError
            When one of them cannot be had.
        """
        async with self._turn:  # requests that come meanwhile wait for it
            await self._start()

    async def _start(self) -> None:
        pipes: dict[str, Any] = {"stdin": asyncio.subprocess.PIPE, "stdout": asyncio.subprocess.PIPE}
        # A session of its own: Ctrl-C is for the service, which ends it, and all that rules have started there.
        process = await asyncio.create_subprocess_exec(*self._command, **pipes, start_new_session=True)
        try:
            limit_s = max(self.limit_s, self.start_s)
            status = WARMING
            while status in (COMPILING, WARMING):  # each decision has its own time
                async with asyncio.timeout(None if status == COMPILING else limit_s):
                    status, content = await _receive(process)
        except BaseException as error:
            _kill(process)
            code = await process.wait()
            if isinstance(error, TimeoutError):
                problem = f"the rules were not loaded, or one did not decide, within {limit_s:g} s"
                raise EndedError(problem) from None
            if isinstance(error, asyncio.IncompleteReadError):
                raise EndedError(f"the rules' process ended with code {code} as it started") from None
            raise
        if status == FAILED:
            await process.wait()
            raise InputError(*json.loads(content))
        self.names = tuple(json.loads(content))
        self._process = process
        self._watching = asyncio.create_task(_end_group(process))

    async def ask(self, content: bytes) -> Reply:
        """Return the answer to a request.

        Raises
        ------
        BusyError, LateError, EndedError
            When there is none.
        """
        try:
            async with asyncio.timeout(self.limit_s):
                await self._turn.acquire()
        except TimeoutError:
            raise BusyError(f"other requests came first; this one was not begun within {self.limit_s:g} s") from None
        try:
            if self._stopped:
                raise EndedError("the service ends")
            if self.pid is None:
                await self._start_again()
            return await self._exchange(content)
        finally:
            self._turn.release()

    async def stop(self) -> None:
        """End the process; callers that wait for an answer get an error."""
        self._stopped = True
        if self._replacing is not None:
            self._replacing.cancel()
        if self._process is not None:
            process, self._process = self._process, None
            _kill(process)  # it keeps nothing that were worth a farewell
            await process.wait()

    async def _exchange(self, content: bytes) -> Reply:
        process = self._process
        assert process is not None and process.stdin is not None
        try:
            async with asyncio.timeout(self.limit_s):
                process.stdin.write(message(0, content))
                await process.stdin.drain()
                status, content = await _receive(process)
            while status == WARMING:  # a hall whose batch failed takes its journal again, and says so batch by batch
                async with asyncio.timeout(self.limit_s):
                    status, content = await _receive(process)
            return Reply(status, content)
        except BaseException as error:  # an answer that still came would be taken for the next request's
            self._process = None
            _kill(process)
            if self._stopped:
                raise EndedError("the service ends") from None
            self._replacing = asyncio.create_task(self._replace())
            if isinstance(error, TimeoutError):
                raise LateError(f"no decision within {self.limit_s:g} s (`--limit-s`); it was given up") from None
            if isinstance(error, asyncio.IncompleteReadError | ConnectionError):
                raise EndedError(f"the rules' process ended with code {await process.wait()}") from None
            raise

    async def _replace(self) -> None:
        async with self._turn:
            if self._process is None and not self._stopped:
                try:
                    await self._start_again()
                except EndedError as error:  # the next request tries again, and is told
                    print(f"Note: {error}.", file=sys.stderr)

    async def _start_again(self) -> None:
        try:
            await self._start()
        except InputError as error:
            raise EndedError(f"the rules cannot be loaded again: {error}") from error
        self.restarts += 1


async def _end_group(process: asyncio.subprocess.Process) -> None:
    """Wait for a process to end, and end what it leaves: that may hold open the pipe for its answers."""
    await process.wait()
    _kill(process)


def _kill(process: asyncio.subprocess.Process) -> None:
    """Kill the process and, where there are such, its group: whatever its rules have started."""
    with suppress(ProcessLookupError):  # all have ended by themselves
        if sys.platform == "win32":
            process.kill()
        else:  # the process's own `kill` may take the code of one that has ended before asyncio does
            os.killpg(process.pid, signal.SIGKILL)


async def _receive(process: asyncio.subprocess.Process) -> tuple[int, bytes]:
    assert process.stdout is not None
    status, length = HEAD.unpack(await process.stdout.readexactly(HEAD.size))
    return status, await process.stdout.readexactly(length)
