"""The rules of one run, registered on a plugin manager of their own."""

from __future__ import annotations

import json
import platform
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

import pluggy
from attrs import define, evolve, field, frozen

from rmfs_core.errors import InputError
from rmfs_core.events import Event
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
)
from rmfs_core.rules.parameters import build, parameters_of, values_of
from rmfs_core.rules.parts import NamedFile, Parts, add_paths, made_in, with_given
from rmfs_core.rules.sources import INLINE, OBJECT, RuleSource, RuleSources, source_of
from rmfs_core.rules.traits import RuleTraits, installed_version
from rmfs_core.scenario.model import RuleChoice, RulesSection
from rmfs_core.scenario.rulenames import rule_choices
from rmfs_core.scenario.source import KeyPath, dotted
from rmfs_core.scenario.structuring import fields_of
from rmfs_core.wording import nearest, one_line, shown_short
from rmfs_core.world.travel import Travel

_SINGLE = tuple(role.key for role in Role if not role.many)
LIBRARIES = ("attrs", "numba", "numpy", "pluggy", "rmfs", "simpy")
"""Distributions that take part in every run."""


@frozen(eq=False)
class BoundRule:
    """A rule that plays one role in a run.

    Parameters
    ----------
    role
        The role: the kind of decision.
    source
        Its name, and where it comes from.
    instance
        The rule itself, with its parameters.
    traits
        Declarations of its class.
    hook
        Calls the role's hook of this rule and of no other. (Observers are called together, through
        ``RuleSet.pm.hook``.)
    wake
        Asks it when to wake up; None for a rule that does not implement `wake_at`.
    parts
        Its parts: files that its parameters name, and classes, with those of rules that it asks in turn.
    """

    role: Role
    source: RuleSource
    instance: Any
    traits: RuleTraits
    hook: pluggy.HookCaller
    wake: pluggy.HookCaller | None = None
    parts: Parts = field(factory=Parts)

    call: Callable[..., Any] = field()
    """Calls the rule's hook, past pluggy, with those arguments that it takes."""

    @call.default
    def _(self) -> Callable[..., Any]:
        ones = self.hook.get_hookimpls()  # none of an observer that hears no events
        if not ones:
            return self.hook
        function, names = ones[0].function, ones[0].argnames
        return lambda **arguments: function(*map(arguments.__getitem__, names))

    @property
    def name(self) -> str:
        """As in the scenario."""
        return self.source.name

    def describe(self) -> str:
        """Name the rule for a message, as its source does."""
        return self.source.describe()

    def prepare(self, travel: Travel) -> None:
        """Let the rule load what it has compiled, if it wants to."""
        if self.traits.prepare is not None:
            way = self.traits.way if self.role is Role.PP else None
            self.traits.prepare(travel if way is None else way.prepare_with(travel))


class _Registered:
    """Plugin registered for a rule: the hook methods that the run uses, bound to the instance.

    pluggy tells plugins apart by hash and equality, and attrs instances with the same parameters are equal. Also, a
    rule that could decide POA and PPS but is selected for one of them must not answer the other.
    """

    def __init__(self, instance: object, hooks: Collection[str], described: str | None = None) -> None:
        self.instance = instance
        self.described = described
        for hook, method in marked_methods(instance).items():
            if hook in hooks:
                setattr(self, method, getattr(instance, method))


