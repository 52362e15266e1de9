"""From the folder of a run to its replay: the columns of its trace, and what is next to it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from attrs import frozen

from rmfs_commands.replay.columns import Columns, ColumnsBuilder
from rmfs_commands.replay.recorded import recorded_decisions
from rmfs_commands.trace import Trace, TraceStream, fitting, trace_file
from rmfs_commands.validation.checking import read_result
from rmfs_commands.validation.header import check_readable
from rmfs_core.errors import InputError
from rmfs_core.events import Event
from rmfs_core.results import RESULT_FILE
from rmfs_core.wording import shown_short


@frozen(eq=False)
class Replay:
    """A run that can be watched.

    Parameters
    ----------
    name
        Its name on the page: that of its folder.
    start
        The trace's header: what the run started from.
    tick, status
        When it ended, and how.
    columns
        Its events.
    metrics
        Of its result; empty where none is next to the trace.
    says
        Sentence on what limits it, of the result's summary.
    decisions
        Decisions of its rules, where they were recorded.
    """

    name: str
    start: Trace
    tick: int
    status: str
    columns: Columns
    metrics: Mapping[str, Any]
    says: Sequence[str]
    decisions: Mapping[str, Any] | None


class Follower(Protocol):
    """The followers of a trace while it is read."""

    def start(self, trace: Trace) -> None:
        """Begin with what the run started from."""

    def follow(self, event: Event) -> None:
        """Take an event, one after another."""


def read_replay(path: str | Path, follower: Follower | None = None) -> Replay:
    """Read what a run has recorded.

    Parameters
    ----------
    path
        The folder of a run with ``trace.jsonl.gz``, or a trace file.
    follower
        Is told of the events, too.

    Raises
    ------
    InputError
        When there is no trace, or one that is damaged, cut off, or of another run than what is next to it.
    """
    file = trace_file(path)
    stream = TraceStream(file)
    metrics, says = _result(file, stream.start)
    with fitting(file, "shown"):
        check_readable(stream.start)
        builder = ColumnsBuilder(stream.start)
        if follower is not None:
            follower.start(stream.start)
        for event in stream:
            builder.add(event)
            if follower is not None:
                follower.follow(event)
    columns = builder.columns()
    decisions = recorded_decisions(file.parent, stream.start, columns.bundles())
    name = file.resolve().parent.name
    return Replay(name, stream.start, stream.tick, stream.status, columns, metrics, says, decisions)


def picked_before(start: Trace) -> list[tuple[int, int, int]]:
    """Return order, SKU and number of items that were picked before a run that begins in a state; else nothing.

    Items in hand count as not picked: the events of the trace tell of them.
    """
    if start.state is None:
        return []
    told, skus = start.state["content"], {name: i for i, name in enumerate(start.instance.skus)}
    ids = {order.name: i for i, order in enumerate(start.instance.orders)}
    left: Counter[tuple[str, str]] = Counter()
    for station in told["stations"].values():
        asked = [*station.get("requests", ()), *([] if station.get("in_hand") is None else [station["in_hand"]])]
        left.update((one["order"], one["sku"]) for one in asked)
    begun = {order for order, _ in left}
    handled = [one for one in (told.get("run") or {}).get("going", ()) if one["kind"] == "handled"]
    left.update((one["order"], one["sku"]) for one in handled)
    found = []
    for name, order in told["orders"].items():
        parts = order.get("parts")
        whole = order.get("cancelled") or (parts is None and name not in begun)
        assigned = {sku for part in parts or () for sku in part["skus"]}
        for sku, quantity in () if whole else order["lines"].items():
            kept = quantity if sku not in assigned and not left[name, sku] else left[name, sku]
            found.append((ids[name], skus[sku], quantity - kept))
    return [one for one in found if one[2] > 0]


def _result(file: Path, start: Trace) -> tuple[Mapping[str, Any], Sequence[str]]:
    """Return metrics and what limits the run, of the result next to a trace; none where there is no result."""
    result = file.parent / RESULT_FILE
    if (content := read_result(result)) is None:
        return {}, ()
    found, told = content.get("scenario"), start.scenario
    if different := _difference(found, told, ""):
        raise InputError(str(result), f"is of another run than {file.name}: {different}; expected files of one run")
    said: Any = content
    for key in ("summary", "bottleneck", "says"):
        said = said.get(key) if isinstance(said, Mapping) else None
    with fitting(result, "shown"):
        return content["metrics"], [str(sentence) for sentence in said or ()]


def _difference(found: object, told: object, key: str) -> str | None:
    """Say where a result's scenario is not that of the trace."""
    if isinstance(found, Mapping) and isinstance(told, Mapping):
        for name in {**found, **told}:
            below = _difference(found.get(name), told.get(name), f"{key}.{name}" if key else str(name))
            if below:
                return below
        return None
    if found == told:
        return None
    return f"its {key or 'scenario'} is {shown_short(found)}, that of the trace {shown_short(told)}"
