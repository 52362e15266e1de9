"""The rules' process: asked, given up, replaced."""

from __future__ import annotations

import asyncio
import json
import os
import signal
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from rmfs_core.errors import InputError
from rmfs_serve.process import BusyError, EndedError, LateError, RuleProcess


def with_process(rule: str, limit_s: float, do: Callable[[RuleProcess], Awaitable[None]]) -> None:
    """Do something with a process that is running."""

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
    """A decision that takes too long is given up, and so is who waited for it too long; then it goes on as before."""

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
    """Who asks next is answered all the same."""

    async def do(process: RuleProcess) -> None:
        assert process.pid is not None
        os.kill(process.pid, signal.SIGKILL)
        while process.pid is not None:
            await asyncio.sleep(0.01)
        assert (await process.ask(json.dumps(state).encode())).status == 200
        assert process.restarts == 1

    with_process("first-come", 30, do)


def test_large_requests(state: dict[str, Any]) -> None:
    """Longer than any pipe holds."""

    async def do(process: RuleProcess) -> None:
        content = json.dumps(state).encode()
        reply = await process.ask(content + b" " * 3_000_000)
        assert reply == await process.ask(content)

    with_process("first-come", 30, do)


def test_a_rule_that_is_not_there() -> None:
    """The sentence is that of the process."""
    with pytest.raises(InputError, match=r'^--rule firstcome: there is no rule "firstcome" \(did you mean'):
        asyncio.run(RuleProcess(["firstcome"]).start())
