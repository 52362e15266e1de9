"""Which hooks a rule's class implements, and whether it does so correctly."""

from __future__ import annotations

import inspect
from collections.abc import Collection, Iterable, Mapping
from types import FunctionType, MethodType
from typing import Any

import attrs
import pluggy

from rmfs_core.errors import InputError
from rmfs_core.hookspecs import DecisionHooks, FilterHooks, ObserverHooks, TimeHooks
from rmfs_core.roles import Role
from rmfs_core.wording import did_you_mean, listed

SPECIFICATIONS = (DecisionHooks, FilterHooks, TimeHooks, ObserverHooks)
WAKE = "wake_at"


class _Manager(pluggy.PluginManager):
    """Evaluates nothing of a plugin, whatever the version of pluggy, and no method of Python's own is a hook."""

    def parse_hookimpl_opts(self, plugin: Any, name: str) -> Any:
        return None if name.startswith("__") else _marked(plugin).get(name)


def new_manager() -> pluggy.PluginManager:
    """Return a plugin manager that knows every hook and has nothing registered."""
    manager = _Manager("rmfs")
    for specification in SPECIFICATIONS:
        manager.add_hookspecs(specification)
    return manager


MARK, MARKED = "rmfs_impl", (FunctionType, MethodType, staticmethod, classmethod)
"""Attribute in which ``@hookimpl`` leaves its options, and what can have it."""
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
    return {options.get("specname") or method: method for method, options in _marked(plugin).items()}


def _marked(plugin: object) -> dict[str, Any]:
    """Return the options of marks by method; nothing of a class or object is evaluated."""
    kind = plugin if isinstance(plugin, type) else type(plugin)
    found: dict[str, Any] = {}
    for one in (*reversed(kind.__mro__), plugin):
        found |= getattr(one, "__dict__", {})
    marked = {name: one for name, one in found.items() if isinstance(one, MARKED) and hasattr(one, MARK)}
    return {name: getattr(one, MARK) for name, one in marked.items()}


def roles_of(rule: type) -> tuple[Role, ...]:
    """Return the roles that a rule's class can play, from the hooks it implements."""
    hooks = marked_methods(rule).keys()
    return tuple(role for role in Role if (OBSERVER_HOOKS if role is Role.OBSERVER else {*role.hooks}) & hooks)


def check_hooks(place: str, plugin: object, class_name: str) -> None:
    """Raise `InputError` for a misspelt hook, an option of pluggy's, or an argument that a hook does not have."""
    for method, options in _marked(plugin).items():
        for option in ("wrapper", "hookwrapper", "tryfirst", "trylast", "optionalhook"):
            if options.get(option):  # who is asked or told first, and what comes of an answer, is up to the kernel
                problem = f"`{method}` is marked with {option}; expected @hookimpl alone"
                raise InputError(place, f"class {class_name}: {problem}")
        kinds = inspect.isgeneratorfunction, inspect.iscoroutinefunction, inspect.isasyncgenfunction
        if any(kind(getattr(plugin, method)) for kind in kinds):
            problem = f"`{method}` yields or is async; expected a method that returns its answer"
            raise InputError(place, f"class {class_name}: {problem}")
        if (hook := options.get("specname") or method) not in ARGUMENTS:
            missing = f"a hook `{hook}`, which does not exist{did_you_mean(hook, ARGUMENTS)}"
            raise InputError(place, f"class {class_name} implements {missing}; the hooks are {listed(ARGUMENTS)}")
        valid = ARGUMENTS[hook]
        for argument in _required_arguments(plugin, method):
            if argument not in valid:
                problem = f"hook `{hook}` has no argument `{argument}`{did_you_mean(argument, valid)}"
                expected = f"valid arguments are {listed(valid)}" if valid else "it has none"
                raise InputError(place, f"class {class_name}: {problem}; {expected}")


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
    found = f"class {rule.__name__}" if isinstance(rule, type) else repr(rule)
    expected = "expected a class decorated with @attrs.define"
    raise InputError(place, f"{rule_name} is no attrs class: {expected}, found {found}")


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
    problem = f"{rule_name} does not decide {role.label} (hook `{role.hook}`)"
    raise InputError(place, f"{problem}; class {rule.__name__} decides {decided(roles)}")


def decided(roles: Collection[Role]) -> str:
    """Return what a rule decides that can play these roles, for a message."""
    return listed(role.label for role in roles) if roles else "nothing (it implements no hook)"
