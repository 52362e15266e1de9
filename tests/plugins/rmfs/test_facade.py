"""The package that users import: one package, whose names are those of the packages behind it."""

import subprocess
import sys
from importlib import import_module
from importlib.metadata import version

import pytest

import rmfs
import rmfs_core

MODULES = {
    "gym": "rmfs_commands.gym",
    "helpers": "rmfs_rules.helpers",
    "layouts": "rmfs_commands.layouts",
    "testing": "rmfs_commands.testing",
    "warehouse": "rmfs_core.warehouse",
    "world": "rmfs_core.world",
}


def test_every_name_is_there() -> None:
    assert all(getattr(rmfs, name) is not None for name in rmfs.__all__)
    assert all(getattr(rmfs, name) is getattr(rmfs_core, name) for name in rmfs_core.__all__)
    assert {*rmfs_core.__all__, *MODULES, "Decider", "load_result", "replay", "run_experiment"} <= {*rmfs.__all__}
    assert rmfs.__version__ == version("rmfs")


@pytest.mark.parametrize(("module", "target"), MODULES.items())
def test_a_module_has_the_names_of_the_one_behind_it(module: str, target: str) -> None:
    ours, theirs = import_module(f"rmfs.{module}"), import_module(target)
    assert ours.__all__ == theirs.__all__ != []
    assert all(getattr(ours, name) is getattr(theirs, name) for name in theirs.__all__)


def test_all_events_are_there() -> None:
    ours, kernel, processes = map(import_module, ("rmfs.events", "rmfs_core.events", "rmfs_commands.processes.events"))
    assert ours.__all__ == [*kernel.__all__, *processes.__all__]
    there = [one for module in (kernel, processes) for one in vars(module).values() if isinstance(one, type)]
    events = {one.__name__ for one in there if issubclass(one, kernel.Event)}
    assert {name for name in events if not name.startswith("_")} <= {*ours.__all__}


def test_a_name_that_is_not_there_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'rmfs' has no attribute 'runn'"):
        _ = rmfs.runn


def test_importing_it_costs_next_to_nothing() -> None:
    """Neither numpy nor any part of the kernel is loaded before something is used."""
    heavy = ("numpy", "attrs", "rmfs_core.", "rmfs_commands", "rmfs_rules")
    code = f"import sys, rmfs; print([name for name in sys.modules if name.startswith({heavy})])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_it_is_the_command_line_too() -> None:
    done = subprocess.run([sys.executable, "-m", "rmfs", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.rstrip().endswith(f"version {version('rmfs')}")
