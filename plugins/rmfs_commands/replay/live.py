"""A run that is watched while it goes on: the page of a replay, served on loopback, which asks for what is new.

The server is the standard library's: it needs nothing to be installed, and serves one person on one machine. The
address has a random token, as those of notebooks do: other users of the machine, who reach the port, do not know it.
"""

from __future__ import annotations

import hmac
import re
import secrets
import threading
import time
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qsl

import click

from rmfs_commands.replay.columns import ColumnsBuilder
from rmfs_commands.replay.page import live_page, packed
from rmfs_commands.replay.reading import Replay
from rmfs_commands.replay.telling import told
from rmfs_commands.trace import trace_of
from rmfs_core import hookimpl
from rmfs_core.events import Event
from rmfs_core.info import RunInfo

HOST = "127.0.0.1"
_OWN = re.compile(r"(127\.0\.0\.1|localhost)(:\d+)?", re.ASCII | re.IGNORECASE)
_TICK = re.compile(r"\d{1,18}", re.ASCII)
RUNNING = "running"
REST = 10
"""So many times as long as it took to tell the run it is not told anew: watching costs a tenth of the time at most."""


class Watch:
    """Observer that serves a run as a page on loopback.

    Parameters
    ----------
    name
        Name of the run.

    Attributes
    ----------
    token
        The random text that every request must have.
    address
        Where the page is, with the token; empty before the run starts.
    """

    def __init__(self, name: str = "run") -> None:
        self.name = name
        self.address = ""
        self.token = secrets.token_urlsafe()
        self._server: _Server | None = None
        self._changes = threading.Lock()
        self._telling = threading.Lock()
        self._tick, self._status = 0, RUNNING
        self._told, self._told_tick, self._told_status, self._rests_until = "", -1, "", 0.0

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Serve the page, and say where."""
        self._start = trace_of(run)
        self._builder = ColumnsBuilder(self._start)
        self._server = _Server((HOST, 0), _Handler)
        self._server.watch = self
        self.address = f"http://{HOST}:{self._server.server_port}/?token={self.token}"
        threading.Thread(target=self._server.serve_forever, kwargs={"poll_interval": 0.1}, daemon=True).start()
        click.echo(f"Watch the run at {self.address}", err=True)

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Take an event."""
        with self._changes:
            self._builder.add(event)
            self._tick = event.tick

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        """Tell the page that nothing more will come."""
        with self._changes:
            self._tick, self._status = tick, status

    def wait(self) -> None:
        """Serve on until somebody presses Ctrl-C."""
        click.echo(f"The run is at {self.address} until you press Ctrl-C.", err=True)
        try:
            while True:
                time.sleep(3600)
        except KeyboardInterrupt:
            click.echo(err=True)

    def close(self) -> None:
        """Stop serving."""
        if self._server is not None:
            self._server.shutdown()
            self._server.server_close()
            self._server = None

    def news(self, after: int) -> str | None:
        """Return the run so far, packed as in a page.

        Parameters
        ----------
        after
            The time up to which it is known, in ticks; None is returned where there is nothing new, or it was told a
            moment ago.
        """
        with self._telling:
            ended = self._status != RUNNING
            if ended or (self._tick > after and time.monotonic() >= self._rests_until):
                self._tell(best=ended)
            return self._told if ended or self._told_tick > after else None

    def _tell(self, *, best: bool) -> None:
        if (self._tick, self._status) == (self._told_tick, self._told_status):
            return
        begin = time.monotonic()
        with self._changes:
            columns = self._builder.columns()
            replay = Replay(self.name, self._start, self._tick, self._status, columns, {}, (), None)
            self._told_tick, self._told_status, values = self._tick, self._status, told(replay)
        self._told = packed(values, level=9 if best else 1)
        self._rests_until = time.monotonic() + REST * (time.monotonic() - begin)


class _Server(ThreadingHTTPServer):
    daemon_threads = True
    watch: Watch

    def handle_error(self, *_request: Any) -> None:
        """Say nothing of a browser that has gone away."""


class _Handler(BaseHTTPRequestHandler):
    """Answers with the page, and with the run so far."""

    server: _Server
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        """Answer."""
        path, _, query = self.path.partition("?")
        asked = dict(parse_qsl(query))
        watch = self.server.watch
        # A page of somewhere else may ask, whose name was made to lead here; another port is that of a tunnel.
        if not _OWN.fullmatch(self.headers.get("Host", "")):
            self._answer(HTTPStatus.FORBIDDEN, "text/plain", "This page is for the machine that it runs on.")
        elif not hmac.compare_digest(asked.get("token", "").encode("utf-8"), watch.token.encode("utf-8")):
            problem = "Open the address that rmfs run --watch printed, with its token."
            self._answer(HTTPStatus.FORBIDDEN, "text/plain", problem)
        elif path == "/":
            self._answer(HTTPStatus.OK, "text/html", live_page(watch.name))
        elif path == "/run":
            after = asked.get("after", "")
            text = watch.news(int(after) if _TICK.fullmatch(after) else -1)
            self._answer(HTTPStatus.NO_CONTENT if text is None else HTTPStatus.OK, "text/plain", text or "")
        else:
            self._answer(HTTPStatus.NOT_FOUND, "text/plain", "There is / and /run.")

    def _answer(self, status: HTTPStatus, kind: str, text: str) -> None:
        content = text.encode("utf-8")
        self.send_response(status)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_arguments: Any) -> None:
        """Say nothing: the terminal shows the run."""
