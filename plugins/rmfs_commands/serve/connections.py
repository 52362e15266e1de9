"""Connections to the service: never more than there can be files, and none on which nothing is asked."""

from __future__ import annotations

import asyncio

from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle

MOST_CONNECTIONS = 100
"""Connections that may be open at a time: the 64 that may wait, some more, and fewer than any system lets be open."""
MOST_AT_ONCE = 64
"""Connections that are taken before any of them is looked at."""


class Connection(H11Protocol):
    """A connection that is closed where there are too many, or where it is silent for too long.

    Silent is also who begins a request and does not come to its end: uvicorn gives up connections on which nothing
    comes between two requests, and waits forever within one.
    """

    _silence: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take the connection, or close it at once."""
        super().connection_made(transport)
        if len(self.connections) > MOST_CONNECTIONS:
            transport.close()
        else:
            self._listen()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        if self._silence is not None:
            self._silence.cancel()
        super().connection_lost(exc)

    def _listen(self) -> None:
        self._silence = self.loop.call_later(self.timeout_keep_alive, self._check, self.cycle)

    def _check(self, last: RequestResponseCycle | None) -> None:
        if self.cycle is last and (last is None or last.response_complete):
            self.transport.close()
        else:
            self._listen()
