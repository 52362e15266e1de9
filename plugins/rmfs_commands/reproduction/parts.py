"""The parts of a reproduction: which experiment each runs, and what its rows are compared with."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from attrs import evolve, frozen

from rmfs_commands.experiments import Experiment, load_experiment
from rmfs_commands.reproduction.estimates import Rows
from rmfs_commands.reproduction.extensions import example_tables, large_tables, packing_tables, prefilter_tables
from rmfs_commands.reproduction.instance_sets import ORDERS, instance_set_tables
from rmfs_commands.reproduction.paper import Exhibit
from rmfs_commands.reproduction.tables import Table
from rmfs_core.errors import InputError
from rmfs_core.wording import nearest


@frozen
class Part:
    """A part of the paper's evaluation.

    Parameters
    ----------
    name
        Its name for ``--only``.
    experiment
        Name of the shipped experiment file.
    tables
        Makes its tables from the rows of its runs.
    """

    name: str
    experiment: str
    tables: Callable[[Rows, Mapping[str, Exhibit]], list[Table]]


PARTS = (
    Part("examples", "paper-examples", example_tables),
    Part("instances", "paper-instances", instance_set_tables),
    Part("packing", "paper-packing", packing_tables),
    Part("prefilter", "paper-prefilter", prefilter_tables),
    Part("large", "paper-2000", large_tables),
)

QUICK_PARTS = ("examples", "instances")
QUICK_ORDERS = 50
QUICK_SEEDS = 1


def choose_parts(only: tuple[str, ...] = (), quick: bool = False) -> list[Part]:
    """Return the parts of these names, or all; of a quick reproduction, only its parts.

    Raises
    ------
    InputError
        When there is no part of a name, or it has no quick version.
    """
    names = [part.name for part in PARTS]
    for name in only:
        if name not in names:
            raise InputError("--only", f'there is no part "{name}"{nearest(name, names)}')
        if quick and name not in QUICK_PARTS:
            raise InputError("--only", f"{name} has no part in --quick, which is {' and '.join(QUICK_PARTS)}")
    chosen = only or (QUICK_PARTS if quick else names)
    return [part for part in PARTS if part.name in chosen]


def experiment_of(part: Part, quick: bool = False) -> Experiment:
    """Return the experiment of a part; the quick one has its first seed and its smallest instance set alone."""
    experiment = load_experiment(part.experiment)
    if not quick:
        return experiment
    axes = tuple(
        evolve(axis, points=tuple(point for point in axis.points if point.value == QUICK_ORDERS))
        if axis.name == ORDERS
        else axis
        for axis in experiment.axes
    )
    return evolve(experiment, axes=axes, seeds=experiment.seeds[:QUICK_SEEDS])
