"""`rmfs generate`: write an instance to CSV files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rmfs_cli.completion import SetCommand
from rmfs_cli.options import OutPath, no_inline_option, scenario_argument, seed_option, set_option
from rmfs_cli.screen import tell

if TYPE_CHECKING:
    from rmfs_core.scenario import RuleChoice, RulesSection, Scenario


@click.command(cls=SetCommand, short_help="Write a scenario's orders and pods as CSV.")
@scenario_argument
@click.option("--out", required=True, metavar="DIR", type=OutPath(), help="Folder to write to; made if not there.")
@set_option
@seed_option
@click.option("--force", is_flag=True, help="Replace files that are there already.")
@no_inline_option
def generate(
    scenario: str, out: Path, overrides: tuple[str, ...], seed: int | None, force: bool, no_inline_rules: bool
) -> None:
    """Write the orders and pods of SCENARIO to DIR as CSV, and a scenario that uses them.

    DIR/scenario.toml runs on the same instance as SCENARIO. A text map and rules from files are copied along.
    """
    from rmfs_cli.checking import load_checked
    from rmfs_cli.csv_writing import orders_csv, pods_csv
    from rmfs_cli.file_writing import write_files
    from rmfs_cli.toml_scenario import to_toml
    from rmfs_core.wording import counted
    from rmfs_core.world import make_instance

    loaded = load_checked(scenario, overrides, seed)
    instance = make_instance(loaded)
    moved, copied = _with_files(loaded, allow_inline=not no_inline_rules)
    files = {
        **copied,
        "orders.csv": orders_csv(instance).encode(),
        "pods.csv": pods_csv(instance).encode(),
        "scenario.toml": to_toml(moved).encode(),
    }
    write_files(out, files, force=force)
    tell(
        f"Wrote {counted(len(instance.orders), 'order')} and {counted(len(instance.pods), 'pod')} to {out}: "
        f"{', '.join(sorted(files))}. Run them with: rmfs run {out / 'scenario.toml'}"
    )


def _with_files(scenario: Scenario, *, allow_inline: bool) -> tuple[Scenario, dict[str, bytes]]:
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
        arrivals=Arrivals() if arrivals.backlog is None else arrivals,
        pod_capacity=given.pod_capacity,
        skus_file=skus_file,
        replenishment=replenishment,
    )
    rules = _with_rule_files(scenario.rules, old, copied, allow_inline)
    return evolve(scenario, instance=instance, layout=layout, robots=robots, rules=rules), copied


def _with_rule_files(rules: RulesSection, old: Path, copied: dict[str, bytes], allow_inline: bool) -> RulesSection:
    """Add the files of rules to those to copy, and return the rules as another folder names them."""
    from attrs import evolve

    from rmfs_core.errors import InputError
    from rmfs_core.roles import Role
    from rmfs_core.scenario.rulenames import is_inline, rule_choices

    moved: dict[str, list[RuleChoice]] = {}
    for (key, *_), choice in rule_choices(rules):
        file, _, class_name = choice.rule.rpartition(":")
        renamed = choice
        if is_inline(choice.rule):
            if not allow_inline:
                raise InputError(f"rules.{key}", f'rule "{choice.rule}" is a file, which --no-inline-rules refuses')
            content = _read(old / file)
            target = Path(file if not Path(file).is_absolute() else Path(file).name)
            while copied.get(target.as_posix(), content) != content:  # another file of that name is there
                target = target.with_stem(f"{target.stem}_2")
            copied[target.as_posix()] = content
            renamed = evolve(choice, rule=f"./{target.as_posix()}:{class_name}")
        moved.setdefault(str(key), []).append(renamed)
    many = [role.key for role in Role if role.many]
    changed: dict[str, Any] = {key: tuple(found) if key in many else found[0] for key, found in moved.items()}
    return evolve(rules, **changed)


def _read(path: Path) -> bytes:
    from rmfs_core.errors import InputError

    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(str(path), f"cannot be read: {error.strerror}") from None
