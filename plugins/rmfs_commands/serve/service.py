"""From the bytes of a request to the bytes of its answer, whatever they come by."""

from __future__ import annotations

import gc
import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from http import HTTPStatus
from typing import Any

from attrs import fields_dict, frozen

from rmfs_commands.cli.choices import option_named, parse_choice, with_parameters
from rmfs_commands.results.files import to_json
from rmfs_commands.serve.warehouses import StaleError, Warehouses
from rmfs_commands.session import StaleBatchError
from rmfs_commands.states import Decider, state_from_dict
from rmfs_commands.states.state import DECIDES
from rmfs_commands.states.state_json import parse_json
from rmfs_core.errors import InputError, RmfsError
from rmfs_core.roles import Role
from rmfs_core.scenario.checks import key
from rmfs_core.scenario.source import Source
from rmfs_core.scenario.structuring import KeyProblem, structure_as
from rmfs_core.wording import listed, nearest, one_line, sentence, shown_short

LARGE = 100_000
"""Bytes of a state of which Python's collector of garbage would take its time to look at all objects."""


@frozen
class Request:
    """A state to decide in and how it comes: whole, or as what has changed."""

    state: Mapping[str, Any] | None = key("The whole state", None)
    change: Mapping[str, Any] | None = key(
        "Instead of `state`: what has changed of the warehouse's last state, a JSON merge patch (RFC 7396)", None
    )
    warehouse: str | None = key("Name by which the service keeps the state, so that changes of it can follow", None)
    base: str | None = key("`revision` of the state that `change` starts from", None)
    rule: str | None = key("Rule to ask, as named by `--rule`; left out: the only one", None)

    def __attrs_post_init__(self) -> None:
        if (self.state is None) == (self.change is None):
            raise ValueError("expected either `state` or `change`")
        if self.change is not None and (self.warehouse is None or self.base is None):
            raise ValueError("expected `warehouse` and `base` with `change`")
        if self.change is None and self.base is not None:
            raise ValueError("found `base` with a whole state; expected it with `change`")


@frozen
class Reply:
    """An answer: a status of HTTP, and a line of JSON. Every status but 200 comes with a problem after RFC 9457."""

    status: int
    content: bytes


def problem(status: int, detail: str, place: str | None = None, **more: Any) -> Reply:
    """Return the reply that says what is wrong, and where."""
    told = {"title": HTTPStatus(status).phrase, "status": status, "detail": sentence(detail), **more}
    return Reply(status, line_of(told | ({} if place is None else {"place": sentence(place)})))


def replied(content: bytes, answer: Callable[[Any], Mapping[str, Any]]) -> Reply:
    """Return the reply to a request, whatever it is; ``answer`` is given its JSON."""
    try:
        data = parse_json(content, "request")
    except InputError as error:
        return problem(400, str(error), error.place)
    try:
        return Reply(200, line_of(answer(data)))
    except StaleBatchError as error:
        return problem(409, str(error), error.place, seq=error.seq)
    except InputError as error:
        return problem(409 if isinstance(error, StaleError) else 422, str(error), error.place)
    except RecursionError:
        return problem(422, "request: is nested too deeply", "request")
    except Exception as error:  # whatever it is, the next request is answered
        return problem(500, str(error) if isinstance(error, RmfsError) else one_line(error))


