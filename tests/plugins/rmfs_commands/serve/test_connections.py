"""How many connections there may be, and how long."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
import uvicorn
from uvicorn.server import ServerState

from rmfs_commands.serve import connections
from rmfs_commands.serve.connections import Connection

Client = tuple[asyncio.StreamReader, asyncio.StreamWriter]
ASKED = b"GET / HTTP/1.1\r\nHost: here\r\n\r\n"


async def slow(_scope: Any, _receive: Any, send: Any) -> None:
    """Answer when longer has passed than a connection may be silent."""
    await asyncio.sleep(1.5)
    await send({"type": "http.response.start", "status": 204, "headers": []})
    await send({"type": "http.response.body"})


def with_server(do: Callable[[Callable[[], Awaitable[Client]]], Awaitable[None]]) -> None:
    """Do something with a server whose connections may be silent for one second."""

    async def run() -> None:
        config = uvicorn.Config(slow, log_config=None, timeout_keep_alive=1, lifespan="off")
        state = ServerState()
        server = await asyncio.get_running_loop().create_server(lambda: Connection(config, state, {}), "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        async with server:
            await do(lambda: asyncio.open_connection("127.0.0.1", port))

    asyncio.run(run())


@pytest.mark.parametrize("sent", [b"", b"GET / HT"])
def test_who_asks_nothing_is_not_waited_for(sent: bytes) -> None:
    """Neither who says nothing, nor who begins and does not end."""

    async def do(connect: Callable[[], Awaitable[Client]]) -> None:
        reader, writer = await connect()
        writer.write(sent)
        assert await asyncio.wait_for(reader.read(), 20) == b""
        writer.close()

    with_server(do)


def test_who_waits_for_an_answer_gets_it() -> None:
    """However long it takes."""

    async def do(connect: Callable[[], Awaitable[Client]]) -> None:
        reader, writer = await connect()
        writer.write(ASKED)
        assert (await asyncio.wait_for(reader.readline(), 20)).startswith(b"HTTP/1.1 204")
        writer.close()

    with_server(do)


def test_no_more_than_so_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """One more is closed at once; when another has gone there is room again."""
    monkeypatch.setattr(connections, "MOST_CONNECTIONS", 2)

    async def do(connect: Callable[[], Awaitable[Client]]) -> None:
        taken = [await connect() for _ in range(2)]
        for _, writer in taken:
            writer.write(ASKED)
        more, its = await connect()
        assert await more.read() == b""
        its.close()
        for reader, writer in taken:
            assert (await reader.readline()).startswith(b"HTTP/1.1 204")
            writer.close()
            await writer.wait_closed()
        await asyncio.sleep(0.1)
        reader, writer = await connect()
        writer.write(ASKED)
        assert (await reader.readline()).startswith(b"HTTP/1.1 204")
        writer.close()

    with_server(do)
