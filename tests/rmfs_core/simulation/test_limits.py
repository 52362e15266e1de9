"""Calls that do not return in time."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest
from numba.core.compiler_lock import global_compiler_lock

from rmfs_core.simulation.limits import OverdueError, within

needs_alarms = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no alarms")


def compute() -> None:
    """Never return."""
    while True:
        pass


def catch() -> None:
    """Never return, whatever goes wrong."""
    while True:
        try:
            time.sleep(60)
        except Exception:
            continue


def catch_all_once() -> None:
    """Never return, though the first end is caught."""
    try:
        time.sleep(60)
    except BaseException:
        compute()


def wait_for_a_lock() -> None:
    """Wait for what never comes."""
    lock = threading.Lock()
    with lock:
        lock.acquire()


def read() -> None:
    """Wait for input that never comes."""
    reading, writing = os.pipe()
    try:
        os.read(reading, 1)
    finally:
        os.close(reading)
        os.close(writing)


@needs_alarms
@pytest.mark.parametrize("call", [compute, catch, catch_all_once, wait_for_a_lock, read])
def test_a_call_that_never_returns_is_ended(call: Callable[[], None]) -> None:
    """Whether it computes, waits, or catches what goes wrong; who else uses the signal has it back."""
    before = signal.getsignal(signal.SIGALRM)
    started = time.monotonic()
    with pytest.raises(OverdueError):
        within(0.05, call, {})
    assert time.monotonic() - started < 20
    assert signal.getsignal(signal.SIGALRM) is before
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0


def test_what_returns_in_time_is_returned() -> None:
    """So is what it raises."""
    assert within(60, dict, {"a": 1}) == {"a": 1}
    with pytest.raises(ZeroDivisionError):
        within(60, lambda: 1 / 0, {})


@needs_alarms
def test_compiling_goes_on() -> None:
    """Else a machine that is slow would begin anew each time."""

    def compiling() -> str:
        with global_compiler_lock:
            time.sleep(0.2)
        return "compiled"

    assert within(0.05, compiling, {}) == "compiled"


def test_outside_the_main_thread_a_call_goes_on() -> None:
    """There are no signals; who called looks at the clock afterwards."""
    found: list[Any] = []

    def slow() -> str:
        time.sleep(0.1)
        return "done"

    thread = threading.Thread(target=lambda: found.append(within(0.01, slow, {})))
    thread.start()
    thread.join()
    assert found == ["done"]
