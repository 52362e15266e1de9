"""Completion for the shell: scenarios, keys and values of ``--set``, rules, experiments. Imports no rule.

A shell is told of it once: ``eval "$(_RMFS_COMPLETE=bash_source rmfs)"``, and likewise ``zsh_source``, ``fish_source``.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click
from click.shell_completion import CompletionItem


def _matching(names: Iterable[str], incomplete: str) -> list[CompletionItem]:
    return [CompletionItem(name) for name in names if name.startswith(incomplete)]


def _files(incomplete: str, suffix: str) -> list[str]:
    """Return files of a suffix, and folders, as far as they are typed."""
    above, _, _ = incomplete.rpartition("/")
    typed = f"{above}/" if "/" in incomplete else ""
    folder = Path(typed or ".").expanduser()
    found = sorted(folder.iterdir()) if folder.is_dir() else []
    shown = [path for path in found if not path.name.startswith(".") and (path.is_dir() or path.suffix == suffix)]
    return [f"{typed}{path.name}{'/' if path.is_dir() else ''}" for path in shown]


def scenarios(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Complete a scenario: a shipped one, or a file."""
    from rmfs_core.scenario.reading import shipped_scenarios

    if (key := _key_without_value(ctx)) is not None:
        return _matching(_values(key), incomplete)
    return _matching([*shipped_scenarios(), *_files(incomplete, ".toml")], incomplete)


def experiments(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Complete an experiment: a shipped one, or a file."""
    from rmfs_core.scenario.reading import EXPERIMENTS, shipped_folder

    shipped = sorted(path.stem for path in (shipped_folder() / EXPERIMENTS).glob("*.toml"))
    return _matching([*shipped, *_files(incomplete, ".toml")], incomplete)


def rules(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Complete the name of an installed rule."""
    return _matching(_rule_names(), incomplete)


def recorders(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Complete the name of an installed recorder."""
    from rmfs_core import entrypoints

    return _matching(entrypoints.offers(entrypoints.RECORDERS), incomplete)


def overrides(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Complete ``KEY=VALUE`` of ``--set``: the keys of a scenario, and the rules after ``rules.poa=``."""
    key, equals, value = incomplete.partition("=")
    keys = [key] if equals else [name for name in _keys() if name.startswith(key)]
    if len(keys) == 1 and (values := _values(keys[0])):
        return _matching((f"{keys[0]}={name}" for name in values), f"{keys[0]}={value}")
    return [] if equals else [CompletionItem(f"{name}=") for name in keys]


class SetCommand(click.Command):
    """A command with ``--set``, whose values bash has completed, too: it takes ``rules.poa=x`` for three words."""

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Complete a value that stands alone, or else what any command completes."""
        if (key := _key_without_value(ctx)) is not None:
            return _matching(_values(key), incomplete)
        return super().shell_complete(ctx, incomplete)


def _key_without_value(ctx: click.Context) -> str | None:
    """Return the last ``--set`` if it has no ``=``, which stands in a word of its own then."""
    given: tuple[str, ...] = ctx.params.get("overrides") or ()
    return given[-1] if given and "=" not in given[-1] else None


def _values(key: str) -> list[str]:
    """Return what a key can be set to: one rule, where a single one is named."""
    from rmfs_core.roles import Role

    single = [f"rules.{role.key}{end}" for role in Role if not role.many for end in ("", ".rule")]
    return _rule_names() if key in single else []


def _rule_names() -> list[str]:
    from rmfs_core import entrypoints

    return list(entrypoints.offers(entrypoints.RULES))


def _keys() -> list[str]:
    from rmfs_core.scenario.model import Scenario
    from rmfs_core.scenario.structuring import fields_of, section_class

    found = []
    for name in fields_of(Scenario):
        section = section_class(Scenario, name)
        found += [name] if section is None else [f"{name}.{key}" for key in fields_of(section)]
    return found
