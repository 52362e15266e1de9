"""Asking a rule: the clock is read, what it raises is caught, what it returns is looked at."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Container, Mapping, Sequence
from typing import Any, Protocol, TypeVar

from rmfs_core.clock import to_seconds
from rmfs_core.errors import RuleError
from rmfs_core.info import Question
from rmfs_core.rules import BoundRule
from rmfs_core.rules.hooks import LABEL_OF_ROLE

T = TypeVar("T")


class ImpossibleError(Exception):
    """A decision that cannot be carried out; the text says what is wrong with it."""


class Onlookers(Protocol):
    """Who is told of each question and its answer."""

    def asked(self, question: Question) -> None:
        """Take note of a rule that is about to be asked."""

    def answered(self, question: Question, answer: object) -> None:
        """Take note of what it returned."""


class Asker:
    """Calls rules and turns whatever goes wrong into one `RuleError`.

    Parameters
    ----------
    now
        Returns the simulated time in ticks.
    limit_s
        Wall-clock seconds a single decision may take; None for no limit.
    tables_s
        Returns the wall-clock seconds that travel tables have taken, whoever asked for them.
    """

    def __init__(
        self, now: Callable[[], int], limit_s: float | None, tables_s: Callable[[], float] = lambda: 0.0
    ) -> None:
        self._now = now
        self._limit_s = limit_s
        self._tables_s = tables_s
        self.onlookers: Onlookers | None = None
        self.period = 0
        """Number of the period; 0 before the first."""
        self.seconds: dict[str, float] = {}
        self.tables_in: dict[str, float] = {}
        """Seconds of travel tables within each hook."""
        self.calls: dict[str, int] = {}

    def ask(self, rule: BoundRule, **arguments: Any) -> tuple[Any, float]:
        """Call the rule's hook; return its answer and the wall-clock seconds it took.

        Raises
        ------
        RuleError
            When the rule raises or takes longer than the limit.
        """
        name = rule.hook.name
        question = None if self.onlookers is None else self._question(rule, arguments)
        if question is not None and self.onlookers is not None:
            self.onlookers.asked(question)
        tables, start = self._tables_s(), time.perf_counter()
        try:
            answer = rule.hook(**arguments)
        except (Exception, SystemExit, GeneratorExit) as error:  # whatever a rule does, the run ends in order
            raise self.raised(rule.describe(), name, error) from error
        seconds = time.perf_counter() - start
        self.seconds[name] = self.seconds.get(name, 0.0) + seconds
        self.tables_in[name] = self.tables_in.get(name, 0.0) + self._tables_s() - tables
        self.calls[name] = self.calls.get(name, 0) + 1
        if question is not None and self.onlookers is not None:
            self.onlookers.answered(question, answer)
        if self._limit_s is not None and seconds > self._limit_s:
            raise self.error(rule, f"took {seconds:.3g} s; the scenario allows run.decision_limit_s = {self._limit_s}")
        return answer, seconds

    def _question(self, rule: BoundRule, arguments: dict[str, Any]) -> Question:
        asked = {name: value for name, value in arguments.items() if name not in ("warehouse", "rng")}
        view, rng = arguments["warehouse"], arguments["rng"]
        return Question(LABEL_OF_ROLE[rule.role], rule.name, rule.hook.name, view, rng, self.period, asked)

    def apply(self, rule: BoundRule, check: Callable[[], T]) -> T:
        """Run a check, or a change that checks itself, and name the rule when it finds the decision impossible."""
        try:
            return check()
        except ImpossibleError as problem:
            raise self.error(rule, str(problem)) from None

    def raised(self, name: str, hook: str, error: BaseException) -> RuleError:
        """Return the error that says what a rule or an observer raised, and where."""
        return self.fault(name, hook, f"raised {_raised(error)}")

    def error(self, rule: BoundRule, problem: str) -> RuleError:
        """Return the error that names rule, distribution, hook, simulated time and the problem."""
        return self.fault(rule.describe(), rule.hook.name, problem)

    def fault(self, name: str, hook: str, problem: str) -> RuleError:
        """Return the error that names who was called, the hook, the simulated time and the problem."""
        return RuleError(f"{name}, {hook}, at {to_seconds(self._now()):.3f} s: {problem}.")


def sequence_of(answer: object, kind: type[T]) -> Sequence[T]:
    """Check that an answer is a sequence of ``kind``."""
    if isinstance(answer, (str, bytes)) or not isinstance(answer, Sequence):
        raise ImpossibleError(f"returned {_a(answer)}; expected a sequence of {kind.__name__}")
    for entry in answer:
        if not isinstance(entry, kind):
            raise ImpossibleError(f"returned a sequence with {_a(entry)} in it; expected {kind.__name__} only")
    return answer


def instance_of(answer: object, kind: type[T]) -> T:
    """Check the type of an answer."""
    if not isinstance(answer, kind) or isinstance(answer, bool):
        raise ImpossibleError(f"returned {_a(answer)}; expected {kind.__name__}")
    return answer


def faulty_measurement(numbers: object, known: Container[str]) -> str | None:
    """Return what is wrong with an answer of ``measured``; ``known`` has the metrics that there are already."""
    if not isinstance(numbers, Mapping):
        return f"returned {_a(numbers)}; expected numbers by name"
    for name, number in numbers.items():
        if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII):
            return f"named a metric {name!r}; expected letters, digits and underscores"
        if name in known:
            return f"named a metric {name!r}, which there is already"
        plain = isinstance(number, int | float) and not isinstance(number, bool) and math.isfinite(number)
        if number is not None and not plain:
            return f"measured {name} = {number!r:.80}; expected a finite int or float, or None"
    return None


def _a(answer: object) -> str:
    return "None" if answer is None else f"{type(answer).__name__} {answer!r:.80}"


def _raised(error: BaseException) -> str:
    text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    frame = error.__traceback__
    while frame is not None and frame.tb_next is not None:
        frame = frame.tb_next
    if frame is None:
        return text
    return f"{text} ({frame.tb_frame.f_code.co_filename}, line {frame.tb_lineno})"
