"""The process in which the rules of the HTTP service decide: ``python -m rmfs_serve.worker``.

Standard input has requests, standard output their answers, each with its status and its length before it.
"""

from __future__ import annotations

import json
import struct
import sys
from typing import BinaryIO

from rmfs_cli.streams import kept_output, no_input, own_input
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_serve.service import Service

HEAD = struct.Struct(">HQ")
"""Before each message: a status (of a request: 0), and the length of what follows."""
READY, FAILED = 1, 2
"""Status of the first message: the rules are loaded (their names follow), or cannot be had (place and problem)."""


def message(status: int, content: bytes) -> bytes:
    """Return a message as it is sent."""
    return HEAD.pack(status, len(content)) + content


def main() -> None:
    """Load the rules that the first argument names, say so, and answer until there are no more requests."""
    settings = json.loads(sys.argv[1])
    with no_input(), kept_output() as answers:
        requests = own_input()
        try:
            decides = None if settings["decides"] is None else Role.labelled(settings["decides"])
            service = Service.of(settings["rules"], settings["settings"], decides, settings["allow_inline"])
        except InputError as error:
            _send(answers, FAILED, json.dumps([error.place, error.problem]).encode())
            return
        service.warm_up()
        _send(answers, READY, json.dumps(service.rules).encode())
        while head := requests.read(HEAD.size):
            _, length = HEAD.unpack(head)
            reply = service.answer(requests.read(length))
            _send(answers, reply.status, reply.content)


def _send(answers: BinaryIO, status: int, content: bytes) -> None:
    answers.write(message(status, content))
    answers.flush()


if __name__ == "__main__":
    main()
