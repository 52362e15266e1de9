"""The tools for testing rules under the name that tests of rules import: what `rmfs_commands.testing` offers."""

from rmfs_core.offered import offered

__path__: list[str] = []  # not that of the other: its modules could be imported twice
__getattr__, __dir__ = offered("rmfs_commands.testing")
