"""Ctrl-C while ``rmfs`` runs: heard where it does no harm, not in the middle of an import or of what LLVM does.

None is lost, and none shows a traceback.
"""

from __future__ import annotations

import _thread
import signal
import sys
import time
from threading import Timer, current_thread, main_thread
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sys import UnraisableHookArgs
    from types import FrameType

AGAIN_S = 0.02
"""Seconds after which an interrupt that came at a bad moment is raised again."""
PATIENCE_S = 5.0
"""Seconds after which it is raised in spite of that: what is imported may never end."""

NOT_WITHIN = ("importlib._bootstrap", "joblib.externals.loky", "llvmlite")
"""Modules, with those below them, that an exception at any line leaves in a state nobody expects.

A module that is imported by halves cannot be imported again; a process pool loses count of its work; and LLVM, whose
call for machine code comes back without any, has functions at address zero: the process dies.
"""


class Interrupt:
    """A handler of SIGINT that raises KeyboardInterrupt, as Python's own does, or a moment later where that would harm.

    Parameters
    ----------
    not_within
        Prefixes of names of modules that are left before an interrupt is raised.
    """

    ends_runs = True
    """A run in the foreground ends between two events, not by this handler."""

    def __init__(self, not_within: tuple[str, ...]) -> None:
        self.not_within = not_within
        self._postponed_until_s: float | None = None

    def __call__(self, _signal: int, frame: FrameType | None) -> None:
        """Handle the signal."""
        now_s = time.monotonic()
        until_s = self._postponed_until_s
        if until_s is None or now_s > until_s + 1:  # another handler has heard the last one meanwhile
            until_s = now_s + PATIENCE_S
        if now_s < until_s and self._harms(frame):
            self._postponed_until_s = until_s
            interrupt_again()
            return
        self._postponed_until_s = None
        raise KeyboardInterrupt

    def _harms(self, frame: FrameType | None) -> bool:
        while frame is not None:
            if (frame.f_globals.get("__name__") or "").startswith(self.not_within):
                return True
            frame = frame.f_back
        return False


interrupt = Interrupt(NOT_WITHIN)
"""The handler that ``rmfs`` has."""


def interrupt_again() -> None:
    """Interrupt the main thread in a moment."""
    again = Timer(AGAIN_S, _interrupt_main)
    again.daemon = True
    again.start()


def _interrupt_main() -> None:
    if callable(signal.getsignal(signal.SIGINT)):
        if hasattr(signal, "pthread_kill"):
            signal.pthread_kill(main_thread().ident or 0, signal.SIGINT)  # which ends its waiting, too
        else:
            _thread.interrupt_main()


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
