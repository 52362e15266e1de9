"""The rule itself."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar
from urllib.parse import urlsplit
from weakref import finalize

from attrs import define, field, validators

from rmfs_commands.cli.options import DECIDING
from rmfs_commands.remote.channel import Address, Channel, Command
from rmfs_commands.results.files import json_ready
from rmfs_commands.states.answers import answer_from
from rmfs_commands.states.snapshots import HEARD, Snapshots, call_of
from rmfs_commands.states.state_json import parse_json
from rmfs_commands.states.written import WrittenAnswer, read_answer
from rmfs_core.errors import InputError
from rmfs_core.events import Event, OrderArrived
from rmfs_core.hookspecs import hookimpl
from rmfs_core.rules.parts import parts_now
from rmfs_core.simulation.asking import ImpossibleError
from rmfs_core.warehouse import WarehouseView
from rmfs_core.wording import listed

if TYPE_CHECKING:
    from rmfs_core.info import Question, RunInfo

ROLES = tuple(str(role) for role in DECIDING)


def _doc(text: str, unit: str | None = None) -> dict[str, str]:
    return {"doc": text} if unit is None else {"doc": text, "unit": unit}


def _is_address(_rule: object, _field: object, value: str | None) -> None:
    if value is None:
        return
    try:
        parts = urlsplit(value)
        whole = parts.scheme in ("http", "https") and parts.hostname and parts.port != 0
    except ValueError:  # of a port that is none
        whole = False
    if not whole:
        raise ValueError("expected an address such as http://127.0.0.1:8750/decide")


def _are_roles(_rule: object, _field: object, value: tuple[str, ...] | None) -> None:
    for role in value or ():
        if role not in ROLES:
            raise ValueError(f"expected {listed(ROLES, 'or')}")


@define(eq=False)
class Remote:
    """Asks another program, in any language: the state of the warehouse goes to it as JSON, its answer comes back.

    The program is started (``command``, ``file``) and asked by lines, or asked over HTTP (``url``). A request is
    ``{"state": ...}``, as `rmfs serve` takes it; the answer is as `rmfs decide` prints it. One program decides
    everything that the same choice stands for in a scenario.

    References
    ----------
    T. Bray (ed.): The JavaScript Object Notation (JSON) Data Interchange Format. RFC 8259, 2017.
    https://doi.org/10.17487/RFC8259.
    """

    url: str | None = field(
        default=None, validator=_is_address, metadata=_doc("Address that is asked over HTTP, by POST")
    )
    command: str | None = field(
        default=None, metadata=_doc("Program that is started, with its arguments, instead of `url`")
    )
    file: Path | None = field(
        default=None,
        metadata=_doc("File with the rule's code, next to the scenario: the program's last argument"),
    )
    _decides: tuple[str, ...] | None = field(
        default=None,
        alias="decides",
        validator=_are_roles,
        metadata=_doc("What it can decide, by the keys of a scenario's `rules`; none: all but paths and filters"),
    )
    version: str = field(
        default="",
        metadata=_doc("Version of the program: change it with the program, so that finished runs are not reused"),
    )
    timeout_s: float = field(
        default=60.0,
        validator=[validators.gt(0), validators.le(86_400)],
        metadata=_doc("Time that an answer may take at most", "s"),
    )
    splits_over_time: bool = field(
        default=False, metadata=_doc("Whether it may leave lines of an assigned order in the backlog")
    )
    packing_capacity: int | None = field(
        default=None,
        validator=validators.optional(validators.ge(0)),
        metadata=_doc("Split orders that may be open at once; none: any number", "orders"),
    )
    _run: _Followed | None = field(default=None, init=False, repr=False)
    _wake_s: float | None = field(default=None, init=False, repr=False)

    hears: ClassVar = HEARD

    def __attrs_post_init__(self) -> None:
        if (self.url is None) == (self.command is None):
            raise ValueError("expected either `url` or `command`")
        if self.command is not None and not self._words:
            raise ValueError("`command` is empty; expected a program")
        if self.file is not None and self.command is None:
            raise ValueError("`file` goes with `command`")
        if not parts_now().allow_code:
            raise ValueError("it would have another program decide, which --no-inline-rules refuses")

    @property
    def decides(self) -> tuple[str, ...]:
        """Decisions that it can be asked for, by the keys of a scenario's `rules`."""
        return ROLES if self._decides is None else self._decides

    @property
    def _words(self) -> list[str]:
        return [*shlex.split(self.command or ""), *([] if self.file is None else [str(self.file)])]

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Follow the run from its start."""
        self._run = _Followed(run, self._channel)

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Keep up with orders and pods."""
        if self._run is not None:
            self._run.told(event)

    @hookimpl
    def rule_asked(self, question: Question) -> None:
        """Keep what a rule is asked: this one, where the next hook is its own."""
        if self._run is not None:
            self._run.question = question

    @hookimpl
    def run_ended(self) -> None:
        """End the program."""
        if self._run is not None:
            self._run.close()

    @hookimpl
    def wake_at(self, warehouse: WarehouseView) -> float | None:
        """Wake up when the last answer said so."""
        wake_s, self._wake_s = self._wake_s, None
        return wake_s if wake_s is not None and wake_s > warehouse.now_s else None

    def _channel(self) -> Channel:
        return Address(self.url, self.timeout_s) if self.url is not None else Command(self._words, self.timeout_s)

    def _decided(self) -> object:
        """Return the decision that the program answers."""
        if self._run is None or self._run.question is None:
            raise ImpossibleError("is asked outside of a run, where no request can be written; ask the program itself")
        answer, decision = self._run.decide()
        self._wake_s = None if answer.ask_again_s is None else self._run.now_s + answer.ask_again_s
        return decision


