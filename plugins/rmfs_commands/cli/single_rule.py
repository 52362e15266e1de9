"""A rule that is asked outside a run."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule, bind
from rmfs_core.rules.hooks import decided, require_attrs_class, roles_of
from rmfs_core.rules.sources import RuleSources
from rmfs_core.scenario import RuleChoice
from rmfs_core.wording import listed

if TYPE_CHECKING:
    from rmfs_traffic.reserved import ReservedDriving


def load_rule(
    choice: RuleChoice,
    roles: Collection[Role],
    *,
    folder: str = ".",
    allow_inline: bool = True,
    place: str = "rule",
    preferred: Role | None = None,
    sources: RuleSources | None = None,
) -> BoundRule:
    """Import, create and check one rule on its own.

    Parameters
    ----------
    choice
        The rule's name and its parameters.
    roles
        The roles that it may play; the one of them that its class can play is the rule's.
    folder
        Where the file of an inline rule is, and files that parameters name.
    allow_inline
        Whether such a file may be loaded at all.
    place
        Name of the choice in messages.
    preferred
        The role to take where the class can play several.
    sources
        Where to find it, instead of ``folder`` and ``allow_inline``: then a file is loaded once for several calls.

    Raises
    ------
    InputError
        When there is no such rule, a parameter is wrong, or it can play none of the roles, or several and none is
        preferred.
    """
    sources = sources or RuleSources(folder, allow_inline)
    source = sources.find(choice.rule, place)
    able = roles_of(require_attrs_class(place, source.target, source.describe()))
    playable = [preferred] if preferred in roles and preferred in able else [role for role in able if role in roles]
    if len(playable) > 1:  # what else it decides comes first, unless packing is asked for
        playable = [role for role in playable if role not in (Role.PACKING, Role.PACKING_TASK)] or playable
    if not playable:
        wanted = listed((role.label for role in roles), "or")
        raise InputError(place, f"{source.describe()} decides {decided(able)}; expected a rule for {wanted}")
    if len(playable) > 1:
        raise InputError(
            place,
            f"{source.describe()} decides {decided(playable)}; say which of them is asked "
            "(`--decides`; in Python `decides`)",
        )
    return bind(sources, [(playable[0], choice, place)])[1][0]


def reserving_way(rule: BoundRule, place: str, asked: str) -> type[ReservedDriving] | None:
    """Return the way of driving of a PP rule, whose questions are those of ours; None where it reserves nothing.

    Raises
    ------
    InputError
        When the way is no subclass of ours: nobody but the way knows what it hands its rule. ``asked`` says why that
        is wrong.
    """
    way: type | None = rule.traits.way
    if way is None:
        return None
    from rmfs_core.simulation.driving.free import FreeDriving
    from rmfs_traffic.reserved import ReservedDriving

    if issubclass(way, ReservedDriving):
        return way
    if issubclass(way, FreeDriving):
        return None
    problem = f"{rule.describe()} plans for the way of driving {rule.traits.reserves!r}, {asked}"
    raise InputError(place, f"{problem}; expected a rule for a way that rmfs ships, or for a subclass of one")
