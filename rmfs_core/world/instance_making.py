"""From a scenario to its instance."""

from __future__ import annotations

from pathlib import Path

from rmfs_core.scenario.model import Scenario
from rmfs_core.scenario.reading import located
from rmfs_core.world.csv_reading import read_instance
from rmfs_core.world.generator import generate_instance
from rmfs_core.world.instance import Instance
from rmfs_core.world.instance_checks import check_instance


def make_instance(scenario: Scenario) -> Instance:
    """Generate the instance of a scenario, or read it from the scenario's CSV files.

    Raises
    ------
    InputError
        When a file is wrong, or the instance cannot be run in this scenario: an order that no station or no stock can
        serve, an unknown pod at a station.
    """
    with located(scenario):
        return _made(scenario)


def _made(scenario: Scenario) -> Instance:
    section = scenario.instance
    if section.orders_file is None or section.pods_file is None:
        instance = generate_instance(section, scenario.seed)
    else:
        folder = Path(scenario.folder)
        instance = read_instance(folder / section.orders_file, folder / section.pods_file)
    check_instance(instance, scenario)
    return instance
