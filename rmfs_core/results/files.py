"""The old name of `rmfs_commands.results.files`, until 0.3.0."""

from rmfs_core.former import former

__getattr__ = former(__name__, "rmfs_commands.results.files")
