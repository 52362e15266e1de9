"""Paths and statuses, without a network and without rules."""

from __future__ import annotations

import asyncio
import json
from typing import Any, cast

import pytest
from attrs import define, field

from rmfs_commands.serve.app import MOST_WAITING, app_of
from rmfs_commands.serve.process import BusyError, EndedError, LateError, RuleProcess
from rmfs_commands.serve.service import Reply
from rmfs_core.errors import RmfsError

JSON = {"content-type": "application/json"}

SCOPE = {"type": "http", "method": "POST", "path": "/decide", "headers": [(b"content-type", b"application/json")]}
"""What a server tells an application of a request."""


@define
class Scripted:
    """In place of rules: a reply, or an error."""

    answer: Reply | RmfsError = field(factory=lambda: Reply(200, b'{"decides":"POA"}\n'))
    pid: int | None = 1
    names: tuple[str, ...] = ("scripted",)
    restarts: int = 3
    limit_s: float = 5.0
    gate: asyncio.Event | None = None

    async def ask(self, content: bytes) -> Reply:
        if self.gate is not None:
            await self.gate.wait()
        if isinstance(self.answer, RmfsError):
            raise self.answer
        return self.answer


class Client:
    """Calls an application as a server does.

    Parameters
    ----------
    process
        What decides.
    most_bytes
        The longest request.
    hosts
        What requests may call it.
    """

    def __init__(self, process: Scripted, most_bytes: int = 1000, hosts: tuple[str, ...] | None = None) -> None:
        self.app = app_of(cast(RuleProcess, process), most_bytes, hosts)

    async def call(
        self, method: str, path: str, content: bytes = b"", headers: dict[str, str] | None = None, parts: int = 1
    ) -> tuple[int, dict[str, str], bytes]:
        """Return status, headers and content of an answer."""
        size = max(-(-len(content) // parts), 1)
        pieces = [content[i : i + size] for i in range(0, len(content), size)] or [b""]
        messages = [
            {"type": "http.request", "body": piece, "more_body": i + 1 < len(pieces)} for i, piece in enumerate(pieces)
        ]
        scope = {
            "type": "http",
            "asgi": {"version": "3.0"},
            "http_version": "1.1",
            "method": method,
            "scheme": "http",
            "path": path,
            "root_path": "",
            "query_string": b"",
            "headers": [(name.encode(), value.encode()) for name, value in (headers or {}).items()],
        }
        sent: list[Any] = []

        async def receive() -> Any:
            return messages.pop(0) if messages else {"type": "http.disconnect"}

        async def send(message: Any) -> None:
            sent.append(message)

        await self.app(scope, receive, send)
        found = {name.decode(): value.decode() for name, value in sent[0]["headers"]}
        return sent[0]["status"], found, b"".join(message.get("body", b"") for message in sent[1:])


def call(process: Scripted, *arguments: Any, **options: Any) -> tuple[int, dict[str, str], bytes]:
    """Call a new application once."""
    return asyncio.run(Client(process).call(*arguments, **options))


def test_a_decision() -> None:
    """The reply as it is."""
    status, headers, content = call(
        Scripted(), "POST", "/decide", b"{}", {"content-type": "Application/JSON; charset=utf-8"}
    )
    assert (status, headers["content-type"], content) == (200, "application/json", b'{"decides":"POA"}\n')


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("localhost:8000", 200),
        ("[::1]:8000", 200),
        ("LOCALHOST", 200),
        ("example.org:8000", 421),
        ("", 421),
        ("[", 421),
    ],
)
def test_only_requests_for_this_host(host: str, status: int) -> None:
    """A web page cannot have a browser ask in its name, even if its own host's name leads here."""
    client = Client(Scripted(), hosts=("localhost", "::1"))
    got, _, content = asyncio.run(client.call("POST", "/decide", b"{}", {**JSON, "host": host}))
    assert got == status
    assert status == 200 or json.loads(content)["detail"] == f'"{host}" is not served here'


@pytest.mark.parametrize(
    "accept",
    [
        *("", "*/*", "application/json", ";,=;q=x", "\xff", "text/plain; version=1.0.0; escaping=allow-utf-8"),
        *("application/openmetrics-text; version=abc", "application/openmetrics-text;version"),
    ],
)
def test_figures_whatever_the_request_accepts(accept: str) -> None:
    """As text, which every reader of such figures knows."""
    status, headers, content = call(Scripted(), "GET", "/metrics", headers={"accept": accept})
    assert (status, headers["content-type"]) == (200, "text/plain; version=0.0.4; charset=utf-8")
    assert b"rmfs_restarts 3.0" in content


@pytest.mark.parametrize(
    ("answer", "status", "more"),
    [
        (Reply(422, b"{}\n"), 422, {}),
        (BusyError("busy"), 503, {"retry-after": "1"}),
        (EndedError("ended"), 503, {"retry-after": "1"}),
        (LateError("late"), 504, {}),
    ],
)
def test_no_decision(answer: Reply | RmfsError, status: int, more: dict[str, str]) -> None:
    """Problems after RFC 9457, each with its status."""
    got, headers, content = call(Scripted(answer), "POST", "/decide", b"{}", JSON)
    assert (got, headers["content-type"]) == (status, "application/problem+json")
    assert more.items() <= headers.items()
    if isinstance(answer, RmfsError):
        assert json.loads(content)["detail"] == str(answer)


