"""A session: batches of facts in, numbered commands out, a journal from which it starts again where it was."""

from __future__ import annotations

import hashlib
import itertools
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from attrs import evolve

from rmfs_commands.processes.events import OrderPacked, PackingAssigned
from rmfs_commands.results.files import to_json
from rmfs_commands.session.correcting import CorrectedFloor
from rmfs_commands.session.facts import Batch, ContradictionError, Fact, batch_of
from rmfs_commands.session.floor import AWAITED, check_supported
from rmfs_commands.session.handling import Handling
from rmfs_commands.session.journal import Journal
from rmfs_commands.session.packing import ENDS, FloorPacking
from rmfs_commands.session.replacing import Replacement, replacement_of
from rmfs_commands.states.beginning import Begun
from rmfs_commands.states.snapshots import Snapshots
from rmfs_core import events
from rmfs_core.clock import to_seconds, to_ticks
from rmfs_core.errors import InputError
from rmfs_core.hookspecs import hookimpl
from rmfs_core.info import RunInfo
from rmfs_core.results.running import versions_of
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario, located
from rmfs_core.scenario.writing import plain
from rmfs_core.warehouse import Order
from rmfs_core.world import make_instance, make_layout

MOST_IDS = 100_000
"""Ids of facts that are known again: those of the latest."""
MOST_ANSWERS = 1_000
"""Answers that are given once more at a time."""
MOST_DONE = 5_000
"""Orders that are complete and still known: the latest."""
MOST_COMMANDS = 10_000
"""Commands that can be refused: the latest."""
OF_ROBOTS = ("drive", "queue", "lift", "set")
"""Kinds of what a robot does, and no picker."""
ARRIVALS = ("order_arrived", "order_cancelled")
"""Facts of which those that follow each other in a batch have one round."""


class StaleBatchError(InputError):
    """A batch that comes after another one than the last; ``seq`` is the number of the last."""

    def __init__(self, place: str, problem: str, seq: int) -> None:
        super().__init__(place, problem)
        self.seq = seq


