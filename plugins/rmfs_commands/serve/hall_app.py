"""Halls over HTTP: what is asked at which path."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Container, Iterator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

from attrs import frozen
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse

from rmfs_commands.serve.app import Metrics, around, at, reply_to, response
from rmfs_commands.serve.hall_openapi import openapi_of_halls
from rmfs_commands.serve.hall_processes import HallProcesses
from rmfs_commands.serve.process import NoAnswerError
from rmfs_commands.serve.service import Reply, problem

MOST_FOLLOWING = 32
"""Requests for commands that may wait at a time."""
WAIT_S, BEAT_S = 25.0, 15.0
"""Seconds that such a request waits for the next batch unless it says otherwise, at most; a stream's pauses."""


COUNTS: Mapping[str, tuple[type[CounterMetricFamily | GaugeMetricFamily], str]] = {
    "seq": (GaugeMetricFamily, "Number of the last batch"),
    "facts": (CounterMetricFamily, "Facts that were taken, since the journal began"),
    "dropped": (CounterMetricFamily, "Facts that contradicted the state, since the journal began"),
    "open_orders": (GaugeMetricFamily, "Orders that are neither complete nor cancelled"),
    "awaited": (GaugeMetricFamily, "Facts that commands and robots wait for"),
    "overdue": (GaugeMetricFamily, "What nothing was heard of for --dead-s, in the last answer"),
    "quarantined": (GaugeMetricFamily, "Entries of session.quarantine"),
    "restarts": (CounterMetricFamily, "How often the hall's process was replaced"),
}
"""Figures of each hall."""


class Counts(Collector):
    """Figures of halls; ``halls`` has them by name."""

    halls: Mapping[str, Mapping[str, float]] = {}

    def collect(self) -> Iterator[Metric]:
        """Yield what is measured, with a value for each hall."""
        for name, (kind, told) in COUNTS.items():
            family = kind(f"rmfs_hall_{name}", told, labels=["hall"])
            for hall, counts in self.halls.items():
                family.add_metric([hall], counts[name])
            yield family


@frozen
class _Asked:
    """A question to a hall."""

    how: Callable[[str, bytes], Awaitable[Reply]]
    hall: str
    limit_s: float

    async def ask(self, content: bytes, /) -> Reply:
        return await self.how(self.hall, content)


