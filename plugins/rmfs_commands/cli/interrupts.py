"""Ctrl-C while ``rmfs`` runs: none is lost, and none shows a traceback."""

from __future__ import annotations

import signal
import sys
from threading import current_thread, main_thread
from typing import TYPE_CHECKING

from rmfs_core.interrupts import interrupt, interrupt_again

if TYPE_CHECKING:
    from sys import UnraisableHookArgs


def hear_interrupts() -> None:
    """Let Ctrl-C do no harm where it comes, and raise it again where Python drops it: in a finalizer, say."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # a program in the background ignores them
        signal.signal(signal.SIGINT, interrupt)
    sys.unraisablehook = _again


def _again(lost: UnraisableHookArgs) -> None:
    if isinstance(lost.exc_value, KeyboardInterrupt):
        interrupt_again()  # here it would be dropped, too
    else:
        sys.__unraisablehook__(lost)


def ignore_interrupts() -> None:
    """Ignore Ctrl-C from now on: the process prints its last sentence and ends."""
    if current_thread() is main_thread():
        signal.signal(signal.SIGINT, lambda _signal, _frame: None)  # for one that is there already
        signal.signal(signal.SIGINT, signal.SIG_IGN)