class Hall(Handling):
    """A warehouse that a session runs.

    Parameters
    ----------
    scenario
        Layout, pods, stations, robots and rules. Its orders and bundles are left out: they arrive as facts.
    journal
        File that the session is kept in, and started again from; None: it is kept in memory only.
    dead_s
        Seconds without a fact after which what a robot or picker is to do is reported as overdue; None: never.
    observers
        Objects whose ``@hookimpl`` methods are told of every event.
    allow_inline
        Whether rules may be loaded from files.
    replayed
        Called for each batch of a journal that is taken again.
    read_only
        Whether the journal is read and not written, also while another session writes it.

    Raises
    ------
    InputError
        Where the scenario or the journal cannot be used, before anything is decided.
    """

    def __init__(
        self,
        scenario: Scenario,
        journal: Path | None = None,
        dead_s: float | None = None,
        observers: Callable[[], Sequence[object]] = tuple,
        *,
        allow_inline: bool = True,
        replayed: Callable[[], None] = lambda: None,
        read_only: bool = False,
    ) -> None:
        self._scenario, self._observers, self._allow_inline = scenario, observers, allow_inline
        self._dead = None if dead_s is None else to_ticks(dead_s)
        with located(scenario):
            check_supported(scenario)
            self._given_instance, self._layout = make_instance(scenario), make_layout(scenario)
        self.replayed = replayed
        self._begin()
        self._journal = self._kept_in(journal, read_only=read_only)
        try:
            self._replay()
        except BaseException:
            self.close()
            raise

    # Made, and made again

    def _made_from(self) -> dict[str, Any]:
        digest = hashlib.sha256(to_json(plain(self._scenario)).encode("utf-8", "backslashreplace"))
        data = hashlib.sha256(repr((self._given_instance.skus, self._given_instance.pods)).encode())
        versions = versions_of(self._floor.rules, self._floor.scenario)
        dead_s = None if self._dead is None else to_seconds(self._dead)
        return {
            "scenario": digest.hexdigest(),
            "stock": data.hexdigest(),
            "seed": self._scenario.seed,
            "dead_s": dead_s,
            "versions": versions,
        }

    def _kept_in(self, journal: Path | None, *, read_only: bool) -> Journal:
        return Journal(journal, self._made_from(), read_only=read_only)

    def _begin(self) -> None:
        """Let the hall be as it is before the first batch."""
        self.seq = 0
        self._numbers = itertools.count(1)
        self._last: tuple[Any, dict[str, Any]] | None = None
        self._ids: set[str] = set()
        self._latest_ids: deque[str] = deque()
        self._begun = False
        self.facts = self.dropped = self.overdue = 0
        self._begin_floor()

    def _begin_floor(self, begun: Begun | None = None) -> None:
        """Let the floor be new: with nothing under way, or as a state has it."""
        scenario = self._scenario
        self._instance = self._given_instance if begun is None else begun.instance
        with located(scenario):
            rules = RuleSet.load(scenario.rules, scenario.folder, allow_inline=self._allow_inline)
            scenario = evolve(scenario, rules=rules.with_file_names(scenario.rules))
        self._commands: list[dict[str, Any]] = []
        self._done: deque[Order] = deque()  # orders that are complete, and packed where orders are
        self._snapshots: Snapshots | None = None
        self._floor = self._open(scenario, rules, begun)
        self._begin_to_handle()
        self._floor.start()
        self._commands.clear()  # what robots do already in a state is no command
        self._floor.settle()

    def _open(self, scenario: Scenario, rules: RuleSet, begun: Begun | None = None) -> CorrectedFloor:
        """Return the floor, of which observers are told; the session itself first."""
        for observer in self._observers():
            rules.register_observer(observer)
        rules.register_observer(self)
        return CorrectedFloor(scenario, self._instance, self._layout, rules, self._command, begun)

    def _again(self) -> None:
        """Let the hall be as the journal has it."""
        self._begin()
        self._replay()

    def _replay(self) -> None:
        """Take all batches of the journal again; each has to be answered as it was."""
        for number, (given, answer) in enumerate(self._journal.batches(), 2):
            self.replayed()
            where = f"{self._journal.name}, line {number}"
            try:
                batch = self._read(given)
            except InputError as error:
                raise InputError(where, f"{error.place}: {error.problem}") from None
            if batch.after != self.seq or batch.tick < self._floor.now:
                raise InputError(where, f"expected a batch after {self.seq}, and not earlier than that")
            if to_json(self._apply(batch)) != to_json(answer):
                raise InputError(where, "is not answered as it was; expected the rules that wrote the journal")
            self._last = given, answer

    def close(self) -> None:
        """End the session; the journal stays."""
        self._journal.close()

    # Facts in, commands out

    def take(self, given: Any) -> dict[str, Any]:
        """Take a batch of facts; return the commands that follow from it.

        Parameters
        ----------
        given
            ``{"after": seq, "time_s": seconds, "events": [{"id": ..., "kind": ..., ...}]}``, as JSON has it; or, with
            ``{"after": seq, "state": {...}}``, a state that replaces the session's own.

        Returns
        -------
        dict[str, Any]
            ``seq``, ``time_s``, ``commands``, ``dropped``, ``overdue`` and ``ask_again_s``.

        Raises
        ------
        StaleBatchError
            When the batch comes after another one than the last.
        InputError
            When it has another shape, names a fact that sessions do not take, or goes back in time.
        RmfsError
            When a rule or the journal fails. In all cases nothing has changed.
        """
        if self._last is not None and given == self._last[0] and given["after"] == self.seq - 1:
            if "state" not in given:
                batch_of(given)  # true is equal to 1, but no number
            if type(given["after"]) is int:
                return self._last[1]
        batch = self._read(given)
        if batch.after != self.seq:
            raise self._stale(batch.after)
        if batch.tick < self._floor.now:
            now = to_seconds(self._floor.now)
            place = "batch.time_s" if isinstance(batch, Batch) else "batch.state.time_s"
            raise InputError(place, f"found {to_seconds(batch.tick)}; expected no time before {now}, the last one")
        try:
            answer = self._apply(batch)
            self._journal.append({"batch": given, "answer": answer})
        except Exception:
            self._again()
            raise
        self._last = given, answer
        return answer

    def since(self, seq: int) -> list[dict[str, Any]]:
        """Return the answers that were given after the batch of a number, the first `MOST_ANSWERS` of them."""
        return [answer for _, answer in itertools.islice(self._journal.batches(seq), MOST_ANSWERS)]

    def _read(self, given: Any) -> Batch | Replacement:
        """Return a batch from JSON's objects, or the state in place of one."""
        if not isinstance(given, Mapping) or "state" not in given:
            return batch_of(given)
        if given.get("after") != self.seq and type(given.get("after")) is int:  # whatever the state is like
            raise self._stale(given["after"])
        return replacement_of(given, self._scenario, evolve(self._given_instance, orders=(), bundles=()), self._layout)

    def _stale(self, after: int) -> StaleBatchError:
        return StaleBatchError("batch.after", f"found {after}; expected {self.seq}, the last batch", self.seq)

    def _replace(self, new: Replacement) -> list[str]:
        """Let the floor be as a state has it; rules begin afresh, and are asked at once.

        Return the names of orders that have waited for their turn, and are not in the state.
        """
        waited = [name for name, order in self._orders.items() if order.id not in self._floor.warehouse.arrived]
        self._begin_floor(new.begun)
        floor, self._begun = self._floor, True
        self._orders = {order.name: order for order in floor.book}
        for (kind, name), why in new.doubtful:
            if kind == "cell":
                if name.isdecimal() and int(name) in floor.warehouse.free_locations:
                    self._cell_blocked(int(name))
                    self._doubtful[kind, name] = why
            else:
                self._doubt((kind, name), why)
        for station in new.closed:
            timed = self._by_name["station"][station].id in floor.hours and station not in new.by_floor
            if not timed and ("station", station) not in self._doubtful:
                self._station_closed(station)
        for station in new.opened:
            if ("station", station) not in self._doubtful:
                self._station_opened(station)
        for robot in new.failed:
            self._robot_failed(robot)
        floor.round()
        return [name for name in waited if name not in self._orders]

    def _apply(self, batch: Batch | Replacement) -> dict[str, Any]:
        if isinstance(batch, Replacement):
            left_out = self._replace(batch)
            return self._answer([], {"replaced": True, **({"left_out": left_out} if left_out else {}), **batch.own})
        floor, dropped = self._floor, list[dict[str, Any]]()
        floor.advance(batch.tick)
        if not self._begun and not (batch.facts and batch.facts[0].kind in ARRIVALS and not floor.now):
            floor.round()
        self._begun = True
        facts = [(i, fact) for i, fact in enumerate(batch.facts) if self._new(fact)]
        self.facts += len(facts)
        for _, group in itertools.groupby(facts, lambda one: one[1].kind in ARRIVALS or one[1].id):
            changed = False  # so that rules have something to decide
            for i, fact in group:
                try:
                    changed |= bool(getattr(self, f"_{fact.kind}")(**fact.fields))
                except ContradictionError as problem:
                    dropped.append({"id": fact.id, "place": f"events.{i}", "problem": f"{problem}.", **fact.own})
                    for concern in problem.concerns:
                        self._doubt(concern, str(problem))
                        changed = True
            if changed:
                floor.round()
        return self._answer(dropped, batch.own)

    def _answer(self, dropped: list[dict[str, Any]], own: Mapping[str, Any]) -> dict[str, Any]:
        floor = self._floor
        self.seq += 1
        overdue = self._overdue()
        self.dropped, self.overdue = self.dropped + len(dropped), len(overdue)
        self._forget()
        commands, self._commands = self._commands, []
        return {
            "seq": self.seq,
            "time_s": to_seconds(floor.now),
            "commands": commands,
            "dropped": dropped,
            "overdue": overdue,
            "ask_again_s": None if (tick := floor.next_tick) is None else to_seconds(tick),
            **own,
        }

    def _new(self, fact: Fact) -> bool:
        if fact.id in self._ids:
            return False
        self._ids.add(fact.id)
        self._latest_ids.append(fact.id)
        if len(self._ids) > MOST_IDS:
            self._ids.remove(self._latest_ids.popleft())
        return True

    def _forget(self) -> None:
        """Forget the orders that have been complete for longest; the first one stays, for rules look at its age."""
        while len(self._done) > MOST_DONE:
            order = self._done.popleft()
            if order.id:
                self._floor.forget(order)
                self._orders.pop(order.name, None)
                self._doubtful.pop(("order", order.name), None)
                assert self._snapshots is not None
                self._snapshots.forget(order.id)
        if len(self._floor.services.begun) > MOST_IDS:  # of orders that are over, most of them
            self._floor.services.begun.clear()

    @property
    def counts(self) -> dict[str, int]:
        """How much there is of what a session is watched by."""
        return {
            "seq": self.seq,
            "facts": self.facts,
            "dropped": self.dropped,
            "open_orders": len(self._floor.book) - self._floor.completed,
            "awaited": len(self._floor.waits) + sum(1 for _ in self._packing()),
            "overdue": self.overdue,
            "quarantined": len(self._doubtful),
        }

    @property
    def state(self) -> dict[str, Any]:
        """The whole state: that of `rmfs decide`, and ``session`` with what only a session has."""
        assert self._snapshots is not None
        self._floor.tell_corrected()
        self._snapshots.look({})
        doubtful = [{kind: name, "why": why, **self._held(kind, name)} for (kind, name), why in self._doubtful.items()]
        waits: list[dict[str, Any]] = [
            {"awaits": AWAITED[kind], **self._who(kind, who), "since_s": to_seconds(wait.since)}
            for (kind, who), wait in self._floor.waits.items()
        ]
        waits += [told for told, _ in self._packing()]
        closed, opened = (
            sorted(self._floor.warehouse.stations[number].name for number in ids)
            for ids in (self._floor.closed, self._floor.opened)
        )
        session = {"seq": self.seq, "quarantine": doubtful, "awaited": waits, "failed": sorted(self._failed)}
        return {**self._snapshots.state, "session": {**session, "closed": closed, "opened": opened}}

    # What nothing is heard of

    def _overdue(self) -> list[dict[str, Any]]:
        """Return what nothing is heard of, after the requests of pods that are late were uncovered."""
        if self._dead is None:
            return []
        found, late = [], False
        lines = [station.line for station in self._floor.warehouse.stations]
        for (kind, who), wait in [*self._floor.waits.items()]:
            if kind == "queue" and any(robot.id == who for line in lines for robot in line[1:]):
                continue  # it stands in a line
            since = wait.since if kind == "release" else max(wait.since, self._heard.get(who, 0))
            if self._floor.now - since > self._dead:
                told = self._who(kind, who)
                found.append({"awaits": AWAITED[kind], **told, "since_s": to_seconds(since)})
                if kind in OF_ROBOTS and "pod" in told and ("pod", told["pod"]) not in self._doubtful:
                    self._passing.add(told["pod"])
                    self._doubt(("pod", told["pod"]), f"nothing is heard of robot {told['robot']}")
                    late = True
        if late:
            self._floor.round()
        return found + [told for told, since in self._packing() if self._floor.now - since > self._dead]

    def _packing(self) -> Iterator[tuple[dict[str, Any], int]]:
        """Yield what is awaited of conveyors and packers, and since when."""
        packing = self._floor.packing
        for (kind, who), (_, since) in packing.waits.items() if isinstance(packing, FloorPacking) else ():
            if kind in ENDS:
                what = {"order": self._floor.warehouse.orders[who].name} if kind == "pack" else {"tote": who}
                yield {"awaits": ENDS[kind], **what, "since_s": to_seconds(since)}, since

    def _who(self, kind: str, who: int) -> dict[str, str]:
        warehouse = self._floor.warehouse
        if kind == "release":
            return {"station": warehouse.stations[who].name}
        robot = warehouse.robots[who]
        return {"robot": robot.name} | ({} if robot.task is None else {"pod": warehouse.pods[robot.task].name})

    # What the kernel tells

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Follow the state."""
        self._snapshots = Snapshots(run)
        self._floor.followers.append(self._snapshots)

    @hookimpl
    def on_event(self, event: events.Event) -> None:
        """Follow the state, and turn decisions into commands."""
        assert self._snapshots is not None
        self._snapshots.told(event)
        match event:
            case events.OrderAssigned():
                skus = [self._instance.skus[sku] for sku in event.skus]
                self._command("assign", order=event.order, station=event.station, skus=skus, part=event.period)
            case events.TaskAssigned():
                station = self._floor.warehouse.pods[event.pod].bound_for[0]
                self._command("fetch", robot=event.robot, pod=event.pod, station=station)
            case events.VisitEnded(next_station=int(station)):
                robot = self._floor.warehouse.pods[event.pod].robot
                self._command("go_on", robot=robot, pod=event.pod, station=station)
            case events.RobotSent() if event.robot in self._floor.stories:  # no event of how a state came to be
                charge = self._floor.stories[event.robot][2]
                self._command("move_robot", robot=event.robot, cell=event.cell, charge=charge)
            case events.PodMoveDecided():
                self._command("move_pod", robot=event.robot, pod=event.pod, cell=event.cell)
            case PackingAssigned():
                self._command("assign_packing", order=event.order, packing=event.packing, box=event.box)
            case events.OrderCancelled() | OrderPacked():
                self._done.append(self._floor.warehouse.orders[event.order])
            case events.OrderCompleted() if self._floor.packing is None:
                self._done.append(self._floor.warehouse.orders[event.order])
            case events.BundleAssigned():
                bundle = self._floor.warehouse.stations[event.station].bundles[-1]
                self._command("assign_bundle", bundle=bundle.name, station=event.station)

    def _command(self, kind: str, **fields: Any) -> None:
        """Give the next command, with names in place of ids."""
        warehouse = self._floor.warehouse
        among = {
            "robot": warehouse.robots,
            "pod": warehouse.pods,
            "station": warehouse.stations,
            "order": warehouse.orders,
        }
        told = {name: among[name][value].name if name in among else value for name, value in fields.items()}
        if "packing" in told:
            told["packing"] = str(told["packing"] + 1)
        if "sku" in told:
            told["sku"] = self._instance.skus[told["sku"]]
        number = next(self._numbers)
        self._commands.append({"command": number, "kind": kind, **told})
        self._given[number] = self._commands[-1]
        if len(self._given) > MOST_COMMANDS:
            self._given.popitem(last=False)
