"""Layouts for authors of generators: what `rmfs_commands.layouts` has."""

from rmfs.lazy import module_of

__path__: list[str] = []  # not that of the other: its modules could be imported twice
__getattr__, __dir__ = module_of("rmfs_commands.layouts")
