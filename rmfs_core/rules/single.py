"""One rule on its own, bound to one role: to be asked outside a run."""

from __future__ import annotations

from rmfs_core.errors import InputError
from rmfs_core.rules.hooks import (
    HOOK_OF_ROLE,
    LABEL_OF_ROLE,
    OBSERVER_HOOKS,
    new_manager,
    require_attrs_class,
    roles_of,
)
from rmfs_core.rules.ruleset import BoundRule, _bind, _register, _select, _Selected
from rmfs_core.rules.sources import RuleSources
from rmfs_core.scenario.model import RuleChoice
from rmfs_core.wording import listed


def load_rule(
    choice: RuleChoice,
    roles: tuple[str, ...],
    *,
    folder: str = ".",
    allow_inline: bool = True,
    place: str = "rule",
    preferred: str | None = None,
) -> BoundRule:
    """Import, create, check and register one rule.

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
    rule = require_attrs_class(place, source.target, source.describe())
    playable = [role for role in roles_of(rule) if role in roles]
    if preferred in playable:
        playable = [preferred]
    if not playable:
        wanted = listed((LABEL_OF_ROLE[role] for role in roles), "or")
        found = [LABEL_OF_ROLE[role] for role in roles_of(rule)]
        does = listed(found) if found else "nothing (it implements no hook)"
        raise InputError(place, f"{source.describe()} decides {does}; expected a rule for {wanted}")
    if len(playable) > 1:
        labels = listed(LABEL_OF_ROLE[role] for role in playable)
        raise InputError(place, f"{source.describe()} decides {labels}; say which of them is asked")
    created: dict[tuple[str, str], _Selected] = {}
    one = _select(sources, created, playable[0], choice, place)
    manager = new_manager()
    one.registered = _register(manager, one.instance, OBSERVER_HOOKS | {HOOK_OF_ROLE[playable[0]]}, source.name)
    return _bind(manager, playable[0], one)
