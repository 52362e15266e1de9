"""The event trace of a run, ``trace.jsonl.gz``: one JSON object a line, compressed with gzip, UTF-8.

The trace and nothing else is enough to recompute every metric and to say where every robot and pod is at any time.
`rmfs_commands.trace.read_trace` reads it. Ids count from 0 and are positions in the lists of the header. A cell is
``row * width + column``; row 0 is north, column 0 west. Headings are 0 east, 1 north, 2 west, 3 south. Times are whole
ticks of ``tick_s`` seconds since the start of the run.

First line, the header::

    format, version   "rmfs-trace", 1
    tick_s            0.001
    versions          of what draws layouts and instances: rmfs, numpy
    scenario          the resolved scenario (as in result.json)
    map               the text of the scenario's map file, where it has one
    layout            width, height
                      kind: a text per row, a digit per cell: 0 wall, 1 floor, 2 storage location, 3 queue, 4 station,
                      5 charger, 6 maintenance cell
                      moves: a text per row, a hexadecimal digit per cell; bit 1 << heading is set where a robot may
                      step from the cell into its neighbour in that heading
                      stations: for each its cell and its queue's cells, the one next to the station first
                      replenishing: how many of these, the last ones, are no picking stations; left out: none
                      packing: cells of the packing stations; left out: there are none on it
    motion            acceleration_m_per_s2, top_speed_m_per_s, full_turn_s, lift_s
    skus              names
    sizes             space that an item of each SKU takes on a pod; left out: 1 each
    bundles           of a file: [name, arrival (tick), SKU, items] each; left out: there is none
    restocked         true where bundles may arrive
    levels            [reorder point, order-up-to level] of each SKU, in items; left out: nothing is reordered
    orders            name, arrival (tick), lines: [SKU, quantity] each; due, cancelled (ticks), priority and route
                      of trucks where it has one
    pods              name, contents: [SKU, items or null for unlimited] each, cell, robot that carries it or null,
                      bound_for: stations it is at or bound for from the start; place: [row, column], from 1, of the
                      storage location in which it stands at first, where the file of pods says so
    robots            cell, heading
    stations          name, capacity, counts_orders (capacity in orders instead of items); bundle_capacity where bundles
                      are stored
    blocked           storage locations that hold an empty pod for the whole run
    state             of a run that begins in a state: file, sha256, tick, content: the state (`rmfs-state`), lines:
                      robots in line at each station. Pods and robots of the header are as it has them, and the events
                      begin with what observers are told of the time before (times up to ``tick``); left out: the run
                      begins at time 0
    reserves          null where the PP rule does not keep robots apart: they pass through each other; left out: it does
    floor             of a real day: batches, facts, dropped ones, corrected_s, when the floor first corrected what was
                      known, or null, and waiting, ids of orders that waited for stock from their arrival to the end

Then one line an event, in the order in which they happened: ``e``, the event's class in lower case with underscores,
and the fields of that class in `rmfs.events` (where each is documented), ``tick`` first. Left out is ``wall_s``
of ``decision_made``: equal runs have equal traces. ``decides`` is ``"POA"``, ``"PPS"``, ``"POA+PPS"``, ``"ROA"``,
``"RPS"`` or ``"ROA+RPS"``.

Where a robot is: it rests at its header cell until its first ``robot_moved``. In such a leg it stands at ``origin`` for
``wait_ticks`` from ``start_tick``, turns there for ``turn_ticks`` to ``heading``, and drives ``distance_m`` cells
straight until ``tick``: from rest with ``acceleration_m_per_s2`` up to ``top_speed_m_per_s``, and back to rest
(`rmfs_core.motion.Motion.position_m`). It then rests at ``to``. A leg that ``run.until_s`` cut off has the ``tick`` of
the end, and ``to`` is the last cell whose centre the robot has passed by then. A pod is where its robot is from
``pod_lifted`` to ``pod_stored``; an item leaves it with each ``item_picked``, and those of a bundle come with
``bundle_stored``.

Last line: ``{"e": "end", "tick": ..., "status": ...}`` with the status ``complete``, ``horizon``, ``partial`` or
``failed``. A trace without it was cut off.
"""

from __future__ import annotations

import hashlib
import json
import re
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import attrs

from rmfs_commands.instances.tables import finite
from rmfs_commands.processes import events as of_processes
from rmfs_commands.results.files import json_ready
from rmfs_commands.trace.json_lines import JsonLinesFile, beside_results
from rmfs_core import events
from rmfs_core.clock import TICKS_PER_S
from rmfs_core.events import DecisionMade, Event
from rmfs_core.hookspecs import hookimpl
from rmfs_core.scenario import scenario_to_dict

if TYPE_CHECKING:
    from rmfs_core.info import RunInfo
    from rmfs_core.warehouse import Station
    from rmfs_core.world import Layout, OrderData, StationCells

FILE = "trace.jsonl.gz"
FORMAT = "rmfs-trace"
VERSION = 1
NOT_TRACED = frozenset({"wall_s"})
MADE_BY = ("rmfs", "numpy")
"""Distributions on whose versions it depends what a scenario and its seed make."""


def _snake(name: str) -> str:
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()


EVENTS: dict[str, type[Event]] = {
    _snake(name): kind
    for module in (events, of_processes)
    for name in module.__all__
    if (kind := getattr(module, name)) is not Event
}
"""Every class of event by its name in a trace."""

