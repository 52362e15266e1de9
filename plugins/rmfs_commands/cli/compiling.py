"""Saying that searches are being compiled, which happens once on a machine and takes some seconds."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rmfs_commands.cli.loading import loading_alone

if TYPE_CHECKING:
    from rich.console import Console

    from rmfs_core.scenario import Scenario


@contextmanager
def compiling_announced(notes: Console) -> Iterator[None]:
    """Say so, once, when something is compiled meanwhile in this process; what is cached is not, and loads alone."""
    from numba.core import event

    class Announcer(event.Listener):
        done = False

        def on_start(self, event: Any) -> None:  # noqa: ARG002
            if not self.done:
                self.done = True
                notes.print("Compiling searches (once a rule; up to a minute) ...", highlight=False, soft_wrap=True)

        def on_end(self, event: Any) -> None:
            pass

    with loading_alone(), event.install_listener("numba:compile", Announcer()):
        yield


def compile_searches(notes: Console, scenario: Scenario) -> None:
    """Compile what a scenario's runs search with: before worker processes do so side by side, unheard."""
    from rmfs_core.rules import RuleSet
    from rmfs_core.simulation.engine import Simulation
    from rmfs_core.world import make_instance, make_layout

    with compiling_announced(notes):
        rules = RuleSet.load(scenario.rules, scenario.folder)
        Simulation(scenario, make_instance(scenario), make_layout(scenario), rules)
