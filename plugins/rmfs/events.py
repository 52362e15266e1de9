"""Events that observers are told."""

from rmfs_commands.processes import events as of_processes
from rmfs_commands.processes.events import *
from rmfs_core import events
from rmfs_core.events import *

__all__ = [*events.__all__, *of_processes.__all__]  # noqa: PLE0604 (all are texts)
