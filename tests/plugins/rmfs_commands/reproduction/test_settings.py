"""The paper's parameters beside those of scenarios."""

from attrs import evolve

from rmfs_commands.reproduction.paper import load_paper
from rmfs_commands.reproduction.settings import Setting, settings
from rmfs_core.scenario import RuleChoice, load_scenario


def test_the_shipped_experiment_has_the_papers_settings(jobs) -> None:
    """All of them: the 24 instances, layout, robots, times and rules."""
    scenarios = [job.scenario for job in jobs["instances"] if job.seed == 1]
    differing = [entry for entry in settings(load_paper()["settings"], scenarios) if entry.verdict != "same"]
    assert differing == []


def test_some_of_several_values_do_not_differ() -> None:
    """A reproduction of one instance set has some of the paper's numbers of orders."""
    assert Setting("Number of orders |O|", "50, 150, 250", "50").verdict == "some of them"
    assert Setting("Number of orders |O|", "50, 150, 250", "40, 50").verdict == "differs"
    assert Setting("PP", "whca-n", "").verdict == "differs"


def test_what_differs_is_said() -> None:
    """One robot more, another weight and another path planning."""
    scenario = load_scenario("paper-250-integrated", ["robots.count=9", "rules.pp=free-flow"])
    weighted = RuleChoice("integrated", {"unused_capacity_weight": 3.5})
    scenario = evolve(scenario, rules=evolve(scenario.rules, poa_pps=weighted))
    found = {entry.name: entry for entry in settings(load_paper()["settings"], [scenario])}
    assert found["Robots"] == Setting("Robots", "8", "9")
    assert found["Robots"].verdict == "differs"
    assert found["W_u"].ours == "3.5"
    assert found["PP"].ours == "free-flow"
    assert found["POA, sequential"].ours == ""
