"""Ways to another program: one that is started and speaks by lines, or one that is asked over HTTP."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from http.client import HTTPConnection, HTTPException, HTTPSConnection
from typing import Protocol
from urllib.parse import urlsplit

from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.wording import shown_short

MOST_BYTES = 50_000_000
"""Bytes of one answer."""


class Channel(Protocol):
    """Takes requests to a program and brings its answers."""

    def ask(self, request: bytes) -> bytes:
        """Return the answer to a request, each one line; raise `ImpossibleError` where there is none."""

    def close(self) -> None:
        """End what was opened or started."""


class Command:
    """Starts a program; each request is a line to it, each answer a line from it.

    Parameters
    ----------
    words
        The program and its arguments.
    timeout_s
        Seconds that an answer may take.
    """

    def __init__(self, words: Sequence[str], timeout_s: float) -> None:
        self._name = shlex.join(words)
        self._timeout_s = timeout_s
        program = shutil.which(words[0])
        if program is None:
            raise ImpossibleError(f"cannot start `{self._name}`: there is no program {words[0]}")
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed with the program
        try:
            self._process = subprocess.Popen(
                [program, *words[1:]],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
                start_new_session=True,  # so that it can be ended with what it starts
            )
        except OSError as error:
            raise ImpossibleError(f"cannot start `{self._name}`: {error.strerror or error}") from error
        self._asked = False
        self._exchanging = ThreadPoolExecutor(1)  # a pipe has no time limit of its own, least of all on Windows

    def ask(self, request: bytes) -> bytes:
        """Return the program's next line."""
        if further := self._further():
            told = shown_short(further.decode(errors="replace").strip())
            raise ImpossibleError(f"`{self._name}` said {told} before it was asked; expected one line per request")
        self._asked = True
        answer = self._exchanging.submit(self._exchange, request)
        try:
            line = answer.result(self._timeout_s)
        except TimeoutError:
            self.close()
            raise ImpossibleError(f"`{self._name}` gave no answer within {self._timeout_s:g} s") from None
        except OSError:  # it reads no more
            line = b""
        self._asked = False
        if not line.endswith(b"\n"):
            raise ImpossibleError(self._ended(line))
        return line

    def _further(self) -> bytes:
        """Return what the program has said that nobody asked for, where the system shows that without waiting."""
        assert self._process.stdout is not None
        if sys.platform == "win32":  # a pipe with nothing in it would fail there
            return b""
        os.set_blocking(self._process.stdout.fileno(), False)
        found: bytes = self._process.stdout.peek()  # type: ignore[attr-defined]
        os.set_blocking(self._process.stdout.fileno(), True)
        return found

    def _exchange(self, request: bytes) -> bytes:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(request + b"\n")
        self._process.stdin.flush()
        return self._process.stdout.readline(MOST_BYTES)

    def _ended(self, line: bytes) -> str:
        """Say why there is no whole line."""
        if len(line) == MOST_BYTES:
            return f"`{self._name}` answered with a line of more than {MOST_BYTES:,} bytes"
        self._end()
        self._errors.seek(0)
        said = self._errors.read().decode(errors="replace").strip().splitlines()
        last = f", and said {shown_short(said[-1])}" if said else ""
        return f"`{self._name}` ended with exit code {self._process.returncode} and without an answer{last}"

    def close(self) -> None:
        """End the program: at the end of its input, or by force a second later."""
        self._end()
        self._errors.close()

    def _end(self) -> None:
        """End the program: at the end of its input where it reads, else by force, with what it has started."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        if not self._asked:  # else a thread may hold the pipe
            with suppress(OSError):  # it reads no more
                self._process.stdin.close()
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(1)
        if self._process.poll() is None or self._asked:
            if hasattr(os, "killpg"):
                with suppress(ProcessLookupError, PermissionError):
                    os.killpg(self._process.pid, signal.SIGKILL)
            self._process.kill()
            self._process.wait()
        self._exchanging.shutdown()
        for pipe in (self._process.stdin, self._process.stdout):
            with suppress(OSError):
                pipe.close()


class Address:
    """Asks a program over HTTP: each request a POST of JSON.

    Parameters
    ----------
    url
        Where, as ``http://127.0.0.1:8750/decide``.
    timeout_s
        Seconds without a byte of an answer, at most.
    """

    def __init__(self, url: str, timeout_s: float) -> None:
        parts = urlsplit(url)
        kind = HTTPSConnection if parts.scheme == "https" else HTTPConnection
        self._url = url
        self._timeout_s = timeout_s
        self._path = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
        self._connection = kind(parts.hostname or "", parts.port, timeout=timeout_s)

    def ask(self, request: bytes) -> bytes:
        """Return the body of the answer."""
        for again in (True, False):
            fresh = self._connection.sock is None
            try:
                self._connection.request("POST", self._path, request, {"Content-Type": "application/json"})
                reply = self._connection.getresponse()
                body = reply.read(MOST_BYTES)
                break
            except TimeoutError:
                self.close()
                raise ImpossibleError(f"{self._url} gave no answer within {self._timeout_s:g} s") from None
            except (OSError, HTTPException) as error:
                self.close()
                if fresh or not again:  # a connection that was open may have been closed since: the other side's right
                    told = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)
                    raise ImpossibleError(f"{self._url} gave no answer: {told or type(error).__name__}") from error
        if reply.status != 200:
            raise ImpossibleError(f"{self._url} answered with status {reply.status}{_detail(body)}")
        return body

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()


def _detail(body: bytes) -> str:
    """Return what a refusal says, as RFC 9457 has it."""
    try:
        return f": {json.loads(body)['detail']}"
    except (ValueError, TypeError, KeyError):
        return ""
