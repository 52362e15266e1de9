"""`rmfs serve --hall ... --stdio`: sessions by lines."""

import json
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from calling import refused
from cases import cases
from rmfs_commands.cli.main import main

SMALL = Path(__file__).parents[4] / "scenarios" / "examples" / "small.toml"


@contextmanager
def served(rmfs: tuple[str, ...], *arguments: str) -> Iterator["subprocess.Popen[bytes]"]:
    command = (*rmfs, "serve", *arguments, "--stdio")
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        yield process
        process.kill()


def ask(process: "subprocess.Popen[bytes]", request: Any) -> Any:
    process.stdin.write(json.dumps(request).encode() + b"\n")
    process.stdin.flush()
    return json.loads(process.stdout.readline())


def test_lines_name_their_hall(rmfs: tuple[str, ...]) -> None:
    batch = {"after": 0, "time_s": 1, "events": []}
    with served(rmfs, "--hall", f"a={SMALL}", "--hall", f"b={SMALL}") as process:
        assert ask(process, {"hall": "a", **batch})["seq"] == 1
        assert ask(process, {"hall": "b", "get": "state"})["session"]["seq"] == 0
        stale = ask(process, {"hall": "a", **batch, "time_s": 2})
        assert (stale["status"], stale["seq"]) == (409, 1)
        for request, status, detail in (
            (batch, 422, "hall: is missing; expected a or b"),
            ({"hall": "c", **batch}, 422, "no hall is"),
            ({"hall": "a", "get": "all"}, 422, "expected state, answers, seq or counts"),
            ({"hall": "a", "get": "answers", "after": 2}, 422, "expected 0 to 1"),
        ):
            answer = ask(process, request)
            assert answer["status"] == status
            assert detail in answer["detail"]


@cases(
    "arguments problem",
    (["--hall", "a"], "expected NAME=SCENARIO"),
    (["--hall", f"a={SMALL}", "--hall", f"a={SMALL}"], "found this hall twice"),
    (["--hall", f"a={SMALL}", "--rule", "pod-match"], "found --rule with --hall"),
    (["--rule", "pod-match", "--journal", "x"], "found --journal with --rule"),
    ([], "Missing option '--rule' or '--hall'"),
)
def test_what_cannot_be_served_is_refused(
    capsys: pytest.CaptureFixture[str], arguments: list[str], problem: str
) -> None:
    assert problem in refused(capsys, main, ["serve", *arguments, "--stdio"])
