"""The rules of one run, registered on a plugin manager of their own."""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Collection, Iterator
from functools import cache, partial, wraps
from importlib.metadata import version
from typing import Any

import pluggy
from attrs import define, field, frozen

from rmfs_core.errors import InputError
from rmfs_core.rules.hooks import (
    ARGUMENTS,
    HOOK_OF_ROLE,
    OBSERVER_HOOKS,
    check_hooks,
    check_rule_class,
    marked_methods,
    new_manager,
)
from rmfs_core.rules.parameters import build
from rmfs_core.rules.sources import INLINE, RuleSource, RuleSources, describe
from rmfs_core.scenario.model import RuleChoice, RulesSection
from rmfs_core.wording import one_line

LIBRARIES = ("attrs", "numba", "numpy", "pluggy", "rmfs", "simpy")
"""Distributions that take part in every run."""


@frozen(eq=False)
class BoundRule:
    """A rule that plays one role in a run.

    Parameters
    ----------
    role
        ``"poa"``, ``"pps"``, ``"poa_pps"``, ``"pr"``, ``"ta"``, ``"pp"``, ``"filter"`` or ``"observer"``.
    name
        As in the scenario.
    instance
        The rule itself, with its parameters.
    distribution, version
        Where it comes from; for a file beside the scenario, the file's name and ``"inline"``.
    hook
        Calls the role's hook of this rule and of no other. (Observers are called together, through
        ``RuleSet.pm.hook``.)
    """

    role: str
    name: str
    instance: Any
    distribution: str
    version: str
    hook: pluggy.HookCaller

    def describe(self) -> str:
        """Name the rule for a message: ``rule "demand" (rmfs 0.1.0)``."""
        return describe(self.name, self.distribution, self.version)


class _Registered:
    """What is registered for a rule: the hook methods that the run uses, bound to the instance.

    pluggy tells plugins apart by hash and equality, and attrs instances with the same parameters are equal. Also, a
    rule that could decide POA and PPS but is selected for one of them must not answer the other.
    """

    def __init__(self, instance: object, hooks: frozenset[str], described: str | None = None) -> None:
        self.instance = instance
        self.described = described
        for hook, method in marked_methods(instance).items():
            if hook in hooks or hook not in ARGUMENTS:
                bound = getattr(instance, method)
                setattr(
                    self,
                    method,
                    bound if described is None or hook not in OBSERVER_HOOKS else _named(bound, described, hook),
                )


class ObserverError(Exception):
    """An observer that the scenario names raised in one of its observer hooks; the cause is what it raised.

    Parameters
    ----------
    name
        The observer, as messages call it.
    hook
        The hook.
    """

    def __init__(self, name: str, hook: str) -> None:
        super().__init__(name, hook)
        self.name = name
        self.hook = hook


def _named(method: Callable[..., Any], name: str, hook: str) -> Callable[..., Any]:
    """Return an observer's method that says whose it is when it raises."""

    @wraps(method)
    def call(*arguments: Any) -> Any:
        try:
            return method(*arguments)
        except InputError:  # a sentence for a person: of a file that cannot be written, say
            raise
        except (Exception, SystemExit, GeneratorExit) as error:  # whatever an observer does, the run ends in order
            raise ObserverError(name, hook) from error

    return call


def _called_by_name(function: Callable[..., Any], names: Collection[str], **arguments: Any) -> Any:
    return function(*(arguments[name] for name in names))


@define(eq=False)
class _Selected:
    """One instance of a rule and the roles it was selected for."""

    source: RuleSource
    instance: Any
    hooks: set[str] = field(factory=set)
    registered: _Registered | None = None


