"""The HTTP service: what is asked at which path, and what the answer's status is."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Container, Sequence
from typing import Any, Protocol
from urllib.parse import urlsplit

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, ProcessCollector
from prometheus_client.exposition import CONTENT_TYPE_PLAIN_0_0_4, generate_latest
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import HTMLResponse, JSONResponse, RedirectResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp, Receive, Scope, Send
from swagger_ui_bundle import swagger_ui_path

from rmfs_commands.serve.lines import too_long
from rmfs_commands.serve.openapi import PAGE, openapi
from rmfs_commands.serve.process import NoAnswerError, RuleProcess
from rmfs_commands.serve.service import Reply, problem

MOST_WAITING = 64
"""Requests that may be there at a time; what comes besides is told to come again."""
SECONDS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, float("inf"))
"""Bounds of the histogram."""


class Metrics:
    """Counters of the service, for Prometheus.

    Parameters
    ----------
    labels
        Labels of answers besides their status.
    """

    def __init__(self, *labels: str) -> None:
        self.registry = registry = CollectorRegistry()
        self._answers = Counter("rmfs_answers", "Requests, by status", [*labels, "status"], registry=registry)
        told = "From request to answer"
        self.seconds = Histogram("rmfs_answer_seconds", told, labels, buckets=SECONDS, registry=registry)
        self.waiting = Gauge("rmfs_waiting", "Requests that have no answer yet", registry=registry)
        ProcessCollector(registry=registry)

    def follow(self, process: RuleProcess) -> None:
        """Measure the rules' process, too."""
        restarts = Gauge("rmfs_restarts", "How often the rules' process was replaced", registry=self.registry)
        restarts.set_function(lambda: process.restarts)
        ProcessCollector(namespace="rmfs_rules", pid=lambda: process.pid or 0, registry=self.registry)

    def answered(self, status: int, seconds: float, *labels: str) -> None:
        """Count an answer."""
        self._answers.labels(*labels, str(status)).inc()
        (self.seconds.labels(*labels) if labels else self.seconds).observe(seconds)

    def page(self) -> Response:
        """Return all figures in the one format that every reader knows, whatever a request accepts."""
        return Response(generate_latest(self.registry), headers={"Content-Type": CONTENT_TYPE_PLAIN_0_0_4})


class OfHosts:
    """Refuses requests for other hosts: a page of a browser whose own host's name was given this address later.

    Parameters
    ----------
    app
        The app that answers all others.
    hosts
        Names and addresses without ports.
    """

    def __init__(self, app: ASGIApp, hosts: Container[str]) -> None:
        self.app = app
        self.hosts = hosts

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        said = dict(scope["headers"]).get(b"host", b"").decode("latin-1")
        app = self.app if _host(said) in self.hosts else response(problem(421, f'"{said}" is not served here'))
        await app(scope, receive, send)


def _host(said: str) -> str | None:
    try:
        return urlsplit(f"//{said}").hostname
    except ValueError:
        return None


def app_of(process: RuleProcess, most_bytes: int, hosts: Container[str] | None = None) -> Starlette:
    """Return the application that asks a process with rules.

    Parameters
    ----------
    process
        The rules' process.
    most_bytes
        Largest request.
    hosts
        Names by which requests may call this host; None: any.
    """
    metrics = Metrics()
    metrics.follow(process)
    waiting = 0

    async def decide(request: Request) -> Response:
        nonlocal waiting
        started = time.perf_counter()
        waiting += 1
        metrics.waiting.set(waiting)
        try:
            reply = await reply_to(request, process, most_bytes, waiting)
        finally:
            waiting -= 1
            metrics.waiting.set(waiting)
        metrics.answered(reply.status, time.perf_counter() - started)
        return response(reply)

    async def health(_request: Request) -> Response:
        there = process.pid is not None
        return JSONResponse({"status": "ok" if there else "starting", "rules": process.names}, 200 if there else 503)

    async def measured(_request: Request) -> Response:
        return metrics.page()

    routes = [at("/decide", decide, "POST"), at("/health", health), at("/metrics", measured)]
    return around(routes, hosts, lambda: openapi(process.names), "POST /decide, or one of GET /docs, /health, /metrics")