@define(eq=False, slots=False)
class RuleSet:
    """The rules of one run. Instances are new for each rule set, so no state is carried from run to run.

    Parameters
    ----------
    pm
        The run's plugin manager; ``pm.hook.on_event(event=...)`` tells all observers.
    pr, ta, pp, others
        The rules that decide, the others by their keys. Each key is an attribute: ``rules.poa`` is None without such
        a rule.
    filters, observers
        In the order in which the scenario lists them.
    distributions
        Version of every distribution that takes part, by name, python included.
    inline_files
        Files next to the scenario that code was loaded from.
    files
        Files that parameters of rules name.
    sources
        Where the rules come from. Close them when the rules are no longer needed.
    """

    pm: pluggy.PluginManager
    pr: BoundRule
    ta: BoundRule
    pp: BoundRule
    others: Mapping[str, BoundRule | None]
    filters: tuple[BoundRule, ...] = ()
    observers: tuple[BoundRule, ...] = ()
    distributions: dict[str, str] = field(factory=dict)
    inline_files: tuple[str, ...] = ()
    files: tuple[NamedFile, ...] = ()
    sources: RuleSources = field(factory=lambda: RuleSources("."))

    @classmethod
    def load(
        cls,
        rules: RulesSection,
        folder: str,
        *,
        allow_inline: bool = True,
        objects: Mapping[str, Any] | None = None,
    ) -> RuleSet:
        """Import, create, check and register the rules that a scenario selects.

        Parameters
        ----------
        rules
            The scenario's choices.
        folder
            Where the files of inline rules are.
        allow_inline
            Whether such files may be loaded at all.
        objects
            Rules that are there already, which ``rules`` names: `with_objects`.

        Raises
        ------
        InputError
            With the place inside the scenario, for example ``rules.poa``.
        """
        there = {dotted(("rules", *path)): rule for path, rule, _ in _given(objects or {})}
        keyed = {role.key: role for role in Role}
        chosen = [(keyed[str(path[0])], choice, dotted(("rules", *path))) for path, choice in rule_choices(rules)]
        sources = RuleSources(folder, allow_inline)
        try:
            manager, bound = bind(sources, chosen, there)
        except BaseException:
            sources.close()
            raise
        single = {rule.role.key: rule for rule in bound if not rule.role.many}
        return cls(
            pm=manager,
            **{role: single.pop(role) for role in (Role.PR, Role.TA, Role.PP)},
            others=single,
            filters=tuple(rule for rule in bound if rule.role is Role.FILTER),
            observers=tuple(rule for rule in bound if rule.role is Role.OBSERVER),
            distributions=_versions(bound),
            files=tuple(one for rule in bound for one in rule.parts.files),
            inline_files=tuple(dict.fromkeys(rule.source.file for rule in bound if rule.source.file is not None)),
            sources=sources,
        )

    def __getattr__(self, key: str) -> BoundRule | None:
        if key in _SINGLE:
            return vars(self).setdefault(key, self.others.get(key))  # which is found sooner the next time
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {key!r}")

    @property
    def deciding(self) -> tuple[BoundRule, ...]:
        """Every rule but the observers, in the order of their roles."""
        return (*filter(None, (getattr(self, key) for key in _SINGLE)), *self.filters)

    @property
    def deciding_bundles(self) -> tuple[BoundRule, ...]:
        """The rules for ROA and RPS, in the order in which they are asked."""
        return tuple(rule for rule in (self.roa_rps, self.roa, self.rps) if rule is not None)

    def with_file_names(self, rules: RulesSection) -> RulesSection:
        """Return the choices that it was loaded from with files named as the scenario calls them, wherever given."""
        names = {id(one.text): one.name for one in self.files}
        keys = fields_of(RulesSection)
        changed = {key: with_given(getattr(rules, key), lambda text: names.get(id(text), str(text))) for key in keys}
        return evolve(rules, **changed)

    def register_observer(self, observer: object, described: str | None = None) -> None:
        """Register an object whose ``@hookimpl`` methods observe the run. Decision hooks it may have are not called.

        Its exception ends the run with an error that names it ``described``; without that it is raised as it is.
        """
        name = type(observer).__name__
        check_hooks(f"observer {name}", observer, name)
        if not OBSERVER_HOOKS & marked_methods(observer).keys():
            raise InputError(f"observer {name}", "it implements no observer hook")
        RuleTraits.of(observer, f"observer {name}", "it")
        _register(self.pm, observer, OBSERVER_HOOKS, f"observer {len(self.pm.get_plugins())}: {name}", described)

    @property
    def instances(self) -> list[object]:
        """Every rule and observer that takes part, in the order of registration."""
        registered: list[tuple[str, Any]] = self.pm.list_name_plugin()
        return [plugin.instance for _, plugin in registered]

    def told_of(self, kind: type[Event]) -> list[tuple[_Registered, Callable[[Event], object]]]:
        """Return what is called at a kind of event, and whose it is: who was registered last first."""
        told: list[tuple[_Registered, Callable[[Event], object]]] = []
        for one in self.told("on_event"):
            hears = getattr(one.plugin.instance, "hears", None)
            if isinstance(hears, Mapping):
                told += [(one.plugin, method) for method in hears.get(kind, ())]
            elif not isinstance(hears, tuple) or kind in hears:
                told.append((one.plugin, one.function if one.argnames else lambda _, one=one: one.function()))  # type: ignore[misc]
        return told

    def told(self, hook: str) -> list[Any]:
        """Return pluggy's implementations of an observer hook, those of who was registered last first."""
        return getattr(self.pm.hook, hook).get_hookimpls()[::-1]  # type: ignore[no-any-return]


def with_objects(rules: RulesSection, objects: Mapping[str, Any]) -> RulesSection:
    """Return a scenario's choices with objects instead of some: named by their classes, with their parameters.

    A joint rule replaces those for POA and PPS, and one of these replaces a joint rule.

    Parameters
    ----------
    objects
        By the keys of a scenario's section ``rules``: an object of a rule's class, a list of them for ``filters``.

    Raises
    ------
    InputError
        For an unknown key, something that is no such object, or choices that do not go together.
    """
    if not objects:
        return rules
    changed: dict[str, Any] = {}
    choices: dict[str, list[RuleChoice]] = {}
    for path, rule, role in _given(objects):
        changed |= {other.key: None for other in role.excludes}
        source = source_of(rule)
        require_attrs_class(_argument(path), source.target, source.describe())
        choices.setdefault(role.key, []).append(RuleChoice(source.name, values_of(rule)))
    changed |= {key: tuple(choices.get(key, ())) if key == Role.FILTER.key else choices[key][0] for key in objects}
    try:
        return evolve(rules, **changed)
    except ValueError as error:
        raise InputError("argument rules", str(error)) from error


