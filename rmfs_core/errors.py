"""What can go wrong, by who has to mend it."""

from __future__ import annotations

from typing import Any


class RmfsError(Exception):
    """Base of every error this package raises on purpose; its text is one sentence for a person."""

    exit_code = 1


class InputError(RmfsError):
    """A scenario, CSV file, map, state file or command line is wrong.

    Parameters
    ----------
    place
        Where: a file, with the line or the key's path when known.
    problem
        What was found and what would be right.
    """

    exit_code = 2

    def __init__(self, place: str, problem: str) -> None:
        super().__init__(f"{place}: {problem}")
        self.place = place
        self.problem = problem


class RunError(RmfsError):
    """A run stopped before its end; ``result`` holds what it had measured until then, a `rmfs_core.Result`."""

    def __init__(self, message: str) -> None:
        super().__init__(message)
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
