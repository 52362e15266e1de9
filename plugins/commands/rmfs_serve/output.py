"""The standard output of a process that answers there."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from typing import BinaryIO


@contextmanager
def kept_for_answers() -> Iterator[BinaryIO]:
    """Yield the standard output. Whatever else is printed meanwhile, by a rule or a solver, goes to standard error."""
    sys.stdout.flush()
    own = os.dup(1)
    os.dup2(2, 1)
    try:
        with os.fdopen(os.dup(own), "wb") as stream, redirect_stdout(sys.stderr):
            yield stream
    finally:
        os.dup2(own, 1)
        os.close(own)
