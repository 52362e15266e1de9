"""Asking rules and telling observers: what they raise ends the run with one error that says whose fault it is."""

from __future__ import annotations

import os
import re
import time
from collections import defaultdict
from collections.abc import Callable, Container, Mapping, Sequence
from traceback import walk_tb
from typing import Any, TypeVar

import numpy as np
import pluggy

from rmfs_core.clock import to_seconds
from rmfs_core.entrypoints import format_module
from rmfs_core.errors import InputError, RmfsError, RuleError, is_interrupt
from rmfs_core.events import Event
from rmfs_core.info import Question
from rmfs_core.rules import BoundRule, RuleSet
from rmfs_core.simulation.limits import OverdueError, within
from rmfs_core.warehouse import Warehouse
from rmfs_core.wording import raised, shown_short

T = TypeVar("T")
_copied = [0]  # how often a process was copied down to this one: quicker to look at than its id
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _copied.append(_copied.pop() + 1))


class ImpossibleError(Exception):
    """A decision that cannot be carried out; the text says what is wrong with it."""


class Observers:
    """Observers of a run.

    Parameters
    ----------
    rules
        The rules of the run, with all observers registered.
    warehouse
        Its clock.

    Attributes
    ----------
    seconds
        Wall-clock seconds that they have taken.
    hear_questions
        Whether any of them wants to be told what rules are asked.
    """

    def __init__(self, rules: RuleSet, warehouse: Warehouse) -> None:
        self._rules = rules
        self._warehouse = warehouse
        self.seconds = 0.0
        self._told: dict[type[Event], list[tuple[Any, Callable[..., Any]]]] = {}
        self.hear_questions = bool(rules.told("rule_asked") or rules.told("rule_answered"))

    def tell(self, event: Event) -> None:
        """Tell those what happened who listen to it."""
        told = self._told.get(type(event))
        if told is None:
            told = self._told[type(event)] = self._rules.told_of(type(event))
        started = time.perf_counter()
        try:
            for whose, tell in told:  # noqa: B007
                tell(event)
        except BaseException as error:
            self._blame(whose, "on_event", error)
            raise
        self.seconds += time.perf_counter() - started

    def call(self, hook: str, **arguments: Any) -> None:
        """Call a hook of all observers."""
        for one in self._rules.told(hook):
            self._ask(one, hook, **arguments)

    def _ask(self, one: Any, hook: str, **arguments: Any) -> Any:
        started = time.perf_counter()
        try:
            answer = one.function(*[arguments[name] for name in one.argnames])
        except BaseException as error:
            self._blame(one.plugin, hook, error)
            raise
        self.seconds += time.perf_counter() - started
        return answer

    def _blame(self, whose: Any, hook: str, error: BaseException) -> None:
        """Raise an error that names who has raised one, whatever it is: the run ends in order.

        Not where it has no name, nor for a sentence for a person: of a file that cannot be written, say.
        """
        if whose.described is not None and not isinstance(error, InputError) and not is_interrupt(error):
            raise fault(self._warehouse, whose.described, hook, f"raised {raised(error, whose.instance)}") from error

    def end(self, status: str) -> tuple[dict[str, float | None], list[BaseException]]:
        """Tell every observer that the run is over; return what they have measured, by name, and what they raised."""
        found, errors = dict[str, float | None](), list[BaseException]()
        by_clock = format_module("results").timing(0, 0, 0, 0, (), ())  # for the names
        for hook, one in [(name, one) for name in ("run_ended", "measured") for one in self._rules.told(name)]:
            try:
                answer = self._ask(one, hook, tick=self._warehouse.now, status=status)
                found.update(_numbers(answer, {**by_clock, **found}) if hook == "measured" else {})
            except ImpossibleError as problem:
                name = one.plugin.described or f"observer {type(one.plugin.instance).__name__}"
                errors.append(fault(self._warehouse, name, "measured", str(problem)))
            except BaseException as error:
                errors.append(error)
        return found, errors


