"""Which hooks a rule's class implements, and whether it does so correctly."""

from __future__ import annotations

import inspect
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any

import attrs
import pluggy

from rmfs_core.errors import InputError
from rmfs_core.hookspecs import DecisionHooks, FilterHooks, ObserverHooks, TimeHooks
from rmfs_core.roles import Role
from rmfs_core.wording import did_you_mean, listed

SPECIFICATIONS = (DecisionHooks, FilterHooks, TimeHooks, ObserverHooks)
WAKE = "wake_at"


def new_manager() -> pluggy.PluginManager:
    """Return a plugin manager that knows every hook and has nothing registered."""
    manager = pluggy.PluginManager("rmfs")
    for specification in SPECIFICATIONS:
        manager.add_hookspecs(specification)
    return manager


_reader = new_manager()
OBSERVER_HOOKS = frozenset(name for name in vars(ObserverHooks) if not name.startswith("_"))
ARGUMENTS: Mapping[str, tuple[str, ...]] = {
    name: tuple(inspect.signature(function).parameters)[1:]
    for specification in SPECIFICATIONS
    for name, function in vars(specification).items()
    if not name.startswith("_")
}
"""Every hook's name and the names of its arguments."""


def marked_methods(plugin: object) -> dict[str, str]:
    """Return hook name to method name for every ``@hookimpl`` method of a rule's class or of an object."""
    return {options.get("specname") or method: method for method, options in _marked(plugin)}


def _marked(plugin: object) -> Iterator[tuple[str, Any]]:
    for method in [name for name in dir(plugin) if not name.startswith("__")]:  # of Python's own there are dozens
        with suppress(Exception, SystemExit):  # a property that raises is no hook
            if (options := _reader.parse_hookimpl_opts(plugin, method)) is not None:
                yield method, options


def roles_of(rule: type) -> tuple[Role, ...]:
    """Return the roles that a rule's class can play, from the hooks it implements."""
    hooks = marked_methods(rule).keys()
    return tuple(role for role in Role if (OBSERVER_HOOKS if role is Role.OBSERVER else {*role.hooks}) & hooks)


def check_hooks(place: str, plugin: object, class_name: str) -> None:
    """Raise `InputError` for a misspelt hook, an option of pluggy's, or an argument that a hook does not have."""
    for method, options in _marked(plugin):
        for option in ("wrapper", "hookwrapper", "tryfirst", "trylast", "optionalhook"):
            if options.get(option):  # who is asked or told first, and what comes of an answer, is up to the kernel
                problem = f"`{method}` is marked with {option}; expected @hookimpl alone"
                raise InputError(place, f"class {class_name}: {problem}")
    for hook, method in marked_methods(plugin).items():
        if hook not in ARGUMENTS:
            raise InputError(
                place,
                f"class {class_name} implements a hook `{hook}`, which does not exist{did_you_mean(hook, ARGUMENTS)}; "
                f"the hooks are {listed(ARGUMENTS)}",
            )
        valid = ARGUMENTS[hook]
        for argument in _required_arguments(plugin, method):
            if argument not in valid:
                raise InputError(
                    place,
                    f"class {class_name}: hook `{hook}` has no argument `{argument}`{did_you_mean(argument, valid)}; "
                    f"{f'valid arguments are {listed(valid)}' if valid else 'it has none'}",
                )


def _required_arguments(plugin: object, method: str) -> Iterable[str]:
    """Yield the arguments, without ``self``, that pluggy will hand to a hook method."""
    names = [
        parameter.name
        for parameter in inspect.signature(getattr(plugin, method)).parameters.values()
        if parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD)
        and parameter.default is parameter.empty
    ]
    unbound = isinstance(plugin, type) and inspect.isfunction(inspect.getattr_static(plugin, method))
    return names[1:] if unbound else names


def require_attrs_class(place: str, rule: object, rule_name: str) -> type:
    """Return what a rule's name led to if it is an attrs class."""
    if isinstance(rule, type) and attrs.has(rule):
        return rule
    what = f"class {rule.__name__}" if isinstance(rule, type) else repr(rule)
    raise InputError(
        place, f"{rule_name} is no attrs class: expected a class decorated with @attrs.define, found {what}"
    )


def check_rule_class(place: str, rule: object, rule_name: str, role: Role) -> type:
    """Return the class of a rule, checked: attrs, hooks spelt right, and able to play the role."""
    rule = require_attrs_class(place, rule, rule_name)
    check_hooks(place, rule, rule.__name__)
    roles = roles_of(rule)
    if role in roles:
        return rule
    for hook in role.hooks:
        if not roles and callable(getattr(rule, hook, None)):
            raise InputError(place, f"{rule_name} has a method `{hook}` that lacks the @hookimpl decorator")
    raise InputError(
        place,
        f"{rule_name} does not decide {role.label} (hook `{role.hook}`); "
        f"class {rule.__name__} decides {decided(roles)}",
    )


def decided(roles: Collection[Role]) -> str:
    """Return what a rule decides that can play these roles, for a message."""
    return listed(role.label for role in roles) if roles else "nothing (it implements no hook)"