class Service:
    """Rules that answer requests, one request at a time.

    Parameters
    ----------
    deciders
        The rules, by the names that requests use.
    """

    def __init__(self, deciders: Mapping[str, Decider]) -> None:
        self._deciders = deciders
        self._warehouses = Warehouses()

    @classmethod
    def of(
        cls, rules: Sequence[str], settings: Sequence[str] = (), decides: Role | None = None, allow_inline: bool = True
    ) -> Service:
        """Load rules as they are named on a command line.

        Raises
        ------
        InputError
            For the first that cannot be had.
        """
        if settings and len(rules) > 1:
            how = """parameters in each `--rule`, as in --rule '{ rule = "random", PARAMETER = VALUE }'"""
            raise InputError(f"--set {settings[0]}", f"found {len(rules)} rules; expected one, or {how}")
        deciders: dict[str, Decider] = {}
        for text in rules:
            option = f"--rule {text}"
            choice = with_parameters(parse_choice(text, option), settings)
            if choice.rule in deciders:
                raise InputError(option, "found this rule twice; expected each once")
            with option_named("rule", option, settings):
                deciders[choice.rule] = Decider(choice, decides=decides, allow_inline=allow_inline)
        return cls(deciders)

    @property
    def rules(self) -> tuple[str, ...]:
        """Names of the rules."""
        return tuple(self._deciders)

    def warm_up(self) -> Iterator[None]:
        """Ask each rule once, so that what it compiles is there before the first request; yield after each time."""
        for decider in self._deciders.values():
            for role in DECIDES:
                with suppress(RmfsError):  # most decide one thing; and one may have no answer in this state
                    decider.decide(
                        state_from_dict({**SMALL, "ask": {"decides": role, "pod": "3", "robot": "3", "goal": 6}})
                    )
                yield

    def answer(self, content: bytes) -> Reply:
        """Answer a request, whatever it is. A state that gets no decision is not kept."""
        return replied(content, lambda data: self._answer(content, data))

    def _answer(self, content: bytes, data: Any) -> Mapping[str, Any]:
        request = _request(data)
        decider = self._decider(request)
        revision = hashlib.sha256(content).hexdigest()[:16]  # with `base` in it, it stands for all requests before
        state = request.state
        if request.change is not None:
            state = self._warehouses.changed(str(request.warehouse), str(request.base), request.change, revision)
        assert state is not None  # there is one of them
        if request.warehouse is None:
            return decider.decide(state_from_dict(state)).to_dict()
        first = request.warehouse not in self._warehouses
        opened = self._warehouses.opened(request.warehouse, state)
        answer = decider.decide(opened).to_dict()
        self._warehouses.keep(request.warehouse, revision, state, opened)
        if first and len(content) > LARGE:
            _set_aside()
        return answer | {"warehouse": request.warehouse, "revision": revision}

    def _decider(self, request: Request) -> Decider:
        if request.rule is None and len(self._deciders) == 1:
            return next(iter(self._deciders.values()))
        if request.rule is None:
            raise InputError("request, rule", f"is missing; expected {listed(self.rules, 'or')}")
        if request.rule not in self._deciders:
            raise InputError("request, rule", f'"{request.rule}" is not served{nearest(request.rule, self.rules)}')
        return self._deciders[request.rule]


def _set_aside() -> None:
    """Have the collector of garbage pass over what is kept: else every few changes wait for it."""
    gc.unfreeze()
    gc.collect()
    gc.freeze()


def _request(data: Any) -> Request:
    """Return what JSON asks; a state on its own is one, too."""
    if not isinstance(data, Mapping):
        raise InputError("request", f"expected a JSON object, found {shown_short(data)}")
    if not data.keys() & fields_dict(Request).keys():
        return Request(state=data)
    try:
        return structure_as(Request, data)
    except KeyProblem as wrong:
        raise InputError(Source("request").place_of(wrong.path), wrong.problem) from None


def line_of(value: object) -> bytes:
    """Return an answer as a line of JSON."""
    # Half a surrogate pair, which JSON may name, is written as it came.
    return (to_json(value) + "\n").encode("utf-8", "backslashreplace")


SMALL: Mapping[str, Any] = {
    "format": "rmfs-state",
    "version": 2,
    "layout": {
        "map": ["........", ".##.##..", ".##.##..", "........", ".##.##.qqqO", ".##.##.@@@.", "..........."],
    },
    "pods": {
        "1": {"contents": {"a": 5}, "cell": 12},
        "2": {"contents": {"b": 5}, "cell": 13},
        "3": {"contents": {"c": 5}, "home": 15},
        "4": {"contents": {"a": 1, "b": 1}, "cell": 16},
    },
    "stations": {
        "1": {"item_capacity": 6, "queue_length": 3, "requests": [{"order": "1", "sku": "a"}], "inbound": ["2"]}
    },
    "orders": {"1": {"lines": {"a": 1}}, "2": {"lines": {"b": 1, "c": 1}}, "3": {"lines": {"a": 1, "b": 2}}},
    "robots": {"1": {"cell": 0}, "2": {"cell": 1, "task": "3"}, "3": {"cell": 2}},
    "waiting": ["2"],
}
"""A state in which there is something to decide of each kind."""
