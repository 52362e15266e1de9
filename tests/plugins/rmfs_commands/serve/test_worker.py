"""The process that decides, seen by its pipes."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Any

from rmfs_commands.serve.worker import FAILED, HEAD, READY, WARMING, message


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
    """First it says that it is ready; what a rule prints is not taken for an answer; it ends with its input."""
    prints = state | {"orders": {"print": {"lines": {"jam": 1}}}}
    found, printed = talk(trouble, b"{", json.dumps(prints).encode())
    begun = [status for status, _ in found].index(READY)
    assert {status for status, _ in found[:begun]} == {WARMING}  # nothing of it is compiled
    found = found[begun:]
    assert [status for status, _ in found] == [READY, 400, 200]
    assert found[0][1] == [trouble]
    assert sorted(printed.splitlines()) == ["from below", "hello"]


def test_a_rule_that_is_not_there() -> None:
    """Place and problem, and nothing else."""
    ((status, told),), _ = talk("firstcome")
    assert (status, told[0]) == (FAILED, "--rule firstcome")
