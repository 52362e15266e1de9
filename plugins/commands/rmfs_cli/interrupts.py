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


def hear_every_interrupt() -> None:
    """Raise an interrupt again that came where Python drops what is raised: in a finalizer, or another's callback."""
    sys.unraisablehook = _again


def _again(lost: UnraisableHookArgs) -> None:
    if isinstance(lost.exc_value, KeyboardInterrupt):
        again = Timer(AGAIN_S, _thread.interrupt_main)  # here it would be dropped, too
        again.daemon = True
        again.start()
    else:
        sys.__unraisablehook__(lost)


def hear_no_more_interrupts() -> None:
    """Let nothing interrupt the last words of a process, nor its end."""
    if current_thread() is main_thread():
        signal.signal(signal.SIGINT, lambda _signal, _frame: None)  # for one that is there already
        signal.signal(signal.SIGINT, signal.SIG_IGN)
