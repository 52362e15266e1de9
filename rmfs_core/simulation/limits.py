"""Ending a call that does not return in time."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Mapping
from threading import current_thread, main_thread
from typing import Any

AGAIN_S = 0.5
"""Seconds after which code that has caught the first `OverdueError` gets the next."""


class OverdueError(BaseException):
    """A call took too long. No `Exception`: code that catches whatever goes wrong must not catch it."""


def within(limit_s: float, call: Callable[..., Any], arguments: Mapping[str, Any]) -> Any:
    """Return what a call returns; end it when it takes too long.

    A signal ends it, not another process: what is called works on objects of this one, and keeps what it learns. So it
    is ended where Python runs or waits. Compiled code is ended when it returns to Python, and compiling goes on to its
    end. On Windows, and outside the main thread, there is no such signal: no call is ended.

    Parameters
    ----------
    limit_s
        Wall-clock seconds.
    call, arguments
        The function and its arguments.

    Raises
    ------
    OverdueError
        When it was ended.
    """
    if not hasattr(signal, "setitimer") or current_thread() is not main_thread():
        return call(**arguments)
    watching = True

    def ring(_signal: int, _frame: object) -> None:
        locks: Any = sys.modules.get("numba.core.compiler_lock")  # where numba is not imported, nothing is compiled
        if watching and not (locks and locks.global_compiler_lock.is_locked()):  # what is compiled is kept
            raise OverdueError

    before = signal.signal(signal.SIGALRM, ring)
    try:
        try:
            signal.setitimer(signal.ITIMER_REAL, limit_s, AGAIN_S)
            return call(**arguments)
        finally:
            watching = False
    finally:  # reached by an alarm in the line above, too; the next is far
        watching = False
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