_NAMES = {kind: name for name, kind in EVENTS.items()}
_FIELDS = {
    kind: tuple(field.name for field in attrs.fields(kind) if field.name not in NOT_TRACED) for kind in EVENTS.values()
}


class TraceWriter:
    """Observer that writes the trace next to the results while the run goes on; it has its name once that has ended."""

    file: ClassVar = FILE

    @hookimpl
    def run_started(self, run: RunInfo) -> None:
        """Write the header."""
        self._file = JsonLinesFile(beside_results(run, self.file))
        self._file.write(header(run))

    @hookimpl
    def on_event(self, event: Event) -> None:
        """Write a line."""
        kind = type(event)
        line: dict[str, Any] = {"e": _NAMES[kind]}
        for name in _FIELDS[kind]:
            line[name] = getattr(event, name)
        if isinstance(event, DecisionMade):
            line["decides"] = event.decides.label
            line["objective"], line["bound"] = finite(event.objective), finite(event.bound)
        self._file.write(line)

    @hookimpl
    def run_ended(self, tick: int, status: str) -> None:
        """Write the last line and give the file its name."""
        self._file.write({"e": "end", "tick": tick, "status": status})
        self._file.commit()


def header(run: RunInfo) -> dict[str, Any]:
    """Return the first line of a run's trace."""
    warehouse, instance = run.warehouse, run.instance
    return {
        "format": FORMAT,
        "version": VERSION,
        "tick_s": 1 / TICKS_PER_S,
        "versions": {name: version(name) for name in MADE_BY},
        "scenario": json_ready(scenario_to_dict(run.scenario)),
        **_map(run),
        "layout": _layout(run.layout),
        "motion": attrs.asdict(run.motion),
        "skus": instance.skus,
        **({"sizes": instance.sizes} if instance.sizes else {}),
        **({"bundles": [attrs.astuple(bundle) for bundle in instance.bundles]} if instance.bundles else {}),
        **({"levels": instance.levels} if instance.levels else {}),
        **({"restocked": True} if instance.restocked else {}),
        "orders": [_order(order) for order in instance.orders],
        "pods": [
            {
                "name": pod.name,
                "contents": data.contents,
                "cell": pod.cell,
                "robot": pod.robot if pod.location is None else None,
                "bound_for": pod.bound_for,
                **({} if data.place is None else {"place": data.place[:2]}),
            }
            for pod, data in zip(warehouse.pods, instance.pods, strict=True)
        ],
        "robots": [{"cell": robot.cell, "heading": robot.heading} for robot in warehouse.robots],
        "stations": [_station(warehouse.station(i)) for i in range(len(run.layout.stations))],
        "blocked": warehouse.blocked_locations,
        **_state(run),
        **({} if run.apart else {"reserves": None}),
        **({"floor": run.summary["floor"]} if "floor" in run.summary else {}),
    }


def _state(run: RunInfo) -> dict[str, Any]:
    """Return the state that a run begins in, whole: a trace needs no file next to it."""
    name = run.scenario.instance.state_file
    if name is None:
        return {}
    content = (Path(run.scenario.folder) / name).read_bytes()
    digest = hashlib.sha256(content).hexdigest()
    robots = {robot.pod: robot.id for robot in run.warehouse.robots if robot.pod is not None}
    lines = [[robots[pod] for pod in run.warehouse.station(i).pods_in_line] for i in range(len(run.layout.stations))]
    told = {"file": name, "sha256": digest, "tick": run.began, "lines": lines}
    return {"state": {**told, "content": json.loads(content)}}


def _map(run: RunInfo) -> dict[str, str]:
    name = run.scenario.layout.map_file
    return {} if name is None else {"map": (Path(run.scenario.folder) / name).read_text(encoding="utf-8-sig")}


def _station(station: Station) -> dict[str, Any]:
    told = {"name": station.name, "capacity": station.capacity, "counts_orders": station.counts_orders}
    return told | ({"bundle_capacity": station.bundle_capacity} if station.stores else {})


def _order(order: OrderData) -> dict[str, Any]:
    told: dict[str, Any] = {"name": order.name, "arrival": order.arrival_tick, "lines": order.lines}
    if order.due_tick is not None:
        told["due"] = order.due_tick
    if order.cancelled_tick is not None:
        told["cancelled"] = order.cancelled_tick
    if order.route is not None:
        told["route"] = order.route
    return told | ({"priority": order.priority} if order.priority else {})


def _layout(layout: Layout) -> dict[str, Any]:
    def rows(cells: Any) -> list[str]:
        digits = "".join(f"{int(cell):x}" for cell in cells)
        return [digits[i : i + layout.width] for i in range(0, len(digits), layout.width)]

    return {
        "width": layout.width,
        "height": layout.height,
        "kind": rows(layout.kind),
        "moves": rows(layout.moves),
        "stations": [_station_cells(cells) for cells in layout.stations],
        **({"replenishing": layout.replenishing} if layout.replenishing else {}),
        **({"packing": layout.packing} if layout.packing else {}),
    }


def _station_cells(cells: StationCells) -> dict[str, Any]:
    told = {"cell": cells.station, "queue": cells.queue}
    return told | {"clear": cells.clear} if cells.clear else told