class HallApp:
    """Answers requests to halls.

    Parameters
    ----------
    halls
        The halls.
    most_bytes
        Largest request.
    """

    def __init__(self, halls: HallProcesses, most_bytes: int) -> None:
        self._halls, self._most_bytes = halls, most_bytes
        self._waiting = self._following = 0
        self._metrics, self._counts = Metrics("hall"), Counts()
        self._metrics.registry.register(self._counts)

    def within(self, hosts: Container[str] | None = None) -> Starlette:
        """Return the application.

        Parameters
        ----------
        hosts
            Names by which requests may call this host; None: any.
        """
        one = "/v1/halls/{hall}"
        routes = [
            at("/v1/halls", self._names),
            at(one, self._make, "POST"),
            at(one, self._state),
            at(one, self._replace, "PUT"),
            at(one, self._end, "DELETE"),
            at(f"{one}/events", self._events, "POST"),
            at(f"{one}/commands", self._commands),
            at("/health", self._health),
            at("/metrics", self._measured),
        ]
        return around(
            routes, hosts, openapi_of_halls, "/v1/halls, /v1/halls/NAME, or one of GET /docs, /health, /metrics"
        )

    async def _names(self, _request: Request) -> Response:
        return JSONResponse({"halls": self._halls.names})

    async def _health(self, _request: Request) -> Response:
        there = self._halls.there
        told = {"status": "ok" if there else "starting", "halls": self._halls.names}
        return JSONResponse(told, 200 if there else 503)

    async def _posted(self, request: Request, how: Callable[[str, bytes], Awaitable[Reply]]) -> Response:
        hall, started = request.path_params["hall"], time.perf_counter()
        self._waiting += 1
        self._metrics.waiting.set(self._waiting)
        try:
            reply = await reply_to(request, _Asked(how, hall, self._halls.limit_s), self._most_bytes, self._waiting)
        finally:
            self._waiting -= 1
            self._metrics.waiting.set(self._waiting)
        if hall in self._halls.names:
            self._metrics.answered(reply.status, time.perf_counter() - started, hall)
        return response(reply)

    async def _measured(self, _request: Request) -> Response:
        halls = self._halls.names
        replies = await asyncio.gather(*(_told(self._halls.ask(hall, {"get": "counts"})) for hall in halls))
        found = {
            hall: json.loads(reply.content) for hall, reply in zip(halls, replies, strict=True) if reply.status == 200
        }
        self._counts.halls = {
            hall: {**counts, "restarts": self._halls.restarts(hall)} for hall, counts in found.items()
        }
        return self._metrics.page()

    async def _make(self, request: Request) -> Response:
        return await self._posted(request, self._halls.make)

    async def _events(self, request: Request) -> Response:
        return await self._posted(request, self._halls.ask)

    async def _state(self, request: Request) -> Response:
        reply = await _told(self._halls.ask(request.path_params["hall"], {"get": "state"}))
        shown = response(reply)
        if reply.status == 200:
            shown.headers["ETag"] = f'"{json.loads(reply.content)["session"]["seq"]}"'
        return shown

    async def _replace(self, request: Request) -> Response:
        said = _matched(request)
        if not _is_number(said):
            return response(problem(422, "If-Match: expected the number of the last batch"))
        return await self._posted(request, partial(self._halls.replace, int(said)))

    async def _end(self, request: Request) -> Response:
        said = _matched(request)
        if "if-match" in request.headers and not _is_number(said):
            return response(problem(422, "If-Match: expected the number of the last batch, or no such header"))
        return response(await _told(self._halls.end(request.path_params["hall"], int(said) if said else None)))

    async def _commands(self, request: Request) -> Response:
        after = request.query_params.get("after", request.headers.get("last-event-id", "0"))
        wait = request.query_params.get("wait_s", f"{WAIT_S}")
        if not _is_number(after):
            return response(problem(422, "after: expected the number of a batch"))
        if not (_is_number(wait.replace(".", "", 1)) and float(wait) <= WAIT_S):
            return response(problem(422, f"wait_s: expected seconds from 0 to {WAIT_S:g}"))
        if self._following >= MOST_FOLLOWING:
            waiting = f"{MOST_FOLLOWING} requests for commands are waiting already"
            return response(problem(503, f"{waiting}; expected this one later"))
        hall, streamed = request.path_params["hall"], "text/event-stream" in request.headers.get("accept", "")
        self._following += 1
        try:
            reply = await self._next(hall, int(after), 0.0 if streamed else float(wait))
        finally:
            self._following -= 1
        if streamed and reply.status == 200:
            return StreamingResponse(self._stream(hall, int(after)), media_type="text/event-stream")
        return response(reply)

    async def _stream(self, hall: str, after: int) -> AsyncIterator[bytes]:
        self._following += 1
        try:
            while (reply := await self._next(hall, after, BEAT_S)).status == 200:
                answers: list[Mapping[str, Any]] = json.loads(reply.content)["answers"]
                for answer in answers:
                    after = int(answer["seq"])
                    yield f"id: {after}\ndata: {json.dumps(answer, separators=(',', ':'))}\n\n".encode()
                if not answers:
                    yield b":\n\n"
        finally:
            self._following -= 1

    async def _next(self, hall: str, after: int, wait_s: float) -> Reply:
        """Return the answers after a batch, as soon as there are some, or none after some seconds."""
        time = asyncio.get_running_loop().time
        until = time() + wait_s
        while True:
            news = self._halls.news(hall)  # from before the question, so that nothing falls in between
            reply = await _told(self._halls.ask(hall, {"get": "answers", "after": after}))
            if reply.status != 200 or json.loads(reply.content)["answers"] or time() >= until:
                return reply
            with suppress(TimeoutError):
                await asyncio.wait_for(news.wait(), until - time())


def _matched(request: Request) -> str:
    return request.headers.get("if-match", "").strip().strip('"')


def _is_number(text: str) -> bool:
    return text.isascii() and text.isdecimal() and len(text) < 18


async def _told(reply: Awaitable[Reply]) -> Reply:
    try:
        return await reply
    except NoAnswerError as error:
        return problem(error.status, str(error))