@pytest.mark.parametrize(
    ("method", "path", "headers", "content", "status", "detail"),
    [
        ("POST", "/decide", {}, b"{}", 415, 'found Content-Type ""; expected application/json'),
        ("POST", "/decide", {"content-type": "text/plain"}, b"{}", 415, "expected application/json"),
        ("POST", "/decide", JSON | {"content-length": "1001"}, b"", 413, "found more than 1,000 bytes"),
        ("POST", "/decide", JSON | {"content-length": "9" * 5000}, b"", 413, "found more than 1,000 bytes"),
        ("POST", "/decide", JSON, b" " * 1001, 413, "found more than 1,000 bytes"),
        ("GET", "/decide", {}, b"", 405, "GET /decide is not answered"),
        ("POST", "/health", {}, b"", 405, "POST /health is not answered"),
        ("GET", "/health/", {"host": "example.org"}, b"", 404, "there is nothing at /health/"),
        ("GET", "/nowhere", {}, b"", 404, "there is nothing at /nowhere"),
        ("GET", "/docs/files/nothing.js", {}, b"", 404, "there is nothing at"),
    ],
)
def test_what_is_wrong_with_a_request(
    method: str, path: str, headers: dict[str, str], content: bytes, status: int, detail: str
) -> None:
    """Before any rule is asked; the size counts as it comes, whatever was said before."""
    got, found, told = call(Scripted(), method, path, content, headers, parts=3)
    assert (got, found["content-type"]) == (status, "application/problem+json")
    assert detail in json.loads(told)["detail"]
    assert ("allow" in found) == (status == 405)


def test_too_many_at_a_time() -> None:
    """Whoever comes when so many wait is told to come again, at once."""

    async def run() -> None:
        process = Scripted(gate=asyncio.Event())
        client = Client(process)
        waiting = [asyncio.create_task(client.call("POST", "/decide", b"{}", JSON)) for _ in range(MOST_WAITING)]
        await asyncio.sleep(0)
        status, headers, _ = await client.call("POST", "/decide", b"{}", JSON)
        assert (status, headers["retry-after"]) == (503, "1")
        cast(asyncio.Event, process.gate).set()
        assert {status for status, _, _ in await asyncio.gather(*waiting)} == {200}
        assert b'rmfs_answers_total{status="200"} 64.0' in (await client.call("GET", "/metrics"))[2]

    asyncio.run(run())


def test_a_request_that_does_not_come() -> None:
    """Who sends nothing more is not waited for without end."""

    async def run() -> int:
        app = app_of(cast(RuleProcess, Scripted(limit_s=0.01)), 1000)
        sent: list[Any] = []

        async def send(message: Any) -> None:
            sent.append(message)

        await app(SCOPE | {"root_path": "", "query_string": b""}, asyncio.Event().wait, send)
        return int(sent[0]["status"])

    assert asyncio.run(run()) == 408


def test_a_request_that_breaks_off() -> None:
    """A client that goes in the middle of its request leaves no trace but a count."""

    async def run() -> int:
        client, sent = Client(Scripted()), []

        async def receive() -> Any:
            return {"type": "http.disconnect"}

        async def send(message: Any) -> None:
            sent.append(message)

        await client.app(SCOPE | {"root_path": "", "query_string": b""}, receive, send)
        return int(sent[0]["status"])

    assert asyncio.run(run()) == 400


def test_health() -> None:
    """Ready, or not yet again."""
    assert call(Scripted(), "GET", "/health")[::2] == (200, b'{"status":"ok","rules":["scripted"]}')
    assert call(Scripted(pid=None), "GET", "/health")[0] == 503


def test_metrics() -> None:
    """Prometheus' text format: statuses, times, the process."""

    async def run() -> list[str]:
        client = Client(Scripted())
        await client.call("POST", "/decide", b"{}", JSON)
        await client.call("POST", "/decide", b"{}")
        status, headers, content = await client.call("GET", "/metrics")
        assert (status, headers["content-type"].partition(";")[0]) == (200, "text/plain")
        return content.decode().splitlines()

    lines = asyncio.run(run())
    for line in ('rmfs_answers_total{status="200"} 1.0', 'rmfs_answers_total{status="415"} 1.0', "rmfs_waiting 0.0"):
        assert line in lines
    assert {"rmfs_restarts 3.0", "rmfs_answer_seconds_count 2.0"} <= {*lines}
    assert any(line.startswith("rmfs_rules_process_resident_memory_bytes ") for line in lines)


def test_the_page_and_its_files() -> None:
    """Everything the page names is there, and nothing of it on another machine."""
    status, _, content = call(Scripted(), "GET", "/docs")
    page = content.decode()
    assert status == 200 and "//" not in page
    files = [part.split('"')[0] for part in page.split('"docs/')[1:]]
    assert len(files) == 3
    for file in files:
        assert call(Scripted(), "GET", f"/docs/{file}")[0] == 200
    assert call(Scripted(), "GET", "/")[1]["location"].endswith("/docs")
    assert json.loads(call(Scripted(), "GET", "/openapi.json")[2])["openapi"].startswith("3.")
