"""What the parts of a run share."""

from __future__ import annotations

from pathlib import Path

import pytest

from rmfs_commands.testing import small_world
from rmfs_core.errors import RuleError
from rmfs_core.scenario.model import RunSection, Scenario
from rmfs_core.simulation.context import RunContext
from rmfs_core.warehouse import WarehouseView
from rmfs_core.world import parse_map
from scripted import run_of, scripted, until_nothing_happens


def context(folder: Path, seed: int = 1, **rules: object) -> RunContext:
    """Return a run of scripted rules that answer with a number they have drawn."""
    world = small_world({"1": ["a"]}, {"p": ["a"]})
    run, rule = run_of(world, folder, **rules)
    run = RunContext(run.scenario.with_seed(seed), run.rules, world)
    for each in (rule, *(bound.instance for bound in run.rules.filters)):
        each.answers = {hook: [lambda told: told["rng"].random()] * 9 for hook in ("assign_orders", "filter_backlog")}
    return run


def drawn(run: RunContext) -> list[float]:
    """Ask the assigning rule and each filter for a number."""
    poa = run.rules.poa
    assert poa is not None
    return [run.ask(poa)[0], *(run.ask(rule, orders=())[0] for rule in run.rules.filters)]


def test_every_rule_draws_from_a_stream_of_its_own(tmp_path: Path) -> None:
    """Also two filters of one name; another rule beside it changes nobody's numbers."""
    filters = (scripted("First"), scripted("Second"), scripted("Second"))
    numbers = drawn(context(tmp_path, filters=filters))
    assert len(set(numbers)) == 4
    assert drawn(context(tmp_path, filters=filters)) == numbers
    assert drawn(context(tmp_path, filters=filters[1:])) == [numbers[0], *numbers[2:]]
    assert not set(drawn(context(tmp_path, seed=2, filters=filters))) & set(numbers)


def test_a_stream_goes_on_from_question_to_question(tmp_path: Path) -> None:
    """The second number of a rule is its second, whatever others draw in between."""
    run = context(tmp_path, filters=(scripted("First"),))
    (one, _), (two, _) = drawn(run), drawn(run)
    alone = context(tmp_path)
    assert [*drawn(alone), *drawn(alone)] == [one, two]
    assert one != two


def test_rules_see_the_whole_warehouse_unless_they_are_shown_less(tmp_path: Path) -> None:
    """The view that a question has is the one that is handed over."""
    world = small_world({"1": ["a"]}, {"p": ["a"]})
    run, rule = run_of(world, tmp_path)
    poa, less = run.rules.poa, WarehouseView(world, ())
    assert poa is not None
    run.ask(poa)
    run.ask(poa, less)
    assert [told["warehouse"] for _, told in rule.asked] == [run.view, less]


def test_the_clock_counts_ticks(tmp_path: Path) -> None:
    """What happens after some ticks happens then."""
    run = context(tmp_path)
    ticks: list[int] = []
    for wait in (70, 30):
        run.after(wait).callbacks.append(lambda _: ticks.append(run.warehouse.now))
    until_nothing_happens(run)
    assert ticks == [30, 70]


def test_the_limit_of_the_scenario_holds(tmp_path: Path) -> None:
    """Without one, nothing depends on the wall clock."""
    world = small_world({"1": ["a"]}, {"p": ["a"]})
    given, _ = run_of(world, tmp_path)
    limited = Scenario(rules=given.scenario.rules, run=RunSection(decision_limit_s=1e-9))
    run, _ = run_of(world, tmp_path, limited)
    assert (given.rules.ta.hook.name, given.ask(given.rules.ta)[0]) == ("assign_tasks", ())
    with pytest.raises(RuleError, match=r"assign_tasks, at 0.000 s: took .* allows run.decision_limit_s = 1e-09"):
        run.ask(run.rules.ta)


def test_the_profile_divides_wall_clock_time(tmp_path: Path) -> None:
    """Path queries are apart from the other rules, and tables that a rule caused from the rule's own time."""
    layout = parse_map("#....\n.....\n.qO..\n.....", "a layout that no other test has tables of")
    world = small_world({"1": ["a"]}, {"p": ["a"]}, robots=1, layout=layout)
    goal = world.stations[0].cell
    world.travel.load_searches()
    run, rule = run_of(world, tmp_path)
    rule.answers = {"plan_path": [lambda told: told["warehouse"].travel.times_to(layout.width, True)]}
    assert run.profile == {"tables": 0.0, "queries": 0.0, "rules": 0.0, "observers": 0.0}
    run.ask(run.rules.ta)
    _, seconds = run.ask(run.rules.pp, robot=None, goal=goal, traffic=None)
    profile = run.profile
    assert profile["rules"] == run.asker.seconds["assign_tasks"] > 0
    assert 0 < profile["tables"] < seconds
    assert profile["queries"] == pytest.approx(seconds - profile["tables"])
