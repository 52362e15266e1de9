"""From the folder of a run to its replay: the columns of its trace, and what the page says of it."""

from __future__ import annotations

import inspect
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import EntryPoint
from itertools import chain
from pathlib import Path
from typing import Any

from attrs import frozen

from rmfs_core import entrypoints
from rmfs_core.clock import to_ticks
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE
from rmfs_core.wording import one_line, shown_short
from rmfs_replay.columns import COLUMNS_OF_LEGS, Columns, ColumnsBuilder, digits
from rmfs_replay.recorded import recorded_decisions
from rmfs_trace import FILE, Trace, TraceStream
from rmfs_validation.header import check_readable

ROLES = ("poa", "pps", "poa_pps", "pr", "ta", "pp")


@frozen(eq=False)
class Replay:
    """A run that can be watched.

    Parameters
    ----------
    name
        What the page calls it: the name of its folder.
    start
        The trace's header: what the run started from.
    tick, status
        When it ended, and how.
    columns
        Its events.
    metrics
        Of its result; empty where none lies beside the trace.
    decisions
        What its rules decided, where it was recorded.
    """

    name: str
    start: Trace
    tick: int
    status: str
    columns: Columns
    metrics: Mapping[str, Any]
    decisions: Mapping[str, Any] | None

    def to_dict(self) -> dict[str, Any]:
        """Return everything that the page needs, as plain values."""
        start, instance, layout = self.start, self.start.instance, self.start.layout
        return {
            "name": self.name,
            "status": self.status,
            "tick": self.tick,
            "seed": start.scenario.get("seed"),
            "warmup": to_ticks((start.scenario.get("run") or {}).get("warmup_s") or 0),
            "rules": rules_of(start.scenario),
            "about": summaries(set(rules_of(start.scenario).values())),
            "metrics": {name: value for name, value in self.metrics.items() if isinstance(value, int | float)},
            "layout": {
                "width": layout.width,
                "height": layout.height,
                "kind": digits(layout),
                "queues": [[cells.station, *cells.queue] for cells in layout.stations],
            },
            "motion": {
                "acceleration": start.motion.acceleration_m_per_s2,
                "speed": start.motion.top_speed_m_per_s,
            },
            "skus": list(instance.skus),
            "orders": {
                "name": [order.name for order in instance.orders],
                "lines_n": [len(order.lines) for order in instance.orders],
                "lines": list(chain.from_iterable(chain.from_iterable(order.lines for order in instance.orders))),
                **_dated(start),
            },
            "pods": {
                "name": [pod.name for pod in instance.pods],
                "contents_n": [len(pod.contents) for pod in instance.pods],
                "contents": [
                    -1 if value is None else value
                    for pod in instance.pods
                    for content in pod.contents
                    for value in content
                ],
                "cell": [pod["cell"] for pod in start.pods],
                "robot": [-1 if pod["robot"] is None else pod["robot"] for pod in start.pods],
                "bound_for": [list(pod["bound_for"]) for pod in start.pods],
            },
            "robots": {name: [robot[name] for robot in start.robots] for name in ("cell", "heading")},
            "stations": {
                name: [station[name] for station in start.stations] for name in ("name", "capacity", "counts_orders")
            },
            "blocked": list(start.blocked),
            "legs": {
                "n": [len(legs.gap) for legs in self.columns.legs],
                **{
                    name: list(chain.from_iterable(getattr(legs, name) for legs in self.columns.legs))
                    for name in COLUMNS_OF_LEGS
                },
            },
            "events": {
                kind: {name: list(values) for name, values in columns.items()}
                for kind, columns in self.columns.events.items()
            },
            "order": "".join(chr(ord("a") + code) for code in self.columns.order),
            "texts": list(self.columns.texts),
            "decisions": None
            if self.decisions is None
            else {name: list(values) for name, values in self.decisions.items()},
        }


def read_replay(path: str | Path) -> Replay:
    """Read what a run has recorded.

    Parameters
    ----------
    path
        The folder of a run with ``trace.jsonl.gz``, or a trace file.

    Raises
    ------
    InputError
        When there is no trace, or one that is damaged, cut off, or of another run than what lies beside it.
    """
    file = Path(path)
    if file.is_dir():
        if not (file / FILE).exists():
            raise InputError(str(file), f"has no {FILE}; `rmfs run --trace` records one")
        file = file / FILE
    stream = TraceStream(file)
    metrics = _metrics(file, stream.start)
    with sound(file):
        check_readable(stream.start)
        builder = ColumnsBuilder(stream.start)
        for event in stream:
            builder.add(event)
    decisions = recorded_decisions(file.parent, stream.start)
    name = file.resolve().parent.name
    return Replay(name, stream.start, stream.tick, stream.status, builder.columns(), metrics, decisions)


@contextmanager
def sound(file: Path) -> Iterator[None]:
    """Say in a sentence that a trace cannot be shown which nothing has recorded."""
    try:
        yield
    except (TypeError, KeyError, IndexError, AttributeError, ValueError, ArithmeticError) as error:
        problem = "what it says does not fit together, so that it cannot be shown; expected what rmfs has recorded"
        raise InputError(str(file), f"{problem} ({one_line(error)})") from error


def _metrics(file: Path, start: Trace) -> Mapping[str, Any]:
    """Return the metrics of the result beside a trace; none where there is no result."""
    result = file.parent / RESULT_FILE
    if not result.exists():
        return {}
    try:
        content = json.loads(result.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(str(result), f"cannot be read as JSON: {error}") from error
    if not isinstance(content, Mapping) or not isinstance(content.get("metrics"), Mapping):
        raise InputError(str(result), "expected a result that rmfs has written, with the key `metrics`")
    found, told = content.get("scenario"), start.scenario
    if different := _difference(found, told, ""):
        raise InputError(str(result), f"is of another run than {file.name}: {different}; expected what one run wrote")
    metrics: Mapping[str, Any] = content["metrics"]
    return metrics


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


def rules_of(scenario: Mapping[str, Any]) -> dict[str, str]:
    """Return the names of a scenario's rules by what they decide."""
    rules = scenario.get("rules") or {}
    found = {}
    for role in ROLES:
        choice = rules.get(role)
        name = choice.get("rule") if isinstance(choice, Mapping) else choice
        if isinstance(name, str):
            found[role.upper().replace("_", "+")] = name
    return found


def summaries(names: set[str]) -> dict[str, str]:
    """Return the first sentence of each installed rule's documentation, where it can be had."""
    offered = entrypoints.offers(entrypoints.RULES)
    found = {name: _summary(offered[name][0]) for name in sorted(names & offered.keys())}
    return {name: text for name, text in found.items() if text}


def _summary(entry: EntryPoint) -> str:
    try:
        return (inspect.getdoc(entry.load()) or "").partition("\n\n")[0].replace("\n", " ")
    except Exception:  # the run was recorded with a rule that can no longer be imported: it is shown without
        return ""


def _dated(start: Trace) -> dict[str, Any]:
    """Return due times and priorities, where any order has one."""
    orders = start.instance.orders
    if not start.instance.dated:
        return {}
    return {
        "due": [order.due_tick for order in orders],
        "priority": [order.priority for order in orders],
    }
