"""A real day as a run: the journal of a session, replayed for the observers of runs."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from attrs import evolve

from rmfs_commands.results.recorders import make_observers, make_recorders
from rmfs_commands.session.correcting import CorrectedFloor
from rmfs_commands.session.facts import Batch
from rmfs_commands.session.hall import Hall
from rmfs_commands.session.journal import Journal, header_of
from rmfs_commands.session.replacing import Replacement
from rmfs_commands.states.beginning import Begun
from rmfs_core import entrypoints, events
from rmfs_core.clock import to_seconds
from rmfs_core.errors import InputError
from rmfs_core.hookspecs import hookimpl
from rmfs_core.results import Result
from rmfs_core.results.catalogue import described_by
from rmfs_core.results.running import PreparedRun, versions_of
from rmfs_core.rules import RuleSet
from rmfs_core.scenario import Scenario
from rmfs_core.world import EAST, NORTH, SOUTH, WEST, OrderData

Told = Sequence[tuple[object, str | None]]


class _Noting(Hall):
    """A hall that notes what the observers of a run know earlier than a session.

    Attributes
    ----------
    orders
        Those of the day.
    handled
        Of each pick, the tick at which its item was handled.
    refused
        Assignments that were refused: order, station, part.
    assigned
        When each assignment was given as a command.
    corrected
        Tick at which the floor first corrected what was known; None: never.
    waiting
        Orders that have waited for stock since they arrived, by id.
    """

    def _begin(self) -> None:
        self.orders: list[OrderData] = []
        self.handled: list[int] = []
        self.assigned: dict[tuple[int, int, int], int] = {}
        self.refused: set[tuple[int, int, int]] = set()
        self._in_hand: dict[int, int] = {}  # by station, its pick that is not handled
        self.corrected: int | None = None
        self.waiting = set[int]()
        super()._begin()

    def _apply(self, batch: Batch | Replacement) -> dict[str, Any]:
        if isinstance(batch, Replacement):
            problem = f"the state was replaced at {to_seconds(batch.tick):g} s; expected a day that nobody replaced"
            raise InputError(f"{self._journal.name}, line {self.seq + 2}", problem)
        return super()._apply(batch)

    def _order_arrived(self, order: str, *given: Any, **named: Any) -> bool:
        super()._order_arrived(order, *given, **named)
        found = self._orders[order]
        lines = tuple((line.sku, line.quantity) for line in found.lines)
        data = OrderData(order, arrival_tick=self._floor.now, lines=lines, due_tick=found.due_tick)
        self.orders.append(evolve(data, priority=found.priority))
        return True

    def _doubt(self, concern: tuple[str, str], why: str) -> None:
        self._corrects()
        super()._doubt(concern, why)

    def _counted(self, *given: Any) -> bool:
        self._corrects()
        return super()._counted(*given)

    def _robot_failed(self, robot: str) -> bool:
        self._corrects()
        return super()._robot_failed(robot)

    def _handled(self, station: str) -> None:
        super()._handled(station)
        if (pick := self._in_hand.pop(self._by_name["station"][station].id, None)) is not None:
            self.handled[pick] = self._floor.now

    def _command_refused(self, command: int, why: str) -> bool:
        given = self._given.get(command, {})
        changed = super()._command_refused(command, why)
        self._corrects()
        if given["kind"] == "assign":
            order, station = self._orders[given["order"]], self._by_name["station"][given["station"]]
            self.refused.add(part := (order.id, station.id, given["part"]))
            given_at = self.assigned[part]
            self.corrected = given_at if self.corrected is None else min(self.corrected, given_at)
        return changed

    def _corrects(self) -> None:
        self.corrected = self._floor.now if self.corrected is None else self.corrected

    @hookimpl
    def on_event(self, event: events.Event) -> None:
        """Note assignments, cancellations and picks."""
        super().on_event(event)
        if isinstance(event, events.OrderArrived) and self._floor.book[event.order].waits_for_stock:
            self.waiting.add(event.order)
        elif isinstance(event, events.OrderInStock):
            self.waiting.discard(event.order)
        elif isinstance(event, events.OrderCancelled):
            self.orders[event.order] = evolve(self.orders[event.order], cancelled_tick=event.tick)
        elif isinstance(event, events.OrderAssigned):
            self.assigned[event.order, event.station, event.period] = event.tick
        elif isinstance(event, events.ItemPicked):
            self._in_hand[event.station] = len(self.handled)
            self.handled.append(event.picker_free_tick)

    @property
    def ended(self) -> tuple[int, str]:
        """When the day ended, and how."""
        return self._floor.now, "complete" if self._floor.completed == len(self.orders) else "horizon"


class _Telling(Hall):
    """A hall that tells the observers of a run, with what was noted."""

    def __init__(self, noted: _Noting, told: Told, out: Path, *given: Any, **options: Any) -> None:
        self._noted, self._told, self._out = noted, told, out
        super().__init__(*given, **options)

    def _open(self, scenario: Scenario, rules: RuleSet, begun: Begun | None = None) -> CorrectedFloor:
        for observer, name in self._told:
            rules.register_observer(observer, name)
        floor, noted = super()._open(scenario, rules, begun), self._noted
        floor.tell_through(self._corrected_of)
        tick, status = noted.ended
        if scenario.instance.orders_file is None:
            scenario = evolve(scenario, instance=evolve(scenario.instance, orders=len(noted.orders)))
        if status == "horizon":
            scenario = evolve(scenario, run=evolve(scenario.run, until_s=to_seconds(tick)))
        floor.scenario = scenario
        instance = evolve(self._instance, orders=tuple(noted.orders), bundles=())
        corrected_s = None if noted.corrected is None else to_seconds(noted.corrected)
        counts: dict[str, Any] = {"batches": noted.seq, "facts": noted.facts, "dropped": noted.dropped}
        counts |= {"corrected_s": corrected_s, "waiting": sorted(noted.waiting)}
        floor.info = evolve(
            floor.info, scenario=floor.scenario, instance=instance, out=self._out, summary={"floor": counts}
        )
        floor.followers += [one for one, _ in self._told if hasattr(one, "corrected")]
        return floor

    def _corrected_of(self, tell: Callable[[events.Event], None]) -> Callable[[events.Event], None]:
        """Return what tells events as they turned out."""
        handled, refused, orders = iter(self._noted.handled), self._noted.refused, self._noted.orders
        late, assigned = set[int](), defaultdict[int, set[int]](set)

        def told(event: events.Event) -> None:
            left_out = False
            match event:
                case events.ItemPicked():
                    event = evolve(event, picker_free_tick=next(handled))
                case events.OrderArrived() if self._floor.book[event.order].waits_for_stock:
                    late.add(event.order)
                case events.OrderInStock():  # of one that a count made wait again no event tells
                    left_out = event.order not in late
                    late.discard(event.order)
                case events.OrderAssigned() if (event.order, event.station, event.period) in refused:
                    left_out = True  # the session gave a command, and took it back
                case events.OrderAssigned():
                    assigned[event.order].update(event.skus)
                    event = evolve(event, complete=len(assigned[event.order]) == len(orders[event.order].lines))
            if left_out:
                self.on_event(event)
                self._floor.corrected[0].add(event.order)  # type: ignore[attr-defined]
                self._floor.tell_corrected()
            elif isinstance(event, events.RobotMoved):
                for leg in _straight(event, self._layout.width):
                    tell(leg)
            else:
                tell(event)

        return told

    def _kept_in(self, journal: Path | None, *, read_only: bool) -> Journal:  # noqa: ARG002
        return self._noted._journal  # with the batches that were noted, not later ones

    def prepared(self, rows: Any, wall_s: float) -> PreparedRun:
        """Return the run that this was."""
        rules = self._floor.rules
        versions, described = versions_of(rules, self._scenario), described_by(reversed(rules.instances))
        return PreparedRun(self._floor, rows, versions, described, self._out, self._noted.ended[1], wall_s)


def _straight(event: events.RobotMoved, width: int) -> Iterator[events.RobotMoved]:
    """Yield straight legs from one cell that the floor told of to the next: along the row first."""
    (row, column), (to_row, to_column) = divmod(event.origin, width), divmod(event.to, width)
    across, down = abs(to_column - column), abs(to_row - row)
    corner = row * width + to_column
    if across:
        heading = EAST if to_column > column else WEST
        yield evolve(event, to=corner, heading=heading, distance_m=across)
    if down or not across:
        heading = event.heading if not down else SOUTH if to_row > row else NORTH
        start = event.tick if across else event.start_tick
        yield evolve(event, start_tick=start, origin=corner, heading=heading, distance_m=down)


def run_day(
    scenario: Scenario,
    journal: Path,
    out: Path,
    record: Sequence[str] = (),
    observers: Sequence[object] = (),
    *,
    allow_inline_rules: bool = True,
) -> Result:
    """Replay a journal and write what a run leaves: result.json, tables, and the files of recorders.

    Parameters
    ----------
    scenario
        The scenario that the session was made from.
    journal
        The journal's file; another session may be writing it.
    out
        Folder for the files.
    record, observers, allow_inline_rules
        As for `rmfs_core.run`.

    Raises
    ------
    InputError
        Where the journal is none, of another scenario or version, or not answered as it was; nothing is written then.
    """
    dead_s = header_of(journal).get("dead_s")
    options: dict[str, Any] = {"allow_inline": allow_inline_rules, "read_only": True}
    noted = _Noting(scenario, journal, dead_s, **options)
    if not noted.seq:
        noted.close()
        raise InputError(str(journal), "has no batch; expected the journal of a session that was told facts")
    recorders, standing, rows = make_recorders(record), make_observers(), entrypoints.format_module("tables").Tables()
    told = [*((observer, None) for observer in observers), *recorders, *reversed(standing), (rows, None)]
    started = time.perf_counter()
    writing: Any = entrypoints.format_module("results").writing(out, scenario, [one for one, _ in standing])
    with writing as folder_for:
        folder = folder_for([one for one, name in told if name is not None])
        day = _Telling(noted, told, folder, scenario, journal, dead_s, **options)
        day.close()
        prepared = day.prepared(rows, time.perf_counter() - started)
        result = prepared.conclude()
        if prepared.error is not None:
            raise prepared.error
        result.save(folder)
    return result
