"""Which sources runs, scenarios and rules have."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from importlib.metadata import metadata, version
from pathlib import Path
from typing import Any

from attrs import evolve, frozen

from rmfs_commands.cite.bibtex import CORPORATE, Reference, references_in, with_own_keys
from rmfs_commands.cli.description import RuleDescription, installed_rules, sections
from rmfs_commands.experiments import load_experiment, shipped_experiments
from rmfs_commands.experiments.command import RUNS_FOLDER
from rmfs_commands.instances.toml_lines import read_toml
from rmfs_commands.validation.checking import read_result
from rmfs_core.errors import InputError
from rmfs_core.results import RESULT_FILE
from rmfs_core.rules import RuleSet
from rmfs_core.rules.sources import RuleSources
from rmfs_core.scenario import Scenario, load_scenario, located, scenario_from_dict
from rmfs_core.scenario.reading import shipped_scenarios
from rmfs_core.scenario.rulenames import rule_choices
from rmfs_core.scenario.source import dotted
from rmfs_core.wording import did_you_mean

RMFS, CITATION = "rmfs", "CITATION.cff"
SET, SET_VERSION = "benchmark", "1"
"""Name by which `rmfs cite` is asked for the instances of `rmfs benchmark`, and the version of the set."""
EXPECTED = "a rule, a scenario, an experiment, the folder of a run, a comparison or benchmark runs, or benchmark"


@frozen
class Cited:
    """A source, and the rules that name it.

    Parameters
    ----------
    reference
        The source.
    rules
        Names of the rules, `RMFS` for the framework itself, with what they say of it.
    """

    reference: Reference
    rules: Mapping[str, str]


def cited(what: Iterable[str], *, allow_inline: bool = True) -> list[Cited]:
    """Return every source once, rmfs first.

    Parameters
    ----------
    what
        Folders of runs, scenarios, files of rules, and names of rules.
    allow_inline
        Whether rules may be loaded from files.

    Raises
    ------
    InputError
        When something is none of these.
    """
    installed = {rule.name: rule for rule in installed_rules()}
    named: dict[str, list[Reference]] = {}
    what = [*what]
    on_set = any(one == SET or _is_file(Path(one) / f"{SET}.json") for one in what)
    of_set = [Cited(_instances(), {SET: ""})] if on_set else []
    for one in what:
        if one == SET:
            continue
        for rule, text in _references(one, installed, allow_inline):
            named.setdefault(rule, references_in(text))
    pairs = [(rule, reference) for rule, references in named.items() for reference in references]
    entries = {entry.title: entry for entry in with_own_keys(reference for _, reference in pairs)}
    rules: dict[str, dict[str, str]] = {title: {} for title in entries}
    for rule, reference in pairs:
        rules[reference.title][rule] = reference.note
    return [Cited(_software(), {RMFS: ""}), *of_set, *(Cited(entry, rules[title]) for title, entry in entries.items())]


def _references(one: str, installed: Mapping[str, RuleDescription], allow_inline: bool) -> Iterator[tuple[str, str]]:
    """Yield the name and the references of each rule that something names."""
    if one in installed:
        yield one, installed[one].reference
        return
    if ".py:" in one:
        target = RuleSources(".", allow_inline).find(one, "rmfs cite").target
        yield one, _own_references(target)
        return
    runs = Path(one) / RUNS_FOLDER
    if _is_folder(runs):
        for scenario in _stored(runs):
            yield from _of_result(one, scenario, installed, allow_inline)
        return
    if _is_experiment(one):
        for scenario in _of_experiment(one, allow_inline):
            yield from _of_scenario(scenario, installed, allow_inline)
        return
    scenario = _scenario(one, installed)
    if scenario.source is None:
        yield from _of_result(one, scenario, installed, allow_inline)
    elif alone := _rules_alone(one):
        yield from _of_result(one, scenario, installed, allow_inline, alone)
    else:
        yield from _of_scenario(scenario, installed, allow_inline)


def _is_folder(path: Path) -> bool:
    return os.path.isdir(path)  # noqa: PTH112 (False for a name that is too long, too)


def _is_file(path: Path) -> bool:
    return os.path.isfile(path)  # noqa: PTH113 (as above)


def _rules_alone(one: str) -> frozenset[str]:
    """Return the keys of a file that has rules and nothing else, such as `rmfs tune` writes; none of another file."""
    if not one.endswith(".toml"):
        return frozenset()
    tables = read_toml(Path(one).read_bytes().decode("utf-8-sig"))  # a scenario's reader has found nothing wrong
    return frozenset(tables["rules"]) if tables.keys() == {"rules"} else frozenset()


def _is_experiment(one: str) -> bool:
    """Whether a name is that of an experiment file, or of a shipped experiment and of no scenario."""
    if one in shipped_experiments() and one not in shipped_scenarios():
        return True
    try:
        return one.endswith(".toml") and "rule_sets" in read_toml(Path(one).read_bytes().decode("utf-8-sig"))
    except (OSError, ValueError):  # what is wrong with it, a scenario's reader says
        return False


def _of_experiment(one: str, allow_inline: bool) -> Iterator[Scenario]:
    """Yield a scenario with each choice of rules of an experiment."""
    experiment = load_experiment(one)
    jobs = evolve(experiment, seeds=experiment.seeds[:1]).jobs(allow_inline_rules=allow_inline)
    yield from {repr(job.scenario.rules): job.scenario for job in jobs}.values()


def _stored(runs: Path) -> Iterator[Scenario]:
    """Yield a scenario with each choice of rules in a folder of finished runs."""
    found: dict[str, Scenario] = {}
    for file in sorted(file for below in ("*", "*/*") for file in runs.glob(f"{below}/{RESULT_FILE}")):
        if result := read_result(file):
            scenario = scenario_from_dict(result["scenario"], name=str(file))
            found.setdefault(repr(scenario.rules), scenario)
    yield from found.values()


def _of_scenario(
    scenario: Scenario, installed: Mapping[str, RuleDescription], allow_inline: bool
) -> Iterator[tuple[str, str]]:
    """Yield the name and the references of each rule of a scenario."""
    with located(scenario):
        rules = RuleSet.load(scenario.rules, scenario.folder, allow_inline=allow_inline)
    for bound in (*rules.deciding, *rules.observers):
        yield bound.name, _own_references(type(bound.instance))
    for _, choice in rule_choices(scenario.rules):
        yield from _references_inside(choice.parameters, installed)


def _of_result(
    one: str,
    scenario: Scenario,
    installed: Mapping[str, RuleDescription],
    allow_inline: bool,
    keys: Collection[str] = (),
) -> Iterator[tuple[str, str]]:
    """Yield the same of a run's result, which names its rules, and need not have all that they were made with.

    Of the rules with these keys alone, if there are any.
    """
    for path, choice in rule_choices(scenario.rules):
        if keys and path[0] not in keys:
            continue
        place = f"{one}, {dotted(('rules', *path))}"
        if choice.rule in installed:
            yield choice.rule, installed[choice.rule].reference
        elif ".py:" in choice.rule:
            yield (
                choice.rule,
                _own_references(RuleSources(scenario.folder, allow_inline).find(choice.rule, place).target),
            )
        else:
            why = "a rule that the run was given as an object has its references in its own code"
            raise InputError(place, f'found rule "{choice.rule}", expected one that is installed; {why}')
        yield from _references_inside(choice.parameters, installed)


def _own_references(rule: object) -> str:
    return sections(inspect.getdoc(rule) or "").get("References", "")


def _scenario(one: str, installed: Iterable[str]) -> Scenario:
    path = Path(one)
    if _is_folder(path):
        result = read_result(path / RESULT_FILE)
        if result is None:
            raise InputError(one, f"there is no {RESULT_FILE}; expected {EXPECTED}")
        return scenario_from_dict(result["scenario"], name=str(path / RESULT_FILE))
    if path.suffix == ".toml" or _is_file(path) or one in shipped_scenarios():
        return load_scenario(one)
    near = did_you_mean(one, {*installed, *shipped_scenarios(), *shipped_experiments()})
    raise InputError("rmfs cite", f'found "{one}"{near}; expected {EXPECTED}')


def _references_inside(parameters: Any, installed: Mapping[str, RuleDescription]) -> Iterator[tuple[str, str]]:
    for name in _rules_inside(parameters):
        if name in installed:
            yield name, installed[name].reference


def _rules_inside(parameters: Any) -> Iterator[str]:
    """Yield the names of rules that a rule's parameters choose: of cases, as `switch` has them."""
    if isinstance(parameters, Mapping):
        if isinstance(parameters.get("rule"), str):
            yield parameters["rule"]
        parameters = list(parameters.values())
    if isinstance(parameters, list | tuple):
        for value in parameters:
            yield from _rules_inside(value)


