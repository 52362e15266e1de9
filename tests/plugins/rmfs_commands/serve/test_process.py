"""The process that decides: asked, given up, replaced, seen by its pipes."""

import asyncio
import io
import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from rmfs_commands.serve.lines import serve_lines
from rmfs_commands.serve.process import BusyError, EndedError, LateError, RuleProcess
from rmfs_commands.serve.service import Service
from rmfs_commands.serve.worker import FAILED, HEAD, READY, WARMING, message
from rmfs_core.errors import InputError

SPAWNING = """
import subprocess, time
from attrs import define
from rmfs_core import hookimpl

@define
class Spawning:
    "POA: starts a child; asked about an order called hang, or always, it never returns."
    always: bool = False
    @hookimpl
    def assign_orders(self, warehouse):
        child = subprocess.Popen(["sleep", "600"])
        with open("children", "a") as file:
            print(child.pid, file=file)
        while self.always or any(order.name == "hang" for order in warehouse.backlog):
            pass
        return []
"""


def living(pids: Iterable[int]) -> list[int]:
    """Return the processes that have not ended, of some."""
    found = []
    for pid in pids:
        with suppress(FileNotFoundError, ProcessLookupError):
            if Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0] != "Z":
                found.append(pid)
    return found


def ended(pids: Iterable[int]) -> bool:
    until = time.monotonic() + 20
    while living(pids) and time.monotonic() < until:
        time.sleep(0.02)
    return not living(pids)