def _given(objects: Mapping[str, Any]) -> Iterator[tuple[KeyPath, Any, Role]]:
    """Yield the place of each object as a scenario has it, the object, and its role."""
    roles = {role.key: role for role in Role if role is not Role.OBSERVER}  # observers are given as such
    if not isinstance(objects, Mapping):
        expected = 'expected rules by what they decide, such as {"poa": MyRule()}'
        raise InputError("argument rules", f"{expected}, found {shown_short(objects)}")
    for key, given in objects.items():
        if key not in roles:
            raise InputError("argument rules", f"unknown key {key!r}{nearest(str(key), roles)}")
        many = roles[key].many
        if many and not isinstance(given, list | tuple):
            raise InputError(_argument((key,)), f"expected a list of rules, found {shown_short(given)}")
        for path, rule in (((key, i), one) for i, one in enumerate(given)) if many else [((key,), given)]:
            if rule is None or isinstance(rule, str | type):
                expected = "expected an object of a rule's class, such as MyRule()"
                raise InputError(_argument(path), f"{expected}, found {shown_short(rule)}")
            yield path, rule, roles[key]


def _argument(path: KeyPath) -> str:
    """Return what messages call the place of an object: not the key of that name, which has a line in a file."""
    return f"argument {dotted(('rules', *path))}"


@define(eq=False)
class _Created:
    """An instance of a rule's class, and the hooks that it was chosen to answer."""

    source: RuleSource
    instance: Any
    traits: RuleTraits
    parts: Parts
    hooks: set[str] = field(factory=lambda: {*OBSERVER_HOOKS, WAKE})
    registered: _Registered | None = None


def bind(
    sources: RuleSources, chosen: Sequence[tuple[Role, RuleChoice, str]], there: Mapping[str, Any] | None = None
) -> tuple[pluggy.PluginManager, list[BoundRule]]:
    """Import, create, check and register rules; one choice for two roles is one rule.

    Parameters
    ----------
    sources
        Where to find them.
    chosen
        Of each its role, its name with parameters, and what a message calls the choice.
    there
        Rules that are neither imported nor created, by what messages call their choices.
    """
    created: dict[tuple[str, str], _Created] = {}
    ones = []
    for role, choice, chosen_at in chosen:
        given = (there or {}).get(chosen_at)
        place = chosen_at if given is None else f"argument {chosen_at}"
        key = (choice.rule, json.dumps(with_given(choice.parameters, repr), sort_keys=True, default=repr))
        if given is not None:
            key, source = (str(id(given)), ""), source_of(given)
        else:
            source = created[key].source if key in created else sources.find(choice.rule, place)
        name = source.describe()
        rule = check_rule_class(place, source.target, name, role)
        if key not in created:
            with made_in(sources.folder, sources.allow_inline) as parts:
                instance = build(rule, choice.parameters, place, name) if given is None else given
                for field_ in parameters_of(rule).values() if given is not None else ():
                    add_paths(getattr(given, field_.name))
            created[key] = _Created(source, instance, RuleTraits.of(instance, place, name, source.distribution), parts)
        if role not in (able := created[key].traits.decides):
            raise InputError(place, f"{name} decides {decided(able)}, with its parameters; expected {role.label}")
        called = created[key].traits.hook(role)
        if role is Role.PP and called not in marked_methods(rule):
            reserves = created[key].traits.reserves
            raise InputError(place, f"{name} has reserves = {reserves!r} and no hook `{called}`; expected both")
        created[key].hooks.add(called)
        ones.append(created[key])
    manager = new_manager()
    for number, one in enumerate(created.values()):
        name = one.source.describe()
        one.registered = _register(manager, one.instance, one.hooks, f"{number}: {one.source.name}", name)
    bound = []
    for (role, _, _), one in zip(chosen, ones, strict=True):
        others = [plugin for plugin in manager.get_plugins() if plugin is not one.registered]
        hook, wake = (manager.subset_hook_caller(name, remove_plugins=others) for name in (one.traits.hook(role), WAKE))
        wakes = wake if wake.get_hookimpls() else None
        bound.append(BoundRule(role, one.source, one.instance, one.traits, hook, wakes, one.parts))
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
    versions = {rule.source.distribution: rule.source.version for rule in rules if rule.source.version != INLINE}
    found |= {name: version for name, version in versions.items() if version != OBJECT}
    found |= {rule.name: f"object of {rule.source.distribution}" for rule in rules if rule.source.version == OBJECT}
    return dict(sorted(found.items()))
