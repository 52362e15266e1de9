"""The frozen instances, as ``instances.toml`` has them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import attrs
from attrs import field, frozen

from rmfs_commands.instances.toml_lines import read_toml
from rmfs_core.errors import InputError
from rmfs_core.scenario import Scenario, scenario_from_dict, scenario_to_dict
from rmfs_core.simulation.setup import open_warehouse
from rmfs_core.warehouse import WarehouseView
from rmfs_core.wording import nearest
from rmfs_core.world import Instance, make_instance, make_layout

FILE, BOUNDS_FILE = "instances.toml", "bounds.json"
RULES: Mapping[str, Any] = {"poa": "pod-match", "pps": "completes", "pr": "nearest", "ta": "nearest-robot"}
"""Of an instance that is run without others."""
PATHS = {"free": "free-flow", "shared": "sipp"}
"""Rule for paths that goes with each kind of roads."""
OBJECTIVES = ("pod_station_visits", "makespan_s", "turnover_s", "packed_s", "late_orders", "distance_m")
"""Metrics with best known values; less of each is better."""


@frozen
class Frozen:
    """An instance of the set.

    Parameters
    ----------
    name, about
        Its name and its purpose.
    roads
        ``"free"``, where robots do not stand in each other's way, or ``"shared"``, where no two hold one cell.
    checksum
        Of what its scenario makes, as `checksum_of` has it.
    scenario
        The scenario, with `RULES`.
    """

    name: str
    about: str
    roads: str
    checksum: str
    scenario: Scenario = field(repr=False)

    @property
    def objectives(self) -> tuple[str, ...]:
        """The metrics of `OBJECTIVES` that it has: of packing and due times only where there are such."""
        section = self.scenario.instance
        dated = section.due is not None or section.departures is not None
        lacking = {"packed_s"} if self.scenario.packing is None else set()
        return tuple(name for name in OBJECTIVES if name not in lacking | ({"late_orders"} if not dated else set()))

    def reached(self, row: Mapping[str, Any]) -> dict[str, float | None]:
        """Return what a run has of each objective, by its row of an experiment; None unless the run is complete."""
        return {name: row.get(name) if row["status"] == "complete" else None for name in self.objectives}

    @property
    def static(self) -> bool:
        """Whether whole schedules can be made for it: all orders are there at the start, nothing is packed."""
        return self.scenario.instance.arrivals.process == "start" and self.scenario.packing is None

    def with_rules(self, rules: Mapping[str, Any]) -> Scenario:
        """Return the scenario with other rules; those for paths are of its roads where ``rules`` has none.

        Raises
        ------
        InputError
            When rules do not fit together.
        """
        data = scenario_to_dict(self.scenario)
        joint = {"poa_pps"} if "poa_pps" not in rules else {"poa", "pps"}
        usual = {key: rule for key, rule in RULES.items() if key not in joint}
        data["rules"] = {**usual, "pp": PATHS[self.roads], **rules}
        return scenario_from_dict(data, name=f"benchmark instance {self.name}")

    def problem_with(self, scenario: Mapping[str, Any]) -> str | None:
        """Return what in a recorded scenario is not this instance's; None where only its rules are others."""
        own = json.loads(json.dumps(scenario_to_dict(self.scenario)))
        for key in {*own, *scenario} - {"rules"}:
            if own.get(key) != json.loads(json.dumps(scenario.get(key))):
                return f"its `{key}` is not that of the instance"
        rules = scenario.get("rules") or {}
        if rules.get("move") is not None:
            return "its rules carry pods without a visit (`rules.move`), which bounds do not allow for"
        return None


@frozen
class BenchmarkSet:
    """All instances of a version of the set, by name."""

    version: str
    instances: Mapping[str, Frozen]

    def find(self, name: str) -> Frozen:
        """Return an instance; raise `InputError` for a name that none has."""
        if name not in self.instances:
            raise InputError(name, f"there is no such instance{nearest(name, list(self.instances))}")
        return self.instances[name]

    def chosen(self, names: Sequence[str]) -> list[Frozen]:
        """Return the instances with these names, or all; a name that ends in ``*`` stands for all that begin so.

        Raises
        ------
        InputError
            When there is none.
        """
        found: dict[str, Frozen] = {}
        for name in names:
            many = [one for key, one in self.instances.items() if name.endswith("*") and key.startswith(name[:-1])]
            if name.endswith("*") and not many:
                raise InputError(name, "no instance has a name that begins so; `rmfs benchmark list` has all names")
            found |= {one.name: one for one in many or [self.find(name)]}
        return list(found.values() if names else self.instances.values())


@cache
def benchmark_set() -> BenchmarkSet:
    """Return the set that comes with the package."""
    data = read_toml(Path(__file__).with_name(FILE).read_text("utf-8"))
    found = {}
    for entry in data["instance"]:
        name, roads = entry["name"], entry["roads"]
        given = {**entry["scenario"], "seed": entry["seed"], "rules": {**RULES, "pp": PATHS[roads]}}
        scenario = scenario_from_dict(given, name=f"benchmark instance {name}")
        found[name] = Frozen(name, entry["about"], roads, entry["checksum"], scenario)
    return BenchmarkSet(data["version"], found)


@cache
def known_bounds() -> dict[str, dict[str, float]]:
    """Return the bounds that were proven for the set, by instance and metric."""
    found: dict[str, dict[str, float]] = json.loads(Path(__file__).with_name(BOUNDS_FILE).read_text("utf-8"))
    return found


def checksum_of(instance: Instance, pods: Sequence[int], robots: Sequence[int], empty: Sequence[int]) -> str:
    """Return the SHA-256 of an instance and of where everything stands at time 0.

    Parameters
    ----------
    instance
        Orders and pods with contents.
    pods, robots, empty
        Cells of the pods, of the robots, and of the pods without contents.
    """
    content = {**attrs.asdict(instance), "cells": [list(pods), list(robots), sorted(empty)]}
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return f"sha256:{hashlib.sha256(text.encode()).hexdigest()}"


def made_checksum(scenario: Scenario) -> str:
    """Return the checksum of what a scenario makes here."""
    instance = make_instance(scenario)
    warehouse = WarehouseView(open_warehouse(scenario, instance, make_layout(scenario)).warehouse)
    cells = [pod.cell for pod in warehouse.pods], [robot.cell for robot in warehouse.robots]
    return checksum_of(instance, *cells, warehouse.blocked_locations)
