"""The rules of one run, registered on a plugin manager of their own."""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from functools import partial, wraps
from typing import Any

import pluggy
from attrs import define, field, frozen

from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.rules.hooks import (
    OBSERVER_HOOKS,
    WAKE,
    check_hooks,
    check_rule_class,
    decided,
    marked_methods,
    new_manager,
    require_attrs_class,
    roles_of,
)
from rmfs_core.rules.parameters import build
from rmfs_core.rules.sources import INLINE, RuleSource, RuleSources
from rmfs_core.rules.traits import RuleTraits, installed_version
from rmfs_core.scenario.model import RuleChoice, RulesSection
from rmfs_core.scenario.rulenames import rule_choices
from rmfs_core.scenario.source import dotted
from rmfs_core.wording import listed, one_line

LIBRARIES = ("attrs", "numba", "numpy", "pluggy", "rmfs", "simpy")
"""Distributions that take part in every run."""


@frozen(eq=False)
class BoundRule:
    """A rule that plays one role in a run.

    Parameters
    ----------
    role
        What it decides.
    source
        Its name, and where it comes from.
    instance
        The rule itself, with its parameters.
    traits
        What its class declares besides.
    hook
        Calls the role's hook of this rule and of no other. (Observers are called together, through
        ``RuleSet.pm.hook``.)
    wake
        Asks it when to wake up; None for a rule that does not implement `wake_at`.
    """

    role: Role
    source: RuleSource
    instance: Any
    traits: RuleTraits
    hook: pluggy.HookCaller
    wake: pluggy.HookCaller | None = None

    @property
    def name(self) -> str:
        """As in the scenario."""
        return self.source.name

    def describe(self) -> str:
        """Name the rule for a message, as its source does."""
        return self.source.describe()


class _Registered:
    """What is registered for a rule: the hook methods that the run uses, bound to the instance.

    pluggy tells plugins apart by hash and equality, and attrs instances with the same parameters are equal. Also, a
    rule that could decide POA and PPS but is selected for one of them must not answer the other.
    """

    def __init__(self, instance: object, hooks: Collection[str], described: str | None = None) -> None:
        self.instance = instance
        self.described = described
        for hook, method in marked_methods(instance).items():
            if hook in hooks:
                bound = getattr(instance, method)
                named = described is not None and hook in OBSERVER_HOOKS
                setattr(self, method, _named(bound, str(described), hook) if named else bound)


class ObserverError(Exception):
    """An observer raised; the arguments are what messages call it, and the hook, the cause is what it raised."""


def _named(method: Callable[..., Any], name: str, hook: str) -> Callable[..., Any]:
    """Return an observer's method that says whose it is when it raises."""

    @wraps(method)
    def call(*arguments: Any) -> Any:
        try:
            return method(*arguments)
        except (InputError, KeyboardInterrupt):  # a sentence for a person: of a file that cannot be written, say
            raise
        except BaseException as error:  # whatever an observer does, the run ends in order
            raise ObserverError(name, hook) from error

    return call


