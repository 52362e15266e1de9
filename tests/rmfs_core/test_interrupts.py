"""Where Ctrl-C is raised at once, and where a moment later."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from types import ModuleType

import pytest

from rmfs_core import interrupts
from rmfs_core.interrupts import Interrupt

CALLING_BACK = """
def call(function):
    try:
        return function()
    except KeyboardInterrupt:
        return "broken"
"""


@pytest.fixture
def library() -> Iterator[ModuleType]:
    """A module that nothing may be raised through, and the handler that knows it."""
    module = ModuleType("delicate.inner")
    exec(CALLING_BACK, vars(module))
    handler = Interrupt(("delicate",))
    before = signal.signal(signal.SIGINT, handler)
    yield module
    signal.signal(signal.SIGINT, before)


def pressed() -> str:
    signal.raise_signal(signal.SIGINT)
    return "whole"


def test_an_interrupt_waits_until_a_library_has_returned(library: ModuleType) -> None:
    with pytest.raises(KeyboardInterrupt):
        assert library.call(pressed) == "whole"
        time.sleep(5)


def test_an_interrupt_elsewhere_is_raised_at_once(library: ModuleType) -> None:
    with pytest.raises(KeyboardInterrupt):
        pressed()


def test_an_interrupt_is_not_put_off_for_ever(library: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interrupts, "PATIENCE_S", 0.1)

    def endless() -> str:
        signal.raise_signal(signal.SIGINT)
        time.sleep(5)
        return "whole"

    assert library.call(endless) == "broken"
