"""The process in which the rules of the HTTP service decide: ``python -m rmfs_commands.serve.worker``.

Standard input has requests, standard output their answers, each with its status and its length before it.
"""

from __future__ import annotations

import json
import os
import select
import signal
import struct
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, BinaryIO

from rmfs_commands.cli.streams import kept_output, no_input, own_input
from rmfs_commands.serve.halls import Halls
from rmfs_commands.serve.service import Service
from rmfs_core.errors import InputError
from rmfs_core.roles import Role

HEAD = struct.Struct(">HQ")
"""Before each message: a status (of a request: 0), and the length of what follows."""
READY, FAILED, WARMING, COMPILING = 1, 2, 3, 4
"""Status of the first messages: the rules are ready (their names follow), or cannot be had (place and problem). Before
that: they are loaded and decide for the first time (once for each decision), and something is compiled for them."""


def message(status: int, content: bytes) -> bytes:
    """Return a message as it is sent."""
    return HEAD.pack(status, len(content)) + content


def main() -> None:
    """Load the rules that the first argument names, say so, and answer until there are no more requests."""
    settings = json.loads(sys.argv[1])
    _end_with_service()
    with no_input(), kept_output() as answers:
        requests = own_input()
        try:
            service = _service(settings, lambda: _send(answers, WARMING, b""))
        except InputError as error:
            _send(answers, FAILED, json.dumps([error.place, error.problem]).encode())
            return
        with _compiling_told(lambda status: _send(answers, status, b"")):
            _send(answers, WARMING, b"")
            for _ in service.warm_up() if isinstance(service, Service) else ():
                _send(answers, WARMING, b"")
        _send(answers, READY, json.dumps(service.rules).encode())
        while head := requests.read(HEAD.size):
            _, length = HEAD.unpack(head)
            reply = service.answer(requests.read(length))
            _send(answers, reply.status, reply.content)


def _service(settings: Mapping[str, Any], replayed: Callable[[], None]) -> Service | Halls:
    if "halls" in settings:
        return Halls.of(**settings, replayed=replayed)
    decides = None if settings["decides"] is None else Role.labelled(settings["decides"])
    return Service.of(settings["rules"], settings["settings"], decides, settings["allow_inline"])


@contextmanager
def _compiling_told(tell: Callable[[int], None]) -> Iterator[None]:
    """Tell when something begins to be compiled, which takes its time once, and when that is done."""
    from numba.core import event

    class Teller(event.Listener):
        under_way = 0

        def on_start(self, event: object) -> None:  # noqa: ARG002
            self.under_way += 1
            tell(COMPILING)

        def on_end(self, event: object) -> None:  # noqa: ARG002
            self.under_way -= 1
            tell(COMPILING if self.under_way else WARMING)

    with event.install_listener("numba:compile", Teller()):
        yield


def _end_with_service() -> None:
    """Have this process's group killed when the service that started it ends, however that ends.

    Whoever is killed cannot end its processes itself, and a rule that computes does not see that its input has ended.
    So a copy of this process, which waits for that and nothing else, kills the group.
    """
    if not hasattr(os, "fork") or os.getpgrp() != os.getpid() or os.fork():  # a group with others in it is not ours
        return
    os.closerange(1, 256)  # else the service would take this process for the one that answers
    poll = select.poll()
    poll.register(0, 0)  # of the end alone; what comes is not for this process
    while not poll.poll():
        pass
    os.killpg(0, signal.SIGKILL)


def _send(answers: BinaryIO, status: int, content: bytes) -> None:
    answers.write(message(status, content))
    answers.flush()


if __name__ == "__main__":
    main()