@pytest.fixture
def spawning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "spawning.py").write_text(SPAWNING, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path / "children"


def numbers(children: Path) -> list[int]:
    return [*map(int, children.read_text(encoding="utf-8").split())]


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads the states of processes as Linux has them")
def test_children_of_rules_end_with_their_process(spawning: Path, state: dict[str, Any]) -> None:
    async def do(process: RuleProcess) -> None:
        begun = numbers(spawning)
        assert living(begun) == begun
        with pytest.raises(LateError):
            await process.ask(json.dumps(state | {"orders": {"hang": {"lines": {"jam": 1}}}}).encode())
        assert await asyncio.to_thread(ended, begun)
        process.limit_s = 30
        assert (await process.ask(json.dumps(state).encode())).status == 200
        assert living(numbers(spawning))
        os.kill(process.pid, signal.SIGKILL)
        assert await asyncio.to_thread(ended, numbers(spawning))

    with_process("./spawning.py:Spawning", 1, do)
    assert ended(numbers(spawning))


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="reads the states of processes as Linux has them")
def test_nothing_outlives_a_service_that_is_killed(spawning, state, rmfs) -> None:
    """Not even a rule that computes and would never see the end of its input."""
    command = [*rmfs, "serve", "--rule", "./spawning.py:Spawning", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as service:
        address = service.stdout.readline().partition(" at ")[2].partition(";")[0]
        hanging = json.dumps(state | {"orders": {"hang": {"lines": {"jam": 1}}}}).encode()
        before = len(numbers(spawning))
        with socket.create_connection((urlsplit(address).hostname, urlsplit(address).port)) as client:
            head = "POST /decide HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: "
            client.sendall(head.encode() + b"%d\r\n\r\n" % len(hanging) + hanging)
            while len(numbers(spawning)) == before:
                time.sleep(0.02)
            group = os.getpgid(numbers(spawning)[-1])
            assert living([group]) == [group]
            service.kill()
    assert ended([group, *numbers(spawning)])


def test_a_first_decision_that_never_returns(spawning: Path) -> None:
    async def run() -> None:
        rule = "{ rule = './spawning.py:Spawning', always = true }"
        process = RuleProcess([rule], limit_s=0.5, start_s=4)
        with pytest.raises(EndedError, match=r"the rules were not loaded, or one did not decide, within 4 s"):
            await process.start()
        assert process.pid is None

    asyncio.run(run())
    assert ended(numbers(spawning))


def with_process(rule: str, limit_s: float, do: Callable[[RuleProcess], Awaitable[None]]) -> None:
    async def run() -> None:
        process = RuleProcess([rule], limit_s=limit_s)
        await process.start()
        try:
            await do(process)
        finally:
            await process.stop()
        assert process.pid is None

    asyncio.run(run())


def test_late_busy_ended(trouble: str, state: dict[str, Any]) -> None:
    def named(name: str) -> bytes:
        return json.dumps(state | {"orders": {name: {"lines": {"jam": 1}}}}).encode()

    async def do(process: RuleProcess) -> None:
        first = process.pid
        slow, late, after = await asyncio.gather(
            process.ask(named("sleep")), process.ask(named("A")), process.ask(named("B")), return_exceptions=True
        )
        assert isinstance(slow, LateError)
        assert str(slow) == "no decision within 0.7 s (`--limit-s`); it was given up"
        assert all(isinstance(one, BusyError) for one in (late, after))
        process.limit_s = 30  # the machine may be busy
        assert (await process.ask(named("A"))).status == 200
        assert process.pid not in (None, first)
        with pytest.raises(EndedError, match="ended with code 7"):
            await process.ask(named("exit"))
        replies = await asyncio.gather(*(process.ask(named(name)) for name in "ABCD"))
        assert [reply.status for reply in replies] == [200] * 4
        assert process.restarts == 2

    with_process(trouble, 0.7, do)


def test_a_process_that_was_ended_by_somebody(state: dict[str, Any]) -> None:
    async def do(process: RuleProcess) -> None:
        os.kill(process.pid, signal.SIGKILL)
        while process.pid is not None:
            await asyncio.sleep(0.01)
        assert (await process.ask(json.dumps(state).encode())).status == 200
        assert process.restarts == 1

    with_process("first-come", 30, do)


def test_large_requests(state: dict[str, Any]) -> None:
    async def do(process: RuleProcess) -> None:
        content = json.dumps(state).encode()
        reply = await process.ask(content + b" " * 3_000_000)
        assert reply == await process.ask(content)

    with_process("first-come", 30, do)


def test_a_rule_that_is_not_there() -> None:
    with pytest.raises(InputError, match=r'^--rule firstcome: there is no rule "firstcome" \(did you mean'):
        asyncio.run(RuleProcess(["firstcome"]).start())
    ((status, told),), _ = talk("firstcome")
    assert (status, told[0]) == (FAILED, "--rule firstcome")


def talk(rule: str, *requests: bytes) -> tuple[list[tuple[int, Any]], str]:
    """Return the messages of a process with a rule, and what it writes to standard error."""
    told = {"rules": [rule], "settings": [], "decides": None, "allow_inline": True}
    command = (sys.executable, "-m", "rmfs_commands.serve.worker", json.dumps(told))
    given = b"".join(message(0, request) for request in requests)
    done = subprocess.run(command, input=given, capture_output=True, check=True)
    found, rest = [], done.stdout
    while rest:
        status, length = HEAD.unpack(rest[: HEAD.size])
        content = rest[HEAD.size : HEAD.size + length]
        found.append((status, json.loads(content) if content else None))
        rest = rest[HEAD.size + length :]
    return found, done.stderr.decode()


def test_requests_and_answers(trouble: str, state: dict[str, Any]) -> None:
    prints = state | {"orders": {"print": {"lines": {"jam": 1}}}}
    found, printed = talk(trouble, b"{", json.dumps(prints).encode())
    begun = [status for status, _ in found].index(READY)
    assert {status for status, _ in found[:begun]} == {WARMING}  # nothing of it is compiled
    found = found[begun:]
    assert [status for status, _ in found] == [READY, 400, 200]
    assert found[0][1] == [trouble]
    assert sorted(printed.splitlines()) == ["from below", "hello"]


def asked(text: bytes, most_bytes: int = 1_000_000) -> list[dict[str, Any]]:
    answers = io.BytesIO()
    serve_lines(Service.of(["first-come"]), io.BytesIO(text), answers, most_bytes)
    return [json.loads(line) for line in answers.getvalue().splitlines()]


def test_answers_and_lines(state: dict[str, Any]) -> None:
    line = json.dumps(state).encode()
    first, second, third = asked(b"\n" + line + b"\r\nnonsense\n" + line)
    assert first == third
    assert (first["decides"], second["status"]) == ("POA", 400)
    line = json.dumps(state).encode()
    first, second = asked(b"x" * 5 * len(line) + b"\n" + line + b"\n", len(line))
    assert first["detail"] == f"request: found more than {len(line)} bytes; expected at most that many (`--max-mb`)"
    assert second["decides"] == "POA"
    assert [told["status"] for told in asked(b"x" * 9, 8)] == [413]