def _software() -> Reference:
    title = "rmfs: interchangeable decision rules for robotic mobile fulfillment systems"
    now = version(RMFS)  # in a note, for classic styles of BibTeX know neither its field nor @software
    told = {"author": CORPORATE, "title": title, "note": f"Version {now}", "year": _year(now), "url": _address()}
    return Reference("misc", RMFS, told)


def _instances() -> Reference:
    title = f"The rmfs benchmark set, version {SET_VERSION}: instances for robotic mobile fulfillment systems"
    now = version(RMFS)
    told = {"author": CORPORATE, "title": title, "note": f"With rmfs {now}", "year": _year(now), "url": _address()}
    return Reference("misc", f"{RMFS}-{SET}", told)


def _year(of: str) -> str:
    """Return the year of a release, as CITATION.cff has it; nothing for a version between releases."""
    beside = Path(__file__).with_name(CITATION)  # where the wheel has it; else a checkout, where it is at the top
    file = beside if beside.is_file() else Path(__file__).parents[3] / CITATION
    if not file.is_file():
        return ""
    found = re.search(rf"^version: {re.escape(of)}\ndate-released: (\d{{4}})", file.read_text("utf-8"), re.MULTILINE)
    return found[1] if found else ""


def _address() -> str:
    """Return the address of the project, once it has a public one."""
    addresses = dict(entry.split(", ", 1) for entry in metadata(RMFS).get_all("Project-URL") or [])
    return next((addresses[name] for name in ("Repository", "Source", "Homepage") if name in addresses), "")