@define(eq=False)
class RuleSet:
    """The rules of one run. Instances are new for each rule set, so no state is carried from run to run.

    Parameters
    ----------
    pm
        The run's plugin manager; ``pm.hook.on_event(event=...)`` tells all observers.
    poa, pps, poa_pps, pr, ta, pp
        The rule that decides, None where the scenario names none.
    filters, observers
        In the order in which the scenario lists them.
    distributions
        Version of every distribution that takes part, by name, python included.
    inline_files
        Files beside the scenario that code was loaded from.
    """

    pm: pluggy.PluginManager
    pr: BoundRule
    ta: BoundRule
    pp: BoundRule
    poa: BoundRule | None = None
    pps: BoundRule | None = None
    poa_pps: BoundRule | None = None
    filters: tuple[BoundRule, ...] = ()
    observers: tuple[BoundRule, ...] = ()
    distributions: dict[str, str] = field(factory=dict)
    inline_files: tuple[str, ...] = ()

    @classmethod
    def load(cls, rules: RulesSection, folder: str, *, allow_inline: bool = True) -> RuleSet:
        """Import, create, check and register the rules that a scenario selects.

        :param rules: the scenario's choices.
        :param folder: where the files of inline rules are.
        :param allow_inline: whether such files may be loaded at all.
        :raises InputError: with the place inside the scenario, for example ``rules.poa``.
        """
        sources = RuleSources(folder, allow_inline)
        created: dict[tuple[str, str], _Selected] = {}
        choices = list(_choices(rules))
        selected = [_select(sources, created, *choice) for choice in choices]
        manager = new_manager()
        for number, one in enumerate(created.values()):
            one.registered = _register(
                manager, one.instance, frozenset(one.hooks), f"{number}: {one.source.name}", one.source.describe()
            )
        bound: dict[str, list[BoundRule]] = {}
        for (role, _, _), one in zip(choices, selected, strict=True):
            bound.setdefault(role, []).append(_bind(manager, role, one))
        rule_set = cls(
            pm=manager,
            **{role: found[0] for role, found in bound.items() if role not in ("filter", "observer")},
            filters=tuple(bound.get("filter", ())),
            observers=tuple(bound.get("observer", ())),
            distributions=_versions(created.values()),
            inline_files=tuple(dict.fromkeys(one.source.file for one in created.values() if one.source.file)),
        )
        rule_set.check()
        return rule_set

    def register_observer(self, observer: object, described: str | None = None) -> None:
        """Register an object whose ``@hookimpl`` methods observe the run. Decision hooks it may have are not called.

        What it raises ends the run with an error that names it ``described``; without that it is raised as it is.
        """
        name = type(observer).__name__
        check_hooks(f"observer {name}", observer, name)
        if not OBSERVER_HOOKS & marked_methods(observer).keys():
            raise InputError(f"observer {name}", "it implements no observer hook")
        _register(self.pm, observer, OBSERVER_HOOKS, f"observer {len(self.pm.get_plugins())}: {name}", described)

    @property
    def instances(self) -> list[object]:
        """Every rule and observer that takes part, in the order of registration."""
        registered: list[tuple[str, Any]] = self.pm.list_name_plugin()
        return [plugin.instance for _, plugin in registered]

    def told(self, hook: str) -> Iterator[tuple[str, Callable[..., Any]]]:
        """Yield every observer's name and method of a hook, so that one that fails keeps nothing from the others.

        Who was registered last comes first, as pluggy calls them.
        """
        for implementation in reversed(getattr(self.pm.hook, hook).get_hookimpls()):
            if implementation.wrapper or implementation.hookwrapper:
                continue
            names, function = implementation.argnames, implementation.function
            call = partial(_called_by_name, function, names)
            yield implementation.plugin.described or f"observer {type(implementation.plugin.instance).__name__}", call

    def check(self) -> None:
        """Raise `InputError` if anything registered implements a hook that does not exist."""
        try:
            self.pm.check_pending()
        except pluggy.PluginValidationError as error:
            raise InputError("rules", one_line(error)) from error


def _choices(rules: RulesSection) -> Iterator[tuple[str, RuleChoice, str]]:
    """Yield role, choice and the choice's place in the scenario."""
    for role in ("poa", "pps", "poa_pps", "pr", "ta", "pp"):
        choice = getattr(rules, role)
        if choice is not None:
            yield role, choice, f"rules.{role}"
    for key in ("filters", "observers"):
        for index, choice in enumerate(getattr(rules, key)):
            yield key.removesuffix("s"), choice, f"rules.{key}[{index}]"


def _select(
    sources: RuleSources, created: dict[tuple[str, str], _Selected], role: str, choice: RuleChoice, place: str
) -> _Selected:
    """Return the rule of a choice; the same choice for two roles is one instance."""
    key = (choice.rule, json.dumps(dict(choice.parameters), sort_keys=True, default=repr))
    source = created[key].source if key in created else sources.find(choice.rule, place)
    rule = check_rule_class(place, source.target, source.describe(), role)
    if key not in created:
        created[key] = _Selected(source, build(rule, choice.parameters, place, source.describe()))
    created[key].hooks |= OBSERVER_HOOKS | {HOOK_OF_ROLE[role]}
    return created[key]


def _register(
    manager: pluggy.PluginManager, instance: object, hooks: frozenset[str], name: str, described: str | None = None
) -> _Registered:
    registered = _Registered(instance, hooks, described)
    try:
        manager.register(registered, name)
    except pluggy.PluginValidationError as error:
        raise InputError(f"class {type(instance).__name__}", one_line(error)) from error
    return registered


def _bind(manager: pluggy.PluginManager, role: str, one: _Selected) -> BoundRule:
    others = [plugin for plugin in manager.get_plugins() if plugin is not one.registered]
    hook = manager.subset_hook_caller(HOOK_OF_ROLE[role], remove_plugins=others)
    source = one.source
    return BoundRule(role, source.name, one.instance, source.distribution, source.version, hook)


@cache
def _installed(library: str) -> str:
    """Version of a library, read once."""
    return version(library)


def _versions(selected: Collection[_Selected]) -> dict[str, str]:
    found = {name: _installed(name) for name in LIBRARIES} | {"python": platform.python_version()}
    found |= {name: _installed(name) for one in selected for name in getattr(one.source.target, "libraries", ())}
    found |= {one.source.distribution: one.source.version for one in selected if one.source.version != INLINE}
    return dict(sorted(found.items()))
