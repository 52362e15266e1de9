"""A run as plain values for the page of a replay; `view/unpack.mjs` reads it."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from importlib.metadata import EntryPoint
from itertools import chain, pairwise
from typing import Any

from rmfs_commands.details.catalogue import METRICS, PACKING
from rmfs_commands.replay.charges import Line
from rmfs_commands.replay.columns import COLUMNS_OF_LEGS, Columns
from rmfs_commands.replay.reading import Replay, picked_before
from rmfs_commands.results.figures import show
from rmfs_commands.trace import Trace
from rmfs_commands.trace.reader import packing_stations
from rmfs_core import entrypoints
from rmfs_core.roles import Role
from rmfs_core.world import Instance, Layout

SHOWN = (
    *("turnover_s", "packed_s", "psv_per_order", "pile_on", "distance_per_order_m"),
    *("orders_per_hour", "picks_per_hour", "picker_utilisation"),
)
"""Metrics of the result that the page shows next to what is so at a time."""
ROLES = tuple(role for role in Role if not role.many)
"""All that are decided by one rule at a time."""


def told(replay: Replay) -> dict[str, Any]:
    """Return everything that the page needs: lists instead of tuples and arrays, -1 instead of None in columns."""
    start = replay.start
    rules = rules_of(start.scenario)
    decisions = replay.decisions
    return {
        "name": replay.name,
        "status": replay.status,
        "tick": replay.tick,
        **({} if start.state is None else {"begin": start.began, "picked": picked_before(start)}),
        "seed": start.scenario.get("seed"),
        "rules": rules,
        "about": summaries(set(rules.values())),
        "metrics": metrics_of(replay.metrics),
        "says": list(replay.says),
        "layout": _layout(start.layout),
        "motion": {
            "acceleration": start.motion.acceleration_m_per_s2,
            "speed": start.motion.top_speed_m_per_s,
        },
        "skus": list(start.instance.skus),
        "orders": _orders(start.instance),
        "pods": _pods(start),
        "robots": {name: [robot[name] for robot in start.robots] for name in ("cell", "heading")},
        "stations": {
            **{name: [station[name] for station in start.stations] for name in ("name", "capacity", "counts_orders")},
            "bundle_capacity": [station.get("bundle_capacity", 0) for station in start.stations],
        },
        "packing": _packing(start),
        "blocked": list(start.blocked),
        **_columns(replay.columns),
        "charges": _charges(replay.columns.charges.lines(replay.tick)),
        "decisions": None if decisions is None else {name: list(values) for name, values in decisions.items()},
    }


def _layout(layout: Layout) -> dict[str, Any]:
    return {
        "width": layout.width,
        "height": layout.height,
        "kind": "".join(map(str, layout.kind.tolist())),
        "queues": [[cells.station, *cells.queue] for cells in layout.stations],
        **({"packing": [*layout.packing]} if layout.packing else {}),
    }


def _packing(start: Trace) -> dict[str, Any] | None:
    """Return how many packing stations there are, and what each has; None without them."""
    section = start.scenario.get("packing")
    if section is None:
        return None
    found = {name: section[name] for name in ("boxes", "packers", "sorters")}
    return {**found, "stations": packing_stations(start), "until_picked": section["packing_from"] == "picked"}


def _orders(instance: Instance) -> dict[str, Any]:
    orders = instance.orders
    found = {
        "name": [order.name for order in orders],
        "lines_n": [len(order.lines) for order in orders],
        "lines": list(chain.from_iterable(chain.from_iterable(order.lines for order in orders))),
    }
    if instance.dated:
        found["due"] = [order.due_tick for order in orders]
        found["priority"] = [order.priority for order in orders]
    return found


def _pods(start: Trace) -> dict[str, Any]:
    pods = start.instance.pods
    contents = chain.from_iterable(chain.from_iterable(pod.contents for pod in pods))
    return {
        "name": [pod.name for pod in pods],
        "contents_n": [len(pod.contents) for pod in pods],
        "contents": [-1 if value is None else value for value in contents],
        "cell": [pod["cell"] for pod in start.pods],
        "robot": [-1 if pod["robot"] is None else pod["robot"] for pod in start.pods],
        "bound_for": [list(pod["bound_for"]) for pod in start.pods],
    }


def _columns(columns: Columns) -> dict[str, Any]:
    """Return legs, robot by robot, and events; the kinds in the order of events are letters from a on."""
    legs = {name: list(chain.from_iterable(getattr(own, name) for own in columns.legs)) for name in COLUMNS_OF_LEGS}
    return {
        "legs": {"n": [len(own.gap) for own in columns.legs], **legs},
        "events": {kind: {name: list(values) for name, values in own.items()} for kind, own in columns.events.items()},
        "order": "".join(chr(ord("a") + code) for code in columns.order),
        "texts": list(columns.texts),
    }


def _charges(lines: Sequence[Line]) -> dict[str, list[int]]:
    """Return the charges, robot by robot: how many points each has, their times as differences, and how full."""
    return {
        "n": [len(line.ticks) for line in lines],
        "tick": [tick - before for line in lines for before, tick in pairwise([0, *line.ticks])],
        "charge": [charge for line in lines for charge in line.charges],
    }


def metrics_of(values: Mapping[str, Any]) -> list[list[str]]:
    """Return label and value of metrics, as people read them; none where there is no result."""
    known = {metric.name: metric for group in (*METRICS.values(), PACKING) for metric in group}
    found = [(known[name], values[name]) for name in SHOWN if isinstance(values.get(name), int | float)]
    return [[metric.label, f"{show(metric, value)} {metric.unit}".rstrip()] for metric, value in found]


def rules_of(scenario: Mapping[str, Any]) -> dict[str, str]:
    """Return the names of a scenario's rules by what they decide."""
    rules = scenario.get("rules") or {}
    found = {}
    for role in ROLES:
        choice = rules.get(role.key)
        name = choice.get("rule") if isinstance(choice, Mapping) else choice
        if isinstance(name, str):
            found[role.label] = name
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
