from pathlib import Path
from typing import Any

from attrs import evolve

from rmfs_core.rules import RuleSet
from rmfs_core.scenario.model import RuleChoice, RulesSection, Scenario
from rmfs_core.simulation.context import RunContext
from rmfs_core.warehouse import Warehouse

SOURCE = """
from attrs import define, field
from rmfs_core import hookimpl

@define
class Scripted:
    answers: dict = field(init=False, factory=dict)
    asked: list = field(init=False, factory=list)
    def told(self, hook, default, **arguments):
        self.asked.append((hook, arguments))
        answer = self.answers[hook].pop(0) if self.answers.get(hook) else default
        return answer(arguments) if callable(answer) else answer
    @hookimpl
    def assign_orders(self, warehouse, rng): return self.told("assign_orders", (), warehouse=warehouse, rng=rng)
    @hookimpl
    def select_pods(self, warehouse, max_fetches):
        return self.told("select_pods", (), warehouse=warehouse, max_fetches=max_fetches)
    @hookimpl
    def choose_storage_location(self, warehouse, pod):
        return self.told("choose_storage_location", -1, warehouse=warehouse, pod=pod)
    @hookimpl
    def assign_tasks(self, warehouse): return self.told("assign_tasks", (), warehouse=warehouse)
    @hookimpl
    def plan_path(self, warehouse, robot, goal, traffic):
        return self.told("plan_path", None, warehouse=warehouse, robot=robot, goal=goal, traffic=traffic)

@define
class First(Scripted):
    @hookimpl
    def filter_backlog(self, warehouse, orders, rng):
        return self.told("filter_backlog", orders, warehouse=warehouse, orders=orders, rng=rng)

@define
class Second(First):
    pass

@define
class Waking(First):
    also: int = 0
    @hookimpl
    def wake_at(self, warehouse): return self.told("wake_at", None, now_s=warehouse.now_s)

@define
class Joint(Scripted):
    @hookimpl
    def assign_orders_and_pods(self, warehouse):
        return self.told("assign_orders_and_pods", (), warehouse=warehouse)
"""


def scripted(name: str = "Scripted") -> RuleChoice:
    return RuleChoice(f"./scripted_rules.py:{name}")


def run_of(world: Warehouse, folder: Path, scenario: Scenario | None = None, **rules: Any) -> tuple[RunContext, Any]:
    """Return a run in which one scripted rule decides everything, and that rule; ``rules`` take its place in a role."""
    (folder / "scripted_rules.py").write_text(SOURCE, encoding="utf-8")
    single = {role: scripted() for role in ("pr", "ta", "pp")}
    orders = {} if "poa_pps" in rules else {"poa": scripted(), "pps": scripted()}
    chosen = RulesSection(**(single | orders | rules))
    scenario = Scenario(rules=chosen) if scenario is None else evolve(scenario, rules=chosen)
    loaded = RuleSet.load(chosen, str(folder))
    return RunContext(scenario, loaded, world), loaded.pp.instance


def until_nothing_happens(run: RunContext) -> None:
    """Let everything happen that is due, as the engine does: the warehouse's clock goes with the events."""
    while run.env.peek() < float("inf"):
        run.warehouse.advance(int(run.env.peek()))
        run.env.step()
