"""Which hooks a rule's class implements, and whether it does so correctly."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping

import attrs
import pluggy

from rmfs_core.errors import InputError
from rmfs_core.hookspecs import DecisionHooks, FilterHooks, ObserverHooks
from rmfs_core.wording import did_you_mean, listed

HOOK_OF_ROLE = {
    "poa": "assign_orders",
    "pps": "select_pods",
    "poa_pps": "assign_orders_and_pods",
    "pr": "choose_storage_location",
    "ta": "assign_tasks",
    "pp": "plan_path",
    "filter": "filter_backlog",
    "observer": "on_event",
}
"""Role of a rule in a scenario to the hook that plays it. (An observer may implement the other observer hooks too.)"""

LABEL_OF_ROLE = {
    "poa": "POA",
    "pps": "PPS",
    "poa_pps": "POA+PPS",
    "pr": "PR",
    "ta": "TA",
    "pp": "PP",
    "filter": "filter",
    "observer": "observer",
}
"""Role of a rule to what people call it."""

ROLE_OF_LABEL = {label: role for role, label in LABEL_OF_ROLE.items()}

SPECIFICATIONS = (DecisionHooks, FilterHooks, ObserverHooks)


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
    found = {}
    for method in dir(plugin):
        options = _reader.parse_hookimpl_opts(plugin, method)
        if options is not None:
            found[options.get("specname") or method] = method
    return found


def roles_of(rule: type) -> tuple[str, ...]:
    """Return the roles that a rule's class can play, from the hooks it implements."""
    hooks = marked_methods(rule)
    return tuple(
        role
        for role, hook in HOOK_OF_ROLE.items()
        if hook in hooks or (role == "observer" and OBSERVER_HOOKS & hooks.keys())
    )


def check_hooks(place: str, plugin: object, class_name: str) -> None:
    """Raise `InputError` for a misspelt hook, or an argument that a hook does not have."""
    for hook, method in marked_methods(plugin).items():
        if hook not in ARGUMENTS:
            raise InputError(
                place,
                f"class {class_name} implements a hook `{hook}`, which does not exist{did_you_mean(hook, ARGUMENTS)}; "
                f"the hooks are {listed(ARGUMENTS)}",
            )
        for argument in _required_arguments(plugin, method):
            if argument not in ARGUMENTS[hook]:
                raise InputError(
                    place,
                    f"class {class_name}: hook `{hook}` has no argument `{argument}`"
                    f"{did_you_mean(argument, ARGUMENTS[hook])}; valid arguments are {listed(ARGUMENTS[hook])}",
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


def check_rule_class(place: str, rule: object, rule_name: str, role: str) -> type:
    """Return the class of a rule, checked: attrs, hooks spelt right, and able to play the role."""
    rule = require_attrs_class(place, rule, rule_name)
    check_hooks(place, rule, rule.__name__)
    roles = roles_of(rule)
    if role in roles:
        return rule
    hook, label = HOOK_OF_ROLE[role], LABEL_OF_ROLE[role]
    if not roles and callable(getattr(rule, hook, None)):
        raise InputError(place, f"{rule_name} has a method `{hook}` that lacks the @hookimpl decorator")
    does = listed(LABEL_OF_ROLE[other] for other in roles) if roles else "nothing (it implements no hook)"
    raise InputError(
        place, f"{rule_name} does not decide {label} (hook `{hook}`); class {rule.__name__} decides {does}"
    )
