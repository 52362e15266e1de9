"""Fixtures for tests of the decision service."""

import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

Serve = Callable[..., tuple["subprocess.Popen[str]", int]]

TROUBLE = """
import os, sys, time
from attrs import define
from rmfs_core import hookimpl

@define
class Trouble:
    "POA: nothing; what else it does, the name of the first order says."
    @hookimpl
    def assign_orders(self, warehouse):
        name = warehouse.backlog[0].name if warehouse.backlog else ""
        if name == "print":
            print("hello")
            os.system("echo from below")
        if name == "sleep":
            time.sleep(60)
        if name == "exit":
            os._exit(7)
        if name == "raise":
            raise ZeroDivisionError("nothing to divide")
        return []
"""


@pytest.fixture
def state() -> dict[str, Any]:
    return {
        "format": "rmfs-state",
        "version": 2,
        "pods": {"P1": {"contents": {"milk": 3, "tea": 1}}, "P2": {"contents": {"jam": 6}}},
        "stations": {"north": {"item_capacity": 4, "inbound": ["P1"]}},
        "orders": {"A": {"lines": {"milk": 1, "tea": 1}}, "B": {"lines": {"jam": 2}, "due_s": 900}},
    }


@pytest.fixture
def trouble(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return the name of a rule in a file of the current folder that does what an order is called."""
    (tmp_path / "trouble.py").write_text(TROUBLE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return "./trouble.py:Trouble"


@pytest.fixture
def rmfs() -> tuple[str, ...]:
    return (sys.executable, "-c", "from rmfs_commands.cli.main import main; main()")


@pytest.fixture
def serve(rmfs: tuple[str, ...]) -> Iterator[Serve]:
    """Return a function that starts a service at a free port; it is ended with the test."""
    started: list[subprocess.Popen[str]] = []

    def start(*arguments: str) -> tuple[subprocess.Popen[str], int]:
        command = (*rmfs, "serve", *arguments, "--port", "0")
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        started.append(process)
        line = process.stdout.readline()
        found = re.search(r" at http://.+:(\d+); Ctrl-C ends it\.$", line)
        assert found, (line, process.communicate())
        return process, int(found[1])

    yield start
    for process in started:
        process.kill()
        process.communicate()