for _role in DECIDING:
    setattr(Remote, _role.hook, hookimpl(specname=_role.hook)(lambda self: self._decided()))


class _Followed:
    """A run that the rule takes part in: its state, the ids of its names, and the way to the program."""

    def __init__(self, run: RunInfo, opened: Any) -> None:
        self.question: Question | None = None
        self._snapshots = Snapshots(run)
        self._view = view = run.warehouse
        self.pods = {pod.name: pod.id for pod in view.pods}
        stations = (*view.stations, *(station for station in view.replenishment_stations if not station.picks))
        self.stations = {station.name: station.id for station in stations}
        self.orders = {order.name: order.id for order in view.orders}
        self.skus = {sku: i for i, sku in enumerate(run.instance.skus)}
        self._opened = opened
        self._channel: Channel | None = None

    @property
    def now_s(self) -> float:
        """Simulated time (s)."""
        return self._view.now_s

    def told(self, event: Event) -> None:
        """Take note of an event."""
        self._snapshots.told(event)
        if isinstance(event, OrderArrived):
            self.orders[self._view.order(event.order).name] = event.order

    def decide(self) -> tuple[WrittenAnswer, object]:
        """Return the answer to the question that the rule is asked now, as written and as the kernel takes it."""
        question = self.question
        assert question is not None
        self._snapshots.look(call_of(question))
        if self._channel is None:
            self._channel = self._opened()
            finalize(self, self._channel.close)  # however the run ends
        request = json.dumps({"state": json_ready(self._snapshots.state)}, separators=(",", ":")).encode()
        try:
            data = parse_json(self._channel.ask(request), "answer")
            if isinstance(data, Mapping) and "detail" in data:  # a refusal, as RFC 9457 has it
                raise ImpossibleError(f"the program refuses the request: {data['detail']}")
            answer = read_answer(data)
        except InputError as error:
            raise ImpossibleError(str(error)) from None
        return answer, answer_from(answer, question.decides, self._view, self)

    def close(self) -> None:
        """End the program, or close the connection."""
        if self._channel is not None:
            self._channel.close()
            self._channel = None
