"""`rmfs generate`: write an instance to CSV files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rmfs_commands.cli.completion import SetCommand
from rmfs_commands.cli.options import OutPath, no_inline_option, scenario_argument, seed_option, set_option
from rmfs_commands.cli.screen import say, tell

if TYPE_CHECKING:
    from rmfs_core.scenario import RuleChoice, RulesSection, Scenario
    from rmfs_core.scenario.model import Departures

WRITTEN = ("orders.csv", "pods.csv", "scenario.toml")
"""Files that are made, not copied."""


@click.command(cls=SetCommand, short_help="Write a scenario's orders and pods as CSV.")
@scenario_argument
@click.option(
    "--out", required=True, metavar="DIR", type=OutPath(), help="Folder to write to; it is made if it does not exist."
)
@set_option
@seed_option
@click.option("--force", is_flag=True, help="Replace files that are there already.")
@no_inline_option
def generate(
    scenario: str, out: Path, overrides: tuple[str, ...], seed: int | None, force: bool, no_inline_rules: bool
) -> None:
    """Write the orders and pods of SCENARIO to DIR as CSV, and a scenario that uses them.

    DIR/scenario.toml runs on the same instance as SCENARIO. A text map, rules from files, and files that
    parameters of rules name are copied along.
    """
    from attrs import evolve

    from rmfs_commands.cli.checking import load_checked
    from rmfs_commands.cli.csv_writing import orders_csv, pods_csv
    from rmfs_commands.cli.file_writing import write_files
    from rmfs_commands.cli.toml_scenario import to_toml
    from rmfs_commands.instances.departures import before_trucks
    from rmfs_core.scenario import located
    from rmfs_core.wording import counted
    from rmfs_core.world import make_instance

    loaded = load_checked(scenario, overrides, seed)
    instance = make_instance(loaded)
    orders, trucks = before_trucks(instance.orders, loaded.instance.departures)
    with located(loaded):
        moved, copied = _with_files(loaded, trucks, allow_inline=not no_inline_rules)
    files = {
        **copied,
        "orders.csv": orders_csv(evolve(instance, orders=orders), None if trucks is None else trucks.column).encode(),
        "pods.csv": pods_csv(instance).encode(),
        "scenario.toml": to_toml(moved).encode(),
    }
    write_files(out, files, force=force)
    tell(
        f"Wrote {counted(len(instance.orders), 'order')} and {counted(len(instance.pods), 'pod')} to {out}: "
        f"{', '.join(sorted(files))}. Run them with: rmfs run {out / 'scenario.toml'}"
    )


def _with_files(
    scenario: Scenario, trucks: Departures | None, *, allow_inline: bool
) -> tuple[Scenario, dict[str, bytes]]:
    """Return the scenario for another folder, on CSV files, and the other files it needs there by name."""
    from attrs import evolve

    from rmfs_core.scenario import Arrivals, InstanceSection

    old = Path(scenario.folder)
    copied: dict[str, bytes] = {}
    layout = scenario.layout
    if layout.map_file is not None:
        name = Path(layout.map_file).name
        copied[name] = _read(old / layout.map_file)
        layout = evolve(layout, map_file=name)
    robots = scenario.robots
    if robots.file is not None:
        copied["robots.csv"] = _read(old / robots.file)
        robots = evolve(robots, file="robots.csv")
    given, arrivals = scenario.instance, scenario.instance.arrivals
    skus_file, replenishment = given.skus_file, given.replenishment
    if skus_file is not None:
        copied["skus.csv"], skus_file = _read(old / skus_file), "skus.csv"
    if replenishment is not None and replenishment.file is not None:
        copied["bundles.csv"] = _read(old / replenishment.file)
        replenishment = evolve(replenishment, file="bundles.csv")
    instance = InstanceSection(
        orders_file="orders.csv",
        pods_file="pods.csv",
        pods_at_stations=given.pods_at_stations,
        start=given.start,
        departures=trucks,
        arrivals=Arrivals() if arrivals.backlog is None else arrivals,
        pod_capacity=given.pod_capacity,
        skus_file=skus_file,
        replenishment=replenishment,
    )
    rules = _with_rule_files(scenario.rules, old, copied, allow_inline)
    return evolve(scenario, instance=instance, layout=layout, robots=robots, rules=rules), copied


def _with_rule_files(rules: RulesSection, old: Path, copied: dict[str, bytes], allow_inline: bool) -> RulesSection:
    """Add files of rules and files that their parameters name, and return the rules as another folder names them.

    Which parameters name files only the rules know, so they are loaded.
    """
    from attrs import evolve

    from rmfs_commands.cli.notes import notes_console
    from rmfs_core.errors import InputError
    from rmfs_core.rules import RuleSet
    from rmfs_core.rules.parts import with_given
    from rmfs_core.scenario.rulenames import GivenText, is_inline, rule_choices

    for (key, *_), choice in rule_choices(rules):
        if is_inline(choice.rule) and not allow_inline:
            raise InputError(f"rules.{key}", f'rule "{choice.rule}" is a file, which --no-inline-rules refuses')
    rules = _with_given_texts(rules, str(old))
    loaded = RuleSet.load(rules, str(old))
    for file in loaded.inline_files:
        say(notes_console(quiet=False), f"Loading code from {file}.")
    names = {}
    for one in loaded.files:
        default = not isinstance(one.text, GivenText)  # of the rule's class: the rule looks for it under this name
        if default and one.name in WRITTEN:
            continue
        content = _read(one.file)
        if default and not Path(one.name).is_absolute():
            copied[one.name] = content
        elif not default:
            names[id(one.text)] = _add(copied, one.name, content)

    def moved(choice: RuleChoice) -> RuleChoice:
        file, _, class_name = choice.rule.rpartition(":")
        name = f"./{_add(copied, file, _read(old / file))}:{class_name}" if is_inline(choice.rule) else choice.rule
        renamed: RuleChoice = with_given(choice, lambda text: names.get(id(text), str(text)))
        return evolve(renamed, rule=name)

    return _changed(rules, moved)


def _with_given_texts(rules: RulesSection, folder: str) -> RulesSection:
    """Return the rules with every text of a parameter as given in the folder; two equal choices have the same texts."""
    import json

    from attrs import evolve

    from rmfs_commands.instances.overrides import given_in
    from rmfs_core.rules.parts import with_given

    known: dict[tuple[str, str], RuleChoice] = {}

    def given(choice: RuleChoice) -> RuleChoice:
        key = choice.rule, json.dumps(with_given(choice.parameters, repr), sort_keys=True, default=repr)
        found = given_in(dict(choice.parameters), ("rules", ""), folder)
        return known.setdefault(key, evolve(choice, parameters=found))

    return _changed(rules, given)


def _changed(rules: RulesSection, change: Callable[[RuleChoice], RuleChoice]) -> RulesSection:
    """Return the rules with each choice changed."""
    from attrs import evolve

    from rmfs_core.roles import Role
    from rmfs_core.scenario.rulenames import rule_choices

    changed: dict[str, list[RuleChoice]] = {}
    for (key, *_), choice in rule_choices(rules):
        changed.setdefault(str(key), []).append(change(choice))
    many = [role.key for role in Role if role.many]
    given: dict[str, Any] = {key: tuple(found) if key in many else found[0] for key, found in changed.items()}
    return evolve(rules, **given)


def _add(copied: dict[str, bytes], name: str, content: bytes) -> str:
    """Add a file to those to copy, and return its name there: another one where that of a different file is taken."""
    target = Path(name)
    if target.is_absolute() or ".." in target.parts:
        target = Path(target.name)
    while target.as_posix() in WRITTEN or copied.get(target.as_posix(), content) != content:
        target = target.with_stem(f"{target.stem}_2")
    copied[target.as_posix()] = content
    return target.as_posix()


def _read(path: Path) -> bytes:
    from rmfs_core.errors import InputError

    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(str(path), f"cannot be read: {error.strerror}") from None