def at(path: str, answer: Callable[[Request], Awaitable[Response]], method: str = "GET") -> Route:
    """Return the route to what answers a path."""
    return Route(path, answer, methods=[method])


def around(
    routes: Sequence[Route], hosts: Container[str] | None, document: Callable[[], dict[str, Any]], expected: str
) -> Starlette:
    """Return the application with these routes, and with what each has: its description, refusals, hosts.

    Parameters
    ----------
    routes
        Paths that are answered.
    hosts
        Names by which requests may call this host; None: any.
    document
        Returns the OpenAPI document.
    expected
        Paths that are answered, for the refusal of any other.
    """

    async def described(_request: Request) -> Response:
        return JSONResponse(document())

    async def page(_request: Request) -> Response:
        return HTMLResponse(PAGE)

    async def start(_request: Request) -> Response:
        return RedirectResponse("/docs")

    async def refused(request: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        reply = response(problem(error.status_code, _said(request, error.status_code, expected)))
        reply.headers.update(error.headers or {})
        return reply

    app = Starlette(
        routes=[
            *routes,
            at("/openapi.json", described),
            at("/docs", page),
            at("/", start),
            Mount("/docs/files", StaticFiles(directory=swagger_ui_path)),
        ],
        middleware=[] if hosts is None else [Middleware(OfHosts, hosts=hosts)],
        exception_handlers={HTTPException: refused},
    )
    app.router.redirect_slashes = False  # the address that it redirects to is what the request says of itself
    return app


class Answering(Protocol):
    """Object that answers the content of a request, within a time."""

    @property
    def limit_s(self) -> float:
        """Seconds that a request may take to arrive, and wait for its turn."""

    async def ask(self, content: bytes, /) -> Reply:
        """Return the answer, or raise NoAnswerError."""


async def reply_to(request: Request, process: Answering, most_bytes: int, waiting: int) -> Reply:
    """Return the reply to a request whose body is JSON, whatever it is; ``waiting``: requests that are there now."""
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind != "application/json":
        return problem(415, f'found Content-Type "{kind}"; expected application/json')
    if waiting > MOST_WAITING:
        return problem(503, f"{MOST_WAITING} requests are waiting already; expected this one later")
    try:
        async with asyncio.timeout(process.limit_s):
            content = await _content(request, most_bytes)
        return too_long(most_bytes) if content is None else await process.ask(content)
    except TimeoutError:
        return problem(408, f"the request was not there within {process.limit_s:g} s")
    except ClientDisconnect:
        return problem(400, "the request ended before its end")
    except NoAnswerError as error:
        return problem(error.status, str(error))


async def _content(request: Request, most_bytes: int) -> bytes | None:
    """Return the body of a request, or None when it is too long: then the rest of it is not read."""
    said = request.headers.get("content-length", "")
    if said.isdecimal() and int(said[:19]) > most_bytes:
        return None
    content = bytearray()
    async for part in request.stream():
        content += part
        if len(content) > most_bytes:
            return None
    return bytes(content)


def response(reply: Reply) -> Response:
    """Return a reply as HTTP has it."""
    kind = "application/json" if reply.status < 300 else "application/problem+json"
    written = Response(reply.content, reply.status, {"Content-Type": kind})
    if reply.status == 503:
        written.headers["Retry-After"] = "1"
    if reply.status in (408, 413):  # there is more of the request, which nobody reads
        written.headers["Connection"] = "close"
    return written


def _said(request: Request, status: int, expected: str) -> str:
    if status == 404:
        return f"there is nothing at {request.url.path}; expected {expected}"
    return f"{request.method} {request.url.path} is not answered; the header Allow says what is"