def _called_by_name(function: Callable[..., Any], names: Collection[str], **arguments: Any) -> Any:
    return function(*(arguments[name] for name in names))


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

        Parameters
        ----------
        rules
            The scenario's choices.
        folder
            Where the files of inline rules are.
        allow_inline
            Whether such files may be loaded at all.

        Raises
        ------
        InputError
            With the place inside the scenario, for example ``rules.poa``.
        """
        keyed = {role.key: role for role in Role}
        chosen = [(keyed[str(path[0])], choice, dotted(("rules", *path))) for path, choice in rule_choices(rules)]
        manager, bound = _bind(RuleSources(folder, allow_inline), chosen)
        playing = {role: [rule for rule in bound if rule.role is role] for role in Role}
        filters, observers = playing.pop(Role.FILTER), playing.pop(Role.OBSERVER)
        return cls(
            pm=manager,
            **{role: found[0] for role, found in playing.items() if found},
            filters=tuple(filters),
            observers=tuple(observers),
            distributions=_versions(bound),
            inline_files=tuple(dict.fromkeys(rule.source.file for rule in bound if rule.source.file is not None)),
        )

    @property
    def deciding(self) -> tuple[BoundRule, ...]:
        """Every rule but the observers, those for orders first."""
        single = (self.poa, self.pps, self.poa_pps, self.pr, self.ta, self.pp)
        return (*(rule for rule in single if rule is not None), *self.filters)

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
            names, function = implementation.argnames, implementation.function
            call = partial(_called_by_name, function, names)
            yield implementation.plugin.described or f"observer {type(implementation.plugin.instance).__name__}", call


def load_rule(
    choice: RuleChoice,
    roles: Collection[Role],
    *,
    folder: str = ".",
    allow_inline: bool = True,
    place: str = "rule",
    preferred: Role | None = None,
) -> BoundRule:
    """Import, create, check and register one rule on its own, to be asked outside a run.

    Parameters
    ----------
    choice
        The rule's name and its parameters.
    roles
        The roles that it may play; the one of them that its class can play is the rule's.
    folder
        Where the file of an inline rule is.
    allow_inline
        Whether such a file may be loaded at all.
    place
        What a message calls the choice.
    preferred
        The role to take where the class can play several.

    Raises
    ------
    InputError
        When there is no such rule, a parameter is wrong, or it can play none of the roles, or several and none is
        preferred.
    """
    sources = RuleSources(folder, allow_inline)
    source = sources.find(choice.rule, place)
    able = roles_of(require_attrs_class(place, source.target, source.describe()))
    playable = [preferred] if preferred in roles and preferred in able else [role for role in able if role in roles]
    if not playable:
        wanted = listed((role.label for role in roles), "or")
        raise InputError(place, f"{source.describe()} decides {decided(able)}; expected a rule for {wanted}")
    if len(playable) > 1:
        raise InputError(place, f"{source.describe()} decides {decided(playable)}; say which of them is asked")
    return _bind(sources, [(playable[0], choice, place)])[1][0]


@define(eq=False)
class _Created:
    """An instance of a rule's class, and the hooks that it was chosen to answer."""

    source: RuleSource
    instance: Any
    traits: RuleTraits
    hooks: set[str] = field(factory=lambda: {*OBSERVER_HOOKS, WAKE})
    registered: _Registered | None = None


def _bind(
    sources: RuleSources, chosen: Sequence[tuple[Role, RuleChoice, str]]
) -> tuple[pluggy.PluginManager, list[BoundRule]]:
    """Import, create, check and register rules, each with its role and place; one choice for two roles is one rule."""
    created: dict[tuple[str, str], _Created] = {}
    ones = []
    for role, choice, place in chosen:
        key = (choice.rule, json.dumps(dict(choice.parameters), sort_keys=True, default=repr))
        source = created[key].source if key in created else sources.find(choice.rule, place)
        name = source.describe()
        rule = check_rule_class(place, source.target, name, role)
        if key not in created:
            instance = build(rule, choice.parameters, place, name)
            created[key] = _Created(source, instance, RuleTraits.of(instance, place, name))
        if role not in (able := created[key].traits.decides):
            raise InputError(place, f"{name} decides {decided(able)}, with its parameters; expected {role.label}")
        created[key].hooks.add(role.hook)
        ones.append(created[key])
    manager = new_manager()
    for number, one in enumerate(created.values()):
        name = one.source.describe()
        one.registered = _register(manager, one.instance, one.hooks, f"{number}: {one.source.name}", name)
    bound = []
    for (role, _, _), one in zip(chosen, ones, strict=True):
        others = [plugin for plugin in manager.get_plugins() if plugin is not one.registered]
        hook, wake = (manager.subset_hook_caller(name, remove_plugins=others) for name in (role.hook, WAKE))
        wakes = wake if wake.get_hookimpls() else None
        bound.append(BoundRule(role, one.source, one.instance, one.traits, hook, wakes))
    return manager, bound


def _register(
    manager: pluggy.PluginManager, instance: object, hooks: Collection[str], name: str, described: str | None = None
) -> _Registered:
    registered = _Registered(instance, hooks, described)
    try:
        manager.register(registered, name)
    except pluggy.PluginValidationError as error:
        raise InputError(f"class {type(instance).__name__}", one_line(error)) from error
    return registered


def _versions(rules: Iterable[BoundRule]) -> dict[str, str]:
    libraries = {*LIBRARIES, *(name for rule in rules for name in rule.traits.libraries)}
    found = {name: installed_version(name) for name in libraries} | {"python": platform.python_version()}
    found |= {rule.source.distribution: rule.source.version for rule in rules if rule.source.version != INLINE}
    return dict(sorted(found.items()))
