"""`rmfs generate`: write an instance to CSV files."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rmfs_cli.options import scenario_argument, seed_option, set_option

if TYPE_CHECKING:
    from rmfs_core.scenario import Scenario


@click.command()
@scenario_argument
@click.option("--out", required=True, metavar="DIR", help="Folder to write to; it is made if it is not there.")
@set_option
@seed_option
@click.option("--force", is_flag=True, help="Replace files that are there already.")
def generate(scenario: str, out: str, overrides: tuple[str, ...], seed: int | None, force: bool) -> None:
    """Write the orders and pods of SCENARIO to DIR as CSV, and a scenario that uses them.

    DIR/scenario.toml runs on the same instance as SCENARIO. A text map and rules from files are copied along.
    """
    from rmfs_core.results.files import output_folder
    from rmfs_core.scenario import load_scenario, to_toml
    from rmfs_core.world import make_instance, orders_csv, pods_csv

    loaded = load_scenario(scenario, overrides, seed)
    instance = make_instance(loaded)
    moved, copied = _with_files(loaded)
    files = {
        **copied,
        "orders.csv": orders_csv(instance).encode(),
        "pods.csv": pods_csv(instance).encode(),
        "scenario.toml": to_toml(moved).encode(),
    }
    folder = output_folder(out)
    _write(folder, files, force)
    click.echo(
        f"Wrote {len(instance.orders)} orders and {len(instance.pods)} pods to {folder}: "
        f"{', '.join(sorted(files))}. Run them with: rmfs run {folder / 'scenario.toml'}"
    )


def _with_files(scenario: Scenario) -> tuple[Scenario, dict[str, bytes]]:
    """Return the scenario for another folder, on CSV files, and the other files it needs there by name."""
    from attrs import evolve

    from rmfs_core.scenario import InstanceSection
    from rmfs_core.scenario.rulenames import is_inline, rule_choices

    old = Path(scenario.folder)
    copied = {}
    layout = scenario.layout
    if layout.map_file is not None:
        name = Path(layout.map_file).name
        copied[name] = _read(old / layout.map_file)
        layout = evolve(layout, map_file=name)
    for _, choice in rule_choices(scenario.rules):
        if is_inline(choice.rule):
            file = choice.rule.rpartition(":")[0]
            copied[Path(file).as_posix()] = _read(old / file)
    instance = InstanceSection(
        orders_file="orders.csv", pods_file="pods.csv", pods_at_stations=scenario.instance.pods_at_stations
    )
    return evolve(scenario, instance=instance, layout=layout), copied


def _read(path: Path) -> bytes:
    from rmfs_core.errors import InputError

    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(str(path), f"cannot be read: {error.strerror}") from None


def _write(folder: Path, files: Mapping[str, bytes], force: bool) -> None:
    """Write all files or none: each is complete beside its place before the first takes its place."""
    from rmfs_core.errors import InputError
    from rmfs_core.results.files import AtomicFile, output_folder

    there = [str(folder / name) for name in sorted(files) if (folder / name).exists()]
    if there and not force:
        raise InputError(", ".join(there), "found a file of that name; --force replaces it")
    waiting: list[AtomicFile] = []
    try:
        for name, content in files.items():
            output_folder((folder / name).parent)
            waiting.append(AtomicFile(folder / name))
            waiting[-1].stream.write(content)
    except BaseException:
        for file in waiting:
            file.discard()
        raise
    for file in waiting:
        file.commit()
