"""Compiling what is not in numba's cache yet, which happens once on a machine: shown, and on two cores where there are.

The search of the rule that plans paths takes about as long as all the rest. Another process compiles it meanwhile, into
the cache, where this one finds it; each function has files of its own there, which are replaced whole.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from attrs import define, field

from rmfs_commands.cli.loading import loading_alone
from rmfs_core import entrypoints
from rmfs_core.jit import interpret
from rmfs_core.roles import Role

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

    from rmfs_core.scenario import RuleChoice, Scenario
    from rmfs_core.world.travel import Travel

SMALL_LINES, SMALL_ROBOTS, SMALL_BLOCKS, SMALL_FILE = 900, 8, 80, 4_000
"""Lines, robots, length of all blocks and bytes of each file of a run that is quicker than loading machine code."""
LONGEST_S = 300.0
"""How long the other process is waited for."""
SHIPPED = "rmfs_rules"


@define
class _Shown:
    """Shows what is being compiled: on a terminal a bar for each rule, elsewhere one line."""

    notes: Console
    _depth: int = field(default=0, init=False)
    _begun: float = field(default=0.0, init=False)
    _said: bool = field(default=False, init=False)
    _spent: dict[str, float] = field(factory=dict, init=False)
    _bars: Progress | None = field(default=None, init=False)
    _now: str = field(default="", init=False)

    def begin(self, module: str) -> None:
        """A function of a module is compiled from now on, or waited for."""
        self._depth += 1
        if self._depth > 1:  # what another one calls
            return
        self._now, self._begun = _whose(module), time.monotonic()
        if not self._said and not self.notes.is_terminal:
            self.notes.print("Compiling searches (once a rule; up to a minute) ...", highlight=False, soft_wrap=True)
        self._said = True
        if self.notes.is_terminal and not self.notes.quiet:
            self._open()

    def end(self) -> None:
        """It is compiled."""
        self._depth -= 1
        if self._depth == 0:
            self._spent[self._now] = self._spent.get(self._now, 0.0) + time.monotonic() - self._begun
            self.close()

    def _open(self) -> None:
        """Show a bar for what was compiled, and one that moves for what is compiled now."""
        from rich.errors import LiveError
        from rich.progress import BarColumn, Progress, TextColumn

        self._bars = Progress(
            TextColumn("Compiling, once on this machine: {task.description}"),
            BarColumn(bar_width=24),
            TextColumn("{task.fields[spent]}"),
            console=self.notes,
            transient=True,
        )
        for name, spent in self._spent.items():
            if name != self._now:
                self._bars.add_task(name, total=1, completed=1, spent=f"{spent:.0f} s")
        self._bars.add_task(self._now, total=None, spent="")
        try:
            self._bars.start()
        except LiveError:  # the display of the run has the terminal
            self._bars = None

    def close(self) -> None:
        """Give the terminal back."""
        if self._bars is not None:
            self._bars.stop()
            self._bars = None


def _whose(module: str) -> str:
    """Return what a module is part of, for people: a rule's package, or all that rules share."""
    package, _, rest = module.partition(".")
    if package != SHIPPED:
        return "roads and stock" if package in ("rmfs_core", "rmfs_traffic") else package
    name = rest.partition(".")[0]
    return "choice of orders and pods" if name == "helpers" else f"rule {name.replace('_', '-')}"


@define
class _Other:
    """The process that compiles a rule meanwhile.

    Parameters
    ----------
    role, choice
        Role of the rule, its name and its parameters.
    package
        Where its functions are.
    """

    role: Role
    choice: RuleChoice
    package: str
    _process: subprocess.Popen[bytes] | None = field(default=None, init=False)

    def start(self) -> None:
        """Let it begin, once."""
        if self._process is None:
            told = json.dumps([self.role.key, self.choice.rule, dict(self.choice.parameters)])
            command = [sys.executable, "-c", f"from {__name__} import compile_told; compile_told()", told]
            nothing = subprocess.DEVNULL
            with suppress(OSError):
                self._process = subprocess.Popen(command, stdin=nothing, stdout=nothing, stderr=nothing)

    def wait(self) -> bool:
        """Wait until it is done; return whether it had begun at all."""
        if self._process is None:
            return False
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(LONGEST_S)
        return True

    def close(self) -> None:
        """End it if it still works: nobody needs it any more."""
        if self._process is not None and self._process.poll() is None:
            self._process.terminate()
            self._process.wait()


