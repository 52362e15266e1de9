"""Traits of a rule that the kernel needs besides its decisions: read once, from attributes that its class declares."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from attrs import field, frozen

from rmfs_core.entrypoints import DRIVING, load, offers, preferred
from rmfs_core.errors import InputError
from rmfs_core.events import Event
from rmfs_core.roles import Role
from rmfs_core.scenario.model import Scenario
from rmfs_core.wording import listed, shown_short
from rmfs_core.world import Instance

NEEDS: dict[str, tuple[Callable[[Scenario, Instance], bool], str]] = {
    "unlimited stock": (
        lambda _, instance: instance.unlimited_stock,
        "pods whose SKUs never run out, but the instance has finite stock",
    ),
    "item capacity": (
        lambda scenario, _: scenario.stations.order_capacity is None,
        "stations that count items, but the scenario sets `stations.order_capacity`",
    ),
    "no batteries": (
        lambda scenario, _: scenario.robots.battery is None,
        "robots without batteries, as it sends none to a charger, but the scenario sets `robots.battery`",
    ),
}
"""Values of a rule's ``needs``: the test, and the end of the sentence when it fails."""


def _roles(roles: Iterable[str]) -> tuple[Role, ...]:
    return tuple(map(Role, roles))


@frozen
class RuleTraits:
    """The attributes that a rule's class may declare, each of which may be left out.

    Parameters
    ----------
    needs
        Tuple of what the rule relies on, from `NEEDS` (such as ``"unlimited stock"``). A scenario that lacks it is
        refused.
    libraries
        Tuple of distributions that the rule computes with, such as a solver's: their versions are kept with the
        results.
    decides
        Tuple of roles that the rule can play; the class has their hooks. It may depend on parameters.
    splits_over_time
        True for a rule that may leave lines of an order in the backlog: it is asked when the smallest open line fits,
        not only when the smallest order does.
    whole_orders
        True for a joint rule that never splits an order: where the scenario refuses orders that are larger than any
        station, it is refused those, as every rule for POA alone is.
    packing_capacity
        Number of split orders that may be open at once, or None: a decision that exceeds it is refused. It may be a
        parameter of the rule.
    reserves
        How a PP rule keeps robots out of each other's way: the name of a way of driving, an entry point in the group
        ``rmfs.driving``. None: not at all, robots pass through each other. With ``"full paths"`` each path ends at the
        goal and is reserved for its robot, the goal without end. With ``"windows"`` a path may end wherever the robot
        may then stay, and the rule is asked again there. ``"fleet"`` is as full paths, for all robots that need one at
        once; the rule answers `plan_paths`. These make the reservations and refuse a path that hits one.
    prepare
        Method called with the `Travel` of the run before it starts, for a rule with compiled searches to load them:
        then no decision's time has it in. A PP rule that ``reserves`` is handed what its way of driving makes of it.
    hears
        Events that it observes: a tuple of classes, or a mapping from these to functions, as `on_event` says.
    distribution
        Who offers the rule, which it does not declare: of ways of driving with the same name its own, or else ours.
    """

    needs: tuple[str, ...] = ()
    libraries: tuple[str, ...] = ()
    decides: tuple[Role, ...] = field(default=tuple(Role), converter=_roles)
    splits_over_time: bool = False
    whole_orders: bool = False
    packing_capacity: int | None = None
    reserves: str | None = None
    prepare: Callable[[Any], None] | None = None
    hears: tuple[type[Event], ...] | Mapping[type[Event], Sequence[Callable[[Any], object]]] | None = None
    distribution: str = field(default="rmfs", eq=False)

    @property
    def way(self) -> Any:
        """The way of driving that it plans for, a class; None where robots pass through each other."""
        if self.reserves is None:
            return None
        return load(preferred(DRIVING, self.reserves, self.distribution), "rules.pp", "way of driving")

    def hook(self, role: Role) -> str:
        """Return the hook that the rule answers in a role."""
        return role.hook if role is not Role.PP or self.reserves is None else self.way.hook

    @classmethod
    def of(cls, rule: object, place: str, name: str, distribution: str = "rmfs") -> RuleTraits:
        """Return the traits of a rule, named at ``place``, that messages call ``name``; InputError for a wrong one."""
        found: dict[str, Any] = {"distribution": distribution}
        for trait, (expected, holds) in _EXPECTED.items():
            try:
                value = getattr(rule, trait, None)
            except Exception as error:
                value = error
            if value is not None:
                if not holds(value):
                    wanted = expected if isinstance(expected, str) else expected()
                    raise InputError(place, f"{name} has {trait} = {shown_short(value)}; expected {wanted}")
                found[trait] = value
        return cls(**found)

    def lacks(self, scenario: Scenario, instance: Instance) -> list[str]:
        """Return what the rule needs and a scenario does not have, each as the end of a sentence."""
        return [sentence for met, sentence in map(NEEDS.__getitem__, self.needs) if not met(scenario, instance)]


installed_version = cache(version)
"""Version of an installed distribution, read once."""


def _texts(value: Any) -> bool:
    return isinstance(value, tuple) and all(isinstance(text, str) for text in value)


def _installed(value: Any) -> bool:
    try:
        return _texts(value) and all(map(installed_version, value))
    except (PackageNotFoundError, ValueError):
        return False


def _heard(value: Any) -> bool:
    called = value.values() if isinstance(value, Mapping) else [] if isinstance(value, tuple) else [None]
    lists = all(isinstance(one, list | tuple) and all(map(callable, one)) for one in called)
    return lists and all(isinstance(kind, type) and Event in kind.__mro__[1:] for kind in value)


_EXPECTED: dict[str, tuple[str | Callable[[], str], Callable[[Any], bool]]] = {
    "needs": (f"a tuple of {listed(map(repr, NEEDS), 'or')}", lambda value: _texts(value) and {*value} <= NEEDS.keys()),
    "libraries": ("a tuple of installed distributions' names", _installed),
    "decides": ("a tuple of roles", lambda value: _texts(value) and {*value} <= {*Role}),
    "splits_over_time": ("True or False", lambda value: isinstance(value, bool)),
    "whole_orders": ("True or False", lambda value: isinstance(value, bool)),
    "packing_capacity": ("a whole number >= 0, or None", lambda value: type(value) is int and value >= 0),
    "reserves": (
        lambda: listed(map(repr, (*offers(DRIVING), None)), "or"),
        lambda value: _texts((value,)) and value in offers(DRIVING),
    ),
    "prepare": ("a method", callable),
    "hears": ("a tuple of classes of events, or a mapping from these to lists of functions", _heard),
}
