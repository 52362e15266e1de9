"""``rmfs serve --stdio``: a request a line, an answer a line."""

from __future__ import annotations

from typing import BinaryIO

from rmfs_commands.serve.halls import Halls
from rmfs_commands.serve.service import Reply, Service, problem


def serve_lines(service: Service | Halls, requests: BinaryIO, answers: BinaryIO, most_bytes: int) -> None:
    """Answer each line as it comes, until there are no more; empty lines are passed over."""
    while line := requests.readline(most_bytes + 1):
        if not line.strip():
            continue
        answers.write(_answer(service, line, requests, most_bytes).content)
        answers.flush()


def _answer(service: Service | Halls, line: bytes, requests: BinaryIO, most_bytes: int) -> Reply:
    if len(line.rstrip(b"\r\n")) <= most_bytes:
        return service.answer(line)
    while line and not line.endswith(b"\n"):  # the rest of it
        line = requests.readline(most_bytes + 1)
    return too_long(most_bytes)


def too_long(most_bytes: int) -> Reply:
    """Return the reply to a request of too many bytes."""
    return problem(413, f"request: found more than {most_bytes:,} bytes; expected at most that many (`--max-mb`)")
