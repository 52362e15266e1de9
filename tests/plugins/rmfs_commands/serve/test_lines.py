"""JSON lines."""

from __future__ import annotations

import io
import json
from typing import Any

from rmfs_commands.serve.lines import serve_lines
from rmfs_commands.serve.service import Service


def asked(text: bytes, most_bytes: int = 1_000_000) -> list[dict[str, Any]]:
    """Return what is answered to some text."""
    answers = io.BytesIO()
    serve_lines(Service.of(["first-come"]), io.BytesIO(text), answers, most_bytes)
    return [json.loads(line) for line in answers.getvalue().splitlines()]


def test_an_answer_a_line(state: dict[str, Any]) -> None:
    """In the order of the requests; what is wrong is a line, too, and an empty line none."""
    line = json.dumps(state).encode()
    first, second, third = asked(b"\n" + line + b"\r\nnonsense\n" + line)
    assert first == third
    assert (first["decides"], second["status"]) == ("POA", 400)


def test_a_line_that_is_too_long(state: dict[str, Any]) -> None:
    """It is passed over to its end; one of just the length that is allowed is answered."""
    line = json.dumps(state).encode()
    first, second = asked(b"x" * 5 * len(line) + b"\n" + line + b"\n", len(line))
    assert first["detail"] == f"request: found more than {len(line)} bytes; expected at most that many (`--max-mb`)"
    assert second["decides"] == "POA"
    assert [told["status"] for told in asked(b"x" * 9, 8)] == [413]
