"""Ctrl-C while ``rmfs`` runs: none is lost, and none shows a traceback."""

from __future__ import annotations

import _thread
import signal
import sys
from threading import Timer, current_thread, main_thread
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

AGAIN_S = 0.02
"""Seconds after which an interrupt that was dropped is raised again."""


def repeat_lost_interrupts() -> None:
    """Raise an interrupt again that Python drops, since it came in a finalizer or in a callback of a library."""
    sys.unraisablehook = _again


def _again(lost: UnraisableHookArgs) -> None:
    if isinstance(lost.exc_value, KeyboardInterrupt):
        again = Timer(AGAIN_S, _thread.interrupt_main)  # here it would be dropped, too
        again.daemon = True
        again.start()
    else:
        sys.__unraisablehook__(lost)


def ignore_interrupts() -> None:
    """Ignore Ctrl-C from now on: the process prints its last sentence and ends."""
    if current_thread() is main_thread():
        signal.signal(signal.SIGINT, lambda _signal, _frame: None)  # for one that is there already
        signal.signal(signal.SIGINT, signal.SIG_IGN)
