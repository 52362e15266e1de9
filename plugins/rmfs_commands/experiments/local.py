"""Worker processes on this machine."""

from __future__ import annotations

import os
import re
import signal
import sys
import threading
import time
import warnings
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager

from joblib.externals.loky import BrokenProcessPool, ProcessPoolExecutor
from joblib.externals.loky.backend.resource_tracker import ensure_running

from rmfs_commands.experiments.experiment import Job
from rmfs_commands.experiments.outcome import Outcome, simulate
from rmfs_commands.experiments.workers import WorkerDiedError

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
"""Every core has a run of its own: libraries must not start threads besides."""


class LocalWorkers:
    """Processes of joblib's loky, each in a pool of its own.

    A pool breaks as a whole when one of its processes dies, and does not say which run was to blame; pools of one
    process do, and leave the other runs alone. They are clean interpreters, used for one run after another.

    Parameters
    ----------
    count
        How many runs there are at a time.
    """

    def __init__(self, count: int) -> None:
        self.count = count
        self.closed = False
        self._idle: deque[ProcessPoolExecutor] = deque()
        self._all: deque[ProcessPoolExecutor] = deque()

    def run(self, job: Job) -> Outcome:
        """Run a job in an idle process, or in a new one."""
        pool = self._idle.pop() if self._idle else self._open()
        try:
            with _interrupts_blocked():
                submitted = pool.submit(simulate, job)
            outcome: Outcome = submitted.result()
        except BrokenProcessPool as error:
            pool.shutdown(wait=False, kill_workers=True)
            self._all.remove(pool)
            raise WorkerDiedError(_how(error)) from error
        self._idle.append(pool)
        return outcome

    def _open(self) -> ProcessPoolExecutor:
        _keep_tracker()
        pool = ProcessPoolExecutor(
            max_workers=1, initializer=_depend_on_parent, initargs=(os.getpid(),), env=ONE_THREAD
        )
        self._all.append(pool)
        return pool

    def close(self) -> None:
        """Kill the processes."""
        self.closed = True
        _keep_tracker()
        with _closing, _closing_quietly():
            for pool in list(self._all):
                pool.shutdown(wait=True, kill_workers=True)


_closing = threading.Lock()
"""Held while a hook of the process is replaced."""


@contextmanager
def _closing_quietly() -> Iterator[None]:
    """Let threads of loky fail without a traceback: one that hands on a run finds it gone when its pool is closed."""
    shown = threading.excepthook

    def show(failure: threading.ExceptHookArgs) -> None:
        if not type(failure.thread).__module__.startswith("joblib.externals.loky"):
            shown(failure)

    threading.excepthook = show
    try:
        yield
    finally:
        threading.excepthook = shown


_tracking = threading.Lock()


def _keep_tracker() -> None:
    """Start the process in which loky keeps track of its semaphores; anew, with a sentence, where it was killed.

    One that is started anew knows nothing of what there was: the tracebacks that it would print of that tell nobody
    anything.
    """
    with _tracking, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        errors, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(nowhere, 2)
            ensure_running()
        finally:
            os.dup2(errors, 2)
            os.close(errors)
            os.close(nowhere)
    if any("resource_tracker" in str(warning.message) for warning in caught):
        print("A helper process of joblib was killed; it is started anew, and no run is lost.", file=sys.stderr)


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Let no interrupt reach this thread meanwhile, nor processes that it starts, until they say what they do with it.

    A terminal sends Ctrl-C to them, too: while one is still importing, it would show a traceback.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing.resource_tracker import ensure_running as ensure_own_running

    ensure_own_running()  # Python's own; where loky starts it, that lets interrupts through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _depend_on_parent(parent: int) -> None:
    """Set up a worker: leave Ctrl-C, which a terminal sends to every process, to the parent, and end when it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    """Wait for the parent's end; a parent that was killed cannot stop its workers itself."""
    while os.getppid() == parent:
        time.sleep(1)
    os._exit(1)


def _how(error: BrokenProcessPool) -> str:
    """Return how a process died from loky's message, which ends with ``{SIGKILL(-9)}`` or the like."""
    found = re.search(r"\{(.+)\}", str(error))
    return f"its worker process died with {found[1]}" if found else "its worker process died"
