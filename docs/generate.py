"""The parts of the reference that are made from the code: scenario keys, rules, metrics, features.

Each function returns Markdown. `conf.py` writes them into `reference/_generated` before Sphinx reads the pages, which
include them; tests hold them to be complete.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import attrs

from rmfs_commands.cli.description import Parameter, RuleDescription, installed_rules
from rmfs_commands.details.catalogue import CATALOGUE
from rmfs_commands.gym import FEATURES
from rmfs_commands.results.figures import TIMING
from rmfs_commands.testing.trial_worlds import FINITE
from rmfs_commands.testing.trial_worlds import trial_worlds as worlds_of_trials
from rmfs_core import entrypoints
from rmfs_core.results.catalogue import Metric
from rmfs_core.roles import Role
from rmfs_core.rules.hooks import SPECIFICATIONS
from rmfs_core.rules.traits import NEEDS
from rmfs_core.scenario.model import RuleChoice, RulesSection, Scenario

TEMPLATES = "../../plugins/rmfs_commands/kit/templates"
"""Seen from the folder of the reference."""


def scenario_keys() -> str:
    """Return the keys of scenario files: a table for each section."""
    rows: dict[str, list[tuple[str, ...]]] = {}
    for path, default, unit, meaning in keys_of(Scenario, ""):
        section = path.rpartition(".")[0]
        rows.setdefault(section, []).append((f"`{path}`", default, unit, meaning))
    parts = []
    for section, keys in rows.items():
        title = f"`[{section}]`" if section else "At the top"
        parts += [f"## {title}", "", *_table(("key", "default", "unit", "meaning"), keys), ""]
    return "\n".join(parts)


def keys_of(section: type[Any], prefix: str) -> Iterator[tuple[str, str, str, str]]:
    """Yield each key of a section and of those in it: path, default, unit, meaning."""
    attrs.resolve_types(section)
    fields = [f for f in attrs.fields(section) if "doc" in f.metadata]
    for f in sorted(fields, key=_is_section):
        if _is_section(f):
            yield from keys_of(_section(f), f"{prefix}{f.name}.")
        else:
            yield prefix + f.name, _default(f), f.metadata["unit"] or "", f.metadata["doc"]


def _is_section(f: attrs.Attribute[Any]) -> bool:
    return _section(f) is not None


def _section(f: attrs.Attribute[Any]) -> Any:
    """Return the class of the table that a key holds, also one that may be left out; None of a value."""
    kinds: tuple[Any, ...] = (f.type, *get_args(f.type))
    return next((kind for kind in kinds if kind is not RuleChoice and isinstance(kind, type) and attrs.has(kind)), None)


def _default(f: attrs.Attribute[Any]) -> str:
    default: Any = f.default
    default = default.factory() if hasattr(default, "factory") else default
    default = getattr(default, "rule", default)
    if default in (attrs.NOTHING, None, (), {}):
        return ""
    return f"`{json.dumps(default)}`"


def hooks() -> str:
    """Return the hooks of decisions: a table."""
    rows = [
        (f"`{hook}`", f"{role.label}: {role.what}", f"`{_specification(hook).__annotations__['return']}`")
        for role in Role
        for hook in role.hooks
        if role is not Role.OBSERVER
    ]
    return "\n".join(_table(("hook", "decides", "returns"), rows))


def decisions() -> str:
    """Return a section for each decision: its hook, and the rule that `rmfs new-rule` writes for it."""
    parts = []
    for role in Role:
        if role is not Role.OBSERVER:
            hook, example = (
                f"rmfs_core.hookspecs.{_specification(role.hook).__qualname__}",
                f"{TEMPLATES}/{role}/rule.py",
            )
            parts += [f"### {role.hook}", "", "```{eval-rst}", f".. automethod:: {hook}", "```", ""]
            parts += [f"```{{literalinclude}} {example}", ":pyobject: TheRule", "```", ""]
    return "\n".join(parts)


def _specification(hook: str) -> Any:
    return next(vars(group)[hook] for group in SPECIFICATIONS if hook in vars(group))


def rules() -> str:
    """Return the rules that this distribution ships: a section for each decision, and each rule in it."""
    shipped = [rule for rule in installed_rules() if rule.distribution == "rmfs"]
    parts = []
    for role in Role:
        ours = [rule for rule in shipped if role.label in rule.decides]
        if ours:
            parts += [f"## {role.label}: {attrs.fields_dict(RulesSection)[role.key].metadata['doc']}", ""]
        for rule in ours:
            parts += [f"### `{rule.name}`", "", *_rule(rule)]
    return "\n".join(parts)


def _rule(rule: RuleDescription) -> Iterator[str]:
    module, _, name = entrypoints.offers(entrypoints.RULES)[rule.name][0].value.partition(":")
    yield from ("```{eval-rst}", f".. autoclass:: {module}.{name}", "   :no-index:", "   :no-index-entry:", "```", "")
    if rule.parameters:
        # The docstring's section "Parameters" is shown above, where there is one.
        told = "\nParameters\n---" in rule.doc
        head = ("parameter", "default", "unit", "value") + (() if told else ("meaning",))
        rows = [(f"`{p.name}`", _given(p), p.unit, p.type, p.doc)[: len(head)] for p in rule.parameters]
        yield from (*_table(head, rows), "")


def _given(parameter: Parameter) -> str:
    if parameter.required:
        return "required"
    return "none" if parameter.default is None else f"`{json.dumps(parameter.default)}`"


def metrics() -> str:
    """Return the metrics and timing figures of result.json: a table for each group."""
    parts = []
    for group, ours in {**CATALOGUE, "Wall clock (under `timing`)": TIMING}.items():
        rows = [(f"`{m.name}`", m.label.strip(), _unit(m), m.meaning) for m in ours]
        parts += [f"## {group}", "", *_table(("name", "on the screen", "unit", "meaning"), rows), ""]
    return "\n".join(parts)


def _unit(metric: Metric) -> str:
    # Shares are shown in percent, and stored as shares.
    return metric.unit if metric.scale == 1 else "share"


def needs() -> str:
    """Return what a rule may say that it needs."""
    rows = [(f'`"{need}"`', sentence) for need, (_, sentence) in NEEDS.items()]
    return "\n".join(_table(("need", "the rule needs"), rows))


def trial_worlds() -> str:
    """Return the small worlds that `check_rule` tries a rule in."""
    worlds = {world.name: world for world in worlds_of_trials()}
    rows = [
        (name, world.purpose, "both" if f"{name}{FINITE}" in worlds else "as it says")
        for name, world in worlds.items()
        if not name.endswith(FINITE)
    ]
    return "\n".join(_table(("world", "what it is for", "stock"), rows))


def features() -> str:
    """Return what a learner sees of each candidate: a table for each decision."""
    parts = []
    for role, ours in FEATURES.items():
        rows = [(f"`{f.name}`", f.text, "" if f.half is None else f"x / (x + {f.half:g})") for f in ours]
        parts += [f"### {role.label}", "", *_table(("feature", "x", "shown as"), rows), ""]
    return "\n".join(parts)


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    cells = [[str(cell).replace("|", r"\|").replace("\n", " ") for cell in row] for row in rows]
    return [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}", *(f"| {' | '.join(row)} |" for row in cells)]


def write(folder: Path) -> None:
    """Write every part to a file of its own."""
    folder.mkdir(exist_ok=True)
    for part in (scenario_keys, hooks, decisions, rules, metrics, needs, trial_worlds, features):
        file = folder / f"{part.__name__.replace('_', '-')}.md"
        text = part() + "\n"
        if not file.is_file() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")
