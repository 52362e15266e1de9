"""A rule that decides in states, one after the other: loaded once, and asked as if for the first time in each."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any, cast

import pluggy
from attrs import evolve, frozen

from rmfs_commands.cli.single_rule import load_rule
from rmfs_commands.states.deciding import Answer, ask, repaired
from rmfs_commands.states.rebuilding import OpenState, open_state
from rmfs_commands.states.state import ASKED, DECIDES, State
from rmfs_core.errors import InputError
from rmfs_core.roles import Role
from rmfs_core.rules import BoundRule
from rmfs_core.rules.hooks import decided, marked_methods, require_attrs_class, roles_of
from rmfs_core.rules.parameters import build
from rmfs_core.rules.parts import made_in
from rmfs_core.rules.sources import RuleSources
from rmfs_core.scenario.model import RuleChoice
from rmfs_core.scenario.rulenames import is_inline
from rmfs_core.wording import listed, shown_short

MOST_LOADED = 8
"""Rules that `decide` keeps."""

_last: dict[str, Decider] = {}


class Decider:
    """A rule, loaded once, that decides in any number of states.

    Each state is decided by a new instance of the rule, so the same state gets the same answer whatever was asked
    before. Rules are not made for threads: one call at a time.

    Parameters
    ----------
    choice
        The rule's name and its parameters.
    decides
        Decision to ask of a rule that decides several things; by default the ``ask`` of a state.
    folder
        Where the file of an inline rule is, and files that parameters name.
    allow_inline
        Whether such a file may be loaded at all.

    Raises
    ------
    InputError
        When there is no such rule, a parameter is wrong, or it does not decide that.
    """

    def __init__(
        self, choice: RuleChoice, *, decides: Role | None = None, folder: str = ".", allow_inline: bool = True
    ) -> None:
        if not isinstance(choice, RuleChoice):
            raise InputError(
                "choice", f'expected a RuleChoice such as `RuleChoice("nearest")`, found {shown_short(choice)}'
            )
        if decides is not None and decides not in ASKED:
            raise InputError(
                "decides", f"expected {listed(DECIDES, 'or')}, found {getattr(decides, 'label', decides)!r}"
            )
        self.choice, self.decides = choice, decides
        self._sources = RuleSources(folder, allow_inline)
        self._rules: dict[Role | None, BoundRule] = {}
        source = self._sources.find(choice.rule, "rule")
        kind = require_attrs_class("rule", source.target, source.describe())
        self._roles, self._described = [role for role in ASKED if role in roles_of(kind)], source.describe()
        if decides is None and len(self._roles) > 1:
            with made_in(folder):
                build(kind, choice.parameters, "rule", source.describe())  # which role it plays, a state will say
        else:
            self._rule(decides)

    def decide(self, state: State | OpenState, source: str = "state") -> Answer:
        """Return what the rule decides in a state.

        Parameters
        ----------
        state
            The state; or a warehouse made from it, in which the decision is carried out.
        source
            Name of the state's source in messages.

        Raises
        ------
        InputError
            When the state contradicts itself, or lacks something that the rule needs.
        RuleError
            When the rule raises, or decides something impossible.
        """
        if not isinstance(state, State | OpenState):
            raise InputError(source, f"expected a State, such as `read_state` returns, found {shown_short(state)}")
        opened = open_state(state, source) if isinstance(state, State) else state
        asked = opened.state.ask.role
        if self.decides is None and asked is not None and asked not in self._roles:
            found = f"found {asked.label}; {self._described} decides {decided(self._roles)}"
            opened.names.wrong(("ask", "decides"), f"{found}; expected that, or a rule for {asked.label}")
        return repaired(opened, ask(opened, self._rule(self.decides or asked)))

    def _rule(self, preferred: Role | None) -> BoundRule:
        if preferred not in self._rules:
            roles = ASKED if self.decides is None else (self.decides,)
            rule = load_rule(self.choice, roles, preferred=preferred, sources=self._sources)
            afresh = _Afresh.of(rule, self.choice.parameters, self._sources.folder)
            hook = cast(pluggy.HookCaller, afresh)  # is called as one
            self._rules[preferred] = evolve(rule, hook=hook, call=hook)
        return self._rules[preferred]


@frozen
class _Afresh:
    """Calls a hook of a new instance of a rule, which nobody has asked before."""

    name: str
    rule: BoundRule
    method: str
    arguments: tuple[str, ...]
    parameters: Mapping[str, Any]
    folder: str

    @classmethod
    def of(cls, rule: BoundRule, parameters: Mapping[str, Any], folder: str) -> _Afresh:
        (implementation,) = rule.hook.get_hookimpls()
        method = marked_methods(type(rule.instance))[rule.hook.name]
        return cls(rule.hook.name, rule, method, implementation.argnames, parameters, folder)

    def __call__(self, **given: Any) -> Any:
        with made_in(self.folder):
            instance = build(type(self.rule.instance), self.parameters, "rule", self.rule.describe())
        return getattr(instance, self.method)(*(given[name] for name in self.arguments))


def decide(
    state: State,
    choice: RuleChoice,
    *,
    decides: Role | None = None,
    folder: str = ".",
    allow_inline: bool = True,
    source: str = "state",
) -> Answer:
    """Ask a rule what it decides in a state, as a `Decider` does; the last few rules stay loaded.

    Parameters
    ----------
    state
        The state.
    choice, decides, folder, allow_inline
        The rule, as for `Decider`.
    source
        Name of the state's source in messages.

    Raises
    ------
    InputError, RuleError
        As `Decider` and its `decide`.
    """
    asked = repr((choice, decides, folder, sys.path))  # what is installed may change with the path
    decider = _last.pop(asked, None) or Decider(choice, decides=decides, folder=folder, allow_inline=allow_inline)
    if not is_inline(choice.rule):  # a file may change
        _last[asked] = decider
        if len(_last) > MOST_LOADED:
            del _last[next(iter(_last))]
    return decider.decide(state, source)
