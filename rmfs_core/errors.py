"""Errors, by who has to mend them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rmfs_core.wording import cut, one_line, shortened


class RmfsError(Exception):
    """Base of every error this package raises on purpose; its text is one sentence for a person.

    Parameters
    ----------
    problem
        The finding, and the value that would be right; of long values that it quotes the middle is left out.
    place
        Where the problem is, if known; the message begins with it.
    """

    exit_code = 1

    def __init__(self, problem: str = "", place: str | None = None) -> None:
        self.problem = shortened(problem)
        self.place = None if place is None else cut(shortened(place), 300)
        super().__init__(self.problem, self.place)  # simpy makes an error anew of these

    def __str__(self) -> str:
        """Return the sentence."""
        return self.problem if self.place is None else f"{self.place}: {self.problem}"


class InputError(RmfsError):
    """A scenario, CSV file, map, state file or command line is wrong.

    Parameters
    ----------
    place
        Where: a file, with the line or the key's path when known.
    problem
        The finding, and the value that would be right.
    """

    exit_code = 2
    place: str

    def __init__(self, place: str, problem: str) -> None:
        super().__init__(problem, place)
        self.args = (self.place, self.problem)


class RunError(RmfsError):
    """A run stopped before its end; ``result`` holds what it had measured until then, a `rmfs_core.Result`."""

    def __init__(self, problem: str, place: str | None = None) -> None:
        super().__init__(problem, place)
        self.result: Any = None


class RuleError(RunError):
    """A rule raised, answered with the wrong type, or decided something impossible."""


class StandstillError(RunError):
    """Orders are left, but nothing will ever happen again."""


def is_interrupt(error: BaseException | None) -> bool:
    """Whether an error is a keyboard interrupt, or what Python makes of one that comes within compiled code."""
    while isinstance(error, SystemError):  # simpy raises it again
        error = error.__cause__
    return isinstance(error, KeyboardInterrupt)


@contextmanager
def refusing(place: str, what: str, told: Callable[[BaseException], str] = one_line, but: Any = ()) -> Iterator[None]:
    """Raise as `InputError` whatever is raised within, but interrupts and ``but``, with ``what`` before the error."""
    try:
        yield
    except BaseException as error:
        if isinstance(error, but) or is_interrupt(error):
            raise
        raise InputError(place, f"{what} {told(error)}") from error
