"""Listening and answering until somebody ends it."""

from __future__ import annotations

import asyncio
import ipaddress
import os
import signal
import socket
from collections.abc import Callable, Container
from contextlib import ExitStack
from types import FrameType
from typing import Protocol

import uvicorn
from starlette.types import ASGIApp

from rmfs_commands.serve.connections import MOST_AT_ONCE, Connection
from rmfs_core.errors import InputError

FAREWELL_S = 3
"""Seconds that decisions have when the service is ended."""
LOOPBACK = ("localhost", "127.0.0.1", "::1")
"""Host names of requests from this machine to itself."""
KEEP_ALIVE_S = 60
"""Seconds that a connection stays open on which nothing is asked, or no request comes to its end."""


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens; port 0 is any free one."""
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        family, kind, protocol, _, address = found[0]
        # asyncio takes delays out of connections (TCP_NODELAY) whose socket names its protocol: 40 ms an answer
        with ExitStack() as opened:
            listening = opened.enter_context(socket.socket(family, kind, protocol))
            if os.name == "posix":  # elsewhere it would let two listen at one port
                listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listening.bind(address)
            listening.listen()
            opened.pop_all()
            return listening
    except (OSError, UnicodeError) as error:
        problem = f"cannot listen there: {getattr(error, 'strerror', None) or error}"
        raise InputError(f"--host {host} --port {port}", problem) from error


def is_loopback(listening: socket.socket) -> bool:
    """Whether none but this machine reaches a socket."""
    return ipaddress.ip_address(listening.getsockname()[0].partition("%")[0]).is_loopback


def url_of(listening: socket.socket) -> str:
    """Return where a socket is reached."""
    host, port = listening.getsockname()[:2]
    return f"http://[{host}]:{port}" if ":" in host else f"http://{host}:{port}"


class Served(Protocol):
    """Processes that answer."""

    async def start(self) -> None:
        """Start them."""

    async def stop(self) -> None:
        """End them."""


App = Callable[[Container[str] | None], ASGIApp]
"""Returns the application that asks processes, by the hosts that requests may name."""


def serve(process: Served, app: App, host: str, port: int, ready: Callable[[socket.socket], None]) -> None:
    """Start processes, listen, and answer until SIGINT (Ctrl-C) or SIGTERM.

    Parameters
    ----------
    process
        The processes, not started.
    app
        Asks them.
    host, port
        Where to listen.
    ready
        Called with the socket as soon as requests are taken.

    Raises
    ------
    KeyboardInterrupt
        When it was Ctrl-C, and everything has ended in order.
    """
    if asyncio.run(_serve(process, app, host, port, ready)):
        raise KeyboardInterrupt


class _Server(uvicorn.Server):
    """A server that gives up decisions which take too long when it is to end."""

    def __init__(self, config: uvicorn.Config, process: Served) -> None:
        super().__init__(config)
        self._process = process
        self.interrupted = False

    def handle_exit(self, number: int, frame: FrameType | None) -> None:
        """Begin to end, and take note of which signal it was."""
        self.interrupted |= number == signal.SIGINT
        super().handle_exit(number, frame)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Wait for what is under way, a while."""

        async def give_up() -> None:
            await asyncio.sleep(FAREWELL_S)
            await self._process.stop()

        waiting = asyncio.create_task(give_up())
        await super().shutdown(sockets)
        waiting.cancel()


async def _serve(process: Served, app: App, host: str, port: int, ready: Callable[[socket.socket], None]) -> bool:
    """Serve; return whether Ctrl-C has ended it."""
    with listen(host, port) as listening:
        try:
            await process.start()
            config = uvicorn.Config(
                app({*LOOPBACK, host} if is_loopback(listening) else None),
                http=Connection,
                backlog=MOST_AT_ONCE,
                log_config=None,
                log_level="error",
                access_log=False,
                server_header=False,
                ws="none",
                lifespan="off",
                timeout_keep_alive=KEEP_ALIVE_S,
                timeout_graceful_shutdown=2 * FAREWELL_S,
            )
            server = _Server(config, process)
            for number in (signal.SIGINT, signal.SIGTERM):  # uvicorn's own handlers would have them end the process
                signal.signal(number, server.handle_exit)
            ready(listening)
            await server.serve(sockets=[listening])
            return server.interrupted
        finally:
            await process.stop()