class Asker:
    """Calls rules and turns whatever goes wrong into one `RuleError`.

    Parameters
    ----------
    warehouse
        The warehouse that rules decide on; its clock is in every message.
    limit_s
        Wall-clock seconds a single decision may take; None for no limit.
    observers
        Who is told of each question and its answer.

    Attributes
    ----------
    period
        Number of the period; 0 before the first.
    calls, seconds, tables_in
        By hook: how often rules were asked, the wall-clock seconds that took, and how many of these went into tables of
        driving times.
    """

    def __init__(self, warehouse: Warehouse, limit_s: float | None = None, observers: Observers | None = None) -> None:
        self.warehouse = warehouse
        self._limit_s = limit_s
        self._observers = observers if observers is not None and observers.hear_questions else None
        self.period = 0
        self.calls: dict[str, int] = defaultdict(int)
        self.seconds: dict[str, float] = defaultdict(float)
        self.tables_in: dict[str, float] = defaultdict(float)

    def ask(
        self, rule: BoundRule, arguments: dict[str, Any], hook: pluggy.HookCaller | None = None
    ) -> tuple[Any, float]:
        """Call the rule's hook, or one of which observers are not told; return its answer and the seconds it took.

        Raises
        ------
        RuleError
            When the rule raises or takes longer than the limit; it is ended then, where that can be.
        """
        name, called = (hook or rule.hook).name, hook or rule.call
        observers, travel = self._observers if hook is None else None, self.warehouse.travel
        if observers is not None:
            question = self._question(rule, arguments)
            observers.call("rule_asked", question=question)
        tables, start, copied = travel.seconds, time.perf_counter(), _copied[0]
        try:
            answer = called(**arguments) if self._limit_s is None else within(self._limit_s, called, arguments)
        except OverdueError as error:
            raise self.error(rule, self._too_long(time.perf_counter() - start), hook) from error
        except ImpossibleError as problem:
            raise self.error(rule, str(problem), hook) from problem
        except BaseException as error:  # whatever a rule does, the run ends in order
            if is_interrupt(error):
                raise
            raise self.error(rule, f"raised {raised(error, rule.instance)}", hook) from error
        finally:
            if _copied[0] != copied:  # a copy that the rule made, and would have simulate, and write, a second time
                os._exit(1)
        seconds = time.perf_counter() - start
        self.seconds[name] += seconds
        self.tables_in[name] += travel.seconds - tables
        self.calls[name] += 1
        if observers is not None:
            told = list(answer) if isinstance(answer, list) else answer  # a list is the one answer that can be changed
            observers.call("rule_answered", question=question, answer=told)
        if self._limit_s is not None and seconds > self._limit_s:
            raise self.error(rule, self._too_long(seconds), hook)
        return answer, seconds

    def _too_long(self, seconds: float) -> str:
        return f"took {seconds:.3g} s; the scenario allows run.decision_limit_s = {self._limit_s}"

    def _question(self, rule: BoundRule, arguments: dict[str, Any]) -> Question:
        asked = {name: value for name, value in arguments.items() if name not in ("warehouse", "rng")}
        view, rng = arguments["warehouse"], arguments["rng"]
        return Question(rule.role, rule.name, rule.hook.name, view, rng, self.period, asked)

    def apply(self, rule: BoundRule, check: Callable[[], T], hook: pluggy.HookCaller | None = None) -> T:
        """Run a check, or a change that checks itself, and name the rule when it finds the decision impossible."""
        try:
            return check()
        except ImpossibleError as problem:
            raise self.error(rule, str(problem), hook) from None
        except BaseException as error:  # of an object in the answer: what is asked of it may do anything
            raising = [*walk_tb(error.__traceback__)][-1][0].f_globals.get("__name__")
            if isinstance(error, RmfsError) or is_interrupt(error) or str(raising).startswith("rmfs_core."):
                raise
            raise self.error(rule, f"gave an answer that raised {raised(error, rule.instance)}", hook) from error

    def error(self, rule: BoundRule, problem: str, hook: pluggy.HookCaller | None = None) -> RuleError:
        """Return the error that names rule, distribution, hook, simulated time and the problem."""
        return fault(self.warehouse, rule.describe(), (hook or rule.hook).name, problem)


def fault(warehouse: Warehouse, name: str, hook: str, problem: str) -> RuleError:
    """Return the error that names who was called, the hook, the simulated time and the problem."""
    return RuleError(f"{problem}.", f"{name}, {hook}, at {to_seconds(warehouse.now):.3f} s")


def sequence_of(answer: object, kind: type[T]) -> Sequence[T]:
    """Check that an answer is a sequence of ``kind``."""
    if not isinstance(answer, (list, tuple)) and (isinstance(answer, (str, bytes)) or not isinstance(answer, Sequence)):
        named = "ids" if kind is object else kind.__name__
        raise ImpossibleError(f"returned {_a(answer)}; expected a sequence of {named}")
    try:
        entries = answer if type(answer) in (list, tuple) else list(answer)  # another kind may do anything, each time
    except Exception as error:
        raise ImpossibleError(f"returned {_a(answer)}, which raised {raised(error)}") from error
    for entry in entries:
        if not isinstance(entry, kind):
            raise ImpossibleError(f"returned a sequence with {_a(entry)} in it; expected {kind.__name__} only")
    return entries


def instance_of(answer: object, kind: type[T]) -> T:
    """Check the type of an answer."""
    if not isinstance(answer, kind) or isinstance(answer, bool):
        raise ImpossibleError(f"returned {_a(answer)}; expected {kind.__name__}")
    return answer


def _numbers(answer: object, known: Container[str]) -> dict[str, float | None]:
    """Return an answer of ``measured``, checked; ``known`` has the metrics that there are already."""
    if not isinstance(answer, Mapping):
        raise ImpossibleError(f"returned {_a(answer)}; expected numbers by name")
    try:
        numbers = {name: value.item() if isinstance(value, np.generic) else value for name, value in answer.items()}
    except Exception as error:
        raise ImpossibleError(f"returned {_a(answer)}, which raised {raised(error)}") from error
    for name, number in numbers.items():
        if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z]\w*", name, re.ASCII):
            raise ImpossibleError(f"named a metric {shown_short(name)}; expected letters, digits and underscores")
        if name in known:
            raise ImpossibleError(f"named a metric {name!r}, which exists already")
        plain = isinstance(number, int | float) and not isinstance(number, bool) and abs(number) < 1 << 63
        if number is not None and not plain:
            told = f"measured {name} = {shown_short(number)}"
            raise ImpossibleError(f"{told}; expected an int or float below 2^63, or None")
    return numbers


def _a(answer: object) -> str:
    name, text = type(answer).__name__, shown_short(answer)
    return text if answer is None or text.startswith((f"{name}(", f"a {name}")) else f"{name} {text}"
