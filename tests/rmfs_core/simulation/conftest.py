from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rmfs_commands.testing import small_layout
from rmfs_core.rules import RuleSet
from rmfs_core.scenario.model import (
    InstanceSection,
    LayoutSection,
    RobotsSection,
    RuleChoice,
    RulesSection,
    RunSection,
    Scenario,
    StationsSection,
)
from rmfs_core.simulation.engine import Simulation
from rmfs_core.world import Instance, Layout
from told import ToldRun

SEQUENTIAL = {"poa": "pod-match", "pps": "demand", "pr": "nearest", "ta": "nearest-robot", "pp": "free-flow"}


@pytest.fixture
def tiny_run(tmp_path: Path) -> Callable[..., ToldRun]:

    def prepare(
        instance: Instance,
        *,
        layout: Layout | None = None,
        robots: int = 1,
        capacity: int | tuple[int, ...] = 15,
        order_capacity: int | None = None,
        queue_length: int = 3,
        run: RunSection | None = None,
        at_stations: dict[str, tuple[str, ...]] | None = None,
        seed: int = 1,
        change: Callable[[Scenario], Scenario] = lambda scenario: scenario,
        **rules: Any,
    ) -> ToldRun:
        chosen = SEQUENTIAL | rules
        if "poa_pps" in chosen:
            del chosen["poa"], chosen["pps"]
        filters, observers = (
            tuple(RuleChoice(name) for name in chosen.pop(key, ())) for key in ("filters", "observers")
        )
        choices = {r: c if isinstance(c, RuleChoice) else RuleChoice(c) for r, c in chosen.items()}
        scenario = Scenario(
            rules=RulesSection(filters=filters, observers=observers, **choices),
            seed=seed,
            instance=InstanceSection(pods_at_stations=at_stations or {}),
            layout=LayoutSection(pod_fill=0.05),
            robots=RobotsSection(count=robots),
            stations=StationsSection(item_capacity=capacity, order_capacity=order_capacity, queue_length=queue_length),
            run=run or RunSection(),
            folder=str(tmp_path),
        )
        scenario = change(scenario)
        loaded = RuleSet.load(scenario.rules, scenario.folder)
        stations = len(capacity) if isinstance(capacity, tuple) else 1
        layout = layout or small_layout(stations, queue_length=queue_length)
        run = ToldRun(Simulation(scenario, instance, layout, loaded))
        loaded.register_observer(run)
        return run

    return prepare
