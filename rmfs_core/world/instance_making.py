"""From a scenario to its instance, generated or read, and whether it can be run in that scenario."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from attrs import evolve

from rmfs_core import entrypoints
from rmfs_core.errors import InputError
from rmfs_core.scenario.model import Arrivals, InstanceSection, Scenario
from rmfs_core.scenario.reading import located
from rmfs_core.world.instance import Instance

Wrong = Callable[[InputError], None]
"""A function called with each mistake in a file; when it returns, the row is left out."""


def refuse(error: InputError) -> None:
    """Raise the first mistake."""
    raise error


def reader() -> Any:
    """Return the module that reads the files which scenarios name, the entry point ``csv`` of ``rmfs.formats``.

    It has ``Calendar(start)``, ``read_instance(orders_file, pods_file, start, wrong, departures)``,
    ``line_of(orders_file, order, sku)``, ``drawn(instance, scenario)`` (`Scale`), ``departing(instance, scenario)``,
    ``read_robots(file)``, ``restocked(instance, scenario, wrong)``, ``read_profile(file)`` and ``read_times(file)``.
    """
    return entrypoints.format_module("csv")


def make_instance(scenario: Scenario) -> Instance:
    """Generate the instance of a scenario, or read it from the scenario's CSV files.

    Raises
    ------
    InputError
        When a file is wrong, or the instance cannot be run in this scenario: an order that no station or no stock can
        serve, an unknown pod at a station.
    """
    with located(scenario):
        instance = unchecked_instance(scenario)
        for problem in instance_problems(instance, scenario):
            raise problem
    return instance


def unchecked_instance(scenario: Scenario, wrong: Wrong = refuse) -> Instance:
    """Generate or read the instance, as `make_instance` does, without asking whether it can be run.

    ``wrong`` is called with each mistake in its files, as `read_instance` does.
    """
    section, folder = scenario.instance, Path(scenario.folder)
    reader().Calendar(section.start).zero()  # whether or not it is used, what is wrong with it is said
    if section.orders_file is None or section.pods_file is None:
        if isinstance(hours := section.arrivals.profile, str):
            section = evolve(section, arrivals=evolve(section.arrivals, profile=reader().read_profile(folder / hours)))
        return _restocked(_generated(section, scenario), scenario, wrong)
    orders, pods = folder / section.orders_file, folder / section.pods_file
    for key, file in (("orders_file", orders), ("pods_file", pods)):
        if not os.path.exists(file):  # noqa: PTH110 (False for a name that is too long, too)
            raise InputError(f"instance.{key}", f"there is no file {file}")
    instance = reader().read_instance(orders, pods, section.start, wrong, section.departures)
    return _restocked(instance if section.scale is None else reader().drawn(instance, scenario), scenario, wrong)


def _restocked(instance: Instance, scenario: Scenario, wrong: Wrong) -> Instance:
    given = scenario.instance.replenishment
    plain = scenario.instance.skus_file is None and (given is None or given.process == "none")
    instance = instance if scenario.instance.departures is None else reader().departing(instance, scenario)
    return instance if plain else reader().restocked(instance, scenario, wrong)


def generator_of(section: InstanceSection) -> entrypoints.Entries:
    """Return the entry points of an instance's generator (of section, seed, parameters); one, or they clash."""
    return entrypoints.chosen(entrypoints.INSTANCES, section.generator, "paper")


def _generated(section: InstanceSection, scenario: Scenario) -> Instance:
    read: set[str] = set()  # keys of the section; `__reduce_ex__` when a copy is made, of which any may be read

    class Watched(InstanceSection):
        def __getattribute__(self, name: str) -> Any:
            read.add(name)
            return getattr(section, name)

    entries, watched = generator_of(section), object.__new__(Watched)
    malformed = entrypoints.format_module("problems").malformed
    made = entrypoints.generated(entries, Instance, malformed, scenario.folder, section=watched, seed=scenario.seed)
    for key in ("due", "arrivals", "lines", "demand", "items_per_sku"):
        timed = key == "arrivals" and section.arrivals.backlog is not None  # by the run, as orders are done
        if getattr(section, key) not in (None, Arrivals()) and not timed and not read & {key, "__reduce_ex__"}:
            found = f'generator "{entries[0].name}" has made this instance without reading it'
            expected = f"expected it left out, or a generator that reads `section.{key}` in each call"
            raise InputError(f"instance.{key}", f"{found}; {expected}")
    return made


def instance_problems(instance: Instance, scenario: Scenario) -> Iterator[InputError]:
    """Yield what keeps an instance from being run: short SKUs, orders that are too large, pods at stations."""
    return entrypoints.format_module("problems").instance_problems(instance, scenario)  # type: ignore[no-any-return]