@contextmanager
def compiling_announced(notes: Console, scenario: Scenario | None = None) -> Iterator[None]:
    """Show what is compiled meanwhile in this process; what is cached is not, and loads alone.

    Where a scenario is given, another process compiles the rule of its that plans paths, once anything else has to be
    compiled, if the rule ships with rmfs and there is more than one core.
    """
    from numba.core import event

    shown, other = _Shown(notes), None if scenario is None else _other_for(scenario)

    class Announcer(event.Listener):
        def on_start(self, event: Any) -> None:
            shown.begin(event.data["dispatcher"].py_func.__module__)

        def on_end(self, event: Any) -> None:  # noqa: ARG002
            shown.end()

    def missed(module: str) -> bool:
        """Whether a function that is not in the cache may be there now: another process has compiled it."""
        if other is None:
            return False
        if not module.startswith(other.package):
            other.start()
            return False
        shown.begin(module)
        try:
            return other.wait()
        finally:
            shown.end()

    try:
        with loading_alone(missed), event.install_listener("numba:compile", Announcer()):
            yield
    finally:
        shown.close()
        if other is not None:
            other.close()


@contextmanager
def compiling_for(notes: Console, scenario: Scenario, *, own: bool) -> Iterator[None]:
    """Do as `compiling_announced` for a run of a scenario with its ``own`` orders; a small one compiles only models."""
    with ExitStack() as stack:
        announce = partial(stack.enter_context, compiling_announced(notes, scenario))
        if not (own and _is_small(scenario) and interpret(announce)):
            announce()
        yield


def _is_small(scenario: Scenario) -> bool:
    """Whether a run has few orders, of few lines, few robots and a small grid."""
    given, layout = scenario.instance, scenario.layout
    files = [Path(scenario.folder, name) for name in (given.orders_file, given.pods_file, layout.map_file) if name]
    if layout.generator is not None or given.state_file is not None or scenario.robots.count > SMALL_ROBOTS:
        return False
    most = given.max_lines if given.lines is None else len(given.lines)
    orders = given.orders_file is not None or given.orders * most <= SMALL_LINES
    blocks = (
        layout.map_file is not None or layout.block_rows * layout.block_columns * layout.block_length <= SMALL_BLOCKS
    )
    return orders and blocks and all(file.is_file() and file.stat().st_size <= SMALL_FILE for file in files)


def _other_for(scenario: Scenario) -> _Other | None:
    """Return what another process can compile of a scenario; None where it had better not."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    choice = scenario.rules.pp
    found = entrypoints.offers(entrypoints.RULES).get(choice.rule, ())
    if cores < 2 or len(found) != 1 or not found[0].module.startswith(f"{SHIPPED}."):
        return None
    return _Other(Role.PP, choice, ".".join(found[0].module.split(".")[:2]))


def compile_told() -> None:
    """Compile the rule that the command line names: of the process that does so for another one."""
    role, name, parameters = json.loads(sys.argv[1])
    single = import_module("rmfs_commands.cli.single_rule")
    with loading_alone():
        from rmfs_core.scenario import RuleChoice

        rule = single.load_rule(RuleChoice(name, parameters), [next(one for one in Role if one.key == role)])
        rule.prepare(_few_times())


def _few_times() -> Travel:
    """Return travel times that are quick to make; of any, the same functions are compiled."""
    from rmfs_core.scenario import load_scenario
    from rmfs_core.simulation.setup import motion_of
    from rmfs_core.world import make_layout
    from rmfs_core.world.travel import travel_on

    scenario = load_scenario("examples/small")
    return travel_on(make_layout(scenario), motion_of(scenario.robots))


def compile_searches(notes: Console, scenario: Scenario) -> None:
    """Compile what a scenario's runs search with: before worker processes do so side by side, unheard."""
    from rmfs_core.rules import RuleSet
    from rmfs_core.simulation.engine import Simulation
    from rmfs_core.world import make_instance, make_layout

    with compiling_announced(notes, scenario):
        rules = RuleSet.load(scenario.rules, scenario.folder)
        Simulation(scenario, make_instance(scenario), make_layout(scenario), rules)
